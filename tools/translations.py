"""Bring the catalogues of the languages up to date, and check them.

``update`` takes every text of the program into every ``.po`` under ``atleak/locale``; one whose English has changed
keeps its translation, marked *fuzzy*. ``add es`` begins a language. ``check`` ends with what is not translated, what no
code asks for and whose places differ, each in a line. The catalogues are edited with Poedit, Weblate or a text editor.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from string import Formatter
from typing import Any

from babel.localedata import exists
from babel.messages import Catalog, Message
from babel.messages.pofile import read_po, write_po

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.entries import shipped_files
from atleak.catalogue.fluid import fluids
from atleak.catalogue.instruments import instruments
from atleak.catalogue.limits import limit_sets
from atleak.catalogue.workbook.cells import ChoiceCell
from atleak.catalogue.workbook.subjects import CONTROLLER, SUBJECTS
from atleak.common.translations import Text, english, languages, source

ROOT = Path(__file__).resolve().parents[1]
_FORMS = {"Sentence": slice(1), "counted": slice(1, 3)}  # which arguments of a call are a text's forms
_COUNT = {("count", "", None)}  # a place that the form for one may lack
_SIGNS = " .,:;()–…\n"  # that stand between places without a word
_TEMPERATURE = re.compile(r", \d+ °C$")  # ends the name of an operating point; readers have it in their unit


@cache
def _of_code() -> tuple[tuple[Text, str], ...]:
    """Return the sentences of the code that hold words. Babel's own reader misses some that stand inside another."""
    found: list[tuple[Text, str]] = []
    for path in (ROOT / "app.py", *(ROOT / "atleak").rglob("*.py"), *(ROOT / "pages").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            name = getattr(node.func, "id", "") if isinstance(node, ast.Call) else ""
            if name in _FORMS:
                forms = [ast.literal_eval(form) for form in node.args[_FORMS[name]]]
                if any(literal.strip(_SIGNS) for form in forms for literal, *_ in Formatter().parse(form)):
                    found.append((Text(*forms), ""))
    return tuple(found)


def _of_files() -> Iterator[tuple[Text, str]]:
    """Yield the texts that are asked for by key, and the key: where it is the text itself, its table."""
    for table, texts in english().items():
        for key, text in texts.items():
            if text.one:
                yield text, table if key == text.one else f"{table}.{key}"


def _sources_and_notes() -> Iterator[str]:
    """Yield what the shipped files say where each value is from, and their notes: pages, PDF and workbook show both."""
    kinds = ("controllers", "fluids", "limits")
    paths = [path for kind in kinds for path in shipped_files(kind).values()]
    tables: list[Any] = [tomllib.loads(path.read_text(encoding="utf-8")) for path in paths]
    while tables:
        table = tables.pop()
        tables += table.values() if isinstance(table, dict) else table if isinstance(table, list) else ()
        if isinstance(table, dict):
            yield from (table[key] for key in ("source", "note") if isinstance(table.get(key), str))


@cache
def shipped_names() -> set[str]:
    """Return the names, sources and notes in the shipped files that have words of a language, no brands and no keys."""
    controllers = [load_controller(name) for name in shipped_files("controllers")]
    names = {
        name
        for controller in controllers
        for name in (
            controller.name,
            *controller.components.values(),
            *(each.name for each in (*controller.circuits, *controller.leaks, *controller.consumers)),
            *(each.label for each in (*controller.operating_points, *controller.complaints)),
            *(repair.name for repair in controller.repairs),
            *filter(None, [controller.representative]),
        )
    }
    names |= {name for each in instruments() for name in (each.name, each.name.lower(), each.source)}
    others = [text for fluid in fluids() for text in (fluid.name, *fluid.representative)]
    others += [*(limits.name for limits in limit_sets()), *_sources_and_notes()]
    return names | {"representative"} | {text for text in others if re.search(r"\b[a-z]{4,}\b", text)}


def form_texts() -> set[str]:
    """Return the headings, choices and helps of the forms in which files of the catalogue are typed."""
    sheets = [sheet for subject in (*SUBJECTS.values(), CONTROLLER) for sheet in subject.sheets]
    columns = [column for sheet in sheets for column in sheet.columns]
    choices = {choice for column in columns if isinstance(column.kind, ChoiceCell) for choice in column.kind.shown}
    texts = {text for sheet in sheets for text in (sheet.name, sheet.about)} | choices | {"yes", "no"}
    return (texts | {text for column in columns for text in (column.heading, column.help)}) - {"", None}


def template() -> Catalog:
    """Return every text of the program, with the keys by which it is asked for."""
    catalogue = Catalog(project="atleak")
    words = [(Text(name, context="name"), "") for name in shipped_names()] + [
        (Text(name, context="form"), "") for name in form_texts()
    ]
    for text, key in (*_of_code(), *_of_files(), *words):
        forms = (text.one, text.several) if text.several else text.one
        catalogue.add(forms, context=text.context, auto_comments=[key] if key else [])
    return catalogue


def read(language: str) -> Catalog:
    """Read the catalogue of a language."""
    with source(language).open("rb") as file:
        return read_po(file, language)


def write(language: str, catalogue: Catalog) -> None:
    """Write a catalogue by its texts, without the lines of the code, so that moving code changes nothing."""
    for message in catalogue:
        message.flags -= {"python-format"}  # "100 % of" is none
        message.auto_comments.sort()
    source(language).parent.mkdir(parents=True, exist_ok=True)
    with source(language).open("wb") as file:
        write_po(file, catalogue, width=120, no_location=True, sort_output=True, ignore_obsolete=True)


def update(language: str) -> None:
    """Take every text of the program into the catalogue of a language."""
    begun = Catalog(language, project="atleak", header_comment="# The texts of atleak, for translators.", fuzzy=False)
    catalogue = read(language) if source(language).exists() else begun
    created = catalogue.creation_date
    catalogue.update(template(), update_creation_date=False)
    catalogue.creation_date = created
    write(language, catalogue)


def _places(form: str) -> set[tuple[str, str | None, str | None]]:
    return {(name, shape, turned) for _, name, shape, turned in Formatter().parse(form) if name is not None}


def _forms(message: Message) -> tuple[str, ...]:
    return tuple(message.string) if isinstance(message.string, tuple | list) else (message.string or "",)


def faults(language: str) -> Iterator[str]:
    """Yield what is wrong with the catalogue of a language."""
    catalogue, wanted = read(language), {(each.id, each.context) for each in template() if each.id}
    there = {(each.id, each.context): each for each in catalogue if each.id}
    yield from (f"not in the catalogue: {key}" for key in sorted(wanted - there.keys(), key=str))
    yield from (f"no text of the program: {key}" for key in sorted(there.keys() - wanted, key=str))
    for (text, _), message in there.items():
        one, several = (text, text) if isinstance(text, str) else text
        forms = _forms(message)
        apart = (_places(forms[0]) ^ _places(one)) - (_COUNT if isinstance(text, tuple) else set())
        if not all(forms) or message.fuzzy:
            yield f"not translated: {text}"
        elif apart or any(_places(form) ^ _places(several) for form in forms[1:]):
            yield f"other places: {text}: {forms}"
        elif (end := _TEMPERATURE.search(one)) and not forms[0].endswith(end[0]):
            yield f"does not end with {end[0]!r}: {text}: {forms[0]}"
        elif several in forms and len(re.findall(r"[a-z]{3,}", re.sub(r"\{.*?\}|^Dziubak.*", "", several))) > 3:
            yield f"left in English: {text}"


def main() -> int:
    """Update, add or check."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("update", "add", "check"))
    parser.add_argument("language", nargs="?")
    asked = parser.parse_args()
    if (asked.language or asked.what == "add") and not exists(asked.language or ""):
        parser.error("name a language by its code, such as es")
    others = [asked.language] if asked.language else [each for each in languages() if each != "en"]
    found = []
    for language in others:
        if asked.what != "check":
            update(language)
        found += [f"{language}: {fault}".replace("\n", " ") for fault in faults(language)]
    shown = [source(asked.language)] if asked.what == "add" else found  # of a language begun, nothing is translated
    print(*shown, f"{len(found)} to translate or mend", sep="\n")
    return bool(found) and asked.what == "check"


if __name__ == "__main__":
    sys.exit(main())
