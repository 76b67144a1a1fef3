"""The tables of a sheet: where each begins and ends, what its title says, and whether it holds readings at all.

A sheet whose headings run down its first column is turned. Where nothing is understood, `likely` says which column most
likely is what, for a person to judge.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise, zip_longest
from typing import Any

from atleak.common.errors import ReadingsError
from atleak.common.sentences import Sentence, all_of
from atleak.readers.cells.extent import MOST_TABLES
from atleak.readers.cells.sheet import Cell, Sheet
from atleak.readers.cells.workbook_marks import Marks
from atleak.readers.sheets.controller_names import UNITS, ControllerNames, Sizes, is_whole, numbers_of, read_label
from atleak.readers.sheets.mapping import NOTHING_SAID, SheetMapping, tables_of_form
from atleak.readers.sheets.table import HeadedTable, find_headers, headings, read_together
from atleak.readers.sheets.words import (
    is_blank,
    letters,
    number_of,
    part_in,
    plain,
    summary_of,
)

_TITLE_ROWS = 4


def find_tables(sheet: Sheet, names: ControllerNames) -> list[HeadedTable]:
    """Return every table of a sheet that has headings, from top to bottom and from left to right."""
    if (own := tables_of_form(sheet)) is not None:
        return own
    return [
        table
        for strip in _strips(sheet, names)
        for above in _stacked(strip, names)
        for beside in _side_by_side(above)
        for table in _sections(_titled(beside, names), names)
    ]


def mapped_tables(sheet: Sheet, mapping: SheetMapping, names: ControllerNames) -> list[HeadedTable]:
    """Return the tables whose columns a person named, cut by lines between their rows; no title leaves one aside.

    A table begins wherever its headings come again.
    """
    table = _by_content(mapping.table(sheet, names), Sizes(names.controller))
    depth = table.last - table.first
    again = [
        replace(table, first=row, last=row + depth, messages=())
        for row in (table.rows if any(table.headed) else ())
        if tuple(headings(table.sheet, row, row + depth))[: len(table.headed)] == table.headed
    ]
    return [
        section
        for cut in _cut(table.sheet, [table, *again])
        for section in _sections(replace(_titled(cut, names, mapping), left_aside=None), names, mapping)
    ]


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
    headed = [view for view in views if any(map(_is_whole, find_headers(view, names.is_named)))]
    return views if len(headed) > 1 else [sheet]


def _is_whole(header: HeadedTable) -> bool:
    return bool((header.values or header.of("specification")) and header.labels)


def _only(sheet: Sheet, left: int, right: int, end: int | None = None) -> Sheet:
    rows = sheet.rows if end is None else sheet.rows[:end]
    if left > 0 or right < sheet.width:
        rows = [["" if index < left else cell for index, cell in enumerate(row[:right])] for row in rows]
    return replace(sheet, rows=rows, faults={at: why for at, why in sheet.faults.items() if left <= at[1] < right})


def _stacked(sheet: Sheet, names: ControllerNames) -> Iterator[HeadedTable]:
    headers = find_headers(sheet, names.is_named)
    if len(headers) > MOST_TABLES:
        problem = Sentence("this sheet has {count} tables with headings of their own", count=len(headers))
        expected = Sentence("at most {count}", count=MOST_TABLES)
        raise ReadingsError(problem, place=sheet.place(), expected=expected)
    for table in _cut(sheet, headers):
        yield _by_content(table, Sizes(names.controller))


def _cut(sheet: Sheet, headers: Sequence[HeadedTable]) -> Iterator[HeadedTable]:
    """Yield every table of a sheet with its own rows: down to the headings of the next, or the titles over these."""
    for header, following in zip_longest(headers, headers[1:]):
        end = len(sheet.rows)
        if following is not None:
            titles = [row for row in _title_rows(sheet, following.first, header.last) if is_single(sheet, row)]
            end = min([following.first, *titles])
        yield replace(header, sheet=_only(sheet, 0, sheet.width, end))


def _by_content(table: HeadedTable, sizes: Sizes) -> HeadedTable:
    """Return the table without a "result" that is no diameter, and without raw readings beside others."""
    kept = []
    for column in table.columns:
        if not column.tentative or sizes.fill(table.cells(column.index).values()):
            kept.append(column)
        elif column.otherwise is not None:
            kept.append(replace(column, role=column.otherwise, tentative=False))
    groups = [(other.group, other) for other in kept if other.holds_value]
    for at, column in enumerate(kept):
        others = [other for group, other in groups if group == column.group and other is not column]
        corrected = any(other.standing == "corrected" for other in others) and column.standing != "corrected"
        if column.role == "diameter" and others and (column.standing == "raw" or corrected):
            kept[at] = replace(column, role="raw")
    return replace(table, columns=tuple(kept))


def is_single(sheet: Sheet, row: int) -> bool:
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


def _side_by_side(table: HeadedTable) -> Iterator[HeadedTable]:
    """Yield the table, or those that share its rows: between empty headings, or where the first one returns."""
    starts = {index for index in range(1, len(table.texts)) if table.texts[index] and not table.texts[index - 1]}
    keys = table.labels
    starts |= {column.index for column in keys[1:] if plain(column.heading) == plain(keys[0].heading)}
    edges = [0]
    for start in sorted(starts):
        left, right = _between(table, edges[-1], start), _between(table, start, table.sheet.width)
        if all(side.labels and any(column.holds_size for column in side.columns) for side in (left, right)):
            edges.append(start)
    if len(edges) == 1:
        yield table
        return
    for begin, end in pairwise([*edges, table.sheet.width]):
        part = _between(table, begin, end)
        texts = tuple(text if begin <= index < end else "" for index, text in enumerate(table.texts))
        columns = read_together(list(part.columns))
        yield replace(part, sheet=_only(table.sheet, begin, end), columns=columns, texts=texts)


def _between(table: HeadedTable, begin: int, end: int) -> HeadedTable:
    return replace(table, columns=tuple(column for column in table.columns if begin <= column.index < end))


def _titled(table: HeadedTable, names: ControllerNames, said: SheetMapping = NOTHING_SAID) -> HeadedTable:
    """Return the table with what its title lines and its sheet's name say of it."""
    above = _title_rows(table.sheet, table.first, -1)
    texts = [" ".join(str(cell) for cell in table.sheet.rows[row] if not is_blank(cell)) for row in above]
    lines = [(Sentence("the title {said!r}", said=text), text) for text in texts]
    if table.sheet.name is not None:
        lines.append((Sentence("the sheet's name {said!r}", said=table.sheet.name), table.sheet.name))
    return replace(_said(table, lines, names, said), left_aside=_why_aside(table, [*texts[:1], table.sheet.name or ""]))


