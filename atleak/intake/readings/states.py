"""Whether readings of one station are repeats, or two states of the same valve body that must not be averaged."""

from __future__ import annotations

import datetime
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from atleak.catalogue.controller import Controller
from atleak.catalogue.instruments import Part
from atleak.errors import Message, Place, ReadingsError, unknown
from atleak.intake.readings.columns import Columns
from atleak.intake.readings.headings import Header
from atleak.intake.readings.sheet_tables import Table
from atleak.intake.readings.values import DiameterCell
from atleak.intake.readings.words import (
    PERSONS,
    STATES,
    is_blank,
    is_repeat_title,
    is_state,
    letters,
    plain,
    text_of,
    vocabulary,
)
from atleak.intake.sheets.sheet import Cell, Sheet, rows_named
from atleak.intake.units import find_unit
from atleak.phrases import PART_WORDS, angle
from atleak.sentence import Sentence
from atleak.unit_systems import Quantity
from atleak.workshop_units import UM

_TIME = re.compile(r"[T ,]+\d{1,2}:\d{2}(:\d{2})?(\.\d+)?\s*([ap]m)?$", re.IGNORECASE)
_LISTED = 4  # values of a column that are named
_FEWEST = 2  # rows that make a block
_AS_ONE = 3e-6  # [m] within which rows that return pass for repeats without a warning: choice of this project
_NO_REMARK = Sentence("the remark 'rejected', and nothing else, in the rows that do not count; or without these rows")
_COUNTING = vocabulary("repeat", "reading", "number", "generic")

StationKey = tuple[str, Part, str, float | None, bool, int | None]
Splits = Mapping[StationKey, Mapping[str, list[int]]]  # values of a column, and in which rows each stands


@dataclass(frozen=True)
class Break:
    """A row between readings: a title, or the headings printed again."""

    row: int
    title: str  # "" for headings


def question(
    entries: Sequence[DiameterCell], breaks: Sequence[Break], table: Table, columns: Columns
) -> ReadingsError | None:
    """Return an error where the same stations come in two states and no column counts repeats."""
    sheet, header = table.sheet, table.header
    several = _several(entries)
    if not several:
        return None
    place = sheet.place(max(header.last, 0))
    remarks = {column.index for column in header.of("remark")}
    for index, splits in _splitting(several, sheet, header, columns):
        heading = header.text(index)
        named = Sentence("column {heading!r}", heading=heading) if heading else Sentence("a column without heading")
        values = _values(splits)
        station = next(iter(splits))
        rows = sorted(row for same_value in splits[station].values() for row in same_value)
        return ReadingsError(
            Sentence(
                "{column} tells states apart that would be averaged as repeats: {station} stands in {rows}{also}",
                column=named,
                station=_name(station),
                rows=rows_named(sheet, rows),
                also=_also(len(splits)),
            ),
            place=sheet.place(max(header.last, 0), index, heading),
            value=", ".join(values[:_LISTED]) + (" …" if len(values) > _LISTED else ""),
            expected=Sentence(
                "{which}; or, if they are repeats, a column 'Repeat' with 1, 2 …",
                which=_NO_REMARK if index in remarks else _which_rows(heading, values[0]),
            ),
        )
    return _blocks(entries, breaks, sheet, place)


def _several(entries: Sequence[DiameterCell]) -> dict[StationKey, list[int]]:
    """Return the stations that stand in more than one row, and these rows."""
    rows: dict[StationKey, dict[int, None]] = defaultdict(dict)
    for entry in entries:
        rows[_station(entry)][entry.row] = None
    return {station: list(each) for station, each in rows.items() if len(each) > 1}


def _station(entry: DiameterCell) -> StationKey:
    key = entry.key
    return key.component, key.part, key.plane, key.direction, key.unworn, key.repeat


def _name(station: StationKey) -> Sentence:
    component, part, plane, direction, unworn, repeat = station
    return Sentence(
        "component {component}, {part}, plane {plane}{direction}{end}{repeat}",
        component=component,
        part=PART_WORDS[part],
        plane=plane,
        direction=angle(direction),
        end=Sentence(", unworn end") if unworn else "",
        repeat="" if repeat is None else Sentence(", repeat {repeat},", repeat=repeat),
    )


