"""Work out the clearance of every land from the readings.

`clearances` averages the readings of each land and says what the average hides: ovality, taper, how far repeats agree,
what is missing.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from statistics import fmean
from typing import Literal

from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Controller, Land
from atleak.catalogue.instruments import Instruments, Part, load_instruments
from atleak.catalogue.words import PART_WORDS, angle, in_mm, in_um, named
from atleak.common.errors import Message, Place, ReadingsError, translates_refusals
from atleak.common.sentences import Sentence
from atleak.common.units import Quantity
from atleak.equations import clearance as clearance_equations
from atleak.equations.gap import flow_equal_clearance
from atleak.measurements.readings import Reading, Readings
from atleak.measurements.vacuum import LeakClearance

Status = Literal["measured", "spool_only", "sleeve_only", "vacuum", "not_measured"]
_STATUS: Mapping[tuple[bool, bool], Status] = {  # by whether the spool was measured, and its sleeve
    (True, True): "measured",
    (True, False): "spool_only",
    (False, True): "sleeve_only",
    (False, False): "not_measured",
}

_HALF = ("sleeve_missing", "spool_missing")  # codes of what is said of a land of which one part was measured
CONTRADICTION = 2.58  # standard uncertainties by which micrometer and vacuum test differ in 1 of 100 cases
REPEAT_TOLERANCE = 5e-6  # [m] repeats of one diameter further apart than this are flagged: choice of this project
OVALITY_TO_LOOK_AT = 50e-6  # [m] choice of this project
_TOLERATED = REPEAT_TOLERANCE + 1e-12  # [m] less than this beyond it is floating point
NOMINAL_TOLERANCE = 0.5e-3  # [m] a diameter further than this from the nominal one is flagged: choice of this project


@dataclass(frozen=True)
class Station:
    """One plane and direction of a land with both diameters; what was not measured there is the part's mean."""

    plane: str  # letter or number of the plane
    direction: float | None  # [°]
    spool_diameter: float  # [m]
    sleeve_diameter: float  # [m]

    @property
    def radial_clearance(self) -> float:
        """Return the radial clearance [m], eq. (28); negative where the sleeve measures smaller than the spool."""
        return _clearance(self.sleeve_diameter, self.spool_diameter)


@dataclass(frozen=True)
class Disagreement:
    """Repeats of one place that are further apart than `REPEAT_TOLERANCE`, and those of them that count."""

    repeats: tuple[Reading, ...]  # all of the place
    counted: tuple[Reading, ...]  # of which its mean is made

    @property
    def agreed(self) -> bool:
        """Tell whether most of the independent repeats agree: the others were left out as slips."""
        return 2 * len(independent_repeats(self.counted)) > len(independent_repeats(self.repeats))

    @property
    def apart(self) -> float:
        """Return how far the repeats are apart [m]."""
        return _spread(self.repeats)


