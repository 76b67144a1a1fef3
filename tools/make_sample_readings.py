"""Write the sample measuring sheet: spool 6 as published, every other reading representative.

    python tools/make_sample_readings.py

The same controller file gives the same bytes. What is published and what is not stands in ``sample_data/README.md``.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path

from atleak.catalogue.controller import Land, load_controller
from atleak.readings import Reading
from atleak.report.measuring_sheet import write_readings

TARGET = Path(__file__).resolve().parents[1] / "sample_data" / "measuring_sheet_four_speed.xlsx"
SEED = 7667

# Dziubak & Szczepaniak, Energies 2023, 16, 7667, Table 1 (spool 6): plane, direction [°], the two coordinates [mm]
PUBLISHED = (
    ("1", 0.0, 89.605, 79.666),
    ("1", 0.0, 79.666, 89.605),
    ("1", 90.0, 86.422, 76.483),
    ("1", 90.0, 76.483, 86.422),
    ("2", 0.0, 84.371, 74.430),
    ("2", 0.0, 74.430, 84.371),
    ("2", 90.0, 85.121, 75.178),
    ("2", 90.0, 75.178, 85.121),
)

# Growth of the radial clearance that the sample shows, in percent of the mounting clearance; all other lands are
# within a few percent of new. Representative of a unit whose main pressure side has worn.
WEAR_PERCENT = {
    ("25", 1): 68,
    ("26", 2): 58,
    ("17", 2): 34,
    ("20", 1): 26,
    ("14", 1): 19,
    ("13", 1): 14,
    ("8", 2): 12,
    ("23", 1): 11.5,
}


def main() -> None:
    controller = load_controller("four_speed_2023")
    chance = random.Random(SEED)
    readings = [reading for land in controller.lands for reading in _land(land, chance)]
    fields = {"Job": "atleak sample", "Vehicle": "sample, no real vehicle", "Mileage": "106 315 km"}
    TARGET.write_bytes(write_readings(controller, readings, fields=fields, blank_rows=False))


def _land(land: Land, chance: random.Random) -> Iterator[Reading]:
    wear = WEAR_PERCENT.get(land.key, chance.uniform(-4.0, 6.0)) / 100.0
    sleeve = land.nominal_diameter * 1e3 + 2.0 * land.new_clearance * 1e3 * (1.0 + wear)
    lean = max(wear, 0.0) * land.new_clearance * 1e3  # a bore wears to one side: wider across than along
    if land.component == "6":
        yield from _published(land)
    else:
        for direction in (0.0, 90.0):
            for repeat in (1, 2):
                diameter = land.nominal_diameter * 1e3 + _reading_error(chance)
                start = chance.randint(82_000, 92_000) / 1e3
                pair = (start, round(start - diameter, 3))
                yield _reading(land, "spool", direction, repeat, pair[0] - pair[1], pair)
    for direction, across in ((0.0, -lean), (90.0, lean)):
        for repeat in (1, 2):
            yield _reading(land, "sleeve", direction, repeat, sleeve + across + _reading_error(chance))


def _published(land: Land) -> Iterator[Reading]:
    count: dict[float, int] = {}
    for plane, direction, first, second in PUBLISHED:
        if plane in land.planes:
            count[direction] = count.get(direction, 0) + 1
            yield _reading(land, "spool", direction, count[direction], abs(first - second), (first, second))


def _reading_error(chance: random.Random) -> float:
    return chance.choice((-0.001, 0.0, 0.0, 0.001))


def _reading(
    land: Land, part: str, direction: float, repeat: int, diameter: float, pair: tuple[float, float] | None = None
) -> Reading:
    return Reading(
        component=land.component,
        part=part,
        plane=land.planes[0],
        direction=direction,
        repeat=repeat,
        diameter=round(diameter, 3) * 1e-3,
        coordinates=None if pair is None else (pair[0] * 1e-3, pair[1] * 1e-3),
    )


if __name__ == "__main__":
    main()
