"""Cells left empty under the first of a block, filled with what stands above them, where the user says so."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache

from atleak.errors import Message, ReadingsError
from atleak.intake.readings.controller_names import ControllerNames
from atleak.intake.readings.one_heading import Role
from atleak.intake.readings.sizes import UNITS, Sizes, numbers_of
from atleak.intake.readings.table import Table
from atleak.intake.readings.values import DiameterCell
from atleak.intake.readings.words import is_blank, plain, repeat_of, text_of
from atleak.intake.sheets.sheet import rows_named
from atleak.readings import NOMINAL_HEADING
from atleak.sentence import Sentence
from atleak.wording import languages, own_table

_FILLED: tuple[Role, ...] = ("component", "part", "plane", "land", "direction")
FILL_DOWN = Sentence("or --fill-down, if an empty cell means the one above it")


def filled_down(table: Table, told: bool) -> Table:
    """Return the table with the empty cells of a block filled from the first one.

    ``told`` is whether the user says that empty cells go on with the one above. Without it only the program's own form
    saved as text is filled, whose blocks are known. A label that changes ends what stands to the right of it.
    """
    if not told and not (table.sheet.is_text and is_own_form(table)):
        return table
    sheet = table.sheet
    keys = sorted(each.index for each in table.columns if each.role in _FILLED and each.index not in sheet.derived)
    counts = [each.index for each in table.of("repeat")]
    beside = [each.index for each in table.of("specification")] if not told else []
    filled: dict[tuple[int, int], tuple[int, int]] = {}
    first: dict[int, int] = {}  # of each column the row with the label that counts now
    repeat = 0
    for row in table.rows:
        if all(is_blank(cell) for cell in sheet.rows[row]):
            first = {}
            continue
        given = [index for index in keys if not is_blank(sheet.filled(row, index))]
        new = next((index for index in given if not _is_same(table, first.get(index), row, index)), None)
        number = next((number for index in counts if (number := repeat_of(sheet.filled(row, index)))), 0)
        if new is None and not given and 0 < number <= repeat:
            first = {}  # repeats that begin again under no label: one was forgotten
        repeat = number
        if new is not None:
            first = {index: at for index, at in first.items() if index < new}
        first |= dict.fromkeys(given, row)
        for index in (*keys, *beside):
            if index in first and is_blank(sheet.filled(row, index)):
                filled[row, index] = sheet.merged.get((first[index], index), (first[index], index))
            elif index in beside and not is_blank(sheet.filled(row, index)):
                first[index] = row
    if not filled:
        return table
    return replace(
        table,
        sheet=replace(sheet, merged={**sheet.merged, **filled}),
        told=(*table.told, _what_was_filled(table, filled)),
        filled=frozenset(row for row, _ in filled),
    )


def _is_same(table: Table, first: int | None, row: int, index: int) -> bool:
    if first is None:
        return False
    return plain(text_of(table.sheet.filled(first, index))) == plain(text_of(table.sheet.filled(row, index)))


def _what_was_filled(table: Table, filled: Mapping[tuple[int, int], tuple[int, int]]) -> Message:
    text = Sentence(
        "empty cells under {headings} go on with the one above them ({rows})",
        headings=tuple(repr(table.heading(index)) for index in sorted({index for _, index in filled})),
        rows=rows_named(table.sheet, sorted({row for row, _ in filled})),
    )
    return Message("info", "filled_down", text, table.sheet.place(min(row for row, _ in filled)))


def broken_blocks(table: Table, entries: Sequence[DiameterCell], names: ControllerNames) -> Iterator[ReadingsError]:
    """Yield a problem for each filled row that cannot go on with the one above: of another diameter, or come twice."""
    sizes = Sizes(names.controller)
    seen: dict[object, int] = {}
    before: list[object] = []
    row, here = -1, list[object]()
    for entry in entries:
        if entry.row != row:
            row, before, here = entry.row, here, []
        key = entry.key
        station = (key.component, key.part, key.plane, key.direction)
        here.append(station)
        if entry.row in table.filled:
            units = (entry.raw.unit,) if entry.raw.unit is not None else UNITS
            beside = [
                number
                for column in table.of("specification")
                for number in numbers_of(table.sheet.cell(entry.row, column.index))
                if sizes.near(number, units)
            ]
            written = [entry.raw.size, *beside]
            if not all(sizes.near_plane(each, units, key.component, key.plane) for each in written):
                yield _broken(table, entry, Sentence("and another nominal diameter than that stands here"))
            elif station in seen and station not in before and key.repeat is None:
                text = Sentence("which stands in row {row} already", row=table.sheet.row_number(seen[station]))
                yield _broken(table, entry, text)
        seen[station] = row


def _broken(table: Table, entry: DiameterCell, why: Sentence) -> ReadingsError:
    key = entry.key
    return ReadingsError(
        Sentence(
            "this row would go on with component {component}, plane {plane}, {why}: is its label missing?",
            component=key.component,
            plane=key.plane,
            why=why,
        ),
        place=entry.raw.place,
        value=entry.raw.size,
        expected=Sentence("the label in the first row of every block"),
    )


def is_own_form(table: Table) -> bool:
    """Return whether a table has the heading of nominal diameters that the program's own form has."""
    return any(table.heading(index).partition(" [")[0] in nominal_headings() for index in table.span)


@cache
def nominal_headings() -> frozenset[str]:
    """Return the heading of the form's own column of nominal diameters in every language, without its unit."""
    english = str(NOMINAL_HEADING)
    headings = (own_table(each, "messages", english.split()[0]).get(english, english) for each in languages())
    return frozenset(" ".join(heading.split()) for heading in headings)
