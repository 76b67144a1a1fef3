"""A fleet's run with real processes: workers, a scheduler and a client that are ended in the midst of it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import cache
from pathlib import Path

import psutil
import pytest
from distributed import Client

from atleak.common.errors import FleetError
from atleak.fleet import dispatch
from atleak.fleet.cluster import HERE, connected
from atleak.fleet.results import Results
from atleak.fleet.run import Finished, Progress, run_fleet
from atleak.fleet.units import FleetUnit
from atleak.job.result import result_record
from tests.unit.fleet.small_units import Deadly, Greedy, Lost, OnceDeadly, Slow, Stuck, bad_unit, small_unit

# draws as many as the workers do
pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("all_draws")]

UNITS = 40
CLIENT = """
import os, signal, sys
from pathlib import Path

import psutil

from atleak.fleet import cluster, dispatch
from atleak.fleet.cluster import connected
from atleak.fleet.results import Results
from atleak.fleet.run import run_fleet
from tests.unit.fleet.small_units import small_unit

def main():
    out, count, address = sys.argv[1:]
    dispatch.WRITTEN_EVERY = float(os.environ.get("WRITTEN_EVERY", dispatch.WRITTEN_EVERY))
    cluster._ANSWER = float(os.environ.get("ANSWER", cluster._ANSWER))
    kills, killed = int(os.environ.get("KILLS", 0)), []
    with Results.open(Path(out), for_writing=True) as results, connected(address or None, 2) as client:

        def kill(progress):
            if len(killed) < kills and progress.done >= progress.of // 8 * len(killed):
                for pid in list(client.run(os.getpid).values())[:1]:
                    psutil.Process(pid).kill()
                    killed.append(pid)
                    print(pid, flush=True)

        print("begun", flush=True)
        print(run_fleet([*map(small_unit, range(int(count)))], results, client, progress=kill).evaluated, flush=True)

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # what a shell starts in the background ignores it
    main()
"""


@pytest.fixture(autouse=True)
def importable(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets processes that are started import the tests' own units."""
    monkeypatch.syspath_prepend(str(root))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(root), os.environ.get("PYTHONPATH", "")]))


