"""Define how things look on every medium: one row per verdict, the colours of lines and words, the papers of reports.

Verdicts differ in sign, word and shade, and bars on the screen in their pattern too, so that a greyscale print or a
colour-blind reader loses nothing. Their words in each language stand in `atleak/texts`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal

from atleak.common.errors import unknown
from atleak.common.sentences import Sentence
from atleak.common.verdicts import Band, Verdict

_Point = tuple[float, float]


@dataclass(frozen=True)
class SignShape:
    """A sign as a polygon in the square from −1 to 1, y downwards: no font is needed to draw it."""

    points: tuple[_Point, ...]
    filled: bool = True


def _circle(radius: float) -> tuple[_Point, ...]:
    turns = (2.0 * math.pi * corner / 32 for corner in range(32))
    return tuple((round(radius * math.cos(turn), 4), round(radius * math.sin(turn), 4)) for turn in turns)


_DISC = SignShape(_circle(0.8))
_RING = SignShape(_circle(0.75), filled=False)
_TRIANGLE = SignShape(((0.0, -1.0), (1.0, 0.85), (-1.0, 0.85)))
_SQUARE = SignShape(((-0.8, -0.8), (0.8, -0.8), (0.8, 0.8), (-0.8, 0.8)))
_CROSS = SignShape(
    (
        (-1.0, -0.55), (-0.55, -1.0), (0.0, -0.45), (0.55, -1.0), (1.0, -0.55), (0.45, 0.0),
        (1.0, 0.55), (0.55, 1.0), (0.0, 0.45), (-0.55, 1.0), (-1.0, 0.55), (-0.45, 0.0),
    )
)  # fmt: skip


@dataclass(frozen=True)
class Look:
    """The looks of one verdict. Colours are ``#RRGGBB``; every medium takes its shade of the same hue from here."""

    sign: str  # one character, for text
    shape: SignShape  # the same sign, for drawings
    screen: str  # bars, markers and table cells on the screen
    on_screen: str  # words on that colour; "" where a table cell stays plain
    fill: str  # a land in the drawings and bars on paper; each has another grey in a greyscale print
    line: str  # its outline, and the sign beside a word
    on_fill: str  # the sign on the fill
    tint: str  # ground behind words on paper and in the workbook
    on_tint: str  # words on the tint
    width: float  # of the outline in the drawings
    dashes: str  # of the outline in the drawings, as SVG states them
    style: str  # on a terminal, as rich states it
    pattern: str  # over bars on the screen, as plotly states it
    hatch: str  # over bars on paper, as matplotlib states it
    marker: str  # on the screen, as plotly names it
    box: Literal["success", "warning", "error", "info"]  # of the page's first sentence


LOOKS: dict[Verdict, Look] = {
    Verdict.NOT_MEASURED: Look(
        sign="○", shape=_RING,
        screen="#8793a0", on_screen="", fill="#FFFFFF", line="#7A858F", on_fill="#7A858F",
        tint="#EEEEEE", on_tint="#555555", width=1.0, dashes="3 2.5",
        style="", pattern=".", hatch="...", marker="circle-open", box="info",
    ),
    Verdict.OK: Look(
        sign="●", shape=_DISC,
        screen="#2f9e62", on_screen="", fill="#F3F8F3", line="#2E6B3A", on_fill="#2E6B3A",
        tint="#E6F2E6", on_tint="#1E5B2A", width=1.0, dashes="",
        style="", pattern="", hatch="", marker="circle", box="success",
    ),
    Verdict.WATCH: Look(
        sign="▲", shape=_TRIANGLE,
        screen="#e8a317", on_screen="#000000", fill="#F7D774", line="#6B4A00", on_fill="#4A3300",
        tint="#FBEBB8", on_tint="#6B4A00", width=1.4, dashes="",
        style="yellow", pattern="/", hatch="///", marker="triangle-up", box="warning",
    ),
    Verdict.REPLACE: Look(
        sign="■", shape=_SQUARE,
        screen="#d1383d", on_screen="#FFFFFF", fill="#E5736F", line="#7A1216", on_fill="#3D0608",
        tint="#F8D3D0", on_tint="#7A1216", width=1.8, dashes="",
        style="red", pattern="x", hatch="", marker="square", box="error",
    ),
    Verdict.CRITICAL: Look(
        sign="✖", shape=_CROSS,
        screen="#a3278f", on_screen="#FFFFFF", fill="#7A1F6E", line="#4A0B42", on_fill="#FFFFFF",
        tint="#E7C8E2", on_tint="#5E1053", width=2.2, dashes="",
        style="bold magenta", pattern="+", hatch="", marker="x", box="error",
    ),
}  # fmt: skip


