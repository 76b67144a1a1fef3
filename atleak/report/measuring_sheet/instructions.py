"""Write the tab of a measuring sheet that says how to measure."""

from __future__ import annotations

from collections.abc import Iterator

from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Controller
from atleak.report.lands_sheet import LANDS
from atleak.report.measuring_sheet.columns import UNWORN_END
from atleak.report.paging import Paging, Tab, row_height
from atleak.report.pressure_sheet import PRESSURES
from atleak.sentence import Name, Sentence
from atleak.unit_systems import Quantity
from atleak.wording import Wording

INSTRUCTIONS = Sentence("How to measure")
_WIDTHS = (24, 96)
_BETWEEN = 6.0  # [pt] height of the row below a topic, which also keeps words of several from being read as headings
ORDER = Sentence(
    "Down the rows, component by component: its spool in all planes by their numbers, each at 0° and 90°; lifted off "
    "and set up afresh, all again for the second repeat; then its bore likewise."
)
_REFERENCE = Quantity(REFERENCE_TEMPERATURE, "temperature")
_Topic = tuple[Sentence, Sentence]
_Topics = tuple[_Topic, ...]
_BEFORE: _Topics = (
    (
        Sentence("Before"),
        Sentence(
            "Clean and dry spools and bores. Let the parts and the instrument lie together at {reference} "
            "{reference.unit} for an hour.",
            reference=_REFERENCE,
        ),
    ),
    (
        Sentence("Temperature"),
        Sentence(
            "Where the room is not at {reference} {reference.unit}, write the temperature of parts and instrument at "
            "the head of the sheet, in {reference.unit}: the diameters are corrected to {reference} {reference.unit}. "
            "A bore of {bore:g} {bore.unit} in aluminium reads {more:g} {more.unit} more at {warm} {warm.unit}.",
            reference=_REFERENCE,
            bore=Quantity(15.0, "length"),
            more=Quantity(2.0, "clearance"),
            warm=Quantity(35.0, "temperature"),
        ),
    ),
    (
        Sentence("Pump"),
        Sentence(
            "Where the head asks for them: the side clearance is the whole axial play, by straightedge and feeler "
            "gauge between the faces of gears or rotors and the body; the tip clearance is that between the tips and "
            "what they seal against. Another unit than that of the label is written behind the number: 0.0033 in."
        ),
    ),
)
_ORDER_AND_PLACE: _Topics = (
    (
        Sentence("Where"),
        Sentence(
            "Every row of the sheet names a component, its part (spool or piston, sleeve), a plane and a direction. "
            "A plane is half-way along a cylindrical section; 0° and 90° are two directions at right angles."
        ),
    ),
    (
        Sentence("In which order"),
        Sentence("{order} Or all spools first and then all bores, to change gauges once.", order=ORDER),
    ),
    (
        Sentence("Drawing"),
        Sentence(
            "Beside its rows every spool is shown upright with the planes that the rows ask for, numbered alike; the "
            "end on top is the left one elsewhere. It is not to scale unless the valve body's file says where the "
            "lands lie. 0° is up and down as the valve body lies on the bench, 90° level."
        ),
    ),
    (
        Sentence("Code"),
        Sentence(
            "Where the job is known, the head has its code: a scanner types the job's number and the valve body's id "
            "from it, into the search of the job book for one."
        ),
    ),
    (
        Sentence("How often"),
        Sentence(
            "Measure twice. Lift the part off and set it up afresh in between: writing the same two coordinates in "
            "the other order is no second measurement."
        ),
    ),
)
_WHAT_TO_WRITE = Sentence("What to write")
_IN_MM = Sentence(
    "With a microscope the two coordinates, with a micrometer or bore gauge the diameter: one of the two "
    "is enough. Millimetres, to 0.001. Decimal point or comma, as your program writes them. In inches: "
    "write [inch] in the heading in place of [mm]; the deviation from the nominal diameter follows."
)
_IN_INCHES = Sentence(
    "With a microscope the two coordinates, with a micrometer or bore gauge the diameter: one of the two "
    "is enough. Inches, to 0.00005. Decimal point or comma, as your program writes them. In millimetres: "
    "write [mm] in the heading in place of [in]; the deviation from the nominal diameter follows."
)
_BORES: _Topic = (
    Sentence("Bores"),
    Sentence(
        "A bore wears to one side. Measured in one direction only, its wear may be missed; the report then says "
        "that the clearance is a lower bound."
    ),
)
_WHAT_ELSE: _Topics = (
    (
        Sentence("Not measured"),
        Sentence(
            "Leave the cells empty, or delete the rows. Such a pair is computed with its mounting clearance and marked "
            "as not measured. With only one part measured the other one's nominal diameter is taken, and that is said "
            "too."
        ),
    ),
    (
        Sentence("More rows"),
        Sentence(
            "For a third repeat or another direction insert a row inside the block and number the repeat. Columns may "
            "stand in any order; their headings must stay."
        ),
    ),
    (
        Sentence("Lands"),
        Sentence(
            "The tab {tab} takes the contact length of a land and where it begins on its spool, if you measured them, "
            "and which repair a component was given earlier. Left empty, what the valve body's file states counts.",
            tab=LANDS,
        ),
    ),
    (
        Sentence("Pressures"),
        Sentence(
            "The tab {tab} takes what gauges show while the vehicle stands, range by range: for a job of its own or "
            "beside the diameters. Left empty, it is no table.",
            tab=PRESSURES,
        ),
    ),
)
_REFUSED: _Topic = (
    Sentence("Refused"),
    Sentence(
        "A sleeve smaller than its spool, a clearance over {most:g} {most.unit}, a number that is off by 10, 25.4 "
        "or 1000, and a component that the valve body does not have. The message names sheet, row and column.",
        most=Quantity(0.5, "length"),
    ),
)


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
    Paging(_WIDTHS).set_up(sheet)
    sheet.write_string(0, 0, say.sentence(INSTRUCTIONS), formats["title"])
    for number, (topic, text) in enumerate(_topics(controller, far, say)):
        row = 2 * number + 2
        said = say.sentence(text)
        sheet.write_string(row, 0, say.sentence(topic), formats["topic"])
        sheet.write_string(row, 1, said, formats["wrap"])
        sheet.set_row(row, row_height(zip((say.sentence(topic), said), _WIDTHS, strict=True)))
        sheet.set_row(row + 1, _BETWEEN)


