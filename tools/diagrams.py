"""Draw the diagrams of the documentation by the package's own drawing, with numbers computed from the sample jobs.

    python tools/diagrams.py                # all of them, into docs/pictures
    python tools/diagrams.py --only gap     # one of them; may be repeated
    python tools/diagrams.py --check        # status 1 where one that is kept is not what is drawn today

Each is an SVG on a white ground, so that it can be read on dark pages too. Drawings are equal where their words are
equal and no number differs by more than `APART`. Of a chart that matplotlib drew, words, lines and colours are compared
so: how it writes a style, from which corner it draws an area, and how far from an axis or a corner it puts words and
the legend differs from one of its versions to another.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import picture_jobs as made

from atleak.analysis.pressures import HeldPressure, pressures_at
from atleak.analysis.what_if import WhatIf, tried
from atleak.common.style import PAPER_INKS, SHEET_COLOURS, SHEET_OF_PAPER, SPREADS, look_of
from atleak.common.units import DM3_MIN, KPA, MM, UM
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording, wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.engine.projection import Projection
from atleak.equations.gap import ENTRY_AND_EXIT_LOSS, eccentricity_factor, entry_loss_flow
from atleak.measurements.measuring_plan import DIRECTIONS
from atleak.report.charts import paper_axes as plotting
from atleak.report.charts.drawing import sign_svg, spool_svg, svg_head, svg_text
from atleak.report.charts.paper_curves import pump_chart
from atleak.report.tables.pressures import pump_over_speed

PICTURES = Path(__file__).resolve().parents[1] / "docs" / "pictures"
APART = 0.06  # [px] that two drawings may differ by at any place
PAIR = ("25", 1)  # land of the four-speed's sample that costs most
WIDE = 200e-6  # [m] a gap far past every limit, at which the loss at its entry can be seen
_ARROW = 7.0  # length of an arrow's head
WORDS_APART = 8.0  # [px] that two versions of matplotlib may put the words and the legend of a chart apart
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")
_COLOUR = re.compile(r"#[0-9a-fA-F]{6}\b")
_CORNER = re.compile(r"[A-Za-z][^A-Za-z]*")
_SVG = "{http://www.w3.org/2000/svg}"
_SHOWN_TAGS = [_SVG + name for name in ("path", "use", "text", "rect")]
_OF_MATPLOTLIB = '<g id="matplotlib.axis_1">'

SAY: Wording = wording("en")
BODY, SPOOL = SHEET_COLOURS["bore"], SHEET_COLOURS["spool"]
FLUID = SPREADS[0]


# --- what is computed


@cache
def four_speed() -> Diagnosis:
    """Return the diagnosis of the sample job."""
    return made.sample_case().diagnose()


@cache
def five_speed() -> Diagnosis:
    """Return the diagnosis of the five-speed's sample sheet."""
    return made.sample_case(name=made.FIVE_SPEED, controller="five_speed_2005", road_test=None).diagnose()


def hot_idle(diagnosis: Diagnosis) -> Projection:
    """Return the hot idle of a diagnosis."""
    return next(each for each in diagnosis.projections if each.condition.name == "hot_idle")


def worst_circuit() -> tuple[Projection, HeldPressure]:
    """Return the circuit of the five-speed's sample that loses most, and where."""
    found = five_speed()
    every = [(at, held) for at in found.projections for held in pressures_at(found, at).circuits if not held.vented]
    return max(every, key=lambda each: each[1].loss)


def kpa(pressure: float) -> str:
    """Write a pressure [Pa]."""
    return f"{pressure * KPA:.0f} kPa"


# --- drawing


