"""Known patterns of pressure tables: what each asks for, and that a few cells show none."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.diagnosis.gauge_patterns import GaugeStanding, find_patterns
from atleak.measurements.gauge_readings import Engine, GaugeCell

SLOW, FAST, STALL = Engine.SLOW_IDLE, Engine.FAST_IDLE, Engine.STALL
WORDS = {"l": "low", "n": "normal", "h": "high"}


def table(**states: str) -> list[GaugeStanding]:
    """Return readings at the line: ``slow="Rl Dn"`` is reverse low and drive normal at slow idle."""
    engines = {"slow": SLOW, "fast": FAST, "stall": STALL}
    return [
        GaugeStanding(GaugeCell(each[0], engines[name]), 400e3, stands=WORDS[each[1]])
        for name, written in states.items()
        for each in written.split()
    ]


def kinds(readings: list[GaugeStanding], applied: Mapping | None = None) -> list[str]:
    return [each.kind for each in find_patterns(readings, applied)]


@pytest.mark.parametrize(
    ("states", "kind"),
    [
        ({"slow": "Pl Rl Nl Dl", "fast": "Pn Rn Nn Dn"}, "low_at_slow_idle"),
        ({"slow": "Rl Dl 2l", "fast": "Rn Dh 2n"}, "low_at_slow_idle"),
        ({"slow": "Rl Dl 2l", "stall": "Rn Dn 2n"}, "low_at_slow_idle"),  # the commonest test has no fast idle
        ({"slow": "Rl Dn 2n", "fast": "Rl Dn 2n"}, "one_range_low"),
        ({"slow": "Pn Rl Nn Dn"}, "one_range_low"),
        ({"slow": "Rl Dl 2l", "fast": "Rl Dl 2l"}, "all_low"),
        ({"slow": "Rl Dl 2l", "stall": "Rl Dl 2l"}, "all_low"),
        ({"slow": "Rh Dh 2h", "stall": "Rh Dh 2h"}, "all_high"),
    ],
)
def test_a_pattern_is_named(states: dict[str, str], kind: str) -> None:
    assert kinds(table(**states)) == [kind]


@pytest.mark.parametrize(
    "states",
    [
        {},
        {"slow": "Dl"},
        {"slow": "Rl Dl", "fast": "Rn Dn"},  # two ranges
        {"slow": "Rl Dl 2l"},  # one state: pump and regulation look alike
        {"slow": "Rl Dl 2l", "fast": "Rn Dn"},  # too few at fast idle
        {"slow": "Rl Dl 2l", "fast": "Rn Dn 2l"},  # neither pattern
        {"slow": "Rl Dn 2n", "fast": "Rn Dl 2n"},  # not one range
        {"slow": "Rl Dl 2n"},
        {"slow": "Rl Dn", "fast": "Rl Dn"},
        {"slow": "Rh Dh 2h", "fast": "Rh Dh 2n"},
        {"slow": "Rn Dn 2n", "fast": "Rn Dn 2n", "stall": "Rn Dn 2n"},  # all is well
    ],
)
def test_a_table_that_does_not_tell_has_no_pattern(states: dict[str, str]) -> None:
    assert kinds(table(**states)) == []


def test_one_range_low_names_the_circuits_that_are_applied_there_alone() -> None:
    applied = {
        "R": frozenset({"reverse_clutch", "low_brake"}),
        "D": frozenset({"forward"}),
        "1": frozenset({"low_brake"}),
    }
    (pattern,) = find_patterns(table(slow="Rl Dn 1n"), applied)
    assert (pattern.ranges, pattern.others, pattern.circuits) == (("R",), ("D", "1"), ("reverse_clutch",))
    assert pattern.cells == (GaugeCell("R", SLOW),)


def falling(*pressures: float, uncertainty: float = 8e3, start: int = 1) -> list[GaugeStanding]:
    cell = GaugeCell("D", SLOW)
    return [GaugeStanding(cell, each * 1e3, number, uncertainty) for number, each in enumerate(pressures, start=start)]


@pytest.mark.parametrize("pressures", [(400.0, 390.0, 380.0), (400.0, 399.0, 398.0, 350.0)])
def test_pressure_that_falls_with_every_reading_is_said(pressures: tuple[float, ...]) -> None:
    (pattern,) = find_patterns(falling(*pressures))
    assert pattern.kind == "falling"
    assert pattern.amount == pytest.approx((400.0 - pressures[-1]) / 400.0, abs=1e-12)


@pytest.mark.parametrize(
    "pressures",
    [
        (400.0, 300.0),  # two readings
        (400.0, 380.0, 385.0, 350.0),  # not steadily
        (400.0, 395.0, 385.0),  # within what the gauge may err
        (380.0, 390.0, 400.0),
    ],
)
def test_pressure_that_does_not_surely_fall_is_not(pressures: tuple[float, ...]) -> None:
    assert find_patterns(falling(*pressures)) == ()


def test_the_order_of_the_readings_counts_not_of_their_rows() -> None:
    assert kinds(list(reversed(falling(400.0, 390.0, 380.0)))) == ["falling"]


def test_a_circuit_that_lost_pressure_is_said_with_its_worst_cell() -> None:
    def tap(engine: Engine, loss: float | None, cause: str = "seal") -> GaugeStanding:
        return GaugeStanding(GaugeCell("D", engine, "clutch_c1"), 300e3, loss=loss, causes={(cause, "clutch_c1"): 1.0})

    assert find_patterns([tap(SLOW, None), tap(STALL, None)]) == ()
    (pattern,) = find_patterns([tap(SLOW, 104e3), tap(FAST, 180e3, "hole"), tap(STALL, None)])
    assert (pattern.kind, pattern.circuits, pattern.amount) == ("circuit_loss", ("clutch_c1",), 180e3)
    assert pattern.worst == GaugeCell("D", FAST, "clutch_c1")
    assert pattern.cells == (GaugeCell("D", SLOW, "clutch_c1"), GaugeCell("D", FAST, "clutch_c1"))
    assert pattern.causes == {("hole", "clutch_c1"): 1.0}


def test_of_several_readings_of_a_cell_the_last_stands() -> None:
    early = [
        GaugeStanding(GaugeCell("R", SLOW), 400e3, 1, stands="low"),
        GaugeStanding(GaugeCell("R", SLOW), 500e3, 2, stands="normal"),
    ]
    assert kinds([*early, *table(slow="Dn 2n Nn")]) == []


@pytest.mark.hypothesis
@given(
    st.lists(
        st.builds(
            GaugeStanding,
            st.builds(GaugeCell, st.sampled_from("PRND321"), st.sampled_from(list(Engine))),
            st.floats(0.0, 2e6),
            st.integers(1, 4),
            st.just(8e3),
            st.sampled_from([None, "low", "normal", "high"]),
        ),
        max_size=30,
        unique_by=lambda each: (each.cell, each.repeat),
    )
)
def test_patterns_of_any_table_agree_with_it(readings: list[GaugeStanding]) -> None:
    found = {pattern.kind: pattern for pattern in find_patterns(readings)}
    last = {each.cell: each.stands for each in sorted(readings, key=lambda each: each.repeat) if each.stands}
    assert len({"low_at_slow_idle", "one_range_low", "all_low", "all_high"} & set(found)) <= 1
    for kind, stands in (("all_low", "low"), ("all_high", "high"), ("one_range_low", "low")):
        if kind in found:
            assert {last[cell] for cell in found[kind].cells} == {stands}
    if "all_low" in found:
        assert set(last.values()) == {"low"}
        assert len(found["all_low"].cells) == len(last)
