"""The pictures of a measuring sheet: each spool beside its rows, the directions and the job's code in its head."""

from __future__ import annotations

import io
from collections.abc import Iterable
from dataclasses import dataclass

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.controller import Controller
from atleak.look import SHEET_COLOURS
from atleak.measuring.plan import DIRECTIONS
from atleak.report.drawn_png import Drawing, pngs_of
from atleak.report.measuring_sheet.columns import Column
from atleak.report.measuring_sheet.head import PICTURES, qr_code
from atleak.report.paging import height_of
from atleak.sentence import Name, Sentence
from atleak.views.drawing import directions_svg, upright_svg
from atleak.wording import Wording

_LEAST, _MOST = 90.0, 190.0  # [pt] height of a drawing: less shows nothing, more only takes room
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
    """Draw every component's spool below its name, where its rows leave room for it.

    Parameters
    ----------
    sheet
        of a workbook that is being written.
    controller
        whose spools are drawn.
    blocks
        where its components stand.
    width
        of the column of names, in characters.
    say
        the reader's words.

    Returns
    -------
    list
        of the blocks that have a drawing, so that their names stand on top.
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
        _insert(sheet, (block.row, Column.NAME), (_EDGE, above), pictures[drawing], 1.0, say.sentence(title))
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
