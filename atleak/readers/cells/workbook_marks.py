"""Reads what a workbook's author hid, crossed out, coloured or commented on, from the XML of an xlsx or ods.

Cells are read without their styles elsewhere, so this looks at the XML itself. Bytes in, plain data out.
"""

from __future__ import annotations

import io
import posixpath
import re
import zipfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import accumulate
from typing import Literal
from xml.etree import ElementTree

Hiding = Literal["by hand", "by a filter", "in a folded outline"]

PART_LIMIT = 32_000_000  # bytes of one unpacked part; a measuring sheet is a hundredth of it
_LIST_LIMIT = 2_000_000  # of one that lists sheets, or relations
_COLUMNS = 16_384  # of a sheet
_WORDS = 300  # characters of a comment

# no pattern runs past the next "<", so that none takes more than linear time on a hostile file
_ROW = re.compile(rb"<(?:\w{1,20}:)?row\b([^<>]*)>")
_COLUMN = re.compile(rb"<(?:\w{1,20}:)?col\b([^<>]*)>")
_TEXT = re.compile(rb"<(?:\w{1,20}:)?c\b([^<>]*)>\s*<(?:\w{1,20}:)?v>(\d{1,9})</")
_FILLED = re.compile(rb"<(?:\w{1,20}:)?c\b([^<>]*[^<>/])>\s*<(?:\w{1,20}:)?(?:v|f|is)\b")
_PLAIN = re.compile(rb"|rgb (?:00|FF)(?:000000|FFFFFF)|theme [01]|indexed (?:8|9|64|65)|auto 1", re.IGNORECASE)
_ATTRIBUTE = re.compile(rb'(?:^|\s)(\w+)="([^"<>]*)"')
_REFERENCE = re.compile(rb"([A-Z]{1,3})(\d{1,7})")
_AREA = re.compile(rb"\$?([A-Z]{1,3})\$?(\d{1,7}):\$?([A-Z]{1,3})\$?(\d{1,7})")
_YES = {b"1", b"true"}
_PLAIN_IN_ODS = re.compile(r"|transparent|#0{6}|#f{6}", re.IGNORECASE)
_TABLE = "{urn:oasis:names:tc:opendocument:xmlns:table:1.0}"
_STYLE = "{urn:oasis:names:tc:opendocument:xmlns:style:1.0}"
_OFFICE = "{urn:oasis:names:tc:opendocument:xmlns:office:1.0}"
_TEXT_OF = "{urn:oasis:names:tc:opendocument:xmlns:text:1.0}"
_FO = "{urn:oasis:names:tc:opendocument:xmlns:xsl-fo-compatible:1.0}"
_SEEN = ("background-color", "color")  # of a cell's ground and its letters


@dataclass(frozen=True)
class Marks:
    """What is hidden, crossed out, coloured or commented on, on one sheet; rows and columns count from 0.

    A row hidden in several ways counts as hidden by the filter. Colours are those of a filled cell's ground and
    letters as the file writes them, to tell cells apart; of cells that have those of an empty sheet there are none.
    """

    hidden_rows: dict[int, Hiding] = field(default_factory=dict)
    hidden_columns: frozenset[int] = frozenset()
    struck: frozenset[tuple[int, int]] = frozenset()  # cells crossed out
    colours: dict[tuple[int, int], str] = field(default_factory=dict)
    comments: dict[tuple[int, int], str] = field(default_factory=dict)


def marks(data: bytes) -> dict[str, Marks]:
    """Return the marks on each sheet of an xlsx or ods, by its name; empty for other files.

    A damaged file raises `zipfile.BadZipFile`, `ElementTree.ParseError` or `KeyError`.
    """
    if not data.startswith(b"PK"):
        return {}
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        names = set(archive.namelist())
        if "xl/workbook.xml" in names:
            return _xlsx(archive, names)
        if "content.xml" in names:
            return _ods(unpacked_part(archive, "content.xml"))
    return {}


def column_index(letters: str) -> int:
    """Return a column's letters as a number from 0.

    >>> column_index("A"), column_index("AB")
    (0, 27)
    """
    index = 0
    for letter in letters:
        index = index * 26 + ord(letter) - 64
    return index - 1


def whole_number(text: str | bytes) -> int:
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


# --- xlsx -----------------------------------------------------------------------------------------------------------


