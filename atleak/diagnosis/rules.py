"""Make every rule that judges a land or a total, once, and judge it once.

A rule says which quantity is limited, at which condition, its value and the limits that apply there: those of wear
depend on the land's mounting clearance, those of a share on what the same land or unit draws when new. Everything
after it (decisions, reports, pages) takes these objects as they are.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from atleak.catalogue.circuits import Circuit, PermissiblePressure
from atleak.catalogue.limits import ROUNDING, Level, LimitOrigin, Limits, RuleKind, Steps, falls_below
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.pump import Pump
from atleak.catalogue.repairs import LandKey
from atleak.common.sentences import Name, Sentence
from atleak.common.verdicts import Band, Verdict
from atleak.engine.projection import Projection
from atleak.measurements.clearances import LandClearance

_OWN_LIMIT_SOURCE = "the valve body's file"
_MANUAL = "the pump's manual, as the valve body's file states it"
_EVERYWHERE = Sentence("")


@dataclass(frozen=True)
class Rule:
    """One limited quantity of one land or of the unit: ``value`` in SI or as a fraction, with its limits."""

    kind: RuleKind  # what is limited
    condition: OperatingPoint | None  # of a share; None where the rule holds everywhere
    value: float  # SI or a fraction
    steps: Steps  # with the limits that apply to this land or unit at this condition
    new: float | None = None  # the same of the same land or unit as it may have been when new; None for wear, clearance
    circuit: Circuit | None = None  # whose pressure it is
    where: Sentence = _EVERYWHERE  # in a log or table: at which time or place the value was taken
    reached: tuple[float, ...] | None = field(default=None, compare=False)  # how likely each level; None: by the value

    @cached_property
    def _judged(self) -> tuple[Level, float]:
        return self.steps.judge(self.value, Band.GREEN if self.kind.in_bands else Verdict.OK, self.reached)

    @property
    def level(self) -> Level:
        """Return the level that the value has reached: a verdict for a land, a band for a total."""
        return self._judged[0]

    @property
    def probable(self) -> bool:
        """Tell whether the level is that of what is likely, and the value alone has reached another one."""
        return replace(self, reached=None).level != self.level

    @property
    def verdict(self) -> Verdict:
        """Return the verdict that the level counts as."""
        return self.level.verdict if isinstance(self.level, Band) else self.level

    @property
    def limit(self) -> float:
        """Return the limit that was reached, or the lowest one where none was; in the value's unit."""
        return self._judged[1]

    @property
    def growth(self) -> float | None:
        """Return how much the share has grown over that of a new one, as a fraction; None where that is no number."""
        comparable = self.new is not None and self.kind.is_share and math.isfinite(self.value)
        return self.value / self.new - 1.0 if comparable and self.new and 0.0 < self.new < math.inf else None

    @property
    def severity(self) -> float:
        """Return how far the value is past the limit it reached, as a fraction of that."""
        past = self.limit - self.value if self.steps.falling else self.value - self.limit
        return past / abs(self.limit) if self.limit else past

    @property
    def origin(self) -> LimitOrigin:
        """Return who set the limit."""
        return self.steps.origin

    @property
    def source(self) -> str:
        """Say where the limit was published, or why it was chosen."""
        return self.steps.source

    @property
    def quantity(self) -> Sentence:
        """Name what is limited, in plain words."""
        limited = _LABELS[self.kind]
        if self.circuit is None:
            return limited
        return Sentence("{quantity} of {circuit}", quantity=limited, circuit=Name(self.circuit.name))

    @property
    def label(self) -> Sentence:
        """Name the quantity and its condition in plain words."""
        parts = tuple(part for part in (self.quantity, self.condition, self.where) if part)
        return Sentence("{parts}", parts=parts)

    @property
    def id(self) -> str:
        """Return the rule's name in records, with the unit of its value: ``share_hot_idle_percent``."""
        circuit = self.circuit.id if self.circuit else ""
        at = "" if self.condition is None else self.condition.name
        return "_".join(filter(None, (_IDS.get(self.kind, str(self.kind)), circuit, at, self.kind.suffix)))


