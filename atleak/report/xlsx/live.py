"""Bring together the sheets that compute, from diameters to verdicts.

A cell that atleak computed holds the formula an auditor would write and, as its cached value, atleak's own number. What
an auditor may change (diameters, contact lengths, conditions, limits) is blue.
"""

from __future__ import annotations

from xlsxwriter.worksheet import Worksheet

from atleak.diagnosis import Diagnosis
from atleak.land_diagnosis import LandDiagnosis
from atleak.look import DATA_BAR
from atleak.report.xlsx.book import Book, cell
from atleak.report.xlsx.budget_sheet import BudgetCells
from atleak.report.xlsx.circuits_sheet import CircuitCells
from atleak.report.xlsx.conditions_sheet import ConditionsSheet
from atleak.report.xlsx.constants import ConstantCells
from atleak.report.xlsx.directions_sheet import DirectionCells, write_directions
from atleak.report.xlsx.gaps_sheet import GapCells
from atleak.report.xlsx.instruments_sheet import InstrumentCells
from atleak.report.xlsx.land_columns import LandRow, LandSheet, land_columns
from atleak.report.xlsx.limit_cells import LimitCells
from atleak.report.xlsx.live_cells import (
    Cell,
    ColumnKey,
    SheetCondition,
    cells_of_row,
    component_width,
    sheet_conditions,
    write_cell,
)
from atleak.report.xlsx.readings_sheet import ReadingCells
from atleak.report.xlsx.rules_sheet import RuleCells
from atleak.rules import LandKey
from atleak.sentence import Sentence
from atleak.verdicts import VERDICTS
from atleak.views.positions import spools_taken

LANDS = Sentence("Lands")


class LiveSheets:
    """The sheets of one diagnosis that compute, and where each of their cells stands."""

    def __init__(self, book: Book, diagnosis: Diagnosis) -> None:
        self.book, self.diagnosis = book, diagnosis
        say = book.say
        self.sheet = say.sentence(LANDS)
        self.lands = diagnosis.lands
        self.row_of = {land.key: row for row, land in enumerate(self.lands, start=1)}
        self.conditions = sheet_conditions(diagnosis, say)
        self.readings = ReadingCells(diagnosis, say)
        self.directions = DirectionCells(self.lands, say)
        self.constants = ConstantCells(diagnosis, say)
        uncertainty = diagnosis.uncertainty
        self.instruments = InstrumentCells(uncertainty, self.readings, say) if uncertainty else None
        self.budget = BudgetCells(diagnosis, self.readings, say) if uncertainty else None
        self.gaps = GapCells(diagnosis, self.conditions, say)
        self.limits = LimitCells(diagnosis.limits, say)
        self.rules = RuleCells(diagnosis, self.conditions, self.limits, say)
        self.circuits = CircuitCells(diagnosis, self.conditions, self.rules, say)
        self.totals = ConditionsSheet(diagnosis, self.conditions, self.gaps, self.rules, say)
        self.columns = land_columns(
            LandSheet(
                lands=self.lands,
                say=say,
                components={key: say.name(name) for key, name in diagnosis.controller.components.items()},
                conditions=self.conditions,
                gaps=self.gaps,
                rules=self.rules,
                readings=self.readings,
                directions=self.directions,
                spools=spools_taken(diagnosis.profile),
            )
        )
        self.column_of = {column.key: number for number, column in enumerate(self.columns)}

    def land_cell(self, land: LandDiagnosis, key: ColumnKey) -> Cell:
        """Return the content of one of a land's cells."""
        return self.columns[self.column_of[key]].cell(self._row(land))

    def _row(self, land: LandDiagnosis) -> LandRow:
        return LandRow(land, cells_of_row(self.row_of[land.key], self.column_of))

    def of_land(self, key: LandKey, column: ColumnKey) -> str:
        """Return the address of one of a land's cells, as other sheets ask for it."""
        return cell(self.row_of[key], self.column_of[column], self.sheet)

    def write_lands(self, sheet: Worksheet) -> None:
        """Write one row per land: D, d → c_r → c_re → q → share → verdict."""
        book, last = self.book, len(self.lands)
        book.headings(sheet, 0, [column.heading for column in self.columns], lines=6)
        sheet.repeat_columns(0, 3)
        sheet.fit_to_pages(2, 0)
        for land in self.lands:
            row, row_of_land = self.row_of[land.key], self._row(land)
            for number, column in enumerate(self.columns):
                write_cell(book, sheet, row, number, column.cell(row_of_land))
        for number, column in enumerate(self.columns):
            sheet.set_column(number, number, column.width)
        sheet.autofilter(0, 0, last, len(self.columns) - 1)
        verdict = self.column_of["verdict"]
        book.colour_words(sheet, (1, verdict), (last, verdict), VERDICTS)
        for condition in self.conditions:
            share = self.column_of["share", condition.prefix]
            bar = {"type": "data_bar", "bar_color": DATA_BAR, "min_type": "num", "min_value": 0}
            sheet.conditional_format(1, share, last, share, bar)

    def write_conditions(self, sheet: Worksheet) -> None:
        """Write temperature, pressures, fluid, pump and totals of every condition."""
        self.totals.write(self.book, sheet)

    def write_gaps(self, sheet: Worksheet, at: SheetCondition) -> None:
        """Write one row per gap of the condition's gear, its flow computed from the other cells of the row."""
        self.gaps.write(self.book, sheet, at, self.of_land)

    def write_limits(self, sheet: Worksheet) -> None:
        """Write every limit in cells that the rules point to."""
        self.limits.write(self.book, sheet)

    def write_rules(self, sheet: Worksheet) -> None:
        """Write what each rule says of the unit and of each land; the worst gives the verdict."""
        self.rules.write(self.book, sheet, self.of_land, self.circuits.held)

    def write_circuits(self, sheet: Worksheet) -> None:
        """Write the pressure that every circuit holds at every condition."""
        self.circuits.write(self.book, sheet)

    def write_readings(self, sheet: Worksheet) -> None:
        """Write every reading as entered, sorted by land; the lands' diameters are means of these cells."""
        self.readings.write(self.book, sheet)
        sheet.set_column(0, 0, component_width(self.diagnosis.controller.components))

    def write_constants(self, sheet: Worksheet) -> None:
        """Write every number that formulas ask for by name."""
        self.constants.write(self.book, sheet)

    def write_directions(self, sheet: Worksheet) -> None:
        """Write the clearance in every direction, from the readings; the lands' form follows from it."""
        write_directions(self.book, sheet, self.directions, self.readings, self.of_land)
        sheet.set_column(0, 0, component_width(self.diagnosis.controller.components))
