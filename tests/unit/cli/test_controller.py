"""A valve body described in a workbook, from the command line."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import openpyxl
import pytest

from atleak import cli
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.entries import shipped_files

Run = Callable[..., tuple[int, str, str]]

# A five-speed like Ford's 4R44E and 5R55E, in inches, diametral and psi. Published are the boost valve's diameters
# (Sonnax, sonnax.com/parts/2224), the clearance of new valves (Sonnax, valve body inspection: 0.0005-0.0016 inch) and
# the overdrive servo's feed (Sonnax, kit 4R44E-5R55E-ZIP); everything else is made up for this test.
VALVES = {
    "pressure_regulator": ("main pressure regulator valve", (0.571, 0.571, 0.433)),
    "boost_valve": ("line boost valve", (0.388, 0.571, 0.634)),
    "manual_valve": ("manual valve", (0.492, 0.492, 0.492)),
    "solenoid_regulator": ("solenoid regulator valve", (0.433, 0.433)),
    "forward_engagement": ("forward engagement valve", (0.413, 0.413)),
    "shift_1_2": ("shift valve 1-2", (0.433, 0.433)),
    "shift_2_3": ("shift valve 2-3", (0.433, 0.433)),
    "shift_3_4": ("shift valve 3-4", (0.433, 0.433)),
    "servo_regulator": ("overdrive servo regulator valve", (0.413, 0.413)),
    "reverse_modulator": ("reverse engagement valve", (0.433, 0.433, 0.433)),
    "converter_clutch_control": ("converter clutch control valve", (0.472, 0.472, 0.472)),
    "forward_accumulator": ("forward clutch accumulator", (0.866, 0.866)),
}
CIRCUITS = {"forward_clutch": "1234", "overdrive_band": "24", "reverse_servo": "R", "epc": ""}
GAPS = {
    "shift_1_2": ("overdrive_band", "2 4"),
    "forward_engagement": ("forward_clutch", "1-4"),
    "reverse_modulator": ("reverse_servo", "R"),
}


@pytest.fixture(scope="module")
def ford_like(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The unit as a workshop fills in the template."""
    path = tmp_path_factory.mktemp("ford") / "unit.xlsx"
    units = ["--units", "inch", "--clearance", "diametral", "--pressure", "psi"]
    assert cli.main(["controller", "template", "-o", str(path), *units]) == 0
    book = openpyxl.load_workbook(path)
    made_up = {"Source": "made up for this test", "How known": "representative"}
    _fill_form(
        book["Head"],
        {
            "Id": "ford_like",
            "Name": "Five-speed of the 4R44E/5R55E family (made-up data)",
            "Source": "made up for a test, but for what Sonnax publishes",
            "Date": "2026-11-21",
            "Representative": "Nearly all of it is made up.",
            "Gears": "P R N 1 2 3 4",
            "Contact length unless stated": 0.2,
            "Mounting clearance unless stated": 0.0005,
            "Up to, where it is a range": 0.0016,
            "Material of the body": "aluminium",
            "Material of spools": "aluminium",
        },
    )
    _fill(book["Materials"], [{"Name": "aluminium", "Expansion": 21.3, **made_up}])
    _fill(book["Components"], [{"Id": each, "Name": name} for each, (name, _) in VALVES.items()])
    _fill(
        book["Lands"],
        [
            {
                "Component": each,
                "Land": number,
                "Diameter": diameter,
                "Diameter is": "published" if each == "boost_valve" else "representative",
                "Length is": "representative",
                "Clearance is": "published",
            }
            for each, (_, diameters) in VALVES.items()
            for number, diameter in enumerate(diameters, start=1)
        ],
    )
    _fill_form(
        book["Pump"],
        {
            "Displacement of one revolution": 1.2,
            "Volumetric efficiency": 0.92,
            "Slip coefficient": 4e-8,
            "Source": "made up for this test",
        },
    )
    _fill(
        book["Operating points"],
        [
            {
                "Name": name,
                "Label": label,
                "Fluid temperature": 100,
                "Engine speed": 650,
                "Gear": gear,
                "Main pressure": pressure,
                "Converter pressure": 45,
                **made_up,
            }
            for name, label, gear, pressure in (
                ("hot_idle", "hot idle in drive", 1, 130),
                ("reverse_idle", "hot idle in reverse", "R", 185),
            )
        ],
    )
    _fill(book["Circuits"], [{"Id": each, "Name": each, "Source": "made up for this test"} for each in CIRCUITS])
    _fill(
        book["Feeds"],
        [{"Circuit": each, "Fed from": "p_g", "Diameter": 0.072} for each in CIRCUITS],
    )
    _fill(book["Set pressures"], [{"Circuit": "epc", "Set by": "always", "Pressure": 60}])
    _fill(
        book["Apply chart"],
        [{"Circuit": each, **dict.fromkeys(gears, "x")} for each, gears in CIRCUITS.items() if gears],
    )
    _fill(
        book["Gaps"],
        [
            {
                "Component": each,
                "Land": number,
                "From": start,
                "To": "drain",
                "Gears": gears,
                "How known": "representative",
            }
            for each, (_, diameters) in VALVES.items()
            for number in range(1, len(diameters) + 1)
            for start, gears in [GAPS.get(each, ("p_g", "all"))]
        ],
    )
    _fill(
        book["Line pressures"],
        [
            {"Ranges": "D", "Gears": "1-4", "State": "idle", "Lowest": 110, "Highest": 150, **made_up},
            {"Ranges": "R", "Gears": "R", "State": "idle", "Lowest": 140, "Highest": 225, **made_up},
        ],
    )
    book.save(path)
    return path


