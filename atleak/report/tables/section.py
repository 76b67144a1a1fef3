"""A section of an answer, said once for every medium: a title, and below it sentences, lists, tables and charts.

Terminal, page, PDF and workbook print sections, and none of them knows what they are about.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from atleak.report.charts.chart import Chart
from atleak.report.tables.table import Table, VerdictOrBand


@dataclass(frozen=True)
class Text:
    """A paragraph."""

    words: str
    small: bool = False  # a note on what stands before it
    leads: bool = False  # it stays with what follows it
    level: VerdictOrBand | None = None  # in whose colour it stands


@dataclass(frozen=True)
class Points:
    """A list, a paragraph each."""

    items: Sequence[str]


@dataclass(frozen=True)
class Picture:
    """A chart with what is said of it."""

    name: str  # by which a page or a file finds it, the same in every language
    chart: Chart
    alt: str  # what it shows, for those who do not see it
    caption: str = ""
    legend: Sequence[VerdictOrBand] = ()  # on paper: levels whose shades it has
    numbers: Table | None = None  # those that it shows, where nothing can be drawn


@dataclass(frozen=True)
class Facts:
    """Names and values side by side."""

    rows: Sequence[tuple[str, str]]


SectionPart = Text | Points | Facts | Table | Picture


@dataclass(frozen=True)
class Section:
    """A title and what stands below it, in a reader's words; of level 1 it begins a new subject."""

    name: str  # the same in every language
    title: str
    parts: Sequence[SectionPart] = ()
    level: int = 2
