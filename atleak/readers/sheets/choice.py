"""Which tables of which sheets are the measurement, and whether they are one."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from atleak.catalogue.instruments import Part
from atleak.catalogue.words import PART_WORDS
from atleak.common.errors import Message, Place, ReadingsError, unknown
from atleak.common.sentences import Sentence
from atleak.readers.cells.extent import FAULTS
from atleak.readers.cells.sheet import Sheet
from atleak.readers.sheets.controller_names import ControllerNames, Sizes
from atleak.readers.sheets.diameters import PlaceKey, filled_down
from atleak.readers.sheets.layout import continued, find_tables, turned
from atleak.readers.sheets.rows import SheetRows
from atleak.readers.sheets.table import EXPECTED_SHEET, HeadedTable, best_header
from atleak.readers.sheets.words import is_repeat_title, letters


@dataclass(frozen=True)
class SheetChoice:
    """The tables to read, those beside them that hold no readings, and the sheets that were not asked for.

    ``sheets`` are all of the file as they were understood, some with rows and columns exchanged.
    ``of_lands`` hold what lands themselves have, also on a sheet of their own beside the one asked for. ``doubtful``
    hold values of which no column says the component.
    """

    sheets: tuple[Sheet, ...]
    tables: tuple[HeadedTable, ...]
    of_lands: tuple[HeadedTable, ...]
    doubtful: tuple[HeadedTable, ...]
    aside: tuple[HeadedTable, ...]
    sheets_aside: tuple[Sheet, ...]
    messages: tuple[Message, ...]


def choose_sheet(
    sheets: Sequence[Sheet], file: str, names: ControllerNames, wanted: str | None, fill_down: bool = False
) -> SheetChoice:
    """Choose the tables to read: of the sheet that is asked for, or of every visible sheet that is filled in.

    ``fill_down`` says that empty cells of a label go on with the one above them.

    Raises
    ------
    ReadingsError
        where there is no such sheet, none holds readings, or none is filled in.
    """
    understood = [_the_right_way_round(sheet, names) for sheet in sheets]
    sheets, tables = [sheet for sheet, _ in understood], {sheet.name: found for sheet, found in understood}
    for before, sheet in pairwise(sheets):
        readable = [table for table in tables[before.name] if table.readable]
        if not tables[sheet.name] and readable and (more := continued(sheet, readable[-1], names)) is not None:
            tables[sheet.name] = [more]
    if wanted is not None and any(sheet.name is not None for sheet in sheets):
        looked_at = [_wanted(sheets, tables, file, wanted)]
        tables[wanted] = _unless_none(tables[wanted])
    else:
        filled = [sheet for sheet in sheets if any(_is_filled(table) for table in tables[sheet.name])]
        # hidden sheets are read only where no visible sheet is filled in
        shown = [sheet for sheet in filled if not sheet.hidden] or filled
        looked_at = [sheet for sheet in sheets if sheet in shown or not sheet.hidden]
    every = [table for sheet in looked_at for table in tables[sheet.name]]
    readable = [table for table in every if table.readable]
    if not readable:
        raise _no_readings(sheets, tables, file, names)
    others = [sheet for sheet in sheets if sheet not in looked_at and not sheet.hidden]
    beside = [sheet for sheet in others if not any(table.values for table in tables[sheet.name])]
    of_lands = [table for table in every if table.is_of_lands]
    of_lands += [table for sheet in beside for table in tables[sheet.name] if table.is_of_lands]
    with_lands = {table.sheet.name for table in of_lands}
    rest = [table for table in every if not table.readable and not table.is_of_lands]
    read_names = {table.sheet.name for table in readable if _is_filled(table)}
    read = [sheet for sheet in sheets if sheet.name in read_names]
    unread = [sheet for sheet in sheets if sheet not in read and any(table.readable for table in tables[sheet.name])]
    return SheetChoice(
        sheets=tuple(sheets),
        tables=tuple(filled_down(table, fill_down) for table in readable),
        of_lands=tuple(of_lands),
        doubtful=tuple(table for table in rest if not table.aside),
        aside=tuple(table for table in rest if table.aside),
        sheets_aside=tuple(sheet for sheet in others if sheet.name not in with_lands),
        messages=tuple(_about_sheets(file, read, unread, wanted)),
    )


def _the_right_way_round(sheet: Sheet, names: ControllerNames) -> tuple[Sheet, list[HeadedTable]]:
    """Return a sheet with its tables, turned where its headings run down the first column."""
    tables = find_tables(sheet, names)
    if any(table.of("component") and any(each.holds_size for each in table.columns) for table in tables):
        return sheet, tables
    around = turned(sheet, names)
    tables_around = [] if around is None else find_tables(around, names)
    if around is None or not any(_is_filled(table) for table in tables_around):
        return sheet, tables
    return around, tables_around


def _is_filled(table: HeadedTable) -> bool:
    return table.readable and table.count_values() > 0


def _about_sheets(file: str, read: Sequence[Sheet], unread: Sequence[Sheet], wanted: str | None) -> Iterator[Message]:
    names, others = (_quoted(sheet.name for sheet in sheets) for sheets in (read, unread))
    if len(read) > 1:
        text = Sentence(
            "read as one measurement from sheets {sheets}, which hold different planes or parts", sheets=names
        )
        yield Message("info", "sheets_read", text, Place(file))
    if unread and read and wanted is None:
        text = Sentence("read from sheet {sheets}; left aside: {others}", sheets=names, others=others)
        yield Message("info", "sheet_chosen", text, Place(file, read[0].name))
    for sheet in read:
        if sheet.turned:
            text = Sentence(
                "the headings run down the first column: read with rows and columns exchanged, so where a message says "
                "'row' of readings, it is a column of the sheet"
            )
            yield Message("info", "sheet_turned", text, Place(file, sheet.name))


def _quoted(names: Iterable[str | None]) -> tuple[str, ...]:
    return tuple(map(repr, names))


def _wanted(sheets: Sequence[Sheet], tables: dict[str | None, list[HeadedTable]], file: str, wanted: str) -> Sheet:
    by_name = {sheet.name: sheet for sheet in sheets if sheet.name is not None}
    if wanted not in by_name:
        raise unknown(
            Sentence("the workbook has no such sheet"), wanted, by_name, kind=ReadingsError, place=Place(file)
        )
    if not any(table.readable for table in _unless_none(tables[wanted])):
        usable = [name for name in by_name if any(table.readable for table in tables[name])]
        problem = Sentence("this sheet holds no readings")
        if usable:
            problem = Sentence("this sheet holds no readings; readings are in sheet {sheets}", sheets=_quoted(usable))
        raise ReadingsError(problem, place=Place(file, wanted), expected=EXPECTED_SHEET)
    return by_name[wanted]


def _unless_none(tables: list[HeadedTable]) -> list[HeadedTable]:
    """Return the tables of a sheet that was asked for; its name alone does not leave them aside."""
    if any(table.readable for table in tables):
        return tables
    return [replace(table, aside=None) if table.values else table for table in tables]


def _no_readings(
    sheets: Sequence[Sheet], tables: dict[str | None, list[HeadedTable]], file: str, known: ControllerNames
) -> ReadingsError:
    if not any(any(any(str(cell).strip() for cell in row) for row in sheet.rows) for sheet in sheets):
        return ReadingsError(
            Sentence("the workbook is empty"), place=Place(file), expected=Sentence("a measuring sheet filled in")
        )
    all_tables = [table for listed in tables.values() for table in listed]
    put_aside = [table for table in all_tables if table.aside and table.values and table.of("component")]
    if put_aside:
        table = put_aside[0]
        problem = Sentence(
            "the table in {where} is left aside ({why}), and there is no other", where=table.where, why=table.aside
        )
        place = Place(file, table.sheet.name, table.sheet.row_number(max(table.first, 0)))
        expected = Sentence("a title that says 'measured' where these are the readings")
        return ReadingsError(problem, place=place, expected=expected)
    headers = [*all_tables, *filter(None, map(best_header, sheets))]
    if headers:
        return _incomplete(max(headers, key=lambda table: table.score), Sizes(known.controller))
    names = [sheet.name for sheet in sheets if sheet.name is not None]
    problem = Sentence("no row of headings found: not a measuring sheet?")
    if len(names) > 1:
        problem = Sentence(
            "no row of headings found in any of the sheets {sheets}: not a measuring sheet?", sheets=_quoted(names)
        )
    place = Place(file, sheets[0].name if len(sheets) == 1 else None)
    return ReadingsError(problem, place=place, expected=EXPECTED_SHEET)


def _incomplete(table: HeadedTable, sizes: Sizes) -> ReadingsError:
    """Return why a table cannot be read whose headings are the best of the file, and what may be meant by them."""
    missing = [] if table.of("component") else [Sentence("component")]
    missing += [] if table.values else [Sentence("diameter, or coordinate x1 and coordinate x2")]
    problem = Sentence("this row holds headings and readings as well")
    if missing:
        what = missing[0]
        if len(missing) > 1:
            what = Sentence("{first} nor for {second}", first=missing[0], second=missing[1])
        problem = Sentence("no heading for {what}", what=what)
    others = [column.name for column in table.of("specification")]
    headings = [table.heading(index) for index in range(table.sheet.width)]
    beside = [text for text in headings if letters(text).any("deviation") and text not in others]
    means = [column.name for column in table.of("mean")]
    for said, template in (
        (others, Sentence("{problem}: what a diameter should be, or was, is no measurement ({headings})")),
        (
            beside if others else [],
            Sentence(
                "{problem}. No deviations of diameters were understood under {headings}: beside a nominal one those "
                "are that say no more than part, direction or repeat"
            ),
        ),
        (means, Sentence("{problem}. Means are no readings ({headings})")),
        (
            _of_size(table, sizes),
            Sentence(
                "{problem}. Numbers of that size stand under {headings}: more words there than a part, land, "
                "direction or repeat"
            ),
        ),
    ):
        if said and not table.values:
            problem = template.of(problem=problem, headings=_quoted(said))
    value = ", ".join(repr(column.name) for column in table.columns)
    return ReadingsError(problem, place=table.sheet.place(table.last), value=value, expected=EXPECTED_SHEET)


def _of_size(table: HeadedTable, sizes: Sizes) -> list[str]:
    """Return the headings that say nothing known, and under which most numbers are of the size of a diameter."""
    headed = (index for index in range(table.sheet.width) if table.role(index) in (None, "quantity"))
    found = [table.heading(index) for index in headed if sizes.fill(table.cells(index).values())]
    return list(filter(None, found))


def require_one_measurement(read: Sequence[SheetRows], file: str) -> list[ReadingsError]:
    """Return the problems where two tables of a sheet hold the same diameters and nothing calls them repeats.

    Raises
    ------
    ReadingsError
        where two sheets do: which is meant, only the user knows.
    """
    problems: list[ReadingsError] = []
    first: dict[tuple[str, Part, str], list[tuple[SheetRows, PlaceKey]]] = defaultdict(list)
    asked: dict[str | None, None] = {}
    reported: set[tuple[int, int]] = set()
    for before, rows in zip((None, *read), read, strict=False):
        if len(problems) > FAULTS:
            break
        if is_repeat_title(rows.table.title):
            continue
        over_the_page, sheet = _goes_on(before, rows), rows.table.sheet.name
        mine: dict[object, PlaceKey] = {}
        for entry in rows.entries:
            key = entry.key
            place = key.component, key.part, key.plane
            if entry.row == over_the_page:
                continue
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
        raise ReadingsError(
            Sentence("{count} sheets hold readings of the same planes", count=len(asked)),
            place=Place(file),
            value=", ".join(_quoted(asked)),
            expected=Sentence("one: say which sheet, or delete the others"),
        )
    return problems


def _goes_on(before: SheetRows | None, rows: SheetRows) -> int | None:
    """Return the first row under headings printed again, where it goes on with the station of the row above them."""
    if before is None or before.table.sheet.name != rows.table.sheet.name or not before.entries or not rows.entries:
        return None
    last = {entry.key for entry in before.entries if entry.row == before.entries[-1].row}
    first = {entry.key for entry in rows.entries if entry.row == rows.entries[0].row}
    return rows.entries[0].row if first == last and not rows.table.title else None


def _twice(rows: SheetRows, other: SheetRows, key: PlaceKey, place: Place) -> ReadingsError:
    return ReadingsError(
        Sentence(
            "component {component}, {part}, plane {plane} stands in this table and in the one in {where} already: "
            "repeats, or two states?",
            component=key.component,
            part=PART_WORDS[key.part],
            plane=key.plane,
            where=other.table.where,
        ),
        place=place,
        expected=Sentence("a column 'repeat' in both, or only the table that is meant"),
    )
