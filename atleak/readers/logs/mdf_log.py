"""Reads MDF 3 and 4: physical channels, and OBD2 answers on a CAN bus. Needs the extra ``mdf`` (asammdf)."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from atleak.common.errors import RoadTestError, extra_installed
from atleak.common.sentences import Sentence
from atleak.readers import remembered_columns as memory
from atleak.readers.logs.clock import Clock
from atleak.readers.logs.columns import Assigner, find_candidates, map_columns, stated_units
from atleak.readers.logs.delimited import Filled
from atleak.readers.logs.headings import Heading
from atleak.readers.logs.log_file import LogFile
from atleak.readers.logs.names import split_unit
from atleak.readers.logs.timeline import build as build_timeline
from atleak.readers.logs.understood import TableResult, Understood, finish, labels_of
from atleak.readers.process.mdf import mdf_contents, mdf_ranges
from atleak.readers.process.parent import MDF, read_apart, read_apart_in_parts

RANGE = 1 << 19
"""Samples of each channel that are handed over at once."""


@dataclass(frozen=True)
class _MdfChannel:
    """One channel of the file: its heading, how many valid samples it has, and where they are found.

    Of an answer on a CAN bus the stamps [s] and the numbers are known already.
    """

    heading: Heading
    count: int
    cycles: int = 0  # of its group, each with a sample, valid or not
    group: int = -1
    index: int = -1
    course: tuple[np.ndarray, np.ndarray] | None = None


@dataclass(frozen=True)
class Pid:
    """A value of SAE J1979 service 01: name, unit, and how its data bytes make it."""

    name: str
    unit: str
    size: int
    value: Callable[[np.ndarray], np.ndarray]


# SAE J1979 (ISO 15031-5), service 01
PIDS: Mapping[int, Pid] = {
    0x05: Pid("Engine coolant temperature", "°C", 1, lambda data: data[:, 0] - 40.0),
    0x0C: Pid("Engine speed", "rpm", 2, lambda data: (data[:, 0] * 256.0 + data[:, 1]) / 4.0),
    0x0D: Pid("Vehicle speed", "km/h", 1, lambda data: data[:, 0].astype(float)),
    0xA4: Pid("Transmission actual gear", "", 4, lambda data: (data[:, 1] >> 4).astype(float)),
}


def decode_obd2(
    time: np.ndarray, identifiers: np.ndarray, data: np.ndarray
) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """Return the answers of service 01 among CAN frames, by PID: (stamps, values).

    ``data`` are the frames' bytes, shape (frames, 8). Answers come from 7E8-7EF or, with 29 bits, 18DAF1xx; one frame
    may carry the answers to several PIDs. The first control unit that answers a PID is the one taken.
    """
    identifiers = identifiers.astype(np.int64) & 0x1FFFFFFF
    is_answer = ((identifiers >= 0x7E8) & (identifiers <= 0x7EF)) | (identifiers >> 8 == 0x18DAF1)
    length = data[:, 0]
    is_answer &= (length >= 3) & (length <= 7) & (data[:, 1] == 0x41)
    places: dict[int, list[tuple[int, int]]] = {}  # by PID the frames that hold it, and where
    for frame in np.flatnonzero(is_answer).tolist():
        row, at = data[frame].tobytes(), 2
        while at < row[0] and (pid := PIDS.get(row[at])) is not None and at + pid.size <= row[0]:
            places.setdefault(row[at], []).append((frame, at))
            at += 1 + pid.size
    result = {}
    for code, answers in places.items():
        frames, starts = np.array(answers).T
        first = identifiers[frames] == identifiers[frames[0]]
        frames, starts, pid = frames[first], starts[first], PIDS[code]
        result[code] = time[frames], pid.value(data[frames[:, None], starts[:, None] + 1 + np.arange(pid.size)])
    return result


def understand_mdf(
    source: LogFile,
    mapping: Mapping[str, str],
    units: Mapping[str, str],
    constants: Mapping[str, float],
    every: int = 1,
    room: float = math.inf,
) -> Understood:
    """Read an MDF file, of which only the channels that may hold a quantity, of ``every`` samples one.

    A `RoadTestError` says that asammdf is not installed, the file is damaged, it holds bus frames that need a database,
    or it would take more memory than there is (``room``).
    """
    channels, frames, version = _contents(source)
    headings = tuple(channel.heading for channel in channels)
    if not headings and frames:
        problem = Sentence(
            "is a recording of a CAN bus ({frames} frames) without OBD2 answers: turning frames into quantities "
            "needs the car's database (DBC)",
            frames=frames,
        )
        raise source.error(problem, expected=Sentence("the logger's export with decoded (physical) channels"))
    if not headings:
        raise source.error(Sentence("holds no channels"))
    assigner = Assigner(source.file, units, stated_units(headings), every=every, room=room)
    assigner.leave_out(mapping)
    if frames:
        text = Sentence("{format}: OBD2 answers were decoded from {frames} CAN frames")
        assigner.say("obd2_decoded", text, format=f"MDF {version}", frames=frames)
    named_columns = {quantity: column for quantity, column in mapping.items() if quantity != "time"}
    candidates = [candidate for candidate in find_candidates(headings) if candidate.quantity != "time"]
    candidates = map_columns(candidates, headings, named_columns, source.file)
    wanted = [channels[index] for index in sorted({candidate.heading.index for candidate in candidates})]
    longest = max(channels, key=lambda channel: channel.count)
    assigner.refuse_too_large(max(each.count for each in wanted or [longest]), 8 * (len(wanted) + 1))
    samples = _samples(source, wanted or [longest], every)
    assigner.decide_all((candidate, *samples[candidate.heading.index][::-1]) for candidate in candidates)
    main = assigner.signals.get("engine_speed") or next(iter(assigner.signals.values()), None)
    if main is not None:
        stamps = main.time
    else:
        stamps, _ = (samples | _samples(source, [longest], every))[longest.heading.index]
    assert stamps is not None
    timeline = build_timeline(stamps)
    reading = TableResult(len(stamps), timeline, "", Clock(stamps, "s"))
    signature = memory.signature(labels_of(headings))
    blank = Understood(source.file, "", f"MDF {version}", None, None, None, headings, (), signature)
    return finish(blank, assigner, reading, constants)


def mdf_columns(source: LogFile) -> list[tuple[Heading, np.ndarray]]:
    """Return the heading and the numbers of every channel of an MDF file."""
    channels, _, _ = _contents(source)
    samples = _samples(source, channels)
    return [(channel.heading, samples[channel.heading.index][1]) for channel in channels]


def _contents(source: LogFile) -> tuple[list[_MdfChannel], int, str]:
    """Return the channels, with those decoded from OBD2 answers, the number of CAN frames and the version."""
    _check_readable(source)
    channels: list[_MdfChannel] = []
    frames, bus, version = 0, [], ""
    for kind, part in read_apart(mdf_contents, source.apart, source.file, RoadTestError, MDF):
        if kind == "file":
            version = part["version"]
        elif kind == "channel":
            name = split_unit(part["label"].split("\\")[0])
            heading = Heading(len(channels), part["label"], (name.text,), part["unit"] or name.unit)
            channels.append(
                _MdfChannel(heading, **{name: part[name] for name in ("count", "cycles", "group", "index")})
            )
        else:
            frames += part["count"]
            if "data" in part:
                bus.append(part)
    for code, (time, values) in sorted(_obd2(bus).items()):
        pid = PIDS[code]
        label = f"{pid.name} (OBD2 01 {code:02X})"
        heading = Heading(len(channels), label, (pid.name,), pid.unit or None)
        channels.append(_MdfChannel(heading, len(time), course=(time, values)))
    return channels, frames, version


_Course = tuple[np.ndarray, np.ndarray]
"""Stamps [s] and numbers of a channel."""


def _samples(source: LogFile, wanted: Sequence[_MdfChannel], every: int = 1) -> dict[int, _Course]:
    """Return the course of some channels by their places, of ``every`` samples one.

    Channels that follow each other and have the same stamps share them.
    """
    by_place = {channel.heading.index: channel for channel in wanted}
    read = _read_channels(source, [channel for channel in by_place.values() if channel.course is None], every)
    result: dict[int, _Course] = {}
    shared = np.empty(0)
    for index, channel in sorted(by_place.items()):
        time, values = read[index] if channel.course is None else (each[::every] for each in channel.course)
        shared = shared if np.array_equal(time, shared) else time
        result[index] = shared, values
    return result


def _read_channels(source: LogFile, channels: Sequence[_MdfChannel], every: int) -> dict[int, _Course]:
    """Return the course of channels that stand in the file."""
    groups: dict[int, list[_MdfChannel]] = {}
    for channel in channels:
        groups.setdefault(channel.group, []).append(channel)
    common = {group: Filled(these[0].cycles, every) for group, these in groups.items()}
    values = {each.heading.index: Filled(each.count, every) for each in channels}
    own = {each.heading.index: Filled(each.count, every) for each in channels if each.count < each.cycles}
    indexes = {group: [channel.index for channel in these] for group, these in groups.items()}
    parts = read_apart_in_parts(
        mdf_ranges, source.apart, source.file, RoadTestError, MDF, indexes=indexes, length=RANGE
    )
    for _, part in parts if groups else ():
        common[part["group"]].add(np.frombuffer(part["stamps"]))
        source.tell(every * len(common[part["group"]].numbers))
        for channel, read in zip(groups[part["group"]], part["channels"], strict=True):
            values[channel.heading.index].add(np.frombuffer(read["values"]))
            if channel.heading.index in own:
                stamps = part["stamps"] if read["stamps"] is None else read["stamps"]
                own[channel.heading.index].add(np.frombuffer(stamps))
    shared = {group: filled.numbers for group, filled in common.items()}  # one array for all of a group
    places = {each.heading.index: each.group for each in channels}
    return {at: (own[at].numbers if at in own else shared[group], values[at].numbers) for at, group in places.items()}


def _check_readable(source: LogFile) -> None:
    """Refuse an MDF file that is cut off, or that nothing is there to read."""
    if importlib.util.find_spec("asammdf") is None:
        problem = Sentence("is an MDF file: reading it needs the extra 'mdf'")
        raise source.error(problem, expected=extra_installed("mdf"))
    if source.head[64:66] != b"HD" and source.head[64:68] != b"##HD":
        raise source.error(Sentence("is a damaged MDF file: its header is missing"))


def _obd2(bus: Sequence[Mapping[str, bytearray]]) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """Return the OBD2 answers among the frames of all groups."""
    if not bus:
        return {}
    time = np.concatenate([np.frombuffer(part["stamps"]) for part in bus])
    identifiers = np.concatenate([np.frombuffer(part["identifiers"], np.int64) for part in bus])
    data = np.concatenate([np.frombuffer(part["data"], np.uint8).reshape(-1, 8) for part in bus])
    by_time = np.argsort(time, kind="stable")
    return decode_obd2(time[by_time], identifiers[by_time], data[by_time])
