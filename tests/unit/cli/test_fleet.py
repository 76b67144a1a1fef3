"""``atleak fleet run``: what it tells of a fleet, and its exit status. The workers are tried in `tests/unit/fleet`."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from atleak.common.errors import FleetError, Message
from atleak.common.sentences import Sentence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.fleet import cluster
from atleak.fleet import run as fleet_run
from atleak.fleet.folder import known_folders
from atleak.fleet.results import Results
from atleak.fleet.run import Finished, Progress
from atleak.fleet.worker import evaluate_unit
from atleak.job.case import Case
from atleak.job.parts import job_parts
from atleak.job.zip_file import write_job_file
from atleak.job_book.book import open_book
from atleak.measurements.job_card import Job
from atleak.version import __version__
from tests.unit.cli.conftest import Run

_FREE = "a folder that is new or empty, or one with results of a fleet"


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Has units evaluated here, without workers, and keeps what was asked of them."""
    asked: dict[str, Any] = {}

    @contextmanager
    def connected(scheduler: str | None, workers: int | None, *, tell: Callable[[Message], None]) -> Iterator[None]:
        asked.update(scheduler=scheduler, workers=workers)
        if scheduler is not None:
            tell(Message("warning", "other_versions", Sentence("workers have other versions")))
        yield None

    def run_fleet(
        units: Any, results: Results, client: None, *, progress: Callable[[Progress], None], **options: Any
    ) -> Finished:
        asked.update(options, units=len(units))
        known = results.done() - (results.failed() if options["retry_errors"] else set())
        rows = [evaluate_unit(unit) for unit in units if unit.input_sha256 not in known]
        results.add(rows)
        progress(Progress(done=len(rows), errors=1, before=0, of=len(units), seconds=2.0, workers=1))
        verdicts = Counter(str(each.verdict) for each in rows if each.verdict is not None)
        return Finished(verdicts, {"refused": len(rows) - verdicts.total()}, before=0, twice=0, seconds=2.0)

    monkeypatch.setattr(cluster, "connected", connected)
    monkeypatch.setattr(fleet_run, "run_fleet", run_fleet)
    return asked


@pytest.fixture
def jobs(unmeasured: Diagnosis, tmp_path: Path) -> Path:
    """A folder of three job files in two groups, of which one is there twice."""
    for name, number in (("north/1", "1"), ("south/2", "2"), ("south/again", "2")):
        path = tmp_path / "jobs" / f"{name}.zip"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(write_job_file(unmeasured, Job(number=number)))
    return tmp_path / "jobs"


def test_a_run_counts_verdicts_and_tells_what_is_there_twice(
    run: Run, asked: dict[str, Any], jobs: Path, tmp_path: Path
) -> None:
    out = tmp_path / "results"
    status, printed, told = run("fleet", "run", jobs, "--out", out, "--workers", 3)
    assert status == 0
    assert printed.splitlines() == [f"2 units tried in 2 s; 2 with a result in {out}:", "       2  ○ not measured"]
    assert f"{jobs / 'south' / 'again.zip'}: the same as {jobs / 'south' / '2.zip'}, which is evaluated once" in told
    assert {name: value for name, value in asked.items() if name != "tell"} == {
        "scheduler": None, "workers": 3, "units": 3, "time_limit": 1800.0, "retry_errors": False,
    }  # fmt: skip
    assert pq.read_table(out / "units")["group"].to_pylist() == ["north", "south"]
    assert [each.path for each in known_folders()] == [out.resolve()]  # which the dashboard offers
    status, printed, _ = run("fleet", "run", jobs, "--out", out, "--time-limit", 0)
    assert (status, printed.splitlines()[0]) == (0, f"0 units tried in 2 s; 2 with a result in {out}:")
    assert asked["time_limit"] is None


def test_a_bad_file_stops_no_other_and_ends_with_status_2(
    run: Run, asked: dict[str, Any], jobs: Path, tmp_path: Path
) -> None:
    out = tmp_path / "results"
    (jobs / "bad.zip").write_bytes(b"no job at all")
    for new in (3, 0):  # the same again, though nothing is done again
        status, printed, told = run("fleet", "run", jobs, "--out", out)
        assert (status, printed.splitlines()[0]) == (2, f"{new} units tried in 2 s; 2 with a result in {out}:")
        assert "atleak: 1 without a result (refused):" in told
        assert f"  {jobs / 'bad.zip'}: is no sound zip" in told
        assert f"every error stands in {out / 'errors'}; --retry-errors tries them again" in told
    (jobs / "bad.zip").unlink()
    status, _, told = run("fleet", "run", jobs, "--out", out)
    assert status == 0
    assert "1 of units that were not given this time" in told
    run("fleet", "run", jobs, "--out", out, "--retry-errors")
    assert asked["retry_errors"] is True


