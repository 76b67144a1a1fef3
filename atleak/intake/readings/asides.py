"""Rows that hold numbers and no reading: means and sums, what their author crossed out, hid or called void."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean, median

from atleak.errors import Message, ReadingsError, nearest_name
from atleak.intake.readings.columns import Columns
from atleak.intake.readings.controller_names import ControllerNames
from atleak.intake.readings.sheet_tables import Table
from atleak.intake.readings.values import DiameterCell
from atleak.intake.readings.words import (
    CHARACTERISTIC,
    COUNTS,
    COUNTS_NOT,
    Summary,
    Vocabulary,
    direction_of,
    is_blank,
    is_rejected,
    letters,
    number,
    number_of,
    part_said,
    plain,
    repeat_of,
    says_no,
    says_specification,
    says_yes,
    summary_of,
    text_of,
    vocabulary,
)
from atleak.intake.sheets.sheet import Cell, rows_named
from atleak.intake.workbook_marks import Hiding
from atleak.sentence import Sentence, some

LEFT_ASIDE = (
    "summaries_left_aside",
    "rejected_left_aside",
    "struck_left_aside",
    "hidden_rows",
    "specifications_left_aside",
    "characteristics_left_aside",
    "notes_left_aside",
)  # codes of messages
_HALF_A_MICROMETRE = 0.5e-3  # in the numbers of a sheet in mm: how far a mean may be rounded
_SHOWN = 4
_OF_GAUGE = vocabulary("gauge", "calibration")
_DIAMETER = vocabulary("diameter")
_MARKS = {"x", "✓", "✔", "1"}
_NAMES: dict[Summary, tuple[Sentence, Sentence]] = {  # of one, and of several
    "mean": (Sentence("mean"), Sentence("means")),
    "sum": (Sentence("sum"), Sentence("sums")),
    "largest": (Sentence("largest value"), Sentence("largest values")),
    "smallest": (Sentence("smallest value"), Sentence("smallest values")),
    "spread": (Sentence("spread"), Sentence("spreads")),
    "count": (Sentence("count"), Sentence("counts")),
}
_COMPUTED: dict[Summary, Callable[[Sequence[float]], float]] = {
    "mean": fmean,
    "sum": sum,
    "largest": max,
    "smallest": min,
}


@dataclass(frozen=True)
class SummaryRow:
    """A row that gives the mean, sum, largest, smallest, spread or count of other rows."""

    row: int
    kind: Summary

    @property
    def name(self) -> Sentence:
        """Return what one such number is called."""
        return _NAMES[self.kind][0]


class Asides:
    """Decides which rows under the headings are left aside, and why."""

    def __init__(self, table: Table, columns: Columns, names: ControllerNames) -> None:
        self.sheet, self.header, self.columns, self.names = table.sheet, table.header, columns, names
        self.summaries: list[SummaryRow] = []
        self.struck: list[int] = []
        self._rejected: dict[Sentence, list[int]] = defaultdict(list)
        self._specified: dict[str, list[int]] = defaultdict(list)
        self._characteristics: dict[str, list[int]] = defaultdict(list)
        self._notes: dict[str, list[int]] = defaultdict(list)
        self._hidden: dict[Hiding, list[int]] = defaultdict(list)
        values = {column.index for group in columns.groups for column in group.values()}
        keys = columns.keys
        self._keys = [column.index for column in keys]
        self._others = [index for index in range(self.sheet.width) if index not in values and index not in self._keys]
        self._counts, self._counts_not = (
            [index for index in self._others if _asks(self.header.text(index), words)] for words in (COUNTS, COUNTS_NOT)
        )

        component = columns.component
        self._beside_component = [
            index for index in self._keys if component is not None and index != component.index and self._cells(index)
        ]
        self._machine = [index for index in self._others if self._says_characteristics(index)]

        # marks in some rows and nothing in others, and nowhere a "no": what is not marked does not count
        self._marked = [
            index
            for index in self._counts
            if all(says_yes(cell) and text_of(cell).lower() in _MARKS for cell in self._cells(index))
            and self._cells(index)
        ]

    def _cells(self, index: int) -> list[Cell]:
        rows = range(self.header.last + 1, len(self.sheet.rows))
        return [cell for row in rows if not is_blank(cell := self.sheet.filled(row, index))]

    def _says_characteristics(self, index: int) -> bool:
        words = letters(self.header.text(index))
        named = any(word in CHARACTERISTIC for word in words) and len(words) < 4
        return named and any(_says_diameter(text_of(cell)) for cell in self._cells(index))

    def takes(self, row: int) -> bool:
        """Return whether a row that holds numbers is no reading, and note why."""
        hidden = self.sheet.marks.hidden_rows.get(row)
        if hidden is not None:
            self._hidden[hidden].append(row)
            if hidden == "by hand":
                return True
        rejected = self._rejection(row)
        if rejected is not None:
            self._rejected[rejected].append(row)
            return True
        if any(self._is_struck(row, index) for index in self._keys):
            self.struck.append(row)
            return True
        kind = self._summary(row)
        if kind is not None:
            self.summaries.append(SummaryRow(row, kind))
            return True
        other = self._other_characteristic(row)
        if other is not None:
            self._characteristics[other].append(row)
            return True
        note = self._note(row)
        if note is not None:
            self._notes[note].append(row)
            return True
        specified = self._specification(row)
        if specified is not None:
            self._specified[specified].append(row)
        return specified is not None

    def _other_characteristic(self, row: int) -> str | None:
        """Return what a measuring machine's row is of, None where it is of a diameter or no column says."""
        cells = [text_of(cell) for index in self._machine if not is_blank(cell := self.sheet.filled(row, index))]
        return cells[0] if cells and not any(map(_says_diameter, cells)) else None

    def _note(self, row: int) -> str | None:
        """Return the label of a row that says nothing of what a diameter is of, and whose label is no component.

        A label that is nearly a component's name is a slip in a reading, and is refused as one.
        """
        component = self.columns.component
        if component is None or any(not is_blank(self.sheet.filled(row, index)) for index in self._beside_component):
            return None
        label = self.sheet.filled(row, component.index)
        if not self._beside_component and not any(word in _OF_GAUGE for word in letters(label)):
            return None
        if not isinstance(label, str) or is_blank(label) or self.names.component(label) is not None:
            return None
        near = nearest_name(plain(label), [name for name, _ in self.names.by_length])
        return text_of(label) if near is None and number_of(label) is None and letters(label) else None

    def _specification(self, row: int) -> str | None:
        """Return the word that calls the row's number a nominal or specified one, None where no word does."""
        for index, cell in enumerate(self.sheet.rows[row]):
            if isinstance(cell, str) and says_specification(cell) and self._is_label(index, cell):
                return cell
        return None

    def _is_label(self, index: int, cell: str) -> bool:
        """Return whether a cell names its row: in a key's column, or in one that holds no numbers."""
        if index in self._keys:
            return self.names.component(cell) is None
        return index in self._others and not any(
            isinstance(each, int | float) or number_of(str(each)) is not None for each in self._cells(index)
        )

    def _is_struck(self, row: int, index: int) -> bool:
        return bool(self.sheet.marks.struck) and self.sheet.is_struck(row, index)

    def _rejection(self, row: int) -> Sentence | None:
        for index in self._counts:
            cell = self.sheet.filled(row, index)
            if not is_blank(cell) and says_no(cell):
                return self._says(index, cell)
            if index in self._marked and is_blank(cell):
                return Sentence("column {heading!r} has no mark", heading=self.header.text(index))
        for index in self._counts_not:
            cell = self.sheet.filled(row, index)
            if not is_blank(cell) and says_yes(cell):
                return self._says(index, cell)
        for index in self._others:
            cell = self.sheet.cell(row, index)
            if is_rejected(cell):
                return Sentence("a remark says {said!r}", said=text_of(cell))
        return None

    def _says(self, index: int, cell: Cell) -> Sentence:
        return Sentence("column {heading!r} says {said!r}", heading=self.header.text(index), said=text_of(cell))

    def _summary(self, row: int) -> Summary | None:
        columns, cell = self.columns, self.sheet.filled
        for column in columns.keys:
            label = cell(row, column.index)
            if not isinstance(label, str) or is_blank(label):
                continue
            understood = (
                self.names.component(label) is not None
                if column in (columns.component, *columns.names)
                else part_said(label) is not None
                if column == columns.part
                else direction_of(label) is not None
                if column == columns.direction
                else column == columns.repeat and repeat_of(label) is not None
            )
            kind = None if understood else summary_of(label, key=True)
            if kind is not None:
                return kind
        return next((kind for index in self._others if (kind := summary_of(self.sheet.cell(row, index)))), None)

    # --- what is said of them -----------------------------------------------------------------------------------------

    def messages(self, entries: Sequence[DiameterCell]) -> Iterator[Message]:
        """Yield what was left aside, and which means or sums disagree with the readings above them."""
        place = self.sheet.place()
        by_kind: dict[Summary, list[int]] = defaultdict(list)
        for summary in self.summaries:
            by_kind[summary.kind].append(summary.row)
        for kind, rows in by_kind.items():
            what, named = _NAMES[kind][1], rows_named(self.sheet, rows)
            text = Sentence("{rows} of {what} left aside ({named})", rows=_count(rows), what=what, named=named)
            yield Message("info", "summaries_left_aside", text, place)
        for word, rows in self._specified.items():
            text = Sentence(
                "{rows} of {word!r} left aside, what should be ({named})",
                rows=_count(rows),
                word=word,
                named=rows_named(self.sheet, rows),
            )
            yield Message("info", "specifications_left_aside", text, place)
        if self._characteristics:
            rows = [row for each in self._characteristics.values() for row in each]
            text = Sentence(
                "{rows} of other characteristics left aside ({characteristics}): {named}",
                rows=_count(rows),
                characteristics=some(tuple(self._characteristics), _SHOWN),
                named=rows_named(self.sheet, rows),
            )
            yield Message("info", "characteristics_left_aside", text, place)
        if self._notes:
            rows = [row for each in self._notes.values() for row in each]
            text = Sentence(
                "{rows} left aside, whose label is no component and which say nothing else ({labels}): {named}",
                rows=_count(rows),
                labels=some(tuple(map(repr, self._notes)), _SHOWN),
                named=rows_named(self.sheet, rows),
            )
            yield Message("warning", "notes_left_aside", text, place)
        for reason, rows in self._rejected.items():
            text = Sentence(
                "{rows} left aside, because {reason} ({named})",
                rows=_count(rows),
                reason=reason,
                named=rows_named(self.sheet, rows),
            )
            yield Message("warning", "rejected_left_aside", text, place)
        if self.struck:
            rows = sorted(set(self.struck))
            text = Sentence(
                "{rows} with a crossed-out reading: it was left aside ({named})",
                rows=_count(rows),
                named=rows_named(self.sheet, rows),
            )
            yield Message("warning", "struck_left_aside", text, place)
        for way, rows in self._hidden.items():
            counted, named = _count(rows), rows_named(self.sheet, rows)
            yield Message("warning" if way == "by hand" else "info", "hidden_rows", _hidden(way, counted, named), place)
        for summary in self.summaries:
            yield from self._disagreement(summary, entries)

    def stands_alone(self, summary: SummaryRow, entries: Sequence[DiameterCell]) -> bool:
        """Return whether a row of means says what it is of, and the sheet holds no single readings of that."""
        labels = self._labels(summary.row)
        return (
            summary.kind in ("mean", "largest", "smallest")
            and "component" in labels
            and not any(_matches(entry, labels) for entry in entries)
        )

    def _labels(self, row: int) -> Mapping[str, object]:
        """Return what the row's labels say, as far as they are understood."""
        columns, cell = self.columns, self.sheet.filled
        labels: dict[str, object] = {}
        component = self.names.component(cell(row, columns.component.index)) if columns.component else None
        if component is not None:
            labels["component"] = component
            try:
                if columns.plane is not None and not is_blank(cell(row, columns.plane.index)):
                    labels["plane"] = self.names.plane(component, cell(row, columns.plane.index))
                elif columns.land is not None and not is_blank(cell(row, columns.land.index)):
                    labels["plane"] = self.names.land(component, cell(row, columns.land.index)).planes[0]
            except ReadingsError:
                pass
        if columns.part is not None:
            labels["part"] = part_said(text_of(cell(row, columns.part.index)))
        if columns.direction is not None:
            labels["direction"] = direction_of(cell(row, columns.direction.index))
        return {name: value for name, value in labels.items() if value is not None}

    def _disagreement(self, summary: SummaryRow, entries: Sequence[DiameterCell]) -> Iterator[Message]:
        compute = _COMPUTED.get(summary.kind)
        if compute is None:
            return
        before = max((other.row for other in self.summaries if other.row < summary.row), default=-1)
        labels = self._labels(summary.row)
        for group in self.columns.groups:
            column = group.get("diameter")
            if column is None or is_blank(self.sheet.cell(summary.row, column.index)):
                continue
            try:
                stated, _ = number(self.sheet.cell(summary.row, column.index))
            except ReadingsError:
                continue
            above = [entry for entry in entries if entry.row < summary.row and entry.column == column.index]
            same = [entry for entry in above if labels and _matches(entry, labels)]
            sets = [same, [entry for entry in above if entry.row > before], above]
            sizes = [[entry.raw.size for entry in each] for each in sets if each]
            if not sizes or any(_agree(stated, compute(each)) for each in sizes):
                continue
            if summary.kind == "mean" and any(_agree(stated, median(each)) for each in sizes):
                continue
            rows = [entry.row for entry in next(each for each in sets if each)]
            yield Message(
                "warning",
                "summary_disagrees",
                Sentence(
                    "the {what} {stated:.7g} stands in row {row}, but that of {rows} is {computed:.7g}: a slip in one "
                    "of them",
                    what=summary.name,
                    stated=stated,
                    row=self.sheet.row_number(summary.row),
                    rows=rows_named(self.sheet, rows),
                    computed=compute(sizes[0]),
                ),
                self.sheet.place(summary.row, column.index, self.header.text(column.index)),
            )


