"""The controller with its components, and one spool with its planes, as SVG: the same drawing on screen and on paper.

Verdicts are told apart by shade, outline and sign, so that a greyscale print still shows them.
"""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from types import MappingProxyType

from atleak.controller import Controller, Land
from atleak.workshop_units import MM

FONT = "Noto Sans, DejaVu Sans, sans-serif"
INK = "#1B2733"
METAL = "#D9DEE3"
CARD = ' rx="4" fill="#FFFFFF"'
_DARK_INK, _DARK_CARD = "#E8EEF2", ' rx="4" fill="#1B262E"'


class Shade:
    """How a verdict looks: fill, outline, its width and dashes, and the colour of its sign."""

    __slots__ = ("dashes", "fill", "line", "sign", "width")

    def __init__(self, fill: str, line: str, width: float, dashes: str, sign: str) -> None:
        self.fill, self.line, self.width, self.dashes, self.sign = fill, line, width, dashes, sign


SHADES: Mapping[str, Shade] = MappingProxyType(
    {
        "ok": Shade("#F3F8F3", "#2E6B3A", 1.0, "", "#2E6B3A"),
        "watch": Shade("#F7D774", "#6B4A00", 1.4, "", "#4A3300"),
        "replace": Shade("#DD8452", "#5E1E00", 1.8, "", "#3B1200"),
        "critical": Shade("#8E1B16", "#4A0B08", 2.2, "", "#FFFFFF"),
        "not_measured": Shade("#FFFFFF", "#7A858F", 1.0, "3 2.5", "#7A858F"),
        "": Shade(METAL, INK, 1.0, "", INK),
    }
)
_SIGNS = {  # in a box of 2 by 2 around the origin
    "ok": '<circle r="0.8"/>',
    "watch": '<path d="M0-1 1 0.85H-1Z"/>',
    "replace": '<path d="M-0.8-0.8H0.8V0.8H-0.8Z"/>',
    "critical": '<path d="M-1-0.55-0.55-1 0-0.45 0.55-1 1-0.55 0.45 0 1 0.55 0.55 1 0 0.45-0.55 1-1 0.55-0.45 0Z"/>',
    "not_measured": '<path d="M0-0.9A0.9 0.9 0 1 1 0 0.9 0.9 0.9 0 1 1 0-0.9Z'
    'M0-0.6A0.6 0.6 0 1 0 0 0.6 0.6 0.6 0 1 0 0-0.6Z"/>',
}
_NUMBER = 8  # characters of a component's number that are drawn
_WIDTH = 1000.0
_ROW = 104.0
_ROD = 0.45  # of a land's diameter
_STRETCH = 2.2  # lengths are drawn up to this much larger than diameters
_BETWEEN = 5.0  # [mm] of rod between two lands, which no catalogue states


def sign_svg(verdict: str, x: float, y: float, size: float, colour: str | None = None) -> str:
    """The sign of a verdict as SVG shapes around a point: no font needed."""
    shade = SHADES[verdict]
    place = f"translate({x:.2f} {y:.2f}) scale({size:.3f})"
    return f'<g transform="{place}" fill="{colour or shade.line}">{_SIGNS[verdict]}</g>'


