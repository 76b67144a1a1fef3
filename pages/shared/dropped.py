"""Take in whatever files somebody hands over, each told by its content."""

from __future__ import annotations

from collections.abc import Sequence

from atleak.analysis.record_doubts import check_decisions
from atleak.catalogue.controller_file import written_toml
from atleak.common.errors import AtleakError
from atleak.common.pictures import printable_picture
from atleak.job.case import SLOTS, SourceFile
from atleak.job.kinds import FileKind, kind_of, slots_of
from atleak.job.zip_file import parse_job
from atleak.readers.controller_workbook import read_controller_workbook
from pages.shared.cases import catalogue_entry, controller_of
from pages.shared.state import Refusal, job, open_job, pick, put_file, put_job, remember, session
from pages.shared.undo import Told

_ORDER = tuple(FileKind)  # a job before what is added to it, its valve body before the sheet
_OF_JOB = (FileKind.READINGS, FileKind.ROAD_TEST, FileKind.PRESSURES, FileKind.VACUUM, FileKind.FLOWS)


def take(files: Sequence[SourceFile]) -> None:
    """Take files into the job, each to its place; what cannot be used is kept in ``refused`` of the session."""
    now = session()
    now.notices, now.not_taken = (), ()
    now.refused.pop("job", None)
    kinds = []
    for file in files:
        try:
            kinds.append((kind_of(file, controller_of(now.good)), file))
        except AtleakError as error:
            now.not_taken += (Refusal(file.name, error),)
    kinds.sort(key=lambda each: _ORDER.index(each[0]))
    if any(kind is not FileKind.JOB for kind, _ in kinds):  # a job that is opened is remembered there
        names = ", ".join(file.name for _, file in kinds)
        remember(lambda say: say("done.taken_in", name=names))
    last = dict(kinds)
    for kind, file in kinds:
        if kind in _OF_JOB and file is not last[kind]:
            _leave_out(kind, file, last[kind])
            continue
        try:
            _take(kind, file)
        except AtleakError as error:
            session().not_taken += (Refusal(file.name, error),)  # of another session where a job was opened


def _take(kind: FileKind, file: SourceFile) -> None:
    now = session()
    if kind in _OF_JOB:
        if kind is FileKind.READINGS:
            now.follow = True
            if not now.case.sample and now.sheet_before is None:
                now.sheet_before = now.case.readings
        put_file(kind, file)
    elif kind is FileKind.JOB:
        open_job(file.name, file.content)
    elif kind is FileKind.RECORD:
        record = parse_job(file.content, file.name)
        check_decisions(record, controller_of(now.case), file.name)
        put_job(record.with_pictures(job().pictures))
        _tell(lambda say: say("done.record", name=file.name))
    elif kind is FileKind.PICTURE:
        printable_picture(file.name, file.content)
        put_job(job().with_photo(file.name, file.content))
        _tell(lambda say: say("done.photo", name=file.name))
    elif kind is FileKind.CONTROLLER_WORKBOOK:
        described = read_controller_workbook(file.content, name=file.name)
        name = f"{described.controller.id}.toml"
        _choose(("controller",), SourceFile(name, written_toml(described.data).encode("utf-8")))
    else:
        slot = next(slot for slot in SLOTS.values() if slot.name.endswith(kind))
        _choose(slots_of(kind, catalogue_entry(slot.name, file)), file)


def _choose(slots: Sequence[str], file: SourceFile) -> None:
    for slot in slots:
        pick(slot, file)
    _tell(lambda say: say("done.used_for", name=file.name, slots=", ".join(say(f"slots.{slot}") for slot in slots)))


def _leave_out(kind: FileKind, file: SourceFile, other: SourceFile) -> None:
    if kind is FileKind.READINGS:
        session().sheet_before = file
    _tell(lambda say: say("done.left_out", name=file.name, other=other.name))


def _tell(told: Told) -> None:
    session().notices += (told,)
