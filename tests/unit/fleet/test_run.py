"""How the units of a fleet are handed out and taken back: workers that are threads of this process, and some that fail.

`test_processes.py` does the same with processes that are really ended.
"""

from __future__ import annotations

import itertools
import pickle
import re
import socket
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import dask
import pytest
from distributed import Client, get_worker
from distributed.scheduler import KilledWorker

from atleak.common.errors import FleetError, Message
from atleak.fleet import cluster
from atleak.fleet import dispatch as running
from atleak.fleet import worker as task
from atleak.fleet.cluster import HERE, SETTINGS, connected
from atleak.fleet.dispatch import Run
from atleak.fleet.results import Results
from atleak.fleet.run import Finished, Progress, run_fleet
from atleak.fleet.units import FleetUnit
from atleak.fleet.worker import BEGUN, OVERDUE, on_worker
from tests.unit.fleet.small_units import Short, bad_unit, small_unit
from tests.unit.own_loop import awaited


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    """Two workers in this process."""
    with (
        dask.config.set(SETTINGS),
        Client(processes=False, n_workers=2, threads_per_worker=1, dashboard_address=f"{HERE}:0", set_as_default=False)
        as client,
    ):  # fmt: skip
        yield client


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """What waits for something to be said waits a little, as all of it is said in this process."""
    monkeypatch.setattr(running, "_TICK", 0.05)
    monkeypatch.setattr(running, "_TOLD_WITHIN", 0.05)
    monkeypatch.setattr(task, "_OUT", 0.05)


@pytest.fixture
def results(tmp_path: Path) -> Iterator[Results]:
    with Results.open(tmp_path / "out", for_writing=True) as results:
        yield results


Failing = Callable[[Callable[[FleetUnit, int], BaseException | None]], None]


@pytest.fixture
def failing(monkeypatch: pytest.MonkeyPatch) -> Failing:
    """Lets the tasks of some units end in an error, as dask has it where a worker is lost."""

    def let(error_of: Callable[[FleetUnit, int], BaseException | None]) -> None:
        def failing_on_worker(unit: bytes, name: str, tries: int, **options: Any) -> Any:
            error = error_of(pickle.loads(unit), tries)
            if error is not None:
                raise error
            return on_worker(unit, name, tries, **options)

        monkeypatch.setattr(running, "on_worker", failing_on_worker)

    return let


def _killed(address: str = "tcp://gone:1", failures: int = 0) -> KilledWorker:
    return KilledWorker("unit", SimpleNamespace(address=address), failures)  # type: ignore[arg-type]


def _rows(results: Results) -> dict[str, str]:
    """What became of every unit: its verdict, or the kind of its error."""
    units, errors = (results.table(name).to_pylist() for name in ("units", "errors"))
    names = [row["name"] for row in (*units, *errors)]
    assert len(names) == len(set(names)), "a unit stands there twice"
    return {row["name"]: row.get("verdict") or row["kind"] for row in (*units, *errors)}


def test_every_unit_has_one_result_and_a_bad_file_stops_nothing(client: Client, results: Results) -> None:
    units = [*map(small_unit, range(0, 800, 200)), bad_unit(7), small_unit(200)]
    said: list[Progress] = []
    finished = run_fleet(units, results, client, progress=said.append)
    alone = {unit.name: unit.opened()[0].diagnose().verdict.value for unit in units if unit.name != "unit 7"}
    assert _rows(results) == {**alone, "unit 7": "refused"}
    assert len(set(alone.values())) > 1
    assert finished == Finished(Counter(alone.values()), {"refused": 1}, before=0, twice=1, seconds=finished.seconds)
    assert (said[-1].done, said[-1].errors, said[-1].of, said[-1].workers) == (5, 1, 6, 2)


def test_running_again_does_only_what_is_missing(client: Client, results: Results) -> None:
    first, more = [small_unit(1), bad_unit(2)], [small_unit(3)]
    run_fleet(first, results, client)
    before = {row["name"]: row["evaluated_at"] for row in results.table("units").to_pylist()}
    finished = run_fleet([*first, *more], results, client)
    assert (finished.before, finished.evaluated, finished.errors) == (2, 1, {})
    after = {row["name"]: row["evaluated_at"] for row in results.table("units").to_pylist()}
    assert after["unit 1"] == before["unit 1"]
    assert set(_rows(results)) == {"unit 1", "unit 2", "unit 3"}


