"""A job as one file: opened again it gives the same verdict, and a hostile one does no harm."""

from __future__ import annotations

import io
import json
import struct
import tracemalloc
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest
from PIL import Image

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.entries import catalogue_files
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.instruments import load_instruments
from atleak.catalogue.limits import load_limits
from atleak.catalogue.pump import PumpClearances
from atleak.common.errors import InputError
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import stated_condition
from atleak.job.case import OWN_FILES, SLOTS, Case, SourceFile
from atleak.job.parts import JOB_FORMAT, entry_of
from atleak.job.result import judged_otherwise
from atleak.job.zip_file import read_job_file, write_job_file
from atleak.measurements.job_card import Job
from atleak.measurements.measuring_plan import Plan
from atleak.readers.logs import read_road_test
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.readers.typed_sheet import TYPED_FILE, Typed, TypedEntry, written_sheet
from atleak.report.json.diagnosis import diagnosis_record
from atleak.version import __version__

SHEET = b"""component;part;plane;direction;diameter 1 [mm];diameter 2 [mm]
6;spool;1;0;9,939;9,940
6;spool;1;90;9,938;9,939
6;sleeve;1;0;10,031;10,030
6;sleeve;1;90;10,032;10,031
8;spool;1;0;10,000;10,000
8;spool;1;90;10,000;10,001
8;sleeve;1;0;10,120;10,121
8;sleeve;1;90;10,119;10,120
"""
LOG = "time [s],rpm,line,atf_temperature [°C],gear\n" + "".join(
    f"{number / 10},{900 + 5 * number},{500 + number},{60 + number / 20},{1 + number // 100}\n" for number in range(400)
)
LOG_CHOICES = {
    "mapping": {"engine_speed": "rpm", "main_pressure": "line"},
    "units": {"engine_speed": "rpm", "main_pressure": "kPa"},
}


def case_of(sheet: bytes = SHEET) -> Case:
    return Case(
        readings=SourceFile("=sheet.csv", sheet),
        road_test=SourceFile("log <1>.csv", LOG.encode()),
        columns=tuple(LOG_CHOICES["mapping"].items()),
        units=tuple(LOG_CHOICES["units"].items()),
    )


@pytest.fixture(scope="module")
def diagnosis() -> Diagnosis:
    controller = load_controller("four_speed_2023")
    return diagnose(
        controller,
        load_fluid("mobil_atf_220"),
        load_limits("project_default"),
        readings=read_readings(SHEET, controller, name="=sheet.csv"),
        road_test=read_road_test(LOG.encode(), name="log <1>.csv", **LOG_CHOICES),
        profile=WORKSHOP.with_options(entry_loss="on", eccentricity="0.25"),
        condition=stated_condition(controller, temperature=92.5, engine_speed=1111 / 60),
        mileage_km=123_456.0,
        instruments=load_instruments("micrometer", "air_gauge"),
        assumptions=DEFAULTS.with_settings({"viscosity_percent": 3.0}),
    )


@pytest.fixture(scope="module")
def content(diagnosis) -> bytes:
    job = Job(number="7", date="2026-02-03", photos=[{"file": "a/b.png"}]).with_pictures({"a/b.png": b"picture"})
    return write_job_file(diagnosis, job, case_of())


def test_another_atleak_comes_to_the_same_verdict(diagnosis, content, tmp_path):
    (tmp_path / "job.zip").write_bytes(content)
    job_file = read_job_file(tmp_path / "job.zip")
    again = diagnosis_record(job_file.diagnose())
    assert again == diagnosis_record(diagnosis)
    assert job_file.result == json.loads(json.dumps(again))
    assert again["verdict"] in ("replace", "critical")
    assert job_file.job.number == "7"
    assert job_file.job.pictures == {"a/b.png": b"picture"}


def test_same_job_same_bytes(diagnosis, content):
    job = Job(number="7", date="2026-02-03", photos=[{"file": "a/b.png"}]).with_pictures({"a/b.png": b"picture"})
    assert content == write_job_file(diagnosis, job, case_of())


