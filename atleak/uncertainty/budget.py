"""Lay the uncertainty of one land's clearance out as a budget: a row per source, as the GUM has them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from atleak.equations.uncertainty import rectangular
from atleak.uncertainty.sources import MEASURING_TEMPERATURE, MOUNTING, OF_A_DIAMETER, LandSources, UncertaintySource

MOST_BUDGETS = 12  # lands of a unit whose budget a report shows in full, the worst first
InputKind = Literal["diameter", "temperature", "clearance"]


@dataclass(frozen=True)
class BudgetLine:
    """One source in the budget of a radial clearance c_r = (D − d)/2.

    ``input_uncertainty`` is the standard uncertainty u(x) of what the source is about [m, or K of a temperature],
    ``sensitivity`` the change of c_r with it [1, or m/K], ``contribution`` their product [m], which keeps its sign.
    An error of both parts is one line: what it does to D and to d is added before. ``degrees_of_freedom`` are those
    behind a spread that this unit's repeats show; infinite where the source is no sample of readings, but a
    certificate, a step or an assumption.
    """

    source: UncertaintySource
    input_kind: InputKind
    input_uncertainty: float
    degrees_of_freedom: float
    sensitivity: float
    contribution: float
    fraction: float  # of the variance of c_r

    @property
    def statistical(self) -> bool:
        """Return whether it was evaluated from repeated readings (type A), not otherwise (type B)."""
        return math.isfinite(self.degrees_of_freedom)


def budget_lines(land: LandSources) -> tuple[BudgetLine, ...]:
    """Return the budget of a land's clearance, the largest contribution first; without what is taken as exact.

    Notes
    -----
    The spread of few repeats is widened beforehand by √(ν/(ν − 2)), the standard deviation of Student's t with ν
    degrees of freedom, so the combined uncertainty takes the factors of a normal distribution.

    References
    ----------
    JCGM 100:2008, 5.1 and H.1; JCGM 101:2008, 6.4.9.
    """
    return tuple(line for line in every_line(land) if line.input_uncertainty > 0.0)


def every_line(land: LandSources) -> tuple[BudgetLine, ...]:
    """Return the same with what is taken as exact: what may become uncertain where a number is changed."""
    return tuple(_line(land, source, fraction) for source, fraction in land.budget)


def effective_degrees(lines: Sequence[BudgetLine]) -> float:
    """Return the effective degrees of freedom of the combined uncertainty; infinite where nothing rests on repeats.

    They say how much of it repeats carry. No factor is taken from them: the spread of few repeats is widened already.

    References
    ----------
    JCGM 100:2008, G.4.1 (Welch-Satterthwaite).
    """
    over = math.fsum(line.contribution**4 / line.degrees_of_freedom for line in lines)
    return combined(lines) ** 4 / over if over > 0.0 else math.inf


def combined(lines: Sequence[BudgetLine]) -> float:
    """Return the combined standard uncertainty of a budget [m]: its lines are independent of one another."""
    return math.sqrt(math.fsum(line.contribution**2 for line in lines))


def _line(land: LandSources, source: UncertaintySource, fraction: float) -> BudgetLine:
    kind = _input_kind(source)
    u = _input_uncertainty(land, source, kind)
    return BudgetLine(
        source=source,
        input_kind=kind,
        input_uncertainty=u,
        degrees_of_freedom=_degrees_of_freedom(land, source),
        sensitivity=source.standard_uncertainty / u if u > 0.0 else 0.0,
        contribution=source.standard_uncertainty,
        fraction=fraction,
    )


def _input_kind(source: UncertaintySource) -> InputKind:
    if source.kind == MEASURING_TEMPERATURE:
        return "temperature"
    return "clearance" if source.kind == MOUNTING else "diameter"


def _input_uncertainty(land: LandSources, source: UncertaintySource, kind: InputKind) -> float:
    """Return u(x) of a source: of the temperature, or of the diameter, of which the clearance takes half."""
    if kind == "temperature":
        return rectangular(land.assumptions.room_temperature)
    members = [each for each in land.sources if source.group is not None and each.group == source.group] or [source]
    u = max(abs(each.standard_uncertainty) for each in members)
    return u if kind == "clearance" else u / OF_A_DIAMETER


def _degrees_of_freedom(land: LandSources, source: UncertaintySource) -> float:
    spread = land.spreads.get(source.part) if source.kind == "repeats" and source.part is not None else None
    if spread is None or spread.origin != "repeats":
        return math.inf
    return float(spread.degrees_of_freedom)
