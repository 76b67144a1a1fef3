"""Turn a summary of a fleet into the JSON record that scripts rely on: unrounded, units in the keys."""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from atleak.errors import Message
from atleak.fleet.columns import HASH
from atleak.fleet.summed import (
    Difference,
    ErrorKind,
    FleetSummary,
    GroupComparison,
    SummedUnit,
    ValveBody,
    VerdictCounts,
)
from atleak.spreads import PARTS, Rate, Spread
from atleak.version import __version__
from atleak.views.diagnosis_record import FORMAT
from atleak.views.message_record import message_record
from atleak.workshop_units import PERCENT

_QUANTILES = [f"p{part * PERCENT:.0f}" for part in PARTS]
_BESIDE = {Rate: ("percent",), Difference: ("differs",)}  # what a record says beside its fields
_KEYS: Mapping[type, Mapping[str, str]] = {  # of those whose keys are not their fields: each key, and what has it
    VerdictCounts: {key: key for key in ("units", "judged", "verdicts", "decisions", "provisional", "ok_in_part",
                                         "without_sheet", "rates")},
    GroupComparison: {"in_pairs": "in_pairs", "groups": "groups", "group_not_stated": "not_stated",
                      "verdicts": "verdicts", "lands": "lands", "messages": "messages"},
    ValveBody: {"controller": "controller", "name": "name", "visits": "visits", "counts": "counts",
                "deciders": "deciders", "lands": "pairs", "wear_over_mileage": "wear", "temperatures": "temperatures",
                "conditions": "conditions", "comparison": "comparison", "messages": "messages"},
    FleetSummary: {"folder": "folder", "results_by": "atleak", "by": "by", "headings": "headings", "visits": "visits",
                   "counts": "counts", "groups": "groups", "group_not_stated": "not_stated", "controllers": "bodies",
                   "errors": "errors", "worst": "worst", "messages": "messages"},
}  # fmt: skip


def summary_record(summary: FleetSummary) -> dict[str, Any]:
    """Return the record of a summary, in the form ``atleak fleet summary --json`` writes."""
    return {"format": FORMAT, "atleak": __version__, **_record(summary)}


def _record(value: Any) -> Any:
    if isinstance(value, Message):
        return message_record(value)
    if isinstance(value, dt.date):
        return value.isoformat()
    if isinstance(value, Mapping):
        return {key or "none": _record(each) for key, each in value.items()}
    if isinstance(value, tuple):
        return [_record(each) for each in value]
    return _fields(value) if is_dataclass(value) else value


def _fields(value: Any) -> dict[str, Any]:
    """Return the record of an object: its fields by their names, a land's key by component and land."""
    own = {each.name: each.name for each in fields(value) if each.name != HASH} | {
        name: name for name in _BESIDE.get(type(value), ())
    }
    made: dict[str, Any] = {}
    for key, name in _KEYS.get(type(value), own).items():
        of_it = getattr(value, name)
        if name == "key":
            made["component"], made["land"] = of_it
        elif isinstance(value, SummedUnit) and name == "decided_by":
            made[key] = _decided_by(of_it)
        elif isinstance(value, Spread) and name == "quantiles":
            made[key] = None if of_it is None else dict(zip(_QUANTILES, of_it, strict=True))
        elif isinstance(value, ErrorKind) and name == "first":
            made[key] = [{"name": file, "message": message} for file, message in of_it]
        else:
            made[key] = _record(of_it)
    return made


def _decided_by(what: tuple[str, int] | str | None) -> dict[str, Any]:
    component, land = what if isinstance(what, tuple) else (None, None)
    return {"kind": "land" if isinstance(what, tuple) else what, "component": component, "land": land}
