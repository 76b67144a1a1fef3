"""A run that ends in the midst of writing, whenever: nothing is lost, nothing is there twice, nothing is half there."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atleak.common.errors import FleetError
from atleak.fleet import results
from atleak.fleet.columns import Rows
from atleak.fleet.folder import ResultPart, folder_of, write_part
from atleak.fleet.results import Results
from tests.unit.fleet import writing
from tests.unit.fleet.writing import LANDS, failed, unit

State = dict[str, tuple[str, int, bool]]  # reference → hash, number of the evaluation, whether it is an error


class Ended(BaseException):
    """The program was ended: nothing of it runs any more."""


class Life:
    """So many steps of writing or removing until a program is ended, then none; without end where none are given."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.left: int | None = None
        remove = Results._remove

        def writing_while_it_lives(folder: Path, part: ResultPart, *given: Any) -> None:
            beside = part.under(folder).with_name(f".atleak-{random.getrandbits(64):016x}.part")
            self.step(beside)
            write_part(folder, part, *given)

        def removing_while_it_lives(of: Results, parts: Iterable[ResultPart]) -> None:
            for part in list(parts):
                self.step()
                remove(of, [part])

        patch.setattr(results, "write_part", writing_while_it_lives)
        patch.setattr(Results, "_remove", removing_while_it_lives)

    def step(self, unfinished: Path | None = None) -> None:
        """Go on, or end in the midst of a file."""
        if self.left == 0:
            if unfinished is not None and unfinished.parent.is_dir():
                unfinished.write_bytes(b"PAR1")
            raise Ended
        if self.left is not None:
            self.left -= 1


def with_batch(state: State, batch: Sequence[Rows]) -> State:
    """What is to be read once the rows of a batch count: of several of one reference or hash the last."""
    for rows in _last_of_each(batch):
        ((data_set, evaluation),) = (
            (name, rows.tables[name]["tries"][0].as_py()) for name in ("units", "errors") if name in rows.tables
        )
        others = {
            reference: told
            for reference, told in state.items()
            if reference != rows.reference and told[0] != rows.input_sha256
        }
        state = {**others, rows.reference: (rows.input_sha256, evaluation, data_set == "errors")}
    return state


def states_between(state: State, batch: Sequence[Rows]) -> list[State]:
    """What may be read after a batch was begun: the rows of each valve body count together, the errors last."""
    kept = _last_of_each(batch)
    keys = {("errors" in rows.tables, folder_of(rows.controller)): None for rows in kept}
    order = sorted(keys, key=lambda key: key[0])
    between, counting = [state], state
    for key in order:
        counting = with_batch(
            counting, [rows for rows in kept if ("errors" in rows.tables, folder_of(rows.controller)) == key]
        )
        between.append(counting)
    return between


def _last_of_each(batch: Sequence[Rows]) -> list[Rows]:
    def same(one: Rows, other: Rows) -> bool:
        return one.reference == other.reference or one.input_sha256 == other.input_sha256

    return [rows for at, rows in enumerate(batch) if not any(same(rows, later) for later in batch[at + 1 :])]


def read(folder: Path) -> State:
    """What atleak reads, once it was found to be whole: of every unit all of its lands, of one evaluation."""
    opened = Results.open(folder)
    state: State = {}
    for data_set in ("units", "errors"):
        columns = opened.table(data_set, ["reference", "input_sha256", "tries"]).to_pydict()  # type: ignore[arg-type]
        for reference, sha256, tries in zip(*columns.values(), strict=True):
            assert reference not in state
            state[reference] = (sha256, tries, data_set == "errors")
    assert opened.done() == {sha256 for sha256, *_ in state.values()}
    assert opened.failed() == {sha256 for sha256, _, error in state.values() if error}
    assert len(opened.done()) == len(state)
    lands = opened.table("lands", ["input_sha256", "spool_readings"]).to_pydict()
    assert sorted(zip(*lands.values(), strict=True)) == sorted(
        (sha256, tries) for sha256, tries, error in state.values() if not error for _ in range(LANDS)
    )
    return state


