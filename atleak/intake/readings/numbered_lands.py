"""Columns of diameters headed 1, 2 …: the lands of each component where its nominal diameters leave nothing else."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from atleak.errors import Message, ReadingsError
from atleak.intake.readings.controller_names import ControllerNames
from atleak.intake.readings.headings import Header
from atleak.intake.readings.one_heading import Column
from atleak.intake.readings.sizes import INCH, MM, UM, Sizes
from atleak.intake.readings.words import is_blank, number
from atleak.intake.sheets.sheet import Sheet
from atleak.intake.units import Unit
from atleak.readings import NOMINAL_TOLERANCE
from atleak.sentence import Sentence

_Cells = Sequence[tuple[str, str, float]]  # component, number in the heading, diameter as written


def with_lands(sheet: Sheet, header: Header, names: ControllerNames) -> tuple[Header, tuple[Message, ...]]:
    """Return the headings with numbers as lands, where every diameter fits that land and they can be no repeats.

    They can be none where the diameters of a row are further apart than repeats of one place ever are. The message
    says which columns are so read.
    """
    numbered = [column for column in header.values if column.repeat is not None]
    if (
        len(numbered) < 2
        or header.of("land")
        or header.of("plane")
        or any(each.land or each.plane for each in numbered)
    ):
        return header, ()
    sizes = Sizes(names.controller)
    for component in header.of("component"):
        rows = list(_rows(sheet, header, component, numbered, names))
        for unit in (MM, UM, INCH):
            if rows and all(_fits(row, unit, names, sizes) for row in rows) and any(_apart(row, unit) for row in rows):
                columns = tuple(
                    replace(column, land=str(column.repeat), repeat=None, unsure=False)
                    if column in numbered
                    else column
                    for column in header.columns
                )
                return replace(header, columns=columns), (_told(sheet, header, numbered),)
    return header, ()


def _told(sheet: Sheet, header: Header, numbered: Sequence[Column]) -> Message:
    text = Sentence(
        "columns {names} are read as lands by their numbers: the diameters fit the nominal ones of these lands, and "
        "are too far apart for repeats",
        names=tuple(repr(column.name) for column in numbered),
    )
    return Message("info", "numbers_as_lands", text, sheet.place(header.last, numbered[0].index, numbered[0].heading))


def _rows(
    sheet: Sheet, header: Header, component: Column, numbered: Sequence[Column], names: ControllerNames
) -> Iterator[_Cells]:
    for row in range(header.last + 1, len(sheet.rows)):
        named = names.component(sheet.filled(row, component.index))
        cells = []
        for column in numbered:
            cell = sheet.cell(row, column.index)
            if named is None or is_blank(cell):
                continue
            try:
                cells.append((named, str(column.repeat), number(cell)[0]))
            except ReadingsError:
                continue
        if cells:
            yield cells


def _fits(row: _Cells, unit: Unit, names: ControllerNames, sizes: Sizes) -> bool:
    for component, land, value in row:
        planes = [
            plane for each in names.controller.lands_of(component) if str(each.land) == land for plane in each.planes
        ]
        if not any(sizes.near_plane(value, (unit,), component, plane) for plane in planes):
            return False
    return True


def _apart(row: _Cells, unit: Unit) -> bool:
    sizes = [unit.to_si(value) for *_, value in row]
    return max(sizes) - min(sizes) > NOMINAL_TOLERANCE
