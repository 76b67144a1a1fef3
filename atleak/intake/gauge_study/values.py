"""The cells of a gauge study's table → readings by part, operator and trial; what cannot be read is a problem."""

from __future__ import annotations

import datetime as dt
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from statistics import median

import numpy as np

from atleak.errors import Message, Place
from atleak.gauge_study.readings import FEWEST, GaugeStudyError, StudyReadings
from atleak.intake.gauge_study.table import StudyTable, text_of
from atleak.intake.units import Unit, unit
from atleak.written_numbers import decimal_number

_USUAL_M = (0.5e-3, 100e-3)  # [m] diameters of valve bodies: outside of it another unit may have been meant
_ENDS = ("average", "mean", "mittelwert", "średnia", "srednia", "range", "spannweite", "rozstęp")
_SHOWN = 6


@dataclass
class _Cells:
    """What the cells give so far."""

    by_pair: dict[tuple[str, str], list[tuple[str | None, float, Place]]] = field(default_factory=dict)
    problems: list[GaugeStudyError] = field(default_factory=list)


def crossed(table: StudyTable, stated: Unit | None, sha256: str) -> tuple[StudyReadings | None, list[GaugeStudyError]]:
    """Return the readings of a table, and what of it cannot be read.

    Parameters
    ----------
    table
        with the columns of a sheet.
    stated
        the unit of all readings, where it was asked for; else that of their heading, else mm.
    sha256
        of the file.
    """
    cells = _Cells()
    for row in range(table.row + 1, len(table.sheet.rows)):
        _read_row(table, row, stated, cells)
    file = table.sheet.file
    if not cells.problems:
        cells.problems += _gaps(cells, table)
    if cells.problems:
        return None, cells.problems
    parts = tuple(dict.fromkeys(part for part, _ in cells.by_pair))
    operators = tuple(dict.fromkeys(operator for _, operator in cells.by_pair))
    values = np.array(
        [[[value for _, value, _ in cells.by_pair[part, operator]] for operator in operators] for part in parts]
    )
    messages = tuple(_messages(table, stated, values))
    return StudyReadings(parts, operators, values, file, sha256, messages), []


def _read_row(table: StudyTable, row: int, stated: Unit | None, cells: _Cells) -> None:
    sheet = table.sheet
    filled = [column for column in table.values if _is_filled(table, row, column)]
    if not filled:
        return
    named: dict[str, str] = {}
    for key, column in table.keys.items():
        name = text_of(sheet.filled(row, column))
        if not name and key != "trial":
            # a form names an operator once, on the first of the rows that are his
            name = next((above for above in _above(table, row, column) if above), "")
        if name.casefold() in _ENDS:
            return  # the averages at the foot of a form are no readings
        if not name and key != "trial":
            problem = f"nothing says of which {key} this row's readings are"
            cells.problems.append(GaugeStudyError(problem, place=_place(table, row, column), expected=f"a {key}"))
            return
        named[key] = name
    for column in filled:
        value = _value(table, row, column, stated, cells)
        if value is not None:
            said: Mapping[str, str] = {**named, **table.values[column]}
            pair = said["part"], said["operator"]
            cells.by_pair.setdefault(pair, []).append((said.get("trial") or None, value, _place(table, row, column)))


def _above(table: StudyTable, row: int, column: int) -> Iterator[str]:
    return (text_of(table.sheet.filled(above, column)) for above in range(row - 1, table.row, -1))


def _is_filled(table: StudyTable, row: int, column: int) -> bool:
    cell = table.sheet.cell(row, column)
    if table.sheet.is_struck(row, column):
        return False
    return (row, column) in table.sheet.faults or (cell is not None and text_of(cell) != "")


def _value(table: StudyTable, row: int, column: int, stated: Unit | None, cells: _Cells) -> float | None:
    """Return a reading [m]; None where it is a problem."""
    cell, place = table.sheet.cell(row, column), _place(table, row, column)
    fault = table.sheet.faults.get((row, column))
    expected = "a number such as 12.345 or 12,345; an empty cell where nothing was read is a gap in the study"
    if fault is not None:
        problem = "a formula without a usable result"
        cells.problems.append(GaugeStudyError(problem, place=place, value=fault, expected=expected))
        return None
    no_number = isinstance(cell, bool | dt.date | dt.time | dt.timedelta)
    number = None if no_number else decimal_number(cell) if isinstance(cell, str) else float(cell)
    if number is None or not np.isfinite(number):
        cells.problems.append(GaugeStudyError("not a number", place=place, value=str(cell), expected=expected))
        return None
    return float((stated or table.units.get(column) or unit("mm", "length")).to_si(number))


