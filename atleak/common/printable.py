"""Text for a terminal: a name from somebody's file must not move the cursor, change colours or rename the window."""

from __future__ import annotations

import logging
import os
import reprlib
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import fields
from typing import Any, TextIO, TypeVar, cast

_KEPT = "\n\t"
_LONGEST = 2000  # characters of a result at the prompt: choice of this project
_PARTS = reprlib.Repr()
_PARTS.maxtuple = _PARTS.maxdict = _PARTS.maxfrozenset = 2
_PARTS.maxstring = _PARTS.maxother = 120
_Result = TypeVar("_Result")
_CONTROLS = {code: None for code in (*range(0x20), *range(0x7F, 0xA0)) if chr(code) not in _KEPT}


def printable(text: str) -> str:
    r"""The text without control characters; line ends and tabs stay.

    >>> printable("p_g \x1b[31m\x9b2J\r\x07[kPa]\n")
    'p_g [31m2J[kPa]\n'
    """
    return text.translate(_CONTROLS)


def brief(result: type[_Result]) -> type[_Result]:
    """Let the results of a dataclass show the beginning of each field at the prompt: they hold megabytes.

    Whatever compares results, or keeps something by them, uses their fields or a hash of the file: never this text.
    """

    def shown(self: Any) -> str:
        parts = (f"{each.name}={_PARTS.repr(getattr(self, each.name))}" for each in fields(self) if each.repr)
        text = f"{type(self).__name__}({', '.join(parts)})"
        return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 2]}…)"

    result.__repr__ = shown  # type: ignore[assignment,method-assign]
    return result


class PrintableStream:
    """A text stream that writes nothing but what is printable; in all else the stream that it stands for."""

    def __init__(self, unguarded: TextIO, asked_for: TextIO | None = None) -> None:
        self.unguarded = unguarded
        self.asked_for = asked_for  # another stream, where that goes which somebody asked to have on this very stream

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


def asked_for(stream: TextIO) -> TextIO:
    """The stream for what somebody asked to have on it, which `only_what_is_asked_for` lets through."""
    return stream.asked_for or stream if isinstance(stream, PrintableStream) else stream


@contextmanager
def only_what_is_asked_for() -> Iterator[None]:
    """Swallow what is printed on standard output, but what `asked_for` takes there."""
    printed = sys.stdout
    with open(os.devnull, "w", encoding="utf-8") as nowhere:  # noqa: PTH123 (a device, no path)
        sys.stdout = PrintableStream(nowhere, printed)
        try:
            yield
        finally:
            sys.stdout = printed


def printable_log() -> None:
    """Let no control character through to standard error from now on, where a server logs tracebacks.

    Handlers of loggers keep the stream that stood there when they were made: those get the guarded one too.
    """
    if sys.stderr is None:  # of a program without a console
        return
    plain = unguarded(sys.stderr)
    guarded = cast(TextIO, PrintableStream(plain))
    sys.stderr = guarded
    loggers = (logging.getLogger(name) for name in list(logging.root.manager.loggerDict))
    for handler in (handler for logger in (logging.root, *loggers) for handler in logger.handlers):
        if isinstance(handler, logging.StreamHandler) and handler.stream in (plain, sys.__stderr__):
            handler.setStream(guarded)


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
