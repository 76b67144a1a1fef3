"""A referee for the workbook: calculates its formulas from its inputs, independently of atleak and of any office suite.

Knows just the functions a report uses; an unknown one fails loudly.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable
from statistics import NormalDist
from typing import Any

import numpy as np
import openpyxl
from openpyxl.utils import get_column_letter
from openpyxl.utils.cell import coordinate_to_tuple


def _flat(values: tuple[Any, ...]) -> list[Any]:
    flat: list[Any] = []
    for value in values:
        listed = isinstance(value, list | np.ndarray)
        flat += _flat(tuple(value)) if listed else [] if value is None else [value]
    return flat


def _numbers(values: tuple[Any, ...]) -> list[float]:
    """What functions of statistics see of cells: their numbers, not their texts."""
    return [value for value in _flat(values) if not isinstance(value, str)]


def _shown(value: Any) -> Any:
    """A cell that holds an empty text shows nothing."""
    return None if isinstance(value, str) and not value else value


def _meets(cell: Any, key: str) -> bool:
    return cell > float(key[1:]) if key[:1] == ">" else cell == key


def _rows(*stretches: Any) -> Any:
    """The rows of several stretches of cells, of which each may be one cell."""
    return zip(*(cells if isinstance(cells, list) else [cells] for cells in stretches), strict=True)


def _counted(*cells_and_keys: Any) -> int:
    """The rows in which every stretch of cells holds what is asked of it."""
    rows = _rows(*cells_and_keys[::2])
    return sum(all(cell == key for cell, key in zip(row, cells_and_keys[1::2], strict=True)) for row in rows)


def _chosen(keys: Any, key: str, values: Any) -> list[float]:
    return [value for name, value in _rows(keys, values) if name == key and value is not None]


def _products(stretches: tuple[Any, ...]) -> Any:
    return zip(*map(_flat, zip(stretches)), strict=True)


_FUNCTIONS = {
    "SUM": lambda *v: math.fsum(_numbers(v)),
    "AVERAGE": lambda *v: math.fsum(_numbers(v)) / len(_numbers(v)),
    "AVERAGEIF": lambda keys, key, values: math.fsum(_chosen(keys, key, values)) / len(_chosen(keys, key, values)),
    "COUNT": lambda *v: len(_numbers(v)),
    "COUNTIFS": _counted,
    "ROWS": lambda cells: len(cells) if isinstance(cells, list) else 1,
    "SUMSQ": lambda *v: math.fsum(value * value for value in _numbers(v)),
    "NORMSINV": lambda p: NormalDist().inv_cdf(p),
    "MAX": lambda *v: max(_numbers(v), default=0.0),
    "MIN": lambda *v: min(_numbers(v), default=0.0),
    "IF": lambda test, yes, no: yes if test else no,
    "SUMIF": lambda keys, key, values: math.fsum(_chosen(keys, key, values)),
    "SUMPRODUCT": lambda *v: math.fsum(math.prod(each or 0.0 for each in row) for row in _products(v)),
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
    "EXP": np.exp,
    "SQRT": math.sqrt,
    "SINH": math.sinh,
    "ASINH": math.asinh,
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
        self.sheets = {sheet.title: sheet for sheet in self.book}
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
            cell = self.sheets[sheet][key[1]]
            result = self._calculate(sheet, cell.value) if cell.data_type == "f" else cell.value
            self.known[key] = np.float64(result) if isinstance(result, int | float) else result
        return self.known[key]

    def _calculate(self, sheet: str, formula: str) -> Any:
        text, at = "", 1
        while at < len(formula):
            token = _TOKEN.match(formula, at)
            assert token, f"unknown at {at} in {formula}"
            text += _PYTHON[token.lastgroup](token[0], sheet)  # type: ignore[index]
            at = token.end()
        with np.errstate(all="ignore"):  # the branch of an IF that is not taken may divide by zero
            return eval(text, {"__builtins__": {}, "float": np.float64}, {"_f": _FUNCTIONS, "_r": self._range})

    def _range(self, sheet: str, text: str) -> Any:
        named = "!" not in text and text in self.book.defined_names
        if named:
            text = self.book.defined_names[text].attr_text
        name, _, address = text.replace("$", "").rpartition("!")
        name = name.strip("'") or sheet
        if ":" not in address:
            return self.value(name, address)
        (left, top), (right, bottom) = map(_place, address.split(":"))
        if (left, top) == (right, bottom):
            return self.value(name, address.partition(":")[0])
        columns = [get_column_letter(number) for number in range(left, right + 1)]
        values = [self.value(name, f"{letter}{row}") for row in range(top, bottom + 1) for letter in columns]
        return np.array(values) if named else values  # with a name, to be calculated with cell by cell


_TOKEN = re.compile(
    r"""(?P<text>"(?:[^"]|"")*")
    |(?P<function>[A-Z][A-Z0-9]*\()
    |(?P<cells>(?:(?:'[^']+'|\w+)!)?\$?[A-Z]{1,3}\$?[0-9]+(?![\w.])(?::\$?[A-Z]{1,3}\$?[0-9]+)?|[^\W\d][\w.]*)
    |(?P<number>[0-9]+\.?[0-9]*(?:E[+-]?[0-9]+)?)
    |(?P<sign><=|>=|<>|[-+*/^(),<>=])""",
    re.VERBOSE,
)
_SIGNS = {"^": "**", "=": "==", "<>": "!="}
_PYTHON: dict[str, Callable[[str, str], str]] = {
    "text": lambda token, _: repr(token[1:-1].replace('""', '"')),
    "function": lambda token, _: f"_f[{token[:-1]!r}](",
    "cells": lambda token, sheet: f"_r({sheet!r},{token!r})",
    "number": lambda token, _: f"float({token!r})",
    "sign": lambda token, _: _SIGNS.get(token, token),
}


def _place(address: str) -> tuple[int, int]:
    row, column = coordinate_to_tuple(address)
    return column, row


def differing(book: openpyxl.Workbook, value: Callable[[str, str], Any], expected: openpyxl.Workbook) -> list[Any]:
    """The formulas that do not give what another workbook holds, but for lists whose lands stay as issued."""
    wrong, compared = [], 0
    for sheet in book:
        if sheet.title == "Uncertainty budget":
            continue
        last = sheet.max_row
        if sheet.title == "Summary":
            last = next(row[0].row for row in sheet.iter_rows() if str(row[0].value).startswith("Flagged lands"))
        for cells in sheet.iter_rows(max_row=last):
            for cell in cells:
                heading = str(sheet.cell(1, cell.column).value)
                if cell.data_type == "f" and not heading.startswith("order among those flagged since"):
                    compared += 1
                    found, wanted = value(sheet.title, cell.coordinate), expected[sheet.title][cell.coordinate].value
                    if not same(_shown(found), _shown(wanted)):
                        wrong.append((sheet.title, cell.coordinate, found, wanted))
    assert compared > 300
    return wrong


def same(left: object, right: object) -> bool:
    if isinstance(left, int | float) and isinstance(right, int | float):
        return abs(left - right) <= 1e-9 * max(abs(left), abs(right)) + 1e-9
    return left == right
