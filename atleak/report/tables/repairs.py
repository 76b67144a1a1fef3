"""Say what is planned: the repairs that a valve body's file offers, what a plan costs, and where it ends.

What a set of repairs brings at every condition stands in a table of its own: share, pressure held and reserve, before
and after.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from atleak.analysis.repair.choice import Basis, OfferedRepair
from atleak.analysis.repair.options import Cost, Option
from atleak.analysis.repair.plan import PumpStep, Remainder, RepairPlan, RepairStep
from atleak.analysis.repair.totals import RepairedAt, Total
from atleak.catalogue.controller import Controller
from atleak.catalogue.entries import Evidence
from atleak.catalogue.limits import RuleKind
from atleak.catalogue.repairs import LandKey, Repair
from atleak.common.units import KPA, MM, MM2_S, PERCENT, UM
from atleak.common.wording import Wording, isolated
from atleak.diagnosis.consequence import Consequence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.engine.operation import LINE
from atleak.report.json.conditions import OF_REPAIR, kit_components, named_record, of_land
from atleak.report.tables.lands import CONDITION_WIDTH
from atleak.report.tables.names import components_words, land_number
from atleak.report.tables.sentences import consequence_words, land_in_words, replace_at
from atleak.report.tables.table import VERDICT, Column, Judged, Table, span


@dataclass(frozen=True)
class RepairOptionRow:
    """One repair that the file names for the land, or the pump, of one step; the number counts the steps from 1."""

    number: int
    step: PumpStep | RepairStep
    option: Option
    controller: Controller

    @property
    def chosen(self) -> bool:
        """Tell whether the plan computes with it."""
        return self.step.chosen is self.option

    def lands(self, say: Wording) -> str:
        """Name the lands that it changes; of a kit its components."""
        lands = ", ".join(f"{component}/{land}" for component, land in self.option.lands)
        return kit_words(self.controller, self.option, say) or lands

    @property
    def representative(self) -> bool:
        """Tell whether price, hours and clearance are those of such repairs in general."""
        return self.option.repair.evidence is Evidence.REPRESENTATIVE

    @property
    def mends(self) -> bool:
        """Tell whether it brings the step's land within its limits, as every repair of the pump does that."""
        return isinstance(self.step, PumpStep) or self.option.mends(self.step.land.key)

    def name(self, say: Wording) -> str:
        """Name it with its part number, and say where it is representative."""
        label = repair_name(self.option.repair, say)
        return f"{label} ({say('plan.representative')})" if self.representative else label

    @property
    def left(self) -> list[float]:
        """Return the radial clearance that it leaves of the step's land [µm], or the ends of a range."""
        if isinstance(self.step, PumpStep):
            return []
        state = self.option.states[self.step.land.key]
        ends = (state.radial_clearance,) if self.option.repair.keeps_clearance else state.land.mounting_ends
        return [end * UM for end in ends]

    def leaves(self, say: Wording) -> str:
        """Return what it leaves in the reader's unit, without it: a number, or the ends of a range; a pump as new."""
        return span(self.left, "clearance", say) if self.left else say("repair_plan.as_new")

    def price(self, say: Wording) -> str:
        """Return the price with its currency; a dash where the file states none."""
        repair = self.option.repair
        return "–" if repair.price is None else f"{say.number(repair.price, 2)} {repair.currency}"

    def hours(self, say: Wording) -> str:
        """Return the hours of work; a dash where the file states none."""
        return say.number(self.option.repair.hours, 1)

    def use(self, say: Wording) -> str:
        """Say whether it is the one that is planned, and where it does not mend the land."""
        said = [say("plan.chosen") if self.chosen else "", "" if self.mends else say("plan.mends_not")]
        return ", ".join(filter(None, said))


def repair_name(repair: Repair, say: Wording) -> str:
    """Return the name of a repair with its part number."""
    name = say.name(repair.name)
    return f"{name} ({repair.part_number})" if repair.part_number else name


