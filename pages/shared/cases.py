"""Hold the job of the dashboard and its results, each kept so that a page change costs nothing.

Everything is kept by the SHA-256 of the files' bytes and the choices: two files that differ in one value never share a
result. For every session the last six are kept of sheets, tables of gauges, logs and results, and beside them each
result that some session shows (`state.RESULTS`). A log larger than `LARGE` and the results over it are kept for the
session that has them, `LARGE_KEPT` of them, and go with it.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import suppress
from contextvars import ContextVar
from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar
from weakref import WeakValueDictionary

import streamlit as st

from atleak.catalogue.controller import Controller
from atleak.catalogue.entries import ListedEntry, catalogue_files, listed_entries, own_files, shipped_names
from atleak.catalogue.instruments import Instruments
from atleak.common.errors import AtleakError, CatalogueError, Message, OutputError
from atleak.common.memory import give_back_soon, kept_with
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.job.case import OWN_FILES, SLOTS, Case, CaseChoice, Reader, Slot, SourceFile, with_log_choices
from atleak.measurements.gauge_readings import PressureTable
from atleak.measurements.measuring_plan import PLAN_PARTS
from atleak.measurements.readings import Readings
from atleak.readers.logs import (
    LogColumn,
    Understood,
    default_path,
    log_columns,
    recall,
    remember,
    understand,
)
from atleak.readers.remembered_columns import RememberedColumns, recall_all
from atleak.readers.sheets.mapping import FORMAT
from atleak.readers.sheets.measuring_sheet import SheetLook, look_at

CaseKind = TypeVar("CaseKind", bound=Case)
SAMPLES = Path(__file__).resolve().parents[2] / "sample_data"
LARGE, LARGE_KEPT = 4_000_000, 2  # [bytes], and how many
_CHOICES = {  # those that belong to one file, and go with it
    "readings": ("sheet_name", "sheet_unit", "sheet_where", "sheet_fill_down", "sheet_columns"),
    "road_test": ("columns", "units", "constants", "every", "remember"),
    "pressures": (),
    "vacuum": (),
    "flows": (),
}
FITTED: dict[str, dict[str, Any]] = {  # the same, as a fresh job has them
    slot: {name: getattr(Case, name) for name in names} for slot, names in _CHOICES.items()
}


@dataclass(frozen=True)
class PageCase(Case):
    """A job in the dashboard; ``sample`` says that its files are the shipped ones."""

    sample: bool = False

    def with_file(self, slot: str, file: SourceFile | None) -> PageCase:
        """Return this job with another sheet or log; the sample's other file never mixes with the user's own."""
        if self.sample:
            fitted = {name: value for choices in FITTED.values() for name, value in choices.items()}
            return replace(self, **fitted, sample=False).with_files({**dict.fromkeys(OWN_FILES), slot: file})
        return replace(self, **FITTED[slot]).with_files({slot: file})


def sample_case() -> PageCase:
    """Return the job that a fresh start shows."""
    return PageCase(
        readings=_sample("measuring_sheet_four_speed.xlsx"),
        road_test=_sample("minimum_acceleration_test.csv"),
        sample=True,
    )


def _sample(name: str) -> SourceFile | None:
    path = SAMPLES / name
    return SourceFile(path.name, path.read_bytes()) if path.is_file() else None


def opened_case(case: Case) -> PageCase:
    """Return the case of a job file; an entry that the catalogue here holds too is chosen by id.

    Raises
    ------
    AtleakError
        a controller that cannot be used.
    """
    shown = PageCase(**{field.name: getattr(case, field.name) for field in fields(Case)} | chosen_by_id(case))
    controller = controller_of(shown)
    opened = shown.with_condition(shown.condition(controller), controller)
    assert isinstance(opened, PageCase)
    return opened


def held(case: PageCase) -> PageCase:
    """Return the job with the user's own entries, and the columns of its log, as they are now.

    What is done later to the entries' files, or to the columns that are remembered, changes nothing.
    """
    case = case_with_columns(case)
    usual = controller_of(case).usual_fluid
    own = {name: slot.own_file(getattr(case, name) or usual) for name, slot in SLOTS.items()}
    return case.with_files(
        {name: SourceFile(file.name, file.content) for name, file in own.items() if file is not None}
    )


def chosen_by_id(case: Case) -> dict[str, CaseChoice | None]:
    """Return what a job takes from the catalogue, by id wherever the catalogue here holds that very file."""
    return {name: _by_id(slot, getattr(case, name)) for name, slot in SLOTS.items()}


def _by_id(slot: Slot, choice: CaseChoice | None) -> CaseChoice | None:
    if not isinstance(choice, SourceFile):
        return choice
    known = catalogue_files(slot.folder).items()
    return next((name for name, path in known if path.read_bytes() == choice.content), choice)


def is_large(log: SourceFile | None) -> bool:
    """Tell whether a log is kept for its session alone."""
    return log is not None and len(log.content) > LARGE


def _released(_: object) -> None:
    """Hand the memory of a large log, or of a result over it, to the system."""
    give_back_soon()


class Kept(Reader):
    """A reader of a job's files that reads each once: for every session of this server, large logs for each session."""

    def entry(self, slot: Slot, choice: CaseChoice | None) -> Any:
        if choice is None:
            return None
        own = slot.own_file(choice)
        called = choice if isinstance(choice, str) else choice.name
        return _entry(slot.name, called, "" if own is None else own.sha256, choice)

    def readings(self, case: Case, controller: Controller) -> Readings:
        assert case.readings is not None
        file = case.readings
        key = repr(
            (file.name, file.sha256, controller.sha256, sorted(case.sheet_choices.items()), sheets_remembered(case))
        )
        return _readings(key, case, controller)

    def pressures(self, case: Case, controller: Controller) -> PressureTable:
        assert case.pressures is not None
        file = case.pressures
        return _pressures(repr((file.name, file.sha256, controller.sha256)), case, controller)

    def log(self, case: Case) -> Understood:
        assert case.road_test is not None
        return understood(case.road_test, case)


