"""Hold what two visits of one unit come to side by side: lands, operating points, logs, and what changed."""

from __future__ import annotations

from dataclasses import dataclass

from atleak.catalogue.circuits import Circuit
from atleak.comparison.changes import Change
from atleak.comparison.choices import DifferingChoice
from atleak.comparison.logs import LogComparison
from atleak.diagnosis import Diagnosis, LandDiagnosis
from atleak.engine.projection import CircuitState, Projection
from atleak.errors import Message
from atleak.rules import LandKey


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

    @property
    def only_before(self) -> bool:
        """Return whether it was measured at the visit before alone."""
        return _measured(self.before) and not _measured(self.after)

    @property
    def only_after(self) -> bool:
        """Return whether it was measured at the visit after alone."""
        return _measured(self.after) and not _measured(self.before)

    @property
    def half(self) -> bool:
        """Return whether one of its parts was not measured at one of the visits, and is taken as nominal."""
        return any(each is not None and each.state.status != "measured" for each in (self.before, self.after))

    @property
    def flagged(self) -> bool:
        """Return whether it has reached a limit at either visit."""
        return any(each is not None and each.verdict.flagged for each in (self.before, self.after))

    @property
    def order(self) -> tuple[int, int]:
        """Return what orders lands by their verdicts: the worst before comes first, of these what is best now."""
        before, after = (0 if each is None else each.verdict.rank for each in (self.before, self.after))
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

    name: str
    label: str
    before: Projection | None
    after: Projection | None
    alike: Projection | None
    share: Change | None  # of the pump's flow, as a fraction
    leakage: Change | None  # [m³/s]
    reserve: Change | None
    main_pressure: Change | None  # [Pa] that holds
    circuits: tuple[CircuitComparison, ...]


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
    def leading(self) -> ConditionComparison | None:
        """Return the operating point at which the total before was worst, of those that both jobs were judged at."""
        both = [each for each in self.conditions if each.before is not None and each.alike is not None]
        worst = self.before.worst.condition.name
        return next((each for each in both if each.name == worst), both[0] if both else None)


def _measured(land: LandDiagnosis | None) -> bool:
    return land is not None and land.state.measured