def kit_words(controller: Controller, option: Option | None, say: Wording) -> str:
    """Name the components that a kit mends in one repair; an empty text of any other repair."""
    components = () if option is None else option.repair.components
    return say("plan.kit", components=components_words(controller, components, say)) if len(components) > 1 else ""


def option_rows(plan: RepairPlan) -> list[RepairOptionRow]:
    """Return every option of every step of a plan, those of the file's order, the planned one first."""
    controller = plan.choice.unit.controller
    return [
        RepairOptionRow(number, step, option, controller)
        for number, step in enumerate(plan.order, start=1)
        for option in sorted(step.options, key=lambda option: option is not step.chosen)
    ]


def step_in_words(diagnosis: Diagnosis, step: PumpStep | RepairStep, say: Wording) -> str:
    """Name what a step repairs, the land that calls for it and what a kit mends with it; say of a pump if as new."""
    if isinstance(step, RepairStep):
        kit = kit_words(diagnosis.controller, step.chosen, say)
        return ", ".join(filter(None, (land_in_words(diagnosis, step.land.key, say), kit)))
    return say("pump.name") if step.options else say("pump.as_new")


def pump_brings(at: RepairedAt, say: Wording) -> str:
    """Say what a new pump brings at a condition: the pressure held, where it rises, and the reserve."""
    held, new = (say.quantity(each.pressures[LINE] * KPA, "pressure", 0) for each in (at.before, at.after))
    reserve, reserve_new = (say.number(each.reserve, 2) for each in (at.before, at.after))
    key = "pump.brings" if at.gained else "pump.brings_reserve"
    return say(key, condition=say.condition(at.condition), held=held, new=new, reserve=reserve, reserve_new=reserve_new)


def order_table(diagnosis: Diagnosis, plan: RepairPlan, say: Wording) -> Table:
    """Return the steps of a plan in their order, with what each brings at the condition where it helps most."""

    def share(end: str, step: PumpStep | RepairStep) -> str | None:
        total: Total = getattr(step.at, end)
        known = say.number(total.share * PERCENT, 1) if math.isfinite(total.share) else say("diagnosis.no_flow")
        return known if step.helps else None

    def helps(step: PumpStep | RepairStep) -> str:
        if not step.helps:
            return no_help(step, say)
        return pump_brings(step.at, say) if isinstance(step, PumpStep) else say.condition(step.at.condition)

    steps = {id(step): number for number, step in enumerate(plan.order, start=1)}
    columns = (
        Column("number", digits=0, words=say("repair_plan.number"), of=lambda step: steps[id(step)]),
        Column("pair", width=250, of=lambda step: step_in_words(diagnosis, step, say)),
        Column("verdict", VERDICT),
        Column("consequence", width=150, of=lambda step: step_consequence(diagnosis, step, say)),
        Column("helps_at", width=200, of=helps),
        Column("before", words_of="percent", of=partial(share, "before")),
        Column("after", words_of="percent", of=partial(share, "after")),
        Column("then", VERDICT, of=lambda step: step.at.after.band if step.helps else None),
        Column(
            "replace_at",
            width=100,
            of=lambda step: replace_at(step.land, say) if isinstance(step, RepairStep) else None,
        ),
    )
    return Table("order", columns, plan.order, say)


def totals_table(diagnosis: Diagnosis, plan: RepairPlan, say: Wording) -> Table:
    """Return the total at every condition as measured, and after every step of a plan that has any."""
    totals = [(0, [each.before for each in plan.order[0].conditions])]
    totals += [(number, [each.after for each in step.conditions]) for number, step in enumerate(plan.order, start=1)]

    def step(row: tuple[int, list[Total]]) -> str:
        number, _ = row
        repaired = step_in_words(diagnosis, plan.order[number - 1], say)
        return f"{number}. {repaired}" if number else say("repair_plan.as_measured")

    def total(name: str, row: tuple[int, list[Total]]) -> Judged:
        at = next(each for each in row[1] if each.condition.name == name)
        known = say.number(at.share * PERCENT, 1) if math.isfinite(at.share) else say("diagnosis.no_flow")
        return Judged(f"{known} {say.level(at.band)}", at.band)

    columns = (
        Column("after_step", words=say("repair_plan.after_step"), of=step),
        *(
            Column(
                each.name,
                width=CONDITION_WIDTH,
                words=say.condition(each),
                words_of="percent",
                of=partial(total, each.name),
            )
            for each in (projection.condition for projection in diagnosis.presented)
        ),
    )
    return Table("totals", columns, totals, say)


