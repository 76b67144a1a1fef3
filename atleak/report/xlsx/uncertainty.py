"""Write the sheet of instruments and the uncertainty budgets of the flagged lands, every number a formula.

From the repeats to the spread of one reading: see `atleak.diagnosis.uncertainty.sources`; the spread before rounding is
the root of an equation, whose Newton steps stand below. Sources and rows of the budgets are those of
`atleak.diagnosis.uncertainty.results`, which the PDF prints too.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.instruments import Instrument, Part
from atleak.catalogue.words import PART_WORDS
from atleak.common.sentences import Name, Sentence
from atleak.common.units import PERCENT, UM, UnitOf
from atleak.common.wording import Wording
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.uncertainty import UnitUncertainty
from atleak.diagnosis.uncertainty.results import MOST_BUDGETS, BudgetLine, combined, effective_degrees, every_line
from atleak.diagnosis.uncertainty.sources import OF_A_DIAMETER, PARTS, SLOPES, LandSources, PooledRepeats, RepeatSpread
from atleak.equations.statistics import normal_quantile, persistent_rounding_variance
from atleak.report.xlsx import live_sheet as names
from atleak.report.xlsx.book import ReportBook, cell
from atleak.report.xlsx.live_sheet import (
    AFTER_A_NUMBER,
    AVERAGED,
    CLEARANCE,
    EXPANSIONS,
    PER_KELVIN,
    TRUSTED_DEGREES,
    VISIBLE_STEP,
    LiveCell,
    NamedQuantity,
    address,
    cells_of_part,
    quote,
    write_cell,
)
from atleak.report.xlsx.page import SheetPage
from atleak.report.xlsx.readings import ReadingCells

if TYPE_CHECKING:
    from atleak.report.xlsx.lands import LiveSheets

INSTRUMENTS_SHEET = Sentence("Instruments")
INFINITE = "∞"  # degrees of freedom of what is no sample of readings
_FIRST = 2  # column of the first part
_STEPS = 10  # of Newton to the spread before rounding, and terms of the series
_TERMS = "const_terms_of_series"  # name of their numbers
_UM2 = UM**2
_NOTES = (
    Sentence(
        "The step in which the sheet is written stays as issued where a reading is changed; it may be changed itself."
    ),
    Sentence(
        "Repeats of one place that differ make the spread; few of them are widened as Student's t is (JCGM 101, "
        "6.4.9). Rounding to a step q leaves the variance P, which repeats do not average out (Widrow and Kollár 2008)."
    ),
)


@dataclass(frozen=True)
class _Step:
    """One of Newton's steps to the spread before rounding, in µm and µm²."""

    spread: float
    excess: float  # of the variance that it would have rounded, over the one found
    slope: float


