"""What earlier versions wrote is opened, migrated and verified, and says no less than it did."""

from __future__ import annotations

import gzip
import json
import os
import shutil
import stat
import zipfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from atleak import cli

RELEASE = Path(__file__).parent / "0.2.0"
JOBS = {"A-1": "four_speed", "B-7": "five_speed"}
PLAN = '"parts", "directions": 2, "repeats": 2, "planes": null, "lands": []}'  # the number of the job that was typed
Ran = Callable[..., str]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Ran:
    """Runs a command, which must succeed, in a home of its own; what it printed."""
    monkeypatch.setenv("ATLEAK_HOME", str(tmp_path))

    def command(*arguments: object) -> str:
        status = cli.main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        assert status == 0, err
        return out

    return command


@pytest.fixture
def book(tmp_path: Path) -> None:
    """The book of the release, in the test's home."""
    (tmp_path / "book.sqlite").write_bytes(gzip.decompress((RELEASE / "book.sqlite.gz").read_bytes()))


def job_file(number: str) -> Path:
    (found,) = RELEASE.glob(f"{number}_*.zip")
    return found


def keys(record: Any, at: str = "") -> Iterator[str]:
    """Name every key of a record, the items of a list alike."""
    if isinstance(record, Mapping):
        for key, value in record.items():
            yield f"{at}.{key}"
            yield from keys(value, f"{at}.{key}")
    elif isinstance(record, list):
        for item in record:
            yield from keys(item, at)


@pytest.mark.usefixtures("book")
def test_a_job_book_opens_and_every_job_of_it_is_whole(run: Ran) -> None:
    assert run("jobs", "verify").startswith("5 jobs, every one whole")
    listed = json.loads(run("jobs", "list", "--json", "-"))
    assert {job["number"] for job in listed if job["vin"]} == {"A-1", "A-2", "B-7"}
    assert len(listed) == 4  # one is archived


@pytest.mark.usefixtures("book")
def test_the_plan_of_typed_readings_is_no_job_number_any_more(run: Ran, tmp_path: Path) -> None:
    listed = json.loads(run("jobs", "list", "--json", "-"))
    (typed,) = [job for job in listed if not job["vin"]]
    shown = json.loads(run("jobs", "show", typed["id"], "--json", "-"))
    assert (typed["number"], shown["job"]["number"]) == ("", None)
    assert shown["job"]["notes"] == (
        f"The job number was emptied: atleak 0.2.0 had put the plan of the typed readings in its place. It read: {PLAN}"
    )
    assert json.loads(run("jobs", "list", "--text", "directions", "--json", "-")) == []
    assert {job["number"] for job in listed if job["vin"]} == {"A-1", "A-2", "B-7"}
    before = tmp_path / "book.sqlite.before-0004"
    assert stat.S_IMODE(before.stat().st_mode) == 0o600 or os.name != "posix"
    run("jobs", "restore", before, "--force")  # the book as 0.2.0 wrote it: it comes in as it was brought up to date
    assert json.loads(run("jobs", "show", typed["id"], "--json", "-"))["job"] == shown["job"]
    assert run("jobs", "verify").startswith("5 jobs, every one whole")


@pytest.mark.usefixtures("book")
def test_the_plan_of_typed_readings_is_no_job_number_of_a_job_file_either(run: Ran, tmp_path: Path) -> None:
    (typed,) = [job for job in json.loads(run("jobs", "list", "--json", "-")) if not job["vin"]]
    run("jobs", "export", typed["id"], "-o", tmp_path / "export")
    earlier = tmp_path / "earlier.zip"  # as 0.2.0 exported it
    with zipfile.ZipFile(tmp_path / "export" / f"{typed['id']}.zip") as now, zipfile.ZipFile(earlier, "w") as then:
        for name in now.namelist():
            content = now.read(name)
            if name == "job.json":
                content = json.dumps({**json.loads(content), "job": {"number": PLAN}}).encode()
            then.writestr(name, content)
    run("jobs", "import", earlier)
    jobs = [job for job in json.loads(run("jobs", "list", "--json", "-")) if not job["vin"]]
    records = [json.loads(run("jobs", "show", job["id"], "--json", "-"))["job"] for job in jobs]
    assert len(records) == 2
    assert records[0] == records[1]
    assert records[0]["number"] is None
    assert records[0]["notes"].endswith(PLAN)


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
@pytest.mark.usefixtures("book")
def test_a_job_book_is_its_owners_alone_from_then_on(run: Ran, tmp_path: Path) -> None:
    for path, mode in ((tmp_path, 0o755), (tmp_path / "book.sqlite", 0o644)):
        path.chmod(mode)
    run("jobs", "list")
    assert [stat.S_IMODE(path.stat().st_mode) for path in (tmp_path, tmp_path / "book.sqlite")] == [0o700, 0o600]
    (tmp_path / "book.sqlite").chmod(0o640)  # as somebody wants it since
    run("jobs", "list")
    assert stat.S_IMODE((tmp_path / "book.sqlite").stat().st_mode) == 0o640


