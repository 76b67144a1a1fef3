"""Numbers as people of several countries write them."""

from __future__ import annotations

import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.catalogue.written_numbers import (
    ENGINE_SPEED,
    MILEAGE,
    SHIFT,
    TEMPERATURE,
    AskedNumber,
    decimal_number,
    possible_values,
    read_number,
    written,
)
from atleak.common.translations import languages
from atleak.common.units import SYSTEMS
from atleak.common.wording import wording

ASKED = (TEMPERATURE, ENGINE_SPEED, MILEAGE, SHIFT)
# decimal sign and sign between thousands: English, German, Swiss, French, Polish, plain
COUNTRIES = [
    (".", ","), (",", "."), (".", "’"), (",", "\u202f"), (",", "\u00a0"), (".", " "), (",", ""), (".", ""),
]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("850,5", (850.5,)),
        ("850.5", (850.5,)),
        ("−5", (-5.0,)),
        ("– 5,25", (-5.25,)),
        ("+3", (3.0,)),
        (",5", (0.5,)),
        ("5.", (5.0,)),
        ("1e3", (1000.0,)),
        ("1,234e3", (1234.0,)),
        ("123.456", (123.456, 123456.0)),
        ("1,234", (1.234, 1234.0)),
        ("-1,234", (-1.234, -1234.0)),
        ("0.456", (0.456,)),
        ("1234,567", (1234.567,)),
        ("1.234.567", (1234567.0,)),
        ("1,234.567", (1234.567,)),
        ("1.234,567", (1234.567,)),
        ("1'234", (1234.0,)),
        ("1’234’567.5", (1234567.5,)),
        ("1 234", (1234.0,)),
        ("1\u202f234,567", (1234.567,)),
        ("\ufeff850,5 ", (850.5,)),
        ("８５０．５", (850.5,)),
        ("٨٥٠٫٥", (850.5,)),
    ],
)
def test_a_number_means_what_was_written(text: str, values: tuple[float, ...]) -> None:
    assert possible_values(text) == values


@pytest.mark.parametrize(
    "text",
    [
        "", " ", "abc", "-", ".", ",", "1,2,3", "1.2.3", "12 34", "1,23,456", "1 234 56", "1.234,567.8", "1,,5", "10²",
        "½", "nan", "inf", "1e999", "1_000", "0x10", "1e", "--5", "1\n234", "95 °C", "1:30", "5 %", "\ud800",
    ],
)  # fmt: skip
def test_what_is_no_number_is_none(text: str) -> None:
    assert possible_values(text) == ()
    assert decimal_number(text) is None


@given(st.decimals(-10_000_000, 10_000_000, places=6), st.integers(0, 6), st.sampled_from(COUNTRIES))
def test_a_number_of_any_country_is_itself_or_doubted(number, places: int, country: tuple[str, str]) -> None:
    plain = f"{number:,.{places}f}"
    text = plain.translate({ord("."): country[0], ord(","): country[1]})
    value, values = float(plain.replace(",", "")), possible_values(text)
    assert value in values
    if len(values) == 2:
        assert abs(values[1]) == pytest.approx(abs(values[0]) * 1000.0, rel=1e-12, abs=0.0)


@given(st.decimals(-1_000_000, 10_000_000, places=3), st.sampled_from(COUNTRIES), st.sampled_from(ASKED))
def test_a_number_that_is_taken_is_never_another_one(number, country: tuple[str, str], asked) -> None:
    plain = f"{number:,f}"
    text = plain.translate({ord("."): country[0], ord(","): country[1]})
    value, entry = float(plain.replace(",", "")), read_number(text, asked)
    if not asked.limits[0] <= value <= asked.limits[1]:
        return  # what cannot be meant is not looked for
    assert entry.value in (value, None)
    assert entry.value is not None or "two ways" in entry.doubt


@given(st.text(max_size=12), st.sampled_from(ASKED))
def test_any_text_is_taken_or_doubted_in_words(text: str, asked) -> None:
    number = read_number(text, asked)
    assert number.value is not None or number.doubt.endswith(".")
    if number.value is not None:
        assert asked.limits[0] <= number.value <= asked.limits[1]


@given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from(ASKED))
def test_what_a_field_starts_with_is_read_back(value: float, asked) -> None:
    if asked.limits[0] <= value <= asked.limits[1]:
        assert read_number(written(value, asked), asked).value == value


@pytest.mark.parametrize(
    ("text", "asked", "value", "words"),
    [
        ("95,5", TEMPERATURE, 95.5, ""),
        ("95,5 °C", TEMPERATURE, 95.5, ""),
        ("92.715", TEMPERATURE, 92.715, ""),  # 92715 °C cannot be meant
        ("955", TEMPERATURE, None, "955 °C is not taken: the temperature must be from −60 to 200 °C."),
        ("160", TEMPERATURE, 160.0, "160 °C is taken, but unusual: the temperature is mostly from −30 to 150 °C."),
        ("203 °F", TEMPERATURE, None, "'203 °F' is not a number: write the temperature in °C, such as 95.5."),
        ("8505", ENGINE_SPEED, 8505.0, "8505 rpm is taken, but unusual"),
        (
            "1.250",
            ENGINE_SPEED,
            None,
            "two ways: write 1250 for 1250 rpm, or 1.25 for 1.25 rpm.",
        ),
        ("−5", ENGINE_SPEED, None, "−5 rpm is not taken"),
        ("123 456", MILEAGE, 123456.0, ""),
        ("123.456", MILEAGE, None, "write 123456 for 123456 km, or 123.4560 for 123.456 km."),
        ("123", MILEAGE, 123.0, "123 km is taken, but unusual: the mileage is mostly from 1000 to 1000000 km."),
        ("1e9", MILEAGE, None, "1e9 km is not taken"),
    ],
)
def test_an_entry_is_taken_or_doubted(text: str, asked, value: float | None, words: str) -> None:
    entry = read_number(text, asked)
    assert entry.value == value
    assert words in entry.doubt
    assert bool(words) == bool(entry.doubt)


@given(
    asked=st.sampled_from(ASKED),
    language=st.sampled_from(languages()),
    units=st.sampled_from(tuple(SYSTEMS)),
    part=st.floats(0.0, 1.0),
)
def test_what_a_field_shows_is_read_back_in_every_language_and_unit(
    asked: AskedNumber, language: str, units: str, part: float
) -> None:
    say = wording(language, units)
    shown = asked.to(say)
    value = shown.limits[0] + part * (shown.limits[1] - shown.limits[0])
    assert read_number(written(value, shown, say), shown).value == value


@pytest.mark.parametrize("language", languages())
def test_a_doubt_names_limits_and_unit_as_the_reader_has_them(language: str) -> None:
    say = wording(language, "us")
    doubt = say.sentence(read_number("900", TEMPERATURE.to(say)).doubt)
    assert "900 °F" in doubt
    assert "−76" in doubt
    assert "392 °F" in doubt


def test_a_doubt_has_the_decimal_sign_of_the_reader_s_language() -> None:
    say = wording("de")
    assert say.sentence(read_number("1.250", ENGINE_SPEED).doubt) == (
        "'1.250' lässt sich auf zwei Arten lesen: 1250 schreiben für 1250 rpm, oder 1,25 für 1,25 rpm."
    )
    assert say.sentence(read_number("x", TEMPERATURE).reason).endswith("Temperatur in °C schreiben, etwa 95,5")
    assert pickle.loads(pickle.dumps(read_number("x", MILEAGE))) == read_number("x", MILEAGE)
