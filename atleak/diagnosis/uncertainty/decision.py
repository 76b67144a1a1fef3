"""Decide from a value, its uncertainty and a limit, and say in plain words what to do where that is left open."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, reduce
from itertools import product
from typing import Literal

from atleak.catalogue.instruments import Instrument, Part, instruments
from atleak.catalogue.limits import Level, RuleKind, reaches
from atleak.common.sentences import Name, Sentence, all_of
from atleak.diagnosis.rules import Rule
from atleak.diagnosis.uncertainty.sources import PARTS, LandSources
from atleak.equations.statistics import guard_band, normal_cdf, probability_over

Decision = Literal["pass", "conditional_pass", "conditional_fail", "fail"]
DECISIONS: tuple[Decision, ...] = ("pass", "conditional_pass", "conditional_fail", "fail")  # the worst last
GUARD_FACTOR = 1.645  # one-sided 95 %


def certainty(decision: Decision | None) -> int:
    """Rank a decision: the surer a limit is passed, the higher."""
    return -1 if decision is None else DECISIONS.index(decision)


@dataclass(frozen=True)
class LevelDecision:
    """One of a rule's limits, and the decision of the value against it."""

    level: Level  # that begins at the limit
    limit: float  # SI or a fraction
    decision: Decision  # of the value against it
    probability_over: float  # that the true value is past it


@dataclass(frozen=True)
class RuleDecision:
    """The decision on a rule: its value against the limit it reached, or its lowest limit where it reached none.

    ``limit`` and ``standard_uncertainty`` are in SI or fractions, as the rule's value is.
    """

    rule: Rule  # what was judged
    limit: float  # SI or a fraction
    standard_uncertainty: float  # of the value, likewise
    decision: Decision  # how sure the verdict is
    probability_over_limit: float  # that the true value is past the limit
    levels: tuple[LevelDecision, ...]  # every limit of the rule, with the decision against it
    level_uncertainties: tuple[float, ...]  # of the value at each of the levels
    interval: tuple[float, float] | None = None  # of the value, from draws; None where it is normally distributed

    @property
    def skewed(self) -> bool:
        """Tell whether the value's distribution lies to one side, so that a standard uncertainty does not describe it.

        It does where one end of the interval is more than twice as far from the value as the other: project's choice.
        """
        if self.interval is None or not all(map(math.isfinite, (*self.interval, self.rule.value))):
            return False
        near, far = sorted((self.rule.value - self.interval[0], self.interval[1] - self.rule.value))
        return far > 2.0 * near and far > 0.0

    @property
    def value(self) -> float:
        """Return the rule's value."""
        return self.rule.value

    @property
    def conditional(self) -> bool:
        """Return whether the measurement leaves the decision open."""
        return self.decision in {"conditional_pass", "conditional_fail"}

    @property
    def about(self) -> Level:
        """Name the level whose limit the decision is about; of levels that begin together the worst."""
        return self.levels[self._number].level

    @property
    def _number(self) -> int:
        return _number_of(self.limit, self.levels)

    @property
    def at_next_level(self) -> RuleDecision | None:
        """Return the decision on the same value against the limit above; None where there is none."""
        beyond = (number for number, level in enumerate(self.levels) if self._beyond(level.limit))
        number = next((number for number in beyond if number > self._number), None)
        return None if number is None else self._at(number)

    def _beyond(self, limit: float) -> bool:
        """Return whether a limit is reached after this one's."""
        return limit < self.limit if self.rule.steps.falling else limit > self.limit

    @property
    def at_first_level(self) -> RuleDecision:
        """Return the decision on the same value against the limit that is reached first."""
        first = max if self.rule.steps.falling else min
        return self._at(_number_of(first(level.limit for level in self.levels), self.levels))

    def _at(self, number: int) -> RuleDecision:
        level = self.levels[number]
        return replace(
            self,
            limit=level.limit,
            standard_uncertainty=self.level_uncertainties[number],
            decision=level.decision,
            probability_over_limit=level.probability_over,
        )

    @property
    def severity(self) -> tuple[int, float]:
        """Return what ranks rules: the verdict, then how likely the limit is passed."""
        return self.rule.verdict.rank, self.probability_over_limit


