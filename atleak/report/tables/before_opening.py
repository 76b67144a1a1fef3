"""Say what was measured before a unit was opened: a vacuum test, and flows that were caught in a jug."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from atleak.common.units import DM3_MIN
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.flows import FlowFinding
from atleak.report.json.conditions import named_record
from atleak.report.tables.table import Column, Section, Table, Text
from atleak.report.tables.vacuum import vacuum_section


def before_opening(diagnosis: Diagnosis, say: Wording) -> Iterator[Section]:
    """Yield a section for each kind of measurement that there is."""
    if diagnosis.vacuum:
        yield vacuum_section(diagnosis, say)
    if diagnosis.flows:
        assumed = diagnosis.gauge_card.assumptions
        spread = {"usual": assumed.consumer_flow, "jug": assumed.caught_flow}
        note = say("before_opening.flows_note", **{name: say.percent(part, 0) for name, part in spread.items()})
        parts = (flow_table(diagnosis.flows, say), Text(note, small=True))
        yield Section("flows", say("before_opening.flows"), parts)


def flow_table(flows: tuple[FlowFinding, ...], say: Wording) -> Table:
    """Return a row for every flow that was caught: beside the usual one, and what the line left over."""

    def what(each: FlowFinding) -> str:
        return say.sentence(each.name) if each.consumer is None else say.name(each.name)

    def left(each: FlowFinding) -> str:
        low, high = (say.value(end * DM3_MIN, "flow") for end in (each.left_low, each.left_high))
        return say("before_opening.at_least", flow=low) if each.bound else f"{low}–{high}"

    shown = (
        Column("consumer", width=190, of=what),
        Column("condition", width=190, of=lambda each: say.condition(each.point)),
        Column("caught", "flow", of="flow", times=DM3_MIN),
        Column("usual", "flow", times=DM3_MIN),
        Column("left_over", words_of="flow", width=150, of=left),
        Column("computed_left", "flow", of="computed", times=DM3_MIN),
    )
    return Table("flows", shown, flows, say).filled


def flow_record(each: FlowFinding) -> dict[str, Any]:
    """Return a flow as ``atleak diagnose --json`` writes it."""
    return {
        **named_record(each, "condition", "what"),
        **named_record(each.consumer, consumer="id"),
        **named_record(each, "flow_dm3_min", "usual_dm3_min", "left_low_dm3_min", "left_high_dm3_min"),
        **named_record(each, bound="bound", computed_left_dm3_min="computed"),
        "place": each.reading.place.parts,
    }
