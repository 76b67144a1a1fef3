"""Read the table of a pump: what it displaces by its dimensions, and what its gaps let slip."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from atleak.catalogue.controller_parts import PartReading
from atleak.catalogue.keys import unit_of
from atleak.catalogue.pump import Pump, PumpClearances, PumpGaps, TipGaps
from atleak.catalogue.pump_tables import PumpKind, PumpTable
from atleak.common.errors import CatalogueError, DomainError, one_of
from atleak.common.sentences import Sentence
from atleak.equations import DomainError as RefusedByEquation
from atleak.equations import pump as equations


class _Kind(NamedTuple):
    """What the displacement and the slip of one kind of pump follow from, as keys of the table."""

    name: Sentence
    displacement: Callable[..., float]
    sizes: tuple[str, ...]  # the arguments of that function, in its order
    faces: tuple[tuple[str, str], ...]  # of every rotor: where the sealing land of its faces begins and ends
    rims: int  # along which tips seal between delivery and suction
    in_a_row: str | None  # how many tips of a rim; None: one
    besides: tuple[str, ...] = ()  # from which one of those follows

    @property
    def of_faces(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys([*(key for ends in self.faces for key in ends), *self.besides]))

    @property
    def of_tips(self) -> tuple[str, ...]:
        if not self.rims:
            return ()
        return ("width_mm", "tip_land_mm", *(() if self.in_a_row is None else (self.in_a_row,)))


_GEAR = ("root_diameter_mm", "shaft_diameter_mm")
_RING = ("ring_outer_diameter_mm", "ring_root_diameter_mm")
_KINDS: Mapping[PumpKind, _Kind] = MappingProxyType(
    {
        "external_gear": _Kind(
            Sentence("gear pump"),
            equations.gear_pair_displacement,
            ("tip_diameter_mm", "centre_distance_mm", "width_mm", "teeth"),
            (_GEAR, _GEAR),
            2,
            "sealing_tips",
        ),
        "crescent": _Kind(
            Sentence("crescent pump"),
            equations.crescent_displacement,
            ("tip_diameter_mm", "ring_tip_diameter_mm", "centre_distance_mm", "width_mm", "teeth", "ring_teeth"),
            (_GEAR, _RING),
            2,
            "sealing_tips",
        ),
        "gerotor": _Kind(
            Sentence("gerotor"),
            equations.gerotor_displacement,
            ("tip_diameter_mm", "root_diameter_mm", "width_mm", "teeth"),
            (_GEAR, _RING),
            1,
            None,
            ("tip_diameter_mm",),
        ),
        "vane": _Kind(
            Sentence("vane pump"),
            equations.vane_displacement,
            ("cam_ring_diameter_mm", "eccentricity_mm", "width_mm", "vanes"),
            (("rotor_diameter_mm", "shaft_diameter_mm"),),
            0,
            None,
        ),
    }
)
_BY_MODULE = ("module_mm", "teeth", "width_mm", "tooth_height_mm")  # the arguments of `equations.pump.displacement`
_WITH_MODULE = (None, "external_gear", "crescent")  # kinds of which it holds
_BEYOND: Mapping[str, tuple[str, str]] = MappingProxyType(  # dimensions of which the first is the larger
    {"external_gear": ("tip_diameter_mm", "centre_distance_mm"), "gerotor": ("tip_diameter_mm", "root_diameter_mm")}
)
_DIMENSIONS = tuple(
    dict.fromkeys(key for kind in _KINDS.values() for key in (*_BY_MODULE, *kind.sizes, *kind.of_faces, *kind.of_tips))
)


def read_pump(table: PumpTable, reading: PartReading) -> Pump | None:
    """Return the pump of a table, or None where its displacement cannot be known; what is wrong is gathered."""
    _check_kind(table, reading)
    _check_clearances(table, reading)
    sizes = _dimensions(table)
    _check_faces(table.kind, sizes, reading)
    displacement, gaps = None, PumpGaps(None, None)
    try:
        displacement = _displacement(table, sizes, reading)
        if displacement is not None and table.kind is not None:
            gaps = _gaps(_KINDS[table.kind], sizes, displacement)
    except RefusedByEquation as refused:  # dimensions that cannot be those of one pump
        reading.faults.append(reading.fault_of_table(("pump",), DomainError.of(refused).sentence))
    if displacement is None:
        return None
    pump = Pump(
        displacement,
        table.volumetric_efficiency,
        table.slip_coefficient,
        tuple(table.representative),
        kind=table.kind,
        held_at_demand=table.held_at_demand,
        gaps=gaps,
        clearances=PumpClearances.of_um(table.side_clearance_um, table.tip_clearance_um),
        limits=PumpClearances.of_um(table.side_clearance_limit_um, table.tip_clearance_limit_um),
    )
    return pump.with_gaps() if pump.slip_coefficient is None else pump


def _dimensions(table: PumpTable) -> dict[str, Any]:
    """Return the dimensions that are known, in SI: those stated, and those that follow from them."""
    sizes = {key: getattr(table, key) for key in _DIMENSIONS if getattr(table, key) is not None}
    if table.kind == "gerotor" and {"tip_diameter_mm", "root_diameter_mm"} <= sizes.keys():
        tip, root = sizes["tip_diameter_mm"], sizes["root_diameter_mm"]
        sizes.setdefault("ring_root_diameter_mm", tip + 0.5 * (tip - root))  # into which its tips fit
    if table.kind == "vane" and {"cam_ring_diameter_mm", "rotor_diameter_mm"} <= sizes.keys():
        play = sizes["cam_ring_diameter_mm"] - sizes["rotor_diameter_mm"]
        sizes.setdefault("eccentricity_mm", 0.5 * play)  # until the rotor touches the ring
    return {key: unit_of(key)[1].in_si(size) for key, size in sizes.items()}


def other_dimensions(kind: PumpKind | None) -> tuple[str, ...]:
    """Return the keys of dimensions that pumps of this kind do not have; without a kind, those that need one."""
    own = _own_dimensions(kind)
    return tuple(key for key in _DIMENSIONS if key not in own)


def _own_dimensions(kind: PumpKind | None) -> Collection[str]:
    if kind is None:
        return _BY_MODULE
    of = _KINDS[kind]
    return {*of.sizes, *of.of_faces, *of.of_tips, *(_BY_MODULE if kind in _WITH_MODULE else ())}


def _check_kind(table: PumpTable, reading: PartReading) -> None:
    """Refuse dimensions that a pump of this kind does not have, or those of a kind that is not stated."""
    own = _own_dimensions(table.kind)
    others = [key for key in _DIMENSIONS if getattr(table, key) is not None and key not in own]
    if table.kind is None:
        if others:
            problem = Sentence("no kind of pump, of which {key} is a dimension", key=others[0])
            expected = one_of(_KINDS)
            reading.faults.append(reading.fault(("pump", "kind"), problem, expected=expected))
        return
    for key in others:
        problem = Sentence("no dimension of a {pump}", pump=_KINDS[table.kind].name)
        expected = Sentence("of {names}", names=[name for name in _DIMENSIONS if name in own])
        reading.faults.append(reading.fault(("pump", key), problem, value=getattr(table, key), expected=expected))


def _check_faces(kind: PumpKind | None, sizes: dict[str, Any], reading: PartReading) -> None:
    """Refuse a sealing land that ends where it begins, and go on without the diameter where it does."""
    for outer, inner in () if kind is None else dict.fromkeys(_KINDS[kind].faces):
        if sizes.get(outer, 1.0) <= sizes.get(inner, 0.0):
            at, value = ("pump", inner), sizes.pop(inner) * 1e3
            problem = Sentence("the sealing land of the faces would end where it begins")
            expected = Sentence("less than {key}", key=outer)
            reading.faults.append(reading.fault(at, problem, value=value, expected=expected))


def _check_clearances(table: PumpTable, reading: PartReading) -> None:
    for name in ("side_clearance", "tip_clearance"):
        new, most = getattr(table, f"{name}_um"), getattr(table, f"{name}_limit_um")
        at = ("pump", f"{name}_limit_um")
        if new is not None and most is not None and most < new:
            problem = Sentence("a limit under the clearance of a new pump")
            expected = Sentence("at least {new:g} µm", new=new)
            reading.faults.append(reading.fault(at, problem, value=most, expected=expected))
        if name == "tip_clearance" and table.kind == "vane" and (new or most):
            at, problem = ("pump", f"{name}_um") if new is not None else at, Sentence("a tip clearance of a vane pump")
            expected = Sentence("none: its vanes lie against the ring")
            reading.faults.append(reading.fault(at, problem, value=new or most, expected=expected))


def _displacement(table: PumpTable, sizes: Mapping[str, Any], reading: PartReading) -> float | None:
    """Return what a pump displaces [m³/rev]; None, with the fault gathered, where the table does not say."""
    kind = None if table.kind is None else _KINDS[table.kind]
    if table.displacement_mm3 is not None:
        twice = _dimensions_beside(table, kind)
        if not twice:
            return table.displacement_mm3 * 1e-9
        problem = Sentence("the displacement is stated, and {keys} too, from which it would follow", keys=twice)
        expected = Sentence("{ways}, not both", ways=_ways(kind))
        reading.faults.append(reading.fault_of_table(("pump",), problem, expected=expected))
        return None
    formula, keys = (kind.displacement, kind.sizes) if kind else (equations.displacement, _BY_MODULE)
    if table.kind in _WITH_MODULE and (table.module_mm is not None or table.tooth_height_mm is not None):
        formula, keys = equations.displacement, _BY_MODULE
    there = [key for key in keys if key in sizes]
    if not there:
        problem = Sentence("nothing says what the pump displaces")
        reading.faults.append(reading.fault_of_table(("pump",), problem, expected=_ways(kind)))
    for key in keys if there else ():
        if key not in sizes:
            problem = Sentence("missing beside {keys}", keys=there)
            reading.faults.append(reading.fault(("pump", key), problem, expected=_ways(kind)))
    if len(there) < len(keys):
        return None
    misfit = None if formula is equations.displacement else _misfit(table, reading)
    if misfit is not None:
        reading.faults.append(misfit)
        return None
    return float(formula(*(sizes[key] for key in keys)))


def _dimensions_beside(table: PumpTable, kind: _Kind | None) -> list[str]:
    """Return the dimensions of a table from which a displacement follows, those of its slip aside."""
    of_slip, sizes = ((*kind.of_faces, *kind.of_tips), kind.sizes) if kind else ((), ())
    of_size = {*_BY_MODULE, *sizes} - set(of_slip)
    return [key for key in _DIMENSIONS if key in of_size and getattr(table, key) is not None]


def _misfit(table: PumpTable, reading: PartReading) -> CatalogueError | None:
    """Return the fault of dimensions that cannot be those of one pump, each in the unit of the file."""
    if table.kind is not None and table.kind in _BEYOND:
        outer, inner = _BEYOND[table.kind]
        most, least = getattr(table, outer), getattr(table, inner)
        if most > least:
            return None
        expected = Sentence("more than {key}, {least:g} mm: check both", key=inner, least=least)
        return reading.fault(
            ("pump", outer), Sentence("too small beside {key}", key=inner), value=most, expected=expected
        )
    if table.kind == "crescent":
        return _meshing_misfit(table, reading)
    return None


def _meshing_misfit(table: PumpTable, reading: PartReading) -> CatalogueError | None:
    """Return the fault of a pinion or ring gear whose tips do not reach past the circle on which both roll."""
    tip, ring_tip, apart = table.tip_diameter_mm, table.ring_tip_diameter_mm, table.centre_distance_mm
    teeth, ring_teeth = table.teeth, table.ring_teeth
    if tip is None or ring_tip is None or apart is None or teeth is None or ring_teeth is None or ring_teeth <= teeth:
        return None
    working, ring_working = (2.0 * apart * count / (ring_teeth - teeth) for count in (teeth, ring_teeth))
    numbers = {"apart": apart, "teeth": teeth, "ring_teeth": ring_teeth}
    if tip <= working:
        problem = Sentence(
            "the pinion's tips of {tip:g} mm, axes {apart:g} mm apart, and {teeth} and {ring_teeth} teeth do not fit "
            "together",
            tip=tip,
            **numbers,
        )
        expected = Sentence(
            "tips above {least:.2f} mm with these axes and teeth: check tip diameter, centre distance and numbers of "
            "teeth",
            least=working,
        )
        return reading.fault(("pump", "tip_diameter_mm"), problem, expected=expected)
    if ring_tip >= ring_working:
        problem = Sentence(
            "the ring gear's tips of {tip:g} mm, axes {apart:g} mm apart, and {teeth} and {ring_teeth} teeth do not "
            "fit together",
            tip=ring_tip,
            **numbers,
        )
        expected = Sentence(
            "tips below {most:.2f} mm with these axes and teeth: check tip diameter, centre distance and numbers of "
            "teeth",
            most=ring_working,
        )
        return reading.fault(("pump", "ring_tip_diameter_mm"), problem, expected=expected)
    return None


def _ways(kind: _Kind | None) -> Sentence:
    """Say how a displacement can be stated."""
    if kind is None:
        return Sentence(
            "either displacement_mm3 or the dimensions of one kind: all of {keys} and {last}, or with kind those of it",
            keys=_BY_MODULE[:-1],
            last=_BY_MODULE[-1],
        )
    return Sentence(
        "either displacement_mm3 or the dimensions of a {pump}: all of {keys}", pump=kind.name, keys=kind.sizes
    )


def _gaps(kind: _Kind, sizes: Mapping[str, Any], displacement: float) -> PumpGaps:
    """Return what the gaps of a pump make of its slip coefficient."""
    of_side, of_tip = (tuple(key for key in keys if key not in sizes) for keys in (kind.of_faces, kind.of_tips))
    side = tips = None
    if not of_side:
        slip = sum(equations.face_slip(1.0, sizes[outer], sizes[inner]) for outer, inner in kind.faces)
        side = equations.slip_coefficient(slip, displacement)
    if kind.rims and not of_tip:
        in_a_row = 1 if kind.in_a_row is None else sizes[kind.in_a_row]
        tips = TipGaps(sizes["width_mm"], sizes["tip_land_mm"], in_a_row, kind.rims)
    return PumpGaps(side, tips, kind.rims > 0, of_side, of_tip)