def decide(
    value: float,
    limit: float,
    standard_uncertainty: float,
    guard_factor: float = GUARD_FACTOR,
    probability_over: float | None = None,
    *,
    by_value: bool = False,
) -> Decision:
    """Decide how a value stands to an upper limit, given the uncertainty of its measurement.

    Parameters
    ----------
    value, limit, standard_uncertainty
        y, T and u, in one unit.
    guard_factor
        k of the guard band k u.
    probability_over
        that the true value has reached the limit, where its distribution is not normal: it alone says how sure the
        decision is (JCGM 106), because a guard band of k u leaves another risk above a skewed value than below it.
    by_value
        whether the value says all the same on which side of the limit the verdict is, however likely the other one is.

    Returns
    -------
    {"pass", "conditional_pass", "conditional_fail", "fail"}
        y ≤ T − k u; < T; ≤ T + k u; above. A value at its limit has reached it, as for the verdict. With a
        probability: at most the risk of the guard band; under a half; under one less that risk; the rest.

    Raises
    ------
    DomainError
        Negative uncertainty or factor.

    References
    ----------
    ILAC-G8:09/2019, 4.2.3 (non-binary statement with guard band); JCGM 106:2012.

    Examples
    --------
    >>> [decide(y, 30.0, 1.0) for y in (28.0, 29.0, 31.0, 32.0)]
    ['pass', 'conditional_pass', 'conditional_fail', 'fail']
    """
    over = reaches(value, limit)
    if probability_over is not None:
        risk = _risk_of(guard_factor)
        over = over if by_value else probability_over >= 0.5
        sure = probability_over >= 1.0 - risk if over else probability_over <= risk
    elif math.isfinite(standard_uncertainty):
        guard = guard_band(standard_uncertainty, guard_factor)
        sure = value > limit + guard if over else value <= limit - guard
    else:
        sure = False
    if over:
        return "fail" if sure else "conditional_fail"
    return "pass" if sure else "conditional_pass"


@lru_cache(maxsize=8)
def _risk_of(guard_factor: float) -> float:
    """Return the part of a normal distribution beyond k standard deviations."""
    return float(normal_cdf(-guard_factor))


def _number_of(limit: float, levels: Sequence[LevelDecision]) -> int:
    """Return the place of the worst level that begins at a limit."""
    return max(number for number, level in enumerate(levels) if level.limit == limit)


def decide_normal(rule: Rule, uncertainty: float | tuple[float, ...], guard_factor: float) -> RuleDecision:
    """Decide a rule whose value is normal, with one standard uncertainty or another at each of its levels."""
    limits = [limit for _, limit in rule.steps.levels]
    us = uncertainty if isinstance(uncertainty, tuple) else (uncertainty,) * len(limits)
    over = tuple(probability_over(rule.value, limits, us).tolist())
    return decide_rule(rule, us, over, guard_factor, skewed=False)


def decide_rule(
    rule: Rule,
    standard_uncertainties: tuple[float, ...],
    probabilities: tuple[float, ...],
    guard_factor: float,
    skewed: bool,
    interval: tuple[float, float] | None = None,
    *,
    by_value: bool = False,
) -> RuleDecision:
    """Decide a rule level by level; uncertainty and probability over the limit are given for each of its levels.

    ``interval`` is that of the value, where it was drawn. Where the value is ``skewed``, the rule's level follows from
    the probabilities: it has most likely been reached; ``by_value``: from the value, and how sure it is from them.
    """
    rule = replace(rule, reached=probabilities) if skewed and not by_value else rule
    sign = -1.0 if rule.steps.falling else 1.0  # under a falling limit is over the same limit with another sign
    levels = tuple(
        LevelDecision(
            name,
            limit,
            decide(sign * rule.value, sign * limit, u, guard_factor, p if skewed else None, by_value=by_value),
            p,
        )
        for (name, limit), u, p in zip(rule.steps.levels, standard_uncertainties, probabilities, strict=True)
    )
    index = _number_of(rule.limit, levels)
    return RuleDecision(
        rule=rule,
        limit=levels[index].limit,
        standard_uncertainty=standard_uncertainties[index],
        decision=levels[index].decision,
        probability_over_limit=levels[index].probability_over,
        levels=levels,
        level_uncertainties=standard_uncertainties,
        interval=interval,
    )


FORM_LEADS = 0.5  # fraction of the clearance's variance from which on the form of the parts is what to measure better
_MOST_REPEATS = 10  # of one place: beyond that a better instrument is the answer
_SYMBOL: dict[Part, str] = {"spool": "d", "sleeve": "D"}


