"""Take a job apart into what a job file and the job book keep of it, and put it together again."""

from __future__ import annotations

import datetime as dt
import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, AwareDatetime, BaseModel, ConfigDict, Field

from atleak.analysis.record_doubts import without_plan_as_number
from atleak.catalogue.controller_tables import State
from atleak.catalogue.entries import Origin, catalogue_files
from atleak.catalogue.fluid import FluidState
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.damage import own_errors_only
from atleak.common.errors import InputError, Place
from atleak.common.file_faults import validated
from atleak.common.seals import RECORD_LIMIT
from atleak.common.sentences import Sentence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.uncertainty import DEFAULTS, GUARD_FACTOR
from atleak.engine.profile import find_profile
from atleak.job.case import OWN_FILES, SLOTS, Case, SourceFile, differing_options, pairs_of, plain_name
from atleak.job.photos import without_notes
from atleak.measurements.job_card import (
    Job,
    MeasuringCelsius,
    PumpSideMicrometres,
    PumpTipMicrometres,
    without_surrogates,
)
from atleak.report.json.diagnosis import diagnosis_record
from atleak.version import __version__

JOB_FORMAT: Literal[1] = 1


# --- everything of a job but its files


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)


def _known_slot(name: str) -> str:
    """Check that a name is one of the files that a job can hold."""
    if name not in (*OWN_FILES, *SLOTS):
        raise ValueError(Sentence("one of {names}", names=(*OWN_FILES, *SLOTS)))
    return name


class _Condition(_Strict):
    """The stated condition, in SI."""

    name: str
    label: str
    temperature: float
    engine_speed: float
    gear: int
    main_pressure: float
    converter_pressure: float
    source: str
    stated_state: State | None = None
    solenoid_current: float | None = None
    lockup_duty: float | None = None
    values_of: str = ""


_OF_RECORD = ("measuring_temperature_c", "pump_side_clearance_um", "pump_tip_clearance_um")  # which holds them too


class ReadingChoices(_Strict):
    """The choices by which `read_readings` read the measuring sheet, and what was measured beside its diameters."""

    sheet: str | None = None  # of a workbook
    unit: str | None = None  # of the diameters
    where: dict[str, str] = {}  # heading → what must stand under it
    fill_down: bool = False  # an empty cell of a label goes on with the one above
    mapping: dict[str, str] = {}  # role → column, chosen now or earlier
    measuring_temperature_c: MeasuringCelsius | None = None  # of gauge and parts
    pump_side_clearance_um: PumpSideMicrometres | None = None  # the whole axial play
    pump_tip_clearance_um: PumpTipMicrometres | None = None  # of its tips


class LogChoices(_Strict):
    """The choices by which a log's columns are read; none stated where there is no log."""

    mapping: dict[str, str] | None = None  # quantity → column
    units: dict[str, str] | None = None  # quantity → unit
    constants: dict[str, str | float] | None = None  # quantity → value in SI
    every: Annotated[int, Field(ge=1, strict=True)] = 1  # of how many rows one is read


class Choices(_Strict):
    """The content of ``job.json``: everything of a job but its files."""

    format: Literal[1]  # of this file
    atleak: str  # version that wrote it
    job: Job = Job()  # the record
    profile: str  # how the engine computes
    options: dict[str, bool | float | str] = {}  # of the profile, that were set
    condition: _Condition  # at which leakage is projected
    mileage: Annotated[float, Field(ge=0)] | None = None  # [km]
    fluid_state: FluidState | None = None  # fresh or used
    complaint: str | None = None  # id of one of the controller's
    repairs: list[str] = []  # ids of those that were chosen
    readings: ReadingChoices = ReadingChoices()  # how the sheet is read
    road_test: LogChoices = LogChoices()  # how the log is read
    assumptions: dict[str, float] = {}  # that were set, by name
    guard_factor: float | None = None  # k of the guard band
    files: dict[Annotated[str, AfterValidator(_known_slot)], Annotated[str, AfterValidator(plain_name)]] = {}

    @property
    def record(self) -> Job:
        """Return the job record with the measuring temperature and the pump's clearances that were chosen."""
        chosen = self.readings.model_dump(exclude_none=True, include=set(_OF_RECORD))
        return self.job.model_copy(update=chosen) if chosen else self.job

    def case(self, sources: Mapping[str, SourceFile]) -> Case:
        """Return the case that these choices and files make up; nothing that this computer remembers is used."""
        profile = find_profile(self.profile, {name: str(value) for name, value in self.options.items()})
        log, sheet = self.road_test, self.readings
        return Case(
            profile=profile.name,
            options=differing_options(profile),
            point=OperatingPoint(**self.condition.model_dump()),
            mileage=self.mileage,
            measuring_temperature=self.record.measuring_temperature_c,
            pump_clearances=self.record.pump_clearances,
            fluid_state=self.fluid_state,
            complaint=self.complaint,
            repairs=tuple(self.repairs),
            sheet_name=sheet.sheet,
            sheet_unit=sheet.unit,
            sheet_where=pairs_of(sheet.where),
            sheet_fill_down=sheet.fill_down,
            sheet_columns=pairs_of(sheet.mapping),
            columns=pairs_of(log.mapping),
            units=pairs_of(log.units),
            constants=pairs_of(log.constants),
            every=log.every,
            remember=False,
            assumptions=() if self.assumptions.items() <= DEFAULTS.settings.items() else pairs_of(self.assumptions),
            guard_factor=None if self.guard_factor == GUARD_FACTOR else self.guard_factor,
        ).with_files(sources)


