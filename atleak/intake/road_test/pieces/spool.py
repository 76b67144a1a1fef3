"""Keeps the columns of a large log in a folder on disk while it is read, and says where there is no room for them."""

from __future__ import annotations

import shutil
import tempfile
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from atleak.columns import ROOM, DiskColumn
from atleak.errors import Place, RoadTestError
from atleak.sentence import Sentence

_SPARE = 1.1  # of the room that columns are thought to need
_WIDTH = 8  # bytes of a number


class NotInPiecesError(RoadTestError):
    """A log is of a form that is not read in pieces, or there is no room for these: it may still be read whole."""


class Spool:
    """A folder with columns, deleted when it is closed."""

    def __init__(self, file: str, within: Path | None = None) -> None:
        self.file = file
        self.folder = tempfile.TemporaryDirectory(prefix="atleak-log-", dir=within)
        self._numbers = count()

    def column(self, dtype: Any = np.float64) -> DiskColumn:
        """Return a new column."""
        return DiskColumn(Path(self.folder.name) / f"{next(self._numbers)}.column", dtype)

    def file_with(self, data: bytes) -> Path:
        """Return a new file with these bytes."""
        path = Path(self.folder.name) / f"{next(self._numbers)}.log"
        path.write_bytes(data)
        return path

    def close(self) -> None:
        """Delete all columns."""
        self.folder.cleanup()

    def check_room(self, numbers: float) -> None:
        """Refuse a log whose columns the disk has no room for.

        Parameters
        ----------
        numbers
            how many stand there at most at once: those that are read, and what is made of them.

        Raises
        ------
        NotInPiecesError
            saying how much is needed, and where.
        """
        needed, free = numbers * _WIDTH * _SPARE, shutil.disk_usage(self.folder.name).free
        if needed > free:
            raise NotInPiecesError(
                Sentence(
                    "is read in pieces, for which {folder} needs {needed:.1f} GB and has {free:.1f}",
                    folder=str(Path(self.folder.name).parent),
                    needed=needed / 1e9,
                    free=free / 1e9,
                ),
                place=Place(file=self.file),
                expected=ROOM,
            )


def too_large_for(file: str, what: Sentence, expected: Sentence) -> NotInPiecesError:
    """Return the error for a large log of a form that is not read in pieces."""
    problem = Sentence("is too large to be held in memory, and {what} is not read in pieces", what=what)
    return NotInPiecesError(problem, place=Place(file=file), expected=expected)