def sheet_paths(archive: zipfile.ZipFile) -> dict[str, str]:
    """Return the part of the archive that holds each sheet of an xlsx, by the sheet's name."""
    targets = dict(_targets(archive, "xl/workbook.xml"))
    paths = {}
    for element in ElementTree.fromstring(unpacked_part(archive, "xl/workbook.xml", _LIST_LIMIT)).iter():
        if element.tag.endswith("}sheet"):
            relation = next((value for key, value in element.attrib.items() if key.endswith("}id")), "")
            paths[element.get("name", "")] = targets.get(relation, "xl")
    return paths


def _targets(archive: zipfile.ZipFile, part: str) -> Iterator[tuple[str, str]]:
    """Yield what a part of an xlsx refers to: the id of each relation and the part it leads to."""
    folder, name = posixpath.split(part)
    for relation in ElementTree.fromstring(unpacked_part(archive, f"{folder}/_rels/{name}.rels", _LIST_LIMIT)):
        target = relation.get("Target", "")
        path = target.lstrip("/") if target.startswith("/") else posixpath.normpath(f"{folder}/{target}")
        yield relation.get("Id", ""), path


def _xlsx(archive: zipfile.ZipFile, names: set[str]) -> dict[str, Marks]:
    def part(name: str) -> bytes:
        return unpacked_part(archive, name) if name in names else b""

    styles_xml = part("xl/styles.xml")
    styles, coloured = _struck_styles(styles_xml), _coloured_styles(styles_xml)
    strings = _struck_strings(part("xl/sharedStrings.xml"))
    marks_by_sheet = {}
    for sheet, path in sheet_paths(archive).items():
        if path in names:
            sheet_xml = unpacked_part(archive, path)
            filters = _filters(archive, names, path, sheet_xml) if b"hidden=" in sheet_xml else []
            marks_by_sheet[sheet] = Marks(
                _hidden_rows(sheet_xml, filters),
                frozenset(_hidden_columns(sheet_xml)),
                frozenset(_struck_cells(sheet_xml, styles, strings)),
                dict(_coloured_cells(sheet_xml, coloured)),
                dict(_comments(archive, names, path)),
            )
    return marks_by_sheet


def _attributes(tag: bytes) -> dict[bytes, bytes]:
    return dict(_ATTRIBUTE.findall(tag))


def _elements(xml: bytes, name: bytes) -> list[bytes]:
    """Return the text after each opening tag of that name, up to the next such tag."""
    return re.split(rb"<(?:\w{1,20}:)?" + name + rb"(?=[\s>/])", xml)[1:]


def _inside(xml: bytes, name: bytes) -> bytes:
    """Return the content of the first element of that name."""
    parts = _elements(xml, name)
    return re.split(rb"</(?:\w{1,20}:)?" + name + rb">", parts[0], maxsplit=1)[0] if parts else b""


def _is_struck(xml: bytes) -> bool:
    return any(
        _attributes(tag).get(b"val", b"1") in _YES
        for tag in re.findall(rb"<(?:\w{1,20}:)?d?strike\b([^<>]*?)/?>", xml, re.IGNORECASE)
    )


def _styles(xml: bytes) -> list[tuple[int, int]]:
    """Return the number of the font and of the ground of every style of cells."""
    tags = (_attributes(style.split(b">")[0].rstrip(b"/")) for style in _elements(_inside(xml, b"cellXfs"), b"xf"))
    return [(whole_number(tag.get(b"fontId", b"0")), whole_number(tag.get(b"fillId", b"0"))) for tag in tags]


def _struck_styles(xml: bytes) -> frozenset[int]:
    if b"trike" not in xml:
        return frozenset()
    fonts = {number for number, font in enumerate(_elements(_inside(xml, b"fonts"), b"font")) if _is_struck(font)}
    return frozenset(number for number, (font, _) in enumerate(_styles(xml)) if font in fonts)


def _coloured_styles(xml: bytes) -> dict[int, str]:
    """Return the colours of ground and letters of the styles that have others than the first one, the plain."""
    grounds = [_colour(fill, b"fgColor") for fill in _elements(_inside(xml, b"fills"), b"fill")]
    letters = [_colour(font, b"color") for font in _elements(_inside(xml, b"fonts"), b"font")]
    colours = ["".join(grounds[fill : fill + 1] + letters[font : font + 1]) for font, fill in _styles(xml)]
    return {number: colour for number, colour in enumerate(colours) if colour != colours[0]}


