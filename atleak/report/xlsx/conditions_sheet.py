"""Write the sheet of conditions: temperature, pressures, fluid, pump and totals, each cell a name that others use."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from xlsxwriter.worksheet import Worksheet

from atleak.diagnosis import Diagnosis
from atleak.equations.fluid import ABSOLUTE_ZERO, ASTM_D341_SHIFT, STUDY_DENSITY, STUDY_VISCOSITY
from atleak.report.xlsx.book import Book, cell, exact, put
from atleak.report.xlsx.gaps_sheet import GapCells
from atleak.report.xlsx.live_cells import CHANGEABLE, Cell, SheetCondition, band_of_rank, share_of, write_cell
from atleak.report.xlsx.rules_sheet import RuleCells
from atleak.verdicts import BANDS
from atleak.views.positions import spools_taken
from atleak.views.sentences import LEFT_OUT_OF_SPEED, fluid_in_state
from atleak.wording import wording
from atleak.workshop_units import DM3_MIN, G_CM3, KPA, MM2_S, MM3_S, PERCENT, RPM

NO_GROWTH = "–"  # where the same unit new draws nothing, or the pump delivers nothing
AS_SPOOLS_MAY_LIE = (
    "Nobody knows where a spool lies; one that touches its sleeve leaks up to 2.5 times as much as a concentric one, "
    "less where the gap is wide."
)
COVERS = f"The pump covers leakage and its own slip from the speed named; {LEFT_OUT_OF_SPEED}."
DEMAND = "A share over 100 % is a demand that the pump cannot meet, not a flow."

NOT_MEASURED = "not measured"  # in place of a band: the totals of a unit that nobody measured are those of a new one


class Quantity(NamedTuple):
    """A row of the sheet: one quantity at one condition."""

    label: str
    unit: str
    name: str  # of the cell, without the condition's prefix
    formula: str | None  # None for an input
    value: Any
    kind: str  # of number

    @property
    def heading(self) -> str:
        """Return the label with its unit."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label