@dataclass(frozen=True)
class LandClearance:
    """The clearance of one land at 20 °C, and the readings it rests on.

    Means are over repeats, then directions, then planes. A part that was not measured has its nominal diameter, a land
    that was not measured at all its mounting clearance. Ovality is the largest difference between the directions of one
    plane, taper that between the planes, spread of repeats that between *independent* repeats: each is None where the
    readings cannot tell. `Unit.with_clearance` changes clearance, diameters and form together; ``replace`` of one
    leaves the others as they were read.
    """

    land: Land  # as the controller's file describes it
    status: Status  # which of its parts were measured; ``vacuum``: not both, but what it leaks
    spool_diameter: float  # [m] mean, or nominal
    sleeve_diameter: float  # [m] mean, or nominal
    radial_clearance: float  # [m] mean, or the mounting clearance
    min_clearance: float  # over planes and directions
    max_clearance: float  # [m] likewise
    worst_direction: float | None  # [°], of the largest clearance; None where there is no direction to compare
    stations: tuple[Station, ...]  # every plane and direction measured
    spool_ovality: float | None  # [m]
    sleeve_ovality: float | None  # [m]
    spool_taper: float | None  # [m]
    sleeve_taper: float | None  # [m]
    spool_repeat_spread: float | None  # [m]
    sleeve_repeat_spread: float | None  # [m]
    spool_readings: int  # how many
    sleeve_readings: int  # how many
    spool_repeats: int  # independent ones, the fewest of any plane and direction
    sleeve_repeats: int  # likewise
    messages: tuple[Message, ...] = ()  # what a reader must know of it
    doubts: tuple[Disagreement, ...] = ()  # places whose repeats are too far apart to be averaged
    leak: LeakClearance | None = None  # what a vacuum test tells of it alone
    leak_weight: float = 0.0  # of that in the cube of the clearance; the rest is the micrometers'
    contradicted: bool = False  # micrometers and vacuum test differ by more than their uncertainties allow

    @property
    def whole(self) -> bool:
        """Return whether its clearance was measured: both of its parts, or what it leaks."""
        return self.status in ("measured", "vacuum")

    @property
    def measured(self) -> bool:
        """Return whether at least one of the two parts was measured, or what it leaks."""
        return self.status != "not_measured"

    @property
    def shows_wear(self) -> bool:
        """Return whether its bore was measured, or what it leaks: a spool alone says nothing of what wears."""
        return self.measured and self.status != "spool_only"

    @property
    def within_new(self) -> bool:
        """Return whether a pair of which a range is known when new measures within it."""
        low, high = self.land.mounting_range
        return low < high and low <= self.radial_clearance <= high

    @property
    def judged(self) -> bool:
        """Return whether what was measured of it counts: a land that a ring seals is judged by nothing."""
        return self.measured and self.land.seal is None

    @property
    def can_be_ok(self) -> bool:
        """Return whether it can be called ok: it is judged, and by both of its parts or by what it leaks."""
        return self.judged and self.whole

    @property
    def wear(self) -> float:
        """Return the wear (c_r − c_m)/c_m as a fraction, eq. (1), from the upper end of the mounting clearance."""
        return clearance_equations.wear(self.radial_clearance, self.land.mounting_high)

    @property
    def thermal_rate(self) -> float:
        """Return the growth of the radial clearance with temperature [m/K], eq. (2)."""
        return self.land.thermal_rate(self.spool_diameter, self.sleeve_diameter)

    @cached_property
    def form_moments(self) -> tuple[float, float]:
        """Return the second [m²] and third [m³] central moment of the radial clearance over the places measured.

        Directions of a plane are averaged first, then planes, as for the mean. A part known only by its mean adds
        nothing, and nothing is known of a land where no plane has two directions: (0, 0).
        """
        planes: dict[str, list[float]] = defaultdict(list)
        for station in self.stations:
            planes[station.plane].append(station.radial_clearance)
        if all(len(directions) < 2 for directions in planes.values()):
            return 0.0, 0.0
        mean = fmean(fmean(directions) for directions in planes.values())
        second, third = (
            fmean(fmean((c - mean) ** power for c in directions) for directions in planes.values()) for power in (2, 3)
        )
        return second, third

    def effective_clearance(self, temperature: float) -> float:
        """Return the radial clearance [m] at a temperature, eq. (2): zero where the pair binds.

        Parameters
        ----------
        temperature
            of the pair [°C].
        """
        rise = temperature - REFERENCE_TEMPERATURE
        return clearance_equations.effective_clearance(self.radial_clearance, self.thermal_rate, rise)


@dataclass(frozen=True)
class _PartMean:
    """The mean diameters of one part of one land, and the shape that they show."""

    diameter: float
    by_station: Mapping[tuple[str, float | None], float] = field(default_factory=dict)
    by_plane: Mapping[str, float] = field(default_factory=dict)
    ovality: float | None = None
    taper: float | None = None
    repeat_spread: float | None = None
    readings: int = 0
    repeats: int = 0
    messages: tuple[Message, ...] = ()
    doubts: tuple[Disagreement, ...] = ()

    def at(self, station: tuple[str, float | None]) -> float:
        """Return the diameter in a plane and direction; the mean of the plane, or of all, where none was read there."""
        return self.by_station.get(station, self.by_plane.get(station[0], self.diameter))

    def at_reference(self, part_expansion: float, gauge_expansion: float, rise: float) -> _PartMean:
        """Return the same mean, read ``rise`` [K] above the reference temperature, as it is at that temperature."""

        def corrected(diameter: float) -> float:
            return clearance_equations.diameter_at_reference(diameter, part_expansion, gauge_expansion, rise)

        return replace(
            self,
            diameter=corrected(self.diameter),
            by_station={station: corrected(diameter) for station, diameter in self.by_station.items()},
            by_plane={plane: corrected(diameter) for plane, diameter in self.by_plane.items()},
        )


