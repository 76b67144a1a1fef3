"""Everything that is wrong with a controller's tables is named at once, each with its place among them."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import pytest

from atleak.catalogue.controller_file import checked_controller
from atleak.catalogue.entries import read_tables
from atleak.common.errors import CatalogueError, InputError

Tables = dict[str, Any]


@pytest.fixture
def tables() -> Tables:
    return copy.deepcopy(read_tables("controllers", "five_speed_2005")[0])


def faults_of(tables: Tables) -> dict[tuple[str | int, ...], InputError]:
    with pytest.raises(CatalogueError) as caught:
        checked_controller(tables, "my unit")
    faults = [caught.value, *caught.value.others]
    assert all(fault.place.file == "my unit" for fault in faults)
    return {fault.place.steps: fault for fault in faults}


def test_a_fault_in_every_table_is_named_once_whether_of_type_or_of_meaning(tables: Tables) -> None:
    tables["date"] = "yesterday"
    tables["materials"]["aluminium"]["expansion_per_k"] = "21.3e-6"
    tables["pump"]["volumetric_efficiency"] = 1.2
    tables["operating_points"][1]["gear"] = 9
    tables["circuits"][3]["feeds"][0]["from"] = "nowhere"
    tables["circuits"][4]["feeds"][0]["diameter_mm"] = "1,5"
    tables["components"][2]["lands"][0]["nominal_diameter_mm"] = -9.0
    tables["components"][1]["lands"][2]["body"] = "brass"
    tables["gaps"][0]["gears"] = [17]
    tables["gaps"][1]["land"] = 8
    tables["leaks"][1]["from"] = "p_x"
    tables["consumers"][0]["flow_dm3_min"]["hot_idel"] = 1.0
    tables["permissible_pressure"][0]["low_kpa"] = 5000.0
    tables["complaints"][0]["conditions"] = ["reverse"]
    tables["repairs"] = [{"id": "sleeve", "component": "none", "kind": "sleeve", "name": "a sleeve", "source": "x"}]
    faults = faults_of(tables)
    assert set(faults) == {
        ("date",),
        ("materials", "aluminium", "expansion_per_k"),
        ("pump", "volumetric_efficiency"),
        ("operating_points", 1, "gear"),
        ("circuits", 3, "feeds", 0, "from"),
        ("circuits", 4, "feeds", 0, "diameter_mm"),
        ("components", 2, "lands", 0, "nominal_diameter_mm"),
        ("components", 1, "lands", 2, "body"),
        ("gaps", 0, "gears"),
        ("gaps", 1, "land"),
        ("leaks", 1, "from"),
        ("consumers", 0, "flow_dm3_min"),
        ("permissible_pressure", 0),
        ("complaints", 0, "conditions"),
        ("repairs", 0, "component"),
    }
    assert faults[("circuits", 3, "feeds", 0, "from")].place.table == "circuits[4] (overdrive_band).feeds[1]"
    assert faults[("gaps", 1, "land")].value == 8


def test_places_are_those_among_all_tables_where_others_before_them_were_set_aside(tables: Tables) -> None:
    tables["gaps"][0]["gears"] = "all"
    tables["components"][0]["lands"][0]["nominal_diameter_mm"] = "14,5"
    tables["components"][0]["lands"][2]["spool"] = "steal"
    tables["gaps"][5]["gears"] = [17]
    assert set(faults_of(tables)) == {
        ("gaps", 0, "gears"),
        ("components", 0, "lands", 0, "nominal_diameter_mm"),
        ("components", 0, "lands", 2, "spool"),
        ("gaps", 5, "gears"),
    }


@pytest.mark.parametrize(
    ("change", "place"),
    [
        (lambda t: t["components"][1].update(lands="three"), ("components", 1, "lands")),
        (lambda t: t["circuits"][2].update(name=3), ("circuits", 2, "name")),
        (lambda t: t["operating_points"][1].update(temperature_c="hot"), ("operating_points", 1, "temperature_c")),
        (lambda t: t["materials"]["aluminium"].update(source=""), ("materials", "aluminium", "source")),
        (lambda t: t["pump"].update(colour="red"), ("pump", "colour")),
        (lambda t: t["defaults"].update(contact_length_mm=-1.0), ("defaults", "contact_length_mm")),
        (lambda t: t["defaults"].update(body=3), ("defaults", "body")),
        (lambda t: t["defaults"].update(body="brass"), ("defaults", "body")),
        (lambda t: t.update(defaults="aluminium"), ("defaults",)),
        (lambda t: t["gears"].__setitem__(3, "third"), ("gears", 3)),
        (lambda t: t["components"].__setitem__(5, "plug"), ("components", 5)),
        (lambda t: t["components"][11].pop("id"), ("components", 11, "id")),
        (lambda t: t["components"][11].update(lands=None), ("components", 11, "lands")),
        (lambda t: t["components"][3]["lands"][1].update(land=2000), ("components", 3, "lands", 1, "land")),
        (lambda t: t["components"][3]["lands"].__setitem__(1, 2.0), ("components", 3, "lands", 1)),
        (lambda t: t["circuits"][3].update(id="Overdrive Band"), ("circuits", 3, "id")),
        (lambda t: t["operating_points"][1].pop("name"), ("operating_points", 1, "name")),
        (lambda t: t.update({"[key]": 1}), ("[key]",)),
        (lambda t: t["leaks"][1].update({"[key]": 1}), ("leaks", 1, "[key]")),
    ],
)
def test_what_only_follows_from_a_fault_is_no_other_fault(
    tables: Tables, change: Callable[[Tables], None], place: tuple[str | int, ...]
) -> None:
    change(tables)
    assert set(faults_of(tables)) == {place}


def test_an_unknown_key_is_named_beside_a_wrong_one_of_the_same_table(tables: Tables) -> None:
    tables["pressures"] = {"p_s": {"relation": "line", "ratio": "one", "offset_kpa": 0.0, "source": "x", "colour": 1}}
    assert set(faults_of(tables)) == {("pressures", "p_s", "ratio"), ("pressures", "p_s", "colour")}


def test_complaints_may_name_a_land_that_has_a_fault_of_its_own(tables: Tables) -> None:
    tables["complaints"][0]["lands"] = ["boost_valve/1"]
    tables["components"][1]["lands"][0]["body"] = "brass"
    assert set(faults_of(tables)) == {("components", 1, "lands", 0, "body")}


def test_a_repair_of_all_lands_may_name_a_component_whose_only_land_has_a_fault(tables: Tables) -> None:
    (land,) = tables["components"][14]["lands"]
    land["contact_length_mm"] = "long"
    repair = {"id": "kit", "component": tables["components"][14]["id"], "kind": "sleeve", "name": "kit", "source": "x"}
    tables["repairs"] = [repair]
    assert set(faults_of(tables)) == {("components", 14, "lands", 0, "contact_length_mm")}


@pytest.mark.parametrize(
    ("stated", "place", "said"),
    [
        ({}, (), "[repairs[1] (kit)]: the keys of this table do not go together; expected either component or"),
        ({"component": "boost_valve", "components": "all"}, (), "either component or components"),
        ({"components": "all", "lands": [1]}, (), "lands beside a single component alone"),
        (
            {"components": "every"},
            ("components",),
            "'components': value not accepted (found 'every'); expected a list",
        ),
        ({"components": []}, ("components",), '["8", "9"], or "all"'),
        ({"components": ["boost_valve", "boost_valve"]}, ("components",), "each once"),
        ({"components": ["boost_valve", "bost_valve"]}, ("components",), "did you mean 'boost_valve'?"),
    ],
)
def test_a_repair_names_one_component_or_those_of_a_kit(
    tables: Tables, stated: Tables, place: tuple[str, ...], said: str
) -> None:
    tables["repairs"] = [{"id": "kit", "kind": "other", "name": "kit", "source": "made up", **stated}]
    ((where, fault),) = faults_of(tables).items()
    assert where[:2] == ("repairs", 0)
    assert not place or where[2:] == place
    assert said in str(fault)


def test_a_kit_mends_every_land_of_its_components_and_a_body_all_there_are(tables: Tables) -> None:
    first, second = (component["id"] for component in tables["components"][1:3])
    kit = {"kind": "other", "source": "made up"}
    tables["repairs"] = [
        {"id": "kit", "components": [second, first], "name": "kit", **kit},
        {"id": "body", "components": "all", "name": "remanufactured body", **kit},
    ]
    controller = checked_controller(tables)
    two, body = controller.repairs
    assert two.components == (second, first)
    assert two.lands == tuple(land.key for name in (second, first) for land in controller.lands_of(name))
    assert set(body.lands) == {land.key for land in controller.lands}
    assert controller.repairs_of(first) == (two, body)


def test_tables_of_which_nothing_can_be_said_name_what_is_missing() -> None:
    assert set(faults_of({"id": "x", "gears": [1, 2]})) == {
        (key,) for key in ("name", "source", "date", "materials", "pump", "operating_points", "components")
    }
