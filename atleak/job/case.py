"""Hold a job, its files and choices, in one frozen object: the only way in which they become a diagnosis.

The command line, the dashboard, job files and batches all make a `Case` and call `Case.diagnose`. A choice from the
catalogue is an id, a path, or a file of the workshop's own, given as bytes.
"""

from __future__ import annotations

import hashlib
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from io import BufferedReader
from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import Any, Self, TypeVar

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.entries import own_files, shipped_files
from atleak.catalogue.fluid import FluidState, load_fluid
from atleak.catalogue.instruments import (
    DEFAULT_SLEEVE_INSTRUMENT,
    DEFAULT_SPOOL_INSTRUMENT,
    Instruments,
    Part,
    load_instrument,
)
from atleak.catalogue.limits import DEFAULT_LIMITS, load_limits
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.pump import NO_CLEARANCES, PumpClearances
from atleak.catalogue.repairs import find_repairs
from atleak.common.damage import DAMAGE, reason_in_short
from atleak.common.errors import AtleakError, InputError, Message, Place, RoadTestError, reason_of
from atleak.common.memory import kept_with
from atleak.common.sentences import Sentence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.uncertainty import DEFAULTS, GUARD_FACTOR, LandSources
from atleak.diagnosis.uncertainty.sources import sources_of_sheet
from atleak.engine.profile import PROFILES, Profile, find_profile
from atleak.engine.projection import stated_condition
from atleak.engine.road_leakage import OPERATING_POINTS, with_assumed_pressure
from atleak.measurements.flow_readings import FlowTable
from atleak.measurements.gauge_readings import PressureTable
from atleak.measurements.job_card import Job
from atleak.measurements.readings import Readings
from atleak.measurements.road_test import RoadTest
from atleak.measurements.vacuum import VacuumTable
from atleak.readers.dates import words
from atleak.readers.gauges.gauge_table import read_pressure_table
from atleak.readers.gauges.vacuum_table import read_vacuum_table
from atleak.readers.gauges.value_table import read_flow_table
from atleak.readers.logs import NOT_LOGGED, Understood, default_path, recall, understand
from atleak.readers.sheets.mapping import is_role, require_known
from atleak.readers.sheets.measuring_sheet import read_readings

_Loaded = TypeVar("_Loaded")
CaseKind = TypeVar("CaseKind", bound="Case")
Pairs = tuple[tuple[str, Any], ...]


def plain_name(name: str) -> str:
    """Return a file's name without any folder: for messages, never for a path."""
    return PurePosixPath(name.replace("\\", "/")).name or "file"


@dataclass(frozen=True)
class SourceFile:
    """A file of a job: its name and its bytes, or the path from which they are read when they are needed."""

    name: str  # as messages call it
    data: bytes | None = field(default=None, repr=False)  # its bytes
    path: Path | None = field(default=None, repr=False)  # from which they are read

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", plain_name(self.name))

    @classmethod
    def at(cls, path: str | Path) -> SourceFile:
        """Return the file at a path; nothing is read yet."""
        return cls(Path(path).name, path=Path(path))

    @property
    def given(self) -> bytes | Path:
        """Return what the readers take: the path where there is one, or else the bytes."""
        return self.path if self.path is not None else self.content

    @cached_property
    def content(self) -> bytes:
        """Return the bytes of the file.

        Raises
        ------
        InputError
            a path that cannot be read.
        """
        if self.data is not None:
            return self.data
        with self._opened() as stream:
            return stream.read()

    @cached_property
    def sha256(self) -> str:
        """Return the SHA-256 digest of the bytes, as hexadecimal digits; of a file at a path without holding them.

        Raises
        ------
        InputError
            a path that cannot be read.
        """
        if self.data is not None or "content" in vars(self) or self.path is None:
            return hashlib.sha256(self.content).hexdigest()
        with self._opened() as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()

    @contextmanager
    def _opened(self) -> Iterator[BufferedReader]:
        try:
            with Path(self.path or self.name).open("rb") as stream:
                yield stream
        except OSError as error:
            problem = Sentence("cannot be read: {reason}", reason=reason_of(error))
            raise InputError(problem, place=Place(file=self.name)) from error


CaseChoice = str | SourceFile


