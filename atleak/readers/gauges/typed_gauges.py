"""Gauge readings that were typed in by hand, as the text file in which a job keeps them: every sign as it was typed.

`read_pressure_table` reads that file as any other, and says what of it cannot be read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import cast

from atleak.catalogue.controller_tables import SelectorRange
from atleak.common.errors import Place
from atleak.common.units import KPA, RPM, find_unit
from atleak.measurements.gauge_readings import LINE_TAP, RANGES, Engine, GaugeCell, PressureTable
from atleak.readers.cells.sheet_file import csv_bytes, csv_rows

TYPED_GAUGES_FILE = "typed gauge readings.csv"
_RANGE, _STATE, _TAP, _TEMPERATURE, _SPEED = "range", "state", "tap", "ATF temperature [°C]", "engine speed [rpm]"


@dataclass(frozen=True)
class TypedGauges:
    """What was typed: the text of every cell, the unit of all pressures, and what else was said of the readings."""

    cells: Mapping[GaugeCell, str] = field(default_factory=dict)
    unit: str = "kPa"
    temperature: str = ""  # of the fluid [°C]
    fast_idle: str = ""  # engine speed at a fast idle [rpm]

    @classmethod
    def going_on_from(cls, table: PressureTable) -> TypedGauges:
        """Return the readings of a table as if they had been typed: of several in one cell the first."""
        cells = {each.cell: f"{each.pressure * KPA:.10g}" for each in reversed(table.readings)}
        warm = (each.temperature for each in table.readings if each.temperature is not None)
        fast = (each.engine_speed for each in table.readings if each.cell.engine is Engine.FAST_IDLE)
        temperature, speed = next(warm, None), next((each for each in fast if each is not None), None)
        return cls(
            cells,
            temperature="" if temperature is None else f"{temperature:.10g}",
            fast_idle="" if speed is None else f"{speed * RPM:.10g}",
        )

    def with_cell(self, cell: GaugeCell, text: str) -> TypedGauges:
        """Return this with another text in a cell; an empty one takes the cell out."""
        others = {other: typed for other, typed in self.cells.items() if other != cell}
        return replace(self, cells={**others, cell: text.strip()} if text.strip() else others)

    def part_at(self, place: Place) -> GaugeCell | str | None:
        """Return what stands in a place of the file that `written` gives: a cell or another field; None for neither."""
        named = {_TEMPERATURE: "temperature", _SPEED: "fast_idle"}.get(place.column or "")
        cells, row = list(self.cells), (place.row or 0) - 2
        return named or (cells[row] if 0 <= row < len(cells) else None)

    def written(self) -> bytes | None:
        """Return the file; None where no reading was typed."""
        if not self.cells:
            return None
        rows = [[_RANGE, _STATE, _TAP, f"gauge [{self.unit}]", _TEMPERATURE, _SPEED]]
        for cell, text in self.cells.items():
            speed = self.fast_idle if cell.engine is Engine.FAST_IDLE else ""
            rows.append([cell.range, cell.engine.label, cell.tap, text, self.temperature, speed])
        return csv_bytes(rows)


def typed_gauges(content: bytes) -> TypedGauges | None:
    """Return what was typed from the file that `TypedGauges.written` gives; None for any other file."""
    rows = csv_rows(content)
    if not rows or len(rows[0]) != 6 or [*rows[0][:3], *rows[0][4:]] != [_RANGE, _STATE, _TAP, _TEMPERATURE, _SPEED]:
        return None
    unit = find_unit(rows[0][3].removeprefix("gauge [").removesuffix("]"), "pressure")
    engines = {str(engine.label): engine for engine in Engine}
    if unit is None or any(len(row) != 6 or row[0] not in RANGES or row[1] not in engines for row in rows[1:]):
        return None
    cells = {GaugeCell(cast("SelectorRange", row[0]), engines[row[1]], row[2] or LINE_TAP): row[3] for row in rows[1:]}
    return TypedGauges(
        cells=cells,
        unit=unit.name,
        temperature=next((row[4] for row in rows[1:]), ""),
        fast_idle=next((row[5] for row in rows[1:] if row[5]), ""),
    )
