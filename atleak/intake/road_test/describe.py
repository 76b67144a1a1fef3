"""Writes what is understood of a log as JSON for programs, and a road test as a table in workshop units."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from atleak.intake.road_test.outcome import Understood
from atleak.intake.units import Unit, unit
from atleak.road_test import QUANTITIES, Channel, RoadTest
from atleak.version import __version__

_DELIMITERS = {"\t": "\\t", " ": "whitespace"}


def workshop_unit(quantity: str, channel: Channel | None = None) -> Unit | None:
    """Return the unit in which people see a quantity; None for plain numbers."""
    info = QUANTITIES[quantity]
    if info.unit_kind is not None:
        return unit(info.workshop_unit, info.unit_kind)
    if quantity == "lock_up" and channel is not None:
        if channel.unit in ("kPa", "bar", "psi", "MPa", "Pa", "mbar", "kgf/cm²"):
            return unit("kPa", "pressure")
        if channel.unit == "%":
            return unit("%", "ratio")
    return None


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _column(channel: Channel) -> dict[str, Any]:
    shown_unit = workshop_unit(channel.quantity, channel)
    good = channel.good
    good = good[np.isfinite(good)]
    ends = (float(good.min()), float(good.max())) if len(good) else (np.nan, np.nan)
    low, high = (shown_unit.from_si(end) for end in ends) if shown_unit else ends
    return {
        "quantity": channel.quantity,
        "column": channel.column or None,
        "unit": channel.unit or None,
        "unit_assumed": channel.unit_assumed,
        "kind": channel.kind,
        "source": channel.source,
        "samples": channel.samples,
        "suspect_samples": int(channel.suspect.sum()),
        "independent_samples": channel.independent,
        "min": _number(round(low, 9)),
        "max": _number(round(high, 9)),
        "value_unit": shown_unit.name if shown_unit else None,
        "sampling_hz": _number(channel.sampling_hz),
    }


def describe(understood: Understood) -> dict[str, Any]:
    """Return the ``import-log --json`` form: values in rpm, °C, kPa, km/h and s; ``unit`` is the file's own.

    While the log lacks an answer, ``rows`` and ``duration_s`` are None and ``needs`` says what is missing.
    """
    test = understood.road_test
    result: dict[str, Any] = {
        "atleak": __version__,
        "file": understood.file,
        "sha256": understood.sha256,
        "format": understood.format,
        "encoding": understood.encoding,
        "delimiter": _DELIMITERS.get(understood.delimiter or "", understood.delimiter),
        "decimal": understood.decimal,
        "rows": test.rows if test else None,
        "rows_left_out": understood.rows_left_out if test else None,
        "duration_s": _number(test.duration) if test else None,
        "segments": [],
        "columns": [],
        "ambiguous": [
            {"quantity": question.quantity, "candidates": list(question.candidates), "why": question.why}
            for question in understood.ambiguous
        ],
        "unused": list(understood.unused),
        "needs": str(understood.problem) if understood.problem else None,
        "messages": [{"level": each.level, "code": each.code, "text": each.text} for each in understood.messages],
    }
    if test is not None:
        result["segments"] = [
            {"start_row": each.start_row, "rows": each.rows, "start_s": each.start, "duration_s": each.duration}
            for each in understood.segments
        ]
        result["columns"] = [_time_column(understood, test), *map(_column, test.channels.values())]
    return result


def _time_column(understood: Understood, test: RoadTest) -> dict[str, Any]:
    steps = sum(segment.duration for segment in test.segments)
    count = sum(max(segment.rows - 1, 0) for segment in test.segments)
    return _column(
        Channel(
            "time", test.time, test.time, np.zeros(len(test.time), bool), understood.time_label, understood.time_unit,
            understood.time_assumed, source="logged" if understood.time_label else "derived",
            independent=len(test.time), sampling_hz=count / steps if steps > 0 else float("nan"),
        )
    )  # fmt: skip


def tidy_csv(test: RoadTest) -> str:
    """Return a road test as a plain table: one row a stamp, workshop units in the names, blank without sample."""
    columns = {"time [s]": test.time}
    for quantity, channel in test.channels.items():
        shown, values = workshop_unit(quantity, channel), test.values(quantity)
        assert values is not None
        columns[f"{quantity} [{shown.name}]" if shown else quantity] = shown.from_si(values) if shown else values
    return str(pd.DataFrame(columns).to_csv(index=False, float_format="%.10g", lineterminator="\n"))
