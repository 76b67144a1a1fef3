"""What stands on a terminal."""

from __future__ import annotations

import io

import pytest
from rich.table import Table
from rich.text import Text

from atleak.report.terminal import TerminalConsole, print_table
from atleak.system.printable import PrintableStream


def test_counts_in_a_table_are_numbers(capsys: pytest.CaptureFixture[str]) -> None:
    print_table(["a", "b", "c", "d", "e"], [{"a": 1, "b": 0, "c": True, "d": None, "e": 1.0}])
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
