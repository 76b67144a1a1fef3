"""What the author of a sheet marked its readings with: comments, colours, stars. Only people can say what they mean.

A reading that is marked counts all the same; what is crossed out does not.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterator, Sequence

from atleak.errors import Message
from atleak.intake.readings.columns import Columns
from atleak.intake.readings.table import Table
from atleak.intake.readings.words import is_blank, is_marked, letters, plain, text_of
from atleak.intake.sheets.sheet import column_letter, rows_named
from atleak.sentence import Sentence

_QUOTED = 4  # marks that a message names
_LONGEST = 80  # characters of a comment or legend that are quoted
_FEW = (
    0.01,
    0.1,
)  # part of the readings: so many that are coloured otherwise are marked, whether a legend says so or not

At = tuple[int, int]  # row, column


def messages(table: Table, rows: Collection[int], columns: Columns) -> Iterator[Message]:
    """Say which readings of a table are marked; ``rows`` are those that hold any."""
    sheet = table.sheet
    groups = [[column.index for column in group.values()] for group in columns.groups]
    read = [
        [(row, sheet.derived.get(index, index)) for index in group if not is_blank(sheet.cell(row, index))]
        for row in rows
        for group in groups
    ]
    read = [cells for cells in read if cells]
    if read:
        yield from _stars(table, read)
        yield from _comments(table, rows)
        yield from _colours(table, read)


def _stars(table: Table, read: Sequence[Sequence[At]]) -> Iterator[Message]:
    """Say which numbers have a star or dagger, which points to a note."""
    sheet, marked = table.sheet, [at for cells in read for at in cells if is_marked(table.sheet.cell(*at))]
    if marked:
        numbers = tuple(dict.fromkeys(text_of(sheet.cell(*at)) for at in marked))[:_QUOTED]
        text = Sentence(
            "a mark stands behind {numbers} ({rows}): read as they stand; what it means only the sheet's notes say",
            numbers=numbers,
            rows=rows_named(sheet, [row for row, _ in marked]),
        )
        yield Message("info", "numbers_marked", text, sheet.place(*marked[0]))


def _comments(table: Table, rows: Collection[int]) -> Iterator[Message]:
    """Quote the comments on readings, and on what else stands in their rows."""
    sheet = table.sheet
    comments = {at: words for at, words in sorted(sheet.marks.comments.items()) if at[0] in rows and words}
    if comments:
        quoted = [f"{_named(table, at)}: {' '.join(words.split())[:_LONGEST]!r}" for at, words in comments.items()]
        text = Sentence(
            "comments on readings, which count all the same: {comments}. Cross out what is not to count",
            comments=_listed(quoted),
        )
        rejected = any(letters(words).any("counts_not") for words in comments.values())
        yield Message("warning" if rejected else "info", "readings_commented", text, sheet.place(*next(iter(comments))))


def _colours(table: Table, read: Sequence[Sequence[At]]) -> Iterator[Message]:
    """Say which readings are coloured otherwise than most in their column, where they are few or a legend names it."""
    sheet, colours = table.sheet, table.sheet.marks.colours
    by_column: dict[int, Counter[str]] = {}
    for at in (at for cells in read for at in cells):
        by_column.setdefault(at[1], Counter())[colours.get(at, "")] += 1
    usual = {column: counted.most_common(1)[0][0] for column, counted in by_column.items()}
    unusual = ([at for at in cells if colours.get(at, "") != usual[at[1]]] for cells in read)
    others = [cells[0] for cells in unusual if cells]
    legend = _legend(table, {colours[at] for at in others if at in colours}) if others else None
    part = len(others) / len(read)
    if not others or part > 0.5 or (legend is None and not _FEW[0] <= part <= _FEW[1]):
        return
    template = Sentence(
        "coloured otherwise than the rest of their column, {count} of {all} readings: {cells}. They count all the "
        "same: cross out what is not to count"
    )
    if legend is not None:
        template = Sentence(
            "coloured otherwise than the rest of their column, {count} of {all} readings: {cells}; the sheet says "
            "{legend!r}. They count all the same: cross out what is not to count"
        )
    cells, quoted = _listed([_named(table, at) for at in others]), (legend or "")[:_LONGEST]
    text = template.of(count=len(others), all=len(read), cells=cells, legend=quoted)
    yield Message("warning", "readings_coloured", text, sheet.place(*others[0]))


def _legend(table: Table, colours: Collection[str]) -> str | None:
    """Return what on the sheet says what a colour means: it names one, or is a word for what counts not in that one."""
    for row, cells in enumerate(table.sheet.rows):
        for column, cell in enumerate(cells):
            if not isinstance(cell, str):
                continue
            words = letters(cell)
            rejected = words.any("counts_not")
            named = next((word for word in words if word in words.of("colour")), None)
            explained = named and re.search(rf"{re.escape(named)}(?: \w+)?\s*[=:–—-]", plain(cell))
            if (
                (named and rejected)
                or explained
                or (rejected and table.sheet.marks.colours.get((row, column)) in colours)
            ):
                return " ".join(cell.split())
    return None


def _named(table: Table, at: At) -> str:
    """Name a cell as a spreadsheet does."""
    row, column = (at[1], at[0]) if table.sheet.turned else at
    return f"{column_letter(column)}{row + 1}"


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:_QUOTED]) + (" …" if len(names) > _QUOTED else "")
