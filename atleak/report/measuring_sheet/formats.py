"""The formats of a measuring sheet's cells, by name."""

from __future__ import annotations

import xlsxwriter
from xlsxwriter.format import Format

from atleak.look import SHEET_COLOURS
from atleak.wording import Wording


def formats_of(book: xlsxwriter.Workbook, say: Wording) -> dict[str, Format]:
    """Return the formats for every tab; lengths have as many digits as the reader's unit wants."""
    length = f"0.{'0' * say.digits('length', 3)}"
    cell = {"border": 1, "border_color": SHEET_COLOURS["border"], "valign": "vcenter"}
    given = {**cell, "bg_color": SHEET_COLOURS["given"]}
    return {
        "title": book.add_format({"bold": True, "font_size": 14}),
        "field label": book.add_format({"bold": True, "text_wrap": True, "valign": "vcenter"}),
        "field": book.add_format(
            {"bottom": 1, "bg_color": SHEET_COLOURS["entry"], "text_wrap": True, "valign": "vcenter"}
        ),
        "note": book.add_format(
            {"italic": True, "font_size": 8, "font_color": SHEET_COLOURS["note"], "text_wrap": True, "valign": "top"}
        ),
        "heading": book.add_format(
            {
                **cell,
                "bold": True,
                "text_wrap": True,
                "align": "center",
                "bg_color": SHEET_COLOURS["heading"],
                "font_color": SHEET_COLOURS["on_heading"],
            }
        ),
        "text": book.add_format({**given, "text_wrap": True, "align": "left"}),
        "upright": book.add_format({**given, "align": "center", "rotation": 90}),
        "on top": book.add_format({**given, "text_wrap": True, "align": "left", "valign": "top"}),
        "number": book.add_format({**given, "align": "center"}),
        "angle": book.add_format({**given, "align": "center", "num_format": '0"°"'}),
        "input": book.add_format({**cell, "bg_color": SHEET_COLOURS["entry"], "num_format": length, "locked": False}),
        "choice": book.add_format({**cell, "bg_color": SHEET_COLOURS["entry"], "locked": False}),
        "nominal": book.add_format({**given, "num_format": length, "font_color": SHEET_COLOURS["soft"]}),
        "clearance": book.add_format({**given, "num_format": "0.0", "font_color": SHEET_COLOURS["soft"]}),
        "pressure": book.add_format({**cell, "bg_color": SHEET_COLOURS["entry"], "num_format": "0.0", "locked": False}),
        "origin": book.add_format({**given, "font_color": SHEET_COLOURS["soft"], "italic": True, "text_wrap": True}),
        "deviation": book.add_format({**given, "num_format": "0"}),
        "alarm": book.add_format(
            {"bg_color": SHEET_COLOURS["alarm"], "font_color": SHEET_COLOURS["on_heading"], "bold": True}
        ),
        "wrap": book.add_format({"text_wrap": True, "valign": "top"}),
        "topic": book.add_format({"bold": True, "text_wrap": True, "valign": "top"}),
    }
