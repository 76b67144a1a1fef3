"""Write files whole, and keep the user's own: catalogue files, columns of logs, drafts.

Whoever opens a file reads the earlier one or all of the new one, never a part. Entries of a JSON file that several
programs change are written one at a time. Drafts of a person who is signed in are that person's alone; those of nobody
are everybody's.
"""

from __future__ import annotations

import contextlib
import datetime as dt
import glob
import hashlib
import json
import logging
import os
import re
import secrets
import stat
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path

from atleak.common.errors import InputError, OutputError, Place, reason_of
from atleak.common.sentences import Sentence

HOME = "ATLEAK_HOME"
"""The variable of the environment that names another folder."""

DATABASE_URL = "ATLEAK_DATABASE_URL"
"""The variable of the environment that names another database for the job book than the file in the user's folder."""

PRIVATE_FOLDER = 0o700  # that only its owner may open


def home() -> Path:
    """Return the user's folder, whether or not it is there: ``ATLEAK_HOME``, else where the system keeps such data.

    The latter is ``%LOCALAPPDATA%\\atleak`` on Windows, ``~/Library/Application Support/atleak`` on macOS, and
    ``$XDG_DATA_HOME/atleak`` (``~/.local/share/atleak``) elsewhere.
    """
    if folder := os.environ.get(HOME):
        return Path(os.path.expanduser(folder)).absolute()  # noqa: PTH111  the other one refuses the name of no user
    with suppress(ModuleNotFoundError):  # of the engine alone in an environment of few libraries
        from platformdirs import user_data_path  # only who names no folder of their own needs it

        return user_data_path("atleak", appauthor=False)
    usual = {"win32": os.environ.get("LOCALAPPDATA", "~/AppData/Local"), "darwin": "~/Library/Application Support"}
    other = os.environ.get("XDG_DATA_HOME", "").strip() or "~/.local/share"
    return Path(usual.get(sys.platform, other), "atleak").expanduser()


def made_folder(folder: Path) -> Path:
    """Make a folder where it is not there yet, and return it; the user's own is for nobody else.

    Raises
    ------
    OutputError
        naming the folder and why it cannot be made.
    """
    try:
        if folder.is_relative_to(home()):
            home().mkdir(PRIVATE_FOLDER, parents=True, exist_ok=True)
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        problem = Sentence("cannot be made: {reason}", reason=reason_of(error))
        expected = Sentence(
            "a folder that can be written; {variable} in the environment names another one", variable=HOME
        )
        raise OutputError(problem, place=Place(file=str(folder)), expected=expected) from error
    return folder


def earlier_file(name: str) -> Path | None:
    """Return a file of version 0.1.0, which kept it where programs keep their settings; None without one.

    Where ``ATLEAK_HOME`` names the folder, everything is in that folder and nothing is looked for elsewhere.
    """
    if os.environ.get(HOME):
        return None
    folder = os.environ.get("APPDATA") or os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config"
    path = Path(folder) / "atleak" / name
    return path if path.is_file() else None


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


_PATIENCE = 30  # [s] to wait for other writers
_POLL = 0.01  # [s]
_DAMAGED = ".damaged-"


@contextmanager
def rewritten(path: Path) -> Iterator[dict[str, object]]:
    """Yield the entries of the file to be changed, then write them; no other process or thread writes meanwhile.

    A damaged file is set aside, and said, before another one takes its place.

    Raises
    ------
    OutputError
        where the file cannot be written, or another program keeps it locked.
    """
    from filelock import FileLock, Timeout  # 40 ms, and most runs change nothing

    place = Place(file=str(path))
    lock = FileLock(path.with_suffix(".lock"), timeout=_PATIENCE, mode=PRIVATE)
    try:
        made_folder(path.parent)
        with lock.acquire(poll_interval=_POLL):
            entries = _load(path)
            if entries is None:
                _set_aside(path)
                entries = {}
            yield entries
            replace_file(
                path,
                json.dumps(entries, ensure_ascii=False, indent=1).encode("utf-8", "backslashreplace"),
                mode=PRIVATE,
            )
    except Timeout:
        problem = Sentence("another program has kept it locked for {seconds} s", seconds=_PATIENCE)
        raise OutputError(problem, place=place) from None
    except (OSError, NotImplementedError) as error:  # the latter: a file system without locks
        reason = reason_of(error) if isinstance(error, OSError) and error.strerror else str(error)
        problem = Sentence("cannot be written: {reason}", reason=reason)
        raise OutputError(problem, place=place) from error


def readable(path: Path) -> dict[str, object]:
    """Return the entries of the file; none where it cannot be read."""
    try:
        return _load(path) or {}
    except OSError:
        return {}


def _load(path: Path) -> dict[str, object] | None:
    """Return the entries of the file, empty where there is none; None where it is damaged."""
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except (ValueError, RecursionError):
        return None
    return entries if isinstance(entries, dict) else None


def _set_aside(path: Path) -> None:
    """Keep a damaged file under another name, where somebody may mend it, and say so to whoever runs the program."""
    name = f"{path.name}{_DAMAGED}{dt.date.today()}"
    aside = next(other for number in count(1) if not (other := path.with_name(f"{name}-{number}")).exists())
    path.rename(aside)
    problem = Sentence("was damaged and begins anew; what it held is in {file}", file=aside.name)
    logging.getLogger(__name__).warning("atleak: %s: %s", path, problem)


def damaged_before(path: Path) -> list[Path]:
    """Return what of a file was set aside because it was damaged, the earliest first; one that is so now goes there."""
    with suppress(OSError, OutputError):  # it stays where nothing may be written
        if _load(path) is None:
            with rewritten(path):
                pass
    return sorted(path.parent.glob(f"{glob.escape(path.name)}{_DAMAGED}*"))


_TOKEN = re.compile(r"[0-9a-f]{12}")


def new_token() -> str:
    """Return a name for a draft that no other has."""
    return secrets.token_hex(6)


def keep_draft(token: str, text: str, person: str = "") -> None:
    """Keep a person's draft under its name, in place of what that person's was; it stays until it is forgotten.

    Raises
    ------
    OutputError
        where the user's folder cannot be written.
    """
    replace_file(made_folder(_folder(person)) / f"{token}.json", text.encode("utf-8"), mode=PRIVATE)


def drafts(person: str = "") -> dict[str, Path]:
    """Return the files of a person's drafts, and of nobody's, by their names, the newest first."""
    files = {path.stem: path for whose in ("", person) for path in _folder(whose).glob("*.json")}
    kept = {name: path for name, path in files.items() if _TOKEN.fullmatch(name)}
    return dict(sorted(kept.items(), key=lambda each: (_written(each[1]), each[1]), reverse=True))


def _written(path: Path) -> float:
    """Return when a file was written; 0 where another page deleted it a moment ago."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0


def draft_text(token: str, person: str = "") -> str | None:
    """Return what was kept under a name; None where there is nothing that can be read."""
    try:
        return drafts(person)[token].read_text(encoding="utf-8")
    except (KeyError, OSError, ValueError):
        return None


def forget_draft(token: str, person: str = "") -> None:
    """Delete a draft, where there is one that can be deleted."""
    with contextlib.suppress(KeyError, OSError):  # the latter: held by another program
        drafts(person)[token].unlink(missing_ok=True)


def _folder(person: str) -> Path:
    folder = home() / "drafts"
    return folder / hashlib.sha256(person.encode("utf-8")).hexdigest()[:32] if person else folder
