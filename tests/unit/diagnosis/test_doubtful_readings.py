"""Readings that contradict themselves are named, and never make a unit look better than it is."""

from __future__ import annotations

from dataclasses import replace

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.instruments import load_instruments
from atleak.catalogue.limits import Limits
from atleak.common.translations import languages
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.diagnosis.uncertainty.sources import find_sources
from atleak.measurements.clearances import clearances
from atleak.measurements.readings import Reading, Readings
from atleak.report.tables.names import land_number
from atleak.report.tables.sentences import readings_in_doubt

UM = 1e-6
SLIP = 59.5 * UM
CONTROLLERS = {name: load_controller(name) for name in ("minimal_example", "four_speed_2023", "five_speed_2005")}
every_controller = pytest.mark.parametrize("controller", CONTROLLERS.values(), ids=CONTROLLERS)


def first_worn(controller: Controller, *, times: float = 2.0, repeats: int = 2) -> Readings:
    """Every land as new but for the first that no ring seals, which is so many times as wide."""
    worn = next(land for land in controller.lands if land.seal is None)
    readings = []
    for land in controller.lands:
        wide = 2.0 * land.mounting_high * (times if land is worn else 1.0)
        for part, diameter in (("spool", land.nominal_diameter), ("sleeve", land.nominal_diameter + wide)):
            for direction in (0.0, 90.0):
                for repeat in range(1, repeats + 1):
                    place = land.component, part, land.planes[0], direction, repeat
                    readings.append(Reading(*place, round(diameter, 7)))  # type: ignore[arg-type]
    return Readings("sheet.csv", "0" * 64, None, "mm", False, "tidy", tuple(readings))


def with_slip(sheet: Readings, part: str, by: float) -> Readings:
    """The same sheet, with a slip in the last repeats of the worn land's part."""
    controller_first = next(each for each in sheet.readings if each.part == part)
    last = max(each.repeat for each in sheet.readings)
    same = (controller_first.component, part, controller_first.plane)
    return replace(
        sheet,
        readings=tuple(
            replace(each, diameter=each.diameter + by) if each.station[:3] == same and each.repeat == last else each
            for each in sheet.readings
        ),
    )


def diagnosed(controller: Controller, sheet: Readings | None, fluid: Fluid, limits: Limits) -> Diagnosis:
    return diagnose(controller, fluid, limits, readings=sheet)


@pytest.fixture(params=CONTROLLERS, scope="module")
def slipped(request: pytest.FixtureRequest, hipol: Fluid, limits: Limits) -> tuple[Diagnosis, Diagnosis]:
    """A unit with one worn land, and the same with a slip that makes that land look good when it is averaged."""
    controller = CONTROLLERS[request.param]
    sheet = first_worn(controller)
    return tuple(diagnosed(controller, each, hipol, limits) for each in (sheet, with_slip(sheet, "spool", SLIP)))  # type: ignore[return-value]


def test_a_repeat_that_is_far_off_hides_no_wear(slipped: tuple[Diagnosis, Diagnosis]) -> None:
    right, wrong = slipped
    assert right.flagged
    assert [(land.key, land.verdict) for land in wrong.flagged] == [(land.key, land.verdict) for land in right.flagged]
    for rule, same in zip(right.total_rules, wrong.total_rules, strict=True):
        assert same.value == pytest.approx(rule.value, rel=1e-12, abs=0.0)
    assert wrong.verdict == right.verdict


def test_the_land_with_such_repeats_is_in_doubt_and_the_unit_is_not_passed(
    slipped: tuple[Diagnosis, Diagnosis],
) -> None:
    right, wrong = slipped
    assert not right.in_doubt
    (doubtful,) = wrong.in_doubt
    assert {round(each.apart / UM, 6) for each in doubtful.state.doubts} == {59.5}
    assert not any(each.agreed for each in doubtful.state.doubts)
    assert not wrong.passed


