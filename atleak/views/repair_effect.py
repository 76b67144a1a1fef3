"""Say what a set of repairs brings at every condition: share, pressure held and reserve, before and after."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from functools import partial

from atleak.catalogue.limits import RuleKind
from atleak.diagnosis import Diagnosis
from atleak.engine.line import LINE
from atleak.repair import MoveKey, OfferedRepair, OfferedRepairs, RepairedAt, Total
from atleak.views.land_names import land_number
from atleak.views.repair_options import repair_name
from atleak.views.sentences import land_in_words, rule_reached
from atleak.views.table import Column, Judged, Table
from atleak.wording import Wording, isolated
from atleak.workshop_units import KPA


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


def effect_sentences(
    repairs: OfferedRepairs,
    keys: Collection[MoveKey],
    effect: Sequence[RepairedAt],
    say: Wording,
) -> Iterator[str]:
    """Say whether everything is within its limits then, what stays past one, and which flagged lands are left."""
    past = [rule for at in effect for rule in at.after.past]
    chosen = repairs.chosen(keys)
    if past:
        yield say("repair_plan.stays", rules="; ".join(rule_reached(rule, say) for rule in past))
    else:
        one = len(chosen) == 1
        yield say("repair_plan.all_within_one") if one else say("repair_plan.all_within", count=len(chosen))
    mended = {key for move in chosen for key in move.lands}
    controller = repairs.diagnosis.controller
    left = [land_number(controller, land.key, say) for land in repairs.diagnosis.flagged if land.key not in mended]
    if left:
        yield say("repair_plan.flagged_left", lands=", ".join(left))


def offered_words(diagnosis: Diagnosis, each: OfferedRepair, say: Wording) -> str:
    """Say one repair: the worst verdict, its lands, what is done, and what it brings alone where that is most."""
    first = each.lands[0]
    others = ", ".join(land_number(diagnosis.controller, land.key, say) for land in each.lands[1:])
    lands = ", ".join(filter(None, (land_in_words(diagnosis, first.key, say), others)))
    option = each.move.option
    work = say("repair_plan.as_new") if option is None else repair_name(option.repair, say)
    at = each.best_at
    alone = say("repair_plan.no_help")
    if at.saving > 0.0:
        before, after = _share(at.before, say, 2), _share(at.after, say, 2)
        alone = say("repair_plan.alone", before=before, after=after, condition=say.condition(at.condition))
    return f"{say.signed(first.verdict)} · {lands}: {work} ({alone})"