def _heading_row(page: Any, heading: str) -> Any:
    return next(row for row in page.iter_rows() if any(cell.value == heading for cell in row))


def _fill(page: Any, rows: Iterable[Mapping[str, Any]]) -> None:
    """Write below the examples of a table."""
    headings = {cell.value: cell.column for cell in _heading_row(page, "Note")}
    marked = [row[0].row for row in page.iter_rows(max_col=1) if row[0].value in {"Note", "unit", "e.g."}]
    for number, values in enumerate(rows, start=max(marked) + 1):
        for heading, value in values.items():
            page.cell(number, headings[heading]).value = value


def _fill_form(page: Any, values: Mapping[str, Any]) -> None:
    for label, value in values.items():
        line = _heading_row(page, label)
        page.cell(line[0].row, 3).value = value


def test_a_unit_filled_in_in_inches_is_entered_in_one_go(run: Run, ford_like: Path, tmp_path: Path) -> None:
    target = tmp_path / "unit.toml"
    status, out, err = run("controller", "from-workbook", ford_like, "-o", target)
    assert (status, err) == (0, "")
    assert "12 components, 29 lands, 29 gaps, 4 circuits, 2 operating points" in out
    unit = load_controller(target)
    boost = unit.lands_of("boost_valve")
    assert [land.nominal_diameter for land in boost] == pytest.approx([9.8552e-3, 14.5034e-3, 16.1036e-3], abs=1e-15)
    assert boost[0].mounting_range == pytest.approx((6.35e-6, 20.32e-6), abs=1e-18)
    assert boost[0].representative == ("contact_length_mm",)
    assert unit.gears == (0, -1, 1, 2, 3, 4)
    assert unit.circuits[0].feeds[0].diameter == pytest.approx(1.8288e-3, abs=1e-15)
    assert unit.circuits[2].gears == frozenset({-1})
    assert unit.operating_points[1].main_pressure == pytest.approx(185 * 6894.757293168361, abs=1e-6)
    # the same bytes again, and the same unit after the way back through a workbook of other units
    assert run("controller", "from-workbook", ford_like, "-o", "-")[1] == target.read_text(encoding="utf-8")
    for number, units in enumerate((("--units", "mm"), ("--units", "inch", "--clearance", "diametral"))):
        back, again = tmp_path / f"back{number}.xlsx", tmp_path / f"again{number}.toml"
        status, _, err = run("controller", "to-workbook", target, "-o", back, *units)
        assert status == 0
        assert "comments" in err
        assert run("controller", "from-workbook", back, "-o", again)[0] == 0
        assert replace(load_controller(again), origin=unit.origin) == unit
        assert again.read_bytes() == target.read_bytes()


def test_a_diagnosis_is_the_same_after_a_workbook(
    run: Run, tmp_path: Path, small_sheet: Callable[..., Path], record_of: Callable[..., dict[str, Any]]
) -> None:
    book, unit = tmp_path / "unit.xlsx", tmp_path / "unit.toml"
    assert run("controller", "to-workbook", "minimal_example", "-o", book, "--units", "inch")[0] == 0
    assert run("controller", "from-workbook", book, "-o", unit)[0] == 0
    before, after = (record_of(small_sheet(), "--controller", each) for each in ("minimal_example", unit))
    for key in ("lands", "gaps", "conditions", "unit"):
        assert after[key] == before[key]


def test_all_mistakes_are_shown_at_once_and_nothing_is_written(run: Run, ford_like: Path, tmp_path: Path) -> None:
    book = openpyxl.load_workbook(ford_like)
    page = book["Lands"]
    column = {cell.value: cell.column for cell in _heading_row(page, "Diameter")}["Diameter"]
    for row in range(7, 36):
        page.cell(row, column).value = "wide"
    wrong = tmp_path / "wrong.xlsx"
    book.save(wrong)
    status, out, err = run("controller", "from-workbook", wrong, "-o", tmp_path / "unit.toml")
    assert (status, out) == (2, "")
    assert err.count("column D (Diameter): not accepted (found 'wide'); expected a number in inch") == 29
    assert not (tmp_path / "unit.toml").exists()
    status, _, checked = run("controller", "check", wrong)
    assert status == 2
    assert checked == err