def check_read_by_others(folder: Path, state: State) -> None:
    """What any other program reads: exactly one row for every unit, and its lands."""
    units, errors, lands = (pd.read_parquet(folder / name) for name in ("units", "errors", "lands"))
    good = {reference: told[:2] for reference, told in state.items() if not told[2]}
    bad = {reference: told[:2] for reference, told in state.items() if told[2]}
    for found, told in ((units, good), (errors, bad)):
        rows = zip(found.reference, found.input_sha256, found.tries, strict=True)
        assert sorted((reference, (sha256, tries)) for reference, sha256, tries in rows) == sorted(told.items())
    assert sorted(lands.input_sha256) == sorted([sha256 for sha256, _ in good.values()] * LANDS)
    assert not list(folder.rglob(".atleak-*"))


one_unit = st.tuples(st.sampled_from("ABCD"), st.sampled_from("abcde"), st.sampled_from(["good", "722", "bad", "none"]))
ended_after = st.one_of(st.none(), st.integers(0, 14))
steps = st.lists(
    st.tuples(st.one_of(st.none(), st.lists(one_unit, min_size=1, max_size=4)), ended_after), min_size=1, max_size=6
)


def follow(steps: list[tuple[list[tuple[str, str, str]] | None, int | None]]) -> None:
    """Add units, or tidy where none are given, each time until the program is ended or done; look after each."""
    with tempfile.TemporaryDirectory() as name, pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "fsync", lambda handle: None)
        folder, life, evaluation = Path(name) / "fleet", Life(patch), 0
        state: State = {}
        for wanted, life_left in steps:
            batch = []
            for reference, sha256, kind in wanted or ():
                evaluation += 1
                body = {"good": "four_speed_2023", "722": "722", "bad": "722", "none": None}[kind]
                make = unit if kind in ("good", "722") else failed
                batch.append(make(reference, sha256, evaluation, body))
            with Results.open(folder, for_writing=True) as opened:
                assert read(folder) == state
                life.left = life_left
                try:
                    if wanted is None:
                        opened.tidy()
                    else:
                        opened.add(batch)
                    possible = [with_batch(state, batch)]
                except Ended:
                    possible = states_between(state, batch)
                life.left = None
            state = read(folder)
            assert state in possible
        with Results.open(folder, for_writing=True) as opened:
            opened.tidy()
        assert read(folder) == state
        check_read_by_others(folder, state)


@settings(max_examples=15)
@given(steps)
def test_whatever_is_added_ended_and_tidied_every_unit_has_one_row(steps: Any) -> None:
    follow(steps)


@pytest.mark.slow
@settings(max_examples=100)
@given(steps)
def test_whatever_else_is_added_ended_and_tidied_every_unit_has_one_row(steps: Any) -> None:
    follow(steps)


def kill_and_look(folder: Path, times: int, seed: int) -> None:
    """Start a program that writes, and kill it while it does, so many times; look at what it left every time."""
    chance, said = random.Random(seed), set[str]()
    for _ in range(times):
        command = [sys.executable, writing.__file__, str(folder), str(len(said))]
        with subprocess.Popen(command, stdout=subprocess.PIPE, encoding="utf-8") as process:
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
            for _ in range(chance.randrange(4)):
                said |= set(process.stdout.readline().strip().split(","))
            with pytest.raises(FleetError, match="another run is writing"):
                Results.open(folder, for_writing=True)
            time.sleep(chance.uniform(0.0, 0.1))
            process.kill()
            said |= {name for line in process.stdout.read().splitlines() for name in line.split(",")}
        found = read(folder)
        assert said <= found.keys(), "what was said to be written is there"
        assert found.keys() - said <= {f"unit {number}" for number in range(len(said), len(said) + 4)}
        said = set(found)
        if len(said) % 4:  # one of the batch's two valve bodies counts, and the other does not
            said = {name for name in said if int(name.split()[1]) < len(said) // 4 * 4}
    with Results.open(folder, for_writing=True) as opened:
        opened.tidy()
    check_read_by_others(folder, read(folder))


def test_a_killed_program_leaves_whole_results(tmp_path: Path) -> None:
    kill_and_look(tmp_path / "fleet", times=2, seed=18)


@pytest.mark.slow
def test_a_program_that_is_killed_many_times_leaves_whole_results(tmp_path: Path) -> None:
    kill_and_look(tmp_path / "fleet", times=20, seed=19)