class InstrumentCells:
    """The instruments of one unit and what its repeats show."""

    def __init__(self, uncertainty: UnitUncertainty, readings: ReadingCells, say: Wording) -> None:
        self.uncertainty, self.readings, self.say = uncertainty, readings, say

    def write(self, book: ReportBook, sheet: Worksheet) -> None:
        """Write a column for each part, every cell a name that budgets ask for."""
        headings = (Sentence("quantity"), Sentence("unit"), *(PART_WORDS[part] for part in PARTS))
        page = SheetPage(book, sheet, (62, 12, *[22] * 6))
        book.headings(sheet, 0, headings, page.widths[: len(headings)])
        instruments = self.uncertainty.instruments
        book.put(sheet, 1, 0, Sentence("instrument"))
        columns = [list(self._rows(part)) for part in PARTS]
        for column, part in enumerate(PARTS, start=_FIRST):
            page.text(1, column, Name(instruments.of(part).name), align="right")
        for row, rows in enumerate(zip(*columns, strict=True), start=2):
            page.text(row, 0, rows[0].label)
            book.put(sheet, row, 1, rows[0].unit)
            for column, (part, each) in enumerate(zip(PARTS, rows, strict=True), start=_FIRST):
                each.write(book, sheet, row, column, cells_of_part(part, each.name))
        last = 2 + len(columns[0])
        for row, note in enumerate((*(Name(each.source) for each in self._known()), *_NOTES), start=last + 1):
            page.across(row, note)
        self._newton(book, page, last + 6)

    def _known(self) -> list[Instrument]:
        both = (self.uncertainty.instruments.of(part) for part in PARTS)
        return list({each.id: each for each in both}.values())

    def _rows(self, part: Part) -> Iterable[NamedQuantity]:
        """Return what stands in a part's column: its instrument, then what its repeats show, each step a formula."""
        instruments, named = self.uncertainty.instruments, _Names(part)
        same = part == PARTS[1] and instruments.spool == instruments.sleeve  # then its numbers stand once
        known = instruments.of(part)
        for each in _of_instrument(known):
            yield replace(each, formula=cells_of_part(PARTS[0], each.name)) if same else each
        common, own = Sentence("u of the error that all its readings share"), Sentence("u of the calibration's rest")
        follow = (
            _row("common", common, known.common * UM, "{calibration}*SQRT({common_part})"),
            _row("own", own, known.own * UM, "{calibration}*SQRT(1-{common_part})"),
        )
        for each in (*follow, *self._of_repeats(part, self.uncertainty.repeats[part])):
            yield each if each.formula is None else replace(each, formula=each.formula.format_map(named))

    def _of_repeats(self, part: Part, spread: RepeatSpread) -> Iterable[NamedQuantity]:
        """Return the steps from the repeats to the spread of one reading; formulas ask for others by ``{name}``."""
        found = _pooled(spread)
        squares, degrees = (self._summed(part, column) for column in ("squares", "degrees"))
        rounded = "{widened}^2-{roundings}*{q}^2/12"
        averaged = f"IF({rounded}>{{roundings}}*({AVERAGED}*{{q}})^2,SQRT(MAX({rounded},0)),{{newton}})"
        trusted = f"IF({{counted}}<{TRUSTED_DEGREES},MAX({{repeatability}},{{unrounded}}),{{unrounded}})"
        infinite, freedom = quote(INFINITE), spread.degrees_of_freedom if spread.origin == "repeats" else INFINITE
        cells = self.readings.whole(f"ovality_{part}")
        ovality = "0" if cells is None else f"SQRT(SUMSQ({cells})/MAX(COUNT({cells}),1))"
        # fmt: off
        yield _row("step", Sentence("step in which the sheet is written, as issued"), found.step * UM)
        yield _row("q", Sentence("step q that counts, the coarser of both"), spread.resolution * UM,
                   "MAX({resolution},{step})")
        roundings = Sentence("roundings in one diameter")
        yield NamedQuantity("roundings", roundings, "", "count", spread.roundings, fixed=True)
        yield _row("squares", Sentence("sum of squares of the repeats"), found.squares * _UM2, squares,
                   UnitOf("clearance_squared"))
        yield _row("degrees", Sentence("degrees of freedom of the repeats"), found.degrees_of_freedom, degrees,
                   "", "count")
        yield _row("pooled", Sentence("spread of the repeats, pooled over the unit"), found.standard_deviation * UM,
                   "IF({degrees}>0,SQRT({squares}/MAX({degrees},1)),0)")
        yield _row("counted", Sentence("degrees of freedom that count, none of identical repeats"),
                   spread.degrees_of_freedom, f"IF({{pooled}}<{VISIBLE_STEP},0,{{degrees}})", "", "count")
        yield _row("widened", Sentence("spread, widened for few degrees of freedom"), found.widened * UM,
                   "IF({counted}>2,{pooled}*SQRT({counted}/MAX({counted}-2,1)),IF({counted}>0,{pooled}*SQRT(3),0))")
        yield _row("unrounded", Sentence("spread before rounding, from the steps below"), found.before_rounding * UM,
                   f"IF({{counted}}>0,{averaged},0)")
        yield _row("s", Sentence("spread s of one reading: of the repeats, or as stated"),
                   spread.standard_deviation * UM, f"IF({{counted}}=0,MAX({{repeatability}},0),{trusted})")
        yield _row("nu", Sentence("degrees of freedom ν of that spread"), freedom,
                   f"IF({{counted}}>0,IF({{s}}>{{unrounded}},{infinite},{{counted}}),{infinite})", "", "count")
        yield _row("persistent", Sentence("variance P of rounding that repeats do not average out"),
                   spread.persistent_variance * _UM2, _persistent("{s}", "{q}", "{roundings}"),
                   UnitOf("clearance_squared"))
        yield _row("averaged", Sentence("variance that repeats average out"), spread.averaged_variance * _UM2,
                   "IF({s}>0,{s}^2+{roundings}*{q}^2/12-{persistent},0)", UnitOf("clearance_squared"))
        yield _row("ovality", Sentence("ovality, root mean square over the lands that show it"),
                   (spread.ovality or 0.0) * UM, ovality)
        # fmt: on

    def _summed(self, part: Part, column: str) -> str:
        """Return the formula of the sum of a column of the readings over one part."""
        parts, values = self.readings.whole("part"), self.readings.whole(column)
        return "0" if values is None else f"SUMIF({parts},{quote(self.say.sentence(PART_WORDS[part]))},{values})"

    # --- Newton's steps

    def _newton(self, book: ReportBook, page: SheetPage, row: int) -> None:
        """Write Newton's steps to the spread s₀ that gives the widened spread after rounding, for both parts."""
        sheet = page.sheet
        page.text(row, 0, Sentence("Newton's steps to the spread before rounding"), bold=True)
        titles = [
            Sentence("s [{unit}]", unit=CLEARANCE),
            Sentence("excess of the variance [{unit}]", unit=UnitOf("clearance_squared")),
            Sentence("slope [{unit}]", unit=CLEARANCE),
        ]
        page.headings(row + 1, ["", Sentence("step, and term of the series"), *titles, *titles])
        first = row + 2
        name = sheet.get_name()
        ends = cell(first, 1, name), cell(first + _STEPS - 1, 1)
        book.workbook.define_name(_TERMS, f"={':'.join(ends)}")
        for number in range(_STEPS):
            book.put(sheet, first + number, 1, number + 1)
        for column, part in zip((_FIRST, _FIRST + 3), PARTS, strict=True):
            spread = self.uncertainty.repeats[part]
            book.put(sheet, row, column, PART_WORDS[part], book.bold)
            for at, step in enumerate(_newton(spread), start=first):
                for offset, content in enumerate(self._step(part, step, at, column, first)):
                    write_cell(book, sheet, at, column + offset, content)
            book.define(cells_of_part(part, "newton"), first + _STEPS - 1, column, name)

    def _step(self, part: Part, step: _Step, row: int, column: int, first: int) -> Iterable[LiveCell]:
        here, names = [address(row, column + offset) for offset in range(3)], _Names(part)
        before = [address(row - 1, column + offset) for offset in range(3)]
        spread = names["widened"] if row == first else f"MAX({before[0]}-{before[1]}/{before[2]},0)"
        q, r, widened = names["q"], names["roundings"], names["widened"]
        persistent = _persistent(here[0], q, r)
        a = _a(here[0], q, r)
        slope = f"IF({a}<1/2,SQRT({r}/PI())*{q},2*{here[0]}*(1+2*SUMPRODUCT(EXP(-{a}*{_TERMS}^2))))"
        yield LiveCell("nu", step.spread, spread, of="clearance")
        yield LiveCell(
            "scientific", step.excess, f"{here[0]}^2+{r}*{q}^2/12-{persistent}-{widened}^2", of="clearance_squared"
        )
        yield LiveCell("nu", step.slope, slope, of="clearance")


