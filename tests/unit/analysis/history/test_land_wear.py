"""Rates and crossings from several visits: what counts, what begins a series anew, and what is said instead."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import pytest

from atleak.analysis.history.series import Restart, Visit
from atleak.analysis.history.wear import LandWear, WearHistory, wear_over_mileage
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_tables import NewOrigin
from atleak.catalogue.instruments import load_instruments
from atleak.catalogue.limits import Limits, RuleKind
from atleak.common.verdicts import Verdict

VisitAt = Callable[..., Visit]
REGULATOR, TCC, PISTON = ("pressure_regulator", 1), ("tcc_regulator", 1), ("accumulator", 1)
UM = 1e-6


def codes(history: WearHistory) -> list[str]:
    return [message.code for message in history.messages]


def text_of(history: WearHistory, code: str) -> str:
    return next(message.text for message in history.messages if message.code == code)


def per_10_000(land: LandWear) -> float:
    """The rate of a land [µm per 10 000 km]."""
    assert land.line is not None
    return land.line.rate * 1e4 / UM


def counted(land: LandWear) -> list[tuple[float, float]]:
    """Mileage [km] and clearance [µm] of the points that count."""
    return [(point.mileage, round(point.clearance / UM, 3)) for point in land.series.counted]


def measured_when_new(controller: Controller, **changes: object) -> Controller:
    lands = tuple(replace(land, mounting_measured=True, **changes) for land in controller.lands)
    return replace(controller, lands=lands)


def test_two_visits_tell_a_rate_and_the_mileage_of_each_limit(visit_at: VisitAt, limits: Limits) -> None:
    first, second = visit_at(2024, 100_000.0, {REGULATOR: 20.0}), visit_at(2026, 160_000.0, {REGULATOR: 23.0})
    history = wear_over_mileage([second, first], limits)  # in any order
    land = history.land(REGULATOR)
    assert per_10_000(land) == pytest.approx(0.5, abs=1e-6)
    assert [(limit.kind, limit.level) for limit in land.limits] == [
        (RuleKind.WEAR, Verdict.WATCH),
        (RuleKind.WEAR, Verdict.REPLACE),
    ]
    watch, worn = land.limits
    assert (watch.clearance / UM, worn.clearance / UM) == pytest.approx((22.0, 27.0), abs=1e-9)
    assert watch.past
    assert watch.at is None
    assert land.next_limit is worn
    assert worn.at.value == pytest.approx(240_000.0, rel=1e-6, abs=0.0)
    assert 160_000.0 <= worn.at.low < worn.at.value < worn.at.high


def test_one_visit_gives_no_rate_and_says_so(visit_at: VisitAt, limits: Limits) -> None:
    history = wear_over_mileage([visit_at(2026, 160_000.0, {REGULATOR: 23.0, TCC: 17.0})], limits)
    assert history.with_rate == ()
    assert codes(history) == ["no_wear_over_mileage"]
    assert "0 of 2 measured lands" in text_of(history, "no_wear_over_mileage")
    assert [limit.at for limit in history.land(REGULATOR).limits] == [None, None]


def test_a_mounting_clearance_is_a_point_at_0_km_where_it_was_measured(
    visit_at: VisitAt, limits: Limits, minimal: Controller
) -> None:
    measured = measured_when_new(minimal)
    visit = visit_at(2026, 100_000.0, {REGULATOR: 23.0}, controller=measured)
    assert counted(wear_over_mileage([visit], limits).land(REGULATOR)) == [(0.0, 18.0), (100_000.0, 23.0)]
    fitted = visit_at(2026, 100_000.0, {REGULATOR: 23.0}, controller=measured_when_new(minimal, fitted="sleeve"))
    assert counted(wear_over_mileage([fitted], limits).land(REGULATOR)) == [(100_000.0, 23.0)]


def test_what_an_instrument_errs_counts_at_each_visit_though_both_name_the_same(
    visit_at: VisitAt, limits: Limits
) -> None:
    """A job names a kind of instrument: whether it was the same gauge, with the same setting, nobody knows."""
    one, other = load_instruments("micrometer", "bore_gauge"), load_instruments("air_gauge", "air_gauge")
    for first, second in ((one, one), (one, other)):
        before = visit_at(2024, 1e5, {REGULATOR: 20.0}, instruments=first)
        after = visit_at(2026, 2e5, {REGULATOR: 25.0}, instruments=second)
        line = wear_over_mileage([before, after], limits).land(REGULATOR).line
        u = [land.standard_uncertainty for visit in (before, after) for land in visit.lands if land.key == REGULATOR]
        assert math.sqrt(line.covariance[1, 1]) * 1e5 == pytest.approx(math.hypot(*u), rel=1e-6, abs=0.0)


def test_a_repair_begins_the_series_of_its_land_anew(visit_at: VisitAt, limits: Limits) -> None:
    before = visit_at(2022, 100_000.0, {REGULATOR: 30.0, TCC: 17.0}, repaired=[REGULATOR])
    after = visit_at(2022, 100_000.0, {REGULATOR: 18.5, TCC: 17.0})
    later = visit_at(2026, 160_000.0, {REGULATOR: 21.5, TCC: 20.0})
    history = wear_over_mileage([before, after, later], limits)
    land = history.land(REGULATOR)
    assert counted(land) == [(100_000.0, 18.5), (160_000.0, 21.5)]
    assert [point.clearance / UM for point in land.series.earlier] == pytest.approx([30.0], abs=1e-6)
    assert land.series.restart is Restart.REPAIRED
    assert per_10_000(land) == pytest.approx(0.5, abs=1e-6)
    assert len(counted(history.land(TCC))) == 3
    assert "2022-05-01 (job 2022)" in text_of(history, "series_repaired")
    assert "mileage_unchanged" in codes(history)


def test_a_land_repaired_at_the_last_visit_is_past_no_limit(visit_at: VisitAt, limits: Limits) -> None:
    visits = [visit_at(2022, 1e5, {REGULATOR: 24.0}), visit_at(2026, 2e5, {REGULATOR: 30.0}, repaired=[REGULATOR])]
    land = wear_over_mileage(visits, limits).land(REGULATOR)
    assert (land.line, land.limits, land.series.land) == (None, (), None)


def test_a_new_part_begins_where_its_type_does(visit_at: VisitAt, limits: Limits, minimal: Controller) -> None:
    of_type = measured_when_new(minimal, mounting_tolerance=3e-6, new_origin=NewOrigin.TYPE)
    of_pair = measured_when_new(minimal)
    for controller, expected in ((of_type, [(1e5, 18.0), (2e5, 22.0)]), (of_pair, [(2e5, 22.0)])):
        before = visit_at(2022, 1e5, {REGULATOR: 30.0}, controller=controller, repaired=[REGULATOR])
        later = visit_at(2026, 2e5, {REGULATOR: 22.0}, controller=controller)
        assert counted(wear_over_mileage([before, later], limits).land(REGULATOR)) == expected


def test_a_repair_that_the_sheet_names_begins_it_too(visit_at: VisitAt, limits: Limits, minimal: Controller) -> None:
    fitted = replace(minimal, lands=tuple(replace(land, fitted="oversize") for land in minimal.lands))
    visits = [visit_at(2022, 1e5, {TCC: 18.0}), visit_at(2026, 2e5, {TCC: 18.5}, controller=fitted)]
    land = wear_over_mileage(visits, limits).land(TCC)
    assert land.series.restart is Restart.FITTED
    assert counted(land) == [(2e5, 18.5)]


def test_a_clearance_that_falls_beyond_its_uncertainty_begins_it_anew_and_is_questioned(
    visit_at: VisitAt, limits: Limits
) -> None:
    visits = [
        visit_at(2020, 60_000.0, {REGULATOR: 26.0, TCC: 17.0}),
        visit_at(2022, 120_000.0, {REGULATOR: 30.0, TCC: 16.0}),
        visit_at(2024, 180_000.0, {REGULATOR: 19.0, TCC: 17.0}),
        visit_at(2026, 240_000.0, {REGULATOR: 22.0, TCC: 17.0}),
    ]
    history = wear_over_mileage(visits, limits)
    assert counted(history.land(REGULATOR)) == [(180_000.0, 19.0), (240_000.0, 22.0)]
    assert len(counted(history.land(TCC))) == 4  # 1 µm less is within what measuring can be off
    assert text_of(history, "series_narrower").startswith("pressure_regulator/1 measured narrower")


def test_a_mileage_that_falls_counts_from_there_and_is_said(
    visit_at: VisitAt, limits: Limits, minimal: Controller
) -> None:
    measured = measured_when_new(minimal)
    visits = [
        visit_at(year, mileage, {REGULATOR: um}, controller=measured)
        for year, mileage, um in ((2020, 180_000.0, 20.0), (2022, 12_000.0, 21.0), (2024, 62_000.0, 23.0))
    ]
    history = wear_over_mileage(visits, limits)
    land = history.land(REGULATOR)
    assert counted(land) == [(12_000.0, 21.0), (62_000.0, 23.0)]  # of another odometer 0 km is not when it was new
    assert land.series.restart is Restart.ODOMETER
    said = text_of(history, "mileage_falls").replace("\u00a0", " ")
    assert "180 000 km on 2020-05-01 (job 2020) to 12 000 km on 2022-05-01" in said


def test_visits_without_mileage_or_of_another_valve_body_are_left_out_and_named(
    visit_at: VisitAt, limits: Limits, minimal: Controller
) -> None:
    other = replace(minimal, id="other")
    visits = [
        visit_at(2018, 40_000.0, {REGULATOR: 17.0}, controller=other),
        visit_at(2020, 60_000.0, {REGULATOR: 20.0}),
        visit_at(2022, None, {REGULATOR: 21.0}),
        visit_at(2024, 160_000.0, {REGULATOR: 24.0}),
    ]
    history = wear_over_mileage(visits, limits)
    assert counted(history.land(REGULATOR)) == [(60_000.0, 20.0), (160_000.0, 24.0)]
    assert codes(history) == ["visit_of_another_valve_body", "visit_without_mileage"]


def test_wear_that_cannot_be_told_has_no_finite_end(visit_at: VisitAt, limits: Limits) -> None:
    visits = [visit_at(2024, 1e5, {PISTON: 20.0}), visit_at(2026, 1.1e5, {PISTON: 20.4})]
    land = wear_over_mileage(visits, limits).land(PISTON)
    assert not land.line.certain
    assert {limit.at.high for limit in land.limits} == {math.inf}


def test_half_a_pair_gives_no_point(visit_at: VisitAt, limits: Limits, minimal: Controller) -> None:
    visit = visit_at(2026, 1e5, {REGULATOR: 20.0})
    lands = tuple(
        replace(land, state=replace(land.state, status="spool_only")) if land.key == REGULATOR else land
        for land in visit.lands
    )
    assert wear_over_mileage([replace(visit, lands=lands)], limits).lands == ()


def test_faster_wear_is_said_and_widens(visit_at: VisitAt, limits: Limits) -> None:
    points = ((2020, 4e4, 20.0), (2022, 8e4, 20.0), (2024, 12e4, 36.0))
    history = wear_over_mileage([visit_at(year, km, {REGULATOR: um}) for year, km, um in points], limits)
    assert "wear_not_straight" in codes(history)
    straight = [
        visit_at(year, km, {REGULATOR: um}) for (year, km, _), um in zip(points, (20.0, 24.0, 28.0), strict=True)
    ]
    assert "wear_not_straight" not in codes(wear_over_mileage(straight, limits))


def test_a_limit_of_the_clearance_itself_has_its_mileage_too(
    visit_at: VisitAt, limits: Limits, minimal: Controller
) -> None:
    own = replace(minimal, lands=tuple(replace(land, clearance_limit=25e-6) for land in minimal.lands))
    visits = [
        visit_at(2024, 1e5, {REGULATOR: 19.0}, controller=own),
        visit_at(2026, 2e5, {REGULATOR: 21.0}, controller=own),
    ]
    found = wear_over_mileage(visits, limits).land(REGULATOR).limits
    assert [(each.kind, round(each.clearance / UM, 3)) for each in found] == [
        (RuleKind.WEAR, 22.0),
        (RuleKind.CLEARANCE, 25.0),
        (RuleKind.WEAR, 27.0),
    ]
    assert all(a.at.value < b.at.value for a, b in pairwise(found))


def test_without_any_visit_there_is_nothing_to_say(limits: Limits) -> None:
    history = wear_over_mileage([], limits)
    assert (history.visits, history.lands, history.present, history.messages) == ((), (), None, ())