class ConditionsSheet:
    """The sheet of conditions of one diagnosis."""

    def __init__(
        self, diagnosis: Diagnosis, conditions: Sequence[SheetCondition], gaps: GapCells, rules: RuleCells
    ) -> None:
        self.diagnosis, self.conditions, self.gaps, self.rules = diagnosis, conditions, gaps, rules

    def write(self, book: Book, sheet: Worksheet) -> None:
        """Write every quantity of every condition; the gaps use each by its name."""
        fluid = self.diagnosis.fluid
        book.headings(sheet, 0, ["quantity", "unit", *(at.projection.condition.label for at in self.conditions)])
        sheet.set_column(0, 0, 44)
        sheet.set_column(1, 1, 12)
        sheet.set_column(2, 2 + len(self.conditions), 26)
        for column, at in enumerate(self.conditions, start=2):
            quantities = list(self._condition(at))
            for row, each in enumerate(quantities, start=1):
                put(sheet, row, 0, each.label, book.bold)
                put(sheet, row, 1, each.unit)
                look = {"align": "right", **(CHANGEABLE if each.formula is None else {})}
                write_cell(book, sheet, row, column, Cell(each.kind, each.value, each.formula, look))
                book.workbook.define_name(at(each.name), f"={cell(row, column, 'Conditions')}")
            end = len(quantities)
        book.colour_words(sheet, (end, 2), (end, 1 + len(self.conditions)), BANDS)
        notes = [
            ("flows", f"{spools_taken(self.diagnosis.profile)}. {AS_SPOOLS_MAY_LIE}"),
            ("share", DEMAND),
            ("speed", COVERS),
            ("viscosity", self._viscosity_note()),
            ("gaps", "The list of gaps is that of the condition's gear: change the gear in atleak, not here."),
            ("fluid", f"{fluid_in_state(self.diagnosis, wording('en'))}; {fluid.source}"),
            ("profile", self.diagnosis.profile.label),
            *(("condition", f"{at.title}: {at.projection.condition.source}") for at in self.conditions),
        ]
        for row, (label, text) in enumerate(notes, start=end + 2):
            put(sheet, row, 0, label, book.bold)
            put(sheet, row, 1, text)

    def quantities(self, at: SheetCondition) -> dict[str, Quantity]:
        """Return every quantity of one condition by its name."""
        return {each.name: each for each in self._condition(at)}

    def _viscosity_note(self) -> str:
        model = self.diagnosis.profile.viscosity
        low, high = self.diagnosis.fluid.span(model)
        sentence = {
            "d341": "ASTM D341 through two points of the data sheet",
            "regression": "the source study's regressions, eqs. (29) and (30)",
            "tabulated": "read from the fluid's table at this temperature: change it with the temperature",
        }[model]
        return f"{sentence}; answers from {low:g} to {high:g} °C"

    def _condition(self, at: SheetCondition) -> Iterable[Quantity]:
        """Return the quantities of one condition, in their order; the last is the band of the total."""
        projection, condition = at.projection, at.projection.condition
        yield Quantity("gear", "", "gear", str(condition.gear), condition.gear, "count")
        yield Quantity("temperature", "°C", "T", None, condition.temperature, "temperature")
        yield Quantity("engine speed", "1/min", "n", None, condition.engine_speed * RPM, "rpm")
        yield Quantity("main pressure p_g", "kPa", "p_g", None, condition.main_pressure * KPA, "kpa")
        for section, label in (("p_s", "control pressure p_s"), ("p_m", "modulated pressure p_m")):
            relation = self.diagnosis.controller.relations[section]
            text = f"{at('p_g')}*{exact(relation.ratio)}+{exact(relation.offset * KPA)}"
            if relation.limit is not None:
                text = f"MIN({text},{exact(relation.limit * KPA)})"
            yield Quantity(label, "kPa", section, text, projection.pressures[section] * KPA, "kpa")
        yield Quantity("converter pressure p_k", "kPa", "p_k", None, condition.converter_pressure * KPA, "kpa")
        yield from self._fluid(at)
        yield from self._pump(at)
        yield from self._totals(at)

    def _fluid(self, at: SheetCondition) -> Iterable[Quantity]:
        fluid, model = self.diagnosis.fluid, self.diagnosis.profile.viscosity
        temperature = at.projection.condition.temperature
        viscosity = fluid.kinematic_viscosity(temperature, model) * MM2_S
        density = fluid.density(temperature, model) * G_CM3
        texts: tuple[str | None, str | None] = (None, None)
        if model == "d341":
            a, b = fluid.d341
            reference, slope = fluid.density_at, exact(fluid.density_slope * G_CM3)
            texts = (
                f"10^(10^({exact(a)}-{exact(b)}*LOG10({at('T')}+{exact(-ABSOLUTE_ZERO)})))-{ASTM_D341_SHIFT}",
                f"{exact(reference[1] * G_CM3)}+{slope}*({at('T')}-{exact(reference[0])})",
            )
        elif model == "regression":
            (nu, exponent), (rho, per_kelvin) = STUDY_VISCOSITY, STUDY_DENSITY
            texts = (
                f"{exact(nu)}*EXP({exponent}*{at('T')})",
                f"{per_kelvin * G_CM3}*{at('T')}+{exact(rho * G_CM3)}",
            )
        yield Quantity("kinematic viscosity ν", "mm²/s", "nu", texts[0], viscosity, "nu")
        yield Quantity("density ρ", "g/cm³", "rho", texts[1], density, "rho")

    def _pump(self, at: SheetCondition) -> Iterable[Quantity]:
        engine, projection = self.diagnosis.model, at.projection
        pump, condition = engine.controller.pump, projection.condition
        yield Quantity("pump displacement", "mm³/rev", "q_p", None, pump.displacement * MM3_S, "mm3")
        capacity = f"{at('q_p')}*{at('n')}*1E-6"
        if engine.uses_slip:
            yield Quantity("slip coefficient C_s", "", "C_s", None, pump.slip_coefficient, "scientific")
            slip = f"{at('q_p')}*{at('C_s')}*{at('p_g')}*60/(2*PI()*{at('nu')}*{at('rho')})"
            lost = float(engine.pump_slip(condition.main_pressure, condition.temperature))
            yield Quantity("slip", "dm³/min", "slip", slip, lost * DM3_MIN, "flow")
            capacity = f"MAX({capacity}-{at('slip')},0)"
        else:
            yield Quantity("volumetric efficiency", "", "eta_v", None, pump.volumetric_efficiency, "plain")
            capacity = f"{capacity}*{at('eta_v')}"
        yield Quantity("pump capacity", "dm³/min", "capacity", capacity, projection.pump_capacity * DM3_MIN, "flow")

    def _totals(self, at: SheetCondition) -> Iterable[Quantity]:
        now, new, rule = at.projection, at.new, self.diagnosis.total_rule(at.projection)
        of_new = "leakage of the same unit new"
        for name, label, key, each in (
            ("leakage", "leakage drawn from the pump", "q", now),
            ("leakage_new", of_new, "new_q", new),
        ):
            label = f"{label}, {spools_taken(self.diagnosis.profile)}"
            yield Quantity(label, "dm³/min", name, self.gaps.sum_of(key, at) or "0", each.leakage * DM3_MIN, "flow")
        growth = f"({at('leakage')}/{at('leakage_new')}-1)*100"
        growth = f'IF({at("capacity")}*{at("leakage_new")}>0,{growth},"{NO_GROWTH}")'
        grown = NO_GROWTH if rule.growth is None else rule.growth * PERCENT
        yield Quantity("growth over new", "%", "growth", growth, grown, "percent")
        for name, label, flow, each in (
            ("share", "share of pump capacity", "leakage", now),
            ("share_new", "share of the same unit new", "leakage_new", new),
        ):
            yield Quantity(label, "%", name, share_of(at(flow), at("capacity")), each.share * PERCENT, "share")
        yield from self._positions(at)
        yield Quantity(
            "pump covers leakage and slip from", "1/min", "n_min", self._covers(at), now.minimum_speed * RPM, "rpm"
        )
        limits, rank = self.rules.of_total(at)
        for level, limit in rule.steps.levels:
            yield Quantity(f"{level} from a share of", "%", f"from_{level}", limits[level], limit * PERCENT, "share")
        reached = self.diagnosis.band(now)
        band = f'"{NOT_MEASURED}"' if reached is None else band_of_rank(rank)
        yield Quantity("band of the total share", "", "band", band, reached or NOT_MEASURED, "plain")

    def _positions(self, at: SheetCondition) -> Iterable[Quantity]:
        """Return the leakages and shares between which the total may lie as the spools do."""
        now = at.projection
        for key, spools, flow in (
            ("concentric", "every spool concentric", now.concentric_leakage),
            ("touching", "every spool touching its bore", now.touching_leakage),
        ):
            name, leakage = f"leakage_{key}", self.gaps.sum_of(f"q_{key}", at) or "0"
            share = share_of(at(name), at("capacity"))
            yield Quantity(f"leakage with {spools}", "dm³/min", name, leakage, flow * DM3_MIN, "flow")
            yield Quantity(f"share with {spools}", "%", f"share_{key}", share, now.share_of(flow) * PERCENT, "share")

    def _covers(self, at: SheetCondition) -> str:
        if self.diagnosis.model.uses_slip:
            return f"({at('leakage')}+{at('slip')})/({at('q_p')}*1E-6)"
        return f"{at('leakage')}/({at('q_p')}*{at('eta_v')}*1E-6)"
