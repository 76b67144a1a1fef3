"""The rows of a measuring sheet in the order of measuring, and which of them share a cell."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.instruments import Part
from atleak.measuring.plan import DIRECTIONS, PARTS, REPEATS
from atleak.readings import Reading
from atleak.report.paging import Block


@dataclass(frozen=True)
class Row:
    """One reading that is to be taken, and what it was if it was taken."""

    land: Land
    part: Part
    plane: str
    direction: float | None
    repeat: int
    reading: Reading | None

    @property
    def nominal(self) -> float:
        """Return nominal diameter of the part [m]."""
        return self.land.nominal_of(self.part)


Key = Callable[[Row], tuple[Any, ...]]


def of_component(row: Row) -> tuple[Any, ...]:
    """Return what the rows of a component have alike."""
    return (row.land.component,)


def of_part(row: Row) -> tuple[Any, ...]:
    """Return what the rows of a part have alike."""
    return *of_component(row), row.part


def of_round(row: Row) -> tuple[Any, ...]:
    """Return what the rows have alike that are measured without lifting the part off."""
    return *of_part(row), row.repeat


def of_plane(row: Row) -> tuple[Any, ...]:
    """Return what the rows of a plane have alike within a round."""
    return *of_round(row), row.plane


def of_direction(row: Row) -> tuple[Any, ...]:
    """Return what the rows of a direction have alike within a plane."""
    return *of_plane(row), row.direction


def rows_of(controller: Controller, readings: Iterable[Reading], blank_rows: bool) -> list[Row]:
    """Return the rows in the order of measuring that the sheet states, `how_to_measure.order` of the texts."""
    given: dict[tuple[Any, ...], dict[int, Reading]] = defaultdict(dict)
    directions: dict[tuple[str, Part, str], list[float | None]] = defaultdict(list)
    for reading in readings:
        repeats = given[reading.station]
        repeats[reading.repeat if reading.repeat not in repeats else max(repeats) + 1] = reading
        known = directions[reading.component, reading.part, reading.plane]
        if reading.direction not in known:
            known.append(reading.direction)

    def rows_of_part(component: str, part: Part) -> Iterator[Row]:
        for land in controller.lands_of(component):
            for plane in land.planes:
                measured = directions[component, part, plane]
                wanted = [angle for angle in DIRECTIONS if angle not in measured] if blank_rows else []
                for direction in sorted([*measured, *wanted], key=lambda angle: -1.0 if angle is None else angle):
                    repeats = given[component, part, plane, direction]
                    for repeat in {*repeats, *(range(1, REPEATS + 1) if blank_rows else ())}:
                        yield Row(land, part, plane, direction, repeat, repeats.get(repeat))

    components = dict.fromkeys(land.component for land in controller.lands)
    parts = [rows_of_part(component, part) for component in components for part in PARTS]
    return [row for rows in parts for row in sorted(rows, key=lambda row: row.repeat)]


def runs(numbered: Sequence[tuple[int, Row]], pages: Sequence[int], key: Key) -> Iterator[tuple[int, int, Row]]:
    """Return first number, last number and first row of every run of rows with the same key on the same page."""
    for _, block in groupby(zip(numbered, pages, strict=True), key=lambda each: (each[1], key(each[0][1]))):
        inside = [entry for entry, _ in block]
        yield inside[0][0], inside[-1][0], inside[0][1]


def blocks_of(rows: Sequence[Row], keys: Sequence[Key] = (of_component, of_part, of_round, of_plane)) -> list[Block]:
    """Return the numbers of rows of components, within them of parts, of the rounds of measuring, of planes."""
    key, *finer = keys
    groups = [list(block) for _, block in groupby(rows, key=key)]
    return [blocks_of(group, finer) if finer else len(group) for group in groups]
