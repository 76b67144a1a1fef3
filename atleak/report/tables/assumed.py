"""Say which values of a result are assumed, neither measured nor published, and which would change the verdict."""

from __future__ import annotations

from typing import Any

from atleak.analysis.assumed import AssumedValue, Ending, assumed_values
from atleak.common.units import PERCENT, SYSTEMS
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.json.conditions import named_record
from atleak.report.tables.table import Column, Judged, Section, Table, Text

_ORDER = ("verdict", "decision", "nothing", "cause", None)
_SMALL = 1e-3  # number from which on it is written in full


def assumed_line(diagnosis: Diagnosis, say: Wording) -> str:
    """Say how many kinds of value are assumed, and which of them would change the verdict by themselves."""
    values = assumed_values(diagnosis)
    named = [_name(each, say) for each in values if each.changes == "verdict"]
    said = [say("assumed.count", count=len(values))]
    if named:
        said.append(say("assumed.change", count=len(named), values=", ".join(named)))
    elif any(each.changes for each in values):
        said.append(say("assumed.change_none"))
    return " ".join(said)


def assumed_section(diagnosis: Diagnosis, say: Wording) -> Section:
    """Return all of them as a table, those that change most first, with what is said above it."""
    title, table = say("sections.assumptions"), assumed_table(diagnosis, say)
    return Section("assumed", title, (Text(assumed_line(diagnosis, say)), table, Text(say("assumed.how"), small=True)))


def assumed_table(diagnosis: Diagnosis, say: Wording) -> Table:
    """Return all of them as a table, those that change most first."""

    def name(each: AssumedValue) -> str:
        count = f" ({each.count})" if each.count > 1 else ""
        return f"{_name(each, say)}{count}"

    def value(each: AssumedValue) -> str | None:
        if each.values is None or each.kind is None:
            return None
        small = each.values[1] < _SMALL and each.kind == "number"
        numbers = (f"{end:.2g}" if small else say.plain_value(round(end, 3), each.kind) for end in each.values)
        return f"{'–'.join(dict.fromkeys(numbers))} {say.unit(each.kind)}".rstrip()

    def off(each: AssumedValue) -> str | None:
        if each.off is None or each.kind is None:
            return None
        kind, sign = _DIFFERENCES.get(each.kind, each.kind), _SIGNS.get(each.what, "±")
        by = say.percent(each.off / PERCENT, 0) if each.relative else say.quantity(each.off, kind)
        return f"{sign}\u00a0{by}".strip()

    def end(each: AssumedValue, place: int) -> Judged:
        if each.ends is None:
            return Judged(None)
        which = each.ends[place]
        likely = "" if which.probability is None else f" ({say.percent(which.probability, 0)})"
        changed = which.verdict if which.verdict != each.ends[0].verdict else None  # coloured where it is another
        return Judged(f"{say.level(which.verdict)}{likely}", changed)

    def file(each: AssumedValue) -> str:
        return say.table("assumed_files").get(each.stands_in, each.stands_in)

    columns = (
        Column("assumed_what", of=name, width=170),
        Column("assumed_changes", of=lambda each: say.get("assumed_changes", each.changes or "unknown"), width=105),
        Column("assumed_low", of=lambda each: end(each, 1), width=115),
        Column("assumed_high", of=lambda each: end(each, 2), width=115),
        Column("assumed_value", of=value, width=105),
        Column("assumed_off", of=off, width=105),
        Column("assumed_file", of=file, width=175),
    )
    rows = sorted(assumed_values(diagnosis), key=lambda each: _ORDER.index(each.changes))
    return Table("assumed", columns, rows, say)


def assumed_records(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return the same for scripts, in the order of the files."""
    return [
        {
            **named_record(each, "what", "stands_in", "count"),
            "value_low": each.values[0] if each.values else None,
            "value_high": each.values[1] if each.values else None,
            "unit": SYSTEMS["metric"][each.kind].name if each.kind else None,
            "off": each.off,
            "off_is_percent": each.relative,
            **{name: each.ends and _record(each.ends[place]) for place, name in enumerate(("now", "low", "high"))},
            "changes": each.changes,
        }
        for each in assumed_values(diagnosis)
    ]


def _record(end: Ending) -> dict[str, Any]:
    return named_record(end, "verdict", "decision", probability_over_limit="probability")


_SIGNS = {"eccentricity": "+", "fluid_state": "−"}  # of those that can be off one way alone
_DIFFERENCES = {"temperature": "temperature_difference"}  # kinds of which a difference is another


def _name(each: AssumedValue, say: Wording) -> str:
    if each.rule is not None:
        return say("assumed.limit", rule=say(f"rules.{each.rule}"))
    return say.table("bases").get(each.what) or say.get("uncertainty_assumed", each.what)
