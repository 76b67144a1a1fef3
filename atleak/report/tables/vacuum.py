"""Say what a vacuum test tells, and record it for scripts: what was plugged, what it leaks, before and after."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.common.units import DM3_MIN, IN_HG, KPA, MM, UM
from atleak.common.wording import Wording, begun
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.uncertainty import DEFAULTS, Assumptions
from atleak.diagnosis.uncertainty.draws import Interval
from atleak.diagnosis.vacuum import LandShare, VacuumChange, VacuumFinding
from atleak.diagnosis.vacuum_card import GROWN, PassMark, pass_marks
from atleak.measurements.vacuum import VacuumStand
from atleak.report.json.conditions import interval_ends, named_record, of_land
from atleak.report.tables.names import component_words, land_number, land_words
from atleak.report.tables.table import VERDICT, Column, Section, SectionPart, Table, Text, span


def vacuum_records(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return every plug of the vacuum test as ``atleak diagnose --json`` writes it."""
    return [_record(finding) for finding in diagnosis.vacuum]


def _record(finding: VacuumFinding) -> dict[str, Any]:
    reading, change = finding.reading, finding.change
    return {
        **named_record(reading, "circuit", "target"),
        "lands": [of_land(land.key) for land in finding.lands],
        **named_record(reading, reading_kpa="vacuum", orifice_mm="orifice"),
        "flow_area_mm2": finding.stand.area * MM**2,
        "flow_area_known": finding.stand.known,
        "repaired": reading.repaired,
        "clearance_um": finding.clearance * UM,
        **interval_ends("{}_um", finding.interval, UM),
        "bound": "lower" if finding.open else "upper" if finding.tight else None,
        **named_record(finding, "new_clearance_um", "leakage_dm3_min"),
        **interval_ends("leakage_{}_dm3_min", finding.leakage_interval, DM3_MIN),
        "verdict": finding.verdict,
        "alone_worn": [
            {**of_land(share.land.key), **named_record(share, "low_um", "high_um")} for share in finding.each
        ],
        "change": change and _change_record(change),
        "place": reading.place.parts,
    }


def _change_record(change: VacuumChange) -> dict[str, Any]:
    return {
        **named_record(change.before, before_kpa="vacuum"),
        **named_record(change.after, after_kpa="vacuum"),
        "change_um": change.change * UM,
        **interval_ends("{}_um", change.interval, UM),
        "significant": change.significant,
    }


def vacuum_section(diagnosis: Diagnosis, say: Wording) -> Section:
    """Return what a vacuum test tells, for every medium."""
    words = _Words(diagnosis, say)
    return Section("vacuum", say("vacuum.title"), (*words.readings(), *words.shares(), *words.changes()))


def plugged(diagnosis: Diagnosis, finding: VacuumFinding, say: Wording) -> str:
    """Return the name of what was plugged, for people: of a circuit, of a land, or as the table has it."""
    controller, reading = diagnosis.controller, finding.reading
    name = next((each.name for each in controller.circuits if each.id == reading.circuit), None)
    if name is not None:
        return say.name(name)
    return land_words(controller, finding.lands[0].key, say) if len(finding.lands) == 1 else reading.target


