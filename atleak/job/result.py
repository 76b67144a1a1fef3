"""Issue a job's result as the record that other programs read, with a hash by which it is known.

Say where today's version of atleak comes to another result than the stored one, and how far each step of a job is.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from atleak.analysis.record_doubts import record_doubts
from atleak.common.sentences import Name, Sentence
from atleak.common.units import Quantity
from atleak.common.verdicts import Verdict, level_named
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import Job
from atleak.report.json.conditions import message_record
from atleak.report.json.diagnosis import diagnosis_record

_NOT_JUDGED = Sentence("not judged")
_DECISIONS = {
    "pass": Sentence("pass"),
    "conditional_pass": Sentence("conditional pass"),
    "conditional_fail": Sentence("conditional fail"),
    "fail": Sentence("fail"),
}


_NUMBERS: Mapping[str, tuple[Sentence, str]] = {  # keys of the record: what each is called, and of which kind it is
    "spool_diameter_mm": (Sentence("diameter of the spool"), "length"),
    "sleeve_diameter_mm": (Sentence("diameter of the bore"), "length"),
    "radial_clearance_um": (Sentence("radial clearance"), "clearance"),
    "mounting_clearance_um": (Sentence("mounting clearance"), "clearance"),
    "leakage_dm3_min": (Sentence("leakage"), "leak"),
    "share_percent": (Sentence("share of the pump's flow"), "percent"),
    "p_g_held_kpa": (Sentence("line pressure held"), "pressure"),
}
_TOLERATED = 1e-6  # relative: another computer's last digits


def judged_otherwise(
    stored: Mapping[str, Any], today: Mapping[str, Any], *, numbers: bool = False
) -> tuple[Sentence, ...]:
    """Say where two results of one job differ, the verdict of the unit first.

    Parameters
    ----------
    stored, today
        results as ``atleak diagnose --json`` writes them. What only one of them judges counts as *not judged* in the
        other.
    numbers
        whether the numbers of lands and totals of which the verdict is the same are compared too; a file that holds no
        result differs in nothing then.
    """
    if numbers and not stored:
        return ()
    before, now = ({what: (place, row) for what, place, row in _judged(result)} for result in (stored, today))
    verdicts, others = [], []
    for what in dict.fromkeys([*before, *now]):
        (was, row), (is_now, again) = (each.get(what, (_NOT_JUDGED, {})) for each in (before, now))
        if was != is_now:
            verdicts.append((what, was, is_now))
        elif numbers:
            keys = [key for key in _NUMBERS if key in row and key in again and not _same(row[key], again[key])]
            others += [(what, _number(key, row[key]), _number(key, again[key])) for key in keys]
    return tuple(
        Sentence("{what}: {stored}, today {today}", what=what, stored=was, today=is_now)
        for what, was, is_now in (*verdicts, *others)
    )


def _rows(result: Mapping[str, Any], name: str) -> Iterator[Mapping[str, Any]]:
    """Return the rows of a table; of a file that somebody has changed not all may be rows."""
    table = result.get(name)
    return (row for row in table if isinstance(row, dict)) if isinstance(table, list) else iter(())


def _number(key: str, value: object) -> Sentence:
    called, kind = _NUMBERS[key]
    if not isinstance(value, float | int):
        return Sentence("{called} –", called=called)
    return Sentence("{called} {value:.6g} {value.unit}", called=called, value=Quantity(value, kind))


def _same(before: object, now: object) -> bool:
    if isinstance(before, float | int) and isinstance(now, float | int):
        return math.isclose(before, now, rel_tol=_TOLERATED, abs_tol=1e-9)
    return before == now


def _judged(result: Mapping[str, Any]) -> Iterator[tuple[Sentence, Sentence, Mapping[str, Any]]]:
    """Return all that a result judges: what it is, its verdict with its decision, and its numbers."""
    unit = result.get("unit")
    decision = unit.get("decision") if isinstance(unit, dict) else None
    yield Sentence("the unit"), _words(result.get("verdict"), decision), {}
    for land in _rows(result, "lands"):
        pair = Sentence("{pair}", pair=f"{land.get('component')}/{land.get('land')}")
        yield pair, _words(land.get("verdict"), land.get("decision")), land
    for condition in _rows(result, "conditions"):
        at = Name(condition.get("label") or condition.get("name"))
        total = Sentence("total at {condition}", condition=at)
        yield total, _words(condition.get("band"), condition.get("decision")), condition
        for circuit in _rows(condition, "circuits"):
            called = Name(circuit.get("name") or circuit.get("id"))
            place = Sentence("{circuit} at {condition}", circuit=called, condition=at)
            yield place, _words(circuit.get("verdict"), circuit.get("decision")), {}


def _words(verdict: str | None, decision: str | None) -> Sentence:
    level = _NOT_JUDGED
    if verdict:
        known = level_named(str(verdict))
        measured = known is not Verdict.NOT_MEASURED
        level = Sentence("{verdict}", verdict=known) if measured else Sentence("not measured")
    if not decision:
        return level
    return Sentence("{verdict} ({decision})", verdict=level, decision=_DECISIONS.get(str(decision), decision))


def result_record(diagnosis: Diagnosis, job: Job | None = None) -> dict[str, Any]:
    """Return the record of a diagnosis, in the form ``atleak diagnose --json`` writes."""
    record = diagnosis_record(diagnosis)
    of_job = None
    if job is not None:
        of_job = {**job.identity, "doubts": [message_record(each) for each in record_doubts(job, diagnosis)]}
    return {**record, "job": of_job, "result_sha256": result_sha256(record)}


def result_sha256(record: Mapping[str, Any]) -> str:
    """Return the SHA-256 of a result, as hexadecimal digits: the same for the same result, whosever job it is.

    It is that of the JSON in UTF-8 with keys in the order of their signs, without spaces and line ends.
    """
    text = json.dumps(record, ensure_ascii=False, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode("utf-8", errors="backslashreplace")).hexdigest()


@dataclass(frozen=True)
class Step:
    """A step on a job's way: its name in the texts, whether anything is missing, and what is there or is missing."""

    name: str
    complete: bool
    state: str = ""


def job_steps(diagnosis: Diagnosis, job: Job, say: Wording) -> tuple[Step, ...]:
    """Return the steps of a job in their order, in the reader's language."""
    lands, measured = len(diagnosis.lands), diagnosis.measured
    named = job.number or job.vehicle.registration or job.vehicle.vin
    readings = "all" if measured == lands else "some" if measured else "none"
    in_the_car = {name: getattr(diagnosis, name) for name in ("pressures", "log", "flows", "vacuum")}
    found = [say(f"steps.measured_{name}") for name, each in in_the_car.items() if each]
    verdict = say.signed(diagnosis.verdict)
    if diagnosis.verdict is Verdict.OK and (measured < lands or diagnosis.in_doubt):
        verdict = say("steps.so_far", verdict=verdict)
    return (
        Step("job", bool(named), named or say("steps.no_number")),
        Step("measure", measured == lands, say(f"steps.readings_{readings}", measured=measured, lands=lands)),
        Step("in_the_car", bool(found), ", ".join(found) or say("steps.readings_none")),
        Step("diagnosis", diagnosis.verdict is not Verdict.NOT_MEASURED, verdict),
        Step("plan", True),
        Step("report", True),
    )
