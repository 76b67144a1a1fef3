"""What two visits of one unit come to side by side: lands, operating points, logs, and what changed.

A number changed where its difference is more than the measurements can be off. Where two jobs were judged by different
choices, one of them is judged anew by those of the other. The events of two road tests are matched one by one.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from atleak.catalogue.circuits import Circuit
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.pump import NO_CLEARANCES
from atleak.catalogue.repairs import LandKey
from atleak.common.errors import Message
from atleak.common.sentences import Name, Sentence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.road import RoadFindings
from atleak.diagnosis.uncertainty import DEFAULTS, GUARD_FACTOR, LandUncertainty
from atleak.diagnosis.uncertainty.assess import COVERAGE
from atleak.diagnosis.uncertainty.draws import Interval
from atleak.engine.projection import CircuitState, Projection
from atleak.equations.statistics import normal_quantile
from atleak.measurements.events import Event
from atleak.measurements.road_test import RoadTest


@dataclass(frozen=True)
class Change:
    """A number before and after, and their difference."""

    before: float  # SI or a fraction
    after: float  # likewise
    interval: Interval | None  # 95 % of the difference; None where one side has no interval of its own
    standard_uncertainty: float | None = None  # of the difference, where it is normal

    @property
    def value(self) -> float:
        """Return the change: after minus before."""
        return self.after - self.before

    @property
    def significant(self) -> bool | None:
        """Return whether its interval leaves out zero; None where it has none."""
        return None if self.interval is None else not self.interval[0] <= 0.0 <= self.interval[1]


def clearance_change(before: LandUncertainty, after: LandUncertainty) -> Change | None:
    """Return by how much the radial clearance of a land changed [m]; None where one side did not measure it.

    Notes
    -----
    The change is significant where it is more than 1.96 times its standard uncertainty, the root of both variances: of
    lands that did not change, one in twenty at most is called changed.

    Both variances count in full. Two visits may share the certificate of a gauge, the form of a part that stayed in
    its place, or the true size of a part that nobody measured, and what they share drops out of the difference. But a
    sheet does not say whether the gauge was set with the same ring on both days, whether the part is the same one, nor
    at which angle it was turned: what is not known stays inside (choice of this project). All that can be
    shared acts in the same direction on both sides, so the true spread is never larger than this.
    """
    if before.u_clearance is None or after.u_clearance is None:
        return None
    u = math.hypot(before.u_clearance, after.u_clearance)
    first, second = (each.sources.state.radial_clearance for each in (before, after))
    reach = float(normal_quantile(0.5 + 0.5 * COVERAGE)) * u
    return Change(first, second, (second - first - reach, second - first + reach), u)


def change_between(before: float, after: float, interval: Interval | None) -> Change | None:
    """Return by how much a total or a pressure changed; None where it has no end on one of the sides.

    Parameters
    ----------
    interval
        the 95 % interval of the change, as `atleak.diagnosis.uncertainty.paired.changes` draws it; None where nothing
        was measured.
    """
    if not (math.isfinite(before) and math.isfinite(after)):
        return None
    known = interval is not None and all(map(math.isfinite, interval))
    return Change(before, after, interval if known else None)


ChoiceName = Literal["fluid", "limits", "profile", "condition", "assumptions"]


@dataclass(frozen=True)
class DifferingChoice:
    """One choice in which two jobs differ, in English words."""

    name: ChoiceName  # what was chosen
    before: Sentence  # by the job before
    after: Sentence  # by the job after


def differing_choices(before: Diagnosis, after: Diagnosis) -> tuple[DifferingChoice, ...]:
    """Return the choices that change a result of the same readings, and in which two jobs differ.

    Instruments, measuring temperature, pump clearances and lengths that were measured are no such choices: they belong
    to what was measured.
    """
    return tuple(_differing(before, after))


def _differing(before: Diagnosis, after: Diagnosis) -> Iterator[DifferingChoice]:
    for name, what, said in _CHOICES:
        if what(before) != what(after):
            yield DifferingChoice(name, *_told_apart(said(before), said(after)))
    if before.uncertainty is not None and after.uncertainty is not None:
        assumed = [
            {**each.assumptions.settings, "guard band": each.guard_factor}
            for each in (before.uncertainty, after.uncertainty)
        ]
        names = [name for name, value in assumed[0].items() if value != assumed[1][name]]
        if names:
            first, second = (
                tuple(Sentence("{name} {value:g}", name=name.replace("_", " "), value=each[name]) for name in names)
                for each in assumed
            )
            yield DifferingChoice("assumptions", _named(first), _named(second))


def _in_state(diagnosis: Diagnosis) -> Sentence:
    if diagnosis.fluid.state == "used":
        return Sentence("{fluid}, used", fluid=Name(diagnosis.fluid.name))
    return Sentence("{fluid}, fresh", fluid=Name(diagnosis.fluid.name))


def _named(choice: str | OperatingPoint | tuple[Sentence, ...]) -> Sentence:
    return Sentence("{choice}", choice=choice)


def _told_apart(before: Sentence, after: Sentence) -> tuple[Sentence, Sentence]:
    """Return both names; what differs in its file alone says so."""
    return (before, after) if before != after else (before, Sentence("another file of the name {name}", name=after))


def same_condition(before: OperatingPoint, after: OperatingPoint) -> bool:
    """Tell whether two operating points are one and the same; how they are called and who states them aside."""
    return _bare(before) == _bare(after)


def _bare(condition: OperatingPoint) -> OperatingPoint:
    return replace(condition, label="", source="")


_CHOICES: tuple[tuple[ChoiceName, Callable[[Diagnosis], object], Callable[[Diagnosis], Sentence]], ...] = (
    ("fluid", lambda job: (job.fluid.origin.sha256, job.fluid.state, job.fluid.estimated), _in_state),
    ("limits", lambda job: job.limits.origin.sha256, lambda job: _named(Name(job.limits.name))),
    ("profile", lambda job: job.profile.options, lambda job: _named(job.profile.label)),
    ("condition", lambda job: _bare(job.projection.condition), lambda job: _named(job.projection.condition)),
)


def judged_as(after: Diagnosis, before: Diagnosis) -> Diagnosis:
    """Return the unit of ``after``, as measured there, judged by the choices of ``before``.

    Those are fluid, limits, profile, stated condition and assumptions.
    """
    measured, chosen = after.uncertainty, before.uncertainty or after.uncertainty
    same_file = before.controller.sha256 == after.controller.sha256
    # the controller holds this job's pump and lands already: the pump of the sheet's head must not count twice
    readings = None if after.readings is None else replace(after.readings, pump=NO_CLEARANCES)
    again = diagnose(
        after.controller,
        before.fluid,
        before.limits,
        fluid_state=None if before.fluid_state_assumed else before.fluid.state,
        readings=readings,
        road_test=after.log.road_test if after.log is not None else None,
        pressures=after.pressures.table if after.pressures is not None else None,
        vacuum=after.vacuum_table,
        profile=before.profile,
        condition=(before if same_file else after).projection.condition,
        mileage_km=after.mileage,
        measuring_temperature_c=after.measured_at.value if after.measured_at is not None else None,
        instruments=measured.instruments if measured is not None else None,
        assumptions=chosen.assumptions if chosen is not None else DEFAULTS,
        guard_factor=chosen.guard_factor if chosen is not None else GUARD_FACTOR,
        complaint=after.complaint,
    )
    return replace(again, repairs=after.repairs)


MARGIN = 2.0  # [s] shown before an event and after it
_What = tuple[str, int | None, int | None]


@dataclass(frozen=True)
class EventPair:
    """An event of one log and its like in the other: the same kind, for shifts the same gears, in the same place."""

    order: int  # from 1, among the events of the same kind and gears
    before: Event | None  # None: no such event
    after: Event | None  # None: no such event

    @property
    def event(self) -> Event:
        """Return the event of the side that has it, of both the one before."""
        event = self.before or self.after
        assert event is not None
        return event

    @property
    def matched(self) -> bool:
        """Return whether both logs hold it."""
        return self.before is not None and self.after is not None

    @property
    def lasts(self) -> float:
        """Return the longer of both durations [s]."""
        return max(each.duration for each in (self.before, self.after) if each is not None)


@dataclass(frozen=True)
class LogComparison:
    """Two road tests and their events, matched."""

    before: RoadFindings  # the earlier log
    after: RoadFindings  # the later log
    pairs: tuple[EventPair, ...]  # by the time of the log before; what only the log after holds comes last

    @property
    def matched(self) -> tuple[EventPair, ...]:
        """Return the events that both logs hold."""
        return tuple(pair for pair in self.pairs if pair.matched)

    def windows(self, pair: EventPair) -> tuple[tuple[RoadTest, float], ...]:
        """Return of each side the part of its log around a matched event, and the event's own start on its time [s].

        Both parts reach equally far before the start and behind it.
        """
        logs = ((self.before, pair.before), (self.after, pair.after))
        return tuple(
            (findings.road_test.window(event.start - MARGIN, event.start + pair.lasts + MARGIN), event.start)
            for findings, event in logs
            if event is not None
        )


def compared_logs(before: RoadFindings, after: RoadFindings) -> LogComparison:
    """Return two logs with their events matched by kind and order, each to be aligned at its own start."""
    return LogComparison(before, after, match_events(before.events, after.events))


def match_events(before: Sequence[Event], after: Sequence[Event]) -> tuple[EventPair, ...]:
    """Match the events of two logs: the first of a kind with the first, the second with the second, and so on.

    A shift is matched with one between the same gears.
    """
    waiting: dict[_What, list[Event]] = defaultdict(list)
    for event in after:
        waiting[_what(event)].append(event)
    counted: dict[_What, int] = defaultdict(int)
    pairs = []
    for event in before:
        what = _what(event)
        counted[what] += 1
        pairs.append(EventPair(counted[what], event, waiting[what].pop(0) if waiting[what] else None))
    for what, left in waiting.items():
        pairs += [EventPair(counted[what] + number, None, event) for number, event in enumerate(left, start=1)]
    return tuple(pairs)


def _what(event: Event) -> _What:
    return event.kind, event.from_gear, event.to_gear


Side = Literal["before", "after"]
SIDES: tuple[Side, Side] = ("before", "after")


@dataclass(frozen=True)
class LandComparison:
    """One land at both visits; None on the side whose valve body's file has no such land."""

    key: LandKey  # component and land
    before: LandDiagnosis | None  # as measured before
    after: LandDiagnosis | None  # as measured after
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
        return any(each is not None and not each.state.whole for each in self._sides.values())

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

    circuit: Circuit  # as the earlier file describes it
    before: CircuitState  # pressure held before
    after: CircuitState  # pressure held after
    change: Change | None  # None where it is vented on one of the sides


