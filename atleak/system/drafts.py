"""Keep what somebody is typing in the user's folder, so that it outlives a page that is closed or loaded anew."""

from __future__ import annotations

import contextlib
import re
import secrets
from pathlib import Path

from atleak.system.files import PRIVATE, replace_file
from atleak.system.home import home, made

_MOST = 20  # drafts that are kept, the newest
_TOKEN = re.compile(r"[0-9a-f]{12}")


def new_token() -> str:
    """Return a name for a draft that no other has."""
    return secrets.token_hex(6)


def keep_draft(token: str, text: str) -> None:
    """Keep a draft under its name, in place of what was kept under it; the oldest of too many go.

    Raises
    ------
    OutputError
        where the user's folder cannot be written.
    """
    replace_file(made(_folder()) / f"{token}.json", text.encode("utf-8"), mode=PRIVATE)
    for other in [*drafts()][_MOST:]:
        forget_draft(other)


def drafts() -> dict[str, Path]:
    """Return the files of drafts by their names, the newest first."""
    files = [(_written(path), path) for path in _folder().glob("*.json") if _TOKEN.fullmatch(path.stem)]
    return {path.stem: path for _, path in sorted(files, reverse=True)}


def _written(path: Path) -> float:
    """Return when a file was written; 0 where another page deleted it a moment ago."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0


def draft_text(token: str) -> str | None:
    """Return what was kept under a name; None where there is nothing that can be read."""
    if not _TOKEN.fullmatch(token):
        return None
    try:
        return (_folder() / f"{token}.json").read_text(encoding="utf-8")
    except (OSError, ValueError):
        return None


def forget_draft(token: str) -> None:
    """Delete a draft, where there is one that can be deleted."""
    if _TOKEN.fullmatch(token):
        with contextlib.suppress(OSError):  # held by another program, or no folder at all
            (_folder() / f"{token}.json").unlink(missing_ok=True)


def _folder() -> Path:
    return home() / "drafts"
