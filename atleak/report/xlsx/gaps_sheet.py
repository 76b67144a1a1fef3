"""Lay out the sheets of gaps, one for each condition, and give the sums over them as formulas."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from atleak.report.xlsx.gap_columns import GAP_COLUMNS, SAYS_SPOOLS, SheetGap
from atleak.report.xlsx.live_cells import LiveSheet, SheetCondition, component_width, quote
from atleak.rules import LandKey
from atleak.sentence import Sentence
from atleak.views.positions import spools_taken

if TYPE_CHECKING:
    from atleak.report.xlsx.live import LiveSheets


class GapSheets:
    """Where every gap stands on the sheet of its condition: sorted by land, so that a land's gaps are neighbours."""

    def __init__(self, live: LiveSheets) -> None:
        diagnosis, self._drawn = live.diagnosis, quote(live.say("estimate.yes"))
        places = {land.key: number for number, land in enumerate(diagnosis.lands)}
        spools = spools_taken(diagnosis.profile)
        columns = [
            replace(each, heading=Sentence("{heading}, {spools}", heading=each.heading, spools=spools))
            if each.key in SAYS_SPOOLS
            else each
            for each in GAP_COLUMNS
        ]
        columns[0] = replace(columns[0], width=component_width(diagnosis.controller.components))
        self.at: dict[str, LiveSheet] = {}  # by the condition's prefix
        for at in live.conditions:
            pairs = zip(at.projection.gaps, at.new.gaps, strict=True)
            gaps = [
                SheetGap(leak, new, at, diagnosis.model.law, partial(live.of_land, leak.gap.key))
                for leak, new in sorted(pairs, key=lambda pair: places[pair[0].gap.key])
            ]
            self.at[at.prefix] = LiveSheet(at.sheet, columns, gaps)

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
        sheet = self.at[at.prefix]
        rows = [row for row, gap in enumerate(sheet.items, start=1) if land is None or gap.leak.gap.key == land]
        if not rows:
            return None
        flows, counted = (sheet.span(rows[0], rows[-1], name) for name in (key, "drawn"))
        return f"SUMIF({counted},{self._drawn},{flows})*60*1E-6" if drawn else f"SUM({flows})*60*1E-6"
