"""Learn the mounting clearance of every land from measuring sheets of new or known-good units.

A pair's clearance is that of its type, plus what its unit's lands have in common, plus its own deviation, plus the
error of its measurement: a two-way analysis of variance with random units. Variances are pooled over all lands, and
their degrees of freedom follow Welch and Satterthwaite: two units whose lands all differ by the same amount tell as
much as two values, not as sixty.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from atleak.analysis.learning.outliers import (
    MOST_DEGREES,
    Mask,
    Outliers,
    OutlierTable,
    WhyUnit,
    find_outliers,
    prior_degrees,
)
from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.instruments import Instruments, load_instruments
from atleak.common.errors import Place, ReadingsError
from atleak.common.file_faults import faults_together
from atleak.common.sentences import Sentence
from atleak.diagnosis.uncertainty.assumptions import DEFAULTS
from atleak.diagnosis.uncertainty.sources import LandSources, find_sources
from atleak.measurements.clearances import clearances
from atleak.measurements.readings import Readings


@dataclass(frozen=True)
class ClearanceEstimate:
    """What the kept pairs tell of each land; NaN where none was kept."""

    clearance: NDArray[np.float64]  # [m] their mean
    pairs: NDArray[np.int_]  # kept of each land
    standard_error: NDArray[np.float64]  # [m] of the mean, from the scatter of units and of readings
    degrees: NDArray[np.float64]  # of freedom of that scatter; infinite where only the readings' own error is known
    spread: NDArray[np.float64]  # [m] standard deviation between new pairs, measurement taken off; NaN for one unit
    unresolved: NDArray[np.float64]  # [m] the largest of that and of what the readings could hide of it; NaN likewise
    spread_degrees: NDArray[np.float64]  # of freedom of the unresolved spread, which are fewer
    measurement: NDArray[np.float64]  # [m] standard uncertainty of one unit's clearance that units do not share


def estimate_clearance(clearances: OutlierTable, own: OutlierTable, kept: Mask) -> ClearanceEstimate:
    """Return the estimate of every land.

    Parameters
    ----------
    clearances
        radial clearances [m], a row for each unit and a column for each land.
    own
        standard uncertainty of each that the units do not share [m].
    kept
        the pairs that count.
    """
    pairs = kept.sum(axis=0)
    some = np.maximum(pairs, 1)
    there = pairs > 0
    mean = np.where(there, np.where(kept, clearances, 0.0).sum(axis=0) / some, np.nan)
    noise = np.where(there, np.where(kept, own**2, 0.0).sum(axis=0) / some, np.nan)  # [m²]
    residual = np.where(kept, clearances - mean, 0.0)
    free = np.maximum(pairs - 1, 0)
    if not free.any():
        unknown = np.full(mean.shape, np.nan)
        endless = np.full(mean.shape, math.inf)
        return ClearanceEstimate(mean, pairs, np.sqrt(noise), endless, unknown, unknown, unknown, np.sqrt(noise))
    pooled, pooled_degrees = _pooled(residual, kept, free)
    squares = (residual**2).sum(axis=0)
    prior = prior_degrees(squares, free.astype(float))
    if math.isinf(prior):
        variance, degrees = np.full(mean.shape, pooled), np.full(mean.shape, pooled_degrees)
    else:
        variance = (prior * pooled + squares) / (prior + free)
        degrees = np.minimum(prior + free, pooled_degrees)
    # no readings agree better, in the long run, than they can be read
    total = np.maximum(variance, noise)
    between = np.maximum(variance - noise, 0.0)
    unresolved = np.maximum(between, variance * np.sqrt(2.0 / degrees))  # no less than a variance's standard error
    return ClearanceEstimate(
        clearance=mean,
        pairs=pairs,
        standard_error=np.where(there, np.sqrt(total / some), np.nan),
        degrees=np.maximum(degrees, 1.0),
        spread=np.where(there, np.sqrt(between), np.nan),
        unresolved=np.where(there, np.sqrt(unresolved), np.nan),
        spread_degrees=np.maximum(degrees * (unresolved / np.where(variance > 0.0, variance, 1.0)) ** 2, 1.0),
        measurement=np.sqrt(noise),
    )


def _pooled(residual: OutlierTable, kept: Mask, free: NDArray[np.int_]) -> tuple[float, float]:
    """Return the variance of one pair among units [m²], pooled over lands, and its degrees of freedom."""
    measured = kept.sum(axis=1)
    units = int((measured > 0).sum())
    lands = float(kept.sum()) / units  # of a unit, on average
    shift = residual.sum(axis=1) / np.maximum(measured, 1)
    of_units = float((measured * shift**2).sum()) / (units - 1)
    rest = max(float(free.sum()) - (units - 1), 1.0)
    of_rest = float(np.where(kept, (residual - shift[:, None]) ** 2, 0.0).sum()) / rest
    parts = of_units / lands, (1.0 - 1.0 / lands) * of_rest
    variance = sum(parts)
    if variance <= 0.0:
        return 0.0, rest + units - 1.0
    return variance, variance**2 / (parts[0] ** 2 / (units - 1) + parts[1] ** 2 / rest)


COVERED = 0.95  # of new pairs by a tolerance, and of the true values by an uncertainty
PUBLISHED_NEW = (6.4e-6, 20e-6)  # [m] radial: diametral 0.0127-0.040 mm of new valves (Sonnax, valve body inspection)
_TELLING = 12  # diameters, from which on two sheets that agree in all to the micrometre are one


class ToleranceFrom(StrEnum):
    """What the tolerance of a land's mounting clearance rests on."""

    UNITS = "units"  # how far the measured units differ
    FILE = "file"  # the valve body's file as it was, because one unit shows no spread
    PUBLISHED = "published_range"  # half the published range of new valves, likewise


