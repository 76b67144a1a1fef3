"""Write the sheet of circuits: the pressure that each holds, what it lost, and which lands cost it that.

Pressures are solved by steps that a sheet cannot follow: they stand as numbers, and the flows of gaps follow them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.circuits import Circuit
from atleak.catalogue.limits import RuleKind
from atleak.diagnosis import Diagnosis
from atleak.engine.projection import CircuitState
from atleak.engine.repaired import LINE
from atleak.report.xlsx.book import Book, cell
from atleak.report.xlsx.live_cells import AFTER_A_NUMBER, Cell, SheetCondition, address, write_cell
from atleak.report.xlsx.rules_sheet import RuleCells
from atleak.rules import LandKey, Rule
from atleak.verdicts import VERDICTS
from atleak.wording import signed, wording
from atleak.workshop_units import DM3_MIN, KPA

_SHEET = "Circuits"
_HEADINGS = {
    "condition": ("condition", 26),
    "circuit": ("circuit", 14),
    "name": ("name", 30),
    "held": ("pressure held, as issued [kPa]", 13),
    "low": ("low, as issued [kPa]", 12),
    "high": ("high, as issued [kPa]", 12),
    "new": ("pressure held when new, as issued [kPa]", 13),
    "set": ("set pressure, as issued [kPa]", 13),
    "loss": ("lost against new [kPa]", 12),
    "verdict": ("verdict", 15),
    "decision": ("decision as issued", 16),
    "feed": ("through its feeds, as issued [dm³/min]", 13),
    "relief": ("relieved to the sump, as issued [dm³/min]", 13),
    "required": ("pressure at the required main pressure, as issued [kPa]", 15),
    "required_new": ("the same of the unit new, as issued [kPa]", 15),
    "causes": ("what a land costs it (with that land new), as issued", 70),
}
_COLUMN = {key: number for number, key in enumerate(_HEADINGS)}
_NOTE = (
    "Pressures are solved, not followed by the sheet: a changed reading changes gaps and flows at the pressures that "
    "stand here. Gaps leak at the required main pressure, circuits hold what the main pressure held allows."
)
_VENTED = "vented in this gear"


@dataclass(frozen=True)
class _Line:
    """One circuit at one condition, or the line itself."""

    at: SheetCondition
    state: CircuitState | None  # None for the line
    rule: Rule | None  # None of a circuit that is vented, and where nothing judges it

    @property
    def section(self) -> str:
        return self.state.circuit.id if self.state else LINE


class CircuitCells:
    """Where the pressures of every circuit stand on their sheet; the sheet is not there without circuits."""

    def __init__(self, diagnosis: Diagnosis, conditions: Sequence[SheetCondition], rules: RuleCells) -> None:
        self.diagnosis, self.rules = diagnosis, rules
        self.lines: list[_Line] = []
        if diagnosis.controller.circuits:
            for at in conditions:
                of_line = diagnosis.pressure_rule(at.projection, RuleKind.PERMISSIBLE_PRESSURE)
                self.lines.append(_Line(at, None, of_line))
                for state in at.projection.circuits:
                    rule = diagnosis.pressure_rule(at.projection, RuleKind.CIRCUIT_LOSS, state.circuit)
                    self.lines.append(_Line(at, state, rule))

    def held(self, at: SheetCondition, circuit: Circuit) -> str:
        """Return the cell of the pressure that a circuit holds at a condition."""
        rows = enumerate(self.lines, start=1)
        row = next(row for row, line in rows if line.at is at and line.section == circuit.id)
        return cell(row, _COLUMN["held"], _SHEET)

    def write(self, book: Book, sheet: Worksheet) -> None:
        """Write one row per condition and circuit, the line before its circuits."""
        book.headings(sheet, 0, [heading for heading, _ in _HEADINGS.values()], lines=5)
        for row, line in enumerate(self.lines, start=1):
            for key, content in self._cells(line, row).items():
                write_cell(book, sheet, row, _COLUMN[key], content)
            if line.state is not None:
                for key, name in (("required", ""), ("required_new", "new_")):
                    where = cell(row, _COLUMN[key], _SHEET)
                    book.workbook.define_name(line.at(f"{name}c_{line.section}"), f"={where}")
        for number, (_, width) in enumerate(_HEADINGS.values()):
            sheet.set_column(number, number, width)
        last = len(self.lines)
        book.colour_words(sheet, (1, _COLUMN["verdict"]), (last, _COLUMN["verdict"]), VERDICTS)
        sheet.autofilter(0, 0, last, len(_HEADINGS) - 1)
        write_cell(book, sheet, last + 2, 0, Cell("plain", _NOTE))

    def _cells(self, line: _Line, row: int) -> Mapping[str, Cell]:
        diagnosis, at, state = self.diagnosis, line.at, line.state
        projection, new = at.projection, diagnosis.new_at(at.projection)
        total = diagnosis.uncertainty.total(projection.condition.name) if diagnosis.uncertainty else None
        cells = {"condition": Cell("plain", projection.condition.label), "circuit": Cell("plain", line.section)}
        low, high = (None, None)
        if state is None:
            held, when_new, set_to = projection.main_pressure_held, new.main_pressure_held, None
            name = "main pressure (the line)"
            if total is not None:
                low, high = total.main_pressure_interval
        else:
            held, when_new, set_to = state.pressure, new.circuit(line.section).pressure, state.set_pressure
            name = state.circuit.name
            if total is not None:
                low, high = total.circuit_intervals.get(line.section, (None, None))
            for key, flow in (("feed", state.feed), ("relief", state.relief)):
                cells[key] = Cell("flow", flow * DM3_MIN)
        pressures = {
            "held": held,
            "low": low,
            "high": high,
            "new": when_new,
            "set": set_to,
            "required": projection.pressures[line.section],
            "required_new": at.new.pressures[line.section],
        }
        cells["name"] = Cell("plain", name)
        cells |= {key: Cell("kpa", None if each is None else each * KPA) for key, each in pressures.items()}
        if state is not None and state.vented:
            return cells | {"verdict": Cell("plain", _VENTED, look=AFTER_A_NUMBER)}
        lost = f"{address(row, _COLUMN['new'])}-{address(row, _COLUMN['held'])}"
        cells["loss"] = Cell("kpa", (when_new - held) * KPA, lost)
        return cells | self._judged(line)

    def _judged(self, line: _Line) -> dict[str, Cell]:
        rule, diagnosis = line.rule, self.diagnosis
        causes = diagnosis.losses_at(line.at.projection).get(line.section, {})
        cells = {"causes": Cell("plain", "; ".join(_causes(causes)) or None)}
        verdict = diagnosis.circuit_verdict(rule)
        if rule is not None and verdict is not None:
            cells["verdict"] = Cell("plain", signed(verdict), self.rules.of_unit(rule), AFTER_A_NUMBER)
            decided = diagnosis.decided(rule)
            if decided is not None:
                words = wording("en").get("decisions", decided.decision)
                cells["decision"] = Cell("plain", words, look=AFTER_A_NUMBER)
        return cells


def _causes(losses: Mapping[LandKey, float]) -> Iterable[str]:
    for (component, land), loss in losses.items():
        yield f"{component}/{land} {loss * KPA:.1f} kPa"
