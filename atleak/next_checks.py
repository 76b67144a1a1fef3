"""Say what to check next after a road test: a pure function of what the log says.

A check is advice, not a verdict. Each names where it comes from: how workshops read pressures, a published limit, the
source study, or this project's own choice. The words stand with the other texts, by language.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

from atleak.engine.road_pressure import PlaceFinding, RoadPressure
from atleak.road_findings import RoadFindings
from atleak.unit_systems import Quantity
from atleak.workshop_units import KPA

CheckSource = Literal["practice", "ford_2017", "study", "project"]
WARM, HOTTEST = 50.0, 80.0  # [°C] between which workshops have a transmission before its road test


@dataclass(frozen=True)
class NextCheck:
    """One thing to check next: a code, of which ``texts/*.toml`` has the words, and what stands in their places."""

    code: str
    source: CheckSource
    values: Mapping[str, str | Quantity] = field(default_factory=dict)


def next_checks(
    findings: RoadFindings, commanded_limit: float | None, *, gauged: bool = False
) -> tuple[NextCheck, ...]:
    """Return what to check next, the most telling first.

    Parameters
    ----------
    findings
        what the log says by itself.
    commanded_limit
        from which difference on [Pa] actual and commanded pressure disagree; None where no limit is set.
    gauged
        whether main pressure was gauged on the standing vehicle: then nothing asks for that again.
    """
    permitted = findings.permitted
    low = permitted is not None and permitted.below > 0.0
    checks = [
        *(_where_low(permitted) if permitted is not None and low else ()),
        *_against_command(findings, commanded_limit, low=low),
        *(_too_high(permitted) if permitted is not None else ()),
        *_not_judged(findings, gauged=gauged),
        *_tests(findings),
        *_temperature(findings),
    ]
    return tuple(checks)


def _where_low(permitted: RoadPressure) -> Iterator[NextCheck]:
    """Read from where pressure is low what may be behind it."""
    judged = [place for place in permitted.places if place.worst is not None]
    low = [place for place in judged if place.below > 0.0]
    fine = [place for place in judged if not place.below]
    if not fine:
        alone = len({(place.gear, place.state) for place in low}) == 1
        yield NextCheck("low_where_judged" if alone else "low_everywhere", "project")
    elif all(place.state == "idle" for place in low) and any(place.state != "idle" for place in fine):
        yield NextCheck("low_at_idle_only", "practice")
    elif len(gears := _gears(low)) == 1 and not gears & _gears(fine):
        yield NextCheck("low_in_one_gear", "practice", {"gear": str(min(gears))})
    elif all(place.state != "idle" for place in low) and any(place.state == "idle" for place in fine):
        yield NextCheck("low_under_load", "project")
    else:
        yield NextCheck("low_in_some", "project", {"gears": ", ".join(map(str, sorted(gears)))})
    yield NextCheck("then_measure", "project")


def _gears(places: Iterable[PlaceFinding]) -> set[int]:
    return {place.gear for place in places}


def _against_command(findings: RoadFindings, limit: float | None, *, low: bool) -> Iterator[NextCheck]:
    compared = findings.commanded
    if compared is None:
        if low:
            yield NextCheck("log_commanded", "project")
        return
    if limit is None:
        return
    kpa = abs(compared.difference) * KPA
    values = {"kpa": Quantity(kpa, "pressure"), "limit": Quantity(limit * KPA, "pressure")}
    if compared.difference <= -limit:
        yield NextCheck("below_commanded", "ford_2017", values)
    elif compared.difference >= limit:
        yield NextCheck("above_commanded", "ford_2017", values)
    elif low:
        yield NextCheck("low_as_commanded", "project", values)


def _too_high(permitted: RoadPressure) -> Iterator[NextCheck]:
    if permitted.above > 0.0:
        yield NextCheck("above_permitted", "project")


def _not_judged(findings: RoadFindings, *, gauged: bool) -> Iterator[NextCheck]:
    """Say what to gauge or to log, where main pressure could not be judged."""
    why = findings.not_judged
    to_gauge = why in ("no_main_pressure", "not_measured")
    if why is not None and not (to_gauge and gauged):
        yield NextCheck(f"{why}_next", "practice" if to_gauge else "project")


def _tests(findings: RoadFindings) -> Iterator[NextCheck]:
    faults = {event.test.fault for event in findings.events if event.test is not None}
    if faults and None not in faults:
        yield NextCheck("repeat_test", "study")


def _temperature(findings: RoadFindings) -> Iterator[NextCheck]:
    if findings.temperatures is None:
        yield NextCheck("log_temperature", "project")
    elif findings.temperatures[1] < WARM:
        reached, warm, hottest = (Quantity(each, "temperature") for each in (findings.temperatures[1], WARM, HOTTEST))
        values = {"highest": reached, "warm": warm, "hottest": hottest}
        yield NextCheck("warm_up", "practice", values)
