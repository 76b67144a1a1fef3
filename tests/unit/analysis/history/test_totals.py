"""The total over mileage: every land at its own line, through the engine."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from atleak.analysis.history.series import Visit
from atleak.analysis.history.wear import WearHistory, drawn_clearances, totals_over_mileage, wear_over_mileage
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.verdicts import Band
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.engine.projection import project, repaired
from atleak.measurements.readings import Reading, Readings
from tests.unit.conftest import first_of

UM = 1e-6


@pytest.fixture(scope="module", params=["minimal", "three_circuits"])
def unit(
    request: pytest.FixtureRequest, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]
) -> tuple[WearHistory, Diagnosis]:
    """Two visits of a unit of which two lands wear, and the diagnosis of the second; with circuits and without."""
    controller: Controller = request.getfixturevalue(request.param)
    visits, diagnosis = [], None
    for year, mileage, worn in ((2024, 100_000.0, (2.0, 2.0)), (2026, 160_000.0, (5.0, 3.5))):  # [µm]
        diameters = {
            land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * (land.new_clearance + um * UM))
            for land, um in zip(controller.lands, worn, strict=False)
        }
        diagnosis = diagnose(controller, hipol, limits, readings=readings_of(controller, diameters), mileage_km=mileage)
        visits.append(Visit.of(diagnosis, dt.date(year, 5, 1)))
    assert diagnosis is not None
    return wear_over_mileage(visits, limits), diagnosis


def without_errors(history: WearHistory) -> WearHistory:
    """The same lines as if nothing erred: every draw is the line itself."""
    exact = []
    for land in history.lands:
        points = tuple(replace(point, factors={}, own_variance=0.0) for point in land.series.counted)
        exact.append(replace(land, series=replace(land.series, counted=points)))
    return replace(history, lands=tuple(exact))


def test_the_total_is_that_of_the_engine_with_every_land_where_its_line_leads(
    unit: tuple[WearHistory, Diagnosis],
) -> None:
    history, diagnosis = unit
    totals = totals_over_mileage(without_errors(history), diagnosis)
    assert (totals.growing, totals.lands) == (2, len(diagnosis.controller.lands))
    for total, now in zip(totals.totals, diagnosis.projections, strict=True):
        assert total.condition == now.condition
        for mileage, share in list(zip(total.mileages, total.median, strict=True))[::4]:
            states = []
            for state in diagnosis.model.clearances:
                line = next((land.line for land in history.lands if land.key == state.land.key), None)
                cold = state.land.new_clearance if line is None else line.at(mileage)
                states.append(replace(state, radial_clearance=cold))
            expected = project(replace(diagnosis.model, clearances=tuple(states)), now.condition)
            assert share == pytest.approx(expected.share, rel=1e-9, abs=0.0)
        assert total.low == pytest.approx(total.median, rel=1e-9, abs=0.0)


@pytest.mark.parametrize("name", first_of(["minimal_example", "five_speed_2005", "zf_6hp26", "gm_4l60e"]))
def test_a_land_that_was_repaired_has_no_bore_worn_to_one_side(
    name: str, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]
) -> None:
    controller = load_controller(name)
    leaking = {gap.key for gap in controller.gaps if controller.operating_points[0].gear in gap.gears}
    one, other = [land for land in controller.lands if land.key in leaking and not land.seal][:2]
    uneven = [(0.0, one.nominal_diameter + 40 * UM), (90.0, one.nominal_diameter + 120 * UM)]
    visits = []
    for year, mileage, worn in ((2024, 100_000.0, 2.0), (2026, 160_000.0, 5.0)):
        bore = other.nominal_diameter + 2.0 * (other.new_clearance + worn * UM)
        sheet = readings_of(controller, {other.key: (other.nominal_diameter, bore)})
        spool, sleeve = (
            [Reading(one.component, part, one.planes[0], at, 1, diameter) for at, diameter in diameters]
            for part, diameters in (("spool", [(0.0, one.nominal_diameter)]), ("sleeve", uneven))
        )
        sheet = replace(sheet, readings=(*sheet.readings, *spool, *sleeve))
        diagnosis = diagnose(controller, hipol, limits, readings=sheet, mileage_km=mileage)
        done = [one.key] if visits else []
        visits.append(Visit.of(diagnosis, dt.date(year, 5, 1), repaired=done))
    assert next(land for land in diagnosis.lands if land.key == one.key).state.form_moments[0] > 0.0
    totals = totals_over_mileage(without_errors(wear_over_mileage(visits, limits)), diagnosis)
    mended = replace(diagnosis.model, clearances=repaired(diagnosis.model.clearances, [one.key]))
    expected = project(mended, diagnosis.projection.condition)
    assert totals.totals[0].median[0] == pytest.approx(expected.share, rel=1e-9, abs=0.0)


def test_the_total_begins_at_the_last_visit_and_widens(unit: tuple[WearHistory, Diagnosis]) -> None:
    history, diagnosis = unit
    for total, now in zip(totals_over_mileage(history, diagnosis).totals, diagnosis.projections, strict=True):
        assert (total.mileages[0], total.mileages[-1]) == (160_000.0, 360_000.0)
        assert total.low[0] < now.share < total.high[0]
        widths = np.array(total.high) - np.array(total.low)
        assert np.all(np.diff(widths) > 0.0)
        assert np.all(np.diff(total.median) > 0.0)


def test_a_limit_of_the_total_is_reached_where_the_median_crosses_it(unit: tuple[WearHistory, Diagnosis]) -> None:
    history, diagnosis = unit
    for total, rule in zip(totals_over_mileage(history, diagnosis).totals, diagnosis.total_rules, strict=True):
        assert [each.level for each in total.limits] == [level for level, _ in rule.steps.levels]
        for limit in total.limits:
            if limit.past:
                assert limit.at is None
                assert rule.value >= limit.share
                continue
            reached = np.interp(limit.share, total.median, total.mileages)
            if total.median[0] < limit.share < total.median[-1]:
                assert limit.at.value == pytest.approx(reached, rel=0.02, abs=0.0)
            if limit.share > total.high[-1]:
                assert limit.at.not_before == pytest.approx(360_000.0, abs=1.0)
    amber = {each.level: each for each in totals_over_mileage(history, diagnosis).totals[0].limits}[Band.AMBER]
    assert not amber.past


def test_lands_err_together_as_far_as_they_share_what_errs(unit: tuple[WearHistory, Diagnosis]) -> None:
    history, _ = unit
    drawn = drawn_clearances(history, [160_000.0], draws=20_000)
    first, second = (each[:, 0] for each in drawn.values())
    points = [history.land(key).series.counted[-1] for key in drawn]
    names = points[0].factors.keys() & points[1].factors.keys()
    expected = sum(points[0].factors[name] * points[1].factors[name] for name in names)
    assert np.cov(first, second)[0, 1] == pytest.approx(expected, rel=0.1, abs=0.0)
    assert first.std() == pytest.approx(points[0].standard_uncertainty, rel=0.03, abs=0.0)


def test_the_same_history_gives_the_same_digits(unit: tuple[WearHistory, Diagnosis]) -> None:
    history, diagnosis = unit
    assert totals_over_mileage(history, diagnosis) == totals_over_mileage(history, diagnosis)


def test_lands_without_a_rate_are_counted_and_named(unit: tuple[WearHistory, Diagnosis], limits: Limits) -> None:
    history, diagnosis = unit
    totals = totals_over_mileage(history, diagnosis)
    assert [message.code for message in totals.messages] == ["lands_without_rate"]
    alone = wear_over_mileage(history.visits[:1], limits)
    assert totals_over_mileage(alone, diagnosis).totals == ()