def _colour(element: bytes, name: bytes) -> str:
    """Return the attributes of a colour as they are written; nothing of the usual white ground and black letters."""
    tag = re.search(rb"<(?:\w{1,20}:)?" + name + rb"\b([^<>]*)>", element)
    colour = b" ".join(b"%s %s" % attribute for attribute in _attributes(tag[1].rstrip(b"/")).items()) if tag else b""
    return "" if _PLAIN.fullmatch(colour) else f"{name.decode()} {colour.decode('utf-8', 'replace')};"


def _coloured_cells(xml: bytes, styles: dict[int, str]) -> Iterator[tuple[tuple[int, int], str]]:
    """Yield the place and the colours of every cell of such a style that holds something."""
    for tag in _FILLED.findall(xml) if styles else ():
        style = _attributes(tag).get(b"s", b"")
        if style.isdigit() and int(style) in styles:
            for place in _place_of_cell(tag):
                yield place, styles[int(style)]


def _comments(archive: zipfile.ZipFile, names: set[str], path: str) -> Iterator[tuple[tuple[int, int], str]]:
    """Yield the place and the words of every comment on a sheet of an xlsx, without the heading of a threaded one."""
    folder, name = posixpath.split(path)
    if f"{folder}/_rels/{name}.rels" not in names:
        return
    for _, part in _targets(archive, path):
        if part in names and re.search(r"/comments?\d*\.xml$", part) and "threaded" not in part.lower():
            for comment in ElementTree.fromstring(unpacked_part(archive, part)).iter():
                if comment.tag.endswith("}comment"):
                    words = "".join(part.text or "" for part in comment.iter() if part.tag.endswith("}t"))
                    for place in _place_of_cell(f'r="{comment.get("ref", "")}"'.encode()):
                        yield place, words.rpartition("Comment:\n")[2].strip()[:_WORDS]


def _struck_strings(xml: bytes) -> frozenset[int]:
    """Return the numbers of the shared texts that are crossed out throughout."""
    if b"trike" not in xml:
        return frozenset()
    runs = enumerate(_elements(text, b"r") for text in _elements(xml, b"si"))
    return frozenset(number for number, part in runs if part and all(map(_is_struck, part)))


def _struck_cells(xml: bytes, styles: frozenset[int], strings: frozenset[int]) -> Iterator[tuple[int, int]]:
    if styles:
        numbers = b"|".join(b"%d" % style for style in sorted(styles))
        for tag in re.findall(rb'<(?:\w{1,20}:)?c\b([^<>]*\ss="(?:' + numbers + rb')"[^<>]*)>', xml):
            yield from _place_of_cell(tag)
    if b"trike" in xml:
        for cell in _elements(xml, b"c"):
            runs = _elements(cell, b"r")
            if runs and all(_is_struck(run) for run in runs):
                yield from _place_of_cell(cell.partition(b">")[0])
    if strings:
        for tag, value in _TEXT.findall(xml):
            if int(value) in strings and _attributes(tag).get(b"t") == b"s":
                yield from _place_of_cell(tag)


def _place_of_cell(tag: bytes) -> Iterator[tuple[int, int]]:
    reference = _REFERENCE.fullmatch(_attributes(tag.rstrip(b"/")).get(b"r", b""))
    if reference is not None:
        yield int(reference[2]) - 1, column_index(reference[1].decode())


def _hidden_rows(xml: bytes, filters: list[tuple[int, int]]) -> dict[int, Hiding]:
    hidden: dict[int, Hiding] = {}
    if b"hidden=" not in xml:
        return hidden
    row = -1
    for tag in _ROW.findall(xml):
        attributes = _attributes(tag.rstrip(b"/"))
        row = whole_number(attributes[b"r"]) - 1 if b"r" in attributes else row + 1
        if attributes.get(b"hidden") not in _YES:
            continue
        filtered = any(first <= row <= last for first, last in filters)
        hidden[row] = _hiding(filtered, attributes.get(b"outlineLevel", b"0") != b"0")
    return hidden


def _hiding(filtered: bool, folded: bool) -> Hiding:
    return "by a filter" if filtered else "in a folded outline" if folded else "by hand"


def _hidden_columns(xml: bytes) -> Iterator[int]:
    begins = [0] * (_COLUMNS + 1)  # at each column: how many stretches begin there, less how many ended before it
    for tag in _COLUMN.findall(_inside(xml, b"cols"))[:_COLUMNS]:
        attributes = _attributes(tag.rstrip(b"/"))
        if attributes.get(b"hidden") in _YES:
            first, last = (whole_number(attributes.get(name, b"0")) for name in (b"min", b"max"))
            first, last = max(first - 1, 0), min(last, _COLUMNS)
            if first < last:
                begins[first] += 1
                begins[last] -= 1
    yield from (column for column, within in enumerate(accumulate(begins[:-1])) if within)


