"""Rows of a table as units: files, choices and record of each, and what is wrong with one told in its place."""

from __future__ import annotations

import datetime as dt
import os
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from atleak.common.errors import AtleakError, InputError
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.fleet.sources import find_units
from atleak.fleet.unit_table import choices_read, written_choices
from atleak.fleet.units import FleetUnit
from atleak.job.case import Case, SourceFile
from atleak.job.zip_file import write_job_file
from atleak.measurements.job_card import Job
from atleak.readers.logs import default_path, remember, understand

Fleet = Callable[..., list[FleetUnit]]


@pytest.fixture
def fleet(own_home: Path, tmp_path: Path) -> Fleet:
    """The units of a table of these lines, beside which the files ``a.csv``, ``b.csv`` and ``logs/a.csv`` lie."""
    (tmp_path / "logs").mkdir()
    for name in ("a.csv", "b.csv", "logs/a.csv"):
        (tmp_path / name).write_text(f"{name}\n", encoding="utf-8")

    def units(*lines: str, defaults: Case | None = None) -> list[FleetUnit]:
        table = tmp_path / "fleet.csv"
        table.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return list(find_units([table], defaults=defaults))

    return units


def _case(unit: FleetUnit) -> Case:
    return unit.opened()[0]


def _fault(unit: FleetUnit) -> str:
    with pytest.raises(AtleakError) as raised:
        unit.opened()
    return str(raised.value)


def test_a_row_names_files_choices_and_what_is_written_down(fleet: Fleet) -> None:
    (unit,) = fleet(
        "Sheet;Log;Valve body;Fluid;Limits;Job;VIN;S/N;Mileage;Date;Measured on;Customer;Group;Supplier;Batch",
        "a.csv;logs/a.csv;five_speed_2005;mercedes_236_10;new_part_clearance;A-17;WVW1;0815;123 456,5;17.4.2026;"
        "2026-04-16;Kowalski;north;Müller;3",
    )
    case, job = unit.opened()
    assert (unit.name, unit.group) == ("fleet.csv, row 2", "north")
    assert unit.labels == (("Supplier", "Müller"), ("Batch", "3"))  # and no customer among them
    assert case == Case(
        readings=SourceFile("a.csv", b"a.csv" + os.linesep.encode()),
        road_test=SourceFile("a.csv", b"logs/a.csv" + os.linesep.encode()),
        controller="five_speed_2005",
        fluid="mercedes_236_10",
        limits="new_part_clearance",
        mileage=123456.5,
        remember=False,
    )
    assert (job.number, job.vehicle.vin, job.transmission.serial) == ("A-17", "WVW1", "0815")
    assert (job.date, job.measured_on) == (dt.date(2026, 4, 17), dt.date(2026, 4, 16))
    assert (job.customer.name, job.vehicle.mileage_km) == ("Kowalski", 123456.5)


def test_every_other_choice_of_a_row_counts(fleet: Fleet) -> None:
    (unit,) = fleet(
        "sheet;fluid state;stated temperature;rpm;gear;complaint;repairs;sheet name;sheet unit;where;fill down;map;"
        "log units;measuring temperature;pump side clearance;pump tip clearance;spool instrument",
        'a.csv;Used;95,5;900;3;slip;a, b;May;mm;"Inspection=May; Car=7";yes;main_pressure=PL;main_pressure=bar;21,5;45;'
        "150;micrometer",
    )
    case, job = unit.opened()
    assert (case.fluid_state, case.temperature, case.engine_speed, case.gear) == ("used", 95.5, 15.0, 3)
    assert (case.complaint, case.repairs) == ("slip", ("a", "b"))
    assert (case.sheet_name, case.sheet_unit, case.sheet_fill_down) == ("May", "mm", True)
    assert case.sheet_where == (("Inspection", "May"), ("Car", "7"))
    assert (case.columns, case.units) == ((("main_pressure", "PL"),), (("main_pressure", "bar"),))
    assert (case.measuring_temperature, job.measuring_temperature_c) == (21.5, 21.5)
    assert case.pump_clearances.um == (45.0, 150.0)
    assert case.spool_instrument == "micrometer"


