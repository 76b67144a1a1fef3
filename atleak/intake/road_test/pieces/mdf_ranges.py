"""Reads a large MDF file into columns on disk, range by range: each channel has the clock of its group."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from atleak.columns import DiskColumn, spans
from atleak.errors import RoadTestError
from atleak.intake.native.measurements import mdf_contents, mdf_ranges
from atleak.intake.native.process import MDF, read_apart, read_apart_in_parts
from atleak.intake.road_test.channels.assign import Assigner
from atleak.intake.road_test.channels.protocol import TableResult
from atleak.intake.road_test.clock.clocks import Clock
from atleak.intake.road_test.files.log_file import LogFile
from atleak.intake.road_test.importer import Job
from atleak.intake.road_test.mdf import check_readable, heading_of, prepared
from atleak.intake.road_test.outcome import Understood
from atleak.intake.road_test.pieces import timelines
from atleak.intake.road_test.pieces.spool import Spool, too_large_for
from atleak.intake.road_test.pieces.timelines import OF_CLOCK, PIECE, LargeTimeline
from atleak.road_test import QUANTITIES
from atleak.sentence import Sentence

RANGE = 1 << 19
"""Samples of each channel that are handed over at once."""


@dataclass(frozen=True)
class MdfInPieces:
    """What was read of an MDF file: what is known of it, what decided on its channels, and their common time."""

    blank: Understood
    assigner: Assigner
    reading: TableResult
    timeline: LargeTimeline


def read_mdf_in_pieces(job: Job, spool: Spool) -> MdfInPieces:
    """Read the channels that may hold a quantity, as `atleak.intake.road_test.mdf.understand_mdf` does.

    Raises
    ------
    RoadTestError
        as there, and for a recording of a bus, which is not read in pieces.
    """
    source = job.source
    check_readable(source)
    path = source.path or spool.file_with(source.data)
    version, channels = _contents(source, path)
    headings = tuple(heading_of(number, channel) for number, channel in enumerate(channels))
    blank, assigner, candidates = prepared(source.file, headings, 0, version, job.mapping, job.units)
    wanted = sorted({candidate.heading.index for candidate in candidates})
    longest = max(range(len(channels)), key=lambda number: (channels[number]["count"], -number))
    read = wanted or [longest]
    counts = [channels[number]["count"] for number in read]
    spool.check_room(2 * sum(counts) + (len(read) + OF_CLOCK) * max(counts))  # with stamps; and on the common base
    stamps, values = _read(source, path, [(number, channels[number]) for number in read], spool)
    for quantity in QUANTITIES:
        offered = [
            (each, values[each.heading.index], stamps[each.heading.index])
            for each in candidates
            if each.quantity == quantity
        ]
        if offered:
            assigner.decide(quantity, offered)
    main = assigner.signals.get("engine_speed") or next(iter(assigner.signals.values()), None)
    if main is None and longest not in values:
        stamps |= _read(source, path, [(longest, channels[longest])], spool)[0]
    time = stamps[longest] if main is None else main.time
    assert isinstance(time, DiskColumn)
    timeline = timelines.build(time, spool)
    reading = TableResult(len(time), timeline.told, "", Clock(np.empty(0), "s"))
    return MdfInPieces(blank, assigner, reading, timeline)


def _contents(source: LogFile, path: Path) -> tuple[str, list[Mapping[str, Any]]]:
    """Return the version of a file, and its channels that hold numbers."""
    version, channels = "", list[Mapping[str, Any]]()
    request = json.dumps({"path": str(path.absolute())}).encode("ascii")
    for kind, part in read_apart(mdf_contents, request, source.file, RoadTestError, MDF, size=source.size):
        if kind == "file":
            version = part["version"]
        elif kind == "channel":
            channels.append(part)
        else:
            expected = Sentence("the logger's export with decoded (physical) channels")
            raise too_large_for(source.file, Sentence("a recording of a CAN bus"), expected)
    return version, channels


def _read(
    source: LogFile, path: Path, chosen: Sequence[tuple[int, Mapping[str, Any]]], spool: Spool
) -> tuple[dict[int, DiskColumn], dict[int, DiskColumn]]:
    """Return the stamps and the numbers of some channels, by their places.

    Raises
    ------
    NotInPiecesError
        where one of them has no valid sample.
    """
    places: dict[int, list[int]] = {}
    indexes: dict[int, list[int]] = {}
    for number, channel in chosen:
        places.setdefault(channel["group"], []).append(number)
        indexes.setdefault(channel["group"], []).append(channel["index"])
    marked = {number for number, channel in chosen if channel["marked"]}
    own = {number: spool.column() for number in sorted(marked)}
    stamps = {group: spool.column() for group, numbers in places.items() if not marked.issuperset(numbers)}
    values = {number: spool.column() for number, _ in chosen}
    asked = {"path": str(path.absolute()), "indexes": indexes, "length": RANGE}
    request = json.dumps(asked).encode("ascii")
    parts = read_apart_in_parts(mdf_ranges, request, source.file, RoadTestError, MDF, source.size)
    with closing(parts):
        for _, part in parts:
            if part["group"] in stamps:
                stamps[part["group"]].append(np.frombuffer(part["stamps"]))
            for number, channel in zip(places[part["group"]], part["channels"], strict=True):
                values[number].append(np.frombuffer(channel["values"]))
                if number in own:
                    own[number].append(
                        np.frombuffer(part["stamps"] if channel["stamps"] is None else channel["stamps"])
                    )
    if not all(map(len, values.values())):
        what, expected = Sentence("a channel without a valid sample"), Sentence("the log without this channel")
        raise too_large_for(source.file, what, expected)
    return _shared(
        {number: own[number] if number in own else stamps[channel["group"]] for number, channel in chosen}
    ), values


def _shared(stamps: dict[int, DiskColumn]) -> dict[int, DiskColumn]:
    """Return the stamps with one column for channels that follow each other and have the same ones."""
    shared: dict[int, DiskColumn] = {}
    before: DiskColumn | None = None
    for number in sorted(stamps):
        column = stamps[number]
        if before is not None and column is not before and _equal(before, column):
            column = before
        shared[number] = before = column
    kept = {id(column) for column in shared.values()}
    for column in stamps.values():
        if id(column) not in kept:
            column.remove()
    return shared


def _equal(one: DiskColumn, other: DiskColumn) -> bool:
    return len(one) == len(other) and all(
        np.array_equal(one[start:stop], other[start:stop]) for start, stop in spans(len(one), PIECE)
    )
