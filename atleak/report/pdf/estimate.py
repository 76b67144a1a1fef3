"""Build the estimate of a printed report: what is to be done, what it costs, and a box to agree to each line."""

from __future__ import annotations

from collections.abc import Iterable
from operator import itemgetter

from atleak.job.estimate import Line
from atleak.report.pdf.blocks import Block, PrintedColumn, table, text
from atleak.report.pdf.printed_names import PrintedNames


def estimate_blocks(names: PrintedNames) -> Iterable[Block]:
    """Return lines, sums and what is open; nothing where the job states no terms and no price."""
    say, words = names.say, names.estimate
    if words is None:
        return
    yield text(" ".join(words.chosen_by()), leads=True)

    def done(line: Line) -> str:
        return "\n".join(filter(None, (words.work(line), line.decision.part_number, line.decision.reason)))

    yield table(
        [
            PrintedColumn(say("printed.pair"), words.pair, width=5),
            PrintedColumn(say("printed.work"), done, width=4),
            PrintedColumn(say("printed.price"), lambda line: words.money(line.part), side="r"),
            PrintedColumn(say("printed.hours"), words.hours, side="r"),
            PrintedColumn(say("printed.labour"), lambda line: words.money(line.work), side="r"),
            PrintedColumn(say("printed.amount"), words.amount, side="r"),
            PrintedColumn(say("printed.agreed"), words.agreed),
        ],
        words.estimate.lines,
        told=lambda line: f"{say('printed.lacks')}: {words.lacks(line)}",
    )
    names_of_sums = ("state", "parts", "labour", "net", "tax", "gross")
    yield table(
        [
            PrintedColumn(say(f"printed.{name}"), itemgetter(place), side="r" if place else "l", width=int(not place))
            for place, name in enumerate(names_of_sums)
        ],
        [words.sum_row(*each) for each in words.sums],
    )
    for sentence in (*words.missing(), *words.ends()):
        yield text(sentence)
    yield text(words.rounding(), small=True)
