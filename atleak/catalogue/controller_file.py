"""Read a controller from its file, or from tables that came another way, and write the tables as such a file.

The TOML file is described in ``docs/describing-a-controller.md``. What is wrong is gathered: faults of single values
and faults of meaning, of keys that do not fit each other, in one list, each with the place that it concerns.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from atleak import equations
from atleak.catalogue.circuits import Pressure, PressureRelation, read_relation
from atleak.catalogue.controller import Controller, Gap, Land
from atleak.catalogue.controller_parts import (
    PartReading,
    read_circuits,
    read_consumers,
    read_leaks,
    read_line,
    read_permissible,
)
from atleak.catalogue.controller_tables import (
    ComponentTable,
    ControllerFile,
    GapTable,
    LandTable,
    LandValue,
    NewOrigin,
    OperatingPointTable,
)
from atleak.catalogue.doubts import doubts_of
from atleak.catalogue.entries import Evidence, Origin, Shelf
from atleak.catalogue.fluid import RequiredFluid
from atleak.catalogue.keys import made
from atleak.catalogue.limits import DEFAULT_LIMITS, load_limits, reaches
from atleak.catalogue.operating_point import STATED, OperatingPoint
from atleak.catalogue.pump import Pump
from atleak.catalogue.pump_dimensions import read_pump
from atleak.catalogue.remaining_tables import Remaining
from atleak.catalogue.repairs import (
    ALL,
    PUMP,
    PUMP_KINDS,
    Complaint,
    ComplaintTable,
    LandKey,
    Repair,
    RepairKind,
    RepairTable,
    written_land,
)
from atleak.common.errors import CatalogueError, DomainError, KeySteps, Message, one_of
from atleak.common.file_faults import fault_in_words, faults_together, model_in, place_of
from atleak.common.sentences import Name, Sentence
from atleak.common.units import KPA, UM, Quantity, gear_name

_ROUNDED = 0.05 + 1e-6  # [kPa] by which a stated pressure differs from that of the line by rounding alone
_ALL: Mapping[KeySteps, Sequence[int]] = MappingProxyType({})


def _checked(data: Mapping[str, Any], origin: Origin) -> Controller:
    try:
        entry = ControllerFile.model_validate(data)
    except ValidationError as error:
        faults = fault_in_words(error, data, origin.path.name, ControllerFile, CatalogueError)
        raise faults_together([*faults, *_faults_of_meaning(data, error, origin)]) from None
    controller, faults = _read(entry, data, origin)
    if controller is None:
        raise faults_together(faults)
    doubts = doubts_of("controllers", ControllerFile, data, origin.file, displacement=controller.pump.displacement)
    apart = _line_apart(entry, controller, data, origin.file)
    return replace(controller, doubts=(*doubts, *apart, *_mending_nothing(controller, data, origin.file)))


CONTROLLERS = Shelf("controllers", ControllerFile, _checked)
checked_controller, controllers = CONTROLLERS.checked, CONTROLLERS.usable


def load_controller(id_or_path: str | Path) -> Controller:
    """Load a controller from its file.

    Parameters
    ----------
    id_or_path
        the id of one that is shipped or in the workshop's own catalogue, or the path of a file.

    Returns
    -------
    Controller
        checked; ``doubts`` say what is unusual.

    Raises
    ------
    CatalogueError
        if the file is missing or wrong; the message names file, table, key and value, and lists every other fault.
    """
    return CONTROLLERS.load(id_or_path)


def _line_apart(entry: ControllerFile, controller: Controller, data: Mapping[str, Any], file: str) -> Iterator[Message]:
    """Say where the line is set to another main pressure than an operating point states, by more than rounding."""
    for number, (stated, taken) in enumerate(zip(entry.operating_points, controller.operating_points, strict=True)):
        if abs(stated.p_g_kpa - taken.main_pressure * KPA) > _ROUNDED:
            text = Sentence(
                "{point}: [line] gives {taken} {taken.unit}, p_g_kpa states {stated} {stated.unit}; that of [line] is "
                "taken.",
                point=Name(taken.label),
                taken=Quantity(taken.main_pressure * KPA, "pressure", 1),
                stated=Quantity(stated.p_g_kpa, "pressure", 1),
            )
            place = place_of(("operating_points", number, "p_g_kpa"), data, file)
            yield Message("warning", "line_apart", text, place)


def _mending_nothing(controller: Controller, data: Mapping[str, Any], file: str) -> Iterator[Message]:
    """Doubt repairs that may leave lands as wide as worn ones: by the limits that hold unless others are chosen."""
    for number, repair in enumerate(controller.repairs):
        left: dict[str, float] = {}
        for land in (controller.land(*key) for key in repair.lands) if repair.ends else ():
            wear = load_limits(DEFAULT_LIMITS).wear
            assert wear is not None
            worn = min(limit for _, limit in wear.of_wear(land.mounting_high, land.mounting_tolerance or 0.0))
            most = min((1.0 + worn) * land.mounting_high, land.clearance_limit or math.inf)
            widest = land.with_repair(repair).widest_new
            if reaches(widest, most):
                left[f"{land.component}/{land.land}"] = widest
        if left:
            text = Sentence(
                "{repair} leaves up to {left:.4g} {left.unit}, as wide as a worn pair of {lands}: by the default "
                "limits no plan takes it for them.",
                repair=Name(repair.label),
                left=Quantity(max(left.values()) * UM, "clearance", 1),
                lands=tuple(left),
            )
            place = place_of(("repairs", number, "mounting_clearance_um"), data, file)
            yield Message("warning", "repair_leaves_worn", text, place)


def _faults_of_meaning(data: Mapping[str, Any], error: ValidationError, origin: Origin) -> list[CatalogueError]:
    """Return what else is wrong with the tables that are well formed, beside those that the error names."""
    remaining = Remaining.of(data, error)
    try:
        entry = ControllerFile.model_validate(remaining.data)
    except ValidationError:  # so much is wrong that nothing can be said of the rest
        return []
    return [fault for fault in _read(entry, data, origin, remaining.kept)[1] if not remaining.follows(fault)]


def _read(
    entry: ControllerFile, data: Mapping[str, Any], origin: Origin, kept: Mapping[KeySteps, Sequence[int]] = _ALL
) -> tuple[Controller | None, list[CatalogueError]]:
    """Return the controller and no fault, or everything that is wrong with its tables, of which some were ``kept``."""
    reading = PartReading.of(entry, data, origin.path, kept)
    _check_gears(entry, reading)
    _check_default_materials(entry, reading)
    lands = tuple(_lands(entry, reading))
    known = [(component.id, table.land) for component in entry.components for table in component.lands]
    sealed = {land.key for land in lands if land.seal}
    described = [gap for gap in _gaps(entry, known, reading) if gap.key not in sealed]
    leaking = {gap.key for gap in described}
    without = [land for land in lands if land.key not in leaking | sealed]
    gaps = (*described, *_gaps_not_described(entry, without))
    points = tuple(_operating_points(entry, reading))
    controller = made(
        Controller,
        entry,
        components=MappingProxyType({component.id: component.name for component in entry.components}),
        lands=lands,
        gaps=gaps,
        relations=MappingProxyType(_relations(entry, gaps, reading)),
        pump=read_pump(entry.pump, reading) or _NO_PUMP,
        operating_points=points,
        complaints=_complaints(entry.complaints, known, entry.source, reading),
        origin=origin,
        circuits=read_circuits(entry.circuits, reading),
        leaks=read_leaks(entry.leaks, reading),
        consumers=read_consumers(entry.consumers, reading),
        line=None if entry.line is None else read_line(entry.line, reading),
        line_source="" if entry.line is None else entry.line.source,
        permissible=read_permissible(entry.permissible_pressure, reading),
        repairs=_repairs(entry.repairs, lands, known, reading),
        gaps_not_described=frozenset(land.key for land in without),
        fluid=None if entry.fluid is None else made(RequiredFluid, entry.fluid),
        entry=entry,
    )
    if not reading.faults:
        _check_line(controller, reading)
    if reading.faults:
        return None, reading.faults
    return replace(controller, operating_points=tuple(controller.with_line(point) for point in points)), []


def _check_gears(entry: ControllerFile, reading: PartReading) -> None:
    twice = [gear for gear in sorted(entry.gears) if entry.gears.count(gear) > 1]
    if twice:
        reading.faults.append(reading.fault(("gears",), Sentence("gear given twice"), value=twice[0]))


def _check_line(controller: Controller, reading: PartReading) -> None:
    """Refuse a line that is set to no pressure in some gear."""
    points = (replace(point, gear=gear) for point in controller.operating_points for gear in controller.gears)
    for point in points:
        if not controller.with_line(point).main_pressure > 0.0:
            problem = Sentence("the line is set to no pressure in gear {gear}", gear=gear_name(point.gear))
            expected = Sentence("more than 0 kPa at {point}", point=point.name)
            reading.faults.append(reading.fault(("line", "set_kpa"), problem, value="0 kPa", expected=expected))
            return


def _relations(entry: ControllerFile, gaps: Iterable[Gap], reading: PartReading) -> dict[str, PressureRelation]:
    relations: dict[str, PressureRelation] = {}
    for name, table in entry.pressures.items():
        try:
            relations[name] = read_relation(table)
        except equations.DomainError as refused:  # diameters or lengths that cannot be those of one valve
            reading.faults.append(reading.fault_of_table(("pressures", name), DomainError.of(refused).sentence))
    used = {pressure.section for gap in gaps for pressure in (gap.high, gap.low)}
    for section in ("p_s", "p_m"):
        if section in used and section not in entry.pressures:
            problem = Sentence("a gap uses {section}, which no relation gives", section=section)
            expected = Sentence("a table [pressures.{section}]", section=section)
            reading.faults.append(reading.fault(("pressures", section), problem, expected=expected))
        # a controller whose gaps use neither pressure still answers what each would be
        relations.setdefault(section, PressureRelation("line", 0.0, 0.0, None))
    return relations


def _check_default_materials(entry: ControllerFile, reading: PartReading) -> None:
    for key in ("body", "spool"):
        name = getattr(entry.defaults, key)
        if name is not None and name not in entry.materials:
            problem = Sentence("unknown material")
            reading.faults.append(reading.unknown(("defaults", key), problem, name, entry.materials))


def _lands(entry: ControllerFile, reading: PartReading) -> list[Land]:
    lands: list[Land] = []

    def component(table: ComponentTable, where: KeySteps) -> None:
        planes: set[str] = set()

        def land_of(own: LandTable, at: KeySteps) -> None:
            land = _land(entry, table, own, at, reading)
            lands.append(land)
            for plane in land.planes:
                if plane in planes:
                    raise reading.fault((*at, "planes"), Sentence("plane given to two lands"), value=plane)
                planes.add(plane)

        reading.objects_of(table.lands, (*where, "lands"), land_of, twice=Sentence("land given twice"), named_by="land")

    reading.objects_of(entry.components, ("components",), component, twice=Sentence("component given twice"))
    if not any(component.lands for component in entry.components):
        problem, expected = Sentence("no component has a land"), Sentence("at least one land")
        reading.faults.append(reading.fault(("components", 0, "lands"), problem, expected=expected))
    return lands


def _land(
    entry: ControllerFile, component: ComponentTable, table: LandTable, where: KeySteps, reading: PartReading
) -> Land:
    length = table.contact_length_mm or entry.defaults.contact_length_mm
    if length is None:
        problem = Sentence("land {land} has no contact length", land=table.land)
        expected = Sentence("contact_length_mm here or in [defaults]")
        raise reading.fault((*where, "contact_length_mm"), problem, expected=expected)
    materials: list[tuple[str, float]] = []
    for key in ("body", "spool"):
        own = getattr(table, key)
        name = own or getattr(entry.defaults, key)
        if name is None or (own and name not in entry.materials):
            reason = Sentence("no material") if name is None else Sentence("unknown material")
            problem = Sentence("land {land}: {reason}", land=table.land, reason=reason)
            raise reading.unknown((*where, key), problem, name, entry.materials)
        # an unknown material of [defaults] is named there, once for all lands
        materials.append((name, entry.materials[name].expansion_per_k if name in entry.materials else 0.0))
    new = _mounting(entry, table, where, reading)
    return made(
        Land,
        table,
        component=component.id,
        planes=tuple(table.planes or [str(table.land)]),
        part=component.part,
        contact_length=length * 1e-3,
        body_material=materials[0][0],
        spool_material=materials[1][0],
        body_expansion=materials[0][1],
        spool_expansion=materials[1][1],
        representative=tuple(name for name in get_args(LandValue) if entry.known_from(table, name) is _ASSUMED),
        sleeved=component.bore == "sleeved",
        mounting_measured=new["new_origin"] in (NewOrigin.PAIR, NewOrigin.TYPE)
        and entry.known_from(table, "mounting_clearance_um") is Evidence.MEASURED,
        **new,
    )


_NO_LAND = Sentence("no such land in this controller")
_NO_COMPONENT = Sentence("no such component with lands in this controller")
_NO_POINT = Sentence("no such operating point in this controller")
_POINT_TWICE = Sentence("operating point given twice")
_OVERSIZE = 2.0e-3  # [m] by which a repair changes a nominal diameter at most: choice of this project
_ASSUMED = Evidence.REPRESENTATIVE
_NO_PUMP = Pump(1.0, 1.0, None, ())  # of a file whose own is refused


def _mounting(entry: ControllerFile, table: LandTable, where: KeySteps, reading: PartReading) -> dict[str, Any]:
    """Return what a land had when it was new, from its own table or else from [defaults]."""
    defaults, given = entry.defaults, table.mounting_clearance_um
    given = defaults.mounting_clearance_um if given is None else given
    if given is None:
        problem = Sentence("land {land} has no mounting clearance", land=table.land)
        expected = Sentence("mounting_clearance_um here or in [defaults]: a number, or a range such as [6.4, 20.0]")
        raise reading.fault((*where, "mounting_clearance_um"), problem, expected=expected)
    tolerance, at = table.mounting_tolerance_um, (*where, "mounting_tolerance_um")
    used = table.mounting_clearance_of_used_unit
    used = defaults.mounting_clearance_of_used_unit if used is None else used
    if isinstance(given, list):
        if tolerance is not None:
            problem = Sentence("land {land} has a tolerance beside a range of mounting clearances", land=table.land)
            expected = Sentence("a tolerance beside a single value, or a range without one")
            raise reading.fault(at, problem, value=tolerance, expected=expected)
        ends, origin = (given[0] * 1e-6, given[1] * 1e-6), NewOrigin.USED_UNIT if used else NewOrigin.RANGE
        return {"mounting_clearance": ends, "mounting_tolerance": None, "new_origin": origin}
    tolerance = defaults.mounting_tolerance_um if tolerance is None else tolerance
    if tolerance is not None and tolerance >= given:
        problem = Sentence(
            "land {land} has a tolerance that its mounting clearance of {given:g} µm does not exceed",
            land=table.land,
            given=given,
        )
        expected = Sentence("a tolerance that leaves every new pair open, or a range of mounting clearances")
        raise reading.fault(at, problem, value=tolerance, expected=expected)
    origin = NewOrigin.USED_UNIT if used else NewOrigin.PAIR if tolerance is None else NewOrigin.TYPE
    half_width = None if tolerance is None else tolerance * 1e-6
    return {"mounting_clearance": given * 1e-6, "mounting_tolerance": half_width, "new_origin": origin}


def _gaps(entry: ControllerFile, known: Sequence[LandKey], reading: PartReading) -> list[Gap]:
    gaps: list[Gap] = []

    def gap_of(table: GapTable, where: KeySteps) -> None:
        gap = _gap(table, known, where, reading)
        for other in gaps:
            both = gap.gears & other.gears
            if both and (gap.key, gap.high, gap.low) == (other.key, other.high, other.low):
                raise reading.fault((*where, "gears"), Sentence("the same gap was given before"), value=min(both))
        gaps.append(gap)

    reading.objects_of(entry.gaps, ("gaps",), gap_of)
    return gaps


def _gaps_not_described(entry: ControllerFile, lands: Iterable[Land]) -> Iterator[Gap]:
    """Take lands to leak from main pressure to the drain in every gear, which is an upper bound."""
    every_gear = frozenset(entry.gears)
    drain = Pressure(0.0, None)
    for land in lands:
        yield Gap(land.component, land.land, "p_g", Pressure(1.0, "p_g"), drain, every_gear, True, None)


def _gap(table: GapTable, known: Sequence[LandKey], where: KeySteps, reading: PartReading) -> Gap:
    _check_land(table.component, [table.land], "land", known, where, reading)
    gears = reading.gears_of(table.gears, (*where, "gears"))
    high, low = reading.ends(table.high, table.low, where, "gap")
    section = high.section or ""  # never empty: see `Reading.ends`
    if table.section is not None and section != table.section:
        problem = Sentence("not the section that the gap leaks from")
        expected = Sentence("the one named in from = {high!r}", high=table.high)
        raise reading.fault((*where, "section"), problem, value=table.section, expected=expected)
    return made(
        Gap,
        table,
        section=section,
        high=high,
        low=low,
        gears=gears,
        into_sump=(table.ends_in == "sump") if table.ends_in else not low.is_section,
        evidence=table.known_from,
    )


def _check_land(
    component: str, lands: Iterable[int], key: str, known: Sequence[LandKey], where: KeySteps, reading: PartReading
) -> None:
    """Refuse a land that the controller does not have."""
    mine = [land for name, land in known if name == component]
    for land in lands:
        if (component, land) not in known:
            expected = Sentence("lands {lands}", lands=mine) if mine else Sentence("the id of a component with lands")
            at, value = ((*where, key), land) if mine else ((*where, "component"), component)
            problem = _NO_LAND
            raise reading.fault(at, problem, value=value, expected=expected, refers_to="lands")


def _repairs(
    tables: Sequence[RepairTable], lands: Sequence[Land], known: Sequence[LandKey], reading: PartReading
) -> tuple[Repair, ...]:
    def repair(table: RepairTable, where: KeySteps) -> Repair:
        of_pump = table.component == PUMP and all(component != PUMP for component, _ in known)
        _check_what_is_repaired(table, where, reading, of_pump=of_pump)  # a component of that name goes before it
        mended = () if of_pump else _mended(table, known, where, reading)
        _check_diameter(table, [land for land in lands if land.key in mended], where, reading)
        return made(Repair, table, lands=mended)

    return tuple(reading.objects_of(tables, ("repairs",), repair, twice=Sentence("repair given twice")))


def _check_what_is_repaired(table: RepairTable, where: KeySteps, reading: PartReading, *, of_pump: bool) -> None:
    """Refuse what only repairs of components state beside one of the pump, which leaves that as new, or the reverse."""
    of_lands = ("lands", "nominal_diameter_mm", "mounting_clearance_um", "mounting_tolerance_um")
    kinds = [kind for kind in get_args(RepairKind) if kind == "other" or (kind in PUMP_KINDS) == of_pump]
    if table.kind not in kinds:
        problem = Sentence("no repair of the pump") if of_pump else Sentence("a repair of the pump alone")
        raise reading.fault((*where, "kind"), problem, value=table.kind, expected=one_of(kinds))
    for name in of_lands if of_pump else ():
        if getattr(table, name) is not None:
            problem, expected = Sentence("a repair leaves the pump as new"), Sentence("nothing here")
            raise reading.fault((*where, name), problem, value=getattr(table, name), expected=expected)


def _mended(table: RepairTable, known: Sequence[LandKey], where: KeySteps, reading: PartReading) -> tuple[LandKey, ...]:
    """Return the lands of a repair's component, of the several ones of a kit, or of all."""
    if table.component is not None and table.lands is not None:
        _check_land(table.component, table.lands, "lands", known, where, reading)
        return tuple((table.component, land) for land in dict.fromkeys(table.lands))
    if table.components == ALL:
        return tuple(known)
    key, names = ("component", [table.component]) if table.component else ("components", table.components or ())
    components = dict.fromkeys(component for component, _ in known)
    for name in names:
        if name not in components:
            raise reading.unknown((*where, key), _NO_COMPONENT, name, components, refers_to="lands")
    return tuple(key for name in names for key in known if key[0] == name)


