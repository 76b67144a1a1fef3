"""Define what the sheets that compute have in common: cells, conditions, and the formulas that several of them use.

Formulas ask for constants, and for what belongs to the instrument of a part, by names. Those of a condition begin with
the condition's own; `RESERVED` are beginnings that no condition has.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.circuits import SECTIONS, Leak, Pressure
from atleak.catalogue.controller import Gap
from atleak.catalogue.instruments import Part
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.sentences import Sentence
from atleak.common.style import INPUT
from atleak.common.units import UnitOf
from atleak.common.verdicts import BANDS, VERDICTS, Verdict
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.engine.projection import Projection
from atleak.report.sheets.paging import LINE_OF_A_BOOK, row_height
from atleak.report.xlsx.book import Number, ReportBook, cell, cell_span, column_name, formula

RESERVED = frozenset({"const", "limit", "spool", "sleeve"})

CLEARANCE, LENGTH, PRESSURE, TEMPERATURE = map(UnitOf, ("clearance", "length", "pressure", "temperature"))
FLOW, LEAK, GAP_LEAK = map(UnitOf, ("flow", "leak", "gap_leak"))

REFERENCE = "const_reference_temperature"
MEASURED_AT = "const_measured_at"
GAIN = "const_eccentric_gain"
ECCENTRICITY = "const_eccentricity"
MEAN_OF_POSITIONS = "const_mean_eccentric"
FULLY = "const_fully_eccentric"
ENTRY_LOSS = "const_entry_loss"
D341_A, D341_B, D341_SHIFT, ABSOLUTE = "const_d341_A", "const_d341_B", "const_d341_shift", "const_zero_celsius"
DENSITY_AT, DENSITY_NAME, DENSITY_SLOPE_NAME = "const_density_at", "const_density", "const_density_slope"
STUDY_NAMES = ("const_study_nu", "const_study_exponent", "const_study_rho", "const_study_slope")
ROUNDING_NAME = "const_rounding"
NOTHING_DELIVERED = "const_no_delivery"
LARGEST_SHARE = "const_largest_share"
COVERAGE_NAME = "const_coverage"
ROOM_TEMPERATURE = "const_room_temperature"
FORM_RESIDUAL = "const_form_residual"
UNSEEN_OVALITY = "const_unseen_ovality"
NOMINAL_DIAMETER = "const_nominal_diameter"
OWN_MOUNTING = "const_own_mounting"
TOLERANCE_COVERAGE = "const_tolerance_coverage"
REPEATS_APART = "const_repeats_apart"
VISIBLE_STEP = "const_visible_step"
AVERAGED = "const_averaged_from"
TRUSTED_DEGREES = "const_trusted_degrees"


def of_limit(kind: str, part: str, level: str) -> str:
    """Return the name of a part of a limit, such as the growth that it asks for.

    >>> of_limit("wear", "limit", "watch"), of_limit("wear", "at_least", "watch")
    ('limit_wear_watch', 'limit_wear_at_least_watch')
    """
    return "_".join(("limit", kind, *(() if part == "limit" else (part,)), level))


def of_relation(section: str, what: str) -> str:
    """Return the name of a constant of the line that gives a section's pressure."""
    return f"const_{section}_{what}"


def share_of_pressure(pressure: Pressure) -> str:
    """Return the name of the share of a section's pressure that a gap sees."""
    return f"const_share_{_digits(pressure.coefficient)}"


def constant_pressure(pressure: Pressure) -> str:
    """Return the name of a pressure that stays the same."""
    return f"const_pressure_{_digits(pressure.constant)}_Pa"


def of_leak(number: int, what: str) -> str:
    """Return the name of a constant of a leak beside the lands."""
    return f"const_leak_{number}_{what}"


def of_tips(end: str, number: int, what: str) -> str:
    """Return the name of a constant of the slip over a pump's tips."""
    return f"const_tips{end}_{number}_{what}"


def cells_of_part(part: Part, what: str) -> str:
    """Return the name of a cell on the instrument of a part, or on what its repeats show."""
    return f"{part}_{what}"


def _digits(number: float) -> str:
    """Return the digits of a number as a name holds them: ``0.35`` is ``0_35``.

    >>> _digits(0.35), _digits(1e-07)
    ('0_35', '1em07')
    """
    return repr(number).replace(".", "_").replace("-", "m").replace("+", "")