@dataclass(frozen=True)
class LearnedLand:
    """What the sheets tell of one land. All lengths are radial [m]."""

    land: Land  # as the valve body's file has it so far
    clearance: float  # the mounting clearance that was learned
    uncertainty: float  # half width that holds the true one with 95 %: units, readings and the instruments' calibration
    uncertainty_by_units: float  # the same by the scatter of units and readings alone
    tolerance: float  # half width round the learned one that holds 95 % of new pairs
    tolerance_from: ToleranceFrom  # what the tolerance rests on
    spread: float | None  # standard deviation between new pairs, measurement taken off; None where units show none
    measurement: float  # standard uncertainty of one unit's clearance, but for what all units share
    calibration: float  # standard uncertainty that the instruments leave to all units alike
    units: int  # whose pairs count
    unworn_ends: int  # of them known from an unworn end of the bore


@dataclass(frozen=True)
class LeftOut:
    """A pair of one unit that does not count, because it is not as those of the others are."""

    file: str  # name of the sheet
    component: str  # its number
    land: int  # counted from 1 along the spool
    clearance: float  # [m] as measured
    expected: float  # [m] from the other units

    @property
    def wider(self) -> bool:
        """Return whether it is wider than the others, as wear makes it; a tighter one is a wrong reading."""
        return self.clearance > self.expected


@dataclass(frozen=True)
class LearnedUnit:
    """One measuring sheet: what of it counts."""

    file: str  # name of the sheet
    sha256: str  # of its bytes
    lands: int  # of which both parts were measured as new ones
    of_used_unit: bool  # only what is marked as an unworn end counts
    shift: float  # [m] by which all its lands together are wider than those of the other units
    left_out: WhyUnit | None  # why the unit does not count; None where it does


@dataclass(frozen=True)
class Learned:
    """What several measuring sheets tell of a valve body's type when new."""

    controller: Controller  # whose lands they are
    units: tuple[LearnedUnit, ...]  # one for each sheet
    lands: tuple[LearnedLand, ...]  # of which enough pairs tell
    unlearned: tuple[Land, ...]  # no unit that counts measured them: they keep what the file says
    left_out: tuple[LeftOut, ...]  # pairs that do not count

    @property
    def counted(self) -> tuple[LearnedUnit, ...]:
        """Return the units that were not left out as a whole."""
        return tuple(unit for unit in self.units if unit.left_out is None)

    @cached_property
    def spread(self) -> float | None:
        """Return the standard deviation between new pairs over all lands [m]; None where units show none."""
        return _rms([land.spread for land in self.lands if land.spread is not None])

    @cached_property
    def measurement(self) -> float | None:
        """Return the standard uncertainty of one unit's clearance over all lands [m], but for what units share."""
        return _rms([land.measurement for land in self.lands])


