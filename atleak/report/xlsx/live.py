"""Write the sheets that compute: conditions, lands, gaps and rules, from diameters to verdicts.

A cell that atleak computed holds the formula an auditor would write and, as its cached value, atleak's own number. What
an auditor may change (diameters, contact lengths, conditions, limits) is blue.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import groupby
from typing import Any

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Pressure
from atleak.catalogue.instruments import Part
from atleak.catalogue.limits import ROUNDING, Level, RuleKind
from atleak.diagnosis import Diagnosis, LandDiagnosis
from atleak.engine.leakage import GapLeakage
from atleak.engine.profile import UNKNOWN
from atleak.equations.fluid import ABSOLUTE_ZERO, ASTM_D341_SHIFT, STUDY_DENSITY, STUDY_VISCOSITY
from atleak.equations.gap import ECCENTRIC_GAIN, ENTRY_AND_EXIT_LOSS, MEAN_ECCENTRIC
from atleak.look import DATA_BAR
from atleak.readings import Reading
from atleak.report.xlsx.book import Book, cell, exact, formula, put, span
from atleak.report.xlsx.land_columns import (
    CHANGEABLE,
    RANKED,
    Cell,
    ColumnKey,
    LandRow,
    LandSheet,
    SheetCondition,
    address,
    land_columns,
    share_of,
    sheet_conditions,
    verdict_of_rank,
)
from atleak.rules import LandKey, Rule
from atleak.verdicts import BANDS, FLAGGED, VERDICTS, Band
from atleak.wording import signed
from atleak.workshop_units import DM3_MIN, G_CM3, KPA, MM, MM2_S, MM3_S, PERCENT, RPM, UM

_FIRST_LEVEL = 5  # column of the sheet of rules in which the first level's limit stands
_VERDICT = _FIRST_LEVEL + len(FLAGGED)  # and of the verdict, behind the limits


class LiveSheets:
    """The sheets Conditions, Lands, Gaps and Rules of one diagnosis."""

    def __init__(self, book: Book, diagnosis: Diagnosis, record: dict[str, Any]) -> None:
        self.book, self.diagnosis, self.record = book, diagnosis, record
        self.lands = diagnosis.lands
        self.row_of = {land.key: row for row, land in enumerate(self.lands, start=1)}
        self.conditions = sheet_conditions(diagnosis)
        self.gaps = {at.prefix: self._by_land(at.projection.gaps) for at in self.conditions}
        self.rule_rows = self._rule_rows()
        self.limit_cells: dict[tuple[RuleKind, Level], str] = {}  # their addresses in the sheet of limits
        self.means: dict[tuple[LandKey, Part], str] = {}  # filled in when the readings are written
        self.rise = diagnosis.measured_at.value - REFERENCE_TEMPERATURE if diagnosis.measured_at else 0.0
        self.columns = land_columns(
            LandSheet(
                lands=self.lands,
                records=record["lands"],
                components=diagnosis.controller.components,
                conditions=self.conditions,
                gaps=self.gaps,
                ranks={key: span(*rows, _VERDICT + 1, "Rules") for key, rows in self.rule_rows.items()},
                means=self.means,
                gauges=diagnosis.uncertainty.instruments if diagnosis.uncertainty and self.rise else None,
                rise=self.rise,
            )
        )
        self.column_of = {column.key: number for number, column in enumerate(self.columns)}

    def _by_land(self, gaps: Iterable[GapLeakage]) -> list[GapLeakage]:
        """Return the gaps sorted by land, so that a land's leakage is the sum of neighbouring cells."""
        return sorted(gaps, key=lambda leak: self.row_of[leak.gap.key])

    def land_cell(self, land: LandDiagnosis, key: ColumnKey) -> Cell:
        """Return the content of one of a land's cells."""
        row = self.row_of[land.key]
        row_of_land = LandRow(land, self.record["lands"][row - 1], lambda column: address(row, self.column_of[column]))
        return self.columns[self.column_of[key]].cell(row_of_land)

    def _rule_rows(self) -> dict[tuple[str, int], tuple[int, int]]:
        rows, row = {}, 1
        for land in self.lands:
            if land.rules:
                rows[land.key] = (row, row + len(land.rules) - 1)
                row += len(land.rules)
        return rows

    # --- conditions

    def write_conditions(self, sheet: Worksheet) -> None:
        """Write temperature, pressures, fluid and pump of every condition; the gaps use each by its name."""
        book, fluid, profile = self.book, self.diagnosis.fluid, self.diagnosis.profile
        book.headings(sheet, 0, ["quantity", "unit", *(at.projection.condition.label for at in self.conditions)])
        sheet.set_column(0, 0, 34)
        sheet.set_column(1, 1, 12)
        sheet.set_column(2, 2 + len(self.conditions), 26)
        for column, at in enumerate(self.conditions, start=2):
            rows = list(self._condition(at))
            for row, (label, unit, name, text, value, kind) in enumerate(rows, start=1):
                put(sheet, row, 0, label, book.bold)
                put(sheet, row, 1, unit)
                if text is None:
                    put(sheet, row, column, value, book.form(kind, align="right", **CHANGEABLE))
                else:
                    formula(sheet, row, column, text, value, book.form(kind, align="right"))
                book.workbook.define_name(at(name), f"={cell(row, column, 'Conditions')}")
            end = len(rows)
        book.colour_words(sheet, (end, 2), (end, 1 + len(self.conditions)), BANDS)
        notes = [
            ("viscosity", self._viscosity_note()),
            ("gaps", "The list of gaps is that of the condition's gear: change the gear in atleak, not here."),
            ("fluid", f"{fluid.name}; {fluid.source}"),
            ("profile", profile.label),
            ("condition", *(f"{at.title}: {at.projection.condition.source}" for at in self.conditions)),
        ]
        row = end + 2
        for label, *texts in notes:
            for text in texts:
                put(sheet, row, 0, label, book.bold)
                put(sheet, row, 1, text)
                row += 1

    def _viscosity_note(self) -> str:
        model = self.diagnosis.profile.viscosity
        low, high = self.diagnosis.fluid.span(model)
        sentence = {
            "d341": "ASTM D341 through two points of the data sheet",
            "regression": "the source study's regressions, eqs. (29) and (30)",
            "tabulated": "read from the fluid's table at this temperature: change it with the temperature",
        }[model]
        return f"{sentence}; answers from {low:g} to {high:g} °C"

    def _condition(self, at: SheetCondition) -> Iterable[tuple[str, str, str, str | None, Any, str]]:
        """Return one condition's quantities: label, unit, name, formula (None for an input), value, kind of number."""
        projection, condition = at.projection, at.projection.condition
        yield "gear", "", "gear", None, condition.gear, "count"
        yield "temperature", "°C", "T", None, condition.temperature, "temperature"
        yield "engine speed", "1/min", "n", None, condition.engine_speed * RPM, "rpm"
        yield "main pressure p_g", "kPa", "p_g", None, condition.main_pressure * KPA, "kpa"
        for section, label in (("p_s", "control pressure p_s"), ("p_m", "modulated pressure p_m")):
            relation = self.diagnosis.controller.relations[section]
            text = f"{at('p_g')}*{exact(relation.ratio)}+{exact(relation.offset * KPA)}"
            if relation.limit is not None:
                text = f"MIN({text},{exact(relation.limit * KPA)})"
            yield label, "kPa", section, text, projection.pressures[section] * KPA, "kpa"
        yield "converter pressure p_k", "kPa", "p_k", None, condition.converter_pressure * KPA, "kpa"
        yield from self._fluid(at)
        yield from self._pump(at)

    def _fluid(self, at: SheetCondition) -> Iterable[tuple[str, str, str, str | None, Any, str]]:
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
        yield "kinematic viscosity ν", "mm²/s", "nu", texts[0], viscosity, "nu"
        yield "density ρ", "g/cm³", "rho", texts[1], density, "rho"

    def _pump(self, at: SheetCondition) -> Iterable[tuple[str, str, str, str | None, Any, str]]:
        engine, projection = self.diagnosis.model, at.projection
        pump, condition = engine.controller.pump, projection.condition
        yield "pump displacement", "mm³/rev", "q_p", None, pump.displacement * MM3_S, "mm3"
        displaced = f"{at('q_p')}*{at('n')}*1E-6"
        if engine.uses_slip:
            yield "slip coefficient C_s", "", "C_s", None, pump.slip_coefficient, "scientific"
            slip = f"{at('q_p')}*{at('C_s')}*{at('p_g')}*60/(2*PI()*{at('nu')}*{at('rho')})"
            lost = float(engine.pump_slip(condition.main_pressure, condition.temperature))
            yield "slip", "dm³/min", "slip", slip, lost * DM3_MIN, "flow"
            capacity, lowest = f"MAX({displaced}-{at('slip')},0)", f"({at('leakage')}+{at('slip')})/({at('q_p')}*1E-6)"
        else:
            yield "volumetric efficiency", "", "eta_v", None, pump.volumetric_efficiency, "plain"
            capacity = f"{displaced}*{at('eta_v')}"
            lowest = f"{at('leakage')}/({at('q_p')}*{at('eta_v')}*1E-6)"
        yield "pump capacity", "dm³/min", "capacity", capacity, projection.pump_capacity * DM3_MIN, "flow"
        drawn, flows = self._gap_span(at, 12), self._gap_span(at, 11)
        leakage = f'SUMIF({drawn},"yes",{flows})*6E-5' if projection.gaps else "0"
        yield "leakage drawn from the pump", "dm³/min", "leakage", leakage, projection.leakage * DM3_MIN, "flow"
        share = share_of(at("leakage"), at("capacity"))
        yield "share of pump capacity", "%", "share", share, projection.share * PERCENT, "percent"
        yield "pump covers leakage and slip from", "1/min", "n_min", lowest, projection.minimum_speed * RPM, "rpm"
        band = f'"{Band.GREEN}"'
        steps = self.diagnosis.total_rule(projection).steps
        for level, own in steps.levels:  # rising, so that the highest is asked first
            grown = level in steps.growth
            limit = exact(own * PERCENT) if grown else self.limit_cells[RuleKind.TOTAL_SHARE, level]
            band = f'IF({at("share")}>={limit}*(1-{ROUNDING:E}),"{level}",{band})'
        yield "band of the total share", "", "band", band, self.diagnosis.band(projection), "plain"

    def _gap_span(self, at: SheetCondition, column: int) -> str:
        return span(1, max(len(self.gaps[at.prefix]), 1), column, at.sheet)

    # --- lands

    def write_lands(self, sheet: Worksheet) -> None:
        """Write one row per land: D, d → c_r → c_re → q → share → verdict."""
        book, last = self.book, len(self.lands)
        book.headings(sheet, 0, [column.heading for column in self.columns], lines=4)
        sheet.repeat_columns(0, 3)
        sheet.fit_to_pages(2, 0)
        for land in self.lands:
            row = self.row_of[land.key]
            for number, column in enumerate(self.columns):
                content = self.land_cell(land, column.key)
                form = book.form(content.kind, **content.look)
                if content.formula is None:
                    put(sheet, row, number, content.value, form)
                elif content.value is not None:
                    formula(sheet, row, number, content.formula, content.value, form)
        for number, column in enumerate(self.columns):
            sheet.set_column(number, number, column.width)
        sheet.autofilter(0, 0, last, len(self.columns) - 1)
        verdict = self.column_of["verdict"]
        book.colour_words(sheet, (1, verdict), (last, verdict), VERDICTS)
        for condition in self.conditions:
            share = self.column_of["share", condition.prefix]
            bar = {"type": "data_bar", "bar_color": DATA_BAR, "min_type": "num", "min_value": 0}
            sheet.conditional_format(1, share, last, share, bar)

    # --- gaps

    def write_gaps(self, sheet: Worksheet, at: SheetCondition) -> None:
        """Write one row per gap of the condition's gear, its flow computed from the other cells of the row."""
        names = [
            "component",
            "land",
            "section",
            "from",
            "to",
            "pressure drop Δp [kPa]",
            "diameter [mm]",
            "contact length l [mm]",
            "clearance of equal flow [µm]",
            "kinematic viscosity ν [mm²/s]",
            "density ρ [g/cm³]",
            "leakage q [mm³/s]",
            "drawn from pump",
            "Reynolds number",
            "pressure pair published",
        ]
        book = self.book
        book.headings(sheet, 0, names, lines=3)
        for row, leak in enumerate(self.gaps[at.prefix], start=1):
            gap = leak.gap
            for column, value in enumerate((gap.component, gap.land, gap.section, str(gap.high), str(gap.low))):
                put(sheet, row, column, value)
            drop = leak.pressure_drop * KPA
            formula(sheet, row, 5, _drop(gap.high, gap.low, at), drop, book.form("kpa"))
            formula(sheet, row, 6, self._diameter(leak, at), leak.diameter * MM, book.form("mm"))
            put(sheet, row, 7, leak.contact_length * MM, book.form("mm", **CHANGEABLE))
            formula(sheet, row, 8, self._flow_clearance(leak, at), leak.effective_clearance * UM, book.form("um"))
            formula(sheet, row, 9, at("nu"), leak.kinematic_viscosity * MM2_S, book.form("nu"))
            formula(sheet, row, 10, at("rho"), leak.density * G_CM3, book.form("rho"))
            formula(sheet, row, 11, self._flow(row), leak.leakage * MM3_S, book.form("mm3"))
            put(sheet, row, 12, leak.drawn_from_pump)
            reynolds = f"2*L{row + 1}/(PI()*G{row + 1}*J{row + 1})"
            formula(sheet, row, 13, reynolds, leak.reynolds_number, book.form("um"))
            put(sheet, row, 14, gap.published)
        sheet.set_column(0, 14, 13)
        sheet.autofilter(0, 0, max(len(self.gaps[at.prefix]), 1), len(names) - 1)

    def _of_land(self, leak: GapLeakage, key: ColumnKey) -> str:
        """Return the cell with one of the quantities of a gap's land."""
        return cell(self.row_of[leak.gap.key], self.column_of[key], "Lands")

    def _diameter(self, leak: GapLeakage, at: SheetCondition) -> str:
        spool = self._of_land(leak, "spool")
        mean = self.diagnosis.profile.diameter == "mean"
        return f"{spool}+{self._of_land(leak, ('c_re', at.prefix))}*0.001" if mean else spool

    def _flow_clearance(self, leak: GapLeakage, at: SheetCondition) -> str:
        c = self._of_land(leak, ("c_re", at.prefix))
        if not self.diagnosis.model.law.counts_form:
            return c
        return f"({c}^3+MAX(3*{c}*{self._of_land(leak, 'm2')}+{self._of_land(leak, 'm3')},0))^(1/3)"

    def _flow(self, row: int) -> str:
        """Return the formula of the gap law in workshop units: mm, µm, kPa, mm²/s and g/cm³ give mm³/s."""
        profile, r = self.diagnosis.profile, row + 1
        viscous = f"(12*J{r}*K{r}*H{r})"
        if profile.eccentricity == UNKNOWN:
            viscous = f"({viscous}/{exact(MEAN_ECCENTRIC)})"
        elif profile.eccentricity:
            viscous = f"({viscous}/(1+{ECCENTRIC_GAIN}*{exact(profile.eccentricity)}^2))"
        if profile.entry_loss == "off":
            law = f"PI()*G{r}*I{r}^3*F{r}*0.001/{viscous}"
        else:
            root = f"SQRT({viscous}^2+2*{ENTRY_AND_EXIT_LOSS}*K{r}*F{r}*I{r}^4*1E-6)"
            law = f"2*PI()*G{r}*I{r}^3*F{r}*0.001/({viscous}+{root})"
        return f"IF(F{r}>0,{law},0)"

    # --- rules

    def write_rules(self, sheet: Worksheet) -> None:
        """Write what each rule says of each land; the worst gives the land's verdict."""
        names = ["component", "land", "rule", "unit", "value", *(f"{level} from" for level in FLAGGED)]
        names += ["verdict", "rank", "origin of the limit", "source"]
        self.book.headings(sheet, 0, names)
        for judged in self.lands:
            if not judged.rules:
                continue
            for row, rule in enumerate(judged.rules, start=self.rule_rows[judged.key][0]):
                self._rule(sheet, row, judged, rule)
        last = max((rows[1] for rows in self.rule_rows.values()), default=1)
        for column, width in enumerate((12, 7, 44, 7, 12, *(12 for _ in FLAGGED), 14, 7, 24, 60)):
            sheet.set_column(column, column, width)
        sheet.autofilter(0, 0, last, len(names) - 1)
        self.book.colour_words(sheet, (1, _VERDICT), (last, _VERDICT), VERDICTS)

    def _rule(self, sheet: Worksheet, row: int, judged: LandDiagnosis, rule: Rule) -> None:
        book, land, r = self.book, judged.state.land, row + 1
        kind, factor = rule.kind.suffix, rule.kind.factor
        for column, value in enumerate((land.component, land.land, rule.label, rule.kind.unit)):
            put(sheet, row, column, value)
        formula(sheet, row, 4, self._rule_source(judged, rule), rule.value * factor, book.form(kind))
        text = "1"
        of_the_set = self.diagnosis.limits.rules.get(rule.kind)
        for level, limit in rule.steps.levels:
            column = _FIRST_LEVEL + FLAGGED.index(level)
            if of_the_set is not None and limit == dict(of_the_set.levels).get(level):
                formula(sheet, row, column, self.limit_cells[rule.kind, level], limit * factor, book.form(kind))
            else:  # the land's own: by its file, by its mounting clearance or by what it draws when new
                put(sheet, row, column, limit * factor, book.form(kind, **CHANGEABLE))
            text = f"IF(E{r}>={cell(row, column)}*(1-{ROUNDING:E}),{RANKED.index(level) + 1},{text})"
        formula(sheet, row, _VERDICT + 1, text, RANKED.index(rule.verdict) + 1)
        formula(sheet, row, _VERDICT, verdict_of_rank(cell(row, _VERDICT + 1)), signed(rule.verdict), book.form())
        put(sheet, row, _VERDICT + 2, rule.origin)
        put(sheet, row, _VERDICT + 3, rule.source)

    def rule_verdict(self, judged: LandDiagnosis, rule: Rule) -> str:
        """Return the cell with the verdict of one of a land's rules."""
        return cell(self.rule_rows[judged.key][0] + judged.rules.index(rule), _VERDICT, "Rules")

    def _rule_source(self, judged: LandDiagnosis, rule: Rule) -> str:
        """Return the cell with the rule's value on the sheet of lands."""
        row, at = self.row_of[judged.key], self.column_of
        if rule.kind is RuleKind.WEAR:
            return cell(row, at["wear"], "Lands")
        if rule.kind is RuleKind.CLEARANCE:
            return cell(row, at["c_r"], "Lands")
        at_condition = next(each for each in self.conditions if each.projection.condition == rule.condition)
        return cell(row, at["share", at_condition.prefix], "Lands")


