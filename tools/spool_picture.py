"""Draw the picture of the workbook: a spool in its bore, with the lengths and diameters of its lands.

python tools/spool_picture.py
"""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from atleak.common.style import SHEET_COLOURS
from atleak.report.sheets.controller_workbook import SPOOL_PICTURE

_INK, _SOFT = SHEET_COLOURS["heading"], SHEET_COLOURS["soft"]
_BODY, _SPOOL = SHEET_COLOURS["bore"], SHEET_COLOURS["spool"]
_LANDS = ((1.6, 2.4), (6.6, 2.0))  # start and length of the two lands
_RADIUS, _BORE, _ROD = 1.0, 1.13, 0.42
_PORTS = ((0.35, 0.9), (3.4, 2.6), (8.95, 0.9))  # start and length of the openings in the bore


def draw() -> None:
    figure = Figure(figsize=(15.0, 6.4), dpi=100)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(-0.4, 12.4)
    axes.set_ylim(-2.75, 2.75)
    axes.set_axis_off()
    _bore_and_spool(axes)
    (first, _), (second, _) = _LANDS
    _length(axes, first, _PORTS[1][0], -1.78, "contact length:\nspool and bore face each other")
    _length(axes, 0.0, first, 2.15, "position: from the left end\nto the near edge of the land")
    axes.plot([first, first], [_RADIUS, 2.3], color=_SOFT, lw=0.8)
    axes.plot([0.0, 0.0], [_ROD, 2.3], color=_SOFT, lw=0.8)
    _height(axes, second + 1.0, -_RADIUS, _RADIUS, "diameter")
    axes.annotate(
        "clearance, drawn too wide:\nradial here, diametral both sides together",
        (second + 1.6, (_RADIUS + _BORE) / 2), (second + 1.2, 2.25),
        fontsize=15, color=_INK, arrowprops={"arrowstyle": "->", "color": _INK}, va="center", ha="left",
    )  # fmt: skip
    axes.annotate(
        "from: the higher pressure", (5.1, -1.0), (6.0, -2.3),
        fontsize=15, color=_INK, arrowprops={"arrowstyle": "->", "color": _INK}, ha="center", va="center",
    )  # fmt: skip
    axes.annotate(
        "to: the lower one, or the drain", (9.4, -1.1), (9.7, -2.3),
        fontsize=15, color=_INK, arrowprops={"arrowstyle": "<-", "color": _INK}, ha="center", va="center",
    )  # fmt: skip
    for number, (start, _) in enumerate(_LANDS, start=1):
        axes.text(start + 0.12, 0.72, f"land {number}", fontsize=16, color=_INK, ha="left", va="center", weight="bold")
    axes.text(10.15, 1.38, "valve body", fontsize=15, color=_SOFT, va="center")
    figure.savefig(SPOOL_PICTURE, format="png", metadata={"Software": None})


def _bore_and_spool(axes: Axes) -> None:
    for side in (-1.0, 1.0):
        bottom = _BORE if side > 0 else -_BORE - 0.5
        axes.add_patch(Rectangle((0.0, bottom), 10.0, 0.5, facecolor=_BODY, edgecolor=_SOFT, lw=1.0))
    for start, width in _PORTS:
        axes.add_patch(Rectangle((start, -_BORE - 0.52), width, 0.54, facecolor="white", edgecolor="none"))
        axes.plot([start, start], [-_BORE, -_BORE - 0.5], color=_SOFT, lw=1.0)
        axes.plot([start + width, start + width], [-_BORE, -_BORE - 0.5], color=_SOFT, lw=1.0)
    axes.add_patch(Rectangle((0.0, -_ROD), 9.4, 2 * _ROD, facecolor=_SPOOL, edgecolor=_INK, lw=1.4))
    for start, width in _LANDS:
        axes.add_patch(Rectangle((start, -_RADIUS), width, 2 * _RADIUS, facecolor=_SPOOL, edgecolor=_INK, lw=1.8))
    axes.plot([-0.2, 10.2], [0.0, 0.0], color=_SOFT, lw=0.8, dashes=(14, 4, 3, 4))


def _length(axes: Axes, first: float, last: float, height: float, words: str) -> None:
    axes.annotate("", (first, height), (last, height), arrowprops={"arrowstyle": "<->", "color": _INK, "lw": 1.4})
    above = height > 0
    for x in (first, last) if not above else ():
        axes.plot([x, x], [-_RADIUS, height - 0.08], color=_SOFT, lw=0.8)
    x, align = ((first + last) / 2, "center") if not above else (last + 0.15, "left")
    y, upright = (height - 0.12, "top") if not above else (height, "center")
    axes.text(x, y, words, fontsize=15, color=_INK, ha=align, va=upright)


def _height(axes: Axes, x: float, low: float, high: float, words: str) -> None:
    axes.annotate("", (x, low), (x, high), arrowprops={"arrowstyle": "<->", "color": _INK, "lw": 1.4})
    axes.text(x + 0.1, -0.55, words, fontsize=14, color=_INK, va="center")


if __name__ == "__main__":
    draw()
