"""Do for one unit what a worker of dask's does: diagnose it within its time, and write what is kept of it as rows.

A process that takes too long is ended, even where it hangs in compiled code.
"""

from __future__ import annotations

import contextlib
import datetime as dt
import faulthandler
import itertools
import os
import pickle
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pyarrow as pa
from distributed import get_worker

from atleak.analysis.record_doubts import with_sheet
from atleak.catalogue.controller import Controller
from atleak.common.damage import unexpected
from atleak.common.errors import AtleakError, InputError
from atleak.common.units import DM3_MIN, KPA, PERCENT
from atleak.common.verdicts import Verdict, worst
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.engine.road_pressure import TemperatureClass
from atleak.fleet.columns import HASH, DataSet, ErrorKind, Rows, columns_of
from atleak.fleet.folder import folder_of
from atleak.fleet.units import FleetUnit
from atleak.job.case import Case, CaseChoice, Reader, Slot
from atleak.job.result import result_sha256
from atleak.measurements.job_card import Job
from atleak.measurements.readings import Readings
from atleak.readers.logs import Understood, default_path, understand
from atleak.report.json.diagnosis import diagnosis_record
from atleak.version import __version__

_INSTANTS = {  # of the record of a road test: the columns of `units` that stand in it
    "max_leakage": ("leakage_dm3_min", "leakage_low_dm3_min", "leakage_high_dm3_min"),
    "max_share": ("share_percent", "share_low_percent", "share_high_percent"),
    "min_leakage": ("leakage_dm3_min",),
}
STATUS = 75  # with which the process ends
_LAST_WORDS = 0.5  # [s] for what is told to get out
_GRACE = 5.0  # [s] later the process is ended without a word
_lock = threading.Lock()
_deadlines: dict[int, float] = {}  # of whatever is under way in this process, by the clock that never goes back
_numbers = itertools.count()
_nowhere: int | None = None
_KEPT = 64  # entries of the catalogue
_ENTRIES: dict[tuple[str, str, str], Any] = {}
OVERDUE = "atleak-fleet-overdue"  # topic of the scheduler's event log: whose time limit was exceeded
BEGUN = "atleak-fleet-begun"  # likewise: which unit is begun now, of those that are tried alone
_OUT = 0.5  # [s] for what is told to get out: a unit may hold the interpreter at once


def rows_of_result(
    unit: FleetUnit,
    diagnosis: Diagnosis,
    job: Job | None = None,
    *,
    seconds: float | None = None,
    tries: int = 1,
) -> Rows:
    """Return the rows of a unit that was diagnosed.

    Parameters
    ----------
    seconds
        that its evaluation took so far [s].
    tries
        how often it was begun.

    Raises
    ------
    InputError
        the id of the valve body is too long for the name of a folder.
    """
    folder_of(diagnosis.controller.id)  # here, where an id that names no folder concerns this unit alone
    record = diagnosis_record(diagnosis)
    road = record["road_test"]
    of_unit = {
        **_named(unit, tries),
        "seconds": seconds,
        **_written_down(job, record),
        **_diagnosed_with(record),
        "lands_judged": diagnosis.judged,
        **_judged(record["unit"]),
        **_road(road),
        "result_sha256": result_sha256(record),
    }
    own = {HASH: unit.input_sha256}
    rows: dict[DataSet, list[dict[str, Any]]] = {
        "units": [of_unit],
        "lands": [{**own, **land} for land in record["lands"]],
        "conditions": [{**own, **condition} for condition in record["conditions"]],
        "circuits": [
            {**own, "condition": condition["name"], **circuit}
            for condition in record["conditions"]
            for circuit in condition["circuits"]
        ],
        "events": [{**own, **event} for event in (road["events"] if road else ())],
        "temperatures": [{**own, **_temperature(each)} for each in diagnosis.temperature_classes],
    }
    return Rows(
        controller=diagnosis.controller.id,
        input_sha256=unit.input_sha256,
        reference=unit.reference,
        verdict=diagnosis.verdict,
        tables={data_set: _table(data_set, of_set) for data_set, of_set in rows.items() if of_set},
    )


def error_rows(unit: FleetUnit, kind: ErrorKind, message: str, *, tries: int = 1) -> Rows:
    """Return the row of a unit without a result: why it has none, what a person is told, how often it was begun."""
    row = {**_named(unit, tries), "kind": kind, "message": message}
    tables: dict[DataSet, pa.Table] = {"errors": _table("errors", [row])}
    return Rows(None, unit.input_sha256, unit.reference, None, tables)


def _table(data_set: DataSet, rows: Sequence[Mapping[str, Any]]) -> pa.Table:
    """Return rows as a table: what they say beyond its columns is left out, what they do not say is null."""
    columns = columns_of(data_set)
    whole = pa.array(rows, pa.struct(columns))
    return pa.Table.from_arrays(whole.flatten(), schema=columns)


