"""From readings to the clearance of every land."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import pytest

from atleak.catalogue.instruments import Instruments, load_instruments
from atleak.common.errors import Place, ReadingsError
from atleak.measurements.clearances import LandClearance, clearances, independent_repeats
from atleak.measurements.readings import Reading, Readings

UM = 1e-6


@pytest.fixture(scope="module")
def controller(three_pairs):
    return three_pairs


def readings(*taken: Reading) -> Readings:
    return Readings("sheet.csv", "0" * 64, None, "mm", False, "tidy", taken)


def one(component: str, part: str, plane: str, direction: float | None, *diameters_mm: float) -> Iterable[Reading]:
    for repeat, diameter in enumerate(diameters_mm, start=1):
        yield Reading(component, part, plane, direction, repeat, diameter * 1e-3, Place("sheet.csv", row=repeat))


def codes(state: LandClearance) -> list[str]:
    return [message.code for message in state.messages]


def test_one_land_clearance_per_land_in_order(controller):
    assert [each.land.key for each in clearances(None, controller)] == [("6", 1), ("6", 2), ("8", 1), ("12'", 1)]


def test_without_readings_every_land_is_at_its_mounting_clearance(controller):
    for each in clearances(None, controller):
        assert (each.status, each.measured) == ("not_measured", False)
        assert each.radial_clearance == each.min_clearance == each.max_clearance == each.land.mounting_clearance
        assert each.spool_diameter == each.land.nominal_diameter
        assert each.sleeve_diameter == pytest.approx(
            each.land.nominal_diameter + 2 * each.land.mounting_clearance, rel=1e-9, abs=0.0
        )
        assert each.stations == ()
        assert each.messages == ()


def test_mean_over_repeats_then_directions_then_planes(controller):
    # unequal numbers of repeats and directions must not weigh
    spool = readings(
        *one("8", "spool", "1", 0.0, 9.990, 9.990, 9.993),  # 9.991
        *one("8", "spool", "1", 90.0, 9.999),  # plane 1: 9.995
        *one("8", "spool", "2", 0.0, 9.985),  # plane 2
        *one("8", "sleeve", "1", 0.0, 10.050),
        *one("8", "sleeve", "1", 90.0, 10.060),
        *one("8", "sleeve", "2", 0.0, 10.070),
    )
    state = clearances(spool, controller)[2]
    assert state.spool_diameter == pytest.approx(9.990e-3, rel=1e-12, abs=0.0)
    assert state.sleeve_diameter == pytest.approx((10.055e-3 + 10.070e-3) / 2, rel=1e-12, abs=0.0)
    assert state.radial_clearance == pytest.approx((10.0625e-3 - 9.990e-3) / 2, rel=1e-9, abs=0.0)
    assert (state.status, state.measured) == ("measured", True)
    assert (state.spool_readings, state.sleeve_readings) == (5, 3)
    assert (state.spool_repeats, state.sleeve_repeats) == (1, 1)


def test_ovality_taper_and_spread_of_repeats(controller):
    state = clearances(
        readings(
            *one("8", "spool", "1", 0.0, 9.990, 9.992),
            *one("8", "spool", "1", 90.0, 9.995, 9.996),
            *one("8", "spool", "2", 0.0, 9.980, 9.980),
            *one("8", "spool", "2", 90.0, 9.982, 9.983),
            *one("8", "sleeve", "1", 0.0, 10.050),
        ),
        controller,
    )[2]
    assert state.spool_ovality == pytest.approx(4.5 * UM, rel=1e-9, abs=0.0)  # plane 1: 9.9955 − 9.991
    assert state.spool_taper == pytest.approx(9.99325e-3 - 9.98125e-3, rel=1e-9, abs=0.0)
    assert state.spool_repeat_spread == pytest.approx(2 * UM, rel=1e-9, abs=0.0)
    assert (state.sleeve_ovality, state.sleeve_taper, state.sleeve_repeat_spread) == (None, None, None)


def test_worst_direction_and_the_range_over_directions(controller):
    state = clearances(
        readings(
            *one("6", "spool", "1", 0.0, 9.940),
            *one("6", "spool", "1", 90.0, 9.936),
            *one("6", "sleeve", "1", 0.0, 10.000),
            *one("6", "sleeve", "1", 90.0, 10.030),
        ),
        controller,
    )[0]
    assert state.min_clearance == pytest.approx(30 * UM, rel=1e-9, abs=0.0)
    assert state.max_clearance == pytest.approx(47 * UM, rel=1e-9, abs=0.0)
    assert state.radial_clearance == pytest.approx(38.5 * UM, rel=1e-9, abs=0.0)
    assert state.worst_direction == 90.0
    assert [(station.direction, station.plane) for station in state.stations] == [(0.0, "1"), (90.0, "1")]


def test_form_moments_average_directions_then_planes(controller):
    state = clearances(
        readings(
            *one("8", "spool", "1", None, 9.990),
            *one("8", "spool", "2", None, 9.990),
            *one("8", "sleeve", "1", 0.0, 10.020),  # clearances of 15, 15 and 30 µm: mean 20
            *one("8", "sleeve", "1", 60.0, 10.020),
            *one("8", "sleeve", "1", 120.0, 10.050),
            *one("8", "sleeve", "2", 0.0, 10.060, 10.062, 10.058),  # 35 and 45 µm: mean 40, repeats do not weigh
            *one("8", "sleeve", "2", 90.0, 10.080),
        ),
        controller,
    )[2]
    assert state.radial_clearance == pytest.approx(30 * UM, rel=1e-9, abs=0.0)
    m2, m3 = state.form_moments
    assert m2 == pytest.approx(((2 * 15**2 + 0) / 3 + (5**2 + 15**2) / 2) / 2 * UM**2, rel=1e-9, abs=0.0)
    assert m3 == pytest.approx(((-2 * 15**3 + 0) / 3 + (5**3 + 15**3) / 2) / 2 * UM**3, rel=1e-9, abs=0.0)
    cubes = ((2 * 15**3 + 30**3) / 3 + (35**3 + 45**3) / 2) / 2
    c = state.radial_clearance / UM
    assert c**3 + 3 * c * m2 / UM**2 + m3 / UM**3 == pytest.approx(cubes, rel=1e-9, abs=0.0)


def test_no_form_is_known_of_one_direction_of_a_part_that_was_not_measured_or_of_none(controller):
    one_direction = readings(
        *one("8", "spool", "1", 0.0, 9.990),
        *one("8", "sleeve", "1", 0.0, 10.020),
        *one("8", "sleeve", "2", 0.0, 10.060),
        *one("6", "sleeve", "1", 0.0, 10.000),
        *one("6", "sleeve", "1", 90.0, 10.020),
    )
    sleeve_only, missing, single, *_ = clearances(one_direction, controller)
    assert single.form_moments == missing.form_moments == (0.0, 0.0)
    assert sleeve_only.form_moments == pytest.approx((25 * UM**2, 0.0), rel=1e-9, abs=1e-30)


def test_a_spool_without_directions_meets_each_direction_of_the_sleeve(controller):
    state = clearances(
        readings(
            *one("6", "spool", "1", None, 9.940),
            *one("6", "sleeve", "1", 0.0, 10.000),
            *one("6", "sleeve", "1", 90.0, 10.020),
        ),
        controller,
    )[0]
    assert [station.spool_diameter for station in state.stations] == [9.940e-3, 9.940e-3]
    assert state.max_clearance == pytest.approx(40 * UM, rel=1e-9, abs=0.0)


def test_missing_sleeve_takes_its_nominal_diameter_and_says_so(controller):
    state = clearances(readings(*one("6", "spool", "1", 0.0, 9.935), *one("6", "spool", "1", 90.0, 9.935)), controller)[
        0
    ]
    assert (state.status, state.measured) == ("spool_only", True)
    assert state.sleeve_diameter == state.land.nominal_diameter + 2 * state.land.mounting_clearance
    assert state.radial_clearance == pytest.approx(27 * UM, rel=1e-9, abs=0.0)
    message = next(message for message in state.messages if message.code == "sleeve_missing")
    assert message.level == "warning"
    assert "9.989 mm" in message.text
    assert message.place.row == 1


def test_missing_spool_takes_its_nominal_diameter_and_says_so(controller):
    state = clearances(
        readings(*one("12'", "sleeve", "1", 0.0, 14.080), *one("12'", "sleeve", "1", 90.0, 14.080)), controller
    )[3]
    assert (state.status, state.spool_readings) == ("sleeve_only", 0)
    assert state.spool_diameter == state.land.nominal_diameter
    assert state.radial_clearance == pytest.approx(40 * UM, rel=1e-9, abs=0.0)
    message = next(message for message in state.messages if message.code == "spool_missing")
    assert "piston" in message.text


def test_one_direction_only_is_a_lower_bound(controller):
    state = clearances(
        readings(
            *one("6", "spool", "1", 0.0, 9.94), *one("6", "spool", "1", 90.0, 9.94), *one("6", "sleeve", "1", 0.0, 10.0)
        ),
        controller,
    )[0]
    messages = [message for message in state.messages if message.code == "one_direction"]
    assert len(messages) == 1
    assert "sleeve" in messages[0].text
    assert "lower bound" in messages[0].text


@pytest.mark.parametrize(("apart", "flagged"), [(0.005, False), (0.006, True)])
def test_repeats_that_disagree_are_flagged_with_their_values(controller, apart, flagged):
    state = clearances(
        readings(*one("6", "spool", "1", 0.0, 9.940, 9.940 + apart), *one("6", "sleeve", "1", 0.0, 10.0)), controller
    )[0]
    said = [message for message in state.messages if message.code == "repeats_disagree"]
    assert bool(said) is flagged
    if flagged:
        assert "9.94, 9.946 mm" in said[0].text
        assert said[0].place.file == "sheet.csv"


def test_mirrored_and_copied_coordinates_are_no_independent_repeats(controller):
    def coordinate(repeat: int, first: float, second: float) -> Reading:
        return Reading(
            "6", "spool", "1", 0.0, repeat, abs(first - second), Place("sheet.csv", row=repeat), (first, second)
        )

    mirrored = [coordinate(1, 0.089605, 0.079666), coordinate(2, 0.079666, 0.089605), coordinate(3, 0.089605, 0.079666)]
    assert independent_repeats(mirrored) == mirrored[:1]
    state = clearances(readings(*mirrored), controller)[0]
    assert (state.spool_readings, state.spool_repeats, state.spool_repeat_spread) == (3, 1, None)
    message = next(message for message in state.messages if message.code == "mirrored_repeats")
    assert message.level == "info"
    assert message.place.row == 2
    assert "2 of 3" in message.text

    real = [coordinate(1, 0.089605, 0.079666), coordinate(2, 0.079667, 0.089605)]
    state = clearances(readings(*real), controller)[0]
    assert (state.spool_repeats, codes(state).count("mirrored_repeats")) == (2, 0)
    assert state.spool_repeat_spread == pytest.approx(1 * UM, rel=1e-6, abs=0.0)


def test_equal_diameters_without_coordinates_are_independent(controller):
    state = clearances(readings(*one("6", "spool", "1", 0.0, 9.94, 9.94)), controller)[0]
    assert (state.spool_repeats, state.spool_repeat_spread) == (2, 0.0)


def test_large_ovality_and_far_from_nominal_are_flagged(controller):
    oval = clearances(readings(*one("6", "sleeve", "1", 0.0, 9.99), *one("6", "sleeve", "1", 90.0, 10.06)), controller)[
        0
    ]
    assert "large_ovality" in codes(oval)
    far = clearances(readings(*one("6", "spool", "1", 0.0, 9.3)), controller)[0]
    assert "far_from_nominal" in codes(far)
    assert "(assumed)" in next(m.text for m in far.messages if m.code == "far_from_nominal")


def test_a_direction_in_which_the_sleeve_is_smaller_is_negative_there_and_flagged(controller):
    state = clearances(
        readings(
            *one("6", "spool", "1", 0.0, 9.942),
            *one("6", "spool", "1", 90.0, 9.942),
            *one("6", "sleeve", "1", 0.0, 9.940),
            *one("6", "sleeve", "1", 90.0, 9.990),
        ),
        controller,
    )[0]
    assert state.min_clearance == pytest.approx(-1 * UM, rel=1e-9, abs=0.0)
    assert state.radial_clearance > 0
    assert "tight_direction" in codes(state)


def test_readings_of_a_plane_the_controller_lacks_are_left_out(controller):
    states = clearances(readings(*one("6", "spool", "9", 0.0, 9.94)), controller)
    assert all(not state.measured for state in states)


# --- the temperature of measuring


@pytest.fixture
def pair() -> Readings:
    return readings(
        *one("8", "spool", "1", 0.0, 9.990, 9.992),
        *one("8", "sleeve", "1", 0.0, 10.050),
        *one("8", "sleeve", "1", 90.0, 10.060),
    )


def test_diameters_are_corrected_by_the_different_expansion_of_part_and_gauge(controller, pair):
    tools = load_instruments()
    gauges = Instruments(replace(tools.spool, expansion=8e-6), replace(tools.sleeve, expansion=11.5e-6))
    read = clearances(pair, controller)[2]
    state = clearances(pair, controller, temperature_c=35.0, instruments=gauges)[2]
    body = state.land.body_expansion
    assert state.spool_diameter == pytest.approx(9.991e-3 * (1 - (body - 8e-6) * 15), rel=1e-12, abs=0.0)
    assert state.sleeve_diameter == pytest.approx(10.055e-3 * (1 - (body - 11.5e-6) * 15), rel=1e-12, abs=0.0)
    assert state.radial_clearance == pytest.approx(0.5 * (state.sleeve_diameter - state.spool_diameter), abs=1e-15)
    means = [station.radial_clearance for station in state.stations]
    assert (state.min_clearance, state.max_clearance) == (min(means), max(means))
    assert means[1] - means[0] == pytest.approx(5e-6, rel=1e-3, abs=0.0)
    assert state.worst_direction == read.worst_direction == 90.0


def test_the_shipped_gauges_expand_like_steel_unless_given(controller, pair):
    warm = clearances(pair, controller, temperature_c=35.0)
    assert warm == clearances(pair, controller, temperature_c=35.0, instruments=load_instruments())
    assert {load_instruments().of(part).expansion for part in ("spool", "sleeve")} == {11.5e-6}


def test_readings_and_what_is_said_of_them_stay_as_they_were_read(controller, pair):
    apart = readings(*one("8", "spool", "1", 0.0, 9.990, 9.998), *one("8", "sleeve", "1", 0.0, 10.050))
    before = [message.text for message in clearances(apart, controller)[2].messages]
    state = clearances(apart, controller, temperature_c=35.0)[2]
    assert [message.text for message in state.messages] == before
    assert "9.99, 9.998 mm" in " ".join(before)


def test_at_20_degrees_nothing_changes_and_what_was_not_measured_never_does(controller, pair):
    assert clearances(pair, controller, temperature_c=20.0) == clearances(pair, controller)
    only = replace(pair, readings=tuple(each for each in pair.readings if each.part == "sleeve"))
    state = clearances(only, controller, temperature_c=35.0)[2]
    assert state.spool_diameter == state.land.nominal_diameter
    assert clearances(pair, controller, temperature_c=35.0)[0] == clearances(pair, controller)[0]


def test_a_sleeve_that_the_correction_makes_smaller_than_its_spool_is_refused(controller):
    tight = readings(*one("8", "spool", "1", 0.0, 9.990), *one("8", "sleeve", "1", 0.0, 9.9905))
    tools = load_instruments()
    gauges = Instruments(replace(tools.spool, expansion=21.3e-6), tools.sleeve)
    with pytest.raises(ReadingsError) as caught:
        clearances(tight, controller, temperature_c=35.0, instruments=gauges)
    text = str(caught.value)
    assert text.startswith("sheet.csv, row 1: component 8 land 1: corrected from 35 to 20 °C the sleeve is smaller")
    assert "expected the temperature that gauge and parts had" in text


def test_the_jobs_temperature_goes_before_the_sheets(pair):
    stated = replace(pair, temperature=23.0)
    assert (pair.measured_at().value, pair.measured_at().origin) == (20.0, "assumed")
    assert (stated.measured_at().value, stated.measured_at().origin) == (23.0, "sheet")
    assert (stated.measured_at(35.0).value, stated.measured_at(35.0).origin) == (35.0, "job")
