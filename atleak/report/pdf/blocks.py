"""Make the few kinds of block that a report consists of, as plain dictionaries for the template."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

from atleak.views.table import VERDICT, Column, Table
from atleak.wording import Wording, begun, isolated

Block = dict[str, Any]

_NOTE = 1500  # letters of a note that a page can hold together with the last rows of its table


def text(content: str, *, small: bool = False, leads: bool = False) -> Block:
    """Return a paragraph; one that ``leads`` stays on the page of what follows it."""
    return {"kind": "text", "text": content, "small": small, "leads": leads}


def passage(content: str, language: str, say: Wording) -> str | dict[str, str]:
    """Return a text in its own language for a cell or a list, marked so where the report has another."""
    return content if language == say.language else {"text": content, "lang": language}


def facts(rows: Sequence[Sequence[str]]) -> Block:
    """Return names and values side by side; an empty block where there are no rows."""
    return {"kind": "facts", "rows": [list(row) for row in rows]} if rows else {}


@dataclass(frozen=True)
class PrintedColumn:
    """One column of a table: its title, the content of its cells and how it is set.

    ``cell`` turns the item of a row into the content of the cell: a text, or a dictionary with ``sign`` and ``text``
    for a verdict. ``width`` is the column's share of the remaining width (0: as narrow as its content). ``side`` is
    left, centred or right, or the decimal signs below one another.
    """

    title: str
    cell: Callable[[Any], Any]
    unit: str = ""
    width: int = 0
    side: Literal["l", "c", "r", "d"] = "l"

    @property
    def name(self) -> str:
        """Return the title with the unit below it; words begin with a capital letter, a symbol stays as it is."""
        title = begun(self.title) if self.title[:2].isalpha() else self.title
        return f"{title}\n{self.unit}" if self.unit else title


def table(
    columns: Sequence[PrintedColumn],
    items: Iterable[Any],
    *,
    empty: bool = True,
    whole: bool = False,
    told: Callable[[Any], str] | None = None,
) -> Block:
    """Return a table with one row per item; with ``empty`` False, empty columns are left out.

    One that is ``whole`` stands on one page, and is to be short. What is ``told`` of an item stands below its row,
    across all columns.
    """
    items = list(items)
    rows = [[column.cell(item) for column in columns] for item in items]
    kept = [
        index for index in range(len(columns)) if rows and (empty or any(row[index] not in ("", "–") for row in rows))
    ]
    if not kept:
        return {}
    made: Block = {
        "kind": "table",
        "names": [columns[index].name for index in kept],
        "rows": [[row[index] for index in kept] for row in rows],
        "widths": [columns[index].width for index in kept],
        "aligned": "".join(columns[index].side for index in kept),
        "whole": whole,
    }
    if told is not None:
        groups: list[list[list[Any]]] = [
            [row, [{"told": said}]] if said else [row] for row, said in zip(made["rows"], map(told, items), strict=True)
        ]
        made |= {"rows": [row for group in groups for row in group], "groups": _held([*map(len, groups)])}
    return made


def _held(sizes: list[int]) -> list[int]:
    """Return how many rows hold together, so that no page begins or ends with a single item of so many rows each."""
    return [sum(sizes)] if len(sizes) < 4 else [sum(sizes[:2]), *sizes[2:-2], sum(sizes[-2:])]


def grouped_table(
    columns: Sequence[PrintedColumn],
    groups: Iterable[tuple[str, Sequence[Any]]],
    *,
    told: Callable[[Any], str] | None = None,
) -> Block:
    """Return a table in which every group of rows has a heading of its own across all columns and stays on one page."""
    titled = [(title, list(items)) for title, items in groups]
    if not titled:
        return {}
    made = table(columns, [item for _, items in titled for item in items], told=told)
    rows = iter(made["rows"])
    held = []
    for title, items in titled:
        count = sum(2 if told is not None and told(item) else 1 for item in items)
        held.append([[title], *itertools.islice(rows, count)])
    made |= {"rows": [row for group in held for row in group], "groups": [*map(len, held)]}
    return made


def printed(content: Table, *, whole: bool = False) -> Block:
    """Return a table as a block; of verdicts sign and word, of a value the sign of its own verdict."""
    say, made = content.say, []
    for column in content.columns:
        side: Literal["l", "r"] = "r" if column.is_number or column.words_of else "l"
        share = 0 if column.is_number or column.kind == VERDICT else (column.width or 0) // 50
        made.append(PrintedColumn(column.title(say), partial(_printed, column, say), column.unit(say), share, side))
    if content.group is None:
        return table(made, content.rows, whole=whole, told=content.told)
    groups = itertools.groupby(content.rows, content.group)
    return grouped_table(made, ((title, list(items)) for title, items in groups), told=content.told)


def _printed(column: Column, say: Wording, item: Any) -> str | dict[str, str]:
    level = column.judged(item).level
    if level is None:
        return column.text(item, say)
    return {"sign": level, "text": say.level(level) if column.kind == VERDICT else column.text(item, say)}


def with_notes(blocks: Iterable[Block]) -> Iterator[Block]:
    """Give small text that follows a table to the table as its note, so that no page parts them; leave out nothing."""
    table: Block = {}  # that still waits for a note
    for block in blocks:
        if not block:
            continue
        notes = table and block["kind"] == "text" and block["small"] and len(block["text"]) <= _NOTE
        if table:
            yield {**table, "note": block["text"]} if notes else table
            table = {}
        if block["kind"] == "table":
            table = block
        elif not notes:
            yield block
    if table:
        yield table


def joined(parts: Iterable[str], between: str = ", ") -> str:
    """Join the parts that are not empty; each keeps its own direction of writing."""
    return between.join(isolated(part) for part in parts if part)
