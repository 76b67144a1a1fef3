"""Whether readings of one station are repeats, or two states of the same valve body that must not be averaged."""

from __future__ import annotations

import datetime
import re
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from statistics import median

from atleak.catalogue.controller import Controller
from atleak.catalogue.instruments import Part
from atleak.catalogue.words import PART_WORDS, angle
from atleak.common.errors import Message, ReadingsError, unknown
from atleak.common.sentences import Option, Sentence
from atleak.common.units import UM, Quantity, find_unit
from atleak.readers.cells.sheet import Cell, Sheet, rows_named
from atleak.readers.sheets.columns import Columns
from atleak.readers.sheets.diameters import DiameterCell
from atleak.readers.sheets.table import HeadedTable
from atleak.readers.sheets.words import is_blank, is_repeat_title, is_state, letters, plain, text_of

_TIME = re.compile(r"[T ,]+\d{1,2}:\d{2}(:\d{2})?(\.\d+)?\s*([ap]m)?$", re.IGNORECASE)
_LISTED = 4  # values of a column that are named
_FEWEST = 2  # rows that make a block
_AS_ONE = 3e-6  # [m] within which rows that return pass for repeats without a warning: choice of this project
APART = 4e-4  # of a diameter: by how much its repeats may differ, 4 µm of 10 mm
_NO_REMARK = Sentence("the remark 'rejected', and nothing else, in the rows that do not count; or without these rows")
_ONE_STATE = Sentence(
    "one state of the valve body: delete the other rows or hide them; or, if they are repeats, a column 'Repeat' with "
    "1, 2 …"
)

StationKey = tuple[str, Part, str, float | None, bool, int | None]
Splits = Mapping[StationKey, Mapping[str, list[int]]]  # values of a column, and in which rows each stands
Break = tuple[int, str]  # a row between readings, and the title in it


def states_question(
    entries: Sequence[DiameterCell], breaks: Sequence[Break], table: HeadedTable, columns: Columns
) -> ReadingsError | None:
    """Return an error where the same stations come in two states and no column counts repeats."""
    sheet, several = table.sheet, _several(entries)
    for index, splits in _splitting(several, table, columns):
        heading, values, station = table.heading(index), _values(splits), next(iter(splits))
        named = Sentence("column {heading!r}", heading=heading) if heading else Sentence("a column without heading")
        which = _which_rows(heading, values[0]) if table.role(index) != "remark" else _NO_REMARK
        return ReadingsError(
            Sentence(
                "{column} tells states apart that would be averaged as repeats: {station} stands in {rows}{also}",
                column=named,
                station=_name(station),
                rows=rows_named(sheet, [row for same_value in splits[station].values() for row in same_value]),
                also=_also(len(splits)),
            ),
            place=table.heading_place(index),
            value=", ".join(values[:_LISTED]) + (" …" if len(values) > _LISTED else ""),
            expected=Sentence("{which}; or, if they are repeats, a column 'Repeat' with 1, 2 …", which=which),
        )
    return (_blocks(entries, breaks, sheet) or _apart(entries, several, table, columns)) if several else None


def _apart(
    entries: Sequence[DiameterCell], several: Collection[StationKey], table: HeadedTable, columns: Columns
) -> ReadingsError | None:
    """Return an error where most spools and most bores come more than once, too far apart for repeats of one."""
    sizes: dict[StationKey, list[float]] = defaultdict(list)
    for entry in entries if columns.repeat is None else ():
        sizes[_station(entry)].append(entry.raw.size)
    spreads: dict[Part, list[float]] = {"spool": [], "sleeve": []}
    for station in several if sizes else ():
        spreads[station[1]].append(max(sizes[station]) / min(sizes[station]) - 1.0)
    if 2 * len(several) <= len(sizes) or any(len(of) < _FEWEST or median(of) < APART for of in spreads.values()):
        return None
    problem = Sentence(
        "{count} of {all} stations stand in several rows, which are further apart than repeats and which nothing "
        "numbers: two states, two units, or two directions?"
    )
    return ReadingsError(
        problem.of(count=len(several), all=len(sizes)),
        place=table.heading_place(),
        expected=Sentence("one state of the valve body; or a column 'Repeat' with 1, 2 …, or 'Direction' with 0°, 90°"),
    )


def _several(entries: Sequence[DiameterCell], *, numbered: bool = True) -> dict[StationKey, list[int]]:
    rows: dict[StationKey, dict[int, None]] = defaultdict(dict)
    for entry in entries:
        station = _station(entry)
        rows[station if numbered else (*station[:5], None)][entry.row] = None
    return {station: list(numbers) for station, numbers in rows.items() if len(numbers) > 1}


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
        return Sentence(
            "a heading over that column, and which of its rows to read, as in {option}",
            option=Option("where", "Inspection=May"),
        )
    chosen = f"{heading}={value}"
    quoted = f'"{chosen}"' if re.search(r"[^\w=.:/+-]", chosen) else chosen
    return Sentence("which rows to read, as in {option}", option=Option("where", quoted))