def test_a_row_counts_before_the_choices_for_all_rows(fleet: Fleet) -> None:
    defaults = Case(controller="five_speed_2005", measuring_temperature=25.0, gear=2, guard_factor=1.5)
    first, second = map(
        _case, fleet("sheet,controller,measuring temperature", "a.csv,four_speed_2023,20", "b.csv,,", defaults=defaults)
    )
    assert (first.controller, first.measuring_temperature) == ("four_speed_2023", 20.0)
    assert (second.controller, second.measuring_temperature) == ("five_speed_2005", 25.0)
    assert {case.gear for case in (first, second)} == {2}
    assert {case.guard_factor for case in (first, second)} == {1.5}


def test_the_choices_for_all_rows_are_written_and_read_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.toml").write_text("", encoding="utf-8")
    case = Case(controller="own.toml", columns=(("main_pressure", "PL"),), constants=(("time", 0.1),), gear=2)
    monkeypatch.chdir(tmp_path.parent)
    assert choices_read(written_choices(Case())) == Case()
    monkeypatch.chdir(tmp_path)
    again = choices_read(written_choices(case))
    assert again == Case(
        controller=str(tmp_path / "own.toml"),
        columns=(("main_pressure", "PL"),),
        constants=(("time", 0.1),),
        gear=2,
    )


def test_own_files_of_the_catalogue_go_along(fleet: Fleet, edited: Callable[..., Path], tmp_path: Path) -> None:
    own = edited("controllers", "minimal_example")
    (tmp_path / "own").mkdir()
    content = own.read_bytes()
    (tmp_path / "own" / "body.toml").write_bytes(content)
    (unit,) = fleet("sheet,controller", "a.csv,own/body.toml")
    (tmp_path / "own" / "body.toml").unlink()
    assert _case(unit).controller == SourceFile("body.toml", content)


def test_a_record_is_read_and_the_row_counts_before_it(fleet: Fleet, tmp_path: Path) -> None:
    record = 'number = "R-1"\nmeasuring_temperature_c = 22.0\n[vehicle]\nmileage_km = 5000.0\nvin = "V1"\n'
    (tmp_path / "job.toml").write_text(record, encoding="utf-8")
    (unit,) = fleet("sheet,record,mileage", "a.csv,job.toml,7000")
    case, job = unit.opened()
    assert (job.number, job.vehicle.vin, job.vehicle.mileage_km) == ("R-1", "V1", 7000.0)
    assert (case.mileage, case.measuring_temperature) == (7000.0, 22.0)


def test_what_is_wrong_with_a_row_is_its_own_error_with_every_place(fleet: Fleet) -> None:
    good, bad = fleet(
        "Sheet;Log;Mileage;Gear;Fill down;Controller;Fluid state;Date;Where",
        "a.csv;;1000;;;;;;",
        "x.xlsx;logs;123.456;2,5;perhaps;four_sped_2023;old;03/04/2026;May",
    )
    assert _case(good).mileage == 1000.0
    lines = _fault(bad).splitlines()
    said = {
        "Sheet": "no such file (found 'x.xlsx'); expected the path of a file, from the folder of the table on",
        "Log": "is a folder (found 'logs')",
        "Mileage": "'123.456' can be read in two ways",
        "Gear": "a whole number is asked for (found '2,5')",
        "Fill down": "says neither yes nor no (found 'perhaps')",
        "Controller": "did you mean 'four_speed_2023'?",
        "Fluid state": "not one of those that there are (found 'old'); expected one of fresh, used",
        "Date": "no date that can be read in one way (found '03/04/2026'); expected a date such as 2026-04-17",
        "Where": "no such pairs (found 'May'); expected NAME=VALUE",
    }
    assert len(lines) == len(said)
    for column, text in said.items():
        (line,) = [each for each in lines if f"fleet.csv, row 3, column {column}: " in each]
        assert text in line
    assert (bad.case, bad.job) == (None, None)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (",1000", "fleet.csv, row 2: the row names nothing to diagnose; expected a measuring sheet, a log"),
        ("a.csv,12,5", "fleet.csv, row 2: the row has more cells than there are headings (found '5')"),
        ("a.csv,-3", "column mileage: −3 km is not taken: the mileage must be from 0 to 9999999 km (found '-3')"),
    ],
)
def test_a_row_that_says_too_little_or_too_much_is_refused(fleet: Fleet, line: str, said: str) -> None:
    (unit,) = fleet("sheet,mileage", line)
    assert said in _fault(unit)