@st.cache_resource(max_entries=64, show_spinner=False)
def _entry(slot: str, called: str, sha256: str, _choice: CaseChoice) -> Any:
    return Reader().entry(SLOTS[slot], _choice)


@st.cache_resource(max_entries=6, show_spinner="…")
def _readings(key: str, _case: Case, _controller: Controller) -> Readings:
    return Reader().readings(_case, _controller)


@st.cache_resource(max_entries=6, show_spinner=False)
def _look(
    key: str, _file: SourceFile, _controller: Controller, sheet: str | None, mapping: dict[str, str]
) -> SheetLook:
    return look_at(_file.content, _controller, name=_file.name, sheet=sheet, mapping=mapping)


def sheet_look(file: SourceFile, controller: Controller, sheet: str | None, mapping: dict[str, str]) -> SheetLook:
    """Return how a measuring sheet looks, and which column most likely is what.

    Raises
    ------
    ReadingsError
        as `look_at`.
    """
    return _look(f"{file.name} {file.sha256} {controller.sha256}", file, controller, sheet, mapping)


@st.cache_resource(max_entries=6, show_spinner=False)
def _pressures(key: str, _case: Case, _controller: Controller) -> PressureTable:
    return Reader().pressures(_case, _controller)


@st.cache_resource(max_entries=6, show_spinner="…")
def _understood(key: str, _log: SourceFile, _choices: dict[str, Any], _remembered: bool) -> Understood:
    return _read(_log, _choices, _remembered)


