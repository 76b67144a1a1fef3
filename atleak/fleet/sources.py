"""Find the units of a fleet: job files, rows of tables and jobs of the job book; and what its results hold of one."""

from __future__ import annotations

import glob
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from atleak.common.errors import AtleakError, FleetError, InputError, Message, Place, reason_of
from atleak.common.sentences import Sentence
from atleak.common.verdicts import Verdict
from atleak.fleet.columns import HASH, DataSet
from atleak.fleet.results import Results
from atleak.fleet.unit_table import TableUnits, choices_read
from atleak.fleet.units import BOOK, FILE, TABLE, FleetUnit, travelling
from atleak.job.case import Case
from atleak.job_book.book import Book, open_book
from atleak.job_book.search import Query
from atleak.measurements.job_card import Job
from atleak.readers.unit_table import is_unit_table

_JOB_FILE = ".zip"
_ID = 8  # characters of the id of a job that has no number
_EXPECTED = Sentence("job files (.zip), folders of job files, or a table of units as CSV, xlsx or Parquet")
_SOURCE = Sentence("a job file (.zip), or a table of units as CSV, xlsx or Parquet")
_Source = TableUnits | Callable[[], FleetUnit]  # of many units, or of one; each is made when its turn comes


@dataclass
class FoundUnits:
    """The units that were found, each made when its turn comes: only then its files are read and its hash is known.

    Going through them again begins anew.
    """

    sources: Sequence[_Source]
    messages: tuple[Message, ...]  # what was left aside, and how tables were understood
    twice: list[tuple[str, str]] = field(default_factory=list)  # names of units that came before, and as what
    seen: dict[str, str] = field(default_factory=dict)  # hash → name of each unit that had its turn

    @property
    def has_tables(self) -> bool:
        """Tell whether some of them are rows of a table."""
        return any(isinstance(source, TableUnits) for source in self.sources)

    def __len__(self) -> int:
        """Return how many units there are, those that are there twice among them."""
        return sum(len(source) if isinstance(source, TableUnits) else 1 for source in self.sources)

    def __iter__(self) -> Iterator[FleetUnit]:
        """Give every unit; of those with the same content only the first, the others are named in ``twice``."""
        self.twice.clear()
        self.seen.clear()
        for source in self.sources:
            for unit in source if isinstance(source, TableUnits) else (source(),):
                known = _with_hash(unit)
                first = self.seen.get(known.input_sha256)
                if first is None:
                    self.seen[known.input_sha256] = known.name
                    yield known
                else:
                    self.twice.append((known.name, first))


def find_units(jobs: Iterable[str | Path], *, defaults: Case | None = None, book: Query | None = None) -> FoundUnits:
    """Find the units that are to be diagnosed.

    Parameters
    ----------
    jobs
        job files (zip), folders that are searched through for them, tables of units, and patterns of any of these with
        ``*``, ``?``, ``[…]`` and ``**``.
    defaults
        the choices for rows of tables that name none.
    book
        which jobs of the job book; none of them unless given.

    Raises
    ------
    InputError
        what is not there, a pattern that fits nothing, a file of another kind, a table that cannot be read at all.
    BookError
        where the job book cannot be used.
    """
    finder = _Finder(defaults or Case())
    finder.add([str(job) for job in jobs])
    if book is not None:
        finder.add_book(book)
    if not finder.sources:
        raise InputError(Sentence("no job is found"), expected=_EXPECTED)
    return FoundUnits(finder.sources, tuple(finder.messages))


def reopened(reference: str, *, choices: str = "", input_sha256: str | None = None) -> tuple[Case, Job]:
    """Open a unit again that was found earlier, by reference, choices and hash of its `FleetUnit`.

    Raises
    ------
    AtleakError
        what is not there any more, cannot be read, or has not the content of ``input_sha256``.
    """
    unit = _with_hash(_referred_to(reference, choices))
    case, job = unit.opened()
    if input_sha256 is not None and unit.input_sha256 != input_sha256:
        problem = Sentence("{unit} has other content now than its result rests on", unit=unit.name)
        raise InputError(problem, expected=Sentence("the run to be started again, which evaluates it anew"))
    return case, job


