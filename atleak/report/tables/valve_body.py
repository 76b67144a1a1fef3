"""Show what a controller's values are known from, and what a workshop must still measure or look up."""

from __future__ import annotations

from collections import Counter

from atleak.catalogue.controller import Controller
from atleak.catalogue.entries import Evidence
from atleak.catalogue.known_values import KnownValue, counted_values, known_values
from atleak.common.wording import Wording
from atleak.report.tables.table import Column, Table, columns


def evidence_counts(controller: Controller) -> dict[str, int]:
    """Count the values by what they are known from; ``not_stated`` are those of which the file says nothing."""
    counts = counted_values(_values(controller))
    return {evidence or "not_stated": count for evidence, count in counts.items()}


def evidence_table(controller: Controller, say: Wording) -> Table:
    """Return a row for each kind of value: how many of it are known from what."""
    values = _values(controller)
    rows = []
    for kind in dict.fromkeys(each[:2] for each in values):
        counts = counted_values([each for each in values if each[:2] == kind])
        known = {each.value: counts[each] for each in Evidence}
        rows.append({"values": _kind_words(kind, say), **known, "not_stated": counts[None]})
    counted_columns = (Column(name, digits=0) for name in (*Evidence, "not_stated"))
    return Table("evidence", columns("values", *counted_columns), rows, say)


def open_values(controller: Controller, say: Wording) -> list[str]:
    """Say which kinds of values are representative and how many of each, the most numerous first."""
    return [
        say("catalogue.open_values", kind=_kind_words(kind, say), count=count)
        for kind, count in _open_kinds(controller).most_common()
    ]


def _kind_words(kind: tuple[str, str], say: Wording) -> str:
    return say(f"value_kinds.{'_'.join(filter(None, kind))}")


def _open_kinds(controller: Controller) -> Counter[tuple[str, str]]:
    open_ones = [each for each in _values(controller) if each.evidence is Evidence.REPRESENTATIVE]
    return Counter(each[:2] for each in open_ones)


def _values(controller: Controller) -> tuple[KnownValue, ...]:
    return () if controller.entry is None else known_values(controller.entry)