def _named(unit: FleetUnit, tries: int) -> dict[str, Any]:
    return {
        HASH: unit.input_sha256,
        "reference": unit.reference,
        "name": unit.name,
        "group": unit.group,
        "labels": list(unit.labels),
        "choices": unit.choices,
        "atleak": __version__,
        "evaluated_at": dt.datetime.now(dt.UTC),
        "tries": tries,
    }


def _written_down(job: Job | None, record: Mapping[str, Any]) -> dict[str, Any]:
    """Return what tells the job from others; the mileage is that with which the result was computed."""
    identity = {} if job is None else job.identity
    mileage = record["mileage_km"]
    return {
        **{name: identity.get(name) for name in ("number", "vin", "serial")},
        "date": None if job is None else job.date,
        "mileage_km": identity.get("mileage_km") if mileage is None else mileage,
    }


def _diagnosed_with(record: Mapping[str, Any]) -> dict[str, Any]:
    controller, fluid, limits, readings = (record[name] for name in ("controller", "fluid", "limits", "readings"))
    options = {name: str(value) for name, value in record["profile"].items() if name != "name"}
    uncertainty, complaint = record["uncertainty"], record["complaint"]
    return {
        "controller_name": controller["name"],
        "controller_sha256": controller["sha256"],
        "fluid": fluid["id"],
        "fluid_sha256": fluid["sha256"],
        "fluid_state": fluid["state"],
        "limits": limits["id"],
        "limits_sha256": limits["sha256"],
        "profile": record["profile"]["name"],
        "options": list(options.items()),
        "assumptions": None if uncertainty is None else list(uncertainty["assumptions"].items()),
        "guard_factor": None if uncertainty is None else uncertainty["guard_factor"],
        "complaint": None if complaint is None else complaint["id"],
        "readings_sha256": readings["sha256"],
        "measured_on": None if readings["date"] is None else dt.date.fromisoformat(readings["date"]),
        "lands_measured": readings["lands_measured"],
        "lands_total": readings["lands_total"],
    }


def _judged(unit: Mapping[str, Any]) -> dict[str, Any]:
    decided_by = unit["decided_by"] or {}
    return {
        **{name: unit[name] for name in ("verdict", "decision", "provisional")},
        **{
            f"decided_by_{name}": decided_by.get(name) for name in ("kind", "condition", "component", "land", "circuit")
        },
    }