def test_fail_on_is_for_every_unit_of_the_results(
    run: Run, asked: dict[str, Any], jobs: Path, small_sheet: Callable[..., Path], tmp_path: Path
) -> None:
    small_sheet(sleeve=11.2)
    table = tmp_path / "fleet.csv"
    table.write_text("sheet,controller,Batch,Job\nsmall.csv,minimal_example,7,A-1\n", encoding="utf-8")
    out = tmp_path / "results"
    status, printed, told = run("fleet", "run", table, "--out", out)
    assert status == 0
    assert "critical" in printed
    assert "fleet.csv: columns that are kept as labels of their units: Batch" in told
    for level, expected in (("watch", 1), ("critical", 1)):
        assert run("fleet", "run", jobs, "--out", out, "--fail-on", level)[0] == expected
    assert run("fleet", "run", jobs, "--out", out, "--fail-on", "watch", "--replace")[0] == 0
    assert pq.read_table(out / "units")["number"].to_pylist() == ["1", "2"]


def test_a_row_is_diagnosed_as_the_command_diagnose_does(
    run: Run,
    asked: dict[str, Any],
    record_of: Callable[..., dict[str, Any]],
    small_sheet: Callable[..., Path],
    edited: Callable[..., Path],
    tmp_path: Path,
) -> None:
    sheet, own, out = small_sheet(), edited("controllers", "minimal_example"), tmp_path / "results"
    table = tmp_path / "fleet.csv"
    table.write_text("sheet,mileage\nsmall.csv,120000\n", encoding="utf-8")
    chosen = ("--controller", own, "--temperature", 85, "--assume", "eccentricity=unknown", "--guard", "1.5")
    assert run("fleet", "run", table, "--out", out, *chosen)[0] == 0
    alone = record_of(sheet, "--mileage", 120000, *chosen)
    assert pq.read_table(out / "units")["result_sha256"].to_pylist() == [alone["result_sha256"]]


def test_the_head_of_a_sheet_says_whose_it_is_where_its_row_does_not(
    run: Run, asked: dict[str, Any], small_sheet: Callable[..., Path], tmp_path: Path
) -> None:
    sheet, out = small_sheet(), tmp_path / "results"
    head = "Job:,S-7\nVIN:,WVWZZZ1JZXW000001\nMileage:,98765\n\n"
    sheet.write_text(head + sheet.read_text(encoding="utf-8"), encoding="utf-8")
    table = tmp_path / "fleet.csv"
    table.write_text("sheet,VIN\nsmall.csv,\nsmall.csv,WVWZZZ1JZXW000001\n", encoding="utf-8")
    assert run("fleet", "run", table, "--out", out, "--controller", "minimal_example")[0] == 0
    units = pq.read_table(out / "units")
    assert [units[name].to_pylist() for name in ("number", "vin", "mileage_km")] == [
        ["S-7"] * 2, ["WVWZZZ1JZXW000001"] * 2, [98765.0] * 2,
    ]  # fmt: skip


def test_jobs_of_the_book_are_a_source(run: Run, asked: dict[str, Any], unmeasured: Diagnosis, tmp_path: Path) -> None:
    book = open_book()
    for number in ("A-1", "A-2", "B-1"):
        book.save(job_parts(unmeasured, Job(number=number), Case()))
    status, _, _ = run("fleet", "run", "--book", "--text", "A-", "--out", tmp_path / "results")
    assert status == 0
    assert sorted(pq.read_table(tmp_path / "results" / "units")["number"].to_pylist()) == ["A-1", "A-2"]


