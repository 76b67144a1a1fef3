"""Charts, said once as data: what is drawn of them on the screen and on paper is the same.

Numbers are in the reader's units, but for those of spreads, which their kind of quantity converts.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from atleak.analysis.rates import Spread
from atleak.common.style import Look

Span = tuple[float, float]


@dataclass(frozen=True)
class Layer:
    """What a chart shows of each of its rows in one look: a bar, or a mark."""

    name: str  # in the legend
    look: Look
    values: Sequence[float | None]  # None: nothing is drawn in this row
    spans: Sequence[Span | None] = ()  # the interval of each
    hover: Sequence[str] = ()  # words of each where somebody points at it
    inside: Sequence[str] = ()  # words in each bar, where they find room
    thick: float = 0.0  # of a bar, part of its row's height; 0: a mark
    lift: float = 0.0  # above its row's middle, part of the row's height
    open: Sequence[bool] = ()  # whether each mark is an outline alone

    def span(self, row: int) -> Span | None:
        """Return the interval in a row; None without one."""
        return self.spans[row] if self.spans else None

    def ends(self, row: int) -> tuple[float, ...]:
        """Return the value of a row and the ends of its interval; none where nothing is drawn."""
        value = self.values[row]
        return () if value is None else (value, *(self.span(row) or ()))

    def reach(self, row: int) -> float:
        """Return where it ends in a row: its value, or the end of its interval; 0 where nothing is drawn."""
        return (0.0, *self.ends(row))[-1]


@dataclass(frozen=True)
class RowChart:
    """Rows below one another, the first on top, over one axis."""

    names: Sequence[str]
    layers: Sequence[Layer]  # the later ones over the earlier ones
    axis: str  # what it shows, with its unit
    beside: Sequence[str] = ()  # words at the end of each row
    stacked: bool = False  # each bar begins where the one before it ends, up to 100
    zero: bool = False  # values are differences: a line marks where there is none

    @property
    def ends(self) -> list[float]:
        """Return all values and ends of intervals."""
        return [end for layer in self.layers for row in range(len(self.names)) for end in layer.ends(row)]


@dataclass(frozen=True)
class Field:
    """One of the plots over the same classes: spreads with marks, parts of a whole, or numbers of units."""

    title: str
    height: float  # its part of the whole
    kind: str = "number"  # of quantity of its spreads and marks
    spreads: Sequence[Spread | None] = ()
    means: Sequence[float | None] = ()
    extremes: Sequence[float | None] = ()  # on the screen, where one can zoom
    extreme: Literal["largest", "lowest"] = "largest"
    stack: Sequence[tuple[str, Look, Sequence[float]]] = ()  # name, look and parts [%] of each layer, from below
    hover: Sequence[str] = ()  # of each class in the stack
    units: Sequence[int] = ()
    from_zero: bool = True


@dataclass(frozen=True)
class ClassChart:
    """Plots above one another over classes of a quantity."""

    edges: Sequence[Span]
    classes: Sequence[str]  # their names
    axis: str
    fields: Sequence[Field]
    name: str = ""  # of what it is, where several stand beside one another
    thousands: str = ""  # what the axis shows where its numbers are thousands, as they are then

    def known(self, field: Field) -> list[tuple[Span, Spread, str]]:
        """Return each class with its ends, its spread and its name, where there is a spread."""
        classes = zip(self.edges, field.spreads, self.classes, strict=True)
        return [(edge, spread, name) for edge, spread, name in classes if spread is not None]


Chart = RowChart | ClassChart | Sequence[ClassChart]
LayerOf = tuple[str, Look, Sequence[float | None], dict[str, Any]]


def layers_of(named: Iterable[LayerOf]) -> list[Layer]:
    """Return layers by their names, looks, values and what else is to be said of them; one without a value is none."""
    return [
        Layer(name, look, values, **more)
        for name, look, values, more in named
        if any(value is not None for value in values)
    ]