@pytest.fixture
def written_often(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets clients that are started write what is finished four times a second."""
    monkeypatch.setenv("WRITTEN_EVERY", "0.25")


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


def _run(out: Path, units: Sequence[FleetUnit], **options: object) -> Finished:
    """A run on two workers of its own."""
    with Results.open(out, for_writing=True) as results, connected(workers=2) as client:
        return run_fleet(units, results, client, **options)  # type: ignore[arg-type]


def _rows(out: Path, *columns: str) -> dict[str, tuple[object, ...]]:
    """What is kept of every unit: its verdict or the kind of its error, and other columns."""
    results = Results.open(out)
    rows = [row for name in ("units", "errors") for row in results.table(name).to_pylist()]
    kept = {row["name"]: (row.get("verdict") or row["kind"], *(row[name] for name in columns)) for row in rows}
    assert len(kept) == len(rows), "a unit stands there twice"
    return kept


def _as_alone(out: Path, units: Sequence[FleetUnit]) -> None:
    """Every unit has exactly one result, and it is the one that `diagnose` gives by itself."""
    results = Results.open(out)
    assert results.table("errors").num_rows == 0
    rows = results.table("units", ["name", "result_sha256"]).to_pylist()
    assert sorted(row["name"] for row in rows) == sorted(unit.name for unit in units)
    assert {row["name"]: row["result_sha256"] for row in rows} == {unit.name: _alone(unit) for unit in units}


@cache
def _alone(unit: FleetUnit) -> str:
    return str(result_record(unit.opened()[0].diagnose())["result_sha256"])


def test_workers_of_this_machine_are_reached_from_it_alone(out: Path) -> None:
    me = psutil.Process()
    before = {each.laddr for each in me.net_connections("inet")}
    with connected(workers=2) as client:
        processes = [me, *me.children(recursive=True)]
        listening = [
            each.laddr.ip
            for process in processes
            for each in process.net_connections("inet")
            if each.status == psutil.CONN_LISTEN and each.laddr not in before
        ]
        workers = client.run(os.getpid)
        with pytest.raises((OSError, TimeoutError)):
            Client(client.scheduler.address.replace("tls://", "tcp://"), timeout=2.0, set_as_default=False)
    assert len(workers) == 2
    assert set(listening) == {HERE}
    assert not [pid for pid in workers.values() if psutil.pid_exists(pid)]


def test_units_that_harm_their_worker_cost_a_retry_and_then_one_error_each(out: Path, tmp_path: Path) -> None:
    harmful = {Deadly: "ended", Slow: "time limit", Stuck: "time limit"}
    units = [
        small_unit(0),
        *(small_unit(number, kind) for number, kind in enumerate(harmful, 1)),
        *map(small_unit, range(4, 12)),
        bad_unit(12),
        small_unit(13, OnceDeadly, mark=str(tmp_path / "mark")),
    ]
    said: list[Progress] = []
    finished = _run(out, units, time_limit=6.0, progress=said.append)
    assert finished.errors == {"ended": 1, "time limit": 2, "refused": 1}
    kept = _rows(out, "tries")
    assert kept == {
        **{unit.name: ("ok", tries) for unit in units if (tries := kept[unit.name][1]) in (1, 2)},
        "unit 1": ("ended", 1 + dispatch.TRIES_ALONE),
        "unit 2": ("time limit", dispatch.TRIES_OVERDUE),
        "unit 3": ("time limit", 2),
        "unit 12": ("refused", kept["unit 12"][1]),
    }
    assert kept["unit 13"] == ("ok", 2)
    assert said[-1].done == len(units)


def test_a_unit_whose_result_is_lost_before_it_fails_is_an_error(out: Path, tmp_path: Path) -> None:
    units = [small_unit(0), small_unit(1, Lost, mark=str(tmp_path / "mark")), *map(small_unit, range(2, 6))]
    assert _run(out, units).errors == {"ended": 1}
    assert _rows(out) == {**{unit.name: ("ok",) for unit in units}, "unit 1": ("ended",)}


def test_a_unit_that_takes_too_much_memory_is_an_error_that_says_so(out: Path) -> None:
    units = [small_unit(0), small_unit(1, Greedy), *map(small_unit, range(2, 8))]
    with (
        Results.open(out, for_writing=True) as results,
        connected(workers=2, memory_limit=600_000_000) as client,
    ):
        run_fleet(units, results, client)
    kept = _rows(out)
    assert kept == {**{unit.name: ("ok",) for unit in units}, "unit 1": ("ended",)}
    (row,) = Results.open(out).table("errors").to_pylist()
    assert row["message"].startswith("unit 1: needs more memory than a worker may take: it had 0.")


@contextmanager
def _ending(process: subprocess.Popen[str]) -> Iterator[subprocess.Popen[str]]:
    """A process that is ended with those that it started, whatever happens."""
    try:
        yield process
    finally:
        _kill(process)


def _kill(process: subprocess.Popen[str]) -> None:
    """Kill a process; those that it started then end by themselves, which is waited for."""
    children = psutil.Process(process.pid).children(recursive=True) if process.poll() is None else []
    process.kill()
    process.communicate()
    _, left = psutil.wait_procs(children, timeout=60.0)
    for child in left:
        child.kill()
    assert not left


def _start(*command: str) -> subprocess.Popen[str]:
    """A program of Python's in a group of its own, so that Ctrl-C reaches it alone."""
    group = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP} if sys.platform == "win32" else {"process_group": 0}
    return subprocess.Popen(
        [sys.executable, *command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8", **group
    )  # type: ignore[call-overload,no-any-return]


def _client(out: Path, address: str = "") -> subprocess.Popen[str]:
    script = out.with_suffix(".py")
    script.write_text(CLIENT, encoding="utf-8")
    return _start(str(script), str(out), str(UNITS), address)


def _until_some_are_written(out: Path) -> int:
    """Wait until some units are written, and return how many."""
    until = time.monotonic() + 120.0
    while time.monotonic() < until:
        written = len(Results.open(out).done()) if (out / "run.json").exists() else 0
        if written:
            return written
        time.sleep(0.05)
    raise AssertionError("nothing was written")


@contextmanager
def _cluster(folder: Path, port: int = 0) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """A scheduler and two workers started by hand: its address, and its process."""
    file = folder / "scheduler.json"
    file.unlink(missing_ok=True)
    with ExitStack() as stack:
        common = ["--host", HERE, "--preload", "atleak.fleet.prepared"]
        options = [*common, "--port", str(port), "--dashboard-address", f"{HERE}:0", "--scheduler-file", str(file)]
        scheduler = stack.enter_context(_ending(_start("-m", "dask", "scheduler", *options)))
        until = time.monotonic() + 60.0
        while not (file.exists() and file.stat().st_size) and time.monotonic() < until:
            time.sleep(0.05)
        address = json.loads(file.read_text(encoding="utf-8"))["address"]
        options = [*common, "--nworkers", "2", "--nthreads", "1", "--no-dashboard"]
        stack.enter_context(_ending(_start("-m", "dask", "worker", address, *options)))
        yield address, scheduler


def test_workers_killed_five_times_lose_nothing_and_complain_of_nothing(
    out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("KILLS", "5")
    with _ending(_client(out)) as client:
        said, errors = client.communicate()
    *killed, evaluated = said.split()[1:]
    assert len(set(killed)) == 5
    assert (evaluated, errors) == (str(UNITS), "")
    _as_alone(out, [*map(small_unit, range(UNITS))])


def test_a_client_that_is_killed_goes_on_where_it_was(out: Path, written_often: None) -> None:
    with _ending(_client(out)) as first:
        _until_some_are_written(out)
        _kill(first)
    kept = _rows(out, "evaluated_at")
    assert 0 < len(kept) < UNITS
    with _ending(_client(out)) as second:
        said, errors = second.communicate()
    assert (said.split(), errors) == (["begun", str(UNITS - len(kept))], "")
    _as_alone(out, [*map(small_unit, range(UNITS))])
    assert {name: row for name, row in _rows(out, "evaluated_at").items() if name in kept} == kept


@pytest.mark.skipif(sys.platform == "win32", reason="there it is the console that sends Ctrl-C")
def test_ctrl_c_ends_in_order_and_keeps_what_is_finished(out: Path, written_often: None) -> None:
    with _ending(_client(out)) as client:
        _until_some_are_written(out)
        os.killpg(client.pid, signal.SIGINT)  # as a terminal does: the workers get it too
        _, errors = client.communicate()
    assert errors.splitlines()[-1] == "KeyboardInterrupt"
    assert errors.count("Traceback") == 1, "a worker has complained too"
    kept = _rows(out)
    assert 0 < len(kept) < UNITS
    finished = _run(out, [*map(small_unit, range(UNITS))])
    assert (finished.before, finished.evaluated) == (len(kept), UNITS - len(kept))


@pytest.mark.skipif(sys.platform == "win32", reason="there nothing holds Ctrl-C back from workers that start")
def test_ctrl_c_while_the_workers_start_ends_in_order(out: Path) -> None:
    with _ending(_client(out)) as client:
        while not any("spawn_main" in " ".join(each.cmdline()) for each in psutil.Process(client.pid).children()):
            time.sleep(0.01)
        os.killpg(client.pid, signal.SIGINT)
        said, errors = client.communicate()
    assert (said, errors.splitlines()[-1], errors.count("Traceback")) == ("", "KeyboardInterrupt", 1)


def test_a_second_client_on_the_same_results_is_refused(out: Path) -> None:
    with _ending(_client(out)) as first:
        assert first.stdout is not None
        assert first.stdout.readline() == "begun\n"
        with pytest.raises(FleetError, match="another"):
            Results.open(out, for_writing=True)
        said, errors = first.communicate()
    assert (said, errors) == (f"{UNITS}\n", "")


def test_a_scheduler_that_is_killed_loses_nothing(
    out: Path, tmp_path: Path, written_often: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its client says so and ends; with another scheduler it goes on."""
    monkeypatch.setenv("ANSWER", "5")
    units = [*map(small_unit, range(UNITS))]
    with _cluster(tmp_path) as (address, scheduler), _ending(_client(out, address)) as client:
        _until_some_are_written(out)
        scheduler.kill()
        _, errors = client.communicate()
    assert "the scheduler does not answer any more" in errors.splitlines()[-1]
    kept = _rows(out)
    assert 0 < len(kept) < UNITS
    with _cluster(tmp_path) as (address, _), _ending(_client(out, address)) as client:
        said, errors = client.communicate()
    assert (said.split(), errors) == (["begun", str(UNITS - len(kept))], "")
    _as_alone(out, units)


def test_a_scheduler_that_comes_back_is_found_again(out: Path, tmp_path: Path, written_often: None) -> None:
    units = [*map(small_unit, range(UNITS))]
    with ExitStack() as stack:
        address, scheduler = stack.enter_context(_cluster(tmp_path))
        client = stack.enter_context(_ending(_client(out, address)))
        _until_some_are_written(out)
        scheduler.kill()
        scheduler.wait()
        stack.enter_context(_cluster(tmp_path, int(address.rpartition(":")[2])))
        said, errors = client.communicate()
    assert (said.split(), errors) == (["begun", str(UNITS)], "")
    _as_alone(out, units)