_OK, _OPEN = LOOKS[Verdict.OK], LOOKS[Verdict.NOT_MEASURED]
QUIET_ON_DARK = {  # what stands out on white only: lands that are good or not measured, and their outlines
    f'fill="{_OK.fill}"': 'fill="#1D3527"', _OK.line: "#7CC796",
    f'fill="{_OPEN.fill}" stroke="{_OPEN.line}"': 'fill="#1B262E" stroke="#A9B4BD"',
}  # fmt: skip


def look_of(level: Verdict | Band | str) -> Look:
    """Return how a verdict looks; a band looks as the verdict it counts as.

    Raises
    ------
    ValueError
        if the level is neither a verdict nor a band.
    """
    if isinstance(level, Band):
        return LOOKS[level.verdict]
    return LOOKS[Verdict(level)]


@dataclass(frozen=True)
class Inks:
    """The colours of one medium for everything that is no verdict."""

    ink: str  # words, outlines
    soft: str  # words of less weight
    rule: str  # rules and grids
    leakage: str
    pump: str
    share: str
    card: str = "#FFFFFF"  # ground of a drawing's cards
    metal: str = "#D9DEE3"  # spools without a verdict


PAPER_INKS = Inks(ink="#1B2733", soft="#5A6670", rule="#B8C2CB", leakage="#A3211B", pump="#1F4E79", share="#1B2733")
SCREEN = Inks(ink="#16222b", soft="#7b8794", rule="#8793a0", leakage="#2a86d1", pump="#8793a0", share="#e07b00")
DARK = Inks(ink="#E8EEF2", soft="#7b8794", rule="#8793a0", leakage="#2a86d1", pump="#8793a0", share="#e07b00",
            card="#1B262E", metal="#4A5762")  # fmt: skip
SHEET_OF_PAPER = "#FFFFFF"  # what lies under a drawing in black and white
SUSPECT = LOOKS[Verdict.REPLACE].screen  # samples of a log that no result uses
SPREADS = ("#E3EAF1", "#9DB7D5")  # on paper: where nine of ten units are, and where half of them are
SPREADS_ON_SCREEN = ("rgba(42, 134, 209, 0.18)", "rgba(42, 134, 209, 0.38)")  # the same, seen on white and on black
OK_IN_PART = replace(  # units that are ok as far as they were measured, which is not green
    LOOKS[Verdict.OK], screen="#b9c2ca", fill="#E4E8EC", line="#7A858F", on_fill="#4A545E"
)
# what a unit holds or draws when new and once repaired, what nobody judges, and marks of what is stated
AS_NEW = replace(
    LOOKS[Verdict.OK], screen="rgba(128,128,128,0.3)", fill="#FFFFFF", line=PAPER_INKS.ink, pattern="", hatch=""
)
REPAIRED = replace(AS_NEW, screen=SCREEN.leakage, fill=PAPER_INKS.rule, pattern="-")
NOT_JUDGED = replace(AS_NEW, screen=SCREEN.rule, fill=PAPER_INKS.metal)
STATED_INKS = replace(
    AS_NEW, screen=SCREEN.share, fill=PAPER_INKS.ink, marker="line-ns",
    shape=SignShape(((-0.12, -2.6), (0.12, -2.6), (0.12, 2.6), (-0.12, 2.6))),
)  # fmt: skip
LEAST = replace(STATED_INKS, marker="triangle-right", shape=SignShape(((-0.8, -0.9), (0.9, 0.0), (-0.8, 0.9))))
MOST = replace(STATED_INKS, marker="triangle-left", shape=SignShape(((0.8, -0.9), (-0.9, 0.0), (0.8, 0.9))))
EDGE = "#C5CDD5"  # of a drawing's card without a flagged land
CLEAR = "rgba(0,0,0,0)"  # a figure's ground on the screen: the page's own
HATCHING = "rgba(255,255,255,0.7)"  # strokes of a pattern on the screen
FAINT_GRID = "rgba(128,128,128,0.25)"  # seen on white and on black
# maps from little to much; spelled out, since plotly's named scales run the other way in the browser
SCALE_OF_SHARES = [[0.0, "#ffffcc"], [0.5, "#fd8d3c"], [1.0, "#800026"]]
SCALE_OF_TIME = [[0.0, "#deebf7"], [1.0, "#08519c"]]

