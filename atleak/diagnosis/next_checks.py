"""Say what to check next after a road test: a pure function of what the log says.

A check is advice, not a verdict. Each names where it comes from: how workshops read pressures, a published limit, the
source study, or this project's own choice. The words stand with the other texts, by language.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

from atleak.common.unit_systems import KPA, Quantity
from atleak.diagnosis.road_findings import RoadFindings
from atleak.engine.road_pressure import SLUMP_SPAN, STATES, PlaceFinding, RoadPressure

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
    against = tuple(_against_command(findings, commanded_limit, low=low))
    as_commanded = any(check.code == "low_as_commanded" for check in against)  # then no leak is behind it
    checks = [
        *(_where_low(permitted, leaks=not as_commanded) if permitted is not None and low else ()),
        *against,
        *(_too_high(permitted) if permitted is not None else ()),
        *_not_judged(findings, gauged=gauged),
        *_tests(findings),
        *_temperature(findings, low=low),
    ]
    return tuple(checks)


def _where_low(permitted: RoadPressure, *, leaks: bool) -> Iterator[NextCheck]:
    """Read from where pressure is low, and from how warm the fluid is there, what may be behind it.

    ``leaks``: whether a leak may be behind a fall with the fluid's temperature; else it falls as commanded.
    """
    judged = [place for place in permitted.places if place.worst is not None]
    low = [place for place in judged if place.below > 0.0]
    fine = [place for place in judged if not place.below]
    slumps = [place for place in low if place.slump is not None] if leaks else []
    if slumps:
        yield from _falls_with_heat(min(slumps, key=_idle_and_lowest_first))
        hot, cold = (pick(place.held[end].temperature for place in slumps) for pick, end in ((max, -1), (min, 0)))
        # others were not seen as hot, or as cold
        fine = [place for place in fine if place.held and place.held[-1].temperature >= hot - SLUMP_SPAN]
        cold_too = [place for place in low if place.held and place.held[0].temperature <= cold + SLUMP_SPAN]
        if not fine and all(place in slumps for place in cold_too):
            return  # fluid level and filter come first only where it is low from cold
    if not fine:
        alone = len({(place.gear, place.state) for place in low}) == 1
        yield NextCheck("low_where_judged" if alone else "low_everywhere", "project")
        coldest = [place.held[0].temperature for place in low if place.held]
        if coldest and min(coldest) >= WARM:
            yield NextCheck("compare_cold", "practice", {"coldest": Quantity(min(coldest), "temperature")})
    elif all(place.state == "idle" for place in low) and any(place.state != "idle" for place in fine):
        yield NextCheck("low_at_idle_only", "practice")
    elif len(gears := _gears(low)) == 1 and not gears & _gears(fine):
        yield NextCheck("low_in_one_gear", "practice", {"gear": str(min(gears))})
    elif all(place.state != "idle" for place in low) and any(place.state == "idle" for place in fine):
        yield NextCheck("low_under_load", "project")
    else:
        yield NextCheck("low_in_some", "project", {"gears": ", ".join(map(str, sorted(gears)))})
    if not slumps:
        yield NextCheck("then_measure", "project")


def _idle_and_lowest_first(place: PlaceFinding) -> tuple[int, float]:
    return STATES.index(place.state), -place.worst.fraction if place.worst is not None else 0.0


def _falls_with_heat(place: PlaceFinding) -> Iterator[NextCheck]:
    if place.slump is not None and place.worst is not None:
        cold, hot = place.slump
        values: dict[str, str | Quantity] = {"gear": str(place.gear), "state": place.state}
        for name, each in (("cold", cold), ("hot", hot)):
            values[name] = Quantity(each.pressure * KPA, "pressure")
            values[f"{name}_at"] = Quantity(each.temperature, "temperature")
        values["least"] = Quantity(place.worst.limit * KPA, "pressure")
        yield NextCheck("falls_with_heat", "practice", values)


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


def _temperature(findings: RoadFindings, *, low: bool) -> Iterator[NextCheck]:
    if findings.temperatures is None:
        yield NextCheck("log_temperature_low", "practice") if low else NextCheck("log_temperature", "project")
    elif findings.temperatures[1] < WARM:
        reached, warm, hottest = (Quantity(each, "temperature") for each in (findings.temperatures[1], WARM, HOTTEST))
        values = {"highest": reached, "warm": warm, "hottest": hottest}
        yield NextCheck("warm_up", "practice", values)
