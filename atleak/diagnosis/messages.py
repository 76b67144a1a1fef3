"""Say what a person should know about a result: what is assumed, left out, out of its range, or odd about its sheet.

Of a measuring sheet as a whole: all pairs moved alike, pairs tighter than new ones can be, spools and sleeves measured
unequally often, a temperature that job and sheet state differently, a sheet older than the road test. Nothing is
corrected.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from statistics import median

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_tables import NewOrigin
from atleak.catalogue.operating_point import HOT_IDLE, OperatingPoint
from atleak.catalogue.pump import Pump
from atleak.common.errors import Message, Place
from atleak.common.sentences import Name, Sentence, all_of
from atleak.common.units import KPA, UM, Quantity
from atleak.diagnosis.land import without_rate
from atleak.diagnosis.road import RoadDiagnosis
from atleak.diagnosis.rules import cannot_be
from atleak.diagnosis.uncertainty import UnitUncertainty
from atleak.diagnosis.uncertainty.sources import LandSources
from atleak.engine.gap_messages import narrow_gap_messages
from atleak.engine.profile import Profile
from atleak.engine.projection import BesideNew, Projection
from atleak.measurements.clearances import LandClearance
from atleak.measurements.readings import MeasuringTemperature, Readings
from atleak.measurements.road_test import RoadTest

# All choices of this project; benchmarks/common_shift.py says how often they are right.
FEWEST_PAIRS = 5  # that show a common shift; all of them must agree with it, within twice their own uncertainty
OTHERS = 0.2  # of the pairs beyond those may be worn besides
FAR = 3.0  # standard uncertainties from zero: of the instruments' common error, and of the estimate itself
RESOLVED = 2.5  # times its own uncertainty by which a pair must have opened, so that wear would show by its spread
DAYS_OLDER = 30  # than the road test, from where on a sheet may be of another state
SLIP_FROM = 8.0  # times the mounting clearance, from where on an opened pair may be a slip of the pen
_SLIP_LEAST = 0.1e-3  # [m] that the radial clearance must have besides
_KEPT = 2.5  # standard uncertainties within which a pair counts for the estimate
_ROUNDS = 20
LANDS_LISTED = 12  # by a message: choice of this project


@dataclass(frozen=True)
class CommonShift:
    """A shift of all measured pairs against their mounting clearances, as the pairs themselves estimate it."""

    shift: float  # [m] in the radial clearance
    standard_uncertainty: float  # [m] of the estimate
    common_error: float  # [m] standard uncertainty that the instruments leave to all pairs together
    pairs: int
    agreeing: int  # within twice their own uncertainty


def sheet_messages(
    readings: Readings | None,
    measured_at: MeasuringTemperature | None,
    uncertainty: UnitUncertainty | None,
    road_test: RoadTest | None,
    mileage: float | None,
) -> Iterator[Message]:
    """Yield what is to be said of a sheet as a whole, and of how sure its lands are; nothing without a sheet."""
    if uncertainty is None:
        return
    lands, place = [land.sources for land in uncertainty.lands], Place()
    if readings is not None and measured_at is not None:
        place = Place(readings.file, readings.sheet)
        yield from _other_temperature(readings, measured_at, place)
        yield from _older(readings, road_test, place)
        yield from _shifted(lands, place)
    yield from _suspect(lands, readings, place)
    yield from _slips(lands, readings, place)
    yield from _unequal_repeats([land.state for land in lands], place)
    if (rateless := without_rate(uncertainty.lands, mileage)) is not None:
        yield rateless
    yield from uncertainty.messages


# --- all pairs moved alike


def common_shift(lands: Sequence[LandSources]) -> CommonShift | None:
    """Return the shift by which all measured pairs moved alike; None where they did not.

    Wear differs from pair to pair and only opens them; a setting ring or a temperature moves all by the same amount. A
    shift is reported where most pairs agree with it within their own uncertainty, and it is far larger than both what
    is uncertain of it and what the instruments' certificates leave to all pairs in common. A shift that opens the
    pairs is none where a pair's own uncertainty could hide the spread of wear, or where the pairs have rather grown by
    one and the same fraction. Lands of whose mounting clearance only a range is known say nothing.
    """
    measured = [land for land in lands if land.state.status == "measured"]
    pairs = [land for land in measured if len(set(land.state.land.mounting_range)) == 1]
    if len(pairs) < FEWEST_PAIRS:
        return None
    opened = [land.state.radial_clearance - land.state.land.new_clearance for land in pairs]
    own = [math.hypot(math.sqrt(land.own_variance), land.u_mounting) for land in pairs]
    if min(own) <= 0.0:
        return None
    shift, u_shift = _agreed(opened, own)
    agreeing = sum(abs(each - shift) <= 2.0 * u for each, u in zip(opened, own, strict=True))
    common = CommonShift(shift, u_shift, _common_error(pairs), len(pairs), agreeing)
    others = len(pairs) - agreeing
    if others > OTHERS * (len(pairs) - FEWEST_PAIRS) or abs(shift) <= FAR * math.hypot(common.common_error, u_shift):
        return None
    new = [land.state.land.new_clearance for land in pairs]
    if shift > 0.0 and (shift < RESOLVED * median(own) or _is_growth(opened, own, new, shift)):
        return None
    return common


def _agreed(values: Sequence[float], own: Sequence[float]) -> tuple[float, float]:
    """Return the weighted mean of the values that agree with each other, and its standard uncertainty."""
    centre = median(values)
    weight = 0.0
    for _ in range(_ROUNDS):
        kept = [(each, 1.0 / u**2) for each, u in zip(values, own, strict=True) if abs(each - centre) <= _KEPT * u]
        if not kept:
            return centre, max(own)
        before, weight = centre, math.fsum(w for _, w in kept)
        centre = math.fsum(each * w for each, w in kept) / weight
        if centre == before:
            break
    return centre, weight**-0.5


def _common_error(pairs: Sequence[LandSources]) -> float:
    """Return the standard uncertainty [m] of the mean clearance that comes from errors which all pairs share."""
    groups = {name for land in pairs for name in land.groups}
    means = (math.fsum(land.groups.get(name, 0.0) for land in pairs) / len(pairs) for name in groups)
    return math.sqrt(math.fsum(mean * mean for mean in means))


def _is_growth(opened: Sequence[float], own: Sequence[float], new: Sequence[float], shift: float) -> bool:
    """Return whether one fraction of their mounting clearances fits the pairs better than one amount does."""
    growth, _ = _agreed([each / c for each, c in zip(opened, new, strict=True)], [
        u / c for u, c in zip(own, new, strict=True)
    ])  # fmt: skip

    def misfit(expected: Sequence[float]) -> float:
        squares = (((each - e) / u) ** 2 for each, e, u in zip(opened, expected, own, strict=True))
        return math.fsum(min(square, _KEPT**2) for square in squares)

    return misfit([growth * c for c in new]) < misfit([shift] * len(new))


def _shifted(lands: Sequence[LandSources], place: Place) -> Iterator[Message]:
    common = common_shift(lands)
    if common is None:
        return
    text = Sentence(
        "All pairs moved alike: {agreeing} of {pairs} measure {shift} ± {uncertainty} {uncertainty.unit} {way} than "
        "their mounting clearance. Wear differs from pair to pair; a setting ring, a zero or a temperature moves all "
        "by the same amount (the instruments' certificates allow {allowed} {allowed.unit}). Nothing was corrected: "
        "check the gauges and the mounting clearances",
        agreeing=common.agreeing,
        pairs=common.pairs,
        shift=_um(abs(common.shift)),
        uncertainty=_um(2.0 * common.standard_uncertainty),
        way=Sentence("wider") if common.shift > 0.0 else Sentence("tighter"),
        allowed=_um(2.0 * common.common_error),
    )
    yield Message("warning", "pairs_moved_alike", text, place)


# --- single pairs that cannot be so


def _suspect(lands: Sequence[LandSources], readings: Readings | None, place: Place) -> Iterator[Message]:
    suspects = [land for land in lands if land.suspect]
    if not suspects:
        return
    named = tuple(
        Sentence(
            "{pair} {clearance} {clearance.unit} (new {new})",
            pair=_pair(land),
            clearance=_um(land.state.radial_clearance),
            new=_um(land.state.land.mounting_range[0]),
        )
        for land in suspects[:LANDS_LISTED]
    )
    more = tuple(map(_pair, suspects[LANDS_LISTED:]))
    text = Sentence(
        "Tighter than a new pair, by more than three standard uncertainties: {named}{more}. Wear cannot do that, so "
        "these pairs are not passed: check the readings, the gauges and the mounting clearance",
        named=named,
        more=Sentence("; and {pairs}", pairs=more) if more else "",
    )
    yield Message("warning", "tighter_than_new", text, _place_of(suspects[0], readings, place))


def _slips(lands: Sequence[LandSources], readings: Readings | None, place: Place) -> Iterator[Message]:
    for land in lands:
        clearance, new = land.state.radial_clearance, land.state.land.mounting_high
        if land.state.measured and clearance >= max(SLIP_FROM * new, _SLIP_LEAST):
            text = Sentence(
                "{pair}: radial clearance {clearance} {clearance.unit}, {times:.2g} times the mounting clearance "
                "({new} {new.unit}): a slip? Look at its readings",
                pair=_pair(land),
                clearance=_um(clearance),
                times=clearance / new if new else math.inf,
                new=_um(new),
            )
            yield Message("warning", "clearance_far_open", text, _place_of(land, readings, place))


def _place_of(land: LandSources, readings: Readings | None, sheet: Place) -> Place:
    component, planes, leak = land.key[0], land.state.land.planes, land.state.leak
    of_sheet = () if readings is None else readings.readings
    places = (each.place for each in of_sheet if each.component == component and each.plane in planes)
    return next(places, leak.reading.place if leak else sheet)


def _unequal_repeats(states: Sequence[LandClearance], place: Place) -> Iterator[Message]:
    measured = [state for state in states if state.status == "measured"]
    unequal = [state for state in measured if state.spool_repeats != state.sleeve_repeats]
    if 2 * len(unequal) <= len(measured):
        return
    counts = {(state.spool_repeats, state.sleeve_repeats) for state in unequal}
    if len(counts) == 1:
        ((spools, sleeves),) = counts
        what = Sentence(
            "spools were measured {spools} in each place, sleeves {sleeves}",
            spools=_times(spools),
            sleeves=_times(sleeves),
        )
        fewer = Sentence("the spool") if spools < sleeves else Sentence("the sleeve")
    else:
        each = tuple(all_of(map(str, times)) for times in sorted(counts))
        what = Sentence("spools and sleeves were measured unequally often ({each} times)", each=each)
        fewer = Sentence("the part measured less often")
    text = Sentence(
        "In {unequal} of {measured} pairs {said}, counting independent repeats: {fewer} limits what the other's "
        "repeats can tell",
        unequal=len(unequal),
        measured=len(measured),
        said=what,
        fewer=fewer,
    )
    yield Message("info", "unequal_repeats", text, place)


def _times(count: int) -> Sentence:
    if count == 1:
        return Sentence("once")
    return Sentence("twice") if count == 2 else Sentence("{count} times", count=count)


def _um(metres: float) -> Quantity:
    return Quantity(metres * UM, "clearance", 1)


def _pair(land: LandSources) -> str:
    return f"{land.key[0]}/{land.key[1]}"


# --- what the head of the sheet states


def _other_temperature(readings: Readings, measured_at: MeasuringTemperature, place: Place) -> Iterator[Message]:
    if readings.temperature is not None and readings.temperature != measured_at.value:
        text = Sentence(
            "The head of the sheet states a measuring temperature of {sheet:g} {sheet.unit}, the job {job:g} "
            "{job.unit}: the job's is taken",
            sheet=Quantity(readings.temperature, "temperature"),
            job=Quantity(measured_at.value, "temperature"),
        )
        yield Message("warning", "measuring_temperature_differs", text, place)


def _older(readings: Readings, road_test: RoadTest | None, place: Place) -> Iterator[Message]:
    if road_test is None or road_test.date is None or readings.date is None:
        return
    days = (road_test.date - readings.date).days
    if days > DAYS_OLDER:
        text = Sentence(
            "The sheet is dated {sheet}, the road test {file} {driven}: {days} days later. The clearances may be those "
            "of an earlier state",
            sheet=readings.date,
            file=road_test.file,
            driven=road_test.date,
            days=days,
        )
        yield Message("warning", "sheet_older_than_road_test", text, place)


def _what_new_was(controller: Controller) -> Iterable[Message]:
    """Say what the mounting clearances are, where they are not those of these very pairs when new."""
    counts, lands = Counter(land.new_origin for land in controller.lands), len(controller.lands)
    of_origin = {
        NewOrigin.USED_UNIT: Sentence(
            "The mounting clearance of {count} of {lands} lands was measured on a used unit and is taken as new: wear "
            "counts from there.",
            count=counts[NewOrigin.USED_UNIT],
            lands=lands,
        ),
        NewOrigin.TYPE: Sentence(
            "The mounting clearance of {count} of {lands} lands is a value of the unit's type: how far single pairs "
            "differ from it counts in their wear.",
            count=counts[NewOrigin.TYPE],
            lands=lands,
        ),
        NewOrigin.RANGE: Sentence(
            "The mounting clearance of {count} of {lands} lands is known as a range only: wear counts from its upper "
            "end; how likely a pair within it is worn follows from all pairs measured. Flows when new are those of its "
            "mean cube.",
            count=counts[NewOrigin.RANGE],
            lands=lands,
        ),
    }
    for origin, text in of_origin.items():
        if counts[origin]:
            yield Message("info", f"mounting_clearance_{origin}", text)


def _about_pump(pump: Pump, profile: Profile, readings: Readings | None) -> Iterable[Message]:
    """Say what shares of a pump held at demand are of, what measured clearances do, and which are over their limit."""
    if pump.held_at_demand:
        text = Sentence(
            "The pump's displacement is held at demand: its capacity, all shares, its reserve and the speed from which "
            "it covers the leakage are those of its full stroke."
        )
        yield Message("info", "pump_full_stroke", text)
    if pump.counted.any_known and profile.pump_efficiency != "wilson":
        text = Sentence("The pump's measured clearances count nowhere: the profile takes its efficiency as a constant.")
        yield Message("warning", "pump_clearance_left_out", text)
    for name, missing in pump.left_out:
        if name == "side":
            text = Sentence(
                "The pump's side clearance was measured, but makes no slip here: {missing}.", missing=missing
            )
        else:
            text = Sentence(
                "The pump's tip clearance was measured, but makes no slip here: {missing}.", missing=missing
            )
        yield Message("warning", "pump_clearance_left_out", text)
    of_sheet = (None, None) if readings is None else readings.pump.um
    for name, um, most, in_head in zip(("side", "tip"), pump.measured.um, pump.limits.um, of_sheet, strict=True):
        if in_head is not None and um is not None and um != in_head:
            yield Message("warning", "pump_clearance_differs", _differs(name, in_head, um))
        if um is not None and most is not None and um > most:
            yield Message("warning", "pump_clearance_over_limit", _over_limit(name, um, most))
    if pump.counted.any_known and pump.as_new is None:
        text = Sentence(
            "The slip of the pump when new is not known, so that of the measured one stands beside no other."
        )
        yield Message("info", "pump_new_unknown", text)


def _differs(name: str, in_head: float, um: float) -> Sentence:
    values = {"of_head": Quantity(in_head, "clearance"), "of_job": Quantity(um, "clearance")}
    if name == "side":
        return Sentence(
            "The head of the sheet states a pump side clearance of {of_head:g} {of_head.unit}, the job {of_job:g} "
            "{of_job.unit}: the job's is taken.",
            **values,
        )
    return Sentence(
        "The head of the sheet states a pump tip clearance of {of_head:g} {of_head.unit}, the job {of_job:g} "
        "{of_job.unit}: the job's is taken.",
        **values,
    )


def _over_limit(name: str, um: float, most: float) -> Sentence:
    values = {"measured": Quantity(um, "clearance"), "most": Quantity(most, "clearance")}
    if name == "side":
        return Sentence(
            "The pump's side clearance of {measured:g} {measured.unit} is over the {most:g} {most.unit} that its "
            "manual allows.",
            **values,
        )
    return Sentence(
        "The pump's tip clearance of {measured:g} {measured.unit} is over the {most:g} {most.unit} that its manual "
        "allows.",
        **values,
    )


def _cannot_be(unworn: Iterable[Projection], points: Sequence[OperatingPoint]) -> Iterable[Message]:
    """Doubt a description by which a new unit cannot hold its pressure, and a condition set by hand, likewise."""
    lacking = [each for each in unworn if cannot_be(each)]
    own = {each.condition.label: _lack(each) for each in lacking if each.condition in points}
    if own:
        text = Sentence(
            "Not judged: the description of the unit cannot be right. With every land and its pump new it could not "
            "hold its pressure: {conditions}. Look at the pump's displacement, what consumers take, clearances (half "
            "of bore minus spool, in µm), diameters and pressures, and at temperature and speed where they were set "
            "by hand.",
            conditions=tuple(own.values()),
        )
        yield Message("warning", "description_impossible", text)
    by_hand = tuple(_lack(each) for each in lacking if each.condition not in points)
    if by_hand:
        text = Sentence(
            "Not judged at the condition set by hand, which no new unit holds: {conditions}.", conditions=by_hand
        )
        yield Message("warning", "condition_impossible", text)


def _lack(new: Projection) -> Sentence:
    values = {"condition": new.condition, "reserve": new.reserve}
    if not new.pressure_falls:
        return Sentence("at {condition} its pump supplies {reserve:.2f} times what is taken", **values)
    return Sentence(
        "{held:.0f} of {required:.0f} {required.unit} at {condition}, its pump supplying {reserve:.2f} "
        "times what is taken",
        held=Quantity(new.main_pressure_held * KPA, "pressure"),
        required=Quantity(new.condition.main_pressure * KPA, "pressure"),
        **values,
    )


def messages_of(unit: BesideNew, road: RoadDiagnosis, readings: Readings | None) -> Iterator[Message]:
    """Yield the messages on inputs and projections; those of gauges, log and uncertainty are not among them."""
    controller, fluid, profile = unit.model.controller, unit.model.fluid, unit.model.profile
    yield from _cannot_be(unit.unworn, controller.operating_points)
    yield from controller.doubts
    yield from fluid.doubts
    yield from _about_controller(controller, {projection.condition.gear for projection in unit.now})
    yield from _what_new_was(controller)
    yield from _about_pump(controller.pump, profile, readings)
    if readings is None:
        text = Sentence("No measuring sheet: every land is computed at its mounting clearance.")
        if any(state.leak for state in unit.states):
            text = Sentence(
                "No measuring sheet: every land that no vacuum test measured is computed at its mounting clearance."
            )
        yield Message("warning", "no_readings", text)
    else:
        yield from readings.messages
    said_once = {"one_direction"} if readings is not None and readings.one_direction else set()  # of all lands together
    for state in unit.states:
        yield from (message for message in state.messages if message.code not in said_once)
    temperatures = [projection.condition.temperature for projection in unit.now]
    if road.log is not None and road.leakage is not None:
        temperatures += road.log.temperatures or ()
    yield from fluid.messages(min(temperatures), max(temperatures), profile.viscosity)
    yield from narrow_gap_messages(gap for projection in unit.now for gap in projection.gaps)
    yield from _about_conditions(controller, unit.now)
    if road.leakage is not None:
        yield from road.leakage.road_test.messages
        yield from road.leakage.messages


def _about_controller(controller: Controller, gears: Collection[int]) -> Iterator[Message]:
    """Say what a valve body's file assumes, and which of its lands and circuits are not judged in some gears."""
    without = [land for land in controller.lands if land.key in controller.gaps_not_described]
    if 0 < len(without) < sum(not land.seal for land in controller.lands):
        text = Sentence(
            "{controller} names no gap of lands {lands}: they are taken to leak from main pressure to the sump in "
            "every gear, which is an upper bound.",
            controller=Name(controller.name),
            lands=[f"{land.component}/{land.land}" for land in without],
        )
        yield Message("warning", "land_without_gap", text)
    sealed = [f"{land.component}/{land.land}" for land in controller.lands if land.seal]
    if sealed:
        text = Sentence(
            "A ring seals lands {lands}: they leak nothing through their clearance, which is not judged. What passes a "
            "ring is a leak of its own.",
            lands=sealed,
        )
        yield Message("info", "land_sealed", text)
    nowhere = [Name(circuit.name) for circuit in controller.circuits if circuit.gears.isdisjoint(gears)]
    if nowhere:
        text = Sentence("No operating point applies {circuits}: what they hold is judged nowhere.", circuits=nowhere)
        yield Message("warning", "circuit_nowhere_applied", text)


def _about_conditions(controller: Controller, projections: Sequence[Projection]) -> Iterator[Message]:
    for projection in projections:
        yield from projection.messages
        if projection.pump_capacity <= 0.0:
            text = Sentence(
                "{condition}: the pump delivers nothing at this pressure and viscosity.",
                condition=projection.condition,
            )
            yield Message("warning", "pump_delivers_nothing", text)
    if all(projection.condition.name != HOT_IDLE for projection in projections):
        text = Sentence(
            "{controller} states no operating point hot_idle, where a worn unit fails first.",
            controller=Name(controller.name),
        )
        yield Message("info", "no_hot_idle", text)
