"""Write learned mounting clearances into a valve body's file, and say what was left out and how far to trust them."""

from __future__ import annotations

import copy
import datetime as dt
import re
from collections.abc import Iterable, Iterator, Mapping
from statistics import median
from typing import Any

from atleak.analysis.learning.learned_clearances import (
    COVERED,
    PUBLISHED_NEW,
    Learned,
    LearnedLand,
    LearnedUnit,
    LeftOut,
    ToleranceFrom,
)
from atleak.analysis.learning.outliers import UNITS_TO_JUDGE_A_SHIFT, UNITS_TO_NAME_ONE, WhyUnit
from atleak.common.errors import Message, Place
from atleak.common.sentences import Sentence, counted, in_a_row, some
from atleak.common.units import PERCENT, UM, Quantity
from atleak.diagnosis.messages import LANDS_LISTED

_KEY = "mounting_clearance_um"
_DECIMALS = 2  # of a micrometre: finer than any reading
_LEAST = 1.0  # [µm] that the file takes as the clearance of a new pair
_FILES_NAMED = 20


def with_learned(data: Mapping[str, Any], learned: Learned, day: dt.date) -> dict[str, Any]:
    """Return the tables of a valve body's file with the mounting clearances that were learned for it.

    Each land that was learned states its clearance and tolerance, from how many units, and that they were measured; the
    note at the head says from which sheets and when. All else stays as it is.

    Parameters
    ----------
    data
        the tables of the file of ``learned.controller``, as `atleak.catalogue.entries.read_tables` gives them.
    day
        of learning, for the note.
    """
    tables = copy.deepcopy(dict(data))
    by_land = {land.land.key: land for land in learned.lands}
    used = bool(tables.get("defaults", {}).get("mounting_clearance_of_used_unit"))
    for component in tables["components"]:
        for table in component.get("lands", []):
            land = by_land.get((component["id"], table["land"]))
            if land is not None:
                _write(table, land, used_by_default=used)
    tables["note"] = " ".join(part for part in (tables.get("note", "").strip(), origin_note(learned, day)) if part)
    return tables


def _write(table: dict[str, Any], land: LearnedLand, *, used_by_default: bool) -> None:
    clearance, tolerance = (round(length * UM, _DECIMALS) for length in (land.clearance, land.tolerance))
    if tolerance < clearance - _LEAST:
        table |= {_KEY: clearance, "mounting_tolerance_um": tolerance}
    else:  # a number whose tolerance would let a new pair bind is written as the range that both make
        table[_KEY] = [max(round(clearance - tolerance, _DECIMALS), _LEAST), round(clearance + tolerance, _DECIMALS)]
        table.pop("mounting_tolerance_um", None)
    table["learned_from_units"] = land.units
    table["measured"] = [*(key for key in table.get("measured", []) if key != _KEY), _KEY]
    table.pop("mounting_clearance_of_used_unit", None)
    if used_by_default:
        table["mounting_clearance_of_used_unit"] = False
    for name in ("published", "representative"):
        if others := [key for key in table.pop(name, []) if key != _KEY]:
            table[name] = others


def origin_note(learned: Learned, day: dt.date) -> str:
    """Say from which sheets, when and of how many lands mounting clearances were learned."""
    counted, others = learned.counted, [unit.file for unit in learned.units if unit.left_out is not None]
    files = [unit.file for unit in counted]
    named = ", ".join(files[:_FILES_NAMED]) + (f" and {len(files) - _FILES_NAMED} more" if files[_FILES_NAMED:] else "")
    left = f", without {', '.join(others)}" if others else ""
    return (
        f"Mounting clearances of {len(learned.lands)} of {len(learned.controller.lands)} lands were learned on "
        f"{day.isoformat()} from {len(files)} measuring sheet{'' if len(files) == 1 else 's'} ({named}){left}."
    )


def without_sheets(note: str) -> tuple[str, list[str]]:
    """Return a note that names no sheets, and the days on which clearances were learned.

    What `origin_note` has added says on which day and of how many sheets alone; whatever stands behind it is left out.
    """
    found = list(_LEARNED.finditer(note))
    kept = [note[: found[0].start()].strip() if found else note, *(f"{match[0]}." for match in found)]
    return " ".join(part for part in kept if part), [match["day"] for match in found]


_LEARNED = re.compile(
    r"Mounting clearances of \d+ of \d+ lands were learned on (?P<day>[\d-]+) from \d+ measuring sheets?"
)
_FEW_UNITS = 4  # up to so many a result says how few they are