@dataclass(frozen=True)
class Slot:
    """One thing that a job takes from the catalogue."""

    name: str  # name of the field in `Case`
    label: str  # for people
    folder: str  # folder of the catalogue
    load: Callable[[str | Path], Any]
    required: bool  # in a job file: an instrument may have been made in Python
    part: Part | None = None  # that an instrument measures

    def own_file(self, choice: CaseChoice | None) -> SourceFile | None:
        """Return the file behind a choice, where it is the user's own, which can change; None for a shipped one."""
        if choice is None or isinstance(choice, SourceFile):
            return choice
        path = None if choice in shipped_files(self.folder) else own_files(self.folder).get(choice)
        return None if path is None else SourceFile.at(path)


SLOTS: Mapping[str, Slot] = MappingProxyType(
    {
        slot.name: slot
        for slot in (
            Slot("controller", "Valve body", "controllers", load_controller, True),
            Slot("fluid", "Fluid", "fluids", load_fluid, True),
            Slot("limits", "Limits", "limits", load_limits, True),
            Slot("spool_instrument", "Spools measured with", "instruments", load_instrument, False, "spool"),
            Slot("sleeve_instrument", "Sleeves measured with", "instruments", load_instrument, False, "sleeve"),
        )
    }
)


OWN_FILES = (
    "readings",
    "road_test",
    "pressures",
    "vacuum",
    "flows",
)  # of a job, besides what it takes from the catalogue


_ADDED_LATER = {
    "every": 1,
    "vacuum": None,
    "flows": None,
    "sheet_columns": (),
}  # choices that results kept before do not know