@dataclass(frozen=True)
class ConditionComparison:
    """One operating point at both visits, and the changes there.

    ``after`` is as the job after has it, ``alike`` the same unit by the choices of the job before; changes are from
    ``before`` to ``alike``. Each is None where that job was not judged at this very operating point.
    """

    before: Projection | None  # None where that job was not judged here; so for the others
    after: Projection | None  # as the job after has it
    alike: Projection | None = None  # the unit after, by the choices of the job before
    share: Change | None = None  # of the pump's flow, as a fraction
    leakage: Change | None = None  # [m³/s]
    reserve: Change | None = None  # of the pump
    main_pressure: Change | None = None  # [Pa] that holds
    circuits: tuple[CircuitComparison, ...] = ()  # that are applied here

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

    before: Diagnosis  # the earlier one
    after: Diagnosis  # the later one
    alike: Diagnosis  # the unit after, by the choices of the job before; ``after`` itself where none differs
    differing: tuple[DifferingChoice, ...]  # choices in which they differ, which may explain a change
    lands: tuple[LandComparison, ...]  # in the order of the controller of the job after
    conditions: tuple[ConditionComparison, ...]  # those of the job before, then those that only the other one has
    logs: LogComparison | None  # None where one of the jobs has no road test
    messages: tuple[Message, ...]  # what a reader must know of it

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
