"""A fleet in numbers: which visits, units and groups count in what, on a few units made for it."""

from __future__ import annotations

import datetime as dt
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.fleet.summary import summed_up
from atleak.fleet.summary_words import FleetWords
from tests.unit.fleet.few_units import Measured, Unit, condition, results_of, temperature_class

_NEAR = 1e-9  # in per cent, kPa and s
WORN = Measured(90.0, Verdict.REPLACE)
NOT_MEASURED = Measured(None, Verdict.NOT_MEASURED, "not_measured")


def test_of_several_visits_the_last_measured_one_counts(tmp_path: Path) -> None:
    key = ("8", 1)
    visits = [
        Unit("first", {key: Measured(50.0, Verdict.WATCH)}, own={"date": dt.date(2026, 1, 5), "mileage_km": 9e4}),
        Unit("second", {key: WORN}, own={"date": dt.date(2026, 2, 5), "mileage_km": 2e5}),
        Unit("log alone", {key: NOT_MEASURED}, own={"date": dt.date(2026, 3, 5), "mileage_km": 2.1e5}),
    ]
    visits = [Unit(**{**vars(each), "own": {**each.own, "serial": "AB 12-3"}}) for each in visits]
    visits[1] = Unit(**{**vars(visits[1]), "own": {**visits[1].own, "serial": "ab123"}})
    other = Unit("other", {key: Measured(20.0)}, own={"vin": "WDB 99", "serial": "unknown", "mileage_km": 4e4})
    elsewhere = Unit("elsewhere", {key: Measured(20.0)}, "body_b", own={"serial": "AB 12-3"})
    summary = summed_up(results_of(tmp_path, [*visits, other, elsewhere]))
    body = summary.body("body_a")
    assert (summary.visits, summary.counts.units, body.visits, body.counts.units) == (5, 3, 4, 2)
    assert (body.counts.verdicts[Verdict.REPLACE], body.counts.verdicts[Verdict.OK]) == (1, 1)
    assert (body.pairs[0].replace.count, body.pairs[0].replace.of) == (1, 2)
    unit = next(each for each in summary.worst if each.verdict is Verdict.REPLACE)
    assert (unit.name, unit.visits) == ("second", 3)
    wear = body.wear[0]
    assert [part.wear_percent.median for part in wear.classes] == [20.0, 50.0, 90.0], "all visits over mileage"
    assert wear.latest_percent is not None
    assert (wear.latest_percent.units, wear.latest_percent.mean) == (2, 55.0)


def test_a_unit_counts_once_in_a_class_of_mileage(tmp_path: Path) -> None:
    own = {"serial": "7", "mileage_km": 61e3}
    visits = [
        Unit(f"visit {day}", {("8", 1): Measured(wear)}, own={**own, "date": dt.date(2026, 1, day)})
        for day, wear in ((9, 30.0), (2, 10.0), (5, 20.0))
    ]
    (land,) = summed_up(results_of(tmp_path, visits)).bodies[0].wear
    assert [(part.wear_percent.units, part.wear_percent.mean) for part in land.classes] == [(1, 30.0)]


def test_a_clearance_that_new_pairs_have_counts_as_no_wear(tmp_path: Path) -> None:
    own = {"mileage_km": 61e3}
    units = [
        Unit("within", {("8", 1): Measured(-56.0, clearances=(6.4, 9.0, 20.0))}, own=own),
        Unit("tighter", {("8", 1): Measured(-75.0, clearances=(6.4, 5.0, 20.0))}, own=own),
        Unit("one number", {("8", 1): Measured(-10.0, clearances=(20.0, 18.0, 20.0))}, own=own),
        Unit("not stated", {("8", 1): Measured(30.0)}, own=own),
    ]
    (land,) = summed_up(results_of(tmp_path, units)).bodies[0].wear
    assert land.latest_percent is not None
    assert land.latest_percent.mean == pytest.approx((0.0 - 75.0 - 10.0 + 30.0) / 4.0, abs=_NEAR)


