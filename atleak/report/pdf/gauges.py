"""Build the section on gauge readings: each beside what is permissible and expected, and the patterns they show."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from atleak.gauges.check import CheckedReading, PressureCheck
from atleak.pressure_table import LINE
from atleak.report.pdf.blocks import Block, PrintedColumn, facts, joined, table, text
from atleak.report.pdf.printed_names import PrintedNames
from atleak.views.gauge_rows import pattern_text, permissible_text, tap_text
from atleak.wording import Wording
from atleak.workshop_units import KPA


class GaugeSection:
    """The section on gauge readings of the standing vehicle."""

    def __init__(self, names: PrintedNames) -> None:
        self.controller, self.say = names.diagnosis.controller, names.say

    def blocks(self, check: PressureCheck | None) -> Iterable[Block]:
        """Yield where the readings are from, the table, the patterns, and who set the limits."""
        if check is None:
            return
        say = self.say
        source = joined((check.table.file, check.table.sheet or ""))
        yield facts([[say("facts.pressures"), source]])
        yield table(self._columns(check), check.readings)
        sources = dict.fromkeys(each.permissible.source for each in check.readings if each.permissible)
        if sources:
            yield text(say("texts.permissible_from", sources=joined(sources, "; ")), small=True)
        for reason in dict.fromkeys(each.unjudged for each in check.readings if each.unjudged is not None):
            yield text(say("texts.gauges_unjudged", reason=say.sentence(reason)), small=True)
        items = [
            f"{pattern_text(each, self.controller, say)} ({say.get('pattern_sources', each.source)})"
            for each in check.patterns
        ]
        if items:
            yield text(say("texts.patterns"))
            yield {"kind": "list", "items": items}

    def _columns(self, check: PressureCheck) -> list[PrintedColumn]:
        say = self.say
        columns = [
            PrintedColumn(say("printed.verdict"), lambda each: judged(each, say)),
            PrintedColumn(say("printed.selector_range"), lambda each: each.cell.range, side="c"),
            PrintedColumn(say("printed.engine_state"), lambda each: say.sentence(each.cell.engine.label), width=3),
        ]
        if any(each.cell.tap != LINE for each in check.readings):
            columns.append(
                PrintedColumn(say("printed.tap"), lambda each: tap_text(self.controller, each.cell.tap, say), width=3)
            )
        if any(each.reading.repeat > 1 for each in check.readings):
            columns.append(PrintedColumn(say("printed.repeat"), lambda each: str(each.reading.repeat), side="r"))
        numbers = (
            ("gauge", lambda each: each.reading.pressure),
            ("expected", lambda each: each.expected),
            ("lost", lambda each: each.loss),
        )
        gauge, *others = [
            PrintedColumn(say(f"printed.{name}"), _in_kpa(value, say), say.unit("pressure"), side="r")
            for name, value in numbers
            if any(value(each) is not None for each in check.readings)
        ]
        permitted = PrintedColumn(
            say("printed.permissible"),
            lambda each: permissible_text(each.permissible, say) or "–",
            say.unit("pressure"),
            side="r",
        )
        decision = PrintedColumn(say("printed.decision"), lambda each: decided(each, say), width=3)
        return [*columns, gauge, permitted, *others, decision]


def _in_kpa(value: Any, say: Wording) -> Any:
    def cell(each: CheckedReading) -> str:
        pascal = value(each)
        return "–" if pascal is None else say.value(pascal * KPA, "pressure", 0)

    return cell


def judged(each: CheckedReading, say: Wording) -> Any:
    """Return the verdict on a reading as the template shows it; that nothing judges it where nothing does."""
    if each.verdict is None:
        return say("texts.not_judged")
    return {"sign": each.verdict, "text": say.level(each.verdict)}


def decided(each: CheckedReading, say: Wording) -> str:
    """Return how sure the verdict on a reading is."""
    return "–" if each.deciding is None else say.get("decisions", each.deciding.decision)
