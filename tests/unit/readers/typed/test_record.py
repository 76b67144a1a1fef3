"""What the grid shows of every cell and land, in the reader's words."""

from __future__ import annotations

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.measurements.measuring_plan import PlanCell
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.readers.typed_sheet import Typed, judge, written_sheet
from atleak.report.measuring_grid import Grid, grid_record

SLIP = PlanCell("pressure_regulator", "spool", "2", 0.0, 1)


@pytest.fixture(scope="module")
def typed(careful_entries: Typed) -> Typed:
    return careful_entries.put(SLIP, "125,01").put(PlanCell("accumulator", "sleeve", "1", 90.0, 2), "")


@pytest.fixture(scope="module")
def grid(typed: Typed, minimal: Controller, hipol: Fluid, limits: Limits) -> Grid:
    judged = judge(typed, minimal)
    content = written_sheet(typed, judged.counting, minimal)
    assert content is not None
    result: Diagnosis = diagnose(minimal, hipol, limits, readings=read_readings(content, minimal, name="typed.csv"))
    return Grid(typed.plan.cells(minimal, typed.entries), typed, judged, result)


def test_a_land_has_a_result_as_soon_as_all_its_readings_count(grid: Grid) -> None:
    assert list(grid.finished) == [("pressure_regulator", 1), ("tcc_regulator", 1), ("solenoid_modulator", 1)]
    lands = {
        (component["name"], land["name"]): land
        for component in grid_record(grid, wording("en"))["components"]
        for land in component["lands"]
    }
    assert lands["pressure_regulator", "Land 2"]["progress"] == "7 of 8 readings"
    assert lands["accumulator", "Land 1"]["result"] is None
    result = lands["pressure_regulator", "Land 1"]["result"]
    state = grid.finished["pressure_regulator", 1].state
    assert result["clearance"] == wording("en").quantity(state.radial_clearance * 1e6, "clearance") == "20.0\u00a0µm"
    assert result["wear"] == "11\u00a0%"
    assert result["ovality"] == "0.0\u00a0µm"
    assert result["verdict"] == wording("en").signed(grid.finished["pressure_regulator", 1].verdict)


def test_a_doubtful_cell_says_why_and_whether_it_counts(grid: Grid) -> None:
    cells = {tuple(cell["key"]): cell for cell in grid_record(grid, wording("en"))["cells"]}
    assert "10 times" in cells[SLIP.key]["doubt"]
    assert cells[SLIP.key]["counts"] is False
    assert (cells[SLIP.key]["text"], cells[SLIP.key]["part"], cells[SLIP.key]["place"]) == (
        "125,01",
        "Spool",
        "plane 2, 0°",
    )
    assert [cell["doubt"] for key, cell in cells.items() if key != SLIP.key and cell["doubt"]] == []


@pytest.mark.parametrize(
    ("language", "units", "shown"), [("de", "metric", "20,0\u00a0µm"), ("pl", "us", "0,00079\u00a0in")]
)
def test_numbers_stand_in_the_readers_language_and_unit(grid: Grid, language: str, units: str, shown: str) -> None:
    record = grid_record(grid, wording(language, units))
    assert record["components"][0]["lands"][0]["result"]["clearance"] == shown


def test_the_drawing_names_its_planes_and_directions(grid: Grid) -> None:
    drawing = grid_record(grid, wording("en"))["components"][0]["drawing"]
    for name in ('data-plane="1"', 'data-plane="2"', 'data-direction="0"', 'data-direction="90"'):
        assert name in drawing
    assert grid_record(grid, wording("en"), dark=True)["components"][0]["drawing"] != drawing


def test_the_drawing_has_the_readers_decimal_sign_unit_and_name_of_the_valve(grid: Grid) -> None:
    assert "⌀ 15.000" in grid_record(grid, wording("en"))["components"][0]["drawing"]
    german = grid_record(grid, wording("de"))["components"][0]
    assert "⌀ 15,000" in german["drawing"]
    assert "Bünde und Messebenen" in german["drawing"]
    assert german["title"] == german["label"] == wording("de").name("pressure regulator valve")
    assert "⌀ 0,5906" in grid_record(grid, wording("de", "us"))["components"][0]["drawing"]
