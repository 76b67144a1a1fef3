"""Write the sheet of instruments: what is known of each, and what the repeats of this unit show of their spread.

Every step from the repeats to the spread of one reading is a formula: see `atleak.uncertainty.sources`. The spread
before rounding is the root of an equation; Newton's steps to it stand below.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.instruments import Instrument, Part
from atleak.equations.uncertainty import persistent_rounding_variance
from atleak.report.xlsx.book import Book, cell
from atleak.report.xlsx.live_cells import PER_KELVIN, Cell, Quantity, address, quote, write_cell
from atleak.report.xlsx.names import AVERAGED, TRUSTED_DEGREES, VISIBLE_STEP, of_part
from atleak.report.xlsx.readings_sheet import PART_NAMES, ReadingCells
from atleak.sentence import Name, Sentence
from atleak.uncertainty import UnitUncertainty
from atleak.uncertainty.sources import PARTS, PooledRepeats, RepeatSpread
from atleak.wording import Wording
from atleak.workshop_units import UM

INSTRUMENTS = Sentence("Instruments")
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

    def write(self, book: Book, sheet: Worksheet) -> None:
        """Write a column for each part, every cell a name that budgets ask for."""
        headings = (Sentence("quantity"), Sentence("unit"), *(PART_NAMES[part] for part in PARTS))
        book.headings(sheet, 0, headings, lines=1)
        instruments = self.uncertainty.instruments
        book.put(sheet, 1, 0, Sentence("instrument"), book.bold)
        columns = [list(self._rows(part)) for part in PARTS]
        for column, part in enumerate(PARTS, start=_FIRST):
            book.put(sheet, 1, column, Name(instruments.of(part).name), book.wrapped)
        for row, rows in enumerate(zip(*columns, strict=True), start=2):
            book.put(sheet, row, 0, rows[0].label, book.bold)
            book.put(sheet, row, 1, rows[0].unit)
            for column, (part, each) in enumerate(zip(PARTS, rows, strict=True), start=_FIRST):
                each.write(book, sheet, row, column, of_part(part, each.name))
        last = 2 + len(columns[0])
        for row, note in enumerate((*(Name(each.source) for each in self._known()), *_NOTES), start=last + 1):
            book.put(sheet, row, 0, note)
        self._newton(book, sheet, last + 6)
        sheet.set_column(0, 0, 62)
        sheet.set_column(1, 1, 12)
        sheet.set_column(2, 7, 24)

    def _known(self) -> list[Instrument]:
        both = (self.uncertainty.instruments.of(part) for part in PARTS)
        return list({each.id: each for each in both}.values())

    def _rows(self, part: Part) -> Iterable[Quantity]:
        """Return what stands in a part's column: its instrument, then what its repeats show, each step a formula."""
        instruments, named = self.uncertainty.instruments, _Names(part)
        same = part == PARTS[1] and instruments.spool == instruments.sleeve  # then its numbers stand once
        known = instruments.of(part)
        for each in _of_instrument(known):
            yield replace(each, formula=of_part(PARTS[0], each.name)) if same else each
        common, own = Sentence("u of the error that all its readings share"), Sentence("u of the calibration's rest")
        follow = (
            _row("common", common, known.common * UM, "{calibration}*SQRT({common_part})"),
            _row("own", own, known.own * UM, "{calibration}*SQRT(1-{common_part})"),
        )
        for each in (*follow, *self._of_repeats(part, self.uncertainty.repeats[part])):
            yield each if each.formula is None else replace(each, formula=each.formula.format_map(named))

    def _of_repeats(self, part: Part, spread: RepeatSpread) -> Iterable[Quantity]:
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
        yield Quantity("roundings", Sentence("roundings in one diameter"), "", "count", spread.roundings, fixed=True)
        yield _row("squares", Sentence("sum of squares of the repeats"), found.squares * _UM2, squares, "µm²")
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
                   spread.persistent_variance * _UM2, _persistent("{s}", "{q}", "{roundings}"), "µm²")
        yield _row("averaged", Sentence("variance that repeats average out"), spread.averaged_variance * _UM2,
                   "IF({s}>0,{s}^2+{roundings}*{q}^2/12-{persistent},0)", "µm²")
        yield _row("ovality", Sentence("ovality, root mean square over the lands that show it"),
                   (spread.ovality or 0.0) * UM, ovality)
        # fmt: on

    def _summed(self, part: Part, column: str) -> str:
        """Return the formula of the sum of a column of the readings over one part."""
        parts, values = self.readings.whole("part"), self.readings.whole(column)
        return "0" if values is None else f"SUMIF({parts},{quote(self.say.sentence(PART_NAMES[part]))},{values})"

    # --- Newton's steps

    def _newton(self, book: Book, sheet: Worksheet, row: int) -> None:
        """Write Newton's steps to the spread s₀ that gives the widened spread after rounding, for both parts."""
        book.put(sheet, row, 0, Sentence("Newton's steps to the spread before rounding"), book.bold)
        titles = [Sentence("s [µm]"), Sentence("excess of the variance [µm²]"), Sentence("slope [µm]")]
        book.headings(sheet, row + 1, ["", Sentence("step, and term of the series"), *titles, *titles], lines=3)
        first = row + 2
        name = sheet.get_name()
        ends = cell(first, 1, name), cell(first + _STEPS - 1, 1)
        book.workbook.define_name(_TERMS, f"={':'.join(ends)}")
        for number in range(_STEPS):
            book.put(sheet, first + number, 1, number + 1)
        for column, part in zip((_FIRST, _FIRST + 3), PARTS, strict=True):
            spread = self.uncertainty.repeats[part]
            book.put(sheet, row, column, PART_NAMES[part], book.bold)
            for at, step in enumerate(_newton(spread), start=first):
                for offset, content in enumerate(self._step(part, step, at, column, first)):
                    write_cell(book, sheet, at, column + offset, content)
            book.workbook.define_name(of_part(part, "newton"), f"={cell(first + _STEPS - 1, column, name)}")

    def _step(self, part: Part, step: _Step, row: int, column: int, first: int) -> Iterable[Cell]:
        here, names = [address(row, column + offset) for offset in range(3)], _Names(part)
        before = [address(row - 1, column + offset) for offset in range(3)]
        spread = names["widened"] if row == first else f"MAX({before[0]}-{before[1]}/{before[2]},0)"
        q, r, widened = names["q"], names["roundings"], names["widened"]
        persistent = _persistent(here[0], q, r)
        a = _a(here[0], q, r)
        slope = f"IF({a}<1/2,SQRT({r}/PI())*{q},2*{here[0]}*(1+2*SUMPRODUCT(EXP(-{a}*{_TERMS}^2))))"
        yield Cell("nu", step.spread, spread)
        yield Cell("scientific", step.excess, f"{here[0]}^2+{r}*{q}^2/12-{persistent}-{widened}^2")
        yield Cell("nu", step.slope, slope)


def _row(
    name: str, label: Sentence, value: float | str | None, text: str | None = None, unit: str = "µm", kind: str = "nu"
) -> Quantity:
    return Quantity(name, label, unit, kind, value, text)


def _of_instrument(known: Instrument) -> tuple[Quantity, ...]:
    """Return what is known of an instrument, and what follows from it."""
    stated = None if known.repeatability is None else known.repeatability * UM
    # fmt: off
    return (
        _row("calibration", Sentence("standard uncertainty of its calibration"), known.calibration * UM),
        _row("common_part", Sentence("part of that variance that all its readings share"), known.common_part, unit="",
             kind="plain"),
        _row("resolution", Sentence("resolution"), known.resolution * UM),
        _row("repeatability", Sentence("repeatability as stated, one standard deviation"), stated),
        _row("expansion", Sentence("expansion of its scale or masters"), known.expansion * PER_KELVIN, unit="1e-6/K",
             kind="plain"),
    )
    # fmt: on


class _Names(dict[str, str]):
    """The names of the cells of one part."""

    def __init__(self, part: Part) -> None:
        super().__init__()
        self.part = part

    def __missing__(self, name: str) -> str:
        return of_part(self.part, name)


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
