"""Say everything that is known of one component's lands: the pair that was opened in the valve body's picture."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from atleak.catalogue.section_pressures import Pressure
from atleak.diagnosis import Diagnosis
from atleak.land_diagnosis import LandDiagnosis
from atleak.rules import Rule
from atleak.verdicts import Verdict, worst
from atleak.views.condition_matrix import LandAtCondition, MatrixRow
from atleak.views.pair_table import clearance, decision, share_cell, why
from atleak.views.sentences import rule_name, rule_quantity, wear_words
from atleak.views.table import Column, Judged, Table
from atleak.wording import Wording, isolated
from atleak.workshop_units import KPA, MM, UM


@dataclass(frozen=True)
class OpenedLand:
    """One land in a reader's words."""

    land: LandDiagnosis
    why: tuple[str, ...]  # the verdict: what decided, what is missing, what contradicts itself
    facts: tuple[tuple[str, str], ...]  # what each is, and its value
    shares: Table  # at every condition
    rules: Table  # every limit that judges it
    does: tuple[str, ...]  # from where to where it leaks, and which complaints it can cause


def component_verdict(diagnosis: Diagnosis, component: str) -> Verdict:
    """Return the worst verdict of a component's lands; one that is open before one that is ok."""
    levels = [land.verdict for land in diagnosis.lands if land.key[0] == component]
    flagged = [level for level in levels if level.flagged]
    if flagged or all(level == Verdict.OK for level in levels):
        return worst(levels)
    return Verdict.NOT_MEASURED


def components_worst_first(diagnosis: Diagnosis) -> list[str]:
    """Return the components that have lands, those with flagged lands first, the worst of them leading."""
    first = [land.key[0] for land in diagnosis.flagged]
    others = [name for name in diagnosis.controller.components if diagnosis.controller.lands_of(name)]
    return list(dict.fromkeys([*first, *others]))


def opened_lands(diagnosis: Diagnosis, component: str, say: Wording) -> tuple[OpenedLand, ...]:
    """Return every land of a component, in its order along the spool."""
    return tuple(
        OpenedLand(
            land,
            _why(land, say),
            tuple(_facts(land, say)),
            _shares(diagnosis, land, say),
            _rules(land, say),
            tuple(_does(diagnosis, land, say)),
        )
        for land in diagnosis.lands
        if land.key[0] == component
    )


def _why(land: LandDiagnosis, say: Wording) -> tuple[str, ...]:
    said = tuple(why(land, say)) or (say("diagnosis.within_limits"),)
    return (say("diagnosis.nearest_limit", rule=said[0]), *said[1:]) if land.verdict == Verdict.OK else said


def _facts(land: LandDiagnosis, say: Wording) -> Iterator[tuple[str, str]]:
    state = land.state

    def micrometres(value: float | None) -> str:
        return "–" if value is None else say.quantity(value * UM, "clearance")

    def fact(name: str, value: str) -> tuple[str, str]:
        return say(f"diagnosis.{name}"), value

    if not state.measured:
        yield fact("clearance", say("diagnosis.taken_as_new", value=micrometres(state.radial_clearance)))
        return
    yield fact("clearance", clearance(land, say))
    low, high = state.land.mounting_range
    ends = [low] if low == high else [low, high]
    yield fact("when_new", say.span([end * UM for end in ends], "clearance"))
    yield fact("wear", wear_words(land, say))
    for part, ovality, taper in (
        ("spool", state.spool_ovality, state.spool_taper),
        ("sleeve", state.sleeve_ovality, state.sleeve_taper),
    ):
        if ovality is not None:
            yield fact(f"ovality_{part}", micrometres(ovality))
        if taper is not None:
            yield fact(f"taper_{part}", micrometres(taper))
    if state.worst_direction is not None:
        value = micrometres(state.max_clearance)
        yield fact("widest", say("diagnosis.widest_at", value=value, direction=say.plain(state.worst_direction)))
    sizes = (say.quantity(size * MM, "length") for size in (state.spool_diameter, state.sleeve_diameter))
    yield fact("diameters", " / ".join(sizes))
    if land.decision is not None:
        yield fact("decision", decision(land, say))


def _shares(diagnosis: Diagnosis, land: LandDiagnosis, say: Wording) -> Table:
    def limit(cell: LandAtCondition) -> str | None:
        return None if cell.rule is None else rule_quantity(cell.rule, cell.rule.limit, say)

    columns = (
        Column("condition", of=lambda cell: say.condition(cell.projection.condition)),
        Column("share_of_pump", of=lambda cell: share_cell(cell, say)),
        Column("limit", of=limit),
        Column("costs", of=lambda cell: say.quantity(cell.loss * KPA, "pressure") if cell.loss else None),
    )
    row = MatrixRow.of(land, diagnosis, diagnosis.presented)
    table = Table("shares", columns, row.cells, say)
    return table if any(cell.loss for cell in row.cells) else table.without("costs")


def _rules(land: LandDiagnosis, say: Wording) -> Table:
    worst_first = sorted(land.rules, key=lambda rule: (-rule.verdict.rank, -rule.severity))
    of_share = [rule for rule in worst_first if rule.condition is not None]
    kept = [rule for rule in worst_first if rule.condition is None or rule is of_share[0]]  # others stand with shares
    columns = (
        Column("rule", of=lambda rule: rule_name(rule, say)),
        Column("value", of=lambda rule: Judged(rule_quantity(rule, rule.value, say), rule.verdict)),
        Column("limits", of=lambda rule: "; ".join(_levels(rule, say))),
        Column("limit_is", of=lambda rule: say.get("origins", rule.origin)),
    )
    return Table("rules", columns, kept, say)


def _levels(rule: Rule, say: Wording) -> Iterator[str]:
    for level, limit in rule.steps.levels:
        yield say("rules.level", level=say.signed(level), limit=rule_quantity(rule, limit, say))


def _does(diagnosis: Diagnosis, land: LandDiagnosis, say: Wording) -> Iterator[str]:
    """Say from where to where the land leaks, and which complaints of the valve body's file that can cause."""
    controller = diagnosis.controller
    names = {each.id: isolated(say.name(each.name)) for each in controller.circuits}

    def written(pressure: Pressure) -> str:
        if pressure.section is None:
            return say.quantity(pressure.constant * KPA, "pressure") if pressure.constant else say("diagnosis.sump")
        name = names.get(pressure.section) or say.get("pressures", pressure.section)
        if pressure.coefficient == 1.0:
            return name
        return say("diagnosis.part_of", part=say.percent(pressure.coefficient, 0), pressure=name)

    for gap in controller.gaps:
        if gap.key == land.key:
            gears = ", ".join(map(str, sorted(gap.gears)))
            yield say("diagnosis.leaks_to", high=written(gap.high), low=written(gap.low), gears=gears)
    leaking = {each.condition.name for each in diagnosis.projections if each.leakage_of(land.key) > 0.0}
    for complaint in controller.complaints:
        if land.key in complaint.lands or (not complaint.lands and leaking & set(complaint.conditions)):
            yield say("diagnosis.can_cause", complaint=isolated(say.name(complaint.label)))
