"""The tables of a file: where each begins and ends, what its title says, and which of them are the measurement.

A sheet whose headings run down its first column is turned.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, zip_longest
from typing import Any

from atleak.catalogue.instruments import Part
from atleak.catalogue.words import PART_WORDS
from atleak.common.errors import Message, Place, ReadingsError, unknown
from atleak.common.sentences import Sentence, all_of
from atleak.readers.cells.extent import FAULTS, MOST_TABLES
from atleak.readers.cells.sheet import Cell, Sheet
from atleak.readers.cells.workbook_marks import Marks
from atleak.readers.own_forms import own_form_of, tables_of_form
from atleak.readers.sheets.column_headings import unit_of_heading
from atleak.readers.sheets.controller_names import UNITS, ControllerNames, Sizes, is_whole, numbers_of, read_label
from atleak.readers.sheets.diameters import PlaceKey, filled_down
from atleak.readers.sheets.mapping import NOTHING_SAID, SheetMapping
from atleak.readers.sheets.rows import SheetRows
from atleak.readers.sheets.table import (
    COLUMNS,
    EXPECTED_SHEET,
    HeadedTable,
    best_header,
    each_reading,
    find_headers,
    headings,
    is_single,
    line_of,
    read_together,
    split,
    which_columns,
)
from atleak.readers.sheets.words import (
    direction_of,
    is_blank,
    is_repeat_title,
    letters,
    part_in,
    part_said,
    plain,
    summary_of,
    text_of,
)

_TITLE_ROWS = 4


def find_tables(sheet: Sheet, names: ControllerNames, said: SheetMapping = NOTHING_SAID) -> list[HeadedTable]:
    """Return every table of a sheet that has headings, from top to bottom and from left to right.

    ``said`` may tell what the sheet's own words mean.
    """
    if (own := tables_of_form(sheet)) is not None:
        return own
    return [
        table
        for strip in _strips(sheet, names)
        for above in _stacked(strip, names)
        for beside in _side_by_side(above)
        for table in _sections(_titled(said.in_words(beside), names, said), names, said)
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
        if _is_headed_again(table, headings(table.sheet, row, row + depth)[: len(table.headed)])
    ]
    return [
        section
        for cut in _cut(table.sheet, [table, *again])
        for section in _sections(replace(_titled(cut, names, mapping), left_aside=None), names, mapping)
    ]


def _is_headed_again(table: HeadedTable, texts: Sequence[str]) -> bool:
    """Return whether the headings of a table come again, those of some diameters left out."""
    values = {column.index for column in table.values}
    told = [text == table.headed[at] or (not text and at in values) for at, text in enumerate(texts)]
    return all(told) and any(texts) and any(texts[at] for at in values if at < len(texts))


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
    headers = [find_headers(view, names.is_named) for view in views]
    headed = [any((one.values or one.of("specification")) and one.labels for one in found) for found in headers]
    return views if sum(headed) > 1 else [sheet]


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
        table = _by_content(table, Sizes(names.controller))
        for column in table.of("part"):
            apart = _is_block(table) and not table.names_parts(column)
            table = split(table, column.index, names) if apart else table
        yield table


def _cut(sheet: Sheet, headers: Sequence[HeadedTable]) -> Iterator[HeadedTable]:
    for header, following in zip_longest(headers, headers[1:]):
        end = len(sheet.rows)
        if following is not None:
            end = min([following.first, *_title_rows(sheet, following.first, header.last)])
        yield replace(header, sheet=_only(sheet, 0, sheet.width, end))


def _by_content(table: HeadedTable, sizes: Sizes) -> HeadedTable:
    """Return the table without a "result" that is no diameter, and without raw readings beside others."""
    kept = []
    for column in table.columns:
        if column.role == "component" and column.rank < 3 and table.names_directions(column):
            column = replace(column, role="direction")
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
    table = replace(table, columns=tuple(kept))
    for column in table.values if not table.mapped else ():
        table = each_reading(table, column)
    return table


def _title_rows(sheet: Sheet, first: int, after: int) -> list[int]:
    """Return the rows of text above the headings, the nearest first; not the readings of the table above."""
    title_rows: list[int] = []
    for row in range(first - 1, after, -1):
        cells = [cell for cell in sheet.rows[row] if not is_blank(cell)]
        if not cells:
            continue
        reading = (
            len(cells) == 2
            and not line_of(sheet, row)
            and (part_said(text_of(cells[0])) or (numbers_of(cells[1]) and not is_whole(cells[1])))
        )
        if len(cells) > 2 or not isinstance(cells[0], str) or reading or len(title_rows) == _TITLE_ROWS:
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
    above = _title_rows(table.sheet, table.first, -1)
    cells = [[str(cell) for cell in table.sheet.rows[row] if not is_blank(cell)] for row in above]
    texts = [line_of(table.sheet, row) or " ".join(of_row) for row, of_row in zip(above, cells, strict=True)]
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
        label = read_label(text, names) or {}  # "V12", "90°"
        return named or (label.get("component") if text == table.sheet.name else None)

    def direction(text: str) -> str | None:
        label = read_label(text, names) or {}
        return label.get("direction") if {*label} <= {"direction", "part", "component"} else None

    directed = bool(table.of("direction")) or any(column.direction is not None for column in table.values)
    named_by: list[Sentence] = []
    for name, read, wanted in (
        ("part", lambda text: said.named("part", text) or part_in(text), bool(table.values) and not table.has_part),
        ("component", component, not table.of("component")),
        ("direction", direction, bool(table.values) and not directed),
    ):
        found = next(((line, value) for line, text in lines if (value := read(text)) is not None), None)
        if wanted and found is not None:
            named_by.append(found[0])
            change: dict[str, Any] = {name: found[1]}
            if name == "direction":
                angle = direction_of(found[1])
                of_value = (replace(each, direction=angle) if each.holds_value else each for each in table.columns)
                change = {"columns": tuple(of_value)}
            table = replace(table, **change)
    return replace(table, named_by=all_of(dict.fromkeys(named_by))) if named_by else table


def _why_aside(table: HeadedTable, titles: Sequence[str]) -> Sentence | None:
    if not table.values and not table.of_lands:
        return Sentence("no measured diameter by its headings")
    for title in titles:
        words = letters(title)
        counted = summary_of(title.partition(" ")[0]) in ("count", "spread") and words.any("diameter")
        by_gauge = part_in(title) is not None and table.of("component")  # "Bores, bore gauge" are measured with one
        of_gauge = words.any("calibration") and not by_gauge
        if counted or ((of_gauge or words.any("specification_title")) and not words.any("of_reading", "error")):
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
        text = line_of(sheet, row)
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
        for place, row in enumerate(rows):
            if len(rows) >= 2 * (len(found) + len(rows) - place):
                break  # no more can become most
            component = (read_label(row[index] if index < len(row) else "", names) or {}).get("component", "")
            planes = {(component, plane) for land in names.controller.lands_of(component) for plane in land.planes}
            of = {at for at in planes if any(sizes.near_plane(size, UNITS, *at) for size in _exact(row))}
            near |= of
            found += [component] if of else []
        if 2 * len(found) > len(rows) and len(near) >= least and (len(near) > 1 or any(map(str.isalpha, found[0]))):
            return True
    return False


def _exact(row: Sequence[Cell]) -> Iterator[float]:
    return (value for cell in row if not is_whole(cell) for value in numbers_of(cell))


# --- which tables are the measurement, and whether they are one


@dataclass(eq=False)
class _SheetTables:
    sheet: Sheet
    tables: list[HeadedTable]

    @property
    def readable(self) -> list[HeadedTable]:
        return [table for table in self.tables if table.readable]

    @property
    def of_lands(self) -> list[HeadedTable]:
        return [table for table in self.tables if table.is_of_lands]

    @property
    def is_filled(self) -> bool:
        return any(table.count_values() for table in self.readable)

    @property
    def is_of_lands(self) -> bool:
        return bool(self.of_lands) and not any(table.values for table in self.tables)


@dataclass(frozen=True)
class SheetChoice:
    """The sheets of a file, and the tables of them that are the measurement."""

    file: str
    wanted: str | None  # the sheet that is asked for
    every: Sequence[_SheetTables]
    looked_at: Sequence[_SheetTables]
    tables: Sequence[HeadedTable]  # to be read

    @property
    def sheets(self) -> list[Sheet]:
        """Return all sheets of the file as they were understood, some with rows and columns exchanged."""
        return [page.sheet for page in self.every]

    @property
    def _others(self) -> list[_SheetTables]:
        return [page for page in self.every if page not in self.looked_at and not page.sheet.hidden]

    @property
    def of_lands(self) -> list[HeadedTable]:
        """Return the tables of what lands themselves have, also of a sheet of their own beside the one asked for."""
        beside = (page for page in self._others if page.is_of_lands)
        return [table for page in (*self.looked_at, *beside) for table in page.of_lands]

    @property
    def without_readings(self) -> list[HeadedTable]:
        """Return the other tables beside those read: left aside, or without a column that says the component."""
        every = (table for page in self.looked_at for table in page.tables)
        return [table for table in every if not table.readable and not table.is_of_lands]

    @property
    def sheets_left_aside(self) -> list[Sheet]:
        """Return the visible sheets that were not asked for."""
        return [page.sheet for page in self._others if not page.is_of_lands]

    @property
    def messages(self) -> Iterator[Message]:
        """Yield what is to be said of the choice."""
        read = [page.sheet for page in self.looked_at if page.is_filled]
        others = [page.sheet for page in self.every if page.readable and page.sheet not in read]
        names = _quoted(sheet.name for sheet in read)
        if len(read) > 1:
            text = Sentence(
                "read as one measurement from sheets {sheets}, which hold different planes or parts", sheets=names
            )
            yield Message("info", "sheets_read", text, Place(self.file))
        if others and read and self.wanted is None:
            quoted = _quoted(sheet.name for sheet in others)
            text = Sentence("read from sheet {sheets}; left aside: {others}", sheets=names, others=quoted)
            yield Message("info", "sheet_chosen", text, Place(self.file, read[0].name))
        for sheet in read:
            if sheet.turned:
                text = Sentence(
                    "the headings run down the first column: read with rows and columns exchanged, so where a message "
                    "says 'row' of readings, it is a column of the sheet"
                )
                yield Message("info", "sheet_turned", text, Place(self.file, sheet.name))


def choose_sheet(
    sheets: Sequence[Sheet],
    file: str,
    names: ControllerNames,
    wanted: str | None,
    fill_down: bool = False,
    mapping: SheetMapping = NOTHING_SAID,
) -> SheetChoice:
    """Choose the tables to read: of the sheet that is asked for, or of every visible sheet that is filled in.

    ``fill_down`` says that empty cells of a label go on with the one above them, ``mapping`` which columns are read:
    of the sheets that have them. A `ReadingsError` says where there is
    no such sheet, none holds readings, or none is filled in.
    """
    sheets = [(mapping.down and turned(sheet)) or sheet for sheet in sheets]
    mapped = _mapped(sheets, wanted, mapping)
    every = [
        _SheetTables(sheet, mapped_tables(sheet, mapping, names))
        if sheet in mapped
        else _the_right_way_round(sheet, names, mapping)
        for sheet in sheets
    ]
    if wanted is not None and any(sheet.name is not None for sheet in sheets):
        looked_at = [_wanted(every, file, wanted)]
    elif mapped:
        looked_at = [page for page in every if page.sheet in mapped]
    else:
        filled = [page for page in every if page.is_filled]
        # hidden sheets are read only where no visible sheet is filled in
        shown = [page for page in filled if not page.sheet.hidden] or filled
        looked_at = [page for page in every if page in shown or not page.sheet.hidden]
    readable = [table for page in looked_at for table in page.readable]
    if not readable:
        raise _no_readings(every, file)
    return SheetChoice(file, wanted, every, looked_at, [filled_down(table, fill_down) for table in readable])


def _mapped(sheets: Sequence[Sheet], wanted: str | None, mapping: SheetMapping) -> list[Sheet]:
    if not mapping:
        return []
    asked = [sheet for sheet in sheets if (not sheet.hidden if wanted is None else sheet.name in (wanted, None))]
    fitting = [sheet for sheet in asked if mapping.fits(sheet)]
    if asked and not fitting:
        raise mapping.not_found(asked)
    return fitting


def _the_right_way_round(sheet: Sheet, names: ControllerNames, said: SheetMapping) -> _SheetTables:
    """Return a sheet with its tables, turned where its headings run down the first column."""
    upright = _SheetTables(sheet, find_tables(sheet, names, said))
    if own_form_of(sheet) is not None or any(
        (table.of("component") or table.component or _is_block(table))
        and any(column.holds_size for column in table.columns)
        for table in upright.tables
    ):
        return upright
    around = turned(sheet)
    sideways = None if around is None else _SheetTables(around, find_tables(around, names, said))
    return sideways if sideways is not None and sideways.is_filled else upright


def _is_block(table: HeadedTable) -> bool:
    return any(not unit_of_heading(column.heading)[0] for column in table.of("part"))


def _quoted(names: Iterable[str | None]) -> tuple[str, ...]:
    return tuple(map(repr, names))


def _wanted(every: Sequence[_SheetTables], file: str, wanted: str) -> _SheetTables:
    by_name = {page.sheet.name: page for page in every if page.sheet.name is not None}
    if wanted not in by_name:
        raise unknown(
            Sentence("the workbook has no such sheet"), wanted, by_name, kind=ReadingsError, place=Place(file)
        )
    chosen = by_name[wanted]
    if not chosen.readable:
        chosen.tables = [replace(table, left_aside=None) if table.values else table for table in chosen.tables]
    if not chosen.readable:
        usable = [name for name, page in by_name.items() if page.readable]
        problem = Sentence("this sheet holds no readings")
        if usable:
            problem = Sentence("this sheet holds no readings; readings are in sheet {sheets}", sheets=_quoted(usable))
        raise ReadingsError(problem, place=Place(file, wanted), expected=EXPECTED_SHEET)
    return chosen


def _no_readings(every: Sequence[_SheetTables], file: str) -> ReadingsError:
    sheets = [page.sheet for page in every]
    if not any(str(cell).strip() for sheet in sheets for row in sheet.rows for cell in row):
        return ReadingsError(
            Sentence("the workbook is empty"), place=Place(file), expected=Sentence("a measuring sheet filled in")
        )
    tables = [table for page in every for table in page.tables]
    for table in tables:
        if table.left_aside and table.values and table.of("component"):
            problem = Sentence("the table in {where} is left aside ({why}), and there is no other")
            return which_columns(
                problem.of(where=table.where, why=table.left_aside),
                table.sheet.place(max(table.first, 0)),
                expected=Sentence("a title that says 'measured' where these are the readings"),
            )
    headers = [*tables, *filter(None, map(best_header, sheets))]
    if headers:
        return _incomplete(max(headers, key=lambda table: table.score))
    names = [sheet.name for sheet in sheets if sheet.name is not None]
    problem = Sentence("no row of headings found: not a measuring sheet?")
    if len(names) > 1:
        problem = Sentence(
            "no row of headings found in any of the sheets {sheets}: not a measuring sheet?", sheets=_quoted(names)
        )
    place = Place(file, sheets[0].name if len(sheets) == 1 else None)
    return which_columns(problem, place)


def _incomplete(table: HeadedTable) -> ReadingsError:
    lacking = (
        (Sentence("component"), table.of("component")),
        (Sentence("diameter, or coordinate x1 and coordinate x2"), table.values),
    )
    missing = [what for what, there in lacking if not there]
    problem = Sentence("this row holds headings and readings as well")
    if missing:
        both = Sentence("{first} nor for {second}", first=missing[0], second=missing[-1])
        problem = Sentence("no heading for {what}", what=both if len(missing) > 1 else missing[0])
    others = [column.name for column in (*table.of("specification"), *table.of("mean"))]
    if others and not table.values:
        template = Sentence("{problem}: what a diameter should be or was, and a mean, is no measurement ({headings})")
        problem = template.of(problem=problem, headings=_quoted(others))
    value = ", ".join(repr(column.name) for column in table.columns)
    return which_columns(problem, table.sheet.place(table.last), value)


def require_one_measurement(read: Sequence[SheetRows], file: str) -> list[ReadingsError]:
    """Return the problems where two tables of a sheet hold the same diameters and nothing calls them repeats.

    A `ReadingsError` asks where two sheets do: which is meant, only the user knows.
    """
    problems: list[ReadingsError] = []
    first: dict[tuple[str, Part, str], list[tuple[SheetRows, PlaceKey]]] = defaultdict(list)
    asked: dict[str | None, None] = {}
    reported: set[tuple[int, int]] = set()
    for rows in read:
        if len(problems) > FAULTS:
            break
        if is_repeat_title(rows.table.title):
            continue
        sheet = rows.table.sheet.name
        mine: dict[object, PlaceKey] = {}
        for entry in rows.entries:
            key = entry.key
            place = key.component, key.part, key.plane
            for other, earlier in first[place]:
                if None not in (key.direction, earlier.direction) and key.direction != earlier.direction:
                    continue
                if sheet != other.table.sheet.name:
                    asked.update({other.table.sheet.name: None, sheet: None})
                elif not (key.explicit and earlier.explicit) and (id(other), id(rows)) not in reported:
                    reported.add((id(other), id(rows)))
                    problems.append(_twice(rows, other, key, entry.raw.place))
            mine.setdefault((place, key.direction, key.explicit), key)
        for key in mine.values():
            first[key.component, key.part, key.plane].append((rows, key))
    if asked:
        error = ReadingsError(
            Sentence("{count} sheets hold readings of the same planes", count=len(asked)),
            place=Place(file),
            value=", ".join(_quoted(asked)),
            expected=Sentence("one: say which sheet, or delete the others"),
        )
        error.role = COLUMNS  # each may be of a valve that its name does not tell
        raise error
    return problems


def _twice(rows: SheetRows, other: SheetRows, key: PlaceKey, place: Place) -> ReadingsError:
    problem = Sentence(
        "component {component}, {part}, plane {plane} stands in this table and in the one in {where} already: "
        "repeats, or two states?"
    )
    return ReadingsError(
        problem.of(component=key.component, part=PART_WORDS[key.part], plane=key.plane, where=other.table.where),
        place=place,
        expected=Sentence("a column 'repeat' in both, or only the table that is meant"),
    )
