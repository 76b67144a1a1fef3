"""Lay out the sheet of circuits: the pressure that each holds, what it lost, and which lands cost it that.

Pressures are solved by steps that a sheet cannot follow: they stand as numbers, and the flows of gaps follow them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from xlsxwriter.worksheet import Worksheet

from atleak.analysis.pressures import HeldPressure, pressures_at
from atleak.catalogue.circuits import Circuit
from atleak.common.sentences import Name, Sentence
from atleak.common.units import DM3_MIN, KPA
from atleak.common.wording import Wording
from atleak.report.xlsx.book import ReportBook
from atleak.report.xlsx.live_sheet import (
    AFTER_A_NUMBER,
    FLOW,
    PRESSURE,
    LiveCells,
    LiveColumn,
    LiveSheet,
    SheetCondition,
)
from atleak.report.xlsx.rules import RuleCells

if TYPE_CHECKING:
    from atleak.report.xlsx.lands import LiveSheets

CIRCUITS = Sentence("Circuits")
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

    @property
    def ends(self) -> tuple[float | None, float | None]:
        """Return the 95 % interval of the pressure [Pa]."""
        return self.held.interval or (None, None)

    def flow(self, name: str) -> float | None:
        """Return a flow of the circuit [m³/s]; None of the line."""
        return None if self.held.circuit is None else getattr(self.at.projection.circuit(self.held.id), name)


class CircuitCells:
    """Where the pressures of every circuit stand on their sheet; the sheet is not there without circuits."""

    def __init__(self, live: LiveSheets) -> None:
        lines, diagnosis = [], live.diagnosis
        for at in live.conditions if diagnosis.controller.circuits else ():
            pressures = pressures_at(diagnosis, at.projection)
            lines += [_Line(at, held) for held in (pressures.line, *pressures.circuits)]
        self.sheet = LiveSheet(live.say.sentence(CIRCUITS), _columns(live.rules, live.say), lines)

    def held(self, at: SheetCondition, circuit: Circuit, column: str) -> str:
        """Return the cell of the pressure that a circuit holds at a condition, ``held`` or ``new``."""
        rows = enumerate(self.sheet.items, start=1)
        row = next(row for row, line in rows if line.at is at and line.held.circuit == circuit)
        return self.sheet.cell(row, column)

    def write(self, book: ReportBook, sheet: Worksheet) -> None:
        """Write one row per condition and circuit, the line before its circuits."""
        self.sheet.write(book, sheet)
        for row, line in enumerate(self.sheet.items, start=1):
            if line.held.circuit is not None:
                for key, name in (("required", line.at.pressure), ("required_new", line.at.new_pressure)):
                    book.define(name(line.held.id), row, self.sheet.place[key], sheet.get_name())
        book.put(sheet, len(self.sheet.items) + 2, 0, _NOTE)


def _columns(rules: RuleCells, say: Wording) -> Sequence[LiveColumn]:
    def issued(
        key: str, heading: Sentence, value: Callable[[_Line], Any], width: int = 13, kind: str = "kpa"
    ) -> LiveColumn:
        return LiveColumn(key, heading, kind, value, times=DM3_MIN if kind == "flow" else KPA, width=width)

    def verdict(line: _Line) -> str | None:
        held = line.held
        if held.vented:
            return _VENTED
        return None if held.rule is None or held.verdict is None else say.signed(held.verdict)

    def verdict_formula(line: _Line, _: LiveCells) -> str | None:
        held = line.held
        return None if held.vented or held.rule is None or held.verdict is None else rules.of_unit(held.rule)

    def decision(line: _Line) -> str | None:
        held = line.held
        return None if held.vented or held.decided is None else say.get("decisions", held.decided.decision)

    def causes(line: _Line) -> str | None:
        costs = {} if line.held.vented else line.held.causes
        said = (
            f"{component}/{land} {say.spelled(loss * KPA, 'pressure', 1)} {say.spelled_unit('pressure')}"
            for (component, land), loss in costs.items()
        )
        return "; ".join(said) or None

    # fmt: off
    return (
        LiveColumn("condition", say("printed.condition"), value=lambda line: line.at.label, width=34,
                   look={"text_wrap": True}),
        LiveColumn("circuit", Sentence("circuit"), value=lambda line: line.held.id, width=22),
        LiveColumn("name", Sentence("name"), width=30,
                   value=lambda line: Name(line.held.circuit.name) if line.held.circuit else _LINE_NAME),
        issued("held", Sentence("pressure held, as issued [{unit}]", unit=PRESSURE), lambda line: line.held.now),
        issued("low", Sentence("low, as issued [{unit}]", unit=PRESSURE), lambda line: line.ends[0], 12),
        issued("high", Sentence("high, as issued [{unit}]", unit=PRESSURE), lambda line: line.ends[1], 12),
        issued("new", Sentence("pressure held when new, as issued [{unit}]", unit=PRESSURE),
               lambda line: line.held.new),
        issued("set", Sentence("set pressure, as issued [{unit}]", unit=PRESSURE), lambda line: line.held.set_pressure),
        LiveColumn("loss", Sentence("lost against new [{unit}]", unit=PRESSURE), "kpa",
                   lambda line: None if line.held.vented else line.held.loss, "{new}-{held}", KPA),
        LiveColumn("verdict", Sentence("verdict"), "plain", verdict, verdict_formula, width=20, look=AFTER_A_NUMBER),
        LiveColumn("decision", Sentence("decision as issued"), value=decision, width=18, look=AFTER_A_NUMBER),
        issued("feed", Sentence("through its feeds, as issued [{unit}]", unit=FLOW), lambda line: line.flow("feed"),
               kind="flow"),
        issued("relief", Sentence("relieved to the sump, as issued [{unit}]", unit=FLOW),
               lambda line: line.flow("relief"), kind="flow"),
        issued("required", Sentence("pressure at the required main pressure, as issued [{unit}]", unit=PRESSURE),
               lambda line: line.at.projection.pressures[line.held.id], 15),
        issued("required_new", Sentence("the same of the unit new, as issued [{unit}]", unit=PRESSURE),
               lambda line: line.at.new.pressures[line.held.id], 15),
        LiveColumn("causes", Sentence("what a land costs it (with that land new), as issued"), value=causes, width=70),
    )
    # fmt: on
