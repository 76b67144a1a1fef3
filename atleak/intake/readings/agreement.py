"""What a sheet says twice: clearances and means beside the diameters, corrections, the controller at its head."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Collection, Iterator, Sequence
from statistics import fmean

from atleak.catalogue.controller import Controller
from atleak.catalogue.entries import catalogue_files
from atleak.errors import Message, OtherControllerError, ReadingsError
from atleak.intake.readings.columns import Columns
from atleak.intake.readings.headings import Header
from atleak.intake.readings.sheet_tables import Table
from atleak.intake.readings.values import DiameterCell
from atleak.intake.readings.words import (
    BESIDE_ZERO,
    CLEARANCES,
    CORRECTED,
    CORRECTIONS,
    ERRORS,
    NOT_MEASURED,
    RADIAL,
    WEAR,
    ZERO,
    is_blank,
    letters,
    number,
    part_of,
    plain,
    text_of,
    vocabulary,
)
from atleak.intake.sheets.sheet import Sheet, rows_named
from atleak.intake.units import Unit, find_unit
from atleak.readings import Reading
from atleak.sentence import Sentence

_ROUNDED = 1.5e-6  # [m] by which a clearance or mean of rounded diameters may differ from theirs
_SHOWN = 5  # rows that are named one by one
_PAIRS = 400  # at most so many pairs of diameters are compared with a clearance
_TEMPERATURES = 3  # of a column that are named
_TEMPERATURE = vocabulary("temperature")
_BESIDE_TEMPERATURE = vocabulary("temperature", "beside_head", "degree")
_UNITS = ("mm", "µm", "inch")  # that a clearance without a unit may be in
_CONTROLLER = re.compile(
    r"\b(?:controller|schieberkasten|sterownik)\b[\s:=]*([A-Za-z0-9]+(?:[_-][A-Za-z0-9]+)+)?", re.IGNORECASE
)
# the line that the measuring forms of atleak bear, and at the very head what is typed at the bench: any id, also hv3
_OF_A_FORM = re.compile(
    r"(?:Controller|Schieberkasten|Sterownik(?: hydrauliczny)?) ([a-z0-9][a-z0-9_]*)(?:\. (?:Yellow|Gelbe|Wypełnia) |$)"
)
_ID = re.compile(r"[A-Za-z0-9]+(?:[_-][A-Za-z0-9]+)+")


def messages(
    table: Table, columns: Columns, entries: Sequence[DiameterCell], readings: Sequence[Reading]
) -> Iterator[Message]:
    """Yield a message for each clearance or mean that contradicts its diameters, and each correction not applied."""
    sheet, header = table.sheet, table.header
    by_place = {reading.place: reading for reading in readings}
    rows: dict[int, list[Reading]] = defaultdict(list)
    lands: dict[tuple[str, str], list[Reading]] = defaultdict(list)
    for entry in entries:
        reading = by_place.get(entry.raw.place)
        if reading is not None:
            rows[entry.row].append(reading)
            lands[reading.component, reading.plane].append(reading)
    for index in range(sheet.width):
        heading = header.text(index)
        words = letters(heading)
        if index in columns.read or not words:
            continue
        unit = _unit(heading)
        is_clearance = any(word in CLEARANCES for word in words) and not any(word in NOT_MEASURED for word in words)
        if is_clearance or any(word in WEAR for word in words):
            yield from _of_one_part(sheet, index, heading, rows, readings)
        if is_clearance:
            radial = any(word in RADIAL for word in words)
            contradictions = list(_clearances(sheet, index, rows, lands, unit, radial))
            yield from _warnings(sheet, index, heading, contradictions, "clearance")
        elif _is_correction(words):
            yield from _correction(sheet, header, index, rows, columns)
        elif any(column.index == index and column.role == "mean" for column in header.columns):
            contradictions = list(_means(sheet, index, heading, rows, lands, unit))
            yield from _warnings(sheet, index, heading, contradictions, "mean")
    yield from _correction_above(sheet, header)


Contradiction = tuple[int, Sentence, Sentence]  # row, what is stated, what follows from the diameters


def _warnings(
    sheet: Sheet, index: int, heading: str, contradictions: Sequence[Contradiction], what: str
) -> Iterator[Message]:
    for row, stated, computed in contradictions[:_SHOWN]:
        yield Message(
            "warning",
            f"{what}_disagrees",
            Sentence(
                "row {row}: column {heading!r} says {stated}, and the diameters make {computed}: a slip in one of them",
                row=sheet.row_number(row),
                heading=heading,
                stated=stated,
                computed=computed,
            ),
            sheet.place(row, index, heading),
        )
    if len(contradictions) > _SHOWN:
        more = len(contradictions) - _SHOWN
        text = Sentence(
            "{count} more row where column {heading!r} contradicts the diameters", count=more, heading=heading
        )
        if more > 1:
            text = Sentence(
                "{count} more rows where column {heading!r} contradicts the diameters", count=more, heading=heading
            )
        yield Message(
            "warning",
            f"{what}_disagrees",
            text,
            sheet.place(contradictions[_SHOWN][0], index, heading),
        )


def _unit(heading: str) -> Unit | None:
    for bracketed in re.finditer(r"[\[\(]([^\[\]\(\)]+)[\]\)]", heading):
        unit = find_unit(bracketed[1].strip(), "length")
        if unit is not None:
            return unit
    words = plain(heading).replace("_", " ").replace(",", " ").split()
    return find_unit(words[-1], "length") if words and words[-1] in {"mm", "um", "µm", "μm", "inch"} else None


def _stated(sheet: Sheet, row: int, index: int) -> tuple[float, Unit | None] | None:
    cell = sheet.cell(row, index)
    if is_blank(cell):
        return None
    try:
        return number(cell)
    except ReadingsError:
        return None


def _clearances(
    sheet: Sheet,
    index: int,
    rows: dict[int, list[Reading]],
    lands: dict[tuple[str, str], list[Reading]],
    unit: Unit | None,
    radial: bool,
) -> Iterator[Contradiction]:
    for row, readings in rows.items():
        stated = _stated(sheet, row, index)
        if stated is None:
            continue
        beside = readings
        if len({reading.part for reading in readings}) < 2:
            beside = lands[readings[0].component, readings[0].plane]
        known = _differences(beside)
        if not known:
            continue
        value, written = stated
        units = [each for each in (written or unit, *(() if written or unit else map(_length, _UNITS))) if each]
        sizes = [difference * share for difference in known for share in ((0.5,) if radial else (1.0, 0.5))]
        if any(abs(value * each.factor - size) <= _rounded(value, each) for each in units for size in sizes):
            continue
        shown = units[0]
        difference = known[0] * (0.5 if radial else 1.0)
        computed = Sentence("{size:.6g} {unit}", size=shown.from_si(difference), unit=shown.said)
        yield row, Sentence("{size:g} {unit}", size=value, unit=shown.said), computed


def _of_one_part(
    sheet: Sheet, index: int, heading: str, rows: dict[int, list[Reading]], readings: Sequence[Reading]
) -> Iterator[Message]:
    """Tell of a clearance or wear that is all a sheet says of a part without a diameter: it is not used."""
    parts: dict[tuple[str, str], set[str]] = defaultdict(set)
    for reading in readings:
        parts[reading.component, reading.plane].add(reading.part)
    stated = {
        row: value
        for row, beside in rows.items()
        if all(len(parts[each.component, each.plane]) == 1 for each in beside)
        and (value := _stated(sheet, row, index)) is not None
    }
    if not stated:
        return
    unit = next((written for _, written in stated.values() if written), None) or _unit(heading)
    sizes = sorted(size for size, _ in stated.values())
    said = Sentence("{size:g}", size=sizes[0])
    if sizes[-1] > sizes[0]:
        said = Sentence("{low:g} to {high:g}", low=sizes[0], high=sizes[-1])
    text = Sentence(
        "column {heading!r} says {said}{unit} in {rows}, where only one part was measured: it is not used, and the "
        "other part counts with its nominal diameter",
        heading=heading,
        said=said,
        unit=Sentence(" {unit}", unit=unit.said) if unit else "",
        rows=rows_named(sheet, list(stated)),
    )
    yield Message("warning", "clearance_not_used", text, sheet.place(next(iter(stated)), index, heading))


def temperatures(table: Table, columns: Columns, rows: Collection[int]) -> Iterator[Message]:
    """Tell of a column of temperatures of measuring: only the head's is taken, so 20 °C would be assumed."""
    sheet, header = table.sheet, table.header
    for index in range(sheet.width):
        heading = header.text(index)
        words = letters(heading)
        named = any(word in _TEMPERATURE for word in words) and all(word in _BESIDE_TEMPERATURE for word in words)
        cells = [cell for row in rows if named and not is_blank(cell := sheet.cell(row, index))]
        if index in columns.read or not cells:
            continue
        values = tuple(dict.fromkeys(text_of(cell) for cell in cells))
        text = Sentence(
            "column {heading!r} says {values}{more} and is not read: 20 °C counts unless the head of the sheet or the "
            "job states the temperature of measuring, as in 'Temperature: 21.5 °C' or --measuring-temperature",
            heading=heading,
            values=values[:_TEMPERATURES],
            more=" …" if len(values) > _TEMPERATURES else "",
        )
        yield Message("warning", "temperature_not_read", text, sheet.place(max(header.last, 0), index, heading))


