"""Say why the operating system could not read or write a file, so that it can be said in the reader's language too."""

from __future__ import annotations

from atleak.sentence import Sentence

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
)
_BY_TEXT = {str(reason): reason for reason in _KNOWN}


def reason_of(error: OSError) -> Sentence:
    """Return why: what the error carries, else what the system says, which may be in the system's language.

    >>> reason_of(PermissionError(13, "Permission denied"))
    'Permission denied'
    """
    said = error.strerror
    if isinstance(said, Sentence):
        return said
    return _BY_TEXT.get(str(said), Sentence("{reason}", reason=str(said)))
