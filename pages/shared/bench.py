"""The job on the bench: files and choices in one frozen object, and the results that follow from it.

Everything is kept by the SHA-256 of the files' bytes and the choices, so a page change or a rerun costs nothing, and
two files that differ in one value never share a result.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import streamlit as st

from atleak import catalogue
from atleak.controller import Controller, OperatingPoint, load_controller
from atleak.diagnosis import Diagnosis, diagnose
from atleak.errors import OutputError, Place, RoadTestError
from atleak.fluid import load_fluid
from atleak.instruments import DEFAULT_SLEEVE_INSTRUMENT, DEFAULT_SPOOL_INSTRUMENT, Instruments, load_instrument
from atleak.intake.readings import read_readings
from atleak.intake.road_test import Understood, default_path, recall, remember, understand
from atleak.intake.road_test.memory import Settled
from atleak.intake.units import unit
from atleak.job_file import JobFile, SourceFile, load_source, road_test_choices
from atleak.limits import load_limits
from atleak.profile import PROFILES, find_profile
from atleak.projection import stated_condition
from atleak.uncertainty import DEFAULTS, GUARD_FACTOR

SAMPLES = Path(__file__).resolve().parents[2] / "sample_data"
LOADERS = {
    "controller": load_controller,
    "fluid": load_fluid,
    "limits": load_limits,
    "spool_instrument": load_instrument,
    "sleeve_instrument": load_instrument,
}


FOLDERS = {"controller": "controllers", "fluid": "fluids", "limits": "limits"}


@dataclass(frozen=True)
class File:
    """A file as it was uploaded."""

    name: str
    data: bytes = field(repr=False)
    sha256: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", Path(self.name.replace("\\", "/")).name or "file")
        object.__setattr__(self, "sha256", hashlib.sha256(self.data).hexdigest())


@dataclass(frozen=True)
class Bench:
    """Files and choices of one job; a catalogue choice is an id or the user's own file."""

    sheet: File | None = None
    log: File | None = None
    controller: str | File = "four_speed_2023"
    fluid: str | File = "hipol_atf_iid"
    limits: str | File = "project_default"
    spool_instrument: str | File = DEFAULT_SPOOL_INSTRUMENT
    sleeve_instrument: str | File = DEFAULT_SLEEVE_INSTRUMENT
    profile: str = "workshop"
    options: tuple[tuple[str, Any], ...] = ()
    temperature: float | None = None  # [°C], None: the controller's first operating point
    rpm: float | None = None
    gear: int | None = None
    mileage: float | None = None  # [km]
    sheet_name: str = ""  # of the workbook, where several hold readings
    sheet_unit: str = ""  # of the diameters, where the sheet does not say
    sheet_where: tuple[
        tuple[str, str], ...
    ] = ()  # heading and value of the rows to read, where it holds several states
    columns: tuple[tuple[str, str], ...] = ()  # quantity → column of the log, where the user settled it
    units: tuple[tuple[str, str], ...] = ()
    constants: tuple[tuple[str, float], ...] = ()  # quantity → value in SI of a channel the log does not hold
    memory: bool = True  # whether what this computer remembers of the log's columns is consulted
    assumptions: tuple[tuple[str, float], ...] = ()  # where they are not the usual ones
    guard_factor: float | None = None
    point: OperatingPoint | None = None  # in place of the controller's first operating point
    window: tuple[float, float] | None = None  # [s] of the log that is looked at
    sample: bool = False

    @property
    def key(self) -> str:
        """What a result of this job is kept by."""
        return hashlib.sha256(repr(self).encode("utf-8", "backslashreplace")).hexdigest()

    def with_file(self, slot: str, file: File | None) -> Bench:
        """This job with another sheet or log; the sample's other file never mixes with the user's own."""
        settled = {
            "sheet": {"sheet_name": "", "sheet_unit": "", "sheet_where": ()},
            "log": {"columns": (), "units": (), "constants": (), "memory": True},
        }
        if self.sample:
            empty = {"sheet": None, "log": None, "sample": False}
            return replace(self, **{**empty, slot: file}, **settled["sheet"], **settled["log"])
        return replace(self, **{slot: file}, **settled[slot])