def test_visits_without_a_date_follow_their_mileage(tmp_path: Path) -> None:
    visits = [
        Unit(f"at {km}", {("8", 1): Measured(km / 1e3)}, own={"serial": "7", "mileage_km": km})
        for km in (90e3, 120e3, 30e3)
    ]
    (unit,) = summed_up(results_of(tmp_path, visits)).worst
    assert (unit.mileage_km, unit.visits) == (120e3, 3)


def test_results_without_serial_number_and_vin_are_units_of_their_own_and_said_to_be(tmp_path: Path) -> None:
    units = [Unit(f"u{n}", {("8", 1): Measured()}, own={"serial": None, "vin": "unknown"}) for n in range(2)]
    summary = summed_up(results_of(tmp_path, [*units, Unit("known", {("8", 1): Measured()})]))
    assert summary.counts.units == 3
    assert [message.code for message in summary.messages] == ["not_told_apart"]
    assert summary.messages[0].text.startswith("2 of 3 results state neither")


def test_what_was_not_measured_is_in_no_rate_and_not_ok(tmp_path: Path) -> None:
    keys = [("8", 1), ("8", 2), ("9", 1)]
    units = [
        Unit("nothing", dict.fromkeys(keys, NOT_MEASURED)),
        Unit("in part", {keys[0]: Measured(), keys[1]: NOT_MEASURED, keys[2]: NOT_MEASURED}),
        Unit("whole", {keys[0]: Measured(), keys[1]: WORN, keys[2]: Measured(5.0, Verdict.OK, seal="ring")}),
        Unit("half", {keys[0]: Measured(70.0, Verdict.WATCH, "spool_only"), keys[1]: NOT_MEASURED}),
    ]
    body = summed_up(results_of(tmp_path, units)).bodies[0]
    assert (body.counts.units, body.counts.judged, body.counts.ok_in_part) == (4, 3, 1)
    assert (body.counts.verdicts[Verdict.NOT_MEASURED], body.counts.verdicts[Verdict.OK]) == (1, 1)
    assert body.counts.rates[Verdict.WATCH].of == 3
    pairs = {each.key: each for each in body.pairs}
    assert (pairs[keys[0]].flagged.count, pairs[keys[0]].flagged.of, pairs[keys[0]].not_measured) == (0, 2, 2)
    assert pairs[keys[0]].flagged_by_one_part == 1
    assert (pairs[keys[1]].replace.count, pairs[keys[1]].replace.of) == (1, 1)
    assert (pairs[keys[2]].flagged.of, pairs[keys[2]].not_measured) == (0, 4)
    wear = {each.key: each.latest_percent for each in body.wear}
    assert wear[keys[2]] is None, "a ring seals it"
    assert [each.units for each in (wear[keys[0]], wear[keys[1]]) if each is not None] == [2, 1]


def test_a_unit_with_a_log_alone_is_in_no_rate_and_is_counted(tmp_path: Path) -> None:
    lands = {("1", 1): WORN}
    units = [
        Unit("worn", lands),
        Unit("log", verdict=Verdict.OK, own={"road_rows": 1200}),
        Unit("slack", verdict=Verdict.WATCH, own={"decided_by_kind": "permissible_pressure", "road_rows": 1200}),
        Unit("half", {("1", 1): replace(WORN, status="not_measured")}, own={"readings_sha256": "a" * 64}),
    ]
    counts = summed_up(results_of(tmp_path, units)).counts
    assert (counts.units, counts.judged, counts.without_sheet) == (4, 2, 2)
    assert (counts.rates[Verdict.WATCH].count, counts.rates[Verdict.WATCH].of) == (2, 2)
    assert (counts.verdicts[Verdict.OK], counts.verdicts[Verdict.WATCH]) == (1, 1)


