"""Write the words of a report: names of conditions and lands, numbers with their uncertainty, reasons."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import Any

from atleak.catalogue.operating_point import OperatingPoint
from atleak.diagnosis import Diagnosis
from atleak.engine.extremes import Instant
from atleak.job.estimate import estimate
from atleak.job.record import Job
from atleak.land_diagnosis import LandDiagnosis
from atleak.repair import RepairPlan, plan_repairs
from atleak.report.estimate_words import EstimateWords
from atleak.rules import Rule
from atleak.uncertainty import Decision, Remedy
from atleak.views.condition_matrix import LandAtCondition, MatrixRow
from atleak.views.land_names import component_words, land_number
from atleak.views.road_instants import instant_record
from atleak.views.sentences import rule_name, rule_value, wear_words
from atleak.wording import Wording, isolated
from atleak.workshop_units import DM3_MIN, PERCENT, UM

_MOSTLY = 0.5  # fraction of an uncertainty's variance


class PrintedNames:
    """The names and numbers of one diagnosis and its job, in one language."""

    def __init__(self, diagnosis: Diagnosis, record: dict[str, Any], job: Job, say: Wording) -> None:
        self.diagnosis, self.record, self.job, self.say = diagnosis, record, job, say
        self.rows = {(row["component"], row["land"]): row for row in record["lands"]}

    @cached_property
    def plan(self) -> RepairPlan:
        """Return the repairs that the diagnosis calls for."""
        return plan_repairs(self.diagnosis)

    @cached_property
    def estimate(self) -> EstimateWords | None:
        """Return the estimate; None where the job states no terms and no price, or there is nothing to list."""
        if self.diagnosis.without_sheet or not self.job.estimated:
            return None
        words = EstimateWords(estimate(self.diagnosis, self.job), self.say)
        return words if words.estimate.lines else None

    @property
    def mileage(self) -> float | None:
        """Return the mileage [km] that the diagnosis was made with, or else the one of the job."""
        computed = self.record["mileage_km"]
        return self.job.vehicle.mileage_km if computed is None else computed

    def condition(self, point: OperatingPoint) -> str:
        """Return the name of a condition in the reader's language."""
        return self.say.condition(point)

    def section(self, name: str) -> str:
        """Return the name of a section's pressure in the reader's language, or that of a circuit as its file has it."""
        circuits = {each.id: isolated(each.name) for each in self.diagnosis.controller.circuits}
        return self.say.name(circuits[name]) if name in circuits else self.say(f"pressures.{name}")

    def land_number(self, land: LandDiagnosis) -> str:
        """Return component and land in short: ``8/2``."""
        return land_number(self.diagnosis.controller, land.key, self.say)

    def land_name(self, land: LandDiagnosis) -> str:
        """Return the component, its name and the land."""
        return f"{self.pair(land)}, {self.column('land')}\u00a0{self.land(land)}"

    def pair(self, land: LandDiagnosis) -> str:
        """Return the component's number, where it has one, and its name."""
        return component_words(self.diagnosis.controller, land.key[0], self.say)

    def column(self, name: str) -> str:
        """Return the heading of a column."""
        return self.say(f"printed.{name}")

    def clearance(self, land: LandDiagnosis) -> str:
        """Return the radial clearance [µm] with half its interval where the uncertainty is known."""
        value = self.say.value(land.state.radial_clearance * UM, "clearance", 1)
        interval = land.uncertainty.clearance_interval if land.uncertainty else None
        if interval is None:
            return value
        return f"{value} ± {self.say.value((interval[1] - interval[0]) / 2.0 * UM, 'clearance', 1)}"

    def land(self, land: LandDiagnosis) -> str:
        """Return the land's number in its pair."""
        _, number = land.key
        return str(number)

    def verdict(self, land: LandDiagnosis) -> dict[str, str]:
        """Return the verdict's sign and word, as a cell of a table holds them."""
        return {"sign": land.verdict, "text": self.say.level(land.verdict)}

    def mounting(self, land: LandDiagnosis) -> str:
        """Return the mounting clearance [µm], a range where no more is known."""
        return "–".join(self.say.value(end * UM, "clearance", 1) for end in land.state.land.mounting_ends)

    def wear(self, land: LandDiagnosis) -> str:
        """Return the wear [%]."""
        return wear_words(land, self.say, unit=False)

    def share(self, land: LandDiagnosis) -> str:
        """Return the share of the pump's flow at the stated condition [%]."""
        return self.say.number(land.share * PERCENT, 2)

    def share_largest(self, land: LandDiagnosis) -> str:
        """Return the share where it is judged worst, of several where it is largest [%]."""
        worst = self._worst(land)
        return "–" if worst.drawn_from_pump == 0.0 else self.say.number(worst.share * PERCENT, 2)

    def _worst(self, land: LandDiagnosis) -> LandAtCondition:
        return MatrixRow.of(land, self.diagnosis, self.diagnosis.projections).worst

    def leakage_interval(self, land: LandDiagnosis) -> str:
        """Return the interval of the leakage [dm³/min]; a dash where it is not known, or the land does not leak."""
        row = self.rows[land.key]
        interval = self.interval(row["leakage_low_dm3_min"], row["leakage_high_dm3_min"], 3, "flow")
        return interval.strip("\n()") or "–" if land.leakage > 0.0 else "–"

    def interval(self, low: float | None, high: float | None, digits: int, kind: str = "percent") -> str:
        """Return an interval on a separate line; an empty text where it is not known."""
        if low is None or high is None:
            return ""
        return f"\n({self.say.value(low, kind, digits)}–{self.say.value(high, kind, digits)})"

    def flow(self, value: float, digits: int = 2) -> str:
        """Return a flow [m³/s] in dm³/min, without the unit."""
        return self.say.value(value * DM3_MIN, "flow", digits)

    def flow_with_unit(self, value: float | None) -> str:
        """Return a flow [m³/s] in dm³/min with the unit; a dash where it is not known."""
        return "–" if value is None else f"{self.flow(value)} {self.say.unit('flow')}"

    def instant_leakage(self, instant: Instant) -> str:
        """Return the leakage at an instant of the road test, with its interval where it is known."""
        record = instant_record(instant, self.diagnosis.uncertainty)
        interval = self.interval(record["leakage_low_dm3_min"], record["leakage_high_dm3_min"], 2, "flow")
        return self.flow_with_unit(instant.leakage) + interval

    def instant_share(self, instant: Instant) -> str:
        """Return the share at an instant of the road test, with its interval where it is known."""
        record = instant_record(instant, self.diagnosis.uncertainty)
        interval = self.interval(record["share_low_percent"], record["share_high_percent"], 1)
        return self.say.percent(instant.share) + interval

    def decision(self, land: LandDiagnosis) -> str:
        """Return how sure the verdict is."""
        return "–" if land.decision is None else self.decided(land.decision, land.probability_over_limit)

    def decided(self, decision: Decision, probability: float | None) -> str:
        """Return the words of a decision with the probability that the true value is past the limit."""
        words = self.say.get("decisions", decision)
        return words if probability is None else f"{words} ({self.say.percent(probability, 0)})"

    def advice(self, land: LandDiagnosis) -> str:
        """Return what would make an open decision clear; an empty text where it is clear already."""
        return " ".join(filter(None, self._advised(land)))

    def advice_by_group(self, lands: Iterable[LandDiagnosis]) -> list[str]:
        """Return the same for several lands, with those together of which the same is advised."""
        groups: dict[str, list[str]] = {}
        for land in lands:
            doubt, way = self._advised(land)
            if doubt:
                groups.setdefault(way, []).append(f"{self.land_name(land)}: {doubt}")
        return [" ".join([*doubts, way]) for way, doubts in groups.items()]

    def _advised(self, land: LandDiagnosis) -> tuple[str, str]:
        """Return what is open about a land, and what would settle it; empty texts where it is clear."""
        uncertainty = land.uncertainty
        decided = uncertainty.deciding if uncertainty else None
        remedy = uncertainty.remedy(decided) if uncertainty and decided else None
        rule = land.deciding
        if uncertainty is None or decided is None or remedy is None or rule is None:
            return "", ""
        say = self.say
        side = "over" if decided.decision == "conditional_fail" else "under"
        guard = self.rule_value(rule, uncertainty.guard_factor * decided.standard_uncertainty)
        limit = self.rule_value(rule, decided.limit)
        name = self.rule_name(rule)
        said = side if remedy.measurable else "not_measurable"
        doubt = say(f"advice.{said}", rule=name, value=self.rule_value(rule, decided.value), limit=limit, guard=guard)
        if remedy.measurable and remedy.reading_part < _MOSTLY:
            return doubt, say("advice.elsewhere", fraction=say.percent(remedy.reading_part, 0))
        if not remedy.decides:
            return doubt, say("advice.judgement")
        return doubt, " ".join(self._ways(remedy))

    def _ways(self, remedy: Remedy) -> Iterable[str]:
        """Return which measurements would decide it."""
        say = self.say
        if remedy.measurable and remedy.first is not None:
            part, fraction = say(f"advice.{remedy.first}"), say.percent(remedy.fraction, 0)
            yield say("advice.first", part=part, fraction=fraction)
        ways = []
        if remedy.repeats is not None:
            parts = say("advice.and").join(say(f"advice.{part}") for part in remedy.repeat_parts)
            ways.append(say("advice.repeats", count=remedy.repeats, parts=parts))
        if remedy.directions:
            parts = say("advice.and").join(say(f"advice.{part}") for part in remedy.directions)
            ways.append(say("advice.directions", parts=parts))
        for choice in remedy.instruments:
            tools = (say("advice.tool", instrument=say.name(tool), part=say(f"advice.{part}")) for part, tool in choice)
            ways.append(say("advice.and").join(tools))
        if ways:
            yield say("advice.settled", ways=say("advice.or").join(ways))
        else:
            yield say("advice.form", fraction=say.percent(remedy.form, 0))

    def reason(self, land: LandDiagnosis) -> str:
        """Return the rule that gave the verdict with its limit's origin, and every other rule that reached a limit.

        After them stands the condition at which the share is the largest.
        """
        deciding, worst = land.deciding, self._worst(land)
        said = []
        if deciding is not None:
            said.append(self._reached("rules.reached", deciding))
            others = [rule for rule in land.rules if rule.verdict.flagged and rule is not deciding]
            also = "; ".join(self._reached("rules.reached_short", rule) for rule in others)
            said += [self.say("rules.also", others=also)] if also else []
        if worst.drawn_from_pump > 0.0:
            said.append(self.say("rules.largest_at", condition=self.condition(worst.projection.condition)))
        return "; ".join(said)

    def reached(self, rule: Rule) -> str:
        """Return what a rule limits, its value and the limit that it reached."""
        return self._reached("rules.reached_short", rule)

    def _reached(self, key: str, rule: Rule) -> str:
        say = self.say
        return say(
            key,
            rule=self.rule_name(rule),
            value=self.rule_value(rule, rule.value),
            limit=self.rule_value(rule, rule.limit),
            origin=say.get("origins", rule.origin),
        )

    def rule_value(self, rule: Rule, value: float) -> str:
        """Return a value or a limit of a rule, with its unit."""
        return rule_value(value, rule.kind, self.say)

    def rule_name(self, rule: Rule) -> str:
        """Return what a rule is about, with its condition and its circuit."""
        return rule_name(rule, self.say, brief=True)
