"""The cells of a gauge study's table → readings by part, operator and trial; what cannot be read is a problem."""

from __future__ import annotations

import datetime as dt
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import islice, product
from statistics import median

import numpy as np

from atleak.errors import Message, Place
from atleak.gauge_study.readings import FEWEST, GaugeStudyError, StudyReadings
from atleak.intake.gauge_study.table import StudyTable
from atleak.intake.sheets.extent import FAULTS
from atleak.intake.sheets.sheet import text_of
from atleak.intake.units import Unit, unit
from atleak.sentence import Sentence
from atleak.unit_systems import Quantity
from atleak.workshop_units import MM, UM
from atleak.written_numbers import decimal_number

_USUAL_M = (0.5e-3, 100e-3)  # [m] diameters of valve bodies: outside of it another unit may have been meant
_ENDS = ("average", "mean", "mittelwert", "średnia", "srednia", "range", "spannweite", "rozstęp")
_SHOWN = 6
_UNNAMED = {  # a row that names none, and what is expected there
    "part": (Sentence("nothing says of which part this row's readings are"), Sentence("a part")),
    "operator": (Sentence("nothing says of which operator this row's readings are"), Sentence("an operator")),
}


@dataclass
class _Cells:
    """What the cells give so far."""

    by_pair: dict[tuple[str, str], list[tuple[str | None, float, Place]]] = field(default_factory=dict)
    problems: list[GaugeStudyError] = field(default_factory=list)
    above: dict[int, str] = field(default_factory=dict)  # by column: the last that was filled in there


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
        if len(cells.problems) > FAULTS:
            break
        _read_row(table, row, stated, cells)
    file = table.sheet.file
    if not cells.problems:
        cells.problems += islice(_gaps(cells, table), FAULTS)
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
    for column in table.keys.values():
        cells.above[column] = text_of(sheet.filled(row, column)) or cells.above.get(column, "")
    filled = [column for column in table.values if _is_filled(table, row, column)]
    named: dict[str, str] = {}
    for key, column in table.keys.items() if filled else ():
        name = text_of(sheet.filled(row, column))
        if key != "trial":
            name = name or cells.above[column]  # a form names an operator once, on the first of the rows that are his
        if name.casefold() in _ENDS:
            return  # the averages at the foot of a form are no readings
        if not name and key != "trial":
            problem, expected = _UNNAMED[key]
            cells.problems.append(GaugeStudyError(problem, place=_place(table, row, column), expected=expected))
            return
        named[key] = name
    for column in filled:
        value, place = _value(table, row, column, stated, cells), _place(table, row, column)
        if value is not None:
            said: Mapping[str, str] = {**named, **table.values[column]}
            pair = said["part"], said["operator"]
            cells.by_pair.setdefault(pair, []).append((said.get("trial") or None, value, place))


def _is_filled(table: StudyTable, row: int, column: int) -> bool:
    filled = (row, column) in table.sheet.faults or text_of(table.sheet.cell(row, column)) != ""
    return filled and not table.sheet.is_struck(row, column)


def _value(table: StudyTable, row: int, column: int, stated: Unit | None, cells: _Cells) -> float | None:
    """Return a reading [m]; None where it is a problem."""
    cell, fault = table.sheet.cell(row, column), table.sheet.faults.get((row, column))
    problem, number = Sentence("not a number"), None
    if fault is not None:
        problem = Sentence("a formula without a usable result")
    elif not isinstance(cell, bool | dt.date | dt.time | dt.timedelta):
        number = decimal_number(cell) if isinstance(cell, str) else float(cell)
    if number is not None and np.isfinite(number):
        return float((stated or table.units.get(column) or unit("mm", "length")).to_si(number))
    place, found = _place(table, row, column), str(cell) if fault is None else fault
    expected = Sentence("a number such as 12.345 or 12,345; an empty cell where nothing was read is a gap in the study")
    cells.problems.append(GaugeStudyError(problem, place=place, value=found, expected=expected))
    return None


def _place(table: StudyTable, row: int, column: int) -> Place:
    return table.sheet.place(row, column, text_of(table.sheet.filled(table.row, column)))