def test_a_unit_with_a_sheet_of_which_no_land_was_judged_is_in_no_rate(tmp_path: Path) -> None:
    unmeasured = {("1", 1): NOT_MEASURED}
    sheet = {"readings_sha256": "a" * 64, "road_rows": 1200}
    units = [
        Unit("worn", {("1", 1): WORN}, own={**sheet, "lands_judged": 1}),
        Unit("half", {("1", 1): WORN}, own={**sheet, "lands_measured": 0, "lands_judged": 1}),
        Unit("by its log", unmeasured, verdict=Verdict.WATCH, own={**sheet, "lands_judged": 0}),
        Unit("ok by its log", unmeasured, verdict=Verdict.OK, own={**sheet, "lands_judged": 0}),
        Unit("a ring", {**unmeasured, ("2", 1): Measured(seal="ring")}, own={**sheet, "lands_judged": 0}),
    ]
    counts = summed_up(results_of(tmp_path, units)).counts
    assert (counts.judged, counts.without_sheet, counts.rates[Verdict.WATCH].of) == (2, 3, 2)
    assert counts.rates[Verdict.WATCH].count == 2
    assert counts.ok_throughout == 0, "no land of theirs was judged"


def test_a_valve_body_that_the_catalogue_does_not_have_is_named_as_the_results_name_it(tmp_path: Path) -> None:
    units = [Unit(f"{n}", {("1", 1): Measured()}, own={"controller_name": f"Own {n % 3 // 2}"}) for n in range(5)]
    words = FleetWords(summed_up(results_of(tmp_path, units)), wording("en"))
    assert words.body("body_a") == "Own 0"
    nameless = summed_up(results_of(tmp_path / "nameless", [Unit("a", {("1", 1): Measured()})]))
    assert FleetWords(nameless, wording("en")).body("body_a") == "body_a"


def test_few_units_have_counts_and_no_interval(tmp_path: Path) -> None:
    def units(number: int) -> list[Unit]:
        lands = {("8", 1): WORN}
        own = {"mileage_km": 1e5}
        return [
            Unit(f"{number} {n}", lands, conditions=[condition(20.0 + n)], temperatures=[temperature_class()], own=own)
            for n in range(number)
        ]

    few, enough = (summed_up(results_of(tmp_path / str(n), units(n))).bodies[0] for n in (9, 10))
    for body, number in ((few, 9), (enough, 10)):
        rates = (body.counts.rates[Verdict.WATCH], body.pairs[0].replace, body.deciders[0].units)
        spreads = (
            *(body.wear[0].latest_percent, body.wear[0].classes[0].wear_percent),
            *(body.conditions[0].share_percent, body.temperatures[0].share_percent),
        )
        assert [rate.of for rate in rates] == [number] * 3
        assert [spread.units for spread in spreads if spread] == [number] * 4
        assert {rate.low_percent is None for rate in rates} == {number < 10}
        assert {spread.quantiles is None for spread in spreads if spread} == {number < 10}


def test_groups_of_few_units_are_counted_and_not_compared(tmp_path: Path) -> None:
    random = np.random.default_rng(1)
    sizes = {"few": 4, "some": 12, " ": 3}
    units = [
        Unit(f"{name} {n}", {("8", 1): Measured(float(random.normal(30.0, 5.0)))}, own={"group": name})
        for name, size in sizes.items()
        for n in range(size)
    ]
    summary = summed_up(results_of(tmp_path, units), by="group")
    comparison = summary.bodies[0].comparison
    assert comparison is not None
    assert (summary.not_stated, comparison.not_stated) == (3, 3)
    assert [(group.name, group.counts.units) for group in comparison.groups] == [("few", 4), ("some", 12)]
    (of_land,) = comparison.lands
    points = [*(each.points for each in comparison.verdicts), of_land.mean_points]
    assert all(each is not None and each.low is None and each.differs is None for each in points)
    assert of_land.same_mileage_points is None, "nobody stated a mileage"
    assert [message.code for message in comparison.messages] == ["few_units"]
    assert "few: fewer than 10 units" in comparison.messages[0].text


