"""Bring together the sheets that compute, from diameters to verdicts.

A cell that atleak computed holds the formula an auditor would write and, as its cached value, atleak's own number. What
an auditor may change (diameters, contact lengths, conditions, limits) is blue.
"""

from __future__ import annotations

from xlsxwriter.worksheet import Worksheet

from atleak.diagnosis import Diagnosis
from atleak.land_diagnosis import LandDiagnosis
from atleak.look import DATA_BAR
from atleak.report.xlsx.book import Book
from atleak.report.xlsx.budget_sheet import BudgetCells
from atleak.report.xlsx.circuits_sheet import CircuitCells
from atleak.report.xlsx.conditions_sheet import ConditionsSheet
from atleak.report.xlsx.constants import ConstantCells
from atleak.report.xlsx.directions_sheet import DirectionCells
from atleak.report.xlsx.gaps_sheet import GapSheets
from atleak.report.xlsx.instruments_sheet import InstrumentCells
from atleak.report.xlsx.land_columns import land_columns
from atleak.report.xlsx.limit_cells import LimitCells
from atleak.report.xlsx.live_cells import Cell, ColumnKey, LiveSheet, sheet_conditions
from atleak.report.xlsx.readings_sheet import ReadingCells
from atleak.report.xlsx.rules_sheet import RuleCells
from atleak.rules import LandKey
from atleak.sentence import Sentence
from atleak.wording import Wording

LANDS = Sentence("Lands")


class LiveSheets:
    """The sheets of one diagnosis that compute, and where each of their cells stands."""

    def __init__(self, diagnosis: Diagnosis, say: Wording) -> None:
        self.diagnosis, self.say = diagnosis, say
        uncertainty = diagnosis.uncertainty
        self.lands = diagnosis.lands
        self.row_of = {land.key: row for row, land in enumerate(self.lands, start=1)}
        self.conditions = sheet_conditions(diagnosis, say)
        self.readings = ReadingCells(diagnosis, say)
        self.directions = DirectionCells(self)
        self.constants = ConstantCells(diagnosis)
        self.instruments = InstrumentCells(uncertainty, self.readings, say) if uncertainty else None
        self.budget = BudgetCells(self) if uncertainty else None
        self.gaps = GapSheets(self)
        self.limits = LimitCells(diagnosis.limits, say)
        self.rules = RuleCells(self)
        self.circuits = CircuitCells(self)
        self.totals = ConditionsSheet(self)
        self.sheet = LiveSheet(say.sentence(LANDS), land_columns(self), self.lands)

    def land_cell(self, land: LandDiagnosis, key: ColumnKey) -> Cell:
        """Return the content of one of a land's cells."""
        return self.sheet.columns[self.sheet.place[key]].cell(land, self.sheet.row(self.row_of[land.key]))

    def of_land(self, key: LandKey, column: ColumnKey) -> str:
        """Return the address of one of a land's cells, as other sheets ask for it."""
        return self.sheet.cell(self.row_of[key], column)

    def write_lands(self, book: Book, sheet: Worksheet) -> None:
        """Write one row per land: D, d → c_r → c_re → q → share → verdict."""
        self.sheet.write(book, sheet, lines=6)
        sheet.repeat_columns(0, 3)
        sheet.fit_to_pages(2, 0)
        for condition in self.conditions:
            share = self.sheet.place["share", condition.prefix]
            bar = {"type": "data_bar", "bar_color": DATA_BAR, "min_type": "num", "min_value": 0}
            sheet.conditional_format(1, share, len(self.lands), share, bar)
