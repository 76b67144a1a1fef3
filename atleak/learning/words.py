"""Say in sentences what was learned, what was left out, and how far it can be trusted."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from statistics import median

from atleak.errors import Message, Place
from atleak.learning.learned import COVERED, PUBLISHED_NEW, Learned, LearnedLand, LearnedUnit, LeftOut, ToleranceFrom
from atleak.learning.outliers import UNITS_TO_JUDGE_A_SHIFT, UNITS_TO_NAME_ONE, WhyUnit
from atleak.workshop_units import PERCENT, UM

_FEW_UNITS = 4  # up to so many a result says how few they are
_NAMED = 12  # lands that a message lists


def messages(learned: Learned) -> tuple[Message, ...]:
    """Return what is to be known about mounting clearances that were learned, warnings first."""
    said = [
        *_units_left_out(learned),
        *_pairs_left_out(learned),
        *_many_left_out(learned),
        *_one_unit(learned),
        *_few_units(learned),
        *_wider_than_thought(learned),
        *_known_better(learned),
        *_unworn_ends(learned),
        *_unlearned(learned),
    ]
    return tuple(sorted(said, key=lambda message: message.level != "warning"))


def why(unit: LearnedUnit, pairs: Iterable[LeftOut]) -> str:
    """Say why a unit is left out as a whole; "" where it counts."""
    shift = f"{abs(unit.shift) * UM:.1f} µm"
    wide = [f"{pair.component}/{pair.land}" for pair in pairs if pair.file == unit.file and pair.wider]
    match unit.left_out:
        case WhyUnit.WIDE_THROUGHOUT:
            return f"all its lands together are {shift} wider than those of the other units: worn, or another zero"
        case WhyUnit.TIGHT_THROUGHOUT:
            return f"all its lands together are {shift} tighter than those of the other units: another zero or ring"
        case WhyUnit.WIDE_LANDS:
            return f"{len(wide)} lands are wider than those of the other units ({_listed(wide)}): worn"
        case WhyUnit.WIDER_TOGETHER:
            return "its wider lands together are wider than new ones differ by chance, though none by itself: worn"
    return ""


def _units_left_out(learned: Learned) -> Iterator[Message]:
    for unit in learned.units:
        reason = why(unit, learned.left_out)
        if reason:
            yield Message("warning", "unit_left_out", f"{unit.file} is left out as a whole: {reason}", Place(unit.file))


def _pairs_left_out(learned: Learned) -> Iterator[Message]:
    whole = {unit.file for unit in learned.units if unit.left_out is not None}
    for pair in learned.left_out:
        if pair.file in whole:
            continue
        way = "wider, as wear makes it" if pair.wider else "tighter, which no wear does: a wrong reading?"
        yield Message(
            "warning",
            "pair_left_out",
            f"{pair.file}: {pair.component}/{pair.land} is left out: {pair.clearance * UM:.1f} µm, where the other "
            f"units make {pair.expected * UM:.1f} µm: {way}",
            Place(pair.file),
        )


def _many_left_out(learned: Learned) -> Iterator[Message]:
    gone = len(learned.units) - len(learned.counted)
    if 3 * gone > len(learned.units):
        text = (
            f"{gone} of {len(learned.units)} units are left out: the sheets may be of two kinds of unit, or of two "
            "instruments. Look at the units before taking these values over"
        )
        yield Message("warning", "many_units_left_out", text)


def _one_unit(learned: Learned) -> Iterator[Message]:
    if learned.spread is not None:
        return
    low, high = (end * UM for end in PUBLISHED_NEW)
    origins = {land.tolerance_from for land in learned.lands}
    published = (
        f"half the published range of new valves, {low:g}-{high:g} µm radial (Sonnax), is taken as the tolerance "
        "(choice of this project)"
    )
    of_file = "the tolerance is that of the valve body's file, √2 times, as two pairs differ"
    taken = "; ".join(
        text
        for origin, text in ((ToleranceFrom.PUBLISHED, published), (ToleranceFrom.FILE, of_file))
        if origin in origins
    )
    text = (
        "One unit shows what its own clearances are, not how far new pairs differ, and nothing tells whether it is "
        f"worn: {taken}. A second unit, better three, would show it"
    )
    yield Message("warning", "one_unit", text)


def _few_units(learned: Learned) -> Iterator[Message]:
    count = len(learned.counted)
    if learned.spread is None or count > _FEW_UNITS:
        return
    cannot = []
    if len(learned.units) < UNITS_TO_NAME_ONE:
        cannot.append("a worn unit cannot be named, only single pairs that are wider than those of the other unit")
    if len(learned.units) < UNITS_TO_JUDGE_A_SHIFT:
        shifts = [unit.shift for unit in learned.counted]
        apart = (max(shifts) - min(shifts)) * UM
        cannot.append(
            f"a unit that is worn in all lands alike cannot be told from a new one (all lands together are {apart:.1f} "
            "µm apart)"
        )
    text = (
        f"{count} units are few: their spread is taken over all lands together, and the uncertainties are wider by "
        f"Student's t{'; ' if cannot else ''}{'; '.join(cannot)}"
    )
    yield Message("info", "few_units", text)


def _wider_than_thought(learned: Learned) -> Iterator[Message]:
    """Name the lands that are surely wider than the file has new pairs, as all units worn alike would make them."""
    wide = [land for land in learned.lands if land.clearance - land.uncertainty > land.land.widest_new]
    if wide:
        most = max(wide, key=lambda land: land.clearance - land.land.widest_new)
        text = (
            f"{len(wide)} of {len(learned.lands)} lands are wider than the file has them when new "
            f"({_name(most)}: {most.clearance * UM:.1f} µm, so far at most {most.land.widest_new * UM:.1f}): "
            f"{_listed(map(_name, wide))}. Units that are worn alike look like this too: look at them before "
            "taking these values over"
        )
        yield Message("warning", "wider_than_new_so_far", text)


def _known_better(learned: Learned) -> Iterator[Message]:
    better = [land for land in learned.lands if (land.land.learned_from_units or 0) > land.units]
    if better:
        text = (
            f"The file's mounting clearances of {_listed(map(_name, better))} were learned from more units "
            f"({better[0].land.learned_from_units}) than these ({better[0].units}): measure all of them together, or "
            "keep the old ones"
        )
        yield Message("warning", "known_from_more_units", text)


def _unworn_ends(learned: Learned) -> Iterator[Message]:
    lands = [land for land in learned.lands if land.unworn_ends]
    if lands:
        text = (
            f"{_listed(map(_name, lands))} rest on unworn ends of bores, beside the spool as it is: a spool that is "
            "worn too makes the clearance too wide, and nothing on the sheet can tell"
        )
        yield Message("info", "rests_on_unworn_ends", text)


def _unlearned(learned: Learned) -> Iterator[Message]:
    if learned.unlearned:
        names = [f"{land.component}/{land.land}" for land in learned.unlearned]
        text = f"Not measured on any unit that counts: {_listed(names)}. They keep the mounting clearance of the file"
        yield Message("info", "lands_not_learned", text)


def summary(learned: Learned) -> str:
    """Say in one sentence or two what was learned from how many units, and what limits it."""
    count, lands = len(learned.counted), len(learned.lands)
    known = median(land.uncertainty for land in learned.lands) * UM
    by_units = median(land.uncertainty_by_units for land in learned.lands) * UM
    tolerance = median(land.tolerance for land in learned.lands) * UM
    text = (
        f"Mounting clearances of {lands} lands from {count} unit{'' if count == 1 else 's'}, known to ± {known:.1f} µm "
        f"({COVERED * PERCENT:g} %, median of the lands): ± {by_units:.1f} µm by the units and their readings, the "
        "rest by the calibration of the instruments, which more units do not improve. "
    )
    if learned.spread is not None and learned.measurement is not None:
        text += (
            f"New pairs differ by {learned.spread * UM:.1f} µm (one standard deviation), measuring one adds "
            f"{learned.measurement * UM:.1f} µm; {COVERED * PERCENT:g} % of new pairs lie within ± {tolerance:.1f} µm."
        )
    else:
        text += f"The tolerance of ± {tolerance:.1f} µm is taken, not measured."
    return text


def _name(land: LearnedLand) -> str:
    return f"{land.land.component}/{land.land.land}"


def _listed(names: Iterable[str]) -> str:
    every = list(names)
    return ", ".join(every[:_NAMED]) + (f" and {len(every) - _NAMED} more" if every[_NAMED:] else "")