@dataclass
class Drawing:
    """An SVG that is drawn piece by piece, on a white ground."""

    width: float
    height: float
    title: str
    parts: list[str] = field(default_factory=list)

    def rect(
        self, x: float, y: float, width: float, height: float, fill: str, line: str = "", round: float = 0
    ) -> None:
        """Draw an area, with an outline where its colour is given."""
        stroke = f' stroke="{line}" stroke-width="1.4"' if line else ""
        self.parts.append(
            f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="{round:g}" fill="{fill}"{stroke}/>'
        )

    def path(self, points: Sequence[tuple[float, float]], colour: str, width: float = 1.4, dashes: str = "") -> None:
        """Draw a line through points."""
        way = "L".join(f"{x:g} {y:g}" for x, y in points)
        dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
        self.parts.append(f'<path d="M{way}" fill="none" stroke="{colour}" stroke-width="{width:g}"{dashed}/>')

    def arrow(
        self, start: tuple[float, float], end: tuple[float, float], colour: str, width: float = 1.4, both: bool = False
    ) -> None:
        """Draw an arrow; ``both`` gives it a head at either end."""
        self.path((start, end), colour, width)
        for tip, tail in ((end, start), (start, end))[: 2 if both else 1]:
            angle = math.atan2(tip[1] - tail[1], tip[0] - tail[0])
            size = _ARROW + width
            corners = [tip] + [
                (tip[0] - size * math.cos(angle + turn), tip[1] - size * math.sin(angle + turn)) for turn in (-0.4, 0.4)
            ]
            points = " ".join(f"{x:.1f},{y:.1f}" for x, y in corners)
            self.parts.append(f'<polygon points="{points}" fill="{colour}"/>')

    def circle(self, x: float, y: float, radius: float, fill: str, line: str = PAPER_INKS.ink) -> None:
        """Draw a disc."""
        self.parts.append(
            f'<circle cx="{x:g}" cy="{y:g}" r="{radius:g}" fill="{fill}" stroke="{line}" stroke-width="1.4"/>'
        )

    def words(
        self, x: float, y: float, lines: str | Iterable[str], size: float = 14.0, *, bold: bool = False,
        anchor: str = "middle",
    ) -> None:  # fmt: skip
        """Write lines below one another, the first at a point."""
        for number, line in enumerate([lines] if isinstance(lines, str) else lines):
            self.parts.append(svg_text(x, y + 1.35 * size * number, line, size, bold=bold, anchor=anchor))

    @property
    def svg(self) -> str:
        """Return the drawing."""
        head = svg_head(self.width, self.height, self.title)
        return "\n".join((head + _ground(self.width, self.height), *self.parts, "</svg>\n"))


def _ground(width: float, height: float) -> str:
    return f'<rect width="{width:g}" height="{height:g}" fill="{SHEET_OF_PAPER}"/>'


def on_white(drawing: str) -> str:
    """Return a drawing of the package on a white ground."""
    return re.sub(r"(<svg\b[^>]*>)", rf'\1<rect width="100%" height="100%" fill="{SHEET_OF_PAPER}"/>', drawing, count=1)


# --- the diagrams


