"""Say in plain words what to do about a decision that the measurement leaves open."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache, reduce
from itertools import product

from atleak.catalogue.instruments import Instrument, Part, instruments
from atleak.catalogue.limits import RuleKind
from atleak.sentence import Name, Sentence, all_of
from atleak.uncertainty.decision import RuleDecision
from atleak.uncertainty.sources import PARTS, LandSources

FORM_LEADS = 0.5  # fraction of the clearance's variance from which on the form of the parts is what to measure better
_MOST_REPEATS = 10  # of one place: beyond that a better instrument is the answer
_SYMBOL: dict[Part, str] = {"spool": "d", "sleeve": "D"}


@dataclass(frozen=True)
class Remedy:
    """The measurements that would make the guard band narrow enough to decide.

    ``first`` is the part to measure first, ``fraction`` the part of the clearance's variance that its readings carry.
    ``repeats`` is how many independent repeats of each place of ``repeat_parts`` decide it; None where none do.
    ``instruments`` lists the choices of shipped instruments that decide it, each choice a part and its instrument, or
    two where one is not enough. ``reading_part`` is the part of the judged value's variance that the clearance
    carries; no instrument can take away the rest. ``directions`` are the parts that decide it when they are measured
    in four directions, ``form`` the part of the clearance's variance that comes of seeing their form in few. Where
    ``measurable`` is false the limit is finer than the gauge, and all this is what would tell the limit from a new
    pair.
    """

    first: Part | None
    fraction: float
    repeats: int | None
    repeat_parts: tuple[Part, ...]
    instruments: tuple[tuple[tuple[Part, str], ...], ...]
    reading_part: float
    directions: tuple[Part, ...]
    form: float
    measurable: bool

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
    if not way.measurable:
        text = f"{name}: the {limit_text} is not measurable with {tools} ({guard_text})."
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
