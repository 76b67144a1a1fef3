"""Write what a job's files say of the transmission as plain files that hold nothing else: no head, name, note or place.

Each is read back as the job reads it. One that does not say the same again is not given.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields, is_dataclass
from functools import partial
from itertools import pairwise, zip_longest
from typing import Any

import numpy as np

from atleak.catalogue.controller import Controller
from atleak.catalogue.repairs import LandKey
from atleak.common.errors import AtleakError
from atleak.common.units import DM3_MIN, KPA, MM, RPM, Unit, kinds_of, unit
from atleak.job.case import Pairs, SourceFile
from atleak.measurements.flow_readings import FlowTable
from atleak.measurements.gauge_readings import PressureTable
from atleak.measurements.readings import OwnLands, Reading, Readings
from atleak.measurements.road_test import QUANTITIES, Channel, RoadTest
from atleak.measurements.vacuum import VacuumTable
from atleak.readers.cells.sheet_file import csv_bytes
from atleak.readers.gauges.gauge_table import read_pressure_table
from atleak.readers.gauges.vacuum_table import read_vacuum_table
from atleak.readers.gauges.value_table import read_flow_table
from atleak.readers.logs import understand
from atleak.readers.logs.timeline import gap_limit
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.sheets.measuring_columns import PUMP_SIDE, PUMP_TIP
from atleak.report.sheets.measuring_head import FIELDS
from atleak.report.sheets.measuring_sheet import write_readings

_DIGITS = 12  # significant ones: more than a logger writes and fewer than a float's last, which conversion may change
_SAME = 1e-9  # relative difference of values that are the same
_METRES = 1e-12  # difference of diameters that are the same
_CHANNELS = 1e-9  # [SI] of channels
_TIME = "time [s]"


# --- diameters


def plain_sheet(readings: Readings, controller: Controller) -> SourceFile | None:
    """Return a measuring sheet of the same readings; None where it would be read otherwise, or holds no diameter.

    Readings at unworn ends, which no verdict uses, and gauge readings, which have a file of their own, are not in it.
    The controller is as its file describes it, without what this unit has of its own.
    """
    fields: dict[str, Any] = {
        "Date": readings.date and readings.date.isoformat(),
        "Mileage": readings.identity.mileage is not None and f"{readings.identity.mileage!r} km",
        "Measuring temperature": readings.temperature is not None and f"{readings.temperature!r} °C",
        **{
            label: clearance is not None and f"{clearance!r} µm"
            for label, clearance in zip((PUMP_SIDE, PUMP_TIP), readings.pump.um, strict=True)
        },
    }
    assert set(fields) <= set(FIELDS)
    content = write_readings(
        controller,
        readings.readings,
        fields={label: text for label, text in fields.items() if text},
        blank_rows=False,
        own_lands=readings.own_lands,
    )
    file = SourceFile("measuring sheet.xlsx", content)
    try:
        again = read_readings(content, controller, name=file.name)
    except AtleakError:
        return None
    return file if _same_readings(readings, again, controller) else None


def _same_readings(one: Readings, other: Readings, controller: Controller) -> bool:
    """Return whether two sheets say the same of a controller's lands and of how they were measured."""
    beside = ((each.temperature, each.pump.um, each.identity.mileage) for each in (one, other))
    if len(set(beside)) > 1:
        return False
    if _own(one.own_lands) != _own(other.own_lands):
        return False
    mine, theirs = (_of_lands(each.readings, controller) for each in (one, other))
    return [each.station for each in mine] == [each.station for each in theirs] and all(
        abs(each.diameter - again.diameter) <= _METRES for each, again in zip(mine, theirs, strict=True)
    )


def _own(lands: OwnLands) -> tuple[list[tuple[LandKey, float | None, float | None]], list[tuple[str, str]]]:
    lengths = sorted((each.key, _length(each.contact_length), _length(each.position)) for each in lands.lengths)
    return lengths, sorted((each.component, each.repair) for each in lands.fitted)


def _length(metres: float | None) -> float | None:
    return None if metres is None else round(metres, _DIGITS)


