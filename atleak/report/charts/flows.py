"""Lay out where the pump's flow goes, and draw it as ribbons, for screen and paper alike.

A ribbon's width is its flow; shade and sign of a place are its verdict.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from atleak.analysis.pressures import pressures_at
from atleak.catalogue.circuits import Circuit, Consumer, Leak
from atleak.common.style import PAPER_INKS, SCREEN, SHEET_OF_PAPER, look_of
from atleak.common.units import DM3_MIN, KPA
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording, isolated, wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.engine.flows import Flow, FlowKind, FlowPlace, flows_at
from atleak.engine.operation import LINE
from atleak.engine.projection import Projection
from atleak.report.charts.drawing import sign_svg, svg_head, svg_text, wrapped
from atleak.report.printed_fonts import width_of
from atleak.report.tables.names import has_number, land_number
from atleak.report.tables.table import VERDICT, Column, Table

_SHOWN = 12  # lands that are drawn by themselves; the others of a section stand together
_OTHERS = -1  # number of a land that stands for several


@dataclass(frozen=True)
class DrawnPlace:
    """One place of the diagram."""

    place: FlowPlace
    words: str  # short
    pressure: float | None  # [Pa] of a section or circuit
    name: str  # in full
    verdict: Verdict | None  # None where nothing is judged
    column: int  # 0 is the pump
    flow: float  # [m³/s] through it


@dataclass(frozen=True)
class DrawnFlow:
    """One flow of the diagram: between two of its places, by their numbers."""

    source: int
    target: int
    flow: float  # [m³/s]
    verdict: Verdict | None


@dataclass(frozen=True)
class FlowDiagram:
    """Where the flow goes at one condition, at the pressures that hold there."""

    projection: Projection
    places: tuple[DrawnPlace, ...]
    flows: tuple[DrawnFlow, ...]

    @property
    def columns(self) -> int:
        """Count the columns."""
        return 1 + max((each.column for each in self.places), default=0)


def flow_diagram(
    diagnosis: Diagnosis,
    projection: Projection,
    *,
    leaks_only: bool = False,
    lands: int = _SHOWN,
    say: Wording | None = None,
) -> FlowDiagram:
    """Lay out the flow at one condition of a diagnosis.

    Parameters
    ----------
    leaks_only
        begin at the line, and leave out slip, consumers and what is left over.
    lands
        how many are drawn by themselves: the worst first, of equal ones those that leak most.
    say
        the words of a language; English unless given.

    Raises
    ------
    DomainError
        temperature outside the fluid's data.
    """
    say = say or wording("en")
    every = flows_at(diagnosis.model, projection.condition)
    verdicts = _verdicts(diagnosis, projection, every.flows)
    flows, count = _together([*every.flows], verdicts, lands)
    if leaks_only:
        flows = [each for each in flows if each.source.kind not in (FlowKind.PUMP, FlowKind.BEYOND)]
    columns = _columns(flows)
    through: dict[FlowPlace, float] = {
        place: max(
            sum(each.flow for each in flows if each.target == place),
            sum(each.flow for each in flows if each.source == place),
        )
        for place in columns
    }
    order = sorted(columns, key=lambda place: (columns[place], -_rank(verdicts.get(place)), -through[place]))
    words = _Words(diagnosis, every.pressures, count, say)
    places = tuple(
        DrawnPlace(
            place=place,
            words=words.short(place),
            pressure=every.pressures[place.name] if place.kind is FlowKind.SECTION else None,
            name=words.full(place),
            verdict=verdicts.get(place),
            column=columns[place],
            flow=through[place],
        )
        for place in order
    )
    number = {place: at for at, place in enumerate(order)}
    drawn = (DrawnFlow(number[each.source], number[each.target], each.flow, _of_flow(each, verdicts)) for each in flows)
    return FlowDiagram(projection, places, tuple(drawn))


def flow_table(diagram: FlowDiagram, say: Wording) -> Table:
    """Return the diagram as a table, the largest flow first."""
    columns = (
        Column("verdict", VERDICT, width=92),
        Column("flows_from", of=lambda flow: diagram.places[flow.source].name),
        Column("flows_to", of=lambda flow: diagram.places[flow.target].name),
        Column("flow", "flow", 3, times=DM3_MIN),
    )
    return Table("flows", columns, sorted(diagram.flows, key=lambda each: -each.flow), say)


def flow_words(flow: float, say: Wording) -> str:
    """Return a flow [m³/s] in the reader's unit, with as many digits as small ones need: ``7.6``, ``0.088``."""
    value = flow * DM3_MIN
    return say.value(value, "flow", 1 if value >= 1.0 else 2 if value >= 0.1 else 3)


def _verdicts(diagnosis: Diagnosis, projection: Projection, flows: Sequence[Flow]) -> dict[FlowPlace, Verdict]:
    """Return the verdict of every place that is judged at a condition."""
    at = pressures_at(diagnosis, projection)
    of_lands = {land.key: land.verdict for land in diagnosis.lands}
    lands = {each.target for each in flows if each.target.kind is FlowKind.LAND}
    found = {land: of_lands[land.name, land.land] for land in lands}
    found |= {FlowPlace(FlowKind.SECTION, each.id): each.verdict for each in at.applied if each.verdict is not None}
    if at.reserve_verdict is not None:
        found[FlowPlace(FlowKind.PUMP)] = at.reserve_verdict
    return found


def _of_flow(flow: Flow, verdicts: dict[FlowPlace, Verdict]) -> Verdict | None:
    """Return the verdict of the land or circuit that a flow leads into, or out of where it leads to an end."""
    for place in (flow.target, flow.source):
        if place.kind in (FlowKind.LAND, FlowKind.SECTION) and place != FlowPlace(FlowKind.SECTION, LINE):
            return verdicts.get(place)
    return None