@pytest.mark.usefixtures("book")
def test_a_job_book_is_backed_up_and_restored(run: Ran, tmp_path: Path) -> None:
    run("jobs", "backup", tmp_path / "copy.backup")
    run("jobs", "restore", tmp_path / "copy.backup", "--force")
    assert run("jobs", "verify").startswith("5 jobs, every one whole")


def merged_twice(path: Path) -> Path:
    """Write the book in which a unit leads to one that leads on."""
    path.write_bytes(gzip.decompress((RELEASE / "merged_twice.backup.gz").read_bytes()))
    return path


def test_a_backup_in_which_a_unit_leads_to_one_that_leads_on_is_restored(run: Ran, tmp_path: Path) -> None:
    run("jobs", "restore", merged_twice(tmp_path / "merged.backup"))
    assert run("jobs", "verify").startswith("2 jobs, every one whole")
    jobs = json.loads(run("jobs", "list", "--json", "-"))
    assert len({job["unit"] for job in jobs}) == 1


def test_a_book_in_which_a_unit_leads_to_one_that_leads_on_is_opened_backed_up_and_restored(
    run: Ran, tmp_path: Path
) -> None:
    merged_twice(tmp_path / "book.sqlite")
    before = json.loads(run("jobs", "list", "--json", "-"))
    assert len({job["unit"] for job in before}) == 1
    run("jobs", "backup", tmp_path / "copy.backup")
    run("jobs", "restore", tmp_path / "copy.backup", "--force")
    assert json.loads(run("jobs", "list", "--json", "-")) == before
    run("jobs", "part", 1)
    assert len({job["unit"] for job in json.loads(run("jobs", "list", "--json", "-"))}) == 2
    assert run("jobs", "verify").startswith("2 jobs, every one whole")


@pytest.mark.parametrize("number", JOBS)
def test_a_job_file_is_diagnosed_anew_and_says_no_less(run: Ran, number: str) -> None:
    id = run("jobs", "import", job_file(number)).split()
    assert id
    (job,) = json.loads(run("jobs", "list", "--json", "-"))
    now = json.loads(run("jobs", "show", job["id"], "--json", "-"))
    earlier = json.loads(gzip.decompress((RELEASE / f"{JOBS[number]}.json.gz").read_bytes()))
    assert earlier["atleak"] == "0.2.0"
    assert set(keys(earlier)) <= set(keys(now))
    assert [land["radial_clearance_um"] for land in now["lands"]] == pytest.approx(
        [land["radial_clearance_um"] for land in earlier["lands"]], abs=1e-9
    )
    assert now["job"]["number"] == number


def test_the_results_of_a_fleet_are_summed_up(run: Ran, tmp_path: Path) -> None:
    shutil.copytree(RELEASE / "fleet", tmp_path / "fleet")
    summary = json.loads(run("fleet", "summary", tmp_path / "fleet", "--json", "-"))
    assert summary["counts"]["units"] == 3
    assert summary["counts"]["verdicts"] == {
        **dict.fromkeys(summary["counts"]["verdicts"], 0),
        "watch": 1,
        "replace": 2,
    }


def test_a_workbook_is_known_as_one_that_atleak_made(run: Ran, tmp_path: Path) -> None:
    report = shutil.copy(RELEASE / "report.xlsx", tmp_path / "report.xlsx")
    sheet = RELEASE / "sheet_en.xlsx"
    run("diagnose", sheet, "--controller", "minimal_example", "--xlsx", report)  # without --force
    assert Path(report).read_bytes() != (RELEASE / "report.xlsx").read_bytes()


@pytest.mark.parametrize("sheet", ["sheet_en.xlsx", "sheet_de_us.xlsx", "typed_readings.csv"])
def test_a_filled_sheet_is_read(run: Ran, sheet: str) -> None:
    record = json.loads(run("diagnose", RELEASE / sheet, "--controller", "minimal_example", "--json", "-"))
    assert record["readings"]["lands_measured"] == 5
    assert max(land["radial_clearance_um"] for land in record["lands"]) < 30.0


def test_a_workbook_describes_the_valve_body_that_it_did(run: Ran, tmp_path: Path) -> None:
    own, described = tmp_path / "own.toml", RELEASE / "five_speed_2005.xlsx"
    run("controller", "from-workbook", described, "-o", own)
    sheet = Path(cli.__file__).parents[2] / "sample_data" / "measuring_sheet_five_speed.xlsx"
    leakages = []
    for controller in ("five_speed_2005", own):
        chosen = ("--controller", controller, "--fluid", "hipol_atf_iid")  # the workbook names none
        record = json.loads(run("diagnose", sheet, *chosen, "--json", "-"))
        leakages.append([point["leakage_dm3_min"] for point in record["conditions"]])
    assert leakages[1] == pytest.approx(leakages[0], abs=1e-12)
