"""Write the sheets of gaps, one for each condition, and the sums over them as formulas."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from xlsxwriter.worksheet import Worksheet

from atleak.diagnosis import Diagnosis
from atleak.engine.leakage import GapLeakage
from atleak.report.xlsx.book import Book, span
from atleak.report.xlsx.gap_columns import GAP_COLUMN_OF, GAP_COLUMNS, GapRow
from atleak.report.xlsx.live_cells import ColumnKey, SheetCondition, cells_of_row, component_width, quote, write_cell
from atleak.rules import LandKey
from atleak.sentence import Sentence
from atleak.views.positions import spools_taken
from atleak.wording import Wording


class GapCells:
    """Where every gap stands on the sheet of its condition: sorted by land, so that a land's gaps are neighbours."""

    def __init__(self, diagnosis: Diagnosis, conditions: Sequence[SheetCondition], say: Wording) -> None:
        self.diagnosis, self._drawn = diagnosis, quote(say("estimate.yes"))
        places = {land.key: number for number, land in enumerate(diagnosis.lands)}
        self._gaps: Mapping[str, list[tuple[GapLeakage, GapLeakage]]] = {
            at.prefix: sorted(
                zip(at.projection.gaps, at.new.gaps, strict=True), key=lambda pair: places[pair[0].gap.key]
            )
            for at in conditions
        }

    def sum_of(self, key: str, at: SheetCondition, land: LandKey | None = None, *, drawn: bool = True) -> str | None:
        """Return the formula of the sum of some gaps' flows [dm³/min]; None where no gap leaks in this gear.

        Parameters
        ----------
        key
            of the column of flows: ``q``, ``q_concentric``, ``q_touching`` or ``new_q``.
        land
            whose gaps are meant; all of them unless given.
        drawn
            count only what is drawn from the pump.
        """
        gaps = enumerate(self._gaps[at.prefix], start=1)
        rows = [number for number, (leak, _) in gaps if land is None or leak.gap.key == land]
        if not rows:
            return None
        flows, counted = (span(rows[0], rows[-1], GAP_COLUMN_OF[name], at.sheet) for name in (key, "drawn"))
        return f"SUMIF({counted},{self._drawn},{flows})*60*1E-6" if drawn else f"SUM({flows})*60*1E-6"

    def write(
        self, book: Book, sheet: Worksheet, at: SheetCondition, of_land: Callable[[LandKey, ColumnKey], str]
    ) -> None:
        """Write one row per gap of the condition's gear; ``of_land`` gives a cell of the sheet of lands."""
        spools = spools_taken(self.diagnosis.profile)
        headings = (
            Sentence("{heading}, {spools}", heading=column.heading, spools=spools)
            if column.says_spools
            else column.heading
            for column in GAP_COLUMNS
        )
        book.headings(sheet, 0, headings, lines=4)
        law, gaps = self.diagnosis.model.law, self._gaps[at.prefix]
        for row, (leak, new) in enumerate(gaps, start=1):
            land = leak.gap.key
            content = GapRow(leak, new, at, law, partial(of_land, land), cells_of_row(row, GAP_COLUMN_OF))
            for number, column in enumerate(GAP_COLUMNS):
                write_cell(book, sheet, row, number, column.cell(content))
        sheet.set_column(0, 0, component_width(self.diagnosis.controller.components))
        sheet.set_column(1, len(GAP_COLUMNS) - 1, 13)
        sheet.set_column(GAP_COLUMN_OF["drawn"], GAP_COLUMN_OF["drawn"], 20)
        sheet.autofilter(0, 0, max(len(gaps), 1), len(GAP_COLUMNS) - 1)
