"""What a sheet says of its readings: clearances and means beside them, corrections, of which unit and controller.

Titles, sheets and columns may name several transmissions or vehicles, and a line may void or correct readings.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from statistics import fmean

from atleak.catalogue.controller import Controller
from atleak.catalogue.entries import catalogue_files
from atleak.common.errors import Message, OtherControllerError, Place, ReadingsError
from atleak.common.sentences import Option, Sentence, all_of, counted
from atleak.common.units import Unit
from atleak.common.units import unit as unit_named
from atleak.measurements.readings import Reading
from atleak.readers.cells.sheet import Cell, Sheet, rows_named
from atleak.readers.sheets.column_headings import unit_of_heading
from atleak.readers.sheets.columns import Columns
from atleak.readers.sheets.diameters import DiameterCell
from atleak.readers.sheets.mapping import SheetMapping, rows_role, rows_said
from atleak.readers.sheets.rows import SheetRows
from atleak.readers.sheets.table import HeadedTable, is_single
from atleak.readers.sheets.words import (
    Words,
    is_blank,
    letters,
    part_of,
    plain,
    sheet_vocabulary,
    stated_number,
    text_of,
)

_ROUNDED = 1.5e-6  # [m] by which a clearance or mean of rounded diameters may differ from theirs
_SHOWN = 5  # rows that are named one by one
_PAIRS = 400  # at most so many pairs of diameters are compared with a clearance
_TEMPERATURES = 3  # of a column that are named
_UNITS = [unit_named(name, "length") for name in ("mm", "µm", "inch")]  # that a clearance without a unit may be in
_CONTROLLER = re.compile(
    r"\b(?:controller|schieberkasten|sterownik)\b[\s:=]*([A-Za-z0-9]+(?:[_-][A-Za-z0-9]+)+)?", re.IGNORECASE
)
# the line that the measuring forms of atleak bear, and at the very head what is typed at the bench: any id, also hv3
_OF_A_FORM = re.compile(
    r"(?:Controller|Schieberkasten|Sterownik(?: hydrauliczny)?) ([a-z0-9][a-z0-9_]*)(?:\. (?:Yellow|Gelbe|Wypełnia) |$)"
)
_ID = re.compile(r"[A-Za-z0-9]+(?:[_-][A-Za-z0-9]+)+")


def agreement_messages(
    table: HeadedTable, columns: Columns, entries: Sequence[DiameterCell], readings: Sequence[Reading]
) -> Iterator[Message]:
    """Yield a message for each clearance or mean that contradicts its diameters, and each correction not applied."""
    by_place = {reading.place: reading for reading in readings}
    numbers = _StatedNumbers(table, defaultdict(list), defaultdict(list))
    for entry in entries:
        reading = by_place.get(entry.raw.place)
        if reading is not None:
            numbers.rows[entry.row].append(reading)
            numbers.lands[reading.component, reading.plane].append(reading)
    for index in range(table.sheet.width):
        words = letters(table.heading(index))
        if index in columns.read or not words:
            continue
        is_clearance = words.any("clearance") and not words.any("not_of_these", "of_specification")
        if is_clearance or words.any("wear"):
            yield from numbers.of_one_part(index, readings)
        if is_clearance:
            yield from numbers.warnings(index, "clearance", numbers.clearances(index, words.any("radial")))
        elif _is_correction(words):
            yield from _correction(table, index, numbers.rows, columns)
        elif any(column.index == index for column in table.of("mean")):
            yield from numbers.warnings(index, "mean", numbers.means(index))
    yield from _correction_above(table)


Contradiction = tuple[int, Sentence, Sentence]  # row, what is stated, what follows from the diameters


@dataclass(frozen=True)
class _StatedNumbers:
    table: HeadedTable
    rows: dict[int, list[Reading]]
    lands: dict[tuple[str, str], list[Reading]]

    def stated(self, index: int) -> Iterator[tuple[int, list[Reading], float, Unit | None]]:
        _, unit = unit_of_heading(self.table.heading(index))
        for row, readings in self.rows.items():
            stated = stated_number(self.table.sheet.cell(row, index))
            if stated is not None:
                yield row, readings, stated[0], stated[1] or unit

    def warnings(self, index: int, what: str, disagreeing: Iterator[Contradiction]) -> Iterator[Message]:
        contradictions, heading = list(disagreeing), self.table.heading(index)
        for row, stated, computed in contradictions[:_SHOWN]:
            text = Sentence(
                "row {row}: column {heading!r} says {stated}, and the diameters make {computed}: a slip in one of them"
            )
            text = text.of(row=self.table.sheet.row_number(row), heading=heading, stated=stated, computed=computed)
            yield Message("warning", f"{what}_disagrees", text, self.table.sheet.place(row, index, heading))
        if (more := len(contradictions) - _SHOWN) > 0:
            text = counted(
                more,
                "{count} more row where column {heading!r} contradicts the diameters",
                "{count} more rows where column {heading!r} contradicts the diameters",
                heading=heading,
            )
            place = self.table.sheet.place(contradictions[_SHOWN][0], index, heading)
            yield Message("warning", f"{what}_disagrees", text, place)

    def clearances(self, index: int, radial: bool) -> Iterator[Contradiction]:
        """Yield the clearances that are not those of the diameters: radial, or where nothing says so diametral too."""
        for row, readings, value, unit in self.stated(index):
            beside = readings
            if len({reading.part for reading in readings}) < 2:
                beside = self.lands[readings[0].component, readings[0].plane]
            differences = _differences(beside)
            units = [unit] if unit else _UNITS
            sizes = [difference * share for difference in differences for share in ((0.5,) if radial else (1.0, 0.5))]
            if not differences or any(
                abs(value * scale.factor - size) <= _rounded(value, scale) for scale in units for size in sizes
            ):
                continue
            difference, unit_name = units[0].from_si(differences[0] * (0.5 if radial else 1.0)), units[0].said
            computed = Sentence("{size:.6g} {unit}", size=difference, unit=unit_name)
            yield row, Sentence("{size:g} {unit}", size=value, unit=unit_name), computed

    def means(self, index: int) -> Iterator[Contradiction]:
        parts = {part_of(word) for word in letters(self.table.heading(index)) if len(word) > 2} - {None}
        for row, readings, value, stated in self.stated(index):
            unit = stated or _UNITS[0]
            wanted = [reading for reading in readings if len(parts) != 1 or reading.part in parts]
            means = [fmean(sizes) for reading in wanted for sizes in self._sets(reading, wanted)]
            if means and not any(abs(value * unit.factor - mean) <= _rounded(value, unit) for mean in means):
                sizes = (value, unit.from_si(means[0]))
                written, expected = (Sentence("{size:.7g} {unit}", size=size, unit=unit.said) for size in sizes)
                yield row, written, expected

    def _sets(self, reading: Reading, beside: Sequence[Reading]) -> Iterator[list[float]]:
        same = [other for other in self.lands[reading.component, reading.plane] if other.part == reading.part]
        in_row = [other.diameter for other in beside if other.part == reading.part]
        if len(in_row) > 1:
            yield in_row
        yield [other.diameter for other in same if other.direction == reading.direction]
        yield [other.diameter for other in same]
        yield in_row
        yield [other.diameter for other in beside]

    def of_one_part(self, index: int, readings: Sequence[Reading]) -> Iterator[Message]:
        """Tell of a clearance or wear that is all a sheet says of a part without a diameter: it is not used."""
        parts: dict[tuple[str, str], set[str]] = defaultdict(set)
        for reading in readings:
            parts[reading.component, reading.plane].add(reading.part)
        rows = [
            row
            for row, beside, *_ in self.stated(index)
            if all(len(parts[reading.component, reading.plane]) == 1 for reading in beside)
        ]
        if not rows:
            return
        heading = self.table.heading(index)
        text = Sentence(
            "column {heading!r} is not used in {rows}, where only one part was measured: the other part counts with "
            "its nominal diameter",
            heading=heading,
            rows=rows_named(self.table.sheet, rows),
        )
        yield Message("warning", "clearance_not_used", text, self.table.sheet.place(rows[0], index, heading))


def temperatures(table: HeadedTable, columns: Columns, rows: Collection[int]) -> Iterator[Message]:
    """Tell of a column of temperatures of measuring: only the head's is taken, so 20 °C would be assumed."""
    for index in range(table.sheet.width):
        words = letters(table.heading(index))
        named = words.any("temperature") and words.only("temperature", "beside_head", "degree")
        cells = table.cells(index) if named and index not in columns.read else {}
        values = tuple(dict.fromkeys(text_of(cell) for row, cell in cells.items() if row in rows))
        if values:
            text = Sentence(
                "column {heading!r} says {values}{more} and is not read: 20 °C counts unless the head of the sheet or "
                "the job states the temperature of measuring, as in 'Temperature: 21.5 °C' or --measuring-temperature",
                heading=table.heading(index),
                values=values[:_TEMPERATURES],
                more=" …" if len(values) > _TEMPERATURES else "",
            )
            yield Message("warning", "temperature_not_read", text, table.heading_place(index))


