"""Describe a controller: pairs and lands, gaps between pressures, pump, pressure relations, operating points.

A controller is described in a TOML file (see ``docs/describing-a-controller.md``); this module checks one and turns
it into frozen objects in SI units.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

import numpy as np

from atleak.catalogue.circuit_tables import SelectorRange, StandingState, State
from atleak.catalogue.circuits import (
    IDLE_SPEED,
    Circuit,
    Consumer,
    Leak,
    PermissiblePressure,
    Reading,
    SetPressure,
    StandingPressure,
    circuit_ids,
    permissible_in_gear,
    read_circuits,
    read_consumers,
    read_leaks,
    read_line,
    read_standing,
)
from atleak.catalogue.complaints import Complaint, complaints_of, find_complaint
from atleak.catalogue.controller_tables import (
    ComponentTable,
    ControllerFile,
    LandTable,
    NewOrigin,
    PumpGears,
    PumpTable,
)
from atleak.catalogue.entries import Origin, catalogue_error, listed, read_entry
from atleak.catalogue.instruments import Part
from atleak.catalogue.section_pressures import SECTIONS, Pressure, PressureRelation, read_relation
from atleak.equations import clearance as clearance_equations
from atleak.equations import pump as pump_equations
from atleak.errors import CatalogueError, Place, unknown

HOT_IDLE = "hot_idle"
STATED = "stated"  # name of the condition that a job states: no point of a file has it
REFERENCE_TEMPERATURE = 20.0  # °C, at which clearances are measured


@dataclass(frozen=True)
class Land:
    """One cylindrical section of a spool or piston in its sleeve.

    The mounting clearance, radial and in m, is a number or the range (low, high) in which new pairs lie. Its tolerance
    is the half width that holds 95 % of the pairs of the unit's type; without one a number is this pair's own.
    """

    component: str
    land: int
    planes: tuple[str, ...]
    part: Literal["spool", "piston"]
    nominal_diameter: float  # [m] of the spool or piston
    contact_length: float  # [m]
    mounting_clearance: float | tuple[float, float]
    body_material: str
    spool_material: str
    body_expansion: float  # [1/K]
    spool_expansion: float  # [1/K]
    clearance_limit: float | None  # [m] radial, the workshop's own
    representative: tuple[str, ...]  # which of its values are representative
    mounting_tolerance: float | None = None
    new_origin: NewOrigin = NewOrigin.PAIR

    @property
    def key(self) -> tuple[str, int]:
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
        """
        return np.clip(clearance, self.new_clearance, self.widest_new)

    @property
    def nominal_sleeve_diameter(self) -> float:
        """Return the nominal spool diameter plus twice the clearance of a new pair [m]."""
        return self.nominal_diameter + 2.0 * self.new_clearance

    def expansion_of(self, part: Part) -> float:
        """Return the coefficient of expansion of the spool or of the body round it [1/K]."""
        return self.spool_expansion if part == "spool" else self.body_expansion

    def thermal_rate(self, spool_diameter: float, sleeve_diameter: float) -> float:
        """Return how fast the radial clearance grows with temperature [m/K]: eq. (2), body and spool equally warm."""
        return clearance_equations.thermal_rate(
            sleeve_diameter, spool_diameter, self.body_expansion, self.spool_expansion
        )


@dataclass(frozen=True)
class Gap:
    """A land seen as a leak path from one pressure to another in given gears."""

    component: str
    land: int
    section: str
    high: Pressure
    low: Pressure
    gears: frozenset[int]
    into_sump: bool  # ends in the sump, not in another section
    published: bool

    @property
    def key(self) -> tuple[str, int]:
        return self.component, self.land


@dataclass(frozen=True)
class Pump:
    """The fixed-displacement pump on the engine's shaft."""

    displacement: float  # [m³/rev]
    volumetric_efficiency: float
    slip_coefficient: float | None  # Wilson's C_s, None where the controller states none
    representative: tuple[str, ...]