def _row(
    name: str,
    label: Sentence,
    value: float | str | None,
    text: str | None = None,
    unit: str | UnitOf = CLEARANCE,
    kind: str = "nu",
) -> NamedQuantity:
    return NamedQuantity(name, label, unit, kind, value, text)


def _of_instrument(known: Instrument) -> tuple[NamedQuantity, ...]:
    """Return what is known of an instrument, and what follows from it."""
    stated = None if known.repeatability is None else known.repeatability * UM
    # fmt: off
    return (
        _row("calibration", Sentence("standard uncertainty of its calibration"), known.calibration * UM),
        _row("common_part", Sentence("part of that variance that all its readings share"), known.common_part, unit="",
             kind="plain"),
        _row("resolution", Sentence("resolution"), known.resolution * UM),
        _row("repeatability", Sentence("repeatability as stated, one standard deviation"), stated),
        _row("expansion", Sentence("expansion of its scale or masters"), known.expansion * PER_KELVIN,
             unit=UnitOf("expansion"), kind="plain"),
    )
    # fmt: on


class _Names(dict[str, str]):
    """The names of the cells of one part."""

    def __init__(self, part: Part) -> None:
        super().__init__()
        self.part = part

    def __missing__(self, name: str) -> str:
        return cells_of_part(self.part, name)