def gap() -> str:
    """Draw a land in its bore, with what the gap law takes of it."""
    found, at = four_speed(), hot_idle(four_speed())
    land = next(each for each in found.lands if each.key == PAIR)
    (leak,) = at.gaps_of(PAIR)
    (spool, sleeve), state = _diameters(land.state.land.component), land.state
    assert state.radial_clearance is not None
    drawing = Drawing(860, 430, "A land in its bore: clearance, contact length and the pressures at both ends")
    drawing.rect(60, 46, 740, 66, BODY, SHEET_COLOURS["soft"])
    drawing.rect(60, 112, 740, 46, FLUID)
    drawing.rect(60, 158, 740, 130, FLUID)
    drawing.rect(60, 214, 740, 74, SPOOL, PAPER_INKS.ink)
    drawing.rect(240, 158, 370, 130, SPOOL, PAPER_INKS.ink)
    drawing.rect(238, 215, 374, 72, SPOOL)
    drawing.path(((40, 288), (820, 288)), SHEET_COLOURS["soft"], 1.0, "14 4 3 4")
    drawing.words(430, 84, "valve body", 15, bold=True)
    drawing.words(430, 250, "land of the spool", 15, bold=True)
    for y in (124, 135, 146):
        drawing.arrow((90, y), (230, y), PAPER_INKS.leakage, 1.6)
        drawing.arrow((620, y), (770, y), PAPER_INKS.leakage, 1.6)
    drawing.path(((240, 135), (610, 135)), PAPER_INKS.leakage, 1.2, "6 5")
    drawing.words(148, 184, (f"from {kpa(at.pressures['p_g'])}", "(main pressure)"), 13)
    low = at.pressures["p_g"] - leak.pressure_drop
    drawing.words(706, 184, (f"to {kpa(low)},", "then the oil pan"), 13)
    drawing.arrow((300, 112), (300, 158), PAPER_INKS.ink, 1.6, both=True)
    drawing.words(
        312, 30, f"radial clearance: {land.state.land.new_clearance * UM:.1f} µm when new, "
        f"{state.radial_clearance * UM:.1f} µm measured cold, {leak.effective_clearance * UM:.1f} µm at 100 °C",
        13, anchor="start",
    )  # fmt: skip
    drawing.path(((300, 112), (306, 34)), SHEET_COLOURS["soft"], 0.8)
    drawing.path(((240, 288), (240, 330)), SHEET_COLOURS["soft"], 0.8)
    drawing.path(((610, 288), (610, 330)), SHEET_COLOURS["soft"], 0.8)
    drawing.arrow((240, 322), (610, 322), PAPER_INKS.ink, 1.4, both=True)
    drawing.words(425, 344, f"contact length {leak.contact_length * MM:.1f} mm", 13)
    drawing.words(640, 312, (f"spool ⌀ {spool:.3f} mm", f"bore ⌀ {sleeve:.3f} mm"), 13, anchor="start")
    drawing.words(
        430, 380,
        f"leaks {leak.leakage * DM3_MIN:.2f} dm³/min: {100 * at.share_of(leak.leakage):.1f} % of the pump's flow",
        15, bold=True,
    )  # fmt: skip
    drawing.words(430, 408, "Land 1 of component 25 of the sample job at hot idle. The gap is drawn far too wide.", 12)
    return drawing.svg


def _diameters(component: str) -> tuple[float, float]:
    """Return the mean diameters of spool and bore of the first land of a component [mm]."""
    readings = four_speed().readings
    assert readings is not None
    plane = four_speed().controller.lands_of(component)[0].planes[0]
    own = [each for each in readings.readings if (each.component, each.plane) == (component, plane)]
    means = [np.mean([each.diameter for each in own if (each.part == "sleeve") is bore]) for bore in (False, True)]
    return float(means[0]) * MM, float(means[1]) * MM


def pressure_distribution() -> str:
    """Draw the pressure along a gap: new, as measured, and far too wide."""
    at = hot_idle(four_speed())
    (leak,) = at.gaps_of(PAIR)
    high, length = at.pressures["p_g"], leak.contact_length
    new = hot_idle_of_new()
    widths = ((new, "new"), (leak.effective_clearance, "as measured"), (WIDE, "far too wide"))
    looks = ((PAPER_INKS.pump, "--"), (PAPER_INKS.leakage, "-"), (PAPER_INKS.ink, ":"))
    with plotting.drawing():
        figure = plotting.figure_of(250.0)
        axes = plotting.field(figure, 52.0, 490.0, 12.0, 196.0)
        for (clearance, name), (colour, line) in zip(widths, looks, strict=True):
            flow = entry_loss_flow(
                leak.pressure_drop, leak.diameter, clearance, leak.kinematic_viscosity, leak.density, length
            )
            speed = flow / (math.pi * leak.diameter * clearance)
            lost = ENTRY_AND_EXIT_LOSS * leak.density * speed**2 / 2.0
            places = [-1.2e-3, 0.0, 0.0, length, length + 1.2e-3]
            low = high - leak.pressure_drop
            pressures = [high, high, high - lost, low, low]
            parts = f"{clearance * UM:.0f} µm, {flow * DM3_MIN:.2f} dm³/min, {100 * lost / leak.pressure_drop:.1f} %"
            label = f"{name}: {parts} lost at its ends"
            axes.plot(
                [each * MM for each in places], [each * KPA for each in pressures], color=colour, ls=line, lw=1.8,
                label=label,
            )  # fmt: skip
        axes.axvspan(0.0, length * MM, color=SPOOL, alpha=0.35, lw=0)
        axes.set_xlim(-1.2, length * MM + 1.2)
        axes.set_ylim(0.0, 1.12 * high * KPA)
        plotting.number_axes(axes, SAY, "x", "y")
        axes.set_xlabel("along the land [mm]; shaded: where spool and bore face each other")
        axes.set_ylabel("pressure [kPa]")
        axes.legend(loc="lower left", fontsize=plotting.SIZE - 1.0, frameon=False)
        return on_white(plotting.svg(figure))


