"""Say an answer once for every medium: as tables, and as sections of sentences, lists, tables and charts.

Terminal, page, PDF and workbook print them, and none of these knows what they are about. Values are in the units of
atleak's records; language and units follow from the table's `Wording`. Headings stand in the texts as ``columns.KEY``,
what a column means, where that needs saying, as ``column_help.KEY``.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from typing import TYPE_CHECKING, Any, NamedTuple

from atleak.common.style import look_of
from atleak.common.verdicts import Band, Verdict
from atleak.common.wording import Wording
from atleak.report.charts.chart import Chart

if TYPE_CHECKING:
    import pandas as pd

VERDICT = "verdict"
VerdictOrBand = Verdict | Band


class Judged(NamedTuple):
    """A cell's value, and the verdict in whose colour it stands."""

    value: Any  # of the cell
    level: VerdictOrBand | None = None  # verdict; None where nothing was judged


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Parameters
    ----------
    key
        name of the column in the texts
    kind
        kind of quantity, which gives the unit in the heading's brackets; ``"verdict"`` for a verdict or a band; None
        for words, and for numbers without a unit
    digits
        decimal places that the value takes in the unit of atleak's records; None for the usual ones of its kind, and
        for what is no number
    width
        least width on the page [px]; None to let the table choose. On paper words share what width is left likewise
    words
        the heading, where it is no text of its own, such as a verdict's word
    words_of
        kind of quantity that its cells hold as words, such as a range; the heading names the unit
    of
        its value in the unit of atleak's records, or its words, of an item of the table's rows: a function, or the name
        that the item has for it, unless that is ``key``; None where there is none
    times
        by what the item's value is multiplied to be in the unit of atleak's records
    whole
        whether its words are never cut or broken: a user must be able to copy a whole id
    note
        what the column means, where no text of the page says it
    parts
        columns that it becomes where every number has a cell of its own, such as in a workbook: of a rate how many, of
        how many, and the ends of its interval
    """

    key: str
    kind: str | None = None
    digits: int | None = None
    width: int | None = None
    words: str | None = None
    words_of: str | None = None
    of: str | Callable[[Any], Any] = ""
    times: float | None = None
    whole: bool = False
    note: str = ""
    parts: tuple[Column, ...] = ()

    @property
    def is_number(self) -> bool:
        """Tell whether its cells are numbers, to be sorted and set as such."""
        return self.kind != VERDICT and (self.kind is not None or self.digits is not None)

    @property
    def dtype(self) -> str:
        """Return the type of its cells as pandas names it."""
        return "float" if self.is_number else "object"

    def title(self, say: Wording) -> str:
        """Return the words of its heading without a unit; paper breaks their lines where they do."""
        return self.words or say(f"columns.{self.key}")

    def unit(self, say: Wording) -> str:
        """Return the unit of its cells; an empty text where they have none."""
        kind = self.kind if self.is_number else self.words_of
        return "" if kind is None else say.unit(kind)

    def heading(self, say: Wording) -> str:
        """Return the words of its heading, with the unit of its cells: ``Clearance [µm]``."""
        title, unit = self.title(say).replace("\n", " "), self.unit(say)
        return f"{title} [{unit}]" if unit else title

    def help(self, say: Wording) -> str | None:
        """Return what the column means; None where its heading says enough."""
        return self.note or say.table("column_help").get(self.key)

    def places(self, say: Wording) -> int:
        """Return how many decimal places its numbers take in the reader's unit."""
        return self.digits or 0 if self.kind is None else say.digits(self.kind, self.digits)

    def judged(self, item: Any) -> Judged:
        """Return what stands in an item's cell, with the verdict in whose colour; a verdict stands in its own."""
        if callable(self.of):
            found = self.of(item)
        else:
            name = self.of or self.key
            found = item.get(name) if isinstance(item, Mapping) else getattr(item, name)
        value, level = found if isinstance(found, Judged) else (found, None)
        if value is not None and self.times is not None:
            value *= self.times
        return Judged(value, value if isinstance(value, Verdict | Band) else level)

    def cell(self, item: Any, say: Wording, *, rounded: bool = False) -> Any:
        """Return the value of an item's cell in the reader's unit; ``rounded`` as exact as it is shown."""
        return self._shown(self.judged(item).value, say, rounded=rounded)

    def _shown(self, value: Any, say: Wording, *, rounded: bool) -> Any:
        if isinstance(value, bool):
            return say(f"answers.{'yes' if value else 'no'}")
        if value is None or not self.is_number or isinstance(value, str):
            return value
        shown = float(value if self.kind is None else say.convert(value, self.kind))
        return round(shown, self.places(say)) if rounded else shown

    def written(self, shown: float | None, say: Wording) -> str:
        """Return the text of a number in the reader's unit."""
        return say.number(shown, self.places(say))

    def text(self, item: Any, say: Wording) -> str:
        """Return an item's cell as words: numbers as the reader writes them, verdicts signed, a dash for nothing."""
        return self.said(self.judged(item).value, say)

    def said(self, judged: Any, say: Wording) -> str:
        """Return the value of a cell, in the unit of atleak's records, as words."""
        value = self._shown(judged, say, rounded=True)
        if value is None:
            return "–"
        if isinstance(value, Verdict | Band):
            return say.signed(value)
        return self.written(value, say) if isinstance(value, float) and self.is_number else say.sentence(value)