def test_choices_that_do_nothing_are_doubted(run: Run, asked: dict[str, Any], jobs: Path, tmp_path: Path) -> None:
    given = ("--out", tmp_path / "results", "--text", "A-", "--controller", "five_speed_2005")
    status, _, told = run("fleet", "run", jobs, *given)
    assert status == 0
    assert "atleak: --text does nothing without --book" in told
    assert "atleak: choices for units do nothing without a table of units: a job has its own" in told


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ((), "no job is given; expected job files, folders, tables of units, or --book"),
        (("gone.zip",), "gone.zip: no such file or folder"),
        (("jobs", "--workers", "0"), "'0' is no number of processes"),
        (("jobs", "--workers", "2", "--scheduler", "tcp://x:1"), "not allowed with argument"),
        (("jobs", "--time-limit", "-1"), "'-1' is no time"),
    ],
)
def test_what_cannot_be_run_ends_with_status_2(
    run: Run, asked: dict[str, Any], tmp_path: Path, given: tuple[str, ...], said: str
) -> None:
    status, _, told = run("fleet", "run", *given, "--out", tmp_path / "results")
    assert status == 2
    assert said in told
    assert not (tmp_path / "results").exists()


def test_what_is_to_know_of_workers_elsewhere_is_told(
    run: Run, asked: dict[str, Any], jobs: Path, tmp_path: Path
) -> None:
    status, _, told = run("fleet", "run", jobs, "--out", tmp_path / "results", "--scheduler", "tcp://10.0.0.5:8786")
    assert (status, asked["scheduler"]) == (0, "tcp://10.0.0.5:8786")
    assert "atleak: workers have other versions" in told