def _referred_to(reference: str, choices: str) -> FleetUnit:
    gone = Sentence("what the result rests on is not there any more")
    if reference.startswith(FILE):
        path = Path(reference.removeprefix(FILE))
        if not path.is_file():
            raise InputError(
                gone, place=Place(file=str(path)), expected=Sentence("the job file where the run found it")
            )
        return _job_file(path)
    if reference.startswith(TABLE):
        name, _, key = reference.removeprefix(TABLE).rpartition("#")
        if not Path(name).is_file():
            raise InputError(gone, place=Place(file=name), expected=Sentence("the table where the run found it"))
        unit = TableUnits(Path(name), choices_read(choices)).find(key)
        if unit is None:
            expected = Sentence("the row with the files that it had")
            raise InputError(
                Sentence("the unit's row is not in the table any more"), place=Place(name), expected=expected
            )
        return unit
    if reference.startswith(BOOK):
        return _book_job(open_book(), reference.removeprefix(BOOK))
    expected = Sentence("one that begins with {names}", names=(FILE, TABLE, BOOK))
    raise InputError(Sentence("is no reference of a unit"), value=reference, expected=expected)


def _with_hash(unit: FleetUnit) -> FleetUnit:
    """Return a unit whose hash is known; one with a file that cannot be read says so when it is opened."""
    try:
        assert unit.input_sha256
    except AtleakError as error:
        return replace(unit, job_file=None, case=None, job=None, fault=error)
    return unit


# --- what is found ----------------------------------------------------------------------------------------------------


def _job_file(path: Path, group: str | None = None) -> FleetUnit:
    """Return the unit of a job file."""
    name, reference = str(path), f"{FILE}{path.absolute()}"
    try:
        return FleetUnit(name, reference, group, job_file=travelling(path))
    except AtleakError as error:
        return FleetUnit(name, reference, group, fault=error)


def _book_job(book: Book, id: str, number: str = "") -> FleetUnit:
    """Return the unit of a job of the book, without its pictures."""
    name, reference = number or id[:_ID], f"{BOOK}{id}"
    try:
        file = book.load(id).file
    except AtleakError as error:
        return FleetUnit(name, reference, fault=error)
    return FleetUnit(file.job.number or name, reference, case=file.case, job=file.job.with_pictures({}))


class _Finder:
    """Goes through what was given, and keeps where every unit is, and what is to be told."""

    def __init__(self, defaults: Case) -> None:
        self._defaults = defaults
        self.sources: list[_Source] = []
        self.messages: list[Message] = []
        self._seen: set[str] = set()  # files, as they are reached in different ways

    def add(self, jobs: Sequence[str]) -> None:
        """Add what the arguments name: first it is seen whether all of it is there."""
        named = [path for job in jobs for path in self._named(job)]
        several = sum(path.is_dir() for path in named) > 1
        for path in named:
            if path.is_dir():
                self._add_folder(path, path.resolve().name if several else None)
            else:
                self._add_file(path)

    def _named(self, job: str) -> Iterator[Path]:
        """Yield the files and folders that an argument names: itself, or what fits it as a pattern."""
        if Path(job).exists():
            yield Path(job)
            return
        if not glob.has_magic(job):
            raise InputError(Sentence("no such file or folder"), place=Place(file=job), expected=_EXPECTED)
        fitting = [Path(each) for each in sorted(glob.glob(job, recursive=True))]  # noqa: PTH207  of any folder
        if not fitting:
            raise InputError(Sentence("no file fits this pattern"), place=Place(file=job), expected=_EXPECTED)
        for path in fitting:
            if path.is_dir() and "**" in job:
                continue  # the files in it fit too
            if path.is_dir() or _is_job_file(path) or is_unit_table(path, b""):
                yield path
            else:
                self._tell("other_file", Sentence("left out, being neither a job file nor a table of units"), str(path))

    def add_book(self, query: Query) -> None:
        """Add the jobs of the book that are asked for; those that were archived and the sample stay out."""
        book = open_book()
        rows = book.rows(replace(query, archived=False, limit=None))
        taken = [row for row in rows if not row.sample]
        if not taken:
            raise InputError(Sentence("no job of the job book fits"), place=Place(file=book.name))
        self.sources += [partial(_book_job, book, row.id, row.number) for row in taken]

    def _add_file(self, path: Path, group: str | None = None) -> None:
        key = os.path.normcase(path.absolute())
        if key in self._seen:
            return
        self._seen.add(key)
        if _is_job_file(path):
            self.sources.append(partial(_job_file, path, group))
        elif is_unit_table(path, _first_bytes(path)):
            self._add_table(path)
        else:
            raise InputError(Sentence("is of another kind"), place=Place(file=str(path)), expected=_SOURCE)

    def _add_table(self, path: Path) -> None:
        units = TableUnits(path, self._defaults)
        self.sources.append(units)
        labels = units.labels
        if labels:
            text = Sentence("columns that are kept as labels of their units: {names}", names=labels)
            self.messages.append(Message("info", "labels", text, Place(path.name, units.table.sheet)))
        self.messages += units.doubts()

    def _add_folder(self, folder: Path, group: str | None) -> None:
        """Add the job files of a folder; the name of a sub-folder is the group of those in it."""
        before, hidden, links = len(self.sources), 0, 0
        for here, folders, files in os.walk(folder, onerror=self._unreadable):
            hidden += sum(map(_is_hidden, folders))
            folders[:] = sorted(name for name in folders if not _is_hidden(name))
            links += sum((Path(here) / name).is_symlink() for name in folders)
            below = next(iter(Path(here).relative_to(folder).parts), group)
            job_files = [name for name in sorted(files) if _is_job_file(Path(name))]
            hidden += sum(map(_is_hidden, job_files))
            for name in job_files:
                if not _is_hidden(name):
                    self._add_file(Path(here) / name, below)
        if hidden:
            text = Sentence("{count} hidden files or folders are left out", count=hidden)
            self._tell("hidden", text, str(folder))
        if links:
            self._tell("links", Sentence("{count} links to folders are not followed", count=links), str(folder))
        if len(self.sources) == before:
            self._tell("empty_folder", Sentence("no job file (.zip) is found in this folder"), str(folder))

    def _unreadable(self, error: OSError) -> None:
        self._tell("unreadable", Sentence("cannot be read: {reason}", reason=reason_of(error)), str(error.filename))

    def _tell(self, code: str, text: Sentence, file: str) -> None:
        self.messages.append(Message("warning", code, text, Place(file=file)))


