"""A valve body, a fluid and limits as the page Library shows them."""

from __future__ import annotations

from typing import Any

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.entries import shipped_files
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.limits import load_limits
from atleak.common.wording import wording
from atleak.report.tables.catalogue import controller_tables, fluid_tables, limit_tables

EN = wording("en")


@pytest.fixture(scope="module")
def five_speed() -> dict[str, list[dict[str, Any]]]:
    return tables(load_controller("five_speed_2005"))


def tables(controller: Controller) -> dict[str, list[dict[str, Any]]]:
    return {table.name: table.records() for table in controller_tables(controller, EN)}


def test_every_sheet_of_a_valve_body_is_shown_with_its_sources(five_speed: dict[str, list[dict[str, Any]]]) -> None:
    for name in ("Operating points", "Circuits", "Line pressures", "Leaks", "Consumers", "Repairs", "Complaints"):
        assert all(row["Source"] for row in five_speed[name])
    (orifice,) = (row for row in five_speed["Feeds"] if row["Circuit"] == "overdrive_band")
    assert (orifice["Fed from"], orifice["Diameter"], orifice["How known"]) == ("p_g", 1.83, "published")
    pump = {row["what"]: (row["value"].replace("\u00a0", " "), row["known_from"]) for row in five_speed["Pump"]}
    assert pump["Displacement of one revolution"] == ("20000 mm³", "assumed")


def test_what_regulators_are_set_to_stands_in_rows(
    five_speed: dict[str, list[dict[str, Any]]],
) -> None:
    line, *_ = five_speed["Set pressures"]
    assert (line["Circuit"], line["Set by"], line["Which"], line["Ratio"], line["Offset"]) == (
        *("p_g", "another circuit", "epc"),
        *("2.5", 740.0),
    )
    epc = [(row["At"], row["Pressure"]) for row in five_speed["Set pressures"] if row["Circuit"] == "epc"]
    assert epc == [("100", 620.0), ("1000", 20.0)]


def test_lands_show_the_defaults_and_gaps_what_is_taken_where_none_is_described(minimal: Controller) -> None:
    shown = tables(minimal)
    assert not {"Circuits", "Leaks", "Consumers", "Line pressures"} & shown.keys()
    assert [row["Contact length"] for row in shown["Lands"]] == [
        pytest.approx(land.contact_length * 1e3, rel=1e-12, abs=0.0) for land in minimal.lands
    ]
    assert {row["Spool"] for row in shown["Lands"]} == {"aluminium", "steel"}
    assert len(shown["Gaps"]) == len(minimal.gaps)
    assert {(row["From"], row["To"], row["Gears"]) for row in shown["Gaps"]} == {("p_g", "drain", "1 2 3 4 5 6")}


@pytest.mark.parametrize(("language", "units"), [("en", "metric"), ("de", "us"), ("pl", "metric_bar")])
def test_every_table_of_every_shipped_entry_is_said_in_every_language(language: str, units: str) -> None:
    say = wording(language, units)
    entries = [(controller_tables, load_controller, "controllers")]
    entries += [(fluid_tables, load_fluid, "fluids"), (limit_tables, load_limits, "limits")]
    for tables_of, load, kind in entries:
        for name in shipped_files(kind):
            for table in tables_of(load(name), say):
                assert table.title or say(f"catalogue.{table.name}")
                keys = {column.key for column in table.columns}
                assert len({column.heading(say) for column in table.columns}) == len(keys)
                assert [column.cell(row, say) for column in table.columns for row in table.rows]
