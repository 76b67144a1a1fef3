"""Conditions are named in a reader's language, with their temperature in the reader's unit."""

from __future__ import annotations

from dataclasses import replace

import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.common.wording import wording

REVERSE = "reverse_idle"


@pytest.mark.parametrize(
    ("language", "units", "name"),
    [
        ("en", "us", "hot idle in reverse, 212 °F"),
        ("de", "us", "heißer Leerlauf in R, 212 °F"),
        ("de", "metric", "heißer Leerlauf in R, 100 °C"),
    ],
)
def test_the_temperature_in_a_shipped_name_is_in_the_reader_s_unit(language: str, units: str, name: str) -> None:
    points = {point.name: point for point in load_controller("gm_4l60e").operating_points}
    assert wording(language, units).condition(points[REVERSE]).replace("\u00a0", " ") == name


def test_a_name_that_says_another_temperature_than_its_own_stays_as_it_is() -> None:
    point = next(each for each in load_controller("gm_4l60e").operating_points if each.name == REVERSE)
    own = replace(point, label="idle after a hill, 120 °C")
    assert wording("en", "us").condition(own).replace("\u00a0", " ") == "idle after a hill, 120 °C"
