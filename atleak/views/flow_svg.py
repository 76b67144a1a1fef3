"""Draw where the pump's flow goes as ribbons, for screen and paper alike: width is flow, shade and sign are verdict."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

from atleak.look import PAPER, SCREEN, look_of
from atleak.verdicts import Verdict
from atleak.views.drawing import sign_svg, svg_head, svg_text, wrapped
from atleak.views.flow_diagram import DrawnFlow, DrawnPlace, FlowDiagram, flow_words
from atleak.wording import Wording, wording
from atleak.workshop_units import DM3_MIN, KPA

_HIGHEST = 240.0  # of all ribbons of the column through which most flows
_LEAST = 1.0  # of a ribbon: a thread that can still be seen
_BAR = 8.0  # width of a place
_ROW = 13.0  # from one line of words to the next
_BETWEEN = 5.0  # places of a column
_WIDEST = 730.0  # of the drawing, so that letters stay legible on paper, unless its columns are too many
_LETTERS = range(24, 8, -1)  # of a line of words, as many as there is room for
_LINES = 3  # of a name
_LETTER = 6.1  # mean width of one of them
_SIZE = 11.0  # of letters
_EDGE = 8.0
_SWEEPS = 4  # over the columns, until ribbons cross little
_UNJUDGED = SCREEN.pump


@dataclass
class _Box:
    """Where a place is drawn."""

    place: DrawnPlace
    lines: list[str]
    x: float
    y: float = 0.0
    height: float = 0.0
    out: float = 0.0  # height of the ribbons that already leave it
    into: float = 0.0

    @property
    def slot(self) -> float:
        """Return the height that it needs with its words."""
        return max(self.height, _ROW * len(self.lines)) + _BETWEEN


def flow_svg(diagram: FlowDiagram, title: str, say: Wording | None = None) -> str:
    """Draw a flow diagram.

    Parameters
    ----------
    title
        read by a screen reader.
    say
        decimal sign and words; English unless given.
    """
    say = say or wording("en")
    columns: dict[int, list[_Box]] = defaultdict(list)
    through = [sum(each.flow for each in diagram.places if each.column == at) for at in range(diagram.columns)]
    scale = _HIGHEST / max(through, default=1.0)
    words, lefts, width = _words_with_room(diagram, say)
    boxes = [
        _Box(place, lines, lefts[place.column], height=max(place.flow * scale, _LEAST * _ribbons(diagram, number)))
        for number, (place, lines) in enumerate(zip(diagram.places, words, strict=True))
    ]
    for box in boxes:
        columns[box.place.column].append(box)
    height = 2.0 * _EDGE + max(sum(box.slot for box in column) for column in columns.values())
    _arrange(columns, boxes, diagram, height)
    ribbons = sorted(diagram.flows, key=lambda each: (boxes[each.source].y, boxes[each.target].y))
    parts = [svg_head(width, height, title)]
    parts += [_ribbon(each, boxes[each.source], boxes[each.target], scale) for each in ribbons]
    parts += [_words(box) for box in boxes]
    return "".join((*parts, "</svg>"))


def _ribbons(diagram: FlowDiagram, number: int) -> int:
    """Count the ribbons on the fuller side of a place."""
    sides = ([each.source for each in diagram.flows], [each.target for each in diagram.flows])
    return max(side.count(number) for side in sides)


def _words_with_room(diagram: FlowDiagram, say: Wording) -> tuple[list[list[str]], list[float], float]:
    """Return the lines of words of every place, the left edges of the columns and the width, the widest that fits."""
    for letters in _LETTERS:
        words = [_lines(place, letters, say) for place in diagram.places]
        lefts, width = _lefts(diagram, words)
        if width <= _WIDEST:
            break
    return words, lefts, width


def _lefts(diagram: FlowDiagram, words: list[list[str]]) -> tuple[list[float], float]:
    """Return where each column begins, so that its words end before the next one, and the width of the drawing."""
    lefts, x = [], _EDGE
    for column in range(diagram.columns):
        lefts.append(x)
        placed = (lines for place, lines in zip(diagram.places, words, strict=True) if place.column == column)
        x += _BAR + 22.0 + _LETTER * max((len(line) for lines in placed for line in lines), default=0) + 6.0
    return lefts, x


def _lines(place: DrawnPlace, letters: int, say: Wording) -> list[str]:
    """Return the words of a place: name and flow, of a section or circuit its pressure too."""
    name, flow = wrapped(place.words, letters, _LINES), flow_words(place.flow, say)
    if place.pressure is None:
        both = f"{name[-1]} {flow}"
        return [*name[:-1], both] if len(both) <= letters else [*name, flow]
    pressure = f"{say.value(place.pressure * KPA, 'pressure', 0)} {say.unit('pressure')}"
    flow = f"{flow} {say.unit('flow')}"
    both = f"{pressure}, {flow}"
    return [*name, both] if len(both) <= letters else [*name, pressure, flow]


def _arrange(columns: Mapping[int, list[_Box]], boxes: list[_Box], diagram: FlowDiagram, height: float) -> None:
    """Order the places of each column by those that lead to them, so that ribbons cross little, and stack them."""
    for sweep in range(_SWEEPS):
        for number in sorted(columns, reverse=bool(sweep % 2)):
            column = columns[number]
            if sweep:
                centres = {id(box): _centre(box, boxes, diagram, sweep % 2 == 1) for box in column}
                column.sort(key=lambda box: centres[id(box)])
            y = _EDGE + (height - 2.0 * _EDGE - sum(box.slot for box in column)) / 2.0
            for box in column:
                box.y = y + (box.slot - _BETWEEN - box.height) / 2.0
                y += box.slot


def _centre(box: _Box, boxes: list[_Box], diagram: FlowDiagram, backward: bool) -> float:
    """Return the mean height of the places that a place is joined to on one side, by their flow."""
    weights = heights = 0.0
    for each in diagram.flows:
        here, there = (each.source, each.target) if backward else (each.target, each.source)
        if boxes[here] is box:
            weights += each.flow
            heights += each.flow * (boxes[there].y + boxes[there].height / 2.0)
    return heights / weights if weights > 0.0 else box.y + box.height / 2.0


def _ribbon(flow: DrawnFlow, source: _Box, target: _Box, scale: float) -> str:
    """Draw one flow from the right side of its source to the left side of its target."""
    thick = max(flow.flow * scale, _LEAST)
    x0, x1 = source.x + _BAR, target.x
    y0, y1 = source.y + source.out, target.y + target.into
    source.out += thick
    target.into += thick
    bend = (x1 - x0) / 2.0
    look = None if flow.verdict is None else look_of(flow.verdict)
    colour = _UNJUDGED if look is None else look.screen
    flagged = flow.verdict is not None and flow.verdict.flagged
    edge = f' stroke="{colour}" stroke-width="0.8"' if flagged else ""
    return (
        f'<path data-flow="{flow.flow * DM3_MIN:.6g}" fill="{colour}" fill-opacity="{0.6 if flagged else 0.3}"{edge} '
        f'd="M{x0:.1f} {y0:.2f}C{x0 + bend:.1f} {y0:.2f} {x1 - bend:.1f} {y1:.2f} {x1:.1f} {y1:.2f}'
        f"V{y1 + thick:.2f}C{x1 - bend:.1f} {y1 + thick:.2f} {x0 + bend:.1f} {y0 + thick:.2f} "
        f'{x0:.1f} {y0 + thick:.2f}Z"/>'
    )


def _words(box: _Box) -> str:
    """Draw a place, the sign of its verdict, its words and its flow."""
    place = box.place
    fill = PAPER.ink if place.verdict in (None, Verdict.OK, Verdict.NOT_MEASURED) else look_of(place.verdict).screen
    middle, x = box.y + box.height / 2.0, box.x + _BAR + 5.0
    sign = ""
    if place.verdict is not None:
        sign = sign_svg(place.verdict, x + 4.5, middle, 4.5, look_of(place.verdict).screen)
        x += 13.0
    bold = place.verdict is not None and place.verdict.flagged
    lines = box.lines
    top = middle + 4.0 - 0.5 * _ROW * (len(lines) - 1)
    words = (
        svg_text(x, top + _ROW * number, line, _SIZE, bold=bold, anchor="start") for number, line in enumerate(lines)
    )
    bar = f'<rect x="{box.x:.1f}" y="{box.y:.2f}" width="{_BAR:g}" height="{box.height:.2f}" fill="{fill}"/>'
    return "".join((bar, sign, *words))
