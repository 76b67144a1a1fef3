"""The tables of a sheet: where each begins and ends, what its title says, and whether it holds readings at all."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise, zip_longest

from atleak.catalogue.instruments import Part
from atleak.errors import Message, Place, ReadingsError
from atleak.intake.readings.controller_names import ControllerNames
from atleak.intake.readings.deviations import with_deviations
from atleak.intake.readings.headings import Header, find_headers, read_together
from atleak.intake.readings.one_heading import KEYS, Column, Role
from atleak.intake.readings.sizes import INCH, MM, UM, Sizes, numbers_of
from atleak.intake.readings.split_labels import with_split_labels
from atleak.intake.readings.words import (
    ERRORS,
    READINGS,
    is_blank,
    is_page_title,
    letters,
    number_of,
    part_in,
    part_said,
    plain,
    repeat_of,
    summary_of,
    text_of,
    vocabulary,
)
from atleak.intake.sheets.extent import TABLES
from atleak.intake.sheets.sheet import Sheet
from atleak.sentence import Sentence, all_of

_ASIDE = vocabulary("specification_title", "calibration")
_DIAMETER = vocabulary("diameter")
_NUMBER = vocabulary("number")
_READING = vocabulary("reading")
_WORD = re.compile(r"[^\W\d_]+")
_TITLE_ROWS = 4


@dataclass(frozen=True)
class Table:
    """One table of a sheet.

    ``sheet`` holds its cells at the places of the whole sheet, and nothing of the tables beside and below.
    ``part`` and ``component`` are what the title or the sheet's name says, with ``said_by`` naming it. ``aside`` is why
    a table holds no readings of this valve body, None where it may. ``used`` are columns whose numbers went into others
    behind the last, ``filled`` rows whose labels are those of a row above, and ``told`` is what is to be said of both.
    """

    sheet: Sheet
    header: Header
    part: Part | None = None
    component: str | None = None
    said_by: Sentence | None = None
    aside: Sentence | None = None
    used: frozenset[int] = frozenset()
    told: tuple[Message, ...] = ()
    filled: frozenset[int] = frozenset()

    @cached_property
    def title(self) -> str:
        """Return the line of text above the headings, but no count of pages; "" where there is none."""
        lines = [row for row in range(self.header.first) if any(not is_blank(cell) for cell in self.sheet.rows[row])]
        cells = [cell for cell in self.sheet.rows[lines[-1]] if not is_blank(cell)] if lines else []
        title = " ".join(map(str, cells)) if len(cells) == 1 and isinstance(cells[0], str) else ""
        return "" if is_page_title(title) else title

    @cached_property
    def columns(self) -> range:
        """Return the columns that the table spans."""
        wide = [index for index, text in enumerate(self.header.texts) if text]
        return range(min(wide), max(wide) + 1) if wide else range(self.sheet.width)

    @property
    def rows(self) -> range:
        """Return the rows under the headings."""
        return range(self.header.last + 1, len(self.sheet.rows))

    @property
    def as_it_stands(self) -> Table:
        """Return the table for what stands above its headings in the file, also where it was turned."""
        if not self.sheet.turned:
            return self
        first = min((each.index for each in self.header.columns if each.holds_size or each.role in KEYS), default=0)
        return replace(self, sheet=replace(self.sheet, turned=False), header=replace(self.header, first=first))

    @property
    def headings(self) -> Place:
        """Return the place of the heading of its first value."""
        column = self.header.values[0]
        return self.sheet.place(max(self.header.last, 0), column.index, column.name)

    @cached_property
    def block(self) -> range:
        """Return the rows under the headings up to the first empty one."""
        for row in self.rows[1:]:
            if all(is_blank(self.sheet.cell(row, column)) for column in self.columns):
                return range(self.header.last + 1, row)
        return self.rows

    def heading(self, index: int) -> str:
        """Return the heading of a column on one line, "" where it has none."""
        return self.header.text(index)

    @cached_property
    def where(self) -> Sentence:
        """Return the rows from the headings to the last one, as a person counts them."""
        first = self.sheet.row_number(max(self.header.first, 0))
        rows = [row for row in self.block if any(not is_blank(cell) for cell in self.sheet.rows[row])]
        last = self.sheet.row_number(rows[-1]) if rows else first
        if self.sheet.name is None:
            return Sentence("rows {first} to {last}", first=first, last=last)
        return Sentence("sheet {name!r}, rows {first} to {last}", name=self.sheet.name, first=first, last=last)

    @property
    def has_part(self) -> bool:
        """Return whether a column says the part, or every heading of a value; also a "component" column of parts."""
        values = self.header.values
        return (
            bool(self.header.of("part"))
            or (bool(values) and all(column.part for column in values))
            or any(self._holds_parts(column) for column in self.header.of("component"))
        )

    def _holds_parts(self, column: Column) -> bool:
        cells = [cell for row in self.rows if not is_blank(cell := self.sheet.cell(row, column.index))]
        return 2 * sum(part_said(text_of(cell)) is not None for cell in cells) > len(cells)

    @property
    def is_of_lands(self) -> bool:
        """Return whether it holds no diameters, and what lands themselves have: lengths, repairs that are fitted."""
        return not self.header.values and bool(self.header.of_lands) and not self.aside

    @property
    def readable(self) -> bool:
        """Return whether readings can be read from the table at all."""
        known = self.header.of("component") or self.component is not None
        return bool(known and self.header.values and not self.aside)


def find_tables(sheet: Sheet, names: ControllerNames) -> list[Table]:
    """Return every table of a sheet that has headings, from top to bottom and from left to right."""
    return [
        table
        for strip in _strips(sheet, names)
        for above in _stacked(strip, names)
        for beside in _side_by_side(above)
        for table in _sections(_titled(beside, names), names)
    ]


def continued(sheet: Sheet, table: Table, names: ControllerNames) -> Table | None:
    """Return a sheet without headings as the continuation of the table before it, where the columns fit."""
    components, values = table.header.of("component"), table.header.values
    rows = [row for row, cells in enumerate(sheet.rows) if any(not is_blank(cell) for cell in cells)]
    if not rows or not components or not values:
        return None
    for row in rows:
        if not any(names.component(sheet.filled(row, column.index)) for column in components):
            return None
        for column in values:
            cell = sheet.cell(row, column.index)
            if not is_blank(cell) and isinstance(cell, str) and number_of(cell) is None:
                return None
    return Table(sheet, replace(table.header, first=-1, last=-1), table.part, table.component, table.said_by)


def _strips(sheet: Sheet, names: ControllerNames) -> list[Sheet]:
    """Return the sheet, or its parts left and right of empty columns where each has headings of its own."""
    used = sorted({index for row in sheet.rows for index, cell in enumerate(row) if not is_blank(cell)})
    used_or_merged = {column for _, column in sheet.merged} | set(used)
    ranges: list[list[int]] = []
    for index in used:
        if ranges and all(column in used_or_merged for column in range(ranges[-1][1], index)):
            ranges[-1][1] = index + 1
        else:
            ranges.append([index, index + 1])
    views = [_only(sheet, left, right) for left, right in ranges]
    if len(views) < 2 or sum(any(_is_whole(each) for each in find_headers(view, names.is_named)) for view in views) < 2:
        return [sheet]
    return views


def _is_whole(header: Header) -> bool:
    return bool(header.values or header.of("specification")) and bool(_keys(header.columns))


def _keys(columns: Sequence[Column]) -> list[Column]:
    return [column for column in columns if column.role in ("component", "part", "plane", "land")]


def _only(sheet: Sheet, left: int, right: int, end: int | None = None) -> Sheet:
    rows = sheet.rows if end is None else sheet.rows[:end]
    if left > 0 or right < sheet.width:
        rows = [["" if index < left else cell for index, cell in enumerate(row[:right])] for row in rows]
    return replace(sheet, rows=rows, faults={at: why for at, why in sheet.faults.items() if left <= at[1] < right})


def _stacked(sheet: Sheet, names: ControllerNames) -> Iterator[Table]:
    headers = find_headers(sheet, names.is_named)
    if len(headers) > TABLES:
        problem = Sentence("this sheet has {count} tables with headings of their own", count=len(headers))
        expected = Sentence("at most {count}", count=TABLES)
        raise ReadingsError(problem, place=sheet.place(), expected=expected)
    for header, following in zip_longest(headers, headers[1:]):
        end = len(sheet.rows)
        if following is not None:
            titles = [row for row in _title_rows(sheet, following.first, header.last) if _is_single(sheet, row)]
            end = min([following.first, *titles])
        view = _only(sheet, 0, sheet.width, end)
        view, header = with_split_labels(view, _by_content(view, header, names), names)
        view, header, used, told = with_deviations(view, header)
        yield Table(view, header, used=used, told=told)


def _by_content(sheet: Sheet, header: Header, names: ControllerNames) -> Header:
    """Return the headings without a "result" that is no diameter, and without raw readings beside others."""
    kept = []
    for column in header.columns:
        if not column.tentative or _holds_diameters(sheet, header, column, names):
            kept.append(column)
        elif column.otherwise is not None:
            kept.append(replace(column, role=column.otherwise, tentative=False))
    values = [column for column in kept if column.holds_value]
    without_raw = []
    for column in kept:
        others = [other for other in values if other.group == column.group and other is not column]
        corrected = any(other.standing == "corrected" for other in others) and column.standing != "corrected"
        if column.role == "diameter" and others and (column.standing == "raw" or corrected):
            column = replace(column, role="raw")
        without_raw.append(column)
    return _with_counts(sheet, replace(header, columns=tuple(without_raw)))


def _with_counts(sheet: Sheet, header: Header) -> Header:
    """Return the headings with "Measurement" or "Reading" as the repeat where it counts 1, 2, 3 beside diameters.

    A column that numbers all rows through says nothing.
    """
    columns = list(header.columns)
    for index in range(len(header.texts)):
        words = letters(header.text(index))
        others = [column for column in header.values if column.index != index]
        if not others or not any(word in _READING for word in words):
            continue
        if not all(word in _READING or word in _NUMBER for word in words):
            continue
        below = range(header.last + 1, len(sheet.rows))
        rows = [row for row in below if any(not is_blank(sheet.cell(row, column.index)) for column in others)]
        cells = [cell for row in rows if not is_blank(cell := sheet.filled(row, index))]
        read = [repeat_of(cell) for cell in cells if summary_of(cell, key=True) is None]
        numbers = [number for number in read if number is not None]
        if not numbers or len(numbers) < len(read) or sorted(set(numbers)) != list(range(1, len(set(numbers)) + 1)):
            continue
        restarts = any(after <= before for before, after in pairwise(numbers))
        role: Role = "repeat" if (restarts or len(numbers) < len(cells)) and not header.of("repeat") else "remark"
        columns = [column for column in columns if column.index != index]
        columns.append(Column(index, header.texts[index], role))
    return replace(header, columns=tuple(sorted(columns, key=lambda column: column.index)))


def _holds_diameters(sheet: Sheet, header: Header, column: Column, names: ControllerNames) -> bool:
    sizes = Sizes(names.controller)
    cells = [sheet.cell(row, column.index) for row in range(header.last + 1, len(sheet.rows))]
    filled = [cell for cell in cells if not is_blank(cell)]
    sized = [cell for cell in filled if any(sizes.near(value, (MM, UM, INCH)) for value in numbers_of(cell))]
    return 2 * len(sized) > len(filled)


def _is_single(sheet: Sheet, row: int) -> bool:
    """Return whether a row holds one text and nothing else: a title, or a line between the rows."""
    cells = [cell for cell in sheet.rows[row] if not is_blank(cell)]
    return len(cells) == 1 and isinstance(cells[0], str) and number_of(cells[0]) is None


def _title_rows(sheet: Sheet, first: int, after: int) -> list[int]:
    """Return the rows of text above the headings, the nearest first; not the readings of the table above."""
    title_rows: list[int] = []
    for row in range(first - 1, after, -1):
        cells = [cell for cell in sheet.rows[row] if not is_blank(cell)]
        if not cells:
            continue
        if len(cells) > 2 or not isinstance(cells[0], str) or len(title_rows) == _TITLE_ROWS:
            break
        title_rows.append(row)
    return title_rows


def _side_by_side(table: Table) -> Iterator[Table]:
    """Yield the table, or those that share its rows: between empty headings, or where the first one returns."""
    header = table.header
    starts = [
        index
        for index, text in enumerate(header.texts)
        if text and (index == 0 or not header.texts[index - 1]) and index > 0
    ]
    keys = _keys(header.columns)
    first = plain(keys[0].heading) if keys else None
    starts += [column.index for column in keys[1:] if plain(column.heading) == first]
    edges = [0]
    for start in sorted(set(starts)):
        left = [column for column in header.columns if edges[-1] <= column.index < start]
        right = [column for column in header.columns if start <= column.index]
        if all(_keys(side) and any(column.holds_size for column in side) for side in (left, right)):
            edges.append(start)
    if len(edges) == 1:
        yield table
        return
    for begin, end in zip(edges, [*edges[1:], table.sheet.width], strict=True):
        columns = [column for column in header.columns if begin <= column.index < end]
        texts = tuple(text if begin <= index < end else "" for index, text in enumerate(header.texts))
        part = replace(header, columns=read_together(columns), texts=texts)
        yield replace(table, sheet=_only(table.sheet, begin, end), header=part)


def _titled(table: Table, names: ControllerNames) -> Table:
    """Return the table with what its title lines and its sheet's name say of it."""
    above = _title_rows(table.sheet, table.header.first, -1)
    texts = [" ".join(str(cell) for cell in table.sheet.rows[row] if not is_blank(cell)) for row in above]
    lines = [(Sentence("the title {said!r}", said=text), text) for text in texts]
    if table.sheet.name is not None:
        lines.append((Sentence("the sheet's name {said!r}", said=table.sheet.name), table.sheet.name))
    return replace(_said(table, lines, names), aside=_why_aside(table, [*texts[:1], table.sheet.name or ""]))