def test_a_file_that_took_the_name_of_another_loses_neither(client: Client, results: Results) -> None:
    first, other = small_unit(1), small_unit(200)
    run_fleet([first], results, client)
    renamed = replace(first, name="unit 1 elsewhere", reference="file:elsewhere")
    finished = run_fleet([renamed, replace(other, reference=first.reference)], results, client)
    assert set(_rows(results)) == {"unit 1 elsewhere", "unit 200"}
    assert (finished.before, finished.evaluated, finished.twice) == (0, 2, 0)


@pytest.mark.parametrize(("suffix", "group"), [(" moved", "north"), ("", "south")])
def test_a_unit_that_was_moved_stands_once_and_where_it_is_now(
    client: Client, results: Results, suffix: str, group: str
) -> None:
    first, bad, other = replace(small_unit(1), group="north"), replace(bad_unit(2), group="north"), small_unit(3)
    run_fleet([first, bad, other], results, client)
    moved = [
        replace(each, name=f"{each.name}, moved", reference=f"{each.reference}{suffix}", group=group)
        for each in (first, bad)
    ]
    copies = [replace(each, reference=f"{each.reference} copied") for each in moved]
    for before, evaluated in ((1, 1), (3, 0)):
        finished = run_fleet([*moved, other, *copies], results, client)
        assert (finished.before, finished.evaluated, finished.twice) == (before, evaluated, 2)
        rows = [row for name in ("units", "errors") for row in results.table(name).to_pylist()]
        told = {(row["name"], row["reference"], row["group"]) for row in rows}
        assert told == {(each.name, each.reference, each.group) for each in (*moved, other)}
        assert len(rows) == 3
        assert len(set(results.table("lands")["input_sha256"].to_pylist())) == 2


def test_errors_are_tried_again_where_that_is_asked_for(
    client: Client, results: Results, failing: Failing, tmp_path: Path
) -> None:
    mended = tmp_path / "mended"
    failing(lambda unit, tries: None if mended.exists() else RuntimeError())
    assert run_fleet([small_unit(1)], results, client).errors == {"fault": 1}
    mended.touch()
    assert run_fleet([small_unit(1)], results, client).before == 1
    assert run_fleet([small_unit(1)], results, client, retry_errors=True).verdicts == {"ok": 1}
    assert _rows(results) == {"unit 1": "ok"}


def test_units_of_a_worker_that_ended_are_tried_again_alone(client: Client, results: Results, failing: Failing) -> None:
    """Unit 2 takes its neighbours along; they end well as soon as it is not with them."""

    def killed(unit: FleetUnit, tries: int) -> BaseException | None:
        return _killed() if unit.name == "unit 2" or tries == 1 else None

    failing(killed)
    run_fleet([*map(small_unit, range(5))], results, client)
    assert _rows(results) == {**{f"unit {number}": "ok" for number in (0, 1, 3, 4)}, "unit 2": "ended"}
    tries = {row["name"]: row["tries"] for name in ("units", "errors") for row in results.table(name).to_pylist()}
    assert tries == {**dict.fromkeys(("unit 0", "unit 1", "unit 3", "unit 4"), 2), "unit 2": 1 + running.TRIES_ALONE}
    (row,) = results.table("errors").to_pylist()
    assert row["message"] == "unit 2: the process that worked on it ended each time, 3 times in all"


def test_a_scheduler_that_tries_several_workers_counts_them(client: Client, results: Results, failing: Failing) -> None:
    failing(lambda unit, tries: _killed(failures=3) if tries == 1 else None)
    run_fleet([small_unit(1)], results, client)
    assert results.table("units").column("tries").to_pylist() == [5]


def test_a_unit_for_which_the_memory_does_not_suffice_is_tried_again_alone(client: Client, results: Results) -> None:
    finished = run_fleet([small_unit(1, Short)], results, client)
    assert finished.errors == {"ended": 1}
    assert results.table("errors").column("tries").to_pylist() == [1 + running.TRIES_ALONE]


def test_a_worker_that_was_ended_for_its_memory_is_named_as_that(
    client: Client, results: Results, failing: Failing
) -> None:
    client.log_event("worker-restart-memory", {"worker": "tcp://gone:2", "pid": 1, "rss": 2_340_000_000})
    failing(lambda unit, tries: _killed("tcp://gone:2"))
    run_fleet([small_unit(1)], results, client)
    (row,) = results.table("errors").to_pylist()
    assert row["message"] == "unit 1: needs more memory than a worker may take: it had 2.3 GB when it was ended"


