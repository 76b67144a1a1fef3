"""A table with a time column (or one per channel, or long: time, name, value) → signals and a time base."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pandas as pd

from atleak.errors import Place, RoadTestError
from atleak.intake.road_test import clocks, words_as_numbers
from atleak.intake.road_test.assign import (
    Assigner,
    Candidate,
    candidates,
    map_columns,
    plain_name,
)
from atleak.intake.road_test.cells import MISSING, Decimal, is_clock, is_destroyed, kind_of
from atleak.intake.road_test.clocks import Clock, Motion
from atleak.intake.road_test.fit import given
from atleak.intake.road_test.names import match_name, split_unit, words
from atleak.intake.road_test.table import Heading, Row, named_by_a_date
from atleak.intake.road_test.timeline import Timeline
from atleak.intake.road_test.timeline import build as build_timeline
from atleak.road_test import QUANTITIES, Segment


class Table(Protocol):
    """What a format gives: headings, a few rows to look at, and columns on request."""

    @property
    def headings(self) -> tuple[Heading, ...]: ...
    @property
    def has_header(self) -> bool: ...
    @property
    def sample(self) -> Sequence[Row]: ...
    @property
    def preamble(self) -> Sequence[Row]: ...
    @property
    def decimal(self) -> Decimal: ...
    def read(self, columns: Sequence[int]) -> pd.DataFrame: ...


@dataclass(frozen=True)
class Reading:
    """What came of a table: rows counted and the time base; the signals are with the assigner."""

    rows: int
    timeline: Timeline
    time_label: str
    clock: Clock
    long: bool = False
    used: frozenset[str] = frozenset()
    file_segments: tuple[Segment, ...] | None = None


def read_table(table: Table, assigner: Assigner, mapping: Mapping[str, str]) -> Reading:
    """Reads a table's time and quantities.

    Raises
    ------
    RoadTestError
        when no column tells the time, numbers are destroyed, another header begins in the middle, or the table has no
        header and the user has not named columns.
    """
    headings = table.headings
    if not table.has_header and not mapping:
        raise RoadTestError(
            "has no header: nothing tells what its columns are",
            place=Place(file=assigner.file),
            value="; ".join(table.sample[0][:8]) if table.sample else None,
            expected="names for the columns, such as time = 'column 1' and engine_speed = 'column 2'",
        )
    found = map_columns(candidates(headings), headings, mapping, assigner.file)
    if (shape := _long_shape(table, found, mapping)) is not None:
        return _read_long(table, shape, assigner, mapping)
    return _read_wide(table, found, assigner)


# --- wide ---------------------------------------------------------------------------------------------------


def _read_wide(table: Table, found: list[Candidate], assigner: Assigner) -> Reading:
    width = len(table.sample[0]) if table.sample else len(table.headings)
    found = [one for one in found if one.heading.index < max(width, _reach(table.sample))]
    times = _time_candidates(table, found, assigner)
    channels = [one for one in found if one.quantity != "time"]
    chosen = [one.heading.index for one in (*times, *channels)]
    frame = table.read(sorted(set(chosen))) if chosen else pd.DataFrame()
    frame, rows = _drop_lines_that_are_no_rows(frame, times, channels, table, assigner)
    columns = {one.heading.index: _numbers(one, frame, table.decimal, assigner) for one in channels}
    motions = _motions(channels, columns)
    own = _own_times(table.headings, times, channels)
    if own is not None:
        return _read_own_times(own, frame, rows, columns, table, assigner, motions)
    label, clock = _best_clock(times, frame, table, assigner, motions, rows)
    timeline = build_timeline(clock.seconds)
    if not len(timeline.time):
        raise _no_time(table, assigner)
    for quantity in QUANTITIES:
        offered = [(one, columns[one.heading.index], None) for one in channels if one.quantity == quantity]
        if offered:
            assigner.decide(quantity, offered)
    return Reading(rows, timeline, label, clock, used=frozenset([label]))


def _reach(sample: Sequence[Row]) -> int:
    return max((len(row) for row in sample), default=0)


def _time_candidates(table: Table, found: list[Candidate], assigner: Assigner) -> list[Candidate]:
    times = [one for one in found if one.quantity == "time"]
    if not any(one.mapped for one in times):
        for heading in table.headings:
            if named_by_a_date(heading) and not any(one.heading is heading for one in times):
                times.append(Candidate(heading, "time", 0, "unknown", None))
    if not times and table.headings and table.sample:
        # a column without a telling name that holds clock readings
        for heading in table.headings:
            cells = [row[heading.index] for row in table.sample if heading.index < len(row)]
            if cells and sum(is_clock(cell) for cell in cells) > 0.8 * len(cells):
                times.append(Candidate(heading, "time", 0, "unknown", None))
    return sorted(times, key=lambda one: (not one.mapped, one.tier))


def _drop_lines_that_are_no_rows(
    frame: pd.DataFrame, times: list[Candidate], channels: list[Candidate], table: Table, assigner: Assigner
) -> tuple[pd.DataFrame, int]:
    """Takes out comments, markers, repeated headers and blank lines; a different header refuses the file."""
    if frame.empty or all(dtype.kind in "fiub" for dtype in frame.dtypes):
        if not frame.empty and frame.iloc[-1].isna().all():
            blank = frame.isna().all(axis=1).to_numpy()
            tail = len(frame) - int(np.argmax(~blank[::-1])) if not blank.all() else 0
            frame = frame.iloc[:tail]
        return frame, len(frame)
    telling = np.zeros(len(frame), bool)
    worded = []
    for index in frame.columns:
        if frame[index].dtype.kind in "fiub":
            telling |= frame[index].notna().to_numpy()
        else:
            worded.append(index)
    # only rows without a single number so far need a closer look
    unclear = np.flatnonzero(~telling)
    wordy = np.zeros(len(frame), bool)
    clocks_at = {one.heading.index for one in times if _holds_clocks(table, one.heading)}
    for index in worded if len(unclear) else ():
        column = frame[index].iloc[unclear]
        text = column.astype("str").str.strip()
        plain = text.str.replace(",", ".", regex=False) if table.decimal == "," else text
        number = pd.to_numeric(plain, errors="coerce").notna()
        if index in clocks_at:
            number |= text.str.contains(r"\d:\d", regex=True, na=False)
        known = column.notna().to_numpy()
        number = number.to_numpy(dtype=bool) & known
        telling[unclear] |= number
        wordy[unclear] |= ~number & known
    text_only = wordy & ~telling
    if text_only.any():
        _refuse_another_header(frame[text_only], times + channels, assigner)
        # rows that hold nothing but words where the table has numbers are markers
        frame = frame[~text_only]
        assigner.say("lines_left_out", f"{int(text_only.sum())} comment, marker or repeated header line(s) left out")
    blank = frame.isna().all(axis=1).to_numpy()
    if blank.any():
        frame = frame[~blank]
    return frame, len(frame)


def _holds_clocks(table: Table, heading: Heading) -> bool:
    cells = [row[heading.index] for row in table.sample if heading.index < len(row)]
    return sum(is_clock(cell) for cell in cells) > 0.5 * len(cells)


def _refuse_another_header(lines: pd.DataFrame, used: list[Candidate], assigner: Assigner) -> None:
    headings = {one.heading.index: one.heading for one in used}
    for row, cells in lines.iterrows():
        other = []
        for index, cell in cells.items():
            heading = headings.get(int(index))  # type: ignore[arg-type]
            if heading is None or not isinstance(cell, str) or not cell.strip() or cell.strip().lower() in MISSING:
                continue
            if cell.strip() == heading.label or plain_name(cell) in [words(name) for name in heading.names]:
                continue
            if match_name(split_unit(cell).text) is not None:
                other.append((cell.strip(), heading.label))
        if len(other) >= 2 or (other and len(lines.columns) == 1):
            raise RoadTestError(
                "another header with other columns begins in the middle of the log",
                place=Place(file=assigner.file, row=None, column=other[0][1]),
                value=other[0][0],
                expected=f"one header; split the file at data row {int(row) + 1}",  # type: ignore[call-overload]
            )


def _numbers(one: Candidate, frame: pd.DataFrame, decimal: Decimal, assigner: Assigner) -> np.ndarray:
    from atleak.intake.road_test.delimited import numbers

    column = frame[one.heading.index]
    values, strange = numbers(column, decimal)
    if not strange:
        return _without_thousands(one, values, assigner)
    texts = column.dropna().astype("str")
    if one.quantity in ("gear", "selector", "lock_up"):
        if one.quantity == "gear" and words_as_numbers.only_positions(column):
            assigner.say("gear_is_selector", f"{one.label!r} holds selector positions, no gears", "info", one.label)
            return np.full(len(values), np.nan)
        worded = words_as_numbers.as_numbers(one.quantity, column)
        return np.where(np.isnan(values), worded, values)
    bad = texts[pd.to_numeric(texts.str.replace(",", ".", regex=False), errors="coerce").isna()]
    bad = bad[~bad.str.strip().str.lower().isin(MISSING)]
    destroyed = next((text for text in bad.head(50) if is_destroyed(text)), None)
    if destroyed is not None or strange > 0.02 * len(values):
        shown = destroyed or (bad.iloc[0] if len(bad) else "")
        what = "numbers a spreadsheet has destroyed" if destroyed else "text instead of numbers"
        assigner.say("column_refused", f"{one.label!r} holds {what} ({shown}): it is not used", "warning", one.label)
        return np.full(len(values), np.nan)
    assigner.say(
        "cells_unreadable",
        f"{one.label!r}: {strange} cell(s) are no numbers ({bad.iloc[0] if len(bad) else ''}) and left out",
        "warning",
        one.label,
    )
    return values


def _without_thousands(one: Candidate, values: np.ndarray, assigner: Assigner) -> np.ndarray:
    """Refuses a column in which 1.250 stands for 1250: whole numbers up to 999 beside small ones with three decimals."""
    if QUANTITIES[one.quantity].unit_kind != "rotational_speed" or not len(values):
        return values
    part = values[:: max(1, len(values) // 50_000)]
    small = part[(part >= 1) & (part < 16) & (part != np.round(part))]
    whole = part[part == np.round(part)]
    if len(small) < 3 or np.abs(small * 1000 - np.round(small * 1000)).max() > 1e-6:
        return values
    if len(whole) and np.median(whole) > 100 and len(small) + len(whole) + np.isnan(part).sum() == len(part):
        text = f"{one.label!r} mixes numbers such as {small[0]:.3f} and {whole[0]:.0f}: a thousands sign was taken for a decimal sign"
        assigner.say("column_refused", text + "; it is not used", "warning", one.label)
        return np.full(len(values), np.nan)
    return values


def _motions(channels: list[Candidate], columns: Mapping[int, np.ndarray]) -> list[Motion]:
    limits = {"engine_speed": 12000.0, "vehicle_speed": 60.0}
    return [Motion(columns[one.heading.index], limits[one.quantity]) for one in channels if one.quantity in limits]


def _clock_of(
    one: Candidate, frame: pd.DataFrame, table: Table, assigner: Assigner, motions: Sequence[Motion]
) -> Clock | None:
    from atleak.intake.road_test.delimited import numbers

    column = frame[one.heading.index]
    unit = assigner.units.get("time", one.unit)
    if "time" in assigner.units:
        unit = given("time", assigner.units["time"]).unit.name  # type: ignore[union-attr]
    if column.dtype.kind == "M" or _typed(column):
        return Clock(clocks.from_datetimes(column.tolist()), "clock", False, "date and time")
    if column.dtype.kind not in "fiub":
        texts = column.dropna().astype("str")
        probe = texts.iloc[:200].tolist() + texts.iloc[-50:].tolist()
        if sum(is_clock(text) for text in probe) > 0.5 * len(probe):
            return clocks.text_clock(column)
        destroyed = next((text for text in probe if is_destroyed(text)), None)
        if destroyed:
            assigner.say(
                "column_refused",
                f"{one.label!r}: a spreadsheet has destroyed its numbers ({destroyed})",
                "warning",
                one.label,
            )
            return None
    values, strange = numbers(column, table.decimal)
    good = np.isfinite(values)
    if good.sum() < 0.5 * len(values) or strange > 0.05 * len(values):
        return None
    if _cut_short(one, table, values[good]):
        assigner.say(
            "column_refused",
            f"{one.label!r}: a spreadsheet has cut its numbers short ({_cell(table, one)})",
            "warning",
            one.label,
        )
        return None
    return clocks.numeric_clock(values, unit, [] if not good.all() else motions)


def _typed(column: pd.Series) -> bool:
    import datetime as dt

    if column.dtype != object:
        return False
    first = next((cell for cell in column.head(50) if cell is not None and cell == cell), None)
    return isinstance(first, dt.datetime | dt.time | dt.timedelta)


def _cell(table: Table, one: Candidate) -> str:
    index = one.heading.index
    return next((row[index] for row in table.sample if index < len(row) and is_destroyed(row[index])), "")


def _cut_short(one: Candidate, table: Table, values: np.ndarray) -> bool:
    """1,51E+12 in row after row: three digits are left of a long number."""
    index = one.heading.index
    cells = [row[index] for row in table.sample if index < len(row) and row[index]]
    return bool(cells) and sum(is_destroyed(cell) for cell in cells) > 0.3 * len(cells)


def _best_clock(
    times: list[Candidate], frame: pd.DataFrame, table: Table, assigner: Assigner, motions: Sequence[Motion], rows: int
) -> tuple[str, Clock]:
    read: list[tuple[Candidate, Clock]] = []
    for one in times:
        clock = _clock_of(one, frame, table, assigner, motions)
        if clock is not None and _runs(clock.seconds):
            read.append((one, clock))
            if one.mapped:
                break
    if not read:
        counted = _clock_from_preamble(table, rows)
        if counted is None:
            raise _no_time(table, assigner)
        assigner.say(
            "time_counted", f"no time column: time is counted from the interval in the file's head ({counted[1]:g} s)"
        )
        return "", Clock(np.arange(rows) * counted[1], "s", False, "counted")
    best = max(read, key=lambda pair: (pair[0].mapped, -pair[0].tier, _stamps(pair[1].seconds)))
    _compare_clocks(best, read, assigner)
    for note in best[1].notes:
        assigner.say("clock", note, "warning", best[0].label)
    if best[1].unit_assumed:
        text = f"{best[0].label!r} states no unit; {best[1].unit} is assumed for time"
        assigner.say("unit_assumed", f"{text}: confirm or name the unit", "warning", best[0].label)
    return best[0].label, best[1]


def _runs(seconds: np.ndarray) -> bool:
    finite = seconds[np.isfinite(seconds)]
    return len(finite) > 0 and (len(seconds) == 1 or bool(finite.max() > finite.min()))


def _stamps(seconds: np.ndarray) -> int:
    return int((np.diff(seconds[np.isfinite(seconds)]) > 0).sum())


def _compare_clocks(best: tuple[Candidate, Clock], read: list[tuple[Candidate, Clock]], assigner: Assigner) -> None:
    span = np.ptp(best[1].seconds[np.isfinite(best[1].seconds)])
    for one, clock in read:
        if one is best[0]:
            continue
        other = np.ptp(clock.seconds[np.isfinite(clock.seconds)])
        if abs(other - span) > max(2.0, 0.02 * span):
            text = f"the clocks {best[0].label!r} and {one.label!r} disagree ({span:.1f} s and {other:.1f} s): the first is used"
            assigner.say("clocks_disagree", text, "warning", best[0].label)


_INTERVAL = re.compile(
    r"^(delta[_ ]?[xt]|wf_increment|sample ?interval|sampling ?interval|interval|increment|dt|abtastintervall|messintervall|okres próbkowania)\b",
    re.IGNORECASE,
)
_RATE = re.compile(
    r"^(sample[_ ]?rate|sampling[_ ]?rate|sampling[_ ]?frequency|sample[_ ]?frequency|abtastrate|abtastfrequenz|częstotliwość próbkowania)\b",
    re.IGNORECASE,
)


def _clock_from_preamble(table: Table, rows: int) -> tuple[str, float] | None:
    from atleak.intake.road_test.cells import to_float

    for row in table.preamble:
        cells = [cell for cell in re.split(r"[:=]", row[0], maxsplit=1)] + list(row[1:]) if row else []
        cells = [cell.strip() for cell in cells if cell.strip()]
        if len(cells) < 2:
            continue
        number = next((to_float(cell.split()[0], table.decimal) for cell in cells[1:] if cell.split()), float("nan"))
        if not number > 0:
            continue
        name = split_unit(cells[0])
        unit = name.unit or (cells[1].split()[1] if len(cells[1].split()) > 1 else "")
        if _INTERVAL.match(name.text):
            return name.text, number * (1e-3 if unit.lower() in ("ms", "msec") else 1.0)
        if _RATE.match(name.text):
            return name.text, 1.0 / (number * (1e3 if unit.lower() == "khz" else 1.0))
    return None


def _no_time(table: Table, assigner: Assigner) -> RoadTestError:
    refused = [message.text for message in assigner.messages if message.code == "column_refused"]
    return RoadTestError(
        "no time column" + (": " + "; ".join(refused) if refused else ""),
        place=Place(file=assigner.file),
        value=", ".join(heading.label for heading in table.headings[:12]),
        expected="a column such as 'Time (s)', or the name of the one that tells the time",
    )


# --- a time column before each channel ----------------------------------------------------------------------


def _own_times(
    headings: Sequence[Heading], times: list[Candidate], channels: list[Candidate]
) -> dict[int, Candidate] | None:
    """Channel index → its time column, where a time column of one name stands before each channel or group."""
    if any(one.mapped for one in times) and len(times) == 1:
        return None
    alike: dict[str, list[Candidate]] = {}
    for one in times:
        alike.setdefault(words(one.heading.names[0] if one.heading.names else ""), []).append(one)
    group = max(alike.values(), key=len, default=[])
    if len(group) < 2:
        return None
    group = sorted(group, key=lambda one: one.heading.index)
    result = {}
    for channel in channels:
        before = [one for one in group if one.heading.index < channel.heading.index]
        if not before:
            return None
        result[channel.heading.index] = before[-1]
    return result or {-1: group[0]}


def _read_own_times(
    own: dict[int, Candidate], frame: pd.DataFrame, rows: int, columns: dict[int, np.ndarray],
    table: Table, assigner: Assigner, motions: Sequence[Motion],
) -> Reading:  # fmt: skip
    clocks_of: dict[int, Clock] = {}
    stamps = sorted({one.heading.index: one for one in own.values()}.items())
    for index, one in stamps:
        clock = _clock_of(one, frame, table, assigner, motions)
        if clock is not None and _runs(clock.seconds):
            clocks_of[index] = clock
    if not clocks_of:
        raise _no_time(table, assigner)
    first = min(clocks_of)
    base = build_timeline(clocks_of[first].seconds)
    found = [one for one in candidates(table.headings) if one.heading.index in columns and one.quantity != "time"]
    for quantity in QUANTITIES:
        offered = []
        for one in found:
            stamp = own.get(one.heading.index)
            if one.quantity != quantity or stamp is None or stamp.heading.index not in clocks_of:
                continue
            values = columns[one.heading.index]
            if stamp.heading.index == first:
                offered.append((one, values, None))
                continue
            timeline = build_timeline(clocks_of[stamp.heading.index].seconds)
            values = values if timeline.order is None else values[timeline.order]
            good = np.isfinite(values)
            offered.append((one, values[good], timeline.time[good]))
        if offered:
            assigner.decide(quantity, offered)
    label = dict(stamps)[first].label
    return Reading(rows, base, label, clocks_of[first], used=frozenset([label]))


# --- long: time, name, value, unit --------------------------------------------------------------------------

_NAME_HEADERS = {
    "pid",
    "name",
    "signal",
    "channel",
    "parameter",
    "sensor",
    "kanal",
    "key",
    "item",
    "variable",
    "description",
    "signal name",
    "sensor name",
    "measurement",
    "parametr",
    "parameter name",
}
_VALUE_HEADERS = {
    "value",
    "values",
    "wert",
    "messwert",
    "reading",
    "wartosc",
    "valeur",
    "valor",
    "значение",
    "data",
    "physical value",
}
_UNIT_HEADERS = {"unit", "units", "einheit", "jednostka", "unite", "unidade", "единицы"}


@dataclass(frozen=True)
class _Long:
    time: Candidate
    name: Heading
    value: Heading
    unit: Heading | None


def _long_shape(table: Table, found: list[Candidate], mapping: Mapping[str, str]) -> _Long | None:
    headings = [heading for heading in table.headings if heading.index < _reach(table.sample)]
    if not 3 <= len(headings) <= 8 or not table.sample:
        return None
    times = [one for one in found if one.quantity == "time"]
    if not times:
        return None
    plain = {heading.index: words(heading.names[0]) if heading.names else "" for heading in headings}
    name = next((h for h in headings if plain[h.index] in _NAME_HEADERS and _wordy(table, h)), None)
    value = next((h for h in headings if plain[h.index] in _VALUE_HEADERS), None)
    if name is None and value is not None:
        name = next((h for h in headings if h is not value and _names_quantities(table, h)), None)
    if name is None or value is None or any(quantity != "time" for quantity in mapping) and _names_in(table, mapping):
        return None
    unit = next((h for h in headings if plain[h.index] in _UNIT_HEADERS), None)
    return _Long(times[0], name, value, unit)


def _names_in(table: Table, mapping: Mapping[str, str]) -> bool:
    labels = {heading.label for heading in table.headings}
    return all(column in labels for column in mapping.values())


def _cells(table: Table, heading: Heading) -> list[str]:
    return [row[heading.index] for row in table.sample if heading.index < len(row)]


def _wordy(table: Table, heading: Heading) -> bool:
    cells = _cells(table, heading)
    return bool(cells) and sum(kind_of(cell, table.decimal) == "text" for cell in cells) > 0.8 * len(cells)


def _names_quantities(table: Table, heading: Heading) -> bool:
    return _wordy(table, heading) and any(match_name(split_unit(cell).text) for cell in set(_cells(table, heading)))


def _read_long(table: Table, shape: _Long, assigner: Assigner, mapping: Mapping[str, str]) -> Reading:
    from atleak.intake.road_test.delimited import numbers

    columns = [shape.time.heading.index, shape.name.index, shape.value.index]
    if shape.unit:
        columns.append(shape.unit.index)
    frame = table.read(sorted(set(columns)))
    names = frame[shape.name.index].astype("str").str.strip()
    keep = frame[shape.name.index].notna() & (names != shape.name.label)
    frame, names = frame[keep], names[keep]
    clock = _clock_of(shape.time, frame, table, assigner, ())
    if clock is None or not _runs(clock.seconds):
        raise _no_time(table, assigner)
    if clock.unit_assumed:
        text = f"{shape.time.label!r} states no unit; {clock.unit} is assumed for time"
        assigner.say("unit_assumed", f"{text}: confirm or name the unit", "warning", shape.time.label)
    whole = build_timeline(clock.seconds)
    ascending = np.full(len(frame), np.nan)
    ascending[whole.order if whole.order is not None else slice(None)] = whole.time
    values, _ = numbers(frame[shape.value.index], table.decimal)
    texts = frame[shape.value.index]
    codes, uniques = pd.factorize(names)
    headings = []
    for index, name in enumerate(uniques):
        split = split_unit(str(name))
        unit = split.unit
        if unit is None and shape.unit is not None:
            stated = frame[shape.unit.index].to_numpy(dtype=object)[codes == index]
            unit = next((str(cell) for cell in stated if isinstance(cell, str) and cell.strip()), None)
        headings.append(Heading(index, str(name), (split.text,), unit))
    found = candidates(headings)
    own_mapping = {quantity: column for quantity, column in mapping.items() if quantity != "time"}
    found = map_columns(found, headings, own_mapping, assigner.file)
    assigner.neighbours = tuple(heading.unit for heading in headings if heading.unit)
    stamps: list[np.ndarray] = []
    for quantity in QUANTITIES:
        offered = []
        for one in found:
            if one.quantity != quantity or quantity == "time":
                continue
            rows = codes == one.heading.index
            own = values[rows]
            if quantity in ("gear", "selector", "lock_up") and np.isnan(own).all():
                own = words_as_numbers.as_numbers(quantity, texts[rows])
            good = np.isfinite(own) & np.isfinite(ascending[rows])
            time = ascending[rows][good]
            turn = np.argsort(time, kind="stable")
            offered.append((one, own[good][turn], time[turn]))
        if offered:
            assigner.decide(quantity, offered)
            if quantity in assigner.signals:
                stamps.append(assigner.signals[quantity].time)  # type: ignore[arg-type]
    base = np.unique(np.concatenate(stamps)) if stamps else np.unique(whole.time)
    timeline = _on_base(base, whole)
    names_there = frozenset(map(str, uniques))
    return Reading(len(frame), timeline, shape.time.label, clock, True, names_there, whole.segments)


def _on_base(base: np.ndarray, whole: Timeline) -> Timeline:
    segments = []
    for segment in whole.segments:
        low = int(np.searchsorted(base, segment.start, side="left"))
        high = int(np.searchsorted(base, segment.stop, side="right"))
        if high > low:
            segments.append(Segment(low, high - low, float(base[low]), float(base[high - 1] - base[low])))
    return Timeline(
        base,
        None,
        tuple(segments),
        whole.duration,
        whole.unreadable,
        whole.stale,
        whole.reordered,
        whole.restarts,
        whole.gaps,
    )
