"""Show what was learned from measuring sheets: tables for people, and the record that scripts rely on."""

from __future__ import annotations

from typing import Any

from atleak.analysis.learning.learned_clearances import Learned, LearnedLand
from atleak.analysis.learning.learned_words import learned_messages, summary, why_left_out
from atleak.common.units import UM
from atleak.common.wording import Wording
from atleak.report.json.conditions import message_record, named_record
from atleak.report.tables.names import land_number
from atleak.report.tables.table import Column, Table, span
from atleak.version import __version__

_FORMAT = 1


def learned_lands(learned: Learned, say: Wording) -> Table:
    """Return a row for every land that was learned."""
    shown = (
        Column("pair", of=lambda land: land_number(learned.controller, land.land.key, say), whole=True),
        Column("learned_new", "clearance", 2, of="clearance", times=UM),
        Column("sure_to", "clearance", 2, of="uncertainty", times=UM),
        Column("of_pairs", "clearance", 2, of="tolerance", times=UM),
        Column("learned_spread", "clearance", 2, of="spread", times=UM),
        Column("units", digits=0),
        Column("unworn_ends", digits=0),
        Column("so_far", words_of="clearance", of=lambda land: _span(land, say)),
    )
    return Table("learned", shown, learned.lands, say)


def _span(land: LearnedLand, say: Wording) -> str:
    return span((end * UM for end in land.land.mounting_ends), "clearance", say)


def learned_outliers(learned: Learned, say: Wording) -> Table:
    """Return a row for every pair that does not count by itself, the widest first."""
    shown = (
        Column("sheet", of="file"),
        Column("pair", of=lambda pair: land_number(learned.controller, (pair.component, pair.land), say)),
        Column("this_measured", "clearance", 2, of="clearance", times=UM),
        Column("others", "clearance", 2, of="expected", times=UM),
        Column("wider_by", "clearance", 2, of=lambda pair: (pair.clearance - pair.expected) * UM),
    )
    return Table("outliers", shown, sorted(learned.left_out, key=lambda pair: pair.expected - pair.clearance), say)


def learned_units(learned: Learned, say: Wording) -> Table:
    """Return a row for every measuring sheet."""
    shown = (
        Column("sheet", of="file"),
        Column("lands", digits=0),
        Column("learned_unit", of=lambda unit: say("learning.used" if unit.of_used_unit else "learning.new")),
        Column("all_wider_by", "clearance", 2, of="shift", times=UM),
        Column("left_out", of=lambda unit: say.sentence(why_left_out(unit, learned.left_out)) or None),
    )
    return Table("sheets", shown, learned.units, say)


def learned_record(learned: Learned) -> dict[str, Any]:
    """Return all of it under stable keys: lengths in µm, nothing rounded, unknown as None."""
    return {
        "format": _FORMAT,
        "atleak": __version__,
        "controller": named_record(learned.controller, "id", "name", "sha256"),
        "summary": summary(learned),
        **named_record(learned, "spread_um", "measurement_um"),
        "units": [
            named_record(unit, "file", "sha256", "lands", "of_used_unit", "shift_um", "left_out")
            for unit in learned.units
        ],
        "lands": [_land_record(land) for land in learned.lands],
        "lands_not_learned": [named_record(land, "component", "land") for land in learned.unlearned],
        "outliers": [
            named_record(pair, "file", "component", "land", "clearance_um", "expected_um", "wider")
            for pair in learned.left_out
        ],
        "messages": [message_record(message) for message in learned_messages(learned)],
    }


def _land_record(land: LearnedLand) -> dict[str, Any]:
    return {
        **named_record(land.land, "component", "land"),
        **named_record(land, mounting_clearance_um="clearance", uncertainty_um="uncertainty"),
        **named_record(land, "uncertainty_by_units_um", mounting_tolerance_um="tolerance"),
        **named_record(land, "tolerance_from", "spread_um", "measurement_um", "calibration_um"),
        **named_record(land, learned_from_units="units", unworn_ends="unworn_ends"),
        "mounting_clearance_um_so_far": [end * UM for end in land.land.mounting_ends],
    }
