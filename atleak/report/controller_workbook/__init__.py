"""Write the workbook that describes a valve body, empty or filled in.

`atleak.controller_sheets.layout` declares its sheets; `atleak.intake.controller_workbook` reads it back.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xlsxwriter

from atleak.controller_sheets.layout import INSTRUCTIONS, LISTS, SHEETS
from atleak.controller_sheets.units import Units
from atleak.report.controller_workbook.instructions import write_instructions
from atleak.report.controller_workbook.sheets import SheetWriter, formats
from atleak.report.paging import workbook


def write_controller_workbook(data: Mapping[str, Any] | None = None, units: Units | None = None) -> bytes:
    """Return the workbook of a valve body.

    Parameters
    ----------
    data
        the tables of a controller's file, as a TOML file of the same content gives them; without them the workbook is
        empty, but for rows marked as examples.
    units
        in which its numbers are written: mm, radial and kPa unless given.

    Returns
    -------
    bytes
        of an .xlsx workbook; the same tables and units give the same bytes. Texts stay texts, never formulas.
    """

    def write_sheets(book: xlsxwriter.Workbook) -> None:
        styles = formats(book)
        write_instructions(book.add_worksheet(INSTRUCTIONS), styles)
        writer = SheetWriter(book, styles, data, units or Units())
        for sheet in SHEETS:
            write = writer.form if sheet.is_form else writer.table
            write(book.add_worksheet(sheet.name), sheet)
        writer.names(book.add_worksheet(LISTS))

    title = "Valve body to describe" if data is None else f"Valve body: {data.get('name', '')}"[:200]
    return workbook(write_sheets, title, mark="controller workbook")
