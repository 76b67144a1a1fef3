"""Show catalogue entries as tables in a reader's language and units."""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType
from typing import Any

from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.catalogue.repairs import Repair
from atleak.views.catalogue_table import CatalogueTable, Rows, columns, span
from atleak.views.circuit_rows import MILLIAMPERE, circuit_tables, gears_words
from atleak.views.evidence_rows import evidence_table
from atleak.views.land_names import land_number
from atleak.views.repair_options import repair_name
from atleak.views.sentences import rule_value
from atleak.views.table import Column
from atleak.wording import Wording, isolated
from atleak.workshop_units import G_CM3, KPA, MM, MM2_S, PERCENT, RPM, UM

FOLDERS = MappingProxyType({"controller": "controllers", "fluid": "fluids", "limits": "limits"})
_MM3 = 1e9  # from m³
_POINTS = columns(
    "condition",
    Column("temperature", "temperature"),
    Column("engine_speed", "engine_speed"),
    Column("gear", digits=0),
    Column("main_pressure", "pressure"),
    Column("converter_pressure", "pressure"),
    "state",
    Column("solenoid_current", digits=0),
    Column("lockup_duty", "percent", 0),
    "source",
)
_LANDS = columns(
    "component",
    Column("land", digits=0),
    "planes",
    Column("nominal_diameter", "length"),
    Column("contact_length", "length", 2),
    Column("mounting", words_of="clearance"),
    Column("tolerance", "clearance"),
    "known_from",
    Column("own_limit", "clearance"),
    "built",
    "materials",
    "representative_values",
)
_REPAIRS = columns(
    "component",
    "lands",
    "repair",
    "own_id",
    "repair_kind",
    "price",
    Column("hours", digits=1),
    "tool",
    Column("nominal_diameter", "length"),
    Column("clearance_left", words_of="clearance"),
    "known_from",
    "source",
)
_GAPS = columns(
    "component", Column("land", digits=0), "section", "flows_from", "flows_to", "gears", "ends_in", "known_from"
)
_PUMP = columns(
    Column("displacement", "displacement"),
    Column("volumetric_efficiency", digits=3),
    "slip_coefficient",
    "representative_values",
)
_COMPLAINTS = columns("own_id", "complaint", "shows_at", "lands", "source")
_VISCOSITIES = columns(
    Column("temperature", "temperature"), Column("viscosity", "viscosity", 2), Column("density", "density", 4)
)
_LIMITS = columns(
    "rule",
    "from_here",
    "limit",
    Column("at_least", "clearance"),
    Column("growth", "percent", 0),
    Column("added_points", "percent", 1),
    "limit_is",
    "source",
)


def representative(entry: Controller | Fluid, say: Wording) -> str:
    """Say which values of an entry are representative: as its file words it, where that is no shipped one."""
    values = entry.representative
    return say.name(values) if isinstance(values, str) else ", ".join(say.get("value_names", each) for each in values)


def controller_tables(controller: Controller, say: Wording) -> list[CatalogueTable]:
    """Return the tables of operating points, circuits, lands, gaps, pump and complaints; none without a row."""
    tables = [
        evidence_table(controller, say),
        CatalogueTable("points", _POINTS, _point_rows(controller, say)),
        *circuit_tables(controller, say),
        CatalogueTable("lands", _LANDS, [_land_row(land, controller, say) for land in controller.lands]),
        CatalogueTable("repairs", _REPAIRS, [_repair_row(each, controller, say) for each in controller.repairs]),
        CatalogueTable("gaps", _GAPS, _gap_rows(controller, say)),
        CatalogueTable("pump", _PUMP, _pump_rows(controller, say)),
        CatalogueTable("complaints", _COMPLAINTS, _complaint_rows(controller, say)),
    ]
    return [table for table in tables if table.rows]


def _point_rows(controller: Controller, say: Wording) -> Rows:
    return [
        {
            "condition": say.condition(point),
            "temperature": point.temperature,
            "engine_speed": point.engine_speed * RPM,
            "gear": point.gear,
            "main_pressure": point.main_pressure * KPA,
            "converter_pressure": point.converter_pressure * KPA,
            "state": say.get("states", point.state),
            "solenoid_current": None if point.solenoid_current is None else point.solenoid_current * MILLIAMPERE,
            "lockup_duty": None if point.lockup_duty is None else point.lockup_duty * PERCENT,
            "source": point.source,
        }
        for point in controller.operating_points
    ]


def _component(name: str, controller: Controller, say: Wording) -> str:
    return f"{name} · {isolated(say.name(controller.components[name]))}"


def _land_row(land: Land, controller: Controller, say: Wording) -> dict[str, Any]:
    built = [say("measuring.end_plug")] if land.part == "end_plug" else []
    built += [say("catalogue.sleeved")] if land.sleeved else []
    built += [say(f"catalogue.sealed_{land.seal}")] if land.seal else []
    materials = (say.get("catalogue_materials", each) for each in (land.body_material, land.spool_material))
    return {
        "component": _component(land.component, controller, say),
        "land": land.land,
        "planes": ", ".join(land.planes),
        "nominal_diameter": land.nominal_diameter * MM,
        "contact_length": land.contact_length * MM,
        "mounting": span((end * UM for end in land.mounting_ends), "clearance", say),
        "tolerance": None if land.mounting_tolerance is None else land.mounting_tolerance * UM,
        "known_from": say(f"catalogue.new_{land.new_origin}"),
        "own_limit": None if land.clearance_limit is None else land.clearance_limit * UM,
        "built": "; ".join(built) or None,
        "materials": " / ".join(materials),
        "representative_values": ", ".join(say.get("parts", each) for each in land.representative) or None,
    }


