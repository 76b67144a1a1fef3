"""A measuring sheet (workbook or text) → readings.

The form is that of the source study's Table 1, a tidy table, or a table with several diameters in a row; see
``docs/measuring-sheet.md``. Everything wrong is listed at once, with file, sheet, row and column.

What happens to a file:

1. `readers.cells` turns its bytes into sheets: cells, what is merged, hidden or crossed out.
2. `layout` cuts a sheet into tables by what `column_headings`, `table` and `words` understand of headings, or by what a
   person says of the columns (`mapping`), and picks those that are the measurement.
3. `rows` reads every row by its `columns`, without the `exclusions`; `repeats` asks where two states would be averaged.
   `diameters` makes metres of what they hold, `head` and `land_values` read what stands beside.
4. `account` looks at all cells again: what has the size of a diameter and was not read is named or refused.
5. `agreement` compares the diameters with what else the sheet says of them, `plausibility` with the controller.
6. Where a sheet cannot be read, `suggestions` says how it can: what it offers was tried on the file.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.catalogue.words import PART_WORDS
from atleak.common.damage import own_errors_only
from atleak.common.errors import Message, Place, ReadingsError
from atleak.common.file_faults import faults_together
from atleak.common.sentences import Sentence, all_of, counted, in_a_row
from atleak.common.units import Unit, find_unit
from atleak.common.units import unit as unit_named
from atleak.measurements.gauge_readings import PressureTable
from atleak.measurements.readings import Reading, Readings, SheetCells
from atleak.readers.cells.extent import FAULTS
from atleak.readers.cells.sheet import Sheet, sheet_cells
from atleak.readers.cells.sheet_file import read_bytes, read_sheets
from atleak.readers.gauges.gauge_table import find_tabs, likeness_of
from atleak.readers.own_forms import form_doubts, tables_of_form
from atleak.readers.remembered_columns import forget_columns
from atleak.readers.sheets import agreement
from atleak.readers.sheets.account import Account
from atleak.readers.sheets.columns import find_columns
from atleak.readers.sheets.controller_names import ControllerNames
from atleak.readers.sheets.diameters import convert
from atleak.readers.sheets.exclusions import LEFT_ASIDE
from atleak.readers.sheets.head import is_typed, read_head
from atleak.readers.sheets.land_values import LandValues, read_land_values
from atleak.readers.sheets.layout import SheetChoice, choose_sheet, find_tables, require_one_measurement, turned
from atleak.readers.sheets.mapping import SheetMapping, recalled
from atleak.readers.sheets.plausibility import check, nominal_alone
from atleak.readers.sheets.repeats import require_known
from atleak.readers.sheets.rows import SheetRows, read_rows
from atleak.readers.sheets.suggestions import Guess, column_name, suggest
from atleak.readers.sheets.table import HeadedTable, best_header, likely_table
from atleak.readers.sheets.words import direction_of, is_word, letters, text_of

_OWN = 100.0  # score of a form of atleak's own, more than any headings have


class ReadingsRefused(ReadingsError):
    """A measuring sheet that cannot be used: the first reason, and the others below it.

    ``problems`` holds them all, in the order of the sheet. ``sheets`` are those of the file, as `Readings.sheets`.
    """

    def __init__(self, problems: Sequence[ReadingsError], sheets: tuple[SheetCells, ...] = ()) -> None:
        first, *others = self.problems = tuple(problems)
        self.sheets = sheets
        given = {"place": first.place, "value": first.value, "expected": first.expected, "nearest": first.nearest}
        super().__init__(first.problem, **given, others=others)  # type: ignore[arg-type]


__all__ = ["ReadingsRefused", "SheetLook", "check", "forget_sheet", "look_at", "read_readings"]


@own_errors_only(ReadingsError, "name", "source")
def read_readings(
    source: str | Path | bytes,
    controller: Controller,
    *,
    name: str | None = None,
    sheet: str | None = None,
    unit: str | None = None,
    where: Mapping[str, str] | None = None,
    fill_down: bool = False,
    mapping: Mapping[str, str] | None = None,
    remembered: Path | None = None,
    made_for: str | None = None,
    with_cells: bool = False,
) -> Readings:
    """Return the readings of a measuring sheet.

    Parameters
    ----------
    source
        path of a file, or its bytes: ``.xlsx`` (also xls, ods), or text with columns separated by comma, semicolon or
        tab.
    controller
        whose components and planes the sheet names. Its nominal diameters tell a wrong unit.
    name
        what to call the file in messages; the path's own name by default.
    sheet
        the workbook's sheet to read, where more than one holds readings.
    unit
        unit of the diameters ("mm", "µm", "inch" …), instead of what the headings say.
    where
        which rows to read: headings of columns and what must stand under them, as in ``{"Inspection": "May"}``.
    fill_down
        whether an empty cell of a label goes on with the one above it.
    mapping
        role → column, where the headings do not tell: see `atleak.readers.sheets.mapping.SheetMapping`.
    remembered
        a file of mappings chosen earlier (see `atleak.readers.remembered_columns`); None: none are consulted.
    made_for
        id that the sheet may name in place of the controller's: of the one from which this one was copied.
    with_cells
        whether to keep the file's own tables, with what became of every cell.

    Returns
    -------
    Readings
        diameters in metres, each with its place in the file; ``messages`` say what was assumed. Its ``pressures`` are
        those of a tab of gauge readings; where only that is filled in, there are no diameters. Its ``own_lands`` are
        contact lengths, positions and fitted repairs, where the sheet states them. Its ``columns`` are the mapping that
        it was read with, and ``headings`` those by which that may be remembered.

    Raises
    ------
    ReadingsRefused
        with all problems found: an unknown component, part or plane, a cell that is no diameter, a repeat given twice,
        a diameter off its nominal one by a factor, a sleeve smaller than its spool, a clearance over 0.5 mm …
    PressureTableError
        a tab of gauge readings that cannot be used.
    ReadingsError
        where the file as a whole cannot be read: no such file, empty, damaged, a picture, no measuring sheet in it,
        several of them, or none filled in.
    """
    settled = SheetMapping(mapping or {})
    given_unit = None if unit is None else unit_named(unit, "length")
    data, file = read_bytes(source, name)
    of_gauges = likeness_of(controller)
    sheets = read_sheets(data, file, lambda page: max(_score(page), of_gauges(page)), is_word)
    tabs = find_tabs(sheets, controller)
    pressures = tabs.read(file, data)
    sheets = [page for page in sheets if page not in tabs]
    cells = (cell for page in sheets for row in page.rows for cell in row)
    if pressures is not None and not any(any(map(str.isdigit, str(cell))) for cell in cells):
        digest, tab = pressures.sha256, pressures.sheet
        return Readings(pressures.file, digest, tab, "mm", False, "tidy", readings=(), pressures=pressures)
    shown = [page for page in sheets if (not page.hidden if sheet is None else page.name in (sheet, None))]
    earlier = None if remembered is None else recalled(remembered, shown)
    if earlier is not None:
        settled = SheetMapping(earlier.with_chosen(settled.chosen))
        given_unit = given_unit or find_unit(earlier.entry.units.get("value", ""), "length")
    names, digest = ControllerNames(controller), hashlib.sha256(data).hexdigest()
    note = () if earlier is None else (earlier.entry.note,)

    def read(said: SheetMapping, down: bool, cells: bool = False) -> Readings:
        chosen = choose_sheet(sheets, file, names, sheet, down, said)
        require_known(chosen.tables, where or {})
        lands = read_land_values([*chosen.tables, *chosen.of_lands], names, given_unit, where)
        fitted = lands.own.with_fitted(controller)
        measured = _Measurement(chosen, sheets, lands, ControllerNames(fitted), given_unit, where, said)
        result = measured.readings(digest, pressures)
        notes = [*form_doubts(chosen.sheets), *note]
        result = replace(result, messages=(*notes, *result.messages))
        if said.chosen:
            result = replace(result, columns=tuple(said.chosen.items()), headings=measured.first.headed)
        problems = [*measured.problems, *check(result, fitted)]
        problems += [] if any(map(tables_of_form, sheets)) else nominal_alone(result, fitted)
        others = [agreement.other_controller(table, fitted, made_for) for table in chosen.tables]
        problems = next(([other] for other in reversed(others) if other is not None), problems)
        if cells:
            result = replace(result, sheets=measured.sheets(problems))
        if problems:
            refused = sorted(problems, key=lambda problem: problem.place.row or 0)
            refused += [ReadingsError(note.text, place=note.place) for note in notes]
            raise ReadingsRefused(refused, result.sheets)
        if not (result.readings or result.unworn or any(map(is_typed, sheets))) and pressures is None:
            raise _none_left(result, measured.first)
        return result

    try:
        return read(settled, fill_down, with_cells)
    except ReadingsError as error:
        suggest(error, sheets, names, settled, read)
        raise


class _Measurement:
    """The tables of a file that are one measurement: their rows, and the diameters in metres that these make."""

    def __init__(
        self,
        chosen: SheetChoice,
        sheets: Sequence[Sheet],
        lands: LandValues,
        names: ControllerNames,
        unit: Unit | None,
        where: Mapping[str, str] | None,
        said: SheetMapping,
    ) -> None:
        self.chosen, self.lands, self.unit, self.said = chosen, lands, unit, said
        self.given = [page for page in sheets if not page.hidden]
        self.rows = self._rows(names, where)
        self.filled = [rows for rows in self.rows if rows.entries]
        self.first = next((rows.table for rows in self.filled), chosen.tables[0])
        problems = [problem for rows in self.rows for problem in rows.problems]
        problems += require_one_measurement(self.rows, chosen.file)
        problems += [] if problems else agreement.units_apart(self.filled, said)
        for sheet in self.given if not problems else ():
            problems += agreement.lines_that_change(sheet, self.filled, said)
        entries = [entry for rows in self.filled for entry in rows.entries]
        headings = self.first.heading_place(self.first.values[0].index)
        self.converted = convert(entries, names.controller, headings)
        self.head = read_head([rows.table.as_it_stands for rows in self.filled], sheets)
        self.account = self._account(names)
        self.problems = [*problems, *lands.problems, *self.head.problems]
        self.problems += [*self.converted.problems, *self.account.problems]

    def _rows(self, names: ControllerNames, where: Mapping[str, str] | None) -> list[SheetRows]:
        read: list[SheetRows] = []
        for table in self.chosen.tables:
            if sum(len(rows.problems) for rows in read) > FAULTS:
                break
            read.append(read_rows(table, names, self.unit, where, self.said.leaves_out(table.sheet)))
        return [rows for rows in read if not rows.columns.problems or rows.table.count_values()]

    def _account(self, names: ControllerNames) -> Account:
        chosen = self.chosen
        account = Account(names, [*self.converted.units, *([self.unit.name] if self.unit else [])])
        account.take(self.lands.cells, of_lands=True)
        for rows in self.rows:
            account.enter(rows)
        for table in chosen.of_lands:
            account.enter_lands(table)
        for table in chosen.without_readings:
            if table.left_aside:
                account.leave_table(table)
            elif account.holds_sizes(table):
                account.problems += read_rows(table, names, self.unit).problems
        for sheet in chosen.sheets_left_aside:
            account.leave_sheet(sheet)
        for name, row, column in self.head.cells:
            account.take([(name, column, row) if name in self._around else (name, row, column)])
        account.close([page for page in chosen.sheets if not page.hidden])
        return account

    @property
    def _around(self) -> set[str | None]:
        return {page.name for page in self.chosen.sheets if page.turned}

    def sheets(self, problems: Iterable[ReadingsError]) -> tuple[SheetCells, ...]:
        return self.account.sheets(self.given, problems, self._around)

    def readings(self, digest: str, pressures: PressureTable | None) -> Readings:
        converted, head, sheet = self.converted, self.head, self.first.sheet
        by_coordinates = any(reading.coordinates is not None for reading in converted.readings)
        several = any(len({value.group for value in rows.table.values}) > 1 for rows in self.rows)
        sheets = dict.fromkeys(str(rows.table.sheet.name) for rows in self.filled)
        # of a part that was not read, what is left aside may be the readings; so may a sheet that no mapping fits
        half = len({reading.part for reading in converted.readings}) == 1
        doubted = {each.code for each in self.account.messages if half or (self.said and each.code == "sheet_aside")}
        aside = (replace(each, level="warning") if each.code in doubted else each for each in self.account.messages)
        return Readings(
            file=self.chosen.file,
            sha256=digest,
            sheet=None if sheet.is_text else ", ".join(sheets),
            unit=", ".join(converted.units) or (self.unit.name if self.unit else "mm"),
            unit_assumed=converted.unit_assumed,
            layout="table" if by_coordinates else "columns" if several else "tidy",
            readings=tuple(converted.readings),
            messages=(
                *self.chosen.messages,
                *head.messages,
                *(message for rows in self.filled for message in rows.table.messages),
                *(message for rows in self.rows for message in rows.messages),
                *converted.messages,
                *self._about_sheet(),
                *aside,
                *self.lands.messages,
                *self._contradictions(),
                *([_at_unworn_ends(converted.unworn)] if converted.unworn else ()),
            ),
            temperature=head.temperature,
            date=head.date,
            identity=head.identity,
            pressures=pressures,
            pump=head.pump,
            own_lands=self.lands.own,
            unworn=tuple(converted.unworn),
        )

    def _contradictions(self) -> list[Message]:
        messages: list[Message] = []
        for rows in self.rows:
            messages += agreement.agreement_messages(rows.table, rows.columns, rows.entries, self.converted.readings)
        for rows in self.rows if self.head.temperature is None else ():
            messages += agreement.temperatures(rows.table, rows.columns, list(rows.of_row))
        return list(dict.fromkeys(messages))  # a message about what stands above several tables is given once

    def _about_sheet(self) -> Iterator[Message]:
        sheet = self.first.sheet
        if sheet.note:
            yield Message("info", "read_as", sheet.note, Place(sheet.file))
        for table in (rows.table for rows in self.filled if rows.table.named_by):
            part = table.part and PART_WORDS[table.part]
            directions = {f"{each.direction:g}°" for each in table.values if each.direction is not None}
            said = (table.component, part, *(directions if len(directions) == 1 else ()))
            what = all_of(name_of for name_of in said if name_of is not None)
            text = Sentence("{where}: {said}, as {said_by} says", where=table.where, said=what, said_by=table.named_by)
            yield Message("info", "taken_from_title", text, table.sheet.place(table.rows[0]))
        yield from self._directions_in_words()
        unmeasured = sum(rows.rows_without_reading for rows in self.rows)
        if unmeasured:
            text = counted(
                unmeasured,
                "{count} row without a reading: not measured",
                "{count} rows without a reading: not measured",
            )
            yield Message("info", "rows_not_measured", text, Place(sheet.file, sheet.name))

    def _directions_in_words(self) -> Iterator[Message]:
        """Say which angle a word for a direction counts as: of "vertical" not everybody says 90°."""
        angles: dict[str, float] = {}
        for rows in self.filled:
            column = rows.columns.direction
            texts = [] if column is None else [*map(text_of, rows.table.cells(column.index).values())]
            headings = [letters(value.heading) for value in rows.table.values if value.direction is not None]
            words = (word for word in chain(texts, *headings) if word.isalpha() and len(word) > 3)
            angles |= {word.lower(): angle for word in words if (angle := direction_of(word)) is not None}
        if angles:
            said = Sentence("{word!r} as {angle:g}°")
            text = Sentence("directions count: {named}")
            text = text.of(named=all_of(said.of(word=word, angle=angle) for word, angle in angles.items()))
            yield Message("info", "directions_in_words", text, self.first.heading_place())


def _at_unworn_ends(unworn: Sequence[Reading]) -> Message:
    place = Sentence("{component}, plane {plane}")
    text = counted(
        len(unworn),
        "{count} reading at an unworn end (component {places}): of the pair when new, not of its wear. `atleak "
        "controller learn` makes mounting clearances of them",
        "{count} readings at an unworn end (component {places}): of the pair when new, not of its wear. `atleak "
        "controller learn` makes mounting clearances of them",
        places=in_a_row(dict.fromkeys(place.of(component=end.component, plane=end.plane) for end in unworn)),
    )
    return Message("info", "unworn_ends", text, unworn[0].place)


def _score(sheet: Sheet) -> float:
    if (own := tables_of_form(sheet)) is not None:
        return _OWN * len(own)
    header = best_header(sheet)
    return -1.0 if header is None else header.score + 0.01 * min(header.count_values(), 10)


def _none_left(result: Readings, table: HeadedTable) -> ReadingsError:
    reasons = [message.text for message in result.messages if message.code in (*LEFT_ASIDE, "rows_left_out")]
    problem, place = Sentence("no readings are filled in: every diameter is empty"), table.sheet.place(table.last)
    if reasons:
        problem = Sentence("no reading is left: {reasons}", reasons=in_a_row(reasons))
        place = Place(result.file, result.sheet)
    return ReadingsError(problem, place=place, expected=Sentence("at least one diameter, or two coordinates"))


@dataclass(frozen=True)
class SheetLook:
    """A sheet as it stands in its file, for a person to say which column is what."""

    sheets: tuple[str, ...]  # of the workbook, that are shown
    sheet: str | None  # of which the rest is
    cells: SheetCells
    columns: tuple[str, ...]  # as a mapping names them
    examples: tuple[str, ...]  # a cell of each
    header: str  # the rows of the headings, as a mapping names them
    chosen: Mapping[str, str]  # role → column, as it is said, or else as is likely
    understood: bool  # by its headings alone


@own_errors_only(ReadingsError, "name", "source")
def look_at(
    source: str | Path | bytes,
    controller: Controller,
    *,
    name: str | None = None,
    sheet: str | None = None,
    mapping: Mapping[str, str] | None = None,
) -> SheetLook:
    """Return how a sheet looks, and which column most likely is what.

    What is given is as for `read_readings`; without a ``mapping`` rows of headings and columns are found.
    """
    data, file = read_bytes(source, name)
    names, chosen = ControllerNames(controller), SheetMapping(mapping or {})
    pages = read_sheets(data, file, _score, is_word)
    pages = [page for page in pages if not page.hidden] or pages
    page = next((page for page in pages if page.name == sheet), max(pages, key=_score))
    understood = any(table.readable and not find_columns(table, names).problems for table in find_tables(page, names))
    cells = sheet_cells(page, {})
    page = (chosen.down and turned(page)) or page
    table = chosen.table(page, names) if chosen else likely_table(page, names)
    first, last = page.row_number(max(table.first, 0)), page.row_number(max(table.last, 0))
    found = chosen.chosen.get("header", "") or (
        "none" if not any(table.texts) else f"{first}" if first == last else f"{first}-{last}"
    )
    columns = tuple(column_name(table, index) for index in range(page.width))
    below = (list(table.cells(index).values()) for index in range(page.width))
    examples = tuple(text_of(next(iter(filled), "")) for filled in below)
    asked = {role: columns[index] for role, index in (chosen.places(page) or Guess(table, names).roles).items()}
    shown = tuple(page.name for page in pages if page.name)
    return SheetLook(shown, page.name, cells, columns, examples, found, asked, understood)


def forget_sheet(source: str | Path | bytes, path: Path, name: str | None = None) -> None:
    """Delete the columns that are remembered at a path for sheets with this one's headings."""
    data, file = read_bytes(source, name)
    earlier = recalled(path, read_sheets(data, file, _score, is_word))
    if earlier is not None:
        forget_columns(path, earlier.key)


def read_several(
    sources: Iterable[tuple[str, str | Path | bytes]], controller: Controller, **choices: Any
) -> list[Readings]:
    """Return the readings of measuring sheets, each a name with a path or bytes; a name that comes again is numbered.

    ``choices`` are those of `read_readings`. The error is the first fault of any sheet, with all others below it.
    """
    sheets: list[Readings] = []
    faults: list[ReadingsError] = []
    counted: Counter[str] = Counter()
    for given, source in sources:
        counted[given] += 1
        name = given if counted[given] == 1 else f"{given} ({counted[given]})"  # of another folder
        try:
            sheets.append(read_readings(source, controller, name=name, **choices))
        except ReadingsError as fault:
            faults += fault.problems if isinstance(fault, ReadingsRefused) else [fault]
    if faults:
        raise faults_together(faults)
    return sheets