def _also(stations: int) -> Sentence | str:
    if stations > 2:
        return Sentence(", and so do {count} more", count=stations - 1)
    return Sentence(", and so does 1 more") if stations == 2 else ""


def _which_rows(heading: str, value: str) -> Sentence:
    if not heading:
        return Sentence("a heading over that column, and which of its rows to read, as in --where Inspection=May")
    return Sentence("which rows to read, as in --where {chosen}", chosen=_quoted(f"{heading}={value}"))


def _quoted(text: str) -> str:
    return f'"{text}"' if re.search(r"[^\w=.:/+-]", text) else text


# --- columns ----------------------------------------------------------------------------------------------------------


def _splitting(
    several: Mapping[StationKey, Sequence[int]], sheet: Sheet, header: Header, columns: Columns
) -> Iterator[tuple[int, Splits]]:
    """Yield unread columns whose values separate the rows of one station; the surest first."""
    candidates: list[tuple[int, int, Splits]] = []
    for index in range(sheet.width):
        if index in columns.read:
            continue
        heading = header.text(index)
        words = set(letters(heading))
        if words & PERSONS or (has_length(heading) and not words & STATES):
            continue
        splits: dict[StationKey, dict[str, list[int]]] = {}
        for station, rows in several.items():
            values: dict[str, list[int]] = defaultdict(list)
            for row in rows:
                cell = sheet.filled(row, index)
                if not is_blank(cell):
                    values[_day(cell)].append(row)
            if len(values) > 1:
                splits[station] = values
        if not splits:
            continue
        if words & STATES:
            candidates.append((0, index, splits))
        elif all(
            is_state(sheet.filled(row, index)) for each in splits.values() for rows in each.values() for row in rows
        ):
            candidates.append((1, index, splits))
        elif len(splits) == len(several) >= _FEWEST and _same_everywhere(splits, heading):
            candidates.append((2, index, splits))
    for _, index, surest in sorted(candidates, key=lambda each: each[:2]):
        yield index, surest


def _day(cell: Cell) -> str:
    """Return a cell as a label; of a moment only the day, because repeats are taken minutes apart."""
    if isinstance(cell, datetime.datetime):
        return cell.date().isoformat()
    return _TIME.sub("", text_of(cell))


def _values(splits: Splits) -> list[str]:
    return list(dict.fromkeys(value for each in splits.values() for value in each))


def _same_everywhere(splits: Splits, heading: str) -> bool:
    """Return whether every station has the same values, and they are not 1, 2 … under no word for anything else."""
    sets = {frozenset(map(plain, values)) for values in splits.values()}
    if len(sets) > 1:
        return False
    values = _values(splits)
    if all(is_repeat_title(value) for value in values):
        return False
    words = letters(heading)
    if words and not any(word in _COUNTING for word in words):
        return True
    return sorted(value.strip(".) ") for value in values) != [str(number + 1) for number in range(len(values))]


# --- blocks -----------------------------------------------------------------------------------------------------------


def _blocks(
    entries: Sequence[DiameterCell], breaks: Sequence[Break], sheet: Sheet, place: Place
) -> ReadingsError | None:
    """Return an error where stations return under another title or under the headings printed again."""
    last: dict[StationKey, int] = {}
    waiting = list(breaks)
    title, first = "", -1
    apart: Break | None = None
    before: list[StationKey] = []
    row = -1
    for entry in entries:
        if entry.row != row:
            passed = []
            while waiting and waiting[0].row < entry.row:
                passed.append(waiting.pop(0))
            if passed:
                title = next((each.title for each in reversed(passed) if each.title), "")
                apart, first = passed[0], entry.row
                before = [station for station, at in last.items() if at == row]
            row = entry.row
        station = _station(entry)
        earlier = last.get(station)
        if apart is not None and earlier is not None and earlier < first and not is_repeat_title(title):
            if station in before and not title:  # repeats of one station, over the end of a page
                before = [each for each in before if each != station]
            else:
                return ReadingsError(
                    Sentence(
                        "{station} stands in row {earlier} and returns in row {row}, under {title}: two states would "
                        "be averaged as repeats",
                        station=_name(station),
                        earlier=sheet.row_number(earlier),
                        row=sheet.row_number(row),
                        title=repr(title) if title else Sentence("headings of its own"),
                    ),
                    place=sheet.place(row),
                    value=title or None,
                    expected=Sentence(
                        "one state of the valve body: delete the other rows or hide them; or, if they are repeats, a "
                        "column 'Repeat' with 1, 2 …"
                    ),
                )
        last[station] = row
    return None


