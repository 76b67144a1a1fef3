"""Rows that hold numbers and no reading, and readings that their author marked.

`Exclusions` leaves out means and sums, nominal diameters, what was crossed out, hidden or called void. Comments,
colours and stars only people can explain: a reading that is marked counts all the same, and `mark_messages` says so.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cached_property
from statistics import fmean, median
from typing import Any

from atleak.common.errors import Message, ReadingsError, nearest_name
from atleak.common.sentences import Sentence, counted, some
from atleak.readers.cells.sheet import Cell, column_letter, rows_named
from atleak.readers.sheets.column_headings import HeadedColumn
from atleak.readers.sheets.columns import Columns
from atleak.readers.sheets.controller_names import ControllerNames, Sizes
from atleak.readers.sheets.diameters import DiameterCell
from atleak.readers.sheets.table import HeadedTable
from atleak.readers.sheets.words import (
    Summary,
    direction_of,
    is_blank,
    is_marked,
    letters,
    number_of,
    part_said,
    plain,
    repeat_of,
    says,
    says_specification,
    stated_number,
    summary_of,
    text_of,
)

# why rows are left aside, in the order of the messages: by the code of the message, or by how rows are hidden
_WHY: Mapping[str, Sentence] = {
    "summaries_left_aside": Sentence("{rows} of {what} left aside ({named})"),
    "specifications_left_aside": Sentence("{rows} of {what!r} left aside, what should be ({named})"),
    "characteristics_left_aside": Sentence("{rows} of other characteristics left aside ({what}): {named}"),
    "notes_left_aside": Sentence(
        "{rows} left aside, whose label is no component and which say nothing else ({what}): {named}"
    ),
    "rejected_left_aside": Sentence("{rows} left aside, because {what} ({named})"),
    "struck_left_aside": Sentence("{rows} with a crossed-out reading: it was left aside ({named})"),
    "by hand": Sentence("{rows} with readings, hidden by hand: left aside: show them, and they are read ({named})"),
    "by a filter": Sentence("{rows} with readings, hidden by a filter: read all the same ({named})"),
    "in a folded outline": Sentence("{rows} with readings, hidden in a folded outline: read all the same ({named})"),
}
_SAID: Mapping[str, Sentence] = {  # the same of one row
    "summaries_left_aside": Sentence("{what}"),
    "specifications_left_aside": Sentence("{what!r}: what should be"),
    "characteristics_left_aside": Sentence("another characteristic: {what}"),
    "notes_left_aside": Sentence("no component: {what}"),
    "rejected_left_aside": Sentence("{what}"),
    "struck_left_aside": Sentence("crossed out"),
    "by hand": Sentence("hidden by hand"),
}
_HIDDEN, _READ_ALL_THE_SAME = "hidden_rows", ("by a filter", "in a folded outline")
_NO_WARNING = ("summaries_left_aside", "specifications_left_aside", "characteristics_left_aside", *_READ_ALL_THE_SAME)
LEFT_ASIDE = (*(code for code in _WHY if code.endswith("_left_aside")), _HIDDEN)  # codes of messages
_HALF_A_MICROMETRE = 0.5e-3  # in the numbers of a sheet in mm: how far a mean may be rounded
_SHOWN = 4
_MARKS = {"x", "✓", "✔", "1"}
_NAMES: dict[Summary, tuple[Sentence, Sentence]] = {  # of one, and of several
    "mean": (Sentence("mean"), Sentence("means")),
    "sum": (Sentence("sum"), Sentence("sums")),
    "largest": (Sentence("largest value"), Sentence("largest values")),
    "smallest": (Sentence("smallest value"), Sentence("smallest values")),
    "spread": (Sentence("spread"), Sentence("spreads")),
    "count": (Sentence("count"), Sentence("counts")),
}
_COMPUTED: dict[Summary, tuple[Callable[[Sequence[float]], float], ...]] = {  # what may be meant, the usual first
    "mean": (fmean, median),
    "sum": (sum,),
    "largest": (max,),
    "smallest": (min,),
}


class Exclusions:
    """The rows of a table that hold numbers and no reading, with the reason of each."""

    def __init__(self, table: HeadedTable, columns: Columns, names: ControllerNames) -> None:
        self.table, self.sheet, self.columns, self.names = table, table.sheet, columns, names
        self.struck: list[int] = []
        self._summaries: dict[int, Summary] = {}  # by row
        self._left: dict[str, dict[Any, list[int]]] = {why: {} for why in _WHY}  # rows by why, and what says so
        self._keys = [column.index for column in columns.keys]
        self._others = [index for index in range(self.sheet.width) if index not in columns.read]
        self._cells = {index: table.cells(index) for index in (*self._keys, *self._others)}
        asked = {at: words for at in self._others if len(words := letters(table.heading(at))) <= 4}
        self._counts = [at for at, words in asked.items() if words.any("counts")]
        self._counts_not = [at for at, words in asked.items() if words.any("counts_not")]
        self._machine = [index for index in self._others if self._says_characteristics(index)]

    @cached_property
    def _ticked(self) -> list[int]:
        """Return the columns with a tick in the rows that count, and nowhere a "no": no tick says it then."""
        return [
            index
            for index in self._counts
            if (cells := self._cells[index].values())
            and all(says(cell, "yes", "counts_not") and text_of(cell).lower() in _MARKS for cell in cells)
        ]

    @cached_property
    def _beside_component(self) -> list[int]:
        component = self.columns.component
        return [index for index in self._keys if component and index != component.index and self._cells[index]]

    def _says_characteristics(self, index: int) -> bool:
        words = letters(self.table.heading(index))
        named = words.any("characteristic") and len(words) < 4
        return named and any(_says_diameter(text_of(cell)) for cell in self._cells[index].values())

    def takes(self, row: int) -> Sentence | None:
        """Return why a row that holds numbers is no reading, and note it; None where it is one."""
        hidden = self.sheet.marks.hidden_rows.get(row)
        if hidden in _READ_ALL_THE_SAME:
            self._left[hidden].setdefault(None, []).append(row)
        reasons: tuple[tuple[str, Callable[[int], Any]], ...] = (
            ("by hand", lambda _: hidden if hidden == "by hand" else None),
            ("rejected_left_aside", self._rejection),
            ("struck_left_aside", self._strike),
            ("summaries_left_aside", self._summary),
            ("characteristics_left_aside", self._other_characteristic),
            ("notes_left_aside", self._note),
            ("specifications_left_aside", self._specification),
        )
        for why, find in reasons:
            what = find(row)
            if what is not None:
                self._left[why].setdefault(what, []).append(row)
                return _SAID[why].of(what=_NAMES.get(what, (what,))[0])
        return None

    def _rejection(self, row: int) -> Sentence | None:
        for index, rejects in (*((at, "no") for at in self._counts), *((at, "yes") for at in self._counts_not)):
            heading, cell = self.table.heading(index), self._cells[index].get(row)
            if cell is not None and says(cell, rejects, "counts_not"):
                return Sentence("column {heading!r} says {said!r}", heading=heading, said=text_of(cell))
            if cell is None and index in self._ticked:
                return Sentence("column {heading!r} has no mark", heading=heading)
        remarks = (self.sheet.cell(row, index) for index in self._others)
        remark = next((cell for cell in remarks if isinstance(cell, str) and says(cell, "counts_not")), None)
        return None if remark is None else Sentence("a remark says {said!r}", said=text_of(remark))

    def _strike(self, row: int) -> str | None:
        if self.sheet.marks.struck and any(self.sheet.is_struck(row, index) for index in self._keys):
            self.struck.append(row)
            return "struck"
        return None

    def _summary(self, row: int) -> Summary | None:
        columns = self.columns
        for column in columns.keys:
            label = self.sheet.filled(row, column.index)
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
                break
        else:
            cells = (self.sheet.cell(row, index) for index in self._others)
            kind = next((kind for cell in cells if (kind := summary_of(cell))), None)
        if kind is not None:
            self._summaries[row] = kind
        return kind

    def _other_characteristic(self, row: int) -> str | None:
        cells = [text_of(self._cells[index][row]) for index in self._machine if row in self._cells[index]]
        return cells[0] if cells and not any(map(_says_diameter, cells)) else None

    def _note(self, row: int) -> str | None:
        """Return the label of a row that says nothing of what a diameter is of, and whose label is no component.

        A label that is nearly a component's name is a slip in a reading, and is refused as one.
        """
        component = self.columns.component
        if component is None or any(row in self._cells[index] for index in self._beside_component):
            return None
        if component.index in self.sheet.derived:  # of cells that name a land too, if their valve has several
            values = (self.sheet.cell(row, column.index) for group in self.columns.groups for column in group.values())
            if Sizes(self.names.controller).fill([*values]):
                return None
        label = self._cells[component.index].get(row, "")
        if not isinstance(label, str) or not label or self.names.component(label) is not None:
            return None
        if not self._beside_component and not letters(label).any("gauge", "calibration"):
            return None
        near = nearest_name(plain(label), [*self.names.spellings])
        return repr(text_of(label)) if near is None and number_of(label) is None and letters(label) else None

    def _specification(self, row: int) -> str | None:
        for index, cell in enumerate(self.sheet.rows[row]):
            if isinstance(cell, str) and says_specification(cell) and self._is_label(index, cell):
                return cell
        return None

    def _is_label(self, index: int, label: str) -> bool:
        """Return whether a cell names its row: in a key's column, or in one that holds no numbers."""
        if index in self._keys:
            return self.names.component(label) is None
        return index in self._others and not any(
            isinstance(cell, int | float) or number_of(str(cell)) is not None for cell in self._cells[index].values()
        )

    def messages(self, entries: Sequence[DiameterCell]) -> Iterator[Message]:
        """Yield what was left aside, and which means or sums disagree with the readings above them."""
        if self.struck:
            self._left["struck_left_aside"] = {"struck": sorted(set(self.struck))}
        for why, text in _WHY.items():
            groups = list(self._left[why].items())
            if why == "summaries_left_aside":
                groups = [(_NAMES[kind][1], rows) for kind, rows in groups]
            elif why in ("characteristics_left_aside", "notes_left_aside") and groups:  # together, whatever they are
                whats = some(tuple(what for what, _ in groups), _SHOWN)
                groups = [(whats, [row for _, rows in groups for row in rows])]
            for what, rows in groups:
                count = counted(len(rows), "{count} row", "{count} rows")
                reason = text.of(rows=count, what=what, named=rows_named(self.sheet, rows))
                code = why if why in LEFT_ASIDE else _HIDDEN
                yield Message("info" if why in _NO_WARNING else "warning", code, reason, self.sheet.place())
        for row, kind in self._summaries.items():
            if kind in _COMPUTED:
                yield from self._disagreement(row, kind, entries)

    def take_back_means(self, entries: Sequence[DiameterCell]) -> list[tuple[int, Sentence]]:
        """Return the rows of means that say what they are of, and of which the sheet holds no single readings."""
        alone = [
            (row, kind)
            for row, kind in self._summaries.items()
            if kind in ("mean", "largest", "smallest")
            and "component" in (labels := self._labels(row))
            and not any(_matches(entry, labels) for entry in entries)
        ]
        for row, kind in alone:
            del self._summaries[row]
            left = self._left["summaries_left_aside"]
            left[kind].remove(row)
            if not left[kind]:
                del left[kind]
        return [(row, _NAMES[kind][0]) for row, kind in alone]

    def _labels(self, row: int) -> Mapping[str, object]:
        columns, names = self.columns, self.names

        def cell(column: HeadedColumn | None) -> Cell:
            return "" if column is None else self._cells[column.index].get(row, "")

        component = names.component(cell(columns.component))
        labels: dict[str, object] = {"component": component}
        try:
            if component is not None and cell(columns.plane) != "":
                labels["plane"] = names.plane(component, cell(columns.plane))
            elif component is not None and cell(columns.land) != "":
                labels["plane"] = names.land(component, cell(columns.land)).planes[0]
        except ReadingsError:
            pass
        labels["part"] = part_said(text_of(cell(columns.part)))
        labels["direction"] = direction_of(cell(columns.direction))
        return {name: value for name, value in labels.items() if value is not None}

    def _disagreement(self, row: int, kind: Summary, entries: Sequence[DiameterCell]) -> Iterator[Message]:
        for column in (group["diameter"] for group in self.columns.groups if "diameter" in group):
            stated, _ = stated_number(self.sheet.cell(row, column.index)) or (None, None)
            sets = self._summarised(row, column, entries)
            computed = [of([entry.raw.size for entry in above]) for of in _COMPUTED[kind] for above in sets]
            if stated is None or not sets or any(_agree(stated, size) for size in computed):
                continue
            text = Sentence(
                "the {what} {stated:.7g} stands in row {row}, but that of {rows} is {computed:.7g}: a slip in one of "
                "them",
                what=_NAMES[kind][0],
                stated=stated,
                row=self.sheet.row_number(row),
                rows=rows_named(self.sheet, [entry.row for entry in sets[0]]),
                computed=computed[0],
            )
            place = self.sheet.place(row, column.index, self.table.heading(column.index))
            yield Message("warning", "summary_disagrees", text, place)

    def _summarised(
        self, row: int, column: HeadedColumn, entries: Sequence[DiameterCell]
    ) -> list[Sequence[DiameterCell]]:
        """Return what a mean or sum may be of, of the diameters above it: of its labels, since the last one, all."""
        before, labels = max((other for other in self._summaries if other < row), default=-1), self._labels(row)
        above = [entry for entry in entries if entry.row < row and entry.column == column.index]
        same = [entry for entry in above if labels and _matches(entry, labels)]
        since = [entry for entry in above if entry.row > before]
        return [*filter(None, (same, since, above))]


