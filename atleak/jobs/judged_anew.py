"""Say where today's version of atleak judges a job otherwise than the result that was stored with it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class JudgedOtherwise:
    """One verdict that differs."""

    what: str  # the unit, a land or a condition, as people read it
    stored: str
    today: str

    def __str__(self) -> str:
        return f"{self.what}: {self.stored}, today {self.today}"


def judged_otherwise(stored: Mapping[str, Any], today: Mapping[str, Any]) -> tuple[JudgedOtherwise, ...]:
    """Compare two results of one job, the verdict of the unit first.

    Parameters
    ----------
    stored, today
        results as ``atleak diagnose --json`` writes them. What only one of them judges counts as *not judged* in the
        other.
    """
    before, now = dict(_verdicts(stored)), dict(_verdicts(today))
    return tuple(
        JudgedOtherwise(what, before.get(what, "not judged"), now.get(what, "not judged"))
        for what in dict.fromkeys([*before, *now])
        if before.get(what) != now.get(what)
    )


def _verdicts(result: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Return every verdict of a result with its decision, by what is judged."""
    unit = result.get("unit") or {}
    yield "the unit", _words(result.get("verdict"), unit.get("decision"))
    for land in result.get("lands", ()):
        yield f"{land['component']}/{land['land']}", _words(land.get("verdict"), land.get("decision"))
    for condition in result.get("conditions", ()):
        at = condition.get("label") or condition.get("name")
        yield f"total at {at}", _words(condition.get("band"), condition.get("decision"))
        for circuit in condition.get("circuits", ()):
            called = circuit.get("name") or circuit.get("id")
            yield f"{called} at {at}", _words(circuit.get("verdict"), circuit.get("decision"))


def _words(verdict: str | None, decision: str | None) -> str:
    words = f"{verdict or 'not judged'} ({decision})" if decision else verdict or "not judged"
    return words.replace("_", " ")