CHANGEABLE: Mapping[str, Any] = {"font_color": INPUT, "locked": False}  # what an auditor may change
AFTER_A_NUMBER: Mapping[str, Any] = {"align": "left", "indent": 1}  # text to the right of a column of numbers
RANKED: tuple[Verdict, ...] = tuple(verdict for verdict in VERDICTS if verdict != Verdict.NOT_MEASURED)
_SHEET_NAME = 31  # characters that Excel allows in a sheet's name
_NOT_IN_A_SHEETS_NAME = re.compile(r"[\[\]:*?/\\'\x00-\x1f]")

ColumnKey = str | tuple[str, str]  # a name, or a name and the prefix of a condition
PER_KELVIN = 1e6  # expansions are shown in 1e-6/K
EXPANSIONS: Mapping[Part, ColumnKey] = {"spool": "beta_s", "sleeve": "beta_k"}  # columns of the sheet of lands


@dataclass(frozen=True)
class LiveCell:
    """The content of a cell: a value and, where it follows from other cells, the formula that gives it."""

    kind: str  # of number, one of the workbook's formats
    value: Any
    formula: str | None = None
    look: Mapping[str, Any] = field(default_factory=dict)
    of: str | None = None  # kind of quantity, in the unit of atleak's records; None of what has the same unit for all


def write_cell(
    book: ReportBook, sheet: Worksheet, row: int, column: int, content: LiveCell, of: str | None = None
) -> None:
    """Write a cell, of a kind of quantity unless its content says one; a formula that gives nothing is left out."""
    of = content.of or of
    form = book.form(content.kind, of, **content.look)
    known = content.value is not None and (content.formula is not None or not isinstance(content.value, str))
    if book.numbers is not None and known:
        book.numbers[sheet.get_name(), row, column] = Number(content.value, content.formula, form, of)
    if content.formula is None:
        book.put(sheet, row, column, content.value, form)
    elif content.value is not None:
        value = book.words(content.value) if isinstance(content.value, str) else content.value
        formula(sheet, row, column, content.formula, value, form)


LiveCells = Mapping[Any, str]  # the addresses of a row's cells by the keys of their columns


@dataclass(frozen=True)
class LiveColumn:
    """A column of a sheet that computes.

    Parameters
    ----------
    value
        what stands in an item's cell, in the column's unit when multiplied by ``times``; None where the sheet gives
        its cells itself
    formula
        what it follows from: a formula with ``{key}`` for the cell of another column in the same row, or a function of
        the item and those cells that gives one; None for what follows from nothing
    """

    key: ColumnKey
    heading: str
    kind: str = "plain"  # of number, one of the workbook's formats
    value: Callable[[Any], Any] | None = None
    formula: str | Callable[[Any, LiveCells], str | None] | None = None
    times: float | None = None
    width: int = 12
    look: Mapping[str, Any] = field(default_factory=dict)
    blue: bool = False  # to be changed where no formula gives it

    def cell(self, item: Any, here: LiveCells) -> LiveCell:
        """Return the content of an item's cell."""
        value = None if self.value is None else self.value(item)
        if value is not None and self.times is not None:
            value *= self.times
        text = self.formula
        if isinstance(text, str):
            text = text.format_map(here)
        elif text is not None:
            text = text(item, here)
        return LiveCell(self.kind, value, text, CHANGEABLE if self.blue and text is None else self.look, self.of)

    @cached_property
    def of(self) -> str | None:
        """Return the kind of quantity whose unit its heading names."""
        return _kind_named(self.heading)


def _kind_named(heading: Any) -> str | None:
    """Return the kind of quantity whose unit a heading names, or a heading that stands in it."""
    values = heading.values.values() if isinstance(heading, Sentence) else ()
    kinds = (each.kind if isinstance(each, UnitOf) else _kind_named(each) for each in values)
    return next((kind for kind in kinds if kind is not None), None)