def _differences(readings: Sequence[Reading]) -> list[float]:
    """Return D − d [m] of the means, then of single readings; nothing where one part is missing."""
    spools, sleeves = (
        [reading.diameter for reading in readings if reading.part == part] for part in ("spool", "sleeve")
    )
    if not spools or not sleeves:
        return []
    differences = [fmean(sleeves) - fmean(spools), min(sleeves) - max(spools), max(sleeves) - min(spools)]
    if len(spools) * len(sleeves) <= _PAIRS:
        differences += [sleeve - spool for sleeve in sleeves for spool in spools]
    return differences


def _length(name: str) -> Unit | None:
    return find_unit(name, "length")


def _rounded(value: float, unit: Unit) -> float:
    """Return how far rounding may move a stated number away from that of the diameters [m]."""
    decimals = len(f"{value:.6f}".rstrip("0").partition(".")[2])
    return max(0.5 * 10.0**-decimals * unit.factor if decimals else 0.0, _ROUNDED) + 1e-9


def _means(
    sheet: Sheet,
    index: int,
    heading: str,
    rows: dict[int, list[Reading]],
    lands: dict[tuple[str, str], list[Reading]],
    unit: Unit | None,
) -> Iterator[Contradiction]:
    parts = {part_of(word) for word in letters(heading) if len(word) > 2} - {None}
    for row, readings in rows.items():
        stated = _stated(sheet, row, index)
        if stated is None:
            continue
        value, written = stated
        stated_unit = written or unit or _length("mm")
        wanted = [reading for reading in readings if len(parts) != 1 or reading.part in parts]
        if not wanted or stated_unit is None:
            continue
        sets = [means for reading in wanted for means in _sets(reading, wanted, lands)]
        if any(abs(value * stated_unit.factor - fmean(each)) <= _rounded(value, stated_unit) for each in sets):
            continue
        sizes = (value, stated_unit.from_si(fmean(sets[0])))
        said, expected = (Sentence("{size:.7g} {unit}", size=size, unit=stated_unit.said) for size in sizes)
        yield row, said, expected


