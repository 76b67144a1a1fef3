"""Write the sheet of conditions: temperature, pressures, fluid, pump and totals, each cell a name that others use."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.circuits import Consumer
from atleak.catalogue.limits import RuleKind
from atleak.catalogue.pump import Pump
from atleak.diagnosis import Diagnosis
from atleak.engine.projection import LeakFlow, Projection
from atleak.report.xlsx.book import Book, cell
from atleak.report.xlsx.constants import ORDERED_BELOW, fluid_formulas
from atleak.report.xlsx.gaps_sheet import GapCells
from atleak.report.xlsx.live_cells import (
    CHANGEABLE,
    RANKED,
    Cell,
    SheetCondition,
    band_of_rank,
    drop_between,
    quote,
    share_of,
    write_cell,
)
from atleak.report.xlsx.names import (
    LARGEST_SHARE,
    NOTHING_DELIVERED,
    of_leak,
    of_relation,
    of_tips,
)
from atleak.report.xlsx.rules_sheet import RuleCells
from atleak.sentence import Name, Sentence
from atleak.uncertainty import TotalUncertainty
from atleak.verdicts import BANDS
from atleak.views.positions import spools_taken
from atleak.views.sentences import counted_in_speed, fluid_in_state
from atleak.wording import Wording
from atleak.workshop_units import DM3_MIN, G_CM3, KPA, MM2_S, MM3_S, PERCENT, RPM

CONDITIONS = Sentence("Conditions")
BAND_ROWS = ("band", "reserve_band")
SPEED = Sentence("pump covers leakage, slip and consumers from")
_SOLVED = Sentence(
    "Solved, not followed by the sheet: a changed reading changes flows at the pressures that stand here."
)
NO_GROWTH = "–"  # where the same unit new draws nothing, or the pump delivers nothing
AS_SPOOLS_MAY_LIE = Sentence(
    "Nobody knows where a spool lies; one that touches its sleeve leaks up to 2.5 times as much as a concentric one, "
    "less where the gap is wide."
)
DEMAND = Sentence("A share over 100 % is a demand that the pump cannot meet, not a flow.")

NOT_MEASURED = Sentence(
    "not measured"
)  # in place of a band: the totals of a unit that nobody measured are those of a new one

_SET_BY_RELATIONS = (("p_s", Sentence("control pressure p_s")), ("p_m", Sentence("modulated pressure p_m")))
_PERMISSIBLE = (
    ("low", Sentence("permissible main pressure, low")),
    ("high", Sentence("permissible main pressure, high")),
)
_SLIP = Sentence("slip coefficient C_s"), Sentence("slip")
_SLIP_NEW = Sentence("slip coefficient C_s of the same pump new"), Sentence("slip of the same pump new")
_POSITIONS = {
    "concentric": (Sentence("leakage with every spool concentric"), Sentence("share with every spool concentric")),
    "touching": (
        Sentence("leakage with every spool touching its bore"),
        Sentence("share with every spool touching its bore"),
    ),
}


class Quantity(NamedTuple):
    """A row of the sheet: one quantity at one condition."""

    label: Sentence
    unit: str
    name: str  # of the cell, without the condition's prefix
    formula: str | None  # None for an input
    value: Any
    kind: str  # of number
    fixed: bool = False  # a result that no formula gives, or what the rows of other sheets rest on; not an input

    @property
    def heading(self) -> Sentence:
        """Return the label with its unit."""
        return Sentence("{label} [{unit}]", label=self.label, unit=self.unit) if self.unit else self.label


class ConditionsSheet:
    """The sheet of conditions of one diagnosis."""

    def __init__(
        self, diagnosis: Diagnosis, conditions: Sequence[SheetCondition], gaps: GapCells, rules: RuleCells, say: Wording
    ) -> None:
        self.diagnosis, self.conditions, self.gaps, self.rules, self.say = diagnosis, conditions, gaps, rules, say
        self.sheet = say.sentence(CONDITIONS)

    def write(self, book: Book, sheet: Worksheet) -> None:
        """Write every quantity of every condition; the gaps use each by its name."""
        fluid = self.diagnosis.fluid
        book.headings(sheet, 0, [Sentence("quantity"), Sentence("unit"), *(at.label for at in self.conditions)])
        sheet.set_column(0, 0, 62)
        sheet.set_column(1, 1, 12)
        sheet.set_column(2, 2 + len(self.conditions), 26)
        for column, at in enumerate(self.conditions, start=2):
            quantities = list(self._condition(at))
            for row, each in enumerate(quantities, start=1):
                book.put(sheet, row, 0, each.label, book.bold)
                book.put(sheet, row, 1, each.unit)
                look = {"align": "right", **(CHANGEABLE if each.formula is None and not each.fixed else {})}
                write_cell(book, sheet, row, column, Cell(each.kind, each.value, each.formula, look))
                book.workbook.define_name(at(each.name), f"={cell(row, column, self.sheet)}")
            end = len(quantities)
        for row, each in enumerate(quantities, start=1):
            if each.name in BAND_ROWS:
                book.colour_words(sheet, (row, 2), (row, 1 + len(self.conditions)), BANDS)
        notes = [
            (Sentence("pressures held"), _SOLVED),
            (
                Sentence("flows"),
                Sentence("{spools}. {lie}", spools=spools_taken(self.diagnosis.profile), lie=AS_SPOOLS_MAY_LIE),
            ),
            (Sentence("share"), DEMAND),
            (Sentence("engine speed"), covers(self.diagnosis, self.say)),
            (Sentence("viscosity"), self._viscosity_note()),
            (
                Sentence("gaps"),
                Sentence("The list of gaps is that of the condition's gear: change the gear in atleak, not here."),
            ),
            (Sentence("fluid"), f"{fluid_in_state(self.diagnosis, self.say)}; {fluid.source}"),
            (Sentence("profile"), self.diagnosis.profile.label),
            *(
                (self.say("printed.condition"), f"{at.title}: {self.say.name(at.projection.condition.source)}")
                for at in self.conditions
            ),
        ]
        for row, (label, text) in enumerate(notes, start=end + 2):
            book.put(sheet, row, 0, label, book.bold)
            book.put(sheet, row, 1, text)

    @property
    def labels(self) -> str:
        """Return the stretch of cells with the names of the conditions."""
        return self._across(0)

    def row_of(self, name: str) -> str:
        """Return the stretch of cells with one quantity at every condition."""
        rows = {[each.name for each in self._condition(at)].index(name) for at in self.conditions}
        assert len(rows) == 1, f"{name} stands in several rows"
        return self._across(1 + rows.pop())

    def _across(self, row: int) -> str:
        ends = cell(row, 2, self.sheet), cell(row, 1 + len(self.conditions))
        return ":".join(ends)

    def quantities(self, at: SheetCondition) -> dict[str, Quantity]:
        """Return every quantity of one condition by its name."""
        return {each.name: each for each in self._condition(at)}

    def _viscosity_note(self) -> Sentence:
        model = self.diagnosis.profile.viscosity
        low, high = self.diagnosis.fluid.span(model)
        sentence = {
            "d341": Sentence("ASTM D341 through two points of the data sheet"),
            "regression": Sentence("the source study's regressions, eqs. (29) and (30)"),
            "tabulated": Sentence("read from the fluid's table at this temperature: change it with the temperature"),
        }[model]
        return Sentence("{model}; answers from {low:g} to {high:g} °C", model=sentence, low=low, high=high)

    def _condition(self, at: SheetCondition) -> Iterable[Quantity]:
        """Return the quantities of one condition, in their order."""
        projection, condition = at.projection, at.projection.condition
        yield Quantity(Sentence("gear"), "", "gear", None, condition.gear, "count", fixed=True)
        yield Quantity(Sentence("temperature"), "°C", "T", None, condition.temperature, "temperature")
        yield Quantity(Sentence("engine speed"), "1/min", "n", None, condition.engine_speed * RPM, "rpm")
        yield Quantity(
            Sentence("main pressure p_g, required"), "kPa", "p_g", None, condition.main_pressure * KPA, "kpa"
        )
        for section, label in _SET_BY_RELATIONS:
            relation = self.diagnosis.controller.relations[section]
            text = f"{at('p_g')}*{of_relation(section, 'ratio')}+{of_relation(section, 'offset')}"
            if relation.limit is not None:
                text = f"MIN({text},{of_relation(section, 'limit')})"
            yield Quantity(label, "kPa", section, text, projection.pressures[section] * KPA, "kpa")
        yield Quantity(
            Sentence("converter pressure p_k"), "kPa", "p_k", None, condition.converter_pressure * KPA, "kpa"
        )
        yield from self._held(at)
        yield from self._fluid(at)
        yield from self._pump(at)
        yield from self._beside_lands(at)
        yield from self._totals(at)
        yield from self._reserve(at)

    def _held(self, at: SheetCondition) -> Iterable[Quantity]:
        """Return the main pressure that holds, which no formula gives, and between which it is permissible."""
        projection, permissible = at.projection, at.projection.permissible
        low, high = self._interval(at, lambda total: total.main_pressure_interval)
        for name, label, value in (
            ("p_g_held", Sentence("main pressure held, as issued"), projection.main_pressure_held),
            ("p_g_held_low", Sentence("low, as issued"), low),
            ("p_g_held_high", Sentence("high, as issued"), high),
            (
                "p_g_held_new",
                Sentence("main pressure that the same unit new holds, as issued"),
                at.new.main_pressure_held,
            ),
        ):
            yield Quantity(label, "kPa", name, None, None if value is None else value * KPA, "kpa", fixed=True)
        for end, label in _PERMISSIBLE:
            value = None if permissible is None else getattr(permissible, end)
            scaled = None if value is None else value * KPA
            yield Quantity(label, "kPa", f"permissible_{end}", None, scaled, "kpa")

    def _interval(
        self, at: SheetCondition, interval: Callable[[TotalUncertainty], tuple[float, float]]
    ) -> tuple[float | None, float | None]:
        uncertainty = self.diagnosis.uncertainty
        total = uncertainty.total(at.projection.condition.name) if uncertainty else None
        return (None, None) if total is None else interval(total)

    def _fluid(self, at: SheetCondition) -> Iterable[Quantity]:
        fluid, model = self.diagnosis.fluid, self.diagnosis.profile.viscosity
        temperature = at.projection.condition.temperature
        viscosity = fluid.kinematic_viscosity(temperature, model) * MM2_S
        density = fluid.density(temperature, model) * G_CM3
        of_viscosity, of_density = fluid_formulas(model, at("T"))
        yield Quantity(Sentence("kinematic viscosity ν"), "mm²/s", "nu", of_viscosity, viscosity, "nu")
        yield Quantity(Sentence("density ρ"), "g/cm³", "rho", of_density, density, "rho")

    def _pump(self, at: SheetCondition) -> Iterable[Quantity]:
        engine, projection = self.diagnosis.model, at.projection
        pump = engine.controller.pump
        yield Quantity(Sentence("pump displacement"), "mm³/rev", "q_p", None, pump.displacement * MM3_S, "mm3")
        if engine.uses_slip:
            yield from self._slip(at, "", pump, projection.slip)
            if pump.as_new is not None:
                yield from self._slip(at, "_new", pump.as_new, at.new.slip)
        else:
            yield Quantity(Sentence("volumetric efficiency"), "", "eta_v", None, pump.volumetric_efficiency, "plain")
        supply = f"{self._per_revolution(at)}*{at('n')}"
        yield Quantity(Sentence("pump supply"), "dm³/min", "supply", supply, projection.pump_supply * DM3_MIN, "flow")
        capacity = f"MAX({at('supply')}-{at('slip')},0)" if engine.uses_slip else at("supply")
        yield Quantity(
            Sentence("pump capacity"), "dm³/min", "capacity", capacity, projection.pump_capacity * DM3_MIN, "flow"
        )

    def _slip(self, at: SheetCondition, end: str, pump: Pump, slip: float) -> Iterable[Quantity]:
        """Return a slip coefficient and the slip that follows from it and from the tips that it leaves out."""
        coefficient, label = _SLIP_NEW if end else _SLIP
        yield Quantity(coefficient, "", f"C_s{end}", None, pump.slip_coefficient, "scientific")
        text = f"{at('q_p')}*{at(f'C_s{end}')}*{at('p_g')}*60/(2*PI()*{at('nu')}*{at('rho')})"
        if pump.gaps.tips is not None and pump.tips:
            over_tips = "".join(
                f"{sign:+g}*{_over_tips(end, number, at)}" for number, (sign, _) in enumerate(pump.tips, start=1)
            )
            text = f"MAX({text}{over_tips},0)"
        yield Quantity(label, "dm³/min", f"slip{end}", text, slip * DM3_MIN, "flow")

    def _per_revolution(self, at: SheetCondition) -> str:
        """Return the formula of what the pump delivers in one revolution before slip [dm³]."""
        displaced = f"{at('q_p')}*1E-6"
        return displaced if self.diagnosis.model.uses_slip else f"{displaced}*{at('eta_v')}"

    def _beside_lands(self, at: SheetCondition) -> Iterable[Quantity]:
        """Return what leaves the line beside the lands: consumers, leaks of rings and check balls, what is relieved."""
        controller, condition = self.diagnosis.controller, at.projection.condition
        for number, each in enumerate(controller.consumers, start=1):
            label = Sentence("consumer: {name}", name=Name(each.name))
            if each.after_line:
                label = Sentence("{consumer}, behind the line's regulator", consumer=label)
            yield Quantity(label, "dm³/min", f"consumer_{number}", None, each.at(condition) * DM3_MIN, "flow")
            if (stated_at := self._stated_at(each)) is not None:
                label = Sentence("{consumer}: main pressure at which it takes that", consumer=label)
                yield Quantity(label, "kPa", f"consumer_{number}_at", None, stated_at * KPA, "kpa")
        consumed = self._consumers(at)
        consumers = at.projection.consumers * DM3_MIN
        label = Sentence("consumers") if consumed else Sentence("consumers (the valve body's file states none)")
        yield Quantity(label, "dm³/min", "consumers", consumed or "0", consumers, "flow")
        for number, leak in enumerate(controller.leaks, start=1):
            named = Sentence("leak: {name}", name=Name(leak.name))
            for prefix, label, name_of, of in (
                ("", named, at.pressure, at.projection),
                ("new_", Sentence("{leak} of the same unit new", leak=named), at.new_pressure, at.new),
            ):
                flow = next((each for each in of.leaks if each.leak is leak), None)
                text = "0" if flow is None else _leak_formula(number, flow, at, name_of)
                leaked = 0.0 if flow is None else flow.flow * DM3_MIN
                yield Quantity(label, "dm³/min", f"{prefix}leak_{number}", text, leaked, "flow")
        if controller.circuits:
            for prefix, label, of in (
                ("", Sentence("relieved to the sump by circuits, as issued"), at.projection),
                ("new_", Sentence("relieved to the sump by circuits of the same unit new, as issued"), at.new),
            ):
                value = of.relieved * DM3_MIN
                yield Quantity(label, "dm³/min", f"{prefix}relieved", None, value, "flow", fixed=True)

    def _consumers(self, at: SheetCondition, *, after_line: bool | None = None) -> str:
        """Return the formula of the sum of the consumers, or of those behind the line or before it; "" of none."""
        terms = []
        for number, each in enumerate(self.diagnosis.controller.consumers, start=1):
            if after_line is None or each.after_line is after_line:
                same = self._stated_at(each) is None
                root = "" if same else f"*SQRT({at('p_g')}/{at(f'consumer_{number}_at')})"
                terms.append(at(f"consumer_{number}") + root)
        return "+".join(terms)

    def _stated_at(self, consumer: Consumer) -> float | None:
        """Return the main pressure [Pa] of a consumer's flow, where that follows it and is not the required one."""
        return consumer.pressure if self.diagnosis.profile.circuits == "on" else None

    def _with_others(self, at: SheetCondition, gaps: str | None, of: Projection, prefix: str = "") -> str:
        """Return the formula of a leakage from that of the gaps: what leaks beside the lands is added."""
        leaks = enumerate(self.diagnosis.controller.leaks, start=1)
        counted = [each.leak for each in of.leaks if each.drawn_from_pump]
        terms = [gaps] if gaps else []
        terms += [at(f"{prefix}leak_{number}") for number, leak in leaks if any(leak is each for each in counted)]
        terms += [at(f"{prefix}relieved")] if self.diagnosis.controller.circuits else []
        return "+".join(terms) or "0"

    def _totals(self, at: SheetCondition) -> Iterable[Quantity]:
        now, new, rule = at.projection, at.new, self.diagnosis.total_rule(at.projection)
        spools = spools_taken(self.diagnosis.profile)
        for name, label, prefix, each in (
            ("leakage", Sentence("leakage drawn from the pump, {spools}", spools=spools), "", now),
            (
                "leakage_new",
                Sentence(
                    "leakage of the same unit new, its pairs as wide as they may have been, {spools}",
                    spools=spools,
                ),
                "new_",
                new,
            ),
        ):
            flow = self._with_others(at, self.gaps.sum_of(f"{prefix}q", at), each, prefix)
            yield Quantity(label, "dm³/min", name, flow, each.leakage * DM3_MIN, "flow")
        growth = f"({at('leakage')}/{at('leakage_new')}-1)*100"
        growth = f'IF({at("capacity")}*{at("leakage_new")}>0,{growth},"{NO_GROWTH}")'
        grown = NO_GROWTH if rule.growth is None else rule.growth * PERCENT
        yield Quantity(
            Sentence("growth over that new unit"),
            "%",
            "growth",
            growth,
            grown,
            "percent",
        )
        for name, label, flow, each in (
            ("share", Sentence("share of pump capacity"), "leakage", now),
            (
                "share_new",
                Sentence("share of that new unit"),
                "leakage_new",
                new,
            ),
        ):
            yield Quantity(label, "%", name, share_of(at(flow), at("capacity")), each.share * PERCENT, "share")
        yield from self._positions(at)
        yield Quantity(SPEED, "1/min", "n_min", self._covers(at), now.minimum_speed * RPM, "rpm")
        limits, rank = self.rules.limits_and_rank(rule)
        for level, limit in rule.steps.levels:
            label = Sentence("{level} from a share of", level=self.say.level(level))
            yield Quantity(label, "%", f"from_{level}", limits[level], limit * PERCENT, "share")
        reached = self.diagnosis.band(now)
        not_measured = self.say.sentence(NOT_MEASURED)
        band = quote(not_measured) if reached is None else band_of_rank(rank, self.say)
        said = not_measured if reached is None else self.say.level(reached)
        yield Quantity(Sentence("band of the total share"), "", "band", band, said, "plain")
        order = f"{rank}+MIN({at('share')},{LARGEST_SHARE})*1E-6"
        worst = RANKED.index(rule.verdict) + 1 + min(now.share * PERCENT, ORDERED_BELOW) * 1e-6
        label = Sentence("order of the totals, the worst largest: rank of the band, then the share")
        yield Quantity(label, "", "order", order, worst, "plain")

    def _positions(self, at: SheetCondition) -> Iterable[Quantity]:
        """Return the leakages and shares between which the total may lie as the spools do."""
        now = at.projection
        for (key, labels), flow in zip(_POSITIONS.items(), (now.concentric_leakage, now.touching_leakage), strict=True):
            name, leakage = f"leakage_{key}", self._with_others(at, self.gaps.sum_of(f"q_{key}", at), now)
            share = share_of(at(name), at("capacity"))
            yield Quantity(labels[0], "dm³/min", name, leakage, flow * DM3_MIN, "flow")
            yield Quantity(labels[1], "%", f"share_{key}", share, now.share_of(flow) * PERCENT, "share")

    def _covers(self, at: SheetCondition) -> str:
        return f"({self._demand(at, 'leakage')})/({self._per_revolution(at)})"

    def _demand(self, at: SheetCondition, leakage: str, slip_name: str = "slip") -> str:
        """Return the formula of all that leaves the pump, its own slip included."""
        slip = [at(slip_name)] if self.diagnosis.model.uses_slip else []
        return "+".join([at(leakage), *slip, at("consumers")])

    def _reserve(self, at: SheetCondition) -> Iterable[Quantity]:
        """Return the pump's reserve at the required main pressure, as measured and new, and who goes short."""
        now, rule = at.projection, self.diagnosis.pressure_rule(at.projection, RuleKind.RESERVE)
        first, behind = (self._consumers(at, after_line=after_line) for after_line in (False, True))
        left = f"{at('capacity')}-{at('leakage')}" + (f"-({first})" if first else "")
        starved = f"MAX({behind}-MAX({left},0),0)" if behind else "0"
        label = Sentence("by which consumers behind the line's regulator go short")
        yield Quantity(label, "dm³/min", "starved", starved, now.starved * DM3_MIN, "flow")
        new_slip = "slip" if self.diagnosis.controller.pump.as_new is None else "slip_new"
        for name, label, leakage, slip, each in (
            (
                "reserve",
                Sentence("reserve of the pump: supply / (leakage + slip + consumers)"),
                "leakage",
                "slip",
                now,
            ),
            ("reserve_new", Sentence("reserve of the same unit new"), "leakage_new", new_slip, at.new),
        ):
            demand = self._demand(at, leakage, slip)
            text = f"IF({demand}>0,{at('supply')}/({demand}),{NOTHING_DELIVERED})"
            yield Quantity(label, "", name, text, each.reserve, "reserve")
        low, high = self._interval(at, lambda total: total.reserve_interval)
        for end, label, value in (
            ("low", Sentence("reserve, low as issued"), low),
            ("high", Sentence("reserve, high as issued"), high),
        ):
            yield Quantity(label, "", f"reserve_{end}", None, value, "reserve", fixed=True)
        if rule is not None:
            limits, rank = self.rules.limits_and_rank(rule)
            for level, limit in rule.steps.levels:
                label = Sentence("{level} under a reserve of", level=self.say.level(level))
                yield Quantity(label, "", f"reserve_{level}", limits[level], limit, "reserve")
            yield Quantity(
                Sentence("band of the reserve"),
                "",
                "reserve_band",
                band_of_rank(rank, self.say),
                self.say.level(rule.level),
                "plain",
            )


