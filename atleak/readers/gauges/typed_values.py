"""Values that were typed in by hand, as the text files in which a job keeps them: every sign as it was typed.

The readers of such tables read these files as any others, and say what of them cannot be read.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

from atleak.common.errors import Place
from atleak.common.units import KPA, RPM
from atleak.measurements.gauge_readings import LINE_TAP, RANGES, Engine, GaugeCell, PressureTable
from atleak.measurements.own_forms import FLOWS, GAUGES, VACUUM, OwnForm
from atleak.readers.cells.sheet_file import csv_bytes, csv_rows
from atleak.readers.gauges.value_table import unit_in

TYPED_GAUGES_FILE = "typed gauge readings.csv"
Part = Any  # of what was typed: a cell, or the name of a field beside the cells
_Lines = list[tuple[Mapping[str, Part], list[str]]]  # of a file: what stands where, by column, "" for the rest


@dataclass(frozen=True)
class TypedTable(ABC):
    """What was typed: the text of every cell, and the unit of all of them; further fields stand beside the cells."""

    form: ClassVar[OwnForm]
    cells: Mapping[Any, str] = field(default_factory=dict)
    unit: str = ""

    @property
    @abstractmethod
    def _lines(self) -> _Lines: ...

    @classmethod
    @abstractmethod
    def _parsed(cls, rows: Sequence[Sequence[str]]) -> Self: ...

    @classmethod
    def read(cls, content: bytes) -> Self | None:
        """Return what was typed from the file that `written` gives, also without its mark; None for any other file."""
        with suppress(LookupError, TypeError, ValueError, StopIteration):
            rows = csv_rows(content)
            marked = rows[0] == [cls.form.mark]
            typed = cls._parsed(rows[marked:])
            written = typed.written() or b""
            return typed if content == (written if marked else written.partition(b"\r\n")[2]) else None
        return None

    def text(self, part: Part) -> str:
        """Return what stands in a part."""
        return str(getattr(self, part)) if isinstance(part, str) else self.cells.get(part, "")

    def with_text(self, part: Part, text: str) -> Self:
        """Return this with another text in a part; an empty one takes a cell out."""
        if isinstance(part, str):
            changes: dict[str, Any] = {part: text}
            return replace(self, **changes)
        others = {other: typed for other, typed in self.cells.items() if other != part}
        return replace(self, cells={**others, part: text.strip()} if text.strip() else others)

    def part_at(self, place: Place) -> Part | None:
        """Return what stands in a place of the file that `written` gives; None where nothing that was typed does."""
        row = (place.row or 0) - 2  # below the mark
        there = self._lines[row][0] if 0 <= row < len(self._lines) else {}
        return there.get(place.column or "", there.get(""))

    def written(self) -> bytes | None:
        """Return the file, its mark in the first row; None where no cell was filled in."""
        return csv_bytes([[self.form.mark], *(row for _, row in self._lines)]) if self.cells else None


_BESIDE = {"temperature": "°C", "engine_speed": "rpm"}  # columns whose unit is always this
_TEMPERATURE, _SPEED = (f"{GAUGES.headings[key]} [{unit}]" for key, unit in _BESIDE.items())


@dataclass(frozen=True)
class TypedGauges(TypedTable):
    """Gauge readings by `GaugeCell`."""

    form = GAUGES
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

    @property
    def _lines(self) -> _Lines:
        *keys, gauge = (str(said) for key, said in GAUGES.headings.items() if key not in _BESIDE)
        lines: _Lines = [({}, [*keys, f"{gauge} [{self.unit}]", _TEMPERATURE, _SPEED])]
        for cell, text in self.cells.items():
            speed = self.fast_idle if cell.engine is Engine.FAST_IDLE else ""
            row = [cell.range, str(cell.engine.label), cell.tap, text, self.temperature, speed]
            lines.append(({_TEMPERATURE: "temperature", _SPEED: "fast_idle", "": cell}, row))
        return lines

    @classmethod
    def _parsed(cls, rows: Sequence[Sequence[str]]) -> TypedGauges:
        ranges, engines = {str(name): name for name in RANGES}, {str(engine.label): engine for engine in Engine}
        return cls(
            {GaugeCell(ranges[row[0]], engines[row[1]], row[2] or LINE_TAP): row[3] for row in rows[1:]},
            unit_in(rows[0][3]),
            rows[1][4],
            next((row[5] for row in rows[1:] if row[5]), ""),
        )


@dataclass(frozen=True)
class TypedFlows(TypedTable):
    """Flows that were caught in a jug, by the name of an operating point and what flowed."""

    form = FLOWS
    unit: str = "l/min"

    @property
    def _lines(self) -> _Lines:
        rows: _Lines = [({"": cell}, [*cell, text]) for cell, text in self.cells.items()]
        condition, what, value = FLOWS.headings.values()
        return [({}, [condition, what, f"{value} [{self.unit}]"]), *rows]

    @classmethod
    def _parsed(cls, rows: Sequence[Sequence[str]]) -> TypedFlows:
        return cls({(condition, what): text for condition, what, text in rows[1:]}, unit_in(rows[0][2]))


@dataclass(frozen=True)
class TypedVacuum(TypedTable):
    """A vacuum test: readings by circuit or component/land and state of the bore, and the stand that was read."""

    form = VACUUM
    unit: str = "in-Hg"  # of the supply too
    supply: str = ""
    ambient: str = ""  # [kPa]
    temperature: str = ""  # [°C]
    orifice: str = ""  # of the stand [mm]
    known_1: str = ""  # two calibrations: the known orifice [mm], and what the stand showed
    shown_1: str = ""
    known_2: str = ""
    shown_2: str = ""

    @property
    def _lines(self) -> _Lines:
        stand = (("supply", self.unit), ("ambient", "kPa"), ("temperature", "°C"), ("orifice", "mm"))
        lines: _Lines = [({"": name}, [name, self.text(name), unit]) for name, unit in stand if self.text(name)]
        for known, shown in (("known_1", "shown_1"), ("known_2", "shown_2")):
            if self.text(known) and self.text(shown):
                row = ["calibration", self.text(known), "mm", self.text(shown), self.unit]
                lines.append(({"": known, "4": shown}, row))
        target, reading, state = VACUUM.headings.values()
        lines.append(({}, [target, f"{reading} [{self.unit}]", state]))
        return lines + [({"": cell}, [cell[0], text, cell[1]]) for cell, text in self.cells.items()]

    @classmethod
    def _parsed(cls, rows: Sequence[Sequence[str]]) -> TypedVacuum:
        heading = next(number for number, row in enumerate(rows) if row[0] == VACUUM.headings["target"])
        cells = {(target, state): text for target, text, state in rows[heading + 1 :]}
        stand = {name: text for name, text, *_ in rows[:heading] if name != "calibration"}
        for number, row in enumerate((row for row in rows[:heading] if row[0] == "calibration"), start=1):
            stand |= {f"known_{number}": row[1], f"shown_{number}": row[3]}
        return cls(cells, unit_in(rows[heading][1]), **stand)
