"""Set up matplotlib for paper: figures whose fields have fixed places in points, in the report's fonts, as SVG.

No layout is solved for: what stands beside a field is measured beforehand, which takes half the time.
"""

from __future__ import annotations

import io
import math
import threading
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from matplotlib import font_manager
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.path import Path as Outline
from matplotlib.ticker import FuncFormatter, MaxNLocator

from atleak.common.style import PAPER_INKS, Look
from atleak.common.wording import Wording
from atleak.report.printed_fonts import FONTS, fitting, width_of

if TYPE_CHECKING:
    from matplotlib.typing import RcKeyType

WIDTH = 504.0  # [pt] of every chart
SIZE = 9.0  # [pt] of words
BELOW = 34.0  # [pt] of a field, for the axis and its title
_TOP = 4.0  # [pt] over a field of rows
_NAMES = 220.0  # [pt] most that the names of rows take
_LOCK = threading.Lock()  # matplotlib's settings belong to the whole process
_SETTINGS: dict[RcKeyType, Any] = {
    "svg.hashsalt": "atleak",
    "svg.fonttype": "none",
    "font.family": ["Noto Sans", "DejaVu Sans"],
    "font.size": SIZE,
    "axes.edgecolor": PAPER_INKS.ink,
    "axes.labelcolor": PAPER_INKS.ink,
    "axes.linewidth": 0.6,
    "xtick.color": PAPER_INKS.ink,
    "ytick.color": PAPER_INKS.ink,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "hatch.linewidth": 0.5,
    "path.simplify_threshold": 0.2,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.labelpad": 2.0,
    "grid.color": PAPER_INKS.rule,
    "grid.linewidth": 0.5,
    "text.parse_math": False,  # names are the user's
}


@contextmanager
def drawing() -> Iterator[None]:
    """Draw with the report's settings of matplotlib, one thread at a time."""
    with _LOCK, mpl.rc_context(_SETTINGS):
        _add_fonts()
        yield


@cache
def _add_fonts() -> None:
    for path in sorted(FONTS.glob("*.ttf")):
        font_manager.fontManager.addfont(path)


def figure_of(height: float) -> Figure:
    """Return an empty figure of the report's width and a height [pt]."""
    return Figure(figsize=(WIDTH / 72.0, height / 72.0))


def field(figure: Figure, left: float, right: float, top: float, height: float) -> Axes:
    """Return a field between two distances from the left edge, so far below the top edge and so high [pt]."""
    whole = figure.get_figheight() * 72.0
    bottom = whole - top - height
    return figure.add_axes((left / WIDTH, bottom / whole, (right - left) / WIDTH, height / whole))


def number_axes(axes: Axes, say: Wording, *names: str, most: int = 6) -> None:
    """Give some of ``"x"`` and ``"y"`` round values in the reader's way of writing numbers, and a grid."""
    for name in names:
        axis = axes.xaxis if name == "x" else axes.yaxis
        axis.set_major_locator(MaxNLocator(most))
        axis.set_major_formatter(FuncFormatter(lambda value, _: say.plain(value, 5)))
        axis.grid(True)


def widest(names: Iterable[str], size: float = SIZE) -> float:
    """Return the width of the widest of several words [pt]."""
    return max((width_of(name, size) for name in names), default=0.0)


def axis_words(
    axes: Axes, at: tuple[float, float], text: str, off: tuple[float, float] = (0.0, 0.0), **look: Any
) -> None:
    """Write words at a place of the data, shifted by so many points."""
    look = {"va": "center", "fontsize": SIZE, **look}
    axes.annotate(text, at, xytext=off, textcoords="offset points", annotation_clip=False, **look)


def upright_title(axes: Axes, title: str, left: float) -> None:
    """Write what an upright axis shows along it, at the edge of the paper, so far left of the field [pt]."""
    axes.annotate(
        title, (0.0, 0.5), xycoords="axes fraction", xytext=(8.0 - left, 0.0), textcoords="offset points",
        rotation=90, ha="center", va="center", fontsize=SIZE,
    )  # fmt: skip


def name_row(axes: Axes, name: str, place: float, width: float) -> None:
    """Write the name of a row to the left of the axis, no wider than so many points."""
    axis_words(axes, (0.0, place), fitting(name, SIZE, width), (-5.0, 0.0), ha="right")


def interval(axes: Axes, low: float, high: float, place: float) -> None:
    """Draw an interval as a line with a stroke at each end."""
    axes.plot([low, high], [place, place], color=PAPER_INKS.ink, lw=1.1, marker="|", ms=5, zorder=4)


def sign(axes: Axes, look: Look, x: float, y: float) -> None:
    """Draw the sign of a level in its shade."""
    outline = Outline([(x, -y) for x, y in (*look.shape.points, look.shape.points[0])], closed=True)
    axes.plot([x], [y], marker=outline, ms=7, mfc=look.fill, mec=look.line, zorder=5, clip_on=False)


@contextmanager
def rows_of_labels(
    names: Sequence[str], row: float, right: float, room: float, title: str, say: Wording
) -> Iterator[tuple[Figure, Axes]]:
    """Set up a field of rows, the last at 0, each with its name, over an axis that ends at ``right``.

    A row is so many points high; so many points of ``room`` are kept for words right of the axis.
    """
    height = row * max(len(names), 1)
    with drawing():
        figure = figure_of(_TOP + height + BELOW)
        axes = field(figure, min(widest(names), _NAMES) + 7.0, WIDTH - room, _TOP, height)
        axes.set_xlim(0.0, right if math.isfinite(right) and right > 0.0 else 1.0)
        axes.set_ylim(-0.5, max(len(names), 1) - 0.5)
        axes.set_yticks([])
        axes.set_xlabel(title)
        number_axes(axes, say, "x")
        for place, name in zip(places(names), names, strict=True):
            name_row(axes, name, place, _NAMES)
        yield figure, axes


def places(rows: Sequence[Any]) -> range:
    """Return where rows stand, the first on top."""
    return range(len(rows))[::-1]


def bar_of(axes: Axes, end: float, place: float, thick: float, look: Look, begin: float = 0.0) -> None:
    """Draw a bar in the shade of a verdict."""
    axes.barh(
        place, end - begin, left=begin, height=thick, color=look.fill, edgecolor=look.line, lw=0.8, hatch=look.hatch
    )


def svg(figure: Figure) -> str:
    """Return the drawing; the same figure gives the same text.

    Its words stay words: a character that the report's fonts lack is set in another one with the rest of the page.
    """
    target = io.StringIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        figure.savefig(target, format="svg", metadata={"Date": None, "Creator": None}, transparent=True)
    return target.getvalue()
