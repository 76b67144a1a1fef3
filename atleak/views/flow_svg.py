"""Draw where the pump's flow goes as ribbons, for screen and paper alike: width is flow, shade and sign are verdict."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

from atleak.look import PAPER, SCREEN, look_of
from atleak.verdicts import Verdict
from atleak.views.drawing import shortened, sign_svg, svg_head, svg_text
from atleak.views.flow_diagram import DrawnFlow, DrawnPlace, FlowDiagram, flow_words
from atleak.wording import Wording, wording
from atleak.workshop_units import DM3_MIN, KPA

_HIGHEST = 240.0  # of all ribbons of the column through which most flows
_LEAST = 1.0  # of a ribbon: a thread that can still be seen
_BAR = 8.0  # width of a place
_LINE = 15.0  # least height of a place for one line of words
_ROW = 13.0  # from one line of words to the next
_BETWEEN = 5.0  # places of a column
_LETTERS = 24  # of a name that are drawn
_LETTER = 6.1  # mean width of one of them
_SIZE = 11.0  # of letters
_EDGE = 8.0
_SWEEPS = 4  # over the columns, until ribbons cross little
_UNJUDGED = SCREEN.pump


@dataclass
class _Box:
    """Where a place is drawn."""

    place: DrawnPlace
    x: float
    y: float = 0.0
    height: float = 0.0
    out: float = 0.0  # height of the ribbons that already leave it
    into: float = 0.0

    @property
    def slot(self) -> float:
        """Return the height that it needs with its words."""
        return max(self.height, _LINE * (1 if self.place.pressure is None else 2)) + _BETWEEN


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
    lefts, width = _lefts(diagram, say)
    boxes = [
        _Box(place, lefts[place.column], height=max(place.flow * scale, _LEAST * _ribbons(diagram, number)))
        for number, place in enumerate(diagram.places)
    ]
    for box in boxes:
        columns[box.place.column].append(box)
    height = 2.0 * _EDGE + max(sum(box.slot for box in column) for column in columns.values())
    _arrange(columns, boxes, diagram, height)
    ribbons = sorted(diagram.flows, key=lambda each: (boxes[each.source].y, boxes[each.target].y))
    parts = [svg_head(width, height, title)]
    parts += [_ribbon(each, boxes[each.source], boxes[each.target], scale) for each in ribbons]
    parts += [_words(box, say) for box in boxes]
    return "".join((*parts, "</svg>"))


def _ribbons(diagram: FlowDiagram, number: int) -> int:
    """Count the ribbons on the fuller side of a place."""
    sides = ([each.source for each in diagram.flows], [each.target for each in diagram.flows])
    return max(side.count(number) for side in sides)


def _lefts(diagram: FlowDiagram, say: Wording) -> tuple[list[float], float]:
    """Return where each column begins, so that its words end before the next one, and the width of the drawing."""
    lefts, x = [], _EDGE
    for column in range(diagram.columns):
        lefts.append(x)
        placed = (each for each in diagram.places if each.column == column)
        letters = [len(line) for each in placed for line in _lines(each, say)]
        x += _BAR + 22.0 + _LETTER * max(letters, default=0) + 12.0
    return lefts, x


def _lines(place: DrawnPlace, say: Wording) -> list[str]:
    """Return the words of a place: name and flow, of a section or circuit its pressure too."""
    name, flow = shortened(place.words, _LETTERS), flow_words(place.flow, say)
    if place.pressure is None:
        return [f"{name} {flow}"]
    return [name, f"{say.value(place.pressure * KPA, 'pressure', 0)} {say.unit('pressure')}, {flow} {say.unit('flow')}"]


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
                box.y = y
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


def _words(box: _Box, say: Wording) -> str:
    """Draw a place, the sign of its verdict, its words and its flow."""
    place = box.place
    fill = PAPER.ink if place.verdict in (None, Verdict.OK, Verdict.NOT_MEASURED) else look_of(place.verdict).screen
    middle, x = box.y + box.height / 2.0, box.x + _BAR + 5.0
    sign = ""
    if place.verdict is not None:
        sign = sign_svg(place.verdict, x + 4.5, middle, 4.5, look_of(place.verdict).screen)
        x += 13.0
    bold = place.verdict is not None and place.verdict.flagged
    lines = _lines(place, say)
    top = middle + 4.0 - 0.5 * _ROW * (len(lines) - 1)
    words = (
        svg_text(x, top + _ROW * number, line, _SIZE, bold=bold, anchor="start") for number, line in enumerate(lines)
    )
    bar = f'<rect x="{box.x:.1f}" y="{box.y:.2f}" width="{_BAR:g}" height="{box.height:.2f}" fill="{fill}"/>'
    return "".join((bar, sign, *words))