def messages(
    entries: Sequence[DiameterCell], table: Table, columns: Columns, controller: Controller
) -> Iterator[Message]:
    """Yield blocks that return with the same values, and repeats that another column calls states."""
    sheet, header = table.sheet, table.header
    yield from _pasted_twice(entries, sheet, numbered=columns.repeat is not None)
    if columns.repeat is None:
        yield from _returning(entries, sheet, controller)
        yield from _remarks(_several(entries), sheet, header)
        return
    rows: dict[StationKey, dict[int, None]] = defaultdict(dict)
    for entry in entries:
        rows[*_station(entry)[:5], None][entry.row] = None
    several = {station: list(each) for station, each in rows.items() if len(each) > 1}
    for index, splits in _splitting(several, sheet, header, columns):
        if set(letters(header.text(index))) & STATES:
            yield Message(
                "warning",
                "repeats_of_several_states",
                Sentence(
                    "column {heading!r} calls them repeats, so rows are averaged that column {other!r} tells apart "
                    "({values})",
                    heading=columns.repeat.heading,
                    other=header.text(index),
                    values=_values(splits)[:_LISTED],
                ),
                sheet.place(max(header.last, 0), index, header.text(index)),
            )
            return


def _pasted_twice(entries: Sequence[DiameterCell], sheet: Sheet, *, numbered: bool) -> Iterator[Message]:
    """Yield a warning for the first block of rows that repeats the readings of rows above in the same order.

    Where repeats are numbered, one part measured a second time may well give the same: only a block of several tells.
    """
    seen: dict[object, int] = {}
    runs: list[list[tuple[int, int]]] = []
    rows: dict[int, list[tuple[tuple[object, ...], float, int]]] = defaultdict(list)
    for entry in entries:
        rows[entry.row].append((_station(entry)[:5], entry.raw.size, entry.column))
    order = list(rows)
    for at, row in enumerate(order):
        earlier = seen.setdefault(tuple(rows[row]), at)
        if earlier == at:
            continue
        if runs and runs[-1][-1] == (earlier - 1, at - 1):
            runs[-1].append((earlier, at))
        else:
            runs.append([(earlier, at)])
    for run in runs:
        stations = {entry[0] for earlier, _ in run for entry in rows[order[earlier]]}
        told = {station[:2] for station in stations} if numbered else stations  # parts of components
        if len(run) >= _FEWEST and len(told) >= _FEWEST and run[0][1] > run[-1][0]:
            again, first = ([order[pair[which]] for pair in run] for which in (1, 0))
            yield Message(
                "warning",
                "block_repeated",
                Sentence(
                    "{again} hold the same readings in the same order as {first}: pasted twice? They count as repeats",
                    again=rows_named(sheet, again),
                    first=rows_named(sheet, first),
                ),
                sheet.place(again[0]),
            )
            return


def _returning(entries: Sequence[DiameterCell], sheet: Sheet, controller: Controller) -> Iterator[Message]:
    """Yield a message where stations come again after others, and nothing on the sheet calls them repeats."""
    last: dict[StationKey, int] = {}
    order = {row: at for at, row in enumerate(dict.fromkeys(entry.row for entry in entries))}
    back = []
    for entry in entries:
        station = _station(entry)
        if station in last and order[entry.row] > order[last[station]] + 1:
            back.append((last[station], entry.row, station))
        last[station] = entry.row
    if back:
        earlier, row, station = back[0]
        stations: dict[StationKey, list[DiameterCell]] = defaultdict(list)
        for entry in entries:
            stations[_station(entry)].append(entry)
        largest = max(_spread(stations[each], each, controller) for each in {station for *_, station in back})
        differ = Sentence(", up to {apart} {apart.unit} apart", apart=Quantity(largest * UM, "clearance"))
        apart = any(all(is_blank(cell) for cell in sheet.rows[between]) for between in range(earlier, row))
        yield Message(
            "warning" if apart or largest > _AS_ONE else "info",
            "rows_as_repeats",
            Sentence(
                "{station} stands in row {earlier} and again in row {row}{also}{behind}{differ}: counted as repeats",
                station=_name(station),
                earlier=sheet.row_number(earlier),
                row=sheet.row_number(row),
                also=_also(len({each[2] for each in back})),
                behind=Sentence(", behind an empty row") if apart else "",
                differ=differ if largest > _AS_ONE else "",
            ),
            sheet.place(row),
        )


