"""What a workbook's author hid or crossed out: rows, columns and cells, from the styles of an xlsx or ods.

Cells are read without their styles elsewhere, so this looks at the XML itself. Bytes in, plain data out.
"""

from __future__ import annotations

import io
import posixpath
import re
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal
from xml.etree import ElementTree

Hiding = Literal["by hand", "by a filter", "in a folded outline"]

PART_LIMIT = 300_000_000  # bytes of one unpacked part; a measuring sheet is a thousandth of it
_COLUMNS = 16_384  # of a sheet

# no pattern runs past the next "<", so that none takes more than linear time on a hostile file
_ROW = re.compile(rb"<(?:\w{1,20}:)?row\b([^<>]*)>")
_COLUMN = re.compile(rb"<(?:\w{1,20}:)?col\b([^<>]*)>")
_TEXT = re.compile(rb"<(?:\w{1,20}:)?c\b([^<>]*)>\s*<(?:\w{1,20}:)?v>(\d{1,9})</")
_ATTRIBUTE = re.compile(rb'(?:^|\s)(\w+)="([^"<>]*)"')
_REFERENCE = re.compile(rb"([A-Z]{1,3})(\d{1,7})")
_AREA = re.compile(rb"\$?([A-Z]{1,3})\$?(\d{1,7}):\$?([A-Z]{1,3})\$?(\d{1,7})")
_YES = {b"1", b"true"}
_TABLE = "{urn:oasis:names:tc:opendocument:xmlns:table:1.0}"
_STYLE = "{urn:oasis:names:tc:opendocument:xmlns:style:1.0}"


@dataclass(frozen=True)
class Marks:
    """Of one sheet, rows and columns from 0. A row hidden in several ways is under the filter first."""

    hidden_rows: dict[int, Hiding] = field(default_factory=dict)
    hidden_columns: frozenset[int] = frozenset()
    struck: frozenset[tuple[int, int]] = frozenset()  # cells crossed out


def marks(data: bytes) -> dict[str, Marks]:
    """What is hidden or crossed out in each sheet of an xlsx or ods, by the sheet's name; empty for other kinds.

    Raises
    ------
    ValueError
        where a part unpacks to more than `PART_LIMIT` bytes.
    zipfile.BadZipFile, xml.etree.ElementTree.ParseError, KeyError
        for a damaged file.
    """
    if not data.startswith(b"PK"):
        return {}
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        names = set(archive.namelist())
        if "xl/workbook.xml" in names:
            return _xlsx(archive, names)
        if "content.xml" in names:
            return _ods(_part(archive, "content.xml"))
    return {}


def column_index(letters: str) -> int:
    """A column's letters as a number from 0.

    >>> column_index("A"), column_index("AB")
    (0, 27)
    """
    index = 0
    for letter in letters:
        index = index * 26 + ord(letter) - 64
    return index - 1


def _part(archive: zipfile.ZipFile, name: str) -> bytes:
    with archive.open(name) as part:
        content = part.read(PART_LIMIT + 1)
    if len(content) > PART_LIMIT:
        raise ValueError(f"{name} unpacks to more than {PART_LIMIT // 1_000_000} MB")
    return content


# --- xlsx -----------------------------------------------------------------------------------------------------------


def sheet_paths(archive: zipfile.ZipFile) -> dict[str, str]:
    """The part of the archive that holds each sheet of an xlsx, by the sheet's name."""
    targets = dict(_targets(archive, "xl/workbook.xml"))
    paths = {}
    for element in ElementTree.fromstring(_part(archive, "xl/workbook.xml")).iter():
        if element.tag.endswith("}sheet"):
            relation = next((value for key, value in element.attrib.items() if key.endswith("}id")), "")
            paths[element.get("name", "")] = targets.get(relation, "xl")
    return paths