def hot_idle_of_new() -> float:
    """Return the effective clearance of the pair when new, at hot idle [m]."""
    found = four_speed()
    (leak,) = found.new_at(hot_idle(found)).gaps_of(PAIR)
    return float(leak.effective_clearance)


def eccentricity() -> str:
    """Draw where a spool can lie in its bore, and what the whole unit leaks then."""
    found, at = four_speed(), hot_idle(four_speed())
    drawing = Drawing(860, 330, "A spool in the middle of its bore, half way, and touching it: what each leaks")
    names = ("in the middle", "half way", "touching")
    for number, (part, name) in enumerate(zip((0.0, 0.5, 1.0), names, strict=True)):
        x, bore, spool = 150.0 + 280.0 * number, 96.0, 74.0
        drawing.circle(x, 130, bore + 14, BODY, SHEET_COLOURS["soft"])
        drawing.circle(x, 130, bore, FLUID)
        drawing.circle(x, 130 + part * (bore - spool), spool, SPOOL)
        shares = tried(found, WhatIf(point=at.condition.name, eccentricity=part)).projection.share
        factor = float(eccentricity_factor(part, 1.0))
        drawing.words(x, 135 + part * (bore - spool), f"e/c = {part:g}", 15, bold=True)
        drawing.words(x, 272, f"{name}: F = {factor:.3g}", 14, bold=True)
        drawing.words(x, 293, f"the sample at hot idle leaks {100 * shares:.1f} %", 13)
    drawing.words(430, 320, "Seen along the axis; the gap is drawn far too wide. % of what the pump delivers.", 12)
    return drawing.svg


def pump_and_leakage() -> str:
    """Draw the report's chart of the pump's flow over engine speed against what is taken from it."""
    found = four_speed()
    return on_white(pump_chart(pump_over_speed(found, hot_idle(found), SAY), SAY))


def circuit() -> str:
    """Draw a circuit with its feed and its leaks, with the pressures of the five-speed's sample."""
    at, held = worst_circuit()
    found, circuit = five_speed(), held.circuit
    assert circuit is not None
    feed = circuit.feeds[0]
    look = look_of(held.verdict or Verdict.NOT_MEASURED)
    drawing = Drawing(860, 400, f"A circuit with its feed and its leaks: {circuit.name}")
    drawing.rect(30, 110, 170, 76, FLUID, PAPER_INKS.ink, 6)
    drawing.words(115, 140, "main pressure (line)", 14, bold=True)
    drawing.words(115, 164, kpa(at.main_pressure_held), 15)
    drawing.arrow((200, 148), (292, 148), PAPER_INKS.pump, 3)
    for y in (104, 160):
        drawing.rect(296, y, 22, 34, BODY, PAPER_INKS.ink)
    drawing.words(307, 70, ("the feed:", f"orifice ⌀ {feed.diameter * MM:.2g} mm"), 13)
    drawing.arrow((300, 148), (398, 148), PAPER_INKS.pump, 3)
    drawing.rect(402, 92, 226, 112, look.tint, look.line, 6)
    drawing.words(515, 118, circuit.name, 15, bold=True)
    drawing.words(515, 144, f"holds {kpa(held.now)}", 15)
    drawing.words(515, 166, f"new: {kpa(held.new)}", 13)
    drawing.parts.append(sign_svg(held.verdict or Verdict.NOT_MEASURED, 432, 185, 5, look.line))
    drawing.words(
        446,
        190,
        f"loss {kpa(held.loss)}: {SAY.level(held.verdict or Verdict.NOT_MEASURED)}",
        13,
        bold=True,
        anchor="start",
    )
    drawing.arrow((628, 148), (690, 148), PAPER_INKS.pump, 3)
    drawing.rect(694, 110, 136, 76, SPOOL, PAPER_INKS.ink, 6)
    drawing.words(762, 140, ("piston of", "the clutch"), 14, bold=True)
    worst = held.costly[:2]
    for number, (key, gained) in enumerate(worst):
        x = 415 + 215 * number
        from_circuit = 450 + 130 * number
        drawing.arrow((from_circuit, 206), (from_circuit, 262), PAPER_INKS.leakage, 3)
        land = next(each for each in found.lands if each.key == key)
        name = found.controller.components[key[0]]
        clearance = land.state.radial_clearance or 0.0
        lines = (
            f"{name}, land {key[1]}:",
            f"{clearance * UM:.0f} µm radial clearance;",
            f"new it gives back {kpa(gained)}",
        )
        drawing.words(x, 282, lines, 12)
    drawing.path(((300, 340), (760, 340)), PAPER_INKS.ink, 1.4)
    drawing.words(530, 358, "oil pan", 13, bold=True)
    drawing.words(
        430,
        388,
        f"Five-speed sample, {at.condition.label}. It holds the pressure at which its feed brings what leaks out.",
        12,
    )
    return drawing.svg


