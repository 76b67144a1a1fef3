"""Words for the things of a report: conditions, lands, numbers with their uncertainty, reasons."""

from __future__ import annotations

from typing import Any

from atleak.catalogue.controller import OperatingPoint
from atleak.diagnosis import Diagnosis, LandDiagnosis
from atleak.engine.projection import Projection
from atleak.job.record import Job
from atleak.rules import Rule
from atleak.wording import Wording, isolated
from atleak.workshop_units import DM3_MIN, PERCENT, RPM, UM

_MOSTLY = 0.5  # of an uncertainty's variance


class PrintedNames:
    """One diagnosis and its job, spoken of in one language."""

    def __init__(self, diagnosis: Diagnosis, record: dict[str, Any], job: Job, say: Wording) -> None:
        self.diagnosis, self.record, self.job, self.say = diagnosis, record, job, say
        self.rows = {(row["component"], row["land"]): row for row in record["lands"]}

    def condition(self, point: OperatingPoint) -> str:
        """A condition's name in the reader's language."""
        say = self.say
        if point.name in say.texts["conditions"] and point.name != "stated":
            name = say(f"conditions.{point.name}")
            return say("conditions.at", name=name, temperature=say.plain(point.temperature))
        if point.name == "stated":
            temperature, speed = say.plain(point.temperature), say.number(point.engine_speed * RPM, 0)
            return say("conditions.stated", gear=point.gear, temperature=temperature, speed=speed)
        return point.label.replace(" °C", "\u00a0°C")

    def land_number(self, found: LandDiagnosis) -> str:
        """``8/2``: component and land."""
        return f"{found.state.land.component}/{found.state.land.land}"

    def land_name(self, found: LandDiagnosis) -> str:
        """Component, its name and the land."""
        land = found.state.land
        return f"{self.pair(found)}, {self.column('land')}\u00a0{land.land}"

    def pair(self, found: LandDiagnosis) -> str:
        """Component and its name."""
        component = found.state.land.component
        return f"{component} {isolated(self.diagnosis.controller.components[component])}"

    def column(self, name: str) -> str:
        """The heading of a column."""
        return self.say(f"columns.{name}")

    @property
    def idle(self) -> Projection | None:
        """Hot idle where it is not the stated condition itself."""
        idle = self.diagnosis.hot_idle
        return None if idle is None or idle is self.diagnosis.projection else idle

    def clearance(self, found: LandDiagnosis) -> str:
        """Radial clearance [µm] with half its interval where the uncertainty is known."""
        value = self.say.number(found.state.radial_clearance * UM, 1)
        interval = found.uncertainty.clearance_interval if found.uncertainty else None
        if interval is None:
            return value
        return f"{value} ± {self.say.number((interval[1] - interval[0]) / 2.0 * UM, 1)}"

    def land(self, found: LandDiagnosis) -> str:
        """The land's number in its pair."""
        return str(found.state.land.land)

    def verdict(self, found: LandDiagnosis) -> dict[str, str]:
        """The verdict's sign and word, as a cell of a table holds them."""
        return {"sign": found.verdict, "text": self.say.level(found.verdict)}

    def mounting(self, found: LandDiagnosis) -> str:
        """Mounting clearance [µm]."""
        return self.say.number(found.state.land.mounting_clearance * UM, 1)

    def wear(self, found: LandDiagnosis) -> str:
        """Wear [%]."""
        return self.say.number(None if found.wear is None else found.wear * PERCENT, 0)

    def share(self, found: LandDiagnosis) -> str:
        """Share of the pump's flow at the stated condition [%]."""
        return self.say.number(found.share * PERCENT, 2)

    def share_hot_idle(self, found: LandDiagnosis) -> str:
        """Share of the pump's flow at hot idle [%]; a dash where that is no condition of its own."""
        idle = self.idle
        share = None if idle is None else idle.share_of(idle.leakage_of(found.key)) * PERCENT
        return self.say.number(share, 2)

    def leakage(self, found: LandDiagnosis) -> str:
        """Leakage [dm³/min] with its interval where the uncertainty is known and the land leaks at all."""
        row = self.rows[found.key]
        interval = self.interval(row["leakage_low_dm3_min"], row["leakage_high_dm3_min"], 3)
        return self.flow(found.leakage, 3) + interval * (found.leakage > 0.0)

    def interval(self, low: float | None, high: float | None, digits: int) -> str:
        """An interval on a line of its own; nothing where it is not known."""
        if low is None or high is None:
            return ""
        return f"\n({self.say.number(low, digits)}–{self.say.number(high, digits)})"

    def flow(self, value: float, digits: int = 2) -> str:
        """A flow [m³/s] in dm³/min, without the unit."""
        return self.say.number(value * DM3_MIN, digits)

    def flow_with_unit(self, value: float | None) -> str:
        """A flow [m³/s] in dm³/min with the unit; a dash where it is not known."""
        return "–" if value is None else f"{self.flow(value)} dm³/min"

    def decision(self, found: LandDiagnosis) -> str:
        """How sure the verdict is."""
        if found.decision is None:
            return "–"
        said = self.say.get("decisions", found.decision)
        probability = found.probability_over_limit
        return said if probability is None else f"{said}\n({self.say.percent(probability, 0)})"

    def advice(self, found: LandDiagnosis) -> str:
        """What would settle a decision that the measurement leaves open; nothing where it is settled."""
        sure = found.uncertainty
        rule = sure.deciding if sure else None
        remedy = sure.remedy(rule) if sure and rule else None
        judged = found.deciding
        if sure is None or rule is None or remedy is None or judged is None:
            return ""
        say = self.say
        side = "over" if rule.decision == "conditional_fail" else "under"
        guard = self._value(judged, sure.guard_factor * rule.standard_uncertainty)
        limit = self._value(judged, rule.limit)
        name = self._rule(judged)
        said = say(f"advice.{side}", rule=name, value=self._value(judged, rule.value), limit=limit, guard=guard)
        if remedy.reading_part < _MOSTLY:
            return f"{said} {say('advice.elsewhere', fraction=say.percent(remedy.reading_part, 0))}"
        if remedy.first is not None:
            part, fraction = say(f"advice.{remedy.first}"), say.percent(remedy.fraction, 0)
            said += f" {say('advice.first', part=part, fraction=fraction)}"
        ways = []
        if remedy.repeats is not None:
            parts = say("advice.and").join(say(f"advice.{part}") for part in remedy.repeat_parts)
            ways.append(say("advice.repeats", count=remedy.repeats, parts=parts))
        for choice in remedy.instruments:
            tools = (say("advice.tool", instrument=tool, part=say(f"advice.{part}")) for part, tool in choice)
            ways.append(say("advice.and").join(tools))
        if ways:
            return f"{said} {say('advice.settled', ways=say('advice.or').join(ways))}"
        return f"{said} {say('advice.judgement')}"

    def reason(self, found: LandDiagnosis) -> str:
        """The rule that gave the verdict with its limit's origin, then every other rule that reached a limit."""
        deciding = found.deciding
        if deciding is None:
            return ""
        others = [rule for rule in found.rules if rule.verdict.flagged and rule is not deciding]
        also = "; ".join(self._reached("rules.reached_short", rule) for rule in others)
        said = self._reached("rules.reached", deciding)
        return f"{said}\n{self.say('rules.also', others=also)}" if also else said

    def _reached(self, key: str, rule: Rule) -> str:
        say = self.say
        return say(
            key,
            rule=self._rule(rule),
            value=self._value(rule, rule.value),
            limit=self._value(rule, rule.limit),
            origin=say.get("origins", rule.origin),
        )

    def _value(self, rule: Rule, value: float) -> str:
        return f"{self.say.number(value * rule.kind.factor, 1)}\u00a0{rule.kind.unit}"

    def _rule(self, rule: Rule) -> str:
        if rule.condition is None:
            return self.say(f"rules.{rule.kind}")
        return self.say("rules.share_at", condition=self.condition(rule.condition))
