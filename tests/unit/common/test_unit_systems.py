"""Quantities in the reader's units: exact factors, and nothing lost on the way there and back."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.common.errors import InputError
from atleak.common.translations import languages
from atleak.common.units import SYSTEMS
from atleak.common.wording import wording

KINDS = tuple(SYSTEMS["metric"])


@pytest.mark.parametrize(
    ("units", "kind", "carried", "shown"),
    [
        ("us", "length", 25.4, 1.0),
        ("us", "clearance", 25.4, 10.0),  # µm; ten times 0.0001 in
        ("us", "pressure", 689.4757293168361, 100.0),
        ("us", "temperature", 100.0, 212.0),
        ("us", "temperature", -40.0, -40.0),
        ("us", "temperature_difference", 100.0, 180.0),  # a difference has no zero of its own
        ("us", "flow", 3.785411784, 1.0),
        ("us", "flow", 1.0, 1000.0 / 3785.411784),
        ("us", "leak", 3.785411784, 231.0),
        ("us", "density", 0.45359237 / 3.785411784, 1.0),
        ("us", "distance", 1.609344, 1.0),
        ("us", "displacement", 16387.064, 1.0),
        ("metric_bar", "pressure", 1234.0, 12.34),
        ("metric_bar", "flow", 3.2, 3.2),
        ("metric", "pressure", 1234.0, 1234.0),
    ],
)
def test_factors_are_those_by_which_the_units_are_defined(units: str, kind: str, carried: float, shown: float) -> None:
    assert wording("en", units).convert(carried, kind) == pytest.approx(shown, rel=1e-12, abs=0.0)


@given(units=st.sampled_from(tuple(SYSTEMS)), kind=st.sampled_from(KINDS), value=st.floats(-1e6, 1e6))
def test_what_is_shown_in_any_unit_comes_back_as_it_was(units: str, kind: str, value: float) -> None:
    say = wording("en", units)
    assert say.back(say.convert(value, kind), kind) == pytest.approx(value, rel=1e-12, abs=1e-9)


@pytest.mark.parametrize(
    ("kind", "carried", "said"),
    [
        ("pressure", 55.0, "8\xa0psi"),
        ("pressure", 69.0, "10\xa0psi"),
        ("pressure", 103.0, "15\xa0psi"),
        ("pressure", 1034.2, "150\xa0psi"),
        ("pressure", 13.8, "2\xa0psi"),
        ("pressure", 2.0, "0.29\xa0psi"),
        ("clearance", 4.0, "0.00016\xa0in"),
        ("clearance", 0.5, "0.00002\xa0in"),
        ("length", 12.7, "0.5\xa0in"),
        ("length", 15.0, "0.5906\xa0in"),
        ("temperature", 98.9, "210\xa0°F"),
        ("flow", 0.1, "0.026\xa0gpm"),
        ("displacement", 17100.3, "1.044\xa0in³"),
        ("distance", 212_000.0, "131731\xa0mi"),
        ("pressure", 0.0, "0\xa0psi"),
    ],
)
def test_a_stated_value_has_the_digits_of_its_kind_and_two_that_count(kind: str, carried: float, said: str) -> None:
    assert wording("en", "us").plain_quantity(carried, kind) == said


@pytest.mark.parametrize("language", languages())
def test_a_quantity_stands_in_the_readers_unit_with_the_languages_decimal_sign(language: str) -> None:
    sign = "." if language == "en" else ","
    said = {units: wording(language, units).quantity(95.5, "pressure", 1) for units in SYSTEMS}
    assert said == {"metric": f"95{sign}5\xa0kPa", "metric_bar": f"0{sign}955\xa0bar", "us": f"13{sign}9\xa0psi"}


def test_a_clearance_in_a_sentence_is_in_inches_and_below_a_heading_in_tenths_of_a_thousandth() -> None:
    assert wording("en", "us").spelled(25.4, "clearance") == "0.00100"
    say = wording("en", "us")
    assert say.quantity(25.4, "clearance") == "0.00100\xa0in"
    assert (say.value(25.4, "clearance"), say.unit("clearance")) == ("10.0", "0.0001 in")


def test_what_is_not_known_is_a_dash_in_every_system() -> None:
    assert {wording("en", units).value(None, "pressure") for units in SYSTEMS} == {"–"}


def test_a_system_that_is_not_there_is_refused_by_name() -> None:
    with pytest.raises(InputError, match="metric_bar"):
        wording("en", "imperial")