@dataclass(frozen=True)
class Remedy:
    """The measurements that would make the guard band narrow enough to decide.

    Where the limit is finer than the gauge, all this is what would tell the limit from a new pair.
    """

    first: Part | None  # part to measure first
    fraction: float  # of the clearance's variance, that its readings carry
    repeats: int | None  # independent ones of each place of ``repeat_parts`` that decide it; None where none do
    repeat_parts: tuple[Part, ...]  # to be measured again
    instruments: tuple[tuple[tuple[Part, str], ...], ...]  # choices that decide it: a part and its instrument, or two
    reading_part: float  # of the value's variance, that the clearance carries; no instrument takes away the rest
    directions: tuple[Part, ...]  # parts that decide it when measured in four directions
    form: float  # of the clearance's variance, for want of directions
    measurable: bool  # False: the limit is finer than the gauge
    by_range: bool = False  # of wear, where of the pair when new a range is known: measuring it again tells no more
    unworn_end: bool = False  # whether that of its bore would then decide it

    @property
    def decides(self) -> bool:
        """Return whether measuring again can decide it, or comes nearest to that where the form leaves most open."""
        return bool(self.repeats is not None or self.directions or self.instruments or self.form > FORM_LEADS)


def remedy(
    land: LandSources,
    rule: RuleDecision,
    per_clearance: float,
    allowed: float,
    measurable: bool,
) -> Remedy:
    """Work out how a conditional decision could be decided, as `allowed_variance` says how sure it must be."""
    measured = [part for part in PARTS if part in land.plans]
    first = max(measured, key=land.part_fraction, default=None)
    variance = rule.standard_uncertainty**2
    by_reading = (per_clearance * land.standard_uncertainty) ** 2
    reading_part = min(by_reading / variance, 1.0) if variance > 0.0 and math.isfinite(variance) else 0.0
    repeats, parts = _repeats(land, measured, first, allowed)
    return Remedy(
        first=first,
        fraction=land.part_fraction(first) if first else 0.0,
        repeats=repeats,
        repeat_parts=parts,
        instruments=_better(land, measured, allowed) if allowed > 0.0 else (),
        reading_part=reading_part,
        directions=_more_directions(land, measured, allowed),
        form=math.fsum(fraction for source, fraction in land.budget if source.kind == "form"),
        measurable=measurable,
    )


def allowed_variance(
    land: LandSources, rule: RuleDecision, per_clearance: float, guard_factor: float, distance: float
) -> float:
    """Return the variance [m²] that the clearance may have for a guard band as wide as a distance; −1 for none.

    Parameters
    ----------
    per_clearance
        change of the rule's value per change of the clearance [1/m]; 1 for the clearance itself.
    distance
        by which the value, or a new pair where the limit is not measurable, is apart from the limit.
    """
    variance = rule.standard_uncertainty**2
    if not (per_clearance and math.isfinite(variance)):
        return -1.0
    needed = distance / guard_factor if guard_factor else math.inf
    rest = max(variance - (per_clearance * land.standard_uncertainty) ** 2, 0.0)
    return (needed**2 - rest) / per_clearance**2


def gauges_that_do(land: LandSources, allowed: float) -> Sentence:
    """Say which gauges of the catalogue tell the limit from a new pair."""
    measured = [part for part in PARTS if part in land.plans]
    choices = _better(land, measured, allowed) if allowed > 0.0 else ()
    if not choices:
        return Sentence("No gauge of the catalogue would do: set a limit of so many µm (at_least_um).")
    return Sentence(
        "It would be measurable with {gauges}.",
        gauges=reduce(
            lambda said, other: Sentence("{gauges}, or with {others}", gauges=said, others=other),
            map(_gauges, choices),
        ),
    )


def _gauges(choice: Sequence[tuple[Part, str]]) -> Sentence:
    return all_of(
        Sentence("{instrument} for {symbol}", instrument=Name(instrument), symbol=_SYMBOL[part])
        for part, instrument in choice
    )


def advise(rule: RuleDecision, name: str, way: Remedy, land: LandSources, limit_text: str, guard_text: str) -> str:
    """Say a conditional decision and its remedy in plain words.

    Parameters
    ----------
    name
        name of the value that is judged: ``"radial clearance"``.
    limit_text, guard_text
        the limit with its name and the ± guard band, with their units.
    """
    side = "over" if rule.decision == "conditional_fail" else "under"
    tools = _tools(land)
    if way.by_range and way.measurable:
        text = f"{name}, counted from the widest new pair, is {side} the {limit_text}"
        text = "within the range of new" if rule.value <= 0.0 else text
        likely = f"worn past the limit with {_percent(rule.probability_over_limit)} probability"
        text += f", {'but ' if side == 'under' else ''}{likely}"
        first = "measure its bore at an unworn end first, which tells what the pair was when new"
        return f"{text}: {first}." if way.unworn_end else f"{text}. Measuring again will not settle it."
    if not way.measurable:
        text = f"{name}: the {limit_text} is not measurable with {tools} ({guard_text})."
        if way.first is None and land.state.leak is not None:
            return f"{text} Measure its diameters."
        return f"{text} {_ways_to_decide(way)}"
    text = f"{name} is {side} the {limit_text}, but within what {tools} can tell ({guard_text})"
    if way.reading_part < 0.5:
        rest = "the mounting clearance" if rule.rule.kind is RuleKind.WEAR else "fluid, pressure and pump"
        if rule.rule.steps.growth:
            rest = f"what the pair was when new, wear to one side, {rest}"
        return (
            f"{text}: the readings carry only {_percent(way.reading_part)} of the uncertainty, the rest is {rest}. "
            "Measuring again will not settle it."
        )
    if way.first is None and land.state.leak is not None:
        return f"{text}: measure its diameters, which no place of the spool changes."
    if way.first is None:
        return f"{text}: nothing of this pair was measured."
    if not way.decides:
        return f"{text}. {_ways_to_decide(way)}"
    text += (
        f": measure again, {_SYMBOL[way.first]} first, it carries {_percent(way.fraction)} of the uncertainty "
        "of the clearance."
    )
    return f"{text} {_ways_to_decide(way)}"


