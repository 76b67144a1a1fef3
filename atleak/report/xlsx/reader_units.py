"""Convert the cells that compute to the reader's units, and their formulas so that they take and give these.

Sheets are laid out in the units of atleak's records: mm, µm, kPa, dm³/min, °C. For a reader of other units every number
is converted where it stands. A formula computes in the units of the records all the same: it converts each cell that it
takes, and what it gives. So the equations of `docs/model.md` stand in it whatever the units, with factors beside cells.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from xlsxwriter.utility import xl_cell_to_rowcol

from atleak.common.units import ShownUnit
from atleak.report.xlsx.book import ReportBook, formula

_TOKEN = re.compile(
    r'"(?:[^"]|"")*"'  # a text
    r"|(?<![\w.])(?:(?:'[^']+'|[^\W\d]\w*)!)?\$?[A-Z]{1,3}\$?\d+(?::\$?[A-Z]{1,3}\$?\d+)?(?![\w(!])"  # cells
    r"|(?<![\w.])[^\W\d]\w*"  # a function or a name
    r"|[()]"
)
_COUNTS = {"COUNT", "COUNTIF", "COUNTIFS", "ROWS"}  # what they give has no unit, and cells are compared as they stand
_OR_NOTHING = re.compile(r'IF\(([^,()]+),(.*),""\)')  # a number under a condition, else an empty text


@dataclass
class _Call:
    """A function of a formula, or brackets, with what its result is multiplied by for the stretches of cells in it."""

    function: str
    start: int  # its place among the parts of the formula
    back: list[str] = field(default_factory=list)


def in_reader_units(book: ReportBook) -> None:
    """Convert every cell that computes; nothing for a reader of the units of atleak's records."""
    for (sheet, row, column), number in (book.numbers or {}).items():
        unit, value = _unit(book, number.of), number.value
        worksheet = book.workbook.get_worksheet_by_name(sheet)
        assert worksheet is not None
        shown = unit.shown(value) if unit is not None and not isinstance(value, str) else value
        if number.formula is not None:
            formula(worksheet, row, column, _formula(book, sheet, number.formula, unit), shown, number.form)
        elif unit is not None:
            worksheet.write_number(row, column, shown, number.form)


def _unit(book: ReportBook, kind: str | None) -> ShownUnit | None:
    """Return the unit of a kind of quantity, where it is another than that of atleak's records."""
    unit = None if kind is None else book.say.system[kind]
    return None if unit is None or (unit.factor, unit.offset) == (1.0, 0.0) else unit


def _formula(book: ReportBook, sheet: str, text: str, unit: ShownUnit | None) -> str:
    """Return a formula that takes cells in the reader's units and gives its result in ``unit``."""
    whole = _TOKEN.fullmatch(text)
    if whole is not None and _unit_of(book, sheet, text) is unit:
        return text  # the same quantity, as it stands elsewhere
    taken = _in_records(book, sheet, text)
    if unit is None:
        return taken
    branch = _OR_NOTHING.fullmatch(taken)
    return f'IF({branch[1]},{_given(branch[2], unit)},"")' if branch else _given(taken, unit)


def _in_records(book: ReportBook, sheet: str, text: str) -> str:
    """Return a formula with every cell that it takes converted to the unit of atleak's records."""
    parts, calls, last = list[str](), [_Call("", 0)], 0
    for match in _TOKEN.finditer(text):
        parts.append(text[last : match.start()])
        token, last = match[0], match.end()
        if token == "(":
            function = parts[-2] if len(parts) > 1 and not parts[-1] and parts[-2].isidentifier() else ""
            calls.append(_Call(function, len(parts) - 2 if function else len(parts)))
            parts.append(token)
        elif token == ")":
            call = calls.pop()
            parts.append(token)
            if call.back:
                parts[call.start] = f"({parts[call.start]}"
                parts.append(f"{''.join(call.back)})")
        else:
            unit = None if token.startswith('"') or text[last : last + 1] == "(" else _unit_of(book, sheet, token)
            if unit is None or calls[-1].function in _COUNTS:
                parts.append(token)
            elif ":" in token:
                parts.append(token)
                calls[-1].back += [_times(1.0 / unit.factor)] * (2 if calls[-1].function == "SUMSQ" else 1)
            else:
                parts.append(_carried(token, unit))
    return "".join([*parts, text[last:]])


def _unit_of(book: ReportBook, sheet: str, token: str) -> ShownUnit | None:
    """Return the unit of a cell, of the first number in a stretch of cells, or of what has a name."""
    numbers = book.numbers or {}
    if token in book.named:
        number = numbers.get(book.named[token])
        return None if number is None else _unit(book, number.of)
    there, _, cells = token.rpartition("!")
    first, _, last = cells.replace("$", "").partition(":")
    if not re.fullmatch(r"[A-Z]{1,3}\d+", first):
        return None
    (top, left), (bottom, right) = xl_cell_to_rowcol(first), xl_cell_to_rowcol(last or first)
    there = there.strip("'") or sheet
    places = ((there, row, column) for column in range(left, right + 1) for row in range(top, bottom + 1))
    number = next((numbers[place] for place in places if place in numbers), None)
    return None if number is None else _unit(book, number.of)


def _carried(token: str, unit: ShownUnit) -> str:
    shown = f"({token}-{unit.offset:g})" if unit.offset else token
    return f"({shown}{_times(1.0 / unit.factor)})"


def _given(text: str, unit: ShownUnit) -> str:
    return f"({text}){_times(unit.factor)}" + (f"+{unit.offset:g}" if unit.offset else "")


def _times(factor: float) -> str:
    """Return how a formula multiplies by a factor, or divides by its inverse where that is the shorter number."""
    by, over = (f"{each:.15g}".upper() for each in (factor, 1.0 / factor))
    return f"/{over}" if len(over) < len(by) else f"*{by}"