def option_table(plan: RepairPlan, say: Wording) -> Table:
    """Return every option of every step of a plan: what it is, what it leaves of the step's land, what it takes."""

    def repair(name: str) -> Callable[[RepairOptionRow], Any]:
        return lambda row: getattr(row.option.repair, name)

    def priced(row: RepairOptionRow) -> str | None:
        return None if row.option.repair.price is None else row.price(say)

    price = Column("price", digits=2, of=repair("price")), Column("currency", of=repair("currency"))
    columns = (
        Column("number", digits=0, words=say("repair_plan.number")),
        Column("repair", width=300, of=lambda row: row.name(say)),
        Column("use", width=150, of=lambda row: row.use(say)),
        Column("leaves", words_of="clearance", of=lambda row: row.leaves(say)),
        Column("price", of=priced, parts=price),
        Column("hours", digits=1, of=repair("hours")),
        Column("tool", width=150, of=repair("tool")),
        Column(
            "lands",
            of=lambda row: row.lands(say),
            parts=(
                Column("lands", of=lambda row: row.lands(say)),
                Column("id", of=repair("id")),
                Column("source", of=lambda row: say.name(row.option.repair.source)),
            ),
        ),
    )
    return Table("options", columns, option_rows(plan), say)


def planned(row: RepairOptionRow, say: Wording) -> str:
    """Say one option in a line: what it is, what it leaves, and what it costs."""
    hours, kit = row.option.repair.hours, kit_words(row.controller, row.option, say)
    together = say("plan.together", lands=row.lands(say)) if len(row.option.lands) > 1 else ""
    said = [
        row.name(say),
        say("plan.leaves", clearance=say.span(row.left, "clearance", 1)) if row.left else say("repair_plan.as_new"),
        "" if row.option.repair.price is None else row.price(say),
        "" if hours is None else say("plan.hours", hours=row.hours(say)),
        row.option.repair.tool or "",
        kit or together,
    ]
    return ", ".join(filter(None, said))


def costs(plan: RepairPlan, say: Wording) -> Iterator[str]:
    """Say what the planned repairs cost together; nothing where the file names none for any step."""
    cost = plan.cost
    if cost is None:
        return
    nothing = cost.repairs == cost.without_price == cost.without_hours
    if cost.repairs and nothing:
        yield say("plan.cost_none", count=cost.repairs)
    elif cost.repairs:
        prices = " + ".join(f"{say.number(price, 2)} {currency}" for currency, price in cost.prices.items())
        hours = None if cost.without_hours == cost.repairs else cost.hours
        yield say("plan.cost", count=cost.repairs, prices=prices or "–", hours=say.number(hours, 1))
    if not nothing and (cost.without_price or cost.without_hours):
        yield say("plan.cost_open", prices=cost.without_price, hours=cost.without_hours)
    chosen = [row for row in option_rows(plan) if row.chosen]
    if any(row.representative for row in chosen):
        yield say("plan.cost_representative", count=sum(row.representative for row in chosen))
    if cost.without_option:
        yield say("plan.without_option", count=cost.without_option)


def price_and_hours(cost: Cost | None, say: Wording) -> str:
    """Return what repairs cost, as far as that is stated: ``89.00 USD, 1.5 h``."""
    if cost is None:
        return ""
    prices = [f"{say.number(price, 2)} {currency}" for currency, price in cost.prices.items()]
    hours = [] if not cost.hours else [f"{say.number(cost.hours, 1)} h"]
    return ", ".join([*prices, *hours])