def _road(road: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return what the record of a road test says of the unit; nothing without one."""
    if road is None:
        return {}
    instants = {
        f"{name.partition('_')[0]}_{column}": road[name][column]
        for name, columns in _INSTANTS.items()
        for column in columns
        if road[name] is not None
    }
    permissible, commanded = road["permissible_pressure"], road["commanded_pressure"]
    verdicts = [Verdict(each["verdict"]) for each in (permissible, commanded) if each and each["verdict"]]
    return {
        "road_sha256": road["sha256"],
        "road_rows": road["rows"],
        "road_duration_s": road["duration_s"],
        "road_in_pieces": False,
        **instants,
        "below_s": permissible["below_s"] if permissible else None,
        "worst_below_kpa": permissible["worst_below_kpa"] if permissible else None,
        "road_verdict": worst(verdicts) if verdicts else None,
    }


def _temperature(each: TemperatureClass) -> dict[str, Any]:
    def scaled(value: float | None, factor: float) -> float | None:
        return None if value is None else value * factor

    return {
        "temperature_low_c": each.low,
        "temperature_high_c": each.high,
        "seconds": each.seconds,
        **{f"{band}_s": seconds for band, seconds in each.in_bands.items()},
        "share_mean_percent": scaled(each.share_mean, PERCENT),
        "share_max_percent": scaled(each.share_max, PERCENT),
        "pressure_mean_kpa": scaled(each.pressure_mean, KPA),
        "pressure_min_kpa": scaled(each.pressure_min, KPA),
        "leakage_mean_dm3_min": each.leakage_mean * DM3_MIN,
    }


@contextlib.contextmanager
def ended_after(seconds: float | None, tell: Callable[[], object]) -> Iterator[None]:
    """End this process where the block takes longer.

    A thread of Python's does it and says why. Where one piece of compiled code holds the interpreter, no thread of
    Python's runs: then a timer of the C library's does it, a little later and without a word.

    Parameters
    ----------
    seconds
        for the block; None: as long as it takes.
    tell
        called first, by another thread; what it begins has half a second to get out.
    """
    if seconds is None:
        yield
        return
    timer = threading.Timer(seconds, _leave, (tell,))
    timer.daemon = True
    number = next(_numbers)
    timer.start()
    _set(number, time.monotonic() + seconds + _GRACE)
    try:
        yield
    finally:
        _set(number, None)
        timer.cancel()


def _set(number: int, deadline: float | None) -> None:
    """Enter or strike out a deadline and set the C library's timer, of which there is one, to the first of them."""
    global _nowhere
    with _lock:
        _deadlines.pop(number, None)
        if deadline is not None:
            _deadlines[number] = deadline
        if not _deadlines:
            faulthandler.cancel_dump_traceback_later()
            return
        if _nowhere is None:
            _nowhere = os.open(os.devnull, os.O_WRONLY)  # as long as the process
        left = max(min(_deadlines.values()) - time.monotonic(), 0.001)
        faulthandler.dump_traceback_later(left, exit=True, file=_nowhere)


def _leave(tell: Callable[[], object]) -> None:
    try:
        tell()
        time.sleep(_LAST_WORDS)
    finally:
        os._exit(STATUS)


class _Reader(Reader):
    """Read every file of a job anew, but keep what jobs take from the catalogue: a fleet is of few valve bodies."""

    with_cells = False

    def __init__(self, memory: int | None) -> None:
        self._memory = memory

    def readings(self, case: Case, controller: Controller) -> Readings:
        """Read the job's measuring sheet as its row says: what this computer remembers of sheets is not its own.

        Raises
        ------
        ReadingsError
            as `read_readings`.
        """
        return super().readings(replace(case, remember=False), controller)

    def log(self, case: Case) -> Understood:
        """Read the job's log.

        Raises
        ------
        RoadTestError
            for a file that is no log, or takes more memory than a unit may.
        """
        file = case.road_test
        assert file is not None
        remembered = default_path() if case.remember else None
        return understand(file.given, name=file.name, memory=self._memory, remembered=remembered, **case.log_choices)

    def entry(self, slot: Slot, choice: CaseChoice | None) -> Any:
        """Return an entry as it was loaded before, where it is of the same bytes."""
        own = slot.own_file(choice)
        key = (slot.name, str(choice), "") if own is None else (slot.name, own.name, own.sha256)
        entry = _ENTRIES.get(key)
        if entry is None:
            entry = _ENTRIES[key] = super().entry(slot, choice)
            for oldest in list(_ENTRIES)[:-_KEPT]:
                _ENTRIES.pop(oldest, None)  # another thread may have been first
        return entry


def evaluate_unit(unit: FleetUnit, *, tries: int = 1, memory: int | None = None, folder: Path | None = None) -> Rows:
    """Return the rows of a unit: those of its diagnosis, or the one row that says why there is none; never raises.

    A unit for which the memory did not suffice is of the kind ``ended``, as one whose worker was ended for it.

    Parameters
    ----------
    unit
        to be diagnosed, exactly as `atleak.job.case.Case.diagnose` does.
    tries
        how many times it was begun, this time with it.
    memory
        that it may take [bytes]; unless given, as much as is free.
    folder
        where the files of a job are unpacked; unless given, with temporary files. Nothing of them stays there.
    """
    begun = time.perf_counter()
    try:
        with TemporaryDirectory(prefix="atleak-", dir=folder, ignore_cleanup_errors=True) as unpacked:
            case, job = unit.opened(Path(unpacked))
            diagnosis = case.diagnose(_Reader(memory))
            job = with_sheet(job, diagnosis.readings) or job
            return rows_of_result(unit, diagnosis, job, seconds=time.perf_counter() - begun, tries=tries)
    except AtleakError as error:
        if isinstance(error, InputError):
            unit.name_within(error)
        short = any(isinstance(each, MemoryError) for each in _causes(error))
        return error_rows(unit, "ended" if short else "refused", str(error), tries=tries)
    except MemoryError as error:
        return error_rows(unit, "ended", str(unexpected(error, unit.name)), tries=tries)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # noqa: BLE001 (a panic of a library in Rust is no Exception)
        return error_rows(unit, "fault", str(unexpected(error, unit.name)), tries=tries)


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = error.__cause__


class OtherVersionError(Exception):
    """A worker has another version of atleak than the one that sent it a unit."""


def on_worker(
    unit: bytes, name: str, tries: int, time_limit: float | None, version: str, *, tell_begun: bool = False
) -> Rows:
    """Evaluate a unit within its time.

    Parameters
    ----------
    unit
        pickled: dask then need not look for anything of its own in it.
    name
        of this try, by which the scheduler's event log is to know it.
    tries
        how often the unit was begun, this time with it.
    time_limit
        [s] after which this process ends; None: never.
    version
        of the atleak that sends the unit.
    tell_begun
        whether the scheduler's event log is told when the unit's time begins.

    Raises
    ------
    OtherVersionError
        this worker has another one, by which the results would not be what the run says they are.
    """
    if version != __version__:
        raise OtherVersionError(__version__)
    worker = get_worker()
    if tell_begun:
        worker.log_event(BEGUN, {"name": name})
        time.sleep(_OUT)
    with ended_after(time_limit, lambda: worker.log_event(OVERDUE, {"name": name, "worker": worker.address})):
        memory, folder = worker.memory_manager.memory_limit or None, Path(worker.local_directory)
        return evaluate_unit(pickle.loads(unit), tries=tries, memory=memory, folder=folder)