class _Words:
    def __init__(self, diagnosis: Diagnosis, say: Wording) -> None:
        self.diagnosis, self.say, self.findings = diagnosis, say, diagnosis.vacuum

    def _plugged(self, finding: VacuumFinding) -> str:
        return plugged(self.diagnosis, finding, self.say)

    def _clearance(self, finding: VacuumFinding) -> str:
        low, high = (self.say.value(end * UM, "clearance", 1) for end in finding.interval)
        if finding.open:
            return self.say("vacuum.at_least", value=low)
        if finding.tight:
            return self.say("vacuum.at_most", value=high)
        return self._between(finding.clearance, finding.interval, UM, "clearance", 1)

    def _leakage(self, finding: VacuumFinding) -> str | None:
        if finding.leakage is None or finding.leakage_interval is None:
            return None
        return self._between(finding.leakage, finding.leakage_interval, DM3_MIN, "leak", 3)

    def _between(self, value: float, ends: Interval, factor: float, kind: str, digits: int) -> str:
        said, low, high = (self.say.value(each * factor, kind, digits) for each in (value, *ends))
        return self.say("diagnosis.between", value=said, low=low, high=high)

    def readings(self) -> Iterator[SectionPart]:
        say, table = self.say, self.diagnosis.vacuum_table
        columns = (
            Column("verdict", VERDICT, width=92),
            Column("plugged", width=170, of=self._plugged),
            Column("vacuum", "vacuum", 1, of=lambda each: each.reading.vacuum, times=IN_HG),
            Column("stand_orifice", "length", 2, of=lambda each: each.reading.orifice, times=MM),
            Column("bore", width=100, of=lambda each: say("vacuum.repaired") if each.reading.repaired else None),
            Column("clearance", words_of="clearance", width=150, of=self._clearance),
            Column("new_common", "clearance", 1, of="new_clearance", times=UM),
            Column("at_hot_idle", words_of="leak", width=150, of=self._leakage),
        )
        yield Table("vacuum", columns, self.findings, say).filled
        uncertainty = self.diagnosis.uncertainty
        assumptions = uncertainty.assumptions if uncertainty else DEFAULTS
        coefficient = say.number(assumptions.discharge_coefficient, 2)
        supply = say.quantity(table.stand.supply * IN_HG, "vacuum", 1) if table else ""
        for known in dict.fromkeys(each.stand.known for each in self.findings):
            areas = sorted({each.stand.area for each in self.findings if each.stand.known is known})
            area = ", ".join(say.number(each * MM**2, 3) for each in areas)
            how = say("vacuum.calibrated") if known else say("vacuum.assumed", coefficient=coefficient)
            yield Text(say("vacuum.stand", supply=supply, area=area, known=how), small=True)
        yield Text(say("vacuum.position"), small=True)

    def shares(self) -> Iterator[SectionPart]:
        rows = [(finding, share) for finding in self.findings for share in finding.each]
        if not rows:
            return

        def between(row: tuple[VacuumFinding, LandShare]) -> str:
            return span((row[1].low * UM, row[1].high * UM), "clearance", self.say)

        columns = (
            Column("pair", width=220, of=lambda row: land_words(self.diagnosis.controller, row[1].land.key, self.say)),
            Column("alone_between", words_of="clearance", of=between),
        )
        yield Text(self.say("vacuum.several"), leads=True)
        yield Table("vacuum_shares", columns, rows, self.say, group=lambda row: self._plugged(row[0]))
        yield Text(self.say("vacuum.together"), small=True)

    def changes(self) -> Iterator[SectionPart]:
        rows = [(finding, finding.change) for finding in self.findings if finding.change is not None]
        if not rows:
            return
        say = self.say

        def told(row: tuple[VacuumFinding, VacuumChange]) -> str:
            return say("vacuum.significant" if row[1].significant else "vacuum.not_significant")

        def changed(row: tuple[VacuumFinding, VacuumChange]) -> str:
            return self._between(row[1].change, row[1].interval, UM, "clearance", 1)

        columns = (
            Column("plugged", width=170, of=lambda row: self._plugged(row[0])),
            Column("vacuum_before", "vacuum", 1, of=lambda row: row[1].before.vacuum, times=IN_HG),
            Column("vacuum_after", "vacuum", 1, of=lambda row: row[1].after.vacuum, times=IN_HG),
            Column("clearance_change", words_of="clearance", width=110, of=changed),
            Column("told_apart", width=170, of=told),
        )
        yield Text(say("vacuum.changes"), leads=True)
        yield Table("vacuum_changes", columns, rows, say)


def vacuum_card_tables(
    controller: Controller, stand: VacuumStand, assumptions: Assumptions, say: Wording
) -> tuple[Table, Table]:
    """Return what a stand should show of each circuit, or component, and of each land alone."""

    def name(mark: PassMark) -> str:
        lands = mark.lands
        if len(lands) == 1 and mark.circuit is None:
            return land_words(controller, lands[0].key, say)
        keys = ", ".join(land_number(controller, land.key, say) for land in lands)
        called = say.name(mark.name) if mark.circuit else component_words(controller, mark.name, say)
        return f"{begun(called)}: {keys}"

    def said(mark: PassMark, end: str) -> str:
        if not mark.resolved:
            return say("vacuum_card.unresolved") if end == "passes" else ""
        value, away = (mark.mark, math.ceil) if end == "passes" else (mark.doubtful, math.floor)
        inhg, kpa = (say.number(away(value * factor * 10.0) / 10.0, 1) for factor in (IN_HG, KPA))
        return say(f"vacuum_card.{end}", inhg=inhg, kpa=kpa)

    columns = (
        Column("plugged", width=300, of=name),
        Column("card_orifice", "length", 2, of="orifice", times=MM),
        Column("card_unworn", digits=1, of="new", times=IN_HG),
        Column("card_passes", width=130, of=partial(said, end="passes")),
        Column("card_fails", width=130, of=partial(said, end="fails")),
        Column("card_worn", width=90, of=lambda _: ""),
        Column("card_repaired", width=90, of=lambda _: ""),
    )
    whole = say(f"vacuum_card.{'circuits' if controller.circuits else 'components'}")
    marks, of_lands = (pass_marks(controller, stand, by_land=each, assumptions=assumptions) for each in (False, True))
    return (
        Table("vacuum_card", columns, marks, say, whole),
        Table("vacuum_card_lands", columns, of_lands, say, say("vacuum_card.lands")),
    )


def vacuum_card_notes(
    stand: VacuumStand, tables: Sequence[Table], assumptions: Assumptions, say: Wording
) -> Iterator[str]:
    """Yield for which stand a card holds, what cannot be told by it, and where its readings go."""
    closed, ambient = (say.number(value, 1) for value in (stand.supply * IN_HG, stand.ambient * KPA))
    yield say(
        "vacuum_card.calibrated" if stand.calibrations or stand.flow_area is not None else "vacuum_card.assumed_cd",
        closed=f"{closed} in-Hg",
        ambient=f"{ambient} kPa",
        coefficient=say.number(assumptions.discharge_coefficient, 2),
    )
    if not all(mark.resolved for table in tables for mark in table.rows):
        gauge = f"{say.number(assumptions.vacuum_gauge * IN_HG, 1)} in-Hg"
        yield say("vacuum_card.not_resolved", grown=say.percent(GROWN, 0), gauge=gauge)
    yield say("vacuum_card.table")