class LiveSheet:
    """A sheet with a row for each item: where its cells stand, for all formulas, and how it is written."""

    def __init__(self, name: str, columns: Iterable[LiveColumn], items: Iterable[Any]) -> None:
        self.name, self.columns, self.items = name, list(columns), list(items)
        self.place: dict[Any, int] = {column.key: number for number, column in enumerate(self.columns)}

    def row(self, number: int) -> LiveCells:
        """Return the addresses of the cells of one row, for formulas of that row."""
        return {key: address(number, column) for key, column in self.place.items()}

    def cell(self, row: int, key: ColumnKey) -> str:
        """Return the address of a cell, for formulas of any sheet."""
        return cell(row, self.place[key], self.name)

    def span(self, first: int, last: int, key: ColumnKey) -> str:
        """Return the address of a stretch of a column, for formulas of any sheet."""
        return cell_span(first, last, self.place[key], self.name)

    def whole(self, key: ColumnKey) -> str:
        """Return the address of all cells of a column."""
        return self.span(1, len(self.items), key)

    def write(
        self,
        book: ReportBook,
        sheet: Worksheet,
        cells: Callable[[int, Any], Mapping[Any, LiveCell]] | None = None,
        *,
        printed: bool = True,
    ) -> None:
        """Write headings and a row per item, verdicts in their colours.

        ``cells`` gives those of a row, by its number and item; their columns do unless it is given.
        """
        widths = [column.width for column in self.columns]
        lines = book.headings(sheet, 0, [column.heading for column in self.columns], widths)
        rows = float(len(self.items))  # of one line
        for row, item in enumerate(self.items, start=1):
            here, height = self.row(row), LINE_OF_A_BOOK
            of_row = cells(row, item) if cells else {each.key: each.cell(item, here) for each in self.columns}
            for key, content in of_row.items():
                column = self.place[key]
                write_cell(book, sheet, row, column, content, self.columns[column].of)
                if "text_wrap" in content.look:
                    height = max(height, row_height([(book.words(content.value), widths[column])]))
            if height > LINE_OF_A_BOOK:
                sheet.set_row(row, height)
                rows += height / LINE_OF_A_BOOK - 1.0
        for number, width in enumerate(widths):
            sheet.set_column(number, number, width)
        if printed:
            book.print_table(sheet, len(self.items), widths, rows, lines)
        else:
            book.for_screen(sheet, len(self.items) + 1, len(self.columns))
        sheet.autofilter(0, 0, max(len(self.items), 1), len(self.columns) - 1)
        if "verdict" in self.place:
            book.colour_words(sheet, (1, self.place["verdict"]), (len(self.items), self.place["verdict"]), VERDICTS)


@dataclass(frozen=True)
class NamedQuantity:
    """A number of a sheet that stands in a cell with a name, by which formulas ask for it."""

    name: str  # of the cell; of one among several of its kind, without their prefix
    label: Sentence
    unit: str | UnitOf
    kind: str  # of number, one of the workbook's formats
    value: Any
    formula: str | None = None  # None for an input
    fixed: bool = False  # a result that no formula gives, or what the rows of other sheets rest on; not an input
    source: str = ""

    @property
    def heading(self) -> Sentence:
        """Return the label with its unit."""
        return Sentence("{label} [{unit}]", label=self.label, unit=self.unit) if self.unit else self.label

    def write(self, book: ReportBook, sheet: Worksheet, row: int, column: int, name: str) -> None:
        """Write its cell, blue where it may be changed, and give it its name."""
        look = {"align": "right", **(CHANGEABLE if self.formula is None and not self.fixed else {})}
        write_cell(book, sheet, row, column, LiveCell(self.kind, self.value, self.formula, look, self.of))
        book.define(name, row, column, sheet.get_name())

    @property
    def of(self) -> str | None:
        """Return its kind of quantity, where readers have it in units of their own."""
        return self.unit.kind if isinstance(self.unit, UnitOf) else None


@dataclass(frozen=True)
class SheetCondition:
    """One condition of the workbook: its projection, the prefix of its names and its sheet of gaps."""

    projection: Projection
    new: Projection  # of the same unit as it may have been when new
    prefix: str
    sheet: str
    label: str  # its name in the reader's language
    title: str  # that, or which of them is the stated one

    def __call__(self, name: str) -> str:
        """Return the workbook's name for one of the condition's quantities."""
        return f"{self.prefix}_{name}"

    def pressure(self, section: str) -> str:
        """Return the name of the pressure of a section or circuit, at the required main pressure."""
        return self(section if section in SECTIONS else f"c_{section}")

    def new_pressure(self, section: str) -> str:
        """Return the name of the same pressure of the same unit new: those of circuits differ."""
        return self(section if section in SECTIONS else f"new_c_{section}")


