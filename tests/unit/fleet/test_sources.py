"""Where the units of a fleet come from: files, folders, patterns and the job book; and opening one again."""

from __future__ import annotations

import errno
import os
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from atleak.common.errors import BookError, InputError
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.fleet.sources import FoundUnits, find_units, reopened
from atleak.fleet.units import FleetUnit
from atleak.job.case import Case, SourceFile
from atleak.job.parts import job_parts
from atleak.job.zip_file import write_job_file
from atleak.job_book.book import Book, open_book
from atleak.job_book.search import Query
from atleak.measurements.job_card import Job, Photo

Write = Callable[..., Path]


@pytest.fixture
def job_file(unmeasured: Diagnosis, tmp_path: Path) -> Write:
    """Writes a job file; its number is its name unless one is given."""

    def write(name: str, number: str = "") -> Path:
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(write_job_file(unmeasured, Job(number=number or Path(name).stem)))
        return path

    return write


def _told(found: FoundUnits) -> list[str]:
    return [str(message.text) for message in found.messages]


def _names(found: FoundUnits, folder: Path) -> list[tuple[str, str | None]]:
    return [(Path(unit.name).relative_to(folder).as_posix(), unit.group) for unit in found]


def test_a_folder_is_searched_through_and_its_sub_folders_are_groups(job_file: Write, tmp_path: Path) -> None:
    for name in ("b.zip", "a.ZIP", "north/1.zip", "north/late/2.zip", "south/3.zip", ".hidden/4.zip", "south/.5.zip"):
        job_file(f"jobs/{name}")
    (tmp_path / "jobs" / "notes.txt").write_text("nothing", encoding="utf-8")
    found = find_units([tmp_path / "jobs"])
    assert _names(found, tmp_path / "jobs") == [
        ("a.ZIP", None),
        ("b.zip", None),
        ("north/1.zip", "north"),
        ("north/late/2.zip", "north"),
        ("south/3.zip", "south"),
    ]
    assert len(found) == 5
    assert _told(found) == ["2 hidden files or folders are left out"]


@pytest.mark.skipif(os.name == "nt", reason="a link takes a privilege there")
def test_links_to_folders_are_told_and_not_followed(job_file: Write, tmp_path: Path) -> None:
    job_file("jobs/1.zip")
    (tmp_path / "jobs" / "round").symlink_to(tmp_path / "jobs")
    found = find_units([tmp_path / "jobs"])
    assert len(found) == 1
    assert _told(found) == ["1 links to folders are not followed"]


def test_of_several_folders_each_is_a_group(job_file: Write, tmp_path: Path) -> None:
    job_file("jobs/north/1.zip")
    job_file("jobs/south/2.zip")
    expected = [("1.zip", "north"), ("2.zip", "south")]
    for given in ([tmp_path / "jobs" / "north", tmp_path / "jobs" / "south"], [tmp_path / "jobs" / "*"]):
        assert [(Path(unit.name).name, unit.group) for unit in find_units(given)] == expected


def test_patterns_are_expanded_and_what_fits_but_is_no_job_is_told(job_file: Write, tmp_path: Path) -> None:
    job_file("jobs/1.zip")
    job_file("jobs/deep/down/2.zip")
    (tmp_path / "jobs" / "photo.png").write_bytes(b"\x89PNG")
    found = find_units([tmp_path / "jobs" / "**" / "*"])
    assert [name for name, _ in _names(found, tmp_path / "jobs")] == ["1.zip", "deep/down/2.zip"]
    assert _told(found) == ["left out, being neither a job file nor a table of units"]
    assert [name for name, _ in _names(find_units([tmp_path / "jobs" / "?.zip"]), tmp_path / "jobs")] == ["1.zip"]


def test_a_file_that_is_called_like_a_pattern_is_that_file(job_file: Write, tmp_path: Path) -> None:
    path = job_file("job [1].zip")
    assert [unit.name for unit in find_units([path])] == [str(path)]


def test_a_file_reached_in_two_ways_is_one_unit_and_the_same_content_is_evaluated_once(
    job_file: Write, tmp_path: Path
) -> None:
    first = job_file("jobs/1.zip")
    second = job_file("jobs/2.zip", number="1")  # the same to the last byte
    found = find_units([tmp_path / "jobs", first])
    assert len(found) == 2
    for _ in range(2):  # going through them again begins anew
        assert [unit.name for unit in found] == [str(first)]
        assert found.twice == [(str(second), str(first))]


def test_a_file_that_cannot_be_read_stops_no_other(job_file: Write, tmp_path: Path) -> None:
    paths = [job_file(f"jobs/{name}.zip") for name in ("1", "2", "3")]
    found = find_units([tmp_path / "jobs"])
    paths[0].unlink()
    paths[1].write_bytes(b"no job at all")
    gone, damaged, good = found
    with pytest.raises(InputError, match=r"1\.zip: cannot be read"):
        gone.opened()
    with pytest.raises(InputError, match=r"2\.zip: is no sound zip"):
        damaged.opened()
    assert good.opened()[1].number == "3"
    assert len({unit.input_sha256 for unit in (gone, damaged, good)}) == 3