def _a(s: str, q: str, roundings: str) -> str:
    return f"((2*PI()*{s}/{q})^2/{roundings})"


def _persistent(s: str, q: str, roundings: str) -> str:
    """Return the formula of `RepeatSpread.persistent_variance`; of a small a the sum is that after Poisson."""
    a = _a(s, q, roundings)
    few = f"PI()^2/(2*3)-SQRT(PI()*{a})+{a}/2"
    return f"{roundings}*{q}^2/(2*PI()^2)*IF({a}<1/2,{few},SUMPRODUCT(EXP(-{a}*{_TERMS}^2)/{_TERMS}^2))"


def _pooled(spread: RepeatSpread) -> PooledRepeats:
    """Return what the repeats of a part show; nothing where there are none."""
    return spread.pooled or PooledRepeats(0.0, 0, 0.0, 0.0, 0.0, 0.0)


def _newton(spread: RepeatSpread) -> list[_Step]:
    """Return Newton's steps from the widened spread; their last is the spread before rounding."""
    q, r, widened = spread.resolution * UM, spread.roundings, _pooled(spread).widened * UM
    steps, s = [], widened
    for _ in range(_STEPS):
        a = (2.0 * math.pi * s / q) ** 2 / r
        persistent = r * float(persistent_rounding_variance(q, s / math.sqrt(r)))
        excess = s * s + r * q * q / 12.0 - persistent - widened**2
        theta = 1.0 + 2.0 * math.fsum(math.exp(-a * k * k) for k in range(1, _STEPS + 1))
        slope = math.sqrt(r / math.pi) * q if a < 0.5 else 2.0 * s * theta
        steps.append(_Step(s, excess, slope))
        s = max(s - excess / slope, 0.0)
    return steps


BUDGET = Sentence("Uncertainty budget")
_SOURCE, _SHAPE, _NU, _U, _UNIT, _C, _CU, _PART = range(8)
_BESIDE = 9  # column of what the readings of the land give
_WIDTHS = (34, 20, 8, 12, 9, 17, 16, 14, 3, 52, 12, 12)
_BUDGET_NOTES = (
    Sentence("Which lands stand here, and the order of their sources, are as issued; all numbers follow."),
    Sentence(
        "k is that of a normal distribution for any degrees of freedom: the spread of few repeats is widened already "
        "(JCGM 101, 6.4.9), and a factor of Student's t would count that twice."
    ),
)


class BudgetCells:
    """The budgets of one unit."""

    def __init__(self, live: LiveSheets) -> None:
        self.diagnosis, self.readings, self.of_land, self.say = live.diagnosis, live.readings, live.of_land, live.say
        self.flagged = [land for land in self.diagnosis.flagged if land.uncertainty and land.uncertainty.u_clearance]

    def write(self, book: ReportBook, sheet: Worksheet) -> None:
        """Write a budget for every flagged land, the worst first."""
        page = SheetPage(book, sheet, _WIDTHS)
        notes = [self.say("annex.model"), self.say("annex.about_budgets"), *_BUDGET_NOTES]
        shown = self.flagged[:MOST_BUDGETS]
        if not shown:
            notes.append(Sentence("No land is flagged as issued."))
        elif len(shown) < len(self.flagged):
            text = Sentence(
                "Of {all} flagged lands the {count} worst; u of the others stands on the sheet of lands.",
                all=len(self.flagged),
                count=len(shown),
            )
            notes.append(text)
        for row, note in enumerate(notes):
            page.across(row, note)
        row = len(notes) + 1
        for land in shown:
            assert land.uncertainty is not None
            row = _Budget(book, sheet, self, land, land.uncertainty.sources).write(row) + 2


