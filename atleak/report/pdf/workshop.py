"""Build the workshop report's sections on the estimate, on gauges and on what was measured before opening."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from operator import itemgetter

from atleak.analysis.estimate import Line
from atleak.common.wording import Wording, begun, joined
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.gauge_check import CheckedReading
from atleak.diagnosis.missing import Missing
from atleak.report.charts.paper import drawn_on_paper as printed_chart
from atleak.report.pdf.blocks import FEW, Block, abreast, bullets, listed, named_facts, printed, section_blocks, text
from atleak.report.printed_names import PrintedNames
from atleak.report.tables.answer import missing_table
from atleak.report.tables.evidence import printed_sections
from atleak.report.tables.gauges import gauge_table, pattern_sentences, tap_text
from atleak.report.tables.table import Column, Table

_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")  # of what is worse without a line of the estimate


def estimate_blocks(names: PrintedNames) -> Iterable[Block]:
    """Return lines, sums and what is open; nothing where the job states no terms and no price."""
    say, words = names.say, names.estimate
    if words is None:
        return
    yield text(" ".join(words.chosen_by()), leads=True)

    def done(line: Line) -> str:
        decision = line.decision
        day = say.date(decision.date) if decision.date else ""
        return "\n".join(filter(None, (words.work(line), decision.part_number, decision.reason, day)))

    worse: dict[str, tuple[str, str]] = {}
    for line in words.estimate.lines:
        rule, within, without = words.lacking(line)
        worse[line.key] = (say("estimate.with_it", rule=rule, within=within) if within else rule, without or "–")
    rules = dict.fromkeys(rule for rule, _ in worse.values())
    marks = {rule: str(number).translate(_RAISED) for number, rule in enumerate(rules, start=1)}

    def lacks(line: Line) -> str:
        rule, without = worse[line.key]
        return f"{without} {marks[rule]}"

    lines = words.estimate.lines
    as_new = [line for line in lines if not (line.own or line.decision.repair or line.of_pump)]
    bare = [line for line in as_new if line.price is None and line.hours is None]
    bare = bare if len(bare) > FEW else []  # made as new, of which there are no amounts
    lack, agreed = Column("lacks", of=lacks), Column("agreed", of=words.agreed)
    yield listed(
        say,
        [line for line in lines if line not in bare],
        Column("pair", width=150, of=words.pair),
        Column("work", width=150, of=done),
        Column("price", digits=2, of=lambda line: words.money(line.part)),
        Column("hours", digits=1, of=words.hours),
        Column("labour", digits=2, of=lambda line: words.money(line.work)),
        Column("amount", digits=2, of=words.amount),
        lack,
        agreed,
    )
    if bare:
        yield text(say("estimate.bare"), leads=True)
        yield abreast(
            Table("", (Column("pair", width=50, of=words.lands), lack, agreed), bare, say), 2 + names.numbered
        )
    about = joined((f"{mark} {rule}" for rule, mark in marks.items()), "; ")
    yield text(f"{begun(say('printed.lacks'))}: {about}.", small=True)
    sums = ("parts", "labour", "net", "tax", "gross")
    yield listed(
        say,
        [words.sum_row(*each) for each in words.sums],
        Column("state", width=50, of=itemgetter(0)),
        *(Column(name, digits=2, of=itemgetter(place)) for place, name in enumerate(sums, start=1)),
    )
    yield from map(text, (*words.missing(bare), *words.ends()))
    yield text(words.rounding(), small=True)


def gauge_blocks(diagnosis: Diagnosis, say: Wording) -> Iterable[Block]:
    """Yield where gauge readings of the standing vehicle are from, the table, the patterns, and who set the limits."""
    check = diagnosis.pressures
    if check is None:
        return
    yield named_facts("facts", say, pressures=joined((check.table.file, check.table.sheet or "")))
    table = gauge_table(check, say)
    verdict, *others = table.without("range", "engine_state", "tap", "lost_between", "past_limit").columns

    def where(each: CheckedReading) -> str:
        return say("gauge_page.cell", range=each.cell.range, engine=say.sentence(each.cell.engine.label))

    def tap(each: CheckedReading) -> str:
        return begun(tap_text(diagnosis.controller, each.cell.tap, say))

    yield printed(replace(table, columns=(verdict, Column("range", width=110, of=where), *others), group=tap))
    sources = dict.fromkeys(each.permissible.source for each in check.readings if each.permissible)
    said = [say("texts.permissible_from", sources=joined(map(say.name, sources), "; "))] if sources else []
    for reason in dict.fromkeys(each.unjudged for each in check.readings if each.unjudged is not None):
        said.append(say("texts.gauges_unjudged", reason=say.sentence(reason)))
    yield text(" ".join(said), small=True)
    items = pattern_sentences(check, diagnosis.controller, say)
    if items:
        yield text(say("texts.patterns"), leads=True)
        yield bullets(items)
    if diagnosis.missing_flagged:
        yield text(say("answer.split"), leads=True)
        condition, tap_, *amounts = missing_table(diagnosis, say).columns

        def of(each: Missing) -> str:
            return joined(column.text(each, say) for column in (condition, tap_))

        yield listed(say, diagnosis.missing_flagged, *amounts, group=of)


def before_opening_blocks(diagnosis: Diagnosis, say: Wording) -> Iterable[Block]:
    """Yield what was measured before the unit was opened, and what is likely worn where it was not."""
    for section in printed_sections(diagnosis, say):
        yield text(section.title, leads=True)
        yield from section_blocks(section, lambda drawn: printed_chart(drawn.chart, say), say)["blocks"]
