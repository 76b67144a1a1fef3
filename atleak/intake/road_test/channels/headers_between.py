"""Refuses a log in the middle of which another header, or another row of units, begins: its columns change meaning."""

from __future__ import annotations

from typing import NamedTuple

import pandas as pd

from atleak.errors import Place, RoadTestError
from atleak.intake.plain_words import words
from atleak.intake.road_test.channels.assign import Candidate, plain_name
from atleak.intake.road_test.files.cells import MISSING
from atleak.intake.road_test.names.matching import is_unit, match_name, split_unit
from atleak.intake.road_test.names.unit_choice import same_unit
from atleak.road_test import QUANTITIES
from atleak.sentence import Sentence


class _Cell(NamedTuple):
    """A word in a line that is no row, and the column in which it stands."""

    column: Candidate
    text: str

    @property
    def repeats(self) -> bool:
        """Return whether it is the column's own name, with any unit."""
        heading = self.column.heading
        return self.text == heading.label or plain_name(self.text) in [words(name) for name in heading.names]

    @property
    def names_a_quantity(self) -> bool:
        """Return whether it is a name that columns of logs bear."""
        return match_name(split_unit(self.text).text) is not None


def refuse_another_header(lines: pd.DataFrame, used: list[Candidate], file: str, first: int = 0) -> None:
    """Refuse a log with a header among its rows that names other columns, or the same ones in other units.

    Parameters
    ----------
    lines
        of which each bears its number as label, from ``first`` on.

    Raises
    ------
    RoadTestError
        naming the row, the column, and what stands there.
    """
    columns = {candidate.heading.index: candidate for candidate in used}
    indices = [int(index) for index in lines.columns]
    for row, values in zip(lines.index.tolist(), lines.itertuples(index=False, name=None), strict=True):
        cells = [
            _Cell(columns[index], value.strip())
            for index, value in zip(indices, values, strict=True)
            if index in columns and isinstance(value, str) and value.strip().lower() not in MISSING
        ]
        if cells and all(is_unit(cell.text) for cell in cells):
            for cell in cells:  # a column may be called rpm
                _refuse_another_unit(cell, cell.text, first + int(row), file)
            continue
        others = _others(cells, alone=len(indices) == 1)
        if others:
            raise RoadTestError(
                Sentence("another header with other columns begins in the middle of the log"),
                place=Place(file=file, row=None, column=others[0].column.label),
                value=others[0].text,
                expected=Sentence("one header; split the file at data row {row}", row=first + int(row) + 1),
            )
        for cell in cells:
            unit = split_unit(cell.text).unit
            if unit is not None and cell.repeats and cell.text != cell.column.label:
                _refuse_another_unit(cell, unit, first + int(row), file)


def _others(cells: list[_Cell], alone: bool) -> list[_Cell]:
    """Return the cells of a line that name other columns; none where the line is a remark.

    One is enough where the rest of the line is the header; a name that nobody knows counts beside two of the header's.
    """
    repeated = sum(cell.repeats for cell in cells)
    odd = [cell for cell in cells if not cell.repeats]
    named = [cell for cell in odd if cell.names_a_quantity]
    if len(named) >= 2 or (named and (alone or (repeated and len(named) == len(odd)))):
        return named
    return odd if repeated >= 2 and repeated > len(odd) else []


def _refuse_another_unit(cell: _Cell, unit: str, row: int, file: str) -> None:
    stated, kind = cell.column.unit, QUANTITIES[cell.column.quantity].unit_kind
    if kind is None or stated is None or same_unit(stated, unit, kind):
        return
    raise RoadTestError(
        Sentence("the unit changes from {first} to {other} in the middle of the log", first=stated, other=unit),
        place=Place(file=file, column=cell.column.label),
        value=cell.text,
        expected=Sentence("one unit in every column; split the file at data row {row}", row=row + 1),
    )