def test_a_unit_nobody_measured_needs_no_files(unmeasured):
    job_file = read_job_file(write_job_file(unmeasured))
    assert diagnosis_record(job_file.diagnose()) == diagnosis_record(unmeasured)
    assert job_file.case.readings is None


def test_files_that_are_not_those_of_the_diagnosis_are_refused(diagnosis):
    with pytest.raises(InputError, match="measuring sheet is missing"):
        write_job_file(diagnosis)
    with pytest.raises(InputError, match="measuring sheet is not the one"):
        write_job_file(diagnosis, case=case_of(SHEET + b" "))


def test_a_catalogue_file_that_has_gone_or_changed_is_refused(unmeasured, tmp_path):
    origin = unmeasured.fluid.origin
    gone = replace(origin, path=tmp_path / "gone.toml")
    moved = replace(unmeasured, fluid=replace(unmeasured.fluid, origin=gone))
    with pytest.raises(InputError, match="file of the fluid is no longer there"):
        write_job_file(moved)
    assert read_job_file(
        write_job_file(moved, case=Case(fluid=SourceFile("own.toml", origin.path.read_bytes())))
    ).case.fluid
    with pytest.raises(InputError, match="file of the fluid has changed"):
        write_job_file(moved, case=Case(fluid=SourceFile("own.toml", b"other")))


@pytest.mark.parametrize("state", [None, "fresh", "used"])
@pytest.mark.parametrize("fluid", ["hipol_atf_iid", "mobil_atf_220", "own"])
def test_the_state_of_the_fluid_goes_with_the_job(fluid, state):
    own = SourceFile("our atf.toml", catalogue_files("fluids")["hipol_atf_iid"].read_bytes() + b"\n# our copy\n")
    case = Case(fluid=own if fluid == "own" else fluid, fluid_state=state)
    diagnosis = case.diagnose()
    record = diagnosis_record(diagnosis)
    assert (record["fluid"]["state"], record["fluid"]["state_assumed"]) == (state or "fresh", state is None)
    opened = read_job_file(write_job_file(diagnosis, case=case))
    assert opened.case.fluid_state == state
    assert diagnosis_record(opened.diagnose()) == record


def changed(content: bytes, **entries: bytes | None) -> bytes:
    """The zip with entries replaced, added (``a__b`` for a/b) or, where None, left out."""
    target, named = io.BytesIO(), {name.replace("__", "/"): entry for name, entry in entries.items()}
    with zipfile.ZipFile(io.BytesIO(content)) as old, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            if name not in named:
                new.writestr(name, old.read(name))
        for name, entry in named.items():
            if entry is not None:
                new.writestr(name, entry)
    return target.getvalue()


def with_choices(content: bytes, **choices: object) -> bytes:
    with zipfile.ZipFile(io.BytesIO(content)) as bundle:
        record = json.loads(bundle.read("job.json"))
    return changed(content, **{"job.json": json.dumps(record | choices).encode()})


@pytest.mark.parametrize(
    "name",
    ["../evil.toml", "/etc/passwd", "catalogue/../x.toml", "pictures/../../a.png", "pictures/a.exe", "C:\\a.png"],
)
def test_entries_that_no_job_has_are_refused(content, name):
    with pytest.raises(InputError, match="holds a file that no job has"):
        read_job_file(changed(content, **{name: b"x"}))


@pytest.mark.parametrize("entry", ["job.json", "result.json", *map(entry_of, (*OWN_FILES, *SLOTS)), "pictures/a.jpg"])
def test_every_entry_that_a_job_has_is_opened(entry):
    """Its name and its size are known in one place."""
    with zipfile.ZipFile(stream := io.BytesIO(), "w") as bundle:
        bundle.writestr(entry, b"{}")
    with pytest.raises(InputError, match=r"holds no job\.json|another format"):
        read_job_file(stream.getvalue())


def test_a_zip_that_unfolds_without_end_is_refused(content):
    bomb = changed(content, **{"pictures/a.png": b"\0" * 30_000_000})
    assert len(bomb) < 100_000
    with pytest.raises(InputError, match="too large"):
        read_job_file(bomb, size_limit=10_000_000)