def test_groups_of_other_mileage_are_said_to_be(tmp_path: Path) -> None:
    random = np.random.default_rng(4)
    units = [
        Unit(
            f"{group} {n}",
            {("8", 1): Measured(km / 4e3 + float(random.normal(0.0, 2.0)))},
            own={"group": group, "mileage_km": km},
        )
        for group, further in (("far", 60e3), ("near", 0.0))
        for n, km in enumerate(random.uniform(60e3, 200e3, 40) + further)
    ]
    comparison = summed_up(results_of(tmp_path, units), by="group").bodies[0].comparison
    assert comparison is not None
    (message,) = comparison.messages
    assert (message.level, message.code) == ("warning", "other_mileage")
    assert message.text.startswith("far: driven ")
    (of_land,) = comparison.lands
    assert of_land.mean_points is not None
    assert of_land.same_mileage_points is not None
    assert (of_land.mean_points.differs, of_land.same_mileage_points.differs) == (True, False)
    assert of_land.mean_points.value > 10.0
    assert abs(of_land.same_mileage_points.value) < 3.0


def test_lands_that_were_repaired_are_counted_apart_from_wear(tmp_path: Path) -> None:
    units = [
        Unit("worn", {("8", 1): Measured(60.0)}, own={"mileage_km": 1e5}),
        Unit("repaired", {("8", 1): Measured(2.0, fitted_repair="sleeve")}, own={"mileage_km": 1e5}),
    ]
    body = summed_up(results_of(tmp_path, units)).bodies[0]
    (land,) = body.wear
    assert (land.repaired, land.latest_percent and land.latest_percent.mean) == (1, 60.0)
    assert body.pairs[0].flagged.of == 2, "a repaired land is judged like any other"


def test_valve_bodies_share_no_statistics_of_a_land(tmp_path: Path) -> None:
    units = [
        Unit(f"{body} {n}", {("8", 1): Measured(wear)}, body) for body, wear in (("a", 10.0), ("b", 90.0)) for n in "12"
    ]
    summary = summed_up(results_of(tmp_path, units))
    assert [body.wear[0].latest_percent and body.wear[0].latest_percent.mean for body in summary.bodies] == [10.0, 90.0]


def test_conditions_of_one_name_that_are_not_one_stay_apart(tmp_path: Path) -> None:
    units = [
        Unit("hot", {("8", 1): Measured()}, conditions=[condition(10.0)]),
        Unit("hotter", {("8", 1): Measured()}, conditions=[condition(30.0, temperature_c=130.0)]),
        Unit("other pressure", {("8", 1): Measured()}, conditions=[condition(20.0, p_g_kpa=500.0)]),
        Unit("without", {("8", 1): Measured(), ("8", 2): NOT_MEASURED}, conditions=[condition(None)]),
        Unit("not measured", {("8", 1): NOT_MEASURED}, conditions=[condition(5.0)]),
    ]
    first, second = summed_up(results_of(tmp_path, units)).bodies[0].conditions
    by_temperature = {each.temperature_c: each for each in (first, second)}
    hot = by_temperature[110.0]
    assert hot.share_percent is not None
    assert (hot.share_percent.units, hot.share_percent.mean, hot.required_kpa, hot.partly) == (2, 15.0, None, 1)
    assert by_temperature[130.0].required_kpa == 450.0


def test_of_logs_the_last_of_each_unit_counts_and_what_it_lacks_is_none(tmp_path: Path) -> None:
    lands = {("8", 1): Measured()}
    units = [
        Unit(
            "earlier",
            lands,
            temperatures=[temperature_class(share_mean_percent=90.0)],
            own={"serial": "7", "date": dt.date(2026, 1, 1)},
        ),
        Unit(
            "later",
            lands,
            temperatures=[temperature_class(seconds=180.0, share_mean_percent=20.0, pressure_mean_kpa=None)],
            own={"serial": "7", "date": dt.date(2026, 1, 2)},
        ),
        Unit("without a log", lands, own={"serial": "7", "date": dt.date(2026, 1, 3)}),
        Unit("another", lands, temperatures=[temperature_class(share_mean_percent=40.0, pressure_mean_kpa=None)]),
    ]
    (found,) = summed_up(results_of(tmp_path, units)).bodies[0].temperatures
    assert (found.seconds, found.share_mean_percent) == (240.0, 25.0)
    assert found.share_percent is not None
    assert (found.share_percent.units, found.share_percent.mean) == (2, 30.0)
    assert (found.pressure_mean_kpa, found.pressure_kpa, found.bands_percent) == (None, None, None)


