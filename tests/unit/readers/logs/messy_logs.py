"""Makes up logs with all that goes wrong in logs: clocks of every form that jump and stray, words, blanks, remarks."""

from __future__ import annotations

import datetime as dt

import numpy as np

from tests.unit.drives import drive

_HEADINGS = {
    "engine_speed": ("Engine Speed", "rpm", 60.0, 0.0, 0),
    "vehicle_speed": ("Vehicle Speed", "km/h", 3.6, 0.0, 1),
    "main_pressure": ("Line Pressure measured", "kPa", 1e-3, 0.0, 1),
    "atf_temperature": ("ATF Temperature", "°C", 1.0, 0.0, 1),
    "gear": ("Gear", "", 1.0, 0.0, 0),
    "turbine_speed": ("Turbine Speed", "rpm", 60.0, 0.0, 1),
}
_GEARS = {-1: "R", 0: "N", 1: "1st", 2: "2nd", 3: "3rd", 4: "4th"}
CLOCKS = ("s", "ms", "epoch", "time of day", "date and time", "digits", "half days", "none")


def messy_log(seed: int, seconds: float = 30.0, rate: float = 10.0) -> bytes:
    """Return a log as text; the same seed gives the same one."""
    generator = np.random.default_rng(seed)
    chance = generator.random

    def some(count: int) -> np.ndarray:
        return generator.integers(1, rows, int(generator.integers(0, count + 1)))

    test = drive(seed, seconds, tuple(_HEADINGS), 1.0 / rate, breaks=chance() < 0.4)
    rows, time = len(test.time), test.time.copy()
    comma = chance() < 0.3
    delimiter = ";" if comma else str(generator.choice([",", ";", "\t"]))
    stated = chance() < 0.8
    form = str(generator.choice(CLOCKS))
    if form == "none":
        time = np.arange(rows) / rate
    elif chance() < 0.25:  # the clock begins anew
        time[int(generator.integers(1, rows)) :] -= time[-1] * 0.9
    if form != "none" and chance() < 0.3:  # rows out of turn
        for row in some(4):
            time[row - 1 : row + 1] = time[row - 1 : row + 1][::-1]
    if form != "none" and chance() < 0.3:  # stray stamps
        time[some(2)] += 5000.0
    columns: dict[str, list[str]] = {}
    for name, (label, unit, factor, offset, digits) in _HEADINGS.items():
        if chance() < 0.15:
            continue
        values = np.asarray(test.values(name)) * factor + offset
        if name not in ("gear",) and chance() < 0.3:
            values[some(3)] = generator.choice([65535.0, -40.0, 9999.0, 1.0])
        if chance() < 0.2:
            at = int(generator.integers(0, rows))
            values[at : at + rows // 2] = values[at]  # frozen
        if chance() < 0.25:
            values = np.repeat(values[:: int(generator.integers(2, 6))], 6)[:rows]  # an answer that is held
            values = np.pad(values, (0, rows - len(values)), "edge")
        cells = ["" if np.isnan(value) else f"{value:.{digits}f}" for value in values]
        if name == "gear" and chance() < 0.3:
            cells = ["" if np.isnan(value) else _GEARS.get(int(value), "D") for value in values]
        elif chance() < 0.2:
            for row in some(6):
                cells[row] = str(generator.choice(["n/a", "-", "err", "Off", "12 V", "1.2.3"]))
        if chance() < 0.2:
            step = int(generator.integers(2, 9))
            cells = [cell if row % step == 0 else "" for row, cell in enumerate(cells)]
        columns[f"{label} ({unit})" if unit and stated else label] = cells
    header = [*columns]
    table = [list(row) for row in zip(*columns.values(), strict=True)] if columns else [["1"] for _ in range(rows)]
    header = header or ["Load (%)"]
    if form != "none":
        stamps = _stamps(form, time)
        header = [_CLOCK_NAMES[form] if stated else _CLOCK_NAMES[form].split(" (")[0], *header]
        table = [[stamp, *row] for stamp, row in zip(stamps, table, strict=True)]
        if chance() < 0.2:
            for row in some(4):
                table[row][0] = str(generator.choice(["", "remark", "marker 3"]))
    if comma:
        table = [[cell.replace(".", ",") for cell in row] for row in table]
    lines = [delimiter.join(row) for row in table]
    head = delimiter.join(header)
    extras = {
        0.15: "# remark", 0.3: head, 0.45: "", 0.6: delimiter * (len(header) - 1), 0.7: lines[0] + delimiter + "7",
        0.8: delimiter.join(table[0][:-1]), 0.9: '"' + lines[0],
    }  # fmt: skip
    for limit, line in extras.items():
        if limit - 0.12 < chance() < limit and chance() < 0.4:
            for row in sorted(some(3), reverse=True):
                lines.insert(int(row), line)
    if chance() < 0.2:
        lines += [delimiter * (len(header) - 1)] * int(generator.integers(1, 20))
    above = (
        ["Logger 3.1", f"Interval{delimiter}{'0,1' if comma else '0.1'} s"] if form == "none" or chance() < 0.2 else []
    )
    end = str(generator.choice(["\n", "\n", "\r\n"]))
    text = end.join([*above, head, *lines]) + ("" if chance() < 0.3 else end)
    if chance() < 0.1:
        text = text[: -int(generator.integers(1, 6))]
    return text.encode(str(generator.choice(["utf-8", "utf-8-sig", "cp1252"])))


_CLOCK_NAMES = {
    "s": "Time (s)", "ms": "Time (ms)", "epoch": "Timestamp", "time of day": "Time", "date and time": "Date Time",
    "digits": "Time", "half days": "Time",
}  # fmt: skip


def _stamps(form: str, time: np.ndarray) -> list[str]:
    begin = dt.datetime(2026, 3, 1, 23, 59, 40)
    if form == "s":
        return [f"{each:.3f}" for each in time]
    if form == "ms":
        return [f"{each * 1e3:.0f}" for each in time]
    if form == "epoch":
        return [f"{1_772_000_000_000 + each * 1e3:.0f}" for each in time]
    moments = [begin + dt.timedelta(seconds=float(each)) for each in time]
    pattern = {
        "time of day": "%H:%M:%S.%f", "date and time": "%d.%m.%Y %H:%M:%S.%f", "digits": "%H%M%S.%f",
        "half days": "%m/%d/%Y %I:%M:%S.%f %p",
    }[form]  # fmt: skip
    return [moment.strftime(pattern) for moment in moments]
