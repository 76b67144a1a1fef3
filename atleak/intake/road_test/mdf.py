"""MDF 3 and 4: physical channels, and OBD2 answers found on a CAN bus. Needs the extra ``mdf`` (asammdf)."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from atleak.errors import Place, RoadTestError
from atleak.intake.native.measurements import mdf_parts
from atleak.intake.native.process import MDF, read_apart
from atleak.intake.road_test.channels.assign import Assigner, Candidate, candidates, map_columns
from atleak.intake.road_test.channels.protocol import TableResult
from atleak.intake.road_test.clock.clocks import Clock
from atleak.intake.road_test.clock.timeline import build as build_timeline
from atleak.intake.road_test.files.layout import Heading
from atleak.intake.road_test.files.log_file import LogFile
from atleak.intake.road_test.names import memory
from atleak.intake.road_test.names.matching import split_unit
from atleak.intake.road_test.outcome import Understood, finish
from atleak.road_test import QUANTITIES


@dataclass(frozen=True)
class _Raw:
    heading: Heading
    time: np.ndarray
    values: np.ndarray


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
    """Answers of service 01 among CAN frames → PID: (stamps, values).

    ``data`` are the frames' bytes, shape (frames, 8). Answers come from 7E8-7EF or, with 29 bits, 18DAF1xx; one frame
    may carry the answers to several PIDs. The first control unit that answers a PID is the one taken.
    """
    identifiers = identifiers.astype(np.int64) & 0x1FFFFFFF
    answer = ((identifiers >= 0x7E8) & (identifiers <= 0x7EF)) | (identifiers >> 8 == 0x18DAF1)
    length = data[:, 0]
    answer &= (length >= 3) & (length <= 7) & (data[:, 1] == 0x41)
    found: dict[int, list[tuple[np.ndarray, np.ndarray, np.ndarray]]] = {}
    left = np.flatnonzero(answer)
    position = np.full(len(left), 2)
    while len(left):
        codes = data[left, position]
        keep = np.zeros(len(left), bool)
        moved = position.copy()
        for code in np.unique(codes):
            pid = PIDS.get(int(code))
            if pid is None:
                continue
            rows = np.flatnonzero((codes == code) & (position + pid.size <= length[left]))
            if not len(rows):
                continue
            picked = left[rows]
            columns = position[rows][:, None] + 1 + np.arange(pid.size)
            part = data[picked[:, None], columns]
            found.setdefault(int(code), []).append((picked, identifiers[picked], pid.value(part)))
            moved[rows] = position[rows] + 1 + pid.size
            keep[rows] = moved[rows] + 1 <= length[left][rows]
        left, position = left[keep], moved[keep]
    result = {}
    for code, parts in found.items():
        rows = np.concatenate([part[0] for part in parts])
        senders = np.concatenate([part[1] for part in parts])
        values = np.concatenate([part[2] for part in parts])
        turn = np.argsort(rows, kind="stable")
        rows, senders, values = rows[turn], senders[turn], values[turn]
        first = senders == senders[0]
        result[code] = (time[rows[first]], values[first])
    return result


def understand_mdf(
    source: LogFile, mapping: Mapping[str, str], units: Mapping[str, str], constants: Mapping[str, float]
) -> Understood:
    """Reads an MDF file.

    Raises
    ------
    RoadTestError
        when asammdf is not installed, the file is damaged, or it holds bus frames that need a database.
    """
    raws, frames, version = _load(source)
    form = f"MDF {version}"
    headings = tuple(raw.heading for raw in raws)
    if not raws:
        if frames:
            raise RoadTestError(
                f"is a recording of a CAN bus ({frames} frames) without OBD2 answers: turning frames into quantities "
                "needs the car's database (DBC)",
                place=Place(file=source.file),
                expected="the logger's export with decoded (physical) channels",
            )
        raise RoadTestError("holds no channels", place=Place(file=source.file))
    assigner = Assigner(source.file, units, [heading.unit for heading in headings if heading.unit])
    if frames:
        assigner.say("obd2_decoded", f"{form}: OBD2 answers were decoded from {frames} CAN frames")
    blank = Understood(
        source.file, "", form, None, None, None, headings, (), memory.signature(h.label for h in headings)
    )
    wanted = {quantity: column for quantity, column in mapping.items() if quantity != "time"}
    found = [one for one in candidates(headings) if one.quantity != "time"]
    found = map_columns(found, headings, wanted, source.file)
    for quantity in QUANTITIES:
        offered = [_offer(one, raws) for one in found if one.quantity == quantity]
        if offered:
            assigner.decide(quantity, offered)
    main = assigner.signals.get("engine_speed") or next(iter(assigner.signals.values()), None)
    stamps = main.time if main is not None else max(raws, key=lambda raw: len(raw.time)).time
    assert stamps is not None
    timeline = build_timeline(stamps)
    reading = TableResult(len(stamps), timeline, "", Clock(stamps, "s"))
    return finish(blank, assigner, reading, constants)


def _offer(one: Candidate, raws: list[_Raw]) -> tuple[Candidate, np.ndarray, np.ndarray]:
    raw = raws[one.heading.index]
    return one, raw.values, raw.time


def _load(source: LogFile) -> tuple[list[_Raw], int, str]:
    """Channels, those decoded from OBD2 answers among them; number of CAN frames; version."""
    if importlib.util.find_spec("asammdf") is None:
        raise RoadTestError(
            "is an MDF file: reading it needs the extra 'mdf'",
            place=Place(file=source.file),
            expected="atleak installed as atleak[mdf]",
        )
    if source.data[64:66] != b"HD" and source.data[64:68] != b"##HD":
        raise RoadTestError("is a damaged MDF file: its header is missing", place=Place(file=source.file))
    raws: list[_Raw] = []
    frames, bus, version = 0, [], ""
    for kind, part in read_apart(mdf_parts, source.data, source.file, RoadTestError, MDF):
        if kind == "file":
            version = part["version"]
        elif kind == "channel":
            name = split_unit(part["label"].split("\\")[0])
            heading = Heading(len(raws), part["label"], (name.text,), part["unit"] or name.unit)
            time = raws[-1].time if part["stamps"] is None else np.frombuffer(part["stamps"])
            raws.append(_Raw(heading, time, np.frombuffer(part["values"])))
        else:
            frames += part["count"]
            if "data" in part:
                bus.append(part)
    for code, (time, values) in sorted(_obd2(bus).items()):
        pid = PIDS[code]
        label = f"{pid.name} (OBD2 01 {code:02X})"
        raws.append(_Raw(Heading(len(raws), label, (pid.name,), pid.unit or None), time, values))
    return raws, frames, version


def _obd2(bus: Sequence[Mapping[str, bytearray]]) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """The OBD2 answers among the frames of all groups."""
    if not bus:
        return {}
    time = np.concatenate([np.frombuffer(part["stamps"]) for part in bus])
    identifiers = np.concatenate([np.frombuffer(part["identifiers"], np.int64) for part in bus])
    data = np.concatenate([np.frombuffer(part["data"], np.uint8).reshape(-1, 8) for part in bus])
    turn = np.argsort(time, kind="stable")
    return decode_obd2(time[turn], identifiers[turn], data[turn])
