"""The two sheets about circuits that are no plain tables: what regulators are set to, and the apply chart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from atleak.catalogue.workbook.cells import (
    NEUTRAL,
    REVERSE,
    CellForm,
    SheetCellKind,
    Units,
    as_text,
    gear_shown,
    gears_written,
)
from atleak.catalogue.workbook.shapes import (
    Description,
    SheetColumn,
    Values,
    WorkbookRow,
    WorkbookSheet,
    by_id,
    owner_of,
    point_of,
)
from atleak.common.errors import KeySteps, one_of
from atleak.common.file_faults import NotAccepted
from atleak.common.sentences import Sentence

LINE_SHEET = "p_g"  # stands for the line where a circuit is named
ALWAYS, BY_POINT, BY_GEAR, BY_CURRENT, BY_DUTY, FOLLOWING = SET_BY = (
    "always",
    "operating point",
    "gear",
    "solenoid current",
    "solenoid duty",
    "another circuit",
)
UNREADABLE = "?"  # in place of a value that could not be read
_WHICH, _LEVEL, _PRESSURE, _RATIO = 2, 3, 4, 5  # columns of `SetPressures`
_ASKED: Mapping[str, tuple[int, ...]] = {  # the most rows that a way takes, 0 for any, and the columns that it asks for
    ALWAYS: (1, _PRESSURE),
    BY_POINT: (0, _WHICH, _PRESSURE),
    BY_GEAR: (0, _WHICH, _PRESSURE),
    BY_CURRENT: (0, _LEVEL, _PRESSURE),
    BY_DUTY: (0, _LEVEL, _PRESSURE),
    FOLLOWING: (1, _WHICH, _RATIO),
}
_LISTED = {BY_CURRENT: "current_ma", BY_DUTY: "duty_percent"}
_EMPTY_CHART = (REVERSE, NEUTRAL, 1, 2, 3, 4, 5, 6)
_MARKED, _UNMARKED = {"x", "yes", "on", "1", "●", "•", "✓", "✔", "+", "applied"}, {"no", "off", "0", "-", "–", "—"}


@dataclass(frozen=True)
class SetPressures(WorkbookSheet):
    """What regulators are set to: a row for each pressure that is stated.

    Columns are circuit, what it is set by, which point, gear or circuit, at which current or duty, pressure, ratio and
    offset.
    """

    def rows(self, data: Mapping[str, Any]) -> Iterator[Values]:
        tables = [(LINE_SHEET, data.get("line", {})), *((table["id"], table) for table in data.get("circuits", ()))]
        for name, table in tables:
            for values in _set_rows(table.get("set_kpa")):
                pairs = zip(self.columns, (name, *values), strict=True)
                yield {column.heading: value for column, value in pairs if value is not None}

    def fill(self, rows: Sequence[WorkbookRow], into: Description) -> None:
        circuits = by_id(into, "circuits")
        own: dict[str, list[WorkbookRow]] = {}
        for row in rows:
            if (name := owner_of(row, self._headings[0], {LINE_SHEET: None, **circuits}, into)) is not None:
                own.setdefault(name, []).append(row)
        for name, stated in own.items():
            at: KeySteps = ("line",) if name == LINE_SHEET else ("circuits", circuits[name][0])
            into.mark((*at, "set_kpa"), stated[0].at(self._headings[4]))
            table = into.table(at) if name == LINE_SHEET else circuits[name][1]
            value = self._stated(stated, (*at, "set_kpa"), into)
            if value is not None:
                table["set_kpa"] = value
            else:  # it has a fault already, and the circuit is none without supply
                into.left_out.add((*at, "set_kpa"))
                table["set_kpa"] = UNREADABLE

    @property
    def _headings(self) -> tuple[str, ...]:
        return tuple(column.heading for column in self.columns)

    def _stated(self, rows: Sequence[WorkbookRow], at: KeySteps, into: Description) -> Any:
        """Return ``set_kpa`` as the file states it; None, and a fault, where the rows do not go together."""
        _, by, which, level, pressure, ratio, offset = self._headings
        way = rows[0].values.get(by)
        if way is None:
            if by not in rows[0].cells:
                into.fault(rows[0], by, Sentence("what is it set by?"), one_of(SET_BY))
            return None
        if any(by in row.cells and by not in row.values for row in rows):
            return None
        if not self._go_together(rows, way, into):
            return None
        first = rows[0].values
        if way == ALWAYS:
            return first[pressure]
        if way == FOLLOWING:
            names = {"from": which, "ratio": ratio, "offset_kpa": offset}
            for key, heading in names.items():
                into.mark((*at, key), rows[0].at(heading))
            return {key: first[heading] for key, heading in names.items() if heading in first}
        if way in _LISTED:
            names = {_LISTED[way]: level, "kpa": pressure}
            for number, row in enumerate(rows):
                for key, heading in names.items():
                    into.mark((*at, key, number), row.at(heading))
            return {key: [row.values[heading] for row in rows] for key, heading in names.items()}
        return self._of_names(rows, way, at, into)

    def _go_together(self, rows: Sequence[WorkbookRow], way: str, into: Description) -> bool:
        """Tell whether the rows are set by the same and have what that asks for; a fault of each that is not."""
        by, (most, *wanted) = self._headings[1], _ASKED[way]
        further = [row for row in rows[1:] if most == 1 or row.values.get(by) != way]
        expected = Sentence("one row") if most == 1 else Sentence("{way} in every row of this circuit", way=way)
        for row in further:
            into.fault(row, by, Sentence("does not go with the rows before it"), expected)
        headings = [self._headings[column] for column in wanted]
        lacking = [(row, heading) for row in rows for heading in headings if heading not in row.values]
        for row, heading in lacking:
            if heading not in row.cells:
                problem = Sentence("missing where it is set by {way}", way=way)
                into.fault(row, heading, problem, Sentence("a value under {heading}", heading=heading))
        return not further and not lacking

    def _of_names(self, rows: Sequence[WorkbookRow], way: str, at: KeySteps, into: Description) -> Any:
        """Return the pressures of operating points or gears; None where a fault is found."""
        _, _, which, _, pressure, _, _ = self._headings
        named: Values = {}
        known, steps = len(into.faults), (*at, "gear") if way == BY_GEAR else at
        for row in rows:
            for name in [point_of(row, which, into)] if way == BY_POINT else self._gears(row, which, into):
                if name is None:
                    continue
                if name in named:
                    into.fault(row, which, Sentence("given twice"), Sentence("each once"))
                named[name] = row.values[pressure]
                into.mark((*steps, name), row.at(which))
        if len(into.faults) > known:
            return None
        return {"gear": named} if way == BY_GEAR else named

    def _gears(self, row: WorkbookRow, heading: str, into: Description) -> list[str]:
        try:
            return [str(gear) for gear in gears_written(row.values[heading])]
        except NotAccepted as error:
            into.fault(row, heading, Sentence("not a gear"), error.wanted)
            return []


def _set_rows(stated: Any) -> Iterator[tuple[Any, ...]]:
    """Yield what each row says behind the circuit's name."""
    if stated is None:
        return
    if not isinstance(stated, Mapping):
        yield ALWAYS, None, None, stated, None, None
    elif "from" in stated:
        yield FOLLOWING, stated["from"], None, None, stated["ratio"], stated.get("offset_kpa")
    elif way := next((way for way, key in _LISTED.items() if key in stated), None):
        for level, pressure in zip(stated[_LISTED[way]], stated["kpa"], strict=True):
            yield way, None, level, pressure, None, None
    elif isinstance(stated.get("gear"), Mapping):
        for gear, pressure in stated["gear"].items():
            yield BY_GEAR, str(gear_shown(int(gear))), None, pressure, None, None
    else:
        for point, pressure in stated.items():
            yield BY_POINT, point, None, pressure, None, None


