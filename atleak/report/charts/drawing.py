"""Draw the controller with its components, and one spool with its planes, as SVG for screen and paper alike.

Verdicts differ in shade, outline and sign, so that a greyscale print still shows them.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from html import escape
from typing import NamedTuple

from atleak.catalogue.controller import Controller, Land
from atleak.common.sentences import Name, Sentence
from atleak.common.style import DARK, EDGE, PAPER_INKS, QUIET_ON_DARK, Inks, look_of
from atleak.common.units import MM
from atleak.common.verdicts import Verdict, worst
from atleak.common.wording import Wording, wording
from atleak.report.tables.names import has_number

FONT = "Noto Sans, DejaVu Sans, sans-serif"

_NUMBER = 8  # characters of a component's number that are drawn
_TITLE = 5  # most lines of its name
_WIDTH = 1000.0
_ROW = 104.0
_LINE = 13.0  # from one line of a name to the next
_LETTER = 6.3  # mean width of a letter of a name
_ROD = 0.45  # diameter of the rod as a fraction of the smallest land's diameter
_STRETCH = 2.2  # lengths are drawn up to this much larger than diameters
_END_VIEW = 220.0  # of the width, for a spool seen along its axis
_PICTURE = 160.0, 44.0  # [px] of a component drawn by itself
_ABOVE, _BELOW = 56.0, 58.0  # of the axis, beside a spool's reach: the planes' numbers, and the diameters
_ABOVE_END_VIEW, _BELOW_END_VIEW = 96.0, 84.0  # of the axis, where directions are drawn
_AFTER_HYPHEN = re.compile(r"(?<=[^-]-)(?=[^-\d])|(?<=[^-\d]-)(?=\d)")  # shift valve 1-2 is not broken in its number
_VOWELS = "aeiouyäöüàâéèêëïîôùûąęó"
_ONSET = r"sch|ch|ck|ph|th|qu|sz|cz|rz|([bdfgkptw])(?<!\1\1)(?<!ck)[lr]"  # consonants that stay together
_SYLLABLE = re.compile(rf"(?<=\w)(?:{_ONSET}|[^\W\d_{_VOWELS}])(?=[{_VOWELS}])", re.IGNORECASE)  # where one begins
_LEAST = 3  # letters before a hyphen, and one more behind it
_BETWEEN = 5.0  # [mm] of rod between two lands, where the file states no positions


def sign_svg(verdict: str, x: float, y: float, size: float, colour: str) -> str:
    """Draw the sign of a verdict as an SVG shape around a point: no font is needed."""
    shape = look_of(verdict).shape
    points = " ".join(f"{across:g},{down:g}" for across, down in shape.points)
    ink = f'fill="{colour}"' if shape.filled else f'fill="none" stroke="{colour}" stroke-width="0.3"'
    return f'<polygon transform="translate({x:.2f} {y:.2f}) scale({size:.3f})" points="{points}" {ink}/>'


def controller_svg(
    controller: Controller,
    verdicts: Mapping[tuple[str, int], str] | None = None,
    *,
    columns: int = 5,
    title: str = "",
    only: Collection[str] = (),
    named: Callable[[str], str] = str,
    letters: float = 1.0,
    note: str = "",
) -> str:
    """Draw every component that has lands, each land in the shade and with the sign of its verdict.

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
    only
        the components that are drawn, none of them wider for being few; all of them unless given.
    named
        writes a component's name in the reader's language.
    letters
        size of the words against the usual one.
    note
        stands below the drawing.
    """
    components = [name for name in controller.components if controller.lands_of(name)]
    if only:
        components = [name for name in components if name in only]
    else:
        columns = max(min(columns, len(components)), 1)
    cell = _WIDTH / columns
    titles = {
        name: _title(name if has_number(controller, name) else "", named(controller.components[name]), cell, letters)
        for name in components
    }
    lines = max(len(title.lines) for title in titles.values())
    row = _ROW * (1.0 + 0.5 * (letters - 1.0)) + _LINE * letters * max(lines - 2, 0)
    rows = -(-len(components) // columns)
    longest = max(_length(controller.lands_of(name)) for name in components)
    thickest = max(land.nominal_diameter for land in controller.lands) * MM
    scale = _scale(cell - 32.0, longest, 36.0, thickest)
    tall = rows * row + (_LINE * letters + 8.0 if note else 0.0)
    parts = [svg_head(_WIDTH, tall, title or controller.name)]
    for number, name in enumerate(components):
        x, y = (number % columns) * cell, (number // columns) * row
        parts.append(_component(controller.lands_of(name), titles[name], verdicts or {}, (x, y, cell, row), scale))
    if note:
        parts.append(svg_text(4.0, tall - 6.0, note, 11.5 * letters, anchor="start"))
    return "".join((*parts, "</svg>"))


def component_svgs(controller: Controller, verdicts: Mapping[tuple[str, int], str]) -> dict[str, str]:
    """Draw every component that has lands by itself, all to one scale: the pictures that a page lays out as it likes.

    Words are left to the page, which has room for them; a sign and the shade tell the verdict of each land, of which
    there is one by (component, land).
    """
    width, height = _PICTURE
    names = [name for name in controller.components if controller.lands_of(name)]
    longest = max(_length(controller.lands_of(name)) for name in names)
    thickest = max(land.nominal_diameter for land in controller.lands) * MM
    scale = _scale(width - 16.0, longest, height - 12.0, thickest)
    return {
        name: svg_head(width, height, f"{name} · {controller.components[name]}")
        + _spool(controller.lands_of(name), verdicts, width / 2.0, height / 2.0, scale, thick=1.0)
        + "</svg>"
        for name in names
    }


def spool_svg(
    controller: Controller,
    component: str,
    verdicts: Mapping[tuple[str, int], str] | None = None,
    say: Wording | None = None,
    *,
    directions: Sequence[float] = (),
) -> str:
    """Draw one spool in its sleeve with the planes it is measured in, numbered as on the measuring sheet.

    Its name is left to the page, which has room for it. Every plane bears its name as ``data-plane`` and every
    direction its angle as ``data-direction``, so that a page can light the ones that are measured now.

    Parameters
    ----------
    verdicts
        by (component, land).
    say
        the reader's words and units; English and metric unless given.
    directions
        of measuring [°] round the axis, 0 is upright: seen along the axis, beside the spool.

    Raises
    ------
    KeyError
        a component without lands.
    """
    say, verdicts = say or wording("en"), verdicts or {}
    lands = controller.lands_of(component)
    if not lands:
        raise KeyError(component)
    room = _END_VIEW if directions else 0.0
    thickest = max(land.nominal_diameter for land in lands) * MM
    scale = _scale(900.0 - room, _length(lands), 96.0, thickest)
    reach = thickest * scale[1] / 2.0
    above, below = reach + _ABOVE, reach + _BELOW  # no empty band above or beneath
    if directions:
        above, below = max(above, _ABOVE_END_VIEW), max(below, _BELOW_END_VIEW)
    name = Name(controller.components[component])
    title = Sentence("component {component}, {name}: lands and measuring planes", component=component, name=name)
    parts = [svg_head(_WIDTH, above + below, say.sentence(title))]
    centre, middle = (_WIDTH - room) / 2.0, above
    parts.append(_spool(lands, verdicts, centre, middle, scale, thick=2.0))
    for land, left, width in _places(lands, centre, scale):
        for number, plane in enumerate(land.planes):
            x = left + width * (number + 1) / (len(land.planes) + 1)
            line = _axis_line(f"{x:.1f} {middle - reach - 26:.1f}", f"{x:.1f} {middle + reach + 26:.1f}")
            label = svg_text(x, middle - reach - 34, plane, 18, bold=True)
            parts.append(f'<g data-plane="{escape(plane)}">{line}{label}</g>')
        nominal = say.value(land.nominal_diameter * MM, "length", 3)
        parts.append(svg_text(left + width / 2, middle + reach + 48, f"⌀ {nominal}", 16))
    parts.append(_end_view(directions, _WIDTH - room / 2.0, middle, say))
    return "".join((*parts, "</svg>"))


def upright_svg(controller: Controller, component: str, size: tuple[float, float], note: str) -> str:
    """Draw one spool upright, its left end on top, with the planes it is measured in: for the rows of a printed sheet.

    Where the controller's file states where the lands lie, lengths and diameters have one scale.

    Parameters
    ----------
    size
        width and height of the room [pt].
    note
        stands below a drawing that is not to scale.

    Raises
    ------
    KeyError
        a component without lands.
    """
    lands = controller.lands_of(component)
    if not lands:
        raise KeyError(component)
    width, height = (4.0 * each for each in size)  # a unit is a quarter of a point
    letters, known = 40.0, all(land.position is not None for land in lands)
    beside = 0.6 * letters * max(len(plane) for land in lands for plane in land.planes) + 48.0
    longest, thickest = _length(lands), max(land.nominal_diameter for land in lands) * MM
    scale = _scale(height - (24.0 if known else 72.0), longest, min(width - beside - 24.0, 0.55 * width), thickest)
    if known:
        scale = min(scale), min(scale)
    reach, long = thickest * scale[1] / 2.0, longest * scale[0]
    axis, top = (width - beside) / 2.0, 12.0
    spool = _spool(lands, {}, long / 2.0, 0.0, scale, thick=2.0)
    title = f"{component} · {controller.components[component]}"
    parts = [svg_head(width, height, title)]
    parts.append(f'<g transform="translate({axis:.1f} {top:.1f}) rotate(90)">{spool}</g>')
    apart = long / sum(len(land.planes) for land in lands)
    for land, left, along in _places(lands, long / 2.0, scale):
        for number, plane in enumerate(land.planes):
            y = top + left + along * (number + 1) / (len(land.planes) + 1)
            parts.append(_axis_line(f"{axis - reach - 16:.1f} {y:.1f}", f"{axis + reach + 24:.1f} {y:.1f}"))
            size_of = min(letters, apart)
            parts.append(svg_text(axis + reach + 32, y + 0.36 * size_of, plane, size_of, bold=True, anchor="start"))
    if not known:
        parts.append(svg_text(width / 2.0, min(top + long + 48.0, height - 12.0), note, 28.0))
    return "".join((*parts, "</svg>"))


def directions_svg(directions: Sequence[float], say: Wording, title: str) -> str:
    """Draw a spool seen along its axis with the directions of measuring [°], 0 upright."""
    return svg_head(_END_VIEW, _END_VIEW, title) + _end_view(directions, _END_VIEW / 2, _END_VIEW / 2, say) + "</svg>"


def _end_view(directions: Sequence[float], x: float, y: float, say: Wording) -> str:
    """Draw the spool seen along its axis, with a line for each direction in which a diameter is measured."""
    if not directions:
        return ""
    parts = [
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="48" fill="{PAPER_INKS.metal}" '
        f'stroke="{PAPER_INKS.ink}" stroke-width="1.5"/>'
    ]
    for angle in directions:
        across, up = math.sin(math.radians(angle)), math.cos(math.radians(angle))
        ends = [f"{x + far * across:.1f} {y - far * up:.1f}" for far in (-62.0, 62.0)]
        label = svg_text(x + 80.0 * across, y + 6.0 - 80.0 * up, f"{say.plain(angle)}°", 18, bold=True)
        parts.append(f'<g data-direction="{angle:g}">{_axis_line(*ends)}{label}</g>')
    return "".join(parts)


def _axis_line(start: str, end: str) -> str:
    return f'<path d="M{start}L{end}" stroke="{PAPER_INKS.ink}" stroke-width="1.2" stroke-dasharray="10 3 2 3"/>'


def on_dark(drawing: str) -> str:
    """Return the same drawing for a dark ground: light words, dark cards, no land brighter than a bad one."""
    dark = {_card(PAPER_INKS): _card(DARK), **QUIET_ON_DARK, PAPER_INKS.ink: DARK.ink, PAPER_INKS.metal: DARK.metal}
    for light, ink in dark.items():
        drawing = drawing.replace(light, ink)
    return drawing


def _card(inks: Inks) -> str:
    return f' rx="4" fill="{inks.card}"'


class _Title(NamedTuple):
    """The words above a component: its number, where it has one, and the lines of its name beside it."""

    number: str
    lines: list[str]
    left: float  # where the name begins
    letters: float  # their size against the usual one


def _title(number: str, name: str, cell: float, letters: float) -> _Title:
    short = shortened(number, _NUMBER)
    left = 20.0 + 9.5 * letters * len(short) if short else 12.0
    room = max(int((cell - 10.0 - left) / (_LETTER * letters)), 6)
    return _Title(short, wrapped(name, room, _TITLE), left, letters)


def _component(
    lands: tuple[Land, ...],
    title: _Title,
    verdicts: Mapping[tuple[str, int], str],
    place: tuple[float, float, float, float],  # left and top edge, width and height
    scale: tuple[float, float],
) -> str:
    x, y, cell, row = place
    letters = title.letters
    reached = worst(Verdict(verdicts[land.key]) for land in lands if land.key in verdicts)
    edge, thick = (look_of(reached).line, look_of(reached).width) if reached.flagged else (EDGE, 0.8)
    down = y + 8.0 + 12.0 * letters
    label = "".join(
        svg_text(x + title.left, down + _LINE * letters * line, each, 11.5 * letters, anchor="start")
        for line, each in enumerate(title.lines)
    )
    if title.number:
        label = svg_text(x + 12, down + letters, title.number, 15 * letters, bold=True, anchor="start") + label
    return (
        f'<rect x="{x + 4:.1f}" y="{y + 4:.1f}" width="{cell - 8:.1f}" height="{row - 8:.1f}"{_card(PAPER_INKS)} '
        f'stroke="{edge}" stroke-width="{thick}"/>'
        + label
        + _spool(lands, verdicts, x + cell / 2.0, y + row - 38.0, scale, thick=1.0)
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
        f'fill="{PAPER_INKS.metal}" stroke="{PAPER_INKS.ink}" stroke-width="{0.6 * thick:.1f}"/>'
    ]
    for land, x, width in places:
        height = land.nominal_diameter * MM * scale[1]
        look = look_of(verdicts[land.key]) if land.key in verdicts else None
        fill, line, thickness = (look.fill, look.line, look.width) if look else (PAPER_INKS.metal, PAPER_INKS.ink, 1.0)
        dashes = f' stroke-dasharray="{look.dashes}"' if look and look.dashes else ""
        parts.append(
            f'<rect x="{x:.1f}" y="{middle - height / 2:.1f}" width="{width:.1f}" height="{height:.1f}" '
            f'fill="{fill}" stroke="{line}" stroke-width="{thickness * thick:.1f}"{dashes}/>'
        )
        for side in (-1.0, 1.0):  # the sleeve's bore on both sides of the land
            y = middle + side * (height / 2 + 3.0 * thick)
            parts.append(
                f'<path d="M{x - 2:.1f} {y:.1f}H{x + width + 2:.1f}" stroke="{PAPER_INKS.ink}" '
                f'stroke-width="{1.4 * thick:.1f}"/>'
            )
        if look:
            size = min(width * 0.26, 6.5 * thick)
            parts.append(sign_svg(verdicts[land.key], x + width / 2, middle, size, look.on_fill))
    return "".join(parts)


def _places(lands: tuple[Land, ...], centre: float, scale: tuple[float, float]) -> list[tuple[Land, float, float]]:
    """Return each land with its left edge and width on the drawing."""
    left = centre - _length(lands) * scale[0] / 2.0
    return [
        (land, left + start * scale[0], land.contact_length * MM * scale[0])
        for land, start in zip(lands, _starts(lands), strict=True)
    ]


def _starts(lands: tuple[Land, ...]) -> list[float]:
    """Return where each land begins [mm]: as it lies on its spool, where that is known of all of them."""
    positions = [land.position * MM for land in lands if land.position is not None]
    if len(positions) == len(lands):
        return [position - min(positions) for position in positions]
    ends = itertools.accumulate(land.contact_length * MM + _BETWEEN for land in lands[:-1])
    return [0.0, *ends]


def _scale(width: float, longest: float, height: float, thickest: float) -> tuple[float, float]:
    """Return drawing units per millimetre along and across the axis: lengths may be stretched, never shrunk more."""
    across = min(height / thickest, width / longest)
    return min(width / longest, _STRETCH * across), across


def _length(lands: tuple[Land, ...]) -> float:
    return max(start + land.contact_length * MM for land, start in zip(lands, _starts(lands), strict=True))


def shortened(text: str, width: int) -> str:
    """Return text of at most so many characters; an ellipsis stands for the rest."""
    return text if len(text) <= width else text[: max(width - 1, 0)].rstrip() + "…"


def wrapped(text: str, width: int, lines: int) -> list[str]:
    """Break text at spaces and hyphens, and within a word that is longer than a line.

    After so many lines it ends in an ellipsis.
    """
    broken, line = [], ""
    for part in _parts(text, width):
        if line and len(line) + len(part.rstrip()) > width:
            broken.append(f"{line.rstrip()}-" if line[-1] not in " -" else line.rstrip())
            line = ""
        line += part
    broken.append(line.rstrip())
    return broken if len(broken) <= lines else [*broken[: lines - 1], shortened(f"{broken[lines - 1]} …", width)]


def _parts(text: str, width: int) -> Iterator[str]:
    """Return the parts of a text between which a line may end; those of a word that is too long for one, too."""
    for word in text.split():
        *before, last = _AFTER_HYPHEN.split(word)
        for part in (*before, f"{last} "):
            while len(part.rstrip()) > width:
                end = _syllable(part, width - 1)
                yield part[:end]
                part = part[end:]
            yield part


def _syllable(word: str, most: int) -> int:
    """Return where to break a word after so many letters at the most: before a syllable, where one begins there."""
    begins = (each.start() for each in _SYLLABLE.finditer(word))
    return max((at for at in begins if _LEAST <= at <= min(most, len(word.rstrip()) - _LEAST - 1)), default=most)


def svg_head(width: float, height: float, title: str, role: str = "img") -> str:
    """Return the beginning of a drawing; ``title`` is read by a screen reader."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" width="{width:g}" '
        f'height="{height:g}" role="{role}"><title>{escape(title)}</title>'
    )


def svg_text(
    x: float, y: float, text: str, size: float, *, bold: bool = False, anchor: str = "middle", ink: str = PAPER_INKS.ink
) -> str:
    """Return a line of text at a point."""
    weight = ' font-weight="bold"' if bold else ""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" font-family="{FONT}" font-size="{size:g}" fill="{ink}" '
        f'text-anchor="{anchor}"{weight}>{escape(text)}</text>'
    )
