"""Draw verdicts on the photo of an opened valve body: one SVG for page, customer's screen and paper.

What is flagged has a sign on its bore and a label beside the photo, with a leader between them; labels of one side
stand in the order of their bores and never on one another. On a narrow screen the photo alone is shown, with a number
at each of these bores, and the labels below it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from atleak.catalogue.castings import Casting
from atleak.common.style import look_of
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.charts.drawing import sign_svg, svg_head, svg_text, wrapped
from atleak.report.tables.lands import component_verdict, components_worst_first, leader
from atleak.report.tables.names import component_words, has_number
from atleak.report.tables.table import leveled

_WIDTH, _LABEL = 704.0, 140.0  # of the drawing and of a label: letters have one size, however wide the photo is
_WIDE, _HIGH = 400.0, 360.0  # the photo, at the most
_APART = 6.0  # between labels
_LETTERS, _LINE, _EDGE = 14.0, 17.5, 5.0
_ABREAST = int(_WIDTH // (_LABEL + _APART))  # labels of bores without a mark
_SIGNS = 15  # characters in a line of a label
_DISC, _DOT, _HIT = 9.0, 4.0, 14.0  # radii on the photo: of what is flagged, of the rest, and of what a press hits
_NUMBER = 13.0  # size of the numbers on the photo
_STYLE = Path(__file__).parents[1] / "templates" / "casting.css"
_Point = tuple[float, float]
_Box = tuple[float, float, float, float]  # from the left and upper to the right and lower edge


@dataclass(frozen=True)
class _Bore:
    """What the drawing says of a component's bore."""

    component: str
    number: str  # on the photo
    verdict: Verdict
    name: str
    said: tuple[str, ...]  # of each flagged land
    mark: _Point | None  # fractions of the photo's width and height

    @property
    def named(self) -> list[str]:
        """Return the lines of its name on its label; the sign stands beside the first."""
        return wrapped(self.name, _SIGNS - 2, 3)

    @property
    def lines(self) -> list[str]:
        """Return all lines of its label; none where no land is flagged."""
        return [*self.named, *(line for each in self.said for line in wrapped(each, _SIGNS, 2))] if self.said else []

    @property
    def high(self) -> float:
        """Return how high its label is."""
        return _LINE * len(self.lines) + 2.0 * _EDGE


@dataclass(frozen=True)
class CastingDrawing:
    """The drawing as SVG, and as it stands in a page of any width."""

    svg: str
    html: str


