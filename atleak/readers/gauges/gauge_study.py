"""A workbook of repeated readings → the readings of a gauge study, by part, operator and trial.

Either a reading on each row, with its part, its operator and perhaps its trial, or readings side by side: a column for
each trial, for each part (as AIAG's form has them) or for each operator. Everything wrong is listed at once, with
file, sheet, row and column.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import islice, product
from pathlib import Path
from statistics import median

import numpy as np

from atleak.catalogue.written_numbers import decimal_number
from atleak.common.damage import own_errors_only
from atleak.common.errors import InputError, Message, Place
from atleak.common.sentences import Sentence, counted
from atleak.common.units import MM, UM, Quantity, Unit, find_unit, unit
from atleak.measurements.gauge_study import FEWEST, GaugeStudyError, StudyReadings
from atleak.measurements.own_forms import STUDY
from atleak.readers.cells.extent import FAULTS
from atleak.readers.cells.sheet import BRACKETS, Sheet, text_of
from atleak.readers.gauges.value_table import SEARCHED, Faults, ValueFile, ValueTable, label_of, not_typed_as_number
from atleak.readers.own_forms import form_tables

_KEYS = ("part", "operator", "trial")
_PERSON_AND_TRIAL = re.compile(r"(?P<operator>.*?)[\s_./·#-]*(?P<trial>\d+)")


class StudyTable(ValueTable):
    """A table of readings: its columns state part, operator and trial, or the headings of its columns of values do."""

    def unit(self, column: int) -> Unit | None:
        """Return the unit in the heading of a column; None where there is none."""
        return find_unit(self.unit_over(column), "length")


def _likeness(sheet: Sheet) -> float:
    """Count the headings of a sheet that are understood: of a text file, whether it is split the right way."""
    return sum(len(table.columns) + min(len(table.values), 20) for table in _find_tables(sheet))


def _find_tables(sheet: Sheet) -> list[StudyTable]:
    """Return the table of a sheet, if a row holds its headings."""
    if (own := form_tables(sheet, STUDY)) is not None:
        keys = [{key: form.columns[key] for key in _KEYS} for form in own[:1]]
        return [StudyTable(sheet, key, {own[0].columns["reading"]: {}}, own[0].row) for key in keys]
    tables = (_at(sheet, row) for row in range(min(len(sheet.rows), SEARCHED)))
    return list(islice((table for table in tables if table is not None), 1))


def _at(sheet: Sheet, row: int) -> StudyTable | None:
    texts = {column: text_of(sheet.filled(row, column)) for column in range(sheet.width)}
    kinds = {column: label_of(text, "study_columns") for column, text in texts.items() if text}
    keys = {kind: column for column, kind in reversed(kinds.items()) if kind in _KEYS}
    readings = [column for column, kind in kinds.items() if kind == "reading"]
    others = [at for at, kind in kinds.items() if at not in keys.values() and kind not in ("reading", "aside")]
    if {"part", "operator"} <= keys.keys() and len(readings) == 1 and not others:
        return StudyTable(sheet, keys, {readings[0]: {}}, row)
    if not {"part", "operator"} & keys.keys():
        return None
    values = _side_by_side(sheet, row, keys, sorted((*readings, *others)))
    return None if len(values) < 2 and "trial" not in keys else StudyTable(sheet, keys, values, row)


def _side_by_side(sheet: Sheet, row: int, keys: Mapping[str, int], columns: list[int]) -> dict[int, Mapping[str, str]]:
    """Return what the headings of readings side by side say; the only key that no column states, or two of them."""
    missing = [key for key in ("part", "operator") if key not in keys]
    values: dict[int, Mapping[str, str]] = {}
    for number, column in enumerate(columns, start=1):
        name = text_of(BRACKETS.sub(" ", text_of(sheet.filled(row, column))))
        if not missing:
            values[column] = {"trial": str(number)}
        elif missing == ["part"] or "trial" in keys:
            values[column] = {missing[0]: name}
        else:
            both = _PERSON_AND_TRIAL.fullmatch(name)
            if both is not None and both["operator"]:
                values[column] = both.groupdict()
    return values


_USUAL_M = (0.5e-3, 100e-3)  # [m] diameters of valve bodies: outside of it another unit may have been meant
_ENDS = ("average", "mean", "mittelwert", "średnia", "srednia", "range", "spannweite", "rozstęp")
_FEW = 6  # sets of repeats that may be far apart and still be slips
_UNNAMED = {  # a row that names none, and what is expected there
    "part": (Sentence("nothing says of which part this row's readings are"), Sentence("a part")),
    "operator": (Sentence("nothing says of which operator this row's readings are"), Sentence("an operator")),
}


@dataclass
class _Cells(Faults):
    """What the cells give so far."""

    error: type[InputError] = GaugeStudyError
    by_pair: dict[tuple[str, str], list[tuple[str | None, float, Place]]] = field(default_factory=dict)
    above: dict[int, str] = field(default_factory=dict)  # by column: the last that was filled in there


def _read_row(table: StudyTable, row: int, stated: Unit | None, cells: _Cells) -> None:
    sheet = table.sheet
    for column in table.columns.values():
        cells.above[column] = text_of(sheet.filled(row, column)) or cells.above.get(column, "")
    filled = [
        column
        for column in table.values
        if ((row, column) in sheet.faults or text_of(sheet.cell(row, column))) and not sheet.is_struck(row, column)
    ]
    named: dict[str, str] = {}
    for key, column in table.columns.items() if filled else ():
        name = text_of(sheet.filled(row, column))
        if key != "trial":
            name = name or cells.above[column]  # a form names an operator once, on the first of the rows that are his
        if name.casefold() in _ENDS:
            return  # the averages at the foot of a form are no readings
        if not name and key != "trial":
            problem, expected = _UNNAMED[key]
            cells.refuse(problem, table.place(row, column), expected=expected)
            return
        named[key] = name
    for column in filled:
        value = _value(table, row, column, stated, cells)
        if value is not None:
            names: Mapping[str, str] = {**named, **table.values[column]}
            given = cells.by_pair.setdefault((names["part"], names["operator"]), [])
            given.append((names.get("trial") or None, value, table.place(row, column)))


def _value(table: StudyTable, row: int, column: int, stated: Unit | None, cells: _Cells) -> float | None:
    """Return a reading [m]; None where it is a problem."""
    cell, fault = table.sheet.cell(row, column), table.sheet.faults.get((row, column))
    problem, number = Sentence("not a number"), None
    if fault is not None:
        problem = Sentence("a formula without a usable result")
    elif not not_typed_as_number(cell):
        number = decimal_number(cell) if isinstance(cell, str) else float(cell)
    if number is not None and np.isfinite(number):
        return float((stated or table.unit(column) or unit("mm", "length")).to_si(number))
    shown = str(cell) if fault is None else fault
    expected = Sentence("a number such as 12.345 or 12,345; an empty cell where nothing was read is a gap in the study")
    cells.refuse(problem, table.place(row, column), shown, expected=expected)
    return None


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
    expected = counted(
        most,
        "{count} reading, as of the others: every operator reads every part equally often",
        "{count} readings, as of the others: every operator reads every part equally often",
    )
    for part, operator in product(parts, operators):
        given = cells.by_pair.get((part, operator), [])
        if len(given) != most:
            who = {"operator": operator, "part": part}
            problem = Sentence("operator {operator} read part {part} not at all", **who)
            if given:
                problem = counted(
                    len(given),
                    "operator {operator} read part {part} {count} time",
                    "operator {operator} read part {part} {count} times",
                    **who,
                )
            yield GaugeStudyError(problem, place=given[-1][2] if given else file, expected=expected)


def _messages(table: StudyTable, stated: Unit | None, values: np.ndarray) -> Iterator[Message]:
    place = Place(table.sheet.file, table.sheet.name)
    units = dict.fromkeys(unit.name for unit in map(table.unit, table.values) if unit)
    if stated is None and not units:
        text = Sentence("No heading states a unit: the readings are taken as mm.")
        yield Message("info", "unit_assumed", text, place)
    if stated is None and len(units) > 1:
        text = Sentence("The headings state several units: {units}.", units=tuple(units))
        yield Message("warning", "several_units", text, place)
    middle = median(values.ravel().tolist())
    if not _USUAL_M[0] <= middle <= _USUAL_M[1]:
        text = Sentence(
            "The median reading is {median:.6g} {median.unit}, which is no usual diameter of a valve body: is the unit "
            "of the readings right?"
        )
        yield Message("warning", "unusual_readings", text.of(median=Quantity(middle * MM, "length")), place)
    yield from _apart(table, values)


def _apart(table: StudyTable, values: np.ndarray) -> Iterator[Message]:
    """Yield a doubt about a part whose readings are ten times as far apart as those of the others."""
    ranges = np.ptp(values, axis=2)
    usual = float(np.median(ranges))
    far = ranges > 10.0 * usual
    if usual > 0.0 and 0 < far.sum() <= _FEW:
        widest = float(ranges.max())
        text = Sentence(
            "{count} of {total} sets of repeats differ by up to {widest:.4g} {widest.unit}, the others by some "
            "{usual:.3g} {usual.unit}: a slip of the pen counts in every number here.",
            count=int(far.sum()),
            total=ranges.size,
            widest=Quantity(widest * UM, "clearance"),
            usual=Quantity(usual * UM, "clearance"),
        )
        yield Message("warning", "repeats_apart", text, Place(table.sheet.file, table.sheet.name))


_WANTED = Sentence("a workbook (.xlsx) or text (.csv) of repeated readings")
_HEADINGS = Sentence(
    "a row of headings with part, operator, trial and reading, or part and operator beside a column for each trial; "
    "page Library gives a workbook to fill in"
)


@own_errors_only(GaugeStudyError, "name", "source")
def read_study(
    source: str | Path | bytes, *, name: str | None = None, sheet: str | None = None, length_unit: str | None = None
) -> StudyReadings:
    """Return the readings of a gauge study.

    Parameters
    ----------
    source, name
        as `atleak.read_pressure_table` takes them.
    sheet
        the sheet to read; the one sheet with readings by default.
    length_unit
        of all readings; by default that of their heading, else mm.

    Raises
    ------
    GaugeStudyError
        with all problems found: a cell that is no number, a part that an operator did not read, or not as often as
        the others; fewer than two parts, operators or readings of each; or no such table.
    InputError
        a unit that is none of length.
    """
    stated = None if length_unit is None else unit(length_unit, "length")
    missing = GaugeStudyError(Sentence("holds no table of repeated readings"), expected=_HEADINGS)
    held = ValueFile.open(source, name, _find_tables, _likeness, missing, _WANTED, sheet)
    if len(held.tables) > 1:
        sheets_named = tuple(repr(table.sheet.name) for table in held.tables)
        problem = Sentence("several sheets hold readings: {sheets}", sheets=sheets_named)
        raise GaugeStudyError(problem, place=Place(held.file), expected=Sentence("one of them"))
    (table,), cells = held.tables, _Cells()
    for row in table.rows:
        if len(cells.problems) <= FAULTS:
            _read_row(table, row, stated, cells)
    cells.problems += islice(_gaps(cells, table), 0 if cells.problems else FAULTS)
    cells.settle()
    parts = tuple(dict.fromkeys(part for part, _ in cells.by_pair))
    operators = tuple(dict.fromkeys(operator for _, operator in cells.by_pair))
    values = np.array(
        [[[value for _, value, _ in cells.by_pair[part, operator]] for operator in operators] for part in parts]
    )
    messages = (*held.notes, *_messages(table, stated, values))
    return StudyReadings(parts, operators, values, held.file, held.sha256, messages)
