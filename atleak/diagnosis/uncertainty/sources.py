"""Collect from instruments and readings what makes each clearance uncertain, source by source.

Every source is stated as its standard uncertainty in the *radial clearance* (half of that in a diameter). A source
with a ``group`` is one error that lands share: the instrument's common part, the temperature of measuring.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Literal

from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.instruments import Instrument, Instruments, Part
from atleak.diagnosis.uncertainty.assumptions import Assumptions
from atleak.equations.statistics import (
    normal_quantile,
    persistent_rounding_variance,
    pooled_standard_deviation,
    rectangular,
)
from atleak.measurements.clearances import (
    REPEAT_TOLERANCE,
    LandClearance,
    clearances,
    independent_repeats,
    repeats_that_count,
)
from atleak.measurements.readings import Reading, Readings

PARTS: tuple[Part, ...] = ("spool", "sleeve")
OF_A_DIAMETER = 0.5  # part of a diameter's error that the radial clearance c_r = (D − d)/2 takes
SLOPES: Mapping[Part, float] = {"spool": -OF_A_DIAMETER, "sleeve": OF_A_DIAMETER}  # of c_r with each diameter
MEASURING_TEMPERATURE_SOURCE = "measuring temperature"  # group of the error that all lands share
MOUNTING: Literal["mounting clearance"] = "mounting clearance"  # kind of the source: what the pair was when new
SourceKind = Literal[
    "common calibration",
    "calibration",
    "resolution",
    "repeats",
    "form",
    "measuring temperature",
    "nominal diameter",
    "mounting clearance",
    "vacuum gauge",
    "vacuum stand",
    "spool position in the vacuum test",
    "contact length in the vacuum test",
]

VACUUM_KINDS: tuple[SourceKind, ...] = (
    "vacuum gauge",
    "vacuum stand",
    "spool position in the vacuum test",
    "contact length in the vacuum test",
)
TOLERANCE_HOLDS = 0.95  # of the pairs of a type, as a tolerance of the mounting clearance is stated
AVERAGED_FROM = 0.6  # of a step: readings that spread more average their rounding out, but for 3e-8 of its variance
ENOUGH_DEGREES = 6  # of freedom, from which on the repeats are trusted alone: choice of this project
_SUSPECT = 3.0  # standard uncertainties under the mounting clearance: choice of this project
_GROWN = 1.645  # standard uncertainties over the widest new pair: with 95 % probability
_STEPS = (0.1e-6, 0.254e-6, 0.5e-6, 1e-6, 1.27e-6, 2e-6, 2.54e-6, 5e-6, 1e-5, 1.27e-5, 2.54e-5)  # [m]
STEP_TOLERANCE = 1e-9  # [m]
_READINGS_THAT_SHOW_A_STEP = 12


@dataclass(frozen=True)
class UncertaintySource:
    """One reason why a radial clearance is uncertain."""

    kind: SourceKind  # the reason
    part: Part | None  # spool or sleeve; None: of the pair
    standard_uncertainty: float  # [m] in the radial clearance; negative where it acts the other way in its group
    group: str | None = None  # of the error that other lands share
    shape: Literal["normal", "rectangular"] = "normal"  # of its distribution

    @property
    def label(self) -> str:
        """Return the source's name for people: ``"sleeve: repeats"``."""
        return self.kind if self.part is None else f"{self.part}: {self.kind}"


@dataclass(frozen=True)
class PooledRepeats:
    """What the independent repeats of one part show over the unit, step by step."""

    squares: float  # [m²] sum of the squared deviations from the mean of each place, slips limited
    degrees_of_freedom: int
    standard_deviation: float  # [m] of a rounded reading, pooled
    widened: float  # [m] the same for few degrees of freedom; 0 where repeats are identical
    before_rounding: float  # [m]
    step: float  # [m] in which the sheet is written; 0 where it shows none


