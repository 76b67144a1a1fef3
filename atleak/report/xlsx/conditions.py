"""Write the sheet of conditions: temperature, pressures, fluid, pump and totals, each cell a name that others use."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.circuits import Consumer
from atleak.catalogue.limits import RuleKind
from atleak.catalogue.pump import Pump
from atleak.catalogue.workbook.cells import gear_shown
from atleak.common.sentences import Name, Sentence
from atleak.common.units import DM3_MIN, G_CM3, KPA, MM2_S, MM3_S, PERCENT, RPM, Quantity, UnitOf
from atleak.common.verdicts import BANDS
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.uncertainty import TotalUncertainty
from atleak.engine.projection import LeakFlow, Projection
from atleak.report.tables.names import spools_taken
from atleak.report.tables.sentences import counted_in_speed, fluid_in_state
from atleak.report.xlsx import live_sheet as names
from atleak.report.xlsx.book import ReportBook, cell
from atleak.report.xlsx.constants import ORDERED_BELOW, fluid_formulas
from atleak.report.xlsx.live_sheet import (
    FLOW,
    PRESSURE,
    RANKED,
    TEMPERATURE,
    NamedQuantity,
    SheetCondition,
    band_of_rank,
    drop_between,
    of_leak,
    of_relation,
    of_tips,
    quote,
    share_of,
)
from atleak.report.xlsx.page import SheetPage

if TYPE_CHECKING:
    from atleak.report.xlsx.lands import LiveSheets

CONDITIONS = Sentence("Conditions")
_ROOM = 208  # [characters] of all columns
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
_CONCENTRIC = Sentence("leakage with every spool concentric"), Sentence("share with every spool concentric")
_TOUCHING = Sentence("leakage with every spool touching its bore"), Sentence("share with every spool touching its bore")
_POSITIONS = {"concentric": _CONCENTRIC, "touching": _TOUCHING}


def _pressure(
    name: str, label: Sentence, value: float | None, formula: str | None = None, *, fixed: bool = False
) -> NamedQuantity:
    return NamedQuantity(name, label, PRESSURE, "kpa", None if value is None else value * KPA, formula, fixed)


def _flow(
    name: str, label: Sentence, value: float, formula: str | None = None, *, fixed: bool = False
) -> NamedQuantity:
    return NamedQuantity(name, label, FLOW, "flow", value * DM3_MIN, formula, fixed)


def _share(name: str, label: Sentence, value: float, formula: str) -> NamedQuantity:
    return NamedQuantity(name, label, "%", "share", value * PERCENT, formula)


def _plain(name: str, label: Sentence, value: Any, formula: str | None, kind: str = "plain") -> NamedQuantity:
    return NamedQuantity(name, label, "", kind, value, formula)


class ConditionsSheet:
    """The sheet of conditions of one diagnosis."""

    def __init__(self, live: LiveSheets) -> None:
        self.diagnosis, self.conditions, self.say = live.diagnosis, live.conditions, live.say
        self.gaps, self.rules, self.sheet = live.gaps, live.rules, live.say.sentence(CONDITIONS)

    def write(self, book: ReportBook, sheet: Worksheet) -> None:
        """Write every quantity of every condition; the gaps use each by its name."""
        fluid = self.diagnosis.fluid
        many = len(self.conditions)
        label = min(max(_ROOM - 12 - 26 * many, 62), 92)
        widths = [label, 12, *[min(max((_ROOM - 12 - label) // many, 26), 36)] * many]
        page = SheetPage(book, sheet, [*widths, max(_ROOM - sum(widths), 1)])  # room for the notes
        page.headings(0, [Sentence("quantity"), Sentence("unit"), *(at.label for at in self.conditions)])
        for column, at in enumerate(self.conditions, start=2):
            quantities = list(self._condition(at))
            for row, each in enumerate(quantities, start=1):
                page.text(row, 0, each.label)
                book.put(sheet, row, 1, each.unit)
                each.write(book, sheet, row, column, at(each.name))
            end = len(quantities)
        for row, each in enumerate(quantities, start=1):
            if each.name in BAND_ROWS:
                book.colour_words(sheet, (row, 2), (row, 1 + len(self.conditions)), BANDS)
        flows = Sentence("{spools}. {lie}", spools=spools_taken(self.diagnosis.profile), lie=AS_SPOOLS_MAY_LIE)
        gaps = Sentence("The list of gaps is that of the condition's gear: change the gear in atleak, not here.")
        notes: list[tuple[str, str]] = [
            (Sentence("pressures held"), _SOLVED),
            (Sentence("flows"), flows),
            (Sentence("share"), DEMAND),
            (Sentence("engine speed"), covers(self.diagnosis, self.say)),
            (Sentence("viscosity"), self._viscosity_note()),
            (Sentence("gaps"), gaps),
            (Sentence("fluid"), f"{fluid_in_state(self.diagnosis, self.say)}; {self.say.name(fluid.source)}"),
        ]
        for at in self.conditions:
            notes.append(
                (self.say("printed.condition"), f"{at.title}: {self.say.name(at.projection.condition.source)}")
            )
        row = end + 1
        for name, text in notes:
            row = page.across(row, f"{book.words(name)}: {book.words(text)}")
        book.few_pages(sheet, page.lines(row) - page.lines(1), page.lines(1))

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

    def quantities(self, at: SheetCondition) -> dict[str, NamedQuantity]:
        """Return every quantity of one condition by its name."""
        return {each.name: each for each in self._condition(at)}

    def _viscosity_note(self) -> Sentence:
        model = self.diagnosis.profile.viscosity
        ends = [Quantity(end, "temperature") for end in self.diagnosis.fluid.span(model)]
        sentence = {
            "d341": Sentence("ASTM D341 through two points of the data sheet"),
            "regression": Sentence("the source study's regressions, eqs. (29) and (30)"),
            "tabulated": Sentence("read from the fluid's table at this temperature: change it with the temperature"),
        }[model]
        return Sentence(
            "{model}; answers from {low:g} to {high:g} {high.unit}", model=sentence, low=ends[0], high=ends[1]
        )

    def _condition(self, at: SheetCondition) -> Iterable[NamedQuantity]:
        """Return the quantities of one condition, in their order."""
        point = at.projection.condition
        yield NamedQuantity("gear", Sentence("gear"), "", "count", gear_shown(point.gear), fixed=True)
        yield NamedQuantity("T", Sentence("temperature"), TEMPERATURE, "temperature", point.temperature)
        yield NamedQuantity("n", Sentence("engine speed"), UnitOf("engine_speed"), "rpm", point.engine_speed * RPM)
        yield _pressure("p_g", Sentence("main pressure p_g, required"), point.main_pressure)
        for section, label in _SET_BY_RELATIONS:
            relation = self.diagnosis.controller.relations[section]
            text = f"{at('p_g')}*{of_relation(section, 'ratio')}+{of_relation(section, 'offset')}"
            if relation.limit is not None:
                text = f"MIN({text},{of_relation(section, 'limit')})"
            yield _pressure(section, label, at.projection.pressures[section], text)
        yield _pressure("p_k", Sentence("converter pressure p_k"), point.converter_pressure)
        yield from self._held(at)
        yield from self._fluid(at)
        yield from self._pump(at)
        yield from self._beside_lands(at)
        yield from self._totals(at)
        yield from self._reserve(at)

    def _held(self, at: SheetCondition) -> Iterable[NamedQuantity]:
        """Return the main pressure that holds, which no formula gives, and between which it is permissible."""
        permissible, held = at.projection.permissible, at.projection.main_pressure_held
        low, high = self._interval(at, lambda total: total.main_pressure_interval)
        new = Sentence("main pressure that the same unit new holds, as issued")
        yield _pressure("p_g_held", Sentence("main pressure held, as issued"), held, fixed=True)
        yield _pressure("p_g_held_low", Sentence("low, as issued"), low, fixed=True)
        yield _pressure("p_g_held_high", Sentence("high, as issued"), high, fixed=True)
        yield _pressure("p_g_held_new", new, at.new.main_pressure_held, fixed=True)
        for end, label in _PERMISSIBLE:
            yield _pressure(f"permissible_{end}", label, None if permissible is None else getattr(permissible, end))

    def _interval(
        self, at: SheetCondition, interval: Callable[[TotalUncertainty], tuple[float, float]]
    ) -> tuple[float | None, float | None]:
        uncertainty = self.diagnosis.uncertainty
        total = uncertainty.total(at.projection.condition.name) if uncertainty else None
        return (None, None) if total is None else interval(total)

    def _fluid(self, at: SheetCondition) -> Iterable[NamedQuantity]:
        fluid, model = self.diagnosis.fluid, self.diagnosis.profile.viscosity
        temperature = at.projection.condition.temperature
        viscosity = fluid.kinematic_viscosity(temperature, model) * MM2_S
        density = fluid.density(temperature, model) * G_CM3
        of_viscosity, of_density = fluid_formulas(model, at("T"))
        yield NamedQuantity("nu", Sentence("kinematic viscosity ν"), UnitOf("viscosity"), "nu", viscosity, of_viscosity)
        yield NamedQuantity("rho", Sentence("density ρ"), UnitOf("density"), "rho", density, of_density)

    def _pump(self, at: SheetCondition) -> Iterable[NamedQuantity]:
        engine, projection = self.diagnosis.model, at.projection
        pump = engine.controller.pump
        yield NamedQuantity(
            "q_p", Sentence("pump displacement"), UnitOf("displacement_per_turn"), "mm3", pump.displacement * MM3_S
        )
        if engine.uses_slip:
            yield from self._slip(at, "", pump, projection.slip)
            if pump.as_new is not None:
                yield from self._slip(at, "_new", pump.as_new, at.new.slip)
        else:
            yield _plain("eta_v", Sentence("volumetric efficiency"), pump.volumetric_efficiency, None)
        supply = f"{self._per_revolution(at)}*{at('n')}"
        yield _flow("supply", Sentence("pump supply"), projection.pump_supply, supply)
        capacity = f"MAX({at('supply')}-{at('slip')},0)" if engine.uses_slip else at("supply")
        yield _flow("capacity", Sentence("pump capacity"), projection.pump_capacity, capacity)

    def _slip(self, at: SheetCondition, end: str, pump: Pump, slip: float) -> Iterable[NamedQuantity]:
        """Return a slip coefficient and the slip that follows from it and from the tips that it leaves out."""
        coefficient, label = _SLIP_NEW if end else _SLIP
        yield _plain(f"C_s{end}", coefficient, pump.slip_coefficient, None, "scientific")
        text = f"{at('q_p')}*{at(f'C_s{end}')}*{at('p_g')}*60/(2*PI()*{at('nu')}*{at('rho')})"
        if pump.gaps.tips is not None and pump.tips:
            over_tips = "".join(
                f"{sign:+g}*{_over_tips(end, number, at)}" for number, (sign, _) in enumerate(pump.tips, start=1)
            )
            text = f"MAX({text}{over_tips},0)"
        yield _flow(f"slip{end}", label, slip, text)

    def _per_revolution(self, at: SheetCondition) -> str:
        """Return the formula of what the pump delivers in one revolution before slip [dm³]."""
        displaced = f"{at('q_p')}*1E-6"
        return displaced if self.diagnosis.model.uses_slip else f"{displaced}*{at('eta_v')}"

    def _beside_lands(self, at: SheetCondition) -> Iterable[NamedQuantity]:
        """Return what leaves the line beside the lands: consumers, leaks of rings and check balls, what is relieved."""
        controller, condition = self.diagnosis.controller, at.projection.condition
        for number, each in enumerate(controller.consumers, start=1):
            label = Sentence("consumer: {name}", name=Name(each.name))
            if each.after_line:
                label = Sentence("{consumer}, behind the line's regulator", consumer=label)
            yield _flow(f"consumer_{number}", label, each.at(condition))
            if (stated_at := self._stated_at(each)) is not None:
                label = Sentence("{consumer}: main pressure at which it takes that", consumer=label)
                yield _pressure(f"consumer_{number}_at", label, stated_at)
        consumed = self._consumers(at)
        label = Sentence("consumers") if consumed else Sentence("consumers (the valve body's file states none)")
        yield _flow("consumers", label, at.projection.consumers, consumed or "0")
        for number, leak in enumerate(controller.leaks, start=1):
            named = Sentence("leak: {name}", name=Name(leak.name))
            for prefix, label, name_of, of in (
                ("", named, at.pressure, at.projection),
                ("new_", Sentence("{leak} of the same unit new", leak=named), at.new_pressure, at.new),
            ):
                flow = next((each for each in of.leaks if each.leak is leak), None)
                text = "0" if flow is None else _leak_formula(number, flow, at, name_of)
                yield _flow(f"{prefix}leak_{number}", label, 0.0 if flow is None else flow.flow, text)
        if controller.circuits:
            relieved = Sentence("relieved to the sump by circuits, as issued")
            yield _flow("relieved", relieved, at.projection.relieved, fixed=True)
            relieved = Sentence("relieved to the sump by circuits of the same unit new, as issued")
            yield _flow("new_relieved", relieved, at.new.relieved, fixed=True)

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

    def _totals(self, at: SheetCondition) -> Iterable[NamedQuantity]:
        now, new, rule = at.projection, at.new, self.diagnosis.total_rule(at.projection)
        spools = spools_taken(self.diagnosis.profile)
        leakage = Sentence("leakage drawn from the pump, {spools}", spools=spools)
        yield _flow("leakage", leakage, now.leakage, self._with_others(at, self.gaps.sum_of("q", at), now))
        leakage = Sentence(
            "leakage of the same unit new, its pairs as wide as they may have been, {spools}", spools=spools
        )
        drawn_new = self._with_others(at, self.gaps.sum_of("new_q", at), new, "new_")
        yield _flow("leakage_new", leakage, new.leakage, drawn_new)
        growth = f"({at('leakage')}/{at('leakage_new')}-1)*100"
        growth = f'IF({at("capacity")}*{at("leakage_new")}>0,{growth},"{NO_GROWTH}")'
        grown = NO_GROWTH if rule.growth is None else rule.growth * PERCENT
        yield NamedQuantity("growth", Sentence("growth over that new unit"), "%", "percent", grown, growth)
        share, share_new = (share_of(at(name), at("capacity")) for name in ("leakage", "leakage_new"))
        yield _share("share", Sentence("share of pump capacity"), now.share, share)
        yield _share("share_new", Sentence("share of that new unit"), new.share, share_new)
        yield from self._positions(at)
        yield NamedQuantity("n_min", SPEED, UnitOf("engine_speed"), "rpm", now.minimum_speed * RPM, self._covers(at))
        limits, rank = self.rules.limits_and_rank(rule)
        for level, limit in rule.steps.levels:
            label = Sentence("{level} from a share of", level=self.say.level(level))
            yield _share(f"from_{level}", label, limit, limits[level])
        reached = self.diagnosis.band(now)
        not_measured = self.say.sentence(NOT_MEASURED)
        band = quote(not_measured) if reached is None else band_of_rank(rank, self.say)
        said = not_measured if reached is None else self.say.level(reached)
        yield _plain("band", Sentence("band of the total share"), said, band)
        order = f"{rank}+MIN({at('share')},{names.LARGEST_SHARE})*1E-6"
        worst = RANKED.index(rule.verdict) + 1 + min(now.share * PERCENT, ORDERED_BELOW) * 1e-6
        label = Sentence("order of the totals, the worst largest: rank of the band, then the share")
        yield _plain("order", label, worst, order)

    def _positions(self, at: SheetCondition) -> Iterable[NamedQuantity]:
        """Return the leakages and shares between which the total may lie as the spools do."""
        now = at.projection
        for (key, labels), flow in zip(_POSITIONS.items(), (now.concentric_leakage, now.touching_leakage), strict=True):
            name, leakage = f"leakage_{key}", self._with_others(at, self.gaps.sum_of(f"q_{key}", at), now)
            yield _flow(name, labels[0], flow, leakage)
            yield _share(f"share_{key}", labels[1], now.share_of(flow), share_of(at(name), at("capacity")))

    def _covers(self, at: SheetCondition) -> str:
        return f"({self._demand(at, 'leakage')})/({self._per_revolution(at)})"

    def _demand(self, at: SheetCondition, leakage: str, slip_name: str = "slip") -> str:
        """Return the formula of all that leaves the pump, its own slip included."""
        slip = [at(slip_name)] if self.diagnosis.model.uses_slip else []
        return "+".join([at(leakage), *slip, at("consumers")])

    def _reserve(self, at: SheetCondition) -> Iterable[NamedQuantity]:
        """Return the pump's reserve at the required main pressure, as measured and new, and who goes short."""
        now, rule = at.projection, self.diagnosis.pressure_rule(at.projection, RuleKind.RESERVE)
        first, behind = (self._consumers(at, after_line=after_line) for after_line in (False, True))
        left = f"{at('capacity')}-{at('leakage')}" + (f"-({first})" if first else "")
        starved = f"MAX({behind}-MAX({left},0),0)" if behind else "0"
        label = Sentence("by which consumers behind the line's regulator go short")
        yield _flow("starved", label, now.starved, starved)
        new_slip = "slip" if self.diagnosis.controller.pump.as_new is None else "slip_new"
        label = Sentence("reserve of the pump: supply / (leakage + slip + consumers)")
        yield _plain("reserve", label, now.reserve, self._supplied(at, "leakage", "slip"), "reserve")
        text = self._supplied(at, "leakage_new", new_slip)
        yield _plain("reserve_new", Sentence("reserve of the same unit new"), at.new.reserve, text, "reserve")
        low, high = self._interval(at, lambda total: total.reserve_interval)
        yield NamedQuantity("reserve_low", Sentence("reserve, low as issued"), "", "reserve", low, fixed=True)
        yield NamedQuantity("reserve_high", Sentence("reserve, high as issued"), "", "reserve", high, fixed=True)
        if rule is not None:
            limits, rank = self.rules.limits_and_rank(rule)
            for level, limit in rule.steps.levels:
                label = Sentence("{level} under a reserve of", level=self.say.level(level))
                yield _plain(f"reserve_{level}", label, limit, limits[level], "reserve")
            band = band_of_rank(rank, self.say)
            yield _plain("reserve_band", Sentence("band of the reserve"), self.say.level(rule.level), band)

    def _supplied(self, at: SheetCondition, leakage: str, slip: str) -> str:
        """Return the formula of how many times the pump supplies what leaves it."""
        demand = self._demand(at, leakage, slip)
        return f"IF({demand}>0,{at('supply')}/({demand}),{names.NOTHING_DELIVERED})"


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
