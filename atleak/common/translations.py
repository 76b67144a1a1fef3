"""The texts of the program: English of files and code, and the catalogues that translate it.

English that is asked for by key stands in ``atleak/texts``; sentences stand in the code, names in the shipped files and
in the declarations of forms. ``atleak/locale`` has one gettext catalogue of all of them for each further language.
"""

from __future__ import annotations

import gettext
import hashlib
import io
import logging
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from atleak.common.errors import OutputError, unknown
from atleak.common.files import made_folder, replace_file
from atleak.common.sentences import Sentence

DOMAIN = "atleak"
TEXTS = Path(__file__).parents[1] / "texts"
LOCALE = Path(__file__).parents[1] / "locale"
_COMPILED = "locale/{}/LC_MESSAGES/atleak.mo"


class Text(NamedTuple):
    """An English text: more than one form where it counts, and a context where one of its words means two things."""

    one: str
    several: str = ""
    context: str | None = None

    @classmethod
    def of(cls, entry: Any) -> Text:
        """Return the text of a file's entry: ``"…"``, ``[one, several]``, or a table of ``text`` and ``context``."""
        if isinstance(entry, dict):
            return cls.of(entry["text"])._replace(context=entry["context"])
        return cls(*entry) if isinstance(entry, list) else cls(entry)

    def translated(self, catalogue: gettext.NullTranslations, count: int = 1) -> str:
        """Return the text in the language of a catalogue, in the plural form of a count."""
        if not self.one:
            return ""
        if self.several:
            if self.context:
                return catalogue.npgettext(self.context, self.one, self.several, count)
            return catalogue.ngettext(self.one, self.several, count)
        return catalogue.pgettext(self.context, self.one) if self.context else catalogue.gettext(self.one)


@cache
def english() -> Mapping[str, Mapping[str, Text]]:
    """Return the English texts that are asked for by key, by table and key; of a mere list each is its own key.

    Several files may add to one table, such as each page its ``columns``.
    """
    tables: dict[str, dict[str, Text]] = {}
    for path in sorted(TEXTS.glob("*.toml")):
        for name, entries in tomllib.loads(path.read_text(encoding="utf-8")).items():
            table = tables.setdefault(name, {})
            texts = entries if isinstance(entries, dict) else {entry: entry for entry in entries}
            twice = table.keys() & texts.keys()
            assert not twice, f"{path.name} gives texts of another file in {name}: {sorted(twice)}"
            table.update({key: Text.of(entry) for key, entry in texts.items()})
    return tables


@cache
def languages() -> tuple[str, ...]:
    """Return the codes of the languages that atleak speaks."""
    return tuple(sorted({"en", *(path.name for path in LOCALE.iterdir() if path.is_dir())}))


def source(language: str) -> Path:
    """Return where the catalogue of a language stands that translators edit."""
    return LOCALE / language / "LC_MESSAGES" / f"{DOMAIN}.po"


@cache
def catalogue(language: str) -> gettext.NullTranslations:
    """Return the translations of a language: of its source in a checkout, else as they came compiled with the package.

    Raises
    ------
    InputError
        if no text is written in that language.
    """
    if language not in languages():
        raise unknown(Sentence("no report in this language"), language, languages())
    if language == "en":
        return gettext.NullTranslations()
    written = source(language)  # before what an editor of catalogues compiled beside it, which may be of an earlier one
    compiled = (
        _compiled(written.read_bytes(), language) if written.is_file() else written.with_suffix(".mo").read_bytes()
    )
    return gettext.GNUTranslations(io.BytesIO(compiled)) if compiled else gettext.NullTranslations()


def _compiled(written: bytes, language: str) -> bytes:
    """Compile the source of an editable checkout, once for each content: the user's cache keeps what was made of it."""
    try:
        return _kept_or_made(written, language)
    except ModuleNotFoundError as missing:
        from importlib.metadata import PackageNotFoundError, distribution  # only here, as it is dear

        with suppress(PackageNotFoundError, OSError):  # installed, and run from a checkout, whose modules come first
            return Path(str(distribution(DOMAIN).locate_file(f"{DOMAIN}/{_COMPILED.format(language)}"))).read_bytes()
        line = 'no %s to compile the texts of "%s", which stay English: python -m pip install -e ".[test]" brings it'
        logging.getLogger(__name__).warning(line, missing.name, language)
        return b""


def _kept_or_made(written: bytes, language: str) -> bytes:
    from platformdirs import user_cache_path  # only a checkout needs it

    kept = user_cache_path(DOMAIN, appauthor=False) / f"{language}-{hashlib.sha256(written).hexdigest()}.mo"
    with suppress(OSError):  # not made yet, or of a home that may not be read
        return kept.read_bytes()
    from babel.messages import mofile, pofile

    made = io.BytesIO()
    mofile.write_mo(made, pofile.read_po(io.BytesIO(written), language))
    with suppress(OutputError):
        made_folder(kept.parent)
        replace_file(kept, made.getvalue())
    return made.getvalue()
