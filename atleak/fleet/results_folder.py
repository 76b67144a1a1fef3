"""Tell whose a folder for the results of a fleet is, which version wrote them, and let one program write at a time."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from atleak.errors import FleetError, Place
from atleak.sentence import Sentence, some
from atleak.system.files import not_written, replace_file
from atleak.system.reasons import reason_of
from atleak.version import __version__

FORMAT = 1  # of the data sets
_RUN, _LOCK = "run.json", "run.lock"
_KIND = "atleak fleet"  # says in `run.json` whose folder it is
_NOT_OURS = {".DS_Store", "Thumbs.db", "desktop.ini"}  # that systems put into any folder
_FREE = Sentence("a folder that is new or empty, or one with results of a fleet")


def check_readable(folder: Path) -> None:
    """Check that a folder holds results of a fleet that this version can read.

    Raises
    ------
    FleetError
        it holds none, or those of a later version.
    """
    run = _run_of(folder)
    if run is None:
        problem = Sentence("holds no results of a fleet")
        expected = Sentence("the folder that 'atleak fleet run' was given for its results")
        raise FleetError(problem, place=Place(file=str(folder)), expected=expected)
    if run["format"] > FORMAT:
        raise _other_version(folder, run)


def check_version(folder: Path) -> None:
    """Check that a folder holds no results of another version, beside which none of this can be written.

    Raises
    ------
    FleetError
        naming both versions.
    """
    run = _run_of(folder)
    if run is not None and (run["format"], run.get("atleak")) != (FORMAT, __version__):
        raise _other_version(folder, run, Sentence("another folder, or --replace to begin anew"))


def _other_version(folder: Path, run: Mapping[str, Any], expected: Sentence | None = None) -> FleetError:
    problem = Sentence(
        "holds results of atleak {theirs}, and this is atleak {own}", theirs=run.get("atleak"), own=__version__
    )
    return FleetError(problem, place=Place(file=str(folder)), expected=expected)


def check_free(folder: Path) -> None:
    """Make a folder unless it is there, and check that it is empty or a fleet's, before anything is written to it.

    Raises
    ------
    FleetError
        it holds something else.
    OutputError
        it cannot be made.
    """
    if _run_of(folder) is not None:
        return
    if folder.is_symlink() and not folder.exists():
        raise FleetError(Sentence("is a link to something that is not there"), place=Place(str(folder)), expected=_FREE)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        names = sorted(path.name for path in folder.iterdir())
    except OSError as error:
        raise not_written(folder, error) from error
    others = [name for name in names if name != _LOCK and name not in _NOT_OURS and not name.startswith(".atleak-")]
    if others:
        problem = Sentence("holds something else: {names}", names=some(others, 3))
        raise FleetError(problem, place=Place(file=str(folder)), expected=_FREE)


def locked(folder: Path) -> FileLock:
    """Lock a folder for writing until this program lets it go, or ends.

    Raises
    ------
    FleetError
        another program writes there.
    OutputError
        it cannot be locked.
    """
    lock = FileLock(folder / _LOCK, timeout=0, thread_local=False)
    try:
        lock.acquire()
    except Timeout as error:
        problem = Sentence("another run is writing its results there")
        expected = Sentence("another folder, or that run to end first")
        raise FleetError(problem, place=Place(file=str(folder)), expected=expected) from error
    except OSError as error:
        raise not_written(folder / _LOCK, error) from error
    return lock


def remove_empty(folder: Path) -> None:
    """Remove a folder in which nothing but its lock stands, as far as that is possible."""
    with contextlib.suppress(OSError):
        (folder / _LOCK).unlink(missing_ok=True)
        folder.rmdir()


def write_run(folder: Path) -> None:
    """Write down that a folder holds results of this version.

    Raises
    ------
    OutputError
        it cannot be written.
    """
    text = json.dumps({"kind": _KIND, "format": FORMAT, "atleak": __version__}, indent=2)
    replace_file(folder / _RUN, f"{text}\n".encode())


def _run_of(folder: Path) -> dict[str, Any] | None:
    """Return what the folder says of the run whose results it holds; None where it holds none."""
    path = folder / _RUN
    if folder.exists() and not folder.is_dir():
        raise FleetError(Sentence("is a file"), place=Place(file=str(folder)), expected=_FREE)
    try:
        said = json.loads(path.read_bytes())
    except FileNotFoundError:
        return None
    except OSError as error:
        problem = Sentence("cannot be read: {reason}", reason=reason_of(error))
        raise FleetError(problem, place=Place(file=str(path))) from error
    except ValueError:
        said = None
    if not isinstance(said, dict) or said.get("kind") != _KIND or not isinstance(said.get("format"), int):
        raise FleetError(Sentence("is not what a fleet's run wrote"), place=Place(file=str(path)), expected=_FREE)
    return said