def _differences(readings: Sequence[Reading]) -> list[float]:
    spools, sleeves = (
        [reading.diameter for reading in readings if reading.part == part] for part in ("spool", "sleeve")
    )
    if not spools or not sleeves:
        return []
    differences = [fmean(sleeves) - fmean(spools), min(sleeves) - max(spools), max(sleeves) - min(spools)]
    if len(spools) * len(sleeves) <= _PAIRS:
        differences += [sleeve - spool for sleeve in sleeves for spool in spools]
    return differences


def _rounded(value: float, unit: Unit) -> float:
    """Return how far rounding may move a stated number away from that of the diameters [m]."""
    decimals = len(f"{value:.6f}".rstrip("0").partition(".")[2])
    return max(0.5 * 10.0**-decimals * unit.factor if decimals else 0.0, _ROUNDED) + 1e-9


def _is_correction(words: Words) -> bool:
    of_gauge = not {"gauge", "ring"}.isdisjoint(words) and words.any("error")
    is_error = words.any("error") or words.only("zero", "beside_zero", "error", "correction")
    correction = of_gauge or (words.any("zero") and is_error) or words.any("correction")
    return correction and not words.any("corrected")


def _correction(table: HeadedTable, index: int, rows: Collection[int], columns: Columns) -> Iterator[Message]:
    read = [column.heading for group in columns.groups for column in group.values()]
    numbers = {row: stated_number(table.sheet.cell(row, index)) for row in rows}
    stated = {row: number[0] for row, number in numbers.items() if number is not None and number[0]}
    if not stated or any(letters(heading).any("corrected") for heading in read):
        return
    row = max(stated, key=lambda row: abs(stated[row]))
    heading = table.heading(index)
    text = counted(
        len(stated),
        "column {heading!r} is not zero in {count} row (up to {largest:g}, row {row}): it was not applied to the "
        "diameters",
        "column {heading!r} is not zero in {count} rows (up to {largest:g}, row {row}): it was not applied to the "
        "diameters",
        heading=heading,
        largest=stated[row],
        row=table.sheet.row_number(row),
    )
    yield Message("warning", "correction_not_applied", text, table.sheet.place(row, index, heading))


