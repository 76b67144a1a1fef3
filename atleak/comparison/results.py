"""Hold what two visits of one unit come to side by side: lands, operating points, logs, and what changed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from atleak.catalogue.circuits import Circuit
from atleak.comparison.changes import Change
from atleak.comparison.choices import DifferingChoice
from atleak.comparison.logs import LogComparison
from atleak.diagnosis import Diagnosis
from atleak.engine.projection import CircuitState, Projection
from atleak.errors import Message
from atleak.land_diagnosis import LandDiagnosis
from atleak.rules import LandKey

Side = Literal["before", "after"]
SIDES: tuple[Side, Side] = ("before", "after")


@dataclass(frozen=True)
class LandComparison:
    """One land at both visits; None on the side whose valve body's file has no such land."""

    key: LandKey
    before: LandDiagnosis | None
    after: LandDiagnosis | None
    change: Change | None  # of its radial clearance [m]; None unless measured at both visits

    @property
    def significant(self) -> bool:
        """Return whether its clearance changed by more than the measurements can be off."""
        return self.change is not None and bool(self.change.significant)

    def only_on(self, side: Side) -> bool:
        """Return whether it was measured at that visit alone."""
        measured = [name for name, each in self._sides.items() if each is not None and each.state.measured]
        return measured == [side]

    def described_only_on(self, side: Side) -> bool:
        """Return whether only the valve body's file of that visit has it."""
        return any(each is None for name, each in self._sides.items() if name != side)

    @property
    def _sides(self) -> dict[Side, LandDiagnosis | None]:
        return {"before": self.before, "after": self.after}

    @property
    def half(self) -> bool:
        """Return whether one of its parts was not measured at one of the visits, and is taken as nominal."""
        return any(each is not None and each.state.status != "measured" for each in self._sides.values())

    @property
    def flagged(self) -> bool:
        """Return whether it has reached a limit at either visit."""
        return any(each is not None and each.verdict.flagged for each in self._sides.values())

    @property
    def order(self) -> tuple[int, int]:
        """Return what orders lands by their verdicts: the worst before comes first, of these what is best now."""
        before, after = (0 if each is None else each.verdict.rank for each in self._sides.values())
        return -before, after


@dataclass(frozen=True)
class CircuitComparison:
    """One circuit at one condition; a change is that of the pressure it holds [Pa]."""

    circuit: Circuit
    before: CircuitState
    after: CircuitState
    change: Change | None  # None where it is vented on one of the sides


@dataclass(frozen=True)
class ConditionComparison:
    """One operating point at both visits, and the changes there.

    ``after`` is as the job after has it, ``alike`` the same unit by the choices of the job before; changes are from
    ``before`` to ``alike``. Each is None where that job was not judged at this very operating point.
    """

    before: Projection | None
    after: Projection | None
    alike: Projection | None = None
    share: Change | None = None  # of the pump's flow, as a fraction
    leakage: Change | None = None  # [m³/s]
    reserve: Change | None = None
    main_pressure: Change | None = None  # [Pa] that holds
    circuits: tuple[CircuitComparison, ...] = ()

    @property
    def name(self) -> str:
        """Return the name of the operating point in the valve body's file."""
        return self.projection.condition.name

    @property
    def projection(self) -> Projection:
        """Return one of the two: at the same operating point."""
        found = self.after if self.before is None else self.before
        assert found is not None
        return found

    def only_on(self, side: Side) -> bool:
        """Return whether that job alone was judged at it."""
        return self.before is None if side == "after" else self.alike is None and self.before is not None


@dataclass(frozen=True)
class Comparison:
    """Two diagnoses of one unit side by side, with what changed between them."""

    before: Diagnosis
    after: Diagnosis
    alike: Diagnosis  # the unit after, by the choices of the job before; ``after`` itself where none differs
    differing: tuple[DifferingChoice, ...]
    lands: tuple[LandComparison, ...]  # in the order of the controller of the job after
    conditions: tuple[ConditionComparison, ...]  # those of the job before, then those that only the other one has
    logs: LogComparison | None  # None where one of the jobs has no road test
    messages: tuple[Message, ...]

    @property
    def flagged(self) -> tuple[LandComparison, ...]:
        """Return the lands that have reached a limit at either visit: the worst before first, of these the best now."""
        flagged = [land for land in self.lands if land.flagged]
        return tuple(sorted(flagged, key=lambda land: land.order))

    @property
    def changed(self) -> tuple[LandComparison, ...]:
        """Return the lands whose clearance changed beyond its uncertainty, the largest change first."""
        changed = [(abs(land.change.value), land) for land in self.lands if land.change and land.significant]
        return tuple(land for _, land in sorted(changed, key=lambda pair: -pair[0]))

    @property
    def compared(self) -> tuple[LandComparison, ...]:
        """Return the lands that were measured at both visits."""
        return tuple(land for land in self.lands if land.change is not None)

    @property
    def on_both_sides(self) -> tuple[ConditionComparison, ...]:
        """Return the operating points at which totals can be compared, that with the worst total before first.

        There are none where one of the jobs measured no land: its totals are those of a new unit.
        """
        if not (self.before.judged and self.after.judged):
            return ()
        both = [each for each in self.conditions if each.before is not None and each.alike is not None]
        worst = self.before.worst.condition.name
        return tuple(sorted(both, key=lambda each: each.name != worst))

    @property
    def leading(self) -> ConditionComparison | None:
        """Return the first of them; None without one."""
        return next(iter(self.on_both_sides), None)