def _targets(archive: zipfile.ZipFile, part: str) -> Iterator[tuple[str, str]]:
    """What a part of an xlsx refers to: names of relations and the parts they lead to."""
    folder, name = posixpath.split(part)
    for relation in ElementTree.fromstring(_part(archive, f"{folder}/_rels/{name}.rels")):
        target = relation.get("Target", "")
        path = target.lstrip("/") if target.startswith("/") else posixpath.normpath(f"{folder}/{target}")
        yield relation.get("Id", ""), path


def _xlsx(archive: zipfile.ZipFile, names: set[str]) -> dict[str, Marks]:
    styles = _struck_styles(_part(archive, "xl/styles.xml")) if "xl/styles.xml" in names else frozenset()
    strings = (
        _struck_strings(_part(archive, "xl/sharedStrings.xml")) if "xl/sharedStrings.xml" in names else frozenset()
    )
    found = {}
    for sheet, path in sheet_paths(archive).items():
        if path in names:
            xml = _part(archive, path)
            filters = _filters(archive, names, path, xml) if b"hidden=" in xml else []
            found[sheet] = Marks(
                _hidden_rows(xml, filters), frozenset(_hidden_columns(xml)), frozenset(_struck(xml, styles, strings))
            )
    return found


def _attributes(tag: bytes) -> dict[bytes, bytes]:
    return dict(_ATTRIBUTE.findall(tag))


def _elements(xml: bytes, name: bytes) -> list[bytes]:
    """What stands after each opening tag of that name, up to the next one."""
    return re.split(rb"<(?:\w{1,20}:)?" + name + rb"(?=[\s>/])", xml)[1:]


def _inside(xml: bytes, name: bytes) -> bytes:
    """What stands in the first element of that name."""
    parts = _elements(xml, name)
    return re.split(rb"</(?:\w{1,20}:)?" + name + rb">", parts[0], maxsplit=1)[0] if parts else b""


def _is_struck(xml: bytes) -> bool:
    return any(
        _attributes(tag).get(b"val", b"1") in _YES
        for tag in re.findall(rb"<(?:\w{1,20}:)?d?strike\b([^<>]*?)/?>", xml, re.IGNORECASE)
    )


def _struck_styles(xml: bytes) -> frozenset[int]:
    if b"trike" not in xml:
        return frozenset()
    fonts = {number for number, font in enumerate(_elements(_inside(xml, b"fonts"), b"font")) if _is_struck(font)}
    styles = enumerate(_elements(_inside(xml, b"cellXfs"), b"xf"))
    return frozenset(
        number
        for number, style in styles
        if int(_attributes(style.split(b">")[0].rstrip(b"/")).get(b"fontId", b"0")) in fonts
    )


def _struck_strings(xml: bytes) -> frozenset[int]:
    """Texts of which every run is crossed out."""
    if b"trike" not in xml:
        return frozenset()
    found = set()
    for number, text in enumerate(_elements(xml, b"si")):
        runs = _elements(text, b"r")
        if runs and all(_is_struck(run) for run in runs):
            found.add(number)
    return frozenset(found)


def _struck(xml: bytes, styles: frozenset[int], strings: frozenset[int]) -> Iterator[tuple[int, int]]:
    if styles:
        numbers = b"|".join(b"%d" % style for style in sorted(styles))
        for tag in re.findall(rb'<(?:\w{1,20}:)?c\b([^<>]*\ss="(?:' + numbers + rb')"[^<>]*)>', xml):
            yield from _cell(tag)
    if b"trike" in xml:
        for cell in _elements(xml, b"c"):
            runs = _elements(cell, b"r")
            if runs and all(_is_struck(run) for run in runs):
                yield from _cell(cell.partition(b">")[0])
    if strings:
        for tag, value in _TEXT.findall(xml):
            if int(value) in strings and _attributes(tag).get(b"t") == b"s":
                yield from _cell(tag)


def _cell(tag: bytes) -> Iterator[tuple[int, int]]:
    reference = _REFERENCE.fullmatch(_attributes(tag.rstrip(b"/")).get(b"r", b""))
    if reference is not None:
        yield int(reference[2]) - 1, column_index(reference[1].decode())