@dataclass(frozen=True)
class OperatingPoint:
    """A stated condition at which leakage and pump are compared."""

    name: str
    label: str
    temperature: float  # [°C]
    engine_speed: float  # [1/s]
    gear: int
    main_pressure: float  # [Pa]
    converter_pressure: float  # [Pa]
    source: str
    stated_state: State | None = None  # where the file says it
    solenoid_current: float | None = None  # [A]
    values_of: str = ""  # name of the file's point whose set pressures and flows hold here; "" for its own

    @property
    def state(self) -> State:
        """Return whether the engine idles, the converter stalls or the vehicle drives; by speed unless stated."""
        return self.stated_state or ("idle" if self.engine_speed < IDLE_SPEED else "driving")

    @property
    def like(self) -> str:
        """Return the name of the point of the controller's file whose set pressures and flows hold here."""
        return self.values_of or self.name


@dataclass(frozen=True)
class Controller:
    """A transmission's electro-hydraulic controller."""

    id: str
    name: str
    source: str
    date: str
    note: str
    representative: str  # what of it is representative, "" where nothing is
    gears: tuple[int, ...]
    components: MappingProxyType[str, str]  # number → name
    lands: tuple[Land, ...]
    gaps: tuple[Gap, ...]
    relations: MappingProxyType[str, PressureRelation]  # of p_s and p_m; p_g and p_k are measured
    pump: Pump
    operating_points: tuple[OperatingPoint, ...]
    complaints: tuple[Complaint, ...]
    origin: Origin
    circuits: tuple[Circuit, ...] = ()
    leaks: tuple[Leak, ...] = ()
    consumers: tuple[Consumer, ...] = ()
    line: SetPressure | None = None  # of main pressure, where it is not simply that of the operating point
    line_source: str = ""
    permissible: tuple[PermissiblePressure, ...] = ()  # of main pressure
    standing: tuple[StandingPressure, ...] = ()  # of main pressure, for gauge readings of a standing vehicle

    @property
    def sha256(self) -> str:
        return self.origin.sha256

    @cached_property
    def _by_key(self) -> dict[tuple[str, int], Land]:
        return {land.key: land for land in self.lands}

    @cached_property
    def _by_plane(self) -> dict[tuple[str, str], Land]:
        return {(land.component, plane): land for land in self.lands for plane in land.planes}

    def land(self, component: str, land: int) -> Land:
        """Return the land of that component and number.

        Raises
        ------
        KeyError
            if the controller has no such land.
        """
        return self._by_key[component, land]

    def land_of_plane(self, component: str, plane: str) -> Land | None:
        """Return the land that is measured in that plane, or None."""
        return self._by_plane.get((component, plane))

    def lands_of(self, component: str) -> tuple[Land, ...]:
        return tuple(land for land in self.lands if land.component == component)

    def complaint(self, wanted: str | None) -> Complaint | None:
        """Return the complaint of that id; None where none is wanted.

        Raises
        ------
        InputError
            if the controller maps no such complaint.
        """
        return find_complaint(self.complaints, wanted, self.name)

    def gaps_in(self, gear: int) -> tuple[Gap, ...]:
        """Return the gaps that see a pressure drop in that gear."""
        return tuple(gap for gap in self.gaps if gear in gap.gears)

    def permissible_at(self, gear: int, state: State) -> PermissiblePressure | None:
        """Return between which pressures main pressure must lie in a gear and state; None where the file is silent."""
        return next((each for each in self.permissible if gear in each.gears and each.state == state), None)

    def permissible_in(
        self, selected: SelectorRange, gear: int | None, state: StandingState
    ) -> StandingPressure | None:
        """Return the same for a range of the selector lever: what the file says of the range, or else of its gear."""
        of_state = [each for each in self.standing if each.state == state]
        of_range = (each for each in of_state if selected in each.ranges)
        return next(of_range, None) or next((each for each in of_state if gear in each.gears), None)

    def with_line(self, point: OperatingPoint) -> OperatingPoint:
        """Return an operating point with the main pressure that the line is set to there, where the file says what to.

        Where the line follows a circuit this is what it is set to while that circuit holds its own set pressure.
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
        """Compute all four section pressures [Pa] from the two that are measured; arrays give arrays."""
        return {
            "p_g": main_pressure,
            "p_s": self.relations["p_s"](main_pressure),
            "p_m": self.relations["p_m"](main_pressure),
            "p_k": converter_pressure,
        }

    def above_main(self, main_pressure: Any) -> dict[str, Any]:
        """Tell where p_s or p_m would be above main pressure: it feeds both, so there the relation does not hold."""
        pressures = self.section_pressures(main_pressure, 0.0)
        return {section: pressures[section] > np.maximum(main_pressure, 0.0) for section in ("p_s", "p_m")}


def load_controller(id_or_path: str | Path) -> Controller:
    """Load a shipped controller by id or a workshop's own by path.

    Raises
    ------
    CatalogueError
        if the file is missing or wrong; the message names file, table, key and value.
    """
    entry, origin = read_entry("controllers", id_or_path, ControllerFile)
    return _build(entry, origin)


def controllers() -> list[Controller]:
    """Return every controller that can be used, shipped or own."""
    return list(listed("controllers", load_controller).entries.values())


# --- from the file to the objects ---------------------------------------------------------------------------------


def _build(entry: ControllerFile, origin: Origin) -> Controller:
    twice = sorted({gear for gear in entry.gears if entry.gears.count(gear) > 1})
    if twice:
        raise catalogue_error(origin.path, "", "gears", "gear given twice", value=twice[0])
    lands = tuple(_lands(entry, origin.path))
    relations: dict[str, PressureRelation] = {
        name: read_relation(name, table, origin.path) for name, table in entry.pressures.items()
    }
    reading = Reading(
        origin.path,
        entry.gears,
        [point.name for point in entry.operating_points],
        all(point.solenoid_current_ma is not None for point in entry.operating_points),
        [*SECTIONS, *circuit_ids(entry.circuits, origin.path)],
    )
    gaps = tuple(_gaps(entry, lands, reading))
    needed = {
        pressure.section for gap in gaps for pressure in (gap.high, gap.low) if pressure.section in {"p_s", "p_m"}
    }
    for section in sorted(needed - set(relations)):
        raise catalogue_error(
            origin.path,
            "pressures",
            section,
            f"a gap uses {section}, which no relation gives",
            expected=f"a table [pressures.{section}]",
        )
    # a controller whose gaps use neither pressure still answers what each would be
    for section in ("p_s", "p_m"):
        relations.setdefault(section, PressureRelation("line", 0.0, 0.0, None))
    points = tuple(_operating_points(entry, origin.path))
    complaints = complaints_of(
        entry.complaints,
        [point.name for point in points],
        [land.key for land in lands],
        entry.source,
        origin.path,
    )
    standing = read_standing(entry.permissible_pressure, reading)
    controller = Controller(
        id=entry.id,
        name=entry.name,
        source=entry.source,
        date=entry.date,
        note=entry.note,
        representative=entry.representative,
        gears=tuple(entry.gears),
        components=MappingProxyType({component.id: component.name for component in entry.components}),
        lands=lands,
        gaps=gaps,
        relations=MappingProxyType(relations),
        pump=_pump(entry.pump),
        operating_points=points,
        complaints=complaints,
        origin=origin,
        circuits=read_circuits(entry.circuits, reading),
        leaks=read_leaks(entry.leaks, reading),
        consumers=read_consumers(entry.consumers, reading),
        line=None if entry.line is None else read_line(entry.line, reading),
        line_source="" if entry.line is None else entry.line.source,
        permissible=permissible_in_gear(standing),
        standing=standing,
    )
    for point in (replace(point, gear=gear) for point in points for gear in entry.gears):
        if not controller.with_line(point).main_pressure > 0.0:
            problem, expected = (
                f"the line is set to no pressure in gear {point.gear}",
                f"more than 0 kPa at {point.name}",
            )
            raise catalogue_error(origin.path, "line", "set_kpa", problem, value="0 kPa", expected=expected)
    return replace(controller, operating_points=tuple(controller.with_line(point) for point in points))


def _lands(entry: ControllerFile, path: Path) -> list[Land]:
    lands: list[Land] = []
    seen: set[tuple[str, int]] = set()
    components: set[str] = set()
    for component in entry.components:
        if component.id in components:
            raise catalogue_error(path, "components", "id", "component given twice", value=component.id)
        components.add(component.id)
        planes: set[str] = set()
        for table in component.lands:
            where = f"components ({component.id}).lands"
            if (component.id, table.land) in seen:
                raise catalogue_error(path, where, "land", "land given twice", value=table.land)
            seen.add((component.id, table.land))
            land = _land(entry, component, table, where, path)
            for plane in land.planes:
                if plane in planes:
                    raise catalogue_error(path, where, "planes", "plane given to two lands", value=plane)
                planes.add(plane)
            lands.append(land)
    if not lands:
        raise catalogue_error(path, "components", "lands", "no component has a land", expected="at least one land")
    return lands


def _land(entry: ControllerFile, component: ComponentTable, table: LandTable, where: str, path: Path) -> Land:
    length = table.contact_length_mm or entry.defaults.contact_length_mm
    if length is None:
        raise catalogue_error(
            path,
            where,
            "contact_length_mm",
            f"land {table.land} has no contact length",
            expected="contact_length_mm here or in [defaults]",
        )
    materials: list[tuple[str, float]] = []
    for key in ("body", "spool"):
        name = getattr(table, key) or getattr(entry.defaults, key)
        if name is None or name not in entry.materials:
            problem = f"land {table.land}: " + ("no material" if name is None else "unknown material")
            place = Place(file=path.name, table=where, key=key)
            raise unknown(problem, name, entry.materials, kind=CatalogueError, place=place)
        materials.append((name, entry.materials[name].expansion_per_k))
    new = _mounting(entry, table, where, path)
    return Land(
        component=component.id,
        land=table.land,
        planes=tuple(table.planes or [str(table.land)]),
        part=component.part,
        nominal_diameter=table.nominal_diameter_mm * 1e-3,
        contact_length=length * 1e-3,
        mounting_clearance=new.clearance,
        body_material=materials[0][0],
        spool_material=materials[1][0],
        body_expansion=materials[0][1],
        spool_expansion=materials[1][1],
        clearance_limit=None if table.clearance_limit_um is None else table.clearance_limit_um * 1e-6,
        representative=tuple(name for name in entry.representative_values if name not in table.published),
        mounting_tolerance=new.tolerance,
        new_origin=new.origin,
    )


class _Mounting(NamedTuple):
    clearance: float | tuple[float, float]
    tolerance: float | None
    origin: NewOrigin


def _mounting(entry: ControllerFile, table: LandTable, where: str, path: Path) -> _Mounting:
    """Return what a land had when it was new, from its own table or else from [defaults]."""
    defaults, given = entry.defaults, table.mounting_clearance_um
    given = defaults.mounting_clearance_um if given is None else given
    if given is None:
        raise catalogue_error(
            path,
            where,
            "mounting_clearance_um",
            f"land {table.land} has no mounting clearance",
            expected="mounting_clearance_um here or in [defaults]: a number, or a range such as [6.4, 20.0]",
        )
    tolerance = table.mounting_tolerance_um
    used = table.mounting_clearance_of_used_unit
    used = defaults.mounting_clearance_of_used_unit if used is None else used
    if isinstance(given, list):
        if tolerance is not None:
            problem = f"land {table.land} has a tolerance beside a range of mounting clearances"
            expected = "a tolerance beside a single value, or a range without one"
            raise catalogue_error(path, where, "mounting_tolerance_um", problem, value=tolerance, expected=expected)
        return _Mounting((given[0] * 1e-6, given[1] * 1e-6), None, NewOrigin.USED_UNIT if used else NewOrigin.RANGE)
    tolerance = defaults.mounting_tolerance_um if tolerance is None else tolerance
    if tolerance is not None and tolerance >= given:
        problem = f"land {table.land} has a tolerance that its mounting clearance of {given:g} µm does not exceed"
        expected = "a tolerance that leaves every new pair open, or a range of mounting clearances"
        raise catalogue_error(path, where, "mounting_tolerance_um", problem, value=tolerance, expected=expected)
    origin = NewOrigin.PAIR if tolerance is None else NewOrigin.TYPE
    return _Mounting(
        given * 1e-6, None if tolerance is None else tolerance * 1e-6, NewOrigin.USED_UNIT if used else origin
    )


def _gaps(entry: ControllerFile, lands: tuple[Land, ...], reading: Reading) -> list[Gap]:
    path = reading.path
    if not entry.gaps:  # in a minimal description every land leaks from main pressure to the drain in every gear
        every_gear = frozenset(entry.gears)
        drain = Pressure(0.0, None)
        return [
            Gap(land.component, land.land, "p_g", Pressure(1.0, "p_g"), drain, every_gear, True, False)
            for land in lands
        ]
    known = {land.key for land in lands}
    gaps: list[Gap] = []
    for number, table in enumerate(entry.gaps, start=1):
        where = f"gaps[{number}] ({table.component})"
        if (table.component, table.land) not in known:
            mine = [str(land.land) for land in lands if land.component == table.component]
            expected = f"lands {', '.join(mine)}" if mine else "the id of a component with lands"
            raise catalogue_error(
                path,
                where,
                "land" if mine else "component",
                "no such land in this controller",
                value=table.land if mine else table.component,
                expected=expected,
            )
        gears = reading.gears_of(table.gears, where)
        high, low = reading.ends(table.high, table.low, where, "gap")
        section = high.section or ""  # never empty: see `Reading.ends`
        if table.section is not None and section != table.section:
            problem, expected = "not the section that the gap leaks from", f"the one named in from = {table.high!r}"
            raise catalogue_error(path, where, "section", problem, value=table.section, expected=expected)
        gap = Gap(
            component=table.component,
            land=table.land,
            section=section,
            high=high,
            low=low,
            gears=gears,
            into_sump=(table.ends_in == "sump") if table.ends_in else not low.is_section,
            published=table.published,
        )
        for other in gaps:
            both = gap.gears & other.gears
            if both and (gap.key, gap.high, gap.low) == (other.key, other.high, other.low):
                raise catalogue_error(path, where, "gears", "the same gap was given before", value=min(both))
        gaps.append(gap)
    return gaps


def _pump(table: PumpTable) -> Pump:
    size = table.size
    displacement = (
        pump_equations.displacement(
            size.module_mm * 1e-3, size.teeth, size.width_mm * 1e-3, size.tooth_height_mm * 1e-3
        )
        if isinstance(size, PumpGears)
        else size * 1e-9
    )
    return Pump(displacement, table.volumetric_efficiency, table.slip_coefficient, tuple(table.representative))


def _operating_points(entry: ControllerFile, path: Path) -> list[OperatingPoint]:
    points: list[OperatingPoint] = []
    for number, table in enumerate(entry.operating_points, start=1):
        if table.gear not in entry.gears:
            raise catalogue_error(
                path,
                f"operating_points[{number}] ({table.name})",
                "gear",
                "unknown gear",
                value=table.gear,
                expected=f"one of {entry.gears}",
            )
        if table.name == STATED:
            problem = "name of the condition that a job states, which no controller may give to a point of its own"
            raise catalogue_error(
                path, f"operating_points[{number}]", "name", problem, value=table.name, expected="another name"
            )
        if any(table.name == point.name for point in points):
            raise catalogue_error(
                path, f"operating_points[{number}]", "name", "operating point given twice", value=table.name
            )
        points.append(
            OperatingPoint(
                name=table.name,
                label=table.label,
                temperature=table.temperature_c,
                engine_speed=table.engine_rpm / 60.0,
                gear=table.gear,
                main_pressure=table.p_g_kpa * 1e3,
                converter_pressure=table.p_k_kpa * 1e3,
                source=table.source,
                stated_state=table.state,
                solenoid_current=None if table.solenoid_current_ma is None else table.solenoid_current_ma * 1e-3,
            )
        )
    return points
