"""Say what is known of lands: what each leaks at every condition, the table of lands, and the pair that is opened.

Terminal, page, PDF and workbook show the columns of `pair_table` that they have room for: a new one stands there alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

from atleak.catalogue.circuits import Pressure
from atleak.catalogue.limits import RuleKind
from atleak.common.sentences import Name, Sentence
from atleak.common.units import DM3_MIN, KPA, MM, PERCENT, UM, gear_name
from atleak.common.verdicts import Verdict, worst
from atleak.common.wording import Wording, isolated
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.rules import Rule
from atleak.engine.projection import Projection
from atleak.report.tables.names import has_number, land_number
from atleak.report.tables.sentences import (
    consequence_words,
    decision_words,
    land_in_words,
    rule_name,
    rule_quantity,
    rule_reached,
    wear_words,
)
from atleak.report.tables.table import VERDICT, Column, Judged, Table, span

ANOTHER_CIRCUIT = Sentence("another circuit")


@dataclass(frozen=True)
class LandAtCondition:
    """What one land leaks at one condition, and what its share of the pump's flow is judged to be there."""

    projection: Projection
    leakage: float  # [m³/s] through every gap of the land
    drawn_from_pump: float  # [m³/s] the part of it that counts in the total
    share: float  # drawn from the pump / pump capacity: the shares of all lands, and what leaks beside them, add up
    rule: Rule | None  # of the land's share there; None where nothing was measured or no such limit is set
    verdict: Verdict | None  # of that share alone; None where no such limit is set
    loss: float | None  # [Pa] that it costs the circuit that loses most by it; None where no pressure is solved
    #: sections into which it leaks without drawing from the pump; None for one that the valve body's file does not name
    circuits: tuple[str | None, ...]

    @property
    def elsewhere(self) -> Sentence:
        """Say into which circuits it leaks without drawing from the pump; an empty text where it does not."""
        return elsewhere(self.circuits)


@dataclass(frozen=True)
class MatrixRow:
    """One land at every condition."""

    land: LandDiagnosis
    cells: tuple[LandAtCondition, ...]

    @classmethod
    def of(cls, land: LandDiagnosis, diagnosis: Diagnosis, projections: Iterable[Projection]) -> MatrixRow:
        """Return one land at some of the conditions of its diagnosis."""
        return cls(land, tuple(land_at(land, diagnosis, projection) for projection in projections))

    @property
    def leaks(self) -> bool:
        """Tell whether the land leaks at any condition."""
        return any(cell.leakage > 0.0 for cell in self.cells)

    @property
    def worst(self) -> LandAtCondition:
        """Return the condition at which the land's share is judged worst; of several, where it is largest."""
        return max(self.cells, key=lambda cell: (-1 if cell.verdict is None else cell.verdict.rank, cell.share))

    @property
    def circuits(self) -> tuple[str | None, ...]:
        """Return the sections into which it leaks at any condition without drawing from the pump."""
        return tuple(dict.fromkeys(circuit for cell in self.cells for circuit in cell.circuits))

    @property
    def elsewhere(self) -> Sentence:
        """Say into which circuits it leaks at any condition without drawing from the pump; empty where it does not."""
        return elsewhere(self.circuits)


def elsewhere(circuits: Iterable[str | None]) -> Sentence:
    """Say that a land leaks into live circuits.

    >>> elsewhere(["p_m"])
    'leaks into p_m, not drawn from the pump'
    >>> elsewhere([])
    ''
    """
    names = [Name(circuit) if circuit else ANOTHER_CIRCUIT for circuit in circuits]
    if not names:
        return Sentence("")
    said: Sentence | Name = names[0]
    for name in names[1:]:
        said = Sentence("{first} and {second}", first=said, second=name)
    return Sentence("leaks into {circuits}, not drawn from the pump", circuits=said)


def condition_matrix(diagnosis: Diagnosis, projections: Sequence[Projection] | None = None) -> tuple[MatrixRow, ...]:
    """Return every land at every condition, or at those given in their order; lands in the controller's order."""
    at = diagnosis.projections if projections is None else projections
    return tuple(MatrixRow.of(land, diagnosis, at) for land in diagnosis.lands)


def leaking_worst_first(diagnosis: Diagnosis, projections: Sequence[Projection] | None = None) -> tuple[MatrixRow, ...]:
    """Return the lands that leak at any of the conditions: the worst verdict first, then the largest share anywhere."""
    rows = [row for row in condition_matrix(diagnosis, projections) if row.leaks or row.land.verdict.flagged]
    return tuple(sorted(rows, key=lambda row: (-row.land.verdict.rank, -_largest(row))))