def _splitting(
    several: Mapping[StationKey, Sequence[int]], table: HeadedTable, columns: Columns
) -> Iterator[tuple[int, Splits]]:
    """Yield unread columns whose values separate the rows of one station; the surest first."""
    candidates: list[tuple[int, int, Splits]] = []
    for index in range(table.sheet.width) if several else ():
        heading = table.heading(index)
        words = letters(heading)
        bracketed = re.search(r"[\[\(]([^\[\]\(\)]+)[\]\)]", heading)
        length = bracketed and find_unit(bracketed[1], "length") is not None and "km" not in bracketed[1]
        if index in columns.read or words.any("person") or (length and not words.any("state")):
            continue
        cells = table.cells(index)
        splits: dict[StationKey, dict[str, list[int]]] = {}
        for station, rows in several.items():
            values: dict[str, list[int]] = defaultdict(list)
            for row in rows:
                if row in cells:
                    values[_day(cells[row])].append(row)
            if len(values) > 1:
                splits[station] = values
        if not splits:
            continue
        if words.any("state"):
            candidates.append((0, index, splits))
        elif all(is_state(cells[row]) for by_value in splits.values() for rows in by_value.values() for row in rows):
            candidates.append((1, index, splits))
        elif len(splits) == len(several) >= _FEWEST and _same_everywhere(splits, heading):
            candidates.append((2, index, splits))
    yield from ((index, surest) for _, index, surest in sorted(candidates, key=lambda candidate: candidate[:2]))


def _day(cell: Cell) -> str:
    """Return a cell as a label; of a moment only the day, because repeats are taken minutes apart."""
    if isinstance(cell, datetime.datetime):
        return cell.date().isoformat()
    return _TIME.sub("", text_of(cell))


def _values(splits: Splits) -> list[str]:
    return list(dict.fromkeys(value for by_value in splits.values() for value in by_value))


def _same_everywhere(splits: Splits, heading: str) -> bool:
    """Return whether every station has the same values, and they are not 1, 2 … under no word for anything else."""
    sets = {frozenset(map(plain, values)) for values in splits.values()}
    if len(sets) > 1:
        return False
    values = _values(splits)
    if all(is_repeat_title(value) for value in values):
        return False
    words = letters(heading)
    if words and not words.any("repeat", "reading", "number", "generic"):
        return True
    return sorted(value.strip(".) ") for value in values) != [str(number + 1) for number in range(len(values))]


def _blocks(entries: Sequence[DiameterCell], breaks: Sequence[Break], sheet: Sheet) -> ReadingsError | None:
    last: dict[StationKey, int] = {}
    waiting = list(breaks)
    title, first = "", -1  # of the block that the entry stands in
    for entry in entries:
        while waiting and waiting[0][0] < entry.row:
            title, first = waiting.pop(0)[1], entry.row
        station = _station(entry)
        earlier = last.get(station, first)
        last[station] = entry.row
        if earlier < first and not is_repeat_title(title):
            problem = Sentence(
                "{station} stands in row {earlier} and returns in row {row}, under {title!r}: two states would be "
                "averaged as repeats",
                station=_name(station),
                earlier=sheet.row_number(earlier),
                row=sheet.row_number(entry.row),
                title=title,
            )
            return ReadingsError(problem, place=sheet.place(entry.row), value=title, expected=_ONE_STATE)
    return None


def repeat_messages(
    entries: Sequence[DiameterCell], table: HeadedTable, columns: Columns, controller: Controller
) -> Iterator[Message]:
    """Yield blocks that return with the same values, and repeats that another column calls states."""
    yield from _pasted_twice(entries, table.sheet, numbered=columns.repeat is not None)
    if columns.repeat is None:
        yield from _returning(entries, table.sheet, controller)
        yield from _remarks(_several(entries), table)
        return
    for index, splits in _splitting(_several(entries, numbered=False), table, columns):
        if letters(table.heading(index)).any("state"):
            text = Sentence(
                "column {heading!r} calls them repeats, so rows are averaged that column {other!r} tells apart "
                "({values})"
            )
            text = text.of(heading=columns.repeat.heading, other=table.heading(index), values=_values(splits)[:_LISTED])
            yield Message("warning", "repeats_of_several_states", text, table.heading_place(index))
            return


def _pasted_twice(entries: Sequence[DiameterCell], sheet: Sheet, *, numbered: bool) -> Iterator[Message]:
    """Yield a warning for the first block of rows that repeats the readings of rows above in the same order.

    Where repeats are numbered, one part measured a second time may well give the same: only a block of several tells.
    """
    rows: dict[int, list[tuple[tuple[object, ...], float, int]]] = defaultdict(list)
    for entry in entries:
        rows[entry.row].append((_station(entry)[:5], entry.raw.size, entry.column))
    order = list(rows)
    seen: dict[object, int] = {}
    runs: list[list[tuple[int, int]]] = []
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
        measured = {station[:2] for station in stations} if numbered else stations  # parts of components
        if len(run) >= _FEWEST and len(measured) >= _FEWEST and run[0][1] > run[-1][0]:
            again, first = ([order[pair[which]] for pair in run] for which in (1, 0))
            text = Sentence(
                "{again} hold the same readings in the same order as {first}: pasted twice? They count as repeats",
                again=rows_named(sheet, again),
                first=rows_named(sheet, first),
            )
            yield Message("warning", "block_repeated", text, sheet.place(again[0]))
            return


