"""Lay out the sheets of gaps, one for each condition: every factor of a gap's flow, as measured and when new.

A column is added in `GAP_COLUMNS`. A cell with a formula holds atleak's own number as its cached value; the sums over
gaps are formulas too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from atleak.catalogue.repairs import LandKey
from atleak.common.sentences import Sentence
from atleak.common.units import G_CM3, KPA, MM, MM2_S, MM3_S, UM, UnitOf
from atleak.engine.leakage import GapLaw, GapLeakage
from atleak.engine.profile import UNKNOWN
from atleak.report.tables.lands import ANOTHER_CIRCUIT
from atleak.report.tables.names import spools_taken
from atleak.report.xlsx import live_sheet as names
from atleak.report.xlsx.live_sheet import (
    AFTER_A_NUMBER,
    CHANGEABLE,
    CLEARANCE,
    GAP_LEAK,
    LENGTH,
    PRESSURE,
    ColumnKey,
    LiveCells,
    LiveColumn,
    LiveSheet,
    SheetCondition,
    component_width,
    drop_between,
    quote,
    warm_clearance,
)

if TYPE_CHECKING:
    from atleak.report.xlsx.lands import LiveSheets

CONCENTRIC = "1"  # formula of the factor of a concentric spool
SAYS_SPOOLS = ("q", "new_q")  # columns behind whose heading is said where the spools are taken to lie


@dataclass(frozen=True)
class SheetGap:
    """One gap on the sheet: its flow, that of the same gap when new, and the cells of its land elsewhere."""

    leak: GapLeakage
    new: GapLeakage
    at: SheetCondition
    law: GapLaw
    of_land: Callable[[ColumnKey], str]

    @property
    def warm(self) -> str:
        """Return the cell of the land's mean clearance at the condition."""
        return self.of_land(("c_re", self.at.prefix))


def _diameter(gap: SheetGap, mean_clearance: str) -> str:
    """Return the formula of the diameter [mm] in the gap law, from the cell of the mean effective clearance [µm]."""
    spool = gap.of_land("spool")
    return f"{spool}+{mean_clearance}*0.001" if gap.law.profile.diameter == "mean" else spool


def _clearance(gap: SheetGap, _: LiveCells) -> str:
    if not gap.law.counts_form:
        return gap.warm
    return f"({gap.warm}^3+MAX(3*{gap.warm}*{gap.of_land('m2')}+{gap.of_land('m3')},0))^(1/3)"


def _new_clearance(gap: SheetGap, _: LiveCells) -> str:
    """Return the clearance of the same gap when new: no form, the same spool, the same growth with temperature."""
    spool, cold = gap.of_land("spool"), gap.of_land("c_u")
    expansions = gap.of_land("beta_k"), gap.of_land("beta_s")
    return warm_clearance(cold, spool, f"({spool}+2*{cold}*0.001)", expansions, gap.at("T"))


def _taken(gap: SheetGap) -> str:
    """Return the formula of the factor of the position that the profile takes the spool to have."""
    eccentricity = gap.law.profile.eccentricity
    if eccentricity == UNKNOWN:
        return names.MEAN_OF_POSITIONS
    return f"(1+{names.GAIN}*{names.ECCENTRICITY}^2)" if eccentricity else CONCENTRIC


def _flow(gap: SheetGap, here: LiveCells, factor: str, prefix: str = "") -> str:
    """Return the formula of the gap law in workshop units: mm, µm, kPa, mm²/s and g/cm³ give mm³/s.

    ``factor`` is the formula of what the spool's position takes off the friction; ``prefix`` is that of the columns of
    diameter, clearance and pressure drop.
    """
    d, c, drop = (here[f"{prefix}{name}"] for name in ("diameter", "clearance", "drop"))
    rho, size = here["rho"], f"ABS({drop})" if gap.leak.leaks_back else drop
    viscous = f"(12*{here['nu']}*{rho}*{here['length']})"
    if factor != CONCENTRIC:
        viscous = f"({viscous}/{factor})"
    if gap.law.linear:
        law = f"PI()*{d}*{c}^3*{drop}*0.001/{viscous}"
    else:
        root = f"SQRT({viscous}^2+2*{names.ENTRY_LOSS}*{rho}*{size}*{c}^4*1E-6)"
        law = f"2*PI()*{d}*{c}^3*{drop}*0.001/({viscous}+{root})"
    return law if gap.leak.leaks_back else f"IF({drop}>0,{law},0)"


def _drawn(gap: SheetGap) -> bool | Sentence:
    if gap.leak.drawn_from_pump:
        return True
    return Sentence("no, it leaks into {section}", section=gap.leak.gap.low.section or ANOTHER_CIRCUIT)


