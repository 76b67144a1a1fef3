"""Write the tab of a measuring sheet that takes gauge readings: a row for every tap and range, a column for each state.

`atleak.readers.gauges.gauge_table` reads it back.
"""

from __future__ import annotations

from collections.abc import Iterator

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_tables import SelectorRange
from atleak.common.sentences import Name, Sentence
from atleak.common.units import KPA, Quantity
from atleak.common.wording import Wording
from atleak.measurements.gauge_readings import Engine, GaugeCell, PressureTable, applied, permitted, ranges_of, taps_of
from atleak.measurements.own_forms import ATF_TEMPERATURE, PRESSURES
from atleak.report.sheets.paging import HEADER, PagedTable, Tab, only, put
from atleak.report.tables.gauges import permissible_text, tap_text

PRESSURES_TITLE = Sentence("Pressures")
_TEMPERATURE = (3, 2)  # row and column of the field
_HIGHEST = 6000  # [kPa] that the cells take
_RANGE, _TAP, _READ = range(3)  # columns, from 0; the last with one for every state of the engine
_PERMISSIBLE = _READ + len(Engine)  # and again as many
_WIDTHS = (8, 30, 14, 14, 14, 20, 20, 20)
_HOW_TO = (
    Sentence(
        "What gauges show while the vehicle stands, the fluid warm. Yellow cells are to be filled in; leave empty what "
        "was not measured. Stall for five seconds at most, brakes applied, wheels blocked."
    ),
    Sentence("Another unit may stand in a heading, [bar] or [psi], or behind a number. Gauge pressure, not absolute."),
)


def write_pressures(tab: Tab, controller: Controller, readings: PressureTable | None) -> None:
    """Write the tab, empty or with the first reading of each cell; a reading that no row takes is left out.

    The rows name the controller's ranges and circuits, with what its file permits beside them.
    """
    sheet, formats, say = tab.sheet, tab.formats, tab.say
    rows = list(_rows(controller))
    last = HEADER + len(rows)
    table = PagedTable(tab, PRESSURES, _headings(say), _WIDTHS)
    title = Sentence("Pressures of a standing vehicle: {name}", name=Name(controller.name))
    table.write((title, *_HOW_TO), last, _READ)
    label = f"{say.sentence(ATF_TEMPERATURE)} [{say.unit('temperature')}]"
    sheet.set_row(_TEMPERATURE[0], table.row_height)
    sheet.merge_range(_TEMPERATURE[0], 0, _TEMPERATURE[0], _TEMPERATURE[1] - 1, label, formats["field label"])
    sheet.write_blank(*_TEMPERATURE, None, formats["field"])
    for row, (selected, tap) in enumerate(rows, start=HEADER + 1):
        permissible = [
            permissible_text(permitted(controller, GaugeCell(selected, engine, tap)), say) or "" for engine in Engine
        ]
        texts = {_TAP: tap_text(controller, tap, say), **dict(enumerate(permissible, start=_PERMISSIBLE))}
        table.fit(row, texts)
        sheet.write_string(row, _RANGE, selected, formats["text"])
        for column, text in texts.items():
            sheet.write_string(row, column, text, formats["text" if column == _TAP else "origin"])
        for column, engine in enumerate(Engine, start=_READ):
            given = readings.at(GaugeCell(selected, engine, tap)) if readings is not None else ()
            shown = round(float(say.convert(given[0].pressure * KPA, "pressure")), 9) if given else None
            put(sheet, row, column, shown, formats["pressure"])
    message = Sentence(
        "A number such as {example}. Leave empty what was not measured.", example=Quantity(412.5, "pressure", 1)
    )
    highest = float(say.convert(_HIGHEST, "pressure"))
    taken = only("decimal", Sentence("Not a pressure"), message, say, criteria="between", minimum=0, maximum=highest)
    sheet.data_validation(HEADER + 1, _READ, last, _PERMISSIBLE - 1, taken)


def _headings(say: Wording) -> list[str]:
    unit = say.unit("pressure")
    headings = map(say.sentence, PRESSURES.headings.values())
    return [said if column < _READ else f"{said} [{unit}]" for column, said in enumerate(headings)]


def _rows(controller: Controller) -> Iterator[tuple[SelectorRange, str]]:
    """Yield range and tap of every row: all ranges at the line, at a circuit those in which it is applied."""
    for tap in taps_of(controller):
        for selected in ranges_of(controller):
            if applied(controller, GaugeCell(selected, Engine.SLOW_IDLE, tap)):
                yield selected, tap