def _correction_above(table: HeadedTable) -> Iterator[Message]:
    for row in range(max(table.first, 0)):
        for index, cell in enumerate(table.sheet.rows[row]):
            if not isinstance(cell, str) or not _is_correction(letters(re.sub(r"[\d.,+\-−]+", " ", cell))):
                continue
            amount = re.search(r"[+\-−]?\d+(?:[.,]\d+)?\s*(?:µm|um|μm|mm)\b", cell)
            beside = table.sheet.cell(row, index + 1)
            value = amount[0] if amount else "" if is_blank(beside) else text_of(beside)
            if re.search(r"[1-9]", value):
                text = Sentence(
                    "above the table stands {said!r}{value}: it was not applied to the diameters",
                    said=" ".join(cell.split())[:80],
                    value="" if amount else f" {value[:20]}",
                )
                yield Message("warning", "correction_not_applied", text, table.sheet.place(row, index))


def other_controller(
    table: HeadedTable, controller: Controller, made_for: str | None = None
) -> OtherControllerError | None:
    """Return an error where the head of the sheet names another controller than the one it is read for.

    ``made_for`` is the id of one from which this one was copied, and which the head may name as well.
    """
    sheet, catalogue = table.sheet, {plain(name) for name in catalogue_files("controllers")}
    mine = {plain(name) for name in (controller.id, controller.name, made_for) if name is not None}
    for row in range(max(table.first, 0)):
        for index, cell in enumerate(sheet.rows[row]):
            match = _CONTROLLER.search(cell) if isinstance(cell, str) else None
            named, sure = _by_model(cell, catalogue, mine), False
            if match is not None:
                form = _OF_A_FORM.match(cell)
                sure = form is not None and (form.end() < len(cell) or (row, index) == (0, 0))
                said = form[1] if form is not None and sure else match[1]
                if said is None and not cell[match.end() :].strip(" .:"):
                    beside = text_of(sheet.cell(row, index + 1))
                    said = beside if _ID.fullmatch(beside) else None
                named = said or named
            if named is None or plain(named) in mine or not (sure or plain(named) in catalogue or "_" in named):
                continue
            error = OtherControllerError(
                Sentence(
                    "the sheet was made for controller {named}, not for {controller}",
                    named=named,
                    controller=controller.id,
                ),
                place=sheet.place(row, index),
                value=" ".join(cell.split())[:80],
                expected=Sentence(
                    "that controller, chosen with --controller {named} (or the path of its file); or the line taken "
                    "out of the sheet",
                    named=named,
                ),
            )
            error.named = named
            return error
    return None


