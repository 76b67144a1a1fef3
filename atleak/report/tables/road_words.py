"""Say in a reader's language what a road-test log says by itself, and what to check next."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

from atleak.catalogue.limits import RuleKind
from atleak.common.units import DM3_MIN, KPA, RPM, UM, gear_name
from atleak.common.wording import Wording, begun
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.missing import Amount
from atleak.diagnosis.next_checks import NextCheck, next_checks
from atleak.diagnosis.road import RoadFindings
from atleak.diagnosis.warm_up import WarmUp
from atleak.engine.road_pressure import Departure
from atleak.measurements.events import AccelerationTest, Event
from atleak.report.tables.table import Column, Section, SectionPart, Table, Text


def pressure_sentences(log: RoadFindings, say: Wording) -> Iterator[str]:
    """Say how main pressure stood beside what is permitted and what was commanded, and by whose limits."""
    yield permitted_sentence(log, say)
    permitted = log.permitted
    if permitted is not None and permitted.highest is not None and permitted.above > 0.0:
        yield say("findings.above", **_place(permitted.highest, say), seconds=say.number(permitted.above, 1))
    if permitted is not None and permitted.lowest is not None:
        yield say("findings.limits_from", source=say.name(permitted.lowest.source))
    yield from commanded_sentence(log, say)


def commanded_sentence(log: RoadFindings, say: Wording) -> Iterator[str]:
    """Say how far measured main pressure was from what was commanded; nothing where one of them is not logged."""
    compared, decided = log.commanded, log.decided(RuleKind.COMMANDED_PRESSURE)
    if compared is not None and decided is not None:
        yield say(
            "findings.commanded",
            kpa=say.value(compared.difference * KPA, "pressure", 0),
            at=say.number(compared.at, 1),
            actual=say.value(compared.actual * KPA, "pressure", 0),
            commanded=say.value(compared.commanded * KPA, "pressure", 0),
            verdict=say.signed(decided.rule.verdict),
        )


def deciding_sentence(log: RoadFindings, rule: object, say: Wording) -> str:
    """Return what a rule of the log says; without one what is known of main pressure."""
    decided = log.decided(RuleKind.COMMANDED_PRESSURE)
    if decided is not None and decided.rule == rule:
        return " ".join(commanded_sentence(log, say))
    return permitted_sentence(log, say)


def permitted_sentence(log: RoadFindings, say: Wording) -> str:
    """Say how far main pressure lay below what is permitted, how near it came, or why it was not judged."""
    permitted, decided = log.permitted, log.decided(RuleKind.PERMISSIBLE_PRESSURE)
    if permitted is None:
        refused = log.road_test.refused.get("main_pressure")
        if log.not_judged == "no_main_pressure" and refused is not None:
            return say("findings.no_usable_pressure", why=begun(say.sentence(refused)))
        return say(f"findings.{log.not_judged}")
    judged, lowest = say.number(permitted.judged, 1), permitted.lowest
    if lowest is None or decided is None:
        return say("findings.no_least", judged=judged)
    place = _place(lowest, say) | {"judged": judged, "verdict": say.signed(decided.rule.verdict)}
    if not permitted.below:
        return say("findings.nowhere_below", **place)
    return say(
        "findings.below",
        **place,
        seconds=say.number(permitted.below, 1),
        start=say.number(lowest.start, 1),
        stop=say.number(lowest.stop, 1),
        kpa=say.value(lowest.outside * KPA, "pressure", 0),
        percent=say.percent(lowest.fraction),
    )


def _place(departure: Departure, say: Wording) -> dict[str, str]:
    return {
        "gear": gear_name(departure.gear),
        "state": say(f"states.{departure.state}"),
        "at": say.number(departure.at, 1),
        "pressure": say.value(departure.pressure * KPA, "pressure", 0),
        "limit": say.value(departure.limit * KPA, "pressure", 0),
    }


def test_sentences(log: RoadFindings, say: Wording) -> Iterator[str]:
    """Say of every minimum-acceleration test how it was driven."""
    for event in log.events:
        if event.test is not None:
            start, stop = say.number(event.start, 1), say.number(event.stop, 1)
            yield say("findings.test", start=start, stop=stop, how=how_driven(event, event.test, say))


def how_driven(event: Event, test: AccelerationTest, say: Wording) -> str:
    """Say how a minimum-acceleration test was driven: when it went wrong, and by how much."""
    gears = "" if not test.gears else say("findings.test_gears", gears=", ".join(map(gear_name, test.gears)))
    missing = "" if not test.missing else say("findings.test_missing", gears=", ".join(map(gear_name, test.missing)))
    return say(
        f"findings.test_{test.fault or 'passed'}",
        highest=say.number(test.highest_speed * RPM, 0),
        at=say.number(test.highest_at, 1),
        over=say.number(test.over_by * RPM, 0),
        limit=say.number(test.speed_limit * RPM, 0),
        stop=say.number(event.stop, 1),
        gears=gears,
        missing=missing,
    )


def event_name(event: Event, say: Wording) -> str:
    """Return an event's name with its gears: ``shift 1 → 2``."""
    return say(f"events.{event.kind}") + (f" {event.gears}" if event.gears else "")