@dataclass(frozen=True)
class Table:
    """Items as rows, in one reader's words and units.

    Parameters
    ----------
    name
        by which a page, a script or a sheet finds it, the same in every language
    title
        what stands over it, in the reader's words; empty where that says the name
    remark
        what is said of an item below its row; an empty text says nothing
    group
        the heading of the group in which an item stands, where items of one group follow one another
    """

    name: str
    columns: tuple[Column, ...]  # from left to right
    rows: Sequence[Any]  # one item each
    say: Wording  # the reader's words and units
    title: str = ""
    remark: Callable[[Any], str] | None = None
    group: Callable[[Any], str] | None = None

    @property
    def headings(self) -> tuple[str, ...]:
        """Return the heading of every column with its unit."""
        return tuple(column.heading(self.say) for column in self.columns)

    @property
    def filled(self) -> Table:
        """Return it without the columns in which no row has anything; one without rows keeps them all."""
        if not self.rows:
            return self
        has = [any(column.judged(item).value not in (None, "") for item in self.rows) for column in self.columns]
        return replace(self, columns=tuple(itertools.compress(self.columns, has)))

    @property
    def parted(self) -> Table:
        """Return it with every column in its parts."""
        return replace(self, columns=tuple(_parted(self.columns)))

    def only(self, *keys: str) -> Table:
        """Return it with these columns alone, or parts of them, in this order; a key that none has is passed over."""
        by_key = {each.key: each for column in self.columns for each in (column, *column.parts)}
        return replace(self, columns=tuple(by_key[key] for key in keys if key in by_key))

    def first(self, count: int) -> Table:
        """Return it with so many rows at most."""
        return replace(self, rows=self.rows[:count])

    def without(self, *keys: str) -> Table:
        """Return it without these columns."""
        return replace(self, columns=tuple(column for column in self.columns if column.key not in keys))

    def texts(self, item: Any) -> tuple[str, ...]:
        """Return the cells of an item as words."""
        return tuple(column.text(item, self.say) for column in self.columns)

    def records(self) -> list[dict[str, Any]]:
        """Return its rows with each value under its column's key, in the units of atleak's records."""
        return [{column.key: column.judged(item).value for column in self.columns} for item in self.rows]

    def frame(self, *, rounded: bool = False) -> pd.DataFrame:
        """Return it as a DataFrame: numbers in the reader's unit, which the names of the columns say."""
        import pandas as pd

        made = {}
        for heading, column in zip(self.headings, self.columns, strict=True):
            cells = [column.cell(item, self.say, rounded=rounded) for item in self.rows]
            words = any(isinstance(cell, str) for cell in cells)  # such as that there is no number
            made[heading] = pd.Series(cells, dtype="object" if words else column.dtype)
        return pd.DataFrame(made)

    def html(self, opens: Callable[[Any], str | None] | None = None, kind: str = "") -> str:
        """Return it as HTML, every text escaped; ``opens`` names what a press on an item's second cell opens."""
        heads = "".join(f"<th>{escape(heading)}</th>" for heading in self.headings)
        rows = []
        for item in self.rows:
            cells, opened = [], opens(item) if opens else None
            for number, (heading, column) in enumerate(zip(self.headings, self.columns, strict=True)):
                text = leveled(column.text(item, self.say), column.judged(item).level)
                if opened is not None and number == 1:
                    text = f'<button data-pair="{escape(opened)}">{text}</button>'
                head = ' class="head"' if number < 1 + bool(opens) else ""
                cells.append(f'<td{head} data-label="{escape(heading)}">{text}</td>')
            rows.append(f"<tr>{''.join(cells)}</tr>")
        start = f'<table class="{kind}">' if kind else "<table>"
        return f"{start}<thead><tr>{heads}</tr></thead><tbody>{''.join(rows)}</tbody></table>"

    _repr_html_ = html


def _parted(columns: Iterable[Column]) -> Iterator[Column]:
    for column in columns:
        yield from _parted(column.parts) if column.parts else (column,)


def with_sign(text: str, level: VerdictOrBand | None) -> str:
    """Return a text with the sign of a verdict, which tells it without colour; as it is without a verdict."""
    return text if level is None or look_of(level).sign in text else f"{look_of(level).sign} {text}"


def leveled(text: str, level: VerdictOrBand | None) -> str:
    """Return a text as HTML in the colours of a verdict, with its sign; as it is without one."""
    if level is None:
        return escape(text)
    look = look_of(level)
    style = f' style="background:{look.screen};color:{look.on_screen}"' if look.on_screen else ""
    return f'<span class="level{"" if style else " plain"}"{style}>{escape(with_sign(text, level))}</span>'


def columns(*named: str | Column) -> tuple[Column, ...]:
    """Return columns, of which those of words may be given by their names."""
    return tuple(Column(each) if isinstance(each, str) else each for each in named)


def span(ends: Iterable[float], kind: str, say: Wording, digits: int = 1) -> str:
    """Return a value, or the two ends of a range, in the reader's unit and without it: ``10.0–18.0``."""
    return "–".join(say.value(end, kind, digits) for end in ends)


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
