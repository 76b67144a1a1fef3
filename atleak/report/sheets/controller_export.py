"""Write a valve body's description to pass on: one file, with where it comes from and without whose units it is of."""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from atleak.analysis.learning.learned_words import without_sheets
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import written_toml
from atleak.catalogue.entries import read_tables, shipped_files
from atleak.report.tables.catalogue import evidence_counts
from atleak.version import __version__

_WORDS = ("name", "label", "source", "note", "representative", "required")  # keys whose text people write
_LEFT_OUT = "…"
_TELLS = re.compile(  # whose unit it is of: a path, a file's name, a vehicle's number
    r"(?<![\w/:.])(?:[A-Za-z]:[\\/]|\\\\|~[\\/]|/(?=\w+/))[^\s,;]*"
    r"|(?<![^\s,;()])(?!https?://)[^\s,;()]+\.(?:xls[xm]?|ods|csv|tsv|txt|toml|json|pdf|docx?|zip|atleak|mf4|mat)\b"
    r"|\b(?=[A-Z\d]*\d)[A-HJ-NPR-Z\d]{17}\b"
)


@dataclass(frozen=True)
class Exported:
    """The file, and what its giver is to read before it is passed on."""

    text: str  # TOML, as ``--controller`` reads it
    own_words: tuple[str, ...]  # texts in it that do not ship with atleak
    left_out: int  # paths, names of files and numbers of vehicles


def exported_controller(tables: Mapping[str, Any], controller: Controller, day: dt.date) -> Exported:
    """Return the file of a valve body to pass on: no result changes where it is read in place of the one that it is of.

    At its head stands, as TOML behind ``#``, which atleak wrote it when, the SHA-256 of the file that it is of, how its
    values are known, and from how many units which of its clearances were learned when. Comments are not kept.

    Parameters
    ----------
    tables
        of the file of ``controller``, as `atleak.catalogue.entries.read_tables` gives them.
    controller
        that they describe.
    day
        of the export.
    """
    note, learned_on = without_sheets(tables.get("note", ""))
    shipped = {
        text
        for path in shipped_files("controllers").values()
        for _, text in _texts(read_tables("controllers", path)[0])
    }
    count = 0

    def passed_on(value: Any) -> Any:
        nonlocal count
        if isinstance(value, dict):
            return {key: passed_on(each) for key, each in value.items()}
        if isinstance(value, list):
            return [passed_on(each) for each in value]
        if not isinstance(value, str) or value in shipped:
            return value
        told, found = _TELLS.subn(_LEFT_OUT, value)
        count += found
        return told

    given = passed_on({**tables, "note": note} if "note" in tables else dict(tables))
    units = [land.learned_from_units for land in controller.lands if land.learned_from_units is not None]
    provenance = {
        "atleak": __version__,
        "exported": day.isoformat(),
        "sha256": controller.sha256,
        "values": evidence_counts(controller),
        "lands": len(controller.lands),
        "learned": {"lands": len(units), "units": [min(units), max(units)] if units else [], "on": learned_on},
    }
    head = "".join(f"# {line}\n" for line in written_toml({"provenance": provenance}).splitlines() if line)
    own = dict.fromkeys(text for key, text in _texts(given) if key in _WORDS and text not in shipped | {""})
    return Exported(head + "\n" + written_toml(given), tuple(own), count)


def _texts(value: Any, key: str = "") -> Iterator[tuple[str, str]]:
    """Return every text of tables with the key that it stands under."""
    if isinstance(value, str):
        yield key, value
    elif isinstance(value, dict):
        for name, each in value.items():
            yield from _texts(each, name)
    elif isinstance(value, list):
        for each in value:
            yield from _texts(each, key)