def land_at(land: LandDiagnosis, diagnosis: Diagnosis, projection: Projection) -> LandAtCondition:
    """Return what one land leaks at one of the conditions of its diagnosis."""
    shares = (rule for rule in land.rules if rule.kind is RuleKind.PAIR_SHARE)
    rule = next((rule for rule in shares if rule.condition == projection.condition), None)
    aside = [gap.gap for gap in projection.gaps_of(land.key) if gap.leakage > 0.0 and not gap.drawn_from_pump]
    return LandAtCondition(
        projection=projection,
        leakage=projection.leakage_of(land.key),
        drawn_from_pump=projection.drawn_by(land.key),
        share=projection.share_drawn_by(land.key),
        rule=rule,
        loss=diagnosis.loss_by(land, projection),
        verdict=_verdict(land, rule),
        circuits=tuple(dict.fromkeys(gap.low.section for gap in aside)),
    )


def _verdict(land: LandDiagnosis, rule: Rule | None) -> Verdict | None:
    """Return the verdict of a land's share; half a measurement can pass a limit, but never be called ok."""
    if rule is None:
        return None if land.state.judged else Verdict.NOT_MEASURED
    return rule.verdict if land.state.can_be_ok or rule.verdict.flagged else Verdict.NOT_MEASURED


def _largest(row: MatrixRow) -> float:
    return max((cell.share for cell in row.cells if math.isfinite(cell.share)), default=0.0)


def pair_table(
    diagnosis: Diagnosis,
    lands: Sequence[LandDiagnosis],
    say: Wording,
    *,
    at: Sequence[Projection] | None = None,
) -> Table:
    """Return lands as a table with all that is said of each; a medium leaves out what it has no room for.

    Shares are those ``at`` some conditions, unless given those that every report must show.
    """

    def share_at(projection: Projection, land: LandDiagnosis) -> Judged:
        return share_cell(land_at(land, diagnosis, projection), say)

    def mounting(land: LandDiagnosis) -> str:
        return span((end * UM for end in land.state.land.mounting_ends), "clearance", say)

    def interval(land: LandDiagnosis) -> str | None:
        known = land.uncertainty.leakage_interval if land.uncertainty and land.leakage > 0.0 else None
        return None if known is None else span((end * DM3_MIN for end in known), "leak", say, 3)

    def largest(land: LandDiagnosis) -> float | None:
        worst = MatrixRow.of(land, diagnosis, diagnosis.projections).worst
        return None if worst.drawn_from_pump == 0.0 else worst.share

    def decided(land: LandDiagnosis) -> str | None:
        return land.shown_as and decision_words(land.shown_as, land.probability_over_limit, say)

    at = diagnosis.reported if at is None else at
    shares = (
        Column(
            f"share_at_{each.condition.name}",
            words=say("diagnosis.column_share", condition=say.condition(each.condition)),
            of=partial(share_at, each),
        )
        for each in at
    )
    columns = (
        Column("verdict", VERDICT),
        Column("pair", width=150, of=lambda land: land_in_words(diagnosis, land.key, say)),
        Column("land", of=lambda land: str(land.key[1])),
        *shares,
        Column("sleeve", "length", 4, of=lambda land: land.state.sleeve_diameter, times=MM),
        Column("spool", "length", 4, of=lambda land: land.state.spool_diameter, times=MM),
        Column("clearance", words_of="clearance", of=lambda land: with_half_interval(land, say)),
        Column("mounting", words_of="clearance", of=mounting),
        Column("wear", words_of="percent", of=lambda land: wear_words(land, say, unit=False)),
        Column("effective", "clearance", 1, of="effective_clearance", times=UM),
        Column("leakage", "leak", 3, times=DM3_MIN),
        Column("interval", words_of="leak", of=interval),
        Column("share", "percent", 2, times=PERCENT),
        Column("share_largest", "percent", 2, of=largest, times=PERCENT),
        Column("consequence", width=150, of=lambda land: consequence_words(diagnosis, land, say)),
        Column("decided_by", of=lambda land: "; ".join(why(land, say)) or None),
        Column("decision", width=100, of=decided),
    )
    return Table("lands", columns, lands, say)


ON_PAPER = ("land", "sleeve", "spool", "mounting", "effective", "leakage", "interval", "share", "share_largest")


CONDITION_WIDTH = 104  # pixels of a condition: two of them stand beside the pair on a phone


def matrix_table(diagnosis: Diagnosis, rows: Sequence[MatrixRow], say: Wording) -> Table:
    """Return the share of every land at every condition that is presented, each in the colour of its own verdict."""

    def share(number: int, row: MatrixRow) -> Judged:
        cell = row.cells[number]
        if cell.leakage == 0.0:
            return Judged(None)
        return Judged(cell.share * PERCENT if math.isfinite(cell.share) else say("diagnosis.no_flow"), cell.verdict)

    names = [say.condition(each.condition) for each in diagnosis.presented]
    shares = (
        Column(
            each.condition.name, "percent", 2, CONDITION_WIDTH, name, of=partial(share, number),
            note=say("diagnosis.matrix_help", condition=name),
        )
        for number, (each, name) in enumerate(zip(diagnosis.presented, names, strict=True))
    )  # fmt: skip
    columns = (
        Column("pair", width=250, of=lambda row: land_in_words(diagnosis, row.land.key, say)),
        *shares,
        Column(
            "elsewhere", width=300, words=say("diagnosis.matrix_elsewhere"),
            of=lambda row: say.sentence(row.elsewhere) or None,
        ),
    )  # fmt: skip
    return Table("matrix", columns, rows, say)


