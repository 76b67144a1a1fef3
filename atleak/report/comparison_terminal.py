"""Show a comparison of two jobs on a terminal."""

from __future__ import annotations

from dataclasses import replace

from rich.text import Text

from atleak.comparison import Comparison
from atleak.look import look_of
from atleak.report.terminal import TerminalConsole, laid_out
from atleak.views.comparison_rows import condition_table, event_table, land_table
from atleak.views.comparison_words import changed_sentence, total_sentence, verdicts_sentence, visit_caveats
from atleak.wording import Wording

_LEFT_OUT = ("wear", "share", "decision")  # of each land, before and after


def print_comparison(comparison: Comparison, say: Wording) -> None:
    """Print both verdicts, the lands that are flagged or changed, totals and pressures, events, and messages."""
    console = TerminalConsole()
    console.print(Text(f"{say.name(comparison.after.controller.name)} · {say('comparison.title')}"))
    console.print(Text(verdicts_sentence(comparison, say), style=look_of(comparison.after.verdict).style))
    for sentence in (changed_sentence(comparison, say), total_sentence(comparison, say)):
        if sentence is not None:
            console.print(Text(sentence))
    for line in visit_caveats(comparison, say):
        console.print(Text(line))
    shown = [*comparison.flagged, *(land for land in comparison.changed if not land.flagged)]
    lands = land_table(comparison, shown, say)
    tables = [
        lands.without(*(f"{key}_{side}" for key in _LEFT_OUT for side in ("before", "after"))),
        condition_table(comparison, say, brief=True),
        *([] if comparison.logs is None else [event_table(comparison.logs, say)]),
    ]
    for table in tables:
        if table.rows:
            console.print(laid_out(replace(table, title=say(f"compare.{table.name}"))))
        elif table.name == "lands":
            console.print(Text(say("compare.no_land")))
    for message in comparison.messages:
        console.print(Text(f"{'!' if message.level == 'warning' else '·'} {say.sentence(message.text)}"))
