"""Lands are named by the numbers that people use, and by their names where an id is a technical word."""

from __future__ import annotations

from atleak.catalogue.controller_file import load_controller
from atleak.common.wording import wording
from atleak.report.tables.names import component_words, land_number, land_words

GERMAN = wording("de")


def test_a_land_s_name_begins_with_its_number() -> None:
    four_speed = load_controller("four_speed_2023")
    assert land_words(four_speed, ("25", 1), GERMAN) == "25/1 Hauptdruckventil"
    assert land_number(four_speed, ("12'", 1), GERMAN) == "12'/1"
    assert component_words(four_speed, "25", GERMAN) == "25 Hauptdruckventil"
    assert land_words(four_speed, ("gone", 2), GERMAN) == "gone/2"


def test_an_id_in_technical_words_is_not_shown() -> None:
    gm = load_controller("gm_4l60e")
    assert land_words(gm, ("pressure_regulator", 1), GERMAN) == "Druckregelventil (216)/1"
    assert land_number(gm, ("pressure_regulator", 1), GERMAN) == "Druckregelventil (216)/1"
    assert component_words(gm, "accumulator_1_2", GERMAN) == "Speicher 1-2"