@dataclass(frozen=True)
class RepeatSpread:
    """The spread of single readings of one part in this unit, and the step in which they are written."""

    part: Part  # spool or sleeve
    standard_deviation: float  # [m] of one reading before rounding
    degrees_of_freedom: int  # of independent repeats, pooled over the unit
    resolution: float  # [m] the coarser of instrument and sheet
    roundings: int  # in one diameter: 2 where it is the difference of two coordinates
    origin: Literal["repeats", "instrument", "resolution"]  # what tells it
    ovality: float | None  # [m] root mean square over the lands measured in several directions
    pooled: PooledRepeats | None = None  # from which it follows

    @cached_property
    def persistent_variance(self) -> float:
        """Return the variance of the rounding error that repeats of one place do not average out [m²]."""
        s = self.standard_deviation / math.sqrt(self.roundings)
        return self.roundings * _persistent_rounding(self.resolution, s)

    @cached_property
    def averaged_variance(self) -> float:
        """Return the variance of the errors that repeats average out, rounding included [m²]."""
        s = self.standard_deviation
        rounding = self.roundings * self.resolution**2 / 12.0 - self.persistent_variance
        return s * s + rounding if s > 0.0 else 0.0


@dataclass(frozen=True)
class _MeasuringPlan:
    """The way in which one part of one land was measured."""

    repeat_weight: float  # variance of the mean diameter / variance of a single reading
    rounding_weight: float  # the same for the rounding error that repeats do not average out
    two_lobe: float  # 0 … 1: how much of a two-lobe form the directions leave in the mean
    repeats: int
    residual: float  # of what two directions leave of other forms: 1 for two
    angles: Mapping[float, float]  # [rad] of every direction, with its weight in the mean diameter; they add up to 1


