"""Which tables of which sheets are the measurement, and whether they are one."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from atleak.catalogue.instruments import Part
from atleak.catalogue.words import PART_WORDS
from atleak.common.errors import Message, Place, ReadingsError, unknown
from atleak.common.sentences import Sentence
from atleak.readers.cells.extent import FAULTS
from atleak.readers.cells.sheet import Sheet
from atleak.readers.own_forms import own_form_of
from atleak.readers.sheets.controller_names import ControllerNames
from atleak.readers.sheets.diameters import PlaceKey, filled_down
from atleak.readers.sheets.layout import find_tables, mapped_tables, turned
from atleak.readers.sheets.mapping import NOTHING_SAID, SheetMapping
from atleak.readers.sheets.rows import SheetRows
from atleak.readers.sheets.table import EXPECTED_SHEET, HeadedTable, best_header, which_columns
from atleak.readers.sheets.words import is_repeat_title


@dataclass(eq=False)
class _SheetTables:
    """A sheet as it was understood, and its tables."""

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
        """Return whether it holds what lands themselves have, and no diameters."""
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
        else _the_right_way_round(sheet, names)
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
    """Return the sheets whose columns a person named: the one asked for, or the visible ones that have them."""
    if not mapping:
        return []
    asked = [sheet for sheet in sheets if (not sheet.hidden if wanted is None else sheet.name in (wanted, None))]
    fitting = [sheet for sheet in asked if mapping.fits(sheet)]
    if asked and not fitting:
        raise mapping.not_found(asked)
    return fitting


def _the_right_way_round(sheet: Sheet, names: ControllerNames) -> _SheetTables:
    """Return a sheet with its tables, turned where its headings run down the first column."""
    upright = _SheetTables(sheet, find_tables(sheet, names))
    if own_form_of(sheet) is not None or any(
        table.of("component") and any(column.holds_size for column in table.columns) for table in upright.tables
    ):
        return upright
    around = turned(sheet)
    sideways = None if around is None else _SheetTables(around, find_tables(around, names))
    return sideways if sideways is not None and sideways.is_filled else upright


def _quoted(names: Iterable[str | None]) -> tuple[str, ...]:
    return tuple(map(repr, names))


def _wanted(every: Sequence[_SheetTables], file: str, wanted: str) -> _SheetTables:
    """Return the sheet that is asked for; its name alone does not leave its tables aside."""
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
    """Return why a table cannot be read whose headings are the best of the file, and what may be meant by them."""
    missing = [] if table.of("component") else [Sentence("component")]
    missing += [] if table.values else [Sentence("diameter, or coordinate x1 and coordinate x2")]
    problem = Sentence("this row holds headings and readings as well")
    if missing:
        what = missing[0]
        if len(missing) > 1:
            what = Sentence("{first} nor for {second}", first=missing[0], second=missing[1])
        problem = Sentence("no heading for {what}", what=what)
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
        raise ReadingsError(
            Sentence("{count} sheets hold readings of the same planes", count=len(asked)),
            place=Place(file),
            value=", ".join(_quoted(asked)),
            expected=Sentence("one: say which sheet, or delete the others"),
        )
    return problems


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
