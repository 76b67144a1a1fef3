"""Every language has every text, every text that the code asks for is there, and none stands unused."""

from __future__ import annotations

import ast
import importlib
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from atleak.common.translations import english, languages
from atleak.common.units import SYSTEMS
from atleak.common.wording import wording
from tests.unit.product_code import ROOT, nodes

KEYS = {f"{table}.{key}" for table, texts in english().items() for key in texts}
DOTTED = re.compile(r"\w+\..+")
_WHOLE = (("get", 2), ("table", 1))  # methods of a wording that ask for a whole table, by how many arguments they take


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
    keys = "\n".join(KEYS)
    missing = [(place, pattern) for place, pattern in _asked() if not re.search(f"^{pattern}$", keys, re.MULTILINE)]
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
    assert set(english()["column_help"]) <= set(english()["columns"])


def test_every_page_and_unit_has_its_name() -> None:
    pages = {path.stem.partition("_")[2] for path in (ROOT / "pages").glob("[0-9]*_*.py")}
    assert pages <= set(english()["pages"])
    assert set(english()["unit_systems"]) == set(SYSTEMS)


def test_no_text_stands_unused() -> None:
    """One is used by its key, or by what makes its key, or with its whole table; a heading by its column's name."""
    strings: set[str] = set()
    patterns: set[str] = set()
    # by `Wording.level`, the menu, each column, and the form of a catalogue's entry
    whole = {"verdicts", "bands", "pages", "column_help", "study_words", "uncertainty_sources"}
    for found in nodes().values():
        for node in found:
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                strings.add(node.value)
            elif isinstance(node, ast.JoinedStr):
                pattern = _written(node) or ""
                if DOTTED.fullmatch(pattern.replace("\\", "")):
                    patterns.add(pattern)
            elif isinstance(node, ast.Call) and (getattr(node.func, "attr", ""), len(node.args)) in _WHOLE:
                first = node.args[0]
                whole |= {first.value} if isinstance(first, ast.Constant) else set()
    whole.discard("printed")  # where a printed table finds its columns' headings
    made = re.compile("|".join(sorted(patterns)))

    def is_used(key: str) -> bool:
        table, _, name = key.partition(".")
        by_name = table in ("columns", "printed", "unit_systems") and name in strings
        return table in whole or by_name or key in strings or made.fullmatch(key) is not None

    assert sorted(key for key in KEYS if not is_used(key)) == []


@pytest.fixture(name="tool")
def _tool(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The tool that keeps the catalogues."""
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    return importlib.import_module("translations")


@pytest.mark.parametrize("language", [language for language in languages() if language != "en"])
def test_every_text_is_translated_and_none_stands_unused(tool: ModuleType, language: str) -> None:
    """Sentences of the code, texts that are asked for by key, names of the shipped files and of the forms."""
    assert list(tool.faults(language)) == []


def test_each_fault_of_a_catalogue_is_named(tool: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    catalogue = tool.read("pl")
    catalogue.get("{count} row").string = ("{count} wiersz", "{rows} wiersze", "{count} wierszy")
    catalogue.get("hidden column {names} {done}").string = ("kolumna {name}: {done}", *["kolumny {names}: {done}"] * 2)
    catalogue.get("its folder may not be written, or is not there").string = catalogue.get("a file name").string = ""
    catalogue.get("the file is no job book").string = "the file is no job book"
    catalogue.get("driving in second, 80 °C", "name").string = "jazda na drugim biegu w 80 °C"
    catalogue.add("no longer a text", "dawny tekst")
    catalogue.delete("another file")
    monkeypatch.setattr(tool, "read", lambda language: catalogue)
    assert sorted(fault.partition(":")[0] for fault in tool.faults("pl")) == [
        "does not end with ', 80 °C'", "left in English", "no text of the program", "not in the catalogue",
        "not translated", "not translated", "other places", "other places",
    ]  # fmt: skip


def test_a_language_is_begun_by_its_code_alone(
    tool: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    begun = tmp_path / "atleak.po"
    monkeypatch.setattr(tool, "source", lambda language: begun)
    for wrong in (["add"], ["add", "spanish"]):
        monkeypatch.setattr(tool.sys, "argv", ["translations.py", *wrong])
        with pytest.raises(SystemExit):
            tool.main()
    assert not begun.exists()
    monkeypatch.setattr(tool.sys, "argv", ["translations.py", "add", "es"])
    assert tool.main() == 0
    path, left = capsys.readouterr().out.splitlines()
    assert path == str(begun)
    assert int(left.split()[0]) == sum(1 for message in tool.read("es") if message.id)


def test_a_changed_sentence_keeps_its_translation_as_a_draft(
    tool: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A translator sees what it was; nobody else does, until it was looked at."""
    old, new = "the file is no job book", "the file is no job book of atleak"
    wanted = [message for message in tool.template() if message.id != old]
    catalogue = tool.Catalog()
    for message in wanted:
        catalogue.add(message.id, context=message.context)
    catalogue.add(new)
    monkeypatch.setattr(tool, "template", lambda: catalogue)
    kept = tmp_path / "atleak.po"
    kept.write_bytes(tool.source("pl").read_bytes())
    monkeypatch.setattr(tool, "source", lambda language: kept)
    tool.update("pl")
    assert tool.read("pl").get(new).fuzzy
    assert tool.read("pl").get(new).string == "plik nie jest książką zleceń"
    assert list(tool.faults("pl")) == [f"not translated: {new}"]


def test_names_of_the_shipped_catalogue_are_translated_and_others_stay(tool: ModuleType) -> None:
    assert len(tool.shipped_names()) > 250
    assert wording("de").name("main pressure valve") == "Hauptdruckventil"
    assert wording("de").name("assumed, typical of steel") == "angenommen, wie für Stahl"
    assert wording("de").name("valve of a workshop's own file") == "valve of a workshop's own file"
    assert wording("de").name("Start") == "Start", "a word of the program"