def _reynolds(gap: SheetGap, here: LiveCells) -> str:
    flow = f"ABS({here['q']})" if gap.leak.leaks_back else here["q"]
    return f"2*{flow}/(PI()*{here['diameter']}*{here['nu']})"


def _words(key: str, heading: Sentence, value: Callable[[SheetGap], object]) -> LiveColumn:
    return LiveColumn(key, heading, "plain", value, width=13, look={"align": "left"})


def _number(
    key: str,
    heading: Sentence,
    kind: str,
    value: Callable[[SheetGap], float],
    times: float | None,
    formula: Callable[[SheetGap, LiveCells], str] | None,
) -> LiveColumn:
    return LiveColumn(key, heading, kind, value, formula, times, 13, {} if formula else CHANGEABLE)


# fmt: off
GAP_COLUMNS = (
    _words("component", Sentence("component"), lambda gap: gap.leak.gap.component),
    _words("land", Sentence("land"), lambda gap: gap.leak.gap.land),
    _words("section", Sentence("section"), lambda gap: gap.leak.gap.section),
    _words("from", Sentence("from"), lambda gap: str(gap.leak.gap.high)),
    _words("to", Sentence("to"), lambda gap: str(gap.leak.gap.low)),
    _number("drop", Sentence("pressure drop Δp [{unit}]", unit=PRESSURE), "kpa", lambda gap: gap.leak.pressure_drop,
            KPA, lambda gap, _: drop_between(gap.leak.gap, gap.at.pressure)),
    _number("length", Sentence("contact length l [{unit}]", unit=LENGTH), "mm", lambda gap: gap.leak.contact_length,
            MM, None),
    _number("nu", Sentence("kinematic viscosity ν [{unit}]", unit=UnitOf("viscosity")), "nu",
            lambda gap: gap.leak.kinematic_viscosity, MM2_S, lambda gap, _: gap.at("nu")),
    _number("rho", Sentence("density ρ [{unit}]", unit=UnitOf("density")), "rho", lambda gap: gap.leak.density, G_CM3,
            lambda gap, _: gap.at("rho")),
    _number("diameter", Sentence("diameter [{unit}]", unit=LENGTH), "mm", lambda gap: gap.leak.diameter, MM,
            lambda gap, _: _diameter(gap, gap.warm)),
    _number("clearance", Sentence("clearance of equal flow [{unit}]", unit=CLEARANCE), "um",
            lambda gap: gap.leak.effective_clearance, UM, _clearance),
    _number("q", Sentence("leakage q [{unit}]", unit=GAP_LEAK), "mm3", lambda gap: gap.leak.leakage, MM3_S,
            lambda gap, here: _flow(gap, here, _taken(gap))),
    _number("q_concentric", Sentence("leakage with the spool concentric [{unit}]", unit=GAP_LEAK), "mm3",
            lambda gap: gap.leak.concentric_leakage, MM3_S, lambda gap, here: _flow(gap, here, CONCENTRIC)),
    _number("q_touching", Sentence("leakage with the spool touching its bore [{unit}]", unit=GAP_LEAK), "mm3",
            lambda gap: gap.leak.touching_leakage, MM3_S, lambda gap, here: _flow(gap, here, names.FULLY)),
    LiveColumn("drawn", Sentence("drawn from the pump"), "plain", _drawn, width=20, look=AFTER_A_NUMBER),
    _number("new_clearance", Sentence("effective clearance when new [{unit}]", unit=CLEARANCE), "um",
            lambda gap: gap.new.effective_clearance, UM, _new_clearance),
    _number("new_diameter", Sentence("diameter when new [{unit}]", unit=LENGTH), "mm", lambda gap: gap.new.diameter, MM,
            lambda gap, here: _diameter(gap, here["new_clearance"])),
    _number("new_drop", Sentence("pressure drop when new [{unit}]", unit=PRESSURE), "kpa",
            lambda gap: gap.new.pressure_drop, KPA, lambda gap, _: drop_between(gap.leak.gap, gap.at.new_pressure)),
    _number("new_q", Sentence("leakage when new [{unit}]", unit=GAP_LEAK), "mm3", lambda gap: gap.new.leakage, MM3_S,
            lambda gap, here: _flow(gap, here, _taken(gap), "new_")),
    _number("reynolds", Sentence("Reynolds number"), "um", lambda gap: gap.leak.reynolds_number, None, _reynolds),
    LiveColumn("published", Sentence("pressure pair published"), "plain", lambda gap: gap.leak.gap.published, width=13,
               look=AFTER_A_NUMBER),
)
# fmt: on


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
