"""Rows of the clearances and of the catalogue as people read them."""

from __future__ import annotations

from typing import Any

import pytest

from atleak.catalogue.controller_file import controllers
from atleak.catalogue.fluid import fluids
from atleak.catalogue.limits import limit_sets
from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.tables.catalogue import TABLES, representative
from atleak.report.tables.clearances import clearance_table


def rows_of(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    return clearance_table(diagnosis.lands, diagnosis.controller, wording("en")).records()


def test_every_land_has_its_row_in_workshop_units(worn: Diagnosis) -> None:
    rows = rows_of(worn)
    assert [(row["component"], row["land"]) for row in rows] == [land.key for land in worn.lands]
    row, state = rows[4], worn.lands[4].state
    assert row["clearance"] == pytest.approx(state.radial_clearance * 1e6, rel=1e-9, abs=0.0)
    assert row["spool_diameter"] == pytest.approx(state.spool_diameter * 1e3, rel=1e-9, abs=0.0)
    assert row["sleeve_ovality"] == pytest.approx(1.0, rel=1e-9, abs=0.0)
    assert row["clearance_least"] - 1e-9 <= row["clearance"] <= row["clearance_largest"] + 1e-9


def test_what_was_not_measured_says_so_and_has_no_range(worn: Diagnosis) -> None:
    row = rows_of(worn)[-1]
    assert row["measured_parts"] == "not measured"
    assert row["wear"] is row["clearance_largest"] is row["spool_ovality"] is None
    assert row["clearance"] == pytest.approx(row["mounting"], rel=1e-9, abs=0.0)


@pytest.mark.parametrize("language", languages())
def test_every_column_has_its_heading_and_what_tells_pairs_apart_comes_first(worn: Diagnosis, language: str) -> None:
    say = wording(language)
    table = clearance_table(worn.lands, worn.controller, say)
    assert len(set(table.headings)) == len(table.headings)
    widths = [column.width or 0 for column in table.columns[:3]]
    assert [column.key for column in table.columns[:3]] == ["verdict", "component", "land"]
    assert sum(widths) <= 360  # pixels of a phone's table


@pytest.mark.parametrize("entry", controllers(), ids=lambda entry: entry.id)
def test_a_controllers_tables_hold_all_of_it(entry) -> None:
    tables = {table.name: table.records() for table in TABLES["controller"](entry, wording("en"))}
    assert len(tables["Lands"]) == len(entry.lands)
    assert len(tables["Gaps"]) == len(entry.entry.gaps) + len(entry.gaps_not_described)
    assert [row["Engine speed"] for row in tables["Operating points"]] == pytest.approx(
        [point.engine_speed * 60.0 for point in entry.operating_points], rel=1e-9, abs=0.0
    )
    assert representative(entry, wording("en")) == entry.representative


@pytest.mark.parametrize("entry", fluids(), ids=lambda entry: entry.id)
def test_a_fluids_curve_goes_through_its_data_sheet_and_stays_in_its_span(entry) -> None:
    tables = {table.name: table.records() for table in TABLES["fluid"](entry, wording("en"))}
    curve = {row["temperature"]: row["viscosity"] for row in tables["d341"]}
    for at, nu in (entry.points[0], entry.points[-1]):
        if at in curve:
            assert curve[at] == pytest.approx(nu * 1e6, rel=1e-9, abs=0.0)
    low, high = entry.span()
    assert all(low <= temperature <= high for temperature in curve)
    assert not [name for name in entry.representative if name not in wording("en").table("value_names")]
    assert "_" not in representative(entry, wording("en"))


def test_every_limit_is_shown_with_its_origin() -> None:
    for entry in limit_sets():
        [table] = TABLES["limits"](entry, wording("en"))
        rows = table.records()
        assert len(rows) == sum(len(steps.levels) for steps in entry.rules.values())
        assert all(row["limit_is"] and row["source"] for row in rows)
        wear = next(row for row in rows if row["rule"] == "wear")
        assert wear["limit"] == f"{entry.wear.levels[0][1] * 100.0:.1f}\u00a0%"
