"""Judge a land: its verdict, the rule that decided it, and what it costs the pump; and the pump itself."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from atleak.catalogue.limits import RuleKind
from atleak.catalogue.pump import Pump
from atleak.engine.projection import Projection
from atleak.errors import Message
from atleak.readings import LandClearance
from atleak.replace_mileage import replace_mileage
from atleak.rules import LandKey, Rule, UnitRules, pump_rules
from atleak.uncertainty import Decision, LandUncertainty, RuleDecision, UnitUncertainty
from atleak.uncertainty.decision import decide_normal
from atleak.verdicts import Verdict, worst
from atleak.wear_line import Crossing


@dataclass(frozen=True)
class LandDiagnosis:
    """One land's clearance, its leakage at the stated condition, its verdict and how sure that is."""

    state: LandClearance
    wear: float | None  # (c_r − c_m)/c_m; None where not measured
    effective_clearance: float  # [m] at the stated condition
    leakage: float  # [m³/s] at the stated condition, through every gap of the land
    drawn_from_pump: float  # [m³/s] the part of the leakage that counts in the total
    share: float  # what it draws / pump capacity at the stated condition
    excess_share: float  # what it draws above the same land at its mounting clearance, where that costs most
    verdict: Verdict
    rules: tuple[Rule, ...]
    replace_mileage: Crossing | None  # None where one visit cannot tell it, and where it has been passed
    uncertainty: LandUncertainty | None  # None where nothing was measured
    messages: tuple[Message, ...]

    @property
    def key(self) -> LandKey:
        return self.state.land.key

    @property
    def decision(self) -> Decision | None:
        """Say how sure the verdict is, about the limit of the rule that gave it; None where not measured."""
        return self.uncertainty.decision if self.uncertainty and self.verdict != Verdict.NOT_MEASURED else None

    @property
    def suspect(self) -> bool:
        """Return whether the pair measures tighter than a new one can be."""
        return self.uncertainty is not None and self.uncertainty.suspect

    @property
    def in_doubt(self) -> bool:
        """Return whether its readings contradict themselves: repeats too far apart, or a pair tighter than new."""
        return self.suspect or bool(self.state.doubts)

    @property
    def probability_over_limit(self) -> float | None:
        """Return the probability that the true value is over the limit of the rule that gave the verdict."""
        decided = self.deciding_uncertainty
        return decided.probability_over_limit if decided and self.verdict != Verdict.NOT_MEASURED else None

    @property
    def within_new(self) -> bool:
        """Tell whether a land whose clearance when new is known as a range measures within it: it shows no wear."""
        low, high = self.state.land.mounting_range
        return self.wear is not None and low < high and low <= self.state.radial_clearance <= high

    @property
    def deciding_uncertainty(self) -> RuleDecision | None:
        """Return the decision that belongs to the verdict."""
        return self.uncertainty.deciding if self.uncertainty else None

    @property
    def deciding(self) -> Rule | None:
        """Return the rule that gave the verdict: the worst; of several, the likeliest to be over its limit."""
        decided = self.deciding_uncertainty
        if decided is not None:
            return decided.rule
        return max(self.rules, key=lambda rule: rule.verdict.rank, default=None)


@dataclass(frozen=True)
class PumpDiagnosis:
    """What was measured of the pump against its limits, and what is past a limit by its wear."""

    decisions: tuple[RuleDecision, ...]  # on its measured clearances
    lacking: tuple[Rule, ...]  # of one past its limits: totals and pressures better with a new one, the worst first

    @property
    def rules(self) -> tuple[Rule, ...]:
        """Return every rule that it is judged by."""
        return (*(decided.rule for decided in self.decisions), *self.lacking)

    @property
    def deciding(self) -> Rule | None:
        """Return the worst of them; None where nothing that was measured has a limit."""
        return max(self.rules, key=lambda rule: rule.verdict.rank, default=None)

    @property
    def verdict(self) -> Verdict:
        """Return the verdict of that."""
        return Verdict.NOT_MEASURED if self.deciding is None else self.deciding.verdict


def diagnosed_pump(
    pump: Pump, rules: UnitRules, with_new: Iterable[Rule], uncertainty: float, guard_factor: float
) -> PumpDiagnosis:
    """Judge the pump: its clearances, and of one past them what of the unit's rules stands better ``with_new`` one.

    A pump within its own limits is not worn, whatever the unit lacks. ``uncertainty`` is that of a measured
    clearance [m].
    """
    decisions = tuple(decide_normal(rule, uncertainty, guard_factor) for rule in pump_rules(pump))
    if not any(decided.rule.verdict.flagged for decided in decisions):
        return PumpDiagnosis(decisions, ())
    better = {rule.id: rule.verdict.rank for rule in with_new}
    unit = sorted(rules.of_unit, key=lambda rule: rule.kind is not RuleKind.PERMISSIBLE_PRESSURE)  # what drivers feel
    lacking = [rule for rule in unit if rule.verdict.rank > better.get(rule.id, rule.verdict.rank)]
    return PumpDiagnosis(decisions, tuple(sorted(lacking, key=lambda rule: -rule.verdict.rank)))


def diagnosed_land(
    state: LandClearance,
    projections: Sequence[Projection],
    when_new: Sequence[Projection],
    rules: UnitRules,
    mileage: float | None,
    uncertainty: UnitUncertainty | None,
) -> LandDiagnosis:
    """Judge a land by the rules of its unit; ``when_new`` are the same conditions with every land as new."""
    land = state.land
    stated = projections[0]
    wear = state.wear if state.measured else None
    own_rules = rules.of_land(land.key)
    excess = max(
        now.share_of(now.drawn_by(land.key)) - new.share_of(new.drawn_by(land.key)) if now.pump_capacity > 0.0 else 0.0
        for now, new in zip(projections, when_new, strict=True)
    )
    leakage = stated.leakage_of(land.key)
    own_uncertainty = uncertainty.land(land.key) if uncertainty is not None and state.measured else None
    return LandDiagnosis(
        state=state,
        wear=wear,
        effective_clearance=state.effective_clearance(stated.condition.temperature),
        leakage=leakage,
        drawn_from_pump=stated.drawn_by(land.key),
        share=stated.share_drawn_by(land.key),
        excess_share=excess,
        verdict=_verdict(state, own_rules),
        rules=own_rules,
        replace_mileage=replace_mileage(own_rules, mileage, own_uncertainty),
        uncertainty=own_uncertainty,
        messages=state.messages,
    )


def _verdict(state: LandClearance, rules: Iterable[Rule]) -> Verdict:
    """Return the verdict of the worst rule.

    With one part at its nominal diameter a limit can be passed, but ``ok`` cannot be claimed; nor of a sealed land.
    """
    reached = worst(rule.verdict for rule in rules)
    return Verdict.NOT_MEASURED if reached == Verdict.OK and not state.can_be_ok else reached