def _check_diameter(table: RepairTable, lands: Sequence[Land], where: KeySteps, reading: PartReading) -> None:
    """Refuse a repair whose nominal diameter cannot be that of one of its lands."""
    diameter = table.nominal_diameter_mm
    if diameter is None:
        return
    for land in lands:
        if abs(diameter * 1e-3 - land.nominal_diameter) > _OVERSIZE:
            nominal = land.nominal_diameter * 1e3
            problem = Sentence("land {land} is {nominal:g} mm: no oversize of it", land=land.land, nominal=nominal)
            expected = Sentence("lands = [..] with the lands that get this diameter, and another repair for the rest")
            raise reading.fault((*where, "nominal_diameter_mm"), problem, value=diameter, expected=expected)


def _operating_points(entry: ControllerFile, reading: PartReading) -> list[OperatingPoint]:
    def point(table: OperatingPointTable, where: KeySteps) -> OperatingPoint:
        if table.gear not in entry.gears:
            raise reading.unknown_gear((*where, "gear"), table.gear)
        if table.name == STATED:
            problem = Sentence(
                "name of the condition that a job states, which no controller may give to a point of its own"
            )
            raise reading.fault((*where, "name"), problem, value=table.name, expected=Sentence("another name"))
        return made(OperatingPoint, table)

    return reading.objects_of(entry.operating_points, ("operating_points",), point, twice=_POINT_TWICE, named_by="name")