def _said(table: Table, lines: Sequence[tuple[Sentence, str]], names: ControllerNames) -> Table:
    """Return the table with part and component from the nearest line that says one, where no column does."""
    part, component = table.part, table.component
    said_by: list[Sentence] = []
    if table.header.values and not table.has_part:
        for line, text in lines:
            if (named_part := part_in(text)) is not None:
                part = named_part
                said_by.append(line)
                break
    if not table.header.of("component"):
        for line, text in lines:
            named = names.component_in(text) or (names.component(text) if text == table.sheet.name else None)
            if named is not None:
                component = named
                said_by.append(line)
                break
    sayers = all_of(dict.fromkeys(said_by)) if said_by else table.said_by
    return replace(table, part=part, component=component, said_by=sayers)


def _why_aside(table: Table, titles: Sequence[str]) -> Sentence | None:
    header = table.header
    if not header.values and not header.of_lands:
        return Sentence("no measured diameter by its headings")
    for title in titles:
        words = set(_WORD.findall(plain(title)))
        counted = summary_of(title.partition(" ")[0]) in ("count", "spread") and bool(words & _DIAMETER)
        if counted or (words & _ASIDE and not words & READINGS and not words & ERRORS):
            return Sentence("by its title {title!r} no readings", title=title)
    if not header.of("component") and header.of("gauge"):
        return Sentence("a check of the instrument")
    return None


def _sections(table: Table, names: ControllerNames) -> Iterator[Table]:
    """Yield the table, cut where a line between its rows names the part or component that no column does."""
    if table.aside or not table.header.values or (table.has_part and table.header.of("component")):
        yield table
        return
    begin, said, sheet = table.header, table, table.sheet
    for row in table.rows:
        if not _is_single(sheet, row):
            continue
        text = next(str(cell) for cell in sheet.rows[row] if not is_blank(cell))
        next_said = _said(table, [(Sentence("the line {said!r}", said=text), text)], names)
        if next_said.said_by == table.said_by:
            # an unknown line ends what the line before it says
            next_said = replace(table, part=None, component=None, said_by=None)
        else:
            sayers = dict.fromkeys(each for each in (next_said.said_by, said.said_by) if each)
            next_said = replace(
                next_said,
                said_by=all_of(sayers) if sayers else None,
                part=next_said.part or said.part,
                component=next_said.component or said.component,
            )
        yield replace(said, sheet=replace(sheet, rows=sheet.rows[:row]), header=begin)
        begin, said = replace(table.header, first=row, last=row), next_said
    yield replace(said, header=begin)