def _spread(entries: Sequence[DiameterCell], station: StationKey, controller: Controller) -> float:
    """Return how far the diameters of a station are apart [m], by the nominal one: the unit may not be known yet."""
    sizes = [each.raw.unit.to_si(each.raw.size) if each.raw.unit else each.raw.size for each in entries]
    land = controller.land_of_plane(station[0], station[2])
    return 0.0 if land is None else (max(sizes) / min(sizes) - 1.0) * land.nominal_diameter


def _remarks(several: Mapping[StationKey, Sequence[int]], sheet: Sheet, header: Header) -> Iterator[Message]:
    """Yield a warning where remarks differ between rows of one station that nothing calls repeats."""
    for column in header.of("remark"):
        for station, rows in several.items():
            remarks = {row: text_of(cell) for row in rows if isinstance(cell := sheet.filled(row, column.index), str)}
            texts = [text for text in dict.fromkeys(remarks.values()) if letters(text)]
            if texts and len(set(remarks.values())) > 1:
                yield Message(
                    "warning",
                    "remarks_differ",
                    Sentence(
                        "{station} stands in {rows}, counted as repeats, though remarks tell them apart: {remarks}",
                        station=_name(station),
                        rows=rows_named(sheet, rows),
                        remarks=tuple(repr(text[:60]) for text in texts[:_LISTED]),
                    ),
                    sheet.place(rows[0], column.index, column.name),
                )


# --- what to read -----------------------------------------------------------------------------------------------------


def rows_left_out(table: Table, where: Mapping[str, str]) -> frozenset[int]:
    """Return the rows without the values that ``where`` asks for under its headings, where a table has them."""
    cells = table.sheet.filled
    return frozenset(
        row
        for heading, wanted in where.items()
        if (index := _headed(table, heading)) is not None
        for row in table.rows
        if not _matches(cells(row, index), wanted)
    )


def require_known(tables: Sequence[Table], where: Mapping[str, str]) -> None:
    """Check that every heading of ``where`` is that of a column, and what it asks for stands under it.

    Raises
    ------
    ReadingsError
        naming the headings, or the values of the column.
    """
    for heading, wanted in where.items():
        headed = [(table, index) for table in tables if (index := _headed(table, heading)) is not None]
        if not headed:
            texts = [text for table in tables for each in table.header.texts if (text := " ".join(each.split()))]
            place = tables[0].sheet.place(max(tables[0].header.last, 0))
            raise unknown(
                Sentence("no column is headed {heading!r}", heading=heading),
                heading,
                texts,
                kind=ReadingsError,
                place=place,
            )
        cells = [table.sheet.filled(row, index) for table, index in headed for row in table.rows]
        if not any(_matches(cell, wanted) for cell in cells):
            known = [_day(cell) for cell in cells if not is_blank(cell)]
            table, index = headed[0]
            place = table.sheet.place(max(table.header.last, 0), index, table.heading(index))
            problem = Sentence("no row has {wanted!r} there", wanted=wanted)
            raise unknown(problem, wanted, known, kind=ReadingsError, place=place)


def _headed(table: Table, heading: str) -> int | None:
    return next((index for index in table.columns if plain(table.heading(index)) == plain(heading)), None)


def _matches(cell: Cell, wanted: str) -> bool:
    if is_blank(cell):
        return False
    spellings = {plain(text_of(cell)), plain(_day(cell))}
    if isinstance(cell, datetime.date):
        spellings |= {f"{cell:%d.%m.%Y}", f"{cell:%d/%m/%Y}", f"{cell:%m/%d/%Y}", str(cell)}
    return plain(wanted) in spellings or plain(wanted).replace(",", ".") in spellings


def has_length(heading: str) -> bool:
    """Return whether a heading names a unit of length that a diameter or a clearance may stand in."""
    bracketed = re.search(r"[\[\(]([^\[\]\(\)]+)[\]\)]", heading)
    return bracketed is not None and find_unit(bracketed[1], "length") is not None and "km" not in bracketed[1]
