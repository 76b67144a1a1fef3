"""What is missing of a pressure, split by cause: the worked case by hand, and what every split of a game must do."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.analysis.answer import answer_of
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.catalogue.repairs import LandKey
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.missing import PUMP_PART, PUMP_ROW, Cause, Missing, Path, Split, split
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import project
from atleak.measurements.clearances import clearances
from atleak.measurements.gauge_readings import LINE_TAP, Engine, GaugeCell, GaugeReading, PressureTable
from atleak.report.json.answer import answer_record

KPA = 1e3
ROWS = (PUMP_ROW, (Cause.LANDS, None), (Cause.LANDS, "clutch"), (Cause.LINE_SETTING, "control"), (Cause.LANDS, "feed"))
NAMES = PUMP_PART, "line", "own", "setting", "supply"


def game_of(values: Mapping[frozenset[str], float], parts: Sequence[str]) -> Split:
    """A split with one land in each part but the pump, every pressure stated, and a demand that falls as it rises."""
    lands: dict[str, tuple[LandKey, ...]] = {name: () if name == PUMP_PART else ((name, 1),) for name in parts}
    circuits = {(name, 1): row[1] for name, row in zip(NAMES, ROWS, strict=True)}

    def made(sets: Sequence[frozenset[str]]) -> tuple[np.ndarray, np.ndarray]:
        pressure = np.array([[values[each]] for each in sets])
        return pressure, 10.0 - pressure

    return split(Path("clutch", lands, circuits), made, {key: np.ones(1) for key in circuits})


@st.composite
def games(draw: st.DrawFn) -> tuple[dict[frozenset[str], float], tuple[str, ...]]:
    parts = NAMES[: draw(st.integers(1, len(NAMES)))]
    sets = [frozenset(each) for size in range(len(parts) + 1) for each in itertools.combinations(parts, size)]
    numbers = st.floats(-1e3, 1e3, allow_subnormal=False)
    return {each: draw(numbers) for each in sets}, parts


def test_a_worn_pump_and_worn_lands_share_what_is_missing_as_worked_by_hand() -> None:
    """p = Q/(G_pump + G_lands) where that is under 500 kPa; G in m³/(s·Pa), Q = 2e-4 m³/s; a gauge shows 179 kPa."""
    new, now = {PUMP_PART: 1.0e-10, "line": 1.5e-10}, {PUMP_PART: 4.0e-10, "line": 3.0e-10}

    def held(repaired: frozenset[str]) -> float:
        return min(2.0e-4 / sum((new if part in repaired else now)[part] for part in new), 500e3)

    sets = map(frozenset, ([], [PUMP_PART], ["line"], [PUMP_PART, "line"]))
    missing = Missing(
        load_controller("zf_6hp26").operating_points[0],
        "clutch",
        game_of({each: held(each) for each in sets}, (PUMP_PART, "line")),
        179e3,
    )
    amounts = {row: missing.amount(lambda each, row=row: each.of_row(row)).value / KPA for row in missing.rows}
    assert amounts == {
        PUMP_ROW: pytest.approx(175.3, abs=0.05),
        (Cause.LANDS, None): pytest.approx(39.0, abs=0.05),
    }
    assert next(iter(amounts)) == PUMP_ROW
    assert missing.missing / KPA == pytest.approx(321.0, abs=0.05)
    assert missing.unexplained / KPA == pytest.approx(106.7, abs=0.05)


@given(games())
def test_what_parts_get_is_what_they_add_over_all_orders_and_adds_up(
    game: tuple[dict[frozenset[str], float], tuple[str, ...]],
) -> None:
    values, parts = game
    found = game_of(values, parts)
    orders = list(itertools.permutations(parts))
    for part, row in zip(parts, ROWS, strict=False):
        before = [frozenset(order[: order.index(part)]) for order in orders]
        added = math.fsum(values[each | {part}] - values[each] for each in before) / len(orders)
        assert found.rows[row] == pytest.approx(added, abs=1e-9)
        assert found.flows[row] == pytest.approx(added, abs=1e-9)
    assert sum(found.rows.values()) == pytest.approx(found.new - found.now, abs=1e-9)
    assert sum(found.flows.values()) == pytest.approx(found.growth, abs=1e-9)


@given(games())
def test_a_part_that_changes_nothing_gets_nothing_and_parts_that_do_the_same_get_the_same(
    game: tuple[dict[frozenset[str], float], tuple[str, ...]],
) -> None:
    values, parts = game
    *others, idle = parts
    found = game_of({each: values[each - {idle}] for each in values}, parts)
    assert found.rows[ROWS[len(others)]] == pytest.approx(0.0, abs=1e-9)
    by_size = {each: values[frozenset(parts[: len(each)])] for each in values}
    alike = game_of(by_size, parts).rows
    assert all(alike[row] == pytest.approx(alike[PUMP_ROW], abs=1e-9) for row in ROWS[: len(parts)])


@pytest.mark.usefixtures("all_draws")
def test_every_probability_of_an_answer_is_that_of_its_draws(
    hipol: Fluid, limits: Limits, pressed: Callable[..., PressureTable]
) -> None:
    controller = load_controller("zf_6hp26")
    diagnosis = diagnose(controller, hipol, limits, pressures=pressed(controller, hipol, "clutch_a", 200e3))
    answer, record = answer_of(diagnosis), answer_record(diagnosis)
    assert diagnosis.pressures is not None
    assert answer.missing is not None
    named = {answer.cause, *answer.also}
    explained = sum(
        (values for (cause, _), values in answer.missing.rows.items() if cause in named),
        answer.missing.unexplained if Cause.UNEXPLAINED in named else np.zeros(1),
    )
    share = float(np.mean(explained > 0.5 * answer.missing.missing))
    assert answer.probability == pytest.approx(share, abs=1e-12)
    assert record["cause_probability"] == answer.probability
    judged = [each for each in diagnosis.pressures.readings if each.lost is not None]
    assert any(each.verdict is not None and each.verdict.flagged for each in judged)
    for each in judged:
        assert each.lost is not None
        assert each.deciding is not None
        for level in each.deciding.levels:
            past = float(np.sum(each.lost.weights[each.lost.draws >= level.limit]))
            assert level.probability_over == pytest.approx(past, abs=1e-12)
        assert each.over_limit == each.lost.probability_over(each.deciding.limit)


@pytest.mark.parametrize(("number", "factor"), [(0, 0.6), (3, 0.5), (1, 1.4)])
def test_a_gauge_that_the_others_contradict_blames_no_part(
    hipol: Fluid, limits: Limits, pressed: Callable[..., PressureTable], number: int, factor: float
) -> None:
    """Line or clutch once misread: the clutch, fed by the line, is fine in the other state, and beside the line."""
    controller = load_controller("zf_6hp26")
    table = pressed(controller, hipol, "clutch_a", 0.0)
    readings = list(table.readings)
    readings[number] = replace(readings[number], pressure=factor * readings[number].pressure)
    diagnosis = diagnose(controller, hipol, limits, pressures=replace(table, readings=tuple(readings)))
    assert answer_of(diagnosis).cause in (Cause.UNEXPLAINED, Cause.NONE)
    assert diagnosis.pressures is not None
    missing = [
        each.missing for each in diagnosis.pressures.readings if each.missing is not None and each.missing.doubted
    ]
    assert missing
    assert all(row[0] is not Cause.CLUTCH_SEAL for each in missing for row in each.rows)


def test_what_is_missing_is_as_uncertain_as_its_gauge() -> None:
    even = Split(Path("clutch", {}, {}), np.full(256, 500e3), np.full(256, 400e3), {}, {}, {}, {}, np.zeros(256))
    point = load_controller("zf_6hp26").operating_points[0]
    value, low, high = Missing(point, "clutch", even, 380e3, error=5e3).amount(lambda each: each.missing)
    assert value == pytest.approx(120e3, abs=1.0)
    assert (low, high) == pytest.approx((120e3 - 1.96 * 5e3, 120e3 + 1.96 * 5e3), abs=200.0)


@pytest.fixture
def pressed() -> Callable[..., PressureTable]:
    """Gauges on line and a clutch of a new unit in drive, at idle and stall, the clutch so much lower [Pa]."""

    def table(controller: Controller, fluid: Fluid, clutch: str, lower: float) -> PressureTable:
        model, readings = LeakageModel(controller, clearances(None, controller), fluid, WORKSHOP), []
        for point in controller.operating_points:
            if point.gear == 1 and point.state in ("idle", "stall"):
                engine, held = Engine.STALL if point.state == "stall" else Engine.SLOW_IDLE, project(model, point)
                line, tap = held.main_pressure_held, held.circuit(clutch).pressure - lower
                readings += [
                    GaugeReading(GaugeCell("D", engine, name), p) for name, p in ((LINE_TAP, line), (clutch, tap))
                ]
        return PressureTable("gauges.csv", "0" * 64, None, ("kPa",), tuple(readings))

    return table