def learn(
    controller: Controller,
    sheets: Sequence[Readings],
    *,
    instruments: Instruments | None = None,
    temperature: float | None = None,
) -> Learned:
    """Return the mounting clearances that measuring sheets of new or known-good units show.

    Of a sheet with readings marked as taken at unworn ends only the lands so marked count; of any other sheet every
    land of which both parts were measured. The same instruments are taken to have measured all units, so that their
    calibration does not average out.

    Parameters
    ----------
    sheets
        one for each unit, as from `atleak.readers.sheets.measuring_sheet.read_readings`.
    instruments
        that measured; the catalogue's defaults unless given.
    temperature
        of measuring [°C], instead of what each sheet states.

    Raises
    ------
    ReadingsError
        no sheet, one that is given twice, or one that tells no clearance of a new pair; all such sheets are named.
    """
    gauges = instruments or load_instruments()
    _require_different(sheets)
    units = [_sources(controller, sheet, gauges, temperature) for sheet in sheets]
    empty = [_tells_nothing(sheet) for sheet, lands in zip(sheets, units, strict=True) if not any(map(_counts, lands))]
    if empty:
        raise faults_together(empty)
    shape = len(sheets), len(controller.lands)
    measured, own, shared = np.full(shape, np.nan), np.full(shape, np.nan), np.full(shape, np.nan)
    for row, lands in enumerate(units):
        for column, each in enumerate(lands):
            if _counts(each):
                measured[row, column] = each.state.radial_clearance
                own[row, column], shared[row, column] = _uncertainties(each)
    outliers = find_outliers(measured, own)
    estimated = estimate_clearance(measured, own, outliers.kept)
    marked = [{controller.land_of_plane(each.component, each.plane) for each in sheet.unworn} for sheet in sheets]
    learned = {
        land.key: _land(
            land,
            column,
            estimated,
            calibration=_rms(shared[outliers.kept[:, column], column]) or 0.0,
            unworn_ends=sum(land in marked[row] for row in np.flatnonzero(outliers.kept[:, column])),
        )
        for column, land in enumerate(controller.lands)
        if estimated.pairs[column]
    }
    return Learned(
        controller=controller,
        units=tuple(
            LearnedUnit(
                sheet.file,
                sheet.sha256,
                lands=sum(map(_counts, units[row])),
                of_used_unit=bool(sheet.unworn),
                shift=float(outliers.shifts[row]),
                left_out=outliers.units.get(row),
            )
            for row, sheet in enumerate(sheets)
        ),
        lands=tuple(learned.values()),
        unlearned=tuple(land for land in controller.lands if land.key not in learned),
        left_out=tuple(_left_out(controller, sheets, measured, outliers)),
    )


# --- from sheets to numbers


def _require_different(sheets: Sequence[Readings]) -> None:
    """Refuse no sheet at all, and readings that are given twice, in the same file or under another name."""
    if not sheets:
        expected = Sentence("one for each unit, new or known to be good")
        raise ReadingsError(Sentence("no measuring sheet is given"), expected=expected)
    first: dict[object, Readings] = {}
    twice = []
    for sheet in sheets:
        content = frozenset((each.station, each.repeat, each.diameter) for each in (*sheet.readings, *sheet.unworn))
        earlier = first.setdefault(content if len(content) >= _TELLING else sheet.sha256, sheet)
        if earlier is not sheet:
            same = Sentence(
                "the same file as {file}: a unit that is counted twice would look like two that agree",
                file=earlier.file,
            )
            alike = Sentence(
                "a file with the same readings as {file}: a unit that is counted twice would look like two that agree",
                file=earlier.file,
            )
            problem, expected = same if earlier.sha256 == sheet.sha256 else alike, Sentence("one sheet for each unit")
            twice.append(ReadingsError(problem, place=Place(sheet.file), expected=expected))
    if twice:
        raise faults_together(twice)