def _of_lands(readings: Iterable[Reading], controller: Controller) -> list[Reading]:
    known = [each for each in readings if controller.land_of_plane(each.component, each.plane) is not None]
    return sorted(known, key=lambda each: (*each.station[:3], each.direction or -1.0, each.repeat))


# --- a log's channels


@dataclass(frozen=True)
class PlainLog:
    """A log of the channels alone, with the choices by which it is read."""

    file: SourceFile
    columns: Pairs  # quantity → column, as `Case` keeps them
    units: Pairs  # quantity → unit


def plain_log(test: RoadTest, constants: Pairs) -> PlainLog | None:
    """Return a log of the channels that were understood; None where it would be read otherwise.

    ``constants`` stand for channels that the log lacks: quantity and value in SI.
    """
    logged = {name: channel for name, channel in test.channels.items() if channel.source == "logged"}
    shared = all(np.isin(channel.time, test.time).all() for channel in logged.values())
    headings: list[str] = []
    table: list[list[float]] = []  # a column under each
    columns, units = ({"time": _TIME}, {"time": "s"}) if shared else ({}, {})

    def add(heading: str, values: np.ndarray) -> None:
        headings.append(heading)
        table.append(values.tolist())

    if shared:
        add(_TIME, _with_restarts(test))
    for quantity, channel in logged.items():
        written = _unit_of(quantity, channel)
        values = written.from_si(channel.values) if written else channel.values
        if shared:
            rows = slice(None) if len(channel.time) == len(test.time) else np.searchsorted(test.time, channel.time)
            held, values = values, np.full(len(test.time), np.nan)
            values[rows] = held
        else:  # every channel with its own stamps before it
            add(_TIME, channel.time)
        kind = channel.kind if channel.kind != "unknown" else ""
        label = f"{kind} {quantity.replace('_', ' ')}".strip()
        columns[quantity] = f"{label} [{written.name}]" if written else label
        if written is not None and QUANTITIES[quantity].unit_kind is not None:
            units[quantity] = written.name
        add(columns[quantity], values)
    stream = io.StringIO(newline="")
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(headings)
    writer.writerows([_digits(value) for value in row] for row in zip_longest(*table, fillvalue=math.nan))
    file = SourceFile("road test.csv", stream.getvalue().encode())
    plain = PlainLog(file, tuple(columns.items()), tuple(units.items()))
    return plain if _reads_the_same(plain, test, constants) else None


def _with_restarts(test: RoadTest) -> np.ndarray:
    """Return the stamps [s] with the clock set back where a recording began anew, not after a gap: so they are kept."""
    stamps = test.time.copy()
    limit = gap_limit(np.diff(test.time))
    for before, segment in pairwise(test.segments):
        if segment.start - before.stop <= limit:
            stamps[segment.start_row :] = test.time[segment.start_row :] - segment.start + test.time[0]
    return stamps


def _unit_of(quantity: str, channel: Channel) -> Unit | None:
    """Return the unit in which the logger wrote a channel; None for a plain number."""
    kind = QUANTITIES[quantity].unit_kind or next(iter(kinds_of(channel.unit)), None)
    return unit(channel.unit or QUANTITIES[quantity].workshop_unit, kind) if kind and channel.unit else None


def _digits(value: float) -> str:
    return "" if value != value else f"{value:.{_DIGITS}g}"


def _reads_the_same(plain: PlainLog, test: RoadTest, constants: Pairs) -> bool:
    try:
        choices: dict[str, Any] = {"mapping": dict(plain.columns), "units": dict(plain.units)}
        again = understand(plain.file.content, name=plain.file.name, constants=dict(constants), **choices).road_test
    except AtleakError:
        return False
    read = {name: channel for name, channel in test.channels.items() if channel.source != "derived"}
    if again is None or set(again.channels) != set(read) or len(again.segments) != len(test.segments):
        return False
    return _close(test.time, again.time) and all(
        _close(one.time, other.time)
        and _close(one.good, other.good)
        and (one.kind == other.kind or QUANTITIES[one.quantity].unit_kind != "pressure")
        for one, other in ((channel, again.channels[name]) for name, channel in read.items())
    )


