"""Let nothing out but the package's own errors where it reads what others wrote.

A file that is damaged in a way that nobody thought of ends in an exception of whatever library met it, and so does a
fault of atleak's own on a sound one. `own_errors_only` stands at the functions through which files come in, and turns
such an exception into an error that names the file and says which of the two it was.
"""

from __future__ import annotations

import csv
import errno
import lzma
import struct
import traceback
import zipfile
import zlib
from collections.abc import Callable
from functools import wraps
from inspect import signature
from pathlib import Path, PurePath
from typing import Any, ParamSpec, TypeVar
from xml.parsers.expat import ExpatError

from atleak.common.errors import AtleakError, InputError, Place, reason_of, translates_refusals
from atleak.common.sentences import Sentence

DAMAGE: tuple[type[Exception], ...] = (
    ValueError,  # with it Unicode's errors, those of JSON, TOML, pydantic and pandas, and numbers of 5000 digits
    LookupError,
    ArithmeticError,
    TypeError,
    AttributeError,
    AssertionError,
    RuntimeError,  # of an archive under a password, of a generator that stops short; with it RecursionError
    StopIteration,
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

_OF_BYTES = (
    *(UnicodeError, EOFError, OSError, SyntaxError, MemoryError, RecursionError, ExpatError, csv.Error, struct.error),
    *(zlib.error, lzma.LZMAError, zipfile.BadZipFile, zipfile.LargeZipFile),
)
"""What compiled code says of the bytes it is given, whoever calls it: no fault of the caller."""
_PACKAGE = Path(__file__).resolve().parents[1]
_SHOWN = 200  # characters of a library's own message

Given = ParamSpec("Given")
_Result = TypeVar("_Result")


def own_errors_only(
    kind: type[InputError], *named: str
) -> Callable[[Callable[Given, _Result]], Callable[Given, _Result]]:
    """Decorate a function that reads a file so that it raises no errors but the package's own, of this kind.

    ``named`` are its parameters that may say what the file is called: the first that is a name or a path does.
    """

    def guarded(read: Callable[Given, _Result]) -> Callable[Given, _Result]:
        translated = translates_refusals(read)

        @wraps(read)
        def reading(*given: Given.args, **options: Given.kwargs) -> _Result:
            try:
                return translated(*given, **options)
            except AtleakError:
                raise
            except DAMAGE as error:
                arguments = signature(read).bind(*given, **options).arguments
                raise damaged(error, kind, _called(*(arguments.get(name) for name in named))) from error

        return reading

    return guarded


def damaged(error: BaseException, kind: type[InputError] = InputError, file: str | None = None) -> InputError:
    """Return the package's own error for one that was raised while a file was read."""
    return kind(_problem(error), place=Place(file=file))


def unexpected(error: BaseException, file: str | None = None) -> InputError:
    """Return the package's own error for a fault of the program, which stays its cause."""
    problem = Sentence(
        "unexpected {kind}: {reason}. This is a fault of atleak", kind=type(error).__name__, reason=str(error)
    )
    fault = InputError(problem, place=Place(file=file))
    fault.__cause__ = error
    return fault


def _problem(error: BaseException) -> Sentence:
    if isinstance(error, MemoryError):
        return Sentence("is too large for the memory of this computer")
    if isinstance(error, OSError) and error.errno not in (None, errno.EINVAL):  # libraries raise it without a number
        return Sentence("cannot be read from the disk: {reason}", reason=reason_of(error))
    if at := own_line(error):
        return own_fault(reason_in_short(error), at)
    return Sentence("is damaged or of a kind that cannot be read ({reason})", reason=reason_in_short(error))


def own_fault(raised: str, at: str) -> Sentence:
    """Return what to say of a fault of atleak's own: what was raised, and in which line."""
    return Sentence("atleak could not make sense of it: {reason}: please send the file", reason=f"{raised}, {at}")


OWN_FAULT = own_fault("", "").template
"""The wording of a refusal for a fault of atleak's own."""


def is_own_fault(error: BaseException) -> bool:
    """Return whether an error is a fault of atleak's own, or says that one was met."""
    if isinstance(error, InputError):
        return error.problem.template == OWN_FAULT
    return own_line(error) is not None


def own_line(error: BaseException) -> str | None:
    """Return which line of atleak raised an error by its own fault; None where a library raised it, or of bytes."""
    if isinstance(error, _OF_BYTES):
        return None
    last = next(reversed(traceback.extract_tb(error.__traceback__)), None)
    if last is None or not Path(last.filename).is_relative_to(_PACKAGE):
        return None
    return f"{Path(last.filename).relative_to(_PACKAGE).as_posix()}:{last.lineno}"


def reason_in_short(error: BaseException) -> str:
    """Return the kind of an error and the beginning of what it says, in one line that can be printed."""
    text = " ".join(str(error).encode("utf-8", "replace").decode().split())[:_SHOWN]
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def _called(*given: Any) -> str | None:
    """Return the first name among some values: a text as it stands, of a path its last part, of a file its name."""
    for value in given:
        if isinstance(value, PurePath):
            return value.name
        value = getattr(value, "name", value)
        if isinstance(value, str) and value:
            return value
    return None
