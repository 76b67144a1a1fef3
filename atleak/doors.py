"""Let nothing out but the package's own errors where it reads what others wrote.

A file that is damaged in a way that nobody thought of ends in an exception of whatever library met it.
`own_errors_only` stands at the functions through which files come in, and turns such an exception into an error that
names the file.
"""

from __future__ import annotations

import csv
import lzma
import struct
import zipfile
import zlib
from collections.abc import Callable
from functools import wraps
from inspect import signature
from pathlib import PurePath
from typing import Any, ParamSpec, TypeVar
from xml.parsers.expat import ExpatError

from atleak.errors import AtleakError, InputError, Place
from atleak.sentence import Sentence

DAMAGE: tuple[type[Exception], ...] = (
    ValueError,  # with it Unicode's errors, those of JSON, TOML, pydantic and pandas, and numbers of 5000 digits
    LookupError,
    ArithmeticError,
    TypeError,
    AttributeError,
    AssertionError,
    NotImplementedError,
    RecursionError,
    MemoryError,
    EOFError,
    OSError,
    SyntaxError,  # XML's errors
    ExpatError,
    csv.Error,
    struct.error,
    zlib.error,
    lzma.LZMAError,
    zipfile.BadZipFile,
    zipfile.LargeZipFile,
)
"""What libraries raise on a file that they cannot make sense of."""

_SHOWN = 200  # characters of a library's own message

Given = ParamSpec("Given")
Result = TypeVar("Result")


def own_errors_only(
    kind: type[InputError], *named: str
) -> Callable[[Callable[Given, Result]], Callable[Given, Result]]:
    """Decorate a function that reads a file so that it raises no errors but the package's own.

    Parameters
    ----------
    kind
        the error to raise in place of others, which stay its cause.
    named
        the function's parameters that may say what the file is called: the first that is a name or a path does.
    """

    def guarded(read: Callable[Given, Result]) -> Callable[Given, Result]:
        @wraps(read)
        def reading(*given: Given.args, **options: Given.kwargs) -> Result:
            try:
                return read(*given, **options)
            except AtleakError:
                raise
            except DAMAGE as error:
                arguments = signature(read).bind(*given, **options).arguments
                raise damaged(error, kind, called(*(arguments.get(name) for name in named))) from error

        return reading

    return guarded


def damaged(error: BaseException, kind: type[InputError] = InputError, file: str | None = None) -> InputError:
    """Return the package's own error for one that a library raised on a file."""
    said = " ".join(str(error).encode("utf-8", "replace").decode().split())[:_SHOWN]
    reason = f"{type(error).__name__}: {said}" if said else type(error).__name__
    problem = Sentence("is damaged or of a kind that cannot be read ({reason})", reason=reason)
    return kind(problem, place=Place(file=file))


def called(*given: Any) -> str | None:
    """Return the first name among some values: a text as it stands, of a path its last part."""
    for value in given:
        if isinstance(value, PurePath):
            return value.name
        if isinstance(value, str) and value:
            return value
    return None
