"""What every land leaks at every condition, and what of it the pump feels."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import controllers, load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits, RuleKind
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.engine.profile import PAPER, PROFILES, WORKSHOP, Profile
from atleak.measurements.readings import Readings
from atleak.report.json.diagnosis import diagnosis_record, to_json
from atleak.report.tables.lands import MatrixRow, condition_matrix, leaking_worst_first, matrix_table
from tests.unit.conftest import by_turns

Edited = Callable[..., Path]
Build = Callable[..., Readings]
SLOW = pytest.mark.slow
KEYS = {"name", "label", "leakage_dm3_min", "drawn_from_pump_dm3_min", "share_percent", "verdict"}


def row_of(diagnosis: Diagnosis, key: tuple[str, int]) -> MatrixRow:
    return next(row for row in condition_matrix(diagnosis) if row.land.key == key)


@pytest.mark.parametrize(
    ("controller", "profile"),
    [  # one with circuits and one without; the others in the longer round
        pytest.param(*each, id=each[0].id, marks=() if each[0].id in ("four_speed_2023", "five_speed_2005") else SLOW)
        for each in by_turns(controllers(), PROFILES.values())
    ],
)
def test_shares_of_lands_and_what_leaks_beside_them_add_up_to_the_total_at_every_condition(
    controller: Controller, profile: Profile, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    worn = {
        land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * (1.0 + 0.1 * number) * land.new_clearance)
        for number, land in enumerate(controller.lands)
    }
    diagnosis = diagnose(controller, hipol, limits, readings=readings_of(controller, worn), profile=profile)
    record = json.loads(to_json(diagnosis_record(diagnosis)))
    for number, condition in enumerate(record["conditions"]):
        cells = [land["conditions"][number] for land in record["lands"]]
        assert {(cell["name"], cell["label"]) for cell in cells} == {(condition["name"], condition["label"])}
        beside = condition["other_leakage_dm3_min"]
        drawn = math.fsum(cell["drawn_from_pump_dm3_min"] for cell in cells)
        assert drawn + beside == pytest.approx(condition["leakage_dm3_min"], rel=1e-9, abs=0.0)
        share = math.fsum(cell["share_percent"] for cell in cells) + 100.0 * beside / condition["pump_capacity_dm3_min"]
        assert share == pytest.approx(condition["share_percent"], rel=1e-9, abs=0.0)
        assert bool(beside) == bool(controller.leaks)


def test_each_cell_is_judged_by_the_land_s_own_rule_there(sample: Diagnosis) -> None:
    record = json.loads(to_json(diagnosis_record(sample)))
    for land in record["lands"]:
        verdicts = {rule["rule"]: rule["verdict"] for rule in land["rules"]}
        values = {rule["rule"]: rule["value"] for rule in land["rules"]}
        for cell in land["conditions"]:
            assert cell.keys() >= KEYS
            assert cell["verdict"] == verdicts[f"share_{cell['name']}_percent"]
            assert cell["share_percent"] == pytest.approx(values[f"share_{cell['name']}_percent"], rel=1e-12, abs=0.0)
            assert 0.0 <= cell["drawn_from_pump_dm3_min"] <= cell["leakage_dm3_min"]
        stated = land["conditions"][0]
        for key in ("leakage_dm3_min", "drawn_from_pump_dm3_min", "share_percent"):
            assert stated[key] == land[key]


def test_a_gap_into_a_live_circuit_says_so(four_speed: Controller, hipol: Fluid, limits: Limits) -> None:
    """Land 5/1 leaks from main into modulated pressure; the article counts that as drawn from the pump all the same."""
    row = row_of(diagnose(four_speed, hipol, limits), ("5", 1))
    assert [cell.elsewhere for cell in row.cells] == ["leaks into p_m, not drawn from the pump"] * 2
    assert all(cell.leakage > 0.0 == cell.drawn_from_pump == cell.share for cell in row.cells)
    as_printed = row_of(diagnose(four_speed, hipol, limits, profile=PAPER), ("5", 1))
    assert as_printed.elsewhere == ""
    assert all(cell.share > 0.0 for cell in as_printed.cells)
    only_there = row_of(diagnose(four_speed, hipol, limits), ("8", 1))  # in second gear alone
    assert [bool(cell.elsewhere) for cell in only_there.cells] == [True, False]
    assert only_there.elsewhere


def test_the_matrix_says_it_in_the_reader_s_language(four_speed: Controller, hipol: Fluid, limits: Limits) -> None:
    found = diagnose(four_speed, hipol, limits)
    row = row_of(found, ("5", 1))
    assert matrix_table(found, [row], wording("de")).texts(row)[-1] == "leckt in: p_m, nicht von der Pumpe genommen"


def test_a_circuit_without_a_name_is_another_circuit(edited: Edited, hipol: Fluid, limits: Limits) -> None:
    path = edited("controllers", "minimal_example")
    with path.open("a", encoding="utf-8") as file:
        file.write(
            '\n[[gaps]]\ncomponent = "accumulator"\nland = 1\nsection = "p_g"\nfrom = "p_g"\nto = "drain"\n'
            'gears = [1, 2]\nends_in = "section"\n'
        )
    row = row_of(diagnose(load_controller(path), hipol, limits), ("accumulator", 1))
    assert row.elsewhere == "leaks into another circuit, not drawn from the pump"


def test_a_land_that_was_not_measured_is_never_ok(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    land = minimal.land("accumulator", 1)
    half = {("accumulator", 1): (land.nominal_diameter, None)}
    diagnosis = diagnose(minimal, hipol, limits, readings=readings_of(minimal, half))
    for row in condition_matrix(diagnosis):
        assert {cell.verdict for cell in row.cells} == {Verdict.NOT_MEASURED}
    worn = {("accumulator", 1): (land.nominal_diameter - 250e-6, None)}
    diagnosis = diagnose(minimal, hipol, limits, readings=readings_of(minimal, worn))
    assert all(cell.verdict in {"replace", "critical"} for cell in row_of(diagnosis, ("accumulator", 1)).cells)


def test_without_a_limit_of_a_land_s_share_there_is_no_verdict_of_it(sample: Diagnosis, limits: Limits) -> None:
    readings = sample.readings
    diagnosis = diagnose(sample.controller, sample.fluid, replace(limits, pair_share=None), readings=readings)
    for row in condition_matrix(diagnosis):
        assert {cell.verdict for cell in row.cells} == {None}
    record = json.loads(to_json(diagnosis_record(diagnosis)))
    assert {cell["verdict"] for land in record["lands"] for cell in land["conditions"]} == {None}


def test_the_worst_condition_of_a_land_is_found(sample: Diagnosis) -> None:
    for row in condition_matrix(sample):
        shares = {rule.condition: rule for rule in row.land.rules if rule.kind is RuleKind.PAIR_SHARE}
        worst = row.worst
        for cell in row.cells:
            rank, other = (
                shares[worst.projection.condition].verdict.rank,
                shares[cell.projection.condition].verdict.rank,
            )
            assert (rank, worst.share) >= (other, cell.share)


def test_the_lands_that_leak_come_worst_first(sample: Diagnosis) -> None:
    rows = leaking_worst_first(sample)
    order = [(-row.land.verdict.rank, -max(cell.share for cell in row.cells)) for row in rows]
    assert order == sorted(order)
    silent = {row.land.key for row in condition_matrix(sample)} - {row.land.key for row in rows}
    assert silent
    for projection in sample.projections:
        assert all(projection.leakage_of(key) == 0.0 for key in silent)


def test_a_pump_that_delivers_nothing_has_no_share(sample: Diagnosis, limits: Limits) -> None:
    still = replace(sample.projection.condition, name="stated", engine_speed=1e-3)
    readings = sample.readings
    diagnosis = diagnose(sample.controller, sample.fluid, limits, readings=readings, condition=still, profile=WORKSHOP)
    record = json.loads(to_json(diagnosis_record(diagnosis)))
    drawing = [land["conditions"][0] for land in record["lands"] if land["drawn_from_pump_dm3_min"] > 0.0]
    assert drawing
    assert {(cell["share_percent"], cell["verdict"]) for cell in drawing} == {(None, None)}
    assert leaking_worst_first(diagnosis)
