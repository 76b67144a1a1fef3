"""A table of the catalogue as a page shows it: its heading, its columns and its rows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from atleak.views.table import Column
from atleak.wording import Wording

Rows = list[dict[str, Any]]


@dataclass(frozen=True)
class CatalogueTable:
    """Rows of plain values in the units of atleak's records; ``name`` is that of the heading among the texts."""

    name: str
    columns: tuple[Column, ...]
    rows: Rows


def columns(*named: str | Column) -> tuple[Column, ...]:
    """Return columns, of which those of words may be given by their names."""
    return tuple(Column(each) if isinstance(each, str) else each for each in named)


def span(ends: Iterable[float], kind: str, say: Wording, digits: int = 1) -> str:
    """Return a value, or the two ends of a range, in the reader's unit and without it: ``10.0–18.0``."""
    return "–".join(say.value(end, kind, digits) for end in ends)
