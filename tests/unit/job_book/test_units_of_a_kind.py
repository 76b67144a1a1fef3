"""All units of one valve body: distributions, what is flagged and replaced, and where one unit stands."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from atleak.analysis.rates import ENOUGH_UNITS, SHOWN_QUANTILES
from atleak.job.parts import JobParts
from atleak.job_book.book import Book
from atleak.job_book.unit_history import AcrossUnits, LandAcross, across_units, standing, unit_of_visit

MakeJob = Callable[..., JobParts]
UM = 1e-6
TCC = ("tcc_regulator", 1)
DONE = {"component": "tcc_regulator", "land": 1, "decision": "done"}


def unit(serial: object, year: int = 2026, **more: Any) -> dict[str, Any]:
    return {"transmission": {"serial": f"00 {serial}"}, "date": f"{year}-05-01", "number": f"{serial}-{year}", **more}


def of_tcc(across: AcrossUnits) -> LandAcross:
    return next(land for land in across.lands if land.key == TCC)


def test_of_each_unit_the_latest_measured_job_counts(book: Book, small_job: MakeJob) -> None:
    book.save(small_job(11.030, **unit("A", 2022)))
    book.save(small_job(11.040, **unit("A", 2024)))
    book.save(small_job(11.036, **unit("B", 2025)))
    book.save(small_job(11.060, **unit("sample")), sample=True)
    book.archive(book.save(small_job(11.070, **unit("B", 2026))).id)
    across = across_units(book, "minimal_example")
    assert across.units == 2
    assert [(round(c / UM, 1), count) for c, count in of_tcc(across).counted] == [(18.0, 1), (20.0, 1)]
    assert across_units(book, "four_speed_2023") == AcrossUnits("four_speed_2023", 0, (), ())


def test_what_is_flagged_and_replaced_is_counted_by_units(book: Book, small_job: MakeJob) -> None:
    book.save(small_job(11.052, **unit("A", 2022), repair_decisions=[DONE]))
    book.save(small_job(11.052, **unit("A", 2024), repair_decisions=[DONE]))
    book.save(small_job(11.052, **unit("B"), repair_decisions=[{**DONE, "land": None}]))
    book.save(small_job(11.033, **unit("C"), repair_decisions=[{**DONE, "decision": "declined"}]))
    across = across_units(book, "minimal_example")
    assert [(land.key, land.flagged, land.units) for land in across.flagged] == [(TCC, 2, 3)]
    replaced = {(pair.component, pair.land): pair.units for pair in across.replaced}
    assert replaced == {TCC: 1, ("tcc_regulator", None): 1}


def test_the_quantiles_are_those_of_the_clearances(book: Book, small_job: MakeJob) -> None:
    stream = random.Random(4)
    sleeves = [11.032 + 0.002 * stream.randrange(12) for _ in range(ENOUGH_UNITS + 1)]
    jobs = [book.save(small_job(sleeve, **unit(number))) for number, sleeve in enumerate(sleeves)]
    across = across_units(book, "minimal_example")
    land = of_tcc(across)
    clearances = np.array([round((sleeve - 11.0) / 2.0, 6) * 1e-3 for sleeve in sleeves])
    expected = np.quantile(clearances, SHOWN_QUANTILES, method="inverted_cdf")
    assert land.clearances == pytest.approx(expected, abs=1e-9)
    assert land.wear == pytest.approx(expected / 16e-6 - 1.0, abs=1e-4)
    # and this unit's place among the others
    [place] = standing(book, across, unit_of_visit(book, jobs[3].id))
    others = np.delete(clearances, 3)
    assert place.narrower == int((others < clearances[3] - 1e-9).sum())
    assert place.as_wide == int((abs(others - clearances[3]) < 1e-9).sum())
    assert place.others == ENOUGH_UNITS
    assert place.enough


def test_too_few_units_say_no_place(book: Book, small_job: MakeJob) -> None:
    saved = book.save(small_job(**unit("A")))
    [place] = standing(book, across_units(book, "minimal_example"), unit_of_visit(book, saved.id))
    assert (place.others, place.enough) == (0, False)
    assert np.isnan(place.part)
