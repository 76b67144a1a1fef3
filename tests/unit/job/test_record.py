"""The job record: what it takes, what it refuses, and how it is read from a file."""

from __future__ import annotations

import datetime as dt
import json

import pytest
from pydantic import ValidationError

from atleak.common.errors import InputError
from atleak.job.zip_file import load_job, parse_job
from atleak.measurements.job_card import Job, Photo

TOML = """
number = 417
date = 2026-03-14
complaint = "flares from second to third"
fault_codes = ["P0730"]
[workshop]
name = "Łódź Automaty"
logo = "pictures/logo.png"
[vehicle]
vin = "WEXAMPLE123456789"
mileage_km = 106315
[contamination]
grade = "heavy"
[[photos]]
file = "pictures/open.jpg"
[[repair_decisions]]
component = "8"
land = 1
decision = "declined"
reason = "too dear"
"""


def test_a_record_from_toml_and_json_is_the_same(tmp_path):
    (tmp_path / "pictures").mkdir()
    for name in ("logo.png", "open.jpg"):
        (tmp_path / "pictures" / name).write_bytes(name.encode())
    (tmp_path / "job.toml").write_text(TOML, encoding="utf-8")
    job = load_job(tmp_path / "job.toml")
    assert job.number == "417"
    assert job.date == dt.date(2026, 3, 14)
    assert job.repair_decisions[0].reason == "too dear"
    assert job.pictures == {"pictures/logo.png": b"logo.png", "pictures/open.jpg": b"open.jpg"}
    (tmp_path / "job.json").write_text(json.dumps(job.record()), encoding="utf-8-sig")
    assert load_job(str(tmp_path / "job.json")) == job


def test_every_field_is_optional():
    assert Job().empty
    assert Job().record() == {}
    assert not Job(vehicle={"vin": "x"}).empty


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "numer = 1",
            r"job.toml, key 'numer': unknown key \(found 1\); expected one of number, .*mean 'number'",
        ),
        ("[vehicle]\nvim = 'x'", r"\[vehicle\], key 'vim': unknown key.*did you mean 'vin'"),
        ("[vehicle]\nmileage_km = -1", r"\[vehicle\], key 'mileage_km'.*found -1.*expected greater than or equal to 0"),
        ("[vehicle]\nmileage_km = nan", r"key 'mileage_km'"),
        ("[vehicle]\nmileage_km = '123.456'", r"key 'mileage_km'.*can be read in two ways"),
        ("[vehicle]\nmileage_km = '955 °C'", r"key 'mileage_km'.*is not a number"),
        ("[contamination]\ngrade = 'some'", r"key 'grade'.*'none', 'light', 'moderate' or 'heavy'"),
        ("[[photos]]\nfile = '../secret.png'", r"\[photos\[1\]\], key 'file'.*without '..'"),
        ("[[photos]]\nfile = '/etc/secret.png'", r"key 'file'"),
        ("[[photos]]\nfile = 'C:\\secret.png'", r"key 'file'"),
        ("[[photos]]\nfile = 'passwd'", r"a picture: .png, .jpg"),
        ("date = 2026-13-01", r"is not valid"),
        ("a = 1\nb = 2", r"key 'a': unknown key(.|\n)*key 'b': unknown key"),
        ("number = ", r"is not valid"),
    ],
)
def test_what_is_wrong_is_named(text, said):
    with pytest.raises(InputError, match=said):
        parse_job(text.encode(), "job.toml")


def test_json_that_nests_without_end_is_refused():
    with pytest.raises(InputError, match="is not valid"):
        parse_job(b"[" * 200_000, "job.json")


def test_a_missing_record_or_picture_is_named(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        load_job(tmp_path / "nothing.toml")
    (tmp_path / "job.toml").write_text("[[photos]]\nfile = 'a.png'", encoding="utf-8")
    with pytest.raises(InputError, match=r"job.toml, key 'a\.png': picture cannot be read"):
        load_job(tmp_path / "job.toml")


def test_a_link_out_of_the_folder_is_not_followed(tmp_path):
    (tmp_path / "secret.png").write_bytes(b"secret")
    folder = tmp_path / "job"
    folder.mkdir()
    try:
        (folder / "a.png").symlink_to(tmp_path / "secret.png")
    except OSError:  # Windows without the right to make links: the copy beside the record is refused by nothing
        return
    (folder / "job.toml").write_text("[[photos]]\nfile = 'a.png'", encoding="utf-8")
    with pytest.raises(InputError, match="outside the job's folder"):
        load_job(folder / "job.toml")


def test_text_is_cleaned_of_what_no_file_can_hold():
    assert Job(notes="a\x00b\ud800c\td\n").notes == "ab\ufffdc\td"


def test_a_record_is_not_changed_after_it_was_made():
    job = Job(number="1")
    with pytest.raises(ValidationError):
        job.number = "2"  # type: ignore[misc]
    assert Photo(file="a\\b.png").file == "a/b.png"


def test_pictures_it_does_not_name_are_left_out():
    job = Job(photos=[{"file": "a.png"}]).with_pictures({"a.png": b"1", "b.png": b"2"})
    assert dict(job.pictures) == {"a.png": b"1"}
