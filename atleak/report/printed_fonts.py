"""Know the fonts of the printed report: which characters they have, and how wide a text is in them."""

from __future__ import annotations

import unicodedata
from functools import cache
from pathlib import Path

from fontTools.ttLib import TTFont

FONTS = Path(__file__).parent / "fonts"
_TEXT, _OTHERS = "NotoSans-Regular.ttf", ("NotoSans-Bold.ttf", "DejaVuSans.ttf")
_UNKNOWN = 0.6  # width of a character that is set in another font, against the size


@cache
def _widths(name: str) -> dict[int, float]:
    """Return the width of every character of a bundled font, against the size."""
    with TTFont(FONTS / name, lazy=True) as font:
        metrics, em = font["hmtx"].metrics, font["head"].unitsPerEm
        return {sign: metrics[glyph][0] / em for sign, glyph in font.getBestCmap().items()}


@cache
def glyphs() -> frozenset[int]:
    """Return the code points that the bundled fonts have."""
    return frozenset().union(*map(_widths, (_TEXT, *_OTHERS)))


def width_of(text: str, size: float) -> float:
    """Return how wide a line of text is [in the unit of its size]."""
    widths = _widths(_TEXT)
    return size * sum(widths.get(ord(sign)) or _elsewhere(sign) for sign in text)


def _elsewhere(sign: str) -> float:
    """Return about how wide a character is in another font: those of East Asia fill a square."""
    return 1.0 if unicodedata.east_asian_width(sign) in "WF" else _UNKNOWN


def fitting(text: str, size: float, width: float) -> str:
    """Return as much of a text as is no wider; an ellipsis stands for the rest."""
    if width_of(text, size) <= width:
        return text
    shorter = text
    while shorter and width_of(f"{shorter}…", size) > width:
        shorter = shorter[:-1].rstrip()
    return f"{shorter}…"