def sheet_conditions(diagnosis: Diagnosis, say: Wording) -> list[SheetCondition]:
    """Return every condition of a diagnosis with names that Excel takes, in the order in which people read them."""
    made: list[SheetCondition] = []
    gaps = say.sentence(Sentence("Gaps"))
    for at in diagnosis.presented:
        new, label = diagnosis.unworn_at(at), say.condition(at.condition)
        if at is diagnosis.projection:
            made.append(SheetCondition(at, new, "stated", gaps, label, say.sentence(Sentence("stated condition"))))
            continue
        name = at.condition.name
        prefix = f"_{name}" if name[0].isdigit() or name in RESERVED else name
        sheet = _free_name(f"{gaps} {_in_a_sheets_name(at.condition, say)}", made)
        made.append(SheetCondition(at, new, prefix, sheet, label, label))
    return made


def _in_a_sheets_name(point: OperatingPoint, say: Wording) -> str:
    """Return the name of an operating point, without its temperature, in letters that Excel takes in a sheet's name."""
    if say.language == "en" or point.name in say.table("conditions"):
        return say.get("conditions", point.name).replace("_", " ")
    label = say.name(point.label).removesuffix(f", {point.temperature:g} °C")
    return " ".join(_NOT_IN_A_SHEETS_NAME.sub(" ", label).split()) or point.name


def _free_name(wanted: str, made: Iterable[SheetCondition]) -> str:
    """Return the name of a new sheet of gaps: the one wanted, cut and numbered where it is too long or taken."""
    taken = {each.sheet.casefold() for each in made}
    name, number = wanted if len(wanted) <= _SHEET_NAME else f"{wanted[: _SHEET_NAME - 1].rstrip()}…", 1
    while name.casefold() in taken:
        number += 1
        ending = f" {number}"
        name = wanted[: _SHEET_NAME - len(ending)].rstrip() + ending
    return name


def component_width(components: Iterable[str]) -> int:
    """Return the width of a column with the components' numbers or names."""
    return max(12, *(len(each) + 3 for each in components))


# --- formulas


def fine_of(land: LandDiagnosis) -> Verdict:
    """Return the verdict of a land that has reached no limit: half a pair, or a sealed one, is never called ok."""
    return Verdict.OK if land.state.can_be_ok else Verdict.NOT_MEASURED


def quote(text: str) -> str:
    """Return a text as a formula takes it."""
    return '"' + text.replace('"', '""') + '"'


def verdict_of_rank(rank: str, say: Wording, fine: Verdict = Verdict.OK) -> str:
    """Return the formula of a verdict's sign and word, by its rank among those that can be given."""
    words = ",".join(quote(say.signed(verdict)) for verdict in (fine, *RANKED[1:]))
    return f"CHOOSE({rank},{words})"


def band_of_rank(rank: str, say: Wording) -> str:
    """Return the formula of a total's band, by the rank of the verdict that it counts as."""
    bands = ([band for band in BANDS if band.verdict.rank <= verdict.rank][-1] for verdict in RANKED)
    words = ",".join(quote(say.level(band)) for band in bands)
    return f"CHOOSE({rank},{words})"


def drop_between(ends: Gap | Leak, name_of: Callable[[str], str]) -> str:
    """Return the formula of a pressure drop [kPa]; ``name_of`` gives the name of the pressure of a section."""

    def term(pressure: Pressure) -> str:
        if pressure.section is None:
            return constant_pressure(pressure) if pressure.constant else ""
        name = name_of(pressure.section)
        return name if pressure.coefficient == 1.0 else f"{share_of_pressure(pressure)}*{name}"

    taken = term(ends.low)
    return (term(ends.high) or "0") + (f"-{taken}" if taken else "")


def share_of(leakage: str, capacity: str) -> str:
    """Return the formula of a share [%]: 0 without leakage, infinite where a pump without flow feeds any leakage."""
    return f"IF({capacity}>0,{leakage}/{capacity}*100,IF({leakage}>0,{NOTHING_DELIVERED},0))"


def warm_clearance(cold: str, spool: str, sleeve: str, expansions: tuple[str, str], temperature: str) -> str:
    """Return the formula of a mean clearance [µm] at a temperature [°C], eq. (2): zero where the spool binds.

    ``expansions`` are those of body and spool, the diameters those at the reference temperature.
    """
    body, of_spool = expansions
    opening = f"({body}*{sleeve}-{of_spool}*{spool})/2"
    return f"MAX({cold}+{opening}*({temperature}-{REFERENCE})*0.001,0)"


def largest_of(terms: Sequence[str]) -> str:
    """Return the formula of the largest of some terms; one term is itself."""
    return terms[0] if len(terms) == 1 else f"MAX({','.join(terms)})"


def address(row: int, column: int) -> str:
    """Return the address of a cell of the same sheet, free to move with its row."""
    return f"{column_name(column)}{row + 1}"
