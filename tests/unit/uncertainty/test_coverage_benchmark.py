"""The coverage benchmark, small: that it runs, repeats itself and would notice a wrong interval."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

import pytest


@pytest.fixture(scope="module")
def benchmark(benchmark_of: Callable[[str], ModuleType]) -> ModuleType:
    return benchmark_of("coverage")


# lands of one unit share an error: the standard error is about 1 % with 150 units, 3 % with 20
@pytest.mark.parametrize(("units", "tolerance"), [(20, 8.0), pytest.param(150, 3.0, marks=pytest.mark.slow)])
def test_intervals_hold_the_truth(
    benchmark: ModuleType, monkeypatch: pytest.MonkeyPatch, units: int, tolerance: float
) -> None:
    monkeypatch.setenv("ATLEAK_COVERAGE_DRAWS", "1000")
    counted = benchmark._count(benchmark.AS_DECLARED, range(units))
    rates = benchmark.summary(benchmark.AS_DECLARED, counted)
    for name in ("clearance", "leakage", "share"):
        assert rates["coverage"][name] == pytest.approx(95.0, abs=tolerance)
    for rule in rates["rules"].values():
        assert rule["pass_truly_over"] <= 5.0
        assert rule["decided_wrongly"] < rule["unguarded_wrong"]
    again = benchmark._count(benchmark.AS_DECLARED, range(units))
    assert again == counted


def test_a_worse_instrument_than_declared_is_noticed(benchmark: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ATLEAK_COVERAGE_DRAWS", "500")
    world = next(world for world in benchmark.WORLDS if world.calibration == 2.0)
    rates = benchmark.summary(world, benchmark._count(world, range(60)))
    assert rates["coverage"]["clearance"] < 85.0
    assert any(name in text for text in benchmark._failures(rates) for name in ("clearance", "leakage"))