@dataclass(frozen=True)
class Case:
    """The files and choices of one job. The default of every choice stands here and nowhere else."""

    readings: SourceFile | None = None  # the measuring sheet
    road_test: SourceFile | None = None  # the log
    pressures: SourceFile | None = None  # gauge readings of a standing vehicle; the sheet's own tab unless given
    vacuum: SourceFile | None = None  # a vacuum test of circuits and lands
    flows: SourceFile | None = None  # flows that were caught in a jug
    controller: CaseChoice = "four_speed_2023"  # id or file, as of fluid, limits and instruments
    fluid: CaseChoice | None = None  # in the transmission; None: as the controller's file names it
    fluid_state: FluidState | None = None  # None: nobody said; as its data are, fresh as a rule
    limits: CaseChoice = DEFAULT_LIMITS  # by which it is judged
    spool_instrument: CaseChoice = DEFAULT_SPOOL_INSTRUMENT  # that measured spools
    sleeve_instrument: CaseChoice = DEFAULT_SLEEVE_INSTRUMENT  # that measured bores
    profile: str = "workshop"  # how the engine computes
    options: Pairs = ()  # of the profile, where they differ from it
    temperature: float | None = None  # [°C]; None: the controller's first operating point
    engine_speed: float | None = None  # [1/s]
    gear: int | None = None  # of the stated condition
    point: OperatingPoint | None = None  # used instead of the controller's first operating point
    mileage: float | None = None  # [km]; None: as the sheet's head states it
    measuring_temperature: float | None = None  # [°C] of gauge and parts; None: as the sheet's head states it
    pump_clearances: PumpClearances = NO_CLEARANCES  # measured of this job's pump; others as the sheet's head states
    sheet_name: str | None = None  # of the workbook, where several hold readings
    sheet_unit: str | None = None  # of the diameters, where the sheet does not say
    sheet_fill_down: bool = False  # whether an empty cell of a label goes on with the one above it
    sheet_where: tuple[tuple[str, str], ...] = ()  # heading → value of the rows to read, where it holds several states
    sheet_columns: tuple[tuple[str, str], ...] = ()  # role → column of the sheet, where the user chose it
    columns: tuple[tuple[str, str], ...] = ()  # quantity → column of the log, where the user chose it
    units: tuple[tuple[str, str], ...] = ()  # quantity → unit
    constants: Pairs = ()  # quantity → value in SI of a channel that the log lacks; of main pressure `OPERATING_POINTS`
    every: int = 1  # N: only one row in N of the log is read
    remember: bool = True  # whether to use what this computer remembers of such logs and sheets
    assumptions: Pairs = ()  # those that differ from the defaults
    guard_factor: float | None = None  # k of the guard band; None: the usual one
    complaint: str | None = None  # id of one of the controller's complaints
    repairs: tuple[str, ...] = ()  # ids of those of the controller's repairs that the workshop plans with

    @property
    def key(self) -> str:
        """Return a key under which a result can be kept: equal for equal files and choices, and only for those."""
        files = {name: (file.name, file.sha256) for name, file in self._files()}
        values = {name: files.get(name, value) for name, value in vars(self).items() if not name.startswith("_")}
        if self.fluid is None and "controller" in files:  # it may name a fluid of the user's own
            values["fluid"] = [SourceFile.at(path).sha256 for path in own_files("fluids").values()]
        for name, unchosen in _ADDED_LATER.items():
            if values[name] == unchosen:
                del values[name]
        return hashlib.sha256(repr(sorted(values.items())).encode("utf-8", "backslashreplace")).hexdigest()

    def with_files(self, files: Mapping[str, SourceFile | None]) -> Self:
        """Return this job with other files, by the names of their fields.

        Parameters
        ----------
        files
            by field: ``readings``, ``road_test`` …; None takes one away.

        Returns
        -------
        Case
            all choices as they were.
        """
        changes: dict[str, Any] = dict(files)
        return replace(self, **changes)

    def _files(self) -> list[tuple[str, SourceFile]]:
        named = ((name, getattr(self, name)) for name in OWN_FILES)
        chosen = ((name, slot.own_file(getattr(self, name))) for name, slot in SLOTS.items())
        return [(name, file) for name, file in (*named, *chosen) if file is not None]

    @property
    def engine_profile(self) -> Profile:
        """Return the profile with its options.

        Raises
        ------
        InputError
            no such profile or option, or a value that it does not take.
        """
        return find_profile(self.profile, {name: str(value) for name, value in self.options})

    @property
    def sheet_choices(self) -> dict[str, Any]:
        """Return how the measuring sheet is read, as `read_readings` takes it."""
        return {
            "sheet": self.sheet_name,
            "unit": self.sheet_unit,
            "where": dict(self.sheet_where),
            "fill_down": self.sheet_fill_down,
            "mapping": dict(self.sheet_columns),
        }

    @property
    def log_choices(self) -> dict[str, Any]:
        """Return how the log's columns are read, as `read_road_test` takes it."""
        constants = {name: float(value) for name, value in self.constants if value != OPERATING_POINTS}
        return {"mapping": dict(self.columns), "units": dict(self.units), "constants": constants, "every": self.every}

    @property
    def assumes_pressure(self) -> bool:
        """Return whether the valve body's operating points stand for a main pressure that the log lacks."""
        return dict(self.constants).get("main_pressure") == OPERATING_POINTS

    def condition(self, controller: Controller) -> OperatingPoint:
        """Return the stated condition.

        Returns
        -------
        OperatingPoint
            the point that the job states, or the controller's first one, with what the job states besides.

        Raises
        ------
        InputError
            a gear the controller does not have, or a speed that is not positive.
        """
        point, own = self.point, [each.name for each in controller.operating_points]
        if point is not None and point.like not in own:  # of a job that was made with another file
            point = replace(point, values_of=own[0])
        differ = {"temperature": self.temperature, "engine_speed": self.engine_speed}
        return stated_condition(controller, **differ, gear=self.gear, base=point)

    def with_condition(self, condition: OperatingPoint, controller: Controller) -> Case:
        """Return this job at a condition, kept as what differs from the controller's own, or else as a whole.

        Returns
        -------
        Case
            whose `condition` is that one.
        """
        own = controller.operating_points[0]
        differ: dict[str, Any] = {
            name: None if getattr(condition, name) == getattr(own, name) else getattr(condition, name)
            for name in ("temperature", "engine_speed", "gear")
        }
        bare = replace(self, point=None, temperature=None, engine_speed=None, gear=None)
        if condition == own:
            return bare
        if condition.gear in controller.gears and stated_condition(controller, **differ) == condition:
            return replace(bare, **differ)
        return replace(bare, point=condition)

    def diagnose(self, loader: Reader | None = None) -> Diagnosis:
        """Diagnose this job.

        Parameters
        ----------
        loader
            reads the files; unless given, each is read anew.

        Raises
        ------
        AtleakError
            saying which part of the job cannot be used.
        """
        try:
            return self._diagnosed(loader or Reader())
        except AtleakError:
            raise
        except DAMAGE as error:  # of numbers that no unit has, which no check of a single file refused
            problem = Sentence("this job cannot be computed ({reason})", reason=reason_in_short(error))
            raise InputError(problem) from error

    def _diagnosed(self, loader: Reader) -> Diagnosis:
        controller, fluid, limits, spool, sleeve = (
            loader.entry(slot, getattr(self, name)) for name, slot in SLOTS.items()
        )
        readings = None if self.readings is None else loader.readings(self, controller)
        pressures = None if self.pressures is None else loader.pressures(self, controller)
        diagnosis = diagnose(
            controller if readings is None else readings.own_lands.applied(controller),
            fluid,
            limits,
            fluid_state=self.fluid_state,
            readings=readings if readings is not None and readings.readings else None,
            pressures=_one_table(pressures, readings),
            vacuum=None if self.vacuum is None else loader.vacuum(self, controller),
            flows=None if self.flows is None else loader.flows(self, controller),
            road_test=None if self.road_test is None else self.driven(loader.log(self), controller),
            profile=self.engine_profile,
            condition=self.condition(controller),
            mileage_km=self.mileage,
            measuring_temperature_c=self.measuring_temperature,
            pump_clearances=self.pump_clearances,
            instruments=Instruments(spool, sleeve).checked,
            assumptions=DEFAULTS.with_settings(dict(self.assumptions)),
            guard_factor=GUARD_FACTOR if self.guard_factor is None else self.guard_factor,
            complaint=controller.complaint(self.complaint),
        )
        return replace(diagnosis, repairs=find_repairs(controller.repairs, self.repairs, controller.name))

    def driven(self, log: Understood, controller: Controller) -> RoadTest:
        """Return the road test of a log, with the main pressure that is assumed for it.

        Raises
        ------
        AtleakError
            why there is none: what the log lacks, or the question that it leaves open.
        """
        road_test = _road_test(log)
        if not self.assumes_pressure:
            return road_test
        make = partial(with_assumed_pressure, controller, road_test)
        return kept_with(road_test, "assumed pressure", repr(controller.operating_points), make)

    def measured(self, loader: Reader | None = None) -> tuple[LandSources, ...]:
        """Return every land as this job's sheet measured it, with what makes it uncertain; none without a sheet.

        It is what `diagnose` rests on, without its draws: a unit's history asks for nothing more of an earlier visit.

        Returns
        -------
        tuple
            a `LandSources` for every land.

        Raises
        ------
        AtleakError
            saying which part of the job cannot be used.
        """
        if self.readings is None:
            return ()
        loader = loader or Reader()
        controller, spool, sleeve = (
            loader.entry(SLOTS[name], getattr(self, name))
            for name in ("controller", "spool_instrument", "sleeve_instrument")
        )
        readings = loader.readings(self, controller)
        if not readings.readings:
            return ()
        return sources_of_sheet(
            controller,
            readings,
            measuring_temperature=self.measuring_temperature,
            instruments=Instruments(spool, sleeve).checked,
            assumptions=DEFAULTS.with_settings(dict(self.assumptions)),
        )