@pytest.mark.parametrize("entry", ["readings", "road_test", "catalogue__fluid.toml"])
def test_a_small_zip_of_a_file_that_no_job_can_have_is_refused_before_it_is_unpacked(content, entry):
    bomb = changed(content, **{entry: b"0" * 60_000_000})
    assert len(bomb) < 200_000
    tracemalloc.start()
    with pytest.raises(InputError, match=f"{entry.replace('__', '/')}: too large .found 60000000.; expected at most"):
        read_job_file(bomb)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 8_000_000


def test_an_entry_that_is_longer_than_it_says_is_refused(content):
    """The size stands in two headers; what is unpacked counts."""
    with zipfile.ZipFile(io.BytesIO(content)) as bundle:
        size = bundle.getinfo("readings").file_size
    lying = content.replace(struct.pack("<L", size), struct.pack("<L", size - 5))
    assert lying != content
    with pytest.raises(InputError, match=r"no sound zip|too large"):
        read_job_file(lying)


def test_a_log_that_packs_to_a_fiftieth_is_opened(content):
    log = b"time [s],rpm,line\n" + b"".join(b"%d,900,500\n" % (row // 20) for row in range(300_000))
    larger = changed(content, road_test=log)
    assert len(larger) < len(log) // 25
    assert read_job_file(larger).case.road_test.content == log


def test_too_many_and_repeated_entries_are_refused(content):
    many = changed(content, **{f"pictures/{number}.png": b"" for number in range(1100)})
    with pytest.raises(InputError, match="too many files"):
        read_job_file(many)
    target = io.BytesIO(content)
    with zipfile.ZipFile(target, "a") as bundle, pytest.warns(UserWarning, match="Duplicate name"):
        bundle.writestr("job.json", b"{}")
    with pytest.raises(InputError, match="holds a file twice"):
        read_job_file(target.getvalue())


def test_a_damaged_file_is_refused(content, tmp_path):
    for damaged in (b"", b"PK\x03\x04", content[:-200], content[:500] + b"\0" * 50 + content[550:]):
        with pytest.raises(InputError):
            read_job_file(damaged)
    with pytest.raises(InputError, match="cannot be read"):
        read_job_file(tmp_path / "nothing.zip")


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        ({"job.json": None}, "holds no job.json"),
        ({"job.json": b"[]"}, "another format"),
        ({"job.json": b"{"}, "is not valid JSON"),
        ({"job.json": b"[" * 100_000}, "is not valid JSON"),
        ({"readings": None}, "holds no readings, which its record names"),
        ({"catalogue/fluid.toml": None}, "holds no catalogue/fluid.toml"),
    ],
)
def test_an_incomplete_job_is_refused(content, entries, said):
    with pytest.raises(InputError, match=said):
        read_job_file(changed(content, **entries))


def test_a_record_from_elsewhere_is_checked(content):
    with pytest.raises(InputError, match="another format"):
        read_job_file(with_choices(content, format=JOB_FORMAT - 1))
    with pytest.raises(InputError, match="unknown key"):
        read_job_file(with_choices(content, formulas="x"))
    job_file = read_job_file(
        with_choices(content, files={**json.loads(_record(content))["files"], "readings": "../../x.csv"})
    )
    assert job_file.case.readings.name == "x.csv"
    with pytest.raises(InputError, match="no such profile"):
        read_job_file(with_choices(content, profile="mine")).diagnose()


@pytest.mark.parametrize(
    "newer",
    [
        {"format": JOB_FORMAT + 1},
        {"format": JOB_FORMAT + 1, "tone": "x"},
        {"tone": "x"},
        {"profile": "rally"},
        {"options": {"entry_loss": "by_length"}},
    ],
)
def test_a_job_file_of_a_newer_atleak_asks_for_an_update(content, newer):
    with pytest.raises(InputError) as refused:
        read_job_file(with_choices(content, atleak="99.1.0", **newer), name="job.zip")
    assert str(refused.value) == f"job.zip: made by atleak 99.1.0, newer than this {__version__}: update"
    assert "bitte aktualisieren" in wording("de").sentence(refused.value)


