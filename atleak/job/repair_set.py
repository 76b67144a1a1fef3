"""Relate a set of repairs that are ticked to the decisions of the job record, in both directions."""

from __future__ import annotations

from collections.abc import Collection

from atleak.catalogue.controller import Controller
from atleak.job.decisions import covered
from atleak.job.estimate import CARRIED_OUT, Chooser, decision_on, estimate, with_line
from atleak.job.record import Job, RepairDecision
from atleak.repair import Move, MoveKey, OfferedRepairs, choose


def decided_repairs(repairs: OfferedRepairs, job: Job) -> frozenset[MoveKey]:
    """Return the offered repairs that the record proposes, has approved or done."""
    carried_out = [each for each in job.repair_decisions if each.decision in CARRIED_OUT]
    controller = repairs.diagnosis.controller
    moves = [move for move in repairs.moves.all if any(_is_about(each, move, controller) for each in carried_out)]
    return frozenset(move.key for move in repairs.chosen([move.key for move in moves]))


def with_repairs(repairs: OfferedRepairs, job: Job, keys: Collection[MoveKey], chooser: Chooser = choose) -> Job:
    """Return the record with decisions that carry out the offered repairs of some keys, and no other offered repair.

    What was decided already stays as it is where it agrees: an approved repair stays approved, a declined one keeps its
    reason. A repair that is taken back is left open. Decisions about anything that is not offered are not touched.
    """
    chosen, controller = repairs.chosen(keys), repairs.diagnosis.controller
    decisions: list[RepairDecision] = []
    for each in job.repair_decisions:
        about = [move for move in repairs.moves.all if _is_about(each, move, controller)]
        wanted = any(move is other for move in about for other in chosen)
        if about and wanted != (each.decision in CARRIED_OUT):
            each = each.model_copy(update={"decision": "proposed" if wanted else None})
        decisions.append(each)
    known = [each for each in decisions if each.decision in CARRIED_OUT]
    missing = [move for move in chosen if not any(_is_about(each, move, controller) for each in known)]
    decisions += [decision_on(move) for move in missing]
    changed = job.model_copy(update={"repair_decisions": tuple(decisions)})
    while True:  # what the estimate would propose besides is left open too, until it proposes nothing more
        made = estimate(repairs.diagnosis, changed, chooser)
        besides = [line for line in made.lines if not line.own and line.carried_out]
        if not besides:
            return changed
        for line in besides:
            changed = with_line(changed, line, decision=None, price=None, hours=None)


def _is_about(decision: RepairDecision, move: Move, controller: Controller) -> bool:
    """Tell whether a decision is about an offered repair: it names it, or names none and covers its lands."""
    if decision.repair:
        return move.option is not None and move.option.repair.id == decision.repair
    return bool(move.treats) and move.treats <= covered(decision, controller)
