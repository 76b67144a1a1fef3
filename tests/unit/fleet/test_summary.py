"""A fleet in numbers: every number against one that is counted otherwise, and what it means on other units."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from atleak.analysis.rates import SHOWN_QUANTILES, Rate, Spread
from atleak.common.errors import FleetError, InputError
from atleak.common.verdicts import Verdict
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.equations.proportions import newcombe_interval, wilson_interval
from atleak.fleet.results import Results
from atleak.fleet.summary import summed_up
from atleak.fleet.sums import FleetSummary, ValveBody
from atleak.fleet.worker import rows_of_result
from tests.unit.fleet.few_units import Measured, Unit, results_of
from tests.unit.fleet.made_up import CONTROLLERS, ERRORS, GROUPS, WORSE, WORSE_BY, made_up_results
from tests.unit.fleet.test_rows import JOB, Named
from tests.unit.fleet.writing import failed

BODY = CONTROLLERS[0]
_NEAR = 1e-9  # in per cent, kPa and s


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fleet")
    made_up_results(folder, units=160)
    return folder


@pytest.fixture(scope="module")
def summary(folder: Path) -> FleetSummary:
    return summed_up(Results.open(folder), by="group")


@pytest.fixture(scope="module")
def body(summary: FleetSummary) -> ValveBody:
    return summary.body(BODY)


def read(folder: Path, data_set: str) -> pd.DataFrame:
    """A data set as other programs read it, of one valve body."""
    rows = pd.read_parquet(folder / data_set)
    return rows[rows["controller"] == BODY]


def assert_spread(found: Spread | None, values: pd.Series) -> None:
    assert found is not None
    known = values.dropna()
    assert (found.units, found.least, found.most) == (len(known), known.min(), known.max())
    assert (found.mean, found.median) == pytest.approx((known.mean(), known.median()), abs=_NEAR)
    if len(known) < 10:
        assert found.quantiles is None
    else:
        assert found.quantiles == pytest.approx([known.quantile(part) for part in SHOWN_QUANTILES], abs=_NEAR)


def assert_rate(found: Rate, count: int, of: int) -> None:
    assert (found.count, found.of) == (count, of)
    low, high = wilson_interval(count, of)
    assert (found.low_percent, found.high_percent) == pytest.approx((100.0 * low, 100.0 * high), abs=_NEAR)


# --- against plain counting ---


def test_units_are_counted_by_verdict_and_decision(folder: Path, summary: FleetSummary, body: ValveBody) -> None:
    units = read(folder, "units")
    assert (summary.visits, summary.counts.units, body.counts.units) == (160, 160, len(units))
    for verdict, count in body.counts.verdicts.items():
        assert count == (units["verdict"] == verdict).sum()
    assert sum(body.counts.verdicts.values()) == sum(body.counts.decisions.values()) == len(units)
    assert body.counts.decisions["fail"] == (units["decision"] == "fail").sum()
    replace = units["verdict"].isin(["replace", "critical"]).sum()
    assert_rate(body.counts.rates[Verdict.REPLACE], replace, len(units))
    assert {group.name: group.counts.units for group in summary.groups} == {
        name: (pd.read_parquet(folder / "units")["group"] == name).sum() for name in GROUPS
    }


def test_the_worst_pairs_are_counted(folder: Path, body: ValveBody) -> None:
    lands, units = read(folder, "lands"), read(folder, "units")
    assert len(body.pairs) == lands.groupby(["component", "land"]).ngroups
    for each in body.pairs:
        component, land = each.key
        mine = lands[(lands["component"] == component) & (lands["land"] == land)]
        mine = mine[mine["measured"] == "measured"]
        assert_rate(each.flagged, mine["verdict"].isin(["watch", "replace", "critical"]).sum(), len(mine))
        assert_rate(each.replace, mine["verdict"].isin(["replace", "critical"]).sum(), len(mine))
        gave = (units["decided_by_component"] == component) & (units["decided_by_land"] == land)
        assert_rate(each.deciding, gave.sum(), len(units))
        assert each.not_measured == len(units) - len(mine)
    counts = [each.replace.count for each in body.pairs]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > counts[-1]


def test_wear_is_spread_by_classes_of_mileage(folder: Path, body: ValveBody) -> None:
    lands = read(folder, "lands").merge(read(folder, "units")[["input_sha256", "mileage_km"]], on="input_sha256")
    for each in body.wear[::7]:
        component, land = each.key
        mine = lands[(lands["component"] == component) & (lands["land"] == land) & lands["wear_percent"].notna()]
        assert_spread(each.latest_percent, mine["wear_percent"])
        assert each.without_mileage == mine["mileage_km"].isna().sum()
        for part in each.classes:
            within = (mine["mileage_km"] >= part.low_km) & (mine["mileage_km"] < part.high_km)
            assert_spread(part.wear_percent, mine.loc[within, "wear_percent"])
        assert sum(part.wear_percent.units for part in each.classes) == mine["mileage_km"].notna().sum()
    medians = [part.wear_percent.median for part in body.wear[0].classes]
    assert medians[0] < medians[-1]


def test_logs_are_weighted_by_their_time(folder: Path, body: ValveBody) -> None:
    rows = read(folder, "temperatures")
    assert [each.low_c for each in body.temperatures] == sorted(rows["temperature_low_c"].unique())
    for each in body.temperatures:
        mine = rows[rows["temperature_low_c"] == each.low_c]
        assert each.seconds == pytest.approx(mine["seconds"].sum(), abs=_NEAR)
        for column, mean, spread in (
            ("share_mean_percent", each.share_mean_percent, each.share_percent),
            ("pressure_mean_kpa", each.pressure_mean_kpa, each.pressure_kpa),
        ):
            assert mean == pytest.approx(np.average(mine[column], weights=mine["seconds"]), abs=_NEAR)
            assert_spread(spread, mine[column])
        assert each.share_max_percent == mine["share_max_percent"].max()
        assert each.pressure_min_kpa == mine["pressure_min_kpa"].min()
        assert each.bands_percent is not None
        assert each.bands_percent["green"] == pytest.approx(
            100.0 * mine["green_s"].sum() / mine["seconds"].sum(), abs=_NEAR
        )
        assert sum(each.bands_percent.values()) == pytest.approx(100.0, abs=_NEAR)


def test_conditions_are_spread_over_the_units(folder: Path, body: ValveBody) -> None:
    rows = read(folder, "conditions")
    assert [each.name for each in body.conditions] == list(rows["name"].unique())
    for each in body.conditions:
        mine = rows[rows["name"] == each.name]
        assert_spread(each.share_percent, mine["share_percent"])
        assert_spread(each.pressure_held_kpa, mine["p_g_held_kpa"])
        assert (each.required_kpa, each.temperature_c) == (mine["p_g_kpa"].iloc[0], mine["temperature_c"].iloc[0])
        assert {band: (mine["band"] == band).sum() for band in each.bands} == each.bands


def test_groups_are_compared_pair_by_pair(folder: Path, body: ValveBody) -> None:
    comparison = body.comparison
    assert comparison is not None
    assert comparison.in_pairs
    pairs = {("north", "south"), ("north", "west"), ("south", "west")}
    assert {(each.first, each.second) for each in comparison.verdicts} == pairs
    units, lands = read(folder, "units"), read(folder, "lands")
    flagged = units["verdict"].ne("ok").groupby(units["group"]).agg(["sum", "size"])
    each = next(each for each in comparison.verdicts if each.verdict is Verdict.WATCH and each.first == "north")
    (x_1, n_1), (x_2, n_2) = flagged.loc["north"], flagged.loc[each.second]
    assert each.points is not None
    assert each.points.value == pytest.approx(100.0 * (x_1 / n_1 - x_2 / n_2), abs=_NEAR)
    own = newcombe_interval(x_2, n_2, x_1, n_1)
    assert (each.points.low, each.points.high) == pytest.approx([100.0 * end for end in own], abs=_NEAR)
    of_all = newcombe_interval(x_2, n_2, x_1, n_1, 1.0 - 0.05 / 3 / 9)  # three kinds of differences, nine rates
    assert (each.points.low_of_all, each.points.high_of_all) == pytest.approx(
        [100.0 * end for end in of_all], abs=_NEAR
    )
    wear = lands.merge(units[["input_sha256", "group"]], on="input_sha256")
    for of_land in comparison.lands:
        component, land = of_land.key
        mine = wear[(wear["component"] == component) & (wear["land"] == land)].groupby("group")["wear_percent"]
        assert of_land.mean_points is not None
        assert of_land.mean_points.value == pytest.approx(
            mine.mean()[of_land.first] - mine.mean()[of_land.second], abs=_NEAR
        )
        assert of_land.median_points == pytest.approx(
            mine.median()[of_land.first] - mine.median()[of_land.second], abs=_NEAR
        )


def test_the_worse_group_is_found_and_others_are_not(summary: FleetSummary) -> None:
    for body in summary.bodies:
        assert body.comparison is not None
        with_worse = [each for each in body.comparison.lands if each.second == WORSE]
        found = [each for each in with_worse if each.same_mileage_points and each.same_mileage_points.differs]
        assert len(found) > 0.6 * len(with_worse)
        for each in found:
            assert each.same_mileage_points is not None
            assert each.same_mileage_points.low_of_all is not None
            assert each.same_mileage_points.high_of_all is not None
            assert each.same_mileage_points.high_of_all < 0.0
        near = [each.same_mileage_points.value for each in with_worse if each.same_mileage_points]
        assert np.mean(near) == pytest.approx(-WORSE_BY, abs=2.5)
        others = [each for each in body.comparison.lands if WORSE not in (each.first, each.second)]
        assert others
        assert not any(each.mean_points and each.mean_points.differs for each in others)
        assert not any(each.same_mileage_points and each.same_mileage_points.differs for each in others)


def test_suppliers_that_do_not_differ_are_not_called_different(folder: Path) -> None:
    for body in summed_up(Results.open(folder), by=" Supplier ", controller=BODY).bodies:
        assert body.comparison is not None
        called = [each.points for each in body.comparison.verdicts]
        called += [each.mean_points for each in body.comparison.lands]
        called += [each.same_mileage_points for each in body.comparison.lands]
        assert not any(points.differs for points in called if points is not None)


def test_the_worst_units_come_first_and_lead_to_their_files(folder: Path, summary: FleetSummary) -> None:
    ranks = [unit.verdict.rank for unit in summary.worst]
    assert ranks == sorted(ranks, reverse=True)
    assert len(summary.worst) == 50
    worst = summary.worst[0]
    row = pd.read_parquet(folder / "units").set_index("reference").loc[worst.reference]
    assert (worst.name, worst.controller, worst.serial) == (row["name"], row["controller"], row["serial"])
    assert (worst.date, worst.decided_by) == (row["date"], (row["decided_by_component"], row["decided_by_land"]))
    lands = pd.read_parquet(folder / "lands").set_index("input_sha256").loc[row["input_sha256"]]
    assert worst.lands_past == lands["verdict"].isin(["replace", "critical"]).sum()
    assert summed_up(Results.open(folder), listed=3).worst == tuple(
        replace(each, label=None) for each in summary.worst[:3]
    )


def test_errors_are_told_by_kind(summary: FleetSummary) -> None:
    assert sum(each.count for each in summary.errors) == ERRORS
    refused = next(each for each in summary.errors if each.kind == "refused")
    assert refused.first == (("north/bad_0.zip", "bad_0.zip: this is what a person would have been told"),)


def test_one_valve_body_alone_is_what_it_is_beside_others(folder: Path, body: ValveBody) -> None:
    alone = summed_up(Results.open(folder), controller=BODY)
    assert alone.bodies == (replace(body, comparison=None),)
    assert alone.counts == body.counts
    kinds = {each.kind for each in summed_up(Results.open(folder), controller=CONTROLLERS[1]).errors}
    assert kinds == {"refused"}, "those of files whose valve body nobody knows, and of no other valve body"


def test_what_was_written_first_changes_nothing(tmp_path: Path) -> None:
    random = np.random.default_rng(2)
    units = [
        Unit(f"u{n}", {("8", 1): Measured(float(random.lognormal(2.0, 0.5)))}, own={"group": "ab"[n % 2]})
        for n in range(30)
    ]
    first, turned = (
        summed_up(results_of(tmp_path / name, order), by="group") for name, order in (("a", units), ("b", units[::-1]))
    )
    assert (first.bodies, first.worst) == (turned.bodies, turned.worst)


def test_a_unit_that_was_diagnosed_is_summed_up_to_its_own_result(
    tmp_path: Path, sample_diagnoses: dict[str, Diagnosis]
) -> None:
    diagnosis = sample_diagnoses["workshop"]
    with Results.open(tmp_path, for_writing=True) as results:
        results.add([rows_of_result(Named(), diagnosis, JOB)])
    summary = summed_up(Results.open(tmp_path), by="supplier")
    (body,), (unit,) = summary.bodies, summary.worst
    assert (body.controller, summary.headings) == (diagnosis.controller.id, ("group", "batch", "supplier"))
    assert (unit.verdict, unit.decision, unit.label) == (diagnosis.verdict, diagnosis.decision, "Almar")
    assert (unit.serial, unit.date, unit.mileage_km) == ("S 7", JOB.date, diagnosis.mileage or 90e3)
    lands = {land.key: land for land in diagnosis.lands}
    assert {each.key for each in body.pairs} == set(lands)
    for each in body.pairs:
        assert each.flagged.count + each.flagged_by_one_part == lands[each.key].verdict.flagged
    for land in body.wear:
        of_unit = lands[land.key]
        whole = of_unit.state.status == "measured" and of_unit.state.land.seal is None
        assert (land.latest_percent is not None) == whole
        if land.latest_percent is not None and of_unit.wear is not None:
            assert land.latest_percent.mean == pytest.approx(100.0 * of_unit.wear, abs=_NEAR)
    for found, projection in zip(body.conditions, diagnosis.projections, strict=True):
        assert found.label == projection.condition.label
        assert found.share_percent is not None
        assert found.share_percent.mean == pytest.approx(100.0 * projection.share, abs=_NEAR)
    assert body.temperatures
    assert sum(each.seconds for each in body.temperatures) > 0.0


# --- what cannot be summed up ---


def test_what_nobody_states_is_refused_with_what_there_is(folder: Path) -> None:
    with pytest.raises(InputError, match=r"supplyer.*supplier"):
        summed_up(Results.open(folder), by="supplyer")
    with pytest.raises(InputError, match=r"four_speed.*four_speed_2023"):
        summed_up(Results.open(folder), controller="four_speed")


def test_what_differs_from_unit_to_unit_makes_no_groups(tmp_path: Path) -> None:
    units = [Unit(str(n), own={"group": f"g{n}"}) for n in range(201)]
    with pytest.raises(InputError, match="201 different values"):
        summed_up(results_of(tmp_path, units), by="group")


def test_results_without_any_unit_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FleetError, match="holds no unit yet"):
        summed_up(results_of(tmp_path, []))


def test_errors_alone_are_a_summary(tmp_path: Path) -> None:
    with Results.open(tmp_path, for_writing=True) as results:
        results.add([failed(f"file:/{number}", str(number)) for number in range(ERRORS)])
    summary = summed_up(Results.open(tmp_path))
    assert (summary.visits, summary.counts.units, summary.bodies, summary.worst) == (0, 0, (), ())
    assert sum(each.count for each in summary.errors) == ERRORS