def casting_drawing(
    casting: Casting,
    diagnosis: Diagnosis,
    say: Wording,
    *,
    verdicts: Mapping[str, Verdict] | None = None,
    pressed: bool = False,
) -> CastingDrawing:
    """Draw the verdict of every bore that is marked on a photo; a flagged one without a mark stands below the photo.

    Parameters
    ----------
    verdicts
        of components, where they are other ones than the worst of their lands'.
    pressed
        whether a bore and its label can be pressed: each bears its component as ``data-pair``.
    """
    scale = min(_WIDE / casting.width, _HIGH / casting.height)
    width, height = scale * casting.width, scale * casting.height
    bores = list(_bores(diagnosis, casting, say, verdicts or {}))
    flagged = [bore for bore in bores if bore.said]
    sides = _sides([bore for bore in flagged if bore.mark], height)
    tall = max(height, *map(_stacked, sides))
    left, top = (_WIDTH - width) / 2.0, (tall - height) / 2.0
    points = {bore.component: (left + bore.mark[0] * width, top + bore.mark[1] * height) for bore in bores if bore.mark}
    labels: dict[str, _Point] = {}
    for side, x in zip(sides, (1.0, _WIDTH - _LABEL - 1.0), strict=True):
        tops = _tops([(points[bore.component][1], bore.high) for bore in side], tall)
        labels |= {bore.component: (x, y) for bore, y in zip(side, tops, strict=True)}
    parts = [
        f'<image href="{casting.photo}" x="{left:.1f}" y="{top:.1f}" width="{width:.1f}" height="{height:.1f}"/>',
        *(_leader(labels[bore.component], points[bore.component], bore.verdict) for side in sides for bore in side),
    ]
    if unmarked := [bore for bore in flagged if not bore.mark]:
        tall += 2.0 * _LINE
        heading = say("casting.unmarked")
        parts.append(svg_text(0.0, tall - _APART, heading, _LETTERS, anchor="start", ink="currentColor"))
        for first in range(0, len(unmarked), _ABREAST):
            row = unmarked[first : first + _ABREAST]
            labels |= {bore.component: (1.0 + number * (_LABEL + _APART), tall) for number, bore in enumerate(row)}
            tall += max(bore.high for bore in row) + _APART
    taken: list[_Box] = [(x - _DISC, y - _DISC, x + _DISC, y + _DISC) for x, y in points.values()]
    for bore in (*(bore for bore in bores if not bore.said), *flagged):  # what is flagged lies over the rest
        name = bore.component
        drawn = _mark(bore, points[name], taken, (left, left + width)) if name in points else ""
        drawn += _label(bore, *labels[name]) if name in labels else ""
        press = f' data-pair="{escape(name)}" tabindex="0" role="button"' if pressed else ""
        words = escape(", ".join((bore.name, say.signed(bore.verdict), *bore.said)))
        if drawn:
            parts.append(f'<g{press} aria-label="{words}"><title>{words}</title>{drawn}</g>')
    svg = "".join((svg_head(_WIDTH, tall, say("casting.alt"), "group" if pressed else "img"), *parts, "</svg>"))
    shown = f"--shape: {width:.1f} / {height:.1f}; --width: {_WIDTH / width:.2%}; --left: {-left / width:.2%}; "
    photo = f'<div class="photo" style="{shown}--top: {-top / height:.2%}">{svg}</div>'
    below = "".join(_below(bore, pressed) for bore in flagged)
    style = f"<style>{_STYLE.read_text(encoding='utf-8')}</style>"
    return CastingDrawing(svg, f'<div class="casting">{style}{photo}<div class="below">{below}</div></div>')


def _bores(diagnosis: Diagnosis, casting: Casting, say: Wording, verdicts: Mapping[str, Verdict]) -> Iterator[_Bore]:
    """Yield the bore of every component that has lands, the worst first."""
    controller = diagnosis.controller
    for count, component in enumerate(components_worst_first(diagnosis), start=1):
        number = component if has_number(controller, component) else str(count)
        verdict = verdicts.get(component) or component_verdict(diagnosis, component)
        name = component_words(controller, component, say)
        said = tuple(leader(diagnosis, land, say) for land in diagnosis.flagged if land.key[0] == component)
        yield _Bore(component, number, verdict, name, said, casting.marks.get(component))


def _stacked(side: Sequence[_Bore]) -> float:
    """Return how high the labels of a side are together."""
    return sum(bore.high + _APART for bore in side)


def _sides(bores: Sequence[_Bore], height: float) -> tuple[list[_Bore], list[_Bore]]:
    """Return the bores whose labels stand left and right, from the top: on the nearer side, while there is room."""
    ranked = sorted(bores, key=lambda bore: bore.mark or ())
    cut, most = sum(bore.mark < (0.5,) for bore in ranked if bore.mark), max(height, _stacked(ranked) / 2.0 + _LINE)
    while _stacked(ranked[:cut]) > most:
        cut -= 1
    while _stacked(ranked[cut:]) > most:
        cut += 1
    left, right = (sorted(side, key=lambda bore: (bore.mark or ())[::-1]) for side in (ranked[:cut], ranked[cut:]))
    return left, right


def _tops(labels: Sequence[_Point], tall: float) -> list[float]:
    """Return the top of each label, given the height of its bore and its own: as near as others and the edges allow."""
    tops, free = [], 1.0
    for y, high in labels:
        tops.append(max(free, y - high / 2.0))
        free = tops[-1] + high + _APART
    free = tall - 1.0
    for number in reversed(range(len(labels))):
        tops[number] = min(tops[number], free - labels[number][1])
        free = tops[number] - _APART
    return tops