def learned_messages(learned: Learned) -> tuple[Message, ...]:
    """Return what is to be known about mounting clearances that were learned, warnings first."""
    sentences = [
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
    return tuple(sorted(sentences, key=lambda message: message.level != "warning"))


def why_left_out(unit: LearnedUnit, pairs: Iterable[LeftOut]) -> Sentence:
    """Say why a unit is left out as a whole; "" where it counts."""
    shift = _width(abs(unit.shift))
    wide = [f"{pair.component}/{pair.land}" for pair in pairs if pair.file == unit.file and pair.wider]
    match unit.left_out:
        case WhyUnit.WIDE_THROUGHOUT:
            return Sentence(
                "all its lands together are {shift} {shift.unit} wider than those of the other units: worn, or another "
                "zero",
                shift=shift,
            )
        case WhyUnit.TIGHT_THROUGHOUT:
            return Sentence(
                "all its lands together are {shift} {shift.unit} tighter than those of the other units: another zero "
                "or ring",
                shift=shift,
            )
        case WhyUnit.WIDE_LANDS:
            return Sentence(
                "{count} lands are wider than those of the other units ({lands}): worn",
                count=len(wide),
                lands=_listed(wide),
            )
        case WhyUnit.WIDER_TOGETHER:
            return Sentence(
                "its wider lands together are wider than new ones differ by chance, though none by itself: worn"
            )
    return Sentence("")


def _units_left_out(learned: Learned) -> Iterator[Message]:
    for unit in learned.units:
        reason = why_left_out(unit, learned.left_out)
        if reason:
            text = Sentence("{file} is left out as a whole: {reason}", file=unit.file, reason=reason)
            yield Message("warning", "unit_left_out", text, Place(unit.file))


def _pairs_left_out(learned: Learned) -> Iterator[Message]:
    whole = {unit.file for unit in learned.units if unit.left_out is not None}
    for pair in learned.left_out:
        if pair.file in whole:
            continue
        wider, tighter = (
            Sentence("wider, as wear makes it"),
            Sentence("tighter, which no wear does: a wrong reading?"),
        )
        text = Sentence(
            "{file}: {land} is left out: {clearance} {clearance.unit}, where the other units make {expected} "
            "{expected.unit}: {way}",
            file=pair.file,
            land=f"{pair.component}/{pair.land}",
            clearance=_width(pair.clearance),
            expected=_width(pair.expected),
            way=wider if pair.wider else tighter,
        )
        yield Message("warning", "pair_left_out", text, Place(pair.file))


def _many_left_out(learned: Learned) -> Iterator[Message]:
    gone = len(learned.units) - len(learned.counted)
    if 3 * gone > len(learned.units):
        text = Sentence(
            "{gone} of {units} units are left out: the sheets may be of two kinds of unit, or of two instruments. Look "
            "at the units before taking these values over",
            gone=gone,
            units=len(learned.units),
        )
        yield Message("warning", "many_units_left_out", text)


def _one_unit(learned: Learned) -> Iterator[Message]:
    if learned.spread is not None:
        return
    low, high = map(_width, PUBLISHED_NEW)
    origins = {land.tolerance_from for land in learned.lands}
    published = Sentence(
        "half the published range of new valves, {low:g}-{high:g} {high.unit} radial (Sonnax), is taken as the "
        "tolerance (choice of this project)",
        low=low,
        high=high,
    )
    of_file = Sentence("the tolerance is that of the valve body's file, √2 times, as two pairs differ")
    each = ((ToleranceFrom.PUBLISHED, published), (ToleranceFrom.FILE, of_file))
    text = Sentence(
        "One unit shows what its own clearances are, not how far new pairs differ, and nothing tells whether it is "
        "worn: {taken}. A second unit, better three, would show it",
        taken=in_a_row(text for origin, text in each if origin in origins),
    )
    yield Message("warning", "one_unit", text)


def _few_units(learned: Learned) -> Iterator[Message]:
    count = len(learned.counted)
    if learned.spread is None or count > _FEW_UNITS:
        return
    sentences = [
        counted(
            count,
            "{count} unit is few: the uncertainties are wider by Student's t",
            "{count} units are few: their spread is taken over all lands together, and the uncertainties are wider by "
            "Student's t",
        )
    ]
    if len(learned.units) < UNITS_TO_NAME_ONE:
        sentences.append(
            Sentence("a worn unit cannot be named, only single pairs that are wider than those of the other unit")
        )
    if len(learned.units) < UNITS_TO_JUDGE_A_SHIFT:
        shifts = [unit.shift for unit in learned.counted]
        sentences.append(
            Sentence(
                "a unit that is worn in all lands alike cannot be told from a new one (all lands together are {apart} "
                "{apart.unit} apart)",
                apart=_width(max(shifts) - min(shifts)),
            )
        )
    yield Message("info", "few_units", in_a_row(sentences))


def _wider_than_thought(learned: Learned) -> Iterator[Message]:
    """Name the lands that are surely wider than the file has new pairs, as all units worn alike would make them."""
    wide = [land for land in learned.lands if land.clearance - land.uncertainty > land.land.widest_new]
    if wide:
        most = max(wide, key=lambda land: land.clearance - land.land.widest_new)
        text = Sentence(
            "{count} of {lands} lands are wider than the file has them when new ({widest}: {clearance} "
            "{clearance.unit}, so far at most {so_far}): {wide}. Units that are worn alike look like this too: look at "
            "them before taking these values over",
            count=len(wide),
            lands=len(learned.lands),
            widest=_name(most),
            clearance=_width(most.clearance),
            so_far=_width(most.land.widest_new),
            wide=_listed(map(_name, wide)),
        )
        yield Message("warning", "wider_than_new_so_far", text)


def _known_better(learned: Learned) -> Iterator[Message]:
    better = [land for land in learned.lands if (land.land.learned_from_units or 0) > land.units]
    if better:
        text = Sentence(
            "The file's mounting clearances of {lands} were learned from more units ({before}) than these ({now}): "
            "measure all of them together, or keep the old ones",
            lands=_listed(map(_name, better)),
            before=better[0].land.learned_from_units,
            now=better[0].units,
        )
        yield Message("warning", "known_from_more_units", text)


def _unworn_ends(learned: Learned) -> Iterator[Message]:
    lands = [land for land in learned.lands if land.unworn_ends]
    if lands:
        text = Sentence(
            "{lands} rest on unworn ends of bores, beside the spool as it is: a spool that is worn too makes the "
            "clearance too wide, and nothing on the sheet can tell",
            lands=_listed(map(_name, lands)),
        )
        yield Message("info", "rests_on_unworn_ends", text)


def _unlearned(learned: Learned) -> Iterator[Message]:
    if learned.unlearned:
        names = [f"{land.component}/{land.land}" for land in learned.unlearned]
        text = Sentence(
            "Not measured on any unit that counts: {lands}. They keep the mounting clearance of the file",
            lands=_listed(names),
        )
        yield Message("info", "lands_not_learned", text)


def summary(learned: Learned) -> Sentence:
    """Say in one sentence or two what was learned from how many units, and what limits it."""
    count, lands = len(learned.counted), len(learned.lands)
    tolerance = _width(median(land.tolerance for land in learned.lands))
    known = Sentence(
        "Mounting clearances of {lands} lands from {units}, known to ± {known} {known.unit} ({covered:g} %, median of "
        "the lands): ± {by_units} {by_units.unit} by the units and their readings, the rest by the calibration of the "
        "instruments, which more units do not improve.",
        lands=lands,
        units=counted(count, "{count} unit", "{count} units"),
        known=_width(median(land.uncertainty for land in learned.lands)),
        covered=COVERED * PERCENT,
        by_units=_width(median(land.uncertainty_by_units for land in learned.lands)),
    )
    differ = Sentence("The tolerance of ± {tolerance} {tolerance.unit} is taken, not measured.", tolerance=tolerance)
    if learned.spread is not None and learned.measurement is not None:
        differ = Sentence(
            "New pairs differ by {spread} {spread.unit} (one standard deviation), measuring one adds {measuring} "
            "{measuring.unit}; {covered:g} % of new pairs lie within ± {tolerance} {tolerance.unit}.",
            spread=_width(learned.spread),
            measuring=_width(learned.measurement),
            covered=COVERED * PERCENT,
            tolerance=tolerance,
        )
    return Sentence("{known} {differ}", known=known, differ=differ)


def _name(land: LearnedLand) -> str:
    return f"{land.land.component}/{land.land.land}"


def _listed(names: Iterable[str]) -> Sentence:
    return some(list(names), LANDS_LISTED)


def _width(metres: float) -> Quantity:
    return Quantity(metres * UM, "clearance", 1)
