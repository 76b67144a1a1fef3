"""Write the sheet of circuits: the pressure that each holds, what it lost, and which lands cost it that.

Pressures are solved by steps that a sheet cannot follow: they stand as numbers, and the flows of gaps follow them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.circuits import Circuit
from atleak.diagnosis import Diagnosis
from atleak.report.xlsx.book import Book, cell
from atleak.report.xlsx.live_cells import AFTER_A_NUMBER, Cell, SheetCondition, address, write_cell
from atleak.report.xlsx.rules_sheet import RuleCells
from atleak.sentence import Name, Sentence
from atleak.verdicts import VERDICTS
from atleak.views.pressures import HeldPressure, pressures_at
from atleak.wording import Wording
from atleak.workshop_units import DM3_MIN, KPA

CIRCUITS = Sentence("Circuits")
_HEADINGS = {
    "condition": (None, 34),  # which all sheets word alike
    "circuit": (Sentence("circuit"), 22),
    "name": (Sentence("name"), 30),
    "held": (Sentence("pressure held, as issued [kPa]"), 13),
    "low": (Sentence("low, as issued [kPa]"), 12),
    "high": (Sentence("high, as issued [kPa]"), 12),
    "new": (Sentence("pressure held when new, as issued [kPa]"), 13),
    "set": (Sentence("set pressure, as issued [kPa]"), 13),
    "loss": (Sentence("lost against new [kPa]"), 12),
    "verdict": (Sentence("verdict"), 20),
    "decision": (Sentence("decision as issued"), 18),
    "feed": (Sentence("through its feeds, as issued [dm³/min]"), 13),
    "relief": (Sentence("relieved to the sump, as issued [dm³/min]"), 13),
    "required": (Sentence("pressure at the required main pressure, as issued [kPa]"), 15),
    "required_new": (Sentence("the same of the unit new, as issued [kPa]"), 15),
    "causes": (Sentence("what a land costs it (with that land new), as issued"), 70),
}
_COLUMN = {key: number for number, key in enumerate(_HEADINGS)}
_NOTE = Sentence(
    "Pressures are solved, not followed by the sheet: a changed reading changes gaps and flows at the pressures that "
    "stand here. Gaps leak at the required main pressure, circuits hold what the main pressure held allows. "
    "New is the same unit with pairs as wide as these may have been then, given their readings."
)
_LINE_NAME, _VENTED = Sentence("main pressure (the line)"), Sentence("vented in this gear")


@dataclass(frozen=True)
class _Line:
    """The line or one circuit, at one condition."""

    at: SheetCondition
    held: HeldPressure


class CircuitCells:
    """Where the pressures of every circuit stand on their sheet; the sheet is not there without circuits."""

    def __init__(
        self, diagnosis: Diagnosis, conditions: Sequence[SheetCondition], rules: RuleCells, say: Wording
    ) -> None:
        self.diagnosis, self.rules, self.say = diagnosis, rules, say
        self.sheet = say.sentence(CIRCUITS)
        self.lines: list[_Line] = []
        for at in conditions if diagnosis.controller.circuits else ():
            pressures = pressures_at(diagnosis, at.projection)
            self.lines += [_Line(at, held) for held in (pressures.line, *pressures.circuits)]

    def held(self, at: SheetCondition, circuit: Circuit, column: str) -> str:
        """Return the cell of the pressure that a circuit holds at a condition, ``held`` or ``new``."""
        rows = enumerate(self.lines, start=1)
        row = next(row for row, line in rows if line.at is at and line.held.circuit == circuit)
        return cell(row, _COLUMN[column], self.sheet)

    def write(self, book: Book, sheet: Worksheet) -> None:
        """Write one row per condition and circuit, the line before its circuits."""
        book.headings(
            sheet, 0, [heading or self.say("printed.condition") for heading, _ in _HEADINGS.values()], lines=5
        )
        for row, line in enumerate(self.lines, start=1):
            for key, content in (self._pressures(line) | self._judged(line, row)).items():
                write_cell(book, sheet, row, _COLUMN[key], content)
            if line.held.circuit is not None:
                for key, name in (("required", line.at.pressure), ("required_new", line.at.new_pressure)):
                    where = cell(row, _COLUMN[key], self.sheet)
                    book.workbook.define_name(name(line.held.id), f"={where}")
        for number, (_, width) in enumerate(_HEADINGS.values()):
            sheet.set_column(number, number, width)
        last = len(self.lines)
        book.colour_words(sheet, (1, _COLUMN["verdict"]), (last, _COLUMN["verdict"]), VERDICTS)
        sheet.autofilter(0, 0, last, len(_HEADINGS) - 1)
        book.put(sheet, last + 2, 0, _NOTE)

    def _pressures(self, line: _Line) -> dict[str, Cell]:
        held, projection = line.held, line.at.projection
        low, high = held.interval or (None, None)
        pressures = {
            "held": held.now,
            "low": low,
            "high": high,
            "new": held.new,
            "set": held.set_pressure,
            "required": projection.pressures[held.id],
            "required_new": line.at.new.pressures[held.id],
        }
        cells = {key: Cell("kpa", None if each is None else each * KPA) for key, each in pressures.items()}
        cells["condition"] = Cell("plain", line.at.label)
        cells["circuit"] = Cell("plain", held.id)
        cells["name"] = Cell("plain", Name(held.circuit.name) if held.circuit else _LINE_NAME)
        if held.circuit is not None:
            state = projection.circuit(held.id)
            cells |= {"feed": Cell("flow", state.feed * DM3_MIN), "relief": Cell("flow", state.relief * DM3_MIN)}
        return cells

    def _judged(self, line: _Line, row: int) -> dict[str, Cell]:
        held = line.held
        if held.vented:
            return {"verdict": Cell("plain", _VENTED, look=AFTER_A_NUMBER)}
        lost = f"{address(row, _COLUMN['new'])}-{address(row, _COLUMN['held'])}"
        number = self.say.number
        causes = (f"{component}/{land} {number(loss * KPA, 1)} kPa" for (component, land), loss in held.causes.items())
        cells = {"loss": Cell("kpa", held.loss * KPA, lost), "causes": Cell("plain", "; ".join(causes) or None)}
        if held.rule is not None and held.verdict is not None:
            cells["verdict"] = Cell(
                "plain", self.say.signed(held.verdict), self.rules.of_unit(held.rule), AFTER_A_NUMBER
            )
        if held.decided is not None:
            words = self.say.get("decisions", held.decided.decision)
            cells["decision"] = Cell("plain", words, look=AFTER_A_NUMBER)
        return cells
