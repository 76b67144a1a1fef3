"""What the page of questions says of the sample's unit and of the catalogue is so."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.units import KPA
from atleak.common.verdicts import Verdict
from atleak.diagnosis.examination import diagnose
from atleak.readers.logs import read_road_test
from tests.unit.docs.pages import text_of

TEXT = " ".join(text_of("docs/faq.md").split())


def test_a_wide_land_leaves_the_pressure_that_the_page_says(
    four_speed: Controller, hipol: Fluid, limits: Limits, readings_of: Callable
) -> None:
    sizes = {
        land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * land.new_clearance) for land in four_speed.lands
    }
    spool, _ = sizes["25", 1]
    sizes["25", 1] = spool, spool + 600e-6
    idle = diagnose(four_speed, hipol, limits, readings=readings_of(four_speed, sizes)).hot_idle
    assert idle is not None
    assert idle.share > 1.0
    held, required = idle.main_pressure_held * KPA, idle.condition.main_pressure * KPA
    assert f"a land of 300 µm on the sample's unit leaves {held:.0f} of {required:.0f} kPa" in TEXT


def test_a_log_with_two_fifths_of_the_pressure_is_critical(
    four_speed: Controller, hipol: Fluid, limits: Limits, sample_log: Path
) -> None:
    log = read_road_test(sample_log)
    pressure = log.channels["main_pressure"]
    low = replace(log, channels={**log.channels, "main_pressure": replace(pressure, values=0.4 * pressure.values)})
    assert diagnose(four_speed, hipol, limits, road_test=low).verdict is Verdict.CRITICAL
    assert "two fifths of the sample's pressures is *critical*" in TEXT
