"""Show catalogue entries as tables for people: rows with the unit in the heading."""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.views.circuit_rows import MILLIAMPERE, circuit_tables
from atleak.views.evidence_rows import evidence_rows
from atleak.wording import value_names
from atleak.workshop_units import G_CM3, KPA, MM, MM2_S, PERCENT, RPM, UM

Tables = dict[str, list[dict[str, Any]]]
FOLDERS = MappingProxyType({"controller": "controllers", "fluid": "fluids", "limits": "limits"})


def representative(entry: Controller | Fluid) -> str:
    """Return which values of an entry are representative, as text."""
    values = entry.representative
    return values if isinstance(values, str) else ", ".join(values)


def controller_tables(controller: Controller) -> Tables:
    """Return the tables of operating points, circuits, lands, gaps, pump and complaints; none without a row."""
    labels = {point.name: point.label for point in controller.operating_points}
    tables: Tables = {
        "What the values are known from": evidence_rows(controller),
        "Operating points": [
            {
                "name": point.label,
                "temperature [°C]": point.temperature,
                "engine [rpm]": point.engine_speed * RPM,
                "gear": point.gear,
                "p_g [kPa]": point.main_pressure * KPA,
                "p_k [kPa]": point.converter_pressure * KPA,
                "state": point.state,
                "solenoid [mA]": None if point.solenoid_current is None else point.solenoid_current * MILLIAMPERE,
                "lock-up [% duty]": None if point.lockup_duty is None else point.lockup_duty * PERCENT,
                "source": point.source,
            }
            for point in controller.operating_points
        ],
        **circuit_tables(controller),
        "Lands": [
            {
                "component": f"{land.component} · {controller.components[land.component]}",
                "land": land.land,
                "planes": ", ".join(land.planes),
                "nominal diameter [mm]": land.nominal_diameter * MM,
                "contact length [mm]": land.contact_length * MM,
                "mounting clearance [µm]": "–".join(f"{end * UM:.1f}" for end in land.mounting_ends),
                "tolerance ± [µm]": None if land.mounting_tolerance is None else land.mounting_tolerance * UM,
                "known from": land.new_origin.label,
                "own limit [µm]": None if land.clearance_limit is None else land.clearance_limit * UM,
                "is": "; ".join(land.built),
                "body / spool": f"{land.body_material} / {land.spool_material}",
                "representative": value_names(land.representative),
            }
            for land in controller.lands
        ],
        "Repairs": [
            {
                "component": f"{repair.component} · {controller.components[repair.component]}",
                "lands": ", ".join(map(str, sorted(repair.lands))),
                "repair": repair.label,
                "id": repair.id,
                "kind": repair.kind_name,
                "price": None if repair.price is None else f"{repair.price:.2f} {repair.currency}",
                "hours": repair.hours,
                "tool": repair.tool or "",
                "nominal diameter [mm]": None if repair.nominal_diameter is None else repair.nominal_diameter * MM,
                "clearance left [µm]": "–".join(f"{end * UM:.1f}" for end in repair.ends) or "as new parts",
                "known from": repair.evidence or "not stated",
                "source": repair.source,
            }
            for repair in controller.repairs
        ],
        "Gaps": [
            {
                "component": f"{gap.component} · {controller.components[gap.component]}",
                "land": gap.land,
                "section": gap.section,
                "from": str(gap.high),
                "to": str(gap.low),
                "gears": ", ".join(map(str, sorted(gap.gears))),
                "ends in": "sump" if gap.into_sump else "another section",
                "is": gap.evidence or "not stated",
            }
            for gap in controller.gaps
        ],
        "Pump": [
            {
                "displacement [mm³/rev]": controller.pump.displacement * 1e9,
                "volumetric efficiency": controller.pump.volumetric_efficiency,
                "slip coefficient": controller.pump.slip_coefficient,
                "representative": ", ".join(controller.pump.representative),
            }
        ],
        "Complaints": [
            {
                "id": complaint.id,
                "complaint": complaint.label,
                "shows at": "; ".join(labels[name] for name in complaint.conditions),
                "lands": ", ".join(f"{component}/{land}" for component, land in complaint.lands) or "every one",
                "source": complaint.source,
            }
            for complaint in controller.complaints
        ],
    }
    return {title: rows for title, rows in tables.items() if rows}


def fluid_tables(fluid: Fluid) -> Tables:
    """Return data-sheet points, density, and the viscosity that follows from them where it can be trusted."""
    low, high = fluid.span()
    between = [temperature for temperature in range(-20, 141, 20) if low <= temperature <= high]
    tables: Tables = {
        "Data sheet": [
            *({"what": f"viscosity at {at:g} °C", "value": nu * MM2_S, "unit": "mm²/s"} for at, nu in fluid.points),
            {"what": f"density at {fluid.density_at[0]:g} °C", "value": fluid.density_at[1] * G_CM3, "unit": "g/cm³"},
            {"what": "pour point", "value": fluid.pour_point, "unit": "°C"},
        ],
        "ASTM D341 through the data sheet": [
            {
                "temperature [°C]": temperature,
                "viscosity [mm²/s]": fluid.kinematic_viscosity(float(temperature)) * MM2_S,
                "density [g/cm³]": fluid.density(float(temperature)) * G_CM3,
            }
            for temperature in between
        ],
    }
    if fluid.table:
        tables["Tabulated by the source"] = [
            {"temperature [°C]": at, "viscosity [mm²/s]": nu * MM2_S, "density [g/cm³]": rho * G_CM3}
            for at, nu, rho in fluid.table
        ]
    return tables


def limit_tables(limits: Limits) -> Tables:
    """Return every limit with its origin: published, choice of this project, or set by the workshop."""
    rows = []
    for name, steps in limits.rules.items():
        for level, limit in steps.levels:
            growth, added = steps.growth.get(level, (None, None))
            at_least = steps.at_least.get(level)
            rows.append(
                {
                    "rule": name.replace("_", " "),
                    "from here": str(level),
                    "limit": limit * name.factor if steps.has_limit(level) else None,
                    "unit": name.unit if steps.has_limit(level) else None,
                    "at least [µm]": None if at_least is None else at_least * UM,
                    "growth over new [%]": None if growth is None else growth * PERCENT,
                    "added [points of pump flow]": added * PERCENT if added else None,
                    "origin": str(steps.origin),
                    "source": steps.source,
                }
            )
    return {"Limits": rows}


TABLES: MappingProxyType[str, Callable[[Any], Tables]] = MappingProxyType(
    {"controller": controller_tables, "fluid": fluid_tables, "limits": limit_tables}
)