@dataclass(frozen=True)
class Mark(CellForm):
    """A mark in the apply chart."""

    def value(self, cell: SheetCellKind, units: Units) -> bool:
        text = as_text(cell).casefold()
        if text in _MARKED | _UNMARKED:
            return text in _MARKED
        raise NotAccepted(Sentence("x where the circuit is applied, else nothing"))

    def cell(self, value: Any, units: Units) -> str:
        return "x" if value else ""


@dataclass(frozen=True)
class ApplyChart(WorkbookSheet):
    """In which gears circuits are applied: a row for each circuit, a column for each gear."""

    def columns_for(self, data: Mapping[str, Any]) -> tuple[SheetColumn, ...]:
        return (*self.columns, *(_gear_column(str(gear_shown(gear))) for gear in data.get("gears", _EMPTY_CHART)))

    def further_column(self, heading: Any) -> SheetColumn | None:
        try:
            gears = gears_written(as_text(heading))
        except NotAccepted:
            return None
        return _gear_column(as_text(heading)) if len(gears) == 1 else None

    def rows(self, data: Mapping[str, Any]) -> Iterator[Values]:
        for table in data.get("circuits", ()):
            if "gears" in table:
                marks = {str(gear_shown(gear)): True for gear in table["gears"]}
                yield {self.columns[0].heading: table["id"], **marks}

    def fill(self, rows: Sequence[WorkbookRow], into: Description) -> None:
        heading = self.columns[0].heading
        circuits = by_id(into, "circuits")
        for row in rows:
            name = owner_of(row, heading, circuits, into)
            if name is None:
                continue
            place, table = circuits[name]
            if "gears" in table:
                into.fault(row, heading, Sentence("given twice"), Sentence("one row for each circuit"))
                continue
            marked = [gear for gear, is_applied in row.values.items() if gear != heading and is_applied]
            gears: list[int] = []
            for gear in marked:
                number = gears_written(gear)[0]
                if number not in gears:  # P and N are one
                    into.mark(("circuits", place, "gears", len(gears)), row.at(gear))
                    gears.append(number)
            into.mark(("circuits", place, "gears"), row.at(marked[0] if marked else heading))
            if gears:
                table["gears"] = gears
            elif set(row.cells) == {heading}:
                into.notes.append(
                    Sentence(
                        "sheet {sheet!r}, row {row}: {circuit} has no mark and is taken as applied in every gear",
                        sheet=self.name,
                        row=row.spot.row,
                        circuit=name,
                    )
                )


def _gear_column(heading: str) -> SheetColumn:
    return SheetColumn(heading, (), Mark(), width=6)
