"""Circuits, leaks, consumers and permissible pressures as the catalogue shows them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from atleak.catalogue.circuits import Following, SetPressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_reading import load_controller
from atleak.catalogue.entries import shipped_files
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.limits import load_limits
from atleak.views.catalogue_rows import controller_tables, fluid_tables, limit_tables
from atleak.views.circuit_rows import circuit_tables, set_pressure_words
from atleak.wording import wording

EN = wording("en")


@pytest.fixture(scope="module")
def five_speed() -> Controller:
    return load_controller("five_speed_2005")


@pytest.mark.parametrize(
    ("stated", "words"),
    [
        (None, "not regulated"),
        (SetPressure(number=690e3), "690 kPa"),
        (
            SetPressure(points={"hot_idle": 150e3, "another one": 400e3}),
            "hot idle in drive, 100 °C: 150 kPa; another one: 400 kPa",
        ),
        (SetPressure(gears={1: 300e3, -1: 500e3}), "gear 1: 300 kPa; gear -1: 500 kPa"),
        (SetPressure(currents=((0.1, 1.0), (620e3, 20e3))), "100 mA: 620 kPa; 1000 mA: 20 kPa"),
        (SetPressure(duties=((0.0, 0.35), (0.0, 210e3))), "0 % duty: 0 kPa; 35 % duty: 210 kPa"),
        (SetPressure(following=Following("epc", 2.5, 740e3)), "2.5 × epc + 740 kPa"),
        (SetPressure(following=Following("epc", 1.0, -50e3)), "1 × epc − 50 kPa"),
        (SetPressure(following=Following("epc", 2.0, 0.0)), "2 × epc"),
    ],
)
def test_a_set_pressure_is_said_in_words(five_speed: Controller, stated: SetPressure | None, words: str) -> None:
    assert set_pressure_words(stated, five_speed, EN).replace("\u00a0", " ") == words


def test_every_circuit_stands_with_its_feeds_and_its_source(five_speed: Controller) -> None:
    line, *circuits = tables(five_speed)["circuits"]
    assert (line["fed_from"], line["set_to"].replace("\u00a0", " ")) == ("the pump", "2.5 × epc + 740 kPa")
    assert [row["circuit"].split(" · ")[0] for row in circuits] == [circuit.id for circuit in five_speed.circuits]
    servo = next(row for row in circuits if row["circuit"].startswith("overdrive_band"))
    assert (servo["fed_from"].replace("\u00a0", " "), servo["gears"]) == ("p_g ⌀ 1.83 mm, C_d 0.62", "2, 5")
    for rows in tables(five_speed).values():
        assert rows
        assert all(row["source"] for row in rows)


def test_leaks_and_consumers_stand_in_the_units_of_the_file(five_speed: Controller) -> None:
    shown = tables(five_speed)
    rings = shown["leaks"][0]
    assert rings["flow"] == pytest.approx(0.2, abs=1e-12)
    assert rings["at_pressure"] == pytest.approx(900.0, abs=1e-9)
    assert rings["at_viscosity"] == pytest.approx(7.0 * 0.83, abs=1e-9)
    converter = shown["consumers"][0]
    assert converter["hot_idle"] == pytest.approx(3.8, abs=1e-12)
    assert (converter["law"], converter["at_pressure"], converter["starves_first"]) == ("constant", None, "yes")
    first = replace(five_speed.consumers[0], after_line=False, pressure=450e3)
    (bleed,) = tables(replace(five_speed, consumers=(first,)))["consumers"]
    assert (bleed["law"], bleed["at_pressure"], bleed["starves_first"]) == (
        "orifice",
        pytest.approx(450.0, abs=1e-9),
        "no",
    )
    low = {(row["gears"], row["state"]): row["lowest"] for row in shown["permissible"]}
    assert low["-1", "stall"] == pytest.approx(2000.0, abs=1e-9)


def test_a_controller_without_circuits_shows_no_empty_table(minimal: Controller) -> None:
    shown = {table.name for table in controller_tables(minimal, EN)}
    assert not {"circuits", "leaks", "consumers", "permissible"} & shown


@pytest.mark.parametrize(("language", "units"), [("en", "metric"), ("de", "us"), ("pl", "metric_bar")])
def test_every_table_of_every_shipped_entry_is_said_in_every_language(language: str, units: str) -> None:
    say = wording(language, units)
    entries = [(controller_tables, load_controller, "controllers")]
    entries += [(fluid_tables, load_fluid, "fluids"), (limit_tables, load_limits, "limits")]
    for tables_of, load, kind in entries:
        for name in shipped_files(kind):
            for table in tables_of(load(name), say):
                assert say(f"catalogue.{table.name}")
                keys = {column.key for column in table.columns}
                assert len({column.heading(say) for column in table.columns}) == len(keys)
                cells = [column.cell(row, say) for column in table.columns for row in table.rows]
                assert cells


def tables(controller: Controller) -> dict[str, list[dict[str, Any]]]:
    return {table.name: table.records() for table in circuit_tables(controller, EN)}