def _complaints(
    tables: Sequence[ComplaintTable], lands: Collection[LandKey], source: str, reading: PartReading
) -> tuple[Complaint, ...]:
    names = {written_land(key): key for key in lands}

    def complaint(table: ComplaintTable, where: KeySteps) -> Complaint:
        at, problems = (*where, "conditions"), (_NO_POINT, _POINT_TWICE)
        _each_known_once(table.conditions, reading.points, at, problems, "operating_points", reading)
        at, problems = (*where, "lands"), (_NO_LAND, Sentence("land given twice"))
        _each_known_once(table.lands or (), names, at, problems, "lands", reading)
        at_lands = tuple(names[name] for name in table.lands or ())
        return made(Complaint, table, lands=at_lands, source=table.source or source)

    return tuple(reading.objects_of(tables, ("complaints",), complaint, twice=Sentence("complaint given twice")))


def _each_known_once(
    given: Sequence[str],
    known: Collection[str],
    steps: KeySteps,
    problems: tuple[Sentence, Sentence],  # of an unknown name, of one given twice
    refers_to: str,
    reading: PartReading,
) -> None:
    unknown, twice = problems
    for name in given:
        if name not in known:
            raise reading.unknown(steps, unknown, name, known, refers_to=refers_to)
        if given.count(name) > 1:
            raise reading.fault(steps, twice, value=name)


