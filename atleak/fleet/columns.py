"""List the columns of the data sets in which the results of a fleet are kept.

What a diagnosis says of lands, conditions, circuits and events stands there under the keys of ``atleak diagnose
--json``: their names and types are those of its JSON Schema. What is said of a unit and of an error is listed here.
Every data set has its rows' unit by `HASH`; the valve body, `PARTITION`, stands in the folder's name alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, cast, get_args

import pyarrow as pa

from atleak.common.verdicts import BANDS, Verdict
from atleak.report.json.schemas import schema as json_schema

DataSet = Literal["units", "lands", "conditions", "circuits", "events", "temperatures", "errors"]
DATA_SETS: tuple[DataSet, ...] = get_args(DataSet)
ErrorKind = Literal["refused", "time limit", "ended", "fault"]
"""Why a unit has no result: its files are at fault; it took too long; its worker ended; atleak is at fault."""
ERROR_KINDS: tuple[ErrorKind, ...] = get_args(ErrorKind)

HASH = "input_sha256"  # by which rows are told to be of one unit
PARTITION = "controller"  # id of the valve body

_TEXT, _NUMBER, _WHOLE, _YES_NO = pa.string(), pa.float64(), pa.int64(), pa.bool_()
_TEXTS, _NUMBERS = pa.map_(_TEXT, _TEXT), pa.map_(_TEXT, _NUMBER)
_INSTANT, _DAY = pa.timestamp("us", tz="UTC"), pa.date32()

_NAMED = {  # of a unit, whether it has a result or an error
    HASH: _TEXT,  # of all that its result rests on
    "reference": _TEXT,  # by which it is opened again
    "name": _TEXT,  # as people know it
    "group": _TEXT,  # sub-folder, or the column of that name in a table
    "labels": _TEXTS,  # what else a table says of it: batch, supplier
    "choices": _TEXT,  # those of the run for rows of tables, as JSON: with them it is opened again
    "atleak": _TEXT,  # version that evaluated it
    "evaluated_at": _INSTANT,
    "tries": _WHOLE,
}
_OF_UNIT = {
    **_NAMED,
    "seconds": _NUMBER,  # that the evaluation took
    # what the workshop wrote down
    "number": _TEXT,
    "date": _DAY,
    "vin": _TEXT,
    "serial": _TEXT,
    "mileage_km": _NUMBER,
    # what it was diagnosed with
    "controller_name": _TEXT,
    "controller_sha256": _TEXT,
    "fluid": _TEXT,
    "fluid_sha256": _TEXT,
    "fluid_state": _TEXT,
    "limits": _TEXT,
    "limits_sha256": _TEXT,
    "profile": _TEXT,
    "options": _TEXTS,  # every one of the profile, as text
    "assumptions": _NUMBERS,
    "guard_factor": _NUMBER,
    "complaint": _TEXT,
    # its readings
    "readings_sha256": _TEXT,
    "measured_on": _DAY,
    "lands_measured": _WHOLE,
    "lands_judged": _WHOLE,  # of which a part was measured, but for those that a ring seals
    "lands_total": _WHOLE,
    # its verdict
    "verdict": _TEXT,
    "decision": _TEXT,
    "provisional": _YES_NO,
    "decided_by_kind": _TEXT,
    "decided_by_condition": _TEXT,
    "decided_by_component": _TEXT,
    "decided_by_land": _WHOLE,
    "decided_by_circuit": _TEXT,
    # its road test
    "road_sha256": _TEXT,
    "road_rows": _WHOLE,
    "road_duration_s": _NUMBER,
    "road_in_pieces": _YES_NO,  # yes: by an earlier version, which took a large log in pieces; null without a log
    "max_leakage_dm3_min": _NUMBER,
    "max_leakage_low_dm3_min": _NUMBER,
    "max_leakage_high_dm3_min": _NUMBER,
    "max_share_percent": _NUMBER,
    "max_share_low_percent": _NUMBER,
    "max_share_high_percent": _NUMBER,
    "min_leakage_dm3_min": _NUMBER,
    "below_s": _NUMBER,  # time of main pressure below what is permitted
    "worst_below_kpa": _NUMBER,
    "road_verdict": _TEXT,  # of main pressure over the log: the worst of what is permitted and what is commanded
    "result_sha256": _TEXT,  # as `atleak diagnose --json` has it
}
_OF_TEMPERATURES = {  # a class of ATF temperature over the unit's log
    HASH: _TEXT,
    "temperature_low_c": _NUMBER,
    "temperature_high_c": _NUMBER,
    "seconds": _NUMBER,  # with leakage known
    **{f"{band}_s": _NUMBER for band in BANDS},  # of them with the share in each band
    "share_mean_percent": _NUMBER,  # weighted with time, as every mean of the class
    "share_max_percent": _NUMBER,
    "pressure_mean_kpa": _NUMBER,
    "pressure_min_kpa": _NUMBER,
    "leakage_mean_dm3_min": _NUMBER,
}
_OF_ERROR = {**_NAMED, "kind": _TEXT, "message": _TEXT}  # the message that a person would have got
_OWN: Mapping[DataSet, Mapping[str, pa.DataType]] = {
    "units": _OF_UNIT,
    "temperatures": _OF_TEMPERATURES,
    "errors": _OF_ERROR,
}
_OF_RECORD: Mapping[DataSet, str] = {
    "lands": "land",
    "conditions": "condition",
    "circuits": "circuit",
    "events": "event",
}
_BESIDE: Mapping[DataSet, Mapping[str, pa.DataType]] = {"circuits": {"condition": _TEXT}}
_LEFT_OUT: Mapping[DataSet, frozenset[str]] = {
    "conditions": frozenset({"circuits"}),  # a data set of their own
    "events": frozenset({"test"}),
}
_OF_JSON = {"string": _TEXT, "number": _NUMBER, "integer": _WHOLE, "boolean": _YES_NO}
_DEFS = "#/$defs/"


@dataclass(frozen=True)
class Rows:
    """The rows of one unit: of a result in every data set but the errors, of an error in that one alone."""

    controller: str | None  # id of the valve body; None where it is not known
    input_sha256: str
    reference: str
    verdict: Verdict | None  # None of an error
    tables: Mapping[DataSet, pa.Table]

    @property
    def error(self) -> ErrorKind | None:
        """Return why there is no result; None of a result."""
        errors = self.tables.get("errors")
        return None if errors is None else cast(ErrorKind, errors.column("kind")[0].as_py())

    def __reduce__(self) -> tuple[Any, ...]:
        """Travel as Arrow's own bytes, without columns, which both sides know."""
        batches = {data_set: table.combine_chunks().to_batches() for data_set, table in self.tables.items()}
        written = {data_set: batch.serialize().to_pybytes() for data_set, (batch,) in batches.items()}
        return _arrived, (self.controller, self.input_sha256, self.reference, self.verdict, written)