@dataclass(frozen=True)
class LandSources:
    """All sources of the uncertainty of one land's clearance."""

    state: LandClearance  # its clearance
    sources: tuple[UncertaintySource, ...]  # one for each reason
    plans: Mapping[Part, _MeasuringPlan]  # how each part was measured
    spreads: Mapping[Part, RepeatSpread]  # how far readings of each part scatter
    instruments: Instruments  # with which the readings were taken
    assumptions: Assumptions  # what else is uncertain

    @property
    def key(self) -> tuple[str, int]:
        """Return component and number of the land."""
        return self.state.land.key

    @cached_property
    def groups(self) -> dict[str, float]:
        """Return the signed standard uncertainty of each shared error in this clearance [m]."""
        by_group: dict[str, float] = defaultdict(float)
        for source in self.sources:
            if source.group is not None:
                by_group[source.group] += source.standard_uncertainty
        return dict(by_group)

    @cached_property
    def own_variance(self) -> float:
        """Return the variance of the errors that no other land shares [m²]."""
        return math.fsum(source.standard_uncertainty**2 for source in self.sources if source.group is None)

    @cached_property
    def standard_uncertainty(self) -> float:
        """Return the standard uncertainty of the radial clearance [m]."""
        return math.sqrt(self.own_variance + math.fsum(u * u for u in self.groups.values()))

    @property
    def sees_sides(self) -> bool:
        """Return whether some plane of the bore was measured in several directions, that differ where it is uneven."""
        return "sleeve" in self.plans and self.plans["sleeve"].two_lobe < 1.0

    @cached_property
    def direction_variance(self) -> float:
        """Return the variance of the clearance in one direction of one plane by what repeats leave of it [m²]."""
        each = ((self.spreads[part], plan.repeats) for part, plan in self.plans.items())
        return OF_A_DIAMETER**2 * math.fsum(s.averaged_variance / n + s.persistent_variance for s, n in each)

    @cached_property
    def budget(self) -> tuple[tuple[UncertaintySource, float], ...]:
        """Return each source with its part of the variance, the largest first; an error of both parts is one source."""
        total = self.standard_uncertainty**2
        merged: list[UncertaintySource] = [source for source in self.sources if source.group is None]
        for group, u in self.groups.items():
            members = [source for source in self.sources if source.group == group]
            part = members[0].part if len(members) == 1 else None
            merged.append(UncertaintySource(members[0].kind, part, u, group, members[0].shape))
        shares = ((source, source.standard_uncertainty**2 / total if total > 0.0 else 0.0) for source in merged)
        return tuple(sorted(shares, key=lambda item: -item[1]))

    def part_fraction(self, part: Part) -> float:
        """Return the fraction of the clearance's variance that one part's readings carry."""
        return math.fsum(fraction for source, fraction in self.budget if source.part == part)

    @property
    def u_mounting(self) -> float:
        """Return the standard uncertainty of the mounting clearance as this pair's own [m]."""
        return mounting_uncertainty(self.state.land, self.assumptions)

    @property
    def suspect(self) -> bool:
        """Return whether the pair measures tighter than a new one, by more than the readings and c_m can be off.

        Wear only opens a pair. Of a range the lower end counts, which new pairs do not pass.
        """
        low, high = self.state.land.mounting_range
        u = math.hypot(self.standard_uncertainty, self.u_mounting if low == high else 0.0)
        return self.state.whole and self.state.radial_clearance < low - _SUSPECT * u

    @property
    def grown(self) -> bool:
        """Return whether the clearance has surely grown: past the widest of new pairs, with 95 % probability."""
        pair = self.state.land
        u = math.hypot(self.standard_uncertainty, self.u_mounting if pair.widest_new == pair.mounting_range[0] else 0.0)
        return self.state.radial_clearance - pair.widest_new > _GROWN * u

    def variance_with(
        self,
        *,
        repeats: Mapping[Part, int] | None = None,
        instruments: Mapping[Part, Instrument] | None = None,
        four_directions: Sequence[Part] = (),
    ) -> float:
        """Return the variance of the clearance [m²] had it been measured otherwise.

        With more repeats of some parts, with other instruments, or in four directions, among which a two-lobe form
        cancels and half as much of the rest is left.
        """
        chosen = Instruments(**{part: (instruments or {}).get(part, self.instruments.of(part)) for part in PARTS})
        changed: list[UncertaintySource] = []
        otherwise = {*(repeats or ()), *(instruments or ()), *four_directions}
        if chosen.err_alike != self.instruments.err_alike:
            otherwise = set(PARTS)  # errors that both parts share, or share no longer
        for part in PARTS:
            if part not in self.plans or part not in otherwise:
                changed += [source for source in self.sources if source.part == part]
                continue
            plan, spread, instrument = self.plans[part], self.spreads[part], chosen.of(part)
            if part in (instruments or {}):
                s = instrument.repeatability if instrument.repeatability is not None else 0.0
                spread = RepeatSpread(part, s, 0, instrument.resolution, 1, "instrument", spread.ovality)
            times = (repeats or {}).get(part, plan.repeats) / plan.repeats
            if part in four_directions:
                plan = replace(plan, two_lobe=0.0, residual=min(plan.residual, 0.5))
            counts = 1.0 - self.state.leak_weight
            changed += [
                replace(each, standard_uncertainty=counts * each.standard_uncertainty)
                for each in _part_sources(self.state, part, instrument, chosen, plan, spread, self.assumptions, times)
            ]
        changed += [source for source in self.sources if source.part is None]
        return LandSources(self.state, tuple(changed), {}, {}, chosen, self.assumptions).standard_uncertainty ** 2


def find_sources(
    states: Sequence[LandClearance],
    readings: Readings | None,
    controller: Controller,
    instruments: Instruments,
    assumptions: Assumptions,
) -> tuple[tuple[LandSources, ...], dict[Part, RepeatSpread]]:
    """Return every land's sources, and the spread of repeats of each part over the unit.

    The clearances follow from the readings, which are the measuring sheet's.
    """
    by_land: dict[tuple[str, int], dict[Part, list[Reading]]] = defaultdict(lambda: {"spool": [], "sleeve": []})
    for reading in readings.readings if readings else ():
        land = controller.land_of_plane(reading.component, reading.plane)
        if land is not None:
            by_land[land.key][reading.part].append(reading)
    groups = {
        key: {part: _stations(part_readings) for part, part_readings in parts.items()} for key, parts in by_land.items()
    }
    spreads = {
        part: _spread(part, [land[part] for land in groups.values()], states, instruments.of(part)) for part in PARTS
    }
    return tuple(
        _land_sources(state, groups.get(state.land.key, {}), spreads, instruments, assumptions) for state in states
    ), spreads


