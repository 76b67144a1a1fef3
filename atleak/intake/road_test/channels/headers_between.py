"""Refuses a log in the middle of which another header, or another row of units, begins: its columns change meaning.

A unit that only one of two headers states is asked about, unless the numbers of the other part are in it, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pandas as pd

from atleak.errors import Place, RoadTestError
from atleak.intake.plain_words import words
from atleak.intake.road_test.channels.assign import Again, Assigner, Candidate
from atleak.intake.road_test.clock.clocks import Clock
from atleak.intake.road_test.files.cells import MISSING
from atleak.intake.road_test.names.matching import is_unit, match_name, split_unit
from atleak.intake.road_test.names.unit_choice import fit, same_unit
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
        return self.text == heading.label or words(split_unit(self.text).text) in [
            words(name) for name in heading.names
        ]

    @property
    def names_a_quantity(self) -> bool:
        """Return whether it is a name that columns of logs bear."""
        return match_name(split_unit(self.text).text) is not None


def refuse_another_header(lines: pd.DataFrame, used: list[Candidate], assigner: Assigner) -> None:
    """Refuse a log with a header among its rows that names other columns, or the same ones in other units.

    Parameters
    ----------
    lines
        of which each bears its number in the file as label.

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
                _refuse_another_unit(cell, cell.text, int(row), assigner)
            continue
        others = _others(cells, alone=len(indices) == 1)
        if others:
            raise RoadTestError(
                Sentence("another header with other columns begins in the middle of the log"),
                place=Place(file=assigner.file, row=None, column=others[0].column.label),
                value=others[0].text,
                expected=Sentence("one header; split the file at data row {row}", row=int(row) + 1),
            )
        is_header = sum(cell.repeats for cell in cells) >= 2
        for cell in cells:
            unit = split_unit(cell.text).unit
            if unit is not None and cell.repeats and cell.text != cell.column.label:
                _refuse_another_unit(cell, unit, int(row), assigner)
            elif unit is None and is_header and cell.repeats and cell.column.unit is not None:
                assigner.again.setdefault(cell.column.heading.index, Again(None, int(row), cell.text))


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


def _refuse_another_unit(cell: _Cell, unit: str, row: int, assigner: Assigner) -> None:
    quantity = cell.column.quantity
    stated, kind = cell.column.unit or assigner.units.get(quantity), QUANTITIES[quantity].unit_kind
    if kind is not None and stated is None:
        assigner.again.setdefault(cell.column.heading.index, Again(unit, row, cell.text))
    if kind is None or stated is None or same_unit(stated, unit, kind):
        return
    raise RoadTestError(
        Sentence("the unit changes from {first} to {other} in the middle of the log", first=stated, other=unit),
        place=Place(file=assigner.file, column=cell.column.label),
        value=cell.text,
        expected=Sentence("one unit in every column; split the file at data row {row}", row=row + 1),
    )


def with_units_stated_again(
    channels: list[Candidate], columns: Mapping[int, np.ndarray], place: Callable[[int], int], assigner: Assigner
) -> list[Candidate]:
    """Return the channels, with its unit each that a header in the middle of the log states for the first time.

    Parameters
    ----------
    place
        tells how many rows stand before a line.

    Raises
    ------
    RoadTestError
        where the numbers of the part of the log that states no unit may be in another one.
    """
    result = []
    for channel in channels:
        again, kind = assigner.again.get(channel.heading.index), QUANTITIES[channel.quantity].unit_kind
        if again is None or kind is None or channel.quantity in assigner.units:
            result.append(channel)
            continue
        at, values = place(again.row), columns[channel.heading.index]
        before, after = values[:at], values[at:]
        silent, telling = (before, after) if again.unit is not None else (after, before)
        unit = again.unit or channel.unit or ""
        guess = fit(channel.quantity, None, silent, assigner.neighbours)
        known = guess.unit is not None and guess.doubt is None and same_unit(guess.unit.name, unit, kind)
        if np.isfinite(silent).any() and (not known or fit(channel.quantity, unit, telling).problem):
            raise _asked(channel, again, unit, assigner)
        if again.unit is not None:
            assigner.say("unit_stated_later", Sentence(
                "{column!r} states its unit from data row {row} on only; the numbers before are in {unit}, too",
                column=channel.label, row=again.row + 1, unit=unit,
            ), "info", channel.label)  # fmt: skip
        result.append(replace(channel, unit=unit))
    return result


def check_clock_stated_again(
    times: list[Candidate], clock: tuple[str, Clock], unit_before: Callable[[Candidate, int], str], assigner: Assigner
) -> None:
    """Refuse a clock for which a header in the middle of the log states, for the first time, another unit.

    Parameters
    ----------
    unit_before
        tells in which unit a column of numbers seems to be before a line.

    Raises
    ------
    RoadTestError
        asking for its unit.
    """
    label, chosen = clock
    if chosen.form != "number" or "time" in assigner.units:
        return
    for column in times:
        again = assigner.again.get(column.heading.index)
        if again is None or again.unit is None or column.label != label:
            continue
        if not same_unit(unit_before(column, again.row), again.unit, "time"):
            raise _asked(column, again, again.unit, assigner)


def _asked(channel: Candidate, again: Again, unit: str, assigner: Assigner) -> RoadTestError:
    """Return the error that asks for the unit of the rows for which none is stated."""
    problem = Sentence("its unit is stated from data row {row} on only ({unit})", row=again.row + 1, unit=unit)
    if again.unit is None:
        problem = Sentence("its unit ({unit}) is not stated again from data row {row} on", row=again.row + 1, unit=unit)
    return RoadTestError(
        problem,
        place=Place(file=assigner.file, column=channel.label),
        value=again.text,
        expected=Sentence(
            "the unit of all rows, such as {quantity} = {unit!r}; or the file split at data row {row}",
            quantity=channel.quantity,
            unit=unit,
            row=again.row + 1,
        ),
    )
