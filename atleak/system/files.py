"""Write files whole: whoever opens one reads the earlier file or all of the new one, never a part."""

from __future__ import annotations

import contextlib
import os
import secrets
import stat
import time
from collections.abc import Iterator
from pathlib import Path

from atleak.errors import InputError, OutputError, Place
from atleak.sentence import Sentence
from atleak.system.reasons import reason_of

PRIVATE = 0o600  # a file that only its owner may read and write
_NEW = 0o666  # less what the user's umask takes away
_TRIES = 20  # at replacing a file: on Windows a reader or a virus scanner holds a file for a moment
_PAUSE = 0.05  # [s]
_LEFT = 24 * 3600.0  # [s] without a change, after which nobody writes a file that was begun


def replace_file(target: str | Path, content: bytes, *, mode: int | None = None) -> None:
    """Write a file beside its target and put it in the target's place; on any failure the earlier file stays.

    A link stays a link: the file that it leads to is replaced. A device, a pipe, or the file that standard output goes
    to cannot be replaced and is written to.

    Parameters
    ----------
    target
        where the file is to stand, in a folder that is there.
    content
        all of the file.
    mode
        permissions of the file; unless given, those of the file that it replaces, else those of any new file.

    Raises
    ------
    OutputError
        naming the target and why it cannot be written.
    """
    target = Path(target)
    try:
        earlier = _status(target)
        stream = None if earlier is None else _standard_stream(earlier)
        if stream is not None:
            with os.fdopen(os.dup(stream), "wb") as output:
                output.write(content)
        elif earlier is None or stat.S_ISREG(earlier.st_mode):
            with replacing(target, mode=mode) as beside:
                beside.write_bytes(content)
        else:
            with target.open("wb") as device:  # a folder is refused here
                device.write(content)
    except BrokenPipeError:  # the reader went away: nothing of ours is at fault
        raise
    except OSError as error:
        raise not_written(target, error) from error


def not_written(target: str | Path, error: OSError) -> OutputError:
    """Return the error for a file that cannot be written, and why."""
    problem = Sentence("cannot be written: {reason}", reason=reason_of(error))
    return OutputError(problem, place=Place(file=str(target)))


@contextlib.contextmanager
def replacing(target: str | Path, *, mode: int | None = None) -> Iterator[Path]:
    """Give the path of a new file beside its target, to be written by something else, and put it in the target's place.

    On any failure the earlier file stays, and nothing else of the new one.

    Parameters
    ----------
    mode
        permissions of the file, which is there empty; unless given, those of the file that it replaces, else those of
        any new file.

    Raises
    ------
    OutputError
        naming the target and why it cannot be written.
    """
    place = Path(os.path.realpath(target))  # a link stays a link
    try:
        earlier = _status(place)
        if earlier is not None and not os.access(place, os.W_OK):
            raise PermissionError(None, Sentence("it is write-protected"))
        wanted = stat.S_IMODE(earlier.st_mode) if mode is None and earlier is not None else mode
        beside = _new_name(place)
        try:
            if place.parent.is_dir():  # else whatever writes the file says so in its way
                _make(beside, _NEW if wanted is None else wanted)
                if earlier is not None and hasattr(os, "chown"):
                    with contextlib.suppress(OSError):  # another owner's file in a shared folder
                        os.chown(beside, earlier.st_uid, earlier.st_gid)
                if wanted is not None:
                    beside.chmod(wanted)  # the umask does not count for a file that was there
            yield beside
            with beside.open("rb+") as stream:
                os.fsync(stream.fileno())
            _put_in_place(beside, place)
        finally:
            with contextlib.suppress(OSError):
                beside.unlink()
    except OSError as error:
        raise not_written(target, error) from error


def _new_name(target: Path) -> Path:
    """Return the name of a new file beside its target, where what a killed process has left goes after a day."""
    now = time.time()
    with contextlib.suppress(OSError):  # another process was first, or may not read the folder
        for each in target.parent.glob(".atleak-*.part*"):
            if now - each.stat().st_mtime > _LEFT:
                each.unlink()
    return target.with_name(f".atleak-{secrets.token_hex(8)}.part")


def _status(path: Path) -> os.stat_result | None:
    try:
        return path.stat()
    except FileNotFoundError:
        return None


def _standard_stream(status: os.stat_result) -> int | None:
    """Return standard output or error where it goes to this same file, as /dev/stdout does; else None."""
    for stream in (1, 2):
        with contextlib.suppress(OSError):  # a stream that is closed
            if os.path.samestat(status, os.fstat(stream)):
                return stream
    return None


def _make(beside: Path, mode: int) -> None:
    try:
        os.close(os.open(beside, os.O_CREAT | os.O_EXCL, mode))
    except PermissionError as error:
        folder = Sentence("nothing may be written in its folder, where a new file is made first")
        reason = Sentence("{problem}: {reason}", problem=reason_of(error), reason=folder)
        raise PermissionError(error.errno, reason) from error


def _put_in_place(beside: Path, target: Path) -> None:
    for tries_left in reversed(range(_TRIES)):
        try:
            beside.replace(target)
            return
        except PermissionError as error:
            if not tries_left:
                question = Sentence("is it open in another program, Excel for instance?")
                reason = Sentence("{problem}: {reason}", problem=reason_of(error), reason=question)
                raise PermissionError(error.errno, reason) from error
            time.sleep(_PAUSE)


def shipped(name: str) -> Path:
    """A file that lies beside the package: inside an installed wheel, or at the root of a checkout.

    Raises
    ------
    InputError
        where neither has it.
    """
    package = Path(__file__).resolve().parents[1]
    for folder in (package / "_dashboard", package.parent):
        if (folder / name).exists():
            return folder / name
    problem, expected = Sentence("{file} is not beside the package", file=name), Sentence("a complete installation")
    raise InputError(problem, place=Place(file=str(package)), expected=expected)
