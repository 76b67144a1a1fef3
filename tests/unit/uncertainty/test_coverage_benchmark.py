"""The coverage benchmark, small: that it runs, repeats itself and would notice a wrong interval."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

import pytest


@pytest.fixture(scope="module")
def benchmark(benchmark_of: Callable[[str], ModuleType]) -> ModuleType:
    return benchmark_of("coverage")


def test_intervals_hold_the_truth(benchmark: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ATLEAK_COVERAGE_DRAWS", "1000")
    counted = benchmark._count(benchmark.AS_DECLARED, range(150))
    rates = benchmark.summary(benchmark.AS_DECLARED, counted)
    # lands of one unit share an error: about 1 % of standard error
    for name in ("clearance", "leakage", "share"):
        assert rates["coverage"][name] == pytest.approx(95.0, abs=3.0)
    for rule in rates["rules"].values():
        assert rule["pass_truly_over"] <= 5.0
        assert rule["decided_wrongly"] < rule["unguarded_wrong"]
    again = benchmark._count(benchmark.AS_DECLARED, range(150))
    assert again == counted


def test_a_worse_instrument_than_declared_is_noticed(benchmark: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ATLEAK_COVERAGE_DRAWS", "500")
    world = next(world for world in benchmark.WORLDS if world.calibration == 2.0)
    rates = benchmark.summary(world, benchmark._count(world, range(60)))
    assert rates["coverage"]["clearance"] < 85.0
    assert any(name in text for text in benchmark._failures(rates) for name in ("clearance", "leakage"))