def _says_diameter(text: str) -> bool:
    return any(word in _DIAMETER for word in re.findall(r"[ø⌀φ∅]|[^\W\d_]+", plain(text))) or text in {"D", "DM", "DIA"}


def _asks(heading: str, words: Vocabulary) -> bool:
    """Return whether a heading asks if the row counts: it holds such a word, and little else."""
    words_of_heading = letters(heading)
    return len(words_of_heading) <= 4 and any(word in words for word in words_of_heading)


def _matches(entry: DiameterCell, labels: Mapping[str, object]) -> bool:
    return all(getattr(entry.key, name) == value for name, value in labels.items())


def _agree(stated: float, computed: float) -> bool:
    """Return whether two numbers are equal after rounding to the decimals of the stated one."""
    decimals = len(f"{stated:.6f}".rstrip("0").partition(".")[2])
    return abs(stated - computed) <= max(0.5 * 10.0**-decimals if decimals <= 3 else 0.0, _HALF_A_MICROMETRE) + 1e-9


def _hidden(way: Hiding, rows: Sentence, named: Sentence) -> Sentence:
    if way == "by hand":
        return Sentence(
            "{rows} with readings, hidden by hand: left aside: show them, and they are read ({named})",
            rows=rows,
            named=named,
        )
    if way == "by a filter":
        return Sentence("{rows} with readings, hidden by a filter: read all the same ({named})", rows=rows, named=named)
    return Sentence(
        "{rows} with readings, hidden in a folded outline: read all the same ({named})", rows=rows, named=named
    )


def _count(rows: Sequence[int]) -> Sentence:
    if len(rows) > 1:
        return Sentence("{count} rows", count=len(rows))
    return Sentence("{count} row", count=len(rows))
