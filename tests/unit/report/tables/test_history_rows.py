"""Rows of a unit's history: rates, mileages and totals in words that people can use."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable
from dataclasses import replace

import pytest

from atleak.analysis.history.series import Visit
from atleak.analysis.history.wear import WearHistory, totals_over_mileage, wear_over_mileage
from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.verdicts import Band, Verdict
from atleak.common.wording import signed, wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.measurements.readings import Readings
from atleak.report.charts import history_figures as figures
from atleak.report.tables.history import soonest_first, total_table, wear_table
from atleak.report.tables.sentences import consequence_words

REGULATOR, SECOND, TCC, SOLENOID = (
    ("pressure_regulator", 1),
    ("pressure_regulator", 2),
    ("tcc_regulator", 1),
    ("solenoid_modulator", 1),
)
VISITS = (  # year, mileage, clearances [µm]
    (2022, 60_000.0, {REGULATOR: 30.0, TCC: 17.0, SECOND: 18.5, SOLENOID: 23.0}),
    (2024, 100_000.0, {REGULATOR: 20.0, TCC: 17.2, SECOND: 19.0, SOLENOID: 25.0}),
    (2026, 160_000.0, {REGULATOR: 26.0, TCC: 17.1, SECOND: 19.6, SOLENOID: 28.0}),
)
WATCH, REPLACE, ENGLISH = Verdict.WATCH, Verdict.REPLACE, wording("en")


@pytest.fixture(scope="module")
def unit(
    minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]
) -> tuple[WearHistory, Diagnosis]:
    """Three visits, before the second of which the pressure regulator was repaired; the diagnosis of the last."""
    visits, diagnosis = [], None
    for year, mileage, um in VISITS:
        spools = {key: minimal.land(*key).nominal_diameter for key in um}
        readings = readings_of(minimal, {key: (spool, spool + 2e-6 * um[key]) for key, spool in spools.items()})
        diagnosis = diagnose(minimal, hipol, limits, readings=readings, mileage_km=mileage)
        visits.append(Visit.of(diagnosis, dt.date(year, 5, 1), repaired=[REGULATOR] if year == 2022 else []))
    assert diagnosis is not None
    return wear_over_mileage(visits, limits), diagnosis


def test_every_land_has_its_rate_and_when_it_reaches_each_level(unit: tuple[WearHistory, Diagnosis]) -> None:
    history, diagnosis = unit
    rows = {row["pair"]: row for row in wear_table(history, diagnosis, ENGLISH).records()}
    worn = rows["pressure regulator valve/1"]
    assert worn["rate"].startswith("1.00 (0.")
    assert (worn[WATCH], worn["visits"], worn["since"]) == ("reached", 2, "2022-05-01: repaired")
    assert worn[REPLACE].replace("\u00a0", " ").startswith("170 000 km (")
    assert rows["solenoid modulator valve/1"][REPLACE] == "reached"
    unworn = rows["converter clutch regulator valve/1"]
    assert unworn["rate"].startswith("no wear that can be told from measurement: ")
    assert "(−0." in unworn["rate"]
    assert unworn[REPLACE].startswith(("not before", "not foreseeable"))
    assert unworn["since"] is None


def test_what_wear_does_by_the_next_service_follows_from_the_visits(unit: tuple[WearHistory, Diagnosis]) -> None:
    history, diagnosis = unit
    described = replace(diagnosis, controller=replace(diagnosis.controller, gaps_not_described=frozenset()))
    said = {row["pair"]: row["consequence"] for row in wear_table(history, described, ENGLISH).records()}
    solenoid = next(land for land in described.lands if land.key == SOLENOID)
    assert consequence_words(described, solenoid, ENGLISH) == "worn; can wait"  # one visit tells no rate
    assert said["solenoid modulator valve/1"].replace("\u00a0", " ") == "worn; can wait to 220 000 km (service assumed)"
    assert said["converter clutch regulator valve/1"] is None  # within its limits


def test_what_is_past_a_limit_comes_first_and_what_nobody_can_tell_last(unit: tuple[WearHistory, Diagnosis]) -> None:
    history, _ = unit
    assert [land.key for land in soonest_first(history)] == [SOLENOID, REGULATOR, SECOND, TCC]


def test_totals_stand_with_the_mileage_of_each_band(unit: tuple[WearHistory, Diagnosis]) -> None:
    totals = totals_over_mileage(*unit)
    rows = total_table(totals.totals, ENGLISH).records()
    assert [row["condition"] for row in rows] == [each.condition.label for each in unit[1].projections]
    low, high = rows[0]["ahead"].split("(")[1].removesuffix(")").split(" to ")
    assert float(low) < float(rows[0]["ahead"].split(" ")[0]) < float(high)
    assert totals.totals[0].mileages[-1] == 360_000.0
    assert Band.AMBER in rows[0]


def test_the_figure_of_a_land_shows_its_points_its_band_and_its_limits(unit: tuple[WearHistory, Diagnosis]) -> None:
    history, _ = unit
    land = history.land(REGULATOR)
    figure = figures.clearance_over_mileage(land, history.visits, history.present, ENGLISH)
    traces = {trace.name: trace for trace in figure.data}
    assert list(traces["measured"].x) == [100_000.0, 160_000.0]
    assert list(traces["measured"].y) == pytest.approx([20.0, 26.0], abs=1e-6)
    assert list(traces["before"].y) == pytest.approx([30.0], abs=1e-6)
    assert traces["measured"].error_y.array[0] == pytest.approx(
        1.6448536 * land.series.counted[0].standard_uncertainty * 1e6, abs=1e-6
    )
    assert traces["line"].y[0] == pytest.approx(20.0, abs=1e-6)
    end = traces["line"].x[-1]
    band = traces["90\u00a0% of the line"]
    assert band.y[40] == pytest.approx(land.line.band(end)[1] * 1e6, abs=1e-6)
    said = [each.text for each in figure.layout.annotations]
    assert said == [f"{signed('watch')}: 22.0 µm", f"{signed('replace')}: 27.0 µm"]


def test_the_figure_of_a_total_has_the_limits_that_are_near(unit: tuple[WearHistory, Diagnosis]) -> None:
    total = totals_over_mileage(*unit).totals[0]
    figure = figures.total_over_mileage(total, ENGLISH)
    line = next(trace for trace in figure.data if trace.name == "total share")
    assert list(line.y) == pytest.approx([100.0 * each for each in total.median], abs=1e-9)
    near = [limit for limit in total.limits if limit.share <= 1.5 * max(total.high)]
    assert len(figure.layout.annotations) == len(near)


def test_a_pareto_chart_counts_units_and_what_they_make_up() -> None:
    figure = figures.pareto(["a/1", "b/2"], [6, 2], 9, "flagged", ENGLISH)
    [bar] = figure.data
    assert list(bar.text) == ["6 of 9", "2 of 9"]
    assert list(bar.customdata) == [75.0, 100.0]


def test_a_rate_stands_in_the_readers_units(unit: tuple[WearHistory, Diagnosis]) -> None:
    """1.00 µm per 10 000 km is 0.63 times 0.0001 in per 10 000 mi."""
    us = wording("de", "us")
    rows = {row["pair"]: row for row in wear_table(*unit, us).records()}
    assert rows["Druckregelventil/1"]["rate"].startswith("0,63 (")
    figure = figures.clearance_over_mileage(unit[0].land(REGULATOR), unit[0].visits, unit[0].present, us)
    assert figure.layout.xaxis.title.text == "Laufleistung [mi]"
    measured = next(trace for trace in figure.data if trace.name == "gemessen")
    assert list(measured.x) == pytest.approx([62137.119, 99419.391], abs=1e-3)
    assert list(measured.y) == pytest.approx([7.874016, 10.236220], abs=1e-6)
