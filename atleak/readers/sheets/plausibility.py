"""Whether diameters can be what they say: against the nominal ones, against one another, spool against sleeve."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from operator import attrgetter

from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.repairs import LandKey
from atleak.catalogue.words import PART_WORDS, angle, named
from atleak.common.errors import Place, ReadingsError
from atleak.common.sentences import Sentence, all_of
from atleak.common.units import MM as TO_MM
from atleak.common.units import UM, Quantity, find_unit, unit, unit_names
from atleak.measurements.clearances import NOMINAL_TOLERANCE, REPEAT_TOLERANCE, LandClearance, clearances
from atleak.measurements.readings import Reading, Readings
from atleak.readers.sheets.controller_names import MILLIMETRE, ROUNDED

_CLEARANCE_LIMIT = 0.5e-3  # [m] radial; a pair further apart than this is a slip of the pen: choice of this project
REPEAT_LIMIT = 0.5e-3  # [m] repeats further apart than this are a slip too
_FACTORS = (10.0, 25.4, 1000.0 / 25.4, 100.0, 1000.0, 25400.0)  # between units, or a lost decimal point
_FACTOR_TOLERANCE = 1.2  # a factor is recognised this far off: a nominal diameter is only nominal
_FAR = 2.0  # times the nominal diameter, that is another component's land
_WHOLE_SHEET = 0.8  # of all readings wrong by one factor: the unit is wrong, not the readings
_MANY = 12  # diameters that are not all nominal by chance
_EXCHANGED = 0.1e-3  # [m] within which a diameter is that of another land: choice of this project
_diameter = attrgetter("diameter")
_Off = tuple[Reading, Land, float, float | None]  # far from its nominal diameter: how many times, the factor it is near


def check(readings: Readings, controller: Controller) -> list[ReadingsError]:
    """Return everything that makes readings unusable, in the order of the sheet; nothing where they can be used.

    Refused are diameters off their nominal one by a factor of 10, 25.4, 1000 and other factors between units, or more
    than twice too large or small, repeats more than 0.5 mm apart, a sleeve that measures smaller than its spool, and a
    radial clearance over 0.5 mm.
    """
    problems, doubtful = _factors(readings, controller)
    by_land = _by_land(readings, controller)
    gaps = clearances(readings, controller)
    both_measured = [gap for gap in gaps if gap.status == "measured"]
    swapped = [gap for gap in both_measured if _looks_swapped(gap)]
    if len(swapped) > 1 and len(swapped) >= _WHOLE_SHEET * len(both_measured):
        first = min((by_land[gap.land.key][0].place for gap in swapped), key=_row)
        problem = Sentence(
            "in {swapped} of {measured} lands the sleeve measures smaller than the spool, and the other way round they "
            "would fit: spool and sleeve swapped in the whole sheet?",
            swapped=len(swapped),
            measured=len(both_measured),
        )
        expected = Sentence(
            "in the column of parts 'spool' or 'piston' for the smaller diameter, 'sleeve' for the larger"
        )
        problems.append(ReadingsError(problem, place=replace(first, column=None), expected=expected))
    problems += [problem for _, problem in _contradictions(readings, controller, by_land, gaps, doubtful)]
    if readings.unworn:
        places = {problem.place for problem in problems}
        problems += [problem for problem in check(readings.when_new, controller) if problem.place not in places]
    return sorted(problems, key=lambda problem: _row(problem.place))


def nominal_alone(readings: Readings, controller: Controller) -> Iterator[ReadingsError]:
    """Yield a problem where every diameter of many is the nominal one to the micrometre, as if none was measured."""
    lands = [controller.land_of_plane(reading.component, reading.plane) for reading in readings.readings]
    pairs = zip(readings.readings, lands, strict=True)
    nominal = [one for one, land in pairs if land and abs(land.nominal_of(one.part) - one.diameter) <= ROUNDED]
    if len(nominal) == len(lands) >= _MANY:
        problem = Sentence("all {count} diameters are the nominal ones: a list of sizes, not of readings?")
        place, expected = replace(nominal[0].place, column=None), Sentence("diameters as measured")
        yield ReadingsError(problem.of(count=len(nominal)), place=place, expected=expected)


def _row(place: Place) -> int:
    return place.row or 0


def off_by_factor(readings: Readings, controller: Controller) -> list[tuple[Reading, ReadingsError]]:
    """Return every reading that is too large or small to be of its land, each by itself, and what it looks like.

    These are the diameters that `check` refuses for their size; nothing is said of the sheet as a whole.
    """
    off, _ = _off(readings, controller)
    return [(reading, _off_problem(readings, reading, land, ratio, factor)) for reading, land, ratio, factor in off]


def contradictions(readings: Readings, controller: Controller) -> list[tuple[Land, ReadingsError]]:
    """Return every land of which the readings cannot be together, and why: once for each reason.

    These are what `check` refuses of readings that are of the right size: repeats far apart, a sleeve smaller than its
    spool, and a clearance that no pair has.
    """
    by_land = _by_land(readings, controller)
    return list(_contradictions(readings, controller, by_land, clearances(readings, controller), frozenset()))


def _contradictions(
    readings: Readings,
    controller: Controller,
    by_land: Mapping[LandKey, list[Reading]],
    gaps: Sequence[LandClearance],
    doubtful: Collection[LandKey],
) -> Iterator[tuple[Land, ReadingsError]]:
    apart = list(_repeats(readings, controller, doubtful))
    yield from apart
    exchanged = list(_exchanged(gaps, by_land, readings))
    yield from exchanged
    named_lands = {*doubtful, *(land.key for land, _ in (*apart, *exchanged))}
    for gap in gaps:
        if gap.measured and gap.land.key not in named_lands:
            for problem in _clearance(gap, by_land[gap.land.key], readings):
                yield gap.land, problem


def _by_land(readings: Readings, controller: Controller) -> dict[LandKey, list[Reading]]:
    lands: dict[LandKey, list[Reading]] = defaultdict(list)
    for reading in readings.readings:
        land = controller.land_of_plane(reading.component, reading.plane)
        if land is not None:
            lands[land.key].append(reading)
    return lands


def _factor(ratio: float) -> float | None:
    for factor in _FACTORS:
        for candidate in (factor, 1.0 / factor):
            if 1.0 / _FACTOR_TOLERANCE < ratio / candidate < _FACTOR_TOLERANCE:
                return candidate
    return None


def _off(readings: Readings, controller: Controller) -> tuple[list[_Off], int]:
    off: list[_Off] = []
    compared = 0
    for reading in readings.readings:
        land = controller.land_of_plane(reading.component, reading.plane)
        if land is None:
            continue
        compared += 1
        ratio = reading.diameter / land.nominal_of(reading.part)
        if not 1.0 / _FAR < ratio < _FAR:
            off.append((reading, land, ratio, _factor(ratio)))
    return off, compared


def _factors(readings: Readings, controller: Controller) -> tuple[list[ReadingsError], set[LandKey]]:
    off, compared = _off(readings, controller)
    doubtful = {land.key for _, land, _, _ in off}
    counts = Counter(factor for *_, factor in off if factor is not None)
    common, count = counts.most_common(1)[0] if counts else (None, 0)
    problems = []
    if common is not None and count > 1 and count >= _WHOLE_SHEET * compared:
        first, land, *_ = next(entry for entry in off if entry[3] == common)
        problems.append(_wrong_unit(readings, first, land, common, count, compared))
        off = [entry for entry in off if entry[3] != common]
    return [*problems, *(_off_problem(readings, *entry) for entry in off)], doubtful


def _off_problem(readings: Readings, reading: Reading, land: Land, ratio: float, factor: float | None) -> ReadingsError:
    what = Sentence("the diameter is {ratio:.3g} times the nominal one", ratio=ratio)
    if factor is not None:
        what = Sentence("the diameter is {times} the nominal one: {slip}", times=_times(factor), slip=_slip(factor))
    elif abs(ratio - 0.5) < 0.05:
        what = Sentence("the diameter is {ratio:.3g} times the nominal one: a radius?", ratio=ratio)
    value = _written(readings, reading.diameter)
    return ReadingsError(what, place=reading.place, value=value, expected=_about(readings, land, reading))


def _wrong_unit(readings: Readings, first: Reading, land: Land, factor: float, count: int, of: int) -> ReadingsError:
    stated = find_unit(readings.unit, "length")
    units = () if stated is None else (unit(name, "length") for name in unit_names("length"))
    close = (other for other in units if stated and abs(stated.factor / other.factor - factor) < 1e-6 * factor)
    fits = next((other.said for other in close), None)
    mend = Sentence("check the unit in the heading")
    if fits:
        mend = Sentence("if the numbers are in {unit}, state that unit", unit=fits)
    return ReadingsError(
        Sentence(
            "{count} of {known} diameters, read as {unit}, are {times} the nominal ones: a wrong unit{fits}",
            count=count,
            known=of,
            unit=stated.said if stated else readings.unit,
            times=_times(factor),
            fits=Sentence(" ({unit}?)", unit=fits) if fits else "",
        ),
        place=first.place,
        value=_written(readings, first.diameter),
        expected=Sentence("{about}; {mend}", about=_about(readings, land, first), mend=mend),
    )


def _about(readings: Readings, land: Land, reading: Reading) -> Sentence:
    nominal = _written(readings, land.nominal_of(reading.part))
    return Sentence("about {nominal} ({land})", nominal=nominal, land=named(land))


def _times(factor: float) -> Sentence:
    if factor > 1.0:
        return Sentence("{factor:.4g} times", factor=factor)
    return Sentence("1/{part:.4g} of", part=1.0 / factor)


def _slip(factor: float) -> Sentence:
    size = max(factor, 1.0 / factor)
    if size in (25.4, 25400.0) or abs(size - 1000.0 / 25.4) < 1e-9:
        return Sentence("inch and millimetre mixed?")
    return Sentence("a decimal point lost, or another unit?")


def _written(readings: Readings, metres: float) -> Sentence:
    stated = find_unit(readings.unit, "length") or MILLIMETRE
    return Sentence("{size:.7g} {unit}", size=stated.from_si(metres), unit=stated.said)


def _repeats(
    readings: Readings, controller: Controller, doubtful: Collection[LandKey]
) -> Iterable[tuple[Land, ReadingsError]]:
    groups: dict[object, list[Reading]] = defaultdict(list)
    for reading in readings.readings:
        groups[reading.station].append(reading)
    for group in groups.values():
        low, high = min(group, key=_diameter), max(group, key=_diameter)
        spread = high.diameter - low.diameter
        land = controller.land_of_plane(high.component, high.plane)
        if spread <= REPEAT_LIMIT or land is None or land.key in doubtful:  # what is off by a factor is refused already
            continue
        rows = Sentence(" (rows {first} and {second})", first=low.place.row, second=high.place.row)
        problem = Sentence(
            "repeats of component {component}, {part}, plane {plane} are {spread} apart{rows}",
            component=high.component,
            part=PART_WORDS[high.part],
            plane=high.plane,
            spread=_written(readings, spread),
            rows=rows if high.place.row else "",
        )
        expected = Sentence(
            "about {other}, as the other repeat; a difference over {flagged} is flagged, over {refused} refused",
            other=_written(readings, low.diameter),
            flagged=_written(readings, REPEAT_TOLERANCE),
            refused=_written(readings, REPEAT_LIMIT),
        )
        value = _written(readings, high.diameter)
        yield land, ReadingsError(problem, place=high.place, value=value, expected=expected)


def _exchanged(
    gaps: Sequence[LandClearance], by_land: Mapping[LandKey, list[Reading]], all_readings: Readings
) -> Iterator[tuple[Land, ReadingsError]]:
    """Yield the lands that measure like each other in a circle: their readings stand in each other's place."""
    far = [
        gap.land
        for gap in gaps
        if gap.measured
        and all(
            abs(reading.diameter - gap.land.nominal_of(reading.part)) > NOMINAL_TOLERANCE
            for reading in by_land[gap.land.key]
        )
    ]
    lands = {land.key: land for land in far}
    like: dict[LandKey, list[LandKey]] = defaultdict(list)
    for land, other in product(far, far):
        if all(abs(reading.diameter - other.nominal_of(reading.part)) <= _EXCHANGED for reading in by_land[land.key]):
            like[land.key].append(other.key)
    for land in far:
        circle = [lands[key] for key in _circle(land.key, like)]
        if not circle:
            continue
        problem = Sentence(
            "{land} measures like {other}, and the other way round: the two exchanged?",
            land=named(land),
            other=named(circle[-1]),
        )
        if len(circle) > 2:
            problem = Sentence("{land} measures like {other}: the readings of {lands} exchanged in a circle?")
            problem = problem.of(
                land=named(land), other=named(circle[1]), lands=all_of(map(named, sorted(circle, key=far.index)))
            )
        first = by_land[land.key][0]
        written, about = _written(all_readings, first.diameter), _about(all_readings, land, first)
        yield land, ReadingsError(problem, place=first.place, value=written, expected=about)


