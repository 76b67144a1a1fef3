"""Say what a complaint has to do with what was found, which lands to measure first, and which valves are worn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from atleak.analysis.pressures import HeldPressure, PressuresAt, drawing_more, pressures_at
from atleak.analysis.repair.plan import RepairPlan
from atleak.catalogue.limits import RuleKind
from atleak.catalogue.repairs import Complaint, LandKey
from atleak.common.units import KPA
from atleak.common.verdicts import Verdict, worst
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.rules import Rule
from atleak.engine.projection import Projection
from atleak.report.tables.sentences import because_of, unsolved

_SHOWN = 0.5e3  # [Pa] from which a loss is no zero where pressures are printed in kPa


class Doubt(StrEnum):
    """What is open about a land."""

    NOT_MEASURED = "not_measured"
    HALF_MEASURED = "half_measured"  # on the spool or the sleeve only


@dataclass(frozen=True)
class MeasureFirst:
    """A land that can explain a complaint and is not measured yet, or on one part only."""

    land: LandDiagnosis
    projection: Projection  # the one of the complaint's at which the land carries most
    part: float  # of all that leaks there, whether or not it is drawn from the pump

    @property
    def doubt(self) -> Doubt:
        """Return what is open about the land."""
        return Doubt.HALF_MEASURED if self.land.state.measured else Doubt.NOT_MEASURED


@dataclass(frozen=True)
class Explanation:
    """A pressure lost, or a reserve short, where a complaint shows, and the lands because of which it is."""

    rule: Rule  # that judges it
    held: HeldPressure | None  # None: the pump's reserve
    lands: tuple[LandKey, ...]  # the costliest first


def explanations(diagnosis: Diagnosis, complaint: Complaint) -> tuple[Explanation, ...]:
    """Return what of a complaint the lands explain, pressures before the reserve, the worst first; none where nothing.

    A pressure that the same unit would lack with every land new, too, is none.
    """
    found = []
    for projection in diagnosis.complained_of(complaint) if diagnosis.judged else ():
        at = pressures_at(diagnosis, projection)
        for rule in at.rules:
            held = next((each for each in at.applied if each.rule is rule), None)
            keys = _because_of(diagnosis, at, rule, held) if rule.verdict.flagged else ()
            named = tuple(key for key in keys if not complaint.lands or key in complaint.lands)
            if named:
                found.append(Explanation(rule, held, named))
    return tuple(sorted(found, key=lambda each: (each.held is None, -each.rule.verdict.rank, -each.rule.severity)))


def _because_of(diagnosis: Diagnosis, at: PressuresAt, rule: Rule, held: HeldPressure | None) -> tuple[LandKey, ...]:
    if rule.kind is RuleKind.RESERVE:
        falls = at.projection.reserve < 1.0 <= at.reserve_new  # a reserve that is only small is felt nowhere
        return drawing_more(diagnosis, at.projection) if falls else ()
    if held is None or held.loss <= 0.0 or (held.low is not None and held.new < held.low):
        return ()
    return tuple(key for key, _ in held.costly)


def most_lost(diagnosis: Diagnosis) -> HeldPressure | None:
    """Return the pressure that lost most against new where the complaint shows; None where none lost a kilopascal."""
    every = (each for projection in diagnosis.complained for each in pressures_at(diagnosis, projection).applied)
    return max((each for each in every if each.loss >= _SHOWN), key=lambda each: each.loss, default=None)


def finding(diagnosis: Diagnosis, say: Wording) -> str:
    """Say what the complaint of a diagnosis has to do with what was found, and what the list of lands behind it is."""
    if diagnosis.complaint is None or not diagnosis.complained:
        return ""
    said = []
    if diagnosis.judged:
        explained = explanations(diagnosis, diagnosis.complaint)
        said += [say("complaint.linked", because=because_of(diagnosis, each.rule, say)) for each in explained[:1]]
        said += [] if explained else _unexplained(diagnosis, say)
    ranked = measure_first(diagnosis)
    return " ".join([*said, say("complaint.first" if ranked else "complaint.all_measured")])


def _unexplained(diagnosis: Diagnosis, say: Wording) -> list[str]:
    only_line = unsolved(diagnosis, say)
    if diagnosis.profile.circuits != "on":  # what leaks has an effect on no pressure, as none is solved
        return [only_line or ""]
    lost = most_lost(diagnosis)
    if lost is None:
        effect = say("complaint.no_effect")
    else:
        name = say.name(lost.circuit.name) if lost.circuit else say("held.line")
        effect = say("complaint.small_effect", loss=say.value(lost.loss * KPA, "pressure", 0), circuit=name)
    return [effect, *([only_line] if only_line else []), say("complaint.elsewhere")]


def reason(each: MeasureFirst, say: Wording) -> str:
    """Say what is open about a land and how much it carries."""
    carried = say("complaint.carried", part=say.percent(each.part), condition=say.condition(each.projection.condition))
    return say(f"complaint.{each.doubt}", carried=carried)


MEASURE_FIRST = 6  # lands that a report names: choice of this project


def measure_first(diagnosis: Diagnosis) -> tuple[MeasureFirst, ...]:
    """Return the lands that can explain the complaint of a diagnosis and are not measured yet on both parts.

    They are in the order of how much of the leakage they carry at one of the complaint's conditions. None without a
    complaint.
    """
    complaint, at = diagnosis.complaint, diagnosis.complained
    if complaint is None or not at:
        return ()
    named = [_at_most(land, at) for land in diagnosis.unmeasured if not complaint.lands or land.key in complaint.lands]
    kept = [each for each in named if complaint.lands or each.part > 0.0]
    return tuple(sorted(kept, key=lambda each: -each.part))


def _at_most(land: LandDiagnosis, projections: Sequence[Projection]) -> MeasureFirst:
    parts = []
    for projection in projections:
        everything = sum(gap.leakage for gap in projection.gaps)
        parts.append(projection.leakage_of(land.key) / everything if everything > 0.0 else 0.0)
    most = max(range(len(parts)), key=parts.__getitem__)
    return MeasureFirst(land, projections[most], parts[most])


@dataclass(frozen=True)
class WornValve:
    """One component with lands past a limit, and what follows from them."""

    component: str
    lands: tuple[LandDiagnosis, ...]  # past a limit, the worst first
    urgency: Verdict  # the worst of its lands', each to watch where its wear does nothing now

    @property
    def verdict(self) -> Verdict:
        """Return the worst verdict of its lands."""
        return self.lands[0].verdict


def worn_valves(diagnosis: Diagnosis, plan: RepairPlan) -> tuple[WornValve, ...]:
    """Return every valve with lands past a limit: the most urgent first, of equal ones as the plan has them."""
    planned = [land.key[0] for step in plan.steps for land in (step.land, *step.together)]
    turn = {component: number for number, component in reversed([*enumerate(planned)])}
    by_component: dict[str, list[LandDiagnosis]] = {}
    for land in diagnosis.flagged:
        by_component.setdefault(land.key[0], []).append(land)

    def valve(component: str, flagged: list[LandDiagnosis]) -> WornValve:
        lands = tuple(sorted(flagged, key=lambda land: -land.verdict.rank))
        return WornValve(component, lands, worst(map(diagnosis.urgency_of, lands)))

    valves = map(valve, by_component, by_component.values())

    def order(valve: WornValve) -> tuple[int, int, int]:
        return -valve.urgency.rank, -valve.verdict.rank, turn.get(valve.component, len(planned))

    return tuple(sorted(valves, key=order))
