"""Remember the folders in which this computer keeps results of fleets, so that the dashboard can offer them.

Nobody types a path into a page: who reaches a dashboard over a network sees the folders that somebody worked with here,
and no other.
"""

from __future__ import annotations

import datetime as dt
import hashlib
from dataclasses import dataclass
from pathlib import Path

from atleak.errors import AtleakError
from atleak.fleet.results_folder import check_readable
from atleak.system.entries import damaged_before, readable, rewritten
from atleak.system.home import home

_MOST = 50  # folders that are remembered, those that were used last
_ID = 12  # digits


@dataclass(frozen=True)
class KnownFolder:
    """A folder with results of a fleet, as it was known when a command used it last."""

    path: Path
    when: str  # UTC, ISO 8601

    @property
    def id(self) -> str:
        """Return by what an address names it: no path stands there."""
        return hashlib.sha256(str(self.path).encode("utf-8", "surrogatepass")).hexdigest()[:_ID]

    @property
    def is_there(self) -> bool:
        """Tell whether it still holds results that can be read."""
        try:
            check_readable(self.path)
        except (AtleakError, OSError):
            return False
        return True


def note(folder: str | Path) -> None:
    """Remember a folder as the one that was used last; the one that was used longest ago goes from too many.

    Raises
    ------
    OutputError
        where the user's folder cannot be written.
    """
    now = dt.datetime.now(dt.UTC).isoformat(timespec="microseconds")
    with rewritten(_path()) as entries:
        entries[str(Path(folder).resolve())] = now
        for other in sorted(entries, key=lambda each: str(entries[each]), reverse=True)[_MOST:]:
            del entries[other]


def known_folders() -> tuple[KnownFolder, ...]:
    """Return the folders that are remembered, the one that was used last first, whether or not they are still there."""
    entries = readable(_path()).items()
    known = [KnownFolder(Path(path), when) for path, when in entries if isinstance(when, str)]
    return tuple(sorted(known, key=lambda each: each.when, reverse=True))


def set_aside() -> list[Path]:
    """Return the files of such folders that were set aside because they were damaged, the earliest first."""
    return damaged_before(_path())


def forget(folder: KnownFolder) -> None:
    """Remember a folder no longer; its results stay where they are.

    Raises
    ------
    OutputError
        where the user's folder cannot be written.
    """
    with rewritten(_path()) as entries:
        entries.pop(str(folder.path), None)


def _path() -> Path:
    return home() / "fleets.json"