@translates_refusals
def clearances(
    readings: Readings | None,
    controller: Controller,
    *,
    temperature_c: float = REFERENCE_TEMPERATURE,
    instruments: Instruments | None = None,
) -> tuple[LandClearance, ...]:
    """Work out the clearance of every land of the controller, measured or not, in the controller's order.

    Parameters
    ----------
    readings
        as from `atleak.readers.sheets.measuring_sheet.read_readings`; None computes every land at its mounting
        clearance.
    controller
        the controller with its lands. Readings of planes it does not know are left out.
    temperature_c
        that of gauge and parts when they were measured [°C].
    instruments
        those that measured, of which the expansion counts here; the catalogue's defaults unless given.

    Returns
    -------
    tuple of LandClearance
        one per land. A clearance can be negative only where the readings say the sleeve is smaller than the spool,
        which `read_readings` refuses.

    Raises
    ------
    ReadingsError
        a sleeve that is smaller than its spool only after the correction to 20 °C.

    Notes
    -----
    The readings stay as they were read; each mean diameter is corrected to 20 °C by the different expansion of part
    and gauge (`atleak.equations.clearance.diameter_at_reference`). Radial clearance is half the difference of the mean
    diameters, eq. (28) of the source study. Repeats with the two coordinates swapped, as in the study's Table 1, or
    copied unchanged are no independent repeats: they count for the mean, which they leave as it is, not for the spread.
    Of repeats further apart than `REPEAT_TOLERANCE` only those count that `repeats_that_count` names.
    """
    parts: dict[tuple[str, int], dict[Part, list[Reading]]] = defaultdict(lambda: {"spool": [], "sleeve": []})
    for reading in readings.readings if readings else ():
        land = controller.land_of_plane(reading.component, reading.plane)
        if land is not None:
            parts[land.key][reading.part].append(reading)
    gauges = None if temperature_c == REFERENCE_TEMPERATURE else instruments or load_instruments()
    return tuple(_land_clearance(land, parts[land.key], temperature_c, gauges) for land in controller.lands)


def with_leak(state: LandClearance, uncertainty: float, leak: LeakClearance) -> LandClearance:
    """Return a land's clearance with what a vacuum test tells of it: alone, or with both of its parts measured.

    Parameters
    ----------
    uncertainty
        standard uncertainty of that clearance [m].

    Returns
    -------
    LandClearance
        with the mean of both cubes, weighted by their inverse variances at that common clearance: those of the
        clearances. Where these differ by more than `CONTRADICTION` uncertainties there is no mean: a tighter bore read
        after its repair counts alone, as its diameters are then those before it; else the wider counts until one of
        them is measured again. A message says so.

    Notes
    -----
    A spool or sleeve that was measured alone tells nothing beside a leak, which sees the wear of both.
    """
    kept = tuple(each for each in state.messages if each.code not in _HALF)
    alone = replace(state, status="vacuum", stations=(), messages=kept)
    if state.status != "measured":
        return _as_leaking(alone, leak, leak.clearance, 1.0)
    own = flow_equal_clearance(max(state.radial_clearance, 0.0), *state.form_moments)
    by_diameters, by_leak = uncertainty**2, leak.standard_uncertainty**2
    if abs(own - leak.clearance) > CONTRADICTION * math.sqrt(by_diameters + by_leak):
        wider = leak.clearance > own
        if leak.reading.repaired and not wider:
            text = Sentence(
                "{land}: the vacuum test of the repaired bore ({place}) counts, {leak} {leak.unit}; its diameters, "
                "which tell {own} {own.unit}, are taken as read before the repair",
                land=named(state.land),
                own=in_um(own),
                place=leak.reading.place.sentence,
                leak=in_um(leak.clearance),
            )
            message = Message("info", "vacuum_after_repair", text, leak.reading.place)
            return _as_leaking(replace(alone, messages=(*kept, message)), leak, leak.clearance, 1.0)
        text = Sentence(
            "{land}: diameters tell {own} {own.unit}, the vacuum test ({place}) {leak} {leak.unit}: they contradict "
            "one another. Measure again; until then the wider counts",
            land=named(state.land),
            own=in_um(own),
            place=leak.reading.place.sentence,
            leak=in_um(leak.clearance),
        )
        doubted = replace(
            state,
            contradicted=True,
            messages=(*state.messages, Message("warning", "vacuum_contradicts", text, leak.reading.place)),
        )
        return _as_leaking(doubted, leak, leak.clearance if wider else own, float(wider))
    weight = by_diameters / (by_diameters + by_leak) if by_diameters + by_leak else 0.5
    return _as_leaking(state, leak, math.cbrt((1.0 - weight) * own**3 + weight * leak.clearance**3), weight)


