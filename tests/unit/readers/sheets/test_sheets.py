"""Sheets as workshops, metrology rooms and students write them: what is read of each, and which words are said.

They stand in ``columns.toml`` and ``tables.toml``. Every one is tried as text and as a workbook.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from atleak.common.errors import ReadingsError
from atleak.readers.sheets.measuring_sheet import read_readings


def examples(outcome):
    """Return the sheets with that outcome, "reads" or "refused", in each form that can hold them."""
    params = []
    for name in ("columns", "tables"):
        listed = tomllib.loads(Path(__file__).with_name(f"{name}.toml").read_text(encoding="utf-8"))["example"]
        for entry in listed:
            if outcome in entry:
                for form in ("text", "workbook") if "sheet" in entry else ("workbook",):
                    params.append(pytest.param(entry, form, id=f"{entry['name']}-{form}"))
    return params


def sizes(readings):
    """Return the diameters in mm by component, plane and part, in the order of the sheet."""
    by_part: dict[str, list[float]] = {}
    for one in readings.readings:
        by_part.setdefault(f"{one.component}/{one.plane}/{one.part}", []).append(round(one.diameter * 1e3, 4))
    return by_part


@pytest.mark.parametrize(("entry", "form"), examples("reads"))
def test_the_measurement_is_read_and_what_is_left_aside_is_named(example, filled_in, entry, form):
    readings = read_readings(filled_in(entry.get("sheet") or entry["sheets"], form), example)
    assert sizes(readings) == entry["reads"]
    texts = " ".join(message.text for message in readings.messages)
    for word in entry.get("said", ()):
        assert word in texts


@pytest.mark.parametrize(("entry", "form"), examples("refused"))
def test_what_cannot_be_told_is_refused_with_its_names(example, filled_in, entry, form):
    with pytest.raises(ReadingsError) as caught:
        read_readings(filled_in(entry.get("sheet") or entry["sheets"], form), example)
    assert entry["refused"] in str(caught.value)
    assert caught.value.expected
    assert caught.value.place.file == "readings"
