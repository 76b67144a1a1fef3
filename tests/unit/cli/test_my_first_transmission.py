"""The page for a first transmission: its tables typed into its workbook, its commands run as they stand."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import openpyxl
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.common.units import UM
from atleak.common.wording import wording
from atleak.measurements.readings import Reading
from atleak.report.sheets.measuring_columns import SHEET, UNWORN_END
from atleak.report.sheets.measuring_sheet import write_readings

Run = Callable[..., tuple[int, str, str]]
PAGE = Path(__file__).parents[3] / "docs" / "tutorials" / "my-first-transmission.md"


@pytest.fixture(scope="module")
def page() -> str:
    return PAGE.read_text(encoding="utf-8")


def commands(page: str) -> list[list[str]]:
    blocks = re.findall(r"^```(?:sh|text)\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    lines = [line for block in blocks for line in block.splitlines()]
    return [shlex.split(line)[1:] for line in lines if line.startswith("atleak ")]


def tables(page: str) -> Iterator[tuple[str, list[dict[str, str]]]]:
    """Yield the sheets of the workbook that the page shows, each with its rows by heading."""
    for sheet, table in re.findall(r"^Sheet \*(.+?)\*:\n\n((?:\|.*\n)+)", page, re.MULTILINE):
        headings, _, *rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines())
        yield sheet, [dict(zip(headings, row, strict=True)) for row in rows]


def fill(path: Path, page: str) -> None:
    """Type the page's tables into the workbook, as a person would."""
    book = openpyxl.load_workbook(path)
    for name, rows in tables(page):
        sheet = book[name]
        head = next(row for row in range(1, 12) if sheet.cell(row, 1).value == "Note")
        columns = {cell.value: cell.column for cell in sheet[head]}
        fields = {sheet.cell(row, columns.get("Field", 1)).value: row for row in range(head, sheet.max_row + 1)}
        free = (row for row in range(head + 2, 200) if sheet.cell(row, 1).value != "e.g.")
        for row in rows:
            at = fields[row.pop("Field")] if "Field" in row else next(free)
            for heading, text in row.items():
                if text:
                    number = re.fullmatch(r"-?\d+(\.\d+)?", text)
                    sheet.cell(at, columns[heading]).value = float(text) if number else text
    book.save(path)


def measured(controller: Controller, seed: int, worn: float = 0.0) -> list[Reading]:
    """Readings of a made-up unit: new pairs about 11 µm, two directions, twice."""
    random = np.random.default_rng(seed)
    found = []
    for land in controller.lands:
        clearance = 11e-6 + worn + random.normal(0.0, 1e-6)
        for part, diameter in (("spool", land.nominal_diameter), ("sleeve", land.nominal_diameter + 2.0 * clearance)):
            for direction in (0.0, 90.0):
                for repeat in (1, 2):
                    read = round(diameter + random.normal(0.0, 0.7e-6), 6)
                    found.append(Reading(land.component, part, land.planes[0], direction, repeat, read))  # type: ignore[arg-type]
    return found


def measure(folder: Path) -> None:
    """Write the measuring sheets that the page speaks of."""
    controller = load_controller(folder / "my_unit.toml")
    for number in (1, 2, 3):
        (folder / f"new_{number}.xlsx").write_bytes(write_readings(controller, measured(controller, number)))
    (folder / "car_0417.xlsx").write_bytes(write_readings(controller, measured(controller, 9, worn=25e-6)))
    used = folder / "used_with_unworn_ends.xlsx"
    used.write_bytes(write_readings(controller, measured(controller, 7)))
    book = openpyxl.load_workbook(used)
    sheet = book[SHEET]
    heading = next(row for row in sheet.iter_rows() if row[0].value == "No.")
    place = next(cell.column for cell in heading if cell.value == "Taken at")
    part = ""
    for row in range(heading[0].row + 1, sheet.max_row + 1):
        part = sheet.cell(row, 3).value or part
        if part == "sleeve":
            sheet.cell(row, place).value = UNWORN_END
    book.save(used)


def test_every_command_of_the_page_does_what_it_says(
    run: Run, page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ATLEAK_HOME", str(tmp_path / "home"))
    said, learnt = {}, []
    listed = commands(page)
    for command in listed:
        if command[:2] == ["controller", "check"]:
            fill(tmp_path / "my_unit.xlsx", page)
        if "new_1.xlsx" in command and not Path("new_1.xlsx").exists():
            measure(tmp_path)
        status, out, err = run(*command)
        assert status == 0, f"{' '.join(command)}: {err}"
        said[" ".join(command[:2])] = out
        if command[:2] == ["controller", "learn"]:
            learnt.append(out)
        if "-o" in command:
            assert (tmp_path / command[command.index("-o") + 1]).is_file()
    assert [command[0] for command in listed].count("controller") == 6
    shown = re.sub(r"\s+", " ", page)  # a page breaks long lines
    for answer in (said["controller check"], learnt[0].splitlines()[0]):
        assert re.sub(r"\s+", " ", answer).strip() in shown
    lines = [line for line in learnt[0].splitlines() if "regulator/1" in line]
    table = [[cell.strip() for cell in line.split("│")] for line in lines]
    columns = re.findall(r"^\| \*\*(?:New|Sure to ±|95 % of pairs ±|Spread)\*\* \| ([\d.]+) µm \|", page, re.MULTILINE)
    assert columns == table[0][2:6]
    ranged = load_controller("my_unit.toml").lands[0]
    assert f"| {ranged.nominal_sleeve_diameter * 1e3:.3f} mm |" in page
    assert f"| {ranged.mounting_high * UM:.1f} µm (0.0016 in diametral) |" in page
    assert f"{ranged.new_clearance * UM:.1f} µm of 6.35-20.3 µm" in page
    learned = load_controller("my_unit_learned.toml")
    assert {land.learned_from_units for land in learned.lands} == {3}
    assert [land.nominal_diameter * 1e3 for land in learned.lands[:3]] == pytest.approx(
        [15.001] * 2 + [9.855], abs=1e-3
    )
    assert learned.operating_points[0].main_pressure == pytest.approx(65 * 6894.757, abs=1.0)
    assert 12e-6 < learned.pump.displacement < 25e-6  # m³, of a passenger car's
    verdict = said["diagnose car_0417.xlsx"]
    assert "replace (upper bound), decided by regulator/2" in verdict
    assert re.search(r"replace *│ *regulator/2\b", verdict)
    assert "All pairs moved alike" in verdict
    assert Path("car_0417.pdf").read_bytes().startswith(b"%PDF")


def test_every_sheet_and_word_that_the_page_names_is_there(page: str, tmp_path: Path, run: Run) -> None:
    run("controller", "template", "-o", tmp_path / "any.xlsx")
    sheets = openpyxl.load_workbook(tmp_path / "any.xlsx", read_only=True).sheetnames
    named = re.findall(r"^\| ((?:\*[A-Z][\w ,]+\*)) \|", page, re.MULTILINE)
    assert len(named) > 5
    for name in named:
        assert set(name.strip("*").split(", ")) <= set(sheets), name
    (lacking,) = re.findall(r"^\| it names \|.*\n\|[-|]+\n((?:\|.*\n)+)", page, re.MULTILINE)
    says = wording("en")
    assert set(re.findall(r"^\| \*(.+?)\* \|", lacking, re.MULTILINE)) <= set(says.table("bases").values())
    links = [link for link in re.findall(r"\]\(([^)#]+)", page) if not link.startswith("http")]
    for link in links:
        if "/pictures/" not in link:  # made by the tools for pictures
            assert (PAGE.parent / link).is_file(), link