def _as_leaking(state: LandClearance, leak: LeakClearance, even: float, weight: float) -> LandClearance:
    """Return a land that leaks as much as an even one of that clearance, its form as its readings show it."""
    square, third = state.form_moments
    mean = even  # of c³ + 3 c m₂ + m₃ = even³ there is one root
    if square > 0.0:
        root = math.sqrt(square)
        mean = 2.0 * root * math.sinh(math.asinh((even**3 - third) / (2.0 * root**3)) / 3.0)
    moved = mean - state.radial_clearance
    least, most = state.min_clearance + moved, state.max_clearance + moved
    if state.status == "vacuum":
        least = most = mean
        state = replace(state, sleeve_diameter=state.spool_diameter + 2.0 * mean)
    return replace(state, radial_clearance=mean, min_clearance=least, max_clearance=most, leak=leak, leak_weight=weight)


def _land_clearance(
    land: Land, parts: Mapping[Part, list[Reading]], temperature: float, gauges: Instruments | None
) -> LandClearance:
    means = {part: _part_mean(land, part, part_readings) for part, part_readings in parts.items()}
    place = next((reading.place for part_readings in parts.values() for reading in part_readings), None)
    if gauges is not None:
        rise = temperature - REFERENCE_TEMPERATURE
        means = {
            part: mean.at_reference(land.expansion_of(part), gauges.of(part).expansion, rise) if mean.readings else mean
            for part, mean in means.items()
        }
    spool, sleeve = means["spool"], means["sleeve"]
    if gauges is not None and sleeve.diameter < spool.diameter:
        raise _smaller_sleeve(land, spool.diameter, sleeve.diameter, temperature, place)
    status = _STATUS[spool.readings > 0, sleeve.readings > 0]
    clearance = land.new_clearance if status == "not_measured" else _clearance(sleeve.diameter, spool.diameter)
    stations = _stations(spool, sleeve)
    radial_clearances = [station.radial_clearance for station in stations] or [clearance]
    directions = {station.direction for station in stations}
    worst = max(stations, key=lambda station: station.radial_clearance).direction if len(directions) > 1 else None
    result = LandClearance(
        land=land,
        status=status,
        spool_diameter=spool.diameter,
        sleeve_diameter=sleeve.diameter,
        radial_clearance=clearance,
        min_clearance=min(radial_clearances),
        max_clearance=max(radial_clearances),
        worst_direction=worst,
        stations=stations,
        spool_ovality=spool.ovality,
        sleeve_ovality=sleeve.ovality,
        spool_taper=spool.taper,
        sleeve_taper=sleeve.taper,
        spool_repeat_spread=spool.repeat_spread,
        sleeve_repeat_spread=sleeve.repeat_spread,
        spool_readings=spool.readings,
        sleeve_readings=sleeve.readings,
        spool_repeats=spool.repeats,
        sleeve_repeats=sleeve.repeats,
        doubts=(*spool.doubts, *sleeve.doubts),
    )
    return replace(result, messages=(*spool.messages, *sleeve.messages, *_land_messages(result, place)))


def _smaller_sleeve(land: Land, spool: float, sleeve: float, temperature: float, place: Place | None) -> ReadingsError:
    problem = Sentence(
        "{land}: corrected from {measured:g} to {reference:g} {reference.unit} the sleeve is smaller than the {part}",
        land=named(land),
        measured=Quantity(temperature, "temperature"),
        reference=Quantity(REFERENCE_TEMPERATURE, "temperature"),
        part=land.part_name,
    )
    return ReadingsError(
        problem,
        place=place,
        value=Sentence("{sleeve} and {spool} {spool.unit}", sleeve=in_mm(sleeve), spool=in_mm(spool)),
        expected=Sentence("the temperature that gauge and parts had when they were measured"),
    )


