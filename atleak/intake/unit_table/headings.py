"""What the headings of a table of units say: which part of a job stands in each column."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from functools import cache

from atleak.intake.plain_words import vocabulary, words
from atleak.intake.readings.head_identity import identity_field

_NEAR = 0.8  # of the letters of two headings that are taken for the same
_SHORT = 4  # letters: shorter ones are near to anything
UNCLEAR = "unclear"
"""The meaning of a heading that can be understood in two ways: its column is not taken, and nothing is guessed."""

MEASURED = ("job_file", "readings", "road_test", "pressures")
"""The columns of which a row fills at least one: what a unit is diagnosed by."""

_OF_HEAD = {"job": "number", "vin": "vin", "serial": "serial", "mileage": "mileage", "technician": "technician"}
"""Fields of the head of a measuring sheet, and the column that holds the same."""


@cache
def _names() -> Mapping[str, str]:
    return {words(name): column for column, name in spellings()}


def spellings() -> Iterator[tuple[str, str]]:
    """Yield every column with a heading that it may have, the English ones first."""
    for column, by_language in vocabulary(__package__, "unit_vocabulary.toml").items():
        yield from ((column, name) for names in by_language.values() for name in names)


def nearest_heading(heading: str) -> str | None:
    """Return the known heading that one which is none may be a misspelling of; None where none is near.

    >>> nearest_heading("Schieberkastn"), nearest_heading("Straßenfahrt"), nearest_heading("Batch")
    ('Schieberkasten', None, None)
    """
    written = {words(name): name for _, name in spellings()}
    said = words(heading)
    near = get_close_matches(said, [name for name in written if len(name) >= _SHORT], n=1, cutoff=_NEAR)
    return written[near[0]] if near and len(said) >= _SHORT else None


def column_meant(heading: str) -> str | None:
    """Return the column that a heading stands for, `UNCLEAR`, or None: a column of the table's own.

    >>> column_meant("Messblatt"), column_meant("road_test"), column_meant("Laufleistung [km]"), column_meant("Batch")
    ('readings', 'road_test', 'mileage', None)
    """
    named = _names().get(words(heading))
    return named or _OF_HEAD.get(identity_field(heading) or "")
