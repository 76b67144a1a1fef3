"""The gauges benchmark, small: that what circuits lose is found and that sound ones are left alone."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

import pytest

pytestmark = pytest.mark.slow  # test_check.py and test_posterior.py show of single units that losses are found


@pytest.fixture(scope="module")
def benchmark(benchmark_of: Callable[[str], ModuleType]) -> ModuleType:
    return benchmark_of("gauges")


@pytest.mark.parametrize("body", ["chrysler_41te", "five_speed_2005", "zf_6hp26"])
def test_losses_are_found_and_sound_circuits_are_left_alone(benchmark: ModuleType, body: str) -> None:
    counts = benchmark.counted(body, 0.005, "each reading", range(20))
    assert counts["sound"] > 40
    assert counts["lost"] >= 2
    found, alarms = benchmark.rates(counts)
    assert found >= 60.0
    assert alarms <= 2.0


def test_a_gauge_that_errs_more_than_is_said_is_noticed(benchmark: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    true = benchmark.simulate
    monkeypatch.setattr(
        benchmark, "simulate", lambda body, number, gauge, alike: true(body, number, 8.0 * gauge, alike)
    )
    counts = benchmark.counted("chrysler_41te", 0.01, "each reading", range(24))
    assert benchmark.rates(counts)[1] > 1.0
