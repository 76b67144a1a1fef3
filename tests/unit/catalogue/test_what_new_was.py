"""What a controller's file says of its pairs when new: this pair's own value, the type's, or only a range."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.controller_tables import NewOrigin
from atleak.common.errors import CatalogueError

Edited = Callable[..., Path]
FIRST = "land = 1, nominal_diameter_mm = 15.0, mounting_clearance_um = 18.0"


def stating(edited: Edited, text: str, defaults: str = "") -> Path:
    """The minimal example with other keys in its first land and more in [defaults]."""
    changes = [(FIRST, f"land = 1, nominal_diameter_mm = 15.0{text}")]
    if defaults:
        changes.append(("[defaults]", f"[defaults]\n{defaults}"))
    return edited("controllers", "minimal_example", *changes)


@pytest.mark.parametrize(
    ("land", "defaults", "ends", "tolerance", "origin"),
    [
        (", mounting_clearance_um = 18", "", (18, 18), None, NewOrigin.PAIR),
        (", mounting_clearance_um = 18, mounting_tolerance_um = 2", "", (18, 18), 2, NewOrigin.TYPE),
        (", mounting_clearance_um = [6.4, 20]", "", (6.4, 20), None, NewOrigin.RANGE),
        ("", "mounting_clearance_um = [6.4, 20]", (6.4, 20), None, NewOrigin.RANGE),
        ("", "mounting_clearance_um = 13\nmounting_tolerance_um = 5", (13, 13), 5, NewOrigin.TYPE),
        (", mounting_clearance_um = 18, mounting_clearance_of_used_unit = true", "", (18, 18), None, "used_unit"),
        # a tolerance of all single values says nothing of a range
        (", mounting_clearance_um = [6.4, 20]", "mounting_tolerance_um = 5", (6.4, 20), None, NewOrigin.RANGE),
    ],
)
def test_a_file_says_in_one_of_three_ways_what_new_was(
    edited: Edited, land: str, defaults: str, ends: tuple[float, float], tolerance: float | None, origin: str
) -> None:
    first = load_controller(stating(edited, land, defaults)).lands[0]
    assert first.mounting_range == pytest.approx((ends[0] * 1e-6, ends[1] * 1e-6), abs=1e-15)
    assert first.mounting_tolerance == (None if tolerance is None else pytest.approx(tolerance * 1e-6, abs=1e-15))
    assert first.new_origin == origin


@pytest.mark.parametrize(
    ("land", "key", "words"),
    [
        (", mounting_clearance_um = [20, 6.4]", "mounting_clearance_um", "lower end first"),
        (", mounting_clearance_um = [6.4]", "mounting_clearance_um", "a range of two"),
        (', mounting_clearance_um = "6.4-20"', "mounting_clearance_um", "a range of two"),
        (", mounting_clearance_um = [6.4, nan]", "mounting_clearance_um", "a range of two"),
        (", mounting_clearance_um = [6.4, 20], mounting_tolerance_um = 2", "mounting_tolerance_um", "beside a range"),
        (", mounting_clearance_um = 18, mounting_tolerance_um = 18", "mounting_tolerance_um", "leaves every new pair"),
        ("", "mounting_clearance_um", "a number, or a range such as"),
    ],
)
def test_what_new_pairs_cannot_have_been_is_refused(edited: Edited, land: str, key: str, words: str) -> None:
    with pytest.raises(CatalogueError) as caught:
        load_controller(stating(edited, land))
    assert (caught.value.place.file, caught.value.place.key) == ("own.toml", key)
    assert words in str(caught.value)


def test_a_tolerance_beside_a_range_is_refused_among_the_defaults_too(edited: Edited) -> None:
    path = edited(
        "controllers",
        "minimal_example",
        ("[defaults]\n", "[defaults]\nmounting_clearance_um = [6.4, 20.0]\nmounting_tolerance_um = 2.0\n"),
    )
    with pytest.raises(CatalogueError, match="beside a single mounting_clearance_um, not beside a range"):
        load_controller(path)