def test_a_job_file_of_a_newer_atleak_is_read_where_nothing_in_it_is_new(content):
    assert read_job_file(with_choices(content, atleak="99.1.0")).result_by == __version__


def test_a_result_that_was_changed_is_told_with_what_differs(diagnosis, content):
    today = diagnosis_record(diagnosis)
    assert judged_otherwise(read_job_file(content).result, today, numbers=True) == ()
    with zipfile.ZipFile(io.BytesIO(content)) as bundle:
        result = json.loads(bundle.read("result.json"))
    land = next(each for each in result["lands"] if (each["component"], each["land"]) == ("8", 1))
    other = next(each for each in result["lands"] if (each["component"], each["land"]) == ("6", 1))
    kept = land["verdict"]
    land["verdict"] = "critical" if kept == "ok" else "ok"
    other["share_percent"] += 0.5
    other["leakage_dm3_min"] *= 1.0 + 1e-9  # the last digits of another computer
    job_file = read_job_file(changed(content, **{"result.json": json.dumps({**result, "atleak": "0.1.0"}).encode()}))
    assert job_file.result_by == "0.1.0"
    first, second = judged_otherwise(job_file.result, today, numbers=True)
    assert str(first).startswith(f"8/1: {land['verdict']}")
    assert f"today {kept}" in str(first)
    assert str(second).startswith(f"6/1: share of the pump's flow {other['share_percent']:.6g} %, today ")


@pytest.mark.parametrize(
    "result", [b"[]", b"7", b'{"lands": 3, "unit": [], "conditions": [1, {"circuits": {}}], "verdict": {"a": []}}']
)
def test_a_result_that_is_none_does_no_harm(content, diagnosis, result):
    job_file = read_job_file(changed(content, **{"result.json": result}))
    assert all(str(each) for each in judged_otherwise(job_file.result, diagnosis_record(diagnosis), numbers=True))


def test_photos_leave_without_the_place_where_they_were_taken(unmeasured):
    exif = Image.Exif()
    exif.get_ifd(0x8825)[1] = "N"
    target = io.BytesIO()
    Image.new("RGB", (8, 6), "red").save(target, "JPEG", exif=exif)
    job = Job(photos=[{"file": "a.jpg"}]).with_pictures({"a.jpg": target.getvalue()})
    content = write_job_file(unmeasured, job)
    again = read_job_file(content)
    assert not Image.open(io.BytesIO(again.job.pictures["a.jpg"])).getexif()
    assert write_job_file(unmeasured, again.job) == content


def _record(content: bytes) -> bytes:
    with zipfile.ZipFile(io.BytesIO(content)) as bundle:
        return bundle.read("job.json")


