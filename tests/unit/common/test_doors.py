"""At every door only the package's own errors come out, whatever a library raises on what it was given."""

from __future__ import annotations

import zlib
from pathlib import Path

import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.entries import Shelf, read_tables
from atleak.common.damage import DAMAGE, own_errors_only
from atleak.common.errors import CatalogueError, DomainError, InputError, ReadingsError, RoadTestError
from atleak.common.pictures import printable_picture
from atleak.common.sentences import Sentence
from atleak.equations.clearance import radial_clearance
from atleak.job.case import Case
from atleak.job.kinds import kind_of
from atleak.job.parts import JobFile, json_of
from atleak.job.zip_file import load_job, parse_job, read_job_file
from atleak.readers.controller_workbook import read_controller_workbook
from atleak.readers.gauges.gauge_study import read_study
from atleak.readers.gauges.gauge_table import read_pressure_table
from atleak.readers.gauges.vacuum_table import read_vacuum_table
from atleak.readers.gauges.value_table import read_flow_table
from atleak.readers.logs import log_columns, understand
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.readers.typed_sheet import typed_in

DOORS = (
    *(read_readings, read_pressure_table, read_vacuum_table, read_flow_table, read_study),
    *(understand, log_columns, read_controller_workbook),
    *(load_job, parse_job, read_job_file, JobFile.of, printable_picture, kind_of, typed_in),
    *(read_tables, Shelf.load, Shelf.checked),
)
ZIP = b"PK\5\6" + bytes(18)  # one without files


def fails(error: BaseException):
    @own_errors_only(ReadingsError, "name", "source")
    def read(source: Path | bytes, *, name: str | None = None) -> None:
        raise error

    return read


@pytest.mark.parametrize("kind", DAMAGE)
def test_what_a_library_raises_becomes_an_error_that_names_the_file(kind):
    error = UnicodeDecodeError("utf-8", b"\xff", 0, 1, "no") if kind is ValueError else kind("of \ud800 inside")
    with pytest.raises(ReadingsError) as refused:
        fails(error)(Path("folder") / "sheet.csv")
    assert refused.value.place.file == "sheet.csv"
    said = "memory" if kind is MemoryError else type(error).__name__
    assert said in str(refused.value).encode("utf-8").decode()
    assert refused.value.__cause__ is error


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (MemoryError(), "is too large for the memory of this computer"),
        (PermissionError(13, "Permission denied"), "cannot be read from the disk: Permission denied"),
        (OSError(22, "Invalid argument"), "is damaged or of a kind that cannot be read"),  # a library's seek
        (OSError("broken data stream"), "is damaged or of a kind that cannot be read"),
        (KeyError("part"), "is damaged or of a kind that cannot be read"),  # raised here, which is not atleak
        (RuntimeError("is encrypted, password required"), "is damaged or of a kind that cannot be read"),
    ],
)
def test_a_disk_and_a_full_memory_are_no_damage(error, said):
    with pytest.raises(ReadingsError, match=rf"^sheet\.csv: {said}"):
        fails(error)(Path("sheet.csv"))


def test_a_fault_of_atleak_s_own_is_called_so_with_its_place(monkeypatch):
    monkeypatch.setattr("atleak.job.zip_file.tomllib", None)
    fault = r"atleak could not make sense of it: AttributeError: .*, job/zip_file\.py:\d+: please send the file"
    expected = rf"^job\.toml: {fault}$"
    with pytest.raises(InputError, match=expected):
        parse_job(b"number = 7", "job.toml")
    monkeypatch.setattr("atleak.job.zip_file._entries", lambda *_: json_of(None, "a.json"))
    with pytest.raises(
        InputError, match=r"^job\.zip: atleak could not make sense of it: TypeError: .*, job/parts\.py:"
    ):
        read_job_file(ZIP, name="job.zip")


def test_the_name_that_a_file_was_given_comes_first():
    with pytest.raises(ReadingsError, match=r"^upload\.csv: is damaged .* \(error: Error -3\)$"):
        fails(zlib.error("Error -3"))(b"", name="upload.csv")


@pytest.mark.parametrize("error", [RoadTestError(Sentence("own")), KeyboardInterrupt()])
def test_the_package_s_own_errors_and_an_interruption_pass(error):
    with pytest.raises(type(error)) as passed:
        fails(error)(b"")
    assert passed.value is error


@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.__qualname__)
def test_every_door_is_guarded(door):
    """`own_errors_only` keeps what it stands at."""
    function = getattr(door, "__func__", door)
    assert function.__wrapped__.__qualname__ == function.__qualname__
    assert function.__code__.co_filename.endswith("damage.py")


def test_numbers_that_no_unit_has_are_refused_in_words(monkeypatch):
    def overflows(*_: object, **__: object) -> None:
        raise OverflowError("Python int too large to convert to C int")

    monkeypatch.setattr("atleak.job.case.diagnose", overflows)
    with pytest.raises(InputError, match=r"this job cannot be computed .OverflowError: Python int too large"):
        Case().diagnose()


@pytest.mark.parametrize(
    "text",
    ["x = " + "[" * 5000, "x = " + "9" * 5000, 'id = "x"\nname = "' + "a" * 99 + "\\ud800", "\0", "[" * 9999],
)
def test_a_catalogue_file_of_any_text_is_refused_as_such(tmp_path, text):
    path = tmp_path / "own.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(CatalogueError, match=r"^own\.toml"):
        load_controller(path)


def test_what_an_equation_refuses_is_the_package_s_own_error() -> None:
    with pytest.raises(DomainError, match=r"^sleeve diameter must be at least the spool's, found 0\.01 m$"):
        own_errors_only(ReadingsError)(radial_clearance)(0.01, 0.02)