def _sets(
    reading: Reading, beside: Sequence[Reading], lands: dict[tuple[str, str], list[Reading]]
) -> Iterator[list[float]]:
    """Yield the diameters that this mean may be of: of its row, direction, plane; the closest first."""
    same = [each for each in lands[reading.component, reading.plane] if each.part == reading.part]
    in_row = [each.diameter for each in beside if each.part == reading.part]
    direction = [each.diameter for each in same if each.direction == reading.direction]
    if len(in_row) > 1:
        yield in_row
    yield direction
    yield [each.diameter for each in same]
    yield in_row
    yield [each.diameter for each in beside]


# --- corrections ------------------------------------------------------------------------------------------------------


def _is_correction(words: Sequence[str]) -> bool:
    of_gauge = {"gauge", "ring"} & set(words) and any(word in ERRORS for word in words)
    is_error = any(word in ERRORS for word in words) or all(word in BESIDE_ZERO for word in words)
    of_zero = any(word in ZERO for word in words) and is_error
    correction = bool(of_gauge) or of_zero or any(word in CORRECTIONS for word in words)
    return correction and not any(word in CORRECTED for word in words)


def _correction(sheet: Sheet, header: Header, index: int, rows: Collection[int], columns: Columns) -> Iterator[Message]:
    read = [column.heading for group in columns.groups for column in group.values()]
    if any(word in CORRECTED for heading in read for word in letters(heading)):
        return
    nonzero = [(row, stated[0]) for row in rows if (stated := _stated(sheet, row, index)) is not None and stated[0]]
    if nonzero:
        row, largest = max(nonzero, key=lambda each: abs(each[1]))
        heading = header.text(index)
        said = {"heading": heading, "count": len(nonzero), "largest": largest, "row": sheet.row_number(row)}
        text = Sentence(
            "column {heading!r} is not zero in {count} row (up to {largest:g}, row {row}): it was not applied to the "
            "diameters",
            **said,
        )
        if len(nonzero) > 1:
            text = Sentence(
                "column {heading!r} is not zero in {count} rows (up to {largest:g}, row {row}): it was not applied to "
                "the diameters",
                **said,
            )
        yield Message("warning", "correction_not_applied", text, sheet.place(row, index, heading))


