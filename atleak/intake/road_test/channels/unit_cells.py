"""Reads the units that stand in a column of their own beside the numbers; of several none is believed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import pandas as pd

from atleak.intake.plain_words import words
from atleak.intake.road_test.channels.assign import Assigner, Candidate
from atleak.intake.road_test.channels.protocol import LogTable
from atleak.intake.road_test.files.headings import Heading
from atleak.intake.road_test.names.matching import clean_unit, is_unit
from atleak.intake.road_test.names.unit_choice import same_unit
from atleak.road_test import QUANTITIES
from atleak.sentence import Sentence

UNIT_HEADERS = frozenset({"unit", "units", "einheit", "jednostka", "unite", "unidade", "единицы"})


@dataclass
class UnitCells:
    """A column *Unit* on the right of a channel that states none itself: the different units in it."""

    channel: Candidate
    heading: Heading
    written: dict[str, None] = field(default_factory=dict)

    def add(self, cells: pd.Series) -> None:
        """Add the next cells."""
        self.written |= dict.fromkeys(cells.dropna().astype("str").str.strip().unique())

    def told(self, assigner: Assigner) -> Candidate | None:
        """Return the channel with its unit; None of one in several, which a message says."""
        unit, other = _two_units(self.written, QUANTITIES[self.channel.quantity].unit_kind)
        if other is None:
            return replace(self.channel, unit=unit or self.channel.unit)
        say_two_units(self.channel, unit, other, assigner)
        return None


def columns_of_units(channels: list[Candidate], table: LogTable) -> list[UnitCells]:
    """Return the columns of units beside channels that state none."""
    beside = {heading.index - 1: heading for heading in table.headings[: table.width] if _of_units(heading, table)}
    return [
        UnitCells(channel, beside[channel.heading.index])
        for channel in channels
        if channel.heading.index in beside and channel.heading.unit is None
    ]


def with_units_beside(
    channels: list[Candidate], table: LogTable, rows: pd.Index, assigner: Assigner
) -> tuple[list[Candidate], tuple[str, ...]]:
    """Return the channels with the units of a column *Unit* on their right, and the names of those columns used.

    A channel in several units is left out, which a message says.
    """
    beside = {each.channel.heading.index: each for each in columns_of_units(channels, table)}
    result: list[Candidate] = []
    used: list[str] = []
    for channel in channels:
        units = beside.get(channel.heading.index)
        if units is None:
            result.append(channel)
            continue
        units.add(table.read([units.heading.index], assigner.every)[units.heading.index].reindex(rows))
        told = units.told(assigner)
        if told is not None:
            result.append(told)
            used.append(units.heading.label)
    return result, tuple(used)


def _of_units(heading: Heading, table: LogTable) -> bool:
    if not heading.names or words(heading.names[0]) not in UNIT_HEADERS:
        return False
    cells = [row[heading.index] for row in table.sample if heading.index < len(row) and row[heading.index]]
    return bool(cells) and sum(map(is_unit, cells)) > 0.8 * len(cells)


def two_units(cells: pd.Series, kind: str | None) -> tuple[str | None, str | None]:
    """Return the first unit in the cells of a column, and the first that is another; None where there is none."""
    return _two_units(cells.dropna().astype("str").str.strip().unique(), kind)


def _two_units(written: Iterable[str], kind: str | None) -> tuple[str | None, str | None]:
    units = [unit for text in written if (unit := clean_unit(text))]
    first = units[0] if units else None
    return first, next((unit for unit in units if not same_unit(units[0], unit, kind)), None)


def say_two_units(channel: Candidate, first: str | None, other: str, assigner: Assigner) -> None:
    """Say that a channel is not taken because its numbers are in several units."""
    said = Sentence(
        "{column!r} holds numbers in several units ({first}, {other}): it is not used",
        column=channel.label,
        first=str(first),
        other=other,
    )
    assigner.refuse(channel, "column_refused", said)
