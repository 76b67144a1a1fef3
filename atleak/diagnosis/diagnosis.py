"""The result: which pairs of a unit are past a limit, by which rule, and what they cost the pump."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib import import_module

import pandas as pd

from atleak.catalogue.circuits import Circuit
from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits, RuleKind
from atleak.catalogue.operating_point import HOT_IDLE, OperatingPoint
from atleak.catalogue.repairs import Complaint, LandKey, Repair
from atleak.common.errors import Message
from atleak.common.verdicts import Band, Verdict, worst
from atleak.diagnosis.consequence import Consequence, consequences
from atleak.diagnosis.flows import FlowFinding
from atleak.diagnosis.gauge_card import GaugeCard
from atleak.diagnosis.gauge_check import PressureCheck
from atleak.diagnosis.land import (
    NO_RATE,
    SERVICE_INTERVAL,
    LandDiagnosis,
    PumpDiagnosis,
    WearLine,
    line_from_new,
    replace_mileage,
    without_rate,
)
from atleak.diagnosis.missing import Missing, split_as_measured
from atleak.diagnosis.provisional import AssumedBasis, Representative
from atleak.diagnosis.road import RoadFindings, leakage_over
from atleak.diagnosis.rules import Rule, cannot_be, farthest_first
from atleak.diagnosis.uncertainty import Decision, RuleDecision, UnitUncertainty, certainty
from atleak.diagnosis.vacuum import VacuumFinding
from atleak.diagnosis.warm_up import WarmUp
from atleak.engine.leakage import LeakageModel
from atleak.engine.operation import LINE, Losses
from atleak.engine.profile import Profile
from atleak.engine.projection import Projection
from atleak.engine.road_leakage import RoadLeakage
from atleak.engine.road_pressure import SLUMP_SPAN, TemperatureClass, temperature_classes
from atleak.engine.unit import Unit
from atleak.measurements.flow_readings import FlowTable
from atleak.measurements.readings import MeasuringTemperature, Readings
from atleak.measurements.road_test import RoadTest
from atleak.measurements.vacuum import VacuumTable

APART = 0.2  # relative: by which two engine speeds differ that tell a pump from what is stuck: choice of this project

_NAMED = 3  # lands that are named at the prompt
_NOTEBOOK = "atleak.report.notebook"  # a room above: found by its name when asked, as pandas finds what plots for it


@dataclass(frozen=True)
class Diagnosis:
    """All that is known of a unit, with the inputs it follows from; reports and pages compute nothing more.

    Attributes
    ----------
    readings
        of the measuring sheet; None without one.
    measured_at
        temperature of gauge and parts; None without readings.
    controller
        the type of valve body, with the pump of this job.
    fluid
        in its state.
    fluid_state_assumed
        nobody said whether it is fresh or used, and fresh is taken.
    limits
        by which it is judged.
    profile
        by which it is computed.
    mileage
        of the vehicle [km]; None where nobody stated it.
    model
        the engine with the clearances as measured.
    as_new
        the engine with every land new.
    as_unworn
        the engine with every land as wide as its readings may have been when new.
    lands
        in the controller's order.
    projections
        at every condition that is judged, the stated one first.
    new_projections
        of the same unit new, at the same conditions and with the same fluid.
    unworn_projections
        of the unworn unit, likewise; growth is judged by it.
    losses
        which lands cost the line and every circuit how much pressure [Pa], at the same conditions.
    road
        leakage over the log; None without one, and where none can be computed over it.
    log
        what the log says by itself; None without one.
    gauge_card
        what gauges should show on the unit, new and as measured.
    pressures
        gauge readings of the standing vehicle, judged; None without any.
    vacuum
        what every plug of a vacuum test tells, of one land or of several together.
    logged
        what is missing of main pressure where a log shows it, the vehicle standing.
    flow_table
        flows that were caught in a jug; None without any.
    flows
        what each of them says of what the line leaves over.
    warm_up
        what the log tells of leakage where main pressure was not held; None where it does not say enough for that.
    uncertainty
        of flows, shares and totals; None without readings.
    total_rules
        of the total share at every condition that is judged, the stated one first.
    pressure_rules
        of reserve, circuits and permissible pressure at the same conditions.
    pump
        the pump, judged by its clearances.
    pump_new
        the diagnosis of the same sheet with the pump new; None where the pump is not measured.
    complaint
        the customer's, as the controller maps it to conditions and lands.
    messages
        what a reader of the result must know.
    repairs
        that the workshop chose to plan with; of other lands the cheapest is planned.
    vacuum_table
        the vacuum test that ``vacuum`` follows from; None without one.
    lines_of_visits
        wear over mileage of the lands of which several visits tell it; None: since new, where this visit tells that.
    """

    readings: Readings | None
    measured_at: MeasuringTemperature | None
    controller: Controller
    fluid: Fluid
    fluid_state_assumed: bool
    limits: Limits
    profile: Profile
    mileage: float | None
    model: Unit = field(repr=False)
    as_new: LeakageModel = field(repr=False)
    as_unworn: LeakageModel = field(repr=False)
    lands: tuple[LandDiagnosis, ...]
    projections: tuple[Projection, ...]
    new_projections: tuple[Projection, ...]
    unworn_projections: tuple[Projection, ...]
    losses: tuple[Losses, ...]
    road: RoadLeakage | None
    log: RoadFindings | None
    gauge_card: GaugeCard = field(repr=False)
    pressures: PressureCheck | None
    vacuum: tuple[VacuumFinding, ...]
    logged: tuple[Missing, ...] = field(compare=False)
    flow_table: FlowTable | None
    flows: tuple[FlowFinding, ...]
    warm_up: WarmUp | None = field(compare=False)
    uncertainty: UnitUncertainty | None
    total_rules: tuple[Rule, ...]
    pressure_rules: tuple[Rule, ...]
    pump: PumpDiagnosis
    pump_new: Diagnosis | None = field(repr=False)
    complaint: Complaint | None
    messages: tuple[Message, ...]
    repairs: tuple[Repair, ...] = ()
    vacuum_table: VacuumTable | None = None
    lines_of_visits: Mapping[LandKey, WearLine] | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        named = [f"{'{}/{}'.format(*land.key)} {land.verdict}" for land in self.flagged[:_NAMED]]
        named += [f"{len(self.flagged) - _NAMED} more"] if len(self.flagged) > _NAMED else []
        count = f"{self.measured} of {len(self.lands)} lands measured"
        return (
            f"<Diagnosis of {self.controller.id}: {self.verdict}; {count}; {', '.join(named) or 'none past a limit'}>"
        )

    def _repr_html_(self) -> str:
        return str(import_module(_NOTEBOOK).html(self))

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return the tables of `atleak.diagnosis_record` as DataFrames; names of columns say the unit.

        Returns
        -------
        dict
            ``lands``, ``lands_at_conditions``, ``gaps``, ``conditions``, ``circuits``, ``explained``, ``repair_plan``,
            ``messages``, ``assumed`` … by name; what has no rows is left out. A table of lands has component and land
            as its index.
        """
        tables: dict[str, pd.DataFrame] = import_module(_NOTEBOOK).frames(self)
        return tables

    def to_frame(self) -> pd.DataFrame:
        """Return a row for every land, by component and land: clearance, wear, leakage, share, verdict and decision."""
        return self.tables()["lands"]

    @property
    def projection(self) -> Projection:
        """Return the projection at the stated condition."""
        return self.projections[0]

    @property
    def hot_idle(self) -> Projection | None:
        """Return the projection at hot idle, where a worn unit fails first; None where none is stated."""
        return next((each for each in self.projections if each.condition.name == HOT_IDLE), None)

    @property
    def complained(self) -> tuple[Projection, ...]:
        """Return the projections at which the customer's complaint can show; none without one."""
        return () if self.complaint is None else self.complained_of(self.complaint)

    def complained_of(self, complaint: Complaint) -> tuple[Projection, ...]:
        """Return the projections at which a complaint can show.

        Parameters
        ----------
        complaint
            one of the controller's.
        """
        return tuple(each for name in complaint.conditions for each in self.projections if each.condition.name == name)

    @property
    def presented(self) -> tuple[Projection, ...]:
        """Return every projection in the order in which people read them: those of the complaint lead."""
        first = self.complained
        return (*first, *(each for each in self.projections if not any(each is led for led in first)))

    @property
    def reported(self) -> tuple[Projection, ...]:
        """Return the projections that must stand in every report, in the order in which people read them.

        These are those of the complaint, the stated condition, hot idle, the one at which the total is worst, and the
        one of the rule that decided.
        """
        shown = [*self.complained, self.projection, self.hot_idle, self.worst]
        decided_by = self.decided_by
        rule = decided_by if decided_by is None or isinstance(decided_by, Rule) else decided_by.deciding
        if rule is not None and rule.condition is not None:
            shown.append(self.at(rule.condition))
        return tuple(each for each in self.presented if any(each is other for other in shown))

    @property
    def worst(self) -> Projection:
        """Return the projection at which the total reached the worst band; of several, the largest share."""
        condition = self.worst_total.condition
        return self.projection if condition is None else self.at(condition)

    def _place(self, projection: Projection) -> int:
        """Return the place of a projection's condition among those that were judged."""
        return [each.condition for each in self.projections].index(projection.condition)

    def total_rule(self, projection: Projection) -> Rule:
        """Return the rule of the total share at a condition.

        Parameters
        ----------
        projection
            one of `projections`, or of the new or unworn unit, at that condition; so below.
        """
        return self.total_rules[self._place(projection)]

    def unworn_at(self, projection: Projection) -> Projection:
        """Return the projection of the unit as it may have been when new.

        Parameters
        ----------
        projection
            at that condition.
        """
        return self.unworn_projections[self._place(projection)]

    def new_at(self, projection: Projection) -> Projection:
        """Return the projection of the same unit new.

        Parameters
        ----------
        projection
            at that condition.
        """
        return self.new_projections[self._place(projection)]

    def losses_at(self, projection: Projection) -> Losses:
        """Return which lands cost the line and every circuit how much pressure [Pa].

        Parameters
        ----------
        projection
            at that condition.
        """
        return self.losses[self._place(projection)]

    def loss_by(self, land: LandDiagnosis, projection: Projection) -> float | None:
        """Return what a land costs the circuit that loses most by it [Pa]; None where no pressure is solved.

        Parameters
        ----------
        land
            one of `lands`.
        projection
            at the condition.
        """
        losses = self.losses_at(projection)
        return max((of_lands.get(land.key, 0.0) for of_lands in losses.values()), default=None)

    def missing_at(self, projection: Projection, tap: str) -> Missing:
        """Return what is missing of the line, as p_g, or of a circuit, as far as the clearances tell it.

        Parameters
        ----------
        projection
            at the condition.
        tap
            ``p_g``, or the id of a circuit.
        """
        at = projection.condition, tap
        if at not in self._missing:
            self._missing[at] = Missing(at[0], tap, split_as_measured(self.model, self.as_unworn, *at))
        return self._missing[at]

    def missing_shown(self, projection: Projection, tap: str) -> Missing:
        """Return what a gauge shows missing at the operating point of its range and state, the most of it; or as above.

        Parameters
        ----------
        projection
            at the condition.
        tap
            ``p_g``, or the id of a circuit.
        """
        gauges = [each for each in self.missing_measured if each.seconds is None and each.tap == tap]
        here = [each for each in gauges if each.point.name == projection.condition.name]
        return max(here, key=lambda each: float(each.missing.mean())) if here else self.missing_at(projection, tap)

    @cached_property
    def _missing(self) -> dict[tuple[OperatingPoint, str], Missing]:
        return {}

    @property
    def missing_measured(self) -> tuple[Missing, ...]:
        """Return what is missing of every pressure that gauges or a log show, as far as it can be computed."""
        gauges = self.pressures.readings if self.pressures else ()
        return (*(each.missing for each in gauges if each.missing is not None), *self.logged)

    @property
    def missing_flagged(self) -> tuple[Missing, ...]:
        """Return those of them that are past a limit."""
        gauges = self.pressures.readings if self.pressures else ()
        past = [each.missing for each in gauges if each.missing is not None and each.verdict and each.verdict.flagged]
        return (*past, *(each for each in self.logged if self._too_low(each)))

    def _too_low(self, logged: Missing) -> bool:
        permissible = self.controller.permissible_at(logged.point.gear, logged.point.state)
        low = permissible.low if permissible else None
        return low is not None and logged.measured is not None and logged.measured < low

    def told_by_speed(self, missing: Missing) -> bool:
        """Tell whether main pressure was measured at two engine speeds, or as warm and as cold: a pump shows there.

        Parameters
        ----------
        missing
            of which pressure, by gauges or by the log.
        """
        logged = missing.seconds is not None
        line = [
            each.point for each in self.missing_measured if each.tap == LINE and (each.seconds is not None) is logged
        ]
        speeds = [point.engine_speed for point in line if not logged or point.name == missing.point.name]
        warm = [point.temperature for point in line if logged and point.name == missing.point.name]
        spread = max(speeds, default=1.0) / min(speeds, default=1.0) - 1.0
        return spread > APART or max(warm, default=0.0) - min(warm, default=0.0) > SLUMP_SPAN

    def within(self, rule: Rule) -> Verdict:
        """Return what a rule says within its limits: nothing unmeasured is ok, nor a circuit of which a land is not.

        Parameters
        ----------
        rule
            one of the unit.
        """
        if rule.condition is None:  # gauges and logs measured it
            return Verdict.OK
        lands = () if rule.circuit is None else self.lands_of(rule.circuit, rule.condition.gear)
        whole = all(land.state.can_be_ok for land in lands)
        return Verdict.OK if self.judged and whole else Verdict.NOT_MEASURED

    def lands_of(self, circuit: Circuit, gear: int) -> tuple[LandDiagnosis, ...]:
        """Return the lands that leak from or into a circuit in a gear.

        Parameters
        ----------
        circuit
            one of the controller's.
        gear
            the gear engaged.
        """
        gaps = [gap for gap in self.controller.gaps if gear in gap.gears]
        keys = {gap.key for gap in gaps if circuit.id in (gap.high.section, gap.low.section)}
        return tuple(land for land in self.lands if land.key in keys)

    def verdict_on(self, rule: Rule | None) -> Verdict | None:
        """Return the verdict of a rule of the unit; None without one, as of a circuit that is vented.

        Parameters
        ----------
        rule
            one of the unit's, or None.
        """
        if rule is None:
            return None
        return rule.verdict if rule.verdict.flagged else self.within(rule)

    def at(self, condition: OperatingPoint) -> Projection:
        """Return the projection at one of the conditions that were judged.

        Parameters
        ----------
        condition
            equal to that of the projection.
        """
        return next(each for each in self.projections if each.condition == condition)

    def over(self, road_test: RoadTest) -> RoadLeakage:
        """Compute the leakage over a road test with the same model.

        Parameters
        ----------
        road_test
            the road test, or a part of one.

        Returns
        -------
        RoadLeakage
            leakage [m³/s] and share at every sample.

        Raises
        ------
        RoadTestError
            a road test without usable main pressure.
        """
        return leakage_over(self.model, road_test, self.projection.condition)

    @property
    def temperature_classes(self) -> tuple[TemperatureClass, ...]:
        """Return for how long the log stays in each class of fluid temperature, and what it holds there."""
        if self.road is None:
            return ()
        return temperature_classes(self.road, self.limits.total_share, self.as_unworn if self.judged else None)

    def band(self, projection: Projection) -> Band | None:
        """Return the band that the total share has reached; None where nothing was measured.

        The totals of a unit that nobody measured are those of a new one: what is not measured is never green.

        Parameters
        ----------
        projection
            at the condition.
        """
        return Band(self.total_rule(projection).level) if self.judged else None

    @cached_property
    def flagged(self) -> tuple[LandDiagnosis, ...]:
        """Return the lands at watch or past it, the worst first, then the costliest."""
        flagged = [land for land in self.lands if land.verdict.flagged]
        return tuple(sorted(flagged, key=lambda land: (-land.verdict.rank, -land.excess_share)))

    @cached_property
    def consequences(self) -> Mapping[LandKey, Consequence]:
        """Return what the wear of every land does to the unit, by component and land."""
        behind = (each.lands_behind(self._allowed(each)) for each in self.missing_flagged)
        measured = {land.key for land in self.lands if land.state.judged}
        return consequences(self, measured.intersection(itertools.chain(*behind)))

    def _allowed(self, missing: Missing) -> float:
        """Return how much of a pressure may be missing [Pa]."""
        permissible = self.controller.permissible_at(missing.point.gear, missing.point.state)
        if missing.tap == LINE and permissible is not None and permissible.low is not None:
            return float(missing.split.new.mean()) - permissible.low
        return self.limits.circuit_loss.levels[0][1] if self.limits.circuit_loss is not None else math.inf

    def can_wait(self, land: LandDiagnosis) -> bool:
        """Tell whether a land is past a limit of its own and its wear does nothing to the unit.

        Parameters
        ----------
        land
            one of `lands`.
        """
        return land.verdict.flagged and self.consequences[land.key] is Consequence.NONE

    def urgency_of(self, land: LandDiagnosis) -> Verdict:
        """Return how urgent the repair of a land is: as its verdict, and to watch where its wear does nothing now.

        Parameters
        ----------
        land
            one of `lands`.
        """
        waits = self.consequences[land.key] in (Consequence.NONE, Consequence.BEFORE_NEXT_SERVICE)
        return Verdict.WATCH if waits and land.verdict.calls_for_repair else land.verdict

    @cached_property
    def urgency(self) -> Verdict:
        """Return how urgent a repair of the unit is: its verdict, with each land no worse than its wear is urgent."""
        if not self.flagged:
            return self.verdict
        unit = (rule.verdict for rule in self.unit_rules)
        return worst([*map(self.urgency_of, self.flagged), *unit, self.pump.verdict])

    def next_service(self, land: LandDiagnosis) -> float | None:
        """Return the mileage of the next service [km] where a land's wear up to there is known; None where it is not.

        Parameters
        ----------
        land
            one of `lands`.
        """
        line, mileage = self.wear_lines.get(land.key), self.mileage
        return None if line is None or mileage is None or not line.certain else mileage + SERVICE_INTERVAL

    @cached_property
    def wear_lines(self) -> Mapping[LandKey, WearLine]:
        """Return how every land wears of which that is known, by component and land."""
        if self.lines_of_visits is not None:
            return self.lines_of_visits
        of_lands = ((land.key, land.uncertainty) for land in self.lands if land.uncertainty is not None)
        lines = {key: line_from_new(uncertainty.sources, self.mileage) for key, uncertainty in of_lands}
        return {key: line for key, line in lines.items() if line is not None}

    @property
    def ranked(self) -> tuple[LandDiagnosis, ...]:
        """Return all lands by leakage at the stated condition, the largest first."""
        return tuple(sorted(self.lands, key=lambda land: -land.leakage))

    @property
    def drawing_most(self) -> tuple[LandDiagnosis, ...]:
        """Return the lands that draw from the pump at the stated condition, the largest share first."""
        return tuple(sorted((land for land in self.lands if land.share > 0.0), key=lambda land: -land.share))

    @property
    def worst_total(self) -> Rule:
        """Return the total that reached the worst band; of several, the largest."""
        return max(self.total_rules, key=lambda rule: (rule.verdict.rank, rule.value))

    @cached_property
    def decided_by(self) -> LandDiagnosis | PumpDiagnosis | Rule | None:
        """Return what put the unit past a limit: pump, land, total or pressure, the worst; None within all limits.

        Of several that are equally bad the pump leads, and then one that is sure is named before one that is not, a
        land before a total, a total before a pressure, and of pressures the one that is farthest past its limit, those
        of gauges and log last. Without any reading gauges and log alone decide: all else is that of a new unit.
        """
        candidates: list[LandDiagnosis | PumpDiagnosis | Rule] = [*self.flagged]
        candidates += [self.pump] if self.pump.verdict.flagged else []
        if self.judged:
            candidates += [self.worst_total] if self.worst_total.verdict.flagged else []
            candidates += farthest_first(self.pressure_rules)
        candidates += farthest_first(self.vacuum_rules)
        candidates += [*farthest_first(self.gauge_rules), *farthest_first(self.log_rules)]
        return max(
            candidates,
            key=lambda each: (each.verdict.rank, each is self.pump, certainty(self._decision_on(each))),
            default=None,
        )

    @property
    def decision(self) -> Decision | None:
        """Return how sure the verdict of the unit is; within all limits, how sure the least sure of it is.

        None where nothing was measured, and where the description cannot be right.
        """
        decided_by = self.decided_by
        if self.impossible:
            return None
        if decided_by is not None:
            return self._decision_on(decided_by)
        if self.verdict == Verdict.NOT_MEASURED:
            return None
        every: list[LandDiagnosis | PumpDiagnosis | Rule] = [*self.lands, self.pump, *self.unit_rules]
        return max((self._decision_on(each) for each in every), key=certainty, default=None)

    @cached_property
    def provisional(self) -> tuple[AssumedBasis, ...]:
        """Return which representative values the verdict rests on: past a limit those of the rule that decided."""
        if self.verdict == Verdict.NOT_MEASURED:
            return ()
        decided_by = self.decided_by
        rules: list[tuple[Rule, Iterable[Land]]] = []
        on: list[LandDiagnosis | PumpDiagnosis | Rule] = [*self.lands, *self.unit_rules]
        for each in on if decided_by is None else [decided_by]:
            if isinstance(each, LandDiagnosis):
                mine = each.rules if decided_by is None else [each.deciding]
                rules += [(rule, [each.state.land]) for rule in mine if rule is not None]
            else:
                rules += [(rule, self.controller.lands) for rule in ([each] if isinstance(each, Rule) else each.rules)]
        states = [land.state for land in self.lands]
        return Representative(self.controller, self.fluid, states, uses_slip=self.model.uses_slip).bases(rules)

    def with_mileage(self, mileage_km: float | None) -> Diagnosis:
        """Return the same at another mileage: only when lands are to be replaced, and a message, follow from it.

        Whether a rate of wear is known is said once, before what is said of the instruments.

        Parameters
        ----------
        mileage_km
            [km]; None for the one that the sheet's head states.
        """
        mileage = mileage_of(mileage_km, self.readings)
        if mileage == self.mileage:
            return self
        lands = tuple(
            replace(land, replace_mileage=replace_mileage(land.rules, mileage, land.uncertainty)) for land in self.lands
        )
        messages = [each for each in self.messages if each.code != NO_RATE]
        rateless = None if self.uncertainty is None else without_rate(self.uncertainty.lands, mileage)
        if rateless is not None and self.uncertainty is not None:
            of_instruments = set(self.uncertainty.messages)
            place = next((at for at, each in enumerate(messages) if each in of_instruments), len(messages))
            messages.insert(place, rateless)
        return replace(self, mileage=mileage, lands=lands, messages=tuple(messages))

    @property
    def upper_bound(self) -> bool:
        """Tell whether leakage is an upper bound, as the controller's file does not say where all of its lands leak."""
        return bool(self.controller.gaps_not_described)

    def _decision_on(self, judged: LandDiagnosis | PumpDiagnosis | Rule) -> Decision | None:
        if isinstance(judged, LandDiagnosis):
            return judged.decision
        rule = judged.deciding if isinstance(judged, PumpDiagnosis) else judged
        decided = None if rule is None else self.decided(rule)
        return decided.decision if decided else None

    @property
    def valve_body(self) -> Diagnosis:
        """Return the same with its pump as new, where that is past a limit: what is left is up to the valve body."""
        new = self.pump_new if self.pump.verdict.flagged else None
        return self if new is None else replace(new, repairs=self.repairs)

    @cached_property
    def impossible(self) -> tuple[Projection, ...]:
        """Return the file's conditions whose pressure a new unit as described cannot hold, as it would be then."""
        own = [each for each in self.unworn_projections if each.condition in self.controller.operating_points]
        return tuple(each for each in own if cannot_be(each)) if self.judged else ()

    def decided(self, rule: Rule) -> RuleDecision | None:
        """Return the decision on one of the unit's rules; None where it depends on readings that are not there.

        Parameters
        ----------
        rule
            one of the unit's.
        """
        shown = [*(self.pressures.decisions if self.pressures else ()), *(self.log.decisions if self.log else ())]
        shown += [*self.pump.decisions, *(each.decided for each in self.vacuum if each.decided)]
        measured = next((each for each in shown if each.rule == rule), None)
        computed = self.uncertainty.on(rule) if self.uncertainty else None
        return measured or (computed if self.verdict_on(rule) != Verdict.NOT_MEASURED else None)

    @property
    def gauge_rules(self) -> tuple[Rule, ...]:
        """Return the rules that judge what gauges showed."""
        return self.pressures.rules if self.pressures else ()

    @property
    def vacuum_rules(self) -> tuple[Rule, ...]:
        """Return the rules that lands under one plug are past together; within them none of the lands is measured."""
        of_several = [each.decided.rule for each in self.vacuum if each.decided and (len(each.lands) > 1 or each.open)]
        return tuple(rule for rule in of_several if rule.verdict.flagged)

    @property
    def log_rules(self) -> tuple[Rule, ...]:
        """Return the rules that judge the log: main pressure beside what is permitted, and what was commanded."""
        return self.log.rules if self.log else ()

    @property
    def unit_rules(self) -> tuple[Rule, ...]:
        """Return every rule that judges the whole unit: totals first, gauges and log last, alone without readings."""
        of_clearances = (*self.total_rules, *self.pressure_rules) if self.judged else ()
        return (*of_clearances, *self.vacuum_rules, *self.gauge_rules, *self.log_rules)

    def pressure_rules_at(self, projection: Projection) -> tuple[Rule, ...]:
        """Return the rules of reserve, circuits and permissible pressure at a condition.

        Parameters
        ----------
        projection
            at that condition.
        """
        return tuple(rule for rule in self.pressure_rules if rule.condition == projection.condition)

    def pressure_rule(self, projection: Projection, kind: RuleKind, circuit: Circuit | None = None) -> Rule | None:
        """Return one of them; None where that is not judged.

        Parameters
        ----------
        projection
            at that condition.
        kind
            what the rule judges.
        circuit
            whose loss it judges; None for reserve and permissible pressure.
        """
        rules = self.pressure_rules_at(projection)
        return next((rule for rule in rules if rule.kind is kind and rule.circuit == circuit), None)

    @cached_property
    def verdict(self) -> Verdict:
        """Return the worst of pump, lands, totals, gauges and log; ``not_measured`` where none of them is there.

        Readings that cannot be true, of pairs tighter than new ones, are never ok.
        """
        decided_by = self.decided_by
        if decided_by is not None:
            return decided_by.verdict
        if self.too_tight:
            return Verdict.WATCH
        within: list[Verdict] = [land.verdict for land in self.lands if land.verdict == Verdict.OK]
        within += () if self.judged else [rule.verdict for rule in self.unit_rules]
        return worst(within or [Verdict.NOT_MEASURED])

    @property
    def without_sheet(self) -> bool:
        """Return whether a log, gauge readings or both are all there is: neither measuring sheet nor vacuum test."""
        return self.readings is None and not self.vacuum and (self.log is not None or self.pressures is not None)

    @property
    def unmeasured(self) -> tuple[LandDiagnosis, ...]:
        """Return the lands whose clearance was not measured whole, but for those that a ring seals."""
        return tuple(land for land in self.lands if land.state.land.seal is None and not land.state.whole)

    @cached_property
    def open_lands(self) -> frozenset[LandKey]:
        """Return the lands of which nothing that was measured shows wear, but for those that a ring seals, by key."""
        return frozenset(land.key for land in self.lands if not (land.state.shows_wear or land.state.land.seal))

    @property
    def in_doubt(self) -> tuple[LandDiagnosis, ...]:
        """Return the lands whose readings contradict themselves."""
        return tuple(land for land in self.lands if land.in_doubt)

    @property
    def too_tight(self) -> bool:
        """Tell whether pairs measure so much tighter than new ones that the readings, or the description, are wrong.

        One pair may be so by chance; two are not, nor one whose spool could hardly move: choice of this project.
        """
        tight = [land.state for land in self.lands if land.suspect]
        return len(tight) > 1 or any(each.radial_clearance < 0.25 * each.land.mounting_range[0] for each in tight)

    @property
    def passed(self) -> bool:
        """Tell whether the unit may be shown as good: within all limits, all of it measured, no reading in doubt.

        Without a measuring sheet gauges and log alone say so.
        """
        return self.verdict == Verdict.OK and (self.without_sheet or not (self.unmeasured or self.in_doubt))

    @cached_property
    def judged(self) -> int:
        """Count the lands that were measured, on both parts or on one, but for those that a ring seals."""
        return sum(land.state.judged for land in self.lands)

    @cached_property
    def measured(self) -> int:
        """Count the lands of which both parts were measured, or what they leak."""
        return sum(land.state.whole for land in self.lands)


def mileage_of(stated: float | None, readings: Readings | None) -> float | None:
    """Return the mileage [km] that was stated, or else the one of the sheet's head."""
    return stated if stated is not None or readings is None else readings.identity.mileage
