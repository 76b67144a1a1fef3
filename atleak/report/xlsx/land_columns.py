"""Define the columns of the sheet of lands: each knows its heading, its width and the content of a land's cell.

A column is added in `land_columns`. A cell with a formula holds atleak's own number as its cached value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from atleak.catalogue.controller import REFERENCE_TEMPERATURE
from atleak.catalogue.instruments import Instruments, Part
from atleak.diagnosis import Diagnosis, LandDiagnosis
from atleak.engine.leakage import GapLeakage
from atleak.engine.projection import Projection
from atleak.look import INPUT
from atleak.report.xlsx.book import NO_DELIVERY, cell, exact, span
from atleak.rules import LandKey
from atleak.verdicts import VERDICTS, Verdict
from atleak.views.sentences import replace_at
from atleak.wording import signed, value_names, wording
from atleak.workshop_units import DM3_MIN, MM, PERCENT, UM

CHANGEABLE = {"font_color": INPUT}  # numbers that an auditor may change
RANKED: tuple[Verdict, ...] = tuple(verdict for verdict in VERDICTS if verdict != Verdict.NOT_MEASURED)
_PER_KELVIN = 1e6  # expansions are shown in 1e-6/K
_GAP_FLOW, _GAP_DRAWN = 11, 12  # columns of a gap's flow in its sheet, and of whether it is drawn from the pump
_SHEET_NAME = 31  # characters that Excel allows in a sheet's name

ColumnKey = str | tuple[str, str]  # a name, or a name and the prefix of a condition


@dataclass(frozen=True)
class SheetCondition:
    """One condition of the workbook: its projection, the prefix of its names and its sheet of gaps."""

    projection: Projection
    prefix: str
    sheet: str
    title: str

    def __call__(self, name: str) -> str:
        """Return the workbook's name for one of the condition's quantities."""
        return f"{self.prefix}_{name}"


def sheet_conditions(diagnosis: Diagnosis) -> list[SheetCondition]:
    """Return every condition of a diagnosis with names that Excel takes, in the order in which people read them."""
    made: list[SheetCondition] = []
    for at in diagnosis.presented:
        if at is diagnosis.projection:
            made.append(SheetCondition(at, "stated", "Gaps", "stated condition"))
            continue
        name = at.condition.name
        prefix = f"_{name}" if name[0].isdigit() else name
        made.append(SheetCondition(at, prefix, _free_name(f"Gaps {name.replace('_', ' ')}", made), at.condition.label))
    return made


def _free_name(wanted: str, made: Iterable[SheetCondition]) -> str:
    """Return the name of a new sheet of gaps: the one wanted, cut and numbered where it is too long or taken."""
    taken = {each.sheet for each in made}
    name, number = wanted[:_SHEET_NAME], 1
    while name in taken:
        number += 1
        ending = f" {number}"
        name = wanted[: _SHEET_NAME - len(ending)] + ending
    return name


@dataclass(frozen=True)
class Cell:
    """The content of a cell: a value and, where it follows from other cells, the formula that gives it."""

    kind: str  # of number, one of the workbook's formats
    value: Any
    formula: str | None = None
    look: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class LandRow:
    """One land on the sheet: its diagnosis, its record, and the address of any of its cells."""

    land: LandDiagnosis
    record: Mapping[str, Any]
    here: Callable[[ColumnKey], str]


@dataclass(frozen=True)
class LandColumn:
    """A column of the sheet of lands."""

    key: ColumnKey
    heading: str
    width: int
    cell: Callable[[LandRow], Cell]


@dataclass(frozen=True)
class LandSheet:
    """The places on other sheets to which the formulas of this sheet point."""

    lands: Sequence[LandDiagnosis]
    records: Sequence[Mapping[str, Any]]
    components: Mapping[str, str]  # number → name
    conditions: Sequence[SheetCondition]
    gaps: Mapping[str, Sequence[GapLeakage]]  # by the condition's prefix, in the order of its sheet
    ranks: Mapping[LandKey, str]  # the stretch of the sheet of rules that holds a land's ranks
    means: Mapping[tuple[LandKey, Part], str]  # formula of a part's mean diameter over the readings
    gauges: Instruments | None  # that measured, where their expansion counts
    rise: float  # [K] of gauge and parts over 20 °C when they were measured


def land_columns(sheet: LandSheet) -> list[LandColumn]:
    """Return every column that has a value for this unit, in order."""
    uncertain = any(record["uncertainty_um"] is not None for record in sheet.records)
    columns = [*_names(sheet), *_clearances(sheet, uncertain=uncertain)]
    for condition in sheet.conditions:
        columns += _at_condition(sheet, condition)
    return [*columns, *_as_issued(sheet, uncertain=uncertain)]


def _names(sheet: LandSheet) -> Iterable[LandColumn]:
    def verdict(row: LandRow) -> Cell:
        land = row.land
        # half a pair is never called ok
        fine = Verdict.OK if land.state.status == "measured" else Verdict.NOT_MEASURED
        ranks = sheet.ranks.get(land.key)
        formula = None if ranks is None else verdict_of_rank(f"MAX({ranks})", fine)
        return Cell("plain", signed(land.verdict), formula, {"bold": True})

    yield LandColumn("component", "component", 12, lambda row: Cell("plain", row.land.key[0], look={"bold": True}))
    yield LandColumn("name", "name", 26, lambda row: Cell("plain", sheet.components[row.land.key[0]]))
    yield LandColumn("land", "land", 7, lambda row: Cell("plain", row.land.key[1], look={"align": "center"}))
    yield LandColumn("verdict", "verdict", 15, verdict)
    yield LandColumn("status", "measured", 13, lambda row: Cell("plain", row.land.state.status.replace("_", " ")))


def _clearances(sheet: LandSheet, *, uncertain: bool) -> Iterable[LandColumn]:
    expansions: Mapping[Part, ColumnKey] = {"spool": "beta_s", "sleeve": "beta_k"}

    def diameter(part: Part) -> Callable[[LandRow], Cell]:
        def measured(row: LandRow) -> Cell:
            state = row.land.state
            value = state.spool_diameter if part == "spool" else state.sleeve_diameter
            formula = sheet.means.get((row.land.key, part))
            if formula is not None and sheet.gauges is not None:
                own, gauge = row.here(expansions[part]), exact(sheet.gauges.of(part).expansion * _PER_KELVIN)
                formula = f"({formula})*(1-({own}-{gauge})*1E-6*{exact(sheet.rise)})"
            return Cell("mm", value * MM, formula, CHANGEABLE)

        return measured

    def radial_clearance(row: LandRow) -> Cell:
        formula = f"({row.here('sleeve')}-{row.here('spool')})/2*1000"
        return Cell("um", row.land.state.radial_clearance * UM, formula)

    def wear(row: LandRow) -> Cell:
        new = row.here("c_m")
        worn = row.land.wear
        return Cell("percent", None if worn is None else worn * PERCENT, f"({row.here('c_r')}-{new})/{new}*100")

    def changeable(kind: str, value: Callable[[LandDiagnosis], float]) -> Callable[[LandRow], Cell]:
        return lambda row: Cell(kind, value(row.land), look=CHANGEABLE)

    yield LandColumn("sleeve", "sleeve diameter D [mm]", 12, diameter("sleeve"))
    yield LandColumn("spool", "spool diameter d [mm]", 12, diameter("spool"))
    yield LandColumn("c_r", "radial clearance c_r [µm]", 12, radial_clearance)
    if uncertain:
        heading = "standard uncertainty u(c_r) [µm]"
        yield LandColumn("U", heading, 12, lambda row: Cell("um", row.record["uncertainty_um"]))
    new = changeable("um", lambda land: land.state.land.mounting_high * UM)
    yield LandColumn("c_m", "mounting clearance c_m [µm]", 12, new)
    yield LandColumn("wear", "wear Z [%]", 10, wear)
    body = changeable("plain", lambda land: land.state.land.body_expansion * _PER_KELVIN)
    yield LandColumn("beta_k", "expansion of body β_k [1e-6/K]", 12, body)
    spool = changeable("plain", lambda land: land.state.land.spool_expansion * _PER_KELVIN)
    yield LandColumn("beta_s", "expansion of spool β_s [1e-6/K]", 12, spool)
    square = changeable("plain", lambda land: land.state.form_moments[0] * UM**2)
    yield LandColumn("m2", "form: mean of (c − c_r)² as measured [µm²]", 12, square)
    cube = changeable("plain", lambda land: land.state.form_moments[1] * UM**3)
    yield LandColumn("m3", "form: mean of (c − c_r)³ as measured [µm³]", 12, cube)


def _at_condition(sheet: LandSheet, condition: SheetCondition) -> Iterable[LandColumn]:
    projection, prefix = condition.projection, condition.prefix

    def effective_clearance(row: LandRow) -> Cell:
        opening = f"{row.here('beta_k')}*{row.here('sleeve')}-{row.here('beta_s')}*{row.here('spool')}"
        rise = f"({condition('T')}-{exact(REFERENCE_TEMPERATURE)})"
        formula = f"MAX({row.here('c_r')}+({opening})/2*{rise}*0.001,0)"
        return Cell("um", row.land.state.effective_clearance(projection.condition.temperature) * UM, formula)

    def leakage(row: LandRow) -> Cell:
        rows = [number for number, gap in enumerate(sheet.gaps[prefix], start=1) if gap.gap.key == row.land.key]
        if not rows:
            return Cell("flow", 0.0)
        formula = f"SUM({span(rows[0], rows[-1], _GAP_FLOW, condition.sheet)})*6E-5"
        return Cell("flow", projection.leakage_of(row.land.key) * DM3_MIN, formula)

    def drawn(row: LandRow) -> Cell:
        rows = [number for number, gap in enumerate(sheet.gaps[prefix], start=1) if gap.gap.key == row.land.key]
        if not rows:
            return Cell("flow", 0.0)
        counted = span(rows[0], rows[-1], _GAP_DRAWN, condition.sheet)
        formula = f'SUMIF({counted},"yes",{span(rows[0], rows[-1], _GAP_FLOW, condition.sheet)})*6E-5'
        return Cell("flow", projection.drawn_by(row.land.key) * DM3_MIN, formula)

    def share(row: LandRow) -> Cell:
        formula = share_of(row.here(("drawn", prefix)), condition("capacity"))
        return Cell("percent", projection.share_drawn_by(row.land.key) * PERCENT, formula)

    at = f", {condition.title}"
    yield LandColumn(("c_re", prefix), f"effective clearance c_re [µm]{at}", 14, effective_clearance)
    yield LandColumn(("q", prefix), f"leakage q [dm³/min]{at}", 14, leakage)
    yield LandColumn(("drawn", prefix), f"of it drawn from the pump [dm³/min]{at}", 14, drawn)
    yield LandColumn(("share", prefix), f"share of pump capacity [%]{at}", 14, share)


def _as_issued(sheet: LandSheet, *, uncertain: bool) -> Iterable[LandColumn]:
    """Return the columns with results of the program that no formula of the workbook gives."""

    def recorded(key: str, kind: str, factor: float = 1.0) -> Callable[[LandRow], Cell]:
        def issued(row: LandRow) -> Cell:
            value = row.record[key]
            return Cell(kind, None if value is None else value * factor)

        return issued

    def decision(row: LandRow) -> Cell:
        name = row.record["decision"]
        return Cell("plain", None if name is None else wording("en").get("decisions", name))

    def because(row: LandRow) -> Cell:
        rule = row.land.deciding
        return Cell("plain", rule.label if rule and row.land.verdict != Verdict.OK else None, look={"text_wrap": True})

    def mileage(row: LandRow) -> Cell:
        return Cell("plain", replace_at(row.land, wording("en")))

    def representative(row: LandRow) -> Cell:
        return Cell("plain", value_names(row.land.state.land.representative) or None)

    if uncertain:
        yield LandColumn("low", "leakage, low [dm³/min]", 12, recorded("leakage_low_dm3_min", "flow"))
        yield LandColumn("high", "leakage, high [dm³/min]", 12, recorded("leakage_high_dm3_min", "flow"))
    if any(record["decision"] is not None for record in sheet.records):
        yield LandColumn("decision", "decision as issued", 16, decision)
        over = recorded("probability_over_limit", "percent", PERCENT)
        yield LandColumn("probability", "probability over the limit as issued [%]", 14, over)
    if any(land.replace_mileage is not None for land in sheet.lands):
        yield LandColumn("mileage", "replace at (95 % interval), wear ∝ mileage, as issued", 30, mileage)
    yield LandColumn("because", "rule that gave the verdict, as issued", 34, because)
    yield LandColumn("representative", "representative values", 40, representative)


def verdict_of_rank(rank: str, fine: Verdict = Verdict.OK) -> str:
    """Return the formula of a verdict's sign and word, by its rank among those that can be given."""
    words = ",".join(f'"{signed(verdict)}"' for verdict in (fine, *RANKED[1:]))
    return f"CHOOSE({rank},{words})"


def share_of(leakage: str, capacity: str) -> str:
    """Return the formula of a share [%]: 0 without leakage, infinite where a pump without flow feeds any leakage."""
    return f"IF({capacity}>0,{leakage}/{capacity}*100,IF({leakage}>0,{exact(NO_DELIVERY)},0))"


def address(row: int, column: int) -> str:
    """Return the address of a cell of the same sheet, free to move with its row."""
    return cell(row, column).replace("$", "")
