"""Define the columns of the sheet of lands: each knows its heading, its width and the content of a land's cell.

A column is added in `land_columns`. A cell with a formula holds atleak's own number as its cached value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from atleak.land_diagnosis import LandDiagnosis
from atleak.report.xlsx.book import cell
from atleak.report.xlsx.directions_sheet import DirectionCells
from atleak.report.xlsx.gaps_sheet import GapCells
from atleak.report.xlsx.live_cells import (
    AFTER_A_NUMBER,
    CHANGEABLE,
    EXPANSIONS,
    PER_KELVIN,
    Cell,
    ColumnKey,
    SheetCondition,
    component_width,
    fine_of,
    share_of,
    verdict_of_rank,
    warm_clearance,
)
from atleak.report.xlsx.readings_sheet import ReadingCells
from atleak.report.xlsx.rules_sheet import RuleCells
from atleak.sentence import Sentence
from atleak.verdicts import Verdict
from atleak.views.sentences import replace_at
from atleak.wording import Wording
from atleak.workshop_units import DM3_MIN, MM, PERCENT, UM

_STATUS = {
    "measured": Sentence("measured"),
    "spool_only": Sentence("spool only"),
    "sleeve_only": Sentence("sleeve only"),
    "not_measured": Sentence("not measured"),
}
_LEAKAGE_ENDS = {
    "low": Sentence("leakage, low as issued [dm³/min], stated condition"),
    "high": Sentence("leakage, high as issued [dm³/min], stated condition"),
}


@dataclass(frozen=True)
class LandRow:
    """One land on the sheet: its diagnosis, and the address of any of its cells."""

    land: LandDiagnosis
    here: Callable[[ColumnKey], str]


@dataclass(frozen=True)
class LandColumn:
    """A column of the sheet of lands."""

    key: ColumnKey
    heading: Sentence
    width: int
    cell: Callable[[LandRow], Cell]


@dataclass(frozen=True)
class LandSheet:
    """The places on other sheets to which the formulas of this sheet point."""

    lands: Sequence[LandDiagnosis]
    say: Wording
    components: Mapping[str, str]  # number → name, in the reader's language
    conditions: Sequence[SheetCondition]
    gaps: GapCells
    rules: RuleCells
    readings: ReadingCells
    directions: DirectionCells
    spools: Sentence  # where they are taken to lie


def land_columns(sheet: LandSheet) -> list[LandColumn]:
    """Return every column that has a value for this unit, in order."""
    uncertain = any(land.uncertainty is not None and land.uncertainty.u_clearance for land in sheet.lands)
    columns = [*_names(sheet), *_clearances(sheet, uncertain=uncertain)]
    for condition in sheet.conditions:
        columns += _at_condition(sheet, condition)
    return [*columns, *_as_issued(sheet, uncertain=uncertain), _also_flagged(sheet)]


def _also_flagged(sheet: LandSheet) -> LandColumn:
    """Return the order in which the summary lists the lands that are flagged by now and were not as issued."""
    first = cell(1, 0)

    def order(row: LandRow) -> Cell:
        ranks = None if row.land.verdict.flagged else sheet.rules.ranks_of(row.land.key)
        rank = f"MAX({ranks})"
        place = f"ROWS({first}:{row.here('component')})"
        return Cell("plain", 0, f"IF({rank}>1,{rank}-{place}*1E-6,0)" if ranks else "0")

    return LandColumn("also", Sentence("order among those flagged since, as the summary lists them"), 14, order)


def _names(sheet: LandSheet) -> Iterable[LandColumn]:
    def verdict(row: LandRow) -> Cell:
        land = row.land
        ranks = sheet.rules.ranks_of(land.key)
        formula = None if ranks is None else verdict_of_rank(f"MAX({ranks})", sheet.say, fine_of(land))
        return Cell("plain", sheet.say.signed(land.verdict), formula, {"bold": True})

    width = component_width(sheet.components)
    yield LandColumn(
        "component", Sentence("component"), width, lambda row: Cell("plain", row.land.key[0], look={"bold": True})
    )
    yield LandColumn("name", Sentence("name"), 26, lambda row: Cell("plain", sheet.components[row.land.key[0]]))
    yield LandColumn("land", Sentence("land"), 7, lambda row: Cell("plain", row.land.key[1], look={"align": "center"}))
    yield LandColumn("verdict", Sentence("verdict"), 15, verdict)
    yield LandColumn("status", Sentence("measured"), 13, lambda row: Cell("plain", _STATUS[row.land.state.status]))


def _clearances(sheet: LandSheet, *, uncertain: bool) -> Iterable[LandColumn]:
    def spool_diameter(row: LandRow) -> Cell:
        mean = sheet.readings.mean(row.land.key, "spool", row.here(EXPANSIONS["spool"]))
        return Cell("mm", row.land.state.spool_diameter * MM, mean, CHANGEABLE)

    def sleeve_diameter(row: LandRow) -> Cell:
        state = row.land.state
        mean = sheet.readings.mean(row.land.key, "sleeve", row.here(EXPANSIONS["sleeve"]))
        if mean is None:  # as new
            mean = f"{row.here('nominal')}+2*{row.here('c_n')}*0.001"
        return Cell("mm", state.sleeve_diameter * MM, mean, CHANGEABLE)

    def nominal(row: LandRow) -> Cell:
        state, of_sleeve = row.land.state, row.land.state.status in ("measured", "sleeve_only")
        return Cell("mm", None if of_sleeve else state.land.nominal_diameter * MM, look=CHANGEABLE)

    def radial_clearance(row: LandRow) -> Cell:
        formula = f"({row.here('sleeve')}-{row.here('spool')})/2*1000"
        return Cell("um", row.land.state.radial_clearance * UM, formula)

    def wear(row: LandRow) -> Cell:
        new = row.here("c_m")
        worn = row.land.wear
        return Cell("percent", None if worn is None else worn * PERCENT, f"({row.here('c_r')}-{new})/{new}*100")

    yield LandColumn("sleeve", Sentence("sleeve diameter D [mm]"), 12, sleeve_diameter)
    yield LandColumn("spool", Sentence("spool diameter d [mm]"), 12, spool_diameter)
    if any(land.state.status in ("not_measured", "spool_only") for land in sheet.lands):
        yield LandColumn("nominal", Sentence("nominal diameter, of a sleeve not measured [mm]"), 12, nominal)
    yield LandColumn("c_r", Sentence("radial clearance c_r [µm]"), 12, radial_clearance)
    if uncertain:
        heading = Sentence("standard uncertainty u(c_r) as issued [µm]")
        yield LandColumn("U", heading, 12, lambda row: _recorded("um", row.land, "u_clearance", UM))
    yield from _when_new(sheet)
    yield LandColumn("wear", Sentence("wear Z [%]"), 10, wear)
    body = _changeable("plain", lambda land: land.state.land.body_expansion * PER_KELVIN)
    yield LandColumn("beta_k", Sentence("expansion of body β_k [1e-6/K]"), 12, body)
    spool = _changeable("plain", lambda land: land.state.land.spool_expansion * PER_KELVIN)
    yield LandColumn("beta_s", Sentence("expansion of spool β_s [1e-6/K]"), 12, spool)
    for power, sign in ((2, "²"), (3, "³")):
        heading = Sentence("form: mean of (c − c_r){sign} as measured [µm{sign}]", sign=sign)
        yield LandColumn(f"m{power}", heading, 12, _moment(sheet, power))


def _changeable(kind: str, value: Callable[[LandDiagnosis], float]) -> Callable[[LandRow], Cell]:
    return lambda row: Cell(kind, value(row.land), look=CHANGEABLE)


def _when_new(sheet: LandSheet) -> Iterable[LandColumn]:
    """Return what is known of the clearance that a land had when new."""
    lands = [land.state.land for land in sheet.lands]
    a_range = any(len(land.mounting_ends) > 1 for land in lands)

    def low_end(row: LandRow) -> Cell:
        low, *more = row.land.state.land.mounting_ends
        return Cell("um", low * UM if more else None, look=CHANGEABLE)

    def tolerance(row: LandRow) -> Cell:
        half_width = row.land.state.land.mounting_tolerance
        return Cell("um", None if half_width is None else half_width * UM, look=CHANGEABLE)

    def new_clearance(row: LandRow) -> Cell:
        land, high = row.land.state.land, row.here("c_m")
        formula = high
        if len(land.mounting_ends) > 1:  # the mean cube over the range
            low = row.here("c_m_low")
            formula = f"(({low}+{high})*({low}^2+{high}^2)/4)^(1/3)"
        return Cell("um", land.new_clearance * UM, formula)

    def unworn(row: LandRow) -> Cell:
        state, land = row.land.state, row.land.state.land
        if not state.measured:
            return Cell("um", land.new_clearance * UM, row.here("c_n"))
        widest = row.here("c_m") if land.mounting_tolerance is None else f"{row.here('c_m')}+{row.here('tolerance')}"
        formula = f"MAX({row.here('c_n')},MIN({row.here('c_r')},{widest}))"
        return Cell("um", float(land.unworn(state.radial_clearance)) * UM, formula)

    def known_from(row: LandRow) -> Cell:
        return Cell("plain", row.land.state.land.new_origin.label, look=AFTER_A_NUMBER)

    if a_range:
        yield LandColumn("c_m_low", Sentence("mounting clearance, low end of a range [µm]"), 12, low_end)
    heading = Sentence("mounting clearance c_m [µm]")
    if a_range:
        heading = Sentence("mounting clearance c_m, high end of a range [µm]")
    yield LandColumn("c_m", heading, 12, _changeable("um", lambda land: land.state.land.mounting_high * UM))
    if any(land.mounting_tolerance is not None for land in lands):
        heading = Sentence("tolerance of c_m, half width of 95 % [µm]")
        yield LandColumn("tolerance", heading, 12, tolerance)
    yield LandColumn("c_n", Sentence("clearance of a new pair, of equal flow [µm]"), 12, new_clearance)
    yield LandColumn("c_u", Sentence("clearance that it may have had when new, given its reading [µm]"), 12, unworn)
    yield LandColumn("new_origin", Sentence("clearance when new is known from"), 42, known_from)


def _moment(sheet: LandSheet, power: int) -> Callable[[LandRow], Cell]:
    def moment(row: LandRow) -> Cell:
        value = row.land.state.form_moments[power - 2] * UM**power
        formula = sheet.directions.moment(row.land.key, power)
        return Cell("um", value, formula, {} if formula else CHANGEABLE)

    return moment


def _at_condition(sheet: LandSheet, condition: SheetCondition) -> Iterable[LandColumn]:
    at, prefix = condition.projection, condition.prefix

    def effective_clearance(row: LandRow) -> Cell:
        expansions = row.here("beta_k"), row.here("beta_s")
        formula = warm_clearance(row.here("c_r"), row.here("spool"), row.here("sleeve"), expansions, condition("T"))
        return Cell("um", row.land.state.effective_clearance(at.condition.temperature) * UM, formula)

    def leakage(row: LandRow) -> Cell:
        flow = sheet.gaps.sum_of("q", condition, row.land.key, drawn=False)
        return Cell("flow", at.leakage_of(row.land.key) * DM3_MIN, flow or "0")

    def drawn(row: LandRow) -> Cell:
        flow = sheet.gaps.sum_of("q", condition, row.land.key)
        return Cell("flow", at.drawn_by(row.land.key) * DM3_MIN, flow or "0")

    def share(row: LandRow) -> Cell:
        formula = share_of(row.here(("drawn", prefix)), condition("capacity"))
        return Cell("share", at.share_drawn_by(row.land.key) * PERCENT, formula)

    def new_drawn(row: LandRow) -> Cell:
        flow = sheet.gaps.sum_of("new_q", condition, row.land.key)
        return Cell("flow", condition.new.drawn_by(row.land.key) * DM3_MIN, flow or "0")

    def new_share(row: LandRow) -> Cell:
        formula = share_of(row.here(("new_drawn", prefix)), condition("capacity"))
        return Cell("share", condition.new.share_drawn_by(row.land.key) * PERCENT, formula)

    at_title = {"condition": condition.title}
    heading = Sentence("effective clearance c_re [µm], {condition}", **at_title)
    yield LandColumn(("c_re", prefix), heading, 14, effective_clearance)
    heading = Sentence("leakage q [dm³/min], {spools}, {condition}", spools=sheet.spools, **at_title)
    yield LandColumn(("q", prefix), heading, 14, leakage)
    heading = Sentence("of it drawn from the pump [dm³/min], {condition}", **at_title)
    yield LandColumn(("drawn", prefix), heading, 14, drawn)
    heading = Sentence("share of pump capacity [%], {condition}", **at_title)
    yield LandColumn(("share", prefix), heading, 14, share)
    heading = Sentence("drawn from the pump when new [dm³/min], {condition}", **at_title)
    yield LandColumn(("new_drawn", prefix), heading, 14, new_drawn)
    heading = Sentence("the same share when new [%], {condition}", **at_title)
    yield LandColumn(("new_share", prefix), heading, 14, new_share)


def _as_issued(sheet: LandSheet, *, uncertain: bool) -> Iterable[LandColumn]:
    """Return the columns with results of the program that no formula of the workbook gives."""

    def end_of(end: int) -> Callable[[LandRow], Cell]:
        return lambda row: _recorded("flow", row.land, "leakage_interval", DM3_MIN, end)

    def over(row: LandRow) -> Cell:
        probability = row.land.probability_over_limit
        return Cell("percent", None if probability is None else probability * PERCENT)

    def decision(row: LandRow) -> Cell:
        name = row.land.decision
        return Cell("plain", None if name is None else sheet.say.get("decisions", name), look=AFTER_A_NUMBER)

    def because(row: LandRow) -> Cell:
        rule = row.land.deciding
        return Cell("plain", rule.label if rule and row.land.verdict != Verdict.OK else None, look=AFTER_A_NUMBER)

    def mileage(row: LandRow) -> Cell:
        return Cell("plain", replace_at(row.land, sheet.say))

    def representative(row: LandRow) -> Cell:
        return Cell("plain", _value_names(row.land, sheet.say))

    if uncertain:
        for number, (end, heading) in enumerate(_LEAKAGE_ENDS.items()):
            yield LandColumn(end, heading, 12, end_of(number))
    if any(land.decision is not None for land in sheet.lands):
        yield LandColumn("decision", Sentence("decision as issued"), 16, decision)
        yield LandColumn("probability", Sentence("probability over the limit as issued [%]"), 14, over)
    if any(land.replace_mileage is not None for land in sheet.lands):
        yield LandColumn("mileage", Sentence("replace at (90 % interval), wear ∝ mileage, as issued"), 30, mileage)
    yield LandColumn("because", Sentence("rule that gave the verdict, as issued"), 46, because)
    yield LandColumn("representative", Sentence("representative values"), 40, representative)


def _recorded(kind: str, land: LandDiagnosis, name: str, factor: float, end: int | None = None) -> Cell:
    """Return the cell of a result of a land's uncertainty, or of one end of an interval; empty where not known."""
    known = getattr(land.uncertainty, name, None)
    value = known if known is None or end is None else known[end]
    return Cell(kind, None if value is None else value * factor)


def _value_names(land: LandDiagnosis, say: Wording) -> str | None:
    """Name the values that are neither measured nor published; None where there are none."""
    return ", ".join(say.get("parts", name) for name in land.state.land.representative) or None
