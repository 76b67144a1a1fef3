"""Relate what was decided about repairs to the lands of a unit: what a decision covers, and what is still open."""

from __future__ import annotations

from collections.abc import Iterator

from atleak.catalogue.controller import Controller
from atleak.diagnosis import Diagnosis
from atleak.errors import InputError, Place, unknown
from atleak.job.record import Job, RepairDecision
from atleak.land_diagnosis import LandDiagnosis
from atleak.rules import LandKey
from atleak.sentence import Name, Sentence


def check_decisions(job: Job, controller: Controller, file: str = "job record") -> None:
    """Check that every repair decision is about a component, a land and a repair that the valve body has.

    Raises
    ------
    InputError
        the first that is not, with its number, its value, and the nearest name.
    """
    fault = next(decision_faults(job, controller, file), None)
    if fault is not None:
        raise fault


def decision_faults(job: Job, controller: Controller, file: str = "job record") -> Iterator[InputError]:
    """Return what is wrong with each decision on a component, land or repair that the valve body does not have."""
    for number, decision in enumerate(job.repair_decisions, start=1):
        place = Place(file=file, table=f"repair_decisions {number}")
        if decision.component and decision.component not in controller.components:
            problem = Sentence("{controller} has no such component", controller=Name(controller.name))
            yield unknown(problem, decision.component, controller.components, place=place)
            continue
        lands = [land.key[1] for land in controller.lands_of(decision.component)] if decision.component else []
        if decision.land is not None and decision.land not in lands:
            problem = Sentence("a decision without a component has no such land")
            if decision.component:
                problem = Sentence("component {component} has no such land", component=decision.component)
            expected = Sentence("the component that it belongs to")
            if lands:
                expected = Sentence("one of its lands: {lands}", lands=lands)
            yield InputError(problem, place=place, value=decision.land, expected=expected)
        repairs = {repair.id: repair for repair in controller.repairs}
        if decision.repair and decision.repair not in repairs:
            problem = Sentence("{controller} names no such repair", controller=Name(controller.name))
            yield unknown(problem, decision.repair, repairs, place=place)
        elif decision.repair and decision.component not in ("", repairs[decision.repair].component):
            of = {"repair": decision.repair, "component": decision.component}
            problem = Sentence("repair {repair} is none of component {component}", **of)
            expected = Sentence("component {component}", component=repairs[decision.repair].component)
            yield InputError(problem, place=place, expected=expected)


def covered(decision: RepairDecision, controller: Controller) -> frozenset[LandKey]:
    """Return the lands that a decision is about: those that its repair changes, its land, or all of its component."""
    repair = next((each for each in controller.repairs if each.id == decision.repair), None)
    if repair is not None:
        return frozenset((repair.component, land) for land in repair.lands)
    lands = controller.lands_of(decision.component) if decision.component in controller.components else ()
    return frozenset(land.key for land in lands if decision.land in (None, land.key[1]))


def repaired_lands(job: Job, controller: Controller) -> frozenset[LandKey]:
    """Return the lands that were repaired, by the record; one that was only cleaned keeps its wear."""
    cleaned = {repair.id for repair in controller.repairs if repair.keeps_clearance}
    done = (each for each in job.repair_decisions if each.decision == "done" and each.repair not in cleaned)
    return frozenset[LandKey]().union(*(covered(each, controller) for each in done))


def undecided(diagnosis: Diagnosis, job: Job, *, closing: bool = False) -> tuple[LandDiagnosis, ...]:
    """Return the lands to be replaced about which nothing was decided, the worst first.

    Parameters
    ----------
    closing
        the job is handed over: a repair that is only proposed is then open too.
    """
    settled = {"approved", "done", "declined", "deferred", *(() if closing else ("proposed",))}
    decided: set[LandKey] = set()
    for decision in job.repair_decisions:
        if decision.decision in settled:
            decided |= covered(decision, diagnosis.controller)
    return tuple(land for land in diagnosis.flagged if land.verdict.calls_for_repair and land.key not in decided)


def without_reason(job: Job) -> tuple[RepairDecision, ...]:
    """Return the repairs that were declined without a reason being written down."""
    return tuple(each for each in job.repair_decisions if each.decision == "declined" and not each.reason)
