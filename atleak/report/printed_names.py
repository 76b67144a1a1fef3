"""Write the words of a report: names of conditions and lands, numbers with their uncertainty, reasons."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property

from atleak.analysis.answer import Answer, answer_of
from atleak.analysis.estimate import estimate
from atleak.analysis.repair.plan import RepairPlan
from atleak.common.wording import Wording, isolated, joined
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.rules import Rule
from atleak.diagnosis.uncertainty import Remedy
from atleak.measurements.job_card import Job
from atleak.report.tables.estimate import EstimateWords
from atleak.report.tables.lands import MatrixRow, pair_table
from atleak.report.tables.names import component_words, has_number, land_number
from atleak.report.tables.sentences import rule_name, rule_value
from atleak.report.tables.table import Table

_SINGLY = 3  # lands of which the same is advised, each in a sentence of its own
_MOSTLY = 0.5  # fraction of an uncertainty's variance


class PrintedNames:
    """The names and numbers of one diagnosis and its job, in one language."""

    def __init__(self, diagnosis: Diagnosis, job: Job, say: Wording) -> None:
        self.diagnosis, self.job, self.say = diagnosis, job, say

    @cached_property
    def answer(self) -> Answer:
        """Return what is wrong, and how sure that is."""
        return answer_of(self.diagnosis)

    @property
    def plan(self) -> RepairPlan:
        """Return the repairs that the diagnosis calls for."""
        return self.answer.plan

    @cached_property
    def estimate(self) -> EstimateWords | None:
        """Return the estimate; None where the job states no terms and no price, or there is nothing to list."""
        if self.diagnosis.without_sheet or not self.job.estimated:
            return None
        words = EstimateWords(estimate(self.diagnosis, self.job), self.say)
        return words if words.estimate.lines else None

    @property
    def mileage(self) -> str:
        """Return the mileage that the diagnosis was made with, or else that of the job; an empty text without one."""
        mileage = self.job.vehicle.mileage_km if self.diagnosis.mileage is None else self.diagnosis.mileage
        return "" if mileage is None else self.say("texts.mileage", value=self.say.value(mileage, "distance", 0))

    @property
    def vehicle(self) -> str:
        """Return make, model and year of the vehicle."""
        vehicle = self.job.vehicle
        return joined((vehicle.make, vehicle.model, vehicle.year), " ")

    def section(self, name: str) -> str:
        """Return the name of a section's pressure in the reader's language, or that of a circuit as its file has it."""
        circuits = {each.id: isolated(each.name) for each in self.diagnosis.controller.circuits}
        return self.say.name(circuits[name]) if name in circuits else self.say(f"pressures.{name}")

    @cached_property
    def numbered(self) -> bool:
        """Tell whether every component has a number, so that lands are named in a few signs."""
        return all(has_number(self.diagnosis.controller, land.key[0]) for land in self.diagnosis.lands)

    def land_number(self, land: LandDiagnosis) -> str:
        """Return component and land in short: ``8/2``."""
        return land_number(self.diagnosis.controller, land.key, self.say)

    def land_name(self, land: LandDiagnosis) -> str:
        """Return the component, its name and the land."""
        return f"{self.pair(land)}, {self.say('printed.land')}\u00a0{land.key[1]}"

    def pair(self, land: LandDiagnosis) -> str:
        """Return the component's number, where it has one, and its name."""
        return component_words(self.diagnosis.controller, land.key[0], self.say)

    @cached_property
    def lands(self) -> Table:
        """Return the table of all lands, without shares at single conditions, which stand in one of their own."""
        return pair_table(self.diagnosis, self.diagnosis.lands, self.say, at=())

    # --- what would decide an open verdict

    def advice(self, land: LandDiagnosis) -> str:
        """Return what would make an open decision clear; an empty text where it is clear already."""
        return " ".join(filter(None, self._advised(land)))

    def advice_by_group(self, lands: Iterable[LandDiagnosis]) -> list[str]:
        """Return the same for several lands, with those together of which the same is advised; of many in short."""
        groups: dict[str, list[LandDiagnosis]] = {}
        for land in lands:
            if self.advice(land):
                groups.setdefault(self._advised(land)[1], []).append(land)
        return [" ".join([*self._doubts(doubted), way]) for way, doubted in groups.items()]

    def _doubts(self, lands: Sequence[LandDiagnosis]) -> Iterable[str]:
        """Return what is open about lands of which the same is advised; about many in one sentence."""
        near = all(each and each.measurable and not each.by_range for each in map(_remedy, lands))
        if len(lands) <= _SINGLY or not near:
            return [f"{self.land_name(land)}: {self._advised(land)[0]}" for land in lands]
        alike: dict[str, list[str]] = {}
        for land in lands:
            if land.deciding is not None:
                alike.setdefault(self._reached(land.deciding), []).append(self.land_number(land))
        named = (f"{', '.join(numbers)}: {reached}" for reached, numbers in alike.items())
        return [self.say("advice.near", lands="; ".join(named))]

    def _advised(self, land: LandDiagnosis) -> tuple[str, str]:
        """Return what is open about a land, and what would settle it; empty texts where it is clear."""
        uncertainty, rule = land.uncertainty, land.deciding
        decided = uncertainty.deciding if uncertainty else None
        remedy = _remedy(land)
        if uncertainty is None or decided is None or remedy is None or rule is None:
            return "", ""
        say = self.say
        side = "over" if decided.decision == "conditional_fail" else "under"
        spread = uncertainty.guard_factor * decided.standard_uncertainty
        values = {"value": decided.value, "limit": decided.limit, "guard": spread}
        if remedy.by_range and remedy.measurable:
            key = "within_range" if land.shown_as == "within_range" else f"range_{side}"
            chance = say.percent(decided.probability_over_limit, 0)
            shown = {name: self.rule_value(rule, values[name]) for name in ("value", "limit")}
            doubt = say(f"advice.{key}", rule=self.rule_name(rule), chance=chance, **shown)
            return doubt, say("advice.unworn_end" if remedy.unworn_end else "advice.not_again")
        doubt = say(
            f"advice.{side if remedy.measurable else 'not_measurable'}",
            rule=self.rule_name(rule),
            **{name: self.rule_value(rule, value) for name, value in values.items()},
        )
        if remedy.measurable and remedy.reading_part < _MOSTLY:
            return doubt, say("advice.elsewhere", fraction=say.percent(remedy.reading_part, 0))
        if remedy.first is None and land.state.leak is not None:
            return doubt, say("advice.diameters")
        return doubt, " ".join(self._ways(remedy)) if remedy.decides else say("advice.judgement")

    def _ways(self, remedy: Remedy) -> Iterable[str]:
        """Return which measurements would decide it."""
        say, ways = self.say, []

        def parts(named: Iterable[str]) -> str:
            return say("advice.and").join(say(f"advice.{part}") for part in named)

        if remedy.measurable and remedy.first is not None:
            yield say("advice.first", part=parts([remedy.first]), fraction=say.percent(remedy.fraction, 0))
        if remedy.repeats is not None:
            ways.append(say("advice.repeats", count=remedy.repeats, parts=parts(remedy.repeat_parts)))
        if remedy.directions:
            ways.append(say("advice.directions", parts=parts(remedy.directions)))
        for choice in remedy.instruments:
            tools = (say("advice.tool", instrument=say.name(tool), part=parts([part])) for part, tool in choice)
            ways.append(say("advice.and").join(tools))
        if ways:
            yield say("advice.settled", ways=say("advice.or").join(ways))
        else:
            yield say("advice.form", fraction=say.percent(remedy.form, 0))

    # --- rules

    def reason(self, land: LandDiagnosis) -> str:
        """Return the rule that gave the verdict with its limit, and every other rule that reached one.

        After them stands the condition at which the share is the largest.
        """
        deciding, worst = land.deciding, MatrixRow.of(land, self.diagnosis, self.diagnosis.projections).worst
        said = []
        if deciding is not None:
            others = [rule for rule in land.rules if rule.verdict.flagged and rule is not deciding]
            also = "; ".join(map(self._reached, others))
            said = [self._reached(deciding), *([self.say("rules.also", others=also)] if also else [])]
        named = [rule.condition for rule in land.rules if rule.verdict.flagged]
        if worst.drawn_from_pump > 0.0 and worst.projection.condition not in named:
            said.append(self.say("rules.largest_at", condition=self.say.condition(worst.projection.condition)))
        return "; ".join(said)

    def _reached(self, rule: Rule) -> str:
        value, limit = (self.rule_value(rule, each) for each in (rule.value, rule.limit))
        return self.say("rules.reached_short", rule=self.rule_name(rule), value=value, limit=limit)

    def rule_value(self, rule: Rule, value: float) -> str:
        """Return a value or a limit of a rule, with its unit."""
        return rule_value(value, rule.kind, self.say)

    def rule_name(self, rule: Rule) -> str:
        """Return what a rule is about, with its condition and its circuit."""
        return rule_name(rule, self.say, brief=True)


def _remedy(land: LandDiagnosis) -> Remedy | None:
    """Return what would decide an open verdict of a land; None where it is clear."""
    its = land.uncertainty
    return its.remedy(its.deciding) if its and its.deciding else None


class PrintedPart:
    """A part of a report, with the words of its diagnosis and its job at hand."""

    def __init__(self, names: PrintedNames) -> None:
        self.names, self.diagnosis, self.job, self.say = names, names.diagnosis, names.job, names.say
