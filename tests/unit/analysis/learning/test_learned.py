"""Measuring sheets of new units, and of used ones with unworn ends, to a valve body's file."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from atleak.analysis.learning.learned_clearances import Learned, ToleranceFrom, _factor, learn
from atleak.analysis.learning.learned_words import learned_messages, summary, why_left_out, with_learned
from atleak.analysis.learning.outliers import WhyUnit, _one_sided_squares_tail
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import checked_controller, written_toml
from atleak.catalogue.controller_tables import NewOrigin
from atleak.catalogue.entries import read_tables
from atleak.catalogue.instruments import load_instruments
from atleak.common.errors import ReadingsError
from atleak.common.wording import wording
from atleak.measurements.readings import Readings
from atleak.report.tables.learned import learned_lands, learned_outliers, learned_record, learned_units

SheetOf = Callable[..., Readings]
NAME = "four_speed_2023"
DAY = dt.date(2026, 11, 21)


@pytest.fixture(scope="module")
def new_of(four_speed: Controller) -> dict[tuple[str, int], float]:
    """Mounting clearances of a made-up type, other than those of the file."""
    return {land.key: 15e-6 + 0.1e-6 * number for number, land in enumerate(four_speed.lands)}


@pytest.fixture(scope="module")
def sheets(four_speed: Controller, new_of: dict, sheet_of: SheetOf) -> list[Readings]:
    """Six new units."""
    random = np.random.default_rng(11)
    return [
        sheet_of(
            four_speed,
            {key: new + random.normal(0.0, 1e-6) for key, new in new_of.items()},
            random,
            f"unit_{number}.xlsx",
        )
        for number in range(6)
    ]


@pytest.fixture(scope="module")
def six(four_speed: Controller, sheets: list[Readings]) -> Learned:
    return learn(four_speed, sheets)


def of(learned: Learned, component: str, land: int):
    return next(each for each in learned.lands if each.land.key == (component, land))


def codes(learned: Learned) -> list[str]:
    return [message.code for message in learned_messages(learned)]


def test_clearances_of_all_lands_are_learned(six: Learned, new_of: dict) -> None:
    assert len(six.lands) == len(new_of)
    off = [abs(land.clearance - new_of[land.land.key]) for land in six.lands]
    assert np.mean([each <= land.uncertainty_by_units for each, land in zip(off, six.lands, strict=True)]) > 0.85
    assert six.spread == pytest.approx(1e-6, abs=0.15e-6)
    assert six.measurement == pytest.approx(0.55e-6, abs=0.1e-6)
    assert {land.units for land in six.lands} == {6}
    assert not codes(six)


def test_the_calibration_of_the_instruments_does_not_average_out(six: Learned) -> None:
    gauges = load_instruments()
    calibration = 0.5 * np.hypot(gauges.spool.calibration, gauges.sleeve.calibration)
    land = six.lands[0]
    assert land.calibration == pytest.approx(calibration, abs=1e-12)
    assert land.uncertainty == pytest.approx(np.hypot(land.uncertainty_by_units, 1.96 * calibration), abs=1e-9)
    assert land.tolerance > land.uncertainty
    assert "more units do not improve" in summary(six)


def test_the_file_says_what_was_learned_from_how_many_units_and_what_it_rests_on(six: Learned) -> None:
    data, _ = read_tables("controllers", NAME)
    before = written_toml(data)
    tables = with_learned(data, six, DAY)
    assert written_toml(data) == before
    again = checked_controller(tables)
    for land, learned in zip(again.lands, six.lands, strict=True):
        assert land.mounting_clearance == pytest.approx(learned.clearance, abs=0.006e-6)
        assert land.mounting_tolerance == pytest.approx(learned.tolerance, abs=0.006e-6)
        assert land.new_origin is NewOrigin.TYPE
        assert land.learned_from_units == 6
        assert "mounting_clearance_um" not in land.representative
    assert tables["note"].startswith(data["note"])
    assert "on 2026-11-21 from 6 measuring sheets (unit_0.xlsx, unit_1.xlsx" in tables["note"]
    assert written_toml(with_learned(data, six, DAY)) == written_toml(tables)
    assert again.gaps == checked_controller(data).gaps


def test_a_clearance_that_was_published_is_measured_once_it_is_learned(six: Learned) -> None:
    data, _ = read_tables("controllers", NAME)
    data["defaults"]["mounting_clearance_of_used_unit"] = True
    first, second = (component for component in data["components"] if component["id"] in ("5", "6"))
    first["lands"][0] |= {"published": ["nominal_diameter_mm", "mounting_clearance_um"]}
    second["lands"][0] |= {"measured": ["contact_length_mm", "mounting_clearance_um"]}
    tables = with_learned(data, six, DAY)
    lands = {component["id"]: component["lands"][0] for component in tables["components"] if component.get("lands")}
    assert lands["5"]["published"] == ["nominal_diameter_mm"]
    assert lands["5"]["measured"] == ["mounting_clearance_um"]
    assert lands["6"]["measured"] == ["contact_length_mm", "mounting_clearance_um"]
    assert {land.new_origin for land in checked_controller(tables).lands} == {NewOrigin.TYPE}


def test_a_worn_unit_is_left_out_and_named(four_speed: Controller, sheets: list, new_of: dict, sheet_of) -> None:
    random = np.random.default_rng(3)
    worn = dict(new_of)
    for key in list(new_of)[:6]:
        worn[key] += 11e-6
    learned = learn(four_speed, [*sheets, sheet_of(four_speed, worn, random, "worn.xlsx")])
    (unit,) = [unit for unit in learned.units if unit.left_out is not None]
    assert (unit.file, unit.left_out) == ("worn.xlsx", WhyUnit.WIDE_LANDS)
    named = {(pair.component, pair.land) for pair in learned.left_out if pair.wider}
    assert len(named) >= 4
    assert named <= set(list(new_of)[:6])
    assert {land.units for land in learned.lands} == {6}
    (said,) = [message for message in learned_messages(learned) if message.code == "unit_left_out"]
    assert "worn.xlsx is left out as a whole" in said.text
    assert why_left_out(unit, learned.left_out) in said.text
    assert learned_units(learned, wording("en")).frame().iloc[-1, -1].endswith("worn")
    assert learned_outliers(learned, wording("en")).frame().iloc[0, -1] > 5.0
    record = learned_record(learned)
    assert record["units"][-1]["left_out"] == "wide_lands"
    assert {pair["file"] for pair in record["outliers"]} == {"worn.xlsx"}
    note = with_learned(read_tables("controllers", NAME)[0], learned, DAY)["note"]
    assert note.endswith("without worn.xlsx.")


def test_one_pair_is_left_out_by_itself(four_speed: Controller, sheets: list, new_of: dict, sheet_of) -> None:
    random = np.random.default_rng(3)
    odd = {**new_of, ("8", 1): new_of["8", 1] + 20e-6, ("9", 1): new_of["9", 1] - 12e-6}
    learned = learn(four_speed, [*sheets, sheet_of(four_speed, odd, random, "odd.xlsx")])
    assert not [unit for unit in learned.units if unit.left_out is not None]
    assert [(pair.component, pair.wider) for pair in learned.left_out] == [("8", True), ("9", False)]
    assert (of(learned, "8", 1).units, of(learned, "7", 1).units) == (6, 7)
    texts = " ".join(message.text for message in learned_messages(learned))
    assert "8/1 is left out" in texts
    assert "tighter, which no wear does" in texts


def test_one_unit_says_what_one_unit_can_tell(four_speed: Controller, sheets: list, new_of: dict) -> None:
    learned = learn(four_speed, sheets[:1])
    land = learned.lands[0]
    assert land.spread is None
    assert land.tolerance_from is ToleranceFrom.PUBLISHED
    assert land.tolerance == pytest.approx(np.hypot(6.8e-6, land.uncertainty), abs=1e-12)
    (said,) = [message for message in learned_messages(learned) if message.code == "one_unit"]
    assert said.level == "warning"
    for words in ("6.4-20 µm radial", "choice of this project", "nothing tells whether it is worn"):
        assert words in said.text
    assert "is taken, not measured" in summary(learned)
    assert "Spread [µm]" not in learned_lands(learned, wording("en")).filled.headings


def test_one_unit_keeps_a_tolerance_that_the_file_states(four_speed: Controller, sheets: list, six: Learned) -> None:
    known = checked_controller(with_learned(read_tables("controllers", NAME)[0], six, DAY))
    learned = learn(known, sheets[:1])
    land = learned.lands[0]
    assert land.tolerance_from is ToleranceFrom.FILE
    apart = np.sqrt(2.0) * known.lands[0].mounting_tolerance
    assert land.tolerance == pytest.approx(np.hypot(apart, land.uncertainty), abs=1e-12)
    (said,) = [message for message in learned_messages(learned) if message.code == "known_from_more_units"]
    assert "from more units (6) than these (1)" in said.text
    assert "√2" in " ".join(message.text for message in learned_messages(learned))


def test_units_wider_than_the_file_has_new_ones_may_all_be_worn(four_speed: Controller, sheet_of: SheetOf) -> None:
    random = np.random.default_rng(5)
    new = {land.key: land.mounting_high for land in four_speed.lands}
    worn = {key: clearance + 8e-6 * (key == ("8", 1)) for key, clearance in new.items()}

    def said(clearances: dict) -> list:
        units = [sheet_of(four_speed, clearances, random, f"{number}.xlsx") for number in range(3)]
        return [
            message for message in learned_messages(learn(four_speed, units)) if message.code == "wider_than_new_so_far"
        ]

    assert said(new) == []
    (warned,) = said(worn)
    assert warned.level == "warning"
    assert f"1 of {len(new)} lands are wider" in warned.text
    assert "8/1" in warned.text


@pytest.mark.parametrize(
    ("count", "says"), [(2, "a worn unit cannot be named"), (3, "worn in all lands alike"), (4, "")]
)
def test_few_units_say_that_they_are_few(four_speed: Controller, sheets: list, count: int, says: str) -> None:
    learned = learn(four_speed, sheets[:count])
    (said,) = [message for message in learned_messages(learned) if message.code == "few_units"]
    assert says in said.text
    assert learned.lands[0].tolerance_from is ToleranceFrom.UNITS
    assert learned.lands[0].uncertainty_by_units > learn(four_speed, sheets).lands[0].uncertainty_by_units


def test_a_clearance_too_small_for_its_tolerance_is_written_as_a_range(four_speed: Controller, sheet_of) -> None:
    sheet = sheet_of(four_speed, {("8", 1): 5e-6}, np.random.default_rng(1), reading=0.0)
    tables = with_learned(read_tables("controllers", NAME)[0], learn(four_speed, [sheet]), DAY)
    land = checked_controller(tables).land("8", 1)
    assert land.new_origin is NewOrigin.RANGE
    assert land.mounting_range == pytest.approx((1e-6, 12.1e-6), abs=0.2e-6)


def test_lands_that_nobody_measured_keep_what_they_had(four_speed: Controller, new_of: dict, sheet_of) -> None:
    measured = {key: new for key, new in new_of.items() if key not in (("5", 1), ("26", 4))}
    random = np.random.default_rng(1)
    learned = learn(four_speed, [sheet_of(four_speed, measured, random, f"{number}.xlsx") for number in range(5)])
    assert [land.key for land in learned.unlearned] == [("5", 1), ("26", 4)]
    (said,) = [message.text for message in learned_messages(learned) if message.code == "lands_not_learned"]
    assert "5/1, 26/4" in said
    tables = with_learned(read_tables("controllers", NAME)[0], learned, DAY)
    again = checked_controller(tables)
    assert again.land("5", 1).mounting_clearance == four_speed.land("5", 1).mounting_clearance
    assert again.land("5", 1).learned_from_units is None


def test_of_a_used_unit_only_lands_with_unworn_ends_count(four_speed: Controller, sheets: list, sheet_of) -> None:
    random = np.random.default_rng(8)
    worn = sheet_of(four_speed, {("8", 1): 60e-6, ("9", 1): 70e-6}, random, "used.xlsx")
    ends = sheet_of(four_speed, {("8", 1): 17e-6}, random, "used.xlsx")
    used = replace(worn, unworn=tuple(each for each in ends.readings if each.part == "sleeve"))
    learned = learn(four_speed, [used])
    assert [land.land.key for land in learned.lands] == [("8", 1)]
    assert learned.lands[0].clearance == pytest.approx(17e-6, abs=1.5e-6)
    assert learned.lands[0].unworn_ends == 1
    assert learned.units[0].of_used_unit
    (said,) = [message.text for message in learned_messages(learned) if message.code == "rests_on_unworn_ends"]
    assert "beside the spool as it is" in said
    beside = learn(four_speed, [*sheets, used])
    assert (of(beside, "8", 1).units, of(beside, "8", 1).unworn_ends, of(beside, "9", 1).units) == (7, 1, 6)


def test_a_used_unit_whose_spool_was_not_measured_tells_nothing(four_speed: Controller, sheet_of) -> None:
    ends = sheet_of(four_speed, {("8", 1): 17e-6}, np.random.default_rng(8), "used.xlsx")
    bores = tuple(each for each in ends.readings if each.part == "sleeve")
    with pytest.raises(ReadingsError, match=r"used\.xlsx.*no land has readings of its spool and, marked"):
        learn(four_speed, [replace(ends, readings=(), unworn=bores)])


def test_sheets_that_cannot_be_used_are_named_all_at_once(four_speed: Controller, sheets: list) -> None:
    with pytest.raises(ReadingsError, match="no measuring sheet is given"):
        learn(four_speed, [])
    again = replace(sheets[0], file="copy.xlsx")
    saved = replace(sheets[1], file="saved_again.xlsx", sha256="other")
    with pytest.raises(ReadingsError) as refused:
        learn(four_speed, [*sheets, again, saved])
    assert r"copy.xlsx: the same file as unit_0.xlsx" in str(refused.value)
    assert r"saved_again.xlsx: a file with the same readings as unit_1.xlsx" in str(refused.value)
    spools = tuple(each for each in sheets[0].readings if each.part == "spool")
    empty = [replace(sheets[0], readings=spools, file=name, sha256=name) for name in ("a.csv", "b.csv")]
    empty[1] = replace(empty[1], readings=spools[:8])
    with pytest.raises(ReadingsError) as refused:
        learn(four_speed, [*sheets, *empty])
    assert all(f"{name}, sheet 'readings': no land has readings" in str(refused.value) for name in ("a.csv", "b.csv"))


def test_another_batch_among_the_units_is_said(four_speed: Controller, sheets: list, new_of: dict, sheet_of) -> None:
    random = np.random.default_rng(9)
    other = [
        sheet_of(four_speed, {key: new + 8e-6 + random.normal(0.0, 1e-6) for key, new in new_of.items()}, random, name)
        for name in ("x.xlsx", "y.xlsx", "z.xlsx", "v.xlsx")
    ]
    learned = learn(four_speed, [*sheets, *other])
    assert {unit.file for unit in learned.units if unit.left_out} == {"x.xlsx", "y.xlsx", "z.xlsx", "v.xlsx"}
    assert "many_units_left_out" in codes(learned)


@pytest.mark.parametrize(("degrees", "printed"), [(1, 12.71), (2, 4.30), (5, 2.57), (20, 2.09), (50, 2.01)])
def test_the_factors_of_the_guide_s_table_are_met(degrees: int, printed: float) -> None:
    """JCGM 100:2008, table G.2, 95 %."""
    assert _factor(degrees) == pytest.approx(printed, abs=0.005)


@pytest.mark.parametrize("number", [1, 7, 29])
def test_a_sum_of_one_sided_squares_is_past_a_value_as_often_as_draws_are(number: int) -> None:
    draws = np.square(np.maximum(np.random.default_rng(number).normal(size=(100_000, number)), 0.0)).sum(axis=1)
    for value in (0.5, 3.0, 12.0):
        tail = _one_sided_squares_tail(value, number)
        error = np.sqrt(tail * (1.0 - tail) / draws.size)
        assert np.mean(draws > value) == pytest.approx(tail, abs=4.0 * error + 1e-9)
