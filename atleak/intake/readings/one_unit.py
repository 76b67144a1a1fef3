"""Whether what a sheet holds is of one unit: titles, sheets and columns may name several transmissions or vehicles."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from atleak.errors import Place, ReadingsError
from atleak.intake.readings.rows import Rows
from atleak.intake.readings.words import is_blank, letters, part_of, plain, text_of, vocabulary
from atleak.intake.sheets.sheet import Sheet
from atleak.sentence import Sentence, all_of

_NAMED = re.compile(r"([^\W\d_]{3,})[\s:#._-]*(?:(?i:no|nr|number|n°)\b[\s.:#]*)?([A-Z](?![\w])|[\w./-]*\d[\w./-]*)")
_LISTED = 4  # values of a column that are named


@dataclass(frozen=True)
class _Said:
    """What a text says of the unit that readings under it are of: by which word, which one, and where it stands."""

    word: str
    which: str
    text: str
    place: Place
    is_sheet: bool


def units_apart(read: Sequence[Rows]) -> list[ReadingsError]:
    """Return the error where titles, names of sheets or a column call what is read more than one unit.

    The parts of two units fit each other well enough to pass for one: nothing else would show it.
    """
    filled = [rows for rows in read if rows.entries]
    by_word: dict[str, dict[str, _Said]] = defaultdict(dict)
    for rows in filled:
        for said in _titles(rows):
            by_word[said.word].setdefault(said.which, said)
    for named in by_word.values():
        if len(named) > 1:
            return [_by_titles(list(named.values()))]
    column = _column(filled)
    return [] if column is None else [column]


def _titles(rows: Rows) -> Iterator[_Said]:
    sheet = rows.table.sheet
    last = max(entry.row for entry in rows.entries)
    said = [(text, sheet.place(row), False) for row, text in _lines(sheet, rows.table.last, last)]
    said.append((rows.table.title, sheet.place(max(rows.table.first - 1, 0)), False))
    for text, place, is_sheet in (*said, (sheet.name or "", sheet.place(), True)):
        for match in _NAMED.finditer(text):
            if plain(match[1]) in vocabulary("whole_unit"):
                yield _Said(plain(match[1]), match[2].strip("./-"), text, place, is_sheet)


def _lines(sheet: Sheet, first: int, last: int) -> Iterator[tuple[int, str]]:
    """Yield the lines of text between the readings of a table."""
    for row in range(first + 1, last):
        cells = [cell for cell in sheet.rows[row] if not is_blank(cell)]
        if len(cells) == 1 and isinstance(cells[0], str):
            yield row, " ".join(cells[0].split())


def _by_titles(named: Sequence[_Said]) -> ReadingsError:
    expected = Sentence(
        "the readings of one unit: delete or hide the other ones; or one name over all, if it is one unit"
    )
    if all(each.is_sheet for each in named):
        expected = Sentence(
            "one: say which sheet, as in --sheet {name}; or one name for all, if it is one unit",
            name=f'"{named[0].text}"',
        )
    return ReadingsError(
        Sentence(
            "the readings are of several units, by their titles: {titles}",
            titles=all_of(Sentence("{said!r}", said=each.text) for each in named),
        ),
        place=named[1].place,
        value=named[1].text,
        expected=expected,
    )


def _column(filled: Sequence[Rows]) -> ReadingsError | None:
    """Return the error for a column of serial numbers or vehicles, where several stand beside the readings."""
    values: dict[str, dict[str, set[tuple[str, ...]]]] = defaultdict(lambda: defaultdict(set))
    places: dict[str, Place] = {}
    for rows in filled:
        sheet = rows.table.sheet
        for index in rows.table.span:
            heading = rows.table.heading(index)
            words = letters(heading)
            of_unit = words.any("whole_unit", "head_vehicle", "head_vin", "head_serial")
            of_others = words.any("part", "gauge", "head_instrument")  # whose serial number tells no units apart
            if index in rows.columns.read or not of_unit or of_others or any(map(part_of, words)):
                continue
            places.setdefault(heading, rows.table.heading_place(index))
            for entry in rows.entries:
                cell = sheet.filled(entry.row, index)
                if not is_blank(cell) and plain(text_of(cell)) != plain(entry.key.component):
                    values[heading][text_of(cell)].add((entry.key.component, entry.key.part, entry.key.plane))
    for heading, stations in values.items():
        # where every value stands at one part of one component, it is the number of a part, or of a row
        of_parts = len(stations) > 2 and all(len({each[0] for each in stood}) == 1 for stood in stations.values())
        if len(stations) > 1 and not of_parts:
            chosen = next(iter(stations))
            return ReadingsError(
                Sentence("column {heading!r} names several units, whose parts would be put together", heading=heading),
                place=places[heading],
                value=", ".join(list(stations)[:_LISTED]) + (" …" if len(stations) > _LISTED else ""),
                expected=Sentence(
                    "the rows of one unit, as in --where {chosen}; or a heading such as 'Part number', if it is "
                    "one unit",
                    chosen=f'"{heading}={chosen}"',
                ),
            )
    return None
