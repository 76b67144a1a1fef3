"""Describe a controller: pairs and lands, gaps between pressures, pump, pressure relations, operating points.

These are frozen objects in SI units; `controller_file` makes them from a TOML file.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from atleak.catalogue.circuits import (
    Circuit,
    Consumer,
    Leak,
    PermissiblePressure,
    Pressure,
    PressureRelation,
    SetPressure,
)
from atleak.catalogue.controller_tables import (
    PART_NAMES,
    SEALS,
    ControllerFile,
    NewOrigin,
    PartKind,
    Seal,
    SelectorRange,
    StandingState,
    State,
)
from atleak.catalogue.entries import Evidence, Headed, Origin
from atleak.catalogue.fluid import DEFAULT_FLUID, RequiredFluid
from atleak.catalogue.instruments import Part
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.pump import Pump, PumpClearances
from atleak.catalogue.repairs import Complaint, LandKey, Repair
from atleak.common.errors import InputError, Message, unknown
from atleak.common.printable import brief
from atleak.common.sentences import Name, Sentence
from atleak.equations import clearance as clearance_equations

REFERENCE_TEMPERATURE = 20.0  # °C, at which clearances are measured


@dataclass(frozen=True)
class Land:
    """One cylindrical section of a spool or piston in its sleeve."""

    component: str  # its number
    land: int  # counted from 1 along the spool
    planes: tuple[str, ...]  # in which it is measured
    part: PartKind  # what moves in the bore, or closes it
    nominal_diameter: float  # [m] of the spool or piston
    contact_length: float  # [m]
    mounting_clearance: float | tuple[float, float]  # [m] radial: a number, or the range in which new pairs lie
    body_material: str  # of the sleeve
    spool_material: str  # of the spool
    body_expansion: float  # [1/K]
    spool_expansion: float  # [1/K]
    clearance_limit: float | None  # [m] radial, the workshop's own
    representative: tuple[str, ...]  # which of its values are representative
    mounting_tolerance: float | None = None  # [m] half width that holds 95 % of the type's pairs; None: a pair's own
    new_origin: NewOrigin = NewOrigin.PAIR  # what the mounting clearance is known from
    learned_from_units: int | None = None  # of whose measuring sheets the mounting clearance was made
    position: float | None = None  # [m] of its near edge from the end of the spool that the drawing shows left
    seal: Seal | None = None  # the ring on it, which alone it leaks past
    sleeved: bool = False  # whether its bore was sleeved
    contact_length_measured: bool = False  # on this very unit; else as the file states it
    fitted: str | None = None  # id of the repair that this unit was given earlier
    mounting_measured: bool = False  # whether the mounting clearance is: of this pair when new, or of its type

    @property
    def key(self) -> tuple[str, int]:
        """Return component and land."""
        return self.component, self.land

    @property
    def mounting_range(self) -> tuple[float, float]:
        """Return the ends of the mounting clearance [m]: twice the same number where it is one."""
        new = self.mounting_clearance
        return new if isinstance(new, tuple) else (new, new)

    @property
    def mounting_ends(self) -> tuple[float, ...]:
        """Return the mounting clearance as it is shown [m]: one number, or the two ends of its range."""
        return tuple(dict.fromkeys(self.mounting_range))

    @property
    def mounting_high(self) -> float:
        """Return the upper end of the mounting clearance [m], over which a pair is surely worn."""
        return self.mounting_range[1]

    @property
    def new_clearance(self) -> float:
        """Return the clearance that leaks as much as new pairs do on average [m].

        This is the mounting clearance, or the cube root of the mean cube over its range. Lands that are new, repaired
        or not measured are computed with it.
        """
        low, high = self.mounting_range
        return low if low == high else float(clearance_equations.cube_mean(low, high))

    @property
    def widest_new(self) -> float:
        """Return the widest that a new pair commonly is [m]: the upper end of a range, a type's value and tolerance."""
        return self.mounting_high + (self.mounting_tolerance or 0.0)

    def unworn(self, clearance: Any) -> Any:
        """Return the clearance that a pair with that reading may have had when new [m], arrays too.

        A reading within what new pairs have is no wear, so it is taken as it is; a wider one is taken as worn from the
        widest new pair.

        Parameters
        ----------
        clearance
            measured radial clearance [m], a number or an array.

        Returns
        -------
        float or numpy.ndarray
            the same, but at least `new_clearance` and at most `widest_new` [m].
        """
        new, widest = self.new_clearance, self.widest_new
        if isinstance(clearance, float):
            return min(max(clearance, new), widest)
        return np.clip(clearance, new, widest)

    @property
    def part_name(self) -> Sentence:
        """Name the part that moves in the bore, or closes it."""
        return PART_NAMES[self.part]

    @property
    def built(self) -> tuple[str, ...]:
        """Say what is there that a plain spool in its bore has not."""
        parts = (
            self.part_name if self.part == "end_plug" else "",
            "bore sleeved" if self.sleeved else "",
            f"sealed by {SEALS[self.seal]}: its clearance leaks nothing and is not judged" if self.seal else "",
        )
        return tuple(filter(None, parts))

    def with_repair(self, repair: Repair) -> Land:
        """Return the land as a repair leaves it: with the nominal diameter and mounting clearance that this states.

        One that is only cleaned is the same pair.

        Parameters
        ----------
        repair
            one that changes this land: see `Repair.changes`.

        Returns
        -------
        Land
            with ``fitted``; what the repair states without evidence counts as representative.
        """
        if repair.keeps_clearance:
            return self
        diameter, new = repair.nominal_diameter, repair.mounting_clearance
        stated = {"nominal_diameter_mm": diameter, "mounting_clearance_um": new}
        changed = {name for name, value in stated.items() if value is not None}
        kept = [name for name in self.representative if name not in changed]
        kept += sorted(changed) if repair.evidence is Evidence.REPRESENTATIVE else []
        land = replace(self, fitted=repair.id, representative=tuple(kept))
        if diameter is not None:
            land = replace(land, nominal_diameter=diameter)
        if new is None:
            return land
        single = NewOrigin.PAIR if repair.mounting_tolerance is None else NewOrigin.TYPE
        origin = NewOrigin.RANGE if isinstance(new, tuple) else single
        return replace(
            land,
            mounting_clearance=new,
            mounting_tolerance=repair.mounting_tolerance,
            new_origin=origin,
            mounting_measured=repair.evidence is Evidence.MEASURED and origin is not NewOrigin.RANGE,
        )

    @property
    def nominal_sleeve_diameter(self) -> float:
        """Return the nominal spool diameter plus twice the clearance of a new pair [m]."""
        return self.nominal_diameter + 2.0 * self.new_clearance

    def nominal_of(self, part: Part) -> float:
        """Return the nominal diameter of the spool or of the sleeve [m]."""
        return self.nominal_diameter if part == "spool" else self.nominal_sleeve_diameter

    def expansion_of(self, part: Part) -> float:
        """Return the coefficient of expansion of the spool or of the body round it [1/K]."""
        return self.spool_expansion if part == "spool" else self.body_expansion

    def thermal_rate(self, spool_diameter: float, sleeve_diameter: float) -> float:
        """Return how fast the radial clearance grows with temperature [m/K]: eq. (2), body and spool equally warm.

        Parameters
        ----------
        spool_diameter, sleeve_diameter
            cold, as measured or nominal [m].

        Returns
        -------
        float
            [m/K]; negative where the spool grows faster than its bore.
        """
        return clearance_equations.thermal_rate(
            sleeve_diameter, spool_diameter, self.body_expansion, self.spool_expansion
        )


