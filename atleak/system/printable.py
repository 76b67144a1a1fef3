"""Text for a terminal: a name from somebody's file must not move the cursor, change colours or rename the window."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TextIO

_KEPT = "\n\t"
_CONTROLS = {code: None for code in (*range(0x20), *range(0x7F, 0xA0)) if chr(code) not in _KEPT}


def printable(text: str) -> str:
    r"""The text without control characters; line ends and tabs stay.

    >>> printable("p_g \x1b[31m\x9b2J\r\x07[kPa]\n")
    'p_g [31m2J[kPa]\n'
    """
    return text.translate(_CONTROLS)


class PrintableStream:
    """A text stream that writes nothing but what is printable; in all else the stream that it stands for."""

    def __init__(self, unguarded: TextIO) -> None:
        self.unguarded = unguarded

    def write(self, text: str) -> int:
        self.unguarded.write(printable(text))
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.unguarded, name)


def unguarded(stream: TextIO) -> TextIO:
    """The stream itself, for what was made printable earlier, or is no text for a terminal."""
    return stream.unguarded if isinstance(stream, PrintableStream) else stream


@contextmanager
def printable_streams() -> Iterator[None]:
    r"""Standard output and error take any text as UTF-8, and let no control character through.

    Windows' code pages lack µ and °. A file's name that is no text of its system is shown with its bytes as ``\udce9``,
    which JSON reads back as that name. A stream that is closed swallows what is written to it, as `print` does.
    """
    earlier = sys.stdout, sys.stderr
    with open(os.devnull, "w", encoding="utf-8") as nowhere:  # noqa: PTH123 (a device, no path)
        for stream in earlier:
            if hasattr(stream, "reconfigure"):
                stream.reconfigure(encoding="utf-8", errors="backslashreplace")
        sys.stdout, sys.stderr = (PrintableStream(stream or nowhere) for stream in earlier)
        try:
            yield
        finally:
            sys.stdout, sys.stderr = earlier