def option_record(option: Option, key: LandKey) -> dict[str, Any]:
    """Return an option as plain values: what it is, what it costs, and what it leaves of a land."""
    repair, land = option.repair, option.states[key].land
    return {
        **named_record(repair, *OF_REPAIR),
        "components": kit_components(repair),
        "lands": [of_land(changed) for changed in option.lands],
        "nominal_diameter_mm": land.nominal_diameter * MM,
        "clearance_after_um": option.states[key].radial_clearance * UM,
        "mounting_clearance_low_um": None if repair.keeps_clearance else land.mounting_range[0] * UM,
        **named_record(None if repair.keeps_clearance else land, mounting_clearance_um="mounting_high"),
        **named_record(None if repair.keeps_clearance else land, "mounting_tolerance_um"),
        "mends": option.mends(key),
        **named_record(repair, "evidence", "source"),
    }


def cost_record(cost: Cost | None) -> dict[str, Any] | None:
    """Return what a plan costs as plain values; None where the file names no repair for any of its steps."""
    if cost is None:
        return None
    return {
        "prices": [{"price": price, "currency": currency} for currency, price in cost.prices.items()],
        **named_record(cost, "hours", "repairs", "without_price", "without_hours", "without_option"),
    }


def step_consequence(diagnosis: Diagnosis, step: PumpStep | RepairStep, say: Wording) -> str | None:
    """Say whether a step is needed now, or what the most urgent of its lands does."""
    if isinstance(step, PumpStep) or step.consequence is Consequence.NOW:
        return say("consequences.now")
    lands = (step.land, *step.together)
    return next(
        consequence_words(diagnosis, land, say)
        for land in lands
        if diagnosis.consequences[land.key] is step.consequence
    )


def no_help(step: PumpStep | RepairStep, say: Wording) -> str:
    """Say why a land that lowers no total is on the list, or the pump of which that is not known."""
    if isinstance(step, PumpStep):
        return say("pump.not_known")
    return say("plan.draws_no_more" if step.leaks else "plan.never_leaks")


def plan_ends(plan: RepairPlan, say: Wording) -> Iterator[str]:
    """Say where the plan ends: green everywhere, or what remains and what that may be up to."""
    if plan.pump is not None and plan.pump.helps:
        yield say("pump.planned_first")
    if not plan.judged:
        yield say("plan.not_judged")
        return
    if plan.for_total:
        yield say("plan.for_total", count=plan.for_total)
    if plan.reached:
        yield say("plan.green" if plan.order else "plan.green_already")
    for left in plan.remaining:
        yield _remains(left, say)
    for rule in plan.pressures_past:
        condition = say.condition(rule.condition) if rule.condition else ""
        what = say(f"rules.{rule.kind}") + (f" ({say.name(rule.circuit.name)})" if rule.circuit else "")
        yield say("plan.pressure_stays", condition=condition, what=what, level=say.level(rule.level))
    if plan.lands_past:
        lands = ", ".join(f"{land.key[0]}/{land.key[1]}" for land in plan.lands_past)
        yield say("plan.land_stays", lands=lands)
    currencies = plan.choice.moves.currencies
    if plan.choice.basis is Basis.FEWEST and len(currencies) > 1:
        yield say("plan.currencies", currencies=", ".join(currencies))
    if not plan.choice.proven:
        yield say("estimate.not_proven", rounds=plan.choice.rounds)
    if plan.unmeasured:
        yield say("plan.unmeasured", count=plan.unmeasured)
    yield from costs(plan, say)


def _remains(left: Remainder, say: Wording) -> str:
    total = left.total
    condition = say.condition(total.condition)
    if not math.isfinite(total.share):
        return say("plan.no_delivery", condition=condition)
    stays = say("plan.stays", condition=condition, share=say.percent(total.share), band=say.level(total.band))
    if not left.new_is_past:
        return f"{stays} {say('plan.by_lands')}"
    viscosity, loss = say.value(left.kinematic_viscosity * MM2_S, "viscosity", 2), say.percent(left.pump_loss, 0)
    new = say("plan.as_new", share=say.percent(left.new_share))
    return f"{stays} {new} {say('plan.not_lands', viscosity=viscosity, loss=loss)}"


