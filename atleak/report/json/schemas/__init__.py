"""Describe the JSON that the command line writes, as JSON Schema: every key, its unit, what may be null.

Parts that list verdicts or bands are made of `atleak.common.verdicts`; the others stand in the files of this folder. An
object that names no keys as required requires all of them.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

from atleak.common.verdicts import BANDS, FLAGGED, VERDICTS

DIALECT = "https://json-schema.org/draft/2020-12/schema"
OUTPUTS = {
    "diagnose": "diagnose --json, report --formats json",
    "evidence": "evidence --json",
    "variants": "variants --json",
    "import-log": "import-log --json",
    "compare": "compare --json",
    "jobs-list": "jobs list --json",
    "jobs-show": "jobs show --json",
    "controllers": "controllers --json",
    "fluids": "fluids --json",
    "limits": "limits --json",
    "instruments": "instruments --json",
    "gauge-study": "gauge-study --json",
    "controller-learn": "controller learn --json",
    "fleet-summary": "fleet summary --json",
}
"""What is written in JSON, by the name of its schema: the command and its option."""

_NOTE = (
    "Numbers are not rounded and carry their unit at the end of the key; what is not known is null. "
    "Keys may come beside these within a format; none is taken away and none changes what it means."
)
_DEFS = "#/$defs/"


def _of_each(levels: Iterable[str], part: dict[str, Any]) -> dict[str, Any]:
    """Describe an object with one value for each level."""
    names = [str(level) for level in levels]
    return {"type": "object", "properties": dict.fromkeys(names, part), "required": names}


_BY_LEVEL = {
    "verdict": {"enum": [str(verdict) for verdict in VERDICTS]},
    "band": {"enum": [str(band) for band in BANDS]},
    "units_by_verdict": _of_each(VERDICTS, {"type": "integer"}),
    "rates_by_verdict": _of_each(FLAGGED, {"$ref": f"{_DEFS}rate"}),
    "units_by_band": _of_each(BANDS, {"type": "integer"}),
    "time_in_bands": _of_each(BANDS, {"type": "number"}),
}


@cache
def _parts() -> dict[str, Any]:
    files = sorted(Path(__file__).parent.glob("*.json"))
    written = (json.loads(file.read_bytes(), object_hook=_with_required)["$defs"] for file in files)
    return _BY_LEVEL | {name: part for parts in written for name, part in parts.items()}


def _with_required(part: dict[str, Any]) -> dict[str, Any]:
    """Require all keys of an object but where it says itself which; that stands behind its properties."""
    if part.get("type") != "object" or not isinstance(part.get("properties"), dict):
        return part
    required = part.pop("required", list(part["properties"]))
    described: dict[str, Any] = {}
    for name, value in part.items():
        described[name] = value
        if name == "properties" and required:
            described["required"] = required
    return described


def schema(output: str) -> dict[str, Any]:
    """Return the JSON Schema of what a command writes, whole in itself.

    Parameters
    ----------
    output
        one of `OUTPUTS`.
    """
    parts = _parts()
    used: dict[str, Any] = {}
    waiting = list(_named_in(parts[output]))
    while waiting:
        name = waiting.pop()
        if name not in used:
            used[name] = parts[name]
            waiting += _named_in(parts[name])
    about = f"{parts[output]['description']} {_NOTE}"
    head = {"$schema": DIALECT, "$id": f"urn:atleak:{output}:1", "title": f"atleak {output}"}
    return {**head, **parts[output], "description": about, "$defs": dict(sorted(used.items()))}


def _named_in(part: Any) -> Iterator[str]:
    """Yield the names of the parts that a part refers to."""
    if isinstance(part, dict):
        for key, value in part.items():
            if key == "$ref":
                yield value.removeprefix(_DEFS)
            else:
                yield from _named_in(value)
    elif isinstance(part, list):
        for each in part:
            yield from _named_in(each)
