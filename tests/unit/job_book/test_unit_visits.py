"""The jobs of a unit as visits: what each measured, what was repaired, declined and deferred."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable
from dataclasses import replace

import pytest

from atleak.analysis.history.wear import wear_over_mileage
from atleak.catalogue.controller import Controller
from atleak.catalogue.limits import Limits
from atleak.common.errors import ReadingsError
from atleak.job.case import Case, Reader
from atleak.job.parts import JobParts, job_parts
from atleak.job_book.book import Book
from atleak.job_book.unit_history import left_undone, unit_of_visit, visits_of_unit
from atleak.measurements.job_card import Job
from atleak.measurements.readings import Readings

MakeJob = Callable[..., JobParts]
TCC = ("tcc_regulator", 1)
UM = 1e-6


def record(year: int, mileage: float | None, *decisions: dict[str, object], serial: str = "0147") -> dict[str, object]:
    return {
        "number": str(year),
        "date": f"{year}-05-01",
        "vehicle": {"mileage_km": mileage},
        "transmission": {"serial": serial},
        "repair_decisions": list(decisions),
    }


def test_the_jobs_of_a_unit_are_its_visits_the_earliest_first(book: Book, small_job: MakeJob, limits: Limits) -> None:
    declined = {"component": "tcc_regulator", "land": 1, "decision": "declined", "reason": "too dear"}
    later = book.save(small_job(11.044, **record(2026, 160_000.0)))
    book.save(small_job(11.038, **record(2024, 100_000.0, declined)))
    book.save(small_job(11.050, **record(2025, 120_000.0, serial="0148")))
    archived = book.save(small_job(11.060, **record(2025, 130_000.0)))
    book.archive(archived.id)
    unit = unit_of_visit(book, later.id)
    assert unit is not None
    first, second = visits_of_unit(book, unit)
    assert (first.date, first.visit.mileage, first.visit.name) == (dt.date(2024, 5, 1), 100_000.0, "2024")
    assert [each.reason for each in first.decided("declined")] == ["too dear"]
    assert second.decided("declined") == ()
    land = wear_over_mileage([second.visit, first.visit], limits).land(TCC)
    assert land.line.rate * 1e4 / UM == pytest.approx(0.5, abs=1e-6)


def test_what_was_done_is_repaired_and_a_decision_without_a_land_is_about_all_of_its_component(
    book: Book, small_job: MakeJob
) -> None:
    done = (
        {"component": "pressure_regulator", "decision": "done"},
        {**dict(zip(("component", "land"), TCC, strict=True)), "decision": "done"},
    )
    saved = book.save(small_job(**record(2024, 100_000.0, *done, {"component": "accumulator", "decision": "proposed"})))
    [visited] = visits_of_unit(book, unit_of_visit(book, saved.id))
    assert visited.visit.repaired == {("pressure_regulator", 1), ("pressure_regulator", 2), TCC}


def test_a_repair_of_the_valve_bodys_file_is_about_those_lands_alone_that_it_changes(
    book: Book, with_repair: Callable[[Case], Case], small_job: MakeJob
) -> None:
    case = with_repair(small_job().case)
    declined = [{"component": "pressure_regulator", "land": land, "decision": "declined"} for land in (1, 2)]
    done = {"component": "pressure_regulator", "repair": "oversize", "decision": "done"}
    saved = book.save(job_parts(case.diagnose(), Job(**record(2024, 100_000.0, *declined, done)), case))
    visited = visits_of_unit(book, unit_of_visit(book, saved.id))
    assert visited[0].visit.repaired == {("pressure_regulator", 1)}
    assert [decision.land for _, decision in left_undone(visited)] == [2]


def test_a_land_that_was_only_cleaned_wears_on(
    book: Book, with_repair: Callable[[Case], Case], small_job: MakeJob, limits: Limits
) -> None:
    cleaned = {"component": "tcc_regulator", "repair": "clean", "decision": "done"}
    for sleeve, *stated in ((11.038, 2024, 100_000.0, cleaned), (11.044, 2026, 160_000.0)):
        case = with_repair(small_job(sleeve).case)
        saved = book.save(job_parts(case.diagnose(), Job(**record(*stated)), case))
    visited = visits_of_unit(book, unit_of_visit(book, saved.id))
    assert [each.visit.repaired for each in visited] == [frozenset(), frozenset()]
    land = wear_over_mileage([each.visit for each in visited], limits).land(TCC)
    assert land.line.rate * 1e4 / UM == pytest.approx(0.5, abs=1e-6)
    assert land.series.restart is None


def test_what_was_declined_or_deferred_stays_undone_until_it_is_done(book: Book, small_job: MakeJob) -> None:
    def decided(component: str, land: int | None, decision: str) -> dict[str, object]:
        return {"component": component, "land": land, "decision": decision, "reason": f"{decision} then"}

    book.save(
        small_job(
            **record(
                2022,
                1e5,
                decided("pressure_regulator", 1, "declined"),
                decided("pressure_regulator", 2, "deferred"),
                decided("tcc_regulator", 1, "declined"),
                decided("accumulator", 1, "proposed"),
            )
        )
    )
    again = decided("tcc_regulator", 1, "deferred"), decided("pressure_regulator", None, "done")
    last = book.save(small_job(**record(2024, 1.4e5, *again)))
    visited = visits_of_unit(book, unit_of_visit(book, last.id))
    assert [(each.visit.name, decision.component, decision.decision) for each, decision in left_undone(visited)] == [
        ("2024", "tcc_regulator", "deferred")
    ]
    before = [decision.land for _, decision in left_undone(visited[:1])]
    assert before == [1, 2, 1]  # the last one written down first
    approved = book.save(small_job(**record(2026, 1.6e5, decided("tcc_regulator", None, "approved"))))
    assert left_undone(visits_of_unit(book, unit_of_visit(book, approved.id))) == ()


def test_a_sheet_that_cannot_be_read_any_more_leaves_its_visit_without_lands(book: Book, small_job: MakeJob) -> None:
    saved = book.save(small_job(**record(2024, 100_000.0)))

    class Refusing(Reader):
        def readings(self, case: Case, controller: Controller) -> Readings:
            raise ReadingsError("no such column")

    [visited] = visits_of_unit(book, unit_of_visit(book, saved.id), Refusing())
    assert visited.visit.lands == ()
    assert "no such column" in visited.problem


def test_the_book_knows_no_unit_of_a_job_that_it_does_not_have(book: Book) -> None:
    assert unit_of_visit(book, "none") is None


def test_a_case_measures_what_it_diagnoses(small_job: MakeJob) -> None:
    case = replace(small_job().case, spool_instrument="micrometer", measuring_temperature=26.0)
    by_draws = {land.key: land for land in case.diagnose().uncertainty.lands}
    for land in case.measured():
        assert land.state == by_draws[land.key].sources.state
        assert land.sources == by_draws[land.key].sources.sources
    assert replace(case, readings=None).measured() == ()


def test_a_sheet_that_is_in_two_jobs_counts_as_one_measurement(book: Book, small_job: MakeJob) -> None:
    first = book.save(small_job(11.038, **record(2024, 100_000.0)))
    book.save(small_job(11.038, **record(2025, 100_000.0)))
    visited = visits_of_unit(book, book.load(first.id).unit)
    assert [bool(each.visit.lands) for each in visited] == [True, False]
    assert visited[1].problem == f"its measuring sheet is that of job {first.id}, and counts once"
