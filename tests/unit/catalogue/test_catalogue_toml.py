"""A controller's tables written as TOML say what they said, and the same tables give the same text."""

from __future__ import annotations

import tomllib
from dataclasses import replace

import pytest

from atleak.catalogue.controller_file import checked_controller, load_controller, written_toml
from atleak.catalogue.entries import catalogue_files, read_tables

every_controller = pytest.mark.parametrize("name", list(catalogue_files("controllers")))


@every_controller
def test_what_is_written_reads_back_as_the_same_controller(name: str) -> None:
    tables, origin = read_tables("controllers", name)
    text = written_toml(tables)
    assert tomllib.loads(text) == tables
    assert written_toml(tomllib.loads(text)) == text
    assert replace(checked_controller(tomllib.loads(text)), origin=origin) == load_controller(name)


def test_keys_come_in_the_order_of_the_description_whatever_the_order_of_the_tables() -> None:
    tables, _ = read_tables("controllers", "five_speed_2005")
    turned = {key: tables[key] for key in reversed(tables)}
    turned["pump"] = {key: tables["pump"][key] for key in reversed(tables["pump"])}
    assert written_toml(turned) == written_toml(tables)
    assert written_toml(turned).startswith('id = "five_speed_2005"')


def test_what_is_none_is_left_out_and_unknown_keys_are_kept() -> None:
    text = written_toml({"id": "x", "note": None, "pump": {"displacement_mm3": 1.5, "colour": "red"}})
    assert tomllib.loads(text) == {"id": "x", "pump": {"displacement_mm3": 1.5, "colour": "red"}}
