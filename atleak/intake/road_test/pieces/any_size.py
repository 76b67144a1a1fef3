"""Reads a log whole where that is cheap, and in pieces where it is large."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from atleak.doors import own_errors_only
from atleak.errors import RoadTestError
from atleak.intake.road_test.files.log_file import open_source
from atleak.intake.road_test.importer import Job, read_as, understand, understood_whole
from atleak.intake.road_test.outcome import Understood
from atleak.intake.road_test.pieces import LARGE, in_pieces
from atleak.intake.road_test.pieces.spool import NotInPiecesError

TIMES, BESIDE = 6, 200 << 20
"""How many times its size a text takes at most while it is read whole, and how many bytes beside."""
_IN_PIECES = ("text",)  # forms of files


def fitting(memory: int) -> int:
    """Return how many bytes of text a process reads whole that may take so much memory.

    >>> fitting(1_000_000_000) >> 20
    125
    """
    return max((memory - BESIDE) // TIMES, 0)


@own_errors_only(RoadTestError, "name", "source")
def understand_of_any_size(
    source: str | Path | bytes,
    *,
    memory: int | None = None,
    folder: Path | None = None,
    name: str | None = None,
    mapping: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    constants: Mapping[str, float] | None = None,
    remembered: Path | None = None,
) -> Understood:
    """Read a log and return what is understood of it; of a large one the samples stand in ``large``, to be closed.

    A large log that is not read in pieces is read whole where the memory suffices for it.

    Parameters
    ----------
    memory
        bytes that this process may take; unless given, as much as a large log wants.
    folder
        in which the columns of a large one are put.

    The others are those of `atleak.intake.road_test.read_road_test`.

    Raises
    ------
    RoadTestError
        as `atleak.intake.road_test.understand`.
    """
    opened = open_source(source, name)
    job = Job(opened, dict(mapping or {}), dict(units or {}), dict(constants or {}), remembered)
    fits = opened.size if memory is None else fitting(memory)
    if opened.form not in _IN_PIECES or opened.size <= min(fits, LARGE):
        return read_as(job, understood_whole)
    try:
        understood = in_pieces(job, folder)
        if not isinstance(understood.problem, NotInPiecesError):
            return understood
        refused = understood.problem
    except NotInPiecesError as error:
        refused = error
    if opened.size > fits:
        raise refused
    return understand(source, name=name, mapping=mapping, units=units, constants=constants, remembered=remembered)
