"""The few kinds of block a report is built of, as plain dictionaries for the template."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from atleak.wording import isolated

Block = dict[str, Any]


def text(content: str, *, small: bool = False) -> Block:
    """A paragraph."""
    return {"kind": "text", "text": content, "small": small}


def facts(rows: Sequence[Sequence[str]]) -> Block:
    """Names and values side by side; nothing where there are none."""
    return {"kind": "facts", "rows": [list(row) for row in rows]} if rows else {}


@dataclass(frozen=True)
class Column:
    """One column of a table: its title, what stands in it and how it is set.

    ``cell`` makes of a row's item what stands in the cell: a text, or a dictionary with ``sign`` and ``text`` for a
    verdict. ``width`` is the column's share of the room that is left (0: as narrow as its content).
    """

    title: str
    cell: Callable[[Any], Any]
    unit: str = ""
    width: int = 0
    side: Literal["l", "c", "r"] = "l"

    @property
    def name(self) -> str:
        """The title with the unit below it."""
        return f"{self.title}\n{self.unit}" if self.unit else self.title


def table(columns: Sequence[Column], items: Iterable[Any], *, empty: bool = True) -> Block:
    """A table with one row an item; with ``empty`` False, columns in which nothing stands are left out."""
    rows = [[column.cell(item) for column in columns] for item in items]
    kept = [
        index for index in range(len(columns)) if rows and (empty or any(row[index] not in ("", "–") for row in rows))
    ]
    if not kept:
        return {}
    return {
        "kind": "table",
        "names": [columns[index].name for index in kept],
        "rows": [[row[index] for index in kept] for row in rows],
        "widths": [columns[index].width for index in kept],
        "aligned": "".join(columns[index].side for index in kept),
    }


def joined(parts: Iterable[str], between: str = ", ") -> str:
    """Those that are not empty, one after another, each in its own direction."""
    return between.join(isolated(part) for part in parts if part)