# How sure a verdict is: colour and marker on the screen. A conditional decision is open.
DECISION_MARKS: dict[str, tuple[str, str]] = {
    "pass": (LOOKS[Verdict.OK].screen, "circle"),
    **dict.fromkeys(("within_range", "conditional_pass"), ("#7aa621", "circle-open")),
    "conditional_fail": ("#e07b00", "square-open"),
    "fail": (LOOKS[Verdict.REPLACE].screen, "square"),
}

# What a cell of a measuring sheet became, by the name of its kind: red, green and blue, told apart by the colour-blind.
CELL_COLOURS: dict[str, tuple[int, int, int]] = {
    "spool": (0, 114, 178), "sleeve": (230, 159, 0), "label": (0, 158, 115), "new": (204, 121, 167),
    "head": (86, 180, 233), "land": (220, 205, 20), "heading": (140, 86, 75), "aside": (128, 128, 128),
    "refused": (213, 60, 0),
}  # fmt: skip
_STRENGTH = 0.35  # of these colours behind words


def cell_colour(kind: str, *, on_screen: bool) -> str:
    """Return the ground of a cell of a kind: on the screen it lets the page's own through, light or dark."""
    colour = CELL_COLOURS[kind]
    if on_screen:
        return f"rgba({', '.join(map(str, colour))}, {_STRENGTH})"
    return "#" + "".join(f"{round(255 - _STRENGTH * (255 - part)):02X}" for part in colour)


# The workbook, besides its verdicts.
INPUT = "#0000C0"  # numbers that may be changed
HEADING = "#E8EDF2"
DATA_BAR = "#9DB7D5"
CHART_GRID = "#DDDDDD"

# The measuring sheet to fill in.
SHEET_COLOURS = {
    "border": "#9AA5B1",
    "given": "#F3F5F7",
    "entry": "#FFF8DC",
    "note": "#5C3D00",
    "heading": "#1F3A5F",
    "on_heading": "#FFFFFF",
    "soft": "#52606D",
    "alarm": "#C62828",
    "bore": "#D5DCE3",  # in the picture of what to measure; no verdict has these two
    "spool": "#F2DFA0",
}

# Curves that differ in colour and dash: the variants of the source study, models of viscosity.
CURVES = {
    "blue": "#2f7ed8",
    "green": "#2e9e6b",
    "ochre": "#b8860b",
    "red": "#d1495b",
    "grey": "#7a7f87",
    "teal": "#1a93a8",
    "violet": "#8e6bbf",
    "rust": "#c7621b",
    "slate": "#5b7fdb",
}


@dataclass(frozen=True)
class Paper:
    """One size of paper."""

    label: str  # for people
    typst: str  # its name in the PDF's template
    excel: int  # its number in a workbook


PAPERS: Mapping[str, Paper] = MappingProxyType(
    {"a4": Paper("A4", "a4", 9), "letter": Paper("Letter", "us-letter", 1)},
)
DEFAULT_PAPER = next(iter(PAPERS))


def find_paper(name: str) -> Paper:
    """Return the paper of that name.

    Raises
    ------
    InputError
        if there is none.
    """
    if name not in PAPERS:
        raise unknown(Sentence("no such paper"), name, PAPERS)
    return PAPERS[name]
