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

from atleak.controller import Controller, load_controller
from atleak.diagnosis import Diagnosis, diagnose
from atleak.errors import Place, RoadTestError
from atleak.fluid import load_fluid
from atleak.instruments import DEFAULT_SLEEVE_INSTRUMENT, DEFAULT_SPOOL_INSTRUMENT, Instruments, load_instrument
from atleak.intake.readings import read_readings
from atleak.intake.road_test import Understood, default_path, recall, remember, understand
from atleak.intake.road_test.memory import Settled
from atleak.intake.units import unit
from atleak.job_file import SourceFile, load_source, road_test_choices
from atleak.limits import load_limits
from atleak.profile import find_profile
from atleak.projection import stated_condition

SAMPLES = Path(__file__).resolve().parents[2] / "sample_data"
LOADERS = {
    "controller": load_controller,
    "fluid": load_fluid,
    "limits": load_limits,
    "spool_instrument": load_instrument,
    "sleeve_instrument": load_instrument,
}


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
    columns: tuple[tuple[str, str], ...] = ()  # quantity → column of the log, where the user settled it
    units: tuple[tuple[str, str], ...] = ()
    window: tuple[float, float] | None = None  # [s] of the log that is looked at
    sample: bool = False

    @property
    def key(self) -> str:
        """What a result of this job is kept by."""
        return hashlib.sha256(repr(self).encode("utf-8", "backslashreplace")).hexdigest()

    def with_file(self, slot: str, file: File | None) -> Bench:
        """This job with another sheet or log; the sample's other file never mixes with the user's own."""
        settled = {"sheet": {"sheet_name": "", "sheet_unit": ""}, "log": {"columns": (), "units": ()}}
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
def _understood(key: str, _log: File, _columns: dict[str, str], _units: dict[str, str], _memory: bool) -> Understood:
    remembered = default_path() if _memory else None
    return understand(_log.data, name=_log.name, mapping=_columns, units=_units, remembered=remembered)


def understood(log: File, columns: tuple = (), units: tuple = ()) -> Understood:
    """What a log holds, open questions included; with the answers that are remembered now."""
    told = repr((log, columns, units))
    found = _understood(told, log, dict(columns), dict(units), False)
    earlier = recall(default_path(), found.signature)
    if earlier is None:
        return found
    return _understood(f"{told} {earlier}", log, dict(columns), dict(units), True)


def remembered_columns(log: File) -> Settled | None:
    """How the columns of logs with this header were settled earlier."""
    return recall(default_path(), understood(log).signature)


def log_choices(bench: Bench) -> dict[str, Any]:
    """How the columns of the job's log are settled, for its job file."""
    if bench.log is None:
        return {}
    columns, units = dict(bench.columns), dict(bench.units)
    log = understood(bench.log, bench.columns, bench.units)
    return road_test_choices(log, columns, units, remembered=default_path())


def remember_columns(log: File, columns: dict[str, str], units: dict[str, str]) -> str:
    """Keep how this log's columns were settled, for every log with the same header; why it cannot be kept, else ""."""
    try:
        remember(default_path(), understood(log).signature, columns, units)
    except OSError as error:
        return error.strerror or str(error)
    return ""


@st.cache_resource(max_entries=6, show_spinner="Computing …")
def _diagnosis(key: str, _bench: Bench) -> Diagnosis:
    controller = controller_of(_bench)
    fluid, limits, spool, sleeve = (
        catalogue_object(kind, getattr(_bench, kind))
        for kind in ("fluid", "limits", "spool_instrument", "sleeve_instrument")
    )
    condition = stated_condition(
        controller,
        temperature=_bench.temperature,
        engine_speed=None if _bench.rpm is None else unit("rpm", "rotational_speed").to_si(_bench.rpm),
        gear=_bench.gear,
    )
    sheet, log = _bench.sheet, _bench.log
    road_test = None
    if log is not None:
        found = understood(log, _bench.columns, _bench.units)
        if found.road_test is None:
            raise found.problem or RoadTestError("cannot be read", place=Place(file=log.name))
        road_test = found.road_test if _bench.window is None else found.road_test.window(*_bench.window)
    return diagnose(
        controller,
        fluid,
        limits,
        readings=None
        if sheet is None
        else read_readings(
            sheet.data, controller, name=sheet.name, sheet=_bench.sheet_name or None, unit=_bench.sheet_unit or None
        ),
        road_test=road_test,
        profile=find_profile(_bench.profile, dict(_bench.options)),
        condition=condition,
        mileage=_bench.mileage,
        instruments=Instruments(spool, sleeve),
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
    earlier = None if bench.log is None else remembered_columns(bench.log)
    return f"{bench.key} {earlier}"