def _by_model(cell: Cell, catalogue: Collection[str], mine: Collection[str]) -> str | None:
    """Return the one other controller of the catalogue whose id holds a model that a cell names: "AW55", "4L60E"."""
    words = set(re.findall(r"[^\W_]+", plain(cell))) if isinstance(cell, str) else set()
    models = {word for word in words if len(word) > 3 and not word.isalpha() and not word.isdigit()}
    own = {word for name in mine for word in re.findall(r"[^\W_]+", name)}
    named = [name for name in catalogue if name not in mine and not models.isdisjoint(name.split("_"))]
    return named[0] if len(named) == 1 and models.isdisjoint(own) else None


_NAMED = re.compile(r"([^\W\d_]{3,})[\s:#._-]*(?:(?i:no|nr|number|n°)\b[\s.:#]*)?([A-Z](?![\w])|[\w./-]*\d[\w./-]*)")
_LISTED = 4  # values of a column that are named


@dataclass(frozen=True)
class _UnitName:
    """What a text says of the unit that readings under it are of: by which word, which one, and where it stands."""

    word: str
    which: str
    text: str
    place: Place
    is_sheet: bool


def units_apart(read: Sequence[SheetRows], said: SheetMapping) -> list[ReadingsError]:
    """Return the error where titles, names of sheets or a column call what is read more than one unit.

    What of a title is ``said`` to be the name of a valve tells no unit. The parts of two units fit each other well
    enough to pass for one: nothing else would show it.
    """
    by_word: dict[str, dict[str, _UnitName]] = defaultdict(dict)
    for rows in read:
        for unit_name in _titles(rows, said):
            by_word[unit_name.word].setdefault(unit_name.which, unit_name)
    for named in by_word.values():
        if len(named) > 1:
            return [_by_titles(list(named.values()))]
    column = _by_column(read)
    return [] if column is None else [column]


def _titles(rows: SheetRows, said: SheetMapping) -> Iterator[_UnitName]:
    sheet = rows.table.sheet
    last = max(entry.row for entry in rows.entries)
    lines = [row for row in range(rows.table.last + 1, last) if is_single(sheet, row)]
    texts = [(" ".join(map(text_of, sheet.rows[row])).strip(), sheet.place(row), False) for row in lines]
    texts.append((rows.table.title, sheet.place(max(rows.table.first - 1, 0)), False))
    for text, place, is_sheet in (*texts, (sheet.name or "", sheet.place(), True)):
        for match in _NAMED.finditer(said.without_names(text)):
            if plain(match[1]) in sheet_vocabulary("whole_unit"):
                yield _UnitName(plain(match[1]), match[2].strip("./-"), text, place, is_sheet)


def _by_titles(named: Sequence[_UnitName]) -> ReadingsError:
    expected = Sentence(
        "the readings of one unit: delete or hide the other ones; or one name over all, if it is one unit"
    )
    if all(unit_name.is_sheet for unit_name in named):
        expected = Sentence(
            "one: say which sheet, as in {option}; or one name for all, if it is one unit",
            option=Option("sheet", f'"{named[0].text}"'),
        )
    return ReadingsError(
        Sentence(
            "the readings are of several units, by their titles: {titles}",
            titles=all_of(Sentence("{said!r}", said=unit_name.text) for unit_name in named),
        ),
        place=named[1].place,
        value=named[1].text,
        expected=expected,
    )


