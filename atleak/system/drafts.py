"""Keep what somebody is typing in the user's folder, so that it outlives a page that is closed or loaded anew."""

from __future__ import annotations

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
    for other in [*drafts().values()][_MOST:]:
        other.unlink(missing_ok=True)


def drafts() -> dict[str, Path]:
    """Return the files of drafts by their names, the newest first."""
    files = [path for path in _folder().glob("*.json") if _TOKEN.fullmatch(path.stem)]
    return {path.stem: path for path in sorted(files, key=lambda path: path.stat().st_mtime, reverse=True)}


def draft_text(token: str) -> str | None:
    """Return what was kept under a name; None where there is nothing that can be read."""
    if not _TOKEN.fullmatch(token):
        return None
    try:
        return (_folder() / f"{token}.json").read_text(encoding="utf-8")
    except (OSError, ValueError):
        return None


def forget_draft(token: str) -> None:
    """Delete a draft, where there is one."""
    if _TOKEN.fullmatch(token):
        (_folder() / f"{token}.json").unlink(missing_ok=True)


def _folder() -> Path:
    return home() / "drafts"
