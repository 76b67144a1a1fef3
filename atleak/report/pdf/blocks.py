"""Make the few kinds of block that a report consists of, as plain dictionaries for the template."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from atleak.common.verdicts import Band, Verdict
from atleak.common.wording import Wording, begun
from atleak.report.tables.table import VERDICT, Column, Facts, Picture, Points, Section, SectionPart, Table, Text

Block = dict[str, Any]

_PLAIN = re.compile(r"[−\d\s]+([.,]\d+)?(?:–[−\d\s]+[.,]?\d*)?(?:\n.*)?$")  # a number or two, an interval below
FEW = 12  # items of a table, each with all that is said of it; more stand in short
_NOTE = 1500  # letters of a note that a page can hold together with the last rows of its table


def text(content: str, *, small: bool = False, leads: bool = False) -> Block:
    """Return a paragraph, an empty block without words; one that ``leads`` stays on the page of what follows it."""
    return {"kind": "text", "text": content, "small": small, "leads": leads} if content else {}


def passage(content: str, language: str, say: Wording) -> str | dict[str, str]:
    """Return a text in its own language for a cell or a list, marked so where the report has another."""
    return content if language == say.language else {"text": content, "lang": language}


def facts(rows: Sequence[Sequence[str]]) -> Block:
    """Return names and values side by side; an empty block where there are no rows."""
    return {"kind": "facts", "rows": [list(row) for row in rows]} if rows else {}


def named_facts(table: str, say: Wording, **values: str | None) -> Block:
    """Return facts by the keys of their names in a table of the texts; one without a value is left out."""
    return facts([[say(f"{table}.{key}"), value] for key, value in values.items() if value])


def bullets(items: Iterable[str | dict[str, str]]) -> Block:
    """Return a list of sentences; an empty block without any."""
    listed = list(items)
    return {"kind": "list", "items": listed} if listed else {}


def picture(svg: str, alt: str, caption: str) -> Block:
    """Return a drawing with what a screen reader says of it, and its caption."""
    return {"kind": "image", "svg": svg, "alt": alt, "caption": caption}


def signatures(people: Iterable[tuple[str, str]], say: Wording) -> Block:
    """Return a line to sign on for everybody who signs, by role and name."""
    named = [[say(f"texts.sign_{role}"), name] for role, name in people]
    return {"kind": "signatures", "line": say("texts.sign_place"), "room": 9, "people": named}  # room in mm


def listed(
    say: Wording,
    items: Iterable[Any],
    *columns: Column,
    remark: Callable[[Any], str] | None = None,
    group: Callable[[Any], str] | None = None,
    whole: bool = False,
) -> Block:
    """Return a table with a row for every item; see `printed`."""
    return printed(Table("", columns, list(items), say, remark=remark, group=group), whole=whole)


def ends(of: Callable[[Any], tuple[float, float] | None], column: Column) -> tuple[Column, Column]:
    """Return the columns that put an interval below the values of another column."""

    def end(which: int, item: Any) -> float | None:
        interval = of(item)
        return None if interval is None else interval[which]

    low, high = (
        replace(column, key=f"{column.key}_{name}", words="", of=partial(end, which))
        for which, name in enumerate(("low", "high"))
    )
    return low, high


def printed(content: Table, *, whole: bool = False) -> Block:
    """Return a table as a block; of verdicts sign and word, of a value the sign of its own verdict.

    Where there are columns ``X_low`` and ``X_high``, their values stand in brackets below those of ``X``. A table that
    is ``whole`` stands on one page, and is to be short.
    """
    if not content.rows:
        return {}
    say, intervals = content.say, _intervals(content.columns)
    below = [column for both in intervals.values() for column in both]
    shown = [column for column in content.columns if column not in below]

    def held(item: Any) -> list[list[Any]]:
        """Return the rows of an item, which hold together."""
        said = content.remark and content.remark(item)
        row = [_cell(column, intervals.get(column.key), item, say) for column in shown]
        return [row, [{"remark": said}]] if said else [row]

    groups = [  # each of the rows of its items, below its heading
        [*([[[title]]] if title else []), *map(held, items)]
        for title, items in itertools.groupby(content.rows, content.group or (lambda _: ""))
    ]
    rows = [*itertools.chain(*itertools.chain(*groups))]
    full = (row for row in rows if len(row) == len(shown))
    block: Block = {
        "kind": "table",
        "names": [_name(column, say) for column in shown],
        "rows": rows,
        # what is left of the page is shared, in parts of 50 pixels of the screen
        "widths": [0 if column.kind == VERDICT else (column.width or 0) // 50 for column in shown],
        "aligned": "".join(map(_side, shown, zip(*full, strict=True))),
        "whole": whole,
    }
    if content.group is not None or content.remark is not None:
        block["groups"] = [size for group in groups for size in _held([*map(len, group)])]
    return block


def abreast(content: Table, count: int = 2) -> Block:
    """Return a table of many rows of few columns as several beside one another; an empty block without rows."""
    rows = -(-len(content.rows) // count)
    parts = (printed(replace(content, rows=content.rows[rows * part : rows * (part + 1)])) for part in range(count))
    tables = [each for each in parts if each]
    return {"kind": "abreast", "tables": tables} if tables else {}


def _intervals(columns: Sequence[Column]) -> dict[str, tuple[Column, Column]]:
    """Return the columns that stand below another one, by its key."""
    by_key = {column.key: column for column in columns}
    return {key: (by_key[f"{key}_low"], by_key[f"{key}_high"]) for key in by_key if f"{key}_low" in by_key}


def _name(column: Column, say: Wording) -> str:
    """Return a heading with the unit below it; words begin with a capital letter, a symbol stays as it is."""
    title = column.words if column.words is not None else say.table("printed").get(column.key)
    if title is None:
        title = say(column.key) if "." in column.key else column.title(say)
    unit = column.unit(say)
    title = begun(title) if len(title) > 1 and title[:2].isalpha() else title
    return f"{title}\n{unit}" if unit else title


def _side(column: Column, cells: Iterable[Any]) -> str:
    """Return how a column is set: words to the left, plain numbers to the right, others by their decimal signs."""
    if not (column.is_number or column.words_of):
        return "l"
    texts = [cell.get("text", "") if isinstance(cell, dict) else cell for cell in cells]
    decimals = {len(found[1] or "") if (found := _PLAIN.match(text)) else -1 for text in texts if text != "–"}
    return "d" if len(decimals) > 1 or -1 in decimals else "r"


def _cell(column: Column, interval: tuple[Column, Column] | None, item: Any, say: Wording) -> Any:
    value, level = column.judged(item)
    if isinstance(value, dict):  # boxes to tick, or words in a language of their own
        return value
    if type(value) is not str:  # nor one of the program's sentences, which are words of some language
        value = say.level(value) if isinstance(value, Verdict | Band) else column.said(value, say)
    low, high = (each.text(item, say) for each in interval) if interval else ("–", "–")
    text = value if low == "–" or low == high == value else f"{value}\n({low}–{high})"
    return text if level is None else {"sign": level.verdict if isinstance(level, Band) else level, "text": text}


def _held(sizes: list[int]) -> list[int]:
    """Return how many rows hold together, so that no page begins or ends with a single item of so many rows each."""
    return [sum(sizes)] if len(sizes) < 4 else [sum(sizes[:2]), *sizes[2:-2], sum(sizes[-2:])]


def section_blocks(section: Section, draw: Callable[[Picture], str], say: Wording) -> dict[str, Any]:
    """Return a section as the template places it; ``draw`` draws a chart as SVG."""
    made = (_block(part, draw, say) for part in section.parts)
    return {"title": section.title, "level": section.level, "blocks": [*with_notes(made)]}


def _block(part: SectionPart, draw: Callable[[Picture], str], say: Wording) -> Block:
    if isinstance(part, Table):
        return printed(part)
    if isinstance(part, Text):
        return text(part.words, small=part.small, leads=part.leads)
    if isinstance(part, Points):
        return bullets(part.items)
    if isinstance(part, Facts):
        return facts(part.rows)
    image = picture(draw(part), part.alt, part.caption)
    levels = [[level.verdict if isinstance(level, Band) else level, say.level(level)] for level in part.legend]
    return {**image, "legend": levels} if levels else image


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
        if block["kind"] == "table" and not block.get("note"):
            table = block
        elif not notes:
            yield block
    if table:
        yield table
