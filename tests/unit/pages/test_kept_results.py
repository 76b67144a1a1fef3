"""Results stay with the sessions that look at them, however many others there are."""

from __future__ import annotations

import gc
import weakref
from dataclasses import replace

import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.job.case import SourceFile
from atleak.job.zip_file import read_job_file, write_job_file
from pages.shared.cases import PageCase, diagnosis_of
from tests.unit.conftest import first_of

OWN = PageCase(controller="minimal_example", mileage=90_000.0)


def test_a_result_that_somebody_looks_at_is_not_computed_again() -> None:
    shown = diagnosis_of(OWN)
    others = [diagnosis_of(PageCase(controller="minimal_example", temperature=60.0 + number)) for number in range(8)]
    assert diagnosis_of(OWN) is shown
    assert diagnosis_of(replace(OWN, mileage=95_000.0)).projections is shown.projections
    assert len({id(each) for each in (shown, *others)}) == 9


def test_a_result_that_nobody_looks_at_any_more_is_let_go() -> None:
    left = weakref.ref(diagnosis_of(OWN))
    for number in range(8):
        diagnosis_of(PageCase(controller="minimal_example", temperature=80.0 + number))
    gc.collect()
    assert left() is None


@pytest.mark.parametrize("unit", first_of(["minimal_example", "zf_6hp26", "five_speed_2005", "gm_4l60e"]))
@pytest.mark.parametrize("stated", [None, 90_000.0, 95_000.0], ids=["none", "that of the head", "another"])
def test_a_saved_job_is_let_go_whatever_mileage_its_sheet_states(unit: str, stated: float | None) -> None:
    land = load_controller(unit).lands[0]
    diameter, bore = land.nominal_diameter * 1e3, (land.nominal_diameter + 3.0 * land.mounting_high) * 1e3
    rows = ["Mileage;90000 km", "", "Component;Plane;Part;Diameter [mm]"]
    rows += [f"{land.component};{land.planes[0]};{part};{mm:.4f}" for part, mm in (("spool", diameter), ("bore", bore))]
    sheet = SourceFile("sheet.csv", "\n".join(rows).encode())
    case = PageCase(controller=unit, readings=sheet, mileage=stated)
    saved = read_job_file(write_job_file(diagnosis_of(case), case=case)).case
    assert saved.mileage == stated
    left = weakref.ref(diagnosis_of(replace(case, **vars(saved))))
    assert left().mileage == (stated or 90_000.0)
    for number in range(8):
        diagnosis_of(PageCase(controller="minimal_example", temperature=40.0 + number))
    gc.collect()
    assert left() is None
