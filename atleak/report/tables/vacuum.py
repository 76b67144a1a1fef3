"""Say what a vacuum test tells, and record it for scripts: what was plugged, what it leaks, before and after."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from atleak.common.units import DM3_MIN, IN_HG, KPA, MM, UM
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.diagnosis.vacuum import LandShare, VacuumChange, VacuumFinding
from atleak.report.json.conditions import of_land
from atleak.report.tables.names import land_words
from atleak.report.tables.table import VERDICT, Column, Section, SectionPart, Table, Text, span


def vacuum_records(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return every plug of the vacuum test as ``atleak diagnose --json`` writes it."""
    return [_record(finding) for finding in diagnosis.vacuum]


def _record(finding: VacuumFinding) -> dict[str, Any]:
    reading, change = finding.reading, finding.change
    low, high = finding.interval
    least, most = finding.leakage_interval
    return {
        "circuit": reading.circuit,
        "target": reading.target,
        "lands": [of_land(land.key) for land in finding.lands],
        "reading_kpa": reading.vacuum * KPA,
        "orifice_mm": None if reading.orifice is None else reading.orifice * MM,
        "flow_area_mm2": finding.stand.area * MM**2,
        "flow_area_known": finding.stand.known,
        "repaired": reading.repaired,
        "clearance_um": finding.clearance * UM,
        "low_um": low * UM,
        "high_um": high * UM,
        "bound": "lower" if finding.open else "upper" if finding.tight else None,
        "new_clearance_um": finding.new_clearance * UM,
        "leakage_dm3_min": finding.leakage * DM3_MIN,
        "leakage_low_dm3_min": least * DM3_MIN,
        "leakage_high_dm3_min": most * DM3_MIN,
        "verdict": finding.verdict,
        "alone_worn": [
            {**of_land(share.land.key), "low_um": share.low * UM, "high_um": share.high * UM} for share in finding.each
        ],
        "change": None if change is None else _change_record(change),
        "place": reading.place.parts,
    }


def _change_record(change: VacuumChange) -> dict[str, Any]:
    low, high = change.interval
    return {
        "before_kpa": change.before.vacuum * KPA,
        "after_kpa": change.after.vacuum * KPA,
        "change_um": change.change * UM,
        "low_um": low * UM,
        "high_um": high * UM,
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
        end = finding.interval[1] if finding.tight and not finding.open else finding.clearance
        value = self.say.value(end * UM, "clearance", 1)
        if not (finding.open or finding.tight):
            return f"{value} ({self._span(finding.interval, UM, 'clearance', 1)})"
        if finding.open:
            return self.say("vacuum.at_least", value=value)
        return self.say("vacuum.at_most", value=value)

    def _leakage(self, finding: VacuumFinding) -> str:
        value = self.say.value(finding.leakage * DM3_MIN, "leak", 3)
        return f"{value} ({self._span(finding.leakage_interval, DM3_MIN, 'leak', 3)})"

    def _span(self, ends: tuple[float, float], factor: float, kind: str, digits: int) -> str:
        return span((end * factor for end in ends), kind, self.say, digits)

    def readings(self) -> Iterator[SectionPart]:
        say, table = self.say, self.diagnosis.vacuum_table
        columns = (
            Column("verdict", VERDICT, width=92),
            Column("plugged", width=170, of=self._plugged),
            Column("vacuum", "vacuum", 1, of=lambda each: each.reading.vacuum, times=IN_HG),
            Column("stand_orifice", "length", 2, of=lambda each: each.reading.orifice, times=MM),
            Column("bore", of=lambda each: say("vacuum.repaired") if each.reading.repaired else None),
            Column("clearance", words_of="clearance", width=110, of=self._clearance),
            Column("new_common", "clearance", 1, of="new_clearance", times=UM),
            Column("at_hot_idle", words_of="leak", width=110, of=self._leakage),
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
            return self._span((row[1].low, row[1].high), UM, "clearance", 1)

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

        columns = (
            Column("plugged", width=170, of=lambda row: self._plugged(row[0])),
            Column("vacuum_before", "vacuum", 1, of=lambda row: row[1].before.vacuum, times=IN_HG),
            Column("vacuum_after", "vacuum", 1, of=lambda row: row[1].after.vacuum, times=IN_HG),
            Column("clearance_change", "clearance", 1, of=lambda row: row[1].change, times=UM),
            Column("between", words_of="clearance", of=lambda row: self._span(row[1].interval, UM, "clearance", 1)),
            Column("told_apart", of=told),
        )
        yield Text(say("vacuum.changes"), leads=True)
        yield Table("vacuum_changes", columns, rows, say)
