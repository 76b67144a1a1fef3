"""Sheets of the book that show new pairs: of new units, and of what was repaired."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from atleak.analysis.learning.learned_clearances import learn
from atleak.catalogue.controller import Controller
from atleak.common.errors import BookError, InputError
from atleak.job.case import Case, SourceFile
from atleak.job.parts import JobParts, job_parts
from atleak.job_book.book import Book
from atleak.job_book.new_sheets import new_sheets, shared_instruments
from atleak.measurements.job_card import Job

MakeJob = Callable[..., JobParts]
TCC, PISTON = ("tcc_regulator", 1), ("accumulator", 1)
DONE = {"component": "tcc_regulator", "land": 1, "decision": "done"}


def told(serial: str, year: int, mileage: float | None, *decisions: dict[str, Any]) -> dict[str, Any]:
    return {
        "number": f"{serial}-{year}",
        "date": f"{year}-05-01",
        "vehicle": {"mileage_km": mileage},
        "transmission": {"serial": f"00 {serial}"},
        "repair_decisions": list(decisions),
    }


def of_two_lands(small_job: MakeJob, **record: Any) -> JobParts:
    """The small job with a worn land beside its one."""
    rows = [
        f"accumulator,{part},1,{at},{size}"
        for part, size in (("spool", "18.000"), ("sleeve", "18.090"))
        for at in (0, 90)
    ]
    content = small_job().case.readings.content.decode() + "\n" + "\n".join(rows)
    case = Case(readings=SourceFile("two.csv", content.encode()), controller="minimal_example")
    return job_parts(case.diagnose(), Job(**record), case)


def test_of_a_new_unit_every_land_counts_and_of_a_repaired_one_what_was_repaired(
    book: Book, small_job: MakeJob, minimal: Controller
) -> None:
    book.save(small_job(11.033, **told("new", 2024, 12.0)))
    book.save(small_job(11.031, **told("new", 2026, 90_000.0)))
    book.save(of_two_lands(small_job, **told("repaired", 2024, 120_000.0, DONE)))
    book.save(of_two_lands(small_job, **told("repaired", 2025, 120_004.0)))
    book.save(small_job(11.050, **told("worn", 2024, 120_000.0)))
    book.save(small_job(11.050, **told("unknown", 2024, None)))
    book.save(small_job(11.040, **told("late", 2024, 100_000.0, DONE)))
    book.save(small_job(11.035, **told("late", 2026, 140_000.0)))
    sheets = {sheet.name: sheet for sheet in new_sheets(book, "minimal_example")}
    assert set(sheets) == {"job new-2024", "job repaired-2025"}
    whole = sheets["job repaired-2025"].readings(minimal)
    assert {(each.component, each.plane) for each in whole.readings} == {("tcc_regulator", "1")}
    learned = learn(minimal, [sheet.readings(minimal) for sheet in sheets.values()])
    assert [(land.land.key, land.units) for land in learned.lands] == [(TCC, 2)]


def test_a_repair_of_a_whole_component_makes_all_of_its_lands_new(
    book: Book, small_job: MakeJob, minimal: Controller
) -> None:
    done = {**DONE, "land": None}, {**DONE, "component": "accumulator", "land": 1}
    book.save(of_two_lands(small_job, **told("A", 2024, 120_000.0, *done)))
    book.save(of_two_lands(small_job, **told("A", 2025, 120_004.0)))
    [sheet] = new_sheets(book, "minimal_example")
    keys = {minimal.land_of_plane(each.component, each.plane).key for each in sheet.readings(minimal).readings}
    assert keys == {TCC, PISTON}


def test_of_a_component_whose_repair_changes_one_land_only_that_land_is_new(
    book: Book, small_job: MakeJob, with_repair: Callable[[Case], Case], minimal: Controller
) -> None:
    rows = [
        f"pressure_regulator,{part},{land},{at},{size}"
        for land, sizes in ((1, ("15.000", "15.030")), (2, ("12.500", "12.530")))
        for part, size in zip(("spool", "sleeve"), sizes, strict=True)
        for at in (0, 90)
    ]
    content = "\n".join(["component,part,plane,direction,diameter [mm]", *rows])
    case = with_repair(replace(small_job().case, readings=SourceFile("two.csv", content.encode())))
    done = {"component": "pressure_regulator", "repair": "oversize", "decision": "done"}
    for record in (told("A", 2024, 120_000.0, done), told("A", 2025, 120_004.0)):
        book.save(job_parts(case.diagnose(), Job(**record), case))
    [sheet] = new_sheets(book, case.diagnose().controller.id)
    keys = {minimal.land_of_plane(each.component, each.plane).key for each in sheet.readings(minimal).readings}
    assert keys == {("pressure_regulator", 1)}


def test_a_pair_that_was_only_cleaned_is_no_new_one(
    book: Book, small_job: MakeJob, with_repair: Callable[[Case], Case], minimal: Controller
) -> None:
    case = with_repair(of_two_lands(small_job).case)
    cleaned = {"component": "tcc_regulator", "repair": "clean", "decision": "done"}
    for place, decisions in enumerate([(cleaned,), (cleaned, {**DONE, "component": "accumulator"})]):
        for record in (told(f"{place}", 2024, 120_000.0, *decisions), told(f"{place}", 2025, 120_004.0)):
            book.save(job_parts(case.diagnose(), Job(**record), case))
    [sheet] = new_sheets(book, "minimal_example")
    assert sheet.name == "job 1-2025"
    assert {each.component for each in sheet.readings(minimal).readings} == {"accumulator"}


def test_without_any_such_sheet_that_is_said(book: Book, small_job: MakeJob) -> None:
    book.save(small_job(**told("worn", 2024, 120_000.0)))
    with pytest.raises(BookError, match="no measuring sheet of a new or repaired minimal_example"):
        new_sheets(book, "minimal_example")


def test_sheets_of_different_instruments_are_asked_about(book: Book, small_job: MakeJob) -> None:
    book.save(small_job(**told("A", 2024, 0.0)))
    parts = small_job(11.041, **told("B", 2024, 0.0))
    assert shared_instruments(new_sheets(book, "minimal_example")).sleeve.id == "bore_gauge"
    case = replace(parts.case, sleeve_instrument="air_gauge")
    book.save(job_parts(case.diagnose(), parts.job, case))
    with pytest.raises(InputError, match="job B-2024 was measured with other instruments than job A-2024"):
        shared_instruments(new_sheets(book, "minimal_example"))