def spool_measuring() -> str:
    """Draw the dashboard's picture of where a spool is measured, with its planes and directions."""
    own = spool_svg(four_speed().controller, PAIR[0], directions=DIRECTIONS)
    width, height = (float(each) for each in re.findall(r'(?:width|height)="([\d.]+)"', own)[:2])
    drawing = Drawing(width, height + 56.0, "Where a spool is measured")
    drawing.parts.append(own)
    planes = " · ".join(plane for land in four_speed().controller.lands_of(PAIR[0]) for plane in land.planes)
    drawing.words((width - 220.0) / 2.0, height + 22.0, f"planes {planes}: one in the middle of every land", 16)
    drawing.words(width - 110.0, height + 22.0, ("seen along the axis:", "two directions"), 16)
    return drawing.svg


def data_flow() -> str:
    """Draw what goes into a verdict, and what comes out of it."""
    found = four_speed()
    readings, road = found.readings, found.log
    assert readings is not None
    assert road is not None
    drawing = Drawing(880, 420, "From readings, valve body and log to the verdict")
    rows = (
        ("Measuring sheet", f"sample: {len(readings.readings)} readings", 36),
        ("Valve body and fluid", f"sample: {len(found.controller.lands)} lands, their pressures, the pump", 152),
        ("Road-test log", f"sample: {len(road.road_test.time)} rows", 268),
    )
    for name, said, y in rows:
        _box(drawing, 20, y, 230, 84, FLUID, name, _two(said))
    _box(drawing, 330, 36, 210, 84, SHEET_OF_PAPER, "Clearances and wear", ("of every land, with", "their uncertainty"))
    _box(drawing, 330, 152, 210, 84, SHEET_OF_PAPER, "Leakage", ("of every gap, at every", "condition, over the log"))
    _box(drawing, 330, 268, 210, 84, SHEET_OF_PAPER, "Pressures", ("what pump and circuits", "hold against it"))
    flagged = [sum(each.verdict is level for each in found.lands) for level in (Verdict.REPLACE, Verdict.WATCH)]
    look = look_of(found.verdict)
    told = (
        f"sample: {SAY.level(found.verdict)}", f"{flagged[0]} lands to replace,", f"{flagged[1]} to watch", "",
        "which pair, why,", "how sure, what to", "repair first",
    )  # fmt: skip
    _box(drawing, 620, 36, 240, 200, look.tint, "Verdict", told, line=look.line)
    _box(drawing, 620, 268, 240, 84, SHEET_OF_PAPER, "To take along", ("report, workbook, JSON,", "job file, job book"))
    limits = "judged by limits: published, chosen by this project, or the workshop's own"
    for start, end in (
        ((250, 78), (328, 78)), ((250, 194), (328, 194)), ((250, 310), (328, 310)),
        ((250, 172), (328, 96)), ((250, 216), (328, 290)), ((250, 290), (328, 212)),
        ((435, 120), (435, 150)), ((435, 236), (435, 266)),
        ((540, 78), (618, 78)), ((540, 194), (618, 194)), ((540, 300), (618, 226)), ((740, 236), (740, 266)),
    ):  # fmt: skip
        drawing.arrow(start, end, PAPER_INKS.soft, 1.6)
    drawing.words(440, 392, limits, 13)
    return drawing.svg


