"""What is written in JSON is what `atleak schema` says of it: all keys, no other, null only where it says so."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator, ValidationError

from atleak.diagnosis.diagnosis import Diagnosis
from atleak.job.result import result_record
from atleak.measurements.job_card import Job
from atleak.report.json.diagnosis import to_json
from atleak.report.json.schemas import OUTPUTS, schema
from tests.unit.cli.conftest import JOB

Run = Callable[..., tuple[int, str, str]]


def closed(output: str) -> Draft202012Validator:
    """The schema of an output that takes no key but those that it describes."""
    whole = copy.deepcopy(schema(output))
    tables = [whole, *whole["$defs"].values()]
    shared = {each["$ref"].rpartition("/")[2] for table in tables for each in table.get("allOf", ())}
    for table in (whole, *(part for name, part in whole["$defs"].items() if name not in shared)):
        if table.get("type") == "object" and "additionalProperties" not in table:
            table["unevaluatedProperties"] = False
    return Draft202012Validator(whole)


@pytest.fixture
def files(tmp_path: Path, small_sheet: Callable[..., Path]) -> dict[str, Path]:
    """The small files that the commands read, by what stands for them in the tests."""
    random = np.random.default_rng(7)
    readings = [
        f"{part},{'ABC'[who]},{trial},{12.7 + 0.01 * part + 0.001 * random.normal():.4f}"
        for part, who, trial in np.ndindex(5, 3, 3)
    ]
    texts = {
        "JOB": ("job.toml", JOB),
        "LOW": ("low.csv", "tap,range,slow idle [kPa]\nline,D,570\nforward clutch,D,330\n"),
        "FLOWS": ("flows.csv", "condition,what,value\nhot_idle,cooler,3.7 l/min\nhot_idle,cooler,1 l/min\n"),
        "STAND": ("stand.csv", "supply,25,in-Hg\nforward_clutch,17,in-Hg,1 mm\nboost_valve/1,20,in-Hg,1 mm\n"),
        "GAUGES": ("gauges.csv", "range;slow idle [bar];stall [bar]\nD;3,9;11\n1;2,9;\n"),
        "STUDY": ("study.csv", "\n".join(["part,operator,trial,reading [mm]", *readings])),
    }
    for name, text in texts.values():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return {"SHEET": small_sheet(), **{word: tmp_path / name for word, (name, _) in texts.items()}}


MINIMAL = ("--controller", "minimal_example")


@pytest.mark.parametrize(
    ("output", "command"),
    [
        ("diagnose", ("diagnose", "SHEET", *MINIMAL, "--job", "JOB")),
        ("diagnose", ("diagnose", "--flows", "FLOWS", "--controller", "five_speed_2005")),
        ("diagnose", ("diagnose", "--road-test", "LOG", "--profile", "paper")),
        ("diagnose", ("diagnose", "--pressures", "GAUGES", "--complaint", "slips_hot")),
        ("evidence", ("evidence", *MINIMAL)),
        ("evidence", ("evidence", "--vacuum", "STAND", "--flows", "FLOWS", "--controller", "five_speed_2005")),
        ("evidence", ("evidence", "--pressures", "LOW", "--flows", "FLOWS", "--controller", "five_speed_2005")),
        ("evidence", ("evidence", "--road-test", "LOG")),
        ("import-log", ("import-log", "LOG")),
        ("gauge-study", ("gauge-study", "STUDY", "--tolerance", "0.02")),
        ("controller-learn", ("controller", "learn", "SHEET", *MINIMAL)),
        *((name, (name,)) for name in ("variants", "controllers", "fluids", "limits", "instruments")),
    ],
)
def test_every_output_is_as_its_schema_says(
    run: Run, files: dict[str, Path], sample_log: Path, output: str, command: tuple[str, ...]
) -> None:
    named = {**files, "LOG": sample_log}
    status, out, _ = run(*(named.get(word, word) for word in command), "--json", "-")
    assert status == 0
    closed(output).validate(json.loads(out))


def test_jobs_of_the_book_and_their_comparison_are_as_their_schemas_say(
    run: Run, small_sheet: Callable[..., Path], files: dict[str, Path]
) -> None:
    ids = [
        run("jobs", "add", small_sheet(sleeve), *MINIMAL, "--job", files["JOB"])[1].strip() for sleeve in (11.08, 11.03)
    ]
    asked = {"jobs-list": ("jobs", "list"), "jobs-show": ("jobs", "show", ids[0]), "compare": ("compare", *ids)}
    for output, command in asked.items():
        status, out, _ = run(*command, "--json", "-")
        assert status == 0
        record = json.loads(out)
        assert record
        closed(output).validate(record)


def test_a_unit_with_circuits_is_as_the_schema_says(worn_clutch: Diagnosis) -> None:
    record = json.loads(to_json(result_record(worn_clutch)))
    assert all(each["circuits"] for each in record["conditions"])
    closed("diagnose").validate(record)


def test_the_check_notices_a_key_that_is_missing_one_that_is_new_and_a_null(run: Run, files: dict[str, Path]) -> None:
    record = json.loads(run("diagnose", files["SHEET"], *MINIMAL, "--json", "-")[1])
    land = record["lands"][0]
    for wrong in (
        {key: value for key, value in land.items() if key != "share_percent"},
        {**land, "new_key": 1},
        {**land, "radial_clearance_um": None},
        {**land, "verdict": "good"},
    ):
        with pytest.raises(ValidationError):
            closed("diagnose").validate({**record, "lands": [wrong, *record["lands"][1:]]})
    open_to_more = Draft202012Validator(schema("diagnose"))
    assert open_to_more.is_valid({**record, "new_key": 1}), "a later version may add keys"


def test_every_part_of_the_schemas_is_one_of_its_draft() -> None:
    parts = {name: part for output in OUTPUTS for name, part in schema(output)["$defs"].items()}
    heads = {output: {key: value for key, value in schema(output).items() if key != "$defs"} for output in OUTPUTS}
    Draft202012Validator.check_schema({"$defs": {**parts, **heads, "record of a job": Job.model_json_schema()}})


@pytest.mark.parametrize("output", [*OUTPUTS, "job"])
def test_a_schema_is_printed_whole(run: Run, output: str) -> None:
    status, out, err = run("schema", output)
    assert (status, err) == (0, "")
    whole = json.loads(out)
    assert whole["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    referred = {part.partition('"')[0] for part in out.split('"#/$defs/')[1:]}
    assert referred == set(whole["$defs"])


def test_the_schema_of_a_diagnosis_is_printed_unless_another_is_named(run: Run) -> None:
    assert run("schema") == run("schema", "diagnose")
    status, out, err = run("schema", "import-lgo")
    assert (status, out) == (2, "")
    assert "did you mean 'import-log'?" in err


def test_a_job_record_is_as_its_schema_says(run: Run) -> None:
    whole = Draft202012Validator(json.loads(run("schema", "job")[1]))
    job = {"number": "2026-0417", "date": "2026-04-17", "vehicle": {"vin": "WVW", "mileage_km": 90000.0}}
    assert Job.model_validate(job)
    whole.validate(job)
    assert not whole.is_valid({"vehicle": {"vim": "WVW"}})
