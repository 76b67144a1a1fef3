"""``--vacuum`` and ``--flows``: what they give in every medium and in job files, and what is refused."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from pathlib import Path

import openpyxl
import pytest

from tests.unit.report.read_back import text_of

Run = Callable[..., tuple[int, str, str]]
UNIT = ("--controller", "five_speed_2005")


@pytest.fixture
def flows(tmp_path: Path) -> Path:
    path = tmp_path / "flows.csv"
    path.write_text("Betriebspunkt;Was;Wert\nhot_idle;Kühler;946 ml/15 s\nhot_idle;Kühler;0,4 gpm\n", encoding="utf-8")
    return path


@pytest.fixture
def vacuum(tmp_path: Path) -> Path:
    path = tmp_path / "vacuum.csv"
    path.write_text("supply,25,in-Hg\ncircuit,reading,orifice\nforward_clutch,17.5,1 mm\nboost_valve/1,20,1 mm\n")
    return path


def test_flows_in_the_record(record_of, flows: Path) -> None:
    usual, short = record_of("--flows", flows, *UNIT)["flows"]
    assert (usual["condition"], usual["what"], usual["consumer"]) == ("hot_idle", "cooler", "converter_and_cooler")
    assert usual["flow_dm3_min"] == pytest.approx(3.784, abs=0.0)
    assert (usual["bound"], usual["left_high_dm3_min"]) == (True, None)
    assert usual["left_low_dm3_min"] < 3.784 < usual["computed_left_dm3_min"]
    assert usual["usual_dm3_min"] == pytest.approx(3.8, abs=0.0)
    assert short["flow_dm3_min"] == pytest.approx(0.4 * 3.785411784, rel=1e-8, abs=0.0)
    assert short["bound"] is False
    assert short["left_low_dm3_min"] < short["flow_dm3_min"] < short["left_high_dm3_min"]
    assert short["place"] == {"file": "flows.csv", "row": 3, "column": "Wert"}


def test_without_them_the_record_has_none(record_of, small_sheet) -> None:
    assert record_of(small_sheet(), "--controller", "minimal_example")["flows"] == []


def test_a_jug_alone_is_named_with_what_tells_more(run: Run, flows: Path) -> None:
    said = " ".join(run("diagnose", "--flows", flows, *UNIT)[1].split())
    assert "What was caught in the jug gives no verdict" in said
    assert "atleak evidence" in said
    assert "Nothing can be judged yet" not in said


def test_every_medium_shows_both_the_usual_flow_and_what_was_caught(run: Run, flows: Path, tmp_path: Path) -> None:
    names = {kind: tmp_path / f"out.{kind}" for kind in ("pdf", "xlsx", "zip")}
    status, out, _ = run(
        "diagnose", "--flows", flows, *UNIT, "--pdf", names["pdf"], "--xlsx", names["xlsx"], "--job-file", names["zip"]
    )
    assert status == 0
    printed = text_of(names["pdf"].read_bytes())
    for shown in (" ".join(out.split()), printed):
        assert "Flows caught in a jug" in shown
        assert "at least 3.44" in shown
        assert "3.80" in shown
    assert "Before it was opened" in printed
    sheet = openpyxl.load_workbook(io.BytesIO(names["xlsx"].read_bytes()))["Before opening"]
    cells = [[cell.value for cell in row] for row in sheet.iter_rows()]
    assert cells[0][0] == "Flows caught in a jug"
    assert cells[2][2] == pytest.approx(3.784, abs=0.0)
    assert cells[2][4] == "at least 3.44"


def test_consumers_are_named_in_the_readers_language(run: Run, flows: Path, tmp_path: Path) -> None:
    report = tmp_path / "out.pdf"
    assert run("diagnose", "--flows", flows, *UNIT, "--pdf", report, "--language", "de")[0] == 0
    said = text_of(report.read_bytes())
    section = said[said.index("Messbecher") :]
    assert "Wandler, Kühler" in section
    assert "converter, cooler" not in section[:600]


def test_a_batch_of_job_files_keeps_them(run: Run, flows: Path, vacuum: Path, tmp_path: Path) -> None:
    job = tmp_path / "job.zip"
    assert run("diagnose", "--flows", flows, "--vacuum", vacuum, *UNIT, "--job-file", job)[0] == 0
    assert run("report", job, "--format", "json", "--out", tmp_path / "reports")[0] == 0
    record = json.loads((tmp_path / "reports" / "job.json").read_text(encoding="utf-8"))
    assert [each["bound"] for each in record["flows"]] == [True, False]


def test_the_job_book_keeps_them(run: Run, flows: Path, vacuum: Path) -> None:
    identity = run("jobs", "add", "--flows", flows, "--vacuum", vacuum, *UNIT)[1].strip()
    shown = json.loads(run("jobs", "show", identity, "--json", "-")[1])
    assert [each["bound"] for each in shown["flows"]] == [True, False]
    assert [each["circuit"] for each in shown["vacuum"]] == ["forward_clutch", None]
    assert run("jobs", "verify")[0] == 0


def test_a_vacuum_test_alone_measures_its_land(run: Run, record_of, vacuum: Path) -> None:
    record = record_of("--vacuum", vacuum, *UNIT)
    land = next(each for each in record["lands"] if (each["component"], each["land"]) == ("boost_valve", 1))
    assert land["radial_clearance_um"] is not None
    assert land["verdict"] != "not_measured"
    assert record["readings"]["lands_total"] == 34


def test_a_row_of_a_fleet_may_hold_nothing_else(run: Run, flows: Path, tmp_path: Path) -> None:
    table = tmp_path / "fleet.csv"
    table.write_text("Valve body;Flows;Vacuum test\nfive_speed_2005;flows.csv;\n", encoding="utf-8")
    status, _, err = run("fleet", "run", table, "--out", tmp_path / "results", "--workers", "1")
    assert (status, err) == (0, "")


def test_a_bad_table_exits_2_with_its_place(run: Run, tmp_path: Path) -> None:
    for option, text, said in (
        ("--flows", "condition,what,value\nhot_idle,cooler,x4 l/min\n", "row 2, column value: not accepted as flow"),
        ("--vacuum", "supply,25,in-Hg\ncircuit,reading\nclutch,17\n", "row 3, column circuit: no circuit or land"),
    ):
        path = tmp_path / "bad.csv"
        path.write_text(text)
        status, out, err = run("diagnose", option, path, *UNIT)
        assert (status, out) == (2, "")
        assert f"bad.csv, {said}" in err


def test_nothing_at_all_names_both_options(run: Run) -> None:
    status, _, err = run("diagnose")
    assert status == 2
    assert "--vacuum FILE or --flows FILE" in err