def _close(one: np.ndarray, other: np.ndarray) -> bool:
    return one.shape == other.shape and np.allclose(one, other, rtol=_SAME, atol=_CHANNELS, equal_nan=True)


# --- gauge readings


def plain_gauges(table: PressureTable, controller: Controller) -> SourceFile | None:
    """Return a table of the same gauge readings; None where it would be read otherwise."""
    stream = io.StringIO(newline="")
    rows = csv.writer(stream, delimiter=";", lineterminator="\r\n")
    rows.writerow(["range", "state", "tap", "repeat", "gauge [kPa]", "ATF temperature [°C]", "engine speed [rpm]"])
    for each in table.readings:
        cell, speed = each.cell, each.engine_speed
        numbers = (each.pressure * KPA, each.temperature, None if speed is None else speed * RPM)
        written = ["" if number is None else _digits(number) for number in numbers]
        rows.writerow([cell.range, cell.engine.label, cell.tap, each.repeat, *written])
    file = SourceFile("gauge readings.csv", stream.getvalue().encode())
    try:
        again = read_pressure_table(file.content, controller, name=file.name)
    except AtleakError:
        return None
    return file if _gauged(table) == _gauged(again) else None


def _gauged(table: PressureTable) -> list[tuple[str, ...]]:
    """Return every reading of a table in words, to be compared."""
    found = []
    for each in table.readings:
        numbers = (each.pressure, each.temperature, each.engine_speed)
        texts = ["" if number is None else f"{number:.9g}" for number in numbers]
        found.append((each.cell.range, each.cell.engine.value, each.cell.tap, str(each.repeat), *texts))
    return sorted(found)


# --- a vacuum test, and flows


def plain_vacuum(table: VacuumTable, controller: Controller) -> SourceFile | None:
    """Return a vacuum test of the same stand and readings; None where it would be read otherwise."""
    stand = table.stand
    head = [("supply", stand.supply, "Pa"), ("ambient", stand.ambient, "Pa"), ("temperature", stand.temperature, "°C")]
    if stand.flow_area is not None:
        head.append(("flow area", stand.flow_area * MM**2, "mm²"))
    rows = [[name, _digits(value), unit_name] for name, value, unit_name in head]
    for each in stand.calibrations:
        own = [] if each.fitted is None else [_digits(each.fitted * MM), "mm"]
        rows.append(["calibration", _digits(each.orifice * MM), "mm", _digits(each.vacuum), "Pa", *own])
    rows.append(["circuit", "reading [Pa]", "orifice [mm]", "state"])
    for reading in table.readings:
        lands = "+".join(f"{component}/{land}" for component, land in reading.lands)
        orifice = "" if reading.orifice is None else _digits(reading.orifice * MM)
        state = "repaired" if reading.repaired else "worn"
        rows.append([reading.circuit or lands, _digits(reading.vacuum), orifice, state])
    return _plain_table("vacuum test.csv", rows, table, partial(read_vacuum_table, controller=controller))


def plain_flows(table: FlowTable, controller: Controller) -> SourceFile | None:
    """Return a table of the same flows; None where it would be read otherwise."""
    rows = [["condition", "what", "value [l/min]"]]
    rows += [[each.condition, each.what, _digits(each.flow * DM3_MIN)] for each in table.readings]
    return _plain_table("flows.csv", rows, table, partial(read_flow_table, controller=controller))


def _plain_table(name: str, rows: list[list[str]], table: Any, read: Callable[..., Any]) -> SourceFile | None:
    """Return a file of rows; None where its readings, or its stand, differ from those of the table."""
    file = SourceFile(name, csv_bytes(rows))
    try:
        again = read(file.content, name=name)
    except AtleakError:
        return None
    parts = ((each.readings, getattr(each, "stand", None)) for each in (table, again))
    return file if _alike(*parts) else None


def _alike(one: Any, other: Any) -> bool:
    """Return whether readings say the same, whatever is their place and how their target is written."""
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=_SAME)
    if is_dataclass(one):
        names = (field.name for field in fields(one) if field.name not in ("place", "target"))
        return all(_alike(getattr(one, name), getattr(other, name)) for name in names)
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(_alike, one, other))
    return bool(one == other)