def _topics(controller: Controller, far: float, say: Wording) -> Iterator[_Topic]:
    """Yield topics and texts, in the order in which they are needed."""
    yield from _BEFORE
    yield from _ORDER_AND_PLACE
    yield _WHAT_TO_WRITE, _IN_MM if say.unit("length") == "mm" else _IN_INCHES
    yield _BORES
    yield _unworn_ends(say)
    yield from _WHAT_ELSE
    yield _check(far)
    yield _REFUSED
    if controller.representative:
        told = Sentence(
            "{representative} They are there for orientation only.", representative=Name(controller.representative)
        )
        yield Sentence("Nominal values"), told


def _unworn_ends(say: Wording) -> _Topic:
    return (
        Sentence("Unworn ends"),
        Sentence(
            "A bore is as new where its spool never runs. A diameter from there tells what the pair was when new: add "
            "a row for it and choose {choice!r} in its last column. It does not count for wear; the mounting clearance "
            "is learned from it, beside the spool as it is.",
            choice=say.sentence(UNWORN_END),
        ),
    )


def _check(far: float) -> _Topic:
    return (
        Sentence("Check"),
        Sentence(
            "One column shows how far each diameter is from the nominal one. It turns red from {far:g} {far.unit} "
            "on: another plane, a slip of the pen, or inches.",
            far=Quantity(far, "clearance"),
        ),
    )
