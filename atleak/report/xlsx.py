"""A diagnosis as an Excel workbook."""

from __future__ import annotations

import io
import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import xlsxwriter
from xlsxwriter.format import Format
from xlsxwriter.worksheet import Worksheet

from atleak.diagnosis import Diagnosis
from atleak.report.record import DM3_MIN, KPA, PERCENT, RPM, diagnosis_record
from atleak.report.text import SYMBOLS, WORDS
from atleak.road_leakage import RoadLeakage

ROAD_ROWS = 2000  # of the down-sampled road test
_CELL_LIMIT = 32_767  # characters Excel allows in a cell


def write_workbook(diagnosis: Diagnosis) -> bytes:
    """The workbook's bytes: summary, lands, gaps, rules, road test, messages, provenance.

    Text is always written as text: nothing a user typed becomes a formula or a link.
    """
    target = io.BytesIO()
    options = {"in_memory": True, "strings_to_formulas": False, "strings_to_urls": False, "strings_to_numbers": False}
    with xlsxwriter.Workbook(target, options) as workbook:
        _Writer(workbook, diagnosis).write()
    return target.getvalue()


class _Writer:
    def __init__(self, workbook: xlsxwriter.Workbook, diagnosis: Diagnosis) -> None:
        self.workbook, self.diagnosis = workbook, diagnosis
        self.record = diagnosis_record(diagnosis)
        self.heading = workbook.add_format({"bold": True, "bottom": 1, "text_wrap": True, "valign": "top"})
        self.title = workbook.add_format({"bold": True, "font_size": 14})
        self.bold = workbook.add_format({"bold": True})

    def write(self) -> None:
        self.summary()
        self.table("Lands", [_flat(row, {"rules", "messages", "representative"}) for row in self.record["lands"]])
        self.table("Gaps", self.record["gaps"])
        self.table("Rules", list(self.rules()))
        if self.diagnosis.road is not None:
            self.road(self.diagnosis.road)
        self.table("Messages", [_flat(row, {"place"}) for row in self.record["messages"]])
        self.provenance()

    def summary(self) -> None:
        record, sheet = self.record, self.workbook.add_worksheet("Summary")
        _put(sheet, 0, 0, "Internal leakage of a valve body", self.title)
        rows: list[tuple[str, Any]] = [
            ("controller", record["controller"]["name"]),
            ("representative", record["controller"]["representative_note"]),
            ("fluid", record["fluid"]["name"]),
            ("limits", record["limits"]["name"]),
            ("profile", self.diagnosis.profile.label),
            ("mileage [km]", record["mileage_km"]),
            ("readings", record["readings"]["file"]),
            ("lands measured", f"{record['readings']['lands_measured']} of {record['readings']['lands_total']}"),
            ("verdict (worst land)", _verdict(record["verdict"])),
            ("flagged lands", len(self.diagnosis.flagged)),
        ]
        row = self.pairs(sheet, 2, rows)
        for name in ("projection", "hot_idle"):
            if record[name] is not None:
                row = self.pairs(sheet, row + 1, record[name].items())
        row = self.pairs(sheet, row + 1, [("Flagged lands, the worst first", None)])
        flagged = [
            {
                "verdict": _verdict(found.verdict),
                "component": found.state.land.component,
                "land": found.state.land.land,
                "radial_clearance_um": found.state.radial_clearance * 1e6,
                "mounting_clearance_um": found.state.land.mounting_clearance * 1e6,
                "share_percent": found.share * PERCENT,
                "because": found.deciding.label if found.deciding else None,
                "origin of the limit": found.deciding.origin if found.deciding else None,
            }
            for found in self.diagnosis.flagged
        ]
        self.rows(sheet, row, flagged)
        sheet.set_column(0, 0, 26)
        sheet.set_column(1, 8, 18)

    def rules(self) -> Iterable[dict[str, Any]]:
        for land in self.record["lands"]:
            for rule in land["rules"]:
                yield {"component": land["component"], "land": land["land"], **rule}

    def road(self, road: RoadLeakage) -> None:
        sheet, record = self.workbook.add_worksheet("Road test"), self.record["road_test"]
        rows: list[tuple[str, Any]] = [(name, record[name]) for name in ("file", "sha256", "rows", "duration_s")]
        rows.append(("gears", ", ".join(map(str, record["gears"]))))
        rows += [(f"share of volume leaked, {name}", value) for name, value in record["sections"].items()]
        row = self.pairs(sheet, 0, rows)
        instants = [
            {"instant": name, **record[name]} for name in ("max_leakage", "min_leakage", "max_share") if record[name]
        ]
        row = self.rows(sheet, row + 1, instants)
        names, arrays = zip(*_series(road).items(), strict=True)
        for column, name in enumerate(names):
            _put(sheet, row + 1, column, name, self.heading)
        keep = np.unique(np.linspace(0, len(road.time) - 1, min(ROAD_ROWS, len(road.time))).astype(int))
        for line, index in enumerate(keep, start=row + 2):
            for column, array in enumerate(arrays):
                _put(sheet, line, column, float(array[index]))
        sheet.set_column(0, len(names), 20)

    def provenance(self) -> None:
        record, sheet = self.record, self.workbook.add_worksheet("Provenance")
        row = self.pairs(sheet, 0, [("atleak", record["atleak"]), ("format", record["format"])])
        for name in ("profile", "controller", "fluid", "limits", "readings"):
            row = self.pairs(sheet, row + 1, [(name, None), *_flat(record[name], {"rules"}).items()])
        rules = [{"rule": name, **rule} for name, rule in record["limits"]["rules"].items()]
        self.rows(sheet, row + 1, rules)
        sheet.set_column(0, 0, 24)
        sheet.set_column(1, 8, 30)

    # --- cells

    def table(self, name: str, records: Sequence[dict[str, Any]]) -> None:
        sheet = self.workbook.add_worksheet(name)
        self.rows(sheet, 0, records)
        sheet.freeze_panes(1, 0)
        sheet.set_column(0, 40, 16)

    def rows(self, sheet: Worksheet, row: int, records: Sequence[dict[str, Any]]) -> int:
        """A heading row and a row per record; the next free row."""
        names = list(dict.fromkeys(name for record in records for name in record))
        for column, name in enumerate(names):
            _put(sheet, row, column, name, self.heading)
        for line, record in enumerate(records, start=row + 1):
            for column, name in enumerate(names):
                _put(sheet, line, column, record.get(name))
        return row + len(records) + 1

    def pairs(self, sheet: Worksheet, row: int, pairs: Iterable[tuple[str, Any]]) -> int:
        """Names and values below one another, unknown values left out; the next free row."""
        for name, value in pairs:
            if value is None and name.islower() and " " not in name:
                continue
            _put(sheet, row, 0, name, self.bold)
            _put(sheet, row, 1, value)
            row += 1
        return row


