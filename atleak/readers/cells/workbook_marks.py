"""Reads what cells alone do not show of an xlsx or ods: what its author hid, crossed out, coloured or commented on.

Merged ranges of an ods and formulas without a result of an xlsx are read too. Bytes in, plain data out.
"""

from __future__ import annotations

import io
import posixpath
import re
import zipfile
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import chain, islice
from typing import Literal
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

Hiding = Literal["by hand", "by a filter", "in a folded outline"]
CellRange = tuple[tuple[int, int], tuple[int, int]]  # first and last (row, column)

PART_LIMIT = 32_000_000  # bytes of one unpacked part; a measuring sheet is a hundredth of it
_LIST_LIMIT = 2_000_000  # of one that lists sheets, or relations
_COLUMNS = 16_384  # of a sheet
_WORDS = 300  # characters of a comment

_PLAIN = re.compile(r"|rgb (?:00|FF)(?:000000|FFFFFF)|theme [01]|indexed (?:8|9|64|65)|auto 1", re.IGNORECASE)
_REFERENCE = re.compile(r"([A-Z]{1,3})(\d{1,9})", re.IGNORECASE)
_AREA = re.compile(r"\$?[A-Z]{1,3}\$?(\d{1,7}):\$?[A-Z]{1,3}\$?(\d{1,7})")
_YES = {"1", "true"}
_TABLE = "{urn:oasis:names:tc:opendocument:xmlns:table:1.0}"
_STYLE = "{urn:oasis:names:tc:opendocument:xmlns:style:1.0}"
_OFFICE = "{urn:oasis:names:tc:opendocument:xmlns:office:1.0}"
_TEXT_OF = "{urn:oasis:names:tc:opendocument:xmlns:text:1.0}"


@dataclass(frozen=True)
class Marks:
    """What stands on one sheet besides its values; rows and columns count from 0.

    A row hidden in several ways counts as hidden by the filter. Colours are those of a filled cell's ground and
    letters as the file writes them, to tell cells apart; of cells that have those of an empty sheet there are none.
    """

    hidden_rows: dict[int, Hiding] = field(default_factory=dict)
    hidden_columns: frozenset[int] = frozenset()
    struck: frozenset[tuple[int, int]] = frozenset()  # cells crossed out
    colours: dict[tuple[int, int], str] = field(default_factory=dict)
    comments: dict[tuple[int, int], str] = field(default_factory=dict)
    faults: dict[tuple[int, int], str] = field(default_factory=dict)  # formulas with an error or no stored result
    merged: list[CellRange] = field(default_factory=list)  # of an ods alone


def marks(data: bytes) -> dict[str, Marks]:
    """Return the marks on each sheet of an xlsx or ods, by its name; empty for other files.

    A damaged file raises `zipfile.BadZipFile` or `ElementTree.ParseError`.
    """
    if not data.startswith(b"PK"):
        return {}
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        names = set(archive.namelist())
        return _xlsx(archive, names) if "xl/workbook.xml" in names else _ods(_root(archive, "content.xml"))


def column_index(letters: str) -> int:
    """Return a column's letters as a number from 0.

    >>> column_index("A"), column_index("AB")
    (0, 27)
    """
    return sum((ord(letter) - 64) * 26**power for power, letter in enumerate(reversed(letters))) - 1


def whole_number(text: str) -> int:
    """Return the number that an attribute of a workbook's XML states; where it is none, the XML counts as damaged."""
    try:
        return int(text)
    except ValueError as error:
        raise ElementTree.ParseError(f"{text[:20]!r} is no whole number") from error


def unpacked_part(archive: zipfile.ZipFile, name: str, limit: int | None = None) -> bytes:
    """Return the content of a part of a workbook, which counts as damaged where it unpacks to more than the limit."""
    limit = PART_LIMIT if limit is None else limit
    with archive.open(name) as part:
        content = part.read(limit + 1)
    if len(content) > limit:
        raise zipfile.BadZipFile(f"{name} unpacks to more than {limit // 1_000_000} MB")
    return content


def _root(archive: zipfile.ZipFile, name: str, limit: int | None = None) -> Element:
    """Return the XML of a part of a workbook; an empty element where it has no such part."""
    with suppress(KeyError):
        return ElementTree.fromstring(unpacked_part(archive, name, limit))
    return Element("")


def sheet_paths(archive: zipfile.ZipFile) -> dict[str, str]:
    """Return the part of the archive that holds each sheet of an xlsx, by the sheet's name."""
    targets = dict(_targets(archive, "xl/workbook.xml"))
    paths = {}
    for element in _root(archive, "xl/workbook.xml", _LIST_LIMIT).iter():
        if _name(element) == "sheet":
            relation = next((value for key, value in element.attrib.items() if key.endswith("}id")), "")
            paths[element.get("name", "")] = targets.get(relation, "xl")
    return paths