def _circle(start: LandKey, like: Mapping[LandKey, Sequence[LandKey]]) -> list[LandKey]:
    """Return the shortest way from a land to the one that it measures like, and so on, back to it; none without one."""
    ways, reached = [[start]], {start}
    for way in ways:  # the short ones first
        for other in like[way[-1]]:
            if other == start:
                return way
            if other not in reached:
                reached.add(other)
                ways.append([*way, other])
    return []


def _clearance(gap: LandClearance, readings: list[Reading], all_readings: Readings) -> Iterator[ReadingsError]:
    land = gap.land
    spool, sleeve = (_written(all_readings, size) for size in (gap.spool_diameter, gap.sleeve_diameter))
    place = _place(readings, "sleeve") or _place(readings, "spool")
    swapped = _swapped_rows(gap, readings, all_readings)
    if swapped is not None:
        yield swapped
    elif gap.radial_clearance < 0.0:
        yield _smaller(gap, spool, sleeve, place)
    elif gap.radial_clearance > _CLEARANCE_LIMIT:
        missing = {"spool_only": PART_WORDS["sleeve"], "sleeve_only": land.part_name}.get(gap.status)
        problem = Sentence(
            "{land}: radial clearance {clearance} {clearance.unit} between {part} {spool} and sleeve {sleeve}"
            "{unmeasured}",
            land=named(land),
            clearance=Quantity(gap.radial_clearance * TO_MM, "length", 3),
            part=land.part_name,
            spool=spool,
            sleeve=sleeve,
            unmeasured=Sentence(" (nominal: the {part} was not measured)", part=missing) if missing else "",
        )
        expected = Sentence(
            "at most {most:g} {most.unit}; the mounting clearance is {new:.4g} {new.unit}",
            most=Quantity(_CLEARANCE_LIMIT * TO_MM, "length"),
            new=Quantity(land.mounting_high * TO_MM, "length"),
        )
        value = sleeve if gap.status != "spool_only" else spool
        yield ReadingsError(problem, place=place, value=value, expected=expected)