def _repair_row(repair: Repair, controller: Controller, say: Wording) -> dict[str, Any]:
    left = span((end * UM for end in repair.ends), "clearance", say)
    return {
        "component": _component(repair.component, controller, say),
        "lands": ", ".join(map(str, sorted(repair.lands))),
        "repair": repair_name(repair, say),
        "own_id": repair.id,
        "repair_kind": say(f"catalogue.repair_{repair.kind}"),
        "price": None if repair.price is None else f"{say.number(repair.price, 2)} {repair.currency}",
        "hours": repair.hours,
        "tool": repair.tool,
        "nominal_diameter": None if repair.nominal_diameter is None else repair.nominal_diameter * MM,
        "clearance_left": left or say("catalogue.as_new_parts"),
        "known_from": _known_from(repair.evidence, say),
        "source": repair.source,
    }


def _known_from(evidence: str | None, say: Wording) -> str:
    return say(f"evidence.{evidence or 'not_stated'}")


def _gap_rows(controller: Controller, say: Wording) -> Rows:
    return [
        {
            "component": _component(gap.component, controller, say),
            "land": gap.land,
            "section": gap.section,
            "flows_from": str(gap.high),
            "flows_to": str(gap.low),
            "gears": gears_words(gap.gears),
            "ends_in": say("flows.sump") if gap.into_sump else say("catalogue.another_section"),
            "known_from": _known_from(gap.evidence, say),
        }
        for gap in controller.gaps
    ]


def _pump_rows(controller: Controller, say: Wording) -> Rows:
    pump = controller.pump
    return [
        {
            "displacement": pump.displacement * _MM3,
            "volumetric_efficiency": pump.volumetric_efficiency,
            "slip_coefficient": None if pump.slip_coefficient is None else say.plain(pump.slip_coefficient, 4),
            "representative_values": ", ".join(say.get("value_names", each) for each in pump.representative) or None,
        }
    ]


def _complaint_rows(controller: Controller, say: Wording) -> Rows:
    points = {point.name: say.condition(point) for point in controller.operating_points}
    return [
        {
            "own_id": complaint.id,
            "complaint": say.name(complaint.label),
            "shows_at": "; ".join(points[name] for name in complaint.conditions),
            "lands": ", ".join(land_number(controller, each, say) for each in complaint.lands)
            or say("catalogue.every_land"),
            "source": complaint.source,
        }
        for complaint in controller.complaints
    ]


def fluid_tables(fluid: Fluid, say: Wording) -> list[CatalogueTable]:
    """Return data-sheet points, density, and the viscosity that follows from them where it can be trusted."""
    low, high = fluid.span()
    between = [float(temperature) for temperature in range(-20, 141, 20) if low <= temperature <= high]
    at, density = fluid.density_at
    sheet = [
        *(_value_row("viscosity_at", nu * MM2_S, "viscosity", 2, at, say) for at, nu in fluid.points),
        _value_row("density_at", density * G_CM3, "density", 4, at, say),
        _value_row("pour_point", fluid.pour_point, "temperature", 0, None, say),
    ]
    computed = [(each, fluid.kinematic_viscosity(each), fluid.density(each)) for each in between]
    tables = [
        CatalogueTable("data_sheet", columns("what", "value", "unit"), sheet),
        CatalogueTable("d341", _VISCOSITIES, _viscosity_rows(computed)),
        CatalogueTable("tabulated", _VISCOSITIES, _viscosity_rows(fluid.table)),
    ]
    return [table for table in tables if table.rows]


def _value_row(
    what: str, value: float | None, kind: str, digits: int, at: float | None, say: Wording
) -> dict[str, Any]:
    temperature = "" if at is None else say.plain_quantity(at, "temperature")
    return {
        "what": say(f"catalogue.{what}", temperature=temperature),
        "value": say.value(value, kind, digits),
        "unit": say.unit(kind),
    }


def _viscosity_rows(points: Any) -> Rows:
    return [{"temperature": at, "viscosity": nu * MM2_S, "density": rho * G_CM3} for at, nu, rho in points]


def limit_tables(limits: Limits, say: Wording) -> list[CatalogueTable]:
    """Return every limit with its origin: published, choice of this project, or set by the workshop."""
    rows: Rows = []
    for name, steps in limits.rules.items():
        for level, limit in steps.levels:
            growth, added = steps.growth.get(level, (None, None))
            at_least = steps.at_least.get(level)
            rows.append(
                {
                    "rule": say(f"rules.{name}"),
                    "from_here": say.signed(level),
                    "limit": rule_value(limit, name, say) if steps.has_limit(level) else None,
                    "at_least": None if at_least is None else at_least * UM,
                    "growth": None if growth is None else growth * PERCENT,
                    "added_points": added * PERCENT if added else None,
                    "limit_is": say.get("origins", steps.origin),
                    "source": steps.source,
                }
            )
    return [CatalogueTable("limits", _LIMITS, rows)]


TABLES: MappingProxyType[str, Callable[[Any, Wording], list[CatalogueTable]]] = MappingProxyType(
    {"controller": controller_tables, "fluid": fluid_tables, "limits": limit_tables}
)
