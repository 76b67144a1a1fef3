"""Build the section on gauge readings: each beside what is permissible and expected, and the patterns they show."""

from __future__ import annotations

from collections.abc import Iterable

from atleak.diagnosis import Diagnosis
from atleak.report.pdf.blocks import Block, bullets, joined, named_facts, printed, text
from atleak.views.gauge_rows import gauge_table, pattern_sentences
from atleak.wording import Wording


def gauge_blocks(diagnosis: Diagnosis, say: Wording) -> Iterable[Block]:
    """Yield where gauge readings of the standing vehicle are from, the table, the patterns, and who set the limits."""
    check = diagnosis.pressures
    if check is None:
        return
    yield named_facts("facts", say, pressures=joined((check.table.file, check.table.sheet or "")))
    yield printed(gauge_table(check, say).without("lost_between", "past_limit"))
    sources = dict.fromkeys(each.permissible.source for each in check.readings if each.permissible)
    if sources:
        yield text(say("texts.permissible_from", sources=joined(sources, "; ")), small=True)
    for reason in dict.fromkeys(each.unjudged for each in check.readings if each.unjudged is not None):
        yield text(say("texts.gauges_unjudged", reason=say.sentence(reason)), small=True)
    items = pattern_sentences(check, diagnosis.controller, say)
    if items:
        yield text(say("texts.patterns"))
        yield bullets(items)
