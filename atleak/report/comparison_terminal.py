"""Show a comparison of two jobs on a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.table import Table
from rich.text import Text

from atleak.comparison import Comparison
from atleak.look import look_of
from atleak.report.terminal import TerminalConsole
from atleak.views.comparison_rows import (
    CONDITION_COLUMNS,
    EVENT_COLUMNS,
    LAND_COLUMNS,
    condition_rows,
    event_rows,
    land_rows,
)
from atleak.views.comparison_words import changed_sentence, total_sentence, verdicts_sentence, visit_caveats
from atleak.views.table import Column
from atleak.wording import Wording, signed, wording

_ON_TERMINAL = ("pair", "was", "verdict", "clearance_before", "clearance_after", "change", "changed")


def print_comparison(comparison: Comparison) -> None:
    """Print both verdicts, the lands that are flagged or changed, totals and pressures, events, and messages."""
    console, say = TerminalConsole(), wording("en")
    console.print(Text(f"{comparison.after.controller.name} · before and after"))
    console.print(Text(verdicts_sentence(comparison, say), style=look_of(comparison.after.verdict).style))
    for sentence in (changed_sentence(comparison, say), total_sentence(comparison, say)):
        if sentence is not None:
            console.print(Text(sentence))
    for line in visit_caveats(comparison, say):
        console.print(Text(line))
    shown = [*comparison.flagged, *(land for land in comparison.changed if not land.flagged)]
    if shown:
        by_name = {column.key: column for column in LAND_COLUMNS}
        rows = _cells(land_rows(comparison, shown, say), [by_name[name] for name in _ON_TERMINAL], say)
        console.print(_table(rows, "Lands that are flagged or changed; ± 95 % of the measurement"))
    else:
        console.print(Text("No land is flagged at either visit, and none changed."))
    quantities = condition_rows(comparison, say, brief=True)
    if quantities:
        rows = _cells(quantities, CONDITION_COLUMNS, say)
        console.print(_table(rows, "Totals, and pressures that changed"))
    if comparison.logs is not None and comparison.logs.pairs:
        rows = _cells(event_rows(comparison.logs, say), EVENT_COLUMNS, say)
        console.print(_table(rows, "Events of the road tests, before → after"))
    for message in comparison.messages:
        console.print(Text(f"{'!' if message.level == 'warning' else '·'} {message.text}"))


def _cells(rows: Sequence[dict[str, Any]], columns: Sequence[Column], say: Wording) -> list[dict[str, str]]:
    return [{column.heading(say): _cell(row[column.key]) for column in columns} for row in rows]


def _table(rows: Sequence[dict[str, str]], title: str) -> Table:
    table = Table(*rows[0], title=title, title_justify="left", title_style="")
    for row in rows:
        table.add_row(*(Text(cell) for cell in row.values()))
    return table


def _cell(value: Any) -> str:
    if value is None:
        return "–"
    if isinstance(value, float):
        return f"{value:.1f}"
    return signed(value) if hasattr(value, "flagged") else str(value)