def test_time_in_green_of_units_that_were_measured_in_part_is_told_apart(tmp_path: Path) -> None:
    times = {"green_s": 30.0, "amber_s": 10.0, "red_s": 0.0, "critical_s": 0.0}
    whole, part = ({"lands_measured": count, "lands_total": 1} for count in (1, 0))
    units = [
        Unit("whole", {("8", 1): Measured()}, temperatures=[temperature_class(**times)], own=whole),
        Unit("part", {("8", 1): Measured()}, temperatures=[temperature_class(**times)], own=part),
        Unit("part too", temperatures=[temperature_class(**(times | {"green_s": 10.0}))], own=part),
    ]
    (found,) = summed_up(results_of(tmp_path, units)).bodies[0].temperatures
    assert found.bands_percent is not None
    assert (found.bands_percent["green"], found.green_in_part_percent) == pytest.approx((70.0, 40.0), abs=_NEAR)


def test_units_that_were_judged_otherwise_are_said_to_be(tmp_path: Path) -> None:
    columns = ("controller_sha256", "limits_sha256", "fluid_sha256", "profile")
    units = [Unit(f"u{n}", {("8", 1): Measured()}, own=dict.fromkeys(columns, str(n))) for n in range(2)]
    (body,) = summed_up(results_of(tmp_path, units)).bodies
    assert [each.code for each in body.messages] == [
        f"various_{name}" for name in ("controller", "limits", "fluid", "profile")
    ]


def test_what_decided_besides_lands_is_counted(tmp_path: Path) -> None:
    circuit = {"decided_by_kind": "circuit", "decided_by_circuit": "k1"}
    units = [Unit(f"c{n}", {("8", 1): Measured()}, verdict=Verdict.CRITICAL, own=circuit) for n in range(2)]
    units.append(Unit("land", {("8", 1): WORN}))
    body = summed_up(results_of(tmp_path, units)).bodies[0]
    found = [
        (each.kind, each.component, each.land, each.circuit, each.units.count, each.units.of) for each in body.deciders
    ]
    assert found == [("circuit", None, None, "k1", 2, 3), ("land", "8", 1, None, 1, 3)]


def test_components_stand_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    keys = [("10", 1), ("2", 2), ("2", 1), ("12'", 1), ("valve", 1)]
    body = summed_up(results_of(tmp_path, [Unit("one", dict.fromkeys(keys, Measured()))])).bodies[0]
    assert [land.key for land in body.wear] == [("valve", 1), ("2", 1), ("2", 2), ("10", 1), ("12'", 1)]


def test_of_very_many_groups_the_largest_are_compared_with_all_others(tmp_path: Path) -> None:
    random = np.random.default_rng(6)
    sizes = {f"g{n:02}": 12 if n < 2 else 1 for n in range(40)}
    units = [
        Unit(
            f"{name} {n}",
            {("8", 1): Measured(float(random.normal(40.0 if name == "g01" else 20.0, 3.0)))},
            own={"group": name},
        )
        for name, size in sizes.items()
        for n in range(size)
    ]
    (body,) = summed_up(results_of(tmp_path, units), by="group").bodies
    comparison = body.comparison
    assert comparison is not None
    assert len(comparison.groups) == 40
    assert not comparison.in_pairs
    assert {each.second for each in comparison.verdicts} == {None}
    assert len({each.first for each in comparison.lands}) == 30
    assert [each.first for each in comparison.lands if each.mean_points and each.mean_points.differs] == ["g01"]
    second = comparison.lands[0].second_percent
    assert (comparison.lands[0].second, second and second.units) == (None, len(units) - 12)
    means = [
        [unit.lands["8", 1].wear for unit in units if (unit.own["group"] == "g01") is mine] for mine in (True, False)
    ]
    points = comparison.lands[0].mean_points
    assert points is not None
    assert points.value == pytest.approx(np.mean(means[0]) - np.mean(means[1]), abs=_NEAR)
    assert {each.second_units for each in comparison.verdicts if each.first == "g01"} == {len(units) - 12}
    assert "many_groups" in {message.code for message in comparison.messages}
