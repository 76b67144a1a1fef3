"""Say in a reader's language what a comparison comes to: the verdicts, what changed, the total where it was worst."""

from __future__ import annotations

from atleak.comparison import Change, Comparison, EventPair, LandComparison
from atleak.comparison.choices import ChoiceName
from atleak.views.caveats import caveats
from atleak.views.land_names import land_words
from atleak.wording import Wording
from atleak.workshop_units import UM


def verdicts_sentence(comparison: Comparison, say: Wording) -> str:
    """Say the verdict of the unit at both visits, with their signs."""
    before, after = (say.signed(each.verdict) for each in (comparison.before, comparison.after))
    return say("comparison.verdicts", before=before, after=after)


def visit_caveats(comparison: Comparison, say: Wording) -> list[str]:
    """Say what each verdict rests on; what is so at one visit alone, or differs, begins with whose it is."""
    before, after = caveats(comparison.before, say), caveats(comparison.after, say)
    return [
        *(line for line in before if line in after),
        *(f"{say('comparison.before')}: {line}" for line in before if line not in after),
        *(f"{say('comparison.after')}: {line}" for line in after if line not in before),
    ]


def changed_sentence(comparison: Comparison, say: Wording) -> str:
    """Say how many lands changed by more than the measurements can be off."""
    compared = len(comparison.compared)
    if not compared:
        return say("comparison.none_compared")
    return say("comparison.changed", changed=len(comparison.changed), compared=compared)


def total_sentence(comparison: Comparison, say: Wording) -> str | None:
    """Say what the total was and is where it was worst before; None where no total can be compared.

    Where choices differ this is the unit after by the choices of the job before, and its own total stands beside it.
    """
    leading = comparison.leading
    if leading is None or leading.before is None or leading.share is None:
        return None
    own = leading.after if comparison.differing else None
    return say(
        "comparison.total" if own is None else "comparison.total_alike",
        condition=say.condition(leading.before.condition),
        before=say.percent(leading.share.before),
        after=say.percent(leading.share.after),
        own="" if own is None else say.percent(own.share),
        new=say.percent(comparison.before.new_at(leading.before).share),
        how=how_sure(leading.share, say),
    )


def how_sure(change: Change | None, say: Wording) -> str:
    """Say whether a change is more than the measurements can be off."""
    known = None if change is None else change.significant
    return say(f"comparison.{'unknown' if known is None else 'beyond' if known else 'within'}")


def differing_sentence(comparison: Comparison, say: Wording) -> str | None:
    """Say in which choices the two jobs differ, and that the difference is not the repair's alone."""
    if not comparison.differing:
        return None
    names: list[ChoiceName] = [each.name for each in comparison.differing]
    return say("comparison.differing", choices=", ".join(say(f"choices.{name}") for name in names))


def land_name(comparison: Comparison, land: LandComparison, say: Wording) -> str:
    """Name a land: ``25/1 main pressure valve``."""
    after = comparison.after.controller
    return land_words(after if land.key[0] in after.components else comparison.before.controller, land.key, say)


def with_uncertainty(change: Change | None, say: Wording) -> str:
    """Return a change of a clearance [µm] with its sign and half of its 95 % interval: ``−23.5 ± 3.2``."""
    if change is None or change.interval is None:
        return "–"
    half = 0.5 * (change.interval[1] - change.interval[0]) * UM
    digits = say.digits("clearance", 1)
    value = signed_number(say.convert(change.value * UM, "clearance"), digits, say)
    return f"{value} ± {say.value(half, 'clearance', 1)}"


def signed_number(value: float, digits: int, say: Wording) -> str:
    """Return a number with its sign, also where it is positive; no sign where it rounds to zero."""
    text = say.number(value, digits)
    return f"+{text}" if value > 0.0 and float(f"{value:.{digits}f}") != 0.0 else text


def event_name(pair: EventPair, say: Wording) -> str:
    """Name a matched event: ``shift 1 → 2``; of several alike with its place among them."""
    event = pair.event
    gears = "" if event.to_gear is None else f" {event.from_gear} → {event.to_gear}"
    return f"{say(f'events.{event.kind}')}{gears}" + (f" ({pair.order})" if pair.order > 1 else "")