def test_a_unit_that_takes_too_long_has_one_more_try(client: Client, results: Results, failing: Failing) -> None:
    """Its worker names it before it leaves."""

    def leaving(unit: FleetUnit, tries: int) -> BaseException | None:
        if unit.name != "unit 0":
            return None
        get_worker().log_event(OVERDUE, {"name": get_worker().get_current_task()[1], "worker": "tcp://gone:3"})
        time.sleep(0.2)
        return _killed("tcp://gone:3")

    failing(leaving)
    finished = run_fleet([small_unit(0), small_unit(1)], results, client, time_limit=30.0)
    assert (finished.errors, finished.evaluated) == ({"time limit": 1}, 1)
    (row,) = results.table("errors").to_pylist()
    assert (row["tries"], row["name"]) == (running.TRIES_OVERDUE, "unit 0")
    assert row["message"] == "unit 0: takes longer than the 30 s that one unit may take"


@pytest.mark.parametrize(("after", "kind"), [("handed out", "ended"), ("begun", "time limit")])
def test_the_time_of_a_unit_alone_counts_from_where_its_worker_begins_it(
    client: Client, results: Results, monkeypatch: pytest.MonkeyPatch, after: str, kind: str
) -> None:
    """A worker that ends long after it was handed the unit may have been starting all the time."""

    def ending(unit: bytes, name: str, tries: int, **options: Any) -> Any:
        if options["tell_begun"]:
            if after == "begun":
                get_worker().log_event(BEGUN, {"name": name})
            time.sleep(0.4)
        raise _killed()

    monkeypatch.setattr(running, "on_worker", ending)
    assert run_fleet([small_unit(1)], results, client, time_limit=0.2).errors == {kind: 1}


def test_a_worker_says_when_it_begins_a_unit_alone(client: Client, results: Results, failing: Failing) -> None:
    failing(lambda unit, tries: _killed() if tries == 1 else None)
    run = Run([small_unit(1)], {}, results, client, 30.0, lambda run: None)
    run.go()
    assert len(run._begun) == 1


def test_a_unit_that_waited_at_a_worker_that_left_is_not_to_blame(
    client: Client, results: Results, failing: Failing, tmp_path: Path
) -> None:
    lost = tmp_path / "lost"

    def left(unit: FleetUnit, tries: int) -> BaseException | None:
        if lost.exists():
            return None
        lost.touch()
        return _killed("tcp://gone:4")

    failing(left)
    run = Run([small_unit(1)], {}, results, client, 30.0, lambda run: None)
    run._left.add("tcp://gone:4")
    run.go()
    assert results.table("units").column("tries").to_pylist() == [1]


def test_another_fault_of_a_task_is_an_error_of_its_unit(client: Client, results: Results, failing: Failing) -> None:
    failing(lambda unit, tries: RuntimeError("odd"))
    run_fleet([small_unit(1)], results, client)
    (row,) = results.table("errors").to_pylist()
    assert (row["kind"], row["message"]) == ("fault", "unit 1: unexpected RuntimeError: odd. This is a fault of atleak")