def sample_job() -> Bench:
    """The job that a fresh start shows."""
    files = {}
    for slot, name in (("sheet", "measuring_sheet_four_speed.xlsx"), ("log", "minimum_acceleration_test.csv")):
        path = SAMPLES / name
        files[slot] = File(path.name, path.read_bytes()) if path.is_file() else None
    return Bench(**files, sample=True)


def job_on_bench(job: JobFile) -> Bench:
    """The files and choices of a job file; what of its catalogue is this one's too is chosen by id.

    Raises
    ------
    AtleakError
        a controller or profile that cannot be used.
    """
    choices = job.choices
    sheet, log = (None if found is None else File(found.name, found.content) for found in (job.readings, job.road_test))
    profile = find_profile(choices.profile, {name: str(value) for name, value in choices.options.items()})
    base = PROFILES[profile.name].options
    bench = Bench(
        sheet=sheet,
        log=log,
        **{slot: _chosen(slot, found) for slot, found in job.catalogue.items()},
        profile=profile.name,
        options=tuple((name, value) for name, value in profile.options.items() if value != base[name]),
        mileage=choices.mileage,
        sheet_name=choices.readings.sheet or "",
        sheet_unit=choices.readings.unit or "",
        sheet_where=_pairs(choices.readings.where),
        columns=_pairs(choices.road_test.get("mapping")),
        units=_pairs(choices.road_test.get("units")),
        constants=_pairs(choices.road_test.get("constants")),
        memory=False,
        assumptions=() if choices.assumptions == DEFAULTS.settings else _pairs(choices.assumptions),
        guard_factor=None if choices.guard_factor == GUARD_FACTOR else choices.guard_factor,
    )
    return _at_condition(bench, OperatingPoint(**choices.condition.model_dump()))


def _at_condition(bench: Bench, condition: OperatingPoint) -> Bench:
    """The condition by what differs from the controller's own, as the panel states it, or else as a whole."""
    controller = controller_of(bench)
    own = controller.operating_points[0]
    if condition == own:
        return bench
    rpm = unit("rpm", "rotational_speed")
    differ = {
        "temperature": None if condition.temperature == own.temperature else condition.temperature,
        "engine_speed": None if condition.engine_speed == own.engine_speed else condition.engine_speed,
        "gear": None if condition.gear == own.gear else condition.gear,
    }
    if condition.gear not in controller.gears or stated_condition(controller, **differ) != condition:
        return replace(bench, point=condition)
    speed = differ.pop("engine_speed")
    return replace(bench, **differ, rpm=None if speed is None else rpm.from_si(speed))


def _chosen(slot: str, source: SourceFile) -> str | File:
    files = catalogue.catalogue_files("instruments" if slot.endswith("instrument") else FOLDERS[slot])
    same = (name for name, path in files.items() if path.read_bytes() == source.content)
    return next(same, None) or File(source.name, source.content)


def _pairs(found: Any) -> tuple[tuple[str, Any], ...]:
    return tuple((found or {}).items())


@st.cache_resource(max_entries=64, show_spinner=False)
def _catalogue_object(kind: str, key: str, _choice: str | File) -> Any:
    if isinstance(_choice, str):
        return LOADERS[kind](_choice)
    return load_source(LOADERS[kind], SourceFile(_choice.name, _choice.data))


def catalogue_object(kind: str, choice: str | File) -> Any:
    """A controller, fluid or limit set by id, or from the user's own TOML file."""
    return _catalogue_object(kind, repr(choice), choice)


def controller_of(bench: Bench) -> Controller:
    return catalogue_object("controller", bench.controller)


@st.cache_resource(max_entries=6, show_spinner="Reading the road-test log …")
def _understood(key: str, _log: File, _told: dict[str, Any], _memory: bool) -> Understood:
    return understand(_log.data, name=_log.name, remembered=default_path() if _memory else None, **_told)


