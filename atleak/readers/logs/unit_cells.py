"""Reads the units that stand in a column of their own beside the numbers; of several none is believed."""

from __future__ import annotations

from dataclasses import replace

import pandas as pd

from atleak.common.sentences import Sentence
from atleak.measurements.road_test import QUANTITIES
from atleak.readers.dates import words
from atleak.readers.logs.columns import Assigner, Candidate
from atleak.readers.logs.headings import Heading
from atleak.readers.logs.log_table import LogTable
from atleak.readers.logs.names import clean_unit, is_unit
from atleak.readers.logs.units import same_unit

UNIT_HEADERS = frozenset({"unit", "units", "einheit", "jednostka", "unite", "unidade", "единицы"})


def with_units_beside(
    channels: list[Candidate], table: LogTable, rows: pd.Index, assigner: Assigner
) -> tuple[list[Candidate], tuple[str, ...]]:
    """Return the channels with the units of a column *Unit* on their right, and the names of those columns used.

    A channel in several units is left out, which a message says.
    """
    beside = {heading.index - 1: heading for heading in table.headings[: table.width] if _of_units(heading, table)}
    result: list[Candidate] = []
    used: list[str] = []
    for channel in channels:
        heading = beside.get(channel.heading.index) if channel.heading.unit is None else None
        if heading is None:
            result.append(channel)
            continue
        cells = table.read([heading.index], assigner.every)[heading.index].reindex(rows)
        unit, other = two_units(cells, QUANTITIES[channel.quantity].unit_kind)
        if other is not None:
            say_two_units(channel, unit, other, assigner)
            continue
        result.append(replace(channel, unit=unit or channel.unit))
        used.append(heading.label)
    return result, tuple(used)


def _of_units(heading: Heading, table: LogTable) -> bool:
    if not heading.names or words(heading.names[0]) not in UNIT_HEADERS:
        return False
    cells = list(filter(None, table.sampled(heading.index)))
    return bool(cells) and sum(map(is_unit, cells)) > 0.8 * len(cells)


def two_units(cells: pd.Series, kind: str | None) -> tuple[str | None, str | None]:
    """Return the first unit in the cells of a column, and the first that is another; None where there is none."""
    written = cells.dropna().astype("str").str.strip().unique()
    units = [unit for text in written if (unit := clean_unit(text))]
    first = units[0] if units else None
    return first, next((unit for unit in units if not same_unit(units[0], unit, kind)), None)


def say_two_units(channel: Candidate, first: str | None, other: str, assigner: Assigner) -> None:
    """Say that a channel is not taken because its numbers are in several units."""
    text = Sentence(
        "{column!r} holds numbers in several units ({first}, {other}): it is not used",
        column=channel.label,
        first=str(first),
        other=other,
    )
    assigner.refuse(channel, "column_refused", text)