def event_span(event: Event, say: Wording) -> str:
    """Return an event's name, and from when to when it was: ``shift 1 → 2, 12.3 to 12.9 s``."""
    first, last = say.number(event.start, 1), say.number(event.stop, 1)
    return say("road_test.from_to", what=event_name(event, say), first=first, last=last)


def event_remark(event: Event, say: Wording) -> str:
    """Return what else is to be said of an event."""
    return say.sentence(event.note) if event.test is None else how_driven(event, event.test, say)


def log_sentences(log: RoadFindings, say: Wording) -> Iterator[str]:
    """Say which temperatures, gears, slip of the converter and events the log holds."""
    if log.temperatures is None:
        yield say("findings.no_temperature")
    else:
        low, high = (say.value(each, "temperature", 0) for each in log.temperatures)
        if low == high:
            yield say("findings.temperature", temperature=low)
        else:
            yield say("findings.temperatures", low=low, high=high)
    if not log.gears:
        yield say("findings.no_gears")
    else:
        each = (
            say("findings.in_gear", gear=gear_name(gear), seconds=say.number(time, 1))
            for gear, time in log.gears.items()
        )
        yield say("findings.time_in_gears", gears=", ".join(each))
    yield from _slip_sentences(log, say)
    counts = Counter(event.kind for event in log.events)
    if not counts:
        yield say("findings.no_events")
    else:
        named = ", ".join(f"{count} × {say(f'events.{kind}')}" for kind, count in counts.items())
        yield say("findings.counted", events=named)


def _slip_sentences(log: RoadFindings, say: Wording) -> Iterator[str]:
    """Say how far the converter slips; nothing where engine or turbine speed are not logged."""
    slip = log.slip
    if slip is None:
        return
    low, median, high = (say.number(each * RPM, 0) for each in (slip.low, slip.median, slip.high))
    yield say("findings.slip", low=low, median=median, high=high, locked=say.number(slip.locked_seconds, 1))
    if slip.commanded_seconds is not None and slip.commanded_median is not None:
        seconds, slips = say.number(slip.commanded_seconds, 1), say.number(slip.commanded_median * RPM, 0)
        yield say("findings.slip_commanded", seconds=seconds, slip=slips)


def warm_up_section(diagnosis: Diagnosis, say: Wording) -> Section | None:
    """Say what the log tells of leakage by main pressure, and what is taken for that; None where it does not."""
    told = diagnosis.warm_up
    if told is None:
        return None
    parts: list[SectionPart] = [Text(" ".join(_told_by_drive(diagnosis, told, say)))]
    if told.at is not None and told.found != "unlike":
        table, u = _warm_up_table(diagnosis, told, say), diagnosis.gauge_card.assumptions
        off = {
            "displacement": u.volumetric_efficiency,
            "slip": u.slip_coefficient,
            "viscosity": u.viscosity,
            "pressure": u.main_pressure,
        }
        taken = say(
            "warm_up.assumed",
            required=say(f"warm_up.required_{'command' if told.by_command else 'permissible'}"),
            temperature=say.quantity(u.gauged_temperature, "temperature_difference"),
            **{name: say.percent(each, 0) for name, each in off.items()},
        )
        parts += [*([table] if told.found != "held" else []), Text(taken, small=True)]
    return Section("warm_up", say("warm_up.title"), parts)


