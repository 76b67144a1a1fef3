"""Show catalogue entries as tables in a reader's language and units."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from operator import itemgetter
from types import MappingProxyType
from typing import Any

from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Level, Limits, RuleKind, Steps
from atleak.catalogue.repairs import Repair
from atleak.views.circuit_rows import MILLIAMPERE, circuit_tables, gears_words
from atleak.views.evidence_rows import evidence_table
from atleak.views.land_names import land_number
from atleak.views.repair_options import repair_name
from atleak.views.sentences import rule_value
from atleak.views.table import Column, Table, columns, span
from atleak.wording import Wording, isolated
from atleak.workshop_units import G_CM3, KPA, MM, MM2_S, PERCENT, RPM, UM

FOLDERS = MappingProxyType({"controller": "controllers", "fluid": "fluids", "limits": "limits"})
_MM3 = 1e9  # from m³


def representative(entry: Controller | Fluid, say: Wording) -> str:
    """Say which values of an entry are representative: as its file words it, where that is no shipped one."""
    values = entry.representative
    return say.name(values) if isinstance(values, str) else _listed("value_names", values, say)


def _listed(texts: str, names: Iterable[str], say: Wording) -> str:
    return ", ".join(say.get(texts, each) for each in names)


def controller_tables(controller: Controller, say: Wording) -> list[Table]:
    """Return the tables of operating points, circuits, lands, gaps, pump and complaints; none without a row."""
    component = Column("component", of=lambda each: _component(each.component, controller, say))
    tables = [
        evidence_table(controller, say),
        _points(controller, say),
        *circuit_tables(controller, say),
        _lands(controller, component, say),
        _repairs(controller, component, say),
        _gaps(controller, component, say),
        _pump(controller, say),
        _complaints(controller, say),
    ]
    return [table for table in tables if table.rows]


def _points(controller: Controller, say: Wording) -> Table:
    shown = columns(
        Column("condition", of=say.condition),
        Column("temperature", "temperature"),
        Column("engine_speed", "engine_speed", times=RPM),
        Column("gear", digits=0),
        Column("main_pressure", "pressure", times=KPA),
        Column("converter_pressure", "pressure", times=KPA),
        Column("state", of=lambda point: say.get("states", point.state)),
        Column("solenoid_current", digits=0, times=MILLIAMPERE),
        Column("lockup_duty", "percent", 0, times=PERCENT),
        "source",
    )
    return Table("points", shown, controller.operating_points, say)


def _component(name: str, controller: Controller, say: Wording) -> str:
    return f"{name} · {isolated(say.name(controller.components[name]))}"


def _lands(controller: Controller, component: Column, say: Wording) -> Table:
    def materials(land: Land) -> str:
        return " / ".join(say.get("catalogue_materials", each) for each in (land.body_material, land.spool_material))

    shown = columns(
        component,
        Column("land", digits=0),
        Column("planes", of=lambda land: ", ".join(land.planes)),
        Column("nominal_diameter", "length", times=MM),
        Column("contact_length", "length", 2, times=MM),
        Column("mounting", words_of="clearance", of=lambda land: _span_um(land.mounting_ends, say)),
        Column("tolerance", "clearance", of="mounting_tolerance", times=UM),
        Column("known_from", of=lambda land: say(f"catalogue.new_{land.new_origin}")),
        Column("own_limit", "clearance", of="clearance_limit", times=UM),
        Column("built", of=lambda land: _built(land, say)),
        Column("materials", of=materials),
        Column("representative_values", of=lambda land: _listed("parts", land.representative, say) or None),
    )
    return Table("lands", shown, controller.lands, say)


def _built(land: Land, say: Wording) -> str | None:
    built = [say("measuring.end_plug")] if land.part == "end_plug" else []
    built += [say("catalogue.sleeved")] if land.sleeved else []
    built += [say(f"catalogue.sealed_{land.seal}")] if land.seal else []
    return "; ".join(built) or None


def _span_um(ends: Iterable[float], say: Wording) -> str:
    return span((end * UM for end in ends), "clearance", say)


def _repairs(controller: Controller, component: Column, say: Wording) -> Table:
    def price(repair: Repair) -> str | None:
        return None if repair.price is None else f"{say.number(repair.price, 2)} {repair.currency}"

    shown = columns(
        component,
        Column("lands", of=lambda repair: ", ".join(map(str, sorted(repair.lands)))),
        Column("repair", of=lambda repair: repair_name(repair, say)),
        Column("own_id", of="id"),
        Column("repair_kind", of=lambda repair: say(f"catalogue.repair_{repair.kind}")),
        Column("price", of=price),
        Column("hours", digits=1),
        "tool",
        Column("nominal_diameter", "length", times=MM),
        Column(
            "clearance_left",
            words_of="clearance",
            of=lambda repair: _span_um(repair.ends, say) or say("catalogue.as_new_parts"),
        ),
        _known_from(say),
        "source",
    )
    return Table("repairs", shown, controller.repairs, say)


def _known_from(say: Wording) -> Column:
    return Column("known_from", of=lambda each: say(f"evidence.{each.evidence or 'not_stated'}"))


def _gaps(controller: Controller, component: Column, say: Wording) -> Table:
    shown = columns(
        component,
        Column("land", digits=0),
        "section",
        Column("flows_from", of=lambda gap: str(gap.high)),
        Column("flows_to", of=lambda gap: str(gap.low)),
        Column("gears", of=lambda gap: gears_words(gap.gears)),
        Column("ends_in", of=lambda gap: say("flows.sump" if gap.into_sump else "catalogue.another_section")),
        _known_from(say),
    )
    return Table("gaps", shown, controller.gaps, say)


def _pump(controller: Controller, say: Wording) -> Table:
    def slip(pump: Any) -> str | None:
        return None if pump.slip_coefficient is None else say.plain(pump.slip_coefficient, 4)

    shown = columns(
        Column("displacement", "displacement", times=_MM3),
        Column("volumetric_efficiency", digits=3),
        Column("slip_coefficient", of=slip),
        Column("representative_values", of=lambda pump: _listed("value_names", pump.representative, say) or None),
    )
    return Table("pump", shown, [controller.pump], say)


def _complaints(controller: Controller, say: Wording) -> Table:
    points = {point.name: say.condition(point) for point in controller.operating_points}

    def lands(complaint: Any) -> str:
        named = ", ".join(land_number(controller, each, say) for each in complaint.lands)
        return named or say("catalogue.every_land")

    shown = columns(
        Column("own_id", of="id"),
        Column("complaint", of=lambda each: say.name(each.label)),
        Column("shows_at", of=lambda each: "; ".join(points[name] for name in each.conditions)),
        Column("lands", of=lands),
        "source",
    )
    return Table("complaints", shown, controller.complaints, say)


def fluid_tables(fluid: Fluid, say: Wording) -> list[Table]:
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
    viscosities = (
        Column("temperature", "temperature", of=itemgetter(0)),
        Column("viscosity", "viscosity", 2, of=itemgetter(1), times=MM2_S),
        Column("density", "density", 4, of=itemgetter(2), times=G_CM3),
    )
    tables = [
        Table("data_sheet", columns("what", "value", "unit"), sheet, say),
        Table("d341", viscosities, computed, say),
        Table("tabulated", viscosities, fluid.table, say),
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


def limit_tables(limits: Limits, say: Wording) -> list[Table]:
    """Return every limit with its origin: published, choice of this project, or set by the workshop."""

    def limit(rule: tuple[RuleKind, Steps, Level, float]) -> str | None:
        name, steps, level, value = rule
        return rule_value(value, name, say) if steps.has_limit(level) else None

    shown = (
        Column("rule", of=lambda rule: say(f"rules.{rule[0]}")),
        Column("from_here", of=lambda rule: say.signed(rule[2])),
        Column("limit", of=limit),
        Column("at_least", "clearance", of=lambda rule: rule[1].at_least.get(rule[2]), times=UM),
        Column("growth", "percent", 0, of=lambda rule: rule[1].growth.get(rule[2], (None, None))[0], times=PERCENT),
        Column(
            "added_points",
            "percent",
            1,
            of=lambda rule: rule[1].growth.get(rule[2], (None, None))[1] or None,
            times=PERCENT,
        ),
        Column("limit_is", of=lambda rule: say.get("origins", rule[1].origin)),
        Column("source", of=lambda rule: rule[1].source),
    )
    rules = [(name, steps, *level) for name, steps in limits.rules.items() for level in steps.levels]
    return [Table("limits", shown, rules, say)]


TABLES: MappingProxyType[str, Callable[[Any, Wording], list[Table]]] = MappingProxyType(
    {"controller": controller_tables, "fluid": fluid_tables, "limits": limit_tables}
)