def _two(said: str) -> tuple[str, ...]:
    head, _, rest = said.partition(", ")
    return (f"{head},", rest) if rest else (head,)


def _box(
    drawing: Drawing, x: float, y: float, width: float, height: float, fill: str, name: str, lines: Iterable[str],
    line: str = PAPER_INKS.ink,
) -> None:  # fmt: skip
    drawing.rect(x, y, width, height, fill, line, 6)
    drawing.words(x + width / 2.0, y + 27, name, 16, bold=True)
    drawing.words(x + width / 2.0, y + 50, lines, 13)


DIAGRAMS: dict[str, Callable[[], str]] = {
    "gap": gap,
    "pressure-distribution": pressure_distribution,
    "eccentricity": eccentricity,
    "pump-and-leakage": pump_and_leakage,
    "circuit": circuit,
    "spool-measuring": spool_measuring,
    "data-flow": data_flow,
}


# --- kept and compared


def same(first: str, second: str) -> bool:
    """Tell whether two drawings are equal but for the last digits of their places."""
    if _OF_MATPLOTLIB in first and _OF_MATPLOTLIB in second:
        return _same_chart(first, second)
    return _alike(first, second)


def _alike(first: str, second: str, apart: float = APART) -> bool:
    """Tell whether two texts are equal but for numbers that differ by no more than what is given."""
    if _NUMBER.sub("#", first) != _NUMBER.sub("#", second):
        return False
    pairs = zip(_NUMBER.findall(first), _NUMBER.findall(second), strict=True)
    return all(abs(float(one) - float(other)) <= apart for one, other in pairs)


def _same_chart(first: str, second: str) -> bool:
    """Tell whether two charts of matplotlib, of any of its versions, say and show the same."""
    ones, others = _shown(first), _shown(second)
    return len(ones) == len(others) and all(
        (one.what, one.colours, one.said) == (other.what, other.colours, other.said)
        and _alike(one.line, other.line)
        and _alike(one.place, other.place, WORDS_APART)
        for one, other in zip(ones, others, strict=True)
    )


@dataclass(frozen=True)
class _Shown:
    """What an element of a chart shows."""

    what: str
    colours: tuple[str, ...]
    said: str
    line: str
    place: str


def _shown(drawing: str) -> list[_Shown]:
    root = ElementTree.fromstring(drawing)
    legend = {each for group in root.iter(f"{_SVG}g") if group.get("id") == "legend_1" for each in group.iter()}
    return [_as_shown(each, each in legend) for each in root.iter() if each.tag in _SHOWN_TAGS]


def _as_shown(element: ElementTree.Element, in_legend: bool) -> _Shown:
    given = element.attrib
    style = " ".join(given.get(name, "") for name in ("style", "fill", "stroke"))
    colours = tuple(sorted(_COLOUR.findall(style.casefold())))
    corners = [corner.strip() for corner in _CORNER.findall(given.get("d", ""))]
    if corners and corners[-1] == "z":
        corners = sorted(corner.lstrip("ML") for corner in corners)
    where = " ".join((*corners, *(given.get(name, "") for name in ("x", "y", "width", "height"))))
    movable = in_legend or element.tag == f"{_SVG}text"
    said = "".join(element.itertext()).strip()
    return _Shown(element.tag, colours, said, "" if movable else where, where if movable else "")


def main() -> int:
    """Draw the diagrams, or check those that are kept."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--only", metavar="NAME", action="append", choices=DIAGRAMS, help="one of the diagrams")
    parser.add_argument("--check", action="store_true", help="compare with those that are kept, and write none")
    options = parser.parse_args()
    status = 0
    for name in options.only or DIAGRAMS:
        path, drawn = PICTURES / f"{name}.svg", DIAGRAMS[name]()
        if not options.check:
            path.write_text(drawn, encoding="utf-8", newline="\n")
            print(path.name, f"{len(drawn) / 1000:.0f} kB")
        elif not path.is_file() or not same(path.read_text(encoding="utf-8"), drawn):
            print(f"{path.name}: it is not what is drawn today", file=sys.stderr)
            status = 1
    return status


if __name__ == "__main__":
    sys.exit(main())
