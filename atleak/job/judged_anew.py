"""Say where today's version of atleak comes to another result of a job than the one that was stored with it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from atleak.sentence import Name, Sentence
from atleak.unit_systems import Quantity
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


def differs(stored: Mapping[str, Any], today: Mapping[str, Any]) -> tuple[JudgedOtherwise, ...]:
    """Compare two results of one job: verdicts, and the numbers of lands and totals of which the verdict is the same.

    Parameters
    ----------
    stored, today
        as of `judged_otherwise`; a file that holds no result differs in nothing.
    """
    if not stored:
        return ()
    verdicts = judged_otherwise(stored, today)
    said = {str(each.what) for each in verdicts}
    before, now = dict(_numbered(stored)), dict(_numbered(today))
    numbers = (
        JudgedOtherwise(what, _number(key, before[what][key]), _number(key, now[what][key]))
        for what in before
        if what in now and str(what) not in said
        for key in _NUMBERS
        if key in before[what] and key in now[what] and not _same(before[what][key], now[what][key])
    )
    return (*verdicts, *numbers)


_NUMBERS: Mapping[str, tuple[Sentence, str]] = {  # keys of the record: what each is called, and of which kind it is
    "spool_diameter_mm": (Sentence("diameter of the spool"), "length"),
    "sleeve_diameter_mm": (Sentence("diameter of the bore"), "length"),
    "radial_clearance_um": (Sentence("radial clearance"), "clearance"),
    "mounting_clearance_um": (Sentence("mounting clearance"), "clearance"),
    "leakage_dm3_min": (Sentence("leakage"), "flow"),
    "share_percent": (Sentence("share of the pump's flow"), "percent"),
    "p_g_held_kpa": (Sentence("line pressure held"), "pressure"),
}
_TOLERATED = 1e-6  # relative: another computer's last digits


def _numbered(result: Mapping[str, Any]) -> Iterator[tuple[Sentence, Mapping[str, Any]]]:
    """Return every land and every total of a result with its numbers."""
    for land in _rows(result, "lands"):
        yield _pair(land), land
    for condition in _rows(result, "conditions"):
        yield _total_at(condition), condition


def _rows(result: Mapping[str, Any], name: str) -> Iterator[Mapping[str, Any]]:
    """Return the rows of a table; of a file that somebody has changed not all may be rows."""
    table = result.get(name)
    return (row for row in table if isinstance(row, dict)) if isinstance(table, list) else iter(())


def _pair(land: Mapping[str, Any]) -> Sentence:
    return Sentence("{pair}", pair=f"{land.get('component')}/{land.get('land')}")


def _number(key: str, value: object) -> Sentence:
    called, kind = _NUMBERS[key]
    if not isinstance(value, float | int):
        return Sentence("{called} –", called=called)
    return Sentence("{called} {value:.6g} {value.unit}", called=called, value=Quantity(value, kind))


def _same(before: object, now: object) -> bool:
    if isinstance(before, float | int) and isinstance(now, float | int):
        return math.isclose(before, now, rel_tol=_TOLERATED, abs_tol=1e-9)
    return before == now


def _verdicts(result: Mapping[str, Any]) -> Iterator[tuple[Sentence, Sentence]]:
    """Return every verdict of a result with its decision, by what is judged."""
    unit = result.get("unit")
    decision = unit.get("decision") if isinstance(unit, dict) else None
    yield Sentence("the unit"), _words(result.get("verdict"), decision)
    for land in _rows(result, "lands"):
        yield _pair(land), _words(land.get("verdict"), land.get("decision"))
    for condition in _rows(result, "conditions"):
        at = Name(condition.get("label") or condition.get("name"))
        yield _total_at(condition), _words(condition.get("band"), condition.get("decision"))
        for circuit in _rows(condition, "circuits"):
            called = Name(circuit.get("name") or circuit.get("id"))
            said = Sentence("{circuit} at {condition}", circuit=called, condition=at)
            yield said, _words(circuit.get("verdict"), circuit.get("decision"))


def _total_at(condition: Mapping[str, Any]) -> Sentence:
    return Sentence("total at {condition}", condition=Name(condition.get("label") or condition.get("name")))


def _words(verdict: str | None, decision: str | None) -> Sentence:
    level = _level(str(verdict)) if verdict else _NOT_JUDGED
    if not decision:
        return level
    return Sentence("{verdict} ({decision})", verdict=level, decision=_DECISIONS.get(str(decision), decision))


def _level(verdict: str) -> Sentence:
    level = level_named(verdict)
    return Sentence("not measured") if level is Verdict.NOT_MEASURED else Sentence("{verdict}", verdict=level)
