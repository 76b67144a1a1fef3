"""Every column of a log with its range and course, and columns that the user says hold nothing."""

from __future__ import annotations

import gzip
import io
from pathlib import Path

import pytest

from atleak.common.errors import RoadTestError
from atleak.readers.logs import NOT_LOGGED, log_columns, understand

LOG = (
    "time [s];AAA;line pressure [bar];lever;empty\n"
    + "".join(
        f"{step / 10:.1f};{800 + step};{6.5 - step / 100:.2f};{'D' if step % 2 else 'N'};\n" for step in range(200)
    )
).encode()


def test_every_column_is_shown_with_its_range_unit_and_course() -> None:
    columns = {column.label: column for column in log_columns(LOG, name="a.csv")}
    assert list(columns) == ["time [s]", "AAA", "line pressure [bar]", "lever", "empty"]
    speed, pressure = columns["AAA"], columns["line pressure [bar]"]
    assert (speed.least, speed.largest, speed.numbers, speed.unit, speed.quantity) == (800.0, 999.0, 200, None, None)
    assert (pressure.least, pressure.largest) == (4.51, 6.5)
    assert (pressure.unit, pressure.quantity) == ("bar", "main_pressure")
    assert (pressure.curve[0], pressure.curve[-1]) == (6.5, 4.51)
    assert len(pressure.curve) <= 70
    assert (columns["lever"].numbers, columns["lever"].words) == (0, ("N", "D"))
    assert (columns["empty"].numbers, columns["empty"].words, columns["empty"].curve) == (0, (), ())


def test_a_spike_of_one_sample_stays_in_the_course() -> None:
    rows = "".join(f"{step};{5000 if step == 777 else 600}\n" for step in range(2000))
    columns = log_columns(f"time;x\n{rows}".encode(), name="a.csv")
    assert max(columns[1].curve) == 5000.0


def test_a_decimal_comma_and_a_packed_file_are_read_alike() -> None:
    comma = LOG.replace(b".", b",")
    plain, with_comma, packed = (log_columns(each, name="a") for each in (LOG, comma, gzip.compress(LOG)))
    assert plain == with_comma == packed


def test_the_names_of_a_long_log_are_its_columns() -> None:
    rows = "".join(
        f'"{step}";"{name}";"{value}";"{unit}"\n'
        for step in range(30)
        for name, value, unit in (("Engine RPM", 800 + step, "rpm"), ("Oil pressure X", 3 + step, "bar"))
    )
    columns = log_columns(f'"SECONDS";"PID";"VALUE";"UNITS"\n{rows}'.encode(), name="long.csv")
    assert [(each.label, each.unit, each.least, each.largest) for each in columns] == [
        ("Engine RPM", "rpm", 800.0, 829.0),
        ("Oil pressure X", "bar", 3.0, 32.0),
    ]


def test_a_workbook_shows_the_columns_of_its_sheet(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in [("time [s]", "AAA"), *((step / 10, 800 + step) for step in range(50))]:
        book.active.append(row)
    target = io.BytesIO()
    book.save(target)
    columns = log_columns(target.getvalue(), name="a.xlsx")
    assert [(each.label, each.largest) for each in columns] == [("time [s]", 4.9), ("AAA", 849.0)]


def test_what_is_no_log_is_refused() -> None:
    with pytest.raises(RoadTestError):
        log_columns(b"", name="empty.csv")
    assert log_columns(b"Dear Sir,\nno table here\n", name="letter.txt") == ()


# --- a quantity that no column holds


def test_a_quantity_that_no_column_holds_is_not_taken_and_not_asked_for() -> None:
    assert understand(LOG, name="a.csv").road_test.channel("main_pressure") is not None
    without = understand(LOG, name="a.csv", mapping={"main_pressure": NOT_LOGGED})
    assert without.road_test.channel("main_pressure") is None
    assert without.road_test.refused["main_pressure"] == "it is stated that no column of this log holds it"
    assert "line pressure [bar]" in without.unused


def test_two_columns_that_compete_are_no_question_once_neither_is_it() -> None:
    two = b"time [s];line pressure 1 [kPa];line pressure 2 [kPa]\n" + b"".join(
        b"%d;%d;%d\n" % (step, 600 + step, 900 - step) for step in range(60)
    )
    asked = understand(two, name="a.csv")
    assert [each.quantity for each in asked.ambiguous] == ["main_pressure"]
    assert asked.ambiguous[0].guess is None
    assert not understand(two, name="a.csv", mapping={"main_pressure": NOT_LOGGED}).ambiguous


def test_a_single_column_that_resembles_the_name_is_the_guess() -> None:
    one = b"time [s];line pressure 1 [kPa]\n" + b"".join(b"%d;%d\n" % (step, 600 + step) for step in range(60))
    (question,) = understand(one, name="a.csv").ambiguous
    assert question.guess == "line pressure 1 [kPa]"


def test_a_commanded_pressure_is_not_asked_about_where_it_is_stated_that_none_was_measured() -> None:
    log = b"time [s];commanded line pressure [kPa]\n" + b"".join(b"%d;%d\n" % (step, 600 + step) for step in range(60))
    assert [each.quantity for each in understand(log, name="a.csv").ambiguous] == ["main_pressure"]
    assert not understand(log, name="a.csv", mapping={"main_pressure": NOT_LOGGED}).ambiguous


def test_a_mapping_counts_as_used_only_where_every_column_gave_its_quantity() -> None:
    good, wrong = {"engine_speed": "AAA"}, {"engine_speed": "AAA", "atf_temperature": "line pressure [bar]"}
    assert understand(LOG, name="a.csv", mapping=good, units={"engine_speed": "rpm"}).uses(good)
    assert not understand(LOG, name="a.csv", mapping=wrong, units={"engine_speed": "rpm"}).uses(wrong)
    assert understand(LOG, name="a.csv", mapping={"gear": NOT_LOGGED}).uses({"gear": NOT_LOGGED})
