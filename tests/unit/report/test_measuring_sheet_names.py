"""A measuring sheet is read back whatever the valves, circuits and taps of its unit are called."""

from __future__ import annotations

import itertools
import tomllib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import checked_controller, load_controller
from atleak.job.kinds import TableKind, table_kind
from atleak.measurements.gauge_readings import (
    Engine,
    GaugeCell,
    GaugeReading,
    PressureTable,
    applied,
    ranges_of,
    taps_of,
)
from atleak.measurements.readings import Reading
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.readers.sheets.words import plain
from atleak.report.sheets.measuring_sheet import write_readings
from tests.unit.conftest import first_of

SHIPPED = sorted(
    each.name.removesuffix(".toml") for each in (resources.files("atleak") / "catalogue/controllers").iterdir()
)
WORDS = [
    "throttle", "mode", "state", "idle", "stall", "line", "range", "gear", "drive", "reverse", "manual", "pressure",
    "tap", "slow", "fast", "temp", "temperature", "speed", "park", "neutral", "low", "high", "main", "time", "run",
    "unit", "port", "position", "engine", "condition", "lever", "circuit", "gauge", "reading", "value", "limit",
    "min", "max", "no", "date", "result", "ok", "first", "second", "overdrive", "sport", "od", "d", "r", "n", "p",
    "s", "l", "2", "rpm", "atf", "full_throttle", "line_pressure", "kickdown", "detent", "governor", "modulator",
    "lock_up", "shift", "relay", "spool", "sleeve", "bore", "mean", "total", "nominal", "diameter", "rejected",
    "measured", "new", "before", "after", "left", "right",
]  # fmt: skip


def unit_of(names: Iterable[tuple[str, str]]) -> Controller:
    """Return the minimal example with other components, each with two lands: by ids and names."""
    example = resources.files("atleak") / "catalogue/controllers/minimal_example.toml"
    data = tomllib.loads(example.read_text(encoding="utf-8"))
    lands = [
        {"land": land, "nominal_diameter_mm": diameter, "mounting_clearance_um": 18.0}
        for land, diameter in ((1, 15.0), (2, 12.5))
    ]
    components = [{"id": each, "name": name, "lands": lands} for each, name in names]
    return checked_controller({**data, "complaints": [], "components": components})


def measured(unit: Controller, repeats: int = 1) -> list[Reading]:
    wider = {"spool": 0.0, "sleeve": 40e-6}
    return [
        Reading(land.component, part, plane, 0.0, repeat, land.nominal_diameter + wider[part])
        for land in unit.lands
        for part in ("spool", "sleeve")
        for plane in land.planes
        for repeat in range(1, repeats + 1)
    ]


def assert_read_back(unit: Controller, data: bytes, given: Sequence[Reading]) -> None:
    assert table_kind(data, unit) is TableKind.READINGS
    read = read_readings(data, unit, name="sheet.xlsx")
    assert {(each.station, each.repeat): round(each.diameter, 9) for each in read.readings} == {
        (each.station, each.repeat): round(each.diameter, 9) for each in given
    }
    assert read.pressures is None


def shipped_names() -> Iterator[str]:
    for each in SHIPPED:
        unit = load_controller(each)
        yield from itertools.chain.from_iterable(unit.components.items())
        yield from itertools.chain.from_iterable((circuit.id, circuit.name) for circuit in unit.circuits)
        yield from taps_of(unit)


@pytest.mark.parametrize("order", [1, -1])
def test_valves_named_by_words_that_head_tables_are_read_back(order: int) -> None:
    unit = unit_of([(word, f"{word} valve") for word in WORDS[::order]])
    assert_read_back(unit, write_readings(unit, measured(unit), blank_rows=False), measured(unit))


@pytest.mark.parametrize("word", ["throttle", "mode", "state", "idle", "stall", "unit", "pressure"])
def test_a_sheet_with_a_single_such_valve_is_read_back_and_a_blank_one_is_no_table_of_gauges(word: str) -> None:
    unit = unit_of([(word, word), ("other", "1-2 shift valve")])
    given = measured(unit, 2)
    assert_read_back(unit, write_readings(unit, given), given)


def test_what_shipped_units_call_their_valves_circuits_and_taps_is_read_back_as_a_valves_id() -> None:
    names = list({plain(name.replace("_", " ")): name for name in shipped_names()}.values())
    assert len(names) > 200
    for start in range(0, len(names), 80):
        unit = unit_of((name, f"valve {number}") for number, name in enumerate(names[start : start + 80]))
        assert_read_back(unit, write_readings(unit, measured(unit), blank_rows=False), measured(unit))


@pytest.mark.parametrize("unit_id", first_of(SHIPPED))
def test_the_sheet_of_a_shipped_unit_is_read_back_with_its_gauges(unit_id: str) -> None:
    unit = load_controller(unit_id)
    assert_read_back(unit, write_readings(unit, measured(unit)), measured(unit))


@pytest.mark.parametrize("words", [WORDS[:5] + WORDS[6:10], WORDS[9:18], [*"drnps", "mode", "port", "tap", "unit"]])
def test_taps_named_by_words_of_a_table_of_gauges_are_read_back(words: Sequence[str]) -> None:
    unit = load_controller("gm_4l60e")
    named = zip(unit.circuits, words, strict=True)
    unit = replace(unit, circuits=tuple(replace(circuit, id=f"{word}_c", name=word) for circuit, word in named))
    cells = [GaugeCell(each, Engine.SLOW_IDLE, tap) for each in ranges_of(unit) for tap in taps_of(unit)]
    cells = [cell for cell in cells if applied(unit, cell)]
    given = tuple(GaugeReading(cell, 400e3 + number * 1e3) for number, cell in enumerate(cells))
    sheet = write_readings(unit, measured(unit), pressures=PressureTable("", "", None, (), given))
    read = read_readings(sheet, unit, name="sheet.xlsx")
    assert {(each.cell, round(each.pressure)) for each in read.pressures.readings} == {
        (each.cell, round(each.pressure)) for each in given
    }
    assert len(read.readings) == len(measured(unit))


@pytest.mark.slow
@pytest.mark.parametrize("word", ["throttle", "idle", "state"])
def test_such_a_sheet_is_read_back_after_another_office_program_saved_it(
    tmp_path: Path, convert: Callable[[Path, str], None], word: str
) -> None:
    unit = unit_of([(word, f"{word} valve"), ("other", "1-2 shift valve")])
    given = measured(unit, 2)
    (tmp_path / "own.xlsx").write_bytes(write_readings(unit, given))
    for kind in ("ods", "xlsx"):
        convert(tmp_path / "own.xlsx", kind)
        assert_read_back(unit, (tmp_path / f"own.{kind}").read_bytes(), given)
