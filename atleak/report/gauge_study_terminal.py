"""Show a gauge study on a terminal."""

from __future__ import annotations

from typing import Any

from rich.text import Text

from atleak.gauge_study.anova import GaugeStudy
from atleak.report.terminal import TerminalConsole, print_table
from atleak.views.gauge_study import anova_rows, component_rows, named, result_sentence
from atleak.wording import Wording, wording


def print_gauge_study(study: GaugeStudy) -> None:
    """Print what the variation is made of, the analysis behind it, and what there is to know about it."""
    say = wording("en")
    for rows in (component_rows(study), anova_rows(study)):
        shown = named([{key: _short(value, say) for key, value in row.items()} for row in rows], say)
        print_table(list(shown[0]), shown)
    console = TerminalConsole()
    for text in (result_sentence(study, say), *(message.text for message in study.messages), say("gauge_study.whose")):
        console.print(Text(text))


def _short(value: Any, say: Wording) -> Any:
    """Return a number with as many digits as a study can tell."""
    return say.plain(value, 4) if isinstance(value, float) else value
