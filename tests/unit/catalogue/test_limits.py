"""Limits: a value at its limit has reached it, whatever the last digit; a set says where each limit comes from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.catalogue.limits import LimitOrigin, Limits, Steps, load_limits, reaches
from atleak.common.errors import CatalogueError
from atleak.common.verdicts import VERDICTS, Band, Verdict, worst

Edited = Callable[..., Path]
WEAR_WATCH = "watch = { percent = 10.0, at_least_um = 4.0 }"
AMBER = "amber = { growth_percent = 25.0, added_points = 2.0 }"


def test_default_limits_and_their_origins(limits: Limits) -> None:
    assert limits.wear is not None
    assert dict(limits.wear.levels) == {
        "watch": pytest.approx(0.10, rel=1e-9, abs=0.0),
        "replace": pytest.approx(0.50, rel=1e-9, abs=0.0),
    }
    assert limits.wear.at_least == {"watch": pytest.approx(4e-6, rel=1e-9, abs=0.0)}
    assert limits.wear.origin == "choice of this project"
    assert "derived from the study's W3" in limits.wear.source
    assert dict(limits.total_share.growth) == {"amber": (0.25, 0.02), "red": (0.5, 0.04)}
    assert limits.fixed_bands == (("critical", 0.5),)
    assert limits.total_share.origin == "choice of this project"
    assert limits.pair_share is not None
    assert limits.pair_share.origin == "choice of this project"
    assert limits.clearance is None
    of_pressure = ["reserve", "circuit_loss", "permissible_pressure", "commanded_pressure"]
    assert list(limits.rules) == ["wear", "pair_share", "total_share", *of_pressure]
    assert {kind: dict(limits.rules[kind].levels) for kind in of_pressure} == {
        "reserve": {"amber": 1.5, "red": 1.2, "critical": 1.0},
        "circuit_loss": {"watch": 55e3, "replace": 103e3},
        "permissible_pressure": {"watch": 0.0, "replace": 0.1, "critical": 0.25},
        "commanded_pressure": {"watch": 69e3},
    }
    assert [limits.rules[kind].origin for kind in of_pressure] == [
        "choice of this project",
        "choice of this project",  # 55 and 103 kPa are published for the line less a circuit, not for a loss
        "choice of this project",
        "published",
    ]


def test_the_set_with_a_clearance_states_the_other_limits_as_the_default_does(limits: Limits) -> None:
    other = load_limits("new_part_clearance")
    assert other.clearance is not None
    assert replace(other, clearance=None).rules == limits.rules


def band_of(limits: Limits, share: float, new: float) -> str:
    """The band of a total share beside that of the same unit new."""
    steps = limits.total_share
    return replace(steps, levels=steps.over(new)).judge(share, Band.GREEN)[0]


@pytest.mark.parametrize(
    ("new", "share", "band"),
    [
        (0.16, 0.16, "green"),
        (0.16, 0.1999999, "green"),
        (0.16, 0.20, "amber"),  # a quarter more
        (0.16, 0.2399999, "amber"),
        (0.16, 0.24, "red"),  # half as much again
        (0.02, 0.0399999, "green"),  # doubled, but under two points of the pump's flow
        (0.02, 0.04, "amber"),
        (0.02, 0.06, "red"),
        (0.30, 0.4999999, "red"),
        (0.45, 0.4999999, "green"),
        (0.45, 0.50, "critical"),
        (0.0, 0.0, "green"),
        (0.0, 0.02, "amber"),
        (0.16, float("inf"), "critical"),
        (float("inf"), float("inf"), "critical"),
    ],
)
def test_bands_begin_where_a_unit_has_grown_over_itself_new(
    limits: Limits, new: float, share: float, band: str
) -> None:
    assert band_of(limits, share, new) == band


@given(new=st.floats(0.0, 0.49))
def test_a_new_unit_is_green_whatever_it_draws(new: float) -> None:
    assert band_of(load_limits("project_default"), new, new) == "green"


def test_limits_of_growth_follow_every_draw(limits: Limits) -> None:
    new = np.array([0.02, 0.16])
    levels = dict(limits.total_share.over(new))
    assert levels[Band.AMBER] == pytest.approx([0.04, 0.20], rel=1e-12, abs=0.0)
    assert levels[Band.CRITICAL] == 0.5


@pytest.mark.parametrize(
    ("mounting_um", "tolerance_um", "watch_um", "replace_um"),
    [
        (35.0, 0.0, 4.0, 17.5),
        (50.0, 0.0, 5.0, 25.0),
        (13.0, 0.0, 4.0, 6.5),
        (6.4, 0.0, 4.0, 4.0),
        (13.0, 2.0, 6.0, 6.5),
        (13.0, 3.0, 7.0, 7.0),
        (80.0, 3.0, 8.0, 40.0),
    ],
)
def test_wear_has_limits_that_a_gauge_can_tell_from_any_new_pair_and_that_rise(
    limits: Limits, mounting_um: float, tolerance_um: float, watch_um: float, replace_um: float
) -> None:
    assert limits.wear is not None
    levels = dict(limits.wear.of_wear(mounting_um * 1e-6, tolerance_um * 1e-6))
    assert levels[Verdict.WATCH] * mounting_um == pytest.approx(watch_um, rel=1e-9, abs=0.0)
    assert levels[Verdict.REPLACE] * mounting_um == pytest.approx(replace_um, rel=1e-9, abs=0.0)


ABSOLUTE = """
id = "absolute"
name = "absolute limits"
source = "chosen from the study's figures"
date = "2026-11-21"