def test_without_its_workers_one_sentence_says_what_to_install(
    run: Run, jobs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    @contextmanager
    def connected(*_: object, **__: object) -> Iterator[None]:
        raise FleetError(Sentence("a fleet run needs dask.distributed, which is not installed"))
        yield

    monkeypatch.setattr(cluster, "connected", connected)
    status, printed, told = run("fleet", "run", jobs, "--out", tmp_path / "results")
    assert (status, printed) == (2, "")
    assert told.startswith("atleak: a fleet run needs dask.distributed, which is not installed")
    assert not (tmp_path / "results").exists()


def test_units_of_earlier_runs_are_counted_and_an_error_comes_before_a_level(
    run: Run, asked: dict[str, Any], jobs: Path, small_sheet: Callable[..., Path], tmp_path: Path
) -> None:
    out, given = tmp_path / "results", jobs / "north" / "1.zip"
    _, printed, _ = run("fleet", "run", given, "--out", out)
    assert printed.splitlines() == [f"1 unit tried in 2 s; 1 with a result in {out}:", "       1  ○ not measured"]
    _, printed, _ = run("fleet", "run", jobs / "south", "--out", out)
    assert printed.splitlines()[-1] == "1 unit of these was not given this time"
    (jobs / "bad.zip").write_bytes(b"no job at all")
    small_sheet(sleeve=11.2)
    table = tmp_path / "fleet.csv"
    table.write_text("sheet,controller\nsmall.csv,minimal_example\n", encoding="utf-8")
    for more, expected in (((), 1), ((jobs / "bad.zip",), 2)):
        assert run("fleet", "run", table, *more, "--out", out, "--fail-on", "critical")[0] == expected


def test_where_not_all_errors_are_printed_a_command_lists_them(
    run: Run, asked: dict[str, Any], jobs: Path, tmp_path: Path
) -> None:
    for number in range(33):
        (jobs / f"bad {number}.zip").write_bytes(b"no job at all %d" % number)
    status, _, told = run("fleet", "run", jobs, "--out", tmp_path / "results")
    assert status == 2
    assert "atleak: 33 without a result (refused):" in told
    assert told.count("is no sound zip") == 30
    (line,) = [line for line in told.splitlines() if "… and 3 more: `atleak " in line]
    status, listed, _ = run(*line.partition("`atleak ")[2].partition("` lists all")[0].split(" ", 3))
    assert (status, len(listed.splitlines())) == (0, 33)
    assert all(": is no sound zip" in each and each.endswith(" (refused)") for each in listed.splitlines())


@pytest.fixture
def unreached(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Lets no scheduler answer, and keeps which one was asked for."""
    asked_for: list[str] = []

    @contextmanager
    def connected(scheduler: str | None, *_: object, **__: object) -> Iterator[None]:
        asked_for.append(str(scheduler))
        raise FleetError(Sentence("no dask scheduler answers there: {reason}", reason="none"))
        yield

    monkeypatch.setattr(cluster, "connected", connected)
    return asked_for


def test_the_folder_is_checked_before_any_worker_is_reached(
    run: Run, unreached: list[str], jobs: Path, tmp_path: Path
) -> None:
    taken, held, other = tmp_path / "taken", tmp_path / "held", tmp_path / "other"
    for folder in (taken, held, other):
        Results.open(folder, for_writing=True).close()
    (taken / "run.json").rename(taken / "letter.txt")
    text = (other / "run.json").read_text(encoding="utf-8")
    (other / "run.json").write_text(text.replace(__version__, "0.0.1"), encoding="utf-8")
    with Results.open(held, for_writing=True):
        for folder, said in (
            (taken, "holds something else"), (held, "another run is writing"), (other, "holds results of atleak 0.0.1")
        ):  # fmt: skip
            status, _, told = run("fleet", "run", jobs, "--out", folder)
            assert (status, unreached) == (2, [])
            assert said in told


def test_where_no_worker_is_reached_nothing_is_replaced(
    run: Run, asked: dict[str, Any], jobs: Path, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    out = tmp_path / "results"
    run("fleet", "run", jobs, "--out", out)
    request.getfixturevalue("unreached")
    assert run("fleet", "run", jobs, "--out", out, "--replace", "--scheduler", "tcp://x:1")[0] == 2
    assert pq.read_table(out / "units").num_rows == 2
    Results.open(out, for_writing=True).close()  # nobody holds it


def test_a_folder_for_results_that_is_none_is_named_in_plain_words(
    run: Run, asked: dict[str, Any], jobs: Path, tmp_path: Path
) -> None:
    (tmp_path / "file").write_bytes(b"")
    status, _, told = run("fleet", "run", jobs, "--out", tmp_path / "file")
    assert (status, told) == (2, f"atleak: {tmp_path / 'file'}: is a file; expected {_FREE}\n")


@pytest.mark.skipif(os.name == "nt", reason="a link takes a privilege there")
def test_a_link_that_leads_nowhere_is_named_in_plain_words(
    run: Run, asked: dict[str, Any], jobs: Path, tmp_path: Path
) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "gone")
    status, _, told = run("fleet", "run", jobs, "--out", tmp_path / "link")
    assert status == 2
    assert told == f"atleak: {tmp_path / 'link'}: is a link to something that is not there; expected {_FREE}\n"


def test_an_interrupted_run_says_that_it_goes_on(
    run: Run, asked: dict[str, Any], jobs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*given: Any, **options: Any) -> Finished:
        raise KeyboardInterrupt

    monkeypatch.setattr(fleet_run, "run_fleet", interrupted)
    status, printed, told = run("fleet", "run", jobs, "--out", tmp_path / "results")
    assert (status, printed) == (130, "")
    assert told == "atleak: interrupted; what was finished is kept, and running again goes on from it\n"
    assert run("fleet", "run", jobs, "--out", tmp_path / "results", "--replace")[0] == 130  # the folder is free again


@pytest.mark.slow
def test_a_run_of_the_command_with_workers_of_its_own(
    process: Callable[..., Any], jobs: Path, small_sheet: Callable[..., Path], tmp_path: Path
) -> None:
    small_sheet()
    table, out = tmp_path / "fleet.csv", tmp_path / "results"
    lines = [f"small.csv,minimal_example,{20_000 + number}" for number in range(10)]
    table.write_text("\n".join(["sheet,controller,mileage", *lines]) + "\n", encoding="utf-8")
    (jobs / "bad.zip").write_bytes(b"no job")
    for new in (13, 0):
        done = process("fleet", "run", jobs, table, "--out", out, "--workers", 2, "--fail-on", "critical")
        assert done.returncode == 2
        assert done.stdout.decode().startswith(f"{new} units tried in ")
        assert f"; 12 with a result in {out}:" in done.stdout.decode()
        assert "bad.zip: is no sound zip" in done.stderr.decode()
        assert "Traceback" not in done.stderr.decode()
    hashes = pq.read_table(out / "units")["input_sha256"].to_pylist()
    assert len(hashes) == len(set(hashes)) == 12


def test_quiet_prints_nothing_but_what_goes_wrong(run: Run, asked: dict[str, Any], jobs: Path, tmp_path: Path) -> None:
    (jobs / "south" / "again.zip").unlink()
    assert run("fleet", "run", jobs, "--out", tmp_path / "results", "-q") == (0, "", "")