# --- a job in parts


@dataclass(frozen=True)
class JobParts:
    """A job with its result, taken apart: what its job file holds, and what the job book keeps."""

    choices: Choices  # the content of ``job.json``
    sources: Mapping[str, SourceFile]  # by slot: the workshop's own files, then those of the catalogue
    pictures: Mapping[str, bytes]  # by name
    case: Case  # its files and choices
    diagnosis: Diagnosis  # the result

    @cached_property
    def result(self) -> dict[str, Any]:
        """Return the result as ``atleak diagnose --json`` writes it."""
        return diagnosis_record(self.diagnosis)

    @property
    def job(self) -> Job:
        """Return what the workshop wrote down."""
        return self.choices.job


def job_parts(diagnosis: Diagnosis, job: Job | None = None, case: Case | None = None) -> JobParts:
    """Take a job apart.

    Parameters
    ----------
    case
        the files and choices that the result follows from, the log's columns as `with_log_choices` gives them; none for
        a unit that nobody measured or drove.

    Raises
    ------
    InputError
        files that are missing, or not those that the diagnosis rests on.
    """
    job, case = job or Job(), case or Case()
    gauges = diagnosis.pressures.table if diagnosis.pressures else None
    used = {
        "readings": diagnosis.readings or (gauges if case.pressures is None else None),
        "road_test": diagnosis.log.road_test if diagnosis.log else None,
        "pressures": None if case.pressures is None else gauges,
        "vacuum": diagnosis.vacuum_table,
        "flows": diagnosis.flow_table,
    }
    own = {slot: _source(slot, getattr(case, slot), used[slot]) for slot in OWN_FILES if used[slot] is not None}
    if case.readings is not None:
        own.setdefault("readings", case.readings)  # one of which no reading counts yet: what was typed stays
    sources = {**own, **_catalogue_files(diagnosis, case)}
    choices = _choices(diagnosis, job, case, {slot: source.name for slot, source in sources.items()})
    pictures = {name: without_notes(content) for name, content in job.pictures.items()}
    return JobParts(choices, sources, pictures, case, diagnosis)


def _choices(diagnosis: Diagnosis, job: Job, case: Case, files: Mapping[str, str]) -> Choices:
    """Return what was chosen, as the diagnosis took it: what it found in a file by itself is not among it."""
    uncertainty = diagnosis.uncertainty
    head = diagnosis.readings.identity.mileage if diagnosis.readings else None
    # a log is judged with what was assumed also where nothing was measured
    assumed = DEFAULTS.with_settings(dict(case.assumptions)).settings if case.assumptions else {}
    measured: dict[str, Any] = dict(
        zip(_OF_RECORD, (case.measuring_temperature, *case.pump_clearances.um), strict=True)
    )
    log_choices = {**case.log_choices, "constants": dict(case.constants) or None}
    return Choices(
        format=JOB_FORMAT,
        atleak=__version__,
        job=job,
        profile=diagnosis.profile.name,
        options=diagnosis.profile.options,
        condition=_Condition(**asdict(diagnosis.projection.condition)),
        mileage=case.mileage if diagnosis.mileage == head else diagnosis.mileage,
        readings=ReadingChoices(**{**case.sheet_choices, **measured, **_settled(diagnosis)})
        if "readings" in files
        else ReadingChoices(),
        fluid_state=None if diagnosis.fluid_state_assumed else diagnosis.fluid.state,
        complaint=diagnosis.complaint.id if diagnosis.complaint else None,
        repairs=[repair.id for repair in diagnosis.repairs],
        road_test=LogChoices(**log_choices) if "road_test" in files else LogChoices(),
        assumptions=uncertainty.assumptions.settings if uncertainty else assumed,
        guard_factor=uncertainty.guard_factor if uncertainty else case.guard_factor,
        files=dict(files),
    )


