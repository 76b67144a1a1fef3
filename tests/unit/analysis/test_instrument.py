"""What a gauge study becomes as an instrument."""

from __future__ import annotations

import datetime as dt
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tomli_w

from atleak.analysis.gauge_study import GaugeStudy, analysed, instrument_tables
from atleak.catalogue.instruments import Instrument, load_instrument
from atleak.measurements.gauge_study import StudyReadings

UM = 1e-6


@pytest.fixture
def study() -> GaugeStudy:
    random = np.random.default_rng(4)
    values = 12.7e-3 + UM * (
        10.0 * random.standard_normal((10, 1, 1))
        + np.array([-2.0, 0.0, 2.0])[None, :, None]
        + random.standard_normal((10, 3, 3))
    )
    return analysed(StudyReadings(tuple("0123456789"), ("A", "B", "C"), values, "micrometer.xlsx"))


def taken(study: GaugeStudy, of: Instrument, folder: Path) -> Instrument:
    tables = instrument_tables(
        study, of, id="our_micrometer", name="Our micrometer", resolution=UM, date=dt.date(2026, 3, 4)
    )
    path = folder / "our_micrometer.toml"
    path.write_text(tomli_w.dumps(tables), encoding="utf-8")
    return load_instrument(path)


def test_the_instrument_has_the_studys_repeatability_and_reproducibility(study: GaugeStudy, tmp_path: Path) -> None:
    of = load_instrument("micrometer")
    own = taken(study, of, tmp_path)
    assert own.repeatability == pytest.approx(study.of("repeatability").deviation, abs=1e-9)
    beside = study.of("reproducibility").variance
    assert own.calibration == pytest.approx((of.calibration**2 + beside) ** 0.5, abs=1e-9)
    assert own.common == pytest.approx((of.common**2 + study.of("operator").variance) ** 0.5, abs=1e-9)


def test_the_source_names_study_date_and_file(study: GaugeStudy, tmp_path: Path) -> None:
    own = taken(study, load_instrument("micrometer"), tmp_path)
    assert own.source.startswith("gauge study of 2026-03-04, micrometer.xlsx: 10 parts, 3 operators, 3 readings each")
    assert own.date == "2026-03-04"
    assert "taken from Outside micrometer" in own.note


def test_what_the_study_measured_is_no_longer_representative(study: GaugeStudy, tmp_path: Path) -> None:
    own = taken(study, load_instrument("micrometer"), tmp_path)
    assert set(own.representative) == {"calibration_um", "common_part"}


def test_the_touch_of_people_does_not_drop_out_of_bore_minus_spool(study: GaugeStudy, tmp_path: Path) -> None:
    of = replace(load_instrument("workshop_microscope"), alike_inside_and_outside=True)
    assert not taken(study, of, tmp_path).alike_inside_and_outside


def test_an_instrument_without_any_calibration_keeps_its_common_part(tmp_path: Path) -> None:
    values = 12.7e-3 + UM * np.array([[[0.0, 1.0], [1.0, 0.0]], [[10.0, 11.0], [11.0, 10.0]]])
    alike = analysed(StudyReadings(("1", "2"), ("A", "B"), values, "study.xlsx"))
    assert alike.of("reproducibility").variance == 0.0
    of = replace(load_instrument("micrometer"), calibration=0.0)
    assert taken(alike, of, tmp_path).common_part == of.common_part