def test_a_file_that_appears_later_makes_it_another_input(fleet: Fleet, tmp_path: Path) -> None:
    lines = ("sheet,mileage", "later.csv,1000")
    (before,) = fleet(*lines)
    (tmp_path / "later.csv").write_text("x", encoding="utf-8")
    (after,) = fleet(*lines)
    assert before.reference == after.reference
    assert before.input_sha256 != after.input_sha256
    assert _fault(before).endswith("from the folder of the table on")
    assert _case(after).readings is not None


def test_days_and_months_are_told_by_the_other_dates_of_the_column(fleet: Fleet) -> None:
    units = fleet("sheet,date,measured on", "a.csv,03/04/2026,03/04/2026", "b.csv,03/14/2026,25/03/2026")
    (first, second) = (unit.opened()[1] for unit in units)
    assert (first.date, second.date) == (dt.date(2026, 3, 4), dt.date(2026, 3, 14))
    assert (first.measured_on, second.measured_on) == (dt.date(2026, 4, 3), dt.date(2026, 3, 25))


def test_a_mileage_in_miles_becomes_kilometres(fleet: Fleet) -> None:
    first, second = fleet("sheet,Odometer (miles)", "a.csv,100000", "b.csv,100000 km")
    assert _case(first).mileage == pytest.approx(160934.4, abs=1e-6)
    assert _case(second).mileage == 100000.0