def _swapped_rows(gap: LandClearance, readings: list[Reading], all_readings: Readings) -> ReadingsError | None:
    """Return an error where one spool reading exceeds a sleeve reading of its plane, and the other ones fit."""
    spools: dict[tuple[str, float | None], Reading] = {}
    sleeves: dict[tuple[str, float | None], Reading] = {}
    for reading in readings:
        station = reading.plane, reading.direction
        if reading.part == "spool":
            spools[station] = max(spools.get(station, reading), reading, key=_diameter)
        else:
            sleeves[station] = min(sleeves.get(station, reading), reading, key=_diameter)
    pairs = [(spools[station], sleeve) for station, sleeve in sleeves.items() if station in spools]
    if not pairs or gap.max_clearance <= 0.0:
        return None
    spool, sleeve = max(pairs, key=lambda pair: pair[0].diameter - pair[1].diameter)
    if spool.diameter - sleeve.diameter <= REPEAT_TOLERANCE:
        return None
    problem = Sentence(
        "{land}, plane {plane}{direction}: the sleeve measures smaller than the {part}{row} ({spool}): spool and "
        "sleeve swapped there?",
        land=named(gap.land),
        plane=sleeve.plane,
        direction=angle(sleeve.direction),
        part=gap.land.part_name,
        row=Sentence(" in row {row}", row=spool.place.row) if spool.place.row else "",
        spool=_written(all_readings, spool.diameter),
    )
    expected = Sentence("a sleeve larger than the spool in every plane and direction")
    value = _written(all_readings, sleeve.diameter)
    return ReadingsError(problem, place=sleeve.place, value=value, expected=expected)


