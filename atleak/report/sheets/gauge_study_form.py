"""Write the workbook of a gauge study to fill in: a row for every reading that is asked for.

`atleak.readers.gauges.gauge_study` reads it back.
"""

from __future__ import annotations

import io

import xlsxwriter

from atleak.common.style import SHEET_COLOURS
from atleak.common.wording import Wording, wording
from atleak.measurements.gauge_study import FEWEST
from atleak.measurements.own_forms import STUDY

_SHEET = "Gauge study"
STUDY_HEADER = 5  # row of the headings, from 0
_MOST = 60  # parts, operators or trials of a form
_WIDTHS = (10, 14, 10, 16)


def write_study_form(parts: int = 10, operators: int = 3, trials: int = 3, say: Wording | None = None) -> bytes:
    """Return an Excel workbook with a row for every reading, in the order in which they are best taken.

    Every operator measures all parts once before anybody begins again, so that nobody remembers the last reading.

    Parameters
    ----------
    parts, operators, trials
        how many of each, 2 to 60.

    Raises
    ------
    ValueError
        a number that no study can have.
    """
    if not all(FEWEST <= number <= _MOST for number in (parts, operators, trials)):
        raise ValueError(f"{FEWEST} to {_MOST} parts, operators and trials")
    say = say or wording("en")
    target = io.BytesIO()
    with xlsxwriter.Workbook(target, {"in_memory": True}) as book:
        sheet = book.add_worksheet(_SHEET)
        title = book.add_format({"bold": True, "font_size": 14})
        edge = {"border": 1, "border_color": SHEET_COLOURS["border"]}
        heading = book.add_format(
            {"bold": True, "bg_color": SHEET_COLOURS["heading"], "font_color": SHEET_COLOURS["on_heading"], **edge}
        )
        given = book.add_format({"bg_color": SHEET_COLOURS["given"], **edge})
        entry = book.add_format({"bg_color": SHEET_COLOURS["entry"], "num_format": "0.0000", **edge})
        sheet.write_string(0, 0, say("gauge_study.title"), title)
        for row, key in enumerate(("form_order", "form_names", "form_unit"), start=1):
            sheet.write_string(row, 0, say(f"gauge_study.{key}"))
        *keys, reading = map(say.sentence, STUDY.headings.values())
        headings = [*keys, f"{reading} [mm]"]
        sheet.write_string(0, len(headings), STUDY.mark)
        for column, (text, width) in enumerate(zip(headings, _WIDTHS, strict=True)):
            sheet.write_string(STUDY_HEADER, column, text, heading)
            sheet.set_column(column, column, width)
        order = [
            (part, chr(ord("A") + operator) if operators <= 26 else str(operator + 1), trial)
            for trial in range(1, trials + 1)
            for operator in range(operators)
            for part in range(1, parts + 1)
        ]
        for row, (part, operator, trial) in enumerate(order, start=STUDY_HEADER + 1):
            sheet.write_number(row, 0, part, given)
            sheet.write_string(row, 1, operator, given)
            sheet.write_number(row, 2, trial, given)
            sheet.write_blank(row, 3, None, entry)
        sheet.freeze_panes(STUDY_HEADER + 1, 3)
        sheet.set_paper(9)  # A4
        sheet.fit_to_pages(1, 0)
        sheet.print_area(0, 0, STUDY_HEADER + len(order), len(_WIDTHS) - 1)
        sheet.repeat_rows(STUDY_HEADER)
    return target.getvalue()