def _gaps(cells: _Cells, table: StudyTable) -> Iterator[GaugeStudyError]:
    """Yield what keeps the study from being crossed and balanced."""
    parts = list(dict.fromkeys(part for part, _ in cells.by_pair))
    operators = list(dict.fromkeys(operator for _, operator in cells.by_pair))
    file = Place(table.sheet.file, table.sheet.name)
    if not cells.by_pair:
        expected = Sentence("readings below the headings")
        yield GaugeStudyError(Sentence("no reading is filled in"), place=file, expected=expected)
        return
    for names, problem in (
        (parts, Sentence("{count} of the parts that a study needs", count=len(parts))),
        (operators, Sentence("{count} of the operators that a study needs", count=len(operators))),
    ):
        if len(names) < FEWEST:
            expected = Sentence("at least {count}", count=FEWEST)
            yield GaugeStudyError(problem, place=file, value=", ".join(names) or None, expected=expected)
    for pair, given in cells.by_pair.items():
        seen: dict[str, Place] = {}
        for trial, _, place in given:
            if trial is not None and trial in seen:
                problem = Sentence("part {part}, operator {operator}, trial {trial} stands in {place} already")
                problem = problem.of(part=pair[0], operator=pair[1], trial=trial, place=seen[trial].sentence)
                yield GaugeStudyError(problem, place=place, expected=Sentence("each trial once"))
            elif trial is not None:
                seen[trial] = place
    most = max(map(len, cells.by_pair.values()))
    if most < FEWEST:
        expected = Sentence("at least {count} readings of each", count=FEWEST)
        yield GaugeStudyError(Sentence("every operator read every part once"), place=file, expected=expected)
        return
    expected = Sentence("{count} readings, as of the others: every operator reads every part equally often", count=most)
    for part, operator in product(parts, operators):
        given = cells.by_pair.get((part, operator), [])
        if len(given) != most:
            problem = Sentence("operator {operator} read part {part} not at all")
            if given:
                problem = Sentence("operator {operator} read part {part} {count} times")
                if len(given) == 1:
                    problem = Sentence("operator {operator} read part {part} 1 time")
            problem = problem.of(operator=operator, part=part, count=len(given))
            yield GaugeStudyError(problem, place=given[-1][2] if given else file, expected=expected)


def _messages(table: StudyTable, stated: Unit | None, values: np.ndarray) -> Iterator[Message]:
    place = Place(table.sheet.file, table.sheet.name)
    if table.sheet.note:
        yield Message("info", "read_as", table.sheet.note, place)
    if stated is None and not table.units:
        said = Sentence("No heading states a unit: the readings are taken as mm.")
        yield Message("info", "unit_assumed", said, place)
    if stated is None and len({unit.name for unit in table.units.values()}) > 1:
        names = tuple(dict.fromkeys(unit.name for unit in table.units.values()))
        said = Sentence("The headings state several units: {units}.", units=names)
        yield Message("warning", "several_units", said, place)
    middle = median(values.ravel().tolist())
    if not _USUAL_M[0] <= middle <= _USUAL_M[1]:
        said = Sentence(
            "The median reading is {median:.6g} {median.unit}, which is no usual diameter of a valve body: is the unit "
            "of the readings right?",
            median=Quantity(middle * MM, "length"),
        )
        yield Message("warning", "unusual_readings", said, place)
    yield from _apart(table, values)


def _apart(table: StudyTable, values: np.ndarray) -> Iterator[Message]:
    """Yield a doubt about a part whose readings are ten times as far apart as those of the others."""
    ranges = np.ptp(values, axis=2)
    usual = float(np.median(ranges))
    far = ranges > 10.0 * usual
    if usual > 0.0 and 0 < far.sum() <= max(1, _SHOWN):
        widest = float(ranges.max())
        said = Sentence(
            "{count} of {total} sets of repeats differ by up to {widest:.4g} {widest.unit}, the others by some "
            "{usual:.3g} {usual.unit}: a slip of the pen counts in every number here.",
            count=int(far.sum()),
            total=ranges.size,
            widest=Quantity(widest * UM, "clearance"),
            usual=Quantity(usual * UM, "clearance"),
        )
        yield Message("warning", "repeats_apart", said, Place(table.sheet.file, table.sheet.name))