@pytest.mark.parametrize("language", languages())
def test_every_report_names_the_lands_in_doubt(slipped: tuple[Diagnosis, Diagnosis], language: str) -> None:
    right, wrong = slipped
    named = land_number(wrong.controller, wrong.in_doubt[0].key, wording(language))
    assert readings_in_doubt(right, wording(language)) is None
    assert f"{named}:" in (readings_in_doubt(wrong, wording(language)) or "")


@every_controller
def test_a_slip_that_only_widens_a_good_pair_is_not_passed_either(
    controller: Controller, hipol: Fluid, limits: Limits
) -> None:
    new = diagnosed(controller, first_worn(controller, times=1.0), hipol, limits)
    slip = diagnosed(controller, with_slip(first_worn(controller, times=1.0), "spool", 8.0 * UM), hipol, limits)
    assert [land.key for land in slip.in_doubt] == [next(each.key for each in slip.lands if each.state.judged)]
    assert (new.passed, slip.passed) == (new.verdict == Verdict.OK, False)


@every_controller
def test_nothing_measured_is_never_passed(controller: Controller, hipol: Fluid, limits: Limits) -> None:
    nothing = diagnosed(controller, None, hipol, limits)
    assert not nothing.passed
    assert nothing.verdict == Verdict.NOT_MEASURED
    assert {nothing.band(each) for each in nothing.projections} == {None}
    assert len(nothing.unmeasured) == sum(land.seal is None for land in controller.lands)


def test_a_unit_of_which_one_land_was_not_measured_is_not_passed(
    minimal: Controller, hipol: Fluid, limits: Limits
) -> None:
    sheet = first_worn(minimal, times=1.0)
    without = replace(sheet, readings=tuple(each for each in sheet.readings if each.component != "accumulator"))
    diagnosis = diagnosed(minimal, without, hipol, limits)
    assert [land.key for land in diagnosis.unmeasured] == [("accumulator", 1)]
    assert not diagnosis.passed


def test_of_three_repeats_the_one_that_the_others_contradict_is_left_out(minimal: Controller) -> None:
    sheet = first_worn(minimal, repeats=3)
    right = clearances(sheet, minimal)[0]
    for by in (SLIP, -SLIP):
        slip = clearances(with_slip(sheet, "spool", by), minimal)[0]
        assert slip.radial_clearance == pytest.approx(right.radial_clearance, rel=1e-12, abs=0.0)
        assert all(each.agreed and len(each.counted) == 2 for each in slip.doubts)
        said = [message.text for message in slip.messages if message.code == "repeats_disagree"]
        assert said
        assert all(text.endswith("mm counts, on which most of them agree") for text in said)


@pytest.mark.parametrize(("part", "by"), [("spool", -SLIP), ("spool", SLIP), ("sleeve", -SLIP), ("sleeve", SLIP)])
def test_of_two_repeats_that_disagree_the_one_that_makes_the_pair_wider_counts(
    minimal: Controller, part: str, by: float
) -> None:
    sheet = first_worn(minimal, times=4.0)
    right = clearances(sheet, minimal)[0].radial_clearance
    widens = by < 0.0 if part == "spool" else by > 0.0
    slip = clearances(with_slip(sheet, part, by), minimal)[0].radial_clearance
    assert slip == pytest.approx(right + 0.5 * SLIP if widens else right, rel=1e-9, abs=0.0)


def test_how_far_a_slip_is_off_does_not_widen_the_spread_of_other_readings(minimal: Controller) -> None:
    sheet = first_worn(minimal, times=4.0)
    deviations = []
    for by in (8.0 * UM, SLIP):
        slip = with_slip(sheet, "spool", by)
        spreads = find_sources(clearances(slip, minimal), slip, minimal, load_instruments(), DEFAULTS)[1]
        deviations.append(spreads["spool"].standard_deviation)
    assert deviations[0] == pytest.approx(deviations[1], rel=1e-12, abs=0.0)