def _by_column(read: Sequence[SheetRows]) -> ReadingsError | None:
    values: dict[str, dict[str, set[tuple[str, ...]]]] = defaultdict(lambda: defaultdict(set))
    places: dict[str, Place] = {}
    for rows in read:
        sheet = rows.table.sheet
        for index in rows.table.span:
            heading = rows.table.heading(index)
            words = letters(heading)
            of_unit = words.any("whole_unit", "head_vehicle", "head_vin", "head_serial")
            of_others = words.any("part", "gauge", "head_instrument")  # whose serial number tells no units apart
            if index in rows.columns.read or not of_unit or of_others or any(map(part_of, words)):
                continue
            places.setdefault(heading, rows.table.heading_place(index))
            for entry in rows.entries:
                cell = sheet.filled(entry.row, index)
                if not is_blank(cell) and plain(text_of(cell)) != plain(entry.key.component):
                    values[heading][text_of(cell)].add((entry.key.component, entry.key.part, entry.key.plane))
    for heading, stations in values.items():
        # where every value stands at one part of one component, it is the number of a part, or of a row
        of_parts = len(stations) > 2 and all(len({station[0] for station in stood}) == 1 for stood in stations.values())
        if len(stations) > 1 and not of_parts:
            chosen = next(iter(stations))
            return ReadingsError(
                Sentence("column {heading!r} names several units, whose parts would be put together", heading=heading),
                place=places[heading],
                value=", ".join(list(stations)[:_LISTED]) + (" …" if len(stations) > _LISTED else ""),
                expected=Sentence(
                    "the rows of one unit, as in {option}; or a heading such as 'Part number', if it is one unit",
                    option=Option("where", f'"{heading}={chosen}"'),
                ),
            )
    return None


_SMALL = re.compile(r"(?<![\d.,])[+\-−]?0?[.,]\d{2,}|\d\s*(?:[µμu]m|microns?|mils?|thou)\b")
_CODE = re.compile(r"(?<!\w)(\w{1,3})\s*[=:–—-]")


def lines_that_change(sheet: Sheet, every: Sequence[SheetRows], said: SheetMapping) -> Iterator[ReadingsError]:
    """Yield the problems of lines that say how readings are to be corrected, or that a code beside them voids them.

    The rows that count settle it: without such a line, and without the rows of such a code.
    """
    read = [rows for rows in every if rows.table.sheet.name == sheet.name and not rows.table.sheet.turned]
    passed = {row for rows in read for row in rows.of_row} | said.leaves_out(sheet)
    first = min((rows.table.first for rows in read), default=0)
    for row, cells in enumerate(sheet.rows if read else ()):
        text = ("," if sheet.is_text else " ").join(text_of(cell) for cell in cells).strip(" ,")
        words = letters(text) if row not in passed else Words()
        void: set[int] = set()
        problem = Sentence("this line may say that readings are not meant as they stand")
        if words.any("counts_not"):
            codes = {plain(code) for code in _CODE.findall(text)}
            unread = [(rows, at) for rows in read for at in rows.table.span if at not in rows.columns.read]
            void = {
                line
                for rows, at in unread
                for line in rows.of_row
                if plain(text_of(rows.table.sheet.filled(line, at))) in codes
            }
            problem = Sentence("by this line some readings do not count")
        elif (_is_correction(words) and row > first) or words.any("changes_readings"):
            told = row < first and _is_correction(words)  # as one that was not applied
            is_small = any(re.search("[1-9]", number) for number in _SMALL.findall(text))
            void = {row} if is_small and not told and not words.any("corrected") else set()
        if void:
            others = rows_said(sheet.row_number(at) for at in range(len(sheet.rows)) if at not in void | {row})
            expected = Sentence(
                "corrected readings, or ones that hold as they stand; then the rows that count, without this line: "
                "{option}",
                option=Option("map", f'"{rows_role(sheet.name)}={others}"'),
            )
            yield ReadingsError(problem, place=sheet.place(row), value=text[:80], expected=expected)