def covers(diagnosis: Diagnosis, say: Wording) -> Sentence:
    """Say what the lowest speed of the pump means, and which consumers it counts."""
    counted = counted_in_speed(diagnosis, say)
    return Sentence("The pump covers leakage and its own slip from the speed named; {counted}.", counted=counted)


def _over_tips(end: str, number: int, at: SheetCondition) -> str:
    """Return the formula of what slips over a pump's tips [dm³/min], from their slip without viscosity's share."""
    conductance, bend = (of_tips(end, number, what) for what in ("conductance", "bend"))
    viscous = f"({at('nu')}*{at('rho')})"
    return f"2*{conductance}*{at('p_g')}/{viscous}/(1+SQRT(1+{bend}*{at('p_g')}/{viscous}^2))"


def _leak_formula(number: int, flow: LeakFlow, at: SheetCondition, name_of: Callable[[str], str]) -> str:
    """Return the formula of a leak [dm³/min] from the one point at which it was measured."""
    leak = flow.leak
    drop = drop_between(leak, name_of)
    measured, over = of_leak(number, "flow"), of_leak(number, "drop")
    if leak.viscosity is not None:
        driving = f"({drop})" if flow.leaks_back else f"MAX({drop},0)"
        return f"{measured}*{driving}/{over}*{of_leak(number, 'viscosity')}/({at('nu')}*{at('rho')})"
    size = f"ABS({drop})" if flow.leaks_back else f"MAX({drop},0)"
    sign = f"IF({drop}<0,-1,1)*" if flow.leaks_back else ""
    return f"{sign}{measured}*SQRT({size}/{over}*{of_leak(number, 'density')}/{at('rho')})"
