"""Show a gauge study on a terminal."""

from __future__ import annotations

from rich.text import Text

from atleak.gauge_study.anova import GaugeStudy
from atleak.report.terminal import TerminalConsole, print_table
from atleak.views.gauge_study import result_sentence, shown_anova, shown_components
from atleak.wording import wording


def print_gauge_study(study: GaugeStudy) -> None:
    """Print what the variation is made of, the analysis behind it, and what there is to know about it."""
    say = wording("en")
    for rows, columns in (shown_components(study, say), shown_anova(study, say)):
        shown = [
            {
                column.heading(say): column.written(column.value(row[column.key], say), say)
                if column.is_number
                else row[column.key]
                for column in columns
            }
            for row in rows
        ]
        print_table([column.heading(say) for column in columns], shown)
    console = TerminalConsole()
    for text in (result_sentence(study, say), *(message.text for message in study.messages), say("gauge_study.whose")):
        console.print(Text(text))