class _Budget:
    """The budget of one land."""

    def __init__(
        self,
        book: ReportBook,
        sheet: Worksheet,
        cells: BudgetCells,
        land: LandDiagnosis,
        sources: LandSources,
    ) -> None:
        self.book, self.sheet, self.cells, self.land, self.sources = book, sheet, cells, land, sources
        self.readings, self.say = cells.readings, cells.say
        self._of_land = partial(cells.of_land, land.key)
        self._beside: dict[tuple[Part, str], str] = {}  # the cells of what the readings give

    def write(self, row: int) -> int:
        """Write it; return its last row."""
        book, sheet, say = self.book, self.sheet, self.say
        component, number = self.land.key
        name = Name(self.cells.diagnosis.controller.components[component])
        book.put(sheet, row, 0, Sentence("{land} {name}", land=f"{component}/{number}", name=name), book.bold)
        book.put(sheet, row, _C, f"c_r [{say.unit('clearance')}]", book.form(align="right"))
        clearance = LiveCell(
            "um", self.land.state.radial_clearance * UM, self._of_land("c_r"), {"bold": True}, "clearance"
        )
        write_cell(book, sheet, row, _CU, clearance)
        book.headings(sheet, row + 1, [
            say("annex.source"), say("annex.distribution"), say("annex.degrees"), "u(x)", Sentence("unit"),
            Sentence("sensitivity c"), f"|c · u(x)| [{say.unit('clearance')}]", Sentence("part of the variance [%]"),
        ], _WIDTHS[:8])  # fmt: skip
        below = self._readings(row + 1)
        first, lines = row + 2, every_line(self.sources)
        last = first + len(lines) - 1
        whole = [address(last + number, _CU) for number in range(1, 5)]
        for at, line in enumerate(lines, start=first):
            for column, content in enumerate(self._line(line, at, whole[0])):
                write_cell(book, sheet, at, column, content)
        self._whole(last + 1, lines, (first, last), whole)
        return max(last + 4, below)

    # --- the sources

    def _line(self, line: BudgetLine, row: int, combined_cell: str) -> Iterable[LiveCell]:
        source, text, right = line.source, self._input(line), {"align": "right"}
        nu, u, c, contribution = (address(row, column) for column in (_NU, _U, _C, _CU))
        shape = self.say(f"annex.{source.shape}")
        kinds = [f"{shape}, {kind}" for kind in "AB"]
        free: LiveCell
        if source.kind == "repeats" and source.part is not None:
            known = line.degrees_of_freedom if line.statistical else INFINITE
            free = LiveCell("count", known, cells_of_part(source.part, "nu"), right)
            said = f"IF(ISNUMBER({nu}),{quote(kinds[0])},{quote(kinds[1])})"
        else:
            free, said = LiveCell("plain", INFINITE, look=right), None
        yield LiveCell("plain", self.say.get("uncertainty_sources", source.label))
        yield LiveCell("plain", kinds[0 if line.statistical else 1], said)
        yield free
        warm = line.input_kind == "temperature"
        of = "kelvin" if warm else "clearance"
        yield LiveCell("nu", line.input_uncertainty * (1.0 if warm else UM), text, of=of)
        yield LiveCell("plain", self.say.unit(of), look=AFTER_A_NUMBER)
        yield (
            LiveCell("nu", line.sensitivity * UM, self._of_temperature(), of="clearance_per_kelvin")
            if warm
            else LiveCell("plain", self._slope(line))
        )
        yield LiveCell("nu", abs(line.contribution) * UM, f"ABS({c}*{u})", of="clearance")
        share = f"IF({combined_cell}>0,({contribution}/{combined_cell})^2*100,0)"
        yield LiveCell("percent", line.fraction * PERCENT, share)

    def _slope(self, line: BudgetLine) -> float:
        """Return the change of c_r = (D − d)/2 with what a source is about; none of an error that both parts share."""
        counts = 1.0 - self.land.state.leak_weight  # of the diameters beside a vacuum test
        if line.input_kind == "clearance":
            return 1.0
        if line.source.kind != "common calibration":
            return counts * OF_A_DIAMETER
        return 0.0 if line.source.part is None else counts * SLOPES[line.source.part]

    def _input(self, line: BudgetLine) -> str | None:
        """Return the formula of the standard uncertainty of a source [µm, or K]; none of a vacuum test."""
        source, part = line.source, line.source.part or PARTS[0]
        match source.kind:
            case "common calibration":
                return cells_of_part(part, "common")
            case "calibration":
                return cells_of_part(part, "own")
            case "resolution":
                return f"SQRT({cells_of_part(part, 'persistent')}*{self._beside[part, 'rounding']})"
            case "repeats":
                return f"SQRT({cells_of_part(part, 'averaged')}*{self._beside[part, 'repeats']})"
            case "form":
                return self._form(part)
            case "measuring temperature":
                return f"{names.ROOM_TEMPERATURE}/SQRT(3)"
            case "nominal diameter":
                return names.NOMINAL_DIAMETER
            case "mounting clearance":
                return self._mounting()
            case _:
                return None

    def _form(self, part: Part) -> str:
        """Return the formula of what the form leaves uncertain of a diameter; see `uncertainty.sources`."""
        ovality, taper, lobes, rest = (self._beside[part, key] for key in ("ovality", "taper", "lobes", "residual"))
        seen = f"{ovality}^2+" if self._seen(part) is not None else ""  # only what was seen leaves a rest
        return f"SQRT(({ovality}*{lobes}/2)^2/2+({rest}*{names.FORM_RESIDUAL})^2*({seen}{taper}^2))"

    def _mounting(self) -> str:
        land = self.land.state.land
        if len(land.mounting_ends) > 1:
            return f"({self._of_land('c_m')}-{self._of_land('c_m_low')})/2/SQRT(3)"
        if land.mounting_tolerance is not None:
            return f"{self._of_land('tolerance')}/NORMSINV((1+{names.TOLERANCE_COVERAGE})/2)"
        return names.OWN_MOUNTING

    def _of_temperature(self) -> str:
        """Return the formula of the change of c_r with the temperature of measuring [µm/K]."""
        signs: dict[Part, str] = {"sleeve": "", "spool": "-"}
        terms = [
            f"{sign}({self._of_land(EXPANSIONS[part])}-{cells_of_part(part, 'expansion')})*{self._of_land(part)}"
            for part, sign in signs.items()
            if part in self.sources.plans
        ]
        counts = f"*{1.0 - self.land.state.leak_weight}" if self.land.state.leak else ""
        return f"({''.join(terms)})/2*0.001{counts}"

    # --- what the readings of the land give

    def _readings(self, row: int) -> int:
        """Write it beside the sources, a column for each part; return the last row."""
        book, sheet = self.book, self.sheet
        measured = [part for part in PARTS if part in self.sources.plans]
        headings = [Sentence("what its readings give"), *(PART_WORDS[part] for part in measured)]
        for column, name in enumerate(headings, start=_BESIDE):
            book.put(sheet, row, column, name, book.heading)
        below = row
        for column, part in enumerate(measured, start=_BESIDE + 1):
            for at, (key, (label, content)) in enumerate(self._of_part(part).items(), start=row + 1):
                book.put(sheet, at, _BESIDE, label)
                write_cell(book, sheet, at, column, content)
                self._beside[part, key], below = address(at, column), at
        return below

    def _of_part(self, part: Part) -> dict[str, tuple[Sentence, LiveCell]]:
        """Return what the readings of one part of the land give, each with its words."""
        sources, readings, key = self.sources, self.readings, self.land.key
        plan, places = sources.plans[part], readings.places_of(key, part)
        weight, means = readings.span("weight", places), readings.span("mean", places)
        of_one = readings.span("repeat_weight", places)
        apart = f"(MAX({means})-MIN({means}))*1000>={cells_of_part(part, 'q')}-{names.VISIBLE_STEP}"
        seen, state = self._seen(part), self.land.state
        taper = (state.spool_taper if part == "spool" else state.sleeve_taper) or 0.0
        shown = sources.spreads[part].ovality
        ovality = seen if seen is not None else shown if shown is not None else sources.assumptions.unseen_ovality
        text = cells_of_part(part, "ovality") if shown is not None else names.UNSEEN_OVALITY
        if seen is not None:
            text = readings.span(f"ovality_{part}", places[:1]).partition(":")[0]
        return {
            "repeats": (
                Sentence("variance of its mean per variance of a reading"),
                LiveCell("nu", plan.repeat_weight, f"SUMPRODUCT({weight},{weight},{of_one})"),
            ),
            "rounding": (
                Sentence("the same of rounding; 1 where its places round alike"),
                LiveCell("nu", plan.rounding_weight, f"IF({apart},SUMSQ({weight}),1)"),
            ),
            "ovality": (
                Sentence("ovality [{unit}]", unit=CLEARANCE),
                LiveCell("um", ovality * UM, text, of="clearance"),
            ),
            "taper": (
                Sentence("taper [{unit}]", unit=CLEARANCE),
                LiveCell("um", taper * UM, readings.taper(key, part), of="clearance"),
            ),
            "lobes": (Sentence("part of a two-lobe form that its directions leave"), LiveCell("nu", plan.two_lobe)),
            "residual": (Sentence("the same of other forms, of two directions 1"), LiveCell("nu", plan.residual)),
        }

    def _seen(self, part: Part) -> float | None:
        return self.land.state.spool_ovality if part == "spool" else self.land.state.sleeve_ovality

    # --- the whole

    def _whole(self, row: int, lines: Iterable[BudgetLine], rows: tuple[int, int], cells: list[str]) -> None:
        lines, (first, last) = list(lines), rows
        assert self.cells.diagnosis.uncertainty is not None
        u, coverage = combined(lines), self.cells.diagnosis.uncertainty.coverage
        nu, k = effective_degrees(lines), float(normal_quantile(0.5 + 0.5 * coverage))
        contributions = f"{address(first, _CU)}:{address(last, _CU)}"
        over = [
            f"IF(ISNUMBER({address(at, _NU)}),{address(at, _CU)}^4/MAX({address(at, _NU)},1),0)"
            for at, line in enumerate(lines, start=first)
            if line.source.kind == "repeats"
        ]
        over_all = "+".join(over) or "0"
        degrees = f"IF({over_all}>0,{cells[0]}^4/({over_all}),{quote(INFINITE)})" if over else quote(INFINITE)
        known = INFINITE if math.isinf(nu) else nu
        bold = {"bold": True}
        squares, factor = f"SQRT(SUMSQ({contributions}))", f"NORMSINV((1+{names.COVERAGE_NAME})/2)"
        expanded = f"{cells[2]}*{cells[0]}"
        whole = {
            Sentence("combined standard uncertainty u(c_r) [{unit}]", unit=CLEARANCE):
                LiveCell("nu", u * UM, squares, bold, "clearance"),
            Sentence("effective degrees of freedom (JCGM 100, G.4.1)"):
                LiveCell("degrees", known, degrees, {"align": "right"}),
            Sentence("coverage factor k, of a normal distribution"): LiveCell("nu", k, factor),
            Sentence("expanded uncertainty U = k · u(c_r) [{unit}]", unit=CLEARANCE):
                LiveCell("nu", k * u * UM, expanded, bold, "clearance"),
        }  # fmt: skip
        for at, (label, content) in enumerate(whole.items(), start=row):
            self.book.put(self.sheet, at, 0, label, self.book.bold)
            write_cell(self.book, self.sheet, at, _CU, content)
