"""The head of a measuring sheet: which job, vehicle and unit, when and with what was measured, and its QR code.

The pictures of a measuring sheet: each spool beside its rows, the directions and the job's code in its head.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import segno
from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.controller import Controller
from atleak.catalogue.entries import shipped_files
from atleak.catalogue.instruments import Part, load_instrument
from atleak.common.sentences import Name, Sentence
from atleak.common.style import SHEET_COLOURS
from atleak.common.units import ShownUnit, unit_system
from atleak.common.wording import Wording
from atleak.measurements.measuring_plan import DIRECTIONS, PLAN_PARTS
from atleak.report.charts.drawing import directions_svg, upright_svg
from atleak.report.pdf.typesetting import Drawing, pngs_of
from atleak.report.sheets.measuring_columns import PUMP_SIDE, PUMP_TIP, FormColumn
from atleak.report.sheets.paging import height_of

if TYPE_CHECKING:
    from atleak.measurements.job_card import Job

JOB, VEHICLE, DATE = Sentence("Job"), Sentence("Vehicle"), Sentence("Date")
_MILEAGE, MEASURED_BY, VIN = Sentence("Mileage"), Sentence("Measured by"), Sentence("VIN")
SERIAL, _TEMPERATURE = Sentence("Serial number"), Sentence("Measuring temperature")
INSTRUMENT_ROWS: Mapping[Part, Sentence] = {
    "spool": Sentence("Instrument for spools"),
    "sleeve": Sentence("Instrument for bores"),
}
_KINDS = {  # of what stands without a unit: the label states it
    _MILEAGE: "distance",
    _TEMPERATURE: "temperature",
    PUMP_SIDE: "clearance",
    PUMP_TIP: "clearance",
}
TITLE_HEIGHTS = (21.0, 60.0, 15.0)  # [pt] of the rows above: the valve body, what to do, what of it is assumed
_ROWS = (
    (JOB, MEASURED_BY, DATE),
    (VEHICLE, INSTRUMENT_ROWS["spool"], SERIAL),
    (VIN, INSTRUMENT_ROWS["sleeve"], PUMP_SIDE),
    (_MILEAGE, _TEMPERATURE, PUMP_TIP),
)
_BLOCKS = (  # of fields below each other: where their labels begin, where the fields begin and end
    (FormColumn.COMPONENT, FormColumn.PART, FormColumn.DIRECTION),
    (FormColumn.X1, FormColumn.DIAMETER, FormColumn.SECOND_X1),
    (FormColumn.SECOND_X2, FormColumn.NOMINAL, FormColumn.ORIGIN),
)
PICTURES = FormColumn.SECOND_DIAMETER  # from which on the head's pictures stand, beside its titles
MEASURING_HEADER = len(TITLE_HEIGHTS) + len(_ROWS)  # row of the table's headings, from 0


class _Place(NamedTuple):
    """Where a field stands: its row, the column of its label, its own first and last column; from 0."""

    row: int
    label: int
    first: int
    last: int


PLACES: Mapping[Sentence, _Place] = {
    field: _Place(row, *block)
    for row, fields in enumerate(_ROWS, start=len(TITLE_HEIGHTS))
    for field, block in zip(fields, _BLOCKS, strict=True)
}
FIELDS: tuple[Sentence, ...] = tuple(PLACES)
_NAMED_BY = (JOB, SERIAL, VIN)  # the first that is known tells the job from others
_SAME = 1e-7  # relative difference of values that are the same
_LONGEST = 80  # characters of a number that a code of the head's size takes
_MODULE = 4  # dots of the code's smallest square


def label_of(field: Sentence, say: Wording) -> str:
    """Return the label of a field, with its unit."""
    return say.sentence(field) + (f" [{_unit_of(_KINDS[field], say.system).name}]" if field in _KINDS else "")


def fields_of(job: Job, units: str = "metric") -> dict[str, str]:
    """Return what a job's record says of the head's fields, by the names of `FIELDS`.

    The date is that of measuring: where the record has none, whoever measures writes it down. Quantities are in the
    units of the sheet, one of `atleak.common.units.SYSTEMS`, and name them, so that they mean the same on any
    sheet.
    """
    vehicle, system = job.vehicle, unit_system(units)
    car = " ".join(filter(None, (vehicle.make, vehicle.model, vehicle.year)))
    numbers = (
        (_MILEAGE, vehicle.mileage_km),
        (_TEMPERATURE, job.measuring_temperature_c),
        (PUMP_SIDE, job.pump_side_clearance_um),
        (PUMP_TIP, job.pump_tip_clearance_um),
    )
    fields: dict[str, str] = {
        JOB: job.number,
        VEHICLE: ", ".join(filter(None, (car, vehicle.registration))),
        DATE: job.measured_on.isoformat() if job.measured_on else "",
        MEASURED_BY: job.technician,
        VIN: vehicle.vin,
        SERIAL: job.transmission.serial,
        **{INSTRUMENT_ROWS[part]: name for part, name in _instruments_of(job).items()},
        **{
            field: "" if value is None else _written(value, _unit_of(_KINDS[field], system)) for field, value in numbers
        },
    }
    return {label: text for label, text in fields.items() if text}


def instruments_for(part: Part) -> list[str]:
    """Return the names of the instruments that come with atleak and measure a part."""
    known = map(load_instrument, sorted(shipped_files("instruments")))
    return [instrument.name for instrument in known if part in instrument.measures]


def _instruments_of(job: Job) -> dict[Part, str]:
    """Return which instrument of the record is for spools and which for bores.

    One alone is for both, and of several the first is for spools, unless one that comes with atleak measures only one
    of the two.
    """
    spools, bores = map(instruments_for, PLAN_PARTS)
    names = [each.name for each in job.instruments if each.name]
    names.sort(key=lambda name: (name in bores) - (name in spools))
    return {
        "spool": next((name for name in names if name in spools or name not in bores), ""),
        "sleeve": ", ".join(name for name in names[len(names) > 1 :] if name in bores or name not in spools),
    }


def _unit_of(kind: str, system: Mapping[str, ShownUnit]) -> ShownUnit:
    return system[kind].spelled or system[kind]


def _written(value: float, unit: ShownUnit) -> str:
    """Return a value with its unit, in as few decimal places as give it back.

    Three places are none of them: people and programs may take their point for one between thousands.
    """
    shown = unit.shown(value)
    texts = (f"{shown:.{places}f}" for places in range(16) if places != 3)
    least = next((text for text in texts if math.isclose(unit.carried(float(text)), value, rel_tol=_SAME)), repr(shown))
    return f"{least} {unit.name}"


def code_text(controller: Controller, fields: Mapping[str, str]) -> str:
    """Return what a scanner types for this sheet: the job's number, else serial or VIN, and the valve body's id.

    Without any of the three there is nothing to tell the job from others by, and the text is empty; so it is where
    squares of the paper's size could not be scanned.
    """
    name = next((" ".join(fields[label].split()) for label in _NAMED_BY if fields.get(label, "").strip()), "")
    return f"{name} {controller.id}" if 0 < len(name) <= _LONGEST else ""


def qr_code(text: str) -> bytes:
    """Return a QR code as PNG, with the white rim that scanners need; the same text gives the same bytes."""
    target = io.BytesIO()
    segno.make(text, micro=False, error="m").save(target, kind="png", scale=_MODULE)
    return target.getvalue()


_LEAST, _MOST = 48.0, 190.0  # [pt] height of a drawing: less shows nothing, more only takes room
_HEAD = 96.0  # [pt] width and height of a picture in the head
_EDGE = 3.0  # [pt] between a picture and the lines round it
_PIXEL = 0.75  # [pt]
_NOT_TO_SCALE = Sentence("not to scale")
_DIRECTIONS = Sentence("directions of measuring, seen along the spool")


@dataclass(frozen=True)
class ComponentRows:
    """The rows of a component that stand on one page, merged in the column of its name."""

    component: str
    row: int  # the first
    height: float  # [pt]


def draw_spools(
    sheet: Worksheet, controller: Controller, blocks: Iterable[ComponentRows], width: int, say: Wording
) -> list[ComponentRows]:
    """Draw every component's spool below its name in a column of so many characters, where its rows leave room for it.

    Return the blocks that have a drawing, so that their names stand on top.
    """
    room = (7 * width + 5) * _PIXEL - 2 * _EDGE
    placed: list[tuple[ComponentRows, float, Drawing]] = []
    for block in blocks:
        name = say.name(controller.components[block.component])
        above = _EDGE + height_of(name, width)
        high = min(block.height - above - 2 * _EDGE, _MOST)
        if high >= _LEAST:
            svg = upright_svg(controller, block.component, (room, high), say.sentence(_NOT_TO_SCALE))
            placed.append((block, above, Drawing(svg, room, high, SHEET_COLOURS["given"])))
    drawings = list(dict.fromkeys(drawing for _, _, drawing in placed))
    pictures = dict(zip(drawings, pngs_of(drawings), strict=True))
    for block, above, drawing in placed:
        title = Sentence(
            "component {component}, {name}: lands and measuring planes",
            component=block.component,
            name=Name(controller.components[block.component]),
        )
        _insert(sheet, (block.row, FormColumn.NAME), (_EDGE, above), pictures[drawing], 1.0, say.sentence(title))
    return [block for block, _, _ in placed]


def draw_head(sheet: Worksheet, code: str, say: Wording) -> None:
    """Draw the directions of measuring in the head, and beside them the job's code if it has one."""
    label = say.sentence(_DIRECTIONS)
    (png,) = pngs_of([Drawing(directions_svg(DIRECTIONS, say, label), _HEAD, _HEAD)])
    _insert(sheet, (0, PICTURES), (_EDGE, 0.0), png, 1.0, label)
    if code:
        picture = qr_code(code)
        dots = int.from_bytes(picture[16:20])  # a PNG states its width there
        alt = say.sentence(Sentence("QR code: {text}", text=code))
        _insert(sheet, (0, PICTURES), (_HEAD + 2 * _EDGE, 0.0), picture, _HEAD / (dots * _PIXEL), alt)


def _insert(
    sheet: Worksheet, cell: tuple[int, int], offset: tuple[float, float], png: bytes, scale: float, alt: str
) -> None:
    options = {
        "image_data": io.BytesIO(png),
        "x_offset": offset[0] / _PIXEL,
        "y_offset": offset[1] / _PIXEL,
        "x_scale": scale,
        "y_scale": scale,
        "object_position": 2,  # moves with its cells and keeps its size
        "description": alt,
    }
    sheet.insert_image(*cell, "picture.png", options)
