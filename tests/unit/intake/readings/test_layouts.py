"""Sheets that a person reads without doubt are read as that person would, or asked about; none is read wrongly.

They stand in ``layouts.toml`` and ``wordings.toml``.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from atleak.catalogue.controller_reading import load_controller
from atleak.errors import ReadingsError
from atleak.intake.readings import read_readings


def _listed(name):
    return tomllib.loads(Path(__file__).with_name(f"{name}.toml").read_text(encoding="utf-8"))


TRUTHS = _listed("layouts")["truths"]


def examples():
    """Return every sheet in one of the forms that can hold it, turn by turn."""
    listed = [entry for name in ("layouts", "wordings") for entry in _listed(name)["example"]]
    params = []
    for number, entry in enumerate(listed):
        form = "workbook" if "merged" in entry or ("encoding" not in entry and number % 4 == 0) else "text"
        if form not in entry.get("forms", (form,)):
            form = entry["forms"][0]
        params.append(pytest.param(entry, form, id=f"{entry['name']}-{form}"))
    return params


def written(entry, form, filled_in):
    sheet = "\n".join(["Notes of the day"] * entry.get("above", 0) + [entry["sheet"].strip("\n")])
    if form == "text":
        return sheet.encode(entry.get("encoding", "utf-8"))
    return filled_in(sheet, form, entry.get("merged", ()))


def stations(readings):
    """Return the diameters in mm by component, plane, part and direction, repeats in their order."""
    found: dict[str, list[float]] = {}
    for one in sorted(readings.readings, key=lambda each: each.repeat):
        direction = "" if one.direction is None else f" {one.direction:g}"
        found.setdefault(f"{one.component}/{one.plane}/{one.part}{direction}", []).append(round(one.diameter * 1e3, 4))
    return found


def truth(entry):
    return {key: sizes for name in entry.get("truths", [entry.get("truth")]) for key, sizes in TRUTHS[name].items()}


@pytest.mark.parametrize(("entry", "form"), examples())
def test_a_sheet_that_a_person_understands_is_read_or_asked_about(example, filled_in, entry, form):
    controller = load_controller(entry["controller"]) if "controller" in entry else example
    options = {"fill_down": True} if entry.get("fill_down") else {}
    data = written(entry, form, filled_in)
    if "asked" in entry:
        with pytest.raises(ReadingsError) as caught:
            read_readings(data, controller, **options)
        assert entry["asked"] in str(caught.value)
        return
    readings = read_readings(data, controller, **options)
    assert stations(readings) == truth(entry)
    texts = " ".join(message.text for message in readings.messages)
    for word in entry.get("said", ()):
        assert word in texts
