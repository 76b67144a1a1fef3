"""Describe what fluid is forced through between two pressures: gaps, leaks and feed orifices."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from atleak.catalogue.circuits import Pressure
from atleak.equations import gap as gap_equations
from atleak.equations import orifice as orifice_equations


class Restriction(Protocol):
    """Something that fluid is forced through: its flow rises with the pressure drop and is odd in it."""

    def flow(self, drop: Any) -> Any:
        """Return the flow [m³/s] at a pressure drop [Pa]."""


@dataclass(frozen=True)
class GapBranch:
    """An annular gap, or another laminar leak: `restricted_flow`."""

    conductance: Any  # [m³/(s Pa)]
    bend: Any = 0.0  # [1/Pa] of the entry loss

    def flow(self, drop: Any) -> Any:
        return gap_equations.restricted_flow(drop, self.conductance, self.bend)

    def flow_and_slope(self, drop: Any, out: Any = None) -> tuple[Any, Any]:
        """Return the flow, and how steeply it rises [m³/(s Pa)], written into a pair of arrays if given."""
        return gap_equations.restricted_flow_and_slope(drop, self.conductance, self.bend, out)


@dataclass(frozen=True)
class Orifice:
    """A feed, or a leak through a hole: `orifice_flow`."""

    coefficient: Any  # [m³/(s √Pa)]
    transition: Any  # [Pa]

    def flow(self, drop: Any) -> Any:
        return orifice_equations.orifice_flow(drop, self.coefficient, self.transition)

    def flow_and_slope(self, drop: Any) -> tuple[Any, Any]:
        """Return the flow, and how steeply it rises [m³/(s Pa)]."""
        return orifice_equations.orifice_flow_and_slope(drop, self.coefficient, self.transition)


AnyRestriction = TypeVar("AnyRestriction", bound=Restriction, covariant=True)
OtherRestriction = TypeVar("OtherRestriction", bound=Restriction)


@dataclass(frozen=True)
class Branch(Generic[AnyRestriction]):
    """A restriction between two pressures."""

    high: Pressure
    low: Pressure
    restriction: AnyRestriction
    into: str | None  # the section or circuit that the flow ends in; None: the sump
    counts: bool  # as drawn from the pump

    @property
    def into_sump(self) -> bool:
        """Return whether the flow ends in the sump."""
        return self.into is None

    def with_restriction(self, restriction: OtherRestriction) -> Branch[OtherRestriction]:
        """Return another restriction between the same pressures."""
        return Branch(self.high, self.low, restriction, self.into, self.counts)  # 5 times as fast as replace()

    def drop(self, pressures: Mapping[str, Any]) -> Any:
        """Return the pressure drop [Pa], with its sign."""
        return self.high.at(pressures) - self.low.at(pressures)


def leaks_both_ways(ends: Any, solved: frozenset[str]) -> bool:
    """Return whether a gap, or a branch, leaks backwards too: between two sections, one at least a solved circuit.

    A drain leaks nothing back, nor does what ends in the sump or is a share of a pressure.
    """
    between_sections = ends.high.is_section and ends.low.is_section and not ends.into_sump
    return between_sections and bool({ends.high.section, ends.low.section} & solved)