def written_toml(data: Mapping[str, Any], model: type[BaseModel] = ControllerFile) -> str:
    """Return the TOML file of an entry: the keys in the order of its model, none that is None, no comments.

    The same tables give the same text. Tables that are wrong are written too, so that they can be mended.

    Parameters
    ----------
    data
        the tables as a TOML file of the same content gives them.
    model
        what such a file holds; that of a controller unless given.
    """
    import tomli_w  # only who writes a file needs it

    return tomli_w.dumps(_ordered(data, model))


def _ordered(table: Mapping[str, Any], model: type[BaseModel] | None) -> dict[str, Any]:
    """Return a table with its keys in the order of its model, unknown ones last."""
    fields = [] if model is None else [field.alias or name for name, field in model.model_fields.items()]
    known = [key for key in fields if key in table]
    keys = [*known, *sorted(key for key in table if key not in known)] if model is not None else list(table)
    return {key: _value(table[key], _model_of(model, key)) for key in keys if table[key] is not None}


def _value(value: Any, model: type[BaseModel] | None) -> Any:
    if isinstance(value, Mapping):
        if model is None or (any(isinstance(each, Mapping) for each in value.values()) and _is_named(value, model)):
            return {str(key): _value(each, model) for key, each in value.items() if each is not None}
        return _ordered(value, model)
    if isinstance(value, list | tuple):
        return [_value(each, model) for each in value]
    return value


def _is_named(value: Mapping[str, Any], model: type[BaseModel]) -> bool:
    """Tell whether a table holds tables by name, such as materials, rather than the keys of its model."""
    return not any((field.alias or name) in value for name, field in model.model_fields.items())


def _model_of(model: type[BaseModel] | None, key: str) -> type[BaseModel] | None:
    for name, field in (model.model_fields if model is not None else {}).items():
        if (field.alias or name) == key:
            return model_in(field.annotation)
    return None