def test_nothing_is_left_behind(content, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    read_job_file(content).diagnose()
    assert list(Path(tmp_path).iterdir()) == []


def with_bytes_flipped(content: bytes, name: str) -> bytes:
    """The zip with an entry's packed bytes damaged."""
    with zipfile.ZipFile(io.BytesIO(content)) as bundle:
        info = bundle.getinfo(name)
    start = info.header_offset + 30 + len(name)
    return content[:start] + bytes(255 - byte for byte in content[start : start + 40]) + content[start + 40 :]


def packed_by(content: bytes, method: int) -> bytes:
    target = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as old, zipfile.ZipFile(target, "w", method) as new:
        for name in old.namelist():
            new.writestr(name, old.read(name))
    return target.getvalue()


def test_damaged_packing_and_entries_without_a_name_are_refused_in_words(content):
    for damaged, words in (
        (with_bytes_flipped(content, "result.json"), "shop.zip: is no sound zip"),
        (packed_by(content, zipfile.ZIP_LZMA), "shop.zip: is packed in a way that no job is"),
        (content.replace(b"readings", b"\0eadings"), "shop.zip: "),
    ):
        with pytest.raises(InputError, match=words):
            read_job_file(damaged, name="shop.zip")


def test_names_that_cannot_be_encoded_are_cleaned_on_reading(content):
    with zipfile.ZipFile(io.BytesIO(content)) as bundle:
        files = json.loads(bundle.read("job.json"))["files"]
    job_file = read_job_file(with_choices(content, files=files | {"road_test": "a\ud800b.csv"}))
    assert job_file.case.road_test.name == "a\ufffdb.csv"
    assert json.dumps(diagnosis_record(job_file.diagnose()), ensure_ascii=False).encode()


def test_a_file_of_the_job_that_cannot_be_used_is_named_with_its_zip(content):
    broken = changed(content, **{"catalogue/fluid.toml": b"deep = " + b"[" * 5000})
    with pytest.raises(InputError, match=r"^shop\.zip: mobil_atf_220\.toml: is not valid TOML"):
        read_job_file(broken, name="shop.zip").diagnose()


def test_limits_that_no_number_holds_are_named_with_their_place_in_the_zip(content):
    with zipfile.ZipFile(io.BytesIO(content)) as bundle:
        limits = bundle.read("catalogue/limits.toml")
    huge = changed(
        content, **{"catalogue/limits.toml": limits.replace(b"critical = 50.0", b"critical = 1" + b"0" * 400)}
    )
    with pytest.raises(
        InputError, match=r"^shop\.zip: .*\[total_share_percent\], key 'critical'.*greater than 0, up to 10000"
    ):
        read_job_file(huge, name="shop.zip").diagnose()


# --- the temperature of measuring


@pytest.mark.parametrize("chosen", [None, 35.0])
def test_the_measuring_temperature_is_kept(chosen):
    case = replace(Case(readings=SourceFile("sheet.csv", SHEET)), measuring_temperature=chosen)
    made = case.diagnose()
    opened = read_job_file(write_job_file(made, Job(number="7"), case))
    assert opened.case.measuring_temperature == opened.job.measuring_temperature_c == chosen
    again = opened.diagnose()
    assert again.measured_at == made.measured_at
    assert [land.state for land in again.lands] == [land.state for land in made.lands]
    assert again.measured_at.origin == ("assumed" if chosen is None else "job")


def test_a_job_file_of_earlier_versions_is_measured_as_its_record_says():
    case = Case(readings=SourceFile("sheet.csv", SHEET))
    content = write_job_file(case.diagnose(), Job(measuring_temperature_c=35.0), case)
    assert "readings" not in json.loads(zipfile.ZipFile(io.BytesIO(content)).read("job.json"))  # no choice of its own
    assert read_job_file(content).diagnose().measured_at.value == 35.0


def test_the_pump_s_clearances_are_kept():
    clearances = PumpClearances.of_um(85.0, None)
    case = replace(Case(readings=SourceFile("sheet.csv", SHEET)), pump_clearances=clearances)
    opened = read_job_file(write_job_file(case.diagnose(), Job(), case))
    assert opened.case.pump_clearances == clearances
    assert (opened.job.pump_side_clearance_um, opened.job.pump_tip_clearance_um) == (85.0, None)


def test_another_measuring_temperature_is_another_result():
    case = Case(readings=SourceFile("sheet.csv", SHEET))
    warm = replace(case, measuring_temperature=35.0)
    assert warm.key != case.key
    assert warm.diagnose().lands[0].state == case.diagnose().lands[0].state  # not measured
    cold, hot = ({land.key: land.state for land in each.diagnose().lands} for each in (case, warm))
    assert hot["6", 1].radial_clearance < cold["6", 1].radial_clearance


def test_typed_readings_of_which_none_counts_yet_stay_in_the_job() -> None:
    controller = load_controller("minimal_example")
    content = written_sheet(Typed({Plan().cells(controller)[0]: TypedEntry("99,1")}), (), controller)
    assert content is not None
    case = Case(readings=SourceFile(TYPED_FILE, content), controller=controller.id)
    unit = case.diagnose()
    assert not unit.judged
    held = read_job_file(write_job_file(unit, Job(), case)).case.readings
    assert held is not None
    assert held.content == content