def _part_mean(land: Land, part: Part, readings: list[Reading]) -> _PartMean:
    """Return the mean of a part's readings; of a part without any its nominal diameter."""
    if not readings:
        return _PartMean(land.nominal_of(part))
    groups: dict[tuple[str, float | None], list[Reading]] = defaultdict(list)
    for reading in readings:
        groups[reading.plane, reading.direction].append(reading)
    counted = {station: repeats_that_count(group) for station, group in groups.items()}
    by_station = {station: fmean(reading.diameter for reading in group) for station, group in counted.items()}
    planes: dict[str, list[float]] = defaultdict(list)
    for (plane, _), diameter in by_station.items():
        planes[plane].append(diameter)
    by_plane = {plane: fmean(diameters) for plane, diameters in planes.items()}
    ovalities = [max(diameters) - min(diameters) for diameters in planes.values() if len(diameters) > 1]
    independent = [independent_repeats(group) for group in groups.values()]
    spreads = [_spread(group) for group in independent if len(group) > 1]
    pairs = [(groups[station], counted[station]) for station in groups]
    mean = _PartMean(
        diameter=fmean(by_plane.values()),
        by_station=by_station,
        by_plane=by_plane,
        ovality=max(ovalities, default=None),
        taper=max(by_plane.values()) - min(by_plane.values()) if len(by_plane) > 1 else None,
        repeat_spread=max(spreads, default=None),
        readings=len(readings),
        repeats=min(map(len, independent)),
        doubts=tuple(Disagreement(tuple(every), tuple(some)) for every, some in pairs if len(some) < len(every)),
    )
    return replace(mean, messages=tuple(_part_messages(land, part, readings, groups.values(), mean)))


def repeats_that_count(repeats: Sequence[Reading]) -> list[Reading]:
    """Return the repeats of one place that its mean is made of: all of them, where they agree.

    One slip of the pen would move a mean of two by half of itself, and could so hide wear. Of repeats further apart
    than `REPEAT_TOLERANCE` those count of which more than half agree, the others being slips. Where no more than half
    do, nobody can tell which is wrong, and until it is measured again those count that make the pair widest.
    """
    if _spread(repeats) <= _TOLERATED:
        return list(repeats)
    widest_first = sorted(repeats, key=lambda repeat: -repeat.diameter if repeat.part == "sleeve" else repeat.diameter)
    groups = [
        [repeat for repeat in widest_first[place:] if abs(repeat.diameter - first.diameter) <= _TOLERATED]
        for place, first in enumerate(widest_first)
    ]
    largest = max(groups, key=lambda group: len(independent_repeats(group)))  # of equal ones the widest
    most = 2 * len(independent_repeats(largest)) > len(independent_repeats(repeats))
    return largest if most else groups[0]


def independent_repeats(repeats: Iterable[Reading]) -> list[Reading]:
    """Return the repeats of one station without those whose two coordinates only repeat or swap an earlier one's.

    A microscope reads coordinates to 0.001 mm from an origin of its own, so two settings that agree in both are one
    setting written twice. Diameters without coordinates are taken as independent.
    """
    kept: list[Reading] = []
    seen: set[tuple[float, float]] = set()
    for reading in repeats:
        if reading.coordinates is not None:
            low, high = sorted(reading.coordinates)
            if (low, high) in seen:
                continue
            seen.add((low, high))
        kept.append(reading)
    return kept


def _spread(repeats: Iterable[Reading]) -> float:
    diameters = [reading.diameter for reading in repeats]
    return max(diameters) - min(diameters)


def _stations(spool: _PartMean, sleeve: _PartMean) -> tuple[Station, ...]:
    measured = {**spool.by_station, **sleeve.by_station}
    # a part without directions is known as its mean only: no station of its own beside the other's directions
    named = {plane for plane, direction in measured if direction is not None}
    return tuple(
        Station(*station, spool.at(station), sleeve.at(station))
        for station in measured
        if not (station[1] is None and station[0] in named)
    )