def _says_diameter(text: str) -> bool:
    return letters(re.sub("[ø⌀φ]", " ø ", plain(text))).any("diameter") or text in {"D", "DM", "DIA"}


def _matches(entry: DiameterCell, labels: Mapping[str, object]) -> bool:
    return all(getattr(entry.key, name) == value for name, value in labels.items())


def _agree(stated: float, computed: float) -> bool:
    decimals = len(f"{stated:.6f}".rstrip("0").partition(".")[2])
    return abs(stated - computed) <= max(0.5 * 10.0**-decimals if decimals <= 3 else 0.0, _HALF_A_MICROMETRE) + 1e-9


_QUOTED = 4  # marks that a message names
_LONGEST = 80  # characters of a comment or legend that are quoted
_FEW = 0.01, 0.5  # part of the readings: so many that are coloured otherwise are marked

At = tuple[int, int]  # row, column


def mark_messages(table: HeadedTable, rows: Collection[int], columns: Columns) -> Iterator[Message]:
    """Say which readings of a table are marked; ``rows`` are those that hold any."""
    sheet = table.sheet
    groups = [[column.index for column in group.values()] for group in columns.groups]
    read = [
        [(row, sheet.derived.get(index, index)) for index in group if not is_blank(sheet.cell(row, index))]
        for row in rows
        for group in groups
    ]
    read = [cells for cells in read if cells]
    if read:
        yield from _stars(table, read)
        yield from _comments(table, rows)
        yield from _colours(table, read)