def test_a_folder_that_may_not_be_read_is_told(
    job_file: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    job_file("jobs/1.zip")
    job_file("jobs/closed/2.zip")
    read = os.scandir

    def scandir(folder: str) -> Any:
        if Path(folder).name == "closed":
            raise PermissionError(errno.EACCES, "Permission denied", str(folder))
        return read(folder)

    monkeypatch.setattr(os, "scandir", scandir)
    found = find_units([tmp_path / "jobs"])
    assert len(found) == 1
    ((text, place),) = [(str(message.text), str(message.place)) for message in found.messages]
    assert text.startswith("cannot be read: ")
    assert place == str(tmp_path / "jobs" / "closed")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("gone.zip", "gone.zip: no such file or folder; expected job files"),
        ("none/*.zip", "*.zip: no file fits this pattern; expected job files"),
        ("empty", "no job is found; expected job files"),
        ("photo.png", "photo.png: is of another kind; expected a job file (.zip), or a table"),
        ("log.csv", "log.csv: no headings of a table of units are found"),
    ],
)
def test_what_names_no_unit_stops_before_anything_is_evaluated(tmp_path: Path, given: str, said: str) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "photo.png").write_bytes(b"\x89PNG")
    (tmp_path / "log.csv").write_text("time;pressure\n1;2\n", encoding="utf-8")
    with pytest.raises(InputError) as refused:
        find_units([tmp_path / given])
    assert said in str(refused.value)


def test_only_the_unit_in_hand_holds_its_bytes(tmp_path: Path) -> None:
    size, count = 1 << 20, 24
    for number in range(count):
        (tmp_path / f"{number:02}.zip").write_bytes(number.to_bytes(1, "big") * size)
    tracemalloc.start()
    try:
        found = find_units([tmp_path])
        sizes = [len(unit.job_file.content) for unit in found if unit.job_file is not None]
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert sizes == [size] * count
    assert peak < 6 * size  # of 24 MB in all


# --- the job book


@pytest.fixture
def book(own_home: Path) -> Book:
    return open_book()


def _stored(book: Book, unmeasured: Diagnosis, number: str, *, sample: bool = False) -> str:
    job = Job(number=number, photos=(Photo(file="a.png"),)).with_pictures({"a.png": b"\x89PNG\r\n"})
    return book.save(job_parts(unmeasured, job, Case()), sample=sample).id


def test_jobs_of_the_book_are_units_but_for_archived_ones_and_the_sample(book: Book, unmeasured: Diagnosis) -> None:
    ids = {number: _stored(book, unmeasured, number) for number in ("A-1", "A-2", "B-1", "B-2")}
    _stored(book, unmeasured, "shipped", sample=True)
    book.archive(ids["A-2"])
    found = find_units([], book=Query(limit=1))
    assert len(found) == 3
    assert sorted(unit.name for unit in found) == ["A-1", "B-1", "B-2"]
    (unit,) = find_units([], book=Query(text="A-"))
    assert unit.reference == f"book:{ids['A-1']}"
    case, job = unit.opened()
    assert (job.number, dict(job.pictures)) == ("A-1", {})
    assert case.diagnose().verdict == unmeasured.verdict
    assert reopened(unit.reference, input_sha256=unit.input_sha256) == (case, job)
    with pytest.raises(InputError, match="no job of the job book fits"):
        find_units([], book=Query(text="C-1"))


def test_a_job_that_is_gone_from_the_book_says_so(book: Book, unmeasured: Diagnosis) -> None:
    with pytest.raises(BookError, match="the job book has no such job"):
        reopened("book:0123456789abcdef")


# --- opened again


def _unit(found: FoundUnits) -> FleetUnit:
    (unit,) = found
    return unit


def test_a_unit_is_opened_again_by_its_reference(job_file: Write) -> None:
    path = job_file("1.zip")
    unit = _unit(find_units([path]))
    assert reopened(unit.reference, input_sha256=unit.input_sha256)[1].number == "1"
    job_file("1.zip", number="corrected")
    assert reopened(unit.reference)[1].number == "corrected"
    with pytest.raises(InputError, match=r"1\.zip has other content now than its result rests on; expected the run"):
        reopened(unit.reference, input_sha256=unit.input_sha256)
    path.unlink()
    with pytest.raises(InputError, match=r"1\.zip: what the result rests on is not there any more"):
        reopened(unit.reference, input_sha256=unit.input_sha256)
    with pytest.raises(InputError, match="is no reference of a unit"):
        reopened("1.zip")


def test_a_row_is_opened_again_wherever_it_stands_in_its_table_now(tmp_path: Path) -> None:
    for name in ("a", "b", "c"):
        (tmp_path / f"{name}.csv").write_text(name, encoding="utf-8")
    table = tmp_path / "fleet.csv"
    table.write_text("sheet,mileage,batch\na.csv,1000,1\nb.csv,2000,1\n", encoding="utf-8")
    first, second = find_units([table], defaults=Case(controller="five_speed_2005", gear=2))
    table.write_text("sheet,mileage,batch\nc.csv,3000,1\nb.csv,2000,1\na.csv,1500,1\n", encoding="utf-8")
    case, job = reopened(second.reference, choices=second.choices, input_sha256=second.input_sha256)
    assert case.readings == SourceFile("b.csv", b"b")
    assert (case.controller, case.gear, job.vehicle.mileage_km) == ("five_speed_2005", 2, 2000.0)
    with pytest.raises(InputError, match="row 4 has other content now"):
        reopened(first.reference, choices=first.choices, input_sha256=first.input_sha256)
    table.write_text("sheet\nc.csv\n", encoding="utf-8")
    with pytest.raises(InputError, match="the unit's row is not in the table any more"):
        reopened(first.reference, choices=first.choices)
    table.unlink()
    with pytest.raises(InputError, match=r"fleet\.csv: what the result rests on is not there any more"):
        reopened(first.reference, choices=first.choices)
