"""Write the tab of a measuring sheet that takes what a land has beside its diameters, a row for every land.

`atleak.readers.sheets.land_values` reads it back.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.controller import Controller, Land
from atleak.common.sentences import Name, Sentence
from atleak.common.units import MM, Quantity
from atleak.common.wording import Wording
from atleak.measurements.own_forms import LANDS as FORM
from atleak.measurements.readings import OwnLands
from atleak.report.sheets.paging import HEADER, PagedTable, Tab, only, put, width_for

LANDS = Sentence("Lands")
_LENGTH_REPRESENTATIVE = Sentence("stated length assumed")
_LIST = 255  # characters that a spreadsheet program takes as the choices of a cell
_HOW_TO = (
    Sentence(
        "Beside the diameters, where it was measured: yellow cells may stay empty, then the valve body's file counts."
    ),
    Sentence(
        "Contact length: over which spool and bore face each other where the valve works, by calliper. Position: of "
        "the land's near edge, from the left end of the spool."
    ),  # "drawing" would set the table aside when it is read back
)
_HOW_TO_REPAIR = Sentence(
    "Fitted repair: an oversize valve, a sleeve … from an earlier repair, by its id; once for a component."
)


@dataclass(frozen=True)
class _Column:
    holds: str
    width: int
    form: str  # name of the format
    of_length: bool = False  # the unit stands behind the heading
    unbroken: bool = False  # it is as wide as its longest word


_NUMBER, _NAME, _LAND = (
    _Column("component", 5, "text", unbroken=True),
    _Column("name", 26, "text"),
    _Column("land", 5, "number"),
)
_CONTACT = _Column("contact length", 9, "input", of_length=True)
_STATED = _Column("stated length", 11, "nominal", of_length=True)
_POSITION = _Column("position", 10, "input", of_length=True)
_STATED_POSITION = _Column("stated position", 12, "nominal", of_length=True)
_NOTE = _Column("note", 24, "origin")
_FITTED = _Column("fitted repair", 14, "choice", unbroken=True)
_OPTIONS = _Column("note on repairs", 30, "origin", unbroken=True)
_Cells = Mapping[_Column, str | float | None]


def write_lands(tab: Tab, controller: Controller, own: OwnLands) -> None:
    """Write the tab, empty or with what is known of one unit, beside what its controller's file states of its lands."""
    sheet, formats, say = tab.sheet, tab.formats, tab.say
    rows = list(_rows(controller, own, say))
    columns = [_NUMBER, _NAME, _LAND, _CONTACT, _STATED, _POSITION, _STATED_POSITION, _NOTE]
    columns += [_FITTED, _OPTIONS] if any(repair.lands for repair in controller.repairs) else []
    headings = [
        say.sentence(FORM.headings[column.holds]) + (f" [{say.unit('length')}]" if column.of_length else "")
        for column in columns
    ]
    widths = []
    for column in columns:
        texts = [str(cells.get(column) or "") for _, cells in rows] if column.unbroken else []
        widths.append(width_for(texts, column.width))
    table = PagedTable(tab, FORM, headings, widths)
    title = Sentence("Lands of this unit: {name}", name=Name(controller.name))
    how_to = (*_HOW_TO, _HOW_TO_REPAIR) if _FITTED in columns else _HOW_TO
    table.write((title, *how_to), HEADER + len(rows), columns.index(_CONTACT))
    for row, (_, cells) in enumerate(rows, start=HEADER + 1):
        table.fit(row, {at: str(cells.get(column) or "") for at, column in enumerate(columns)})
        for at, column in enumerate(columns):
            put(sheet, row, at, cells.get(column), formats[column.form])
    _check_entries(sheet, controller, columns, [land for land, _ in rows], say)


def _check_entries(
    sheet: Worksheet, controller: Controller, columns: Sequence[_Column], lands: Sequence[Land], say: Wording
) -> None:
    """Let only lengths be typed as such, and repairs be chosen from those of the land."""
    message = Sentence(
        "A number in {example.unit}, such as {example}. Leave empty what was not measured.",
        example=Quantity(5.25, "length", 2),
    )
    lengths = only("decimal", Sentence("Not a length"), message, say, criteria=">=", value=0)
    for column in (_CONTACT, _POSITION):
        number = columns.index(column)
        sheet.data_validation(HEADER + 1, number, HEADER + len(lands), number, lengths)
    message = Sentence("One of the list, or nothing where the component is as it left the factory.")
    for row, land in enumerate(lands, start=HEADER + 1):
        ids = [repair.id for repair in controller.repairs_of(land.component) if repair.changes(land.key)]
        if ids and len(",".join(ids)) <= _LIST:
            number = columns.index(_FITTED)
            choice = only("list", Sentence("No such repair"), message, say, source=ids)
            sheet.data_validation(row, number, row, number, choice)


def _rows(controller: Controller, own: OwnLands, say: Wording) -> Iterator[tuple[Land, _Cells]]:
    """Yield every land with what stands in its row."""

    def shown(metres: float | None) -> float | None:
        return None if metres is None else round(float(say.convert(metres * MM, "length")), 7)

    lengths = {each.key: each for each in own.lengths}
    for land in controller.lands:
        length = lengths.get(land.key)
        contact, position = (length.contact_length, length.position) if length is not None else (None, None)
        repairs = [repair for repair in controller.repairs_of(land.component) if repair.changes(land.key)]
        origin = [_LENGTH_REPRESENTATIVE] if "contact_length_mm" in land.representative else []
        fitted = {each.repair for each in own.fitted if each.component == land.component}
        yield (
            land,
            {
                _NUMBER: land.component,
                _NAME: say.name(controller.components[land.component]),
                _LAND: land.land,
                _CONTACT: shown(contact),
                _STATED: shown(land.contact_length),
                _POSITION: shown(position),
                _STATED_POSITION: shown(land.position),
                _NOTE: "; ".join(map(say.sentence, (*land.built, *origin))),
                _FITTED: next((repair.id for repair in repairs if repair.id in fitted), None),
                _OPTIONS: "; ".join(f"{repair.id}: {say.name(repair.label)}" for repair in repairs),
            },
        )