def controller_svg(
    controller: Controller,
    verdicts: Mapping[tuple[str, int], str] | None = None,
    *,
    columns: int = 5,
    title: str = "",
) -> str:
    """Every component that has lands, each land in the shade and with the sign of its verdict.

    Parameters
    ----------
    controller
        whose components are drawn in its own order, all to one scale; lengths are stretched.
    verdicts
        by (component, land); without them the lands are plain metal.
    columns
        components side by side.
    title
        read by a screen reader; the controller's name unless given.
    """
    components = [name for name in controller.components if controller.lands_of(name)]
    columns = max(min(columns, len(components)), 1)
    cell = _WIDTH / columns
    rows = -(-len(components) // columns)
    longest = max(_length(controller.lands_of(name)) for name in components)
    thickest = max(land.nominal_diameter for land in controller.lands) * MM
    scale = _scale(cell - 32.0, longest, 36.0, thickest)
    parts = [_head(_WIDTH, rows * _ROW, title or controller.name)]
    for number, name in enumerate(components):
        x, y = (number % columns) * cell, (number // columns) * _ROW
        parts.append(_component(controller, name, verdicts or {}, x, y, cell, scale))
    return "".join((*parts, "</svg>"))


def spool_svg(controller: Controller, component: str, verdicts: Mapping[tuple[str, int], str] | None = None) -> str:
    """One spool in its sleeve with the planes it is measured in, numbered as on the measuring sheet.

    Raises
    ------
    KeyError
        a component without lands.
    """
    lands = controller.lands_of(component)
    if not lands:
        raise KeyError(component)
    thickest = max(land.nominal_diameter for land in lands) * MM
    scale = _scale(900.0, _length(lands), 96.0, thickest)
    name = controller.components[component]
    parts = [_head(_WIDTH, 240.0, f"component {component}, {name}: lands and measuring planes")]
    middle = 120.0
    parts.append(_spool(lands, verdicts or {}, _WIDTH / 2.0, middle, scale, thick=2.0))
    reach = thickest * scale[1] / 2.0
    for land, left, width in _places(lands, _WIDTH / 2.0, scale):
        for number, plane in enumerate(land.planes):
            x = left + width * (number + 1) / (len(land.planes) + 1)
            parts.append(
                f'<path d="M{x:.1f} {middle - reach - 26:.1f}V{middle + reach + 26:.1f}" stroke="{INK}" '
                'stroke-width="1.2" stroke-dasharray="10 3 2 3"/>'
            )
            parts.append(_text(x, middle - reach - 34, plane, 18, bold=True))
        parts.append(_text(left + width / 2, middle + reach + 48, f"⌀ {land.nominal_diameter * MM:.3f}", 16))
    parts.append(_text(14, 24, shortened(f"{component} · {name}", 60), 18, bold=True, anchor="start"))
    return "".join((*parts, "</svg>"))


def on_dark(drawing: str) -> str:
    """The same drawing for a dark ground: light words and lines, dark cards; the lands keep their shades."""
    return drawing.replace(CARD, _DARK_CARD).replace(INK, _DARK_INK)


def _component(
    controller: Controller,
    name: str,
    verdicts: Mapping[tuple[str, int], str],
    x: float,
    y: float,
    cell: float,
    scale: tuple[float, float],
) -> str:
    lands = controller.lands_of(name)
    known = [verdicts[land.key] for land in lands if land.key in verdicts]
    order = ("not_measured", "ok", "watch", "replace", "critical")
    worst = max(known, key=order.index, default="")
    edge = SHADES[worst].line if worst in {"watch", "replace", "critical"} else "#C5CDD5"
    thick = {"watch": 1.2, "replace": 1.8, "critical": 2.6}.get(worst, 0.8)
    short = shortened(name, _NUMBER)
    lines = _wrapped(controller.components[name], max(int((cell - 30.0 - 9.5 * len(short)) / 5.8), 6), 2)
    label = "".join(
        _text(x + 12 + 9.5 * len(short) + 8, y + 20 + 13 * number, line, 11.5, anchor="start")
        for number, line in enumerate(lines)
    )
    return (
        f'<rect x="{x + 4:.1f}" y="{y + 4:.1f}" width="{cell - 8:.1f}" height="{_ROW - 8:.1f}"{CARD} '
        f'stroke="{edge}" stroke-width="{thick}"/>'
        + _text(x + 12, y + 21, short, 15, bold=True, anchor="start")
        + label
        + _spool(lands, verdicts, x + cell / 2.0, y + 66.0, scale, thick=1.0)
    )


def _spool(
    lands: tuple[Land, ...],
    verdicts: Mapping[tuple[str, int], str],
    centre: float,
    middle: float,
    scale: tuple[float, float],
    thick: float,
) -> str:
    places = _places(lands, centre, scale)
    left, right = places[0][1], places[-1][1] + places[-1][2]
    rod = min(land.nominal_diameter for land in lands) * MM * scale[1] * _ROD
    parts = [
        f'<rect x="{left - 4:.1f}" y="{middle - rod / 2:.1f}" width="{right - left + 8:.1f}" height="{rod:.1f}" '
        f'fill="{METAL}" stroke="{INK}" stroke-width="{0.6 * thick:.1f}"/>'
    ]
    for land, x, width in places:
        height = land.nominal_diameter * MM * scale[1]
        verdict = verdicts.get(land.key, "")
        shade = SHADES[verdict]
        dashes = f' stroke-dasharray="{shade.dashes}"' if shade.dashes else ""
        parts.append(
            f'<rect x="{x:.1f}" y="{middle - height / 2:.1f}" width="{width:.1f}" height="{height:.1f}" '
            f'fill="{shade.fill}" stroke="{shade.line}" stroke-width="{shade.width * thick:.1f}"{dashes}/>'
        )
        for side in (-1.0, 1.0):  # the sleeve's bore on both sides of the land
            y = middle + side * (height / 2 + 3.0 * thick)
            parts.append(
                f'<path d="M{x - 2:.1f} {y:.1f}H{x + width + 2:.1f}" stroke="{INK}" stroke-width="{1.4 * thick:.1f}"/>'
            )
        if verdict:
            parts.append(sign_svg(verdict, x + width / 2, middle, min(width * 0.26, 6.5 * thick), shade.sign))
    return "".join(parts)


def _places(lands: tuple[Land, ...], centre: float, scale: tuple[float, float]) -> list[tuple[Land, float, float]]:
    """Each land with its left edge and width on the drawing."""
    found, x = [], centre - _length(lands) * scale[0] / 2.0
    for land in lands:
        width = land.contact_length * MM * scale[0]
        found.append((land, x, width))
        x += width + _BETWEEN * scale[0]
    return found


def _scale(width: float, longest: float, height: float, thickest: float) -> tuple[float, float]:
    """Drawing units per millimetre along and across the axis: lengths may be stretched, never shrunk more."""
    across = min(height / thickest, width / longest)
    return min(width / longest, _STRETCH * across), across


def _length(lands: tuple[Land, ...]) -> float:
    return sum(land.contact_length * MM for land in lands) + _BETWEEN * (len(lands) - 1)


def shortened(text: str, width: int) -> str:
    """Text of at most so many characters, an ellipsis for what is left out."""
    return text if len(text) <= width else text[: max(width - 1, 0)].rstrip() + "…"


def _wrapped(text: str, width: int, lines: int) -> list[str]:
    """Text broken at spaces; what does not fit in so many lines ends in an ellipsis."""
    found, line = [], ""
    for word in text.split():
        longer = f"{line} {word}".strip()
        if line and len(longer) > width:
            found.append(line)
            longer = word
        line = longer
    found.append(line)
    short = [shortened(each, width) for each in found]
    if len(short) > lines:
        short = [*short[: lines - 1], shortened(f"{short[lines - 1].rstrip('…')} …", width)]
    return short


def _head(width: float, height: float, title: str) -> str:
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" width="{width:g}" '
        f'height="{height:g}" role="img"><title>{escape(title)}</title>'
    )


def _text(x: float, y: float, text: str, size: float, *, bold: bool = False, anchor: str = "middle") -> str:
    weight = ' font-weight="bold"' if bold else ""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" font-family="{FONT}" font-size="{size:g}" fill="{INK}" '
        f'text-anchor="{anchor}"{weight}>{escape(text)}</text>'
    )
