"""Keep what somebody is typing in the user's folder, so that it outlives a page that is closed or loaded anew.

Drafts of a person who is signed in are that person's alone; those of nobody are everybody's.
"""

from __future__ import annotations

import contextlib
import hashlib
import re
import secrets
from pathlib import Path

from atleak.system.files import PRIVATE, replace_file
from atleak.system.home import home, made

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
    replace_file(made(_folder(person)) / f"{token}.json", text.encode("utf-8"), mode=PRIVATE)


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
