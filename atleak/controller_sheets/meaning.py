"""Say of a cell what a check of the tables says of its value: in the unit, and with the text, that was typed there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from atleak.controller_sheets.description import Description, Fault, Row, Spot
from atleak.controller_sheets.kinds import Number, as_text
from atleak.controller_sheets.shapes import DEFAULTS, Column, Sheet
from atleak.controller_sheets.units import Units
from atleak.errors import CatalogueError, InputError
from atleak.faults import NotAccepted
from atleak.sentence import Sentence, any_of, in_a_row

_LENGTHS = {"mm": 1e-3, "µm": 1e-6, "inch": 0.0254}


def doubts(sheet: Sheet, rows: Iterable[Row], units: Units) -> Iterator[tuple[Spot, Sentence]]:
    """Yield the cells whose numbers are accepted and yet look like those of another unit, each with what to ask.

    An inch sheet with a spool of 7.2, say: 183 mm is none of a valve body, 7.2 mm is.
    """
    for row in rows:
        for column in sheet.columns:
            kind = column.kind
            if not isinstance(kind, Number) or not kind.measure.is_doubted or column.heading not in row.values:
                continue
            if question := _other_unit(column, row, units):
                stands = f"{as_text(row.cells[column.heading])} {kind.label(units)}"
                text = Sentence(
                    "{stands} is unusual{converted}: {question}",
                    stands=stands,
                    converted=_converted(column, row, units),
                    question=question,
                )
                yield row.at(column.heading), text


def in_cells(
    error: CatalogueError, into: Description, sheets: Iterable[Sheet], rows: Mapping[str, Sequence[Row]], units: Units
) -> Iterator[Fault | InputError]:
    """Yield the faults of tables as those of the cells that say them; one that no cell says stays as it is.

    What is wrong with a default that lands take from the head is said once, at the head, and nothing is said of a cell
    that could not be read.
    """
    declared, said = {sheet.name: sheet for sheet in sheets}, set()
    for each in (error, *error.others):
        steps = each.place.steps
        if into.is_unread(steps):
            continue
        spot = into.spot(steps)
        if spot is None:
            yield each
            continue
        columns = declared[spot.sheet].columns
        column = next((column for column in columns if column.heading == spot.heading), None)
        row = next((row for row in rows[spot.sheet] if row.spot.row == spot.row), Row(spot, {}, {}))
        of_head = into.spots.get((DEFAULTS, *steps[-1:]))
        if column is None:
            yield Fault(spot, each.problem, each.value, each.expected, each.nearest)
        elif each.value is None or of_head is None or column.heading in row.cells:
            yield fault_of_cell(each, column, row, units)
        elif (of_head, str(each.value)) not in said:
            said.add((of_head, str(each.value)))
            yield Fault(of_head, each.problem, each.value, each.expected, each.nearest)


def fault_of_cell(error: InputError, column: Column, row: Row, units: Units) -> Fault:
    """Return a fault of the tables as one of the cell in which the value was typed, or is missing."""
    spot = row.at(column.heading)
    if column.heading not in row.cells:
        if error.value is not None:  # of a value that nobody typed
            return Fault(spot, error.problem, error.value, error.expected, error.nearest)
        expected = column.kind.wanted(units) if isinstance(column.kind, Number) else None
        return Fault(spot, Sentence("this cell must be filled in"), expected=expected)
    expected, question = error.expected, _other_unit(column, row, units)
    if expected and question:
        expected = in_a_row((expected, question))
    return Fault(
        spot,
        Sentence("{problem}{converted}", problem=error.problem, converted=_converted(column, row, units)),
        row.cells[column.heading],
        expected or question or None,
        error.nearest,
    )


def _converted(column: Column, row: Row, units: Units) -> Sentence:
    """Say what a number is in the unit of the file, where that is another one, since limits are stated in it."""
    value, kind = row.values.get(column.heading), column.kind
    if not isinstance(kind, Number) or not isinstance(value, float) or kind.value(1.0, units) == 1.0:
        return Sentence("")
    return Sentence(" (it is {value:.6g} {unit})", value=value, unit=kind.label(Units()))


def _other_unit(column: Column, row: Row, units: Units) -> Sentence:
    """Ask for the unit in which a length would be a usual one, where it is none as it stands."""
    kind, cell = column.kind, row.cells[column.heading]
    if not isinstance(kind, Number) or kind.measure.usual == (0.0, 0.0) or column.heading not in row.values:
        return Sentence("")
    low, high = kind.measure.usual
    if low <= row.values[column.heading] <= high:
        return Sentence("")
    try:
        number = float(kind.written(cell, units))
    except NotAccepted:  # a unit stands in the cell already
        return Sentence("")
    sides = 2.0 if kind.measure.of_clearance and units.clearance == "diametral" else 1.0
    names = [name for name, si in _LENGTHS.items() if low <= number * si / float(kind.measure.si) / sides <= high]
    return Sentence("was it in {units}?", units=any_of(names)) if names else Sentence("")
