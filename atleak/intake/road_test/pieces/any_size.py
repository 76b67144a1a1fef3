"""Reads a log whole where that is cheap, and in pieces where it is large."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from atleak.doors import own_errors_only
from atleak.errors import RoadTestError
from atleak.intake.road_test.files.log_file import LogFile, fitting, open_source
from atleak.intake.road_test.files.parquet_table import cells_of_parquet
from atleak.intake.road_test.importer import Job, read_as, understand, understood_whole
from atleak.intake.road_test.outcome import Understood
from atleak.intake.road_test.pieces import LARGE, in_pieces
from atleak.intake.road_test.pieces.spool import NotInPiecesError

_IN_PIECES = ("text", "parquet", "mdf")  # forms of files
_PACKED = 4  # bytes of text that a byte of an MDF file may be, which may be packed
_CELL = 8  # bytes of text that a number takes, more or less


def _size_as_text(source: LogFile) -> int:
    """Return how many bytes a log takes as text: of Parquet, by the number of its cells."""
    if source.form != "parquet":
        return source.size * (_PACKED if source.form == "mdf" else 1)
    try:
        return cells_of_parquet(source) * _CELL
    except BaseException:
        source.close()
        raise


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
    size = _size_as_text(opened)
    fits = size if memory is None else fitting(memory)
    if opened.form not in _IN_PIECES or size <= min(fits, LARGE):
        return read_as(job, understood_whole)
    try:
        understood = in_pieces(job, folder)
        if not isinstance(understood.problem, NotInPiecesError):
            return understood
        refused = understood.problem
    except NotInPiecesError as error:
        refused = error
    if size > fits:
        raise refused
    return understand(source, name=name, mapping=mapping, units=units, constants=constants, remembered=remembered)
