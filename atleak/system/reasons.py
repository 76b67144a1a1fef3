"""Say why a file could not be read or written, so that what the system and Python say reads in any language.

Both say it in English text alone. What is usual is known here; anything else stays as they say it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping

from atleak.sentence import Sentence

_LONGEST = 300  # characters of a parser's message worth showing
_KNOWN = (
    Sentence("Permission denied"),
    Sentence("Operation not permitted"),
    Sentence("No such file or directory"),
    Sentence("File exists"),
    Sentence("Is a directory"),
    Sentence("Not a directory"),
    Sentence("File name too long"),
    Sentence("No space left on device"),
    Sentence("Read-only file system"),
    Sentence("Input/output error"),
    Sentence("Device or resource busy"),
    # of text that is no UTF-8
    Sentence("invalid start byte"),
    Sentence("invalid continuation byte"),
    Sentence("unexpected end of data"),
    # of a TOML file
    Sentence("Invalid statement"),
    Sentence("Expected newline or end of document after a statement"),
    Sentence("Cannot overwrite a value"),
    Sentence("Expected ']' at the end of a table declaration"),
    Sentence("Expected ']]' at the end of an array declaration"),
    Sentence("Expected '=' after a key in a key/value pair"),
    Sentence("Invalid initial character for a key part"),
    Sentence("Unclosed array"),
    Sentence("Unclosed inline table"),
    Sentence("Unescaped '\\' in a string"),
    Sentence("Invalid hex value"),
    Sentence("Escaped character is not a Unicode scalar value"),
    Sentence("Unterminated string"),
    Sentence("Invalid date or datetime"),
    Sentence("Invalid value"),
    Sentence("maximum recursion depth exceeded"),
    # of a JSON file
    Sentence("Expecting value"),
    Sentence("Expecting property name enclosed in double quotes"),
    Sentence("Expecting ',' delimiter"),
    Sentence("Expecting ':' delimiter"),
    Sentence("Extra data"),
    Sentence("Unterminated string starting at"),
    Sentence("Invalid control character at"),
)
_BY_TEXT = {str(reason): reason for reason in _KNOWN}
_OF_ONE: Mapping[str, Callable[[str], Sentence]] = {  # of a TOML file too: what a single thing stands in
    r"Cannot declare (.+) twice": lambda key: Sentence("Cannot declare {key} twice", key=key),
    r"Cannot mutate immutable namespace (.+)": lambda key: Sentence("Cannot mutate immutable namespace {key}", key=key),
    r"Cannot redefine namespace (.+)": lambda key: Sentence("Cannot redefine namespace {key}", key=key),
    r"Duplicate inline table key (.+)": lambda key: Sentence("Duplicate inline table key {key}", key=key),
    r"Found invalid character (.+)": lambda sign: Sentence("Found invalid character {sign}", sign=sign),
    r"Illegal character (.+)": lambda sign: Sentence("Illegal character {sign}", sign=sign),
    r"Expected (\S+)": lambda sign: Sentence("Expected {sign}", sign=sign),
}
_PLACE = re.compile(r"(.+) \(at (?:line (\d+), column (\d+)|end of document)\)", re.DOTALL)


def reason_of(error: OSError) -> Sentence:
    """Return why: what the error carries, else what the system says, which may be in the system's language.

    >>> reason_of(PermissionError(13, "Permission denied"))
    'Permission denied'
    """
    said = error.strerror
    return said if isinstance(said, Sentence) else _known(str(said))


def text_reason(error: Exception) -> Sentence:
    """Return why a text is no TOML or JSON in UTF-8, as `tomllib`, `json` and `bytes.decode` say it.

    >>> text_reason(ValueError("Invalid value (at line 1, column 5)"))
    'Invalid value (at line 1, column 5)'
    """
    if isinstance(error, UnicodeDecodeError):
        return _undecoded(error)
    if isinstance(error, json.JSONDecodeError):
        return Sentence(
            "{reason}: line {line} column {column} (char {position})",
            reason=_known(error.msg),
            line=error.lineno,
            column=error.colno,
            position=error.pos,
        )
    text = str(error)
    at = _PLACE.fullmatch(text)
    if at is None or len(text) > _LONGEST:
        return _known(text[:_LONGEST])
    reason, line, column = _known(at[1]), at[2], at[3]
    if line is None:
        return Sentence("{reason} (at end of document)", reason=reason)
    return Sentence("{reason} (at line {line}, column {column})", reason=reason, line=line, column=column)


def _undecoded(error: UnicodeDecodeError) -> Sentence:
    first, last, reason = error.start, error.end - 1, _known(error.reason)
    if first < last:
        return Sentence(
            "'{encoding}' codec can't decode bytes in position {first}-{last}: {reason}",
            encoding=error.encoding,
            first=first,
            last=last,
            reason=reason,
        )
    return Sentence(
        "'{encoding}' codec can't decode byte 0x{byte:02x} in position {position}: {reason}",
        encoding=error.encoding,
        byte=error.object[first],
        position=first,
        reason=reason,
    )


def _known(text: str) -> Sentence:
    if text in _BY_TEXT:
        return _BY_TEXT[text]
    for pattern, said in _OF_ONE.items():
        if found := re.fullmatch(pattern, text):
            return said(found[1])
    return Sentence("{reason}", reason=text)