def _leader(label: _Point, point: _Point, verdict: Verdict) -> str:
    """Draw the line from a label to its bore: seen on light and on dark."""
    x = label[0] + _LABEL if label[0] < point[0] else label[0]
    path = f'd="M{x:.1f} {label[1] + _EDGE + _LINE:.1f}L{point[0]:.1f} {point[1]:.1f}"'
    line = f'<path {path} class="leader" stroke="{look_of(verdict).line}" stroke-width="1.6"/>'
    return f'<path {path} class="leader" stroke="white" stroke-width="4"/>{line}'


def _mark(bore: _Bore, point: _Point, taken: list[_Box], ends: _Point) -> str:
    """Draw a disc with sign and number on a bore that is flagged, a ring on another one.

    The number is seen where there is no room for labels. It lies on as little as can be of what is ``taken``.
    """
    x, y = point
    look, circle = look_of(bore.verdict), f'<circle cx="{x:.1f}" cy="{y:.1f}" fill='
    if not bore.said:
        rings = (("white", 4.0, ""), (look.line, 1.6, f' stroke-dasharray="{look.dashes}"' if look.dashes else ""))
        drawn = (f'{circle}"none" r="{_DOT}" stroke="{ink}" stroke-width="{wide}"{more}/>' for ink, wide, more in rings)
        return f'{circle}"none" r="{_HIT}" pointer-events="all"/>{"".join(drawn)}'
    wide, far = 0.62 * _NUMBER * len(bore.number), _DISC + 3.0
    corners = ((far, -0.5 * _NUMBER), (-far - wide, -0.5 * _NUMBER), (-0.5 * wide, -far - _NUMBER), (-0.5 * wide, far))
    boxes = [(x + across, y + down, x + across + wide, y + down + _NUMBER) for across, down in corners]
    inside = [box for box in boxes if ends[0] <= box[0] and box[2] <= ends[1]]
    box = min(inside or boxes, key=lambda box: sum(_overlap(box, other) for other in taken))
    taken.append(box)
    number = svg_text(box[0], box[1] + 0.85 * _NUMBER, bore.number, _NUMBER, bold=True, anchor="start")
    return (
        f'{circle}"white" r="{_DISC + 2.0}"/>'
        f'{circle}"{look.fill}" r="{_DISC}" stroke="{look.line}" stroke-width="{look.width}" class="disc"/>'
        + sign_svg(bore.verdict, x, y, 0.5 * _DISC, look.on_fill)
        + f'<g class="number" display="none" stroke="white" stroke-width="3.5" paint-order="stroke">{number}</g>'
    )


def _overlap(one: _Box, other: _Box) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def _label(bore: _Bore, x: float, y: float) -> str:
    look = look_of(bore.verdict)
    box = f'<rect x="{x:.1f}" y="{y:.1f}" width="{_LABEL}" height="{bore.high:.1f}" rx="3" fill="{look.tint}" '
    parts = [f'{box}stroke="{look.line}"/>', sign_svg(bore.verdict, x + 11.0, y + _EDGE + 0.5 * _LINE, 5.0, look.line)]
    for number, line in enumerate(bore.lines):
        said = number >= len(bore.named)
        at = x + (_EDGE if said else 21.0), y + _EDGE + _LINE * (number + 0.75)
        parts.append(svg_text(*at, line, _LETTERS, bold=said, anchor="start", ink=look.on_tint))
    return "".join(parts)


def _below(bore: _Bore, pressed: bool) -> str:
    """Return a label as HTML, led by the number at its bore."""
    number = "" if bore.name.startswith(bore.number) or not bore.mark else f"<b>{escape(bore.number)}</b> "
    said = " ".join(leveled(f"{look_of(bore.verdict).sign} {each}", bore.verdict) for each in bore.said)
    tag, more = ("button", f' data-pair="{escape(bore.component)}"') if pressed else ("div", "")
    return f"<{tag}{more}>{number}{escape(bore.name)} {said}</{tag}>"
