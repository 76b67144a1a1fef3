"""Build the estimate of a printed report: what is to be done, what it costs, and a box to agree to each line."""

from __future__ import annotations

from collections.abc import Iterable
from operator import itemgetter

from atleak.job.estimate import Line
from atleak.report.pdf.blocks import Block, listed, text
from atleak.report.pdf.printed_names import PrintedNames
from atleak.views.table import Column


def estimate_blocks(names: PrintedNames) -> Iterable[Block]:
    """Return lines, sums and what is open; nothing where the job states no terms and no price."""
    say, words = names.say, names.estimate
    if words is None:
        return
    yield text(" ".join(words.chosen_by()), leads=True)

    def done(line: Line) -> str:
        return "\n".join(filter(None, (words.work(line), line.decision.part_number, line.decision.reason)))

    yield listed(
        say,
        words.estimate.lines,
        Column("pair", width=250, of=words.pair),
        Column("work", width=200, of=done),
        Column("price", digits=2, of=lambda line: words.money(line.part)),
        Column("hours", digits=1, of=words.hours),
        Column("labour", digits=2, of=lambda line: words.money(line.work)),
        Column("amount", digits=2, of=words.amount),
        Column("agreed", of=words.agreed),
        told=lambda line: f"{say('printed.lacks')}: {words.lacks(line)}",
    )
    sums = ("parts", "labour", "net", "tax", "gross")
    yield listed(
        say,
        [words.sum_row(*each) for each in words.sums],
        Column("state", width=50, of=itemgetter(0)),
        *(Column(name, digits=2, of=itemgetter(place)) for place, name in enumerate(sums, start=1)),
    )
    yield from map(text, (*words.missing(), *words.ends()))
    yield text(words.rounding(), small=True)
