"""The few kinds of block a report is built of, as plain dictionaries for the template."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from atleak.wording import isolated

Block = dict[str, Any]


def text(content: str, *, small: bool = False) -> Block:
    """A paragraph."""
    return {"kind": "text", "text": content, "small": small}


def facts(rows: Sequence[Sequence[str]]) -> Block:
    """Names and values side by side; nothing where there are none."""
    return {"kind": "facts", "rows": [list(row) for row in rows]} if rows else {}


def table(
    names: Sequence[str], rows: Sequence[Sequence[Any]], widths: str, aligned: str, *, empty: bool = True
) -> Block:
    """A table; ``widths`` are shares (0: as narrow as its content), ``aligned`` l, c or r, a digit or letter a column.

    With ``empty`` False, columns in which nothing stands are left out.
    """
    columns = list(range(len(names)))
    if not empty:
        columns = [column for column in columns if any(row[column] not in ("", "–") for row in rows)]
    if not rows or not columns:
        return {}
    return {
        "kind": "table",
        "names": [names[column] for column in columns],
        "rows": [[row[column] for column in columns] for row in rows],
        "widths": [int(widths[column]) for column in columns],
        "aligned": "".join(aligned[column] for column in columns),
    }


def joined(parts: Iterable[str], between: str = ", ") -> str:
    """Those that are not empty, one after another, each in its own direction."""
    return between.join(isolated(part) for part in parts if part)
