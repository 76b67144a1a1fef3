"""Gather the valves that have reached a limit: where their oil goes, what that can be felt as, what a repair brings."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from atleak.analysis.pressures import HeldPressure, lowest_first, pressures_at
from atleak.analysis.repair.choice import Choice
from atleak.analysis.repair.totals import RepairedAt
from atleak.catalogue.controller import Gap
from atleak.catalogue.limits import RuleKind
from atleak.catalogue.repairs import Complaint, LandKey
from atleak.common.verdicts import Verdict
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.rules import Rule
from atleak.engine.operation import LINE, WORTH_NAMING
from atleak.engine.projection import Projection
from atleak.report.tables.complaint import explanations


class End(Enum):
    """Where oil leaks to that is no section with a name."""

    SUMP = "sump"
    FIXED_PRESSURE = "fixed_pressure"
    ANOTHER_SECTION = "another_section"  # which the valve body's file does not name


Path = tuple[str, str | End]  # section from which, and section or other end into which oil leaks


@dataclass(frozen=True)
class WornValve:
    """One component with lands past a limit, and what follows from them."""

    component: str
    lands: tuple[LandDiagnosis, ...]  # past a limit, the worst first
    paths: tuple[Path, ...]  # on which these lands leak, as the valve body's file describes them
    complaints: tuple[Complaint, ...]  # of the file that a pressure explains which they cost
    costs: tuple[tuple[HeldPressure, float], ...]  # pressures past a limit, and what they cost them [Pa]
    alone: tuple[RepairedAt, ...]  # what repairing them alone brings at every condition; none where nothing is chosen

    @property
    def verdict(self) -> Verdict:
        """Return the worst verdict of its lands."""
        return self.lands[0].verdict

    @property
    def helped(self) -> tuple[RepairedAt, Rule | None] | None:
        """Return the condition that repairing it alone helps most, and the rule there of the pressure that it helps.

        A pressure past its limit comes before the share of the pump's flow, for which there is no rule beside; None
        where neither is helped.
        """
        pressures = [
            (each, after)
            for each in self.alone
            for before, after in zip(each.before.pressure_rules, each.after.pressure_rules, strict=True)
            if before.verdict.flagged and before.kind is not RuleKind.RESERVE and _gained(each, after) >= WORTH_NAMING
        ]
        if pressures:
            return max(pressures, key=lambda each: _gained(*each))
        most = max(self.alone, key=lambda each: each.saving, default=None)
        return None if most is None or most.saving <= 0.0 else (most, None)

    def brings(self, projection: Projection) -> RepairedAt | None:
        """Return what repairing it alone brings at a condition; None where no repair of it is chosen."""
        return next((each for each in self.alone if each.condition == projection.condition), None)


def worn_valves(diagnosis: Diagnosis, choice: Choice) -> tuple[WornValve, ...]:
    """Return every valve with lands past a limit: the worst verdict first, of equal ones that which saves most.

    Parameters
    ----------
    choice
        the repairs that are chosen for the unit; a valve's own of them are those that change one of its lands.
    """
    by_component: dict[str, list[LandDiagnosis]] = {}
    for land in diagnosis.flagged:
        by_component.setdefault(land.key[0], []).append(land)
    mine = [[move for move in choice.chosen if any(key[0] == name for key in move.treats)] for name in by_component]
    now, *after = choice.totals_of([[], *mine])
    held = [each for each in pressures_at(diagnosis, lowest_first(diagnosis)[0]).applied if each.loss > 0.0]
    past = [each for each in held if each.verdict is not None and each.verdict.flagged]
    explained = {
        complaint: {key for each in explanations(diagnosis, complaint) for key in each.lands}
        for complaint in diagnosis.controller.complaints
    }

    def valve(component: str, flagged: list[LandDiagnosis], alone: tuple[RepairedAt, ...]) -> WornValve:
        lands = tuple(sorted(flagged, key=lambda land: -land.verdict.rank))
        keys = {land.key for land in lands}
        complaints = tuple(complaint for complaint, behind in explained.items() if keys & behind)
        costs = ((each, sum(own for key, own in each.costly if key in keys)) for each in past)
        lost = tuple((each, loss) for each, loss in costs if loss > 0.0)
        return WornValve(component, lands, _paths(diagnosis, keys), complaints, lost, alone)

    effects = (tuple(map(RepairedAt, now, totals)) if moves else () for moves, totals in zip(mine, after, strict=True))
    valves = map(valve, by_component, by_component.values(), effects)

    def order(valve: WornValve) -> tuple[int, float]:
        return -valve.verdict.rank, -max((each.saving for each in valve.alone), default=0.0)

    return tuple(sorted(valves, key=order))


def _gained(at: RepairedAt, rule: Rule) -> float:
    held = LINE if rule.circuit is None else rule.circuit.id
    return at.after.pressures[held] - at.before.pressures[held]


def _paths(diagnosis: Diagnosis, keys: set[LandKey]) -> tuple[Path, ...]:
    described = keys - diagnosis.controller.gaps_not_described
    gaps = [gap for gap in diagnosis.controller.gaps if gap.key in described]
    return tuple(dict.fromkeys((gap.high.section, _end(gap)) for gap in gaps if gap.high.section is not None))


def _end(gap: Gap) -> str | End:
    if gap.low.section is None and gap.low.constant > 0.0:
        return End.FIXED_PRESSURE
    if gap.into_sump:
        return End.SUMP
    return gap.low.section if gap.low.section is not None and gap.low.is_section else End.ANOTHER_SECTION
