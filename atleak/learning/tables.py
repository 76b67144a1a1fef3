"""Write learned mounting clearances into the tables of a valve body's file."""

from __future__ import annotations

import copy
import datetime as dt
from collections.abc import Mapping
from typing import Any

from atleak.learning.learned import Learned, LearnedLand
from atleak.workshop_units import UM

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
    learned
        what the sheets tell.
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