def _settled(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the columns that the sheet was read with, now or as settled earlier, and the unit."""
    readings = diagnosis.readings
    if readings is None or not readings.columns:
        return {}
    unit = {} if readings.unit_assumed or ", " in readings.unit else {"unit": readings.unit}
    return {"mapping": dict(readings.columns), **unit}


class OfBook(_Strict):
    """The content of ``book.json``: what a job book knows of a job beside the job; no such file where it is nothing."""

    sample: bool = False
    archived_at: AwareDatetime | None = None
    made_on: dt.date | None = None  # the day on which a job without a date was first saved


@dataclass(frozen=True)
class JobFile:
    """A job that was kept: the record, the case to diagnose anew, and the result as it was when it was kept."""

    job: Job  # the record
    case: Case  # its files and choices
    result: dict[str, Any]  # as JSON has it
    name: str = "job file"  # for messages
    of_book: OfBook = field(default_factory=OfBook)  # what the job book adds

    @property
    def result_by(self) -> str:
        """Return the version of atleak that made the result."""
        return str(self.result.get("atleak", "?"))

    def diagnose(self) -> Diagnosis:
        """Diagnose this job anew, with the installed version of atleak.

        Raises
        ------
        AtleakError
            a file that cannot be used; it names the job file and the file in it.
        """
        try:
            return self.case.diagnose()
        except InputError as error:
            name_within(error, self.name)
            raise

    @classmethod
    @own_errors_only(InputError, "name")
    def of(
        cls,
        choices: bytes,
        sources: Mapping[str, bytes | Path],
        pictures: Mapping[str, bytes],
        result: dict[str, Any],
        *,
        name: str,
        of_book: OfBook | None = None,
    ) -> Self:
        """Put a job together.

        Parameters
        ----------
        choices
            the content of ``job.json``.
        sources
            the content of its files, by slot, or where it lies.
        pictures
            the content of its pictures, by the names in the record.
        of_book
            what the book that it comes from knew of it.

        Raises
        ------
        InputError
            another format, choices that no job has, a file that is missing.
        """
        data = json_of(choices, _within(name, "job.json"))
        try:
            stated = _stated(data, sources.get("readings"), name)
            case = stated.case(_files(stated, sources, name))
        except InputError as error:
            if not isinstance(data, dict) or not _is_newer(data):
                raise
            made_by = data["atleak"] if isinstance(data.get("atleak"), str) else "?"
            problem = Sentence(
                "made by atleak {made_by}, newer than this {version}: update", made_by=made_by, version=__version__
            )
            raise InputError(problem, place=Place(file=name)) from error
        return cls(stated.record.with_pictures(pictures), case, result, name, of_book or OfBook())


def _stated(data: Any, sheet: bytes | Path | None, name: str) -> Choices:
    """Return what ``job.json`` states, if it is of this format."""
    made = data.get("format") if isinstance(data, dict) else None
    if made != JOB_FORMAT:
        expected = Sentence("format {format}", format=JOB_FORMAT)
        problem = Sentence("job file of another format")
        raise InputError(problem, place=Place(file=name), value=made, expected=expected)
    if isinstance(sheet, bytes):
        data = without_plan_as_number(data, sheet)
    return validated(Choices, data, _within(name, "job.json"))


def _files(stated: Choices, sources: Mapping[str, bytes | Path], name: str) -> dict[str, SourceFile]:
    """Return the files of a job by slot, each under the name that it had."""
    files = {}
    for slot, called in stated.files.items():
        content = sources.get(slot)
        if content is None:
            problem = Sentence("holds no {file}, which its record names", file=entry_of(slot))
            raise InputError(problem, place=Place(file=name))
        source = SourceFile(called, content) if isinstance(content, bytes) else SourceFile(called, path=content)
        files[slot] = source
    missing = [slot.name for slot in SLOTS.values() if slot.required and slot.name not in files]
    if missing:
        problem = Sentence("names no {part}", part=missing[0])
        raise InputError(problem, place=Place(file=name), expected=Sentence("a complete job file"))
    return files


def name_within(error: InputError, name: str) -> None:
    """Name the job file, in an error about it or about a file in it."""
    error.rename_file(lambda file: _within(name, file) if file else name)


def _within(name: str, file: str) -> Sentence:
    return Sentence("{name}: {file}", name=name, file=file)


def _is_newer(data: Mapping[str, Any]) -> bool:
    """Tell whether a newer atleak made a job: by its format, or by the version that it names."""
    made, version = data.get("format"), data.get("atleak")
    if isinstance(made, int) and not isinstance(made, bool) and made > JOB_FORMAT:
        return True
    return isinstance(version, str) and _numbers(version) > _numbers(__version__)


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(map(int, re.findall(r"\d+", version)[:3]))


def entry_of(slot: str) -> str:
    """Return the name under which a job file holds the file of a slot."""
    return f"catalogue/{slot}.toml" if slot in SLOTS else slot


def json_of(content: bytes, name: str) -> Any:
    """Return what JSON holds.

    Raises
    ------
    InputError
        naming what is too large or no JSON.
    """
    if len(content) > RECORD_LIMIT:
        raise InputError(Sentence("too large"), place=Place(file=name))
    try:
        return _encodable(json.loads(content.decode("utf-8-sig")))
    except (ValueError, RecursionError) as error:
        problem = Sentence("is not valid JSON: {reason}", reason=str(error)[:200])
        raise InputError(problem, place=Place(file=name)) from error


def _encodable(value: Any) -> Any:
    """Return what JSON holds with every text and key encodable, so that any report can be written of it."""
    if isinstance(value, dict):
        return {without_surrogates(key): _encodable(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_encodable(each) for each in value]
    return without_surrogates(value) if isinstance(value, str) else value


# --- the files that a result rests on

_FILES = {
    "readings": Sentence("the measuring sheet"),
    "pressures": Sentence("the table of gauge readings"),
    "vacuum": Sentence("the vacuum test"),
    "flows": Sentence("the table of flows"),
    "road_test": Sentence("the road-test log"),
    "controller": Sentence("the file of the controller"),
    "fluid": Sentence("the file of the fluid"),
    "limits": Sentence("the file of the limits"),
    "spool_instrument": Sentence("the file of the spool instrument"),
    "sleeve_instrument": Sentence("the file of the sleeve instrument"),
}


def _catalogue_files(diagnosis: Diagnosis, case: Case) -> dict[str, SourceFile]:
    """Return the catalogue files that the diagnosis used, each checked to be unchanged since it was loaded."""
    uncertainty = diagnosis.uncertainty
    used: dict[str, Any] = {name: getattr(diagnosis, name) for name, slot in SLOTS.items() if slot.required}
    if uncertainty is not None:
        used |= {"spool_instrument": uncertainty.instruments.spool, "sleeve_instrument": uncertainty.instruments.sleeve}
    files = {}
    for name, entry in used.items():
        origin, choice = entry.origin, getattr(case, name)
        if origin is None:
            continue  # an instrument made in Python: the catalogue's defaults are taken instead
        # the used state of a user's own fluid may be an entry of the catalogue
        shipped = origin.path in catalogue_files(SLOTS[name].folder).values()
        own = isinstance(choice, SourceFile) and not (shipped and choice.sha256 != origin.sha256)
        source = SourceFile(origin.file, choice.content if own else _bytes_loaded(name, origin))
        if source.sha256 != origin.sha256:
            problem = Sentence("{what} has changed since it was loaded", what=_FILES[name])
            raise InputError(problem, value=origin.file)
        files[name] = source
    return files


def _bytes_loaded(name: str, origin: Origin) -> bytes:
    try:
        return origin.path.read_bytes()
    except OSError as error:
        problem = Sentence("{what} is no longer there", what=_FILES[name])
        raise InputError(problem, value=origin.file) from error


def _source(slot: str, source: SourceFile | None, used: Any) -> SourceFile:
    """Return the file that was read for a slot, under the name by which the diagnosis knows it."""
    if source is None:
        expected = Sentence("the bytes the diagnosis was read from")
        raise InputError(Sentence("{what} is missing", what=_FILES[slot]), value=used.file, expected=expected)
    if source.sha256 != used.sha256:
        problem = Sentence("{what} is not the one the diagnosis was read from", what=_FILES[slot])
        raise InputError(problem, value=used.file)
    if source.data is not None and source.name == used.file:
        return source  # its digest is known
    return SourceFile(used.file, source.content)