def test_workers_of_another_version_are_refused(
    client: Client, results: Results, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(running, "__version__", "0.0.1")
    with pytest.raises(FleetError, match=r"the workers cannot run this atleak, 0\.0\.1: OtherVersionError"):
        run_fleet([small_unit(1)], results, client)
    assert _rows(results) == {}


def test_what_is_finished_is_kept_when_the_run_is_interrupted(client: Client, results: Results) -> None:
    def interrupted(run: Run) -> None:
        if run.done >= 3:
            raise KeyboardInterrupt

    units = [*map(small_unit, range(12))]
    with pytest.raises(KeyboardInterrupt):
        Run(units, {}, results, client, None, interrupted).go()
    kept = _rows(results)
    assert 3 <= len(kept) < 12
    finished = run_fleet(units, results, client)
    assert (finished.before, finished.evaluated) == (len(kept), 12 - len(kept))
    assert set(_rows(results)) == {unit.name for unit in units}


def test_a_run_without_workers_ends_and_says_so(results: Results, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "PATIENCE", 0.0)
    with (
        Client(processes=False, n_workers=0, dashboard_address=f"{HERE}:0", set_as_default=False) as none,
        pytest.raises(FleetError, match=r"there has been no worker for \d+ s; expected the run to be started again"),
    ):
        run_fleet([small_unit(1)], results, none)


def test_a_run_without_workers_says_now_and_then_where_and_until_when_it_waits(
    results: Results, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = itertools.count(1000.0, 2.0)  # two seconds go by between any two looks at it
    monkeypatch.setattr(running, "time", SimpleNamespace(monotonic=lambda: next(clock), sleep=time.sleep))
    told: list[Message] = []
    with Client(processes=False, n_workers=0, dashboard_address=f"{HERE}:0", set_as_default=False) as none:
        address = none.scheduler.address
        with pytest.raises(FleetError, match="there has been no worker for 3"):
            run_fleet([small_unit(1)], results, none, tell=told.append)
    said = [re.fullmatch(rf"no worker for (\d+) s at {address}; waiting until \d\d:\d\d", each.text) for each in told]
    seconds = [int(each[1]) for each in said if each]
    assert len(said) == len(seconds) == 5
    assert 10 <= seconds[0] < 30
    assert all(60 <= later - earlier < 90 for earlier, later in itertools.pairwise(seconds))


def test_a_scheduler_that_ends_is_named_and_what_was_finished_is_kept(results: Results) -> None:
    def ended(run: Run) -> None:
        if run.done >= 2 and other.cluster is not None:
            other.cluster.close()

    units = [*map(small_unit, range(12))]
    with (
        Client(
            processes=False, n_workers=1, threads_per_worker=1, dashboard_address=f"{HERE}:0", set_as_default=False
        ) as other,
        pytest.raises(FleetError, match="the scheduler does not answer any more"),
    ):
        Run(units, {}, results, other, None, ended).go()
    assert 2 <= len(_rows(results)) < 12


def test_nobody_at_an_address_is_said_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "_ANSWER", 0.5)
    address = f"tcp://{HERE}:9"
    with pytest.raises(FleetError, match="no dask scheduler answers there") as error:
        connected(address).__enter__()
    assert address in str(error.value)


@pytest.mark.parametrize("address", ["nonsense", "http://x:80", "tcp://:8786", "tcp://x:0", "tcp://x:65536", "x:²"])
def test_what_is_no_address_is_refused_before_anything_tries_to_reach_it(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "_answering", None)
    with pytest.raises(FleetError, match=r"is no address of a scheduler \(found .*; expected the address that"):
        connected(address).__enter__()


def test_what_listens_and_says_nothing_is_no_scheduler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "_ANSWER", 0.5)
    with (
        socket.create_server((HERE, 0)) as silent,
        pytest.raises(FleetError, match=r"no dask scheduler answers there: no answer within 0\.5 s"),
    ):
        awaited(_inside_a_loop(f"tcp://{HERE}:{silent.getsockname()[1]}"))


async def _inside_a_loop(address: str) -> None:
    """A notebook has a loop running wherever it computes."""
    connected(address).__enter__()


def test_a_client_that_cannot_be_made_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else it goes on trying, and holds up the program's end."""
    made: list[Client] = []
    start = Client.start

    async def answering(address: str) -> None:
        """The scheduler ends in the moment after its answer."""

    def starting(self: Client, **options: Any) -> None:
        made.append(self)
        start(self, **options)

    monkeypatch.setattr(cluster, "_answering", answering)
    monkeypatch.setattr(cluster, "_ANSWER", 0.5)
    monkeypatch.setattr(Client, "start", starting)
    with pytest.raises(FleetError, match="no dask scheduler answers there"):
        connected(f"tcp://{HERE}:9").__enter__()
    assert [each.status for each in made] == ["closed"]


def test_without_dask_the_run_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(FleetError, match=r'python -m pip install "\.\[fleet\]" in the folder'):
        connected().__enter__()


def test_other_versions_at_the_workers_are_told() -> None:
    here = {
        "python": "3.12.1.final.0",
        "numpy": "2.4.6",
        "pandas": "3.1.1",
        "dask": "2026.8.0",
        "distributed": "2026.8.0",
    }
    versions = {
        "client": {"packages": here},
        "workers": {"a": {"packages": here}, "b": {"packages": {**here, "numpy": "2.3.0", "lz4": "1"}}},
    }
    (message,) = cluster._other_versions(versions)
    assert message.text.endswith("differ: numpy 2.3.0 (2.4.6)")
    del versions["workers"]["b"]
    assert not [*cluster._other_versions(versions)]


@pytest.mark.parametrize(("memory", "workers"), [(64e9, 16), (4e9, 7), (0.2e9, 1)])
def test_as_many_workers_are_started_as_the_memory_allows(
    monkeypatch: pytest.MonkeyPatch, memory: float, workers: int
) -> None:
    started: dict[str, Any] = {}

    def local_cluster(**options: Any) -> nullcontext[None]:
        started.update(options)
        return nullcontext()

    monkeypatch.setattr("dask.system.CPU_COUNT", 16)
    monkeypatch.setattr("distributed.system.MEMORY_LIMIT", int(memory))
    monkeypatch.setattr("distributed.LocalCluster", local_cluster)
    monkeypatch.setattr("distributed.Client", lambda *_, **__: nullcontext())
    with connected():
        pass
    assert started["n_workers"] == workers
    assert started["n_workers"] * started["memory_limit"] <= 0.9 * memory
    assert (started["host"], started["threads_per_worker"]) == (HERE, 1)
