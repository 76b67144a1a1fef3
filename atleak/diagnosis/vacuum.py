"""Turn readings of a vacuum stand into clearances and flows.

A plug on one land measures that land; a plug on several tells what they leak together. What is not known is drawn: the
gauge, the stand's C_d A, where each spool lay in the test and lies in service, contact lengths and viscosity.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Controller, Land
from atleak.catalogue.instruments import Instruments, load_instruments
from atleak.catalogue.limits import Limits, RuleKind
from atleak.catalogue.operating_point import HOT_IDLE
from atleak.catalogue.repairs import LandKey
from atleak.catalogue.words import in_um
from atleak.common.errors import InputError, Message, Place, one_of
from atleak.common.sentences import Name, Sentence
from atleak.common.units import IN_HG, Quantity
from atleak.common.verdicts import Verdict
from atleak.diagnosis.rules import Rule
from atleak.diagnosis.uncertainty.assess import COVERAGE
from atleak.diagnosis.uncertainty.assumptions import DEFAULTS, Assumptions
from atleak.diagnosis.uncertainty.decision import GUARD_FACTOR, RuleDecision, decide_rule
from atleak.diagnosis.uncertainty.draws import Interval, interval_of, stream_of
from atleak.diagnosis.uncertainty.propagation import SEED
from atleak.diagnosis.uncertainty.sources import find_sources
from atleak.diagnosis.vacuum_stand import StandFlow, flow_of_reading
from atleak.engine.projection import BesideNew
from atleak.equations import clearance as clearance_equations
from atleak.equations.gap import eccentricity_factor
from atleak.equations.vacuum import air_viscosity, equal_clearance, gap_air_flow, orifice_air_flow
from atleak.measurements.clearances import LandClearance, with_leak
from atleak.measurements.readings import Readings
from atleak.measurements.vacuum import LeakClearance, VacuumReading, VacuumStand, VacuumTable

_DRAWS = 4096
_LEAST = 0.02 / IN_HG  # [Pa] below ambient, that a reading is taken for at least: none tells no clearance
_SURE = 0.975  # probability from which a difference is significant, to either side


@dataclass(frozen=True)
class LandShare:
    """What one of several lands under a plug has if it alone is worn."""

    land: Land
    low: float  # [m] beside others as wide as new ones can be
    high: float  # [m] with all that leaks past it


@dataclass(frozen=True)
class VacuumChange:
    """How much an equivalent clearance has changed from the reading before a repair to that behind it."""

    before: VacuumReading
    after: VacuumReading
    change: float  # [m] of the equivalent clearance, negative where it is tighter
    interval: Interval  # [m]
    significant: bool  # zero lies outside of the interval


@dataclass(frozen=True)
class VacuumFinding:
    """What the last state of a plugged circuit, or of a single land, tells."""

    readings: tuple[VacuumReading, ...]  # those that count: of the repaired bore where there are such
    lands: tuple[Land, ...]  # past which air came in
    stand: StandFlow
    clearance: float  # [m] common to all, of which the even gaps leak as much
    interval: Interval  # [m]
    new_clearance: float  # [m] common to all, when new
    widest_new: float  # [m] likewise, of the widest new lands
    each: tuple[LandShare, ...]  # none where there is but one
    passes: float  # [m³] Σ D c³/l with every spool concentric; at least, where `open`
    u_passes: float  # [m³] standard uncertainty of it by gauge and stand; of a bound, by the stand
    leakage: float | None  # [m³/s] at hot idle, or the stated condition; None where no pressure is applied to them
    leakage_interval: Interval | None  # [m³/s]
    decided: RuleDecision | None  # by the wear limits on the common clearance; None where the set has none
    change: VacuumChange | None
    tight: bool  # as good as closed: an upper bound
    open: bool  # hardly any vacuum: a lower bound

    @property
    def reading(self) -> VacuumReading:
        """Return the last of the readings that count."""
        return self.readings[-1]

    @property
    def verdict(self) -> Verdict:
        """Return the verdict of the wear limits on the common clearance."""
        return Verdict.NOT_MEASURED if self.decided is None else self.decided.rule.verdict


class _Tests:
    """The readings of a table with what is uncertain of them drawn, arrays of shape (draws,)."""

    def __init__(self, table: VacuumTable, controller: Controller, assumptions: Assumptions) -> None:
        self.table, self.assumptions = table, assumptions
        self.stand = table.stand
        self.air = self.stand.temperature, float(air_viscosity(self.stand.temperature))
        self._of_stand = stream_of(SEED, 71).standard_normal(_DRAWS)
        by_key = {land.key: land for land in controller.lands}
        self.groups: list[tuple[tuple[VacuumReading, ...], tuple[Land, ...]]] = []
        for group in table.by_lands:
            lands = tuple(_land(by_key, key, group[0].place) for key in dict.fromkeys(group[0].lands))
            self.groups.append((group, tuple(land for land in lands if not land.seal)))

    def flow_of(self, reading: VacuumReading) -> StandFlow:
        """Return C_d A of the stand as it was fitted; InputError where nothing tells it."""
        return flow_of_reading(self.table, reading, self.assumptions)

    def position(self, seed: int, lands: Sequence[Land]) -> Any:
        """Draw where spools lie in a test, one place for all lands of a component; shape (lands, draws)."""
        drawn = {
            component: stream_of(SEED, 72, seed, place).random(_DRAWS)
            for place, component in enumerate(dict.fromkeys(land.component for land in lands))
        }
        ratio = np.array([drawn[land.component] for land in lands]) * self.assumptions.tested_position
        return eccentricity_factor(ratio, 1.0)

    def split(self, seed: int, lands: Sequence[Land]) -> Any:
        """Draw which part of all that leaks goes past each land, any alike likely; shape (lands, draws)."""
        return stream_of(SEED, 76, seed).dirichlet(np.ones(len(lands)), _DRAWS).T

    def together(self, seed: int, lands: Sequence[Land], split: Any) -> Any:
        """Draw how much more lands pass together than concentric ones: mostly where the leakiest spool lies."""
        return np.sum(split * self.position(seed, lands), axis=0, keepdims=True)

    def length(self, seed: int, lands: Sequence[Land]) -> Any:
        """Draw contact lengths [m], shape (lands, draws)."""
        spread = [self.assumptions.of_contact_length(measured=land.contact_length_measured) for land in lands]
        nominal = np.array([[land.contact_length] for land in lands])
        drawn = stream_of(SEED, 73, seed).standard_normal((len(lands), _DRAWS)) * np.array(spread)[:, None]
        return np.maximum(nominal + drawn, 0.1 * nominal)

    def air_flow(self, reading: VacuumReading, seed: int, *, gauge: bool = True, stand: bool = True) -> tuple[Any, Any]:
        """Return the flow of air [kg/s] that a reading tells, and the pressure in the circuit [Pa], drawn.

        A reading above the supply is one of the closed stand: half of the draws leak, none tells that nothing does.
        """
        flow = self.flow_of(reading)
        half = max(self.assumptions.vacuum_gauge, _LEAST)
        off = half * (2.0 * stream_of(SEED, 74, seed).random(_DRAWS) - 1.0) * gauge
        vacuum = np.clip(min(reading.vacuum, self.stand.supply) + off, _LEAST, self.stand.supply)
        area = flow.area * np.exp(flow.relative_uncertainty * self._of_stand * stand)
        pressure = self.stand.ambient - vacuum
        supply = self.stand.ambient - self.stand.supply
        return orifice_air_flow(pressure, supply, area, self.stand.temperature), pressure

    def clearance(self, flow: Any, pressure: Any, lands: Sequence[Land], lengths: Any, factors: Any) -> Any:
        """Return the clearance common to some lands past which air flows [m]."""
        diameters = np.array([[land.nominal_diameter] for land in lands])
        return equal_clearance(flow, pressure, self.stand.ambient, diameters, lengths, *self.air, factors)


def _land(by_key: Mapping[LandKey, Land], key: LandKey, place: Place) -> Land:
    if key not in by_key:
        names = (f"{component}/{land}" for component, land in by_key)
        raise InputError(Sentence("no such land"), place=place, value="{}/{}".format(*key), expected=one_of(names))
    return by_key[key]


def _last_state(group: Sequence[VacuumReading]) -> tuple[VacuumReading, ...]:
    repaired = tuple(each for each in group if each.repaired)
    return repaired or tuple(group)


def with_vacuum(
    states: Sequence[LandClearance],
    readings: Readings | None,
    controller: Controller,
    vacuum: VacuumTable,
    instruments: Instruments | None = None,
    assumptions: Assumptions = DEFAULTS,
) -> tuple[LandClearance, ...]:
    """Return the clearance of every land with what the vacuum test tells of lands that were plugged alone.

    Parameters
    ----------
    states
        as diameters tell them.

    Raises
    ------
    InputError
        a reading of a land that the valve body does not have, or with a stand of which nothing tells its C_d A.
    """
    tests = _Tests(vacuum, controller, assumptions)
    leaks = {
        lands[0].key: _leak(tests, _last_state(group), lands[0], number)
        for number, (group, lands) in enumerate(tests.groups)
        if len(lands) == 1 and _last_state(group)[-1].vacuum > assumptions.vacuum_gauge  # else no more than a bound
    }
    if not leaks:
        return tuple(states)
    known = find_sources(states, readings, controller, instruments or load_instruments(), assumptions)[0]
    return tuple(
        with_leak(state, land.standard_uncertainty, leaks[state.land.key]) if state.land.key in leaks else state
        for state, land in zip(states, known, strict=True)
    )


def _leak(tests: _Tests, readings: Sequence[VacuumReading], land: Land, number: int) -> LeakClearance:
    """Return the clearance of one land with its sources: each alone, about the mean of the cube."""
    usual = {"lengths": np.array([[land.contact_length]]), "factors": np.mean(tests.position(number, [land]))}
    cubes = _cubes(tests, readings, [land], number, tests.length(number, [land]), tests.position(number, [land]))
    clearance = float(np.cbrt(cubes.mean()))
    per_cube = 3.0 * clearance**2

    def by(**drawn: Any) -> float:
        """Return the standard uncertainty [m] by what is drawn alone."""
        how = {name: drawn.pop(name, value) for name, value in usual.items()}
        on = {"gauge": False, "stand": False} | drawn
        spread = float(np.std(_cubes(tests, readings, [land], number, how["lengths"], how["factors"], **on)))
        return spread / per_cube if per_cube else 0.0

    return LeakClearance(
        clearance=clearance,
        u_reading=by(gauge=True),
        u_stand=by(stand=True),
        u_position=by(factors=tests.position(number, [land])),
        u_length=by(lengths=tests.length(number, [land])),
        reading=readings[-1],
    )


def _cubes(
    tests: _Tests,
    readings: Sequence[VacuumReading],
    lands: Sequence[Land],
    number: int,
    lengths: Any,
    factors: Any,
    *,
    gauge: bool = True,
    stand: bool = True,
) -> Any:
    """Return the cube of the common clearance [m³], drawn; several readings count by how well each tells it."""
    cubes, weights = [], []
    for place, reading in enumerate(readings):
        air = tests.air_flow(reading, 100 * number + place, gauge=gauge, stand=stand)
        cubes.append(tests.clearance(*air, lands, lengths, factors) ** 3)
        if len(readings) > 1:
            of_gauge = tests.air_flow(reading, 100 * number + place, stand=False)
            even = np.array([[land.contact_length] for land in lands])
            weights.append(1.0 / max(float(np.var(tests.clearance(*of_gauge, lands, even, 1.0) ** 3)), 1e-60))
    return np.average(cubes, axis=0, weights=weights or None)


def vacuum_findings(
    vacuum: VacuumTable,
    unit: BesideNew,
    limits: Limits,
    assumptions: Assumptions = DEFAULTS,
    guard_factor: float = GUARD_FACTOR,
) -> tuple[VacuumFinding, ...]:
    """Return what every plug tells: of one land, or of several together.

    Parameters
    ----------
    unit
        as measured and new; at hot idle, or at its stated condition without one, the flow is computed.
    limits
        whose wear limits judge the common clearance beside that when new.

    Raises
    ------
    InputError
        a reading of a land that the valve body does not have, or with a stand of which nothing tells its C_d A.
    """
    tests = _Tests(vacuum, unit.model.controller, assumptions)
    return tuple(
        _finding(tests, group, lands, number, unit, limits, guard_factor)
        for number, (group, lands) in enumerate(tests.groups)
        if lands
    )


def _finding(
    tests: _Tests,
    group: Sequence[VacuumReading],
    lands: Sequence[Land],
    number: int,
    unit: BesideNew,
    limits: Limits,
    guard_factor: float,
) -> VacuumFinding:
    readings = _last_state(group)
    lengths, split = tests.length(number, lands), tests.split(number, lands)
    cubes = _cubes(tests, readings, lands, number, lengths, tests.together(number, lands, split))
    sizes = np.array([land.nominal_diameter for land in lands])
    last, gauge = readings[-1], tests.assumptions.vacuum_gauge
    drawn, clearance = np.cbrt(cubes), float(np.cbrt(cubes.mean()))
    is_open = last.vacuum <= gauge  # it says no more than that they are so wide at least
    if is_open:
        clearance = interval_of(drawn, COVERAGE)[0]
    new, widest, high = (_common(lands, name) for name in ("new_clearance", "widest_new", "mounting_high"))
    decided = None
    if limits.wear is not None and high > 0.0:
        wear = replace(limits.wear, levels=limits.wear.of_wear(high, widest - high))
        reached = tuple(float(np.mean(drawn / high - 1.0 >= limit)) for _, limit in wear.levels)
        where = Sentence("{target}", target=Name(readings[-1].target))
        rule = Rule(RuleKind.WEAR, None, clearance / high - 1.0, wear, where=where)
        spread = float(drawn.std()) / high
        ends = interval_of(drawn / high - 1.0, COVERAGE)
        decided = decide_rule(rule, (spread,) * len(reached), reached, guard_factor, skewed=True, interval=ends)
    usual = np.array([[land.contact_length] for land in lands])
    passes = _cubes(tests, readings, lands, number, usual, 1.0) * float(np.sum(1.0 / usual[:, 0] * sizes))
    passed, u_passed = float(passes.mean()), float(passes.std())
    if is_open:
        passed = interval_of(passes, COVERAGE)[0]
        u_passed = passed * tests.flow_of(last).relative_uncertainty
    flows = _service_flow(cubes, lands, lengths, split, unit, tests.assumptions, number)
    return VacuumFinding(
        readings=tuple(readings),
        lands=tuple(lands),
        stand=tests.flow_of(last),
        clearance=clearance,
        interval=interval_of(drawn, COVERAGE),
        new_clearance=new,
        widest_new=widest,
        each=_shares(tests, last, lands, number, lengths) if len(lands) > 1 else (),
        passes=passed,
        u_passes=u_passed,
        leakage=float(flows.mean()) if flows.any() else None,
        leakage_interval=interval_of(flows, COVERAGE) if flows.any() else None,
        decided=decided,
        change=_change(tests, group, lands, number, lengths, split),
        tight=last.vacuum >= tests.stand.supply - gauge,
        open=is_open,
    )


def _common(lands: Sequence[Land], name: str) -> float:
    """Return the clearance common to lands that leak as much air as they do with one of their own each [m]."""
    weights = [land.nominal_diameter / land.contact_length for land in lands]
    cubes = [getattr(land, name) ** 3 for land in lands]
    return float(np.cbrt(np.average(cubes, weights=weights)))


def _shares(
    tests: _Tests, reading: VacuumReading, lands: Sequence[Land], number: int, lengths: Any
) -> tuple[LandShare, ...]:
    """Return what each of several lands has if it alone is worn, at least and at most."""
    flow, pressure = tests.air_flow(reading, 100 * number)
    factors = tests.position(number, lands)
    d, widest = (np.array([[getattr(land, name)] for land in lands]) for name in ("nominal_diameter", "widest_new"))
    new = gap_air_flow(pressure, tests.stand.ambient, d, widest, lengths, *tests.air, factors)
    shares = []
    for place, land in enumerate(lands):
        only = [land], lengths[[place]], factors[[place]]
        left = np.maximum(flow - (new.sum(axis=0) - new[place]), 0.0)
        least, most = (tests.clearance(part, pressure, *only) for part in (left, flow))
        shares.append(LandShare(land, interval_of(least, COVERAGE)[0], interval_of(most, COVERAGE)[1]))
    return tuple(shares)


def _service_flow(
    cubes: Any,
    lands: Sequence[Land],
    lengths: Any,
    split: Any,
    unit: BesideNew,
    assumptions: Assumptions,
    number: int,
) -> Any:
    """Return what the lands leak in service [m³/s], drawn: spools lie elsewhere unless the profile sets their place.

    How the leak is shared out among several is not known: any split of it is alike likely, the mean an equal one.
    """
    now = next((each for each in unit.now if each.condition.name == HOT_IDLE), unit.now[0])
    model, temperature = unit.model, now.condition.temperature
    nu = model.fluid.kinematic_viscosity(temperature, model.profile.viscosity)
    rho = model.fluid.density(temperature, model.profile.viscosity)
    stream = stream_of(SEED, 75, number)
    nu = nu * np.exp(assumptions.viscosity * stream.standard_normal(_DRAWS))
    weights = np.array([[land.nominal_diameter / land.contact_length] for land in lands])
    places = {component: stream.random(_DRAWS) for component in dict.fromkeys(land.component for land in lands)}
    nu = nu * model.fluid.viscosity_factor(math.sqrt(12.0) * (stream.random(_DRAWS) - 0.5))
    total = np.zeros(_DRAWS)
    for land, part, length, weight in zip(lands, split, lengths, weights, strict=True):
        cold = np.cbrt(cubes * part * weights.sum() / weight)
        rate = land.thermal_rate(land.nominal_diameter, land.nominal_sleeve_diameter)
        mean = clearance_equations.effective_clearance(cold, rate, temperature - REFERENCE_TEMPERATURE)
        diameter = model.law.diameter(land.nominal_diameter, mean)
        factor = eccentricity_factor(places[land.component], 1.0) if not model.profile.sets_position else None
        for gap in now.gaps_of(land.key):
            total += model.law.flow(gap.pressure_drop, diameter, mean, nu, rho, length, factor)
    return total


def _change(
    tests: _Tests, group: Sequence[VacuumReading], lands: Sequence[Land], number: int, lengths: Any, split: Any
) -> VacuumChange | None:
    """Return the change from worn to repaired; the stand errs alike in both, the spool lies elsewhere."""
    worn, repaired = ([each for each in group if each.repaired is state] for state in (False, True))
    if not worn or not repaired:
        return None
    before, after = (
        np.cbrt(_cubes(tests, each, lands, seed, lengths, tests.together(seed, lands, split)))
        for each, seed in ((worn, 5000 + number), (repaired, number))
    )
    drawn = after - before
    interval = interval_of(drawn, 2.0 * _SURE - 1.0)
    significant = not interval[0] <= 0.0 <= interval[1]
    return VacuumChange(worn[-1], repaired[-1], float(drawn.mean()), interval, significant)


def vacuum_messages(
    findings: Iterable[VacuumFinding], stand: VacuumStand, assumptions: Assumptions = DEFAULTS
) -> Iterator[Message]:
    """Yield what is to be said of a vacuum test beside its numbers."""
    findings = tuple(findings)
    assumed = [each.reading for each in findings if not each.stand.known]
    if assumed:
        text = Sentence(
            "Vacuum test: the stand was not calibrated, so a discharge coefficient of {coefficient:g} is assumed for "
            "its orifice"
        )
        if stand.calibrations:
            text = Sentence(
                "Vacuum test: no calibration says that it was made with the stand's orifice of this reading, so a "
                "discharge coefficient of {coefficient:g} is assumed for it"
            )
        text = text.of(coefficient=assumptions.discharge_coefficient)
        yield Message("info", "vacuum_not_calibrated", text, assumed[0].place)
    for each in findings:
        target, place = Name(each.reading.target), each.reading.place
        shown = Quantity(each.reading.vacuum * IN_HG, "vacuum", 1)
        if each.open:
            text = Sentence(
                "Vacuum test, {target}: {reading} {reading.unit} is hardly any vacuum, so {clearance} {clearance.unit} "
                "is a lower bound: check that the plug seals, or take a larger orifice",
                target=target,
                reading=shown,
                clearance=in_um(each.interval[0]),
            )
            yield Message("warning", "vacuum_open", text, place)
        elif each.tight:
            text = Sentence(
                "Vacuum test, {target}: {reading} {reading.unit} is that of the closed stand, so {clearance} "
                "{clearance.unit} is an upper bound: take a smaller orifice",
                target=target,
                reading=shown,
                clearance=in_um(each.interval[1]),
            )
            yield Message("info", "vacuum_tight", text, place)
        if len(each.readings) > 1:
            text = Sentence(
                "Vacuum test, {target}: {readings} {first.unit} count together",
                target=target,
                readings=[Quantity(one.vacuum * IN_HG, "vacuum", 1) for one in each.readings],
                first=shown,
            )
            yield Message("info", "vacuum_read_again", text, place)
        if len(each.lands) > 1 and each.verdict.flagged:
            text = Sentence(
                "Vacuum test, {target}: {count} lands leak together as if each had {clearance} {clearance.unit}, new "
                "{new} {new.unit}: measure them one by one",
                target=target,
                count=len(each.lands),
                clearance=in_um(each.clearance),
                new=in_um(each.new_clearance),
            )
            yield Message("warning", "vacuum_shared_leak", text, place)


def repaired_messages(findings: Iterable[VacuumFinding], *, shown_before: bool) -> Iterator[Message]:
    """Say that a repaired bore and what the unit showed in the car may be of two states.

    Parameters
    ----------
    shown_before
        whether gauges, a log or a jug tell of the unit too.
    """
    repaired = [each.reading for each in findings if each.reading.repaired]
    if repaired and shown_before:
        text = Sentence(
            "The vacuum test holds repaired bores: gauges, log and jug are taken as of the same state. Were they read "
            "before the repair, leave the repaired readings out to find the cause"
        )
        yield Message("warning", "vacuum_repaired_since", text, repaired[0].place)