def _stars(table: HeadedTable, read: Sequence[Sequence[At]]) -> Iterator[Message]:
    sheet, marked = table.sheet, [at for cells in read for at in cells if is_marked(table.sheet.cell(*at))]
    if marked:
        numbers = tuple(dict.fromkeys(text_of(sheet.cell(*at)) for at in marked))[:_QUOTED]
        text = Sentence(
            "a mark stands at {numbers} ({rows}): read as they stand; what it means only the sheet's notes say",
            numbers=numbers,
            rows=rows_named(sheet, [row for row, _ in marked]),
        )
        yield Message("info", "numbers_marked", text, sheet.place(*marked[0]))


def _comments(table: HeadedTable, rows: Collection[int]) -> Iterator[Message]:
    sheet = table.sheet
    comments = {at: words for at, words in sorted(sheet.marks.comments.items()) if at[0] in rows and words}
    if comments:
        quoted = [f"{_named(table, at)}: {' '.join(words.split())[:_LONGEST]!r}" for at, words in comments.items()]
        text = Sentence(
            "comments on readings, which count all the same: {comments}. Cross out what is not to count",
            comments=_listed(quoted),
        )
        rejected = any(letters(words).any("counts_not") for words in comments.values())
        yield Message("warning" if rejected else "info", "readings_commented", text, sheet.place(*next(iter(comments))))


