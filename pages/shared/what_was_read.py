"""Show the file's own table with what became of every cell, and let a row or a column be chosen in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import pandas as pd
import streamlit as st

from atleak.common.style import cell_colour
from atleak.measurements.readings import CellKind, Reading, SheetCells
from atleak.readers.cells.sheet import column_letter, text_of
from atleak.report.tables.what_was_read import (
    KIND_WORDS,
    WHAT_BECAME,
    column_said,
    kinds_in,
    meaning_said,
    reading_said,
    row_said,
)
from pages.shared import reader, show

_AT_ONCE = 300  # rows
_HEIGHT = 420  # pixels
_WIDE = 110  # pixels of a column of the file
MODES: tuple[Any, ...] = ("single-row", "single-column", "single-cell")


class Spot(NamedTuple):
    """What is chosen in the table, counted from 0 in the sheet."""

    row: int | None = None
    column: int | None = None


def draw(sheet: SheetCells, readings: Sequence[Reading], key: str) -> Spot:
    """Draw a sheet with its legend and a sentence on what is chosen; return that."""
    say = reader.say()
    legend = [
        f'<span style="background:{cell_colour(kind, on_screen=True)};padding:1px 6px;margin-right:8px;'
        f'white-space:nowrap">{say.sentence(KIND_WORDS[kind])}</span>'
        for kind in kinds_in([sheet])
    ]
    st.html(f'<div style="line-height:1.9;font-size:0.875rem">{" ".join(legend)}</div>')
    rows = _rows_shown(sheet, key)
    width = max(map(len, sheet.rows), default=0)
    spot = _table(sheet, rows, [_heading(sheet, column) for column in range(width)], key)
    st.markdown(_sentence(sheet, spot, readings))
    return spot


def _rows_shown(sheet: SheetCells, key: str) -> range:
    """Ask which rows are shown where there are too many for one table: at first those of the first refused one."""
    starts = range(0, len(sheet.rows), _AT_ONCE)
    if len(starts) < 2:
        return range(len(sheet.rows))
    refused = (row for row, cells in enumerate(sheet.meanings) if any(one and one.kind == "refused" for one in cells))
    said = [f"{sheet.numbers[start]}–{sheet.numbers[min(start + _AT_ONCE, len(sheet.rows)) - 1]}" for start in starts]
    first = next(refused, 0) // _AT_ONCE
    picked = st.selectbox(reader.say()("what_was_read.rows"), said, first, key=f"{key}-rows")
    start = starts[said.index(picked)]
    return range(start, min(start + _AT_ONCE, len(sheet.rows)))


def _heading(sheet: SheetCells, column: int) -> str:
    said = column_said(sheet, column, reader.say())
    return f"{column_letter(column)} · {said}" if said else column_letter(column)


def _table(sheet: SheetCells, rows: range, headings: Sequence[str], key: str) -> Spot:
    say = reader.say()
    first = say.sentence(WHAT_BECAME)
    texts = [
        [row_said(sheet, row, say), *(text_of(cell) for cell in sheet.rows[row]), *[""] * len(headings)] for row in rows
    ]
    frame = pd.DataFrame(
        [cells[: len(headings) + 1] for cells in texts],
        columns=[first, *headings],
        index=[sheet.numbers[row] for row in rows],
        dtype=str,
    )

    def shades(_: pd.DataFrame) -> pd.DataFrame:
        shaded = [
            ["" if one is None else f"background-color: {cell_colour(one.kind, on_screen=True)}" for one in of_row]
            for of_row in ([None, *sheet.meanings[row], *[None] * len(headings)] for row in rows)
        ]
        return pd.DataFrame(
            [of_row[: len(headings) + 1] for of_row in shaded], index=frame.index, columns=frame.columns
        )

    config = {name: st.column_config.TextColumn(width=_WIDE) for name in headings}
    chosen: Any = st.dataframe(
        frame.style.apply(shades, axis=None),
        width="stretch",
        height=min(_HEIGHT, 38 * (len(rows) + 1)),
        column_config={first: st.column_config.TextColumn(width=170), **config},
        on_select="rerun",
        selection_mode=MODES,
        key=f"{key}-{rows.start}",
    )
    return spot_of(chosen, rows, headings)


def spot_of(chosen: Mapping[str, Any], rows: range, headings: Sequence[str]) -> Spot:
    """Return the row and column of what is selected in the table: of a row or a column as a whole, or of a cell."""
    selection = chosen["selection"]
    cells = selection.get("cells") or ()
    row = next(iter(selection["rows"]), cells[0][0] if cells else None)
    column = next(iter(selection["columns"]), cells[0][1] if cells else None)
    return Spot(
        None if row is None or row >= len(rows) else rows[row],
        list(headings).index(str(column)) if column in headings else None,
    )


def _sentence(sheet: SheetCells, spot: Spot, readings: Sequence[Reading]) -> str:
    """Say in words what the chosen cell, row or column became."""
    say = reader.say()
    if spot == Spot():
        return say("what_was_read.choose")
    if spot.row is None or spot.column is None:
        if spot.row is not None:
            words, name = row_said(sheet, spot.row, say), say("what_was_read.row", row=sheet.numbers[spot.row])
        else:
            words = column_said(sheet, spot.column or 0, say)
            name = say("what_was_read.column", column=column_letter(spot.column or 0))
        return f"**{name}**: {show.plain(words or say('what_was_read.nothing'))}"
    cells, meanings = sheet.rows[spot.row], sheet.meanings[spot.row]
    cell, meaning = (cells[spot.column], meanings[spot.column]) if spot.column < len(cells) else ("", None)
    words = say("what_was_read.nothing") if meaning is None else meaning_said(meaning, say)
    if meaning is not None and meaning.kind in (CellKind.SPOOL, CellKind.SLEEVE):
        words = ", ".join([words, *(reading_said(one, say) for one in _read_from(sheet, spot, readings))])
    return f"**{column_letter(spot.column)}{sheet.numbers[spot.row]}** {show.plain(text_of(cell))}: {show.plain(words)}"


def _read_from(sheet: SheetCells, spot: Spot, readings: Sequence[Reading]) -> list[Reading]:
    """Return what was read from a cell."""
    row, column = sheet.numbers[spot.row or 0], spot.column or 0
    names = {
        column_letter(column),
        str(column + 1),
        *(text_of(each[column]) for each in sheet.rows if column < len(each)),
    }
    found = [one for one in readings if (one.place.sheet, one.place.row) == (sheet.name, row)]
    return [one for one in found if one.place.column in names]
