"""Workbooks of repeated readings in the forms in which people write them."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np
import openpyxl
import pytest

from atleak.measurements.gauge_study import GaugeStudyError
from atleak.readers.gauges.gauge_study import read_study

VALUES = 12.7 + np.array(  # [mm] by part, operator, trial
    [[[0.001, 0.002], [0.003, 0.001]], [[0.010, 0.012], [0.011, 0.013]], [[0.020, 0.021], [0.022, 0.019]]]
)
PEOPLE = ("Anna", "Jan")


def long_form(point: str = ".", delimiter: str = ";", heading: str = "part;operator;trial;reading [mm]") -> str:
    rows = [heading.replace(";", delimiter)]
    rows += [
        delimiter.join([str(part + 1), PEOPLE[person], str(trial + 1), f"{VALUES[part, person, trial]:.4f}"]).replace(
            ".", point
        )
        for part in range(3)
        for person in range(2)
        for trial in range(2)
    ]
    return "\n".join(rows)


def workbook(rows: Sequence[Sequence[Any]]) -> bytes:
    book, target = openpyxl.Workbook(), io.BytesIO()
    for row in rows:
        book.active.append(list(row))
    book.save(target)
    return target.getvalue()


def refused(content: str | bytes, **options: Any) -> GaugeStudyError:
    with pytest.raises(GaugeStudyError) as caught:
        read_study(content.encode() if isinstance(content, str) else content, name="study.csv", **options)
    return caught.value


@pytest.mark.parametrize(
    "text",
    [
        long_form(),
        long_form(","),
        long_form(delimiter="\t"),
        long_form(",", heading="Teil;Prüfer;Wiederholung;Messwert [mm]"),
        long_form(",", heading="Część;Operator;Powtórzenie;Odczyt [mm]"),
        "Gauge study of a micrometer\n\n" + long_form(),
    ],
    ids=["point", "comma", "tab", "German", "Polish", "title above"],
)
def test_a_reading_on_each_row_is_read(text: str) -> None:
    study = read_study(text.encode(), name="study.csv")
    assert (study.parts, study.operators) == (("1", "2", "3"), PEOPLE)
    assert study.values * 1e3 == pytest.approx(VALUES, abs=1e-9)


def test_trials_side_by_side_are_read() -> None:
    rows = [["Part", "Operator", "1 [mm]", "2 [mm]", "Average"]]
    rows += [[part + 1, PEOPLE[who], *VALUES[part, who], 0.0] for part in range(3) for who in range(2)]
    study = read_study(workbook(rows))
    assert study.values * 1e3 == pytest.approx(VALUES, abs=1e-9)


def test_parts_side_by_side_are_read_as_aiags_form_has_them() -> None:
    rows: list[list[Any]] = [["Appraiser", "Trial", "P1", "P2", "P3"]]
    for who in range(2):
        rows += [["" if trial else PEOPLE[who], trial + 1, *VALUES[:, who, trial]] for trial in range(2)]
        rows.append(["Average", "", *VALUES[:, who].mean(axis=1)])
    study = read_study(workbook(rows))
    assert (study.parts, study.operators) == (("P1", "P2", "P3"), PEOPLE)
    assert study.values * 1e3 == pytest.approx(VALUES, abs=1e-9)


def test_people_and_trials_side_by_side_are_read() -> None:
    rows: list[list[Any]] = [["Part", "Anna 1", "Anna 2", "Jan 1", "Jan 2"]]
    rows += [[part + 1, *VALUES[part].ravel()] for part in range(3)]
    study = read_study(workbook(rows))
    assert study.operators == PEOPLE
    assert study.values * 1e3 == pytest.approx(VALUES, abs=1e-9)


def test_readings_in_inches_are_converted() -> None:
    rows: list[list[Any]] = [["part", "operator", "trial", "reading [inch]"]]
    rows += [[part, who, trial, VALUES[part, who, trial] / 25.4] for part, who, trial in np.ndindex(3, 2, 2)]
    assert read_study(workbook(rows)).values * 1e3 == pytest.approx(VALUES, abs=1e-9)


def test_the_unit_that_is_asked_for_counts_over_the_heading() -> None:
    study = read_study(long_form().encode(), name="study.csv", length_unit="inch")
    assert study.values == pytest.approx(VALUES * 0.0254, abs=1e-12)
    assert [message.code for message in study.messages if message.level == "warning"] == ["unusual_readings"]


def test_a_heading_without_a_unit_is_said_to_be_taken_as_millimetres() -> None:
    study = read_study(long_form(heading="part;operator;trial;reading").encode(), name="study.csv")
    assert "unit_assumed" in [message.code for message in study.messages]


def test_a_slipped_digit_among_the_repeats_is_doubted() -> None:
    random = np.random.default_rng(1)
    rows: list[list[Any]] = [["part", "operator", "trial", "reading [mm]"]]
    rows += [
        [part, who, trial, round(12.7 + 0.01 * part + 0.001 * random.standard_normal(), 4)]
        for part, who, trial in np.ndindex(8, 2, 3)
    ]
    assert "repeats_apart" not in [message.code for message in read_study(workbook(rows)).messages]
    rows[5][3] = float(rows[5][3]) + 0.1
    assert "repeats_apart" in [message.code for message in read_study(workbook(rows)).messages]


def test_every_cell_that_is_no_number_is_named() -> None:
    error = refused(long_form().replace("12.7010", "12.7o10", 1).replace("12.7100", "–", 1))
    assert [(each.place.row, each.value) for each in (error, *error.others)] == [(2, "12.7o10"), (6, "–")]
    assert error.place.column == "reading [mm]"


def test_a_gap_in_the_study_is_named_with_part_and_operator() -> None:
    error = refused("\n".join(long_form().splitlines()[:-1]))
    assert "operator Jan read part 3 1 time" in str(error)
    assert "expected 2 readings" in str(error)


def test_a_trial_given_twice_is_named_with_both_places() -> None:
    error = refused(long_form().replace("1;Anna;2;", "1;Anna;1;"))
    assert "part 1, operator Anna, trial 1 stands in study.csv, row 2" in str(error)
    assert error.place.row == 3


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a;b\n1;2", "holds no table of repeated readings"),
        ("part;operator;trial;reading\n", "no reading is filled in"),
        ("part;operator;trial;reading\n1;A;1;12.7\n2;A;1;12.8\n1;A;2;12.7\n2;A;2;12.8", "1 of the operators"),
        ("part;operator;trial;reading\n1;A;1;12.7\n2;A;1;12.8\n1;B;1;12.7\n2;B;1;12.8", "read every part once"),
        ("part;operator;trial;reading\n1;;1;12.7", "nothing says of which operator"),
        ("", "the file is empty"),
    ],
)
def test_a_file_that_holds_no_study_is_refused_in_words(text: str, said: str) -> None:
    assert said in str(refused(text))


def test_a_sheet_that_is_not_there_is_named_with_those_that_are() -> None:
    content = workbook([["part", "operator", "trial", "reading"]])
    with pytest.raises(GaugeStudyError, match=r"no such sheet .*'Study'.*'Sheet'"):
        read_study(content, name="study.xlsx", sheet="Study")