def sources_of_sheet(
    controller: Controller,
    readings: Readings,
    *,
    measuring_temperature: float | None = None,
    instruments: Instruments,
    assumptions: Assumptions,
) -> tuple[LandSources, ...]:
    """Return every land as a measuring sheet has it, with its sources; what the sheet says of its own lands counts.

    Parameters
    ----------
    measuring_temperature
        of gauge and parts [°C]; as the sheet states it unless given, else 20 °C.

    Raises
    ------
    ReadingsError
        a sleeve that is smaller than its spool only after the correction from the measuring temperature to 20 °C.
    """
    own, at = readings.own_lands.applied(controller), readings.measured_at(measuring_temperature)
    states = clearances(readings, own, temperature_c=at.value, instruments=instruments)
    return find_sources(states, readings, own, instruments, assumptions)[0]


def mounting_uncertainty(land: Land, assumptions: Assumptions) -> float:
    """Return how uncertain a land's mounting clearance is as that of one pair [m], one standard deviation.

    A tolerance holds 95 % of the pairs of a type; a range holds all of them, any value alike likely; a number without
    either is this pair's own.
    """
    low, high = land.mounting_range
    if low < high:
        return rectangular(0.5 * (high - low))
    if land.mounting_tolerance is not None:
        return land.mounting_tolerance / float(normal_quantile(0.5 + 0.5 * TOLERANCE_HOLDS))
    return assumptions.mounting_clearance


_Stations = dict[tuple[str, float | None], list[Reading]]


def _stations(readings: Iterable[Reading]) -> _Stations:
    stations: _Stations = defaultdict(list)
    for reading in readings:
        stations[reading.plane, reading.direction].append(reading)
    return stations


def _land_sources(
    state: LandClearance,
    groups: Mapping[Part, _Stations],
    spreads: Mapping[Part, RepeatSpread],
    instruments: Instruments,
    assumptions: Assumptions,
) -> LandSources:
    sources: list[UncertaintySource] = []
    plans: dict[Part, _MeasuringPlan] = {}
    mounting = mounting_uncertainty(state.land, assumptions)
    if state.leak_weight == 1.0:
        groups = {}  # no diameter counts
    if not state.measured:
        sources.append(UncertaintySource(MOUNTING, None, mounting))
    else:
        for part in PARTS:
            stations = groups.get(part)
            if not stations and state.leak_weight == 1.0:
                continue
            if not stations:
                sources.append(
                    UncertaintySource("nominal diameter", part, OF_A_DIAMETER * assumptions.nominal_diameter)
                )
                if part == "sleeve":  # its nominal diameter is the spool's and twice the mounting clearance
                    sources.append(UncertaintySource(MOUNTING, None, mounting))
                continue
            counted = {station: repeats_that_count(group) for station, group in stations.items()}
            plans[part] = _plan(counted, spreads[part].resolution)
            sources += _part_sources(
                state, part, instruments.of(part), instruments, plans[part], spreads[part], assumptions
            )
    return LandSources(state, tuple(_with_leak(state, sources)), plans, spreads, instruments, assumptions)


def _with_leak(state: LandClearance, sources: Iterable[UncertaintySource]) -> Iterable[UncertaintySource]:
    """Return a land's sources with those of its vacuum test: of a weighted mean of cubes each acts by its weight."""
    leak, weight = state.leak, state.leak_weight
    if leak is None:
        return sources
    kept = [replace(each, standard_uncertainty=each.standard_uncertainty * (1.0 - weight)) for each in sources]
    of_leak = zip(VACUUM_KINDS, (leak.u_reading, leak.u_stand, leak.u_position, leak.u_length), strict=True)
    return [
        *(each for each in kept if weight < 1.0),
        *(
            UncertaintySource(kind, None, weight * u, "vacuum stand" if kind == "vacuum stand" else None)
            for kind, u in of_leak
        ),
    ]


