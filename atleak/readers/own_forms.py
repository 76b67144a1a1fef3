"""Forms that atleak wrote itself: known by their mark and read by their headings as they were written, with no guess.

Columns may have been moved, rows put in or taken out. Where the mark or the headings were changed, or columns with
numbers were added, the sheet is read as any other one, and a message says so.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache

from atleak.catalogue.written_numbers import decimal_number
from atleak.common.errors import Message
from atleak.common.sentences import Sentence
from atleak.common.translations import languages
from atleak.common.units import Unit, find_unit
from atleak.common.wording import wording
from atleak.measurements.own_forms import BEGINNING, LANDS, MEASUREMENTS, OWN_FORMS, REPEATED, TYPED, OwnForm
from atleak.readers.cells.sheet import Cell, Sheet, column_letter, text_of
from atleak.readers.sheets.column_headings import KEYS, OF_LANDS, HeadedColumn, Role
from atleak.readers.sheets.table import HeadedTable, headings

_SEARCHED = 60  # rows in which the mark and the headings are looked for
_NOT_KNOWN = Sentence("its mark was changed")
_CHANGED = Sentence("its headings were changed")


_OF_FORM: Mapping[str, Role] = {  # what a column of atleak's own forms is
    **{role: role for role in (*KEYS, *OF_LANDS, "diameter")},
    "name": "component",
    **dict.fromkeys(("coordinate 1", "coordinate 2"), "coordinate"),
    "nominal": "specification",
    **dict.fromkeys(("clearance", "deviation", "stated length", "stated position"), "quantity"),
    **dict.fromkeys(("note", "note on repairs"), "remark"),
}


@dataclass(frozen=True)
class FormTable:
    """A table of a form: the row of its headings, from 0, and the column of each that is there."""

    sheet: Sheet
    row: int
    columns: Mapping[str, int]

    def heading(self, key: str) -> str:
        """Return the heading of a column."""
        return text_of(self.sheet.cell(self.row, self.columns[key]))

    def unit(self, key: str, kind: str) -> Unit | None:
        """Return the unit that stands in the heading of a column."""
        return find_unit(self.heading(key).partition(" [")[2].removesuffix("]"), kind)


@cache
def _headings(form: str) -> Mapping[str, str]:
    says = [wording(language) for language in languages()]
    return {text_of(say.sentence(said)): key for key, said in OWN_FORMS[form].headings.items() for say in says}


def said_by_form(form: OwnForm, cell: Cell) -> str | None:
    """Return what a cell heads in a form, whatever its unit; None where it is no heading of it.

    >>> from atleak.measurements.own_forms import MEASUREMENTS
    >>> said_by_form(MEASUREMENTS, "Nenndurchmesser [mm]"), said_by_form(MEASUREMENTS, "Colour [mm]")
    ('nominal', None)
    """
    return _headings(form.mark).get(text_of(cell).partition(" [")[0]) if isinstance(cell, str) else None


def form_tables(sheet: Sheet, *forms: OwnForm) -> tuple[FormTable, ...] | None:
    """Return the tables of a sheet that is one of some forms; none of another form, and None of any other sheet."""
    form, tables, doubt = _found(sheet)
    return None if form is None or doubt else tables * (form in forms)


def own_form_of(sheet: Sheet) -> OwnForm | None:
    """Return the form that a sheet is; None where it has to be read as any other one."""
    form, _, doubt = _found(sheet)
    return None if doubt else form


def form_doubts(sheets: Iterable[Sheet]) -> list[Message]:
    """Return a message for every sheet that bears a form's mark and has to be read as any other one."""
    messages = (
        Message(
            "info",
            "own_form_changed",
            Sentence("this sheet was a form of atleak's, but {why}: it is read as any other one", why=doubt),
            sheet.place(),
        )
        for sheet in sheets
        if (doubt := _found(sheet)[2]) is not None
    )
    return list(dict.fromkeys(messages))


def _found(sheet: Sheet) -> tuple[OwnForm | None, tuple[FormTable, ...], Sentence | None]:
    texts = [text_of(cell) for row in sheet.rows[:_SEARCHED] for cell in row if isinstance(cell, str) and cell]
    form = next((OWN_FORMS[text] for text in texts if text in OWN_FORMS), None)
    if form is None:
        changed = any(BEGINNING in text.lower() for text in texts)
        return None, (), _NOT_KNOWN if changed else None
    tables = []
    for held in (form, LANDS) if form == TYPED else (form,):
        table = _table(sheet, held) if held.needed else None
        if table is not None:
            tables.append(table)
    if form.needed and not tables:
        return form, (), _CHANGED
    added = [column_letter(column) for table in tables[:1] for column in _added(table)]
    return form, tuple(tables), Sentence("columns were added ({columns})", columns=tuple(added)) if added else None


def _table(sheet: Sheet, form: OwnForm) -> FormTable | None:
    rows = range(min(len(sheet.rows), _SEARCHED)) if form != LANDS else range(len(sheet.rows))
    for row in rows:
        columns: dict[str, int] = {}
        for column, cell in enumerate(sheet.rows[row]):
            key = said_by_form(form, cell)
            if key is not None:
                columns.setdefault(key, column)
        if {REPEATED.get(key, (key,))[0] for key in columns} >= set(form.needed):
            return FormTable(sheet, row, columns)
    return None


def _added(table: FormTable) -> list[int]:
    others = set(range(table.sheet.width)) - set(table.columns.values())
    below = table.sheet.rows[table.row + 1 :]
    return sorted(
        column
        for column in others
        if any(column < len(cells) and decimal_number(str(cells[column])) is not None for cells in below)
    )


def tables_of_form(sheet: Sheet) -> list[HeadedTable] | None:
    """Return the tables of a form that atleak wrote, whose columns are known; None of any other sheet."""
    tables = form_tables(sheet, MEASUREMENTS, TYPED, LANDS)
    if tables is None:
        return None
    ends = [table.row for table in tables[1:]] + [len(sheet.rows)]
    return [_of_form(table, end) for table, end in zip(tables, ends, strict=False)]


def _of_form(table: FormTable, end: int) -> HeadedTable:
    columns = []
    for key, at in sorted(table.columns.items(), key=lambda held: held[1]):
        holds, repeat = REPEATED.get(key, (key, None))
        if holds in _OF_FORM:
            columns.append(
                HeadedColumn(
                    *(at, table.heading(key), _OF_FORM[holds], table.unit(key, "length")),
                    coordinate=int(holds[-1]) if holds.startswith("coordinate") else None,
                    repeat=repeat if holds != "deviation" else None,
                    rank=9 if holds == "component" else 0,
                )
            )
    sheet = replace(table.sheet, rows=table.sheet.rows[:end])
    return HeadedTable(sheet, table.row, table.row, tuple(columns), tuple(headings(sheet, table.row, table.row)))
