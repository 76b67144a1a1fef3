"""Circuits, leaks, consumers and permissible pressures as the catalogue shows them."""

from __future__ import annotations

import pytest

from atleak.catalogue.circuits import Following, SetPressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_reading import load_controller
from atleak.views.catalogue_rows import controller_tables
from atleak.views.circuit_rows import circuit_tables, set_pressure_words

LABELS = {"hot_idle": "hot idle", "stall": "stall in drive"}


@pytest.fixture(scope="module")
def five_speed() -> Controller:
    return load_controller("five_speed_2005")


@pytest.mark.parametrize(
    ("stated", "words"),
    [
        (None, "not regulated"),
        (SetPressure(number=690e3), "690 kPa"),
        (SetPressure(points={"hot_idle": 150e3, "stall": 400e3}), "hot idle: 150 kPa; stall in drive: 400 kPa"),
        (SetPressure(gears={1: 300e3, -1: 500e3}), "gear 1: 300 kPa; gear -1: 500 kPa"),
        (SetPressure(currents=((0.1, 1.0), (620e3, 20e3))), "100 mA: 620 kPa; 1000 mA: 20 kPa"),
        (SetPressure(duties=((0.0, 0.35), (0.0, 210e3))), "0 % duty: 0 kPa; 35 % duty: 210 kPa"),
        (SetPressure(following=Following("epc", 2.5, 740e3)), "2.5 × epc + 740 kPa"),
        (SetPressure(following=Following("epc", 1.0, -50e3)), "1 × epc − 50 kPa"),
        (SetPressure(following=Following("epc", 2.0, 0.0)), "2 × epc"),
    ],
)
def test_a_set_pressure_is_said_in_words(stated: SetPressure | None, words: str) -> None:
    assert set_pressure_words(stated, LABELS) == words


def test_every_circuit_stands_with_its_feeds_and_its_source(five_speed: Controller) -> None:
    line, *circuits = circuit_tables(five_speed)["Circuits"]
    assert (line["fed from"], line["set to"]) == ("the pump", "2.5 × epc + 740 kPa")
    assert [row["circuit"].split(" · ")[0] for row in circuits] == [circuit.id for circuit in five_speed.circuits]
    servo = next(row for row in circuits if row["circuit"].startswith("overdrive_band"))
    assert (servo["fed from"], servo["gears"]) == ("p_g ⌀ 1.83 mm, C_d 0.62", "2, 5")
    for rows in circuit_tables(five_speed).values():
        assert rows
        assert all(row["source"] for row in rows)


def test_leaks_and_consumers_stand_in_the_units_of_the_file(five_speed: Controller) -> None:
    tables = circuit_tables(five_speed)
    rings = tables["Leaks beside the lands"][0]
    assert rings["flow [dm³/min]"] == pytest.approx(0.2, abs=1e-12)
    assert rings["at [kPa]"] == pytest.approx(900.0, abs=1e-9)
    assert rings["at viscosity [mPa·s]"] == pytest.approx(7.0 * 0.83, abs=1e-9)
    converter = tables["Consumers"][0]
    assert converter["hot idle in drive, 100 °C [dm³/min]"] == pytest.approx(3.8, abs=1e-12)
    assert converter["starves before the line"] == "yes"
    low = {(row["gears"], row["state"]): row["low [kPa]"] for row in tables["Permissible main pressure"]}
    assert low["-1", "stall"] == pytest.approx(2000.0, abs=1e-9)


def test_a_controller_without_circuits_shows_no_empty_table(minimal: Controller) -> None:
    assert not {"Circuits", "Leaks beside the lands", "Consumers", "Permissible main pressure"} & set(
        controller_tables(minimal)
    )
