"""Say what to check next after a road test: a pure function of what the log says.

A check is advice, not a verdict. Each names where it comes from: how workshops read pressures, a published limit, the
source study, or this project's own choice. The words stand with the other texts, by language.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

from atleak.common.units import KPA, Quantity, gear_name
from atleak.diagnosis.road import RoadFindings
from atleak.diagnosis.warm_up import HOT, WarmUp
from atleak.engine.road_pressure import SLUMP_SPAN, STATES, PlaceFinding, RoadPressure

CheckSource = Literal["practice", "ford_2017", "study", "project"]
_COLD = 40.0  # [°C] from which on a drive shows what leaks as it warms: choice of this project
WARM, HOTTEST = 50.0, 80.0  # [°C] between which workshops have a transmission before its road test


@dataclass(frozen=True)
class NextCheck:
    """One thing to check next: a code, of which ``texts/*.toml`` has the words, and what stands in their places."""

    code: str
    source: CheckSource
    values: Mapping[str, str | Quantity] = field(default_factory=dict)


def next_checks(
    findings: RoadFindings, commanded_limit: float | None, *, gauged: bool = False, warm_up: WarmUp | None = None
) -> tuple[NextCheck, ...]:
    """Return what to check next, the most telling first.

    Parameters
    ----------
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
        *(_WhereLow(permitted, leaks=not as_commanded).checks() if permitted is not None and low else ()),
        *against,
        *([NextCheck("above_permitted", "project")] if permitted is not None and permitted.above > 0.0 else ()),
        *_not_judged(findings, gauged=gauged),
        *_tests(findings),
        *_temperature(findings, low=low),
        *_to_drive(findings, warm_up),
    ]
    return tuple(checks)


class _WhereLow:
    """Where main pressure was low, and where it was judged, as warm, and was not.

    ``leaks``: whether a leak may be behind a fall with the fluid's temperature; else it falls as commanded.
    """

    def __init__(self, permitted: RoadPressure, *, leaks: bool) -> None:
        judged = [place for place in permitted.places if place.worst is not None]
        self.low = [place for place in judged if place.below > 0.0]
        self.fine = [place for place in judged if not place.below]
        self.slumps = [place for place in self.low if place.slump is not None] if leaks else []
        if self.slumps:  # others were not seen as hot
            hot = max(place.held[-1].temperature for place in self.slumps) - SLUMP_SPAN
            self.fine = [place for place in self.fine if place.held and place.held[-1].temperature >= hot]
        self.gears = {place.gear for place in self.low}
        self.states, self.fine_states = ({place.state for place in places} for places in (self.low, self.fine))

    @property
    def only_hot(self) -> bool:
        """Tell whether it slumps wherever it was seen hot, and is low from cold nowhere."""
        if self.fine or not self.slumps:
            return False
        cold = min(place.held[0].temperature for place in self.slumps) + SLUMP_SPAN
        return all(place in self.slumps for place in self.low if place.held and place.held[0].temperature <= cold)

    @property
    def in_one_place(self) -> bool:
        return len({(place.gear, place.state) for place in self.low}) == 1

    @property
    def in_one_gear(self) -> bool:
        return len(self.gears) == 1 and not any(place.gear in self.gears for place in self.fine)

    def checks(self) -> Iterator[NextCheck]:
        """Read from where pressure is low, and from how warm the fluid is there, what may be behind it."""
        if self.slumps:
            yield from _falls_with_heat(min(self.slumps, key=_idle_and_lowest_first))
        if self.only_hot:
            return  # fluid level and filter come first only where it is low from cold
        code, source = next((code, source) for code, source, holds in _WHERE if holds(self))
        named = {"low_in_one_gear": "gear", "low_in_some": "gears"}.get(code)
        yield NextCheck(code, source, {named: ", ".join(map(gear_name, sorted(self.gears)))} if named else {})
        coldest = [place.held[0].temperature for place in self.low if place.held]
        if not self.fine and coldest and min(coldest) >= WARM:
            yield NextCheck("compare_cold", "practice", {"coldest": Quantity(min(coldest), "temperature")})
        if not self.slumps:
            yield NextCheck("then_measure", "project")


_WHERE: tuple[tuple[str, CheckSource, Callable[[_WhereLow], bool]], ...] = (  # the first that holds
    ("low_where_judged", "project", lambda it: not it.fine and it.in_one_place),
    ("low_everywhere", "project", lambda it: not it.fine),
    ("low_at_idle_only", "practice", lambda it: it.states == {"idle"} and it.fine_states != {"idle"}),
    ("low_in_one_gear", "practice", lambda it: it.in_one_gear),
    ("low_under_load", "project", lambda it: "idle" not in it.states and "idle" in it.fine_states),
    ("low_in_some", "project", lambda it: True),
)


def _idle_and_lowest_first(place: PlaceFinding) -> tuple[int, float]:
    return STATES.index(place.state), -place.worst.fraction if place.worst is not None else 0.0


def _falls_with_heat(place: PlaceFinding) -> Iterator[NextCheck]:
    if place.slump is not None and place.worst is not None:
        cold, hot = place.slump
        values: dict[str, str | Quantity] = {"gear": gear_name(place.gear), "state": place.state}
        for name, each in (("cold", cold), ("hot", hot)):
            values[name] = Quantity(each.pressure * KPA, "pressure")
            values[f"{name}_at"] = Quantity(each.temperature, "temperature")
        values["least"] = Quantity(place.worst.limit * KPA, "pressure")
        yield NextCheck("falls_with_heat", "practice", values)


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


def _to_drive(findings: RoadFindings, warm_up: WarmUp | None) -> Iterator[NextCheck]:
    """Say what to drive where the log could tell more of leakage; one that is cold throughout is to be warm first."""
    if warm_up is not None and warm_up.lacks_range and findings.temperatures and findings.temperatures[1] >= WARM:
        cold, hot = (Quantity(each, "temperature") for each in (_COLD, HOT))
        yield NextCheck("drive_warm", "project", {"cold": cold, "hot": hot})