def understood(
    log: File, columns: tuple = (), units: tuple = (), constants: tuple = (), memory: bool = True
) -> Understood:
    """What a log holds, open questions included; with the answers that are remembered now."""
    told = {"mapping": dict(columns), "units": dict(units), "constants": dict(constants)}
    key = repr((log, told))
    found = _understood(key, log, told, False)
    earlier = recall(default_path(), found.signature) if memory else None
    return found if earlier is None else _understood(f"{key} {earlier}", log, told, True)


def log_of(bench: Bench) -> Understood:
    """What the job's log holds."""
    assert bench.log is not None
    return understood(bench.log, bench.columns, bench.units, bench.constants, bench.memory)


def remembered_columns(log: File) -> Settled | None:
    """How the columns of logs with this header were settled earlier."""
    return recall(default_path(), understood(log).signature)


def sheet_choices(bench: Bench) -> dict[str, Any]:
    """How the job's measuring sheet is to be read, for reading it and for its job file."""
    return {
        "sheet": bench.sheet_name or None,
        "unit": bench.sheet_unit or None,
        "where": dict(bench.sheet_where),
    }


def log_choices(bench: Bench) -> dict[str, Any]:
    """How the columns of the job's log are settled, for its job file."""
    if bench.log is None:
        return {}
    told = {"mapping": dict(bench.columns), "units": dict(bench.units), "constants": dict(bench.constants)}
    return road_test_choices(log_of(bench), **told, remembered=default_path())


def remember_columns(log: File, columns: dict[str, str], units: dict[str, str]) -> str:
    """Keep how this log's columns were settled, for every log with the same header; why it cannot be kept, else ""."""
    try:
        remember(default_path(), understood(log).signature, columns, units)
    except OutputError as error:
        return error.problem
    return ""


@st.cache_resource(max_entries=6, show_spinner="Computing …")
def _diagnosis(key: str, _bench: Bench) -> Diagnosis:
    controller = controller_of(_bench)
    fluid, limits, spool, sleeve = (
        catalogue_object(kind, getattr(_bench, kind))
        for kind in ("fluid", "limits", "spool_instrument", "sleeve_instrument")
    )
    condition = stated_condition(
        controller if _bench.point is None else replace(controller, operating_points=(_bench.point,)),
        temperature=_bench.temperature,
        engine_speed=None if _bench.rpm is None else unit("rpm", "rotational_speed").to_si(_bench.rpm),
        gear=_bench.gear,
    )
    sheet, log = _bench.sheet, _bench.log
    road_test = None
    if log is not None:
        found = log_of(_bench)
        if found.road_test is None:
            raise found.problem or RoadTestError("cannot be read", place=Place(file=log.name))
        road_test = found.road_test if _bench.window is None else found.road_test.window(*_bench.window)
    return diagnose(
        controller,
        fluid,
        limits,
        readings=None
        if sheet is None
        else read_readings(sheet.data, controller, name=sheet.name, **sheet_choices(_bench)),
        road_test=road_test,
        profile=find_profile(_bench.profile, dict(_bench.options)),
        condition=condition,
        mileage=_bench.mileage,
        instruments=Instruments(spool, sleeve),
        assumptions=DEFAULTS.with_settings(dict(_bench.assumptions)),
        guard_factor=GUARD_FACTOR if _bench.guard_factor is None else _bench.guard_factor,
    )


def diagnosis_of(bench: Bench) -> Diagnosis:
    """The diagnosis of a job.

    Raises
    ------
    AtleakError
        saying what of the job cannot be used.
    """
    return _diagnosis(result_key(bench), bench)


def result_key(bench: Bench) -> str:
    """What a result of this job is kept by: its files and choices, and what is remembered of its log's columns."""
    earlier = remembered_columns(bench.log) if bench.log is not None and bench.memory else None
    return f"{bench.key} {earlier}"
