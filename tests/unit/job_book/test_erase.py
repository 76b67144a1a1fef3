"""What erasing leaves of a job: the measured values and the verdicts, and nothing of the person."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from atleak.common.errors import BookError, ChangedElsewhere, ErasedElsewhere
from atleak.job.case import Case, SourceFile
from atleak.job.parts import JobParts, job_parts
from atleak.job_book.book import Book, open_book, packed
from atleak.job_book.erasure import erase, jobs_of_customer, same_vehicle
from atleak.job_book.merges import merge
from atleak.job_book.search import Query
from atleak.job_book.tables import jobs, metadata, results, units
from atleak.measurements.job_card import Job

NAME, VIN, PLATE, SERIAL, NUMBER = "Zyxwvut", "WVWZZZ1JZXW000001", "ZZ-YX 123", "SER55512", "Q-7788"
OF_PERSON = (NAME, VIN, PLATE, "ZZYX123", SERIAL, NUMBER, "Q7788", "K-99120", "K99120", "48.137154", "bertha")
SHEET = f"""Measuring sheet;;;;
Vehicle;{NAME}, {VIN};;;
Temperature: 24 °C;;;;
component;part;plane;direction;diameter [mm];remark
tcc_regulator;spool;1;0;11,0004;{NAME} was here
tcc_regulator;spool;1;90;11,0001;
tcc_regulator;sleeve;1;0;11,0405;
tcc_regulator;sleeve;1;90;11,0402;
"""
LOG = f"# {NAME} {VIN}\ntime [s],rpm,line pressure [kPa],ATF temperature [°C],gear,latitude,driver\n" + "".join(
    f"{row / 10},{900 + 5 * row},{500 + row},{60 + row / 20},1,48.137154,{NAME}\n" for row in range(100)
)


@pytest.fixture(scope="module")
def parts() -> JobParts:
    """A job that names its customer wherever a job can."""
    case = Case(
        controller="minimal_example",
        readings=SourceFile(f"{NAME}.csv", SHEET.encode()),
        road_test=SourceFile(f"{VIN}.csv", LOG.encode()),
        remember=False,
    )
    record: dict[str, Any] = {
        "number": NUMBER,
        "date": "2026-02-03",
        "technician": "Bertha bertha",
        "customer": {"name": f"Hans {NAME}", "number": "K-99120", "address": f"{NAME} road"},
        "vehicle": {"vin": VIN, "registration": PLATE, "mileage_km": 120_000},
        "transmission": {"serial": SERIAL, "note": NAME},
        "complaint": f"{NAME} says it slips",
        "fault_codes": [f"P0741 {NAME}"],
        "repair_decisions": [
            {
                "component": "tcc_regulator",
                "land": 1,
                "work": f"as {NAME} wants",
                "decision": "declined",
                "reason": NAME,
            },
            {"component": NAME, "work": "wash"},
        ],
        "photos": [{"file": f"{NAME}.png", "caption": f"car of {NAME}"}],
        "notes": f"call {NAME}",
    }
    job = Job.model_validate(record).with_pictures({f"{NAME}.png": f"picture of {NAME}".encode()})
    return job_parts(case.diagnose(), job, case)


def everything(book: Book) -> str:
    """All that the tables hold, unpacked."""
    said = []
    with book.engine.connect() as connection:
        for table in metadata.sorted_tables:
            for row in connection.execute(sa.select(table)):
                for value in row:
                    said.append(str(value) if not isinstance(value, bytes) else unpacked(value))
    return "\n".join(said)


def unpacked(value: bytes) -> str:
    try:
        return zlib.decompress(value).decode("utf-8", "replace")
    except zlib.error:
        return value.decode("utf-8", "replace")  # a Parquet table


def test_nothing_of_the_person_is_left_and_the_verdict_stays(book: Book, parts: JobParts, tmp_path: Path) -> None:
    saved = book.save(parts)
    before = book.load(saved.id)
    assert all(text in everything(book) for text in (NAME, VIN, SERIAL, "latitude"))
    (done,) = erase(book, [saved.id])
    assert (done.lost, done.left_in) == ((), ())
    left = everything(book).casefold()
    assert [text for text in OF_PERSON if text.casefold() in left] == []
    for path in tmp_path.glob("*.sqlite*"):
        bytes_left = path.read_bytes().lower()
        assert [text for text in OF_PERSON if text.lower().encode() in bytes_left] == []
    after = book.load(saved.id)
    again = after.file.diagnose()
    assert str(again.verdict) == before.file.result["verdict"] == after.file.result["verdict"]
    assert [land.verdict for land in again.lands] == [land["verdict"] for land in before.file.result["lands"]]
    assert after.file.result["lands"][0]["radial_clearance_um"] == before.file.result["lands"][0]["radial_clearance_um"]
    assert again.measured_at is not None
    assert again.measured_at.value == pytest.approx(24.0, abs=0.0)
    assert again.log is not None
    assert again.log.road_test.rows == 100
    record = after.file.job
    assert (str(record.date), record.vehicle.mileage_km) == ("2026-02-03", 120_000.0)
    assert [(each.component, each.work, each.decision) for each in record.repair_decisions] == [
        ("tcc_regulator", "", "declined")
    ]
    assert "erased" in record.notes


def test_results_of_earlier_versions_lose_their_words_and_keep_their_numbers(book: Book, parts: JobParts) -> None:
    id = book.save(parts).id
    earlier = {
        "verdict": "critical",
        "readings": {"file": f"{NAME}.csv", "sha256": "ab"},
        "lands": [{"component": "tcc_regulator", "wear_percent": 12.345678901234, "verdict": "watch"}],
        "messages": [{"level": "info", "code": "x", "text": f"of {NAME}"}],
    }
    with book.writing() as connection:
        row = dict(connection.execute(sa.select(results)).one()._mapping)
        values = {"atleak": "0.1.0", "record": packed(json.dumps(earlier).encode()), "verdict": "critical"}
        values["made_at"] = row["made_at"].replace(year=2020)
        del row["id"]
        connection.execute(results.insert().values({**row, **values}))
    erase(book, [id])
    with book.reading() as connection:
        kept = connection.execute(sa.select(results).order_by(results.c.made_at)).first()
    assert kept is not None
    record = json.loads(book.unpacked(kept.record, ""))
    assert (kept.atleak, kept.verdict, record["verdict"]) == ("0.1.0", "critical", "critical")
    assert record["lands"] == [{"component": "tcc_regulator", "wear_percent": 12.345678901234, "verdict": "watch"}]
    assert record["readings"] == {"file": None, "sha256": None}
    assert record["messages"] == []


@pytest.mark.parametrize("database", ["sqlite"], indirect=True)
def test_a_sheet_that_cannot_be_read_any_more_goes_and_the_stored_numbers_stay(
    book: Book, small_job: Callable[..., JobParts], monkeypatch: pytest.MonkeyPatch
) -> None:
    id = book.save(small_job(customer={"name": NAME})).id
    stored = book.load(id).file.result
    monkeypatch.setattr("atleak.job_book.erasure.plain_sheet", lambda readings, controller: None)
    (done,) = erase(book, [id])
    assert done.lost == ("measuring sheet",)
    after = book.load(id)
    assert after.file.case.readings is None
    assert "measuring sheet" in after.file.job.notes
    assert after.file.result["lands"][0]["wear_percent"] == stored["lands"][0]["wear_percent"]
    assert book.rows()[0].verdict == stored["verdict"]
    with book.reading() as connection:
        assert connection.execute(sa.text("select count(*) from lands where wear_percent is not null")).scalar()


def test_jobs_of_one_transmission_stay_together_without_its_name(
    book: Book, small_job: Callable[..., JobParts]
) -> None:
    mine = [book.save(small_job(customer={"name": NAME}, vehicle={"vin": VIN}, number=n)).id for n in ("1", "2")]
    next_owner = book.save(small_job(customer={"name": "Next Owner"}, vehicle={"vin": VIN}, number="3")).id
    assert [row.id for row in same_vehicle(book, mine)] == [next_owner]
    erase(book, mine)
    unit = {row.id: row.unit for row in book.rows()}
    assert unit[mine[0]] == unit[mine[1]] != unit[next_owner]
    assert [row.vin for row in book.rows(Query(vin=VIN))] == [VIN]
    erase(book, [next_owner])
    with book.reading() as connection:
        assert VIN not in str(connection.execute(sa.select(units)).all())


def test_what_a_job_shared_with_others_goes_with_it(book: Book, small_job: Callable[..., JobParts]) -> None:
    """A plate that only the erased job stated, of a car that another job states too."""
    book.save(small_job(vehicle={"vin": VIN}, number="7"))
    mine = book.save(small_job(vehicle={"vin": VIN, "registration": PLATE}, number="7")).id
    erase(book, [mine])
    assert PLATE not in everything(book)


@pytest.mark.parametrize("database", ["sqlite"], indirect=True)
def test_a_customer_is_told_by_the_whole_name_or_number(book: Book, small_job: Callable[..., JobParts]) -> None:
    mine = book.save(small_job(customer={"name": "Ana Lima", "number": "K-7"})).id
    book.save(small_job(customer={"name": "Ana Limarez", "number": "K-71"}))
    archived = book.save(small_job(customer={"name": "ana lima"}, number="old")).id
    book.archive(archived)
    assert {row.id for row in jobs_of_customer(book, "ANA LIMA")} == {mine, archived}
    assert [row.id for row in jobs_of_customer(book, "k7")] == [mine]
    assert jobs_of_customer(book, "Ana") == jobs_of_customer(book, " ") == []


@pytest.mark.parametrize("database", ["sqlite"], indirect=True)
def test_a_catalogue_file_that_names_the_person_is_pointed_out(
    book: Book, parts: JobParts, edited: Callable[..., Path]
) -> None:
    own = edited("controllers", "minimal_example", ("source = ", f"# of {NAME}\nsource = "))
    case = Case(controller=SourceFile("own.toml", own.read_bytes()), readings=parts.case.readings)
    job = Job.model_validate({"customer": {"name": NAME}})
    id = book.save(job_parts(case.diagnose(), job, case)).id
    (done,) = erase(book, [id])
    assert done.left_in == ("own.toml",)


@pytest.mark.parametrize("database", ["sqlite"], indirect=True)
def test_one_job_that_is_not_there_erases_none(book: Book, small_job: Callable[..., JobParts]) -> None:
    id = book.save(small_job(customer={"name": NAME})).id
    with pytest.raises(BookError, match="no such job"):
        erase(book, [id, "nothing"])
    assert book.load(id).file.job.customer.name == NAME


def test_somebody_else_who_has_the_book_open_is_told_of(
    tmp_path: Path, small_job: Callable[..., JobParts], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("atleak.job_book.erasure._PATIENCE", 20)
    book, other = (open_book(f"sqlite:///{tmp_path / 'book.sqlite'}") for _ in range(2))
    id = book.save(small_job(customer={"name": NAME})).id
    with other.reading() as connection:
        connection.execute(sa.select(results.c.id)).all()
        with pytest.raises(BookError, match="another program has the job book open"):
            erase(book, [id])
    assert book.load(id).file.job.customer.name == ""
    erase(book, [id])  # sweeps
    assert all(NAME.encode() not in path.read_bytes() for path in tmp_path.glob("book.sqlite*"))
    book.engine.dispose()
    other.engine.dispose()


@pytest.mark.parametrize("database", ["sqlite"], indirect=True)
def test_a_merged_unit_is_left_with_neither_of_its_names(book: Book, small_job: Callable[..., JobParts]) -> None:
    ids = [book.save(small_job(customer={"name": NAME}, vehicle={"vin": vin})).id for vin in (VIN, SERIAL)]
    merge(book, *(row.unit for row in reversed(book.rows())))
    erase(book, ids[:1])
    with book.reading() as connection:
        assert VIN not in str(connection.execute(sa.select(units)).all())
    assert [row.id for row in book.rows(Query(vin=SERIAL))] == ids[1:]
    erase(book, ids[1:])
    with book.reading() as connection:
        assert len(connection.execute(sa.select(units)).all()) == 2
        assert SERIAL not in str(connection.execute(sa.select(units)).all())


def test_a_job_that_cannot_be_opened_any_more_is_deleted_where_that_is_asked(
    book: Book, small_job: Callable[..., JobParts]
) -> None:
    whole, torn = (book.save(small_job(customer={"name": NAME}, number=number)).id for number in ("1", "2"))
    with book.writing() as connection:
        connection.execute(jobs.update().where(jobs.c.id == torn).values(choices=b"torn"))
    with pytest.raises(BookError, match="nothing was erased") as refused:
        erase(book, [whole, torn])
    assert "job 2 was damaged" in str(refused.value)
    assert book.load(whole).file.job.customer.name == NAME
    assert [(done.id, done.deleted) for done in erase(book, [whole, torn], delete=True)] == [
        (whole, False),
        (torn, True),
    ]
    assert [row.id for row in book.rows(Query(archived=None))] == [whole]
    assert NAME not in everything(book)


def test_what_was_opened_before_the_customer_was_erased_is_refused_and_what_was_opened_since_is_saved(
    book: Book, small_job: Callable[..., JobParts]
) -> None:
    first = book.save(small_job(number=NUMBER))
    book.refuse_erased(first.id, first.version)
    erase(book, [first.id])
    for refused in (
        lambda: book.refuse_erased(first.id, first.version),
        lambda: book.save(small_job(number=NUMBER), id=first.id, version=first.version),
    ):
        with pytest.raises(ErasedElsewhere, match="the customer was erased from this job after it was opened here"):
            refused()
    now = book.version(first.id)
    book.refuse_erased(first.id, now)
    book.refuse_erased("of no job", 1)
    later = book.save(small_job(technician="bench"), id=first.id, version=now)
    with pytest.raises(ChangedElsewhere, match="saved elsewhere by bench") as changed:
        book.save(small_job(), id=first.id, version=now)
    assert not isinstance(changed.value, ErasedElsewhere)
    assert book.version(first.id) == later.version


def test_erasing_reaches_what_an_update_kept_of_the_book(
    new_book_on: Callable[[str], Book], small_job: Callable[..., JobParts]
) -> None:
    book = new_book_on("sqlite")
    path = Path(str(book.engine.url.database))
    before, other = path.with_name(f"{path.name}.before-0003"), path.with_name("other.before-0003")
    for each in (before, other):
        each.write_bytes(NAME.encode())
    erase(book, [book.save(small_job(customer={"name": NAME})).id])
    assert not before.exists()
    assert other.exists()