def _arrived(controller: str | None, sha256: str, reference: str, verdict: Verdict | None, written: Any) -> Rows:
    batches = {name: pa.ipc.read_record_batch(pa.py_buffer(each), columns_of(name)) for name, each in written.items()}
    tables = {data_set: pa.Table.from_batches([batch]) for data_set, batch in batches.items()}
    return Rows(controller, sha256, reference, verdict, tables)


@cache
def columns_of(data_set: DataSet) -> pa.Schema:
    """Return the columns of a data set with their types; any of them but the hash may be null."""
    if data_set in _OWN:
        return pa.schema(list(_OWN[data_set].items()))
    parts = json_schema("diagnose")["$defs"]
    keys = parts[_OF_RECORD[data_set]]["properties"]
    left_out = _LEFT_OUT.get(data_set, frozenset())
    of_record = {key: _type_of(part, parts) for key, part in keys.items() if key not in left_out}
    return pa.schema(list({HASH: _TEXT, **_BESIDE.get(data_set, {}), **of_record}.items()))


def _type_of(part: Mapping[str, Any], parts: Mapping[str, Any]) -> pa.DataType:
    """Return the type of column that holds what a part of the JSON Schema describes; any may be null."""
    if "anyOf" in part:
        part = next(each for each in part["anyOf"] if each.get("type") != "null")
    if "$ref" in part:
        return _type_of(parts[part["$ref"].removeprefix(_DEFS)], parts)
    if "enum" in part:
        return _TEXT
    (kind,) = _kinds(part)
    if kind == "array":
        return pa.list_(_type_of(part["items"], parts))
    if kind == "object":
        keys = {key: each for key, each in part["properties"].items() if not _mixed(each)}
        return pa.struct([(key, _type_of(each, parts)) for key, each in keys.items()])
    return _OF_JSON[kind]


def _kinds(part: Mapping[str, Any]) -> list[str]:
    kinds = part["type"]
    return [kind for kind in kinds if kind != "null"] if isinstance(kinds, list) else [kinds]


def _mixed(part: Mapping[str, Any]) -> bool:
    """Return whether values of several kinds stand in one list, as no column holds them: the steps to a place."""
    return part.get("type") == "array" and "type" in part["items"] and len(_kinds(part["items"])) > 1