def _place(table: StudyTable, row: int, column: int) -> Place:
    return table.sheet.place(row, column, text_of(table.sheet.filled(table.row, column)))


def _gaps(cells: _Cells, table: StudyTable) -> Iterator[GaugeStudyError]:
    """Yield what keeps the study from being crossed and balanced."""
    parts = list(dict.fromkeys(part for part, _ in cells.by_pair))
    operators = list(dict.fromkeys(operator for _, operator in cells.by_pair))
    file = Place(table.sheet.file, table.sheet.name)
    if not cells.by_pair:
        yield GaugeStudyError("no reading is filled in", place=file, expected="readings below the headings")
        return
    for names, what in ((parts, "parts"), (operators, "operators")):
        if len(names) < FEWEST:
            problem = f"{len(names)} of the {what} that a study needs"
            yield GaugeStudyError(problem, place=file, value=", ".join(names) or None, expected=f"at least {FEWEST}")
    for pair, given in cells.by_pair.items():
        seen: dict[str, Place] = {}
        for trial, _, place in given:
            if trial is not None and trial in seen:
                part, operator = pair
                problem = f"part {part}, operator {operator}, trial {trial} stands in {seen[trial]} already"
                yield GaugeStudyError(problem, place=place, expected="each trial once")
            elif trial is not None:
                seen[trial] = place
    counts = [len(given) for given in cells.by_pair.values()]
    most = max(counts)
    if most < FEWEST:
        yield GaugeStudyError(
            "every operator read every part once", place=file, expected=f"at least {FEWEST} readings of each"
        )
        return
    for part in parts:
        for operator in operators:
            given = cells.by_pair.get((part, operator), [])
            if len(given) != most:
                times = "not at all" if not given else f"{len(given)} time{'s' * (len(given) > 1)}"
                problem = f"operator {operator} read part {part} {times}"
                place = given[-1][2] if given else file
                expected = f"{most} readings, as of the others: every operator reads every part equally often"
                yield GaugeStudyError(problem, place=place, expected=expected)


def _messages(table: StudyTable, stated: Unit | None, values: np.ndarray) -> Iterator[Message]:
    place = Place(table.sheet.file, table.sheet.name)
    if table.sheet.note:
        yield Message("info", "read_as", table.sheet.note, place)
    if stated is None and not table.units:
        yield Message("info", "unit_assumed", "No heading states a unit: the readings are taken as mm.", place)
    if stated is None and len({unit.name for unit in table.units.values()}) > 1:
        names = ", ".join(dict.fromkeys(unit.name for unit in table.units.values()))
        yield Message("warning", "several_units", f"The headings state several units: {names}.", place)
    middle = median(values.ravel().tolist())
    if not _USUAL_M[0] <= middle <= _USUAL_M[1]:
        text = (
            f"The median reading is {middle * 1e3:.6g} mm, which is no usual diameter of a valve body: is the unit of "
            "the readings right?"
        )
        yield Message("warning", "unusual_readings", text, place)
    yield from _apart(table, values)


def _apart(table: StudyTable, values: np.ndarray) -> Iterator[Message]:
    """Yield a doubt about a part whose readings are ten times as far apart as those of the others."""
    ranges = np.ptp(values, axis=2)
    usual = float(np.median(ranges))
    far = ranges > 10.0 * usual
    if usual > 0.0 and 0 < far.sum() <= max(1, _SHOWN):
        widest = float(ranges.max())
        text = (
            f"{int(far.sum())} of {ranges.size} sets of repeats differ by up to {widest * 1e6:.4g} µm, the others by "
            f"some {usual * 1e6:.3g} µm: a slip of the pen counts in every number here."
        )
        yield Message("warning", "repeats_apart", text, Place(table.sheet.file, table.sheet.name))
