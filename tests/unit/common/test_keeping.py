"""What was computed from an object is kept while the object lives, and let go with it."""

from __future__ import annotations

import gc

import pytest

from atleak.common import memory as keeping
from atleak.common.memory import kept_with


class Owner:
    pass


def test_it_is_made_once_for_each_owner_and_key() -> None:
    made: list[str] = []

    def make(name: str) -> str:
        made.append(name)
        return name

    one, other = Owner(), Owner()
    assert [kept_with(one, "x", "a", lambda: make("a")) for _ in range(3)] == ["a"] * 3
    kept_with(other, "x", "a", lambda: make("other a"))
    kept_with(one, "y", "a", lambda: make("y"))
    assert made == ["a", "other a", "y"]


def test_what_would_keep_itself_alive_is_refused() -> None:
    owner = Owner()
    with pytest.raises(ValueError, match="never be let go"):
        kept_with(owner, "x", "a", lambda: owner)


def test_a_key_is_compared_and_need_not_be_hashable() -> None:
    owner, made = Owner(), []
    for rests_on in ([1], [1], [2], [1]):
        kept_with(owner, "x", rests_on, lambda: made.append(1), most=1)
    assert len(made) == 3


def test_only_the_latest_of_each_name_are_kept() -> None:
    owner = Owner()
    made: list[int] = []
    for number in (0, 1, 2, 0):
        kept_with(owner, "x", number, lambda number=number: made.append(number), most=2)
    assert made == [0, 1, 2, 0]


def test_it_is_let_go_with_its_owner() -> None:
    owner = Owner()
    kept_with(owner, "x", "a", list)
    place = id(owner)
    assert place in keeping._KEPT
    del owner
    gc.collect()
    assert place not in keeping._KEPT