def _said(
    table: HeadedTable, lines: Sequence[tuple[Sentence, str]], names: ControllerNames, said: SheetMapping
) -> HeadedTable:
    """Return the table with part and component from the nearest line that says one, where no column does."""

    def component(text: str) -> str | None:
        named = said.named("component", text) or names.component_in(text)
        return named or (names.component(text) if text == table.sheet.name else None)

    named_by: list[Sentence] = []
    for name, read, wanted in (
        ("part", lambda text: said.named("part", text) or part_in(text), bool(table.values) and not table.has_part),
        ("component", component, not table.of("component")),
    ):
        found = next(((line, value) for line, text in lines if (value := read(text)) is not None), None)
        if wanted and found is not None:
            named_by.append(found[0])
            change: dict[str, Any] = {name: found[1]}
            table = replace(table, **change)
    return replace(table, named_by=all_of(dict.fromkeys(named_by))) if named_by else table


def _why_aside(table: HeadedTable, titles: Sequence[str]) -> Sentence | None:
    if not table.values and not table.of_lands:
        return Sentence("no measured diameter by its headings")
    for title in titles:
        words = letters(title)
        counted = summary_of(title.partition(" ")[0]) in ("count", "spread") and words.any("diameter")
        if counted or (words.any("specification_title", "calibration") and not words.any("of_reading", "error")):
            return Sentence("by its title {title!r} no readings", title=title)
    if not table.of("component") and table.of("gauge"):
        return Sentence("a check of the instrument")
    return None


