"""Show catalogue entries as tables in a reader's language and units: a valve body as its sheets declare it.

What its values are known from stands beside, and what a workshop must still measure or look up.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from operator import itemgetter
from types import MappingProxyType
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.catalogue.entries import Evidence
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.known_values import KnownValue, counted_values, known_values
from atleak.catalogue.limits import Level, Limits, RuleKind, Steps
from atleak.catalogue.workbook.cells import ChoiceCell, Number, Units, YesNo
from atleak.catalogue.workbook.shapes import SheetColumn as Declared
from atleak.catalogue.workbook.sheets import SHEETS
from atleak.common.units import G_CM3, MM2_S, PERCENT, UM
from atleak.common.wording import Wording
from atleak.report.tables.sentences import rule_value
from atleak.report.tables.table import Column, Table, columns

FOLDERS = MappingProxyType({"controller": "controllers", "fluid": "fluids", "limits": "limits"})
_OF_DEFAULTS = ("contact_length_mm", "mounting_clearance_um", "body", "spool")  # for lands that state none
_QUANTITIES = MappingProxyType(  # that people read in units of their own, by the unit of a file's key
    {
        "mm": "length",
        "µm": "clearance",
        "kPa": "pressure",
        "°C": "temperature",
        "rpm": "engine_speed",
        "mm³": "displacement",
        "dm³/min": "flow",
        "g/cm³": "density",
        "mm²/s": "viscosity",
        "%": "percent",
    }
)


def evidence_counts(controller: Controller) -> dict[str, int]:
    """Count the values by what they are known from; ``not_stated`` are those of which the file says nothing."""
    counts = counted_values(_values(controller))
    return {evidence or "not_stated": count for evidence, count in counts.items()}


def evidence_table(controller: Controller, say: Wording) -> Table:
    """Return a row for each kind of value: how many of it are known from what."""
    values = _values(controller)
    rows = []
    for kind in dict.fromkeys(each[:2] for each in values):
        counts = counted_values([each for each in values if each[:2] == kind])
        known = {each.value: counts[each] for each in Evidence}
        rows.append({"values": _kind_words(kind, say), **known, "not_stated": counts[None]})
    counted_columns = (Column(name, digits=0) for name in (*Evidence, "not_stated"))
    return Table("evidence", columns("values", *counted_columns), rows, say)


def open_values(controller: Controller, say: Wording) -> list[str]:
    """Say which kinds of values are representative and how many of each, the most numerous first."""
    return [
        say("catalogue.open_values", kind=_kind_words(kind, say), count=count)
        for kind, count in _open_kinds(controller).most_common()
    ]


def _kind_words(kind: tuple[str, str], say: Wording) -> str:
    return say(f"value_kinds.{'_'.join(filter(None, kind))}")


def _open_kinds(controller: Controller) -> Counter[tuple[str, str]]:
    open_ones = [each for each in _values(controller) if each.evidence is Evidence.REPRESENTATIVE]
    return Counter(each[:2] for each in open_ones)


def _values(controller: Controller) -> tuple[KnownValue, ...]:
    return () if controller.entry is None else known_values(controller.entry)


_ABOVE = ("name", "source", "date", "note", "representative")  # keys of the head that stand above the tables


def representative(entry: Controller | Fluid, say: Wording) -> str:
    """Say which values of an entry are representative: as its file words it, where that is no shipped one."""
    values = entry.representative
    return say.name(values) if isinstance(values, str) else ", ".join(say.get("value_names", each) for each in values)


def controller_tables(controller: Controller, say: Wording) -> list[Table]:
    """Return what its values are known from, and a table for each sheet that describes it; none without a row."""
    tables, data = [evidence_table(controller, say)], _described(controller, say)
    for sheet in SHEETS:
        rows, title = list(sheet.rows(data)), _word(sheet.name, say)
        if sheet.is_form:
            known = {column.how_known: column for column in sheet.columns if column.how_known}
            lines = [
                (each, rows[0][each.heading], rows[0].get(known[each.key].heading) if each.key in known else None)
                for each in sheet.columns
                if each.heading in rows[0] and not each.how_known and each.key not in _ABOVE
            ]
            shown = (
                Column("what", of=lambda line: _word(line[0].heading, say)),
                Column("value", of=lambda line: _with_unit(line[0], line[1], say)),
                Column("known_from", of=lambda line: line[2] and _word(line[2], say)),
            )
            tables.append(Table(sheet.name, shown, lines, say, title))
        else:
            tables.append(
                Table(sheet.name, tuple(_column(each, say) for each in sheet.columns_for(data)), rows, say, title)
            )
    return [table.filled for table in tables if table.rows]


def _described(controller: Controller, say: Wording) -> dict[str, Any]:
    """Return the tables of a valve body's file, with the defaults of lands and the gaps that nobody described."""
    data = {} if controller.entry is None else controller.entry.model_dump(by_alias=True, exclude_unset=True)
    defaults = {key: value for key, value in data.get("defaults", {}).items() if key in _OF_DEFAULTS}
    for component in data.get("components", ()):
        component["lands"] = [{**defaults, **land} for land in component.get("lands", ())]
    for table, point in zip(data.get("operating_points", ()), controller.operating_points, strict=True):
        table["label"] = say.condition(point)
    taken = {"from": "p_g", "to": "drain", "gears": list(controller.gears)}
    undescribed = [land.key for land in controller.lands if land.key in controller.gaps_not_described]
    gaps = [{"component": component, "land": land, **taken} for component, land in undescribed]
    return {**data, "gaps": [*data.get("gaps", ()), *gaps]}


def _word(text: str, say: Wording) -> str:
    """Return a word of the form; how a value is known in the words of every page: *assumed* for *representative*."""
    return say(f"evidence.{text}") if text in set(Evidence) else say.name(text, "form")


def _quantity(declared: Declared) -> str | None:
    return _QUANTITIES.get(declared.kind.measure.metric) if isinstance(declared.kind, Number) else None


def _column(declared: Declared, say: Wording) -> Column:
    """Return the column of a table as its sheet declares it."""
    quantity, heading = _quantity(declared), _word(declared.heading, say)
    if quantity is not None:
        return Column(declared.heading, quantity, words=heading, of=lambda row: row.get(declared.heading))
    unit = say.get("typed_units", declared.kind.label(Units()))
    words = f"{heading} [{unit}]" if unit else heading
    return Column(declared.heading, words=words, of=lambda row: _text(declared, row.get(declared.heading), say))


def _text(declared: Declared, value: Any, say: Wording) -> str | None:
    """Return a value as people read it, without its unit; None where there is none."""
    if value is None:
        return None
    cell = declared.kind.cell(value, Units())
    if not isinstance(cell, str):
        return say.plain(cell)
    return (
        _word(cell, say)
        if isinstance(declared.kind, ChoiceCell | YesNo)
        else say.get("catalogue_materials", say.name(cell))
    )


def _with_unit(declared: Declared, value: Any, say: Wording) -> str:
    quantity = _quantity(declared)
    if quantity is not None:
        return say.plain_quantity(value, quantity)
    return f"{_text(declared, value, say)} {declared.kind.label(Units())}".strip()


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
        Column("source", of=lambda rule: say.name(rule[1].source)),
    )
    rules = [(name, steps, *level) for name, steps in limits.rules.items() for level in steps.levels]
    return [Table("limits", shown, rules, say)]


TABLES: MappingProxyType[str, Callable[[Any, Wording], list[Table]]] = MappingProxyType(
    {"controller": controller_tables, "fluid": fluid_tables, "limits": limit_tables}
)