def _road_test(log: Understood) -> RoadTest:
    """Return the road test of a log, or raise the reason why there is none.

    A log that may hold a main pressure is not taken while it is open which column that is.
    """
    test, place = log.road_test, Place(file=log.file)
    if test is None:
        raise log.problem or InputError(Sentence("the log's columns cannot be identified"), place=place)
    asked = any(question.quantity == "main_pressure" for question in log.ambiguous)
    if asked and test.channel("commanded_pressure") is None:
        reason = test.refused["main_pressure"]
        problem = Sentence("the log's column of main pressure is not usable: {reason}", reason=reason)
        expected = Sentence("the column of main pressure, and its unit, to be named")
        raise RoadTestError(problem, place=place, expected=expected)
    return test


def _one_table(own: PressureTable | None, readings: Readings | None) -> PressureTable | None:
    """Return the gauge readings of a job: those of their own file, or else of the measuring sheet's tab."""
    of_tab = None if readings is None else readings.pressures
    if own is None or of_tab is None:
        return own or of_tab
    text = Sentence(
        "the gauge readings in sheet {sheet!r} of {file} are left aside: those of {own} are used",
        sheet=of_tab.sheet,
        file=of_tab.file,
        own=own.file,
    )
    place = Place(of_tab.file, of_tab.sheet)
    return replace(own, messages=(*own.messages, Message("warning", "pressure_tab_aside", text, place)))


