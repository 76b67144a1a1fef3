"""Say which representative values a verdict rests on: one that rests on any is provisional.

A representative value is one of such units in general, neither measured on this type nor published for it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from enum import StrEnum

from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.entries import Evidence
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.known_values import known_values
from atleak.catalogue.limits import RuleKind
from atleak.diagnosis.rules import Rule
from atleak.measurements.clearances import LandClearance


class AssumedBasis(StrEnum):
    """What a verdict can rest on besides the readings."""

    MOUNTING_CLEARANCE = "mounting_clearance"
    CONTACT_LENGTH = "contact_length"
    NOMINAL_DIAMETER = "nominal_diameter"
    MATERIALS = "materials"
    GAPS = "gaps"  # which land leaks from where to where
    OPERATING_POINT = "operating_point"
    SECTIONS = "sections"  # how p_s and p_m follow main pressure
    LINE = "line"  # what main pressure is set to
    CIRCUITS = "circuits"  # gears, feeds, set pressures
    LEAKS = "leaks"  # beside the lands
    PUMP = "pump"
    CONSUMERS = "consumers"
    PERMISSIBLE_PRESSURE = "permissible_pressure"
    FLUID = "fluid"


_FLOW = {
    AssumedBasis.CONTACT_LENGTH,
    AssumedBasis.NOMINAL_DIAMETER,
    AssumedBasis.MATERIALS,
    AssumedBasis.GAPS,
    AssumedBasis.OPERATING_POINT,
    AssumedBasis.SECTIONS,
    AssumedBasis.LINE,
    AssumedBasis.CIRCUITS,
    AssumedBasis.FLUID,
}
_SHARE = {*_FLOW, AssumedBasis.PUMP}
_HELD = {*_SHARE, AssumedBasis.MOUNTING_CLEARANCE, AssumedBasis.LEAKS, AssumedBasis.CONSUMERS}
_RESTS_ON: dict[RuleKind, set[AssumedBasis]] = {
    RuleKind.WEAR: {AssumedBasis.MOUNTING_CLEARANCE, AssumedBasis.NOMINAL_DIAMETER},
    RuleKind.CLEARANCE: {AssumedBasis.NOMINAL_DIAMETER},
    RuleKind.PAIR_SHARE: {*_SHARE, AssumedBasis.MOUNTING_CLEARANCE},  # it is judged by its growth over new, too
    RuleKind.TOTAL_SHARE: {*_SHARE, AssumedBasis.MOUNTING_CLEARANCE},
    RuleKind.RESERVE: _HELD,
    RuleKind.CIRCUIT_LOSS: _HELD,
    RuleKind.BELOW_EXPECTED: _HELD,
    RuleKind.PERMISSIBLE_PRESSURE: {*_HELD, AssumedBasis.PERMISSIBLE_PRESSURE},
}  # the others are measured on both sides
_OF_LANDS = {
    AssumedBasis.MOUNTING_CLEARANCE: "mounting_clearance_um",
    AssumedBasis.CONTACT_LENGTH: "contact_length_mm",
    AssumedBasis.NOMINAL_DIAMETER: "nominal_diameter_mm",
}
_HARDLY_MATTERS = ("density_g_cm3", "density_slope_g_cm3_k")  # by which fluids differ by some percent
_TABLES = {"pressures": AssumedBasis.SECTIONS}  # of a file whose name is not that of what rests on them


class Representative:
    """The representative values of a unit: of its valve body, its fluid and the lands that nobody measured.

    Parameters
    ----------
    states
        what was measured of every land: of one measured on both parts the nominal diameter counts for nothing, and a
        sleeve that was not is taken as wide as the mounting clearance makes it.
    uses_slip
        whether the pump's flow is computed with its slip, else with its volumetric efficiency.
    """

    def __init__(
        self, controller: Controller, fluid: Fluid, states: Iterable[LandClearance], *, uses_slip: bool
    ) -> None:
        states = tuple(states)
        status = {state.land.key: state.status for state in states}
        self._measured = {key for key, each in status.items() if each == "measured"}
        self._by_leak = {state.land.key for state in states if state.leak is not None}
        self._without_sleeve = {key for key, each in status.items() if each == "spool_only"}
        self._fluid = any(value not in _HARDLY_MATTERS for value in fluid.representative)
        entry, of_pump = controller.entry, _of_pump(controller, uses_slip)
        values = [each for each in known_values(entry) if each.evidence is Evidence.REPRESENTATIVE] if entry else []
        self._tables = {
            _TABLES.get(each.table, each.table) for each in values if each.table != "pump" or each.value in of_pump
        }
        self._pump_limits = any(each[:2] == ("pump", "limits") for each in values)
        points = entry.operating_points if entry else ()
        self._points = {point.name for point in points if point.evidence is Evidence.REPRESENTATIVE}

    def bases(self, rules: Iterable[tuple[Rule, Iterable[Land]]]) -> tuple[AssumedBasis, ...]:
        """Return which of them some rules rest on, each once; a rule comes with the lands that take part in it."""
        assumed = {basis for rule, lands in rules for basis in self._of_rule(rule, tuple(lands))}
        return tuple(basis for basis in AssumedBasis if basis in assumed)

    def _of_rule(self, rule: Rule, lands: Sequence[Land]) -> Iterator[AssumedBasis]:
        if rule.condition is None and rule.kind is RuleKind.PERMISSIBLE_PRESSURE:  # gauges or a log measured it
            rests_on = {AssumedBasis.PERMISSIBLE_PRESSURE}
        else:
            rests_on = _RESTS_ON.get(rule.kind, set())
        if rule.kind is RuleKind.CLEARANCE and any(land.key in self._without_sleeve for land in lands):
            rests_on = {*rests_on, AssumedBasis.MOUNTING_CLEARANCE}
        if rule.kind in (RuleKind.WEAR, RuleKind.CLEARANCE) and any(land.key in self._by_leak for land in lands):
            rests_on = {*rests_on, AssumedBasis.CONTACT_LENGTH}
        if rule.kind in (RuleKind.PUMP_SIDE, RuleKind.PUMP_TIP) and self._pump_limits:
            yield AssumedBasis.PUMP
        for basis in rests_on:
            if basis in _OF_LANDS:
                rests = any(self._of_land(basis, land) for land in lands)
            elif basis is AssumedBasis.FLUID:
                rests = self._fluid
            elif basis is AssumedBasis.OPERATING_POINT:  # gauges: at several
                rests = bool(self._points) if rule.condition is None else rule.condition.like in self._points
            else:
                rests = basis in self._tables
            if rests:
                yield basis

    def _of_land(self, basis: AssumedBasis, land: Land) -> bool:
        measured = basis is AssumedBasis.NOMINAL_DIAMETER and land.key in self._measured
        return not measured and _OF_LANDS[basis] in land.representative


def _of_pump(controller: Controller, uses_slip: bool) -> set[str]:
    """Return which values of the pump, as `known_values` names them, its flow is computed with."""
    if not uses_slip:
        return {"displacement", "volumetric_efficiency"}
    stated = controller.entry is not None and controller.entry.pump.slip_coefficient is not None
    by_gaps = not stated or controller.pump.counted.any_known  # else a stated coefficient goes before them
    return {"displacement", *(["slip_coefficient"] if stated else []), *(["gaps"] if by_gaps else [])}
