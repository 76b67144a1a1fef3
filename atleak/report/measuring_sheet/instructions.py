"""Write the tab of a measuring sheet that says how to measure."""

from __future__ import annotations

from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Controller
from atleak.report.lands_sheet import LANDS
from atleak.report.measuring_sheet.columns import UNWORN_END
from atleak.report.paging import Paging, Tab, row_height
from atleak.report.pressure_sheet import PRESSURES
from atleak.sentence import Sentence

INSTRUCTIONS = Sentence("How to measure")
_WIDTHS = (24, 96)
_BETWEEN = 6.0  # [pt] height of the row below a topic, which also keeps words of several from being read as headings
_TOPICS = (
    "before", "temperature", "pump", "where", "in_which_order", "drawing", "code", "how_often", "what_to_write",
    "bores", "unworn_ends", "not_measured", "more_rows", "lands", "pressures", "check", "refused", "nominal_values",
)  # fmt: skip


def write_instructions(tab: Tab, controller: Controller, far: float) -> None:
    """Write a row for every topic, as high as its text is long.

    Parameters
    ----------
    tab
        on which nothing is written yet.
    controller
        whose representative values are named as such.
    far
        how far from the nominal diameter a cell is coloured [µm].
    """
    sheet, formats, say = tab.sheet, tab.formats, tab.say
    values = {
        "reference": say.plain_quantity(REFERENCE_TEMPERATURE, "temperature"),
        "bore": say.plain_quantity(15.0, "length"),
        "more": say.plain_quantity(2.0, "clearance"),
        "warm": say.plain_quantity(35.0, "temperature"),
        "most": say.plain_quantity(0.5, "length"),
        "far": say.plain_quantity(far, "clearance"),
        "order": say("how_to_measure.order"),
        "choice": repr(say.sentence(UNWORN_END)),
        "representative": say.name(controller.representative),
    }
    tabs = {"lands": LANDS, "pressures": PRESSURES}
    Paging(_WIDTHS).set_up(sheet)
    sheet.write_string(0, 0, say.sentence(INSTRUCTIONS), formats["title"])
    for number, topic in enumerate(_TOPICS if controller.representative else _TOPICS[:-1]):
        row, title = 2 * number + 2, say(f"how_to_measure.{topic}_title")
        key = "in_inches" if topic == "what_to_write" and say.unit("length") != "mm" else topic
        said = say(f"how_to_measure.{key}", tab=say.sentence(tabs.get(topic, "")), **values)
        sheet.write_string(row, 0, title, formats["topic"])
        sheet.write_string(row, 1, said, formats["wrap"])
        sheet.set_row(row, row_height(zip((title, said), _WIDTHS, strict=True)))
        sheet.set_row(row + 1, _BETWEEN)
