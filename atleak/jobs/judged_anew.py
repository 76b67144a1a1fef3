"""Say where today's version of atleak judges a job otherwise than the result that was stored with it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from atleak.sentence import Name, Sentence
from atleak.verdicts import Verdict, level_named


@dataclass(frozen=True)
class JudgedOtherwise:
    """One verdict that differs."""

    what: Sentence  # the unit, a land or a condition, as people read it
    stored: Sentence
    today: Sentence

    @property
    def sentence(self) -> Sentence:
        """Return what is judged otherwise, and how."""
        return Sentence("{what}: {stored}, today {today}", what=self.what, stored=self.stored, today=self.today)

    def __str__(self) -> str:
        return str(self.sentence)


_NOT_JUDGED = Sentence("not judged")
_DECISIONS = {
    "pass": Sentence("pass"),
    "conditional_pass": Sentence("conditional pass"),
    "conditional_fail": Sentence("conditional fail"),
    "fail": Sentence("fail"),
}


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
        JudgedOtherwise(what, before.get(what, _NOT_JUDGED), now.get(what, _NOT_JUDGED))
        for what in dict.fromkeys([*before, *now])
        if before.get(what) != now.get(what)
    )


def _verdicts(result: Mapping[str, Any]) -> Iterator[tuple[Sentence, Sentence]]:
    """Return every verdict of a result with its decision, by what is judged."""
    unit = result.get("unit") or {}
    yield Sentence("the unit"), _words(result.get("verdict"), unit.get("decision"))
    for land in result.get("lands", ()):
        pair = Sentence("{pair}", pair=f"{land['component']}/{land['land']}")
        yield pair, _words(land.get("verdict"), land.get("decision"))
    for condition in result.get("conditions", ()):
        at = Name(condition.get("label") or condition.get("name"))
        yield Sentence("total at {condition}", condition=at), _words(condition.get("band"), condition.get("decision"))
        for circuit in condition.get("circuits", ()):
            called = Name(circuit.get("name") or circuit.get("id"))
            said = Sentence("{circuit} at {condition}", circuit=called, condition=at)
            yield said, _words(circuit.get("verdict"), circuit.get("decision"))


def _words(verdict: str | None, decision: str | None) -> Sentence:
    level = _level(verdict) if verdict else _NOT_JUDGED
    if not decision:
        return level
    return Sentence("{verdict} ({decision})", verdict=level, decision=_DECISIONS.get(decision, decision))


def _level(verdict: str) -> Sentence:
    level = level_named(verdict)
    return Sentence("not measured") if level is Verdict.NOT_MEASURED else Sentence("{verdict}", verdict=level)
