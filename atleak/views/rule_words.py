"""Say a rule in a reader's language and units: what it limits, its value, the limit it reached."""

from __future__ import annotations

import math

from atleak.rules import Rule
from atleak.wording import Wording, isolated

_KINDS = {"µm": "clearance", "kPa": "pressure"}  # kind of quantity by the unit in which rules are recorded


def rule_value(rule: Rule, value: float, say: Wording) -> str:
    """Return a value of a rule, in SI or as a fraction, in the reader's unit."""
    unit = rule.kind.unit
    if unit in _KINDS:
        return say.quantity(value * rule.kind.factor, _KINDS[unit])
    return say.percent(value) if unit else say.number(value, 2)


def rule_name(rule: Rule, say: Wording, *, brief: bool = False) -> str:
    """Return what a rule limits, of which circuit and at which condition; ``brief``, a share's name is one word."""
    if brief and rule.kind.is_share and rule.condition is not None:
        return say("rules.share_at", condition=say.condition(rule.condition))
    return ", ".join(filter(None, (rule_limited(rule, say), *_where(rule, say))))


def rule_reached(rule: Rule, say: Wording) -> str:
    """Return a rule with its value, the limit and where that was: ``wear 60.1 % (limit 30 %)``."""
    value = rule_value(rule, rule.value, say) if math.isfinite(rule.value) else say.number(rule.value, 0)
    limit = rule_value(rule, rule.limit, say)
    key = "probable" if rule.probable and rule.verdict.flagged else "reached_short"
    reached = say(f"rules.{key}", rule=rule_limited(rule, say), value=value, limit=limit)
    return ", ".join(filter(None, (reached, *_where(rule, say))))


def rule_limited(rule: Rule, say: Wording) -> str:
    """Return what a rule limits; with its circuit in the words of the workbook."""
    return say(f"rules.{rule.kind}") if rule.circuit is None else isolated(say.sentence(rule.quantity))


def _where(rule: Rule, say: Wording) -> tuple[str, str]:
    return "" if rule.condition is None else say.condition(rule.condition), say.sentence(rule.where)
