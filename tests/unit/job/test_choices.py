"""How a log's columns were settled goes into the job file, and a file's own name into messages and records."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from atleak.catalogue.entries import catalogue_files
from atleak.catalogue.limits import load_limits
from atleak.common.errors import CatalogueError, InputError
from atleak.job.case import Case, SourceFile, load_source, with_log_choices
from atleak.job.zip_file import read_job_file, write_job_file
from atleak.readers.logs import default_path, read_road_test, remember, understand

SAMPLE = Path(__file__).resolve().parents[3] / "sample_data" / "measuring_sheet_four_speed.xlsx"
ROWS = "".join(f"{step / 10};800;{6 + step};{9 + step};80;2\n" for step in range(30))
LOG = ("time [s];engine_speed [rpm];p one [bar];p two [bar];atf_temperature [°C];gear\n" + ROWS).encode()


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Answers given earlier for logs with this header."""
    monkeypatch.setenv("ATLEAK_HOME", str(tmp_path / "home"))
    path = default_path()
    answers = {"main_pressure": "p one [bar]", "converter_pressure": "p two [bar]"}
    remember(path, understand(LOG, name="a.csv").signature, answers, {"main_pressure": "kPa"})
    return path


@pytest.mark.parametrize("mapping", [{}, {"main_pressure": "p two [bar]"}, {"converter_pressure": "p one [bar]"}])
def test_choices_read_the_log_as_it_was_read_with_the_memory(kept: Path, mapping: dict[str, str]) -> None:
    log = understand(LOG, name="a.csv", mapping=mapping, remembered=kept)
    settled = with_log_choices(Case(road_test=SourceFile("a.csv", LOG), columns=tuple(mapping.items())), log)
    assert not settled.remember
    elsewhere = read_road_test(LOG, name="a.csv", **settled.log_choices)
    assert set(elsewhere.channels) == set(log.road_test.channels)
    for quantity, channel in log.road_test.channels.items():
        assert (elsewhere.channels[quantity].values == channel.values).all()
        assert elsewhere.channels[quantity].column == channel.column


def test_answers_that_were_not_consulted_are_no_choices(kept: Path) -> None:
    log = understand(LOG, name="a.csv", mapping={"main_pressure": "p two [bar]"})
    case = Case(road_test=SourceFile("a.csv", LOG), columns=(("main_pressure", "p two [bar]"),))
    assert with_log_choices(case, log) == replace(case, remember=False)


def test_a_file_at_hand_as_bytes_keeps_its_name() -> None:
    content = catalogue_files("limits")["project_default"].read_bytes()
    assert load_source(load_limits, SourceFile("our limits: 2026.toml", content)).origin.file == "our limits: 2026.toml"
    with pytest.raises(CatalogueError, match=r"^our limits: 2026\.toml, ") as caught:
        load_source(
            load_limits, SourceFile("our limits: 2026.toml", content.replace(b"replace = 50.0", b"replace = 'x'"))
        )
    assert caught.value.place.file == "our limits: 2026.toml"


def test_two_files_keep_their_names() -> None:
    files = catalogue_files("instruments")
    case = Case(
        spool_instrument=SourceFile("one.toml", files["micrometer"].read_bytes()),
        sleeve_instrument=SourceFile("two.toml", files["bore_gauge"].read_bytes()),
        readings=SourceFile.at(SAMPLE),
    )
    instruments = case.diagnose().uncertainty.instruments
    assert (instruments.spool.origin.file, instruments.sleeve.origin.file) == ("one.toml", "two.toml")


def test_equal_files_and_choices_have_one_key_and_others_have_not() -> None:
    case = Case(readings=SourceFile("a.csv", b"1"), options=(("eccentricity", 0.5),))
    assert case.key == replace(case, readings=SourceFile("a.csv", b"1")).key
    others = [
        replace(case, readings=SourceFile("a.csv", b"2")),
        replace(case, options=()),
        replace(case, controller=SourceFile("own.toml", b"x")),
        replace(case, mileage=1.0),
        replace(case, fluid_state="used"),
    ]
    assert len({case.key, *(other.key for other in others)}) == 1 + len(others)


def test_of_how_many_rows_one_is_read_is_a_choice_that_older_results_did_not_have() -> None:
    case = Case(road_test=SourceFile("a.csv", LOG))
    assert "every" not in {name for name, value in case.log_choices.items() if value != 1}
    assert replace(case, every=2).key != case.key
    assert replace(case, every=2).log_choices["every"] == 2
    later = ("every", "vacuum", "flows", "sheet_columns")
    values = {name: value for name, value in vars(case).items() if name not in later}  # as before there was the choice
    values["road_test"] = ("a.csv", case.road_test.sha256)
    assert case.key == hashlib.sha256(repr(sorted(values.items())).encode()).hexdigest()


def test_a_job_file_keeps_of_how_many_rows_one_is_read() -> None:
    columns = (("main_pressure", "p one [bar]"), ("converter_pressure", "p two [bar]"))
    case = Case(road_test=SourceFile("a.csv", LOG), columns=columns, remember=False)
    for every, kept in ((1, {}), (3, {"every": 3})):
        chosen = replace(case, every=every)
        diagnosis = chosen.diagnose()
        content = write_job_file(diagnosis, None, chosen)
        with zipfile.ZipFile(io.BytesIO(content)) as job:
            road_test = json.loads(job.read("job.json"))["road_test"]
        assert {name: value for name, value in road_test.items() if name not in ("mapping", "units")} == kept
        again = read_job_file(content).diagnose()
        assert again.log.road_test.rows == diagnosis.log.road_test.rows == -(-30 // every)


@pytest.mark.parametrize("choice", [{"every": 0}, {"every": {}}, {"mapping": 3}, {"every": True}, {"every": "2"}])
def test_a_job_file_with_another_number_of_rows_is_refused(choice: dict[str, Any]) -> None:
    case = Case(road_test=SourceFile("a.csv", LOG), columns=(("main_pressure", "p one [bar]"),), remember=False)
    source, changed = io.BytesIO(write_job_file(case.diagnose(), None, case)), io.BytesIO()
    with zipfile.ZipFile(source) as job, zipfile.ZipFile(changed, "w") as target:
        for name in job.namelist():
            content = job.read(name)
            if name == "job.json":
                told = json.loads(content)
                content = json.dumps(told | {"road_test": told["road_test"] | choice}).encode()
            target.writestr(name, content)
    with pytest.raises(InputError):
        read_job_file(changed.getvalue())