def _correction_above(sheet: Sheet, header: Header) -> Iterator[Message]:
    for row in range(max(header.first, 0)):
        for index, cell in enumerate(sheet.rows[row]):
            if not isinstance(cell, str) or not _is_correction(letters(re.sub(r"[\d.,+\-−]+", " ", cell))):
                continue
            amount = re.search(r"[+\-−]?\d+(?:[.,]\d+)?\s*(?:µm|um|μm|mm)\b", cell)
            beside = sheet.cell(row, index + 1)
            value = amount[0] if amount else "" if is_blank(beside) else text_of(beside)
            if re.search(r"[1-9]", value):
                yield Message(
                    "warning",
                    "correction_not_applied",
                    Sentence(
                        "above the table stands {said!r}{value}: it was not applied to the diameters",
                        said=" ".join(cell.split())[:80],
                        value="" if amount else f" {value[:20]}",
                    ),
                    sheet.place(row, index),
                )


# --- the head of the sheet --------------------------------------------------------------------------------------------


def other_controller(
    sheet: Sheet, header: Header, controller: Controller, made_for: str | None = None
) -> OtherControllerError | None:
    """Return an error where the head of the sheet names another controller than the one it is read for.

    ``made_for`` is the id of one from which this one was copied, and which the head may name as well.
    """
    known = {plain(name) for name in catalogue_files("controllers")}
    mine = {plain(name) for name in (controller.id, controller.name, made_for) if name is not None}
    for row in range(max(header.first, 0)):
        for index, cell in enumerate(sheet.rows[row]):
            match = _CONTROLLER.search(cell) if isinstance(cell, str) else None
            if not isinstance(cell, str) or match is None:
                continue
            form = _OF_A_FORM.match(cell)
            sure = form is not None and (form.end() < len(cell) or (row, index) == (0, 0))
            named = form[1] if form is not None and sure else match[1]
            if named is None and not cell[match.end() :].strip(" .:"):
                beside = text_of(sheet.cell(row, index + 1))
                named = beside if _ID.fullmatch(beside) else None
            if named is None or plain(named) in mine:
                continue
            if not sure and plain(named) not in known and "_" not in named:
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
