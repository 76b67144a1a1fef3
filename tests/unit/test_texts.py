"""Every language has every text, every text that the code asks for is there, and none stands unused."""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from typing import Any

import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.entries import shipped_files
from atleak.catalogue.fluid import fluids
from atleak.catalogue.instruments import instruments
from atleak.catalogue.limits import limit_sets
from atleak.common.units import SYSTEMS
from atleak.common.wording import languages, wording
from tests.unit.product_code import ROOT, nodes

ENGLISH = wording("en").texts
KEYS = {f"{table}.{key}" for table, texts in ENGLISH.items() if isinstance(texts, dict) for key in texts}
DOTTED = re.compile(r"\w+\..+")


def _written(node: ast.expr) -> str | None:
    """A string of the code as a pattern, with anything in the place of what is put into it; None for no string."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return re.escape(node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(_written(part) or ".*" for part in node.values)
    return None


def _says(call: ast.Call) -> bool:
    """Whether a call asks for a text: ``say(…)``, ``self.say(…)``, ``reader.say()(…)``, ``wording("en")(…)``."""
    asked = call.func
    if isinstance(asked, ast.Call):
        named = asked.func
        name = named.attr if isinstance(named, ast.Attribute) else getattr(named, "id", "")
        return name in ("say", "wording")
    return (asked.attr if isinstance(asked, ast.Attribute) else getattr(asked, "id", "")) == "say"


def _asked() -> Iterator[tuple[str, str]]:
    for path, found in nodes().items():
        for node in found:
            if isinstance(node, ast.Call) and node.args and _says(node):
                pattern = _written(node.args[0])
                if pattern is not None and DOTTED.fullmatch(pattern.replace("\\", "")):
                    yield f"{path}:{node.lineno}", pattern


def test_every_text_that_is_asked_for_is_there() -> None:
    missing = [
        (place, pattern)
        for place, pattern in _asked()
        if pattern.replace("\\", "") not in KEYS and not any(re.fullmatch(pattern, key) for key in KEYS)
    ]
    assert not missing


def test_every_column_has_its_heading() -> None:
    named = [
        (path, node.args[0].value)
        for path, found in nodes().items()
        if any(isinstance(each, ast.ImportFrom) and each.module == "atleak.report.tables.table" for each in found)
        for node in found
        if isinstance(node, ast.Call)
        and getattr(node.func, "id", "") == "Column"
        and node.args
        and isinstance(node.args[0], ast.Constant)
        and not any(keyword.arg == "words" for keyword in node.keywords)
    ]
    assert named
    headings = {each[1]: {f"columns.{each[1]}", f"printed.{each[1]}", each[1]} for each in named}
    assert [each for each in named if not headings[each[1]] & KEYS] == []
    assert set(ENGLISH["column_help"]) <= set(ENGLISH["columns"])


def test_every_page_and_unit_has_its_name() -> None:
    pages = {path.stem.partition("_")[2] for path in (ROOT / "pages").glob("[0-9]*_*.py")}
    assert pages <= set(ENGLISH["pages"])
    assert set(ENGLISH["unit_systems"]) == set(SYSTEMS)


def test_no_text_stands_unused() -> None:
    """One is used by its key, or by what makes its key, or with its whole table; a heading by its column's name."""
    strings: set[str] = set()
    patterns: set[str] = set()
    # by `Wording.level`, the menu, each column, and the form of a catalogue's entry
    whole = {"verdicts", "bands", "pages", "column_help", "entry_fields"}
    for found in nodes().values():
        for node in found:
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                strings.add(node.value)
            elif isinstance(node, ast.JoinedStr):
                pattern = _written(node) or ""
                if DOTTED.fullmatch(pattern.replace("\\", "")):
                    patterns.add(pattern)
            elif isinstance(node, ast.Subscript) and getattr(node.value, "attr", "") == "texts":
                whole |= {node.slice.value} if isinstance(node.slice, ast.Constant) else set()
            elif isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "get" and len(node.args) == 2:
                first = node.args[0]
                whole |= {first.value} if isinstance(first, ast.Constant) else set()
    whole.discard("printed")  # where a printed table finds its columns' headings
    made = re.compile("|".join(sorted(patterns)))

    def is_used(key: str) -> bool:
        table, _, name = key.partition(".")
        by_name = table in ("columns", "printed", "unit_systems") and name in strings
        return table in whole or by_name or key in strings or made.fullmatch(key) is not None

    assert sorted(key for key in KEYS if not is_used(key)) == []


@pytest.mark.parametrize("language", [each for each in languages() if each != "en"])
def test_a_language_is_no_copy_of_english(language: str) -> None:
    """What was forgotten to be translated is the same sentence in both: four words and more are never."""
    texts, alike = wording(language).texts, {"texts.source_study", "conditions.at"}  # a citation; places alone
    same = [
        key
        for key in KEYS - alike
        for table, _, name in [key.partition(".")]
        if ENGLISH[table][name] == texts[table][name] and len(re.findall(r"[a-z]{3,}", ENGLISH[table][name])) > 3
    ]
    assert same == []


def _sources_and_notes() -> Iterator[str]:
    """What the shipped files say where each value is from, and their notes: pages, PDF and workbook show both."""
    kinds = ("controllers", "fluids", "limits")
    tables: list[Any] = [tomllib.loads(path.read_text()) for kind in kinds for path in shipped_files(kind).values()]
    while tables:
        table = tables.pop()
        tables += table.values() if isinstance(table, dict) else table if isinstance(table, list) else ()
        if isinstance(table, dict):
            yield from (table[key] for key in ("source", "note") if isinstance(table.get(key), str))


def test_every_name_of_the_shipped_catalogue_is_translated() -> None:
    shipped = [load_controller(name) for name in sorted(shipped_files("controllers"))]
    names = {
        name
        for controller in shipped
        for name in (
            controller.name,
            *controller.components.values(),
            *(each.name for each in (*controller.circuits, *controller.leaks, *controller.consumers)),
            *(each.label for each in (*controller.operating_points, *controller.complaints)),
            *(each.name for each in controller.repairs),
            *filter(None, [controller.representative]),
        )
    }
    names |= {name for each in instruments() for name in (each.name, each.name.lower())}
    names |= {each.source for each in instruments()} | {"representative"}  # the source of most operating points
    of_fluids = [text for each in fluids() for text in (each.name, *each.representative)]
    of_limits = [each.name for each in limit_sets()]
    told = [*of_fluids, *of_limits, *_sources_and_notes()]
    names |= {text for text in told if re.search(r"\b[a-z]{4,}\b", text)}  # no brands, no keys
    assert len(shipped) > 8
    assert set(ENGLISH["names"]) == names
    assert all(wording("en").name(name) == name for name in names)
    assert wording("de").name("main pressure valve") == "Hauptdruckventil"
    assert wording("de").name("representative of steel") == "repräsentativ für Stahl"
    assert wording("de").name("valve of a workshop's own file") == "valve of a workshop's own file"