def _targets(archive: zipfile.ZipFile, part: str) -> Iterator[tuple[str, str]]:
    """Yield what a part of an xlsx refers to: the id of each relation and the part it leads to."""
    folder, name = posixpath.split(part)
    for relation in _root(archive, f"{folder}/_rels/{name}.rels", _LIST_LIMIT):
        target = relation.get("Target", "")
        path = target.lstrip("/") if target.startswith("/") else posixpath.normpath(f"{folder}/{target}")
        yield relation.get("Id", ""), path


def _xlsx(archive: zipfile.ZipFile, names: set[str]) -> dict[str, Marks]:
    struck, coloured = _styles(_root(archive, "xl/styles.xml"))
    runs = ([run for run in text if _name(run) == "r"] for text in _root(archive, "xl/sharedStrings.xml"))
    struck_texts = {number for number, each in enumerate(runs) if each and all(map(_is_struck, each))}
    return {
        sheet: _xlsx_sheet(archive, path, struck, coloured, struck_texts)
        for sheet, path in sheet_paths(archive).items()
        if path in names
    }


def _xlsx_sheet(
    archive: zipfile.ZipFile, path: str, struck: set[int], coloured: dict[int, str], struck_texts: set[int]
) -> Marks:
    parts = [target for _, target in _targets(archive, path)]
    tables = [_root(archive, part) for part in parts if "/tables/" in f"/{part}"]
    filters = [_filter(element) for table in tables for element in table.iter() if _name(element) == "autoFilter"]
    folded: dict[int, bool] = {}  # hidden rows, and whether they stand in an outline
    columns: list[range] = []
    found = Marks(comments=dict(_comments(archive, parts)))
    crossed = set[tuple[int, int]]()
    row = -1
    for event, element in ElementTree.iterparse(io.BytesIO(unpacked_part(archive, path)), ("start", "end")):
        kind = _name(element)
        if event == "start":
            if kind == "row":
                row = whole_number(element.get("r", str(row + 2))) - 1
                if element.get("hidden") in _YES:
                    folded[row] = element.get("outlineLevel", "0") != "0"
            continue
        if kind == "c" and (place := place_of_cell(element.get("r", ""))) is not None:
            parts_of_cell = {_name(part): part for part in element}
            value = next((part.text for part in element.iter() if _name(part) in ("v", "t") and part.text), None)
            style, type_ = whole_number(element.get("s", "0")), element.get("t")
            runs = [part for part in element.iter() if _name(part) == "r"]
            shared = type_ == "s" and (value or "").isdigit() and int(value or 0) in struck_texts
            if style in struck or shared or (runs and all(map(_is_struck, runs))):
                crossed.add(place)
            if style in coloured and parts_of_cell.keys() & {"v", "f", "is"}:
                found.colours[place] = coloured[style]
            formula = parts_of_cell.get("f")
            if type_ == "e":
                found.faults[place] = value or "an error"
            elif formula is not None and not value and type_ != "str":  # an empty text is a result too
                found.faults[place] = f"={formula.text or ''}"
        elif kind == "col" and element.get("hidden") in _YES:
            first, last = (whole_number(element.get(end, "0")) for end in ("min", "max"))
            columns.append(range(max(first - 1, 0), min(last, _COLUMNS)))
        elif kind == "autoFilter":
            filters.append(_filter(element))
        if kind in ("c", "row"):
            element.clear()
    hidden = {row: _hiding(any(row in rows for rows in filters), outlined) for row, outlined in folded.items()}
    hidden_columns = frozenset(islice(chain.from_iterable(columns), _COLUMNS))
    return replace(found, hidden_rows=hidden, hidden_columns=hidden_columns, struck=frozenset(crossed))


def _name(element: Element) -> str:
    return element.tag.rpartition("}")[2]


def place_of_cell(reference: str) -> tuple[int, int] | None:
    """Return row and column of a cell, both from 0; None where the reference is none.

    >>> place_of_cell("AB7")
    (6, 27)
    """
    match = _REFERENCE.fullmatch(reference)
    return None if match is None else (int(match[2]) - 1, column_index(match[1].upper()))


def _styles(root: Element) -> tuple[set[int], dict[int, str]]:
    """Return the styles of cells that are crossed out, and the colours of those that have others than the first."""
    listed = {_name(part): list(part) for part in root}
    fonts, fills = listed.get("fonts", []), listed.get("fills", [])
    crossed = [_is_struck(font) for font in fonts]
    letters, grounds = [_colour(font, "color") for font in fonts], [_colour(fill, "fgColor") for fill in fills]
    numbers = [[whole_number(style.get(of, "0")) for of in ("fontId", "fillId")] for style in listed.get("cellXfs", [])]
    colours = ["".join(grounds[fill : fill + 1] + letters[font : font + 1]) for font, fill in numbers]
    struck = {style for style, (font, _) in enumerate(numbers) if any(crossed[font : font + 1])}
    return struck, {style: colour for style, colour in enumerate(colours) if colour != colours[0]}