def share_cell(cell: LandAtCondition, say: Wording, *, unit: bool = True) -> Judged:
    """Return a share at one condition in the colour of its own verdict, with % or without; nothing where none leaks."""
    if cell.leakage == 0.0:
        return Judged(None)
    if not math.isfinite(cell.share):
        return Judged(say("diagnosis.no_flow"), cell.verdict)
    return Judged(say.percent(cell.share, 2) if unit else say.number(cell.share * PERCENT, 2), cell.verdict)


def clearance(land: LandDiagnosis, say: Wording) -> str:
    """Return the radial clearance with its 95 % interval; without one where nothing was measured."""
    value = say.quantity(land.state.radial_clearance * UM, "clearance")
    interval = land.uncertainty.clearance_interval if land.uncertainty else None
    if interval is None:
        return value
    low, high = (say.spelled(end * UM, "clearance") for end in interval)
    return say("diagnosis.between", value=value, low=low, high=high)


def with_half_interval(land: LandDiagnosis, say: Wording) -> str:
    """Return the radial clearance in the reader's unit, with half its 95 % interval where known: ``57.4 ± 5.4``."""
    value = say.value(land.state.radial_clearance * UM, "clearance", 1)
    low, high = (land.uncertainty and land.uncertainty.clearance_interval) or (0.0, 0.0)
    return f"{value} ± {say.value((high - low) / 2.0 * UM, 'clearance', 1)}" if high > low else value


def why(land: LandDiagnosis, say: Wording) -> Iterable[str]:
    """Say which rule gave the verdict, which part was not measured, and what contradicts itself."""
    rule = None if land.verdict == Verdict.NOT_MEASURED else land.deciding
    if rule is not None:
        yield rule_reached(rule, say)
    if land.state.status == "spool_only":
        yield say("diagnosis.sleeve_unmeasured")
    elif land.state.status == "sleeve_only":
        yield say("diagnosis.spool_unmeasured")
    yield from _doubts(land, say)


def _doubts(land: LandDiagnosis, say: Wording) -> Iterable[str]:
    """Say what in a land's readings contradicts itself, and what was made of it."""
    for doubt in land.state.doubts:
        first = doubt.repeats[0]
        values = ", ".join(say.quantity(each.diameter * MM, "length", 4) for each in doubt.repeats)
        yield say(
            "diagnosis.slip_left_out" if doubt.agreed else "diagnosis.repeats_apart",
            part=say(f"diagnosis.{first.part}"),
            plane=first.plane,
            apart=say.quantity(doubt.apart * UM, "clearance"),
            values=values,
        )
    if land.state.contradicted:
        yield say("diagnosis.vacuum_contradicts")
    if land.suspect:
        yield say("diagnosis.tighter_than_new")


def decision(land: LandDiagnosis, say: Wording) -> str:
    """Say how sure the verdict is, and how likely the true value is past the limit."""
    words, chance = say.get("decisions", str(land.shown_as)), land.probability_over_limit
    return words if chance is None else say("diagnosis.chance", decision=words, chance=say.percent(chance, 0))


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
    """Return the worst verdict of a component's lands; one that is open, or in doubt, before one that is ok."""
    lands = [land for land in diagnosis.lands if land.key[0] == component]
    levels = [Verdict.NOT_MEASURED if land.in_doubt and not land.verdict.flagged else land.verdict for land in lands]
    flagged = [level for level in levels if level.flagged]
    if flagged or all(level == Verdict.OK for level in levels):
        return worst(levels)
    return Verdict.NOT_MEASURED


def leader(diagnosis: Diagnosis, land: LandDiagnosis, say: Wording) -> str:
    """Say how wide a land is and was: ``25/1: 57 µm, was 34``, or ``Land 3: …`` where components have no numbers."""
    numbered = has_number(diagnosis.controller, land.key[0])
    now, new = land.state.radial_clearance * UM, [end * UM for end in land.state.land.mounting_ends]
    return say(
        "diagnosis.leader",
        land=land_number(diagnosis.controller, land.key, say) if numbered else say("diagnosis.land", land=land.key[1]),
        now=say.quantity(now, "clearance", 0),
        new=span(new, "clearance", say, 0),
    )


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
            gears = ", ".join(map(gear_name, sorted(gap.gears)))
            yield say("diagnosis.leaks_to", high=written(gap.high), low=written(gap.low), gears=gears)
    leaking = {each.condition.name for each in diagnosis.projections if each.leakage_of(land.key) > 0.0}
    for complaint in controller.complaints:
        if land.key in complaint.lands or (not complaint.lands and leaking & set(complaint.conditions)):
            yield say("diagnosis.can_cause", complaint=isolated(say.name(complaint.label)))
