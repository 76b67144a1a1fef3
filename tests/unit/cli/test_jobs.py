"""The job book's commands."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from atleak.cli import app

Run = Callable[..., tuple[int, str, str]]
RECORD = """
number = "Q-1"
date = 2026-04-17
[customer]
name = "Ana Lima"
[vehicle]
vin = "WVWZZZ1JZXW000001"
registration = "M-AB 1"
mileage_km = 90000
[transmission]
serial = "S-55"
"""


@pytest.fixture
def record_file(tmp_path: Path) -> Path:
    path = tmp_path / "job.toml"
    path.write_text(RECORD, encoding="utf-8")
    return path


@pytest.fixture
def add(run: Run, small_sheet: Callable[..., Path]) -> Callable[..., str]:
    """Adds a job of one land; returns its id."""

    def command(*options: object, sleeve: float = 11.04) -> str:
        status, out, err = run("jobs", "add", small_sheet(sleeve), "--controller", "minimal_example", *options)
        assert (status, err) == (0, "")
        return out.removesuffix("\n")

    return command


def listed(run: Run, *options: object) -> list[dict[str, Any]]:
    status, out, err = run("jobs", "list", *options, "--json", "-")
    assert (status, err) == (0, "")
    return json.loads(out)


def test_a_job_is_added_listed_shown_archived_and_brought_back(run: Run, add: Callable[..., str], record_file) -> None:
    id = add("--job", record_file)
    other = add()
    assert [row["id"] for row in listed(run)] == [other, id]
    (row,) = listed(run, "--text", "lima", "--from", "2026-04-17", "--to", "17.4.2026", "--verdict", "watch")
    expected = {
        "id": id, "number": "Q-1", "vin": "WVWZZZ1JZXW000001", "serial": "S-55", "customer": "Ana Lima",
        "date": "2026-04-17", "controller": "minimal_example", "verdict": "watch", "mileage_km": 90000.0,
    }  # fmt: skip
    assert {name: row[name] for name in expected} == expected
    assert listed(run, "--vin", "000001") == [row]
    assert listed(run, "--plate", "M-AC") == []
    status, out, err = run("jobs", "show", "Q1", "--json", "-")
    shown = json.loads(out)
    assert (status, err, shown["job"]["customer"]["name"], shown["verdict"]) == (0, "", "Ana Lima", "watch")
    assert run("jobs", "archive", id[:7], other)[0] == 0
    assert listed(run) == []
    assert len(listed(run, "--archived")) == 2
    assert "was archived on" in run("jobs", "show", id)[2]
    assert run("jobs", "bring-back", id)[0] == 0
    status, out, _ = run("jobs", "list")
    assert status == 0
    assert id[:8] in out
    assert "▲ watch" in out


def test_options_of_diagnose_count_for_a_job_of_the_book(run: Run, add: Callable[..., str]) -> None:
    id = add("--temperature", "75", "--mileage", "120000", "--assume", "eccentricity=unknown")
    shown = json.loads(run("jobs", "show", id, "--json", "-")[1])
    assert (shown["projection"]["temperature_c"], shown["mileage_km"]) == (75.0, 120_000.0)
    assert shown["profile"]["eccentricity"] == "unknown"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("add",), "there is nothing to diagnose"),
        (("show", "nothing"), "the job book has no such job (found 'nothing')"),
        (("list", "--from", "03/04/2026"), "no date that can be read in one way"),
        (("export", "-o", "out"), "it is not said which jobs"),
        (("erase",), "it is not said which jobs"),
        (("erase", "--customer", "Nobody"), "no job is of this customer"),
        (("import", "missing.zip"), "missing.zip: cannot be read"),
        (("merge", "1", "2"), "no such unit"),
        (("list", "--limit", "0"), "'0' is no number of rows: write a whole number from 1 to"),
        (("list", "--limit=-1"), "'-1' is no number of rows"),
        (("list", "--limit", "99999999999999999999"), "is no number of rows"),
    ],
)
def test_what_cannot_be_done_ends_with_status_2_and_a_word(run: Run, arguments: tuple[str, ...], said: str) -> None:
    status, out, err = run("jobs", *arguments)
    assert (status, out) == (2, "")
    assert said in err


def test_a_book_that_cannot_be_opened_is_said(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ATLEAK_DATABASE_URL", "sqlite:////nowhere/at/all/book.sqlite")
    status, _, err = run("jobs", "list")
    assert status == 2
    assert "/nowhere/at/all/book.sqlite: the job book cannot be used: its folder may not be written" in err


def test_jobs_go_out_and_come_into_another_book(
    run: Run, add: Callable[..., str], record_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ids = [add("--job", record_file), add(sleeve=11.2)]
    before = {row["number"]: row["verdict"] for row in listed(run)}
    out = tmp_path / "out"
    assert run("jobs", "export", "--all", "-o", out)[0] == 0
    assert sorted(path.name for path in out.glob("*.zip")) == sorted([f"Q-1_{ids[0]}.zip", f"{ids[1]}.zip"])
    status, _, err = run("jobs", "export", "--all", "-o", out)
    assert status == 2
    assert "is there already" in err
    assert run("jobs", "export", "--all", "-o", out, "--force")[0] == 0
    monkeypatch.setenv("ATLEAK_HOME", str(tmp_path / "other"))
    status, said, _ = run("jobs", "import", out)
    assert status == 0
    assert said.count("taken in") == 2
    assert {row["number"]: row["verdict"] for row in listed(run)} == before
    status, said, _ = run("jobs", "import", *out.glob("*.zip"))
    assert said.count("is in the book already") == 2
    assert len(listed(run)) == 2
    monkeypatch.setenv("ATLEAK_HOME", str(tmp_path / "third"))
    for path in out.glob("*.zip"):
        path.rename(path.with_suffix(".ZIP"))
    assert run("jobs", "import", out)[1].count("taken in") == 2


def test_two_jobs_of_the_book_are_compared(run: Run, add: Callable[..., str], record_file: Path) -> None:
    add("--job", record_file)
    after = add(sleeve=11.01)
    status, out, err = run("jobs", "compare", "Q1", after[:8], "--json", "-")
    assert (status, err) == (0, "")
    (changed,) = [land for land in json.loads(out)["lands"] if land["significant"]]
    assert changed["change_um"] == pytest.approx(-15.0, abs=1e-6)


def test_a_book_is_backed_up_verified_and_restored(
    run: Run, add: Callable[..., str], record_file: Path, tmp_path: Path
) -> None:
    id = add("--job", record_file)
    copy = tmp_path / "copy.sqlite"
    assert run("jobs", "backup", copy) == (0, f"written: {copy}, 1 job\n", "")
    assert run("jobs", "backup", copy)[0] == 2
    assert run("jobs", "erase", id, "--yes")[0] == 0
    assert run("jobs", "verify") == (0, "1 job, every one whole\n", "")
    status, _, err = run("jobs", "restore", copy)
    assert status == 2
    assert "holds 1 job, and nothing was restored" in err
    assert run("jobs", "restore", copy, "--force") == (0, "restored: 1 job, in the place of 1\n", "")
    assert [row["customer"] for row in listed(run)] == ["Ana Lima"]  # a backup made earlier still holds it


def test_erasing_names_what_goes_and_asks(
    run: Run, add: Callable[..., str], record_file: Path, own_home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    id = add("--job", record_file)
    status, out, err = run("jobs", "erase", "--customer", "ana lima")
    assert status == 2
    assert "nobody can be asked here" in err
    assert "Ana Lima" in out
    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    monkeypatch.setattr("builtins.input", lambda question: "no")
    status, out, _ = run("jobs", "erase", id)
    assert (status, out.splitlines()[-1]) == (2, "nothing was erased")
    assert run("jobs", "erase", id, "--yes")[0] == 0
    (row,) = listed(run)
    assert (row["customer"], row["vin"], row["verdict"], row["mileage_km"]) == ("", "", "watch", 90000.0)
    assert b"Lima" not in b"".join(path.read_bytes() for path in own_home.glob("book.sqlite*"))
    assert run("jobs", "show", id)[2] == ""  # judged as it was stored


def test_units_typed_differently_are_pointed_out_and_merged(
    run: Run, add: Callable[..., str], record_file: Path, tmp_path: Path
) -> None:
    add("--job", record_file)
    slip = tmp_path / "slip.toml"
    slip.write_text(RECORD.replace("000001", "000010").replace("S-55", ""), encoding="utf-8")
    add("--job", slip)
    suggested = run("jobs", "duplicates")[1].split("#")[0].split()
    assert suggested[:3] == ["atleak", "jobs", "merge"]
    status, merged, _ = run(*suggested[1:])
    assert status == 0
    assert len({row["unit"] for row in listed(run)}) == 1
    assert "No two units" in run("jobs", "duplicates")[1]
    assert run(*merged.split("`")[1].split()[1:])[0] == 0  # the command that it names
    assert len({row["unit"] for row in listed(run)}) == 2


def test_a_job_is_opened_where_the_dashboard_is_up_or_starts_it(
    run: Run, add: Callable[..., str], monkeypatch: pytest.MonkeyPatch
) -> None:
    id = add()
    shown: list[str] = []
    started: list[list[str]] = []
    monkeypatch.setattr(app.webbrowser, "open", shown.append)
    monkeypatch.setattr(app, "_serve", lambda command, folder, environment: started.append(command) or 0)
    monkeypatch.setattr(app, "_is_up", lambda port: True)
    address = f"http://127.0.0.1:8600/?job={id}"
    assert run("jobs", "open", id[:6], "--port", "8600") == (0, f"{address}\n", "")
    assert (shown, started) == ([address], [])
    monkeypatch.setattr(app, "_is_up", lambda port: False)
    monkeypatch.setattr(app, "_check_free", lambda address, port: None)
    assert run("jobs", "open", id, "--port", "8600") == (0, f"{address}\n", "")
    assert started[0][-4:] == ["--server.headless", "true", "--server.port", "8600"]
