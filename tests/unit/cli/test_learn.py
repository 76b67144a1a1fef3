"""Mounting clearances from measuring sheets, on the command line."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from atleak.catalogue.controller_file import load_controller, written_toml
from atleak.catalogue.entries import read_tables, shipped_files
from atleak.job.case import Case, SourceFile
from atleak.job.parts import job_parts
from atleak.job_book.book import open_book
from atleak.measurements.job_card import Job
from atleak.version import __version__

Run = Callable[..., tuple[int, str, str]]
NAME = "minimal_example"


@pytest.fixture
def new_unit(tmp_path: Path) -> Callable[..., Path]:
    """Writes the measuring sheet of a made-up new unit of the minimal example as text, each diameter read twice."""
    controller = load_controller(NAME)
    random = np.random.default_rng(6)

    def write(name: str, wider: float = 0.0, unit: str = "mm", **marks: str) -> Path:
        rows = [f"component,part,plane,direction,repeat,diameter [{unit}],taken at"]
        size = {"mm": 1e3, "inch": 1e3 / 25.4}[unit]
        for land in controller.lands:
            clearance = 15e-6 + wider + random.normal(0.0, 1e-6)
            for part, diameter in (
                ("spool", land.nominal_diameter),
                ("sleeve", land.nominal_diameter + 2.0 * clearance),
            ):
                for repeat in (1, 2):
                    read = diameter + random.normal(0.0, 1e-6)
                    row = (land.component, part, land.planes[0], 0, repeat, f"{read * size:.5f}", marks.get(part, ""))
                    rows.append(",".join(map(str, row)))
        path = tmp_path / name
        path.write_text("\n".join(rows) + "\n", encoding="utf-8")
        return path

    return write


@pytest.fixture
def six(new_unit: Callable[..., Path]) -> list[Path]:
    return [new_unit(f"unit_{number}.csv") for number in range(6)]


def test_the_file_written_is_a_valve_body_with_the_learned_clearances(
    run: Run, six: list[Path], tmp_path: Path
) -> None:
    target, record = tmp_path / "learned.toml", tmp_path / "learned.json"
    status, out, err = run("controller", "learn", *six, "--controller", NAME, "-o", target, "--json", record)
    assert (status, err) == (0, "")
    assert f"written: {target}" in out
    assert "from 6 units" in out
    said = json.loads(record.read_text(encoding="utf-8"))
    controller = load_controller(target)
    assert len(said["lands"]) == len(controller.lands)
    for land, row in zip(controller.lands, said["lands"], strict=True):
        assert land.learned_from_units == row["learned_from_units"] == 6
        assert land.mounting_clearance * 1e6 == pytest.approx(row["mounting_clearance_um"], abs=0.006)
        assert row["mounting_clearance_um"] == pytest.approx(15.0, abs=row["uncertainty_um"])
    assert [unit["file"] for unit in said["units"]] == [path.name for path in six]
    status, out, _ = run("controller", "check", target)
    assert "nothing is wrong with it" in out


def test_either_file_may_stand_alone_on_standard_output(run: Run, six: list[Path]) -> None:
    _, toml, _ = run("controller", "learn", *six, "--controller", NAME, "-o", "-")
    assert toml.startswith('id = "minimal_example"')
    _, record, _ = run("controller", "learn", *six, "--controller", NAME, "--json", "-")
    assert json.loads(record)["format"] == 1
    status, _, err = run("controller", "learn", *six, "--controller", NAME, "-o", "-", "--json", "-")
    assert status == 2
    assert "only one of -o and --json" in err


def test_sheets_in_inches_and_unworn_ends_are_learned_from(run: Run, new_unit: Callable[..., Path]) -> None:
    inches = new_unit("inch.csv", unit="inch")
    used = new_unit("used.csv", sleeve="unworn end")
    _, out, _ = run("controller", "learn", inches, used, "--controller", NAME, "--json", "-")
    record = json.loads(out)
    assert [unit["of_used_unit"] for unit in record["units"]] == [False, True]
    assert {(land["learned_from_units"], land["unworn_ends"]) for land in record["lands"]} == {(2, 1)}


def test_sheets_of_the_unit_that_was_copied_are_taken_where_that_is_said(
    run: Run, new_unit: Callable[..., Path], tmp_path: Path
) -> None:
    own = tmp_path / "own.toml"
    shipped = read_tables("controllers", NAME)[0]
    own.write_text(written_toml(shipped | {"id": "own_copy"}), encoding="utf-8")
    sheet = new_unit("unit.csv")
    sheet.write_text(f"Controller {NAME}\n\n{sheet.read_text(encoding='utf-8')}", encoding="utf-8")
    status, _, err = run("controller", "learn", sheet, "--controller", own)
    assert status == 2
    assert f"the sheet was made for controller {NAME}, not for own_copy" in err
    status, out, _ = run("controller", "learn", sheet, "--controller", own, "--made-for", NAME)
    assert status == 0
    assert "from 1 unit" in out


def test_what_cannot_be_used_is_named_for_all_sheets(run: Run, six: list[Path], tmp_path: Path) -> None:
    rows = ["component,part,plane,diameter [mm]", "no_valve,spool,1,9.9", "nor_this,spool,1,9.9"]
    (tmp_path / "other.csv").write_text("\n".join(rows), encoding="utf-8")
    (tmp_path / "empty.csv").write_text("component,part,plane,diameter [mm]\n", encoding="utf-8")
    sheets = [tmp_path / "other.csv", *six, tmp_path / "empty.csv"]
    status, out, err = run("controller", "learn", *sheets, "--controller", NAME)
    assert (status, out) == (2, "")
    for words in ("other.csv", "'no_valve'", "'nor_this'", "empty.csv", "no readings are filled in"):
        assert words in err
    status, _, err = run("controller", "learn", six[0], six[0], "--controller", NAME)
    assert status == 2
    assert "the same file as unit_0.csv" in err


@pytest.mark.parametrize("output", ["learned.xlsx", "unit_0.csv"])
def test_the_output_is_a_toml_file_and_no_file_is_written_over(
    run: Run, six: list[Path], tmp_path: Path, output: str
) -> None:
    before = six[0].read_bytes()
    status, _, err = run("controller", "learn", *six, "--controller", NAME, "-o", tmp_path / output)
    assert status == 2
    assert "a name.toml" in err
    assert six[0].read_bytes() == before
    (tmp_path / "mine.toml").write_text("# mine", encoding="utf-8")
    status, _, err = run("controller", "learn", *six, "--controller", NAME, "-o", tmp_path / "mine.toml")
    assert status == 2
    assert "is there already" in err


def test_sheets_of_the_job_book_are_learned_from(run: Run, tmp_path: Path, small_sheet: Callable[..., Path]) -> None:
    book = open_book()
    for number, sleeve in enumerate((11.032, 11.036, 11.034)):
        case = Case(readings=SourceFile.at(small_sheet(sleeve)), controller="minimal_example")
        job = Job(number=str(number), vehicle={"mileage_km": 0.0}, transmission={"serial": f"S{number}"})
        book.save(job_parts(case.diagnose(), job, case))
    book.engine.dispose()
    status, out, _ = run("controller", "learn", "--from-book", "--controller", "minimal_example", "--json", "-")
    assert status == 0
    record = json.loads(out)
    assert [unit["file"] for unit in record["units"]] == ["job 0", "job 1", "job 2"]
    assert run("controller", "learn", "--controller", "minimal_example")[0] == 2
    status, _, error = run("controller", "learn", "--from-book", "--controller", "four_speed_2023")
    assert status == 2
    assert "no measuring sheet of a new or repaired four_speed_2023" in error


# --- passed on


def test_a_learned_valve_body_is_passed_on_without_whose_units_it_is_of(
    run: Run,
    new_unit: Callable[..., Path],
    tmp_path: Path,
    small_sheet: Callable[..., Path],
    record_of: Callable[..., dict[str, Any]],
) -> None:
    learned, own, passed_on = (tmp_path / f"{name}.toml" for name in ("learned", "own", "passed_on"))
    sheets = [new_unit(name) for name in ("KR 4711A, Nowak (job 17).csv", "WVWZZZ1JZXW000001.csv")]
    assert run("controller", "learn", *sheets, "--controller", NAME, "-o", learned)[0] == 0
    tables, _ = read_tables("controllers", learned)
    public = "https://example.org/guides/valve-body.pdf"
    tables["source"] = r"own gauge, C:\Users\nowak\unit.xlsx, of WVWZZZ1JZXW000001; " + public
    tables["note"] = f"Of our stand. {tables['note']}"
    own.write_text("# the unit of Mrs Nowak\n" + written_toml(tables), encoding="utf-8")
    status, out, err = run("controller", "export", own, "-o", passed_on)
    assert (status, out) == (0, f"written: {passed_on}\n")
    text = passed_on.read_text(encoding="utf-8")
    for named in ("nowak", "4711", "wvwzzz", "job 17", ".csv", ".xlsx", "users", str(tmp_path).lower()):
        assert named not in text.lower()
    assert f"own gauge, …, of …; {public}" in err  # and in the file
    before, after = load_controller(own), load_controller(passed_on)
    assert after.note.startswith("Of our stand. Mounting clearances of")
    assert replace(after, origin=before.origin, source=before.source, note=before.note) == before
    results = [record_of(small_sheet(), "--controller", each) for each in (own, passed_on)]
    assert all(results[0][key] == results[1][key] for key in ("lands", "gaps", "conditions", "unit"))
    head = tomllib.loads("\n".join(line.removeprefix("# ") for line in text.partition("\n\n")[0].splitlines()))
    said = head["provenance"]
    assert (said["atleak"], said["sha256"]) == (__version__, hashlib.sha256(own.read_bytes()).hexdigest())
    assert said["learned"] == {"lands": len(after.lands), "units": [2, 2], "on": [said["exported"]]}
    assert said["values"]["measured"] == len(after.lands)
    again = run("controller", "export", passed_on, "-o", "-")[1]
    assert again.partition("\n\n")[2] == text.partition("\n\n")[2]


@pytest.mark.parametrize("unit", shipped_files("controllers"))
def test_a_shipped_valve_body_is_the_same_after_it_was_passed_on(run: Run, unit: str, tmp_path: Path) -> None:
    target = tmp_path / "passed_on.toml"
    assert run("controller", "export", unit, "-o", target) == (0, f"written: {target}\n", "")
    shipped = load_controller(unit)
    assert replace(load_controller(target), origin=shipped.origin) == shipped
