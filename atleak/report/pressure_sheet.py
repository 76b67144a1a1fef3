"""Write the tab of a measuring sheet that takes gauge readings: a row for every tap and range, a column for each state.

`atleak.intake.gauge_table` reads it back.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from xlsxwriter.format import Format
from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.circuit_tables import SelectorRange
from atleak.catalogue.controller import Controller
from atleak.pressure_table import (
    Cell,
    Engine,
    PressureTable,
    applied,
    permitted,
    ranges_of,
    taps_of,
)
from atleak.report.row_heights import PENCIL, row_height
from atleak.sentence import Name, Sentence
from atleak.unit_systems import Quantity
from atleak.views.gauge_rows import permissible_text, tap_text
from atleak.wording import Wording
from atleak.workshop_units import KPA

PRESSURES = Sentence("Pressures")
_ENGINES = {
    Engine.SLOW_IDLE: Sentence("slow idle"),
    Engine.FAST_IDLE: Sentence("fast idle"),
    Engine.STALL: Sentence("stall"),
}
HEADER = 5  # row of the headings, from 0
_TEMPERATURE = (3, 2)  # row and column of the field
_HIGHEST = 6000  # [kPa] that the cells take
_WIDTHS = (8, 30, 16, 16, 16, 22, 22, 22)
_HOW_TO = (
    Sentence(
        "What gauges show while the vehicle stands, the fluid warm. Yellow cells are to be filled in; leave empty what "
        "was not measured. Stall for five seconds at most, brakes applied, wheels blocked."
    ),
    Sentence("Another unit may stand in a heading, [bar] or [psi], or behind a number. Gauge pressure, not absolute."),
)


def write_pressures(
    sheet: Worksheet, formats: Mapping[str, Format], controller: Controller, table: PressureTable | None, say: Wording
) -> None:
    """Write the tab, empty or with the first reading of each cell.

    Parameters
    ----------
    sheet
        of a workbook that is being written.
    formats
        of the measuring sheet.
    controller
        whose ranges and circuits the rows name, with what its file permits beside them.
    table
        readings to fill in; of a cell that no row has none is written.
    say
        the reader's words and units.
    """
    unit = say.unit("pressure")
    sheet.write_string(
        0,
        0,
        say.sentence(Sentence("Pressures of a standing vehicle: {name}", name=Name(controller.name))),
        formats["title"],
    )
    for row, told in enumerate(_HOW_TO, start=1):
        sheet.write_string(row, 0, say.sentence(told))
    sheet.write_string(
        _TEMPERATURE[0], 0, f"{say.sentence(Sentence('ATF temperature'))} [{say.unit('temperature')}]", formats["label"]
    )
    sheet.write_blank(*_TEMPERATURE, None, formats["field"])
    headings = [Sentence("Range"), Sentence("Tap")]
    headings += [Sentence("{engine} [{unit}]", engine=_ENGINES[engine], unit=unit) for engine in Engine]
    headings += [Sentence("Permissible at {engine} [{unit}]", engine=_ENGINES[engine], unit=unit) for engine in Engine]
    said = [say.sentence(heading) for heading in headings]
    widths = [max(width, 2 + max(map(len, heading.split()))) for heading, width in zip(said, _WIDTHS, strict=True)]
    for column, (heading, width) in enumerate(zip(said, widths, strict=True)):
        sheet.write_string(HEADER, column, heading, formats["heading"])
        sheet.set_column(column, column, width)
    sheet.set_row(HEADER, row_height(zip(said, widths, strict=True), bold=True))
    last = HEADER
    for last, (selected, tap) in enumerate(_rows(controller), start=HEADER + 1):
        texts = [tap_text(controller, tap, say)]
        sheet.write_string(last, 0, selected, formats["text"])
        sheet.write_string(last, 1, texts[0], formats["text"])
        for column, engine in enumerate(Engine, start=2):
            cell = Cell(selected, engine, tap)
            given = table.at(cell) if table is not None else ()
            if given:
                sheet.write_number(
                    last, column, round(float(say.convert(given[0].pressure * KPA, "pressure")), 9), formats["pressure"]
                )
            else:
                sheet.write_blank(last, column, None, formats["pressure"])
            texts.append(permissible_text(permitted(controller, cell), say) or "")
            sheet.write_string(last, column + len(Engine), texts[-1], formats["origin"])
        sheet.set_row(last, max(PENCIL, row_height(zip(texts, (widths[1], *widths[-len(Engine) :]), strict=True))))
    sheet.freeze_panes(HEADER + 1, 2)
    sheet.data_validation(
        HEADER + 1,
        2,
        last,
        1 + len(Engine),
        {
            "validate": "decimal",
            "criteria": "between",
            "minimum": 0,
            "maximum": float(say.convert(_HIGHEST, "pressure")),
            "error_title": say.sentence(Sentence("Not a pressure")),
            "error_message": say.sentence(
                Sentence(
                    "A number such as {example}. Leave empty what was not measured.",
                    example=Quantity(412.5, "pressure", 1),
                )
            ),
        },
    )
    sheet.set_landscape()
    sheet.set_paper(9)  # A4
    sheet.fit_to_pages(1, 0)
    sheet.repeat_rows(HEADER)
    sheet.ignore_errors({"number_stored_as_text": f"A{HEADER + 2}:A{last + 1}"})


def _rows(controller: Controller) -> Iterator[tuple[SelectorRange, str]]:
    """Yield range and tap of every row: all ranges at the line, at a circuit those in which it is applied."""
    for tap in taps_of(controller):
        for selected in ranges_of(controller):
            if applied(controller, Cell(selected, Engine.SLOW_IDLE, tap)):
                yield selected, tap
