"""What a diagnosis shows in a notebook and at the prompt: the record's tables, a picture, and never megabytes."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

import pandas as pd
import pytest

import atleak
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.json.diagnosis import diagnosis_record


def test_the_tables_are_those_of_the_record(sample: Diagnosis) -> None:
    record, tables = diagnosis_record(sample), sample.tables()
    assert {"lands", "lands_at_conditions", "gaps", "conditions", "messages"} <= set(tables)
    assert len(tables["conditions"]) == len(record["conditions"])
    for row, (key, land) in zip(record["lands"], sample.to_frame().iterrows(), strict=True):
        assert key == (row["component"], row["land"])
        assert land["radial_clearance_um"] == row["radial_clearance_um"]
        assert land["verdict"] == row["verdict"]


def test_circuits_stand_by_condition(worn_clutch: Diagnosis) -> None:
    circuits = worn_clutch.tables()["circuits"]
    assert set(circuits["condition"]) == {each.condition.name for each in worn_clutch.projections}
    assert circuits["pressure_kpa"].dtype == float


def test_no_cell_holds_a_table_of_its_own(sample: Diagnosis) -> None:
    for name, table in sample.tables().items():
        assert isinstance(table, pd.DataFrame)
        assert not table.map(lambda cell: isinstance(cell, list | dict)).any(axis=None), name


def test_the_page_of_a_notebook_has_answer_picture_and_table(sample: Diagnosis) -> None:
    page = sample._repr_html_()
    assert page.count("<svg") == page.count("</svg>") == 1
    assert page.count("<table") == 1
    assert str(sample.verdict) in page
    assert len(page) < 100_000


def held(value: object) -> list[object]:
    """A result, and all results that its fields hold."""
    if not is_dataclass(value) or isinstance(value, type):
        return []
    return [value, *(getattr(value, each.name) for each in fields(value) if is_dataclass(getattr(value, each.name)))]


def test_no_result_floods_the_prompt(sample: Diagnosis, worn_clutch: Diagnosis) -> None:
    results = [
        *held(sample),
        *held(worn_clutch),
        *sample.projections,
        *sample.lands,
        *sample.total_rules,
        atleak.plan_repairs(sample),
    ]
    assert len(results) > 60
    assert {type(each).__name__: len(repr(each)) for each in results if len(repr(each)) > 2000} == {}


@pytest.mark.parametrize("name", ["Controller", "Limits", "Readings", "RoadTest", "Unit"])
def test_what_is_cut_says_so(name: str, sample: Diagnosis) -> None:
    found = {type(each).__name__: repr(each) for each in held(sample)}
    found["RoadTest"] = repr(sample.road.road_test) if sample.road else ""
    assert found[name].startswith(f"{name}(")
    assert "..." in found[name] or found[name].endswith("…)")
