"""Rows of the clearances and of the catalogue as people read them."""

from __future__ import annotations

import pytest

from atleak.catalogue.controller_reading import controllers
from atleak.catalogue.fluid import fluids
from atleak.catalogue.limits import limit_sets
from atleak.diagnosis import Diagnosis
from atleak.views.catalogue_rows import TABLES, representative
from atleak.views.clearances import clearance_rows


def test_every_land_has_its_row_in_workshop_units(worn: Diagnosis) -> None:
    rows = clearance_rows(worn.lands)
    assert [(row["component"], row["land"]) for row in rows] == [land.key for land in worn.lands]
    row, state = rows[4], worn.lands[4].state
    assert row["radial_clearance_um"] == pytest.approx(state.radial_clearance * 1e6, rel=1e-9, abs=0.0)
    assert row["spool_diameter_mm"] == pytest.approx(state.spool_diameter * 1e3, rel=1e-9, abs=0.0)
    assert row["sleeve_ovality_um"] == pytest.approx(1.0, rel=1e-9, abs=0.0)
    assert row["min_clearance_um"] - 1e-9 <= row["radial_clearance_um"] <= row["max_clearance_um"] + 1e-9


def test_what_was_not_measured_says_so_and_has_no_range(worn: Diagnosis) -> None:
    row = clearance_rows(worn.lands)[-1]
    assert row["status"] == "not measured"
    assert row["wear_percent"] is row["max_clearance_um"] is row["spool_ovality_um"] is None
    assert row["radial_clearance_um"] == pytest.approx(row["mounting_clearance_um"], rel=1e-9, abs=0.0)


@pytest.mark.parametrize("entry", controllers(), ids=lambda entry: entry.id)
def test_a_controllers_tables_hold_all_of_it(entry) -> None:
    tables = TABLES["controller"](entry)
    assert len(tables["Lands"]) == len(entry.lands)
    assert len(tables["Gaps"]) == len(entry.gaps)
    assert [row["engine [rpm]"] for row in tables["Operating points"]] == pytest.approx(
        [point.engine_speed * 60.0 for point in entry.operating_points], rel=1e-9, abs=0.0
    )
    assert representative(entry) == entry.representative


@pytest.mark.parametrize("entry", fluids(), ids=lambda entry: entry.id)
def test_a_fluids_curve_goes_through_its_data_sheet_and_stays_in_its_span(entry) -> None:
    tables = TABLES["fluid"](entry)
    curve = {row["temperature [°C]"]: row["viscosity [mm²/s]"] for row in tables["ASTM D341 through the data sheet"]}
    for at, nu in (entry.points[0], entry.points[-1]):
        if at in curve:
            assert curve[at] == pytest.approx(nu * 1e6, rel=1e-9, abs=0.0)
    low, high = entry.span()
    assert all(low <= temperature <= high for temperature in curve)
    assert representative(entry) == ", ".join(entry.representative)


def test_every_limit_is_shown_with_its_origin() -> None:
    for entry in limit_sets():
        rows = TABLES["limits"](entry)["Limits"]
        assert len(rows) == sum(len(steps.levels) for steps in entry.rules.values())
        assert all(row["origin"] and row["source"] for row in rows)
        wear = next(row for row in rows if row["rule"] == "wear")
        assert wear["limit"] == pytest.approx(entry.wear.levels[0][1] * 100.0, rel=1e-9, abs=0.0)
