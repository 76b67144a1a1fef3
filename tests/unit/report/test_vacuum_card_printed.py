"""The vacuum card, read back: the marks that an own balance of air gives, its empty columns, its stand."""

from __future__ import annotations

import math
import re

import pytest
from scipy.optimize import brentq

from atleak.catalogue.controller_file import load_controller
from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.diagnosis.vacuum_card import pass_marks
from atleak.job.case import Case, SourceFile
from atleak.measurements.job_card import Job, Vehicle
from atleak.measurements.vacuum import VacuumStand
from atleak.report.pdf.gauge_card import write_vacuum_card
from atleak.report.tables.vacuum import vacuum_card_tables
from tests.unit.report.read_back import is_archival, text_of

UNIT = "five_speed_2005"
INHG = 3386.389
STAND = b"supply,85,kPa\nambient,98,kPa\ncalibration,0.5 mm,60 kPa,0.8 mm\ncircuit,reading\n"


def vacuum_of(clearance: float, diameter: float, length: float, orifice: float, factor: float) -> float:
    """The reading [Pa] by the laminar gap and the nozzle alone, as the vacuum test's equations are stated."""
    ambient, supply, kelvin, r, k, mu = 101325.0, 101325.0 - 25 * INHG, 293.15, 287.0, 1.4, 1.81e-5

    def excess(pressure: float) -> float:
        gap = factor * math.pi * diameter * clearance**3 * (ambient**2 - pressure**2) / (24 * mu * r * kelvin * length)
        ratio = max(supply / pressure, 0.5283)
        nozzle = math.sqrt(2 * k / ((k - 1) * r * kelvin) * (ratio ** (2 / k) - ratio ** ((k + 1) / k)))
        return gap - DEFAULTS.discharge_coefficient * math.pi / 4 * orifice**2 * pressure * nozzle

    return ambient - float(brentq(excess, supply + 1e-6, ambient))


def test_marks_of_single_lands_are_those_of_a_balance_of_air() -> None:
    controller = load_controller(UNIT)
    marks = pass_marks(controller, by_land=True)
    assert [(each.lands[0].key) for each in marks] == [land.key for land in controller.lands if not land.seal]
    usual = 1.0 + 1.5 * DEFAULTS.tested_position**2 / 3.0
    for each in marks[:6]:
        (land,) = each.lands
        size = land.nominal_diameter, land.contact_length, each.orifice, usual
        assert each.new / INHG == pytest.approx(vacuum_of(land.widest_new, *size) / INHG, abs=0.6)
        assert each.mark / INHG == pytest.approx(vacuum_of(1.2 ** (1 / 3) * land.widest_new, *size) / INHG, abs=0.6)
        others = [vacuum_of(land.widest_new, *size[:2], o, usual) for o in (0.25e-3, 0.5e-3, 1e-3)]
        grown = [vacuum_of(1.2 ** (1 / 3) * land.widest_new, *size[:2], o, usual) for o in (0.25e-3, 0.5e-3, 1e-3)]
        apart = [new - mark for new, mark in zip(others, grown, strict=True)]
        assert each.orifice == (0.25e-3, 0.5e-3, 1e-3)[apart.index(max(apart))]


@pytest.mark.parametrize("language", languages())
def test_marks_stand_in_both_units_beside_room_for_what_is_read(language: str) -> None:
    say, diagnosis = wording(language), Case(controller=UNIT).diagnose()
    content = write_vacuum_card(diagnosis, language=language)
    text = text_of(content)
    assert is_archival(content)
    for name in ("card_worn", "card_repaired", "plugged"):
        assert say(f"columns.{name}") in text
    for by_land in (False, True):
        for mark in pass_marks(diagnosis.controller, by_land=by_land):
            inhg, kpa = (say.number(math.ceil(mark.mark / unit * 10) / 10, 1) for unit in (INHG, 1e3))
            assert f"≥ {inhg} ({kpa})" in text
    assert re.search(r"25[.,]0 in-Hg", text)
    assert "ATF" not in text


def test_a_reading_as_printed_passes_no_land_that_leaks_more() -> None:
    """Rounded to what a gauge shows, a pass stays a pass and a fail a fail."""
    say = wording("en")
    controller = load_controller(UNIT)
    for table in vacuum_card_tables(controller, VacuumStand(), DEFAULTS, say):
        keys = [column.key for column in table.columns]
        for mark in table.rows:
            cells = dict(zip(keys, table.texts(mark), strict=True))
            passes = float(cells["card_passes"].split()[1])
            fails = float(cells["card_fails"].split()[1])
            assert passes * INHG >= mark.mark > mark.doubtful >= fails * INHG
            assert passes - mark.mark / INHG < 0.1
            assert (cells["card_worn"], cells["card_repaired"]) == ("", "")


def test_what_the_gauge_cannot_tell_says_so() -> None:
    say, coarse = wording("en"), DEFAULTS.with_settings({"vacuum_gauge_in_hg": 3})
    tables = vacuum_card_tables(load_controller(UNIT), VacuumStand(), coarse, say)
    assert all("cannot be told" in table.texts(table.rows[0]) for table in tables)


def test_the_stand_of_a_table_counts_and_the_job_stands_at_the_head() -> None:
    diagnosis = Case(controller=UNIT, vacuum=SourceFile("stand.csv", STAND)).diagnose()
    job = Job(number="2026-0417", vehicle=Vehicle(vin="WVWZZZ1JZXW000001"))
    text = text_of(write_vacuum_card(diagnosis, job, units="us", paper="letter"))
    assert "2026-0417" in text
    assert "as calibrated or stated there" in text
    assert "25.1 in-Hg when closed, at 98.0 kPa" in text
    assert "0.031" in text, "0.8 mm in inches"
    mark = pass_marks(diagnosis.controller, diagnosis.vacuum_table.stand)[0]
    assert f"≥ {math.ceil(mark.mark / INHG * 10) / 10:.1f}" in text


def test_a_unit_without_circuits_has_a_row_for_each_component() -> None:
    text = text_of(write_vacuum_card(Case(controller="four_speed_2023").diagnose()))
    assert "All lands of a component" in text
    assert "around a circuit" not in text