def _together(
    flows: Sequence[Flow], verdicts: dict[FlowPlace, Verdict], lands: int
) -> tuple[list[Flow], dict[FlowPlace, int]]:
    """Let lands that are not drawn by themselves stand together, by the sections between which they leak; count them.

    All that leak to the sump alone are one place.
    """
    through: dict[FlowPlace, float] = defaultdict(float)
    ends: dict[FlowPlace, set[tuple[int, FlowPlace]]] = defaultdict(set)
    for each in flows:
        if each.target.kind is FlowKind.LAND:
            through[each.target] += each.flow
            ends[each.target].add((0, each.source))
        if each.source.kind is FlowKind.LAND:
            ends[each.source].add((1, each.target))
    worst_first = sorted(through, key=lambda land: (-_rank(verdicts.get(land)), -through[land]))
    groups: dict[frozenset[tuple[int, FlowPlace]], list[FlowPlace]] = defaultdict(list)
    for land in worst_first[lands:]:
        to = {end for end in ends[land] if end[0] == 1}
        to_sump = {place.kind for _, place in to} == {FlowKind.SUMP}
        groups[frozenset(to if to_sump else ends[land])].append(land)
    stands_at = {land: land for land in through}
    count: dict[FlowPlace, int] = {}
    for number, alike in enumerate(groups.values()):
        if len(alike) > 1:
            place = FlowPlace(FlowKind.LAND, str(number), _OTHERS)
            count[place] = len(alike)
            verdicts[place] = max((verdicts[land] for land in alike), key=lambda verdict: verdict.rank)
            stands_at |= dict.fromkeys(alike, place)
    sums: dict[tuple[FlowPlace, FlowPlace], float] = defaultdict(float)
    for each in flows:
        sums[stands_at.get(each.source, each.source), stands_at.get(each.target, each.target)] += each.flow
    return [Flow(*both, flow) for both, flow in sums.items()], count


def _rank(verdict: Verdict | None) -> int:
    return -1 if verdict is None else verdict.rank


def _columns(flows: Sequence[Flow]) -> dict[FlowPlace, int]:
    """Return the column of every place: one behind the last that leads to it.

    What leads to the sump alone stands before it, and the sump last of all.
    """
    columns = {place: 0 for each in flows for place in (each.source, each.target)}
    for _ in columns:  # in a circle of flows places stay where the last round leaves them
        later = {each.target: columns[each.source] + 1 for each in sorted(flows, key=lambda each: columns[each.source])}
        moved = {place: max(column, later.get(place, 0)) for place, column in columns.items()}
        if moved == columns:
            break
        columns = moved
    last = max(columns.values(), default=0)
    leads_to: dict[FlowPlace, set[FlowKind]] = defaultdict(set)
    for each in flows:
        leads_to[each.source].add(each.target.kind)
    moved = {
        place: last - 1
        for place in columns
        if leads_to[place] == {FlowKind.SUMP} and place.kind is not FlowKind.SECTION
    }
    moved |= {place: last for place in columns if place.kind is FlowKind.SUMP}
    return columns | moved


@dataclass(frozen=True)
class _Words:
    """The words of the places."""

    diagnosis: Diagnosis
    pressures: Mapping[str, float]
    count: Mapping[FlowPlace, int]
    say: Wording

    def short(self, place: FlowPlace) -> str:
        """Return the words beside a place."""
        controller = self.diagnosis.controller
        if place.kind is not FlowKind.LAND or place in self.count:
            return self.name(place)
        if not has_number(controller, place.name):
            return land_number(controller, (place.name, place.land), self.say)
        return f"{place.name} · {place.land}"

    def full(self, place: FlowPlace) -> str:
        """Return the name of a place, of a section or circuit with its pressure."""
        if place.kind is not FlowKind.SECTION:
            return self.name(place)
        pressure = self.say.value(self.pressures[place.name] * KPA, "pressure", 0)
        return f"{self.name(place)} {pressure} {self.say.unit('pressure')}"

    def name(self, place: FlowPlace) -> str:
        """Return the name of a place."""
        say, controller = self.say, self.diagnosis.controller
        if place in self.count:
            return say("flows.others", count=self.count[place])
        if place.kind is FlowKind.LAND:
            named = isolated(say.name(controller.components[place.name]))
            return f"{self.short(place)} {named}" if has_number(controller, place.name) else self.short(place)
        described: dict[FlowKind, Sequence[Circuit | Leak | Consumer]] = {
            FlowKind.SECTION: controller.circuits,
            FlowKind.LEAK: controller.leaks,
            FlowKind.CONSUMER: controller.consumers,
        }
        if place.kind in described:
            known = next((each.name for each in described[place.kind] if each.id == place.name), "")
            return isolated(say.name(known) if known else say.get("pressures", place.name))
        return say(f"flows.{place.kind}")


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
    """Draw a flow diagram, in English unless told; a screen reader reads its title."""
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
    fill = (
        PAPER_INKS.ink if place.verdict in (None, Verdict.OK, Verdict.NOT_MEASURED) else look_of(place.verdict).screen
    )
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
    wide, tall = 1.1 * max(width_of(line, _SIZE) for line in lines) + 4.0, _ROW * len(lines)
    ground = (  # so that no edge of a ribbon strikes the words through
        f'<rect x="{x - 2.0:.1f}" y="{top - 10.5:.1f}" width="{wide:.1f}" height="{tall:.1f}" rx="3" '
        f'fill="{SHEET_OF_PAPER}" fill-opacity="0.8"/>'
    )
    bar = f'<rect x="{box.x:.1f}" y="{box.y:.2f}" width="{_BAR:g}" height="{box.height:.2f}" fill="{fill}"/>'
    return "".join((bar, ground, sign, *words))
