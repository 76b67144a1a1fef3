"""Build what depends on the condition: the complaint, the matrix of lands, the repairs and what they bring."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from typing import Any

from atleak.land_diagnosis import LandDiagnosis
from atleak.repair import RepairStep, Total
from atleak.report.pdf.blocks import Block, joined, listed, printed, text
from atleak.report.pdf.printed_names import Part
from atleak.views.complaint import finding, measure_first, reason
from atleak.views.condition_matrix import MatrixRow, leaking_worst_first
from atleak.views.land_names import land_number
from atleak.views.repair_options import OptionRow, option_rows
from atleak.views.repair_words import no_help, plan_ends
from atleak.views.sentences import replace_at, shares_add_up
from atleak.views.table import VERDICT, Column, Judged, Table
from atleak.workshop_units import PERCENT

ABREAST = 5  # conditions beside one another in a table
MEASURE_FIRST = 6  # lands named for a complaint


class Conditions(Part):
    """What a report says about each condition."""

    # --- complaint

    def complaint(self) -> dict[str, Any] | None:
        """Return the customer's complaint, what explains it, and the lands to measure first; None without one."""
        say, diagnosis = self.say, self.diagnosis
        if diagnosis.complaint is None:
            return None
        at = joined((self.say.condition(each.condition) for each in diagnosis.complained), "; ")
        ranked = measure_first(diagnosis)
        items = [f"{self.names.land_name(each.land)}: {reason(each, say)}" for each in ranked[:MEASURE_FIRST]]
        if len(ranked) > MEASURE_FIRST:
            items.append(say("complaint.more", count=len(ranked) - MEASURE_FIRST))
        shows = say("complaint.shows", label=say.name(diagnosis.complaint.label), conditions=at)
        return {"sentence": f"{shows} {finding(diagnosis, say)}", "items": items}

    # --- matrix

    def matrix(self) -> Iterable[Block]:
        """Return the share of every land that leaks, at every condition."""
        names, say, at = self.names, self.say, self.diagnosis.presented
        rows = leaking_worst_first(self.diagnosis, at)
        if not rows:
            return

        def share(number: int, row: MatrixRow) -> Judged:
            cell = row.cells[number]
            return Judged(None) if cell.leakage == 0.0 else Judged(say.number(cell.share * PERCENT, 2), cell.verdict)

        first = (
            Column("pair", width=250, of=lambda row: names.pair(row.land)),
            Column("land", of=lambda row: str(row.land.key[1])),
        )
        shares = [
            Column("", words_of="percent", width=100, words=say.condition(each.condition), of=partial(share, number))
            for number, each in enumerate(at)
        ]
        yield from self._abreast(rows, first, shares)
        said = (say("texts.matrix"), shares_add_up(self.diagnosis, say), *self._elsewhere(rows))
        yield text(" ".join(said), small=True)

    def _elsewhere(self, rows: Iterable[MatrixRow]) -> Iterable[str]:
        """Return one sentence for the lands that leak into the same circuits without drawing from the pump."""
        say = self.say
        lands: dict[tuple[str | None, ...], list[LandDiagnosis]] = {}
        for row in rows:
            if row.circuits:
                lands.setdefault(row.circuits, []).append(row.land)
        for circuits, leaking in lands.items():
            into = joined(
                say("texts.another_circuit") if circuit is None else self.names.section(circuit) for circuit in circuits
            )
            yield say("texts.elsewhere", lands=joined(map(self.names.land_number, leaking)), circuits=into)

    # --- repairs

    def repair_order(self) -> Iterable[Block]:
        """Return the repairs in their order, with what each brings at every condition, and where they end."""
        say, plan = self.say, self.names.plan

        def helps(step: RepairStep) -> str:
            return say.condition(step.at.condition) if step.helps else no_help(step, say)

        if plan.steps:
            yield text(say("texts.repair_order_by_options" if plan.cost else "texts.repair_order"), leads=True)
            columns = (
                Column("", digits=0, words="", of=lambda step: step[0]),
                Column("pair", width=250, of=lambda step: self.names.land_name(step[1].land)),
                Column("verdict", VERDICT, of=lambda step: step[1].land.verdict),
                Column("helps_at", width=200, of=lambda step: helps(step[1])),
                Column("before", "percent", of=lambda step: step[1].at.before.share, times=PERCENT),
                Column("after", "percent", of=lambda step: step[1].at.after.share, times=PERCENT),
                Column("replace_at", width=100, of=lambda step: replace_at(step[1].land, say)),
            )
            yield printed(Table("", columns, list(enumerate(plan.steps, start=1)), say).filled)
            yield from self._options()
            if any(step.land.replace_mileage for step in plan.steps):
                yield text(f"{say('printed.replace_at')}: {say('texts.replace_at')}.", small=True)
            if len(self.diagnosis.projections) > 1:
                yield from self._totals_after(plan.steps)
        yield from map(text, plan_ends(plan, say))

    def _options(self) -> Iterator[Block]:
        """Return the repairs that the valve body's file names for the plan's lands."""
        say, controller, rows = self.say, self.diagnosis.controller, option_rows(self.names.plan)
        if not rows:
            return

        def lands(row: OptionRow) -> str:
            return f"{say('printed.land')} {joined(land_number(controller, key, say) for key in row.option.lands)}"

        columns = (
            Column("", digits=0, words="", of=lambda row: row.number),
            Column("repair", width=300, of=lambda row: row.name(say)),
            Column("use", width=150, of=lambda row: row.use(say)),
            Column("leaves", words_of="clearance", of=lambda row: row.leaves(say)),
            Column("price", digits=2, of=lambda row: None if row.option.repair.price is None else row.price(say)),
            Column("hours", digits=1, of=lambda row: row.option.repair.hours),
            Column("tool", width=150, of=lambda row: row.option.repair.tool),
        )
        yield text(say("texts.repair_options"), leads=True)
        yield printed(Table("", columns, rows, say, told=lands).filled)

    def _totals_after(self, steps: Sequence[RepairStep]) -> Iterable[Block]:
        """Return the total after every step at every condition."""
        say = self.say
        yield text(say("texts.totals_after"), leads=True)
        rows = [("–", [each.before for each in steps[0].conditions])]
        rows += [(str(number), [each.after for each in step.conditions]) for number, step in enumerate(steps, start=1)]

        def total(number: int, row: tuple[str, list[Total]]) -> Judged:
            after = row[1][number]
            return Judged(f"{say.number(after.share * PERCENT, 1)} {say.level(after.band)}", after.band)

        first = Column("", digits=0, words="", of=lambda row: row[0])
        totals = [
            Column("", words_of="percent", width=50, words=say.condition(each.condition), of=partial(total, number))
            for number, each in enumerate(self.diagnosis.projections)
        ]
        yield from self._abreast(rows, (first,), totals)

    def _abreast(self, rows: Sequence[Any], first: Sequence[Column], columns: Sequence[Column]) -> Iterator[Block]:
        """Yield tables of as many conditions as have room beside one another."""
        for start in range(0, len(columns), ABREAST):
            yield listed(self.say, rows, *first, *columns[start : start + ABREAST])
