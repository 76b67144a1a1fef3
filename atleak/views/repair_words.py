"""Say in plain words what a repair brings and where the plan ends."""

from __future__ import annotations

import math

from atleak.repair import Remainder, RepairedAt, RepairPlan, RepairStep
from atleak.wording import signed
from atleak.workshop_units import MM2_S, PERCENT


def step_helps(step: RepairStep) -> str:
    """Say at which condition a repair helps most and what it brings there, or why it brings nothing."""
    return change(step.at) if step.helps else no_help(step)


def no_help(step: RepairStep) -> str:
    """Say why a land that lowers no total is on the list."""
    why = "it draws no more from the pump than a new one" if step.leaks else "no operating point lets it leak"
    return f"for its own verdict: {why}"


def change(at: RepairedAt) -> str:
    """Say what a repair changes at one condition: ``total share at hot idle 23.6 → 18.9 % (▲ amber)``."""
    before, after = at.before.share * PERCENT, at.after.share * PERCENT
    return f"total share at {at.condition.label} {before:.1f} → {after:.1f} % ({signed(at.after.band)})"


def plan_ends(plan: RepairPlan) -> list[str]:
    """Say where the plan ends, one sentence each: green everywhere, or what remains and what that may be up to."""
    said = []
    if plan.for_total == 1:
        said.append("The last land is within its own limits: the total asks for it.")
    elif plan.for_total:
        said.append(f"The last {plan.for_total} lands are within their own limits: the total asks for them.")
    if plan.reached:
        said.append("The plan ends green at every condition." if plan.steps else "Every total is green as it is.")
    said += [_remains(left) for left in plan.remaining]
    if plan.unmeasured:
        lands = "lands were" if plan.unmeasured > 1 else "land was"
        said.append(f"{plan.unmeasured} {lands} not measured on both parts: what is missing is taken as new.")
    return said


def _remains(left: Remainder) -> str:
    label = left.total.condition.label
    if not math.isfinite(left.total.share):
        return f"At {label} the pump delivers nothing: that is not up to the lands."
    stays = f"At {label} the total stays at {left.total.share * PERCENT:.1f} % ({signed(left.total.band)})"
    if not left.new_is_past:
        return f"{stays}: no measured land can bring it back to green."
    return (
        f"{stays}, and a unit with every land new is at {left.new_share * PERCENT:.1f} %: the rest is not up to the "
        f"lands but to the limit, the fluid ({left.kinematic_viscosity * MM2_S:.2f} mm²/s there) or the pump, which "
        f"loses {left.pump_loss * PERCENT:.0f} % of what it displaces."
    )
