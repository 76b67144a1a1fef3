"""Write the first sheet: how to fill in the others, with pictures of what is meant."""

from __future__ import annotations

from pathlib import Path

from xlsxwriter.worksheet import Worksheet

from atleak.controller_sheets.layout import EXAMPLE_MARK, INSTRUCTIONS, NOTE_HEADING, SHEETS
from atleak.report.controller_workbook.sheets import Styles

SPOOL_PICTURE = Path(__file__).with_name("spool.png")
"""What the sheet of lands asks for; drawn by ``tools/spool_picture.py``."""

_HOW_TO = (
    (
        "What it is",
        "Everything atleak has to know of a transmission's valve body to judge its leakage. Fill it in, then "
        "'atleak controller check FILE' lists all that is wrong with it at once, and 'atleak controller from-workbook "
        "FILE -o UNIT.toml' makes the file that every command and the dashboard take.",
    ),
    (
        "Where to begin",
        "With the sheets whose tabs are dark: Head, Materials, Components, Lands, Pump, Operating points. That is "
        "enough for a first verdict. Circuits, Feeds, Gaps and the rest sharpen it: a land without "
        "any gap is taken to leak from main pressure to the drain, which is an upper bound.",
    ),
    (
        "Units",
        "Choose on the sheet Head: mm or inch, radial or diametral clearance, kPa, psi or bar. The units under the "
        "headings follow. Change them before you fill in numbers: what stands there already is not converted.",
    ),
    (
        "Clearance",
        "Diametral is bore minus spool, as manuals and part makers state it; radial is half of that. It is what the "
        "pair had when it was new: from the maker, from a new part, or from an unworn end of the bore. Where only the "
        "range of new pairs is known, write both ends.",
    ),
    (
        "How known",
        "Measured: on such a unit, by you. Published: in the source beside it. Representative: what such units "
        "commonly have, to be measured later. Empty: not stated.",
    ),
    (
        "Gears",
        "R is reverse, N and P are neutral, the others are numbers: R N 1 2 3, or 1-5, or all.",
    ),
    (
        "Ids",
        "Components, circuits and operating points have short names of yours; other sheets offer them in their "
        "drop-downs. Small letters, digits and _ (components may have any).",
    ),
    (
        "Rows and columns",
        f"Yellow cells are to be filled in; dark headings must be. Rows marked {EXAMPLE_MARK!r} in the column "
        f"{NOTE_HEADING} are examples and are not read: leave or delete them. What else stands in that column is a "
        "remark of yours, and not carried over. Rows and columns may stand in any order, and empty rows between.",
    ),
    (
        "Numbers",
        "Decimal point or comma, as your program writes them. A unit of its own may stand behind a number: 25 µm, "
        "0.57 in, 110 psi.",
    ),
)


def write_instructions(page: Worksheet, styles: Styles) -> None:
    """Write the sheet.

    Parameters
    ----------
    page
        of a workbook that is being written.
    styles
        its formats.
    """
    page.set_column(0, 0, 18)
    page.set_column(1, 1, 100)
    page.write_string(0, 0, INSTRUCTIONS, styles["title"])
    row = 2
    for row, (topic, text) in enumerate(_HOW_TO, start=2):
        page.write_string(row, 0, topic, styles["topic"])
        page.write_string(row, 1, text, styles["wrap"])
        page.set_row(row, 16 * (1 + len(text) // 105))
    page.insert_image(
        row + 2,
        0,
        str(SPOOL_PICTURE),
        {
            "description": "A spool in its bore: two lands with diameter, contact length, position and clearance",
            "x_scale": 0.5,
            "y_scale": 0.5,
        },
    )
    row += 21
    page.write_string(row, 0, "The sheets", styles["topic"])
    for sheet in SHEETS:
        row += 1
        page.write_url(row, 0, f"internal:'{sheet.name}'!A1", string=sheet.name)
        page.write_string(row, 1, sheet.about, styles["wrap"])
    page.set_paper(9)  # A4
    page.fit_to_pages(1, 1)
