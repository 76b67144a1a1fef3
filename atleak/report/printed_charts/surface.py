"""Draw on a surface that becomes SVG: words that are measured, bars, curves and axes, all in points."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from atleak.look import PAPER, Look
from atleak.report.printed_fonts import width_of
from atleak.views.drawing import FONT, svg_head

WIDTH = 504.0
SIZE, SMALL = 9.0, 8.0  # of words
RULE, THIN, LINE = 0.5, 0.6, 1.1  # widths of lines
_TICK = 3.5
_MIDDLE = 0.36  # of the size, from the middle of a line of words to where they stand
_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)

Point = tuple[float, float]


@dataclass(frozen=True)
class Scale:
    """Where values stand on the surface: ``low`` at ``start``, ``high`` at ``stop``."""

    low: float
    high: float
    start: float
    stop: float

    def __call__(self, value: float) -> float:
        """Return where a value stands."""
        return self.start + (value - self.low) * (self.stop - self.start) / (self.high - self.low)

    def ticks(self, most: int = 6) -> list[float]:
        """Return round values in even steps, at most so many steps.

        >>> Scale(0.0, 31.0, 0.0, 1.0).ticks()
        [0.0, 10.0, 20.0, 30.0]
        """
        least = (self.high - self.low) / most
        power = 10.0 ** math.floor(math.log10(least))
        step = next(step * power for step in _STEPS if step * power >= least * (1.0 - 1e-9))
        first, last = math.ceil(self.low / step - 1e-9), math.floor(self.high / step + 1e-9)
        return [step * number for number in range(first, last + 1)]


class Surface:
    """What is drawn, in the order in which it covers what was drawn before."""

    def __init__(self, height: float) -> None:
        self.height = height
        self._parts: list[str] = []
        self._hatches: set[str] = set()

    def svg(self) -> str:
        """Return the drawing."""
        patterns = "".join(_HATCHES[name] for name in sorted(self._hatches))
        head = svg_head(WIDTH, self.height, "")
        return "".join((head, f"<defs>{patterns}</defs>" if patterns else "", *self._parts, "</svg>"))

    def words(
        self,
        at: Point,
        text: str,
        *,
        size: float = SIZE,
        anchor: str = "start",
        bold: bool = False,
        turned: bool = False,
    ) -> None:
        """Write a line of words, its middle at the height of a point; ``turned`` to be read from below."""
        x, y = at
        weight = ' font-weight="bold"' if bold else ""
        shift = _MIDDLE * size
        place = f'transform="translate({x + shift:.1f} {y:.1f}) rotate(-90)"' if turned else _at(x, y + shift)
        self._parts.append(
            f'<text {place} font-family="{FONT}" font-size="{size:g}" fill="{PAPER.ink}" text-anchor="{anchor}"'
            f"{weight}>{escape(text)}</text>"
        )

    def line(
        self, points: Iterable[Point], colour: str = PAPER.ink, width: float = RULE, dashes: Sequence[float] = ()
    ) -> None:
        """Draw a line through points; a point that is no number leaves a gap."""
        path, pen, last = [], "M", ""
        for x, y in points:
            if not (math.isfinite(x) and math.isfinite(y)):
                pen, last = "M", ""
                continue
            place = f"{x:.1f} {y:.1f}"
            if place != last:
                path.append(pen + place)
            pen, last = "L", place
        dashed = f' stroke-dasharray="{" ".join(f"{each * width:g}" for each in dashes)}"' if dashes else ""
        self._parts.append(
            f'<path d="{"".join(path)}" fill="none" stroke="{colour}" stroke-width="{width:g}"{dashed} '
            'stroke-linejoin="round"/>'
        )

    def box(self, corner: Point, size: Point, fill: str, edge: str, thick: float, hatch: str = "") -> None:
        """Draw a rectangle from its upper left corner, with a hatch over its fill."""
        (x, y), (width, height) = corner, size
        shape = f'x="{x:.1f}" y="{y:.1f}" width="{max(width, 0.0):.1f}" height="{height:.1f}"'
        edged = f'stroke="{edge}" stroke-width="{thick:g}"'
        self._parts.append(f'<rect {shape} fill="{fill}" {edged}/>')
        if hatch:
            self._hatches.add(hatch)
            self._parts.append(f'<rect {shape} fill="url(#{hatch})" {edged}/>')

    def bar(self, start: float, end: float, middle: float, height: float, look: Look) -> None:
        """Draw a bar in the shade of a verdict."""
        corner, size = (start, middle - height / 2.0), (end - start, height)
        self.box(corner, size, look.fill, look.line, 0.8, look.hatch)

    def interval(self, start: float, end: float, middle: float) -> None:
        """Draw an interval as a line with a stroke at each end."""
        self.line([(start, middle), (end, middle)], width=LINE)
        for x in (start, end):
            self.line([(x, middle - 2.5), (x, middle + 2.5)], width=LINE)

    def sign(self, look: Look, at: Point) -> None:
        """Draw the sign of a verdict in its shade."""
        corners = " ".join(f"{at[0] + 3.5 * x:.1f},{at[1] + 3.5 * y:.1f}" for x, y in look.shape.points)
        self._parts.append(f'<polygon points="{corners}" fill="{look.fill}" stroke="{look.line}" stroke-width="1"/>')

    def triangle(self, at: Point, way: float) -> None:
        """Draw a small filled triangle that points right (1) or left (−1)."""
        x, y = at
        corners = f"{x - 3.0 * way:.1f},{y - 3.0:.1f} {x + 3.0 * way:.1f},{y:.1f} {x - 3.0 * way:.1f},{y + 3.0:.1f}"
        self._parts.append(f'<polygon points="{corners}" fill="{PAPER.ink}"/>')

    def disc(self, at: Point, radius: float, fill: str = PAPER.ink) -> None:
        """Draw a disc with an outline."""
        self._parts.append(
            f'<circle cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="{radius:g}" fill="{fill}" stroke="{PAPER.ink}" '
            'stroke-width="0.9"/>'
        )

    # --- axes

    def across(self, scale: Scale, top: float, bottom: float, said: Callable[[float], str], title: str = "") -> None:
        """Draw an axis along the bottom of a field with its grid; without a title its values are not written."""
        for value in scale.ticks():
            x = scale(value)
            self.line([(x, top), (x, bottom)], PAPER.rule)
            if title:
                self.line([(x, bottom), (x, bottom + _TICK)], width=THIN)
                self.words((x, bottom + _TICK + 7.0), said(value), anchor="middle")
        self.line([(scale.start, bottom), (scale.stop, bottom)], width=THIN)
        if title:
            self.words(((scale.start + scale.stop) / 2.0, bottom + 24.0), title, anchor="middle")

    def up(self, scale: Scale, left: float, right: float, said: Callable[[float], str], title: str) -> None:
        """Draw an axis along the left side of a field with its grid."""
        for value in scale.ticks(most=max(int((scale.start - scale.stop) / 18.0), 2)):
            y = scale(value)
            self.line([(left, y), (right, y)], PAPER.rule)
            self.line([(left - _TICK, y), (left, y)], width=THIN)
            self.words((left - _TICK - 2.5, y), said(value), anchor="end")
        self.line([(left, scale.stop), (left, scale.start)], width=THIN)
        self.words((6.0, (scale.start + scale.stop) / 2.0), title, anchor="middle", turned=True)


def _at(x: float, y: float) -> str:
    return f'x="{x:.1f}" y="{y:.1f}"'


def widest(names: Iterable[str], size: float = SMALL) -> float:
    """Return the width of the widest of several words."""
    return max((width_of(name, size) for name in names), default=0.0)


def points(x: Scale, y: Scale, over: np.ndarray, values: np.ndarray) -> Iterable[Point]:
    """Return where the samples of a curve stand."""
    return zip(
        (x.start + (over - x.low) * ((x.stop - x.start) / (x.high - x.low))).tolist(),
        (y.start + (values - y.low) * ((y.stop - y.start) / (y.high - y.low))).tolist(),
        strict=True,
    )


def _hatch(name: str, inside: str, turned: str = "") -> str:
    return f'<pattern id="{name}" width="4" height="4" patternUnits="userSpaceOnUse"{turned}>{inside}</pattern>'


_HATCHES = {
    "lines": _hatch("lines", f'<path d="M2 0V4" stroke="{PAPER.ink}" stroke-width="0.6"/>',
                    ' patternTransform="rotate(30)"'),
    "dots": _hatch("dots", f'<circle cx="2" cy="2" r="0.5" fill="{PAPER.soft}"/>'),
}  # fmt: skip
