"""Makes delimited text of a log whose lines are JSON objects: each a sample, or one signal at a time.

A signal has a name, a value and a time, as OpenXC writes them: it is the one filled cell of its row.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from atleak.common.errors import Message, Place, RoadTestError
from atleak.common.sentences import Sentence
from atleak.readers.logs.log_cells import quoted
from atleak.readers.logs.log_file import LARGE, LogFile
from atleak.readers.logs.text_lines import one_line_end, to_text

_DEPTH = 5  # of objects within objects that are looked at
_MANY = 0.1  # part of the lines that are no objects, as in no log


def as_text(source: LogFile) -> LogFile:
    """Return a log of JSON objects as delimited text; refuse one of which many lines are none."""
    text = to_text(source.data)
    lines = one_line_end(text.data).split(b"\n")
    names: dict[str, None] = {}
    bad: list[int] = []
    for number, line in enumerate(lines):
        record = _record(line) if line.strip() else {}
        names |= dict.fromkeys(record or ())
        bad += [number] if record is None else []
    if len(bad) > max(1, _MANY * len(lines)):
        raise RoadTestError(
            Sentence("is no JSON object"), place=Place(file=source.file, row=bad[0] + 1),
            value=quoted(text.decode(lines[bad[0]])), expected=Sentence("one object a line"),
        )  # fmt: skip
    written = io.StringIO()
    rows = csv.DictWriter(written, list(names), lineterminator="\n")
    rows.writeheader()
    rows.writerows(filter(None, map(_record, lines)))
    data = written.getvalue().encode("utf-8", "replace")
    said = Sentence("{count} line(s) that are no JSON object left out", count=len(bad))
    notes = (Message("warning", "lines_left_out", said, Place(file=source.file)),) if bad else ()
    return replace(source, head=data[:LARGE], form="text", size=len(data), path=None, content=data, notes=notes)


def _record(line: bytes) -> dict[str, Any] | None:
    """Return the values of an object by name, of a signal its time and its value; None where a line is no object."""
    try:
        read = json.loads(line)
    except (ValueError, RecursionError):
        return None
    if not isinstance(read, dict):
        return None
    if read.keys() == {"metadata"}:  # of the file, in OpenXC's first line
        return {}
    if {"timestamp", "name", "value"} <= read.keys():
        read = {"timestamp": read["timestamp"], str(read["name"]): read["value"]}
    return dict(_flat(read))


def _flat(read: dict[str, Any], above: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Yield the values of an object, and those of objects in it, by their path."""
    for name, value in read.items():
        if isinstance(value, dict) and depth < _DEPTH:
            yield from _flat(value, f"{above}{name}/", depth + 1)
        elif isinstance(value, str | int | float):
            yield f"{above}{name}", value
