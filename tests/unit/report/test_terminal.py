"""What stands on a terminal."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from dataclasses import replace

import pytest
from rich.table import Table
from rich.text import Text

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.printable import PrintableStream
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.report.terminal import TerminalConsole, print_diagnosis, print_records
from tests.unit.conftest import with_clearances


def test_counts_in_a_table_are_numbers(capsys: pytest.CaptureFixture[str]) -> None:
    print_records(["a", "b", "c", "d", "e"], [{"a": 1, "b": 0, "c": True, "d": None, "e": 1.0}])
    cells = [cell.strip() for cell in capsys.readouterr().out.splitlines()[3].strip("│").split("│")]
    assert cells == ["1", "0", "yes", "–", "1"]


def test_a_name_sends_no_command_to_a_terminal_but_colours_and_columns_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setenv("FORCE_COLOR", "1")
    screen = io.StringIO()
    table = Table("name", "value")
    for name in ("plain", "\x1b]0;title\x07p_g\x1b[2J\x9b31m"):
        table.add_row(Text(name, style="red"), "1")
    TerminalConsole(PrintableStream(screen)).print(table)
    shown = screen.getvalue()
    assert "\x1b[31m" in shown
    assert not {"\x07", "\x9b"} & set(shown)
    assert "\x1b]0" not in shown
    assert "\x1b[2J" not in shown
    rows = [Text.from_ansi(line).plain for line in shown.splitlines()]
    assert "]0;titlep_g[2J31m" in rows[4]
    assert len({len(row) for row in rows}) == 1


def printed(diagnosis: Diagnosis, capsys: pytest.CaptureFixture[str]) -> str:
    print_diagnosis(diagnosis)
    return " ".join(capsys.readouterr().out.replace("\u00a0", " ").split())


def test_every_condition_says_what_line_and_circuits_hold(
    worn_clutch: Diagnosis, capsys: pytest.CaptureFixture[str]
) -> None:
    said = printed(worn_clutch, capsys)
    assert "Main pressure at “hot idle”: the required 500 kPa is held" in said
    assert "Permissible: 400 to 539 kPa." in said
    assert said.count("Reserve: the pump supplies") == len(worn_clutch.projections)
    assert re.search(
        r"clutch C1 holds 254 of 471 kPa \(\d+ to \d+\): ■ replace; 2/1 valve of clutch C1 costs 1\d\d kPa", said
    )
    assert "● ok: electronic pressure control 200 kPa, lock-up 150 kPa, signal 100 kPa" in said


def test_nothing_unmeasured_is_called_ok(
    three_circuits: Controller, hipol: Fluid, limits: Limits, capsys: pytest.CaptureFixture[str]
) -> None:
    said = printed(diagnose(three_circuits, hipol, limits), capsys)
    assert "○ not measured: electronic pressure control 200 kPa, clutch C1 471 kPa" in said
    assert "● ok" not in said


def test_the_first_line_names_the_pressure_that_decided(
    three_circuits: Controller, hipol: Fluid, limits: Limits, readings_of: Callable, capsys: pytest.CaptureFixture[str]
) -> None:
    clearances = {("2", 1): 19e-6, ("2", 2): 19e-6}
    readings = with_clearances(three_circuits, readings_of, clearances)
    first = three_circuits.circuits[1]
    narrow = replace(first, feeds=(replace(first.feeds[0], diameter=0.3e-3),))
    controller = replace(three_circuits, circuits=(three_circuits.circuits[0], narrow, *three_circuits.circuits[2:]))
    diagnosis = diagnose(controller, hipol, limits, readings=readings)
    said = printed(diagnosis, capsys)
    assert "because of the pressure lost by clutch C1 at “hot idle”:" in said
    assert "Look first at 2/1 valve of clutch C1" in said


def test_a_unit_of_which_anything_is_open_is_not_called_ok(
    four_speed: Controller, hipol: Fluid, limits: Limits, readings_of: Callable, capsys: pytest.CaptureFixture[str]
) -> None:
    new = {
        land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * land.new_clearance) for land in four_speed.lands
    }
    whole = diagnose(four_speed, hipol, limits, readings=readings_of(four_speed, new))
    assert "unit: ● ok" in printed(whole, capsys)
    some = dict(list(new.items())[:3])
    said = printed(diagnose(four_speed, hipol, limits, readings=readings_of(four_speed, some)), capsys)
    assert "unit: ○ not all is sure" in said
    assert "unit: ● ok" not in said
