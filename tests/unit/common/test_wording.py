"""A language is one folder with a catalogue: nothing else names the languages there are."""

from __future__ import annotations

import importlib.metadata
import os
import shutil
import subprocess
import sys
from pathlib import Path

import platformdirs
import pypdfium2
import pytest
from babel.messages.mofile import write_mo
from babel.messages.pofile import read_po

from atleak.common import translations
from atleak.common.translations import catalogue, languages, source

CATALOGUE = """
msgid ""
msgstr ""
"Content-Type: text/plain; charset=utf-8\\n"
"Plural-Forms: nplurals=2; plural=(n != 1);\\n"

msgid "Internal leakage of a valve body"
msgstr "Fugas internas de la caja de válvulas"
"""


def test_a_language_is_added_as_one_folder_and_the_command_line_prints_it(root: Path, tmp_path: Path) -> None:
    added = "xx"
    assert added not in languages()
    copy = tmp_path / "copy"
    shutil.copytree(root / "atleak", copy / "atleak", ignore=shutil.ignore_patterns("__pycache__"))
    catalogue = copy / source(added).relative_to(root)
    catalogue.parent.mkdir(parents=True)
    catalogue.write_text(CATALOGUE, encoding="utf-8")
    report = tmp_path / "report.pdf"
    sheet = root / "sample_data" / "measuring_sheet_four_speed.xlsx"
    command = [sys.executable, "-m", "atleak", "diagnose", str(sheet), "--pdf", str(report), "--language", added]
    environment = os.environ | {"PYTHONPATH": str(copy), "ATLEAK_HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path)}
    done = subprocess.run(command, capture_output=True, encoding="utf-8", env=environment, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stderr
    printed = pypdfium2.PdfDocument(report)[1].get_textpage().get_text_range()
    assert "Fugas internas de la caja de válvulas" in printed
    assert "The valve body" in printed, "a text that the language lacks is printed in English"


def test_without_babel_a_checkout_speaks_english_and_says_so_in_a_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda *_, **__: tmp_path)
    for module in ("babel", "babel.messages"):
        monkeypatch.setitem(sys.modules, module, None)
    nothing = importlib.metadata.PathDistribution(tmp_path / "x")
    monkeypatch.setattr(importlib.metadata, "distribution", lambda _: nothing)
    said = catalogue.__wrapped__("de")
    assert said.gettext("a file name") == "a file name"
    (line,) = caplog.messages
    assert "no babel" in line
    assert list(tmp_path.iterdir()) == []


def test_an_installed_package_reads_what_came_compiled_and_needs_no_babel(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with source("pl").open("rb") as read, (tmp_path / "atleak.mo").open("wb") as written:
        write_mo(written, read_po(read))
    monkeypatch.setattr(translations, "source", lambda language: tmp_path / "atleak.po")
    for module in ("babel", "babel.messages", "platformdirs"):
        monkeypatch.setitem(sys.modules, module, None)
    said = catalogue.__wrapped__("pl")
    assert [said.ngettext("{count} row", "{count} rows", count) for count in (0, 1, 2)] == [
        "{count} wierszy", "{count} wiersz", "{count} wiersze",
    ]  # fmt: skip


def test_an_installed_package_run_from_a_checkout_speaks_the_languages_that_came_compiled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    installed = tmp_path / "atleak" / "locale" / "de" / "LC_MESSAGES" / "atleak.mo"
    installed.parent.mkdir(parents=True)
    with source("de").open("rb") as read, installed.open("wb") as written:
        write_mo(written, read_po(read))
    dist = importlib.metadata.PathDistribution(tmp_path / "atleak.dist-info")
    monkeypatch.setattr(importlib.metadata, "distribution", lambda _: dist)
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda *_, **__: tmp_path / "cache")
    for module in ("babel", "babel.messages"):
        monkeypatch.setitem(sys.modules, module, None)
    assert catalogue.__wrapped__("de").gettext("a file name") == "ein Dateiname"
    assert not caplog.messages


def test_a_home_that_may_not_be_read_only_costs_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda *_, **__: tmp_path / ("x" * 300))
    assert catalogue.__wrapped__("de").gettext("a file name") == "ein Dateiname"


def test_what_an_editor_compiled_beside_a_catalogue_is_not_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Poedit does when it saves; the next change of the catalogue would not be seen."""
    written = shutil.copy(source("de"), tmp_path)
    Path(written).with_suffix(".mo").write_bytes(b"of an earlier catalogue")
    monkeypatch.setattr(translations, "source", lambda language: Path(written))
    assert catalogue.__wrapped__("de").gettext("a file name") == "ein Dateiname"


def test_no_source_file_lists_the_languages(root: Path) -> None:
    listing = [f'"{language}"' for language in languages() if language != "en"]
    for path in (*(root / "atleak").rglob("*.py"), *(root / "pages").rglob("*.py")):
        if "readers" not in path.parts:  # words of logs and sheets are another matter
            text = path.read_text(encoding="utf-8")
            assert not all(name in text for name in listing), path.name
