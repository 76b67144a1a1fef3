"""Define the columns of the sheets of gaps: every factor of a gap's flow as measured, and of the same gap when new.

A column is added in `GAP_COLUMNS`. A cell with a formula holds atleak's own number as its cached value.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from atleak.catalogue.controller import Gap
from atleak.engine.leakage import GapLaw, GapLeakage
from atleak.engine.profile import UNKNOWN
from atleak.report.xlsx.live_cells import (
    AFTER_A_NUMBER,
    CHANGEABLE,
    Cell,
    ColumnKey,
    SheetCondition,
    drop_between,
    warm_clearance,
)
from atleak.report.xlsx.names import ECCENTRICITY, ENTRY_LOSS, FULLY, GAIN, MEAN_OF_POSITIONS
from atleak.sentence import Sentence
from atleak.views.condition_matrix import ANOTHER_CIRCUIT
from atleak.workshop_units import G_CM3, KPA, MM, MM2_S, MM3_S, UM

CONCENTRIC = "1"  # formula of the factor of a concentric spool


@dataclass(frozen=True)
class GapRow:
    """One gap on the sheet: its flow, that of the same gap when new, and the addresses that its formulas ask for."""

    leak: GapLeakage
    new: GapLeakage
    at: SheetCondition
    law: GapLaw
    of_land: Callable[[ColumnKey], str]  # a cell of the gap's land on the sheet of lands
    here: Callable[[str], str]  # a cell of this row


@dataclass(frozen=True)
class GapColumn:
    """A column of the sheets of gaps; behind some headings is said where the spools are taken to lie."""

    key: str
    heading: Sentence
    cell: Callable[[GapRow], Cell]
    says_spools: bool = False


def _drop(row: GapRow) -> Cell:
    return Cell("kpa", row.leak.pressure_drop * KPA, drop_between(row.leak.gap, row.at.pressure))


def _new_drop(row: GapRow) -> Cell:
    return Cell("kpa", row.new.pressure_drop * KPA, drop_between(row.leak.gap, row.at.new_pressure))


def _diameter(row: GapRow, mean_clearance: str) -> str:
    """Return the formula of the diameter [mm] in the gap law, from the cell of the mean effective clearance [µm]."""
    spool = row.of_land("spool")
    return f"{spool}+{mean_clearance}*0.001" if row.law.profile.diameter == "mean" else spool


def _clearance(row: GapRow) -> Cell:
    mean = row.of_land(("c_re", row.at.prefix))
    formula = mean
    if row.law.counts_form:
        formula = f"({mean}^3+MAX(3*{mean}*{row.of_land('m2')}+{row.of_land('m3')},0))^(1/3)"
    return Cell("um", row.leak.effective_clearance * UM, formula)


def _new_clearance(row: GapRow) -> Cell:
    """Return the clearance of the same gap when new: no form, the same spool, the same growth with temperature."""
    spool, cold = row.of_land("spool"), row.of_land("c_u")
    expansions = row.of_land("beta_k"), row.of_land("beta_s")
    formula = warm_clearance(cold, spool, f"({spool}+2*{cold}*0.001)", expansions, row.at("T"))
    return Cell("um", row.new.effective_clearance * UM, formula)


def _taken(row: GapRow) -> str:
    """Return the formula of the factor of the position that the profile takes the spool to have."""
    eccentricity = row.law.profile.eccentricity
    if eccentricity == UNKNOWN:
        return MEAN_OF_POSITIONS
    return f"(1+{GAIN}*{ECCENTRICITY}^2)" if eccentricity else CONCENTRIC


def _flow(row: GapRow, factor: str, prefix: str = "") -> str:
    """Return the formula of the gap law in workshop units: mm, µm, kPa, mm²/s and g/cm³ give mm³/s.

    ``factor`` is the formula of what the spool's position takes off the friction; ``prefix`` is that of the columns of
    diameter, clearance and pressure drop.
    """
    d, c, drop = (row.here(f"{prefix}{name}") for name in ("diameter", "clearance", "drop"))
    rho, size = row.here("rho"), f"ABS({drop})" if row.leak.leaks_back else drop
    viscous = f"(12*{row.here('nu')}*{rho}*{row.here('length')})"
    if factor != CONCENTRIC:
        viscous = f"({viscous}/{factor})"
    if row.law.linear:
        law = f"PI()*{d}*{c}^3*{drop}*0.001/{viscous}"
    else:
        root = f"SQRT({viscous}^2+2*{ENTRY_LOSS}*{rho}*{size}*{c}^4*1E-6)"
        law = f"2*PI()*{d}*{c}^3*{drop}*0.001/({viscous}+{root})"
    return law if row.leak.leaks_back else f"IF({drop}>0,{law},0)"


def _drawn(row: GapRow) -> Cell:
    if row.leak.drawn_from_pump:
        return Cell("plain", True, look=AFTER_A_NUMBER)
    section = row.leak.gap.low.section or ANOTHER_CIRCUIT
    return Cell("plain", Sentence("no, it leaks into {section}", section=section), look=AFTER_A_NUMBER)


def _reynolds(row: GapRow) -> Cell:
    flow = row.here("q")
    formula = f"2*{f'ABS({flow})' if row.leak.leaks_back else flow}/(PI()*{row.here('diameter')}*{row.here('nu')})"
    return Cell("um", row.leak.reynolds_number, formula)


def _published(row: GapRow) -> Cell:
    return Cell("plain", row.leak.gap.published, look=AFTER_A_NUMBER)


def _text(value: Callable[[Gap], Any]) -> Callable[[GapRow], Cell]:
    return lambda row: Cell("plain", value(row.leak.gap), look={"align": "left"})


GAP_COLUMNS = (
    GapColumn("component", Sentence("component"), _text(lambda gap: gap.component)),
    GapColumn("land", Sentence("land"), _text(lambda gap: gap.land)),
    GapColumn("section", Sentence("section"), _text(lambda gap: gap.section)),
    GapColumn("from", Sentence("from"), _text(lambda gap: str(gap.high))),
    GapColumn("to", Sentence("to"), _text(lambda gap: str(gap.low))),
    GapColumn("drop", Sentence("pressure drop Δp [kPa]"), _drop),
    GapColumn(
        "length",
        Sentence("contact length l [mm]"),
        lambda row: Cell("mm", row.leak.contact_length * MM, look=CHANGEABLE),
    ),
    GapColumn(
        "nu",
        Sentence("kinematic viscosity ν [mm²/s]"),
        lambda row: Cell("nu", row.leak.kinematic_viscosity * MM2_S, row.at("nu")),
    ),
    GapColumn("rho", Sentence("density ρ [g/cm³]"), lambda row: Cell("rho", row.leak.density * G_CM3, row.at("rho"))),
    GapColumn(
        "diameter",
        Sentence("diameter [mm]"),
        lambda row: Cell("mm", row.leak.diameter * MM, _diameter(row, row.of_land(("c_re", row.at.prefix)))),
    ),
    GapColumn("clearance", Sentence("clearance of equal flow [µm]"), _clearance),
    GapColumn(
        "q",
        Sentence("leakage q [mm³/s]"),
        lambda row: Cell("mm3", row.leak.leakage * MM3_S, _flow(row, _taken(row))),
        says_spools=True,
    ),
    GapColumn(
        "q_concentric",
        Sentence("leakage with the spool concentric [mm³/s]"),
        lambda row: Cell("mm3", row.leak.concentric_leakage * MM3_S, _flow(row, CONCENTRIC)),
    ),
    GapColumn(
        "q_touching",
        Sentence("leakage with the spool touching its bore [mm³/s]"),
        lambda row: Cell("mm3", row.leak.touching_leakage * MM3_S, _flow(row, FULLY)),
    ),
    GapColumn("drawn", Sentence("drawn from the pump"), _drawn),
    GapColumn("new_clearance", Sentence("effective clearance when new [µm]"), _new_clearance),
    GapColumn(
        "new_diameter",
        Sentence("diameter when new [mm]"),
        lambda row: Cell("mm", row.new.diameter * MM, _diameter(row, row.here("new_clearance"))),
    ),
    GapColumn("new_drop", Sentence("pressure drop when new [kPa]"), _new_drop),
    GapColumn(
        "new_q",
        Sentence("leakage when new [mm³/s]"),
        lambda row: Cell("mm3", row.new.leakage * MM3_S, _flow(row, _taken(row), "new_")),
        says_spools=True,
    ),
    GapColumn("reynolds", Sentence("Reynolds number"), _reynolds),
    GapColumn("published", Sentence("pressure pair published"), _published),
)
GAP_COLUMN_OF = {column.key: number for number, column in enumerate(GAP_COLUMNS)}