def _filters(archive: zipfile.ZipFile, names: set[str], path: str, xml: bytes) -> list[tuple[int, int]]:
    """Return the first and last row of each filter in use, of the sheet itself and of the tables on it."""
    parts = [xml]
    folder, name = posixpath.split(path)
    if f"{folder}/_rels/{name}.rels" in names:
        tables = [target for _, target in _targets(archive, path) if "/tables/" in f"/{target}" and target in names]
        parts += [unpacked_part(archive, target) for target in tables]
    filtered = []
    for part in parts:
        area = _AREA.search(part, max(part.find(b"autoFilter"), 0)) if b"filterColumn" in part else None
        if area is not None:
            filtered.append((int(area[2]), int(area[4]) - 1))  # the row of headings is never hidden by it
    return filtered


# --- ods ------------------------------------------------------------------------------------------------------------


def _ods(xml: bytes) -> dict[str, Marks]:
    if not any(
        sign in xml for sign in (b":visibility=", b"line-through", b":annotation", b"background-color", b":color=")
    ):
        return {}
    root = ElementTree.fromstring(xml)
    struck = {
        style.get(f"{_STYLE}name")
        for style in root.iter(f"{_STYLE}style")
        for text in style.iter(f"{_STYLE}text-properties")
        if "none" not in (kind := [text.get(f"{_STYLE}text-line-through-{name}") for name in ("style", "type")])
        and any(kind)
    }
    colours: dict[str | None, str] = {
        style.get(f"{_STYLE}name"): "".join(
            f"{name} {properties.get(f'{_FO}{name}')};"
            for properties in style
            for name in _SEEN
            if not _PLAIN_IN_ODS.fullmatch(properties.get(f"{_FO}{name}", ""))
        )
        for style in root.iter(f"{_STYLE}style")
    }
    return {table.get(f"{_TABLE}name", ""): _ods_sheet(table, struck, colours) for table in root.iter(f"{_TABLE}table")}


def _ods_sheet(table: ElementTree.Element, struck: set[str | None], colours: dict[str | None, str]) -> Marks:
    rows: dict[int, Hiding] = {}
    coloured: dict[tuple[int, int], str] = {}
    comments: dict[tuple[int, int], str] = {}
    styles: dict[int, str | None] = {}  # of the cells of a column that name none, by the column's end
    columns: set[int] = set()
    cells: set[tuple[int, int]] = set()
    folded = {id(line) for group in table.iter(f"{_TABLE}table-row-group") for line in group.iter(f"{_TABLE}table-row")}
    for first, element in placed(table.iter(f"{_TABLE}table-column"), "columns"):
        end = first + _repeated(element, "columns")
        if element.get(f"{_TABLE}visibility", "visible") != "visible":
            columns.update(range(first, min(end, _COLUMNS)))  # empty past the last column
        styles[end] = element.get(f"{_TABLE}default-cell-style-name")
    for row, line in placed(table.iter(f"{_TABLE}table-row"), "rows"):
        filled = [(column, cell) for column, cell in placed(line, "columns") if len(cell)]
        shown = line.get(f"{_TABLE}visibility", "visible")
        if shown != "visible" and filled:
            rows[row] = _hiding(shown == "filter", id(line) in folded)
        for column, cell in filled:
            if (own := cell.get(f"{_TABLE}style-name")) in struck:
                cells.add((row, column))
            style = own or line.get(f"{_TABLE}default-cell-style-name")
            style = style or next((named for end, named in styles.items() if column < end), None)
            if colour := colours.get(style):
                coloured[row, column] = colour
            for note in cell.iter(f"{_OFFICE}annotation"):
                words = "\n".join("".join(paragraph.itertext()) for paragraph in note.iter(f"{_TEXT_OF}p"))
                comments[row, column] = words.strip()[:_WORDS]
    return Marks(rows, frozenset(columns), frozenset(cells), coloured, comments)


def placed(elements: Iterable[ElementTree.Element], what: str) -> Iterator[tuple[int, ElementTree.Element]]:
    """Yield rows or columns, or the cells of a row, with the place of each: one may stand for many."""
    place = 0
    for element in elements:
        yield place, element
        place += _repeated(element, what)


def _repeated(element: ElementTree.Element, what: str) -> int:
    return max(whole_number(element.get(f"{_TABLE}number-{what}-repeated", "1")), 1)