def _sections(table: HeadedTable, names: ControllerNames, said: SheetMapping = NOTHING_SAID) -> Iterator[HeadedTable]:
    """Yield the table, cut where a line between its rows names the part or component that no column does."""
    if table.left_aside or not table.values or (table.has_part and table.of("component")):
        yield table
        return
    section, sheet = table, table.sheet
    for row in table.rows:
        if not is_single(sheet, row):
            continue
        text = next(str(cell) for cell in sheet.rows[row] if not is_blank(cell))
        following = _said(table, [(Sentence("the line {said!r}", said=text), text)], names, said)
        if following.named_by == table.named_by:
            # an unknown line ends what the line before it says
            following = replace(table, part=None, component=None, named_by=None)
        else:
            following = replace(
                following,
                named_by=all_of(dict.fromkeys(named for named in (following.named_by, section.named_by) if named)),
                part=following.part or section.part,
                component=following.component or section.component,
            )
        yield replace(section, sheet=replace(sheet, rows=sheet.rows[:row]))
        section = replace(following, first=row, last=row)
    yield section


_MOST_CELLS = 200_000  # of a sheet that is turned; a measuring sheet has a hundredth of them


def turned(sheet: Sheet) -> Sheet | None:
    """Return the sheet with rows and columns exchanged; None where it is too large for a measuring sheet."""
    if sheet.width * len(sheet.rows) > _MOST_CELLS:
        return None
    rows = [list(cells) for cells in zip_longest(*sheet.rows, fillvalue="")]
    merged = {(column, row): (left, top) for (row, column), (top, left) in sheet.merged.items()}
    marks = Marks(
        hidden_rows=dict.fromkeys(sheet.marks.hidden_columns, "by hand"),
        hidden_columns=frozenset(sheet.marks.hidden_rows),
        struck=frozenset((column, row) for row, column in sheet.marks.struck),
        colours={(column, row): colour for (row, column), colour in sheet.marks.colours.items()},
        comments={(column, row): words for (row, column), words in sheet.marks.comments.items()},
    )
    faults = {(column, row): why for (row, column), why in sheet.faults.items()}
    rows[:1] = [
        [
            ""
            if isinstance(cell, str) and not numbers_of(cell) and all(is_blank(row[index]) for row in rows[1:])
            else cell
            for index, cell in enumerate(cells)
        ]
        for cells in rows[:1]
    ]  # a title or a note beside nothing heads no column
    return replace(sheet, rows=rows, merged=merged, faults=faults, marks=marks, turned=not sheet.turned)


_LOOKED_AT = 60  # rows by which a sheet is told from a log


def looks_measured(sheet: Sheet, names: ControllerNames, least: int = 1) -> bool:
    """Return whether most rows name a component in one column and hold a diameter of it in another, whatever is headed.

    A gear and a voltage look so as well: more than one plane is found, or a component by a word; and at ``least`` so
    many planes.
    """
    sizes, rows = Sizes(names.controller), [row for row in sheet.rows[:_LOOKED_AT] if any(True for _ in _exact(row))]
    for index in range(sheet.width):
        found: list[str] = []
        near: set[tuple[str, str]] = set()
        for row in rows:
            component = (read_label(row[index] if index < len(row) else "", names) or {}).get("component", "")
            planes = [plane for land in names.controller.lands_of(component) for plane in land.planes]
            of = [
                plane
                for plane in planes
                if any(sizes.near_plane(size, UNITS, component, plane) for size in _exact(row))
            ]
            near |= {(component, plane) for plane in of}
            found += [component] if of else []
        if 2 * len(found) > len(rows) and len(near) >= least and (len(near) > 1 or any(map(str.isalpha, found[0]))):
            return True
    return False


def _exact(row: Sequence[Cell]) -> Iterator[float]:
    return (value for cell in row if not is_whole(cell) for value in numbers_of(cell))
