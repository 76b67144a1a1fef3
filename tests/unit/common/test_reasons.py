"""Why a file cannot be read or written is said as system and Python say it, and in the reader's language."""

from __future__ import annotations

import json
import os
import tomllib
from pathlib import Path

import pytest

from atleak.catalogue.limits import load_limits
from atleak.common.errors import CatalogueError, OutputError, reason_of, text_reason
from atleak.common.files import replace_file
from atleak.common.wording import wording

BROKEN = (
    "a = = 3", "a = 3\na = 4", "a = [1, 2", 'a = "x', "[a\nb = 1", "[[a]\n", "a 1", "a = 1 b = 2", "= 1", "a = {b = 1",
    "[a]\n[a]", "a = {b = 1}\n[a.c]", "a = {b = 1, b = 2}", 'a = "\x01"', "a = 'b\nc'", 'a = "\\q"', "a = 2026-02-30",
)  # fmt: skip


@pytest.mark.parametrize("text", BROKEN)
def test_where_a_toml_file_is_wrong_is_said_in_every_language(text: str) -> None:
    with pytest.raises(tomllib.TOMLDecodeError) as caught:
        tomllib.loads(text)
    said = text_reason(caught.value)
    assert said == str(caught.value)
    german = wording("de").sentence(said)
    assert "Zeile" in german or "am Ende der Datei" in german


@pytest.mark.parametrize("text", ["{", "[1", '{"a" 1}', '{"a": 1,, }', "1 2", '"x', '["\n"]', ""])
def test_where_a_json_file_is_wrong_is_said_in_every_language(text: str) -> None:
    with pytest.raises(json.JSONDecodeError) as caught:
        json.loads(text)
    said = text_reason(caught.value)
    assert said == str(caught.value)
    assert not {"line", "Expecting", "data"} & set(wording("de").sentence(said).split())


@pytest.mark.parametrize("content", [b"a\xff", b"\xe2\x82", b"\xe2a"])
def test_a_text_that_is_no_utf_8_is_said_in_every_language(content: bytes) -> None:
    with pytest.raises(UnicodeDecodeError) as caught:
        content.decode("utf-8")
    said = text_reason(caught.value)
    assert said == str(caught.value)
    assert "kein Text in utf-8: " in wording("de").sentence(said).replace("sind", "ist")
    assert not {"byte", "codec", "position"} & set(wording("pl").sentence(said).split())


def test_what_the_system_says_is_said_in_every_language_and_anything_else_stays(tmp_path: Path) -> None:
    with pytest.raises(OutputError) as caught:
        replace_file(tmp_path, b"in the place of a folder")
    written = wording("de").sentence(caught.value.sentence)
    assert written == f"{tmp_path}: lässt sich nicht schreiben: das ist ein Ordner" or os.name == "nt"
    assert wording("de").sentence(reason_of(OSError(5, "Zugriff verweigert"))) == "Zugriff verweigert"


def test_a_broken_file_of_the_catalogue_is_explained_without_a_word_of_english(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text("id = = 5", encoding="utf-8")
    with pytest.raises(CatalogueError) as caught:
        load_limits(file)
    assert wording("de").sentence(caught.value.sentence) == (
        "own.toml: ist kein gültiges TOML: Ungültiger Wert (Zeile 1, Spalte 6); erwartet: TOML-Text in UTF-8"
    )
