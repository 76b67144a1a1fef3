"""A language of the report is one file of texts: nothing else names the languages there are."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pypdfium2

from atleak.common.wording import languages


def test_a_language_is_added_as_one_folder_and_the_command_line_prints_it(root: Path, tmp_path: Path) -> None:
    added = "xx"
    assert added not in languages()
    copy = tmp_path / "copy"
    shutil.copytree(root / "atleak", copy / "atleak", ignore=shutil.ignore_patterns("__pycache__"))
    spoken = copy / "atleak" / "texts" / added
    shutil.copytree(root / "atleak" / "texts" / "en", spoken)
    english = (spoken / "report.toml").read_text(encoding="utf-8")
    old = 'report = "Internal leakage of a valve body"'
    assert english.count(old) == 1
    texts = english.replace(old, 'report = "Fugas internas de la caja de válvulas"')
    lacked = 'picture = "The valve body"\n'
    assert texts.count(lacked) == 1
    texts = texts.replace(lacked, "")
    (spoken / "report.toml").write_text(texts, encoding="utf-8")
    report = tmp_path / "report.pdf"
    sheet = root / "sample_data" / "measuring_sheet_four_speed.xlsx"
    command = [sys.executable, "-m", "atleak", "diagnose", str(sheet), "--pdf", str(report), "--language", added]
    environment = os.environ | {"PYTHONPATH": str(copy), "ATLEAK_HOME": str(tmp_path)}
    done = subprocess.run(command, capture_output=True, encoding="utf-8", env=environment, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stderr
    printed = pypdfium2.PdfDocument(report)[1].get_textpage().get_text_range()
    assert "Fugas internas de la caja de válvulas" in printed
    assert "The valve body" in printed, "a text that the language lacks is printed in English"


def test_no_source_file_lists_the_languages(root: Path) -> None:
    listing = [f'"{language}"' for language in languages() if language != "en"]
    for path in (*(root / "atleak").rglob("*.py"), *(root / "pages").rglob("*.py")):
        if "readers" not in path.parts:  # words of logs and sheets are another matter
            text = path.read_text(encoding="utf-8")
            assert not all(name in text for name in listing), path.name
