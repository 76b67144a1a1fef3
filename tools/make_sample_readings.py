"""Write the sample measuring sheets: spool 6 of the study as published, every other reading representative.

    python tools/make_sample_readings.py

The sheets in ``sample_data`` are kept as they were first made; this writes the same readings in today's form, so that
other bytes replace them. What is published and what is not stands in ``sample_data/README.md``.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.controller_file import load_controller
from atleak.measurements.readings import Reading
from atleak.report.sheets.measuring_sheet import write_readings

SAMPLE_DATA = Path(__file__).resolve().parents[1] / "sample_data"
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

# Growth of the radial clearance that the study's sample shows, in percent of the mounting clearance; all other lands
# are within a few percent of new. Representative of a unit whose main pressure side has worn.
FOUR_SPEED_WEAR_PERCENT = {
    ("25", 1): 68,
    ("26", 2): 58,
    ("17", 2): 34,
    ("20", 1): 26,
    ("14", 1): 19,
    ("13", 1): 14,
    ("8", 2): 12,
    ("23", 1): 11.5,
}


# Lands whose bores have new sleeves on the sheet of the same unit after its repair.
REPAIRED = (("25", 1), ("26", 2))

# Radial clearances of the five-speed's sample [µm]: two lands of the forward clutch are worn, every other one is
# somewhere within what new valves have.
FIVE_SPEED_WORN_UM = {("manual_valve", 3): 46.0, ("forward_engagement", 1): 48.0}
FIVE_SPEED_NEW_UM = (8.0, 17.0)


def main() -> None:
    chance = random.Random(SEED)
    controller = load_controller("four_speed_2023")
    readings = [reading for land in controller.lands for reading in _four_speed_land(land, chance)]
    _write("measuring_sheet_four_speed.xlsx", controller, readings, {"Mileage": "106 315 km"})
    again = list(_measured_again(controller, readings, random.Random(SEED + 1)))
    _write("measuring_sheet_four_speed_repaired.xlsx", controller, again, {"Mileage": "106 320 km"})
    controller = load_controller("five_speed_2005")
    readings = [reading for land in controller.lands for reading in _five_speed_land(land, chance)]
    known = {
        "Mileage": "212 000 km",
        "Instrument for spools": "micrometer",
        "Instrument for bores": "bore gauge",
    }
    _write("measuring_sheet_five_speed.xlsx", controller, readings, known)


def _write(name: str, controller: Controller, readings: list[Reading], fields: dict[str, str]) -> None:
    head = {"Job": "atleak sample", "Vehicle": "sample, no real vehicle", **fields}
    (SAMPLE_DATA / name).write_bytes(write_readings(controller, readings, fields=head, blank_rows=False))


def _four_speed_land(land: Land, chance: random.Random) -> Iterator[Reading]:
    wear = FOUR_SPEED_WEAR_PERCENT.get(land.key, chance.uniform(-4.0, 6.0)) / 100.0
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
    yield from _sleeve(land, land.new_clearance * 1e3 * (1.0 + wear), lean, chance)


def _measured_again(controller: Controller, readings: list[Reading], chance: random.Random) -> Iterator[Reading]:
    """Read the unit once more: new sleeves in two bores, as wide as when new, and all else as it was."""
    for reading in readings:
        land = next(
            each for each in controller.lands if (each.component, each.planes[0]) == (reading.component, reading.plane)
        )
        diameter = reading.diameter
        if reading.part == "sleeve" and land.key in REPAIRED:
            diameter = land.nominal_diameter + 2.0 * land.new_clearance
        read = round(diameter + _reading_error(chance) * 1e-3, 6)
        yield replace(reading, diameter=read, coordinates=None)


def _five_speed_land(land: Land, chance: random.Random) -> Iterator[Reading]:
    new = chance.uniform(*FIVE_SPEED_NEW_UM) * 1e-3
    clearance = FIVE_SPEED_WORN_UM.get(land.key, 0.0) * 1e-3 or new
    for direction in (0.0, 90.0):
        for repeat in (1, 2):
            yield _reading(land, "spool", direction, repeat, land.nominal_diameter * 1e3 + _reading_error(chance))
    yield from _sleeve(land, clearance, 0.4 * (clearance - new), chance)


def _sleeve(land: Land, clearance: float, lean: float, chance: random.Random) -> Iterator[Reading]:
    """Read the sleeve of a land of so much radial clearance, wider across by twice the lean than along [mm]."""
    sleeve = land.nominal_diameter * 1e3 + 2.0 * clearance
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