[wear_percent]
watch = 10.0
replace = 50.0
origin = "set by the workshop"
source = "as in 0.1.0"

[pair_share_percent]
watch = 2.0
replace = 4.0
critical = 10.0
origin = "set by the workshop"
source = "as in 0.1.0"

[total_share_percent]
amber = 10.0
red = 20.0
critical = 50.0
origin = "set by the workshop"
source = "as in 0.1.0"
"""


def test_a_file_of_fixed_limits_judges_as_it_did(tmp_path: Path) -> None:
    path = tmp_path / "absolute.toml"
    path.write_text(ABSOLUTE, encoding="utf-8")
    old = load_limits(path)
    assert [band_of(old, share, 0.16) for share in (0.0999, 0.1, 0.1999, 0.2, 0.4999, 0.5)] == [
        "green", "amber", "amber", "red", "red", "critical",
    ]  # fmt: skip
    assert old.wear is not None
    assert old.pair_share is not None
    assert old.wear.of_wear(13e-6, 3e-6) == old.wear.levels
    assert old.pair_share.over(0.05) == old.pair_share.levels
    assert old.fixed_bands == old.total_share.levels


def test_wear_of_exactly_a_tenth_is_reached_through_floating_point(limits: Limits) -> None:
    clearance = (12.066e-3 - 12.000e-3) / 2.0
    wear = (clearance - 30e-6) / 30e-6
    assert wear != 0.10
    assert limits.wear is not None
    assert limits.wear.judge(wear, Verdict.OK)[0] == "watch"
    assert limits.wear.judge(0.10 * (1 - 1e-6), Verdict.OK) == ("ok", limits.wear.levels[0][1])


@given(limit=st.floats(1e-9, 1e9), ulps=st.integers(-4, 4))
def test_the_last_digits_do_not_decide(limit: float, ulps: int) -> None:
    assert reaches(limit * (1.0 + ulps * 2.3e-16), limit)
    assert not reaches(limit * (1.0 - 1e-8), limit)
    assert not reaches(-limit, limit)


@given(value=st.floats(-1.0, 10.0))
def test_steps_name_the_highest_level_reached(value: float) -> None:
    steps = Steps(((Verdict.WATCH, 1.0), (Verdict.REPLACE, 2.0), (Verdict.CRITICAL, 5.0)), LimitOrigin.PUBLISHED, "")
    verdict, limit = steps.judge(value, Verdict.OK)
    reached = [(name, level) for name, level in steps.levels if reaches(value, level)]
    assert (verdict, limit) == (reached[-1] if reached else ("ok", 1.0))


@given(st.lists(st.sampled_from(VERDICTS)))
def test_worst_is_the_worst(verdicts: list[Verdict]) -> None:
    order = ["not_measured", "ok", "watch", "replace", "critical"]
    assert worst(verdicts) == (max(verdicts, key=order.index) if verdicts else "ok")


def test_a_workshop_s_own_clearance_limit(edited: Edited) -> None:
    path = edited(
        "limits",
        "project_default",
        ("# [clearance_um]", "[clearance_um]"),
        ("# replace = 60.0", "replace = 60"),
        ('# origin = "set', 'origin = "set'),
        ('# source = "our', 'source = "our'),
    )
    clearance = load_limits(path).clearance
    assert clearance is not None
    assert clearance.origin == "set by the workshop"
    assert clearance.judge(60e-6, Verdict.OK) == ("replace", pytest.approx(60e-6, rel=1e-9, abs=0.0))
    assert clearance.judge(59.9e-6, Verdict.OK)[0] == "ok"


def test_a_rule_left_out_is_not_applied(edited: Edited) -> None:
    path = edited("limits", "project_default")
    text = path.read_text(encoding="utf-8")
    path.write_text(text[: text.index("# What one pair")] + text[text.index("# What all pairs") :], encoding="utf-8")
    assert list(load_limits(path).rules)[:3] == ["wear", "total_share", "reserve"]


def test_limits_that_judge_no_land_are_refused(edited: Edited) -> None:
    path = edited("limits", "project_default")
    text = path.read_text(encoding="utf-8")
    path.write_text(text[: text.index("# Growth")] + text[text.index("# What all pairs") :], encoding="utf-8")
    with pytest.raises(CatalogueError, match="at least one rule for a land: wear_percent"):
        load_limits(path)


@pytest.mark.parametrize(
    ("old", "new", "table", "key", "words"),
    [
        ("replace = 50.0", "replace = 10.0", "wear_percent", None, "replace above watch (10)"),
        (WEAR_WATCH + "\nreplace = 50.0\n", "", "wear_percent", None, "at least one limit"),
        (
            'origin = "choice of this project"\nsource = "derived',
            'source = "derived',
            "wear_percent",
            "origin",
            "missing",
        ),
        ('origin = "choice', 'origin = "mine', "wear_percent", "origin", "'set by the workshop'"),
        (AMBER + "\n", "", "total_share_percent", "amber", "missing"),
        (WEAR_WATCH, "watch = -10.0", "wear_percent", "watch", "greater than 0"),
        (WEAR_WATCH, 'watch = "10"', "wear_percent", "watch", "a number greater than 0, or a table such as"),
        (AMBER, "amber = { growth_percent = 75.0 }", "total_share_percent", None, "of red not below those of amber"),
        (AMBER, AMBER.replace("2.0", "9.0"), "total_share_percent", None, "of red not below those of amber"),
        (WEAR_WATCH, "watch = { at_least_um = 4.0 }", None, None, "a limit in wear_percent.watch"),
        (WEAR_WATCH, "watch = { percent = 10.0, growth_percent = 5.0 }", None, None, "growth_percent of a share only"),
        (WEAR_WATCH, "amber = 10.0", "wear_percent", "amber", "watch, replace, critical"),
        (AMBER, "amber = { added_points = 2.0 }", "total_share_percent", None, "growth_percent beside added_points"),
        (AMBER, "amber = { percent = 5.0, at_least_um = 2.0 }", None, None, "at_least_um in wear_percent only"),
        ("[total_share_percent]", "[total_share]", None, "total_share", "'total_share_percent'"),
    ],
)
def test_limits_that_cannot_be_are_refused(
    old: str, new: str, table: str | None, key: str | None, words: str, edited: Edited
) -> None:
    with pytest.raises(CatalogueError) as caught:
        load_limits(edited("limits", "project_default", (old, new)))
    assert (caught.value.place.file, caught.value.place.table, caught.value.place.key) == ("own.toml", table, key)
    assert words in str(caught.value)
