"""The first sentence names what decided, what was not measured and what is in doubt, in every language."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.translations import languages
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.measurements.readings import Readings
from atleak.report.tables.first_sentence import first_sentence, shown_verdict

Build = Callable[..., Readings]
EN = wording("en")


@pytest.fixture(scope="module")
def new_unit(minimal: Controller, hipol: Fluid, limits: Limits, readings_of: Build) -> Callable[..., Diagnosis]:
    """Diagnoses the minimal example as new, with changes to its readings."""
    sizes = {land.key: (land.nominal_diameter, land.nominal_sleeve_diameter) for land in minimal.lands}

    def build(change: Callable[[Readings], Readings] = lambda sheet: sheet, **without: bool) -> Diagnosis:
        kept = {key: size for key, size in sizes.items() if key[0] not in without}
        return diagnose(minimal, hipol, limits, readings=change(readings_of(minimal, kept)))

    return build


def test_a_unit_that_is_good_throughout_says_so(new_unit: Callable[..., Diagnosis]) -> None:
    good = new_unit()
    assert shown_verdict(good) == Verdict.OK
    assert first_sentence(good, EN).startswith("all 5 measured lands are within their limits; the unit leaks ")
    assert "● green" in first_sentence(good, EN)


def test_what_was_not_measured_is_named_and_nothing_is_green(new_unit: Callable[..., Diagnosis]) -> None:
    part = new_unit(accumulator=False)
    assert shown_verdict(part) == Verdict.NOT_MEASURED
    said = first_sentence(part, EN)
    assert "1 of 5 lands were not measured and count as new (accumulator piston/1)" in said
    assert "green" not in said
    assert "as far as it was measured" in said


def test_a_land_in_doubt_is_named_and_nothing_is_green(new_unit: Callable[..., Diagnosis]) -> None:
    def slip(sheet: Readings) -> Readings:
        last = sheet.readings[-1]
        again = replace(last, repeat=last.repeat + 1, diameter=last.diameter + 9e-6)
        return replace(sheet, readings=(*sheet.readings, again))

    doubtful = new_unit(slip)
    assert shown_verdict(doubtful) == Verdict.NOT_MEASURED
    assert "1 in doubt, to be measured again (accumulator piston/1)" in first_sentence(doubtful, EN)
    assert "green" not in first_sentence(doubtful, EN)


def test_nothing_measured_is_neither_good_nor_bad(minimal: Controller, hipol: Fluid, limits: Limits) -> None:
    nothing = diagnose(minimal, hipol, limits)
    assert shown_verdict(nothing) == Verdict.NOT_MEASURED
    said = first_sentence(nothing, EN)
    assert said.startswith("nothing was measured")
    assert "a new unit leaks " in said
    assert "green" not in said


def test_a_sheet_of_which_nothing_counts_is_not_called_unmeasured(
    minimal: Controller, hipol: Fluid, limits: Limits, new_unit: Callable[..., Diagnosis]
) -> None:
    sheet = new_unit().readings
    assert sheet is not None
    left_out = diagnose(minimal, hipol, limits, readings=replace(sheet, readings=()))
    said = first_sentence(left_out, EN)
    assert said.startswith("none of the readings in the job counts: all of them are doubtful and left out")
    assert shown_verdict(left_out) == Verdict.NOT_MEASURED


@pytest.mark.parametrize("language", languages())
def test_a_worn_unit_says_what_decided_and_by_which_limit(worn: Diagnosis, language: str) -> None:
    say = wording(language)
    said = first_sentence(worn, say)
    decided_by = worn.decided_by
    assert decided_by is not None
    component, land = decided_by.key  # type: ignore[union-attr]
    assert f"{component}/{land} {say.name(worn.controller.components[component])}" in said
    assert say.signed(worn.decided_by.verdict) in said  # type: ignore[union-attr]
    assert f"1 {'of' if language == 'en' else 'von' if language == 'de' else 'z'} 47" in said
    assert said.endswith(".")
    assert "{" not in said
