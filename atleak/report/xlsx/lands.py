"""Write the sheet of lands, and bring together all sheets that compute, from diameters to verdicts.

A cell that atleak computed holds the formula an auditor would write and, as its cached value, atleak's own number. What
an auditor may change (diameters, contact lengths, conditions, limits) is blue. A column with a formula is added in
`land_columns`; one of `pair_table` that has none here stands at the end, as issued.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.repairs import LandKey
from atleak.common.sentences import Sentence
from atleak.common.style import DATA_BAR
from atleak.common.units import DM3_MIN, MM, PERCENT, UM, UnitOf
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.report.tables.lands import ON_PAPER, pair_table
from atleak.report.tables.names import spools_taken
from atleak.report.tables.sentences import replace_at
from atleak.report.xlsx.book import ReportBook, cell
from atleak.report.xlsx.circuits import CircuitCells
from atleak.report.xlsx.conditions import ConditionsSheet
from atleak.report.xlsx.constants import ConstantCells
from atleak.report.xlsx.gaps import GapSheets
from atleak.report.xlsx.live_sheet import (
    AFTER_A_NUMBER,
    CHANGEABLE,
    CLEARANCE,
    EXPANSIONS,
    LEAK,
    LENGTH,
    PER_KELVIN,
    ColumnKey,
    LiveCell,
    LiveCells,
    LiveColumn,
    LiveSheet,
    SheetCondition,
    component_width,
    fine_of,
    share_of,
    sheet_conditions,
    verdict_of_rank,
    warm_clearance,
)
from atleak.report.xlsx.readings import DirectionCells, ReadingCells
from atleak.report.xlsx.rules import LimitCells, RuleCells
from atleak.report.xlsx.uncertainty import BudgetCells, InstrumentCells

_HAS_ITS_OWN = ("verdict", "pair", "clearance", "wear", "decision", *ON_PAPER)  # of the columns of `pair_table`
_STATUS = {
    "measured": Sentence("measured"),
    "spool_only": Sentence("spool only"),
    "sleeve_only": Sentence("sleeve only"),
    "vacuum": Sentence("vacuum test"),
    "not_measured": Sentence("not measured"),
}


def land_columns(live: LiveSheets) -> list[LiveColumn]:
    """Return every column that has a value for this unit, in order."""
    uncertain = any(land.uncertainty is not None and land.uncertainty.u_clearance for land in live.lands)
    columns = [*_names(live), *_clearances(live, uncertain=uncertain)]
    for at in live.conditions:
        columns += _at_condition(live, at)
    return [*columns, *_as_issued(live, uncertain=uncertain), _also_flagged(live)]


def _also_flagged(live: LiveSheets) -> LiveColumn:
    """Return the order in which the summary lists the lands that are flagged by now and were not as issued."""
    first = cell(1, 0)

    def order(land: LandDiagnosis, here: LiveCells) -> str:
        ranks = None if land.verdict.flagged else live.rules.ranks_of(land.key)
        rank = f"MAX({ranks})"
        return f"IF({rank}>1,{rank}-ROWS({first}:{here['component']})*1E-6,0)" if ranks else "0"

    heading = Sentence("order among those flagged since, as the summary lists them")
    return LiveColumn("also", heading, value=lambda _: 0, formula=order, width=14)


def _names(live: LiveSheets) -> Iterable[LiveColumn]:
    say, bold = live.say, {"bold": True}
    components = {key: say.name(name) for key, name in live.diagnosis.controller.components.items()}

    def verdict(land: LandDiagnosis, _: LiveCells) -> str | None:
        ranks = live.rules.ranks_of(land.key)
        return None if ranks is None else verdict_of_rank(f"MAX({ranks})", say, fine_of(land))

    # fmt: off
    yield LiveColumn("component", Sentence("component"), value=lambda land: land.key[0],
                     width=component_width(components), look=bold)
    yield LiveColumn("name", Sentence("name"), value=lambda land: components[land.key[0]], width=26)
    yield LiveColumn("land", Sentence("land"), value=lambda land: land.key[1], width=7, look={"align": "center"})
    yield LiveColumn("verdict", Sentence("verdict"), value=lambda land: say.signed(land.verdict), formula=verdict,
                     width=15, look=bold)
    yield LiveColumn("status", Sentence("measured"), value=lambda land: _STATUS[land.state.status], width=13)
    # fmt: on


def _clearances(live: LiveSheets, *, uncertain: bool) -> Iterable[LiveColumn]:
    readings, lands = live.readings, live.lands

    def spool(land: LandDiagnosis, here: LiveCells) -> str | None:
        return readings.mean(land.key, "spool", here[EXPANSIONS["spool"]])

    def sleeve(land: LandDiagnosis, here: LiveCells) -> str:
        if land.state.status == "vacuum":
            return f"{here['spool']}+2*{here['c_v']}*0.001"
        as_new = f"{here['nominal']}+2*{here['c_n']}*0.001" if "nominal" in here else ""
        return readings.mean(land.key, "sleeve", here[EXPANSIONS["sleeve"]]) or as_new

    def nominal(land: LandDiagnosis) -> float | None:
        return None if land.state.status in ("measured", "sleeve_only") else land.state.land.nominal_diameter

    def clearance(land: LandDiagnosis, here: LiveCells) -> str:
        """Return the formula of the clearance: by diameters, by its leak, or by both, in the mean of the cubes."""
        own, weight = f"({here['sleeve']}-{here['spool']})/2*1000", land.state.leak_weight
        if land.state.leak is None or land.state.status == "vacuum":
            return own
        seen = live.directions.moment(land.key, 2) is not None
        cube = f"({own})^3" + (f"+MAX(3*({own})*{here['m2']}+{here['m3']},0)" if seen else "")
        mean = f"(1-{here['w_v']})*({cube})+{here['w_v']}*{here['c_v']}^3"
        if weight in (0.0, 1.0):  # they contradict one another
            mean = f"{here['c_v']}^3" if weight else cube
        square = f"MAX({here['m2']},1E-9)" if seen else ""
        if seen:  # the root of c³ + 3 c m₂ + m₃
            return f"2*SQRT({square})*SINH(ASINH(({mean}-{here['m3']})/(2*{square}^1.5))/3)"
        return f"({mean})^(1/3)"

    def form(power: int, land: LandDiagnosis) -> float:
        return land.state.form_moments[power - 2]

    def moment(power: int, land: LandDiagnosis, _: LiveCells) -> str | None:
        return live.directions.moment(land.key, power)

    # fmt: off
    yield LiveColumn("sleeve", Sentence("sleeve diameter D [{unit}]", unit=LENGTH), "mm",
                     lambda land: land.state.sleeve_diameter, sleeve, MM, look=CHANGEABLE)
    yield LiveColumn("spool", Sentence("spool diameter d [{unit}]", unit=LENGTH), "mm",
                     lambda land: land.state.spool_diameter, spool, MM, look=CHANGEABLE)
    if any(nominal(land) is not None for land in lands):
        yield LiveColumn("nominal", Sentence("nominal diameter, of a sleeve not measured [{unit}]", unit=LENGTH), "mm",
                         nominal, times=MM, look=CHANGEABLE)
    if any(land.state.leak for land in lands):
        yield LiveColumn("c_v", Sentence("clearance by the vacuum test [{unit}]", unit=CLEARANCE), "um",
                         lambda land: land.state.leak and land.state.leak.clearance, times=UM, look=CHANGEABLE)
        yield LiveColumn("w_v", Sentence("its weight in the mean of the cubes"), "plain",
                         lambda land: land.state.leak and land.state.leak_weight, look=CHANGEABLE)
    yield LiveColumn("c_r", Sentence("radial clearance c_r [{unit}]", unit=CLEARANCE), "um",
                     lambda land: land.state.radial_clearance, clearance, UM)
    if uncertain:
        yield LiveColumn("U", Sentence("standard uncertainty u(c_r) as issued [{unit}]", unit=CLEARANCE), "um",
                         lambda land: land.uncertainty and land.uncertainty.u_clearance, times=UM)
    yield from _when_new(lands)
    yield LiveColumn("wear", Sentence("wear Z [%]"), "percent", lambda land: land.wear,
                     "({c_r}-{c_m})/{c_m}*100", PERCENT, 10)
    yield LiveColumn("beta_k", Sentence("expansion of body β_k [{unit}]", unit=UnitOf("expansion")), "plain",
                     lambda land: land.state.land.body_expansion, times=PER_KELVIN, look=CHANGEABLE)
    yield LiveColumn("beta_s", Sentence("expansion of spool β_s [{unit}]", unit=UnitOf("expansion")), "plain",
                     lambda land: land.state.land.spool_expansion, times=PER_KELVIN, look=CHANGEABLE)
    # fmt: on
    for power, sign, kind in ((2, "²", "clearance_squared"), (3, "³", "clearance_cubed")):
        heading = Sentence("form: mean of (c − c_r){sign} as measured [{unit}]", sign=sign, unit=UnitOf(kind))
        value = partial(form, power)
        yield LiveColumn(f"m{power}", heading, "um", value, partial(moment, power), UM**power, blue=True)


def _when_new(lands: Iterable[LandDiagnosis]) -> Iterable[LiveColumn]:
    """Return what is known of the clearance that a land had when new."""
    nominals = [land.state.land for land in lands]
    a_range = any(len(nominal.mounting_ends) > 1 for nominal in nominals)

    def low_end(land: LandDiagnosis) -> float | None:
        low, *more = land.state.land.mounting_ends
        return low if more else None

    def equal_flow(land: LandDiagnosis, here: LiveCells) -> str:
        high = here["c_m"]
        if len(land.state.land.mounting_ends) == 1:
            return high
        low = here["c_m_low"]
        return f"(({low}+{high})*({low}^2+{high}^2)/4)^(1/3)"  # the mean cube over the range

    def unworn(land: LandDiagnosis) -> float:
        state, nominal = land.state, land.state.land
        return float(nominal.unworn(state.radial_clearance)) if state.measured else nominal.new_clearance

    def unworn_formula(land: LandDiagnosis, here: LiveCells) -> str:
        if not land.state.measured:
            return here["c_n"]
        tolerance = "" if land.state.land.mounting_tolerance is None else f"+{here['tolerance']}"
        return f"MAX({here['c_n']},MIN({here['c_r']},{here['c_m']}{tolerance}))"

    # fmt: off
    if a_range:
        yield LiveColumn("c_m_low", Sentence("mounting clearance, low end of a range [{unit}]", unit=CLEARANCE), "um",
                         low_end, times=UM, look=CHANGEABLE)
    heading = Sentence("mounting clearance c_m [{unit}]", unit=CLEARANCE)
    if a_range:
        heading = Sentence("mounting clearance c_m, high end of a range [{unit}]", unit=CLEARANCE)
    yield LiveColumn("c_m", heading, "um", lambda land: land.state.land.mounting_high, times=UM, look=CHANGEABLE)
    if any(nominal.mounting_tolerance is not None for nominal in nominals):
        yield LiveColumn("tolerance", Sentence("tolerance of c_m, half width of 95 % [{unit}]", unit=CLEARANCE), "um",
                         lambda land: land.state.land.mounting_tolerance, times=UM, look=CHANGEABLE)
    yield LiveColumn("c_n", Sentence("clearance of a new pair, of equal flow [{unit}]", unit=CLEARANCE), "um",
                     lambda land: land.state.land.new_clearance, equal_flow, UM)
    yield LiveColumn("c_u",
                     Sentence("clearance that it may have had when new, given its reading [{unit}]", unit=CLEARANCE),
                     "um", unworn, unworn_formula, UM)
    yield LiveColumn("new_origin", Sentence("clearance when new is known from"), width=42,
                     value=lambda land: land.state.land.new_origin.label, look=AFTER_A_NUMBER)
    # fmt: on


def _at_condition(live: LiveSheets, condition: SheetCondition) -> Iterable[LiveColumn]:
    now, new, prefix, gaps = condition.projection, condition.new, condition.prefix, live.gaps
    at, spools = {"condition": condition.title}, spools_taken(live.diagnosis.profile)

    def warm(land: LandDiagnosis, here: LiveCells) -> str:
        return warm_clearance(here["c_r"], here["spool"], here["sleeve"], (here["beta_k"], here["beta_s"]),
                              condition("T"))  # fmt: skip

    def flow(key: str, land: LandDiagnosis, _: LiveCells, *, drawn: bool = True) -> str:
        return gaps.sum_of(key, condition, land.key, drawn=drawn) or "0"

    def share(key: str, _: LandDiagnosis, here: LiveCells) -> str:
        return share_of(here[key, prefix], condition("capacity"))

    # fmt: off
    yield LiveColumn(("c_re", prefix),
                     Sentence("effective clearance c_re [{unit}], {condition}", unit=CLEARANCE, **at), "um",
                     lambda land: land.state.effective_clearance(now.condition.temperature), warm, UM, 14)
    heading = Sentence("leakage q [{unit}], {spools}, {condition}", unit=LEAK, spools=spools, **at)
    yield LiveColumn(("q", prefix), heading, "flow", lambda land: now.leakage_of(land.key),
                     partial(flow, "q", drawn=False), DM3_MIN, 14)
    yield LiveColumn(("drawn", prefix), Sentence("of it drawn from the pump [{unit}], {condition}", unit=LEAK, **at),
                     "flow", lambda land: now.drawn_by(land.key), partial(flow, "q"), DM3_MIN, 14)
    yield LiveColumn(("share", prefix), Sentence("share of pump capacity [%], {condition}", **at), "share",
                     lambda land: now.share_drawn_by(land.key), partial(share, "drawn"), PERCENT, 14)
    heading = Sentence("drawn from the pump when new [{unit}], {condition}", unit=LEAK, **at)
    yield LiveColumn(("new_drawn", prefix), heading, "flow", lambda land: new.drawn_by(land.key),
                     partial(flow, "new_q"), DM3_MIN, 14)
    yield LiveColumn(("new_share", prefix), Sentence("the same share when new [%], {condition}", **at), "share",
                     lambda land: new.share_drawn_by(land.key), partial(share, "new_drawn"), PERCENT, 14)
    # fmt: on


def _as_issued(live: LiveSheets, *, uncertain: bool) -> Iterable[LiveColumn]:
    """Return the columns with results of the program that no formula of the workbook gives."""
    say = live.say

    def end_of(end: int) -> Callable[[LandDiagnosis], float | None]:
        def leakage(land: LandDiagnosis) -> float | None:
            interval = land.uncertainty.leakage_interval if land.uncertainty else None
            return interval and interval[end]

        return leakage

    def representative(land: LandDiagnosis) -> str | None:
        return ", ".join(say.get("parts", name) for name in land.state.land.representative) or None

    # fmt: off
    if uncertain:
        yield LiveColumn("low", Sentence("leakage, low as issued [{unit}], stated condition", unit=LEAK), "flow",
                         end_of(0), times=DM3_MIN)
        yield LiveColumn("high", Sentence("leakage, high as issued [{unit}], stated condition", unit=LEAK), "flow",
                         end_of(1), times=DM3_MIN)
    if any(land.decision is not None for land in live.lands):
        yield LiveColumn("decision", Sentence("decision as issued"), width=16, look=AFTER_A_NUMBER,
                         value=lambda land: land.shown_as and say.get("decisions", land.shown_as))
        yield LiveColumn("probability", Sentence("probability over the limit as issued [%]"), "percent",
                         lambda land: land.probability_over_limit, times=PERCENT, width=14)
    if any(land.replace_mileage is not None for land in live.lands):
        yield LiveColumn("mileage", Sentence("replace at (90 % interval), wear ∝ mileage, as issued"), width=30,
                         value=lambda land: replace_at(land, say))
    for column in pair_table(live.diagnosis, live.lands, say, at=()).without(*_HAS_ITS_OWN).columns:
        heading = Sentence("{column}, as issued", column=column.heading(say))
        yield LiveColumn(column.key, heading, value=partial(column.cell, say=say, rounded=True), look=AFTER_A_NUMBER,
                         width=14 if column.is_number else 46)
    yield LiveColumn("representative", Sentence("assumed values"), value=representative, width=40)
    # fmt: on


LANDS_SHEET = Sentence("Lands")


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
        self.sheet = LiveSheet(say.sentence(LANDS_SHEET), land_columns(self), self.lands)

    def land_cell(self, land: LandDiagnosis, key: ColumnKey) -> LiveCell:
        """Return the content of one of a land's cells."""
        return self.sheet.columns[self.sheet.place[key]].cell(land, self.sheet.row(self.row_of[land.key]))

    def of_land(self, key: LandKey, column: ColumnKey) -> str:
        """Return the address of one of a land's cells, as other sheets ask for it."""
        return self.sheet.cell(self.row_of[key], column)

    def write_lands(self, book: ReportBook, sheet: Worksheet) -> None:
        """Write one row per land: D, d → c_r → c_re → q → share → verdict."""
        self.sheet.write(book, sheet)
        for condition in self.conditions:
            share = self.sheet.place["share", condition.prefix]
            bar = {"type": "data_bar", "bar_color": DATA_BAR, "min_type": "num", "min_value": 0}
            sheet.conditional_format(1, share, len(self.lands), share, bar)