def effect_table(effect: Sequence[RepairedAt], say: Wording) -> Table:
    """Return every condition with what the unit leaks and holds there, as measured and with the repairs."""

    def judged(kind: RuleKind, total: Total, words: str) -> Judged:
        rule = next((rule for rule in total.pressure_rules if rule.kind is kind), None)
        return Judged(words, rule.verdict if rule is not None and rule.verdict.flagged else None)

    def share(total: Total) -> Judged:
        return Judged(f"{_share(total, say)} {say.signed(total.band)}", total.band)

    def line(total: Total) -> Judged:
        held = say.quantity(total.pressures[LINE] * KPA, "pressure")
        return judged(RuleKind.PERMISSIBLE_PRESSURE, total, held)

    def reserve(total: Total) -> Judged:
        return judged(RuleKind.RESERVE, total, say.number(total.reserve, 2))

    def at_end(of: Callable[[Total], Judged], end: str, at: RepairedAt) -> Judged:
        return of(getattr(at, end))

    columns = [Column("condition", of=lambda at: say.condition(at.condition))]
    for name, of in (("share", share), ("line", line), ("reserve", reserve)):
        heading, then = say(f"repair_plan.column_{name}"), say(f"repair_plan.column_{name}_then")
        columns.append(Column(name, words=heading, of=partial(at_end, of, "before")))
        columns.append(Column(f"{name}_then", words=then, of=partial(at_end, of, "after")))
    if any(_worst_circuit(at.after) for at in effect):
        heading = say("repair_plan.column_worst_circuit")
        columns.append(Column("worst_circuit", words=heading, of=lambda at: _circuit(at, say)))
    return Table("effect", tuple(columns), effect, say)


def _share(total: Total, say: Wording, digits: int = 1) -> str:
    return say.percent(total.share, digits) if math.isfinite(total.share) else say("diagnosis.no_flow")


def _worst_circuit(total: Total) -> str | None:
    """Return the circuit whose pressure is farthest from that when new."""
    rules = [rule for rule in total.pressure_rules if rule.circuit is not None]
    worst = max(rules, key=lambda rule: rule.value, default=None)
    return worst.circuit.id if worst is not None and worst.circuit is not None else None


def _circuit(at: RepairedAt, say: Wording) -> str:
    worst = _worst_circuit(at.before)
    if worst is None:
        return "–"
    name = next(each.circuit.name for each in at.before.projection.circuits if each.circuit.id == worst)
    before, after = (say.quantity(total.pressures[worst] * KPA, "pressure") for total in (at.before, at.after))
    return say("repair_plan.circuit_holds", circuit=isolated(say.name(name)), before=before, after=after)


def offered_words(diagnosis: Diagnosis, each: OfferedRepair, say: Wording, *, short: bool = False) -> str:
    """Say one repair: the worst verdict, its lands, what is done, and what it brings alone where that is most.

    In ``short`` without the verdict and the condition.
    """
    first = each.lands[0]
    option = each.move.option
    others = kit_words(diagnosis.controller, option, say) or ", ".join(
        land_number(diagnosis.controller, land.key, say) for land in each.lands[1:]
    )
    lands = ", ".join(filter(None, (land_in_words(diagnosis, first.key, say), others)))
    work = say("repair_plan.as_new") if option is None else repair_name(option.repair, say)
    if short and all(map(diagnosis.can_wait, each.lands)):
        work = f"{work} ({say('repair_plan.can_wait')})"
    at = each.best_at
    alone = say("repair_plan.no_help")
    if at.saving > 0.0:
        before, after = (_share(end, say, 1 if short else 2) for end in (at.before, at.after))
        if short:
            return f"{lands}: {work} · {before} → {after}"
        alone = say("repair_plan.alone", before=before, after=after, condition=say.condition(at.condition))
    return f"{lands}: {work}" if short else f"{say.signed(first.verdict)} · {lands}: {work} ({alone})"
