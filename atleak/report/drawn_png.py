"""Turn the core's drawings into pictures for programs that take no SVG, with the package's own fonts alone."""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cache

import typst
from PIL import Image, ImageColor

from atleak.look import SHEET_OF_PAPER
from atleak.report.printed_fonts import FONTS

DOTS = 150  # of an inch: on paper, where a sheet is shrunk, about 200
_PAGES = b"""
#for each in json(bytes(sys.inputs.drawings)) {
  page(width: each.width * 1pt, height: each.height * 1pt, margin: 0pt, fill: rgb(each.ground),
    image(bytes(each.svg), format: "svg", width: 100%, height: 100%))
}
"""


@dataclass(frozen=True)
class Drawing:
    """A drawing as SVG, the size in which it is shown [pt], and the colour of what lies under it."""

    svg: str
    width: float
    height: float
    ground: str = SHEET_OF_PAPER


@cache
def bundled_fonts() -> typst.Fonts:
    """Return the fonts of the package and no others."""
    return typst.Fonts(include_system_fonts=False, include_embedded_fonts=False, font_paths=[str(FONTS)])


def pngs_of(drawings: Sequence[Drawing]) -> list[bytes]:
    """Return each drawing as PNG in shades of grey, all drawn in one go; the same drawings give the same bytes."""
    if not drawings:
        return []
    given = [asdict(each) for each in drawings]
    compiler = typst.Compiler(_PAGES, font_paths=bundled_fonts())
    drawn = compiler.compile(format="png", ppi=DOTS, sys_inputs={"drawings": json.dumps(given)})
    assert drawn is not None  # typst returns what it writes to no file
    pages = drawn if isinstance(drawn, list) else [drawn]
    return [_small(png, each.ground) for png, each in zip(pages, drawings, strict=True)]


def _small(png: bytes, ground: str) -> bytes:
    """Return a picture in few shades of grey, a third as large, which says how many dots an inch has."""
    target = io.BytesIO()
    grey = Image.open(io.BytesIO(png)).convert("L").point(_shades(ground))
    grey.save(target, "PNG", dpi=(DOTS, DOTS))
    return target.getvalue()


@cache
def _shades(ground: str) -> list[int]:
    """Return for every shade the nearest one that is kept: sixteen and that of the ground, so that no box is seen."""
    kept = (*range(0, 256, 17), ImageColor.getcolor(ground, "L"))
    return [min(kept, key=lambda shade: abs(shade - each)) for each in range(256)]
