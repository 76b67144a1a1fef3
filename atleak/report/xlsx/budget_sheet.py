"""Write the uncertainty budgets of the flagged lands, every number of them a formula.

Their sources and rows are those of `atleak.uncertainty.budget`, which the PDF prints too. A changed reading, a changed
number of an instrument or of an assumption reaches the combined uncertainty, its degrees of freedom and U.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING, Any

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.instruments import Part
from atleak.equations.uncertainty import normal_quantile
from atleak.land_diagnosis import LandDiagnosis
from atleak.report.xlsx import names
from atleak.report.xlsx.book import Book
from atleak.report.xlsx.instruments_sheet import INFINITE
from atleak.report.xlsx.live_cells import AFTER_A_NUMBER, EXPANSIONS, Cell, address, quote, write_cell
from atleak.report.xlsx.names import of_part
from atleak.report.xlsx.readings_sheet import PART_NAMES
from atleak.sentence import Name, Sentence
from atleak.uncertainty.budget import MOST_BUDGETS, BudgetLine, combined, effective_degrees, every_line
from atleak.uncertainty.sources import OF_A_DIAMETER, PARTS, SLOPES, LandSources
from atleak.workshop_units import PERCENT, UM

if TYPE_CHECKING:
    from atleak.report.xlsx.live import LiveSheets

BUDGET = Sentence("Uncertainty budget")
_SOURCE, _SHAPE, _NU, _U, _UNIT, _C, _CU, _PART = range(8)
_BESIDE = 9  # column of what the readings of the land give
_WIDTHS = (34, 20, 8, 12, 9, 17, 16, 14, 3, 52, 12, 12)
_NOTES = (
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

    def write(self, book: Book, sheet: Worksheet) -> None:
        """Write a budget for every flagged land, the worst first."""
        for column, width in enumerate(_WIDTHS):
            sheet.set_column(column, column, width)
        notes = [self.say("annex.model"), self.say("annex.about_budgets"), *_NOTES]
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
            book.put(sheet, row, 0, note)
        row = len(notes) + 1
        for land in shown:
            assert land.uncertainty is not None
            row = _Budget(book, sheet, self, land, land.uncertainty.sources).write(row) + 2


class _Budget:
    """The budget of one land."""

    def __init__(
        self,
        book: Book,
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
        book.put(sheet, row, _C, "c_r [µm]", book.form(align="right"))
        clearance = Cell("um", self.land.state.radial_clearance * UM, self._of_land("c_r"), {"bold": True})
        write_cell(book, sheet, row, _CU, clearance)
        book.headings(sheet, row + 1, [
            say("annex.source"), say("annex.distribution"), say("annex.degrees"), "u(x)", Sentence("unit"),
            Sentence("sensitivity c"), "|c · u(x)| [µm]", Sentence("part of the variance [%]"),
        ])  # fmt: skip
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

    def _line(self, line: BudgetLine, row: int, combined_cell: str) -> Iterable[Cell]:
        source, text, right = line.source, self._input(line), {"align": "right"}
        nu, u, c, contribution = (address(row, column) for column in (_NU, _U, _C, _CU))
        shape = self.say(f"annex.{source.shape}")
        kinds = [f"{shape}, {kind}" for kind in "AB"]
        free: Cell
        if source.kind == "repeats" and source.part is not None:
            known = line.degrees_of_freedom if line.statistical else INFINITE
            free = Cell("count", known, of_part(source.part, "nu"), right)
            said = f"IF(ISNUMBER({nu}),{quote(kinds[0])},{quote(kinds[1])})"
        else:
            free, said = Cell("plain", INFINITE, look=right), None
        yield Cell("plain", self.say.get("uncertainty_sources", source.label))
        yield Cell("plain", kinds[0 if line.statistical else 1], said)
        yield free
        warm = line.input_kind == "temperature"
        yield Cell("nu", line.input_uncertainty * (1.0 if warm else UM), text)
        yield Cell("plain", "K" if warm else "µm", look=AFTER_A_NUMBER)
        yield Cell("nu", line.sensitivity * UM, self._of_temperature()) if warm else Cell("plain", self._slope(line))
        yield Cell("nu", abs(line.contribution) * UM, f"ABS({c}*{u})")
        share = f"IF({combined_cell}>0,({contribution}/{combined_cell})^2*100,0)"
        yield Cell("percent", line.fraction * PERCENT, share)

    def _slope(self, line: BudgetLine) -> float:
        """Return the change of c_r = (D − d)/2 with what a source is about; none of an error that both parts share."""
        if line.input_kind == "clearance":
            return 1.0
        if line.source.kind != "common calibration":
            return OF_A_DIAMETER
        return 0.0 if line.source.part is None else SLOPES[line.source.part]

    def _input(self, line: BudgetLine) -> str:
        """Return the formula of the standard uncertainty of what a source is about [µm, or K]."""
        source, part = line.source, line.source.part or PARTS[0]
        match source.kind:
            case "common calibration":
                return of_part(part, "common")
            case "calibration":
                return of_part(part, "own")
            case "resolution":
                return f"SQRT({of_part(part, 'persistent')}*{self._beside[part, 'rounding']})"
            case "repeats":
                return f"SQRT({of_part(part, 'averaged')}*{self._beside[part, 'repeats']})"
            case "form":
                return self._form(part)
            case "measuring temperature":
                return f"{names.ROOM_TEMPERATURE}/SQRT(3)"
            case "nominal diameter":
                return names.NOMINAL_DIAMETER
            case "mounting clearance":
                return self._mounting()

    def _form(self, part: Part) -> str:
        """Return the formula of what the form leaves uncertain of a diameter; see `atleak.uncertainty.sources`."""
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
            f"{sign}({self._of_land(EXPANSIONS[part])}-{of_part(part, 'expansion')})*{self._of_land(part)}"
            for part, sign in signs.items()
            if part in self.sources.plans
        ]
        return f"({''.join(terms)})/2*0.001"

    # --- what the readings of the land give

    def _readings(self, row: int) -> int:
        """Write it beside the sources, a column for each part; return the last row."""
        book, sheet = self.book, self.sheet
        measured = [part for part in PARTS if part in self.sources.plans]
        headings = [Sentence("what its readings give"), *(PART_NAMES[part] for part in measured)]
        for column, name in enumerate(headings, start=_BESIDE):
            book.put(sheet, row, column, name, book.heading)
        below = row
        for column, part in enumerate(measured, start=_BESIDE + 1):
            for at, (key, (label, content)) in enumerate(self._of_part(part).items(), start=row + 1):
                book.put(sheet, at, _BESIDE, label)
                write_cell(book, sheet, at, column, content)
                self._beside[part, key], below = address(at, column), at
        return below

    def _of_part(self, part: Part) -> dict[str, tuple[Sentence, Cell]]:
        """Return what the readings of one part of the land give, each with its words."""
        sources, readings, key = self.sources, self.readings, self.land.key
        plan, places = sources.plans[part], readings.places_of(key, part)
        weight, means = readings.span("weight", places), readings.span("mean", places)
        of_one = readings.span("repeat_weight", places)
        apart = f"(MAX({means})-MIN({means}))*1000>={of_part(part, 'q')}-{names.VISIBLE_STEP}"
        seen, state = self._seen(part), self.land.state
        taper = (state.spool_taper if part == "spool" else state.sleeve_taper) or 0.0
        shown = sources.spreads[part].ovality
        ovality = seen if seen is not None else shown if shown is not None else sources.assumptions.unseen_ovality
        text = of_part(part, "ovality") if shown is not None else names.UNSEEN_OVALITY
        if seen is not None:
            text = readings.span(f"ovality_{part}", places[:1]).partition(":")[0]
        return {
            "repeats": (
                Sentence("variance of its mean per variance of a reading"),
                Cell("nu", plan.repeat_weight, f"SUMPRODUCT({weight},{weight},{of_one})"),
            ),
            "rounding": (
                Sentence("the same of rounding; 1 where its places round alike"),
                Cell("nu", plan.rounding_weight, f"IF({apart},SUMSQ({weight}),1)"),
            ),
            "ovality": (Sentence("ovality [µm]"), Cell("um", ovality * UM, text)),
            "taper": (Sentence("taper [µm]"), Cell("um", taper * UM, readings.taper(key, part))),
            "lobes": (Sentence("part of a two-lobe form that its directions leave"), Cell("nu", plan.two_lobe)),
            "residual": (Sentence("the same of other forms, of two directions 1"), Cell("nu", plan.residual)),
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
        squares, factor = f"SQRT(SUMSQ({contributions}))", f"NORMSINV((1+{names.COVERAGE})/2)"
        whole: dict[Sentence, tuple[str, Any, str, dict[str, Any]]] = {
            Sentence("combined standard uncertainty u(c_r) [µm]"): ("nu", u * UM, squares, bold),
            Sentence("effective degrees of freedom (JCGM 100, G.4.1)"): ("degrees", known, degrees, {"align": "right"}),
            Sentence("coverage factor k, of a normal distribution"): ("nu", k, factor, {}),
            Sentence("expanded uncertainty U = k · u(c_r) [µm]"): ("nu", k * u * UM, f"{cells[2]}*{cells[0]}", bold),
        }
        for at, (label, content) in enumerate(whole.items(), start=row):
            self.book.put(self.sheet, at, 0, label, self.book.bold)
            write_cell(self.book, self.sheet, at, _CU, Cell(*content))
