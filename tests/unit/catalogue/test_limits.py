"""Limits: a value at its limit has reached it, whatever the last digit; a set says where each limit comes from."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.catalogue.limits import LimitOrigin, Limits, Steps, load_limits, reaches
from atleak.errors import CatalogueError
from atleak.verdicts import VERDICTS, Verdict, worst

Edited = Callable[..., Path]


def test_default_limits_and_their_origins(limits: Limits) -> None:
    assert limits.wear is not None
    assert dict(limits.wear.levels) == {
        "watch": pytest.approx(0.10, rel=1e-9, abs=0.0),
        "replace": pytest.approx(0.50, rel=1e-9, abs=0.0),
    }
    assert limits.wear.origin == "published"
    assert dict(limits.total_share.levels) == pytest.approx(
        {"amber": 0.10, "red": 0.20, "critical": 0.50}, rel=1e-9, abs=0.0
    )
    assert limits.total_share.origin == "choice of this project"
    assert limits.pair_share is not None
    assert limits.pair_share.origin == "choice of this project"
    assert limits.clearance is None
    assert list(limits.rules) == ["wear", "pair_share", "total_share"]


@pytest.mark.parametrize(
    ("share", "band"),
    [
        (0.0, "green"),
        (0.0999999, "green"),
        (0.10, "amber"),
        (0.1999999, "amber"),
        (0.20, "red"),
        (0.4999999, "red"),
        (0.50, "critical"),
        (7.0, "critical"),
        (float("inf"), "critical"),
    ],
)
def test_bands_begin_at_their_limit(limits: Limits, share: float, band: str) -> None:
    assert limits.band(share) == band


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
    path.write_text(text[: text.index("# One pair")] + text[text.index("# Total") :], encoding="utf-8")
    assert list(load_limits(path).rules) == ["wear", "total_share"]


def test_limits_that_judge_no_land_are_refused(edited: Edited) -> None:
    path = edited("limits", "project_default")
    text = path.read_text(encoding="utf-8")
    path.write_text(text[: text.index("# Growth")] + text[text.index("# Total") :], encoding="utf-8")
    with pytest.raises(CatalogueError, match="at least one rule for a land: wear_percent"):
        load_limits(path)


@pytest.mark.parametrize(
    ("old", "new", "table", "key", "words"),
    [
        ("replace = 50.0", "replace = 10.0", "wear_percent", None, "replace above watch (10)"),
        ("watch = 10.0\nreplace = 50.0\n", "", "wear_percent", None, "at least one limit"),
        ('origin = "published"\n', "", "wear_percent", "origin", "missing"),
        ('origin = "published"', 'origin = "mine"', "wear_percent", "origin", "'set by the workshop'"),
        ("amber = 10.0\n", "", "total_share_percent", "amber", "missing"),
        ("watch = 10.0", "watch = -10.0", "wear_percent", "watch", "greater than 0"),
        ("watch = 10.0", "amber = 10.0", "wear_percent", "amber", "watch, replace, critical"),
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