def _colours(table: HeadedTable, read: Sequence[Sequence[At]]) -> Iterator[Message]:
    """Say which readings are coloured otherwise than most in their column, which are at most half."""
    sheet, colours = table.sheet, table.sheet.marks.colours
    by_column: dict[int, Counter[str]] = {}
    for at in (at for cells in read for at in cells):
        by_column.setdefault(at[1], Counter())[colours.get(at, "")] += 1
    usual = {column: counted.most_common(1)[0][0] for column, counted in by_column.items()}
    unusual = ([at for at in cells if colours.get(at, "") != usual[at[1]]] for cells in read)
    others = [cells[0] for cells in unusual if cells]
    part = len(others) / len(read)
    if not _FEW[0] <= part <= _FEW[1]:
        return
    text = Sentence(
        "coloured otherwise than the rest of their column, {count} of {all} readings: {cells}. They count all the "
        "same: cross out what is not to count"
    )
    text = text.of(count=len(others), all=len(read), cells=_listed([_named(table, at) for at in others]))
    yield Message("warning", "readings_coloured", text, sheet.place(*others[0]))


def _named(table: HeadedTable, at: At) -> str:
    row, column = (at[1], at[0]) if table.sheet.turned else at
    return f"{column_letter(column)}{row + 1}"


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:_QUOTED]) + (" …" if len(names) > _QUOTED else "")