_LABELS = {
    RuleKind.WEAR: Sentence("wear"),
    RuleKind.CLEARANCE: Sentence("radial clearance"),
    RuleKind.PAIR_SHARE: Sentence("share of pump flow"),
    RuleKind.TOTAL_SHARE: Sentence("total share of pump flow"),
    RuleKind.RESERVE: Sentence("reserve of the pump"),
    RuleKind.CIRCUIT_LOSS: Sentence("pressure lost against new"),
    RuleKind.BELOW_LINE: Sentence("pressure below the line"),
    RuleKind.BELOW_EXPECTED: Sentence("main pressure below that of a new unit"),
    RuleKind.PERMISSIBLE_PRESSURE: Sentence("main pressure below the permissible"),
    RuleKind.COMMANDED_PRESSURE: Sentence("main pressure off the commanded"),
    RuleKind.PUMP_SIDE: Sentence("side clearance of the pump"),
    RuleKind.PUMP_TIP: Sentence("tip clearance of the pump"),
}
_IDS = {  # of those whose name in records is not that of the kind
    RuleKind.PAIR_SHARE: "share",
    RuleKind.BELOW_EXPECTED: "below_expected_pressure",
    RuleKind.PERMISSIBLE_PRESSURE: "below_permissible_pressure",
    RuleKind.COMMANDED_PRESSURE: "off_commanded_pressure",
}


@dataclass(frozen=True)
class UnitRules:
    """The rules of every measured land, and those of the whole unit at every condition."""

    lands: Mapping[LandKey, tuple[Rule, ...]]  # by component and land
    totals: tuple[Rule, ...]  # in the order of the conditions
    pressures: tuple[Rule, ...]  # reserves, circuits and permissible pressures, in the order of the conditions
    limits: Limits  # the set that was applied

    @property
    def of_unit(self) -> tuple[Rule, ...]:
        """Return the rules of the whole unit, totals first."""
        return (*self.totals, *self.pressures)

    def of_land(self, key: LandKey) -> tuple[Rule, ...]:
        """Return the rules of one land; none where it was not measured."""
        return self.lands.get(key, ())


def unit_rules(
    states: Sequence[LandClearance],
    projections: Sequence[Projection],
    unworn: Sequence[Projection],
    limits: Limits,
    points: Sequence[OperatingPoint] | None = None,
) -> UnitRules:
    """Make and judge every rule of a unit.

    Parameters
    ----------
    projections
        leakage at every condition that is judged, the stated one first.
    unworn
        leakage of the same unit as it may have been when new, at the same conditions and with the same fluid.
    points
        those of the valve body's file: at another, which no new unit can hold, no pressure is judged; None: at all.
    """
    at = tuple(zip(projections, unworn, strict=True))
    lands = {state.land.key: land_rules(state, at, limits) for state in states if state.measured}
    totals = tuple(_share_rule(RuleKind.TOTAL_SHARE, now, now.share, new.share, limits.total_share) for now, new in at)
    held = [(now, new) for now, new in at if points is None or now.condition in points or not cannot_be(new)]
    pressures = tuple(rule for now, new in held for rule in _pressure_rules(now, new, limits))
    return UnitRules(lands, totals, pressures, limits)


def _pressure_rules(now: Projection, new: Projection, limits: Limits) -> Iterable[Rule]:
    """Make the rules of the pump's reserve, of every circuit that is applied, and of main pressure at one condition."""
    condition = now.condition
    if limits.reserve is not None:
        steps = replace(limits.reserve, levels=limits.reserve.under(new.reserve))
        yield Rule(RuleKind.RESERVE, condition, now.reserve, steps, new.reserve)
    if limits.circuit_loss is not None:
        for circuit, when_new in zip(now.circuits, new.circuits, strict=True):
            if not circuit.vented:
                moved = abs(when_new.pressure - circuit.pressure)  # a rise is judged too
                yield Rule(
                    RuleKind.CIRCUIT_LOSS, condition, moved, limits.circuit_loss, when_new.pressure, circuit.circuit
                )
    low = permissible_low(now)
    below = None if now.permissible is None else permissible_steps(now.permissible, limits)
    if low is not None and below is not None:
        value = 1.0 - now.main_pressure_held / low
        yield Rule(RuleKind.PERMISSIBLE_PRESSURE, condition, value, below, new.main_pressure_held)


