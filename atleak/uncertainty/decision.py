"""Decide from a value, its uncertainty and a limit: pass, conditional pass, conditional fail or fail."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

from atleak.catalogue.limits import Level, reaches
from atleak.equations.uncertainty import guard_band, normal_cdf, probability_over
from atleak.rules import Rule

Decision = Literal["pass", "conditional_pass", "conditional_fail", "fail"]
DECISIONS: tuple[Decision, ...] = ("pass", "conditional_pass", "conditional_fail", "fail")  # the worst last
GUARD_FACTOR = 1.645  # one-sided 95 %


@dataclass(frozen=True)
class LevelDecision:
    """One of a rule's limits, and the decision of the value against it."""

    level: Level
    limit: float
    decision: Decision
    probability_over: float


@dataclass(frozen=True)
class RuleDecision:
    """The decision on a rule: its value against the limit it reached, or its lowest limit where it reached none.

    ``limit`` and ``standard_uncertainty`` are in SI or fractions, as the rule's value is.
    """

    rule: Rule
    limit: float
    standard_uncertainty: float
    decision: Decision
    probability_over_limit: float
    levels: tuple[LevelDecision, ...]
    level_uncertainties: tuple[float, ...]
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
        over = probability_over >= 0.5
        sure = probability_over >= 1.0 - risk or probability_over <= risk
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
) -> RuleDecision:
    """Decide a rule level by level; uncertainty and probability over the limit are given for each of its levels.

    ``interval`` is that of the value, where it was drawn. Where the value is ``skewed``, the rule's level follows from
    the probabilities: it has most likely been reached.
    """
    rule = replace(rule, reached=probabilities) if skewed else rule
    sign = -1.0 if rule.steps.falling else 1.0  # under a falling limit is over the same limit with another sign
    levels = tuple(
        LevelDecision(name, limit, decide(sign * rule.value, sign * limit, u, guard_factor, p if skewed else None), p)
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
