"""A diagnosis on a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from atleak.diagnosis import Diagnosis, LandDiagnosis
from atleak.projection import Projection
from atleak.report.record import DM3_MIN, PERCENT, RPM, UM

SYMBOLS = {"ok": "●", "watch": "▲", "replace": "■", "critical": "✖", "not_measured": "○"}
WORDS = {
    "ok": "ok",
    "watch": "watch",
    "replace": "replace",
    "critical": "critical",
    "not_measured": "not measured",
}
_STYLES = {"watch": "yellow", "replace": "red", "critical": "bold red"}


def print_diagnosis(diagnosis: Diagnosis) -> None:
    """Totals, flagged lands with the rule that flagged them, order of repair, and warnings."""
    console = Console(highlight=False)
    controller, readings = diagnosis.controller, diagnosis.readings
    console.print(Text(f"{controller.name} · {diagnosis.fluid.name} · profile {diagnosis.profile.label}"))
    measured = f"{diagnosis.measured} of {len(diagnosis.lands)} lands measured"
    console.print(Text(measured + (f" in {readings.file}" if readings else "")))
    for projection in diagnosis.projections:
        console.print(Text(_total(diagnosis, projection)))
    if diagnosis.flagged:
        console.print(_flagged(diagnosis.flagged))
    else:
        console.print(Text("No measured land has reached a limit."))
    for number, step in enumerate(diagnosis.repair_plan, start=1):
        land = step.land.state.land
        console.print(
            Text(
                f"{number}. component {land.component} land {land.land}: total share at {step.condition.label} "
                f"{step.share_before * PERCENT:.1f} → {step.share_after * PERCENT:.1f} %"
            )
        )
    for message in diagnosis.messages:
        if message.level == "warning":
            console.print(Text(f"! {message.text}"))


def print_table(columns: Sequence[str], rows: Sequence[dict[str, Any]]) -> None:
    """Records as a table."""
    table = Table(*(column.replace("_", " ") for column in columns))
    for row in rows:
        table.add_row(*(Text(_cell(row[column])) for column in columns))
    Console(highlight=False).print(table)


def _cell(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{found:g} at {name} °C" for name, found in value.items())
    return {None: "–", True: "yes", False: "no"}.get(value, str(value)) if not isinstance(value, list) else str(value)


def _total(diagnosis: Diagnosis, projection: Projection) -> str:
    return (
        f"{projection.condition.label}: leakage {projection.leakage * DM3_MIN:.2f} of "
        f"{projection.pump_capacity * DM3_MIN:.2f} dm³/min, {projection.share * PERCENT:.1f} % "
        f"({diagnosis.band(projection)}); pressure holds from {projection.minimum_speed * RPM:.0f} rpm"
    )


def _flagged(lands: Sequence[LandDiagnosis]) -> Table:
    table = Table("verdict", "component", "land", "clearance µm", "mounting µm", "wear %", "share %", "because")
    for found in lands:
        land, rule = found.state.land, found.deciding
        table.add_row(
            Text(f"{SYMBOLS[found.verdict]} {WORDS[found.verdict]}", style=_STYLES.get(found.verdict, "")),
            Text(land.component),
            str(land.land),
            f"{found.state.radial_clearance * UM:.1f}",
            f"{land.mounting_clearance * UM:.1f}",
            "–" if found.wear is None else f"{found.wear * PERCENT:.0f}",
            f"{found.share * PERCENT:.2f}",
            Text("" if rule is None else f"{rule.label} ({rule.origin})"),
        )
    return table
