"""Show what was learned from measuring sheets as tables in a reader's language and units."""

from __future__ import annotations

from atleak.learning.learned import Learned
from atleak.learning.words import why
from atleak.views.catalogue_table import Rows, columns, span
from atleak.views.columns import Column
from atleak.views.land_names import land_number
from atleak.wording import Wording
from atleak.workshop_units import UM

LEARNED_LANDS = columns(
    "pair",
    Column("learned_new", "clearance", 2),
    Column("sure_to", "clearance", 2),
    Column("of_pairs", "clearance", 2),
    Column("learned_spread", "clearance", 2),
    Column("units", digits=0),
    Column("unworn_ends", digits=0),
    Column("so_far", words_of="clearance"),
)
LEARNED_OUTLIERS = columns(
    "sheet",
    "pair",
    Column("this_measured", "clearance", 2),
    Column("others", "clearance", 2),
    Column("wider_by", "clearance", 2),
)
LEARNED_UNITS = columns(
    "sheet", Column("lands", digits=0), "learned_unit", Column("all_wider_by", "clearance", 2), "left_out"
)


def learned_lands(learned: Learned, say: Wording) -> Rows:
    """Return a row for every land that was learned."""
    return [
        {
            "pair": land_number(learned.controller, (land.land.component, land.land.land), say),
            "learned_new": land.clearance * UM,
            "sure_to": land.uncertainty * UM,
            "of_pairs": land.tolerance * UM,
            "learned_spread": None if land.spread is None else land.spread * UM,
            "units": land.units,
            "unworn_ends": land.unworn_ends,
            "so_far": span((end * UM for end in land.land.mounting_ends), "clearance", say),
        }
        for land in learned.lands
    ]


def learned_outliers(learned: Learned, say: Wording) -> Rows:
    """Return a row for every pair that does not count by itself, the widest first."""
    return [
        {
            "sheet": pair.file,
            "pair": land_number(learned.controller, (pair.component, pair.land), say),
            "this_measured": pair.clearance * UM,
            "others": pair.expected * UM,
            "wider_by": (pair.clearance - pair.expected) * UM,
        }
        for pair in sorted(learned.left_out, key=lambda pair: pair.expected - pair.clearance)
    ]


def learned_units(learned: Learned, say: Wording) -> Rows:
    """Return a row for every measuring sheet."""
    return [
        {
            "sheet": unit.file,
            "lands": unit.lands,
            "learned_unit": say("learning.used" if unit.of_used_unit else "learning.new"),
            "all_wider_by": unit.shift * UM,
            "left_out": say.sentence(why(unit, learned.left_out)) or None,
        }
        for unit in learned.units
    ]