def _ways_to_decide(way: Remedy) -> str:
    ways = []
    if way.repeats is not None:
        which = " and ".join(_SYMBOL[part] for part in way.repeat_parts)
        ways.append(f"{way.repeats} independent repeats of {which} in every place")
    if way.directions:
        ways.append(f"{' and '.join(_SYMBOL[part] for part in way.directions)} in four directions (0, 45, 90 and 135°)")
    ways += [_gauges(choice) for choice in way.instruments]
    if ways:
        return f"It would be decided by {', or by '.join(ways)}, if the value stays where it is."
    if way.form > FORM_LEADS:
        return (
            f"The form of the parts carries {_percent(way.form)} of the uncertainty of the clearance: measure in four "
            "directions (0, 45, 90 and 135°), which narrows it most, then decide."
        )
    tried = "more repeats, directions and the other instruments of the catalogue"
    return f"The value is too near its limit for {tried}: decide by judgement."


def _percent(fraction: float) -> str:
    return f"{100.0 * fraction:.0f} %"


def _tools(land: LandSources) -> str:
    if land.state.leak_weight == 1.0:
        return "the vacuum test"
    spool, sleeve = land.instruments.spool, land.instruments.sleeve
    names = [land.instruments.of(part).name.lower() for part in PARTS if part in land.plans]
    if len(names) == 2 and spool != sleeve:
        return f"this {names[0]} and this {names[1]}"
    return f"this {names[0]}" if names else "catalogue values"


def _repeats(
    land: LandSources, measured: Sequence[Part], first: Part | None, allowed: float
) -> tuple[int | None, tuple[Part, ...]]:
    if allowed <= 0.0 or first is None:
        return None, ()
    for parts in ((first,), tuple(measured)):
        lowest = min(land.plans[part].repeats for part in parts)

        def enough(count: int, parts: tuple[Part, ...] = parts) -> bool:
            repeats = {part: max(count, land.plans[part].repeats) for part in parts}
            return land.variance_with(repeats=repeats) <= allowed

        if lowest < _MOST_REPEATS and enough(_MOST_REPEATS):  # where these are too few, so are fewer
            return next(count for count in range(lowest + 1, _MOST_REPEATS + 1) if enough(count)), parts
    return None, ()


def _more_directions(land: LandSources, measured: Sequence[Part], allowed: float) -> tuple[Part, ...]:
    """Return the parts that decide it when they are measured in four directions: one of them, or else both."""
    if allowed <= 0.0:
        return ()
    for parts in (*((part,) for part in measured), tuple(measured)):
        if land.variance_with(four_directions=parts) <= allowed:
            return parts
    return ()


def _better(land: LandSources, measured: Sequence[Part], allowed: float) -> tuple[tuple[tuple[Part, str], ...], ...]:
    others = {
        part: [
            instrument
            for instrument in _catalogue()
            if part in instrument.measures and instrument != land.instruments.of(part)
        ]
        for part in measured
    }
    single = [{part: instrument} for part, candidates in others.items() for instrument in candidates]
    pairs = [dict(zip(others, chosen, strict=True)) for chosen in product(*others.values())] if len(others) > 1 else []
    for choices in (single, pairs):
        sufficient = [chosen for chosen in choices if land.variance_with(instruments=chosen) <= allowed]
        if sufficient:
            return tuple(
                tuple((part, instrument.name.lower()) for part, instrument in chosen.items()) for chosen in sufficient
            )
    return ()


@lru_cache(maxsize=1)
def _catalogue() -> tuple[Instrument, ...]:
    return tuple(instruments())
