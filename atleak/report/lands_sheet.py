"""Write the tab of a measuring sheet that takes what a land has beside its diameters, a row for every land.

`atleak.intake.readings.land_values` reads it back.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from xlsxwriter.format import Format
from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.controller import Controller, Land
from atleak.own_lands import OwnLands
from atleak.report.row_heights import PENCIL, row_height
from atleak.sentence import Name, Sentence
from atleak.unit_systems import Quantity
from atleak.wording import Wording
from atleak.workshop_units import MM

LANDS = Sentence("Lands")
REPRESENTATIVE, AS_STATED = Sentence("representative"), Sentence("as stated")
HEADER = 5  # row of the headings, from 0
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
    heading: Sentence
    width: int
    form: str  # name of the format
    of_length: bool = False  # the unit stands behind the heading


_NUMBER, _NAME, _LAND = (
    _Column(Sentence("No."), 8, "text"),
    _Column(Sentence("Component"), 26, "text"),
    _Column(Sentence("Land"), 8, "number"),
)
_CONTACT = _Column(Sentence("Contact\nlength"), 14, "input", of_length=True)
_STATED = _Column(Sentence("Stated contact\nlength"), 14, "nominal", of_length=True)
_ORIGIN = _Column(Sentence("Note on\nstated length"), 16, "origin")
_POSITION = _Column(Sentence("Position from\nleft end"), 14, "input", of_length=True)
_STATED_POSITION = _Column(Sentence("Stated length from\nleft end"), 16, "nominal", of_length=True)
_NOTE = _Column(Sentence("Note"), 40, "origin")
_FITTED = _Column(Sentence("Fitted repair"), 24, "choice")
_OPTIONS = _Column(Sentence("Note on repairs"), 60, "origin")


def write_lands(
    sheet: Worksheet, formats: Mapping[str, Format], controller: Controller, own: OwnLands, say: Wording
) -> None:
    """Write the tab, empty or with what is known of one unit.

    Parameters
    ----------
    sheet
        of a workbook that is being written.
    formats
        of the measuring sheet.
    controller
        whose lands the rows name, with what its file states beside them.
    own
        what to fill in.
    say
        the reader's words and units.
    """
    columns = [_NUMBER, _NAME, _LAND, _CONTACT, _STATED, _ORIGIN, _POSITION, _STATED_POSITION, _NOTE]
    columns += [_FITTED, _OPTIONS] if controller.repairs else []
    sheet.write_string(
        0, 0, say.sentence(Sentence("Lands of this unit: {name}", name=Name(controller.name))), formats["title"]
    )
    how_to = (*_HOW_TO, _HOW_TO_REPAIR) if controller.repairs else _HOW_TO
    for row, text in enumerate(how_to, start=1):
        sheet.write_string(row, 0, say.sentence(text))
    headings = [
        say.sentence(column.heading) + (f" [{say.unit('length')}]" if column.of_length else "") for column in columns
    ]
    widths = [
        max(column.width, 2 + max(map(len, said.split()))) for column, said in zip(columns, headings, strict=True)
    ]
    for number, (said, width) in enumerate(zip(headings, widths, strict=True)):
        sheet.write_string(HEADER, number, said, formats["heading"])
        sheet.set_column(number, number, width)
    sheet.set_row(HEADER, row_height(zip(headings, widths, strict=True), bold=True))
    last = HEADER
    for last, (land, values) in enumerate(_rows(controller, own, say), start=HEADER + 1):
        texts = [str(values.get(column) or "") for column in columns]
        sheet.set_row(last, max(PENCIL, row_height(zip(texts, widths, strict=True))))
        for number, column in enumerate(columns):
            value = values.get(column)
            form = formats[column.form]
            if value is None or value == "":
                sheet.write_blank(last, number, None, form)
            elif isinstance(value, str) and not (value.isdecimal() and str(int(value)) == value):
                sheet.write_string(last, number, value, form)
            else:
                sheet.write_number(last, number, float(value), form)
        ids = [repair.id for repair in controller.repairs_of(land.component) if repair.changes(land.key)]
        if ids and len(",".join(ids)) <= _LIST:
            sheet.data_validation(last, columns.index(_FITTED), last, columns.index(_FITTED), _one_of(ids, say))
    for column in (_CONTACT, _POSITION):
        number = columns.index(column)
        sheet.data_validation(HEADER + 1, number, last, number, _lengths(say))
    sheet.freeze_panes(HEADER + 1, 3)
    sheet.set_landscape()
    sheet.set_paper(9)  # A4
    sheet.fit_to_pages(1, 0)
    sheet.repeat_rows(HEADER)
    sheet.ignore_errors({"number_stored_as_text": f"A{HEADER + 2}:A{last + 1}"})


def _lengths(say: Wording) -> dict[str, object]:
    message = Sentence(
        "A number in {example.unit}, such as {example}. Leave empty what was not measured.",
        example=Quantity(5.25, "length", 2),
    )
    return {
        "validate": "decimal",
        "criteria": ">=",
        "value": 0,
        "error_title": say.sentence(Sentence("Not a length")),
        "error_message": say.sentence(message),
    }


def _one_of(ids: list[str], say: Wording) -> dict[str, object]:
    message = Sentence("One of the list, or nothing where the component is as it left the factory.")
    return {
        "validate": "list",
        "source": ids,
        "error_title": say.sentence(Sentence("No such repair")),
        "error_message": say.sentence(message),
    }


def _rows(
    controller: Controller, own: OwnLands, say: Wording
) -> Iterator[tuple[Land, dict[_Column, str | float | None]]]:
    """Yield every land with what stands in its row."""

    def shown(metres: float | None) -> float | None:
        return None if metres is None else round(float(say.convert(metres * MM, "length")), 7)

    lengths = {each.key: each for each in own.lengths}
    for land in controller.lands:
        length = lengths.get(land.key)
        contact, position = (length.contact_length, length.position) if length is not None else (None, None)
        repairs = [repair for repair in controller.repairs_of(land.component) if repair.changes(land.key)]
        fitted = {each.repair for each in own.fitted if each.component == land.component}
        yield (
            land,
            {
                _NUMBER: land.component,
                _NAME: say.name(controller.components[land.component]),
                _LAND: land.land,
                _CONTACT: shown(contact),
                _STATED: shown(land.contact_length),
                _ORIGIN: say.sentence(REPRESENTATIVE if "contact_length_mm" in land.representative else AS_STATED),
                _POSITION: shown(position),
                _STATED_POSITION: shown(land.position),
                _NOTE: "; ".join(say.sentence(part) for part in land.built),
                _FITTED: next((repair.id for repair in repairs if repair.id in fitted), None),
                _OPTIONS: "; ".join(f"{repair.id}: {say.name(repair.label)}" for repair in repairs),
            },
        )