def permissible_low(now: Projection) -> float | None:
    """Return the lowest permissible main pressure at a condition [Pa], or None where there is none to judge by.

    A main pressure that is only assumed is not judged: where the condition itself states less than is permissible, and
    the pump holds it. Nor is one judged by more than the condition states.
    """
    condition, permissible = now.condition, now.permissible
    if permissible is None or permissible.low is None:
        return None
    if condition.main_pressure < permissible.low and not now.pressure_falls:
        return None
    return min(permissible.low, condition.main_pressure) or None


def permissible_steps(permissible: PermissiblePressure, limits: Limits) -> Steps | None:
    """Return the limits of main pressure below the permissible: one under a published least is critical."""
    if limits.below_permissible is None or not permissible.published:
        return limits.below_permissible
    return Steps(((Verdict.CRITICAL, 0.0),), LimitOrigin.PUBLISHED, permissible.source)


def cannot_be(new: Projection) -> bool:
    """Tell whether a new unit as it is described cannot hold its pressure: no such unit has ever run."""
    low = permissible_low(new)
    return falls_below(new.reserve, 1.0) or (low is not None and falls_below(new.main_pressure_held, low))


def pump_rules(pump: Pump) -> tuple[Rule, ...]:
    """Return the rules of the pump's measured clearances, each with the most that its manual allows."""
    now, most, rules = pump.measured, pump.limits, []
    for kind, clearance, limit in ((RuleKind.PUMP_SIDE, now.side, most.side), (RuleKind.PUMP_TIP, now.tip, most.tip)):
        if clearance is not None and limit is not None:
            allowed = limit * (1.0 + 2.0 * ROUNDING)  # so much is allowed, and more is not
            steps = Steps(((Verdict.REPLACE, allowed),), LimitOrigin.PUBLISHED, _MANUAL)
            rules.append(Rule(kind, None, clearance, steps))
    return tuple(rules)


def _share_rule(kind: RuleKind, at: Projection, share: float, new: float, steps: Steps) -> Rule:
    return Rule(kind, at.condition, share, replace(steps, levels=steps.over(new)), new)


def land_rules(state: LandClearance, at: Sequence[tuple[Projection, Projection]], limits: Limits) -> tuple[Rule, ...]:
    """Make the rules of one land; ``at`` holds each condition as it is, and with the unit unworn."""
    land, rules = state.land, []
    if land.seal:  # its ring parts the pressures, not its clearance
        return ()
    if limits.wear is not None:
        wear = replace(limits.wear, levels=limits.wear.of_wear(land.mounting_high, land.mounting_tolerance or 0.0))
        rules.append(Rule(RuleKind.WEAR, None, state.wear, wear))
    steps = clearance_limits(state, limits)
    if steps is not None:
        rules.append(Rule(RuleKind.CLEARANCE, None, state.radial_clearance, steps))
    pair = limits.pair_share
    if pair is not None:
        rules += [
            _share_rule(RuleKind.PAIR_SHARE, now, now.share_drawn_by(land.key), new.share_drawn_by(land.key), pair)
            for now, new in at
            if not cannot_be(new)  # a share of such a pump says nothing of a land
        ]
    return tuple(rules)


def clearance_limits(state: LandClearance, limits: Limits) -> Steps | None:
    """Return the limits of a land's radial clearance [m]: its own from the controller's file, or else the set's."""
    own = state.land.clearance_limit
    if own is None:
        return limits.clearance
    return Steps(((Verdict.REPLACE, own),), LimitOrigin.WORKSHOP, _OWN_LIMIT_SOURCE)


def farthest_first(rules: Iterable[Rule]) -> list[Rule]:
    """Return the rules that reached a limit, the one that is farthest past it first."""
    return sorted((rule for rule in rules if rule.verdict.flagged), key=lambda rule: -rule.severity)
