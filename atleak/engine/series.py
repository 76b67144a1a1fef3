"""Compute the leakage of every sample of a log: the physics of `atleak.engine.leakage`, in an order that costs little.

The physics is changed in ``leakage.py``. This file must agree with it, and ``tests/unit/engine/test_series.py`` shows
whether it does: against a slow loop over samples and gaps, and against ``leakage.py`` at single conditions.

Why it is quick
---------------
One gap leaks ``q = Δp · π D c³ / (12 μ l)``.

1. *Polynomials.* The clearance is linear in temperature, ``c = c_r + a τ`` with ``τ = T − T₀``, and so is the diameter
   D where it is the mean one. Hence ``π D c³ / 12 l = P(τ)``, a polynomial of degree 4: its five coefficients are
   computed once and hold for every sample.
   Where it differs around the circumference, ``c³ + 3 c m₂ + m₃`` stands for c³, of no higher degree.
2. *Groups.* Gaps whose pressure drops differ in size only (0.9 p_g and 0.5 p_g) leak ``μ q = p_g (0.9 P₁ + 0.5 P₂)``:
   their polynomials are added up once. So 600 gaps cost what 6 do.
3. *Powers.* The powers 1, τ … τ⁴ of all samples are the rows of a matrix. One product with the matrix of coefficients
   gives the polynomials of all groups at all samples.
4. *Straight lines.* p_s and p_m are straight lines in p_g up to the limit of their valves, and every drop is a sum of
   section pressures. Where no limit begins among some samples, the total is therefore linear in the two measured
   pressures: ``μ q = p_g M₁(τ) + p_k M₂(τ) + M₃(τ)``. Three polynomials, whatever the number of gaps and groups; the
   viscosity of a sample costs more than its flow.

What breaks it, and what is done then
-------------------------------------
- A drop that turns negative leaks nothing, so that a sum of drops is no straight line (4). A line is lowest at an end:
  the lowest and highest pressures of some samples show whether any drop of theirs is negative. Where one is, or the
  limit of a valve begins, those samples are computed group by group (3).
- The flow of a section is a sum over groups: where sections are asked for, all samples are computed group by group.
- A gap that closes in the cold leaves its polynomial (1): it is computed on its own, by the gap law of ``leakage.py``,
  wherever the range of temperature of some samples reaches so far.
- With entry loss a flow is not linear in its drop (2). With ``auto`` a gap stays in its group, without the loss, as
  long as that takes less than 1 % of its flow at the largest drop, the widest gap and the thinnest fluid of the log
  taken together. The other gaps, or with ``on`` all of them, are computed on their own.

A log is worked through in chunks that fit the processor's cache. The work rows are taken once, because fresh memory
costs more than the sums.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np

from atleak.catalogue.circuits import SECTIONS
from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Controller
from atleak.catalogue.operating_point import OperatingPoint
from atleak.engine.leakage import GapGeometry, GapLaw, LeakageModel
from atleak.engine.log_gaps import CircuitLog, follows_polynomial, polynomial, without_entry_loss
from atleak.engine.log_gaps import powers as write_powers

_CHUNK = 32_768  # samples worked on at a time: the work arrays of one chunk stay in the processor's cache

_RUNS = 32  # runs of one gear in a chunk, above which masks are quicker than slices

_Any = TypeVar("_Any")
_Drop = tuple[tuple[str, float], ...]  # (section, coefficient) …


@dataclass
class LeakageSeries:
    """Leakage over a log, arrays of shape (samples,); NaN where a channel was not usable.

    ``reversed_samples`` counts, per section, samples whose pressure drop was negative in at least one gap of it: they
    count as zero flow there.
    """

    total: np.ndarray  # [m³/s] that counts as leakage
    sections: dict[str, np.ndarray]  # [m³/s] let out to the sump, of circuits too; empty unless asked for
    circuits: dict[str, np.ndarray] = field(default_factory=dict)  # [Pa] the pressure that each holds; 0 where vented
    unbalanced: int = 0  # samples at which no pressures were found at which all circuits balance
    reversed_samples: dict[str, int] = field(default_factory=lambda: dict.fromkeys(SECTIONS, 0))
    outside_fluid: int = 0  # samples at a temperature the fluid's data do not cover
    other_gear: int = 0  # samples in a gear the controller does not have


def leakage_series(
    model: LeakageModel,
    main_pressure: Any,
    converter_pressure: Any,
    temperature: Any,
    gear: Any,
    *,
    sections: bool = False,
    assumed: OperatingPoint | None = None,
) -> LeakageSeries:
    """Compute the leakage of every sample of a log.

    Parameters
    ----------
    main_pressure, converter_pressure
        [Pa], shape (samples,) or scalar; NaN gives NaN.
    temperature
        [°C], likewise.
    gear
        Likewise; a gear the controller does not have, or NaN, gives NaN.
    sections
        Whether the totals of p_g, p_s, p_m, p_k and the circuits are kept too.
    assumed
        The operating point whose set pressures hold, where they go by point or current; the controller's first unless
        given.
    """
    arrays = [np.asarray(array, dtype=float) for array in (main_pressure, converter_pressure, temperature, gear)]
    size = np.broadcast_shapes(*(array.shape for array in arrays), (1,))[0]
    log = _Log(*(np.broadcast_to(array, (size,)) for array in arrays))
    series = LeakageSeries(np.empty(size), {name: np.empty(size) for name in SECTIONS} if sections else {})
    spanned = log.ends
    sums = _gear_sums(model, spanned)
    rows = np.ones((8, min(_CHUNK, size)))
    for start in range(0, size, _CHUNK):
        part = slice(start, start + _CHUNK)
        _compute_chunk(model, sums, log.part(part), series, part, rows[:, : size - start])
    circuits = CircuitLog.of(
        model,
        assumed or model.controller.operating_points[0],
        float(np.nanmax(spanned.sections(model), initial=0.0)),
        spanned.temperature,
    )
    if circuits is not None:
        _add_circuits(circuits, log, series)
    return series


def _add_circuits(circuits: CircuitLog, log: _Log, series: LeakageSeries) -> None:
    """Add the pressures of circuits to a series, and the flows that do not follow from the sections alone."""
    controller = circuits.model.controller
    usable = np.isfinite(series.total) & np.isfinite(log.converter_pressure)
    series.circuits = {circuit.id: np.full(len(usable), np.nan) for circuit in controller.circuits}
    if series.sections:
        series.sections |= {name: np.zeros(len(usable)) for name in series.circuits}
    for flow in (series.total, *series.sections.values()):
        flow[~usable] = np.nan
    channels = log.main_pressure, log.converter_pressure, log.temperature
    for gear in controller.gears:
        samples = np.flatnonzero(usable & (log.gear == gear))
        for part, (balance, drawn, reversed_drops) in circuits.parts(gear, samples, *channels):
            for name, pressures in series.circuits.items():
                pressures[part] = balance.pressures[name]
            for name, flow in drawn.items():
                series.total[part] += flow
                if series.sections:
                    series.sections[name][part] += flow
            for name, reverse in reversed_drops.items():
                series.reversed_samples[name] = series.reversed_samples.get(name, 0) + int(np.count_nonzero(reverse))
            series.unbalanced += len(part) - int(np.count_nonzero(np.broadcast_to(balance.converged, len(part))))


# --- the gaps of one gear, added up


#: One gap as a polynomial times a pressure drop, ``μ q = drop · P(τ)``: the gap; its section, and its drop divided by
#: the size of the first coefficient; and of π D c³/12l times that size the coefficients of τ⁰ … τ⁴.
_Term = tuple[GapGeometry, tuple[str, _Drop], tuple[float, ...]]


def _term(geometry: GapGeometry, law: GapLaw) -> _Term:
    size = abs(geometry.drop_coefficients[0][1])
    drop = tuple((section, round(value / size, 12)) for section, value in geometry.drop_coefficients)
    return geometry, (geometry.gap.section, drop), polynomial(geometry, law, size)


@dataclass(frozen=True)
class _GearSum:
    """The gaps of one gear: added up in groups of one drop, but for those that have to be computed on their own."""

    law: GapLaw
    terms: tuple[_Term, ...]
    alone: tuple[GapGeometry, ...] = ()
    always_open: bool = False  # no gap of a group closes at any temperature that the fluid's data cover

    @cached_property
    def groups(self) -> tuple[tuple[str, _Drop], ...]:
        """Return section and drop of each group, in the order in which the controller names their first gap."""
        return tuple(dict.fromkeys(group for _, group, _ in self.terms))

    @cached_property
    def polynomials(self) -> np.ndarray:
        """Return the polynomials of the gaps of each group, added up: shape (groups, 5)."""
        sums, number = np.zeros((len(self.groups), 5)), {group: row for row, group in enumerate(self.groups)}
        if self.terms:
            np.add.at(sums, [number[group] for _, group, _ in self.terms], [own for _, _, own in self.terms])
        return sums

    @cached_property
    def drops(self) -> np.ndarray:
        """Return the drop of each group as coefficients of the section pressures, shape (groups, sections)."""
        return np.array([[dict(drop).get(section, 0.0) for section in SECTIONS] for _, drop in self.groups])

    def at(self, temperature: np.ndarray) -> _GearSum:
        """Return these gaps with those set apart that close somewhere between the given temperatures [°C]."""
        if self.always_open or not self.terms:
            return self
        open_ = follows_polynomial([geometry for geometry, *_ in self.terms], self.law, *_span(temperature)).tolist()
        if all(open_):
            return self
        terms, closing = _parted(self.terms, open_)
        return _GearSum(self.law, tuple(terms), (*self.alone, *(geometry for geometry, *_ in closing)))


def _parted(each: Sequence[_Any], chosen: Sequence[bool]) -> tuple[list[_Any], list[_Any]]:
    """Return those that are chosen, and the others."""
    pairs = list(zip(each, chosen, strict=True))
    return [one for one, keep in pairs if keep], [one for one, keep in pairs if not keep]


def _gear_sums(model: LeakageModel, ends: _Log) -> dict[int, _GearSum]:
    """Add up the gaps of each gear that count as drawn from the pump."""
    gaps = [
        geometry
        for geometry in model.geometries
        if geometry.drawn_from_pump and geometry.drop_coefficients and geometry.follows_sections
    ]
    drops = [[dict(gap.drop_coefficients).get(section, 0.0) for section in SECTIONS] for gap in gaps]
    largest = np.max(np.array(drops).reshape(-1, len(SECTIONS), 1) * ends.sections(model), axis=2).sum(axis=1)
    in_groups, alone = _parted(gaps, without_entry_loss(model, gaps, largest, ends.temperature))
    terms = [_term(geometry, model.law) for geometry in in_groups]
    always_open = bool(follows_polynomial(in_groups, model.law, *model.fluid.span(model.profile.viscosity)).all())
    return {
        gear: _GearSum(
            model.law,
            tuple(term for term in terms if gear in term[0].gap.gears),
            tuple(geometry for geometry in alone if gear in geometry.gap.gears),
            always_open,
        )
        for gear in model.controller.gears
    }


# --- the samples


@dataclass(frozen=True)
class _Log:
    """The channels of a log, or of a part of one, all of the same length."""

    main_pressure: np.ndarray
    converter_pressure: np.ndarray
    temperature: np.ndarray
    gear: np.ndarray

    @property
    def ends(self) -> _Log:
        """Return the lowest and highest of every channel but the gear."""

        def of(channel: np.ndarray) -> np.ndarray:
            return np.array([np.fmin.reduce(channel), np.fmax.reduce(channel)])

        return _Log(of(self.main_pressure), of(self.converter_pressure), of(self.temperature), self.gear)

    def sections(self, model: LeakageModel) -> np.ndarray:
        """Return the pressure of every section [Pa], shape (sections, samples): the ends of each for `ends`.

        Every relation is monotonous, so that the ends of p_g give those of p_s and p_m.
        """
        pressures = model.controller.section_pressures(self.main_pressure, self.converter_pressure)
        return np.array([pressures[section] for section in SECTIONS])

    def part(self, samples: Any) -> _Log:
        """Return some of the samples."""
        return _Log(
            self.main_pressure[samples], self.converter_pressure[samples], self.temperature[samples], self.gear[samples]
        )


def _compute_chunk(
    model: LeakageModel, sums: dict[int, _GearSum], log: _Log, series: LeakageSeries, part: slice, rows: np.ndarray
) -> None:
    """Fill one part of the series and add to its counts; ``rows`` is work space of shape (8, samples)."""
    total = series.total[part]
    sections = {name: flow[part] for name, flow in series.sections.items()}
    viscosity = model.dynamic_viscosity(log.temperature)
    powers, lines = rows[:5], rows[5:]  # μ q = p_g · lines[0] + p_k · lines[1] + lines[2]
    write_powers(log.temperature, powers)
    matrices: dict[int | None, tuple[_GearSum, np.ndarray | None]] = {}
    straight = None if sections else _straight_lines(model.controller, log)
    one_by_one = []
    for gear, samples in _by_gear(log.gear):
        if gear not in sums:
            lines[:, samples] = np.nan
            viscosity[samples] = 1.0  # left out for its gear, not for its temperature too
            if gear is not None:
                series.other_gear += log.gear[samples].size
            continue
        if gear not in matrices:
            gaps = sums[gear].at(log.temperature)
            matrices[gear] = gaps, _matrix(gaps, straight)
        gaps, matrix = matrices[gear]
        if matrix is None:
            one_by_one.append((gaps, samples))
            lines[:, samples] = 0.0
            continue
        if gaps.alone:
            one_by_one.append((replace(gaps, terms=()), samples))
        if isinstance(samples, slice):  # a view: nothing is copied
            np.matmul(matrix, powers[:, samples], out=lines[:, samples])
        else:
            lines[:, samples] = matrix @ powers[:, samples]
    lines[0] *= log.main_pressure
    lines[1] *= log.converter_pressure
    lines[0] += lines[1]
    lines[0] += lines[2]
    np.divide(lines[0], viscosity, out=total)
    for flow in sections.values():
        flow[:] = total
    for gaps, samples in one_by_one:
        flows, negative = _group_by_group(model, gaps, log.part(samples), viscosity[samples], powers[:, samples])
        whole: Any = sum(flows.values())
        missing = np.isnan(whole) if np.isnan(whole.sum()) else None
        total[samples] += whole
        for name, flow in sections.items():
            flow[samples] = flows[name] if missing is None else np.where(missing, np.nan, flows[name])
        for name, count in negative.items():
            series.reversed_samples[name] += count
    # μ is NaN outside the fluid's data, and only there or where there is no temperature: one sum shows whether
    if np.isnan(viscosity.sum()):
        series.outside_fluid += int(np.count_nonzero(np.isnan(viscosity) & np.isfinite(log.temperature)))


def _straight_lines(controller: Controller, log: _Log) -> tuple[np.ndarray, np.ndarray] | None:
    """Return every section pressure as a sum of p_g, p_k and 1, shape (sections, 3), and the ends of p_g, p_k and 1.

    The ends are the four corners of what these samples span, shape (3, 4). None where the limit of a valve begins among
    the samples.
    """
    main, converter = log.main_pressure, log.converter_pressure
    low, high = float(main.min()), float(main.max())
    lines = {"p_g": (1.0, 0.0, 0.0), "p_k": (0.0, 1.0, 0.0)}
    for section in ("p_s", "p_m"):
        line = controller.relations[section].line_between(low, high)
        if line is None:
            return None
        lines[section] = (line[0], 0.0, line[1])
    low_k, high_k = float(converter.min()), float(converter.max())
    corners = np.array([(low, low, high, high), (low_k, high_k, low_k, high_k), (1.0, 1.0, 1.0, 1.0)])
    return np.array([lines[section] for section in SECTIONS]), corners


def _matrix(gaps: _GearSum, straight: tuple[np.ndarray, np.ndarray] | None) -> np.ndarray | None:
    """Return M of ``μ q = (p_g, p_k, 1) · M · (1, τ, … τ⁴)``, shape (3, 5), from the straight lines of the pressures.

    None where there are none, and where a drop turns negative or a pressure is missing. Gaps that stand alone are not
    in it.
    """
    if straight is None or not gaps.groups:
        return None
    pressures, corners = straight
    drops = gaps.drops @ pressures  # of every group, as sums of p_g, p_k and 1
    if not (drops @ corners).min() >= 0.0:
        return None
    return drops.T @ gaps.polynomials


def _group_by_group(
    model: LeakageModel, gaps: _GearSum, log: _Log, viscosity: np.ndarray, powers: np.ndarray
) -> tuple[dict[str, np.ndarray], dict[str, int]]:
    """Compute the flow of every section, with the gaps that stand alone, and how many samples have a negative drop."""
    pressures = model.controller.section_pressures(log.main_pressure, log.converter_pressure)
    flows = {name: np.zeros(len(viscosity)) for name in SECTIONS}
    negative: dict[str, np.ndarray] = {}

    def above_zero(section: str, drop: np.ndarray) -> np.ndarray:
        if not np.min(drop) >= 0.0:  # negative somewhere, or not a number
            below = drop < 0.0
            negative[section] = negative[section] | below if section in negative else below
        return np.maximum(drop, 0.0)

    for (section, coefficients), flow in zip(gaps.groups, gaps.polynomials @ powers, strict=True):
        drop = sum(pressures[name] * coefficient for name, coefficient in coefficients)
        flow *= above_zero(section, drop)
        flow /= viscosity
        flows[section] += flow
    density = model.fluid.density(log.temperature, model.profile.viscosity) if gaps.alone else 1.0
    for single in gaps.alone:
        mean = single.effective_clearance(log.temperature)
        flows[single.gap.section] += model.law.flow(
            above_zero(single.gap.section, single.pressure_drop(pressures)),
            model.law.diameter(single.spool_diameter, mean),
            model.law.flow_clearance(mean, *single.form_moments),
            viscosity / density,
            density,
            single.contact_length,
        )
    return flows, {section: int(np.count_nonzero(below)) for section, below in negative.items()}


def _span(temperature: np.ndarray) -> tuple[float, float]:
    """Return the lowest and highest temperature that are numbers."""
    span = float(temperature.min()), float(temperature.max())
    if np.isnan(span[0]):
        finite = temperature[np.isfinite(temperature)]
        return _span(finite) if finite.size else (REFERENCE_TEMPERATURE,) * 2
    return span


def _by_gear(gear: np.ndarray) -> Iterator[tuple[int | None, Any]]:
    """Yield (gear, samples): a slice for each run of one gear or, where they are many, a mask for each gear."""
    starts = np.flatnonzero(gear[1:] != gear[:-1]) + 1
    if len(starts) <= _RUNS:
        bounds = [0, *starts.tolist(), len(gear)]
        for start, stop in pairwise(bounds):
            yield _gear_number(gear[start]), slice(start, stop)
        return
    for number in np.unique(gear):  # several NaN are one
        yield _gear_number(number), np.isnan(gear) if np.isnan(number) else gear == number


def _gear_number(value: float) -> int | None:
    """Return the gear as the controller names it: −1 where it has none such, None where the gear is not known."""
    return None if np.isnan(value) else int(value) if value.is_integer() else -1