def _part_sources(
    state: LandClearance,
    part: Part,
    instrument: Instrument,
    instruments: Instruments,
    plan: _MeasuringPlan,
    spread: RepeatSpread,
    assumptions: Assumptions,
    times: float = 1.0,
) -> list[UncertaintySource]:
    """Return the sources of one measured part, with ``times`` as many repeats as were made."""
    slope = SLOPES[part]
    # one instrument for both parts errs alike in both, so that its common error drops out of D − d
    group = "one instrument" if instruments.err_alike else f"{part} instrument"
    resolution = spread.persistent_variance * plan.rounding_weight
    repeats = spread.averaged_variance * plan.repeat_weight / times
    return [
        UncertaintySource("common calibration", part, slope * instrument.common, group),
        UncertaintySource("calibration", part, OF_A_DIAMETER * instrument.own),
        UncertaintySource("resolution", part, OF_A_DIAMETER * math.sqrt(resolution), None, "rectangular"),
        UncertaintySource("repeats", part, OF_A_DIAMETER * math.sqrt(repeats)),
        UncertaintySource("form", part, OF_A_DIAMETER * _form(state, part, plan, spread, assumptions)),
        _temperature_source(state, part, slope, instrument, assumptions),
    ]


def _temperature_source(
    state: LandClearance, part: Part, slope: float, instrument: Instrument, assumptions: Assumptions
) -> UncertaintySource:
    """Return what an error of the measuring temperature does: part and gauge expand, and their difference is read."""
    diameter = state.spool_diameter if part == "spool" else state.sleeve_diameter
    rate = (state.land.expansion_of(part) - instrument.expansion) * diameter  # [m/K]
    u = slope * rate * assumptions.u_room_temperature
    return UncertaintySource("measuring temperature", part, u, MEASURING_TEMPERATURE_SOURCE, "rectangular")


def _form(
    state: LandClearance, part: Part, plan: _MeasuringPlan, spread: RepeatSpread, assumptions: Assumptions
) -> float:
    """Return the standard uncertainty [m] of the mean diameter that comes from seeing the form in few places only.

    Two perpendicular directions cancel a two-lobe form exactly, one direction leaves it all, at an unknown phase.
    """
    ovality = state.spool_ovality if part == "spool" else state.sleeve_ovality
    taper = state.spool_taper if part == "spool" else state.sleeve_taper
    residual = plan.residual * assumptions.form_residual * math.hypot(ovality or 0.0, taper or 0.0)
    if ovality is None:
        ovality = spread.ovality if spread.ovality is not None else assumptions.unseen_ovality
    return math.hypot(0.5 * ovality * plan.two_lobe * math.sqrt(0.5), residual)


def _plan(stations: Mapping[tuple[str, float | None], list[Reading]], resolution: float) -> _MeasuringPlan:
    planes: dict[str, list[float | None]] = defaultdict(list)
    for plane, direction in stations:
        planes[plane].append(direction)
    weights, repeats, means = [], [], []
    angles: dict[float, float] = defaultdict(float)
    repeat_weight = 0.0
    for (plane, direction), group in stations.items():
        weight = 1.0 / (len(planes) * len(planes[plane]))
        counts = _multiplicities(group)
        # a copied or mirrored reading is the same error over again
        repeat_weight += weight * weight * sum(count * count for count in counts) / len(group) ** 2
        weights.append(weight)
        angles[math.radians(direction or 0.0)] += weight  # of one direction that is not stated any will do
        repeats.append(len(counts))
        means.append(math.fsum(reading.diameter for reading in group) / len(group))
    # places with the same reading are rounded the same way; others are rounded independently
    apart = max(means) - min(means) >= resolution - STEP_TOLERANCE  # a step apart, but for floating point
    return _MeasuringPlan(
        repeat_weight=repeat_weight,
        rounding_weight=math.fsum(weight * weight for weight in weights) if apart else 1.0,
        two_lobe=math.fsum(_two_lobe(directions) for directions in planes.values()) / len(planes),
        repeats=min(repeats),
        residual=2.0 / max(2, min(len(directions) for directions in planes.values())),
        angles=dict(angles),
    )


def _multiplicities(group: list[Reading]) -> list[int]:
    """Count how often each independent reading of one place is in the sheet."""
    if all(reading.coordinates is None for reading in group):
        return [1] * len(group)
    independent = independent_repeats(group)
    pairs = [tuple(sorted(reading.coordinates)) if reading.coordinates else None for reading in group]
    return [
        1 if reading.coordinates is None else pairs.count(tuple(sorted(reading.coordinates))) for reading in independent
    ]


def _two_lobe(directions: Sequence[float | None]) -> float:
    angles = [math.radians(2.0 * direction) for direction in directions if direction is not None]
    if not angles:
        return 1.0
    return math.hypot(math.fsum(map(math.cos, angles)), math.fsum(map(math.sin, angles))) / len(angles)


