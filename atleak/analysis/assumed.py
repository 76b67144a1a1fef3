"""List every value of a result that is neither measured nor published, and what it does to the verdict of the unit.

Each value is moved to both ends of what it may be, all of its kind together, and the unit solved with it, as measured
and as it may have been when new. The way δ by which that brings a quantity nearer to its limit moves its standard score
z in the draws: the probability of being past the limit becomes ``Φ((z + δ/u)/u')``. Where draws lie to one side, both
scores are read off the probabilities of the limits and the ends of the interval. The draws hold what a value is off
that is drawn itself, so that u' lacks it. What is no number, such as which land parts which pressures, cannot be moved.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from atleak.catalogue.circuits import SetPressure
from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.entries import Evidence
from atleak.catalogue.fluid import USED_THINNER
from atleak.catalogue.known_values import known_values
from atleak.catalogue.limits import LimitOrigin, RuleKind
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.repairs import LandKey
from atleak.common.memory import kept_with
from atleak.common.units import DM3_MIN, KPA, MM, MM2_S, PERCENT, UM
from atleak.common.verdicts import VERDICTS, Band, Verdict
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.rules import Rule
from atleak.diagnosis.uncertainty import DEFAULTS, Decision, RuleDecision, certainty
from atleak.diagnosis.uncertainty.decision import DECISIONS, LevelDecision
from atleak.diagnosis.uncertainty.drawn_unit import FACTORS, FLUID_STATE, DemandShape, Drawn, DrawnLands
from atleak.diagnosis.uncertainty.draws import flow_ratio
from atleak.diagnosis.uncertainty.land_draws import LandInState
from atleak.diagnosis.uncertainty.one_sided_wear import EXPONENTS, Bore, with_one_side
from atleak.diagnosis.uncertainty.sources import MEASURING_TEMPERATURE_SOURCE, OF_A_DIAMETER, PARTS, LandSources
from atleak.engine.network import Network
from atleak.engine.operation import spread_over
from atleak.engine.projection import Projection
from atleak.equations.clearance import one_sided_moments
from atleak.equations.gap import eccentricity_factor
from atleak.equations.statistics import normal_cdf, normal_quantile

# All choices of this project.
UNSTATED = 0.10  # relative: what a value may be off of which nothing says how sure it is
ALLOYS = 0.05  # relative: by which the expansion of one alloy differs from another's
_USED = 1.0 - USED_THINNER[-1] / PERCENT  # viscosity of a used fluid over that of the fresh one, the least
_REACH = 1.96  # standard uncertainties to the end of 95 % of a normal distribution
_RECTANGLE = 1.65  # the same of a rectangular one
_THIRDS = 1.22  # from half of the wear to one side to none or all of it, all three alike likely
_FEWEST = 1e-4  # probability under which every draw is on one side of a limit
_SHORTEST = 0.1  # of a contact length
_HALF = "spool_only", "sleeve_only"  # states of lands of which one part was measured


class Ending(NamedTuple):
    """What the unit would be with a value at one end of what it may be."""

    verdict: Verdict
    decision: Decision
    probability: float | None  # that what decides there is past its limit; of the pump's clearances None


@dataclass(frozen=True)
class AssumedValue:
    """One value, or all of one kind that are moved together, and what they do to the verdict of the unit."""

    what: str  # its kind; `rule` tells which of the limits
    stands_in: str  # id of the file, or ``assumptions`` or ``profile``
    count: int
    values: tuple[float, float] | None  # least and greatest, in the unit of atleak's records; None of what is no number
    kind: str | None  # of quantity
    off: float | None  # what it may be off either way, in that unit or % of it; None where it is not moved
    relative: bool  # whether that is % of it
    ends: tuple[Ending, Ending, Ending] | None = None  # as it is, low, high; None where that cannot be told
    rule: RuleKind | None = None  # of a limit

    @property
    def changes(self) -> str | None:
        """Return what it would change: ``verdict``, ``decision`` or ``nothing``; None where that cannot be told.

        What counts in no verdict, but in the cause of what gauges or a log miss, changes the ``cause`` alone.
        """
        if self.what in DEFAULTS.priors:
            return "cause"
        if self.ends is None:
            return None
        now, *moved = self.ends
        if any(end.verdict != now.verdict for end in moved):
            return "verdict"
        return "decision" if any(end.decision != now.decision for end in moved) else "nothing"


def assumed_values(diagnosis: Diagnosis) -> tuple[AssumedValue, ...]:
    """Return every value of a result that is neither measured nor published, those of the valve body's file first.

    Parameters
    ----------
    diagnosis
        of the unit; where nothing was measured no value has an effect.
    """
    return kept_with(diagnosis, "assumed", "", lambda: _values(diagnosis), most=1)


def _values(diagnosis: Diagnosis) -> tuple[AssumedValue, ...]:
    of = _Representative(diagnosis.controller)
    rows = [*_of_valve_body(diagnosis, of), *_of_condition(diagnosis, of), *_of_fluid(diagnosis)]
    rows += [*_of_readings(diagnosis), *_of_limits(diagnosis)]
    ends = _Ends(diagnosis, of, [each.what for each in rows if each.off is not None]).endings
    return tuple(replace(each, ends=ends.get(each.what)) for each in rows)


def _row(
    what: str, of: str, values: Iterable[float], kind: str | None, off: float | None, *, relative: bool = False
) -> Iterator[AssumedValue]:
    given = [*values]
    if given:
        yield AssumedValue(
            what, of, len(given), (float(min(given)), float(max(given))) if kind else None, kind, off, relative
        )


def _part(what: str, of: str, values: Iterable[float], kind: str, off: float) -> Iterator[AssumedValue]:
    return _row(what, of, values, kind, off * PERCENT, relative=True)


def _chosen(diagnosis: Diagnosis, name: str) -> bool:
    """Tell whether an assumption is that of this project; the workshop may have set its own."""
    return diagnosis.gauge_card.assumptions.settings[name] == DEFAULTS.settings[name]


def _of_valve_body(diagnosis: Diagnosis, of: _Representative) -> Iterator[AssumedValue]:
    u, file, point = diagnosis.gauge_card.assumptions, diagnosis.controller.id, diagnosis.projection.condition
    states = [land.state for land in diagnosis.lands]
    lengths = (each.land.contact_length * MM for each in states if "contact_length_mm" in each.land.representative)
    yield from _row("contact_length", file, lengths, "length", _REACH * u.contact_length * MM)
    new = [each.land.mounting_range for each in states if "mounting_clearance_um" in each.land.representative]
    for row in _row("mounting_clearance", file, np.ravel(new) * UM, "clearance", _REACH * u.mounting_clearance * UM):
        yield replace(row, count=len(new))
    bare = [each.land for each in states if each.status in _HALF]
    diameters = (land.nominal_diameter * MM for land in bare if "nominal_diameter_mm" in land.representative)
    yield from _row("nominal_diameter", file, diameters, "length", _REACH * u.nominal_diameter * MM)
    yield from _part("materials", file, of.expansions.values(), "expansion", ALLOYS)
    yield from _row("gaps", file, [0.0] * of.count("gaps"), None, None)
    yield from _row("gears", file, [0.0] * of.count("circuits", "gears"), None, None)
    yield from _part("feeds", file, (each * MM for each in of.feeds), "length", _REACH * u.feed)
    yield from _part("set_pressure", file, of.set_at(point), "pressure", UNSTATED)
    yield from _part("sections", file, of.ratios, "number", UNSTATED)
    yield from _part("leaks", file, (each.flow * DM3_MIN for each in of.leaks), "flow", _REACH * u.consumer_flow)
    taken = (each.at(point) * DM3_MIN for each in of.consumers)
    yield from _part("consumers", file, taken, "flow", _REACH * u.consumer_flow)
    lowest = (each.low * KPA for each in diagnosis.controller.permissible if each.low and not each.published)
    yield from _part("permissible_pressure", file, lowest, "pressure", UNSTATED)
    if of.count("pump", "displacement"):
        yield from _part("displacement", file, [diagnosis.controller.pump.displacement * 1e9], "displacement", UNSTATED)


def _of_condition(diagnosis: Diagnosis, of: _Representative) -> Iterator[AssumedValue]:
    """Yield what is drawn once for the unit: pump, pressures and temperature."""
    u, pump, file = diagnosis.gauge_card.assumptions, diagnosis.controller.pump, diagnosis.controller.id
    slip = diagnosis.model.uses_slip
    name, value, off = (
        ("slip_coefficient", pump.slip_coefficient or 0.0, u.slip_coefficient)
        if slip
        else ("volumetric_efficiency", pump.volumetric_efficiency, u.volumetric_efficiency)
    )
    stated = name in pump.representative
    if stated or _chosen(diagnosis, f"{name}_percent"):
        where = file if stated else "assumptions"
        yield from _part("pump_efficiency", where, [value], "number", _REACH * off)
    points, stated = [each.condition for each in diagnosis.projections], of.count("operating_points") > 0
    where = file if stated else "assumptions"
    for name, off in (("main_pressure", u.main_pressure), ("converter_pressure", u.converter_pressure)):
        if stated or _chosen(diagnosis, f"{name}_percent"):
            yield from _part(name, where, (getattr(each, name) * KPA for each in points), "pressure", _REACH * off)
    if stated or _chosen(diagnosis, "temperature_k"):
        warm = (each.temperature for each in points)
        yield from _row("temperature", where, warm, "temperature", _REACH * u.temperature)


def _of_fluid(diagnosis: Diagnosis) -> Iterator[AssumedValue]:
    fluid, u, at = diagnosis.fluid, diagnosis.gauge_card.assumptions, diagnosis.projection.condition.temperature
    nu = [float(fluid.kinematic_viscosity(at, diagnosis.profile.viscosity)) * MM2_S]
    if _chosen(diagnosis, "viscosity_percent"):
        yield from _part("viscosity", fluid.id, nu, "viscosity", _REACH * u.viscosity)
    if diagnosis.fluid_state_assumed:
        yield from _part("fluid_state", fluid.id, nu, "viscosity", 1.0 - _USED)
    low, high = fluid.viscosity_range
    ends = (nu[0] * low, nu[0] * high) if low < high else ()
    for row in _part(_named(FLUID_STATE), fluid.id, ends, "viscosity", (high - low) / (high + low)):
        yield replace(row, count=1)  # of the middle between them
    yield from _row("fluid_data", fluid.id, [0.0] * len(fluid.representative), None, None)


def _of_readings(diagnosis: Diagnosis) -> Iterator[AssumedValue]:
    u, unit = diagnosis.gauge_card.assumptions, diagnosis.uncertainty
    if diagnosis.profile.eccentricity == 0.0:
        yield from _row("eccentricity", "profile", [0.0], "number", 1.0)
    if unit is None:
        return
    if diagnosis.model.law.counts_form and _chosen(diagnosis, "one_sided_wear_percent"):
        half = 0.5 * u.one_sided_wear * PERCENT
        yield from _row("one_sided_wear", "assumptions", [half], "percent", half)
    if diagnosis.measured_at is not None and diagnosis.measured_at.assumed:
        at = [diagnosis.measured_at.value]
        yield from _row("measuring_temperature", "assumptions", at, "temperature", u.room_temperature)
    for part in PARTS if diagnosis.readings is not None else ():
        gauge = unit.instruments.of(part)
        if "calibration_um" in gauge.representative:
            yield from _row(f"{part}_gauge", gauge.id, [0.0], "clearance", _REACH * gauge.common * UM)


def _of_limits(diagnosis: Diagnosis) -> Iterator[AssumedValue]:
    """Yield the limits that are a choice of this project, and what counts in the cause of what is missing alone."""
    for kind, steps in diagnosis.limits.rules.items():
        if steps.origin is LimitOrigin.PROJECT:
            shown = kind.quantity or ("percent" if kind.unit else "number")
            limits = (limit * kind.factor for _, limit in steps.levels)
            for row in _part(_limit(kind), diagnosis.limits.id, limits, shown, UNSTATED):
                yield replace(row, rule=kind)
    for name, prior in diagnosis.gauge_card.assumptions.priors.items() if diagnosis.missing_measured else ():
        if _chosen(diagnosis, name):
            yield from _row(name, "assumptions", [prior.value], prior.kind, None)


def _limit(kind: RuleKind) -> str:
    return f"limit_{kind}"


def _named(factor: str) -> str:
    return "viscosity_range" if factor == FLUID_STATE else factor.replace(" ", "_")


class _Representative:
    """The representative values of a valve body, as its tables have them."""

    def __init__(self, controller: Controller) -> None:
        self.controller, entry = controller, controller.entry
        known = known_values(entry) if entry else ()
        self._known = [each for each in known if each.evidence is _ASSUMED]
        self.leaks, self.consumers = self._of("leaks"), self._of("consumers")
        tables = {each.id: each for each in (entry.circuits if entry else ())}
        self.set_by = {name for name, each in tables.items() if each.set_evidence is _ASSUMED}
        self.feeds = [
            feed.diameter
            for circuit in controller.circuits
            for table, feed in zip(tables[circuit.id].feeds if tables else (), circuit.feeds, strict=False)
            if table.evidence is _ASSUMED
        ]

    def _of(self, table: str) -> list[Any]:
        stated = getattr(self.controller.entry, table, ())
        each_of = zip(stated, getattr(self.controller, table), strict=False)
        return [each for at, each in each_of if at.evidence is _ASSUMED]

    def of(self, table: str) -> set[str]:
        """Return the names of those of a table that has names."""
        return {name for name, each in getattr(self.controller.entry, table, {}).items() if each.evidence is _ASSUMED}

    def count(self, table: str, value: str | None = None) -> int:
        """Count the values of a table, or those of one of its keys."""
        return sum(each.table == table and value in (None, each.value) for each in self._known)

    @property
    def expansions(self) -> Mapping[str, float]:
        """Return the expansion [1e-6/K] of each material."""
        lands, assumed = self.controller.lands, self.of("materials")
        found = {land.body_material: land.body_expansion for land in lands}
        found |= {land.spool_material: land.spool_expansion for land in lands}
        return {name: value * 1e6 for name, value in found.items() if name in assumed}

    @property
    def ratios(self) -> list[float]:
        """Return the ratio of p_s and p_m to main pressure."""
        return [self.controller.relations[name].ratio for name in sorted(self.of("pressures"))]

    def set_at(self, point: OperatingPoint) -> list[float]:
        """Return what circuits are set to at a condition [kPa], those that follow no other."""
        stated = (each.set_pressure for each in self.controller.circuits if each.id in self.set_by)
        own = (each.at(point) for each in stated if each is not None)
        return [each * KPA for each in own if each is not None]


_ASSUMED = Evidence.REPRESENTATIVE
_Key = tuple[RuleKind, str | None, Any]  # of a rule: its condition, and its land or circuit
_Past = Sequence[Any]  # by level: how far the quantity is past it, shape (columns,)


class _Ends:
    """The unit as it is in the first column, and with each value at its low and its high end in two more.

    ``set_to`` is by what the set pressures are multiplied in every column: a balance takes them as numbers.
    """

    def __init__(self, diagnosis: Diagnosis, of: _Representative, names: Sequence[str], set_to: float = 1.0) -> None:
        self.diagnosis, self.of, self.names, self.set_to = diagnosis, of, names, set_to
        self.assumptions = diagnosis.gauge_card.assumptions
        self.lands = diagnosis.uncertainty.lands if diagnosis.uncertainty else ()

    def _end(self, name: str, reach: float = 1.0) -> Any:
        """Return by how much a value is moved in every column: by nothing, and by ∓ that in its own two."""
        columns = np.zeros(1 + 2 * len(self.names))
        if name in self.names:
            at = 1 + 2 * self.names.index(name)
            columns[at : at + 2] = -reach, reach
        return columns

    # --- the verdict

    @property
    def endings(self) -> Mapping[str, tuple[Ending, Ending, Ending]]:
        """Return what the unit is now and at both ends of every value; nothing where nothing was measured."""
        diagnosis = self.diagnosis
        if diagnosis.decision is None or not self.lands:
            return {}
        judged = [self._judged(*each) for each in self._rules()]
        if diagnosis.pump.verdict.flagged:
            leads = certainty(diagnosis.decision) if diagnosis.decided_by is diagnosis.pump else 0
            of_pump = diagnosis.pump.verdict.rank, leads, math.nan
            rank, surely, nan = (np.full(1 + 2 * len(self.names), each) for each in of_pump)
            judged.append((rank, surely, nan))
        ranks, sure, likely = map(np.array, zip(*judged, strict=True))
        least = Verdict.OK.rank if diagnosis.decided_by else max(Verdict.OK.rank, diagnosis.verdict.rank)
        deciding = np.lexsort((likely, sure, ranks), axis=0)[-1], np.arange(ranks.shape[1])
        at = [
            Ending(VERDICTS[max(rank, least)], DECISIONS[how], None if math.isnan(p) else p)
            for rank, how, p in zip(*(each[deciding].tolist() for each in (ranks, sure, likely)), strict=True)
        ]
        return {name: (at[0], at[1 + 2 * place], at[2 + 2 * place]) for place, name in enumerate(self.names)}

    def _rules(self) -> Iterator[tuple[RuleDecision, _Past | None]]:
        """Yield every decision on the unit, and how far its quantity is past each limit; None where it stays."""
        past: dict[_Key, _Past] = {}
        for projection in self.diagnosis.projections:
            past |= self._with_set_pressures(projection)
        for land in self.lands:
            for each in land.rules if land.sources.state.judged else ():
                if each.rule.kind is not RuleKind.PAIR_SHARE:
                    yield each, self._of_clearance(land.sources, each)
                else:  # a land that has not surely grown draws too much by nothing that is moved here
                    yield each, past.get(_key(each.rule, land.key)) if land.sources.grown else None
        for rule in self.diagnosis.unit_rules:
            decided = self.diagnosis.decided(rule)
            if decided is not None:
                yield decided, past.get(_key(rule, rule.circuit.id if rule.circuit else None))

    def _judged(self, decided: RuleDecision, past: _Past | None) -> tuple[Any, Any, Any]:
        """Return the rank, the place in `DECISIONS`, and how likely the limit is passed that decides, by column."""
        rule, nothing, drawn = decided.rule, np.zeros(1 + 2 * len(self.names)), self._drawn
        by_limit = self._end(_limit(rule.kind), UNSTATED) if rule.origin is LimitOrigin.PROJECT else nothing
        sign, rank, passed, most = -1.0 if rule.steps.falling else 1.0, nothing + 1, nothing, nothing
        for number, level in enumerate(decided.levels):
            moved = nothing if past is None else _difference(past[number], past[number][0])
            over, u = sign * (rule.value - level.limit), decided.level_uncertainties[number]
            of_limit = abs(level.limit) * by_limit if math.isfinite(level.limit) else nothing
            moved = moved - sign * of_limit
            likely = _moved(decided, level, u, moved, drawn)
            verdict = level.level.verdict if isinstance(level.level, Band) else level.level
            reached = likely >= 0.5 if rule.reached is not None else over + moved >= 0.0  # wear counts by its value
            rank, passed = np.where(reached, verdict.rank, rank), np.where(reached, likely, passed)
            most = np.maximum(most, likely)
        risk = float(normal_cdf(-self.diagnosis.uncertainty.guard_factor)) if self.diagnosis.uncertainty else 0.0
        flagged = rank > Verdict.OK.rank
        sure = np.where(flagged, np.where(passed >= 1.0 - risk, 3, 2), np.where(most <= risk, 0, 1))
        leads = np.where(flagged, passed, most)
        return rank.astype(int), np.where(leads == leads[0], certainty(decided.decision), sure), leads

    @cached_property
    def _drawn(self) -> Any:
        """Return how many standard uncertainties of a value that the draws hold lie between it and its ends."""
        reach = dict.fromkeys((*map(_named, FACTORS), "spool_gauge", "sleeve_gauge"), _REACH)
        reach |= dict.fromkeys(("measuring_temperature", _named(FLUID_STATE)), _RECTANGLE) | {"one_sided_wear": _THIRDS}
        every = np.full(1 + 2 * len(self.names), math.inf)
        for name, far in reach.items():
            every = np.where(self._end(name) != 0.0, far, every)
        return every

    # --- what moves

    def _shift_of_reading(self, land: LandSources) -> Any:
        """Return by how much the clearance of a land is another by its gauges and what was not measured [m]."""
        status, groups = land.state.status, land.groups
        at = groups.get(MEASURING_TEMPERATURE_SOURCE, 0.0) * self._end("measuring_temperature", _RECTANGLE)
        for part in PARTS:
            at = at + groups.get(f"{part} instrument", 0.0) * self._end(f"{part}_gauge", _REACH)
        if status in _HALF:
            at = at + OF_A_DIAMETER * self.assumptions.nominal_diameter * self._end("nominal_diameter", _REACH)
        return at + self._shift_of_new(land.state.land) if status in ("spool_only", "not_measured") else at

    def _shift_of_new(self, pair: Land) -> Any:
        moved = "mounting_clearance_um" in pair.representative
        return moved * self.assumptions.mounting_clearance * self._end("mounting_clearance", _REACH)

    def _of_clearance(self, land: LandSources, decided: RuleDecision) -> _Past:
        """Return how far wear or clearance of a land moves past each limit."""
        pair, wear = land.state.land, self.diagnosis.limits.wear
        now, new = self._shift_of_reading(land), self._shift_of_new(pair)
        if decided.rule.kind is RuleKind.CLEARANCE or wear is None:
            return [now] * len(decided.levels)
        stated = dict(wear.levels)  # a limit above that is one in µm over new
        factors = (1.0 + (each.limit if each.limit <= stated[each.level] else 0.0) for each in decided.levels)
        return [(now - factor * new) / pair.mounting_high for factor in factors]

    @cached_property
    def _states(self) -> dict[LandKey, tuple[LandInState, LandInState]]:
        return {land.key: self._in_both_states(land.sources) for land in self.lands}

    def _in_both_states(self, land: LandSources) -> tuple[LandInState, LandInState]:
        """Return a land as measured and as it may have been when new, in every column."""
        state, pair, u = land.state, land.state.land, self.assumptions
        assumed, by_alloy = self.of.expansions, 1.0 + self._end("materials", ALLOYS)
        moved: Any = replace(
            pair,
            body_expansion=pair.body_expansion * (by_alloy if pair.body_material in assumed else 1.0),
            spool_expansion=pair.spool_expansion * (by_alloy if pair.spool_material in assumed else 1.0),
        )
        source, by_new = replace(land, state=replace(state, land=moved)), self._shift_of_new(pair)
        now, unworn = (
            np.maximum(state.radial_clearance + self._shift_of_reading(land), 0.0),
            pair.new_clearance + by_new,
        )
        if state.measured and pair.widest_new > pair.mounting_range[0]:
            unworn = np.clip(now, unworn, pair.widest_new + by_new)
        square, cube = state.form_moments
        if "one_sided_wear" in self.names and "sleeve" in land.plans:
            aside = 0.5 * u.one_sided_wear * (1.0 + self._end("one_sided_wear"))
            wear = aside * max(state.radial_clearance - pair.new_clearance, 0.0)
            square, cube = with_one_side(one_sided_moments(wear, EXPONENTS[1]), square, cube)  # the middle shape
        length: Any = pair.contact_length
        if "contact_length_mm" in pair.representative:
            length = np.maximum(length + u.contact_length * self._end("contact_length", _REACH), _SHORTEST * length)
        position = None
        if "eccentricity" in self.names:
            position = eccentricity_factor(np.maximum(self._end("eccentricity"), 0.0), 1.0)
        return (source, Bore(np.maximum(now, 0.0), square, cube), length, position), (
            source,
            Bore(unworn),
            length,
            position,
        )

    def _in_columns(self, point: OperatingPoint) -> Controller:
        """Return the valve body with its pressures, leaks and consumers at a condition, in every column."""
        of, controller, by_section = self.of, self.diagnosis.controller, 1.0 + self._end("sections", UNSTATED)
        by_leak, by_flow = (
            1.0 + self._end(name, _REACH * self.assumptions.consumer_flow) for name in ("leaks", "consumers")
        )
        relations = dict(controller.relations)
        for name in of.of("pressures"):
            relations[name] = replace(relations[name], ratio=relations[name].ratio * by_section)
        circuits = []
        for each in controller.circuits:
            stated = each.set_pressure.at(point) if each.set_pressure and each.id in of.set_by else None
            moved = stated is not None and self.set_to != 1.0
            circuits.append(replace(each, set_pressure=SetPressure((stated or 0.0) * self.set_to)) if moved else each)
        return replace(
            controller,
            relations=MappingProxyType(relations),
            circuits=tuple(circuits),
            leaks=tuple(
                replace(each, flow=each.flow * by_leak) if each in of.leaks else each for each in controller.leaks
            ),
            consumers=tuple(
                replace(each, flow=each.at(point) * by_flow) if each in of.consumers else each
                for each in controller.consumers
            ),
        )

    def _given(self, projection: Projection) -> Drawn:
        """Return a condition in every column."""
        point, u = projection.condition, self.assumptions
        deviates = {name: self._end(_named(name), _RECTANGLE if name == FLUID_STATE else _REACH) for name in FACTORS}
        if u.viscosity:
            deviates["viscosity"] -= math.log(_USED) / u.viscosity * np.minimum(self._end("fluid_state"), 0.0)
        given = Drawn(replace(self.diagnosis.model, controller=self._in_columns(point)), projection, u, deviates)
        by = 1.0 + self._end("displacement", UNSTATED)
        given.pump, given.new_pump = (
            replace(each, pump=replace(each.pump, displacement=each.pump.displacement * by))
            for each in (given.pump, given.new_pump)
        )
        given.capacity = given.pump.capacity(point.engine_speed, given.pressures["p_g"], given.viscosity)
        return given

    def _with_set_pressures(self, projection: Projection) -> dict[_Key, _Past]:
        """Return what `_at` does, in the columns of the set pressures with these moved."""
        past = self._at(projection)
        if "set_pressure" in self.names:
            as_it_is = [name for name in self.names if name == "one_sided_wear"]
            first = 1 + 2 * self.names.index("set_pressure")
            for column, set_to in ((first, 1.0 - UNSTATED), (first + 1, 1.0 + UNSTATED)):
                for key, levels in _Ends(self.diagnosis, self.of, as_it_is, set_to)._at(projection).items():
                    for at, moved in zip(past[key], levels, strict=True):
                        at[column] = moved[0]
        return past

    def _at(self, projection: Projection) -> dict[_Key, _Past]:
        """Return how far every share, the reserve and each pressure at a condition is past each of its limits."""
        limits, point, given = self.diagnosis.limits, projection.condition, self._given(projection)
        required, by_feed = given.pressures["p_g"], 1.0 + self._end("feeds", _REACH * self.assumptions.feed)

        def with_feeds(network: Network) -> Network:
            through = ((each, each.restriction) for each in network.feeds)
            moved = (at.with_restriction(replace(each, coefficient=each.coefficient * by_feed)) for at, each in through)
            return replace(network, feeds=tuple(moved))

        now, unworn = (DrawnLands(given, lands, with_feeds) for lands in zip(*self._states.values(), strict=True))
        of_new = given.new_pump.capacity(point.engine_speed, required, given.viscosity)
        past: dict[_Key, _Past] = {}
        for key, (is_now, was) in self._states.items():
            shares = (flow_ratio(flow, of_new) for flow in (now.count(*is_now)[1], unworn.count(*was)[1]))
            if limits.pair_share is not None:
                share, when_new = shares
                share = _from(projection.share_drawn_by(key), share)
                past[RuleKind.PAIR_SHARE, point.name, key] = _past(share, limits.pair_share.over(when_new))
        when_new = flow_ratio(unworn.leakage, given.capacity)
        total = _from(projection.share, now.share)
        past[RuleKind.TOTAL_SHARE, point.name, None] = _past(total, limits.total_share.over(when_new))
        units = now.unit(), unworn.unit(given.new_pump)
        if limits.reserve is not None:
            reserve, before = (each.reserve(point) for each in units)
            under = limits.reserve.under(before)
            past[RuleKind.RESERVE, point.name, None] = [limit - reserve for _, limit in under]
        demand = DemandShape(self.diagnosis.model, point)
        (main, held), (_, held_new) = (each.held(demand) for each in units)
        if projection.permissible is not None and projection.permissible.low is not None:
            by = 1.0 if projection.permissible.published else 1.0 + self._end("permissible_pressure", UNSTATED)
            low = np.maximum(np.minimum(projection.permissible.low * by, point.main_pressure), 1.0)
            below = 1.0 - main / required * point.main_pressure / low
            past[RuleKind.PERMISSIBLE_PRESSURE, point.name, None] = [below.copy() for _ in VERDICTS]
        for name in (each.circuit.id for each in projection.circuits):
            lost = np.abs(spread_over(held_new[name], main.shape) - spread_over(held[name], main.shape))
            past[RuleKind.CIRCUIT_LOSS, point.name, name] = [lost.copy() for _ in VERDICTS]
        return past


def _from(value: float, share: Any) -> Any:
    """Return a share in every column as many times its value in the first as it is there, where wear has a shape."""
    return share * (value / share[0]) if math.isfinite(value) and 0.0 < share[0] < math.inf else share


def _past(value: Any, limits: Iterable[tuple[Any, Any]]) -> _Past:
    return [_difference(value, limit) for _, limit in limits]


def _difference(value: Any, other: Any) -> Any:
    """Return it; 0 where it is no finite number, as where a pump delivers nothing and every share is infinite."""
    with np.errstate(invalid="ignore"):
        difference = np.asarray(value - other)
    return np.where(np.isfinite(difference), difference, 0.0)


def _key(rule: Rule, of: Any) -> _Key:
    return rule.kind, rule.condition.name if rule.condition else None, of


def _moved(decided: RuleDecision, level: LevelDecision, u: float, moved: Any, drawn: Any) -> Any:
    """Return the probability of being past a limit, to which the quantity comes nearer by so much in each column."""
    if not (u > 0.0 and math.isfinite(u)):
        return np.full(moved.shape, level.probability_over)
    now, nearer = _standings(decided, level, u, moved)
    by = nearer - now
    own = np.append(0.0, np.repeat(0.5 * (by[2::2] - by[1::2]), 2)) / drawn
    likely = normal_cdf((now + by) / np.sqrt(np.maximum(1.0 - own**2, 0.05)))
    return np.where(moved == 0.0, level.probability_over, likely)


def _standings(decided: RuleDecision, level: LevelDecision, u: float, moved: Any) -> tuple[float, Any]:
    """Return how many standard deviations the truth is past a limit now, and with the quantity moved.

    Of a quantity that was drawn they are read off the probabilities of its limits and the ends of its interval: those
    of a share in proportion, as every flow in it is so many times what it was, those of others by difference.
    """
    rule, sign = decided.rule, -1.0 if decided.rule.steps.falling else 1.0
    value, limit, ends = sign * rule.value, sign * level.limit, decided.interval
    if ends is None or not math.isfinite(value + limit):
        at = _standing(level.probability_over)
        return at, at + moved / u
    known = {sign * each.limit: _standing(each.probability_over) for each in decided.levels if _known(each)}
    known |= {min(sign * ends[0], sign * ends[1]): _REACH, max(sign * ends[0], sign * ends[1]): -_REACH}
    scale: Any = np.asarray
    if rule.kind in (RuleKind.PAIR_SHARE, RuleKind.TOTAL_SHARE) and min(value, limit, *known) > 0.0:
        scale, limit = np.log, limit * value / np.maximum(value + moved, _SHORTEST * value)
    else:
        limit = limit - moved
    places = np.array(sorted(known))
    standings = np.minimum.accumulate([known[each] for each in places.tolist()])
    x, at, over = scale(places), scale(np.append(sign * level.limit, limit)), np.empty(0)
    if x[-1] - x[0] <= 0.0:
        over = (value - np.append(sign * level.limit, limit)) / u
    else:
        over = np.interp(at, x, standings)
        slope = (standings[-1] - standings[0]) / (x[-1] - x[0])
        over += slope * (np.minimum(at - x[0], 0.0) + np.maximum(at - x[-1], 0.0))
    return float(over[0]), over[1:]


def _known(level: LevelDecision) -> bool:
    return _FEWEST < level.probability_over < 1.0 - _FEWEST


def _standing(probability: float) -> float:
    return float(normal_quantile(min(max(probability, _FEWEST), 1.0 - _FEWEST)))
