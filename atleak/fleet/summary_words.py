"""Say what a fleet's summary shows, in a reader's words: names of the trade, and every rate with what it is of."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from atleak.analysis.rates import Rate, Spread
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.entries import catalogue_files
from atleak.catalogue.repairs import LandKey
from atleak.common.errors import CatalogueError, Message
from atleak.common.units import RPM
from atleak.common.verdicts import FLAGGED, VERDICTS, Verdict
from atleak.common.wording import Wording
from atleak.fleet.sums import (
    GROUP,
    ConditionSpread,
    Decider,
    Difference,
    FleetSummary,
    PairTrouble,
    RateDifference,
    SummedUnit,
    ValveBody,
    WearDifference,
)
from atleak.report.tables.names import land_number, land_words

NAME = 36  # letters of a group's name, where it is one of several in a line

TERMS = (  # that are explained
    "unit", "verdict", "rate", "few", "pair", "wear", "mileage", "temperature", "condition", "compared", "error",
)  # fmt: skip


@dataclass(frozen=True)
class _Point:
    """A condition of the results, as `Wording.condition` takes it."""

    name: str
    label: str
    temperature: float
    engine_speed: float  # [1/s]
    gear: int
    is_stated: bool = False


class FleetWords:
    """The words of one summary, for one reader.

    Valve bodies, lands and circuits are named as the catalogue of this computer names them. A valve body that it does
    not have is named as the results name it, and its lands and circuits by their numbers and ids.
    """

    def __init__(self, summary: FleetSummary, say: Wording) -> None:
        self.summary, self.say = summary, say
        self._known = {body.controller: _described(body.controller) for body in summary.bodies}

    def body(self, controller: str) -> str:
        """Name a valve body."""
        known = self._known.get(controller)
        if known is None:
            return self.summary.body(controller).name or controller
        return self.say.name(known.name)

    def land_number(self, controller: str, key: LandKey) -> str:
        """Name a land in short: ``25/1``."""
        known = self._known.get(controller)
        return "/".join(map(str, key)) if known is None else land_number(known, key, self.say)

    def land(self, controller: str, key: LandKey) -> str:
        """Name a land, its number first: ``25/1 main pressure valve``."""
        known = self._known.get(controller)
        return "/".join(map(str, key)) if known is None else land_words(known, key, self.say)

    def condition(self, at: ConditionSpread) -> str:
        """Name a stated condition."""
        return self.say.condition(_Point(at.name, at.label, at.temperature_c, at.engine_rpm / RPM, at.gear))

    def decider(self, controller: str, decider: Decider) -> str:
        """Name what decided verdicts: a land, a circuit, or the kind of rule."""
        if decider.component is not None and decider.land is not None:
            return self.land(controller, (decider.component, decider.land))
        kind, circuit = self.say.get("fleet_deciding", decider.kind), decider.circuit
        if circuit is None:
            return kind
        known = self._known.get(controller)
        names = {each.id: each.name for each in known.circuits} if known else {}
        return f"{kind}: {self.say.name(names.get(circuit, circuit))}"

    def decided_by(self, unit: SummedUnit) -> str:
        """Name what decided a unit's verdict; nothing where nothing did."""
        if unit.decided_by is None:
            return ""
        if isinstance(unit.decided_by, str):
            return self.say.get("fleet_deciding", unit.decided_by)
        return self.land(unit.controller, unit.decided_by)

    def heading(self) -> str:
        """Return the heading by which the summary tells groups; nothing where it tells none."""
        by = self.summary.by
        return "" if by is None else self.say("fleet_summary.group") if by == GROUP else by

    def second(self, name: str | None) -> str:
        """Name the second side of a difference."""
        return self.say("fleet_summary.all_others") if name is None else name

    def differs(self, found: bool | None) -> str:
        """Say whether something differs; that there are too few units, where nothing can be said."""
        return self.say("fleet_summary.too_few" if found is None else "estimate.yes" if found else "estimate.no")

    def interval(self, low: float | None, high: float | None) -> str:
        """Write an interval; nothing where there is none."""
        if low is None or high is None:
            return ""
        to = "\u00a0…\u00a0" if min(low, high) < 0.0 else "–"
        return f"{self.say.number(low, 1)}{to}{self.say.number(high, 1)}"

    def percent(self, rate: Rate) -> str:
        """Write a rate [%] with its interval, ``38.0 (31.5–44.9)``; the count alone of too few units, ``3 of 6``."""
        within = self.interval(rate.low_percent, rate.high_percent)
        return f"{self.say.number(rate.percent, 1)}\u00a0({within})" if within else self.counted(rate.count, rate.of)

    def counted(self, count: int, of: int) -> str:
        """Write how many of how many: ``76 of 200``."""
        return self.say("fleet_summary.chart_rate", count=self.say.number(count, 0), of=self.say.number(of, 0))

    def spread(self, spread: Spread | None, kind: str, digits: int | None = None) -> str | None:
        """Write the median, and in brackets where nine of ten units are; of too few units the least and the most."""
        if spread is None:
            return None
        median, *ends = (self.say.value(value, kind, digits) for value in (spread.median, *spread.most_of_all))
        return median if spread.units == 1 else f"{median}\u00a0({'–'.join(ends)})"

    def difference(self, found: Difference | None) -> str | None:
        """Write a difference with the interval that decides; that there are too few units, where there is none."""
        if found is None:
            return None
        within = self.interval(found.low_of_all, found.high_of_all) or self.say("fleet_summary.too_few")
        return f"{self.points(found.value)}\u00a0({within})"

    def lands_measured(self, unit: SummedUnit) -> str | None:
        """Write how many of a unit's lands were measured."""
        if unit.lands_measured is None or unit.lands_total is None:
            return None
        return self.counted(unit.lands_measured, unit.lands_total)

    def rate(self, rate: Rate) -> str:
        """Say a rate in a sentence: ``76 of 200: 38.0 %, 95 % interval 31.5–44.9``; of too few units, the count."""
        counted = self.counted(rate.count, rate.of)
        if not rate.enough:
            return counted
        return self.say(
            "fleet_summary.rate",
            counted=counted,
            percent=self.say.number(rate.percent, 1),
            interval=self.interval(rate.low_percent, rate.high_percent),
        )

    # --- sentences

    def headline(self) -> str:
        """Say how many units call for a repair."""
        counts = self.summary.counts
        if not counts.units:
            return self.say("fleet_summary.headline_none")
        if not counts.judged:
            return self.say("fleet_summary.headline_unmeasured", count=counts.units)
        return self.say("fleet_summary.headline", rate=self.rate(counts.rates[Verdict.REPLACE]))

    def findings(self) -> Iterator[str]:
        """Say what else leads: how many more are to be watched, what was not measured, the pair and the group ahead."""
        say, summary = self.say, self.summary
        counts = summary.counts
        if counts.judged:
            for verdict in reversed(FLAGGED):
                if verdict is not Verdict.REPLACE:
                    key = "of_them" if verdict.calls_for_repair else "besides"
                    count = say.number(counts.verdicts[verdict], 0)
                    yield say(f"fleet_summary.{key}", level=say.level(verdict), count=count)
        others = {
            "unmeasured": counts.verdicts[Verdict.NOT_MEASURED],
            "without_sheet": counts.without_sheet,
            "ok_in_part": counts.ok_in_part,
            "provisional": counts.provisional,
            "failed": sum(each.count for each in summary.errors),
        }
        yield from (say(f"fleet_summary.{key}", count=say.number(count, 0)) for key, count in others.items() if count)

    def leading_pair(self, body: ValveBody) -> str:
        """Say which pair is most often past *replace*, and in how many units."""
        first = next((pair for pair in body.pairs if pair.replace.count), None)
        if first is None:
            return self.say("fleet_summary.no_pair")
        land = self.land(body.controller, first.key)
        return self.say("fleet_summary.leading_pair", pair=land, rate=self.rate(first.replace))

    def difference_of_rates(self, found: RateDifference) -> str:
        """Say by how much the rates of two groups differ."""
        level = self.or_worse(found.verdict)
        return self._difference("fleet_summary.difference_of_rates", found, found.points, level=level)

    def difference_of_wear(self, body: ValveBody, found: WearDifference) -> str:
        """Say by how much the wear of a land differs: at the same mileage where that tells it, else in the mean."""
        same = found.same_mileage_points
        how, points = ("same", same) if same is not None and same.differs else ("mean", found.mean_points)
        pair = self.land(body.controller, found.key)
        return self._difference(f"fleet_summary.wear_{how}", found, points, pair=pair)

    def _difference(
        self, text: str, found: RateDifference | WearDifference, points: Difference | None, **more: str
    ) -> str:
        assert points is not None
        return self.say(
            text,
            first=within_words(found.first, NAME),
            second=within_words(self.second(found.second), NAME),
            points=self.points(points.value),
            interval=self.interval(points.low_of_all, points.high_of_all),
            **more,
        )

    def sides(self, found: WearDifference) -> str:
        """Name both sides of a difference."""
        first, second = (within_words(name, NAME) for name in (found.first, self.second(found.second)))
        return self.say("fleet_summary.sides", first=first, second=second)

    def means(self, found: WearDifference) -> str:
        """Write the mean wear of both sides of a difference [%]."""
        means = (found.first_percent, found.second_percent)
        return " / ".join(self.say.number(mean.mean if mean else None, 1) for mean in means)

    def or_worse(self, level: Verdict, *, signed: bool = False) -> str:
        """Name a verdict and those that are worse, with its sign where that is asked for."""
        word = self.say.signed(level) if signed else self.say.level(level)
        return word if level is VERDICTS[-1] else self.say("fleet_summary.or_worse", level=word)

    def points(self, value: float | None) -> str:
        """Write a difference with its sign."""
        return ("+" if value is not None and round(value, 1) > 0.0 else "") + self.say.number(value, 1)

    def messages(self, messages: tuple[Message, ...]) -> list[str]:
        """Say what to know besides the numbers."""
        return [self.say.sentence(message.text) for message in messages]