@dataclass(frozen=True)
class Gap:
    """A land seen as a leak path from one pressure to another in given gears."""

    component: str  # its number
    land: int  # counted from 1 along the spool
    section: str  # or circuit, whose fluid it loses
    high: Pressure  # pressure before it
    low: Pressure  # pressure behind it
    gears: frozenset[int]  # in which it sees a pressure drop
    into_sump: bool  # ends in the sump, not in another section
    evidence: Evidence | None  # who says where it leaks; None where nobody does

    @property
    def key(self) -> tuple[str, int]:
        """Return component and land."""
        return self.component, self.land

    @property
    def published(self) -> bool:
        """Return whether a publication says where it leaks."""
        return self.evidence is Evidence.PUBLISHED


@brief
@dataclass(frozen=True)
class Controller(Headed):
    """A type of valve body: its lands, the gaps that they seal, circuits, pump and operating points.

    Attributes
    ----------
    representative
        what of it is representative, "" where nothing is.
    gears
        those that the gearbox has.
    components
        name of each component, by its number.
    lands
        in the file's order.
    gaps
        the leak paths of the lands.
    relations
        p_s and p_m as they follow from p_g.
    pump
        its displacement and slip.
    operating_points
        conditions at which a unit is judged.
    complaints
        what customers complain of, with the conditions and lands where it may show.
    origin
        the file.
    circuits
        sections whose pressure follows from their feeds and leaks.
    leaks
        those beside the lands, such as sealing rings.
    consumers
        what takes flow from the pump and is no leak.
    line
        what main pressure is set to, where it is not simply that of the operating point.
    line_source
        who states that.
    permissible
        low and high of main pressure, by gear or range and state.
    repairs
        those that the file names.
    gaps_not_described
        lands taken to leak from main pressure to the sump, as the file says nothing: an upper bound.
    fluid
        that its maker requires.
    entry
        the tables that it was read from.
    doubts
        values that are possible and unusual.
    """

    representative: str
    gears: tuple[int, ...]
    components: MappingProxyType[str, str]
    lands: tuple[Land, ...]
    gaps: tuple[Gap, ...]
    relations: MappingProxyType[str, PressureRelation]
    pump: Pump
    operating_points: tuple[OperatingPoint, ...]
    complaints: tuple[Complaint, ...]
    origin: Origin
    circuits: tuple[Circuit, ...] = ()
    leaks: tuple[Leak, ...] = ()
    consumers: tuple[Consumer, ...] = ()
    line: SetPressure | None = None
    line_source: str = ""
    permissible: tuple[PermissiblePressure, ...] = ()
    repairs: tuple[Repair, ...] = ()
    gaps_not_described: frozenset[LandKey] = frozenset()
    fluid: RequiredFluid | None = None
    entry: ControllerFile | None = field(default=None, repr=False, compare=False)
    doubts: tuple[Message, ...] = field(default=(), repr=False, compare=False)

    @property
    def usual_fluid(self) -> str:
        """Return the id of the fluid that is taken unless another is chosen."""
        return DEFAULT_FLUID if self.fluid is None else self.fluid.entry

    @property
    def sha256(self) -> str:
        """Return the SHA-256 of the file."""
        return self.origin.sha256

    @cached_property
    def _by_key(self) -> dict[tuple[str, int], Land]:
        return {land.key: land for land in self.lands}

    @cached_property
    def _by_plane(self) -> dict[tuple[str, str], Land]:
        return {(land.component, plane): land for land in self.lands for plane in land.planes}

    def land(self, component: str, land: int) -> Land:
        """Return the land of a component.

        Parameters
        ----------
        component
            its number, as ``"26"``.
        land
            counted from 1 along the spool.

        Raises
        ------
        KeyError
            if the controller has no such land.
        """
        return self._by_key[component, land]

    def land_of_plane(self, component: str, plane: str) -> Land | None:
        """Return the land that is measured in a plane; None where there is none.

        Parameters
        ----------
        component
            its number.
        plane
            the plane's letter or number, as measuring sheets give it.
        """
        return self._by_plane.get((component, plane))

    def lands_of(self, component: str) -> tuple[Land, ...]:
        """Return the lands of a component, along the spool.

        Parameters
        ----------
        component
            its number.
        """
        return tuple(land for land in self.lands if land.component == component)

    def lands_around(self, circuit: str) -> tuple[Land, ...]:
        """Return the lands that part a circuit from anything else: those past which air comes in where it is plugged.

        Parameters
        ----------
        circuit
            its id.
        """
        keys = {gap.key for gap in self.gaps if circuit in (gap.section, gap.high.section, gap.low.section)}
        return tuple(land for land in self.lands if land.key in keys)

    def repairs_of(self, component: str) -> tuple[Repair, ...]:
        """Return the repairs that the file names for a component.

        Parameters
        ----------
        component
            its number.
        """
        return tuple(repair for repair in self.repairs if component in repair.components)

    def complaint(self, wanted: str | None) -> Complaint | None:
        """Return a complaint that the file maps; None where none is wanted.

        Parameters
        ----------
        wanted
            its id; None where none is wanted.

        Raises
        ------
        InputError
            if the controller maps no such complaint; it lists those that it maps, or says that it maps none.
        """
        known = {complaint.id: complaint for complaint in self.complaints}
        if wanted is None or wanted in known:
            return known[wanted] if wanted else None
        if not known:
            expected = Sentence("no complaint, or a controller's file with a table [[complaints]]")
            problem = Sentence("{controller} maps no complaint to its operating points", controller=Name(self.name))
            raise InputError(problem, value=wanted, expected=expected)
        raise unknown(Sentence("{controller} maps no such complaint", controller=Name(self.name)), wanted, known)

    def with_measured_pump(self, measured: PumpClearances) -> Controller:
        """Return the same controller with the pump of a job.

        Parameters
        ----------
        measured
            clearances that were measured of that pump.
        """
        pump = self.pump.with_measured(measured)
        return self if pump is self.pump else replace(self, pump=pump)

    @property
    def with_new_pump(self) -> Controller:
        """Return the same controller with its pump as it was when new."""
        return self if self.pump.new is self.pump else replace(self, pump=self.pump.new)

    def gaps_in(self, gear: int) -> tuple[Gap, ...]:
        """Return the gaps that see a pressure drop in a gear.

        Parameters
        ----------
        gear
            the gear engaged.
        """
        return tuple(gap for gap in self.gaps if gear in gap.gears)

    @cached_property
    def permissible_in_gear(self) -> tuple[PermissiblePressure, ...]:
        """Return the permissible pressures that hold at operating points and over logs."""
        return tuple(each for each in self.permissible if each.gears and each.state != "fast_idle")

    def permissible_at(self, gear: int, state: State) -> PermissiblePressure | None:
        """Return between which pressures main pressure must lie; None where the file is silent.

        Parameters
        ----------
        gear
            the gear engaged.
        state
            idle, stall or driving.
        """
        return next((each for each in self.permissible if gear in each.gears and each.state == state), None)

    def permissible_in(
        self, selected: SelectorRange, gear: int | None, state: StandingState
    ) -> PermissiblePressure | None:
        """Return the same for a range of the selector lever; None where the file is silent.

        Parameters
        ----------
        selected
            the range.
        gear
            the gear that the range engages, which counts where the file does not name the range; None where unknown.
        state
            what the engine of the standing vehicle does.
        """
        of_state = [each for each in self.permissible if each.state == state]
        of_range = (each for each in of_state if selected in each.ranges)
        return next(of_range, None) or next((each for each in of_state if gear in each.gears), None)

    def with_line(self, point: OperatingPoint) -> OperatingPoint:
        """Set an operating point's main pressure to that of the line, where the file says what the line is set to.

        Parameters
        ----------
        point
            the operating point.

        Returns
        -------
        OperatingPoint
            where the line follows a circuit, with what it is set to while that circuit holds its own set pressure.
        """
        required = None if self.line is None else self._unleaked(self.line, point)
        return point if required is None else replace(point, main_pressure=required)

    def _unleaked(self, stated: SetPressure, point: OperatingPoint) -> float | None:
        """Return a set pressure [Pa] with no circuit leaking; None where one that it follows has no set pressure."""
        if stated.following is None:
            return stated.at(point)
        followed = next((each for each in self.circuits if each.id == stated.following.section), None)
        if followed is None or followed.set_pressure is None:
            return None
        pressure = self._unleaked(followed.set_pressure, point) if point.gear in followed.gears else 0.0
        known = None if pressure is None else {followed.id: pressure}
        return None if known is None else float(stated.with_pressures(point, known))

    def section_pressures(self, main_pressure: Any, converter_pressure: Any) -> dict[str, Any]:
        """Compute all four section pressures from the two that are measured.

        Parameters
        ----------
        main_pressure
            p_g [Pa], a number or an array.
        converter_pressure
            p_k [Pa], likewise.

        Returns
        -------
        dict
            ``p_g``, ``p_s``, ``p_m`` and ``p_k`` [Pa]; of arrays in their shape.
        """
        return {
            "p_g": main_pressure,
            "p_s": self.relations["p_s"](main_pressure),
            "p_m": self.relations["p_m"](main_pressure),
            "p_k": converter_pressure,
        }

    def above_main(self, main_pressure: Any) -> dict[str, Any]:
        """Tell where p_s or p_m would be above main pressure, which feeds both: there the relation does not hold.

        Parameters
        ----------
        main_pressure
            p_g [Pa], a number or an array.

        Returns
        -------
        dict
            of ``p_s`` and ``p_m``: true where the relation does not hold, in the shape of ``main_pressure``.
        """
        pressures = self.section_pressures(main_pressure, 0.0)
        return {section: pressures[section] > np.maximum(main_pressure, 0.0) for section in ("p_s", "p_m")}