def _hidden_rows(xml: bytes, filters: list[tuple[int, int]]) -> dict[int, Hiding]:
    hidden: dict[int, Hiding] = {}
    if b"hidden=" not in xml:
        return hidden
    row = -1
    for tag in _ROW.findall(xml):
        found = _attributes(tag.rstrip(b"/"))
        row = int(found.get(b"r", b"0")) - 1 if b"r" in found else row + 1
        if found.get(b"hidden") not in _YES:
            continue
        if any(first <= row <= last for first, last in filters):
            hidden[row] = "by a filter"
        else:
            folded = found.get(b"outlineLevel", b"0") != b"0"
            hidden[row] = "in a folded outline" if folded else "by hand"
    return hidden


def _hidden_columns(xml: bytes) -> Iterator[int]:
    for tag in _COLUMN.findall(_inside(xml, b"cols"))[:_COLUMNS]:
        found = _attributes(tag.rstrip(b"/"))
        if found.get(b"hidden") in _YES:
            first, last = (int(found.get(name, b"0")) for name in (b"min", b"max"))
            yield from range(max(first - 1, 0), min(last, _COLUMNS))


def _filters(archive: zipfile.ZipFile, names: set[str], path: str, xml: bytes) -> list[tuple[int, int]]:
    """Rows under a filter that chooses something, of the sheet itself and of the tables on it."""
    parts = [xml]
    folder, name = posixpath.split(path)
    if f"{folder}/_rels/{name}.rels" in names:
        tables = [target for _, target in _targets(archive, path) if "/tables/" in f"/{target}" and target in names]
        parts += [_part(archive, target) for target in tables]
    found = []
    for part in parts:
        area = _AREA.search(part, max(part.find(b"autoFilter"), 0)) if b"filterColumn" in part else None
        if area is not None:
            found.append((int(area[2]), int(area[4]) - 1))  # the row of headings is never hidden by it
    return found


# --- ods ------------------------------------------------------------------------------------------------------------


def _ods(xml: bytes) -> dict[str, Marks]:
    if not any(sign in xml for sign in (b":visibility=", b"line-through")):
        return {}
    root = ElementTree.fromstring(xml)
    struck = {
        style.get(f"{_STYLE}name")
        for style in root.iter(f"{_STYLE}style")
        for text in style.iter(f"{_STYLE}text-properties")
        if "none" not in (kind := [text.get(f"{_STYLE}text-line-through-{name}") for name in ("style", "type")])
        and any(kind)
    }
    return {table.get(f"{_TABLE}name", ""): _ods_sheet(table, struck) for table in root.iter(f"{_TABLE}table")}


def _ods_sheet(table: ElementTree.Element, struck: set[str | None]) -> Marks:
    rows: dict[int, Hiding] = {}
    columns: set[int] = set()
    cells: set[tuple[int, int]] = set()
    folded = {id(line) for group in table.iter(f"{_TABLE}table-row-group") for line in group.iter(f"{_TABLE}table-row")}
    at = 0
    for column in table.iter(f"{_TABLE}table-column"):
        again = _repeated(column, "columns")
        if column.get(f"{_TABLE}visibility", "visible") != "visible":
            columns.update(range(at, min(at + again, _COLUMNS)))  # empty past the last column
        at += again
    at = 0
    for line in table.iter(f"{_TABLE}table-row"):
        shown = line.get(f"{_TABLE}visibility", "visible")
        if shown != "visible" and any(len(cell) for cell in line):
            way: Hiding = (
                "by a filter" if shown == "filter" else "in a folded outline" if id(line) in folded else "by hand"
            )
            rows[at] = way
        across = 0
        for cell in line:
            if cell.get(f"{_TABLE}style-name") in struck and len(cell):
                cells.add((at, across))
            across += _repeated(cell, "columns")
        at += _repeated(line, "rows")
    return Marks(rows, frozenset(columns), frozenset(cells))


def _repeated(element: ElementTree.Element, what: str) -> int:
    return max(int(element.get(f"{_TABLE}number-{what}-repeated", "1")), 1)
