"""The names that drop-downs offer: those that stand on another sheet, as they stand there at the moment."""

from __future__ import annotations

from dataclasses import dataclass, field

import xlsxwriter
from xlsxwriter.utility import xl_col_to_name, xl_rowcol_to_cell
from xlsxwriter.worksheet import Worksheet

from atleak.controller_sheets.layout import LISTS, NAMES


@dataclass
class Places:
    """Where the columns to fill in were written: first and last row and column, all from 0, by sheet and heading."""

    columns: dict[tuple[str, str], tuple[int, int, int]] = field(default_factory=dict)


def defined_name(names: str) -> str:
    """Return the workbook's name of the cells that a drop-down offers.

    >>> defined_name("operating point")
    'operating_point_names'
    """
    return f"{names.replace(' ', '_')}_names"


def write_names(book: xlsxwriter.Workbook, lists: Worksheet, places: Places) -> None:
    """Define the names; where fixed ones come first, all of them stand on a hidden sheet.

    Parameters
    ----------
    book, lists
        the workbook, and its sheet for what no other sheet holds as a column.
    places
        of the columns that hold the names.
    """
    for number, (names, offered) in enumerate(NAMES.items()):
        first, last, column = places.columns[offered.sheet, offered.heading]
        letter = xl_col_to_name(column, col_abs=True)
        cells = f"'{offered.sheet}'!{letter}${first + 1}:{letter}${last + 1}"
        count = f"COUNTA({cells})"
        if not offered.fixed:
            start = f"'{offered.sheet}'!{letter}${first + 1}"
            book.define_name(defined_name(names), f"=OFFSET({start},0,0,MAX(1,{count}),1)")
            continue
        for row, name in enumerate(offered.fixed):
            lists.write_string(row, number, name)
        for row in range(first, last + 1):
            source = f"'{offered.sheet}'!{xl_rowcol_to_cell(row, column)}"
            lists.write_formula(len(offered.fixed) + row - first, number, f'={source}&""', None, "")
        start = f"'{LISTS}'!{xl_col_to_name(number, col_abs=True)}$1"
        book.define_name(defined_name(names), f"=OFFSET({start},0,0,{len(offered.fixed)}+{count},1)")
    lists.hide()