def _told_by_drive(diagnosis: Diagnosis, told: WarmUp, say: Wording) -> Iterator[str]:
    if told.at is None or told.found == "unlike":
        yield say(f"warm_up.{told.found}")
        return
    basis, point = say(f"warm_up.{'measured' if diagnosis.gauge_card.measured else 'new'}"), told.at.point
    at = say(
        "warm_up.at",
        temperature=say.value(point.temperature, "temperature", 0),
        speed=say.number(point.engine_speed * RPM, 0),
        gear=gear_name(point.gear),
        state=say(f"states.{point.state}"),
        pressure=say.value(point.main_pressure * KPA, "pressure", 0),
    )

    def flows(amount: Amount) -> dict[str, str]:
        shown = (say.value(None if each is None else each * DM3_MIN, "flow", 1) for each in amount)
        return dict(zip(("flow", "low", "high"), shown, strict=True))

    if told.found == "held" and told.total is not None:
        yield say("warm_up.held", at=at, basis=basis, flow=flows(told.total)["high"])
        if told.left is not None:
            condition = say.condition(diagnosis.projection.condition)
            yield say("warm_up.left", left=say.value(told.left * DM3_MIN, "flow", 1), condition=condition)
        return
    if told.found == "thin" and told.total is not None:
        yield say("warm_up.thin", at=at, basis=basis, **flows(told.total))
    if told.gaps is not None:
        yield say("warm_up.gaps", at=at, basis=basis, **flows(told.gaps))
        named = _equivalents(diagnosis, told, say)
        if named:
            parts = named[0] if len(named) == 1 else say("warm_up.alternatives", first=named[0], second=named[-1])
            yield say("warm_up.equivalent", parts=parts)
            yield say(f"warm_up.{f'apart_{told.told_apart}' if told.told_apart else 'not_apart'}")
    if told.holes is not None:
        yield say("warm_up.holes", at=at, basis=basis, **flows(told.holes))


def _equivalents(diagnosis: Diagnosis, told: WarmUp, say: Wording) -> list[str]:
    """Name the clearances that leak as much: of the regulator's lands, and of the pump, or how its slip has grown."""
    named = []
    for name, amount in (("bore", told.bore), ("side", told.side), ("slip", None if told.side else told.slip)):
        if amount is not None:
            ends = [0.0 if each is None else each for each in amount]
            shown = (say.number(x, 1) if name == "slip" else say.value(x * UM, "clearance", 0) for x in ends)
            values = dict(zip(("value", "low", "high"), shown, strict=True))
            named.append(say(f"warm_up.{name}", **values, lands=_regulator(diagnosis, told, say)))
    return named


def _regulator(diagnosis: Diagnosis, told: WarmUp, say: Wording) -> str:
    """Name the lands of the main regulator as one."""
    component = say.name(diagnosis.controller.components[told.lands[0].component]) if told.lands else ""
    return f"{component}/{', '.join(str(land.land) for land in told.lands)}"


def _warm_up_table(diagnosis: Diagnosis, told: WarmUp, say: Wording) -> Table:
    """Return a row for each law by which leaks go, and for each clearance that leaks as much; bounds alone if held."""

    def shown(kind: str, times: float) -> Callable[[float], str]:
        return lambda value: say.quantity(value * times, kind, 1 if kind == "flow" else 0)

    flow, clearance = shown("flow", DM3_MIN), shown("clearance", UM)
    rows: list[tuple[str, Amount | None, Callable[[float], str]]] = [
        ("gaps", told.gaps, flow),
        ("holes", told.holes, flow),
        ("total", None if told.gaps else told.total, flow),
        ("bore", told.bore, clearance),
        ("side", told.side, clearance),
        ("slip", told.slip, lambda value: say("warm_up.times", value=say.number(value, 1))),
    ]

    def end(number: int) -> Callable[[Any], str | None]:
        return lambda row: None if row[1][number] is None else row[2](row[1][number])

    def kind(row: Any) -> str:
        return _regulator(diagnosis, told, say) if row[0] == "bore" else say(f"warm_up.row_{row[0]}")

    columns = [Column("leaks_as", width=190, of=kind)]
    columns += [Column(f"leaks_{key}", of=end(number)) for number, key in enumerate(("more", "low", "high"))]
    return Table("warm_up", tuple(columns), [row for row in rows if row[1] is not None], say).filled


def checks_of(diagnosis: Diagnosis) -> tuple[NextCheck, ...]:
    """Return what to check next after the road test; nothing without one."""
    if diagnosis.log is None:
        return ()
    steps = diagnosis.limits.commanded_pressure
    limit = None if steps is None else min(limit for _, limit in steps.levels)
    return next_checks(diagnosis.log, limit, gauged=diagnosis.pressures is not None, warm_up=diagnosis.warm_up)


def check_sentences(diagnosis: Diagnosis, say: Wording) -> list[str]:
    """Return what to check next in words, each with where it comes from."""
    return [f"{check_text(check, say)} ({say(f'check_sources.{check.source}')})" for check in checks_of(diagnosis)]


def check_text(check: NextCheck, say: Wording) -> str:
    """Return a check in words."""
    named = {"state": say(f"states.{check.values['state']}")} if "state" in check.values else {}
    return say(f"checks.{check.code}", **{**check.values, **named})