def within_words(text: str, most: int) -> str:
    """Return a text of at most so many letters; an ellipsis stands for its middle, since names differ at their ends.

    >>> within_words("a/folder/unit_17.zip", 12)
    'a/fol…17.zip'
    """
    if len(text) <= most:
        return text
    kept = most - 1
    return f"{text[: kept // 2].rstrip()}…{text[len(text) - (kept - kept // 2) :].lstrip()}"


def cumulated(pairs: tuple[PairTrouble, ...]) -> list[float | None]:
    """Return which part of all findings at *replace* or past it each pair and those before it have [%].

    >>> cumulated(())
    []
    """
    whole, until, parts = sum(pair.replace.count for pair in pairs), 0, []
    for pair in pairs:
        until += pair.replace.count
        parts.append(100.0 * until / whole if whole else None)
    return parts


def called(found: WearDifference) -> bool | None:
    """Return whether the wear of two groups differs, at the same mileage or at any; None of too few units."""
    differ = [each.differs for each in (found.mean_points, found.same_mileage_points) if each is not None]
    return True if True in differ else False if False in differ else None


def _described(controller: str) -> Controller | None:
    """Return the description of a valve body; None of one that the catalogue does not have, or not in order."""
    if controller not in catalogue_files("controllers"):
        return None
    try:
        return load_controller(controller)
    except CatalogueError:
        return None
