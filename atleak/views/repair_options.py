"""Rows of the repairs that a valve body's file names for a plan's steps, in a reader's language, and as a record."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from atleak.catalogue.entries import Evidence
from atleak.catalogue.repairs import Repair
from atleak.repair import Cost, Option, RepairPlan, RepairStep
from atleak.rules import LandKey
from atleak.views.condition_record import named, of_land, scaled
from atleak.views.table import span
from atleak.wording import Wording
from atleak.workshop_units import MM, UM


@dataclass(frozen=True)
class OptionRow:
    """One repair that the file names for the land of one step; the number counts the steps from 1."""

    number: int
    step: RepairStep
    option: Option

    @property
    def chosen(self) -> bool:
        """Tell whether the plan computes with it."""
        return self.step.chosen is self.option

    @property
    def lands(self) -> str:
        """Name the lands that it changes."""
        return ", ".join(f"{component}/{land}" for component, land in self.option.lands)

    @property
    def representative(self) -> bool:
        """Tell whether price, hours and clearance are those of such repairs in general."""
        return self.option.repair.evidence is Evidence.REPRESENTATIVE

    def name(self, say: Wording) -> str:
        """Name it with its part number, and say where it is representative."""
        label = repair_name(self.option.repair, say)
        return f"{label} ({say('plan.representative')})" if self.representative else label

    @property
    def left(self) -> list[float]:
        """Return the radial clearance that it leaves of the step's land [µm], or the ends of a range."""
        state = self.option.states[self.step.land.key]
        ends = (state.radial_clearance,) if self.option.repair.keeps_clearance else state.land.mounting_ends
        return [end * UM for end in ends]

    def leaves(self, say: Wording) -> str:
        """Return what it leaves in the reader's unit, without it: a number, or the ends of a range."""
        return span(self.left, "clearance", say)

    def price(self, say: Wording) -> str:
        """Return the price with its currency; a dash where the file states none."""
        repair = self.option.repair
        return "–" if repair.price is None else f"{say.number(repair.price, 2)} {repair.currency}"

    def hours(self, say: Wording) -> str:
        """Return the hours of work; a dash where the file states none."""
        return say.number(self.option.repair.hours, 1)

    def use(self, say: Wording) -> str:
        """Say whether it is the one that is planned, and where it does not mend the land."""
        said = [
            say("plan.chosen") if self.chosen else "",
            "" if self.option.mends(self.step.land.key) else say("plan.mends_not"),
        ]
        return ", ".join(filter(None, said))


def repair_name(repair: Repair, say: Wording) -> str:
    """Return the name of a repair with its part number."""
    name = say.name(repair.name)
    return f"{name} ({repair.part_number})" if repair.part_number else name


def option_rows(plan: RepairPlan) -> list[OptionRow]:
    """Return every option of every step of a plan, those of the file's order, the planned one first."""
    return [
        OptionRow(number, step, option)
        for number, step in enumerate(plan.steps, start=1)
        for option in sorted(step.options, key=lambda option: option is not step.chosen)
    ]


def planned(row: OptionRow, say: Wording) -> str:
    """Say one option in a line: what it is, what it leaves, and what it costs."""
    hours = row.option.repair.hours
    said = [
        row.name(say),
        say("plan.leaves", clearance=say.span(row.left, "clearance", 1)),
        "" if row.option.repair.price is None else row.price(say),
        "" if hours is None else say("plan.hours", hours=row.hours(say)),
        row.option.repair.tool or "",
        say("plan.together", lands=row.lands) if len(row.option.lands) > 1 else "",
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


def option_record(option: Option, key: LandKey) -> dict[str, Any]:
    """Return an option as plain values: what it is, what it costs, and what it leaves of a land."""
    repair, land = option.repair, option.states[key].land
    return {
        **named(repair, "id", "kind", "name", "part_number", "price", "currency", "hours", "tool"),
        "lands": [of_land(changed) for changed in option.lands],
        "nominal_diameter_mm": land.nominal_diameter * MM,
        "clearance_after_um": option.states[key].radial_clearance * UM,
        "mounting_clearance_low_um": None if repair.keeps_clearance else land.mounting_range[0] * UM,
        "mounting_clearance_um": None if repair.keeps_clearance else land.mounting_high * UM,
        "mounting_tolerance_um": None if repair.keeps_clearance else scaled(land.mounting_tolerance, UM),
        "mends": option.mends(key),
        **named(repair, "evidence", "source"),
    }


def cost_record(cost: Cost | None) -> dict[str, Any] | None:
    """Return what a plan costs as plain values; None where the file names no repair for any of its steps."""
    if cost is None:
        return None
    return {
        "prices": [{"price": price, "currency": currency} for currency, price in cost.prices.items()],
        **named(cost, "hours", "repairs", "without_price", "without_hours", "without_option"),
    }