def test_cells_with_a_type_are_not_read_as_text(own_home: Path, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(b"a")
    frame = pd.DataFrame(
        {"sheet": ["a.csv"], "mileage": [123.456], "date": [dt.date(2026, 4, 17)], "batch": [3.0], "job": [17]}
    )
    frame.to_parquet(tmp_path / "fleet.parquet")
    (unit,) = find_units([tmp_path / "fleet.parquet"])
    case, job = unit.opened()
    assert (case.mileage, job.date, job.number) == (123.456, dt.date(2026, 4, 17), "17")
    assert unit.labels == (("batch", "3"),)


@pytest.mark.skipif(os.name == "nt", reason="Windows reads such a path itself")
def test_a_path_that_was_written_on_windows_is_found(fleet: Fleet) -> None:
    (unit,) = fleet("log", '"logs\\a.csv"')
    assert _case(unit).road_test is not None


def test_job_files_get_their_labels_from_a_table(fleet: Fleet, unmeasured: Diagnosis, tmp_path: Path) -> None:
    (tmp_path / "7.zip").write_bytes(write_job_file(unmeasured, Job(number="7")))
    one, other = fleet("job file,group,batch,mileage", "7.zip,north,3,1000", "7.zip,north,4,1000")
    assert one.opened()[1].number == "7"
    assert (one.group, one.labels) == ("north", (("batch", "3"), ("mileage", "1000")))
    assert one.input_sha256 != other.input_sha256


def test_what_leads_to_a_person_is_no_label_beside_a_job_file(
    fleet: Fleet, unmeasured: Diagnosis, tmp_path: Path
) -> None:
    (tmp_path / "7.zip").write_bytes(write_job_file(unmeasured, Job(number="7")))
    heading = "Auftragsdatei;Kunde;Kennzeichen;Techniker;Serial;Batch"
    (unit,) = fleet(heading.replace("Auftragsdatei", "job file"), "7.zip;Kowalski;WA 12345;Nowak;0815;B7")
    assert unit.labels == (("Serial", "0815"), ("Batch", "B7"))
    (message,) = find_units([tmp_path / "fleet.csv"]).messages
    assert str(message.text) == "columns that are kept as labels of their units: Serial, Batch"


@pytest.mark.parametrize(
    ("heading", "cell", "said"),
    [
        ("Schieberkastn", "mine", "is a mere label of its units; did you mean 'Schieberkasten'?"),
        (
            "Schieberkastn",
            "five_speed_2005",
            "is a mere label of its units, though it says 'five_speed_2005'; did you mean 'Schieberkasten'?",
        ),
        ("Straßenfahrt", "logs/a.csv", "is a mere label of its units, though it says 'logs/a.csv'"),
        ("Supplier", "Almar", None),
        ("Batch", "7", None),
        ("Test stand", ".", None),
    ],
)
def test_a_label_that_may_be_a_misspelt_column_is_doubted(
    fleet: Fleet, tmp_path: Path, heading: str, cell: str, said: str | None
) -> None:
    fleet(f"sheet;{heading}", "b.csv;", f"a.csv;{cell}")
    messages = find_units([tmp_path / "fleet.csv"]).messages
    doubts = [(str(each.text), str(each.place)) for each in messages if each.level == "warning"]
    assert doubts == ([] if said is None else [(said, f"fleet.csv, column {heading}")])


def test_rows_are_known_by_their_files_and_number_wherever_they_stand(fleet: Fleet) -> None:
    lines = ["sheet,number,batch", "a.csv,1,x", "b.csv,2,x", "a.csv,3,x"]
    references = {unit.opened()[1].number: unit.reference for unit in fleet(*lines)}
    assert len(set(references.values())) == 3
    sorted_anew = fleet(lines[0], "b.csv,4,x", lines[3], lines[2].replace("x", "y"), lines[1])
    assert {unit.opened()[1].number: unit.reference for unit in sorted_anew}.items() >= references.items()


def test_the_same_row_twice_is_evaluated_once_and_two_that_differ_are_two(fleet: Fleet, tmp_path: Path) -> None:
    assert len({unit.reference for unit in fleet("sheet,batch", "a.csv,x", "a.csv,y")}) == 2
    fleet("sheet,batch", "a.csv,x", "a.csv,x")
    found = find_units([tmp_path / "fleet.csv"])
    assert [unit.name for unit in found] == ["fleet.csv, row 2"]
    assert found.twice == [("fleet.csv, row 3", "fleet.csv, row 2")]


def test_columns_that_were_settled_on_this_computer_go_along(fleet: Fleet, sample_log: Path, tmp_path: Path) -> None:
    log = tmp_path / "logs" / "a.csv"
    log.write_bytes(sample_log.read_bytes())
    lines = ("log,map", "logs/a.csv,", "logs/a.csv,engine_speed=own column")
    assert [_case(unit).columns for unit in fleet(*lines)] == [(), (("engine_speed", "own column"),)]
    remember(default_path(), understand(log).signature, {"main_pressure": "p_k"}, {"main_pressure": "bar"})
    plain, mapped = map(_case, fleet(*lines))
    assert dict(plain.columns) == {"main_pressure": "p_k"}
    assert dict(plain.units) == {"main_pressure": "bar"}
    assert dict(mapped.columns) == {"main_pressure": "p_k", "engine_speed": "own column"}
    assert not plain.remember


def test_a_choice_for_all_rows_that_there_is_not_stops_before_anything_is_evaluated(fleet: Fleet) -> None:
    with pytest.raises(InputError, match="did you mean 'four_speed_2023'"):
        fleet("sheet", "a.csv", defaults=Case(controller="four_sped_2023"))