def _is_job_file(path: Path) -> bool:
    return path.suffix.lower() == _JOB_FILE


def _is_hidden(name: str) -> bool:
    return name.startswith(".")


def _first_bytes(path: Path) -> bytes:
    try:
        with path.open("rb") as stream:
            return stream.read(4)
    except OSError as error:
        problem = Sentence("cannot be read: {reason}", reason=reason_of(error))
        raise InputError(problem, place=Place(file=str(path)), expected=_SOURCE) from error


_OF_LANDS = (
    *("component", "land", "measured", "verdict", "decision"),
    *("radial_clearance_um", "uncertainty_um", "wear_percent", "leakage_dm3_min", "share_percent"),
)
_OF_CONDITIONS = (
    *("name", "label", "temperature_c", "engine_rpm", "gear", "band", "decision"),
    *("leakage_dm3_min", "share_percent", "p_g_kpa", "p_g_held_kpa", "reserve"),
)
SourceRow = Mapping[str, Any]  # a value, or None, by the name of its column


@dataclass(frozen=True)
class KeptUnit:
    """The row of a unit, and of its lands, the worst first, and its conditions what people ask for first."""

    unit: SourceRow  # its row
    lands: tuple[SourceRow, ...]  # the worst first
    conditions: tuple[SourceRow, ...]  # what people ask for first

    @property
    def result(self) -> SourceRow:
        """Return what the rows say as `atleak.job.result.judged_otherwise` takes it; of circuits nothing."""
        unit = {"decision": self.unit["decision"]}
        return {
            "verdict": self.unit["verdict"],
            "unit": unit,
            "lands": list(self.lands),
            "conditions": list(self.conditions),
        }

    def opened(self) -> tuple[Case, Job]:
        """Return the case and the record of the job that the rows are the result of.

        Raises
        ------
        AtleakError
            its files are not there any more, cannot be read, or are others than the result rests on.
        """
        return reopened(self.unit["reference"], choices=self.unit["choices"] or "", input_sha256=self.unit[HASH])


def kept_unit(results: Results, sha256: str) -> KeptUnit:
    """Read the rows of a unit.

    Raises
    ------
    FleetError
        the results hold no such unit; a part of them that is damaged.
    """

    def rows(data_set: DataSet, columns: Sequence[str] | None = None) -> tuple[SourceRow, ...]:
        return tuple(results.table(data_set, columns, hashes={sha256}).to_pylist())

    found = rows("units")
    if not found:
        raise FleetError(Sentence("holds no result of this unit any more"), place=Place(file=str(results.folder)))
    ranks = {str(verdict): verdict.rank for verdict in Verdict}
    lands = sorted(rows("lands", _OF_LANDS), key=lambda land: -ranks.get(land["verdict"], 0))
    return KeptUnit(found[0], tuple(lands), rows("conditions", _OF_CONDITIONS))