class LogReading:
    """A large log that is read in a thread of its own: a page that begins anew meanwhile goes on waiting for it."""

    def __init__(self, log: SourceFile, choices: dict[str, Any], remembered: bool) -> None:
        self.log, self.rows, self.cancelled = log, 0, False
        pool = ThreadPoolExecutor(1)
        self.understood = pool.submit(_read, log, choices, remembered, self._count)
        pool.shutdown(wait=False)

    def _count(self, rows: int) -> None:
        if self.cancelled:
            raise CancelledError
        self.rows = rows


WHILE_READING: ContextVar[Callable[[LogReading], object]] = ContextVar("while reading", default=lambda _: None)
"""What a page does until a large log is read."""


def _large_logs() -> dict[str, LogReading]:
    """Return the large logs that this session keeps, the last one last."""
    kept: dict[str, LogReading] = st.session_state.setdefault("large-logs", {})
    return kept


def cancel_reading() -> None:
    """End the reading of a large log; what was read of it goes."""
    kept = _large_logs()
    for key in [key for key, reading in kept.items() if not reading.understood.done()]:
        kept.pop(key).cancelled = True


def _understood_here(key: str, log: SourceFile, choices: dict[str, Any], remembered: bool) -> Understood:
    kept = _large_logs()
    if key not in kept:
        cancel_reading()
        while len(kept) >= LARGE_KEPT:
            del kept[next(iter(kept))]
            give_back_soon()
        kept[key] = LogReading(log, choices, remembered)
    reading = kept[key] = kept.pop(key)  # the latest
    if not reading.understood.done():
        WHILE_READING.get()(reading)
    if reading.understood.exception() is not None:
        kept.pop(key, None)  # the next time it may succeed
    return reading.understood.result()


def _read(
    log: SourceFile, choices: dict[str, Any], remembered: bool, tell: Callable[[int], object] = lambda _: None
) -> Understood:
    memory = default_path() if remembered else None
    return understand(log.content, name=log.name, remembered=memory, tell=tell, **choices)


def understood(log: SourceFile, case: Case | None = None) -> Understood:
    """Return what a log holds, with its open questions and with the answers remembered now.

    ``case`` says how its columns are chosen; a log of its own is read as it comes.
    """
    case = case or Case()
    key = repr((log.name, log.sha256, case.log_choices))
    read = _understood_here if is_large(log) else _understood
    result = read(key, log, case.log_choices, False)
    earlier = recall(default_path(), result.signature) if case.remember else None
    return result if earlier is None else read(f"{key} {earlier}", log, case.log_choices, True)


def catalogue_entry(name: str, choice: CaseChoice) -> Any:
    """Load a controller, fluid, limit set or instrument by id, or from the user's own TOML file."""
    return Kept().entry(SLOTS[name], choice)


def entry_doubts(name: str, choice: CaseChoice) -> tuple[Message, ...]:
    """Return what of an entry is possible and probably a slip; nothing of one that cannot be used."""
    try:
        doubts: tuple[Message, ...] = catalogue_entry(name, choice).doubts
    except AtleakError:
        return ()
    return doubts


def catalogue_list(name: str) -> ListedEntry[Any]:
    """Return the entries to choose from, shipped and own, and what is wrong with own files that cannot be used."""
    return listed_entries(SLOTS[name].folder, partial(catalogue_entry, name))


def catalogue_names(name: str) -> dict[str, Any]:
    """Return what entries to choose from are called, by id: those that ship, and own ones that can be used."""
    folder, own = SLOTS[name].folder, {}
    for id in own_files(folder):
        with suppress(AtleakError):  # said by `own_faults`
            own[id] = catalogue_entry(name, id)
    return dict(sorted({**own, **shipped_names(folder)}.items()))


def own_faults() -> list[CatalogueError]:
    """Return what is wrong with each file of the user's own catalogue that cannot be used, of every kind."""
    names = {slot.folder: name for name, slot in SLOTS.items()}
    return [fault for folder, name in names.items() if own_files(folder) for fault in catalogue_list(name).faults]


