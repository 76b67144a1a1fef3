"""Names as plain words, for comparing what people and loggers write."""

from __future__ import annotations

import re
import tomllib
import unicodedata
from collections.abc import Mapping
from functools import cache, lru_cache
from importlib import resources
from typing import Any

_TRANSLATE = str.maketrans(
    {"ß": "ss", "ä": "ae", "ö": "oe", "ü": "ue", "ł": "l", "ø": "o", "æ": "ae", "№": "no", "đ": "d"}
)
_CAMEL = re.compile(r"(?<=[a-zа-яё])(?=[A-ZА-ЯЁ])|(?<=[A-Z])(?=[A-Z][a-z]{2})")
# digits between letters are kept with them: "n2", "o2"
_SEPARATORS = re.compile(r"[^0-9a-zа-яёͰ-Ͽ一-鿿]+")


@cache
def vocabulary(package: str, file: str) -> Mapping[str, Mapping[str, Any]]:
    """Return the words that stand in a TOML file of a package."""
    return tomllib.loads(resources.files(package).joinpath(file).read_text(encoding="utf-8"))


@lru_cache(maxsize=8192)
def words(name: str) -> str:
    """Return a name in lower-case words separated by one blank; umlauts written out, accents dropped, Cyrillic kept.

    >>> words("Getriebeöltemperatur"), words("VehicleSpeed"), words("P/L Solenoid_Valve-Pressure")
    ('getriebeoeltemperatur', 'vehicle speed', 'p l solenoid valve pressure')
    """
    text = unicodedata.normalize("NFKC", name)
    text = _CAMEL.sub(" ", text).lower().translate(_TRANSLATE)
    text = unicodedata.normalize("NFKD", text)
    # й and ё stay letters of their own
    text = "".join(
        character for character in text if not unicodedata.combining(character) or character in "\u0306\u0308"
    )
    text = unicodedata.normalize("NFKC", text)
    return _SEPARATORS.sub(" ", text).strip()
