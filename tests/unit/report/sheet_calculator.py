"""A referee for the workbook: calculates its formulas from its inputs, independently of atleak and of any office suite.

Knows just the functions a report uses; an unknown one fails loudly.
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import openpyxl
from openpyxl.formula import Tokenizer
from openpyxl.utils import range_boundaries


def _flat(values: tuple[Any, ...]) -> list[Any]:
    flat: list[Any] = []
    for value in values:
        flat += _flat(tuple(value)) if isinstance(value, list) else [] if value is None else [value]
    return flat


def _shown(value: Any) -> Any:
    """A cell that holds an empty text shows nothing."""
    return None if isinstance(value, str) and not value else value


def _meets(cell: Any, key: str) -> bool:
    return cell > float(key[1:]) if key[:1] == ">" else cell == key


_FUNCTIONS = {
    "SUM": lambda *v: math.fsum(_flat(v)),
    "AVERAGE": lambda *v: math.fsum(_flat(v)) / len(_flat(v)),
    "MAX": lambda *v: max(_flat(v)),
    "MIN": lambda *v: min(_flat(v)),
    "IF": lambda test, yes, no: yes if test else no,
    "SUMIF": lambda keys, key, v: math.fsum(x for k, x in zip(_flat((keys,)), _flat((v,)), strict=True) if k == key),
    "SUMPRODUCT": lambda *v: math.fsum(math.prod(terms) for terms in zip(*map(_flat, zip(v)), strict=True)),
    "COUNTIF": lambda cells, key: sum(_meets(cell, key) for cell in _flat((cells,))),
    "LARGE": lambda cells, place: sorted(_flat((cells,)), reverse=True)[int(place) - 1],
    "MATCH": lambda value, cells, _: cells.index(value) + 1,
    "INDEX": lambda cells, *place: cells[int(place[-1]) - 1],
    "CONCATENATE": lambda *v: "".join(f"{each:g}" if isinstance(each, int | float) else each for each in v),
    "ROUND": lambda v, digits: math.floor(v * 10**digits + 0.5) / 10**digits,
    "INT": math.floor,
    "MOD": lambda v, by: v % by,
    "CHOOSE": lambda n, *v: v[int(n) - 1],
    "ABS": abs,
    "PI": lambda: math.pi,
    "LOG10": math.log10,
    "EXP": math.exp,
    "SQRT": math.sqrt,
    "AND": lambda *v: all(_flat(v)),
    "OR": lambda *v: any(_flat(v)),
    "ISNUMBER": lambda v: isinstance(v, int | float) and not math.isnan(v),
    "LOWER": str.lower,
    "FIND": lambda what, text: text.find(what) + 1 or "#VALUE!",
}


class SheetCalculator:
    """A workbook whose cells can be set and asked for; formulas are calculated when asked."""

    def __init__(self, content: bytes) -> None:
        self.book = openpyxl.load_workbook(io.BytesIO(content))
        self.content = content
        self.known: dict[tuple[str, str], Any] = {}

    def cached(self) -> dict[tuple[str, str], Any]:
        """What the file gives for its cells, by (sheet, address), before anything is calculated."""
        book = openpyxl.load_workbook(io.BytesIO(self.content), read_only=True, data_only=True)
        rows = ((sheet, row) for sheet in book for row in sheet.iter_rows())
        return {
            (sheet.title, cell.coordinate): cell.value for sheet, row in rows for cell in row if cell.value is not None
        }

    def formulas(self) -> list[tuple[str, str]]:
        """(sheet, address) of every cell with a formula."""
        return [
            (sheet.title, cell.coordinate)
            for sheet in self.book
            for row in sheet.iter_rows()
            for cell in row
            if cell.data_type == "f"
        ]

    def wrong(self) -> list[Any]:
        """The formulas that do not give their cached value."""
        formulas, cached = self.formulas(), self.cached()
        assert formulas
        found = [(*at, self.value(*at), cached.get(at)) for at in formulas]
        return [each for each in found if not same(*map(_shown, each[2:]))]

    def set(self, sheet: str, address: str, value: Any) -> None:
        self.book[sheet][address].value = value
        self.known.clear()

    def value(self, sheet: str, address: str) -> Any:
        key = (sheet, address.replace("$", ""))
        if key not in self.known:
            cell = self.book[sheet][key[1]]
            result = self._calculate(sheet, cell.value) if cell.data_type == "f" else cell.value
            self.known[key] = np.float64(result) if isinstance(result, int | float) else result
        return self.known[key]

    def _calculate(self, sheet: str, formula: str) -> Any:
        text = ""
        for token in Tokenizer(formula).items:
            match token.type, token.subtype:
                case "FUNC", "OPEN":
                    text += f"_f[{token.value[:-1]!r}]("
                case ("FUNC", "CLOSE") | ("PAREN", _) | ("SEP", _):
                    text += token.value
                case "OPERAND", "RANGE":
                    text += f"_r({sheet!r},{token.value!r})"
                case "OPERAND", "TEXT":
                    text += repr(token.value[1:-1])
                case "OPERAND", "NUMBER":
                    text += f"float({token.value!r})"
                case ("OPERATOR-INFIX", _) | ("OPERATOR-PREFIX", _):
                    text += {"^": "**"}.get(token.value, token.value)
                case "WHITE-SPACE", _:
                    pass
                case _:
                    raise AssertionError(f"unknown token {token.value!r} in {formula}")
        with np.errstate(all="ignore"):  # the branch of an IF that is not taken may divide by zero
            return eval(text, {"__builtins__": {}, "float": np.float64}, {"_f": _FUNCTIONS, "_r": self._range})

    def _range(self, sheet: str, text: str) -> Any:
        if "!" not in text and text in self.book.defined_names:
            text = self.book.defined_names[text].attr_text
        name, _, address = text.rpartition("!")
        name = name.strip("'") or sheet
        left, top, right, bottom = range_boundaries(address)
        if (left, top) == (right, bottom):
            return self.value(name, address.partition(":")[0])
        cells = self.book[name].iter_rows(top, bottom, left, right)
        return [self.value(name, cell.coordinate) for row in cells for cell in row]


def differing(book: openpyxl.Workbook, value: Callable[[str, str], Any], expected: openpyxl.Workbook) -> list[Any]:
    """The formulas that do not give what another workbook holds, but for lists that stay as issued."""
    wrong, compared = [], 0
    for sheet in book:
        last = sheet.max_row
        if sheet.title == "Summary":
            last = next(row[0].row for row in sheet.iter_rows() if str(row[0].value).startswith("Flagged lands"))
        for cells in sheet.iter_rows(max_row=last):
            for cell in cells:
                heading = str(sheet.cell(1, cell.column).value)
                if cell.data_type == "f" and not heading.startswith("order among those flagged since"):
                    compared += 1
                    found, wanted = value(sheet.title, cell.coordinate), expected[sheet.title][cell.coordinate].value
                    if not same(found, wanted):
                        wrong.append((sheet.title, cell.coordinate, found, wanted))
    assert compared > 300
    return wrong


def same(left: object, right: object) -> bool:
    if isinstance(left, int | float) and isinstance(right, int | float):
        return abs(left - right) <= 1e-9 * max(abs(left), abs(right)) + 1e-9
    return left == right
