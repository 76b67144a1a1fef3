"""Say in a reader's language what a repair brings and where the plan ends."""

from __future__ import annotations

import math
from collections.abc import Iterator

from atleak.repair import Basis, Remainder, RepairPlan, RepairStep
from atleak.views.repair_options import costs
from atleak.wording import Wording
from atleak.workshop_units import MM2_S


def no_help(step: RepairStep, say: Wording) -> str:
    """Say why a land that lowers no total is on the list."""
    return say("plan.draws_no_more" if step.leaks else "plan.never_leaks")


def plan_ends(plan: RepairPlan, say: Wording) -> Iterator[str]:
    """Say where the plan ends: green everywhere, or what remains and what that may be up to."""
    if not plan.judged:
        yield say("plan.not_judged")
        return
    if plan.pump_first:
        yield say("pump.planned_first")
    if plan.for_total:
        yield say("plan.for_total", count=plan.for_total)
    if plan.reached:
        yield say("plan.green" if plan.steps else "plan.green_already")
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
    viscosity, loss = say.number(left.kinematic_viscosity * MM2_S, 2), say.percent(left.pump_loss, 0)
    new = say("plan.as_new", share=say.percent(left.new_share))
    return f"{stays} {new} {say('plan.not_lands', viscosity=viscosity, loss=loss)}"