def _is_struck(element: Element) -> bool:
    return any(_name(part).lower() in ("strike", "dstrike") and part.get("val", "1") in _YES for part in element.iter())


def _colour(element: Element, name: str) -> str:
    """Return the attributes of a colour as they are written; nothing of the usual white ground and black letters."""
    colour = next((part.attrib for part in element.iter() if _name(part) == name), {})
    said = " ".join(f"{key} {value}" for key, value in colour.items())
    return "" if _PLAIN.fullmatch(said) else f"{name} {said};"


def _comments(archive: zipfile.ZipFile, parts: Iterable[str]) -> Iterator[tuple[tuple[int, int], str]]:
    """Yield the place and the words of every comment on a sheet of an xlsx, without the heading of a threaded one."""
    for part in parts:
        if re.search(r"/comments?\d*\.xml$", part) and "threaded" not in part.lower():
            for comment in _root(archive, part).iter():
                place = place_of_cell(comment.get("ref", "")) if _name(comment) == "comment" else None
                if place is not None:
                    words = "".join(part.text or "" for part in comment.iter() if _name(part) == "t")
                    yield place, words.rpartition("Comment:\n")[2].strip()[:_WORDS]


def _filter(element: Element) -> range:
    """Return the rows that a filter may hide, which is in use; the row of headings is never hidden by it."""
    area = _AREA.match(element.get("ref", "")) if any(_name(part) == "filterColumn" for part in element) else None
    return range(0) if area is None else range(int(area[1]), int(area[2]))


def _hiding(filtered: bool, folded: bool) -> Hiding:
    return "by a filter" if filtered else "in a folded outline" if folded else "by hand"


def _ods(root: Element) -> dict[str, Marks]:
    struck = {
        style.get(f"{_STYLE}name")
        for style in root.iter(f"{_STYLE}style")
        for text in style.iter(f"{_STYLE}text-properties")
        if "none" not in (kind := [text.get(f"{_STYLE}text-line-through-{name}") for name in ("style", "type")])
        and any(kind)
    }
    return {table.get(f"{_TABLE}name", ""): _ods_sheet(table, struck) for table in root.iter(f"{_TABLE}table")}


def _ods_sheet(table: Element, struck: set[str | None]) -> Marks:
    rows: dict[int, Hiding] = {}
    comments: dict[tuple[int, int], str] = {}
    merged: list[CellRange] = []
    columns: set[int] = set()
    cells: set[tuple[int, int]] = set()
    folded = {id(line) for group in table.iter(f"{_TABLE}table-row-group") for line in group.iter(f"{_TABLE}table-row")}
    for first, element in _placed(table.iter(f"{_TABLE}table-column"), "columns"):
        if element.get(f"{_TABLE}visibility", "visible") != "visible":
            columns.update(
                range(first, min(first + _repeated(element, "columns"), _COLUMNS))
            )  # empty past the last column
    for row, line in _placed(table.iter(f"{_TABLE}table-row"), "rows"):
        placed_cells = list(_placed(line, "columns"))
        for column, cell in placed_cells:
            down, across = (whole_number(cell.get(f"{_TABLE}number-{way}-spanned", "1")) for way in ("rows", "columns"))
            if down * across > 1:
                merged.append(((row, column), (row + down - 1, column + across - 1)))
        filled = [(column, cell) for column, cell in placed_cells if len(cell)]
        shown = line.get(f"{_TABLE}visibility", "visible")
        if shown != "visible" and filled:
            rows[row] = _hiding(shown == "filter", id(line) in folded)
        for column, cell in filled:
            if cell.get(f"{_TABLE}style-name") in struck:
                cells.add((row, column))
            for note in cell.iter(f"{_OFFICE}annotation"):
                words = "\n".join("".join(paragraph.itertext()) for paragraph in note.iter(f"{_TEXT_OF}p"))
                comments[row, column] = words.strip()[:_WORDS]
    return Marks(rows, frozenset(columns), frozenset(cells), comments=comments, merged=merged)


def _placed(elements: Iterable[Element], what: str) -> Iterator[tuple[int, Element]]:
    """Yield rows or columns, or the cells of a row, with the place of each: one may stand for many."""
    place = 0
    for element in elements:
        yield place, element
        place += _repeated(element, what)


def _repeated(element: Element, what: str) -> int:
    return max(whole_number(element.get(f"{_TABLE}number-{what}-repeated", "1")), 1)