def shown_name(entry: Any, say: Wording) -> str:
    """Return the name of an entry of the catalogue in the reader's language; the user's own are marked."""
    own = entry.origin is not None and entry.origin.own
    return say("settings.own_entry", name=entry.name, id=entry.id) if own else say.name(entry.name)


def controller_of(case: Case) -> Controller:
    """Return the controller of a job."""
    controller: Controller = catalogue_entry("controller", case.controller)
    return controller


def remembered_columns(log: SourceFile) -> RememberedColumns | None:
    """Return how the columns of logs with this header were chosen earlier."""
    return recall(default_path(), understood(log).signature)


def remember_columns(log: SourceFile, columns: dict[str, str], units: dict[str, str]) -> str:
    """Keep how this log's columns were chosen, for logs with the same header; return why it failed, else ""."""
    known = understood(log)
    labels = [heading.label for heading in known.headings]
    try:
        remember(default_path(), known.signature, columns, units, format=known.format, columns=labels)
    except OutputError as error:
        return error.problem
    return ""


@st.cache_resource(max_entries=6, show_spinner=False)
def _columns(sha256: str, _log: SourceFile) -> tuple[LogColumn, ...]:
    return log_columns(_log.content, name=_log.name)


def columns_of(log: SourceFile) -> tuple[LogColumn, ...]:
    """Return what every column of a log holds; none where the file is no log."""
    try:
        return _columns(log.sha256, log)
    except AtleakError:
        return ()


def readings_of(case: Case, file: SourceFile) -> Readings:
    """Return what a measuring sheet holds, read as the job says.

    Raises
    ------
    ReadingsError
        as `read_readings`.
    """
    return Kept().readings(replace(case, readings=file), controller_of(case))


def instruments_of(case: Case) -> Instruments:
    """Return the instruments that measured a job's sheet."""
    return Instruments(
        *(catalogue_entry(f"{part}_instrument", getattr(case, f"{part}_instrument")) for part in PLAN_PARTS)
    )


def case_with_columns(case: CaseKind) -> CaseKind:
    """Return the job with the columns of its log as they are read now, for its job file."""
    return case if case.road_test is None else with_log_choices(case, Kept().log(case))


_SHOWN: WeakValueDictionary[str, Diagnosis] = WeakValueDictionary()


@st.cache_resource(max_entries=6, show_spinner="…")
def _diagnosis(key: str, _case: Case) -> Diagnosis:
    return _computed(_case)


@st.cache_resource(max_entries=LARGE_KEPT, scope="session", on_release=_released, show_spinner="…")
def _diagnosis_here(key: str, _case: Case) -> Diagnosis:
    return _computed(_case)


def _computed(case: Case) -> Diagnosis:
    """Compute a diagnosis, or take that without a mileage, of which next to nothing follows."""
    if case.mileage is None:
        return case.diagnose(Kept())
    without = diagnosis_of(replace(case, mileage=None))
    result = without.with_mileage(case.mileage)
    if result is not without:  # the sheet's head states the same mileage
        kept_with(result, "without mileage", "", lambda: without)  # for the next one
    return result


def diagnosis_of(case: Case) -> Diagnosis:
    """Return the diagnosis of a job.

    Raises
    ------
    AtleakError
        saying what of the job cannot be used.
    """
    key = result_key(case)
    if is_large(case.road_test):
        return _diagnosis_here(key, case)
    result = _SHOWN.get(key)
    if result is None:
        result = _SHOWN[key] = _diagnosis(key, case)
    return result


def result_key(case: Case) -> str:
    """Return the key of a job's result: its files and choices, with the columns as they are read now."""
    return case_with_columns(case).key + sheets_remembered(case)


def sheets_remembered(case: Case | None = None) -> str:
    """Return what is remembered of measuring sheets, where a job may be read by it; "" where nothing is."""
    used = case is None or (case.remember and case.readings is not None)
    kept = recall_all(default_path()) if used else {}
    return "".join(f"{key} {entry}" for key, entry in kept.items() if entry.format == FORMAT)