def _part_messages(
    land: Land, part: Part, readings: list[Reading], groups: Iterable[list[Reading]], mean: _PartMean
) -> Iterable[Message]:
    word = land.part_name if part == "spool" else PART_WORDS[part]
    name = Sentence("{land}, {part}", land=named(land), part=word)
    for doubt in mean.doubts:
        first = doubt.repeats[0]
        text = Sentence(
            "{part}, plane {plane}{direction}: repeats are {apart} {apart.unit} apart ({values} {size.unit}), more "
            "than {tolerance} {tolerance.unit}: measure again; until then {counted} {size.unit} counts, {why}",
            part=name,
            plane=first.plane,
            direction=angle(first.direction),
            apart=in_um(doubt.apart),
            values=tuple(in_mm(reading.diameter) for reading in doubt.repeats),
            size=in_mm(first.diameter),
            tolerance=in_um(REPEAT_TOLERANCE),
            counted=tuple(in_mm(reading.diameter) for reading in doubt.counted),
            why=Sentence("on which most of them agree") if doubt.agreed else Sentence("which makes the pair widest"),
        )
        place = next(reading for reading in doubt.repeats if reading not in doubt.counted).place
        yield Message("warning", "repeats_disagree", text, place)
    kept = {id(reading) for group in groups for reading in independent_repeats(group)}
    lost = [reading for reading in readings if id(reading) not in kept]
    if lost:
        text = Sentence(
            "{part}: {lost} of {count} readings only swap or copy the coordinates of another one: no independent "
            "repeats",
            part=name,
            lost=len(lost),
            count=len(readings),
        )
        yield Message("info", "mirrored_repeats", text, lost[0].place)
    planes: dict[str, set[float | None]] = defaultdict(set)
    for reading in readings:
        planes[reading.plane].add(reading.direction)
    single = [plane for plane, directions in planes.items() if len(directions) == 1]
    if single:
        text = Sentence(
            "{part}: measured in one direction only in plane {planes}. A bore wears to one side, so wear found in "
            "one direction is a lower bound",
            part=name,
            planes=single,
        )
        yield Message("warning", "one_direction", text, readings[0].place)
    if mean.ovality is not None and mean.ovality > OVALITY_TO_LOOK_AT:
        text = Sentence(
            "{part}: the directions differ by {ovality} {ovality.unit}: worn to one side, or a slip",
            part=name,
            ovality=in_um(mean.ovality),
        )
        yield Message("warning", "large_ovality", text, readings[0].place)
    far = far_from_nominal(land, part, mean.diameter)
    if far:
        text = Sentence("{part}: mean diameter {far}", part=name, far=far)
        yield Message("warning", "far_from_nominal", text, readings[0].place)


def far_from_nominal(land: Land, part: Part, diameter: float) -> Sentence | None:
    """Say how a diameter [m], as corrected or as read, lies far from its nominal one; nothing where it does not."""
    nominal = land.nominal_of(part)
    if abs(diameter - nominal) <= NOMINAL_TOLERANCE:
        return None
    sizes = {"diameter": in_mm(diameter), "nominal": in_mm(nominal)}
    if "nominal_diameter_mm" in land.representative:
        return Sentence(
            "{diameter} {diameter.unit}, nominal (assumed) {nominal} {nominal.unit}: is it this land?", **sizes
        )
    return Sentence("{diameter} {diameter.unit}, nominal {nominal} {nominal.unit}: is it this land?", **sizes)


def _land_messages(state: LandClearance, place: Place | None) -> Iterable[Message]:
    land = state.land
    name = named(land)
    if state.status == "spool_only":
        text = Sentence(
            "{land}: sleeve not measured; its nominal diameter {nominal} {nominal.unit} was taken, so wear of the "
            "sleeve is not seen",
            land=name,
            nominal=in_mm(state.sleeve_diameter),
        )
        yield Message("warning", "sleeve_missing", text, place)
    elif state.status == "sleeve_only":
        text = Sentence(
            "{land}: {part} not measured; its nominal diameter {nominal} {nominal.unit} was taken, so its wear is "
            "not seen",
            land=name,
            part=land.part_name,
            nominal=in_mm(state.spool_diameter),
        )
        yield Message("warning", "spool_missing", text, place)
    elif state.status == "measured" and state.min_clearance < 0.0 <= state.radial_clearance:
        text = Sentence(
            "{land}: in one direction the sleeve measures {less} {less.unit} smaller than the {part}",
            land=name,
            less=in_um(-2.0 * state.min_clearance),
            part=land.part_name,
        )
        yield Message("warning", "tight_direction", text, place)


def _clearance(sleeve_diameter: float, spool_diameter: float) -> float:
    # eq. (28) refuses a sleeve smaller than its spool; a single direction can be so, and is reported as negative
    if sleeve_diameter >= spool_diameter:
        return clearance_equations.radial_clearance(sleeve_diameter, spool_diameter)
    return -clearance_equations.radial_clearance(spool_diameter, sleeve_diameter)