class Reader:
    """Read every file of a job anew; the dashboard has one that keeps what it has read.

    Each raises what the function raises that it calls: a `CatalogueError`, a `ReadingsError` …
    """

    with_cells = True  # whether readings keep the file's own tables

    def entry(self, slot: Slot, choice: CaseChoice | None) -> Any:
        """Load a controller, fluid, limit set or instrument by id, path or bytes; nothing where nothing is chosen."""
        if choice is None:
            return None
        return load_source(slot.load, choice) if isinstance(choice, SourceFile) else slot.load(choice)

    def readings(self, case: Case, controller: Controller) -> Readings:
        """Read the job's measuring sheet."""
        sheet = case.readings
        assert sheet is not None
        remembered = default_path() if case.remember else None
        choices = {**case.sheet_choices, "remembered": remembered, "with_cells": self.with_cells}
        return read_readings(sheet.given, controller, name=sheet.name, **choices)

    def log(self, case: Case) -> Understood:
        """Read the job's log as far as it is understood, open questions included."""
        log = case.road_test
        assert log is not None
        remembered = default_path() if case.remember else None
        return understand(log.given, name=log.name, remembered=remembered, **case.log_choices)

    def pressures(self, case: Case, controller: Controller) -> PressureTable:
        """Read the job's gauge readings from a file of their own."""
        file = case.pressures
        assert file is not None
        return read_pressure_table(file.given, controller, name=file.name)

    def vacuum(self, case: Case, controller: Controller) -> VacuumTable:
        """Read the job's vacuum test."""
        file = case.vacuum
        assert file is not None
        return read_vacuum_table(file.given, controller, name=file.name)

    def flows(self, case: Case, controller: Controller) -> FlowTable:
        """Read the flows that were caught in the job."""
        file = case.flows
        assert file is not None
        return read_flow_table(file.given, controller, name=file.name)


def with_log_choices(case: CaseKind, log: Understood) -> CaseKind:
    """Return the job with its log's columns as they were chosen, now or earlier: it then reads the same elsewhere.

    Its own choices come first; what is remembered counts only where it was used for the log.
    """
    consulted = any(message.code == "remembered" for message in log.messages)
    earlier = recall(default_path(), log.signature) if consulted and case.remember else None
    if earlier is None:
        return replace(case, remember=False)
    taken = {words(column) for _, column in case.columns if column != NOT_LOGGED}
    columns = {name: column for name, column in earlier.mapping.items() if words(column) not in taken}
    return replace(
        case,
        columns=pairs_of({**columns, **dict(case.columns)}),
        units=pairs_of({**earlier.units, **dict(case.units)}),
        remember=False,
    )


def load_source(load: Callable[[Path], _Loaded], source: SourceFile) -> _Loaded:
    """Load an entry of the catalogue from a file that is given as bytes.

    The name that a user gave is only shown, in messages and records; no file of that name is written.

    Raises
    ------
    InputError
        as ``load``, naming the file as the user does.
    """
    with tempfile.TemporaryDirectory(prefix="atleak-") as folder:
        path = Path(folder) / "own.toml"
        path.write_bytes(source.content)
        try:
            entry: Any = load(path)
        except InputError as error:
            error.rename_file(lambda file: source.name if file == path.name else file)
            raise
    named: _Loaded = replace(entry, origin=replace(entry.origin, path=Path(source.name)))
    return named


def differing_options(profile: Profile) -> Pairs:
    """Return the options in which a profile differs from the shipped one of its name."""
    shipped = PROFILES[profile.name].options
    return tuple((name, value) for name, value in profile.options.items() if value != shipped[name])


def named_columns(
    columns: Iterable[tuple[str, str]], units: Iterable[tuple[str, str]], sheet_unit: str | None = None
) -> dict[str, Any]:
    """Return how a case keeps columns and units by their names: of a log's quantities, and of a sheet's roles.

    Raises
    ------
    InputError
        a name that is neither, or a role that is given twice.
    """
    columns, units = tuple(columns), tuple(units)
    require_known(name for name, _ in (*columns, *units))
    of_sheet = tuple(pair for pair in columns if is_role(pair[0]))
    twice = next((name for name, count in Counter(name for name, _ in of_sheet).items() if count > 1), None)
    if twice is not None:
        expected = Sentence("each role once; of several columns of diameters each as 'value spool' or 'value repeat 2'")
        raise InputError(Sentence("a role of a measuring sheet is given twice"), value=twice, expected=expected)
    of_values = [unit for name, unit in units if is_role(name)]
    return {
        "sheet_columns": of_sheet,
        "sheet_unit": sheet_unit or next(iter(of_values), None),
        "columns": tuple(pair for pair in columns if not is_role(pair[0])),
        "units": tuple(pair for pair in units if not is_role(pair[0])),
    }


def pairs_of(values: Mapping[str, Any] | None) -> Pairs:
    """Return a mapping as the pairs that a case keeps."""
    return tuple((values or {}).items())


def with_record(case: CaseKind, job: Job) -> CaseKind:
    """Return a case with mileage, measuring temperature and pump clearances of the record, where it states none."""
    stated: dict[str, Any] = {"mileage": job.vehicle.mileage_km, "measuring_temperature": job.measuring_temperature_c}
    missing = {name: value for name, value in stated.items() if getattr(case, name) is None}
    return replace(case, **missing, pump_clearances=case.pump_clearances.or_else(job.pump_clearances))