@pytest.mark.parametrize("name", ["five_speed_2005", "minimal_example"])
def test_check_counts_what_is_described(run: Run, name: str) -> None:
    status, out, err = run("controller", "check", name)
    assert (status, err) == (0, "")
    lines = out.splitlines()
    assert f"{len(load_controller(name).lands)} lands" in lines[0]
    assert ("which is an upper bound" in lines[1]) == (name == "minimal_example")
    assert re.fullmatch(r"values: \d+ measured, \d+ published, \d+ representative, \d+ not stated", lines[-2])
    assert lines[-1].startswith("assumed, to be measured or looked up: ")


def test_check_says_what_is_in_doubt_and_where(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "box.toml"
    text = shipped_files("controllers")["minimal_example"].read_text(encoding="utf-8")
    path.write_text(text.replace("displacement_mm3 = 18000.0", "displacement_mm3 = 18.0"), encoding="utf-8")
    status, out, _ = run("controller", "check", path)
    assert status == 0
    assert "in doubt: box.toml, [pump], key 'displacement_mm3': 18 mm³ is unusual" in out


@pytest.mark.parametrize("name", ["minimal_example", "five_speed_2005", "zf_6hp26", "gm_4l60e"])
def test_check_doubts_a_repair_that_leaves_a_worn_pair(run: Run, tmp_path: Path, name: str) -> None:
    land, path = load_controller(name).lands[0], tmp_path / "box.toml"
    text = shipped_files("controllers")[name].read_text(encoding="utf-8")
    for factor, doubted in ((1.0, False), (1.6, True)):
        repair = {"id": "mine", "component": land.component, "lands": [land.land], "kind": "other", "name": "mine"}
        repair |= {"source": "made up", "mounting_clearance_um": factor * land.mounting_high * 1e6}
        path.write_text(
            text + "\n[[repairs]]\n" + "\n".join(f"{k} = {v!r}" for k, v in repair.items()), encoding="utf-8"
        )
        status, out, _ = run("controller", "check", path)
        assert status == 0
        assert ("mine leaves up to" in out) is doubted
        assert ("key 'mounting_clearance_um'" in out) is doubted


def test_a_template_starts_from_a_shipped_unit_without_its_name(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "mine.xlsx"
    assert run("controller", "template", "--from", "minimal_example", "-o", path)[0] == 0
    status, _, err = run("controller", "check", path)
    assert status == 2
    lines = err.splitlines()
    assert len(lines) == 4
    for line, field in zip(lines, ("Id", "Name", "Source", "Date"), strict=True):
        assert f"column C ({field}): this cell must be filled in" in line


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("template", "-o", "unit.toml"), "a name.xlsx"),
        (("to-workbook", "minimal_example", "-o", "unit.ods"), "a name.xlsx"),
        (("to-workbook", "minimal_exampel", "-o", "unit.xlsx"), "did you mean 'minimal_example'?"),
        (("from-workbook", "unit.xlsx", "-o", "unit.xlsx"), "a name.toml"),
        (("from-workbook", "nowhere.xlsx", "-o", "unit.toml"), "no such file"),
        (("check", "nowhere.xlsx"), "no such file"),
    ],
)
def test_what_cannot_be_done_is_said(run: Run, tmp_path: Path, arguments: tuple[str, ...], message: str) -> None:
    places = [str(tmp_path / each) if each.startswith(("unit.", "nowhere.")) else each for each in arguments]
    status, out, err = run("controller", *places)
    assert (status, out) == (2, "")
    assert message in err


def test_a_workbook_is_written_in_other_units(run: Run, tmp_path: Path) -> None:
    first, second, unit = (tmp_path / name for name in ("first.xlsx", "second.xlsx", "unit.toml"))
    assert run("controller", "to-workbook", "minimal_example", "-o", first, "--units", "inch")[0] == 0
    assert run("controller", "to-workbook", first, "-o", second, "--pressure", "bar")[0] == 0
    assert run("controller", "from-workbook", second, "-o", unit)[0] == 0
    shipped = load_controller("minimal_example")
    assert replace(load_controller(unit), origin=shipped.origin) == shipped


def test_a_file_of_somebody_s_own_is_not_written_over(run: Run, tmp_path: Path) -> None:
    book, unit = tmp_path / "unit.xlsx", tmp_path / "unit.toml"
    assert run("controller", "to-workbook", "minimal_example", "-o", book)[0] == 0
    assert run("controller", "to-workbook", "minimal_example", "-o", book)[0] == 0  # atleak's own, unchanged
    unit.write_text("# mine\n", encoding="utf-8")
    status, _, err = run("controller", "from-workbook", book, "-o", unit)
    assert status == 2
    assert "--force" in err
    assert run("controller", "from-workbook", book, "-o", unit, "--force")[0] == 0
    assert load_controller(unit).id == "minimal_example"
