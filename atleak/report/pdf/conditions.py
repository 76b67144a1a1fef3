"""Build what depends on the condition: the complaint, the matrix of lands, the repairs and what they bring."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from atleak.land_diagnosis import LandDiagnosis
from atleak.repair import RepairPlan, RepairStep, Total
from atleak.report.pdf.blocks import Block, PrintedColumn, joined, table, text
from atleak.report.pdf.printed_names import PrintedNames
from atleak.views.complaint import finding, measure_first, reason
from atleak.views.condition_matrix import LandAtCondition, MatrixRow, leaking_worst_first
from atleak.views.land_names import land_number
from atleak.views.repair_options import OptionRow, option_rows
from atleak.views.repair_words import no_help, plan_ends
from atleak.views.sentences import replace_at, shares_add_up
from atleak.workshop_units import PERCENT

ABREAST = 5  # conditions beside one another in a table
MEASURE_FIRST = 6  # lands named for a complaint


class Conditions:
    """What a report says about each condition."""

    def __init__(self, names: PrintedNames) -> None:
        self.names, self.diagnosis, self.say = names, names.diagnosis, names.say

    # --- complaint

    def complaint(self) -> dict[str, Any] | None:
        """Return the customer's complaint, what explains it, and the lands to measure first; None without one."""
        say, diagnosis = self.say, self.diagnosis
        if diagnosis.complaint is None:
            return None
        at = joined((self.names.condition(each.condition) for each in diagnosis.complained), "; ")
        ranked = measure_first(diagnosis)
        items = [f"{self.names.land_name(each.land)}: {reason(each, say)}" for each in ranked[:MEASURE_FIRST]]
        if len(ranked) > MEASURE_FIRST:
            items.append(say("complaint.more", count=len(ranked) - MEASURE_FIRST))
        shows = say("complaint.shows", label=say.name(diagnosis.complaint.label), conditions=at)
        return {"sentence": f"{shows} {finding(diagnosis, say)}", "items": items}

    # --- matrix

    def matrix(self) -> Iterable[Block]:
        """Return the share of every land that leaks, at every condition."""
        names, rows = self.names, leaking_worst_first(self.diagnosis, self.diagnosis.presented)
        if not rows:
            return
        for first in range(0, len(self.diagnosis.presented), ABREAST):
            numbers = range(len(self.diagnosis.presented))[first : first + ABREAST]
            columns = [
                PrintedColumn(names.column("pair"), lambda row: names.pair(row.land), width=5),
                PrintedColumn(names.column("land"), lambda row: names.land(row.land), side="c"),
            ]
            for number in numbers:
                title = names.condition(self.diagnosis.presented[number].condition)
                columns.append(PrintedColumn(title, self._cell(number), "%", width=2, side="d"))
            yield table(columns, rows)
        yield text(
            " ".join(
                [
                    self.say("texts.matrix"),
                    shares_add_up(self.diagnosis, self.say),
                    *self._elsewhere(rows),
                ]
            ),
            small=True,
        )

    def _cell(self, number: int) -> Any:
        return lambda row: self._share(row.cells[number])

    def _share(self, cell: LandAtCondition) -> str | dict[str, str]:
        if cell.leakage == 0.0:
            return "–"
        share = self.say.number(cell.share * PERCENT, 2)
        return share if cell.verdict is None else {"sign": cell.verdict, "text": share}

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
        steps = list(enumerate(plan.steps, start=1))
        if steps:
            yield text(say("texts.repair_order_by_options" if plan.cost else "texts.repair_order"), leads=True)
            columns = [
                PrintedColumn("", lambda step: str(step[0]), side="r"),
                PrintedColumn(say("printed.pair"), lambda step: self.names.land_name(step[1].land), width=5),
                PrintedColumn(say("printed.verdict"), lambda step: self.names.verdict(step[1].land)),
                PrintedColumn(say("printed.helps_at"), lambda step: self._helps(step[1]), width=4),
                PrintedColumn(say("printed.before"), lambda step: self._at(step[1].at.before), side="r"),
                PrintedColumn(say("printed.after"), lambda step: self._at(step[1].at.after), side="r"),
            ]
            foreseen = any(step.land.replace_mileage for step in plan.steps)
            if foreseen:
                reached = PrintedColumn(
                    say("printed.replace_at"),
                    lambda step: replace_at(step[1].land, say) or "–",
                    width=2,
                    side="r",
                )
                columns.append(reached)
            yield table(columns, steps, empty=False)
            yield from self._options(plan)
            if foreseen:
                yield text(f"{say('printed.replace_at')}: {say('texts.replace_at')}.", small=True)
            if len(self.diagnosis.projections) > 1:
                yield from self._totals_after(plan.steps)
        for sentence in plan_ends(plan, say):
            yield text(sentence)

    def _options(self, plan: RepairPlan) -> Iterable[Block]:
        """Return the repairs that the valve body's file names for the plan's lands."""
        say, rows = self.say, option_rows(plan)
        if rows:
            yield text(say("texts.repair_options"), leads=True)
            yield table(
                [
                    PrintedColumn("", lambda row: str(row.number), side="r"),
                    PrintedColumn(say("printed.repair"), lambda row: row.name(say), width=6),
                    PrintedColumn(say("printed.use"), lambda row: row.use(say), width=3),
                    PrintedColumn(say("printed.leaves"), lambda row: row.leaves(say), say.unit("clearance"), side="r"),
                    PrintedColumn(say("printed.price"), lambda row: row.price(say), width=2, side="r"),
                    PrintedColumn(say("printed.hours"), lambda row: row.hours(say), "h", side="r"),
                    PrintedColumn(say("printed.tool"), lambda row: row.option.repair.tool or "–", width=3),
                ],
                rows,
                empty=False,
                told=self._repaired,
            )

    def _repaired(self, row: OptionRow) -> str:
        """Name the lands that a repair changes."""
        lands = joined(land_number(self.diagnosis.controller, key, self.say) for key in row.option.lands)
        return f"{self.say('printed.land')} {lands}"

    def _helps(self, step: RepairStep) -> str:
        if step.helps:
            return self.names.condition(step.at.condition)
        return no_help(step, self.say)

    def _at(self, total: Total) -> str:
        return self.say.percent(total.share)

    def _totals_after(self, steps: Sequence[RepairStep]) -> Iterable[Block]:
        """Return the total after every step at every condition."""
        say = self.say
        yield text(say("texts.totals_after"), leads=True)
        rows = [("–", [each.before for each in steps[0].conditions])]
        rows += [(str(number), [each.after for each in step.conditions]) for number, step in enumerate(steps, start=1)]
        for first in range(0, len(self.diagnosis.projections), ABREAST):
            columns = [PrintedColumn("", lambda row: row[0], side="r")]
            for number in range(len(self.diagnosis.projections))[first : first + ABREAST]:
                title = self.names.condition(self.diagnosis.projections[number].condition)
                columns.append(PrintedColumn(title, self._total(number), "%", width=1, side="d"))
            yield table(columns, rows)

    def _total(self, number: int) -> Any:
        def cell(row: tuple[str, list[Total]]) -> dict[str, str]:
            total = row[1][number]
            words = f"{self.say.number(total.share * PERCENT, 1)} {self.say.level(total.band)}"
            return {"sign": total.band.verdict, "text": words}

        return cell
