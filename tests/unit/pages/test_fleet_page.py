"""The page of a fleet: which results it offers, what it shows of them, and the way down to a unit's own job."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from streamlit.testing.v1 import AppTest

from atleak.common.files import home
from atleak.common.verdicts import Verdict
from atleak.fleet.folder import known_folders, note
from atleak.fleet.results import Results
from atleak.fleet.sources import find_units
from atleak.fleet.worker import evaluate_unit
from atleak.job.parts import job_parts
from atleak.job.zip_file import write_job_file
from atleak.job_book.book import open_book
from atleak.job_book.search import Query
from atleak.measurements.job_card import Job
from pages.shared import fleet, show
from tests.unit.fleet.made_up import CONTROLLERS, GROUPS, made_up_results
from tests.unit.fleet.small_units import small_unit
from tests.unit.pages.conftest import go, part_shown, texts

PAGE = "12_Fleet"
RANKS = ("not measured", "ok", "watch", "replace", "critical")
pytestmark = pytest.mark.page("20_Library")


def shown(app: AppTest, folder: Path, **address: str) -> AppTest:
    """The page, as its address names a folder and what else is chosen there."""
    note(folder)
    app.query_params["fleet"] = known_folders()[0].id
    for name, value in address.items():
        app.query_params[name] = value
    return go(app, PAGE)


def units(app: AppTest) -> Any:
    """The table of units: the one with what decided."""
    return next(each for each in app.dataframe if "Decided by" in each.value)


def pick(app: AppTest, row: int) -> AppTest:
    app.session_state[units(app).key] = {"selection": {"rows": [row], "columns": [], "cells": []}}
    return app.run()


def choice(app: AppTest, label: str) -> Any:
    """A selection on the page, not in the sidebar."""
    return next(each for each in app.main.selectbox if each.label == label)


def job_file(path: Path, number: int) -> Path:
    path.parent.mkdir(exist_ok=True)
    unit = small_unit(number)
    assert unit.case is not None
    path.write_bytes(write_job_file(unit.case.diagnose(), Job(number=f"N{number}"), unit.case))
    return path


@pytest.fixture
def evaluated(tmp_path: Path) -> Path:
    """The results of two units, whose job files lie beside them."""
    for number, group in enumerate(("north", "south")):
        job_file(tmp_path / "jobs" / f"{group}_{number}.zip", number)
    with Results.open(tmp_path / "fleet", for_writing=True) as results:
        results.add([evaluate_unit(unit) for unit in find_units([tmp_path / "jobs"])])
    return tmp_path / "fleet"


def test_without_a_fleet_the_page_says_how_to_make_one(app: AppTest) -> None:
    go(app, PAGE)
    assert not app.exception
    assert "No fleet has been evaluated on this computer yet" in texts(app)
    assert [each.value for each in app.code] == [fleet.COMMAND]
    assert not app.header


def test_a_folder_that_is_gone_is_said_and_can_be_forgotten(app: AppTest, tmp_path: Path) -> None:
    note(tmp_path / "gone")
    go(app, PAGE)
    assert "gone** holds no results of a fleet that can be read" in texts(app)
    assert fleet.COMMAND in [each.value for each in app.code]
    next(each for each in app.button if each.label == "Forget").click().run()
    assert not app.exception
    assert "gone" not in texts(app)
    assert known_folders() == ()


def test_a_damaged_list_of_folders_is_set_aside_and_said(app: AppTest, tmp_path: Path) -> None:
    note(tmp_path / "gone")
    path = home() / "fleets.json"
    path.write_bytes(damaged := path.read_bytes()[:-4])
    go(app, PAGE)
    assert not app.exception
    (aside,) = home().glob("fleets.json.damaged-*")
    assert aside.read_bytes() == damaged
    said = [each.value.replace("\\", "") for each in app.warning]
    assert [each.startswith("The list of the results") and str(aside) in each for each in said] == [True]
    note(tmp_path / "gone")
    assert [folder.path.name for folder in known_folders()] == ["gone"]
    assert list(home().glob("fleets.json.damaged-*")) == [aside]


def test_results_are_shown_as_a_whole_by_valve_body_and_by_group(app: AppTest, tmp_path: Path) -> None:
    made_up_results(tmp_path / "fleet", units=60)
    shown(app, tmp_path / "fleet", body=CONTROLLERS[1], by="group")
    assert not app.exception
    assert not app.error
    said = texts(app)
    assert "of 60" in said
    assert "Files without a result: 4" in said
    assert "bad_0.zip: this is what a person would have been told" in said
    assert "north/bad_0.zip: bad_0.zip" not in said
    assert choice(app, "Groups by").value == "group"
    assert "The 3 groups by “group”, each compared with each." in said
    charts = " ".join(each.proto.id for each in app.get("plotly_chart"))
    drawn = ("verdicts", "pairs", "wear", "temperatures", "groups", "differences")
    assert [name for name in drawn if f"fleet-{name}" not in charts] == []
    # every unit stands in the list, the worst first; it is narrowed down
    table = units(app).value
    assert len(table) == show.PAGE
    ranks = [RANKS.index(_word(each)) for each in table["Verdict"]]
    assert ranks == sorted(ranks, reverse=True)
    assert set(table["Group"]) <= set(GROUPS)
    choice(app, "Verdict").select(Verdict.WATCH).run()
    assert {_word(each) for each in units(app).value["Verdict"]} == {"watch"}
    choice(app, "Group").select(GROUPS[1]).run()
    assert set(units(app).value["Group"]) == {GROUPS[1]}
    next(each for each in app.text_input if each.label == "Look up").set_value("nothing like it").run()
    assert "No unit fits." in texts(app)
    go(go(app, "20_Library"), PAGE)
    assert choice(app, "Groups by").value == "group"
    assert "No unit fits." in texts(app)


def _word(cell: str) -> str:
    return cell.strip().partition(" ")[2]


def test_a_unit_is_opened_as_its_own_job_and_that_can_be_undone(app: AppTest, evaluated: Path) -> None:
    shown(app, evaluated)
    assert list(units(app).value["Unit"]) == ["north_0.zip", "south_1.zip"]
    pick(app, 1)
    assert not app.exception
    assert "south_1.zip" in texts(app)
    lands = next(each.value for each in app.dataframe if "Clearance [µm]" in each.value)
    assert [_word(each) for each in lands["Verdict"]] == ["ok", *(["not measured"] * 4)]
    app.button(key="fleet-open").click().run()
    assert not app.exception
    assert part_shown(app) == "diagnosis="
    assert app.session_state["job-record"].number == "N1"
    assert app.session_state["atleak"].good.readings.name == "1.csv"
    assert not app.session_state["atleak"].in_book.judged_otherwise
    with_book = open_book()
    assert with_book.count(Query()) == 0  # a unit that is only looked at is not in the job book
    with_book.engine.dispose()
    assert app.button(key="undo").label.replace("\\", "") == "Undo: N1 opened"
    app.button(key="undo").click().run()
    assert app.session_state["atleak"].good.sample
    go(app, PAGE)  # the folder is the one that was chosen
    assert len(units(app).value) == 2


def test_the_address_of_an_opened_unit_opens_it_again_after_a_reload(app: AppTest, evaluated: Path) -> None:
    shown(app, evaluated)
    pick(app, 1)
    app.button(key="fleet-open").click().run()
    address = app.query_params["fleet-unit"]
    del app.session_state["atleak"]  # a reload begins a session of its own
    del app.session_state["job-record"]
    go(app, "4_Diagnosis")
    assert not app.exception
    assert app.session_state["job-record"].number == "N1"
    assert app.session_state["atleak"].good.readings.name == "1.csv"
    assert app.query_params["fleet-unit"] == address
    (evaluated.parent / "jobs" / "south_1.zip").unlink()
    del app.session_state["atleak"]
    go(app, "4_Diagnosis")
    assert not app.exception
    assert "the unit of a fleet that the address names" in texts(app)
    assert app.session_state["atleak"].good.sample


def test_the_address_of_a_unit_from_the_job_book_opens_the_job_of_the_book(app: AppTest, tmp_path: Path) -> None:
    with_book = open_book()
    case, job = small_unit(3).opened()
    saved = with_book.save(job_parts(case.diagnose(), job, case))
    with Results.open(tmp_path / "fleet", for_writing=True) as results:
        results.add([evaluate_unit(unit) for unit in find_units([], book=Query())])
    (row,) = Results.open(tmp_path / "fleet").table("units").to_pylist()
    note(tmp_path / "fleet")
    address = f"{known_folders()[0].id}-{row['input_sha256']}"
    app.query_params["fleet-unit"] = address
    go(app, "4_Diagnosis")
    assert not app.exception
    assert app.session_state["atleak"].in_book.id == saved.id, "no second job of the same unit"
    assert app.query_params["job"] == saved.id
    assert "fleet-unit" not in app.query_params
    assert with_book.count(Query()) == 1
    with_book.engine.dispose()


def test_a_unit_whose_file_has_changed_says_so_and_its_results_stay(app: AppTest, evaluated: Path) -> None:
    job_file(evaluated.parent / "jobs" / "north_0.zip", 5)
    shown(app, evaluated)
    pick(app, 0)
    app.button(key="fleet-open").click().run()
    assert not app.exception
    said = texts(app)
    assert "Its job cannot be opened." in said
    assert "other content now" in said
    assert "What the results hold of it stands below." in said
    assert any("Clearance [µm]" in each.value for each in app.dataframe)
    assert app.session_state["atleak"].good.sample
    pick(app, 1)
    assert "other content now" not in texts(app)


def test_what_a_run_adds_is_shown_when_it_is_asked_for(app: AppTest, evaluated: Path) -> None:
    shown(app, evaluated)
    job_file(evaluated.parent / "jobs" / "third.zip", 2)
    with Results.open(evaluated, for_writing=True) as results:
        results.add([evaluate_unit(unit) for unit in find_units([evaluated.parent / "jobs" / "third.zip"])])
    app.run()
    assert "A run has changed these results" in texts(app)
    assert len(units(app).value) == 2
    app.button(key="fleet-anew").click().run()
    assert "A run has changed these results" not in texts(app)
    assert len(units(app).value) == 3


def test_an_address_that_names_no_known_folder_or_heading_shows_what_there_is(app: AppTest, evaluated: Path) -> None:
    note(evaluated)
    app.query_params["fleet"] = "/etc"
    app.query_params["by"] = "supplier"
    app.query_params["body"] = "no_such"
    go(app, PAGE)
    assert not app.exception
    assert "The address names results that this computer does not know" in texts(app)
    assert len(units(app).value) == 2
    assert "no unit of these results" not in texts(app)


def test_results_that_cannot_be_read_are_said_by_their_file(app: AppTest, evaluated: Path) -> None:
    part = next((evaluated / "units" / "controller=minimal_example").glob("part-*.parquet"))
    part.write_bytes(part.read_bytes()[:200])
    shown(app, evaluated)
    assert not app.exception
    assert part.name in "".join(each.value for each in app.error).replace("\\", "")


def test_a_label_of_the_same_heading_as_a_column_of_the_list_hides_none(app: AppTest, tmp_path: Path) -> None:
    found = [replace(small_unit(number), labels=(("Unit", f"U{number}"),)) for number in range(2)]
    with Results.open(tmp_path / "fleet", for_writing=True) as results:
        results.add([evaluate_unit(unit) for unit in found])
    shown(app, tmp_path / "fleet", by="unit")
    assert not app.exception
    assert list(units(app).value["Unit"]) == ["unit 0", "unit 1"]
    assert list(units(app).value["Group: Unit"]) == ["U0", "U1"]
    choice(app, "Unit").select("U1").run()
    assert list(units(app).value["Unit"]) == ["unit 1"]