def _returning(entries: Sequence[DiameterCell], sheet: Sheet, controller: Controller) -> Iterator[Message]:
    last: dict[StationKey, int] = {}
    order = {row: at for at, row in enumerate(dict.fromkeys(entry.row for entry in entries))}
    back = []
    for entry in entries:
        station = _station(entry)
        if station in last and order[entry.row] > order[last[station]] + 1:
            back.append((last[station], entry.row, station))
        last[station] = entry.row
    if not back:
        return
    earlier, row, station = back[0]
    returned: dict[StationKey, list[DiameterCell]] = {station: [] for *_, station in back}
    for entry in entries:
        returned.get(_station(entry), []).append(entry)
    largest = max(_spread(of_station, one, controller) for one, of_station in returned.items())
    differ = Sentence(", up to {apart} {apart.unit} apart", apart=Quantity(largest * UM, "clearance"))
    apart = any(all(is_blank(cell) for cell in sheet.rows[between]) for between in range(earlier, row))
    text = Sentence(
        "{station} stands in row {earlier} and again in row {row}{also}{behind}{differ}: counted as repeats",
        station=_name(station),
        earlier=sheet.row_number(earlier),
        row=sheet.row_number(row),
        also=_also(len(returned)),
        behind=Sentence(", behind an empty row") if apart else "",
        differ=differ if largest > _AS_ONE else "",
    )
    yield Message("warning" if apart or largest > _AS_ONE else "info", "rows_as_repeats", text, sheet.place(row))


def _spread(entries: Sequence[DiameterCell], station: StationKey, controller: Controller) -> float:
    sizes = [entry.raw.unit.to_si(entry.raw.size) if entry.raw.unit else entry.raw.size for entry in entries]
    land = controller.land_of_plane(station[0], station[2])
    return 0.0 if land is None else (max(sizes) / min(sizes) - 1.0) * land.nominal_diameter


def _remarks(several: Mapping[StationKey, Sequence[int]], table: HeadedTable) -> Iterator[Message]:
    for column in table.of("remark"):
        for station, rows in several.items():
            cells = [cell for row in rows if isinstance(cell := table.sheet.filled(row, column.index), str)]
            remarks = dict.fromkeys(map(text_of, cells))
            texts = [text for text in remarks if letters(text)]
            if texts and len(remarks) > 1:
                text = Sentence(
                    "{station} stands in {rows}, counted as repeats, though remarks tell them apart: {remarks}",
                    station=_name(station),
                    rows=rows_named(table.sheet, rows),
                    remarks=tuple(repr(text[:60]) for text in texts[:_LISTED]),
                )
                yield Message("warning", "remarks_differ", text, table.place(rows[0], column))


def rows_left_out(table: HeadedTable, where: Mapping[str, str]) -> frozenset[int]:
    """Return the rows without the values that ``where`` asks for under its headings, where a table has them."""
    cells = table.sheet.filled
    return frozenset(
        row
        for heading, wanted in where.items()
        if (index := _headed(table, heading)) is not None
        for row in table.rows
        if not _matches(cells(row, index), wanted)
    )


def require_known(tables: Sequence[HeadedTable], where: Mapping[str, str]) -> None:
    """Refuse a heading of ``where`` that no column has, or a value that does not stand under it."""
    for heading, wanted in where.items():
        headed = [(table, index) for table in tables if (index := _headed(table, heading)) is not None]
        if not headed:
            texts = [text for table in tables for at in range(len(table.texts)) if (text := table.heading(at))]
            problem = Sentence("no column is headed {heading!r}", heading=heading)
            raise unknown(problem, heading, texts, kind=ReadingsError, place=tables[0].heading_place())
        cells = [cell for table, index in headed for cell in table.cells(index).values()]
        if not any(_matches(cell, wanted) for cell in cells):
            table, index = headed[0]
            problem, place = Sentence("no row has {wanted!r} there", wanted=wanted), table.heading_place(index)
            raise unknown(problem, wanted, map(_day, cells), kind=ReadingsError, place=place)


def _headed(table: HeadedTable, heading: str) -> int | None:
    return next((index for index in table.span if plain(table.heading(index)) == plain(heading)), None)


def _matches(cell: Cell, wanted: str) -> bool:
    if is_blank(cell):
        return False
    spellings = {plain(text_of(cell)), plain(_day(cell))}
    if isinstance(cell, datetime.date):
        spellings |= {f"{cell:%d.%m.%Y}", f"{cell:%d/%m/%Y}", f"{cell:%m/%d/%Y}", str(cell)}
    wanted = plain(str(wanted))
    return wanted in spellings or wanted.replace(",", ".") in spellings