# --- repeats, pooled over the unit


@lru_cache(maxsize=256)  # of few instruments, each tried for every land
def _persistent_rounding(resolution: float, standard_deviation: float) -> float:
    return float(persistent_rounding_variance(resolution, standard_deviation))


def _spread(
    part: Part, lands: Iterable[_Stations], states: Sequence[LandClearance], instrument: Instrument
) -> RepeatSpread:
    deviations, degrees, everything = [], [], []
    for stations in lands:
        for group in stations.values():
            everything += group
            independent = [reading.diameter for reading in independent_repeats(group)]
            if len(independent) > 1:
                mean = math.fsum(independent) / len(independent)
                squares = math.fsum((diameter - mean) ** 2 for diameter in independent)
                apart = max(independent) - min(independent)  # a slip says that repeats disagree, not by how much
                within = min(REPEAT_TOLERANCE / apart, 1.0) if apart else 1.0
                deviations.append(within * math.sqrt(squares / (len(independent) - 1)))
                degrees.append(len(independent) - 1)
    step = _step(everything)
    resolution = max(instrument.resolution, step)
    roundings = 2 if everything and all(reading.coordinates is not None for reading in everything) else 1
    freedom = sum(degrees)
    pooled = float(pooled_standard_deviation(deviations, degrees)) if freedom else 0.0
    squares, degrees_of_repeats, shown = pooled**2 * freedom, freedom, pooled
    if pooled < STEP_TOLERANCE:  # identical repeats show the resolution, not perfection
        freedom, pooled = 0, 0.0
    widened = pooled * math.sqrt(freedom / (freedom - 2.0) if freedom > 2 else 3.0)
    before_rounding = _before_rounding(widened, resolution, roundings) if freedom else 0.0
    s, origin = _single_reading(before_rounding, freedom, instrument)
    ovalities = [state.spool_ovality if part == "spool" else state.sleeve_ovality for state in states]
    measured = [ovality for ovality in ovalities if ovality is not None]
    return RepeatSpread(
        part=part,
        standard_deviation=s,
        degrees_of_freedom=freedom,
        resolution=resolution,
        roundings=roundings,
        origin=origin,
        ovality=math.sqrt(math.fsum(o * o for o in measured) / len(measured)) if measured else None,
        pooled=PooledRepeats(squares, degrees_of_repeats, shown, widened, before_rounding, step),
    )


def _single_reading(
    s: float, freedom: int, instrument: Instrument
) -> tuple[float, Literal["repeats", "instrument", "resolution"]]:
    """Return the spread of one reading, from that of the repeats before rounding and what the instrument states."""
    declared = instrument.repeatability
    if freedom == 0:
        return (0.0, "resolution") if declared is None else (declared, "instrument")
    if freedom < ENOUGH_DEGREES and declared is not None and declared > s:
        return declared, "instrument"
    return s, "repeats"


def _before_rounding(spread: float, resolution: float, roundings: int) -> float:
    """Return the standard deviation [m] of readings before they were rounded, from that of the rounded ones."""

    def rounded_variance(s: float) -> float:
        persistent = persistent_rounding_variance(resolution, s / math.sqrt(roundings))
        return s * s + roundings * (resolution**2 / 12.0 - persistent)

    variance = spread * spread - roundings * resolution**2 / 12.0
    if variance > roundings * (AVERAGED_FROM * resolution) ** 2:
        return math.sqrt(variance)
    low, high = 0.0, spread
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if rounded_variance(middle) < spread * spread else (low, middle)
    return 0.5 * (low + high)


def _step(readings: Sequence[Reading]) -> float:
    """Return the step [m] in which a sheet is written, 0.0 where it has too few readings to show one."""
    diameters = {reading.diameter for reading in readings}
    if len(diameters) < _READINGS_THAT_SHOW_A_STEP:
        return 0.0
    fitting = (
        step
        for step in reversed(_STEPS)
        if all(abs(diameter - step * round(diameter / step)) <= STEP_TOLERANCE for diameter in diameters)
    )
    return next(fitting, 0.0)