def _tells_nothing(sheet: Readings) -> ReadingsError:
    problem = Sentence("no land has readings of both its spool and its sleeve")
    expected = Sentence("both diameters of a land")
    if sheet.unworn:
        problem = Sentence("no land has readings of its spool and, marked as taken at an unworn end, of its sleeve")
        expected = Sentence("the spool's diameter beside that of the bore at its unworn end")
    return ReadingsError(problem, place=Place(sheet.file, sheet.sheet), expected=expected)


def _sources(
    controller: Controller, sheet: Readings, instruments: Instruments, temperature: float | None
) -> tuple[LandSources, ...]:
    new = sheet.when_new
    measured_at = sheet.measured_at(temperature).value
    states = clearances(new, controller, temperature_c=measured_at, instruments=instruments)
    return find_sources(states, new, controller, instruments, DEFAULTS)[0]


def _counts(land: LandSources) -> bool:
    return land.state.status == "measured"


def _uncertainties(land: LandSources) -> tuple[float, float]:
    """Return the standard uncertainties [m] of a clearance that its unit has alone, and that all units share.

    The calibration of the instruments is the same error in every unit; repeats, rounding, form and the temperature of
    measuring are not.
    """
    calibrations = [source for source in land.sources if source.kind in ("calibration", "common calibration")]
    alone = math.fsum(each.standard_uncertainty**2 for each in calibrations if each.group is None)
    groups = {each.group for each in calibrations if each.group is not None}
    common = math.fsum(land.groups[group] ** 2 for group in groups)
    return math.sqrt(max(land.standard_uncertainty**2 - alone - common, 0.0)), math.sqrt(alone + common)


# --- from numbers to lands


def _land(
    land: Land, column: int, estimated: ClearanceEstimate, *, calibration: float, unworn_ends: int
) -> LearnedLand:
    by_units = _factor(estimated.degrees[column]) * float(estimated.standard_error[column])
    uncertainty = math.hypot(by_units, _factor(math.inf) * calibration)
    spread = float(estimated.spread[column])
    if math.isnan(spread):
        apart, tolerance_from = _known_tolerance(land)
    else:
        apart = _factor(estimated.spread_degrees[column]) * float(estimated.unresolved[column])
        tolerance_from = ToleranceFrom.UNITS
    return LearnedLand(
        land=land,
        clearance=float(estimated.clearance[column]),
        uncertainty=uncertainty,
        uncertainty_by_units=by_units,
        tolerance=math.hypot(apart, uncertainty),
        tolerance_from=tolerance_from,
        spread=None if math.isnan(spread) else spread,
        measurement=float(estimated.measurement[column]),
        calibration=calibration,
        units=int(estimated.pairs[column]),
        unworn_ends=unworn_ends,
    )


def _factor(degrees_of_freedom: float) -> float:
    """Return how many standard uncertainties reach as far as is covered, by Student's distribution."""
    from scipy.special import stdtrit  # dear to import, and seldom needed

    return float(stdtrit(min(degrees_of_freedom, MOST_DEGREES), 0.5 + 0.5 * COVERED))


def _known_tolerance(land: Land) -> tuple[float, ToleranceFrom]:
    """Return how far another new pair may be from this one [m], where one unit alone was measured.

    Two pairs of a type differ by √2 times as much as one differs from the type's value. Half the published range is
    taken as it is: it holds valves of all makes, and those of one type lie closer together (choice of this project).
    """
    if land.mounting_tolerance is not None:
        return math.sqrt(2.0) * land.mounting_tolerance, ToleranceFrom.FILE
    low, high = PUBLISHED_NEW
    return 0.5 * (high - low), ToleranceFrom.PUBLISHED


def _left_out(
    controller: Controller, sheets: Sequence[Readings], measured: OutlierTable, outliers: Outliers
) -> Iterator[LeftOut]:
    """Yield the pairs that do not count by themselves, those of units left out for other reasons aside."""
    for row, column in zip(*np.nonzero(outliers.wide | outliers.tight), strict=True):
        land = controller.lands[column]
        expected = float(outliers.expected[row, column])
        yield LeftOut(sheets[row].file, land.component, land.land, float(measured[row, column]), expected)


def _rms(values: Sequence[float] | OutlierTable) -> float | None:
    return math.sqrt(math.fsum(float(each) ** 2 for each in values) / len(values)) if len(values) else None