def write_readings(book: Book, sheet: Worksheet, live: LiveSheets) -> None:
    """Write every reading as entered, sorted by land; the lands' diameters become means of these cells."""
    names = ["component", "land", "part", "plane", "direction [°]", "repeat", "diameter [mm]"]
    names += ["coordinate 1 [mm]", "coordinate 2 [mm]", "sheet", "row", "column"]
    book.headings(sheet, 0, names)
    readings = live.diagnosis.readings
    controller = live.diagnosis.controller
    known: list[tuple[tuple[Any, ...], Reading]] = []
    for reading in readings.readings if readings else ():
        land = controller.land_of_plane(reading.component, reading.plane)
        place = live.row_of[land.key] if land else len(live.lands) + 1
        planes = land.planes.index(reading.plane) if land else 0
        direction = -1.0 if reading.direction is None else reading.direction
        known.append(((place, reading.part != "spool", planes, direction, reading.repeat), reading))
    known.sort(key=lambda pair: pair[0])
    form, mm = book.form(), book.form("mm", **CHANGEABLE)
    rows: dict[tuple[Any, ...], list[int]] = {}
    for row, (_, reading) in enumerate(known, start=1):
        land = controller.land_of_plane(reading.component, reading.plane)
        if land is not None:
            rows.setdefault((land.key, reading.part, reading.plane, reading.direction), []).append(row)
        low, high = reading.coordinates or (None, None)
        values = (reading.component, land.land if land else None, reading.part, reading.plane, reading.direction)
        for column, value in enumerate((*values, reading.repeat)):
            put(sheet, row, column, value, form)
        put(sheet, row, 6, reading.diameter * MM, mm)
        put(sheet, row, 7, None if low is None else low * MM, book.form("mm"))
        put(sheet, row, 8, None if high is None else high * MM, book.form("mm"))
        for column, value in enumerate((reading.place.sheet, reading.place.row, reading.place.column), start=9):
            put(sheet, row, column, value, form)
    sheet.set_column(0, len(names), 13)
    sheet.autofilter(0, 0, max(len(known), 1), len(names) - 1)
    live.means.update(_means(rows))


def _means(rows: dict[tuple[Any, ...], list[int]]) -> Iterable[tuple[Any, str]]:
    """Return the mean over repeats, then directions, then planes, as a formula per land and part."""
    for (key, part), stations in groupby(rows, key=lambda station: station[:2]):
        planes = [
            _average([_average([span(rows[s][0], rows[s][-1], 6, "Readings")]) for s in group])
            for _, group in groupby(stations, key=lambda station: station[2])
        ]
        yield (key, part), _average(planes)


def _average(terms: list[str]) -> str:
    """Return the formula of a mean of numbers; one number is its own mean."""
    if len(terms) == 1 and terms[0].startswith("AVERAGE("):
        return terms[0]
    return f"AVERAGE({','.join(terms)})"


def _drop(high: Pressure, low: Pressure, at: SheetCondition) -> str:
    def term(pressure: Pressure) -> str:
        if pressure.section is None:
            return ""
        name = at(pressure.section)
        return name if pressure.coefficient == 1.0 else f"{exact(pressure.coefficient)}*{name}"

    taken = term(low)
    return (term(high) or "0") + (f"-{taken}" if taken else "")