def _series(road: RoadLeakage) -> dict[str, np.ndarray]:
    found = {"time_s": road.time, "leakage_dm3_min": road.leakage * DM3_MIN}
    if road.pump_capacity is not None and road.share is not None:
        found["pump_capacity_dm3_min"] = road.pump_capacity * DM3_MIN
        found["share_percent"] = road.share * PERCENT
    found |= {f"leakage_{name}_dm3_min": flow * DM3_MIN for name, flow in road.sections.items()}
    for quantity, name, factor in (
        ("main_pressure", "p_g_kpa", KPA),
        ("converter_pressure", "p_k_kpa", KPA),
        ("engine_speed", "engine_rpm", RPM),
        ("atf_temperature", "temperature_c", 1.0),
        ("gear", "gear", 1.0),
    ):
        values = road.road_test.values(quantity)
        if values is not None:
            found[name] = values * factor
    return found


def _put(sheet: Worksheet, row: int, column: int, value: Any, form: Format | None = None) -> None:
    """A value in a cell: numbers as numbers, everything else as text, unknown as an empty cell."""
    if isinstance(value, bool):
        sheet.write_boolean(row, column, value, form)
    elif isinstance(value, int | float):
        if math.isfinite(value):
            sheet.write_number(row, column, value, form)
    elif isinstance(value, list | tuple):
        _put(sheet, row, column, ", ".join(map(str, value)), form)
    elif value is not None:
        sheet.write_string(row, column, str(value)[:_CELL_LIMIT], form)


def _flat(record: dict[str, Any], left_out: set[str]) -> dict[str, Any]:
    return {name: value for name, value in record.items() if name not in left_out}


def _verdict(verdict: str) -> str:
    return f"{SYMBOLS[verdict]} {WORDS[verdict]}"
