"""Reads logs that are larger than memory, piece by piece, into columns on disk: a `atleak.large_log.LargeLog`.

What a log's columns are, what is suspect in them and how they lie on the common base is decided as for a log that is
held in memory, by the same code where it can be: each block of the file is read as a file of its own, and what must be
known of the whole (how many cells are no numbers, the median step, the samples in the middle) is counted as the
blocks come, or looked up in the columns on disk.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from atleak.columns import DiskColumn
from atleak.doors import own_errors_only
from atleak.errors import Place, RoadTestError
from atleak.intake.road_test.channels.assign import Assigner
from atleak.intake.road_test.channels.protocol import LogTable, TableResult
from atleak.intake.road_test.files.decoding import to_text
from atleak.intake.road_test.files.log_file import HEAD, LogFile, open_source
from atleak.intake.road_test.files.parquet_table import open_parquet
from atleak.intake.road_test.files.rows import one_line_end
from atleak.intake.road_test.importer import Job, assigner_for, blank_of, located, read_as
from atleak.intake.road_test.outcome import Understood, finish
from atleak.intake.road_test.pieces.channels import large_channels
from atleak.intake.road_test.pieces.mdf_ranges import read_mdf_in_pieces
from atleak.intake.road_test.pieces.spool import Spool, too_large_for
from atleak.intake.road_test.pieces.table import Blocks, read_in_pieces
from atleak.intake.road_test.pieces.text_blocks import blocks_of_text
from atleak.intake.road_test.pieces.timelines import LargeTimeline
from atleak.large_log import PIECE, LargeLog
from atleak.road_test import Channel
from atleak.sentence import Sentence

LARGE = 200 << 20
"""Bytes from which on a log is read in pieces where nobody looks at its samples; held, it takes six times that."""


class _Located(NamedTuple):
    """A table that was found but not read, what is known of it, what gives its blocks, and how many rows it has."""

    table: LogTable
    blank: Understood
    blocks: Blocks
    rows: float  # more or less


def read_large_log(
    source: str | Path,
    *,
    name: str | None = None,
    mapping: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    constants: Mapping[str, float] | None = None,
    remembered: Path | None = None,
) -> LargeLog:
    """Read a road-test log of any size; its samples lie in a temporary folder until the log is closed.

    Parameters are those of `atleak.intake.road_test.read_road_test`.

    Raises
    ------
    RoadTestError
        as there, and where the temporary folder has no room, or the form of the log is not read in pieces.
    """
    understood = understand_in_pieces(
        source, name=name, mapping=mapping, units=units, constants=constants, remembered=remembered
    )
    if understood.large is None:
        raise understood.problem or RoadTestError(Sentence("cannot be read"), place=Place(file=understood.file))
    return understood.large


@own_errors_only(RoadTestError, "name", "source")
def understand_in_pieces(
    source: str | Path,
    *,
    name: str | None = None,
    mapping: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    constants: Mapping[str, float] | None = None,
    remembered: Path | None = None,
) -> Understood:
    """Read a log of any size and return what is understood of it, as `atleak.intake.road_test.understand` does.

    Parameters are those of `read_large_log`; the samples stand in ``large``, which is to be closed.

    Raises
    ------
    RoadTestError
        as `read_large_log`.
    """
    opened = open_source(Path(source), name)
    return in_pieces(Job(opened, dict(mapping or {}), dict(units or {}), dict(constants or {}), remembered))


def in_pieces(job: Job, folder: Path | None = None) -> Understood:
    """Return what is understood of a log that is opened, as `understand_in_pieces` does.

    Parameters
    ----------
    folder
        in which its columns are put; that of temporary files unless given.

    Raises
    ------
    RoadTestError
        as `read_large_log`.
    """
    spool = Spool(job.source.file, folder)
    try:
        understood = read_as(job, lambda each: _understood(each, spool))
    except BaseException:
        spool.close()
        raise
    if understood.large is None:
        spool.close()
        return understood
    assert understood.road_test is not None
    return replace(understood, large=replace(understood.large, head=understood.road_test))


def _understood(job: Job, spool: Spool) -> Understood:
    job.source.digest.start()
    if job.source.form == "mdf":
        read = read_mdf_in_pieces(job, spool)
        return _finished(job, read.blank, read.assigner, read.reading, read.timeline, spool)
    find = {"text": _located_text, "parquet": _located_parquet}.get(job.source.form)
    if find is None:
        raise too_large_for(job.source.file, Sentence("a workbook"), Sentence("the log as .csv or as Parquet"))
    table, blank, blocks, rows = find(job, spool)
    assigner, mapping = assigner_for(table, blank, job)
    try:
        reading, timeline = read_in_pieces(table, blocks, assigner, mapping, spool, rows)
    except RoadTestError as error:
        return replace(blank, messages=tuple(assigner.messages), problem=error, ambiguous=tuple(assigner.ambiguous))
    return _finished(job, blank, assigner, reading, timeline, spool)


def _finished(
    job: Job, blank: Understood, assigner: Assigner, reading: TableResult, timeline: LargeTimeline, spool: Spool
) -> Understood:
    """Make the road test of signals and clock, its samples on disk."""
    columns: dict[str, DiskColumn] = {}

    def make() -> Mapping[str, Channel]:
        channels, on_disk = large_channels(assigner, timeline, job.constants, spool)
        columns.update(on_disk)
        return channels

    understood = finish(blank, assigner, reading, job.constants, make)
    if understood.road_test is None:
        return understood
    large = LargeLog(understood.road_test, timeline.time, columns, timeline.begins, PIECE, spool.folder)
    return replace(understood, large=large)


def _located_text(job: Job, spool: Spool) -> _Located:
    _refuse_other_text(job.source)
    table, blank = located(job, held=False)
    if job.source.path is None:  # a small one that came packed
        table = replace(table, source=replace(job.source, path=spool.file_with(job.source.data)))
    rows = job.source.size / _bytes_a_row(job.source)
    return _Located(table, blank, lambda columns: blocks_of_text(table, columns), rows)


def _located_parquet(job: Job, _: Spool) -> _Located:
    table = open_parquet(job.source)
    return _Located(table, blank_of(job, table, "Parquet"), table.blocks, table.rows)


def _refuse_other_text(source: LogFile) -> None:
    """Refuse a text whose lines are not to be told apart byte by byte.

    Raises
    ------
    RoadTestError
        saying as what it is to be saved.
    """
    head = source.head.removesuffix(b"\r")
    other_ends = b"\r" in head and (b"\n" not in head[:HEAD] or one_line_end(head) is not head)
    if other_ends or b"\x00" in head or to_text(source.whole_lines).encoding.startswith("utf-16"):
        expected = Sentence("UTF-8 or a code page of one byte a sign, with a line feed behind every line")
        raise too_large_for(source.file, Sentence("a text of this encoding, or with such line ends,"), expected)


def _bytes_a_row(source: LogFile) -> float:
    return len(source.head) / max(source.head.count(b"\n"), 1)