def _smaller(gap: LandClearance, spool: Sentence, sleeve: Sentence, place: Place | None) -> ReadingsError:
    template, value = Sentence("{land}: the sleeve ({sleeve}) measures smaller than the {part} ({spool})"), sleeve
    expected = Sentence("a sleeve larger than {spool}")
    if gap.status == "spool_only":
        value = spool
        template = Sentence(
            "{land}: the {part} ({spool}) measures larger than the nominal sleeve ({sleeve}), and the sleeve was not "
            "measured"
        )
        expected = Sentence("the sleeve's readings too, or the right nominal diameter in the valve body's file")
    elif gap.status == "sleeve_only":
        template = Sentence(
            "{land}: the sleeve ({sleeve}) measures smaller than the nominal {part} ({spool}), and the {part} was not "
            "measured"
        )
        expected = Sentence("readings of the {part} too, or the right nominal diameter in the valve body's file")
    values = {"land": named(gap.land), "part": gap.land.part_name, "spool": spool, "sleeve": sleeve}
    problem = template.of(**values)
    if gap.status == "measured" and _looks_swapped(gap):
        problem = Sentence(
            "{problem}: spool and sleeve swapped? The other way round the radial clearance would be {swapped} "
            "{swapped.unit}",
            problem=problem,
            swapped=Quantity(-gap.radial_clearance * UM, "clearance", 1),
        )
    return ReadingsError(problem, place=place, value=value, expected=expected.of(**values))


def _looks_swapped(gap: LandClearance) -> bool:
    """Return whether, with spool and sleeve exchanged, the clearance would be that of a valve, new or worn."""
    return 0.0 < -gap.radial_clearance <= max(5.0 * gap.land.mounting_high, 0.1e-3)


def _place(readings: list[Reading], part: str) -> Place | None:
    return next((reading.place for reading in readings if reading.part == part), None)
