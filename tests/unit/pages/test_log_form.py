"""A road-test log in the dashboard: its form, its window, and what of it is remembered."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
from streamlit.testing.v1 import AppTest

from atleak.job.case import SourceFile
from atleak.readers.remembered_columns import recall_all
from tests.unit.pages.conftest import ROOT, columns_of, go, texts, uploader

pytestmark = pytest.mark.page("3_In_the_car#log-in-full")

TWO_PRESSURES = (
    "time [s];engine_speed [rpm];line pressure 1 [kPa];line pressure 2 [kPa];ATF temperature [°C];gear\n"
    + "".join(f"{step / 10};800;{600 + step};{900 - step};80;2\n" for step in range(100))
)


def test_a_log_with_a_question_is_settled_by_the_form(app: AppTest) -> None:
    uploader(app, "Road-test log").upload("two.csv", TWO_PRESSURES.encode(), "text/csv").run()
    assert "two.csv was not taken" in texts(app)
    assert not app.exception
    assert "Which column is it?" in texts(app)
    assert "for everyone who uses it" in texts(app)  # the form is open: it must be answered
    assert column_box(app, "main").options[2:4] == [
        "line pressure 1 [kPa] · 600 to 699 kPa",
        "line pressure 2 [kPa] · 801 to 900 kPa",
    ]
    courses = columns_table(app)["Course"]
    assert courses["line pressure 1 [kPa]"][0] < courses["line pressure 1 [kPa]"][-1]
    assert courses["line pressure 2 [kPa]"][0] > courses["line pressure 2 [kPa]"][-1]
    column_box(app, "main").select("line pressure 2 [kPa]")
    use_columns(app)
    assert not app.exception
    assert "not taken" not in texts(app)
    assert taken_from(app)["main (line) pressure"] == "line pressure 2 [kPa]"


def columns_table(app: AppTest):
    return next(each.value for each in app.dataframe if "Course" in each.value).set_index("Column of the file")


def taken_from(app: AppTest) -> dict[str, str]:
    table = next(each.value for each in app.dataframe if "Quantity" in each.value)
    return dict(zip(table["Quantity"], table["Column of the file"], strict=True))


def unfold(app: AppTest, start: str) -> AppTest:
    """Open the fold whose key begins so."""
    for key in [key for key in app.session_state["folds"] if key.startswith(start)]:
        app.session_state[key] = True
    return app.run()


def column_box(app: AppTest, start: str):
    return next(widget for widget in app.main.selectbox if widget.label.startswith(start))


def use_columns(app: AppTest) -> AppTest:
    return next(widget for widget in app.button if widget.label.startswith("Use and remember")).click().run()


def most_leakage(app: AppTest) -> float:
    return float(log_values(app)["Largest"]["leakage"])


def log_values(app: AppTest) -> pd.DataFrame:
    """Return least, mean and largest of every channel of the log that is shown, by its name."""
    unfold(app, "log-values")
    return next(each.value for each in app.dataframe if "Channel" in each.value).set_index("Channel")


def test_a_remapped_log_uploaded_again_gives_the_leakage_of_the_new_column(app: AppTest) -> None:
    log = TWO_PRESSURES.replace("line pressure 1", "main_pressure").encode()
    uploader(app, "Road-test log").upload("two.csv", log, "text/csv").run()
    first = most_leakage(app)
    unfold(app, "columns-")
    column_box(app, "main").select("line pressure 2 [kPa]")
    use_columns(app)
    second = most_leakage(app)
    assert second > 1.2 * first  # 900 kPa at most, not 699
    uploader(app, "Road-test log").set_value(None).run()
    uploader(app, "Road-test log").upload("two.csv", log, "text/csv").run()
    assert not app.exception
    assert most_leakage(app) == second
    assert column_box(unfold(app, "columns-"), "main").value == "line pressure 2 [kPa]"


def test_what_was_settled_earlier_stays_when_something_else_is_settled(app: AppTest) -> None:
    uploader(app, "Road-test log").upload("two.csv", TWO_PRESSURES.encode(), "text/csv").run()
    column_box(app, "main").select("line pressure 2 [kPa]")
    use_columns(app)
    uploader(app, "Road-test log").set_value(None).run()
    uploader(app, "Road-test log").upload("again.csv", TWO_PRESSURES.encode(), "text/csv").run()
    column_box(unfold(app, "columns-"), "converter").select("line pressure 1 [kPa]")
    use_columns(app)
    assert not app.exception
    taken = taken_from(app)
    assert taken["main (line) pressure"] == "line pressure 2 [kPa]"
    assert taken["converter pressure"] == "line pressure 1 [kPa]"


def test_columns_are_used_where_nothing_can_be_remembered(app: AppTest, tmp_path: Path) -> None:
    (tmp_path / "home").write_text("a file where the folder should be", encoding="utf-8")
    uploader(app, "Road-test log").upload("two.csv", TWO_PRESSURES.encode(), "text/csv").run()
    assert "for everyone who uses it" in texts(app)
    column_box(app, "main").select("line pressure 2 [kPa]")
    use_columns(app)
    assert not app.exception
    assert "could not be remembered" in texts(app)
    assert taken_from(app)["main (line) pressure"] == "line pressure 2 [kPa]"


def test_columns_with_which_the_log_is_refused_are_shown_and_not_remembered(app: AppTest, tmp_path: Path) -> None:
    uploader(app, "Road-test log").upload("two.csv", TWO_PRESSURES.encode(), "text/csv").run()
    column_box(app, "main").select("ATF temperature [°C]")  # 80 °C taken as a pressure
    column_box(app, "ATF").select("line pressure 1 [kPa]")
    use_columns(app)
    assert not app.exception
    assert "are not remembered" in texts(app)
    assert "is temperature, not a unit of pressure" in texts(app)
    assert column_box(app, "main").value == "ATF temperature [°C]"
    assert all(fold.proto.expanded for fold in app.expander if "about the road-test log" in fold.label)
    assert recall_all(tmp_path / "home" / "road-test-columns.json") == {}


def test_a_column_is_chosen_for_one_quantity_only(app: AppTest) -> None:
    uploader(app, "Road-test log").upload("two.csv", TWO_PRESSURES.encode(), "text/csv").run()
    column_box(app, "main").select("line pressure 1 [kPa]")
    column_box(app, "converter").select("line pressure 1 [kPa]")
    use_columns(app)
    assert "a column can hold one quantity only" in texts(app)
    assert "two.csv was not taken" in texts(app)


def test_a_log_of_which_nothing_is_recognised_opens_the_form(app: AppTest) -> None:
    strange = "Zeit;AAA;BBB\n" + "".join(f"{step / 10};{800 + step};{step % 7}\n" for step in range(60))
    uploader(app, "Road-test log").upload("strange.csv", strange.encode(), "text/csv").run()
    assert not app.exception
    assert "No column of this log was recognised" in texts(app)
    assert "there is nothing to draw" in texts(app)
    assert column_box(app, "time").options[0] == "as understood: Zeit"
    column_box(app, "engine speed").select("AAA")
    use_columns(app)
    assert not app.exception
    assert taken_from(app) == {"time": "Zeit", "engine speed": "AAA"}


def test_what_is_remembered_is_seen_forgotten_and_brought_back(app: AppTest, tmp_path: Path) -> None:
    kept = tmp_path / "home" / "road-test-columns.json"
    uploader(app, "Road-test log").upload("two.csv", TWO_PRESSURES.encode(), "text/csv").run()
    column_box(app, "main").select("line pressure 2 [kPa]")
    use_columns(app)
    damaged = kept.with_name(f"{kept.name}.damaged-2026-11-23-1")
    damaged.touch()
    go(app, "3_In_the_car#step-drive")
    unfold(app, "remembered-columns")
    assert f"a new one was begun. What it held is in {damaged}" in texts(app).replace("\\", "")
    assert "6 columns: time [s], engine_speed [rpm]" in texts(app)
    assert "main (line) pressure: line pressure 2 [kPa]" in texts(app)
    next(widget for widget in app.button if widget.label == "Forget").click().run()
    assert not app.exception
    assert recall_all(kept) == {}
    assert taken_from(app)["main (line) pressure"] == "line pressure 2 [kPa]"  # the job keeps its columns
    next(widget for widget in app.button if widget.label == "Undo" and widget.key == "forget-undo").click().run()
    assert [dict(each.mapping) for each in recall_all(kept).values()] == [{"main_pressure": "line pressure 2 [kPa]"}]


def test_a_formula_is_drawn_listed_kept_with_the_job_and_refused_in_words(app: AppTest) -> None:
    def draw(name: str, formula: str) -> None:
        next(field for field in app.main.text_input if field.label == "Name").set_value(name)
        next(field for field in app.main.text_input if field.label == "Formula").set_value(formula)
        next(button for button in app.button if button.label == "Draw it").click().run()
        assert not app.exception

    unfold(app, "formulas-fold")
    draw("drop", "p_g − p_k")
    table = log_values(app)
    assert table["in"]["drop"] == "kPa"
    draw("sum", "p_g + n")
    assert "at character 5: a rotational speed cannot be added to a pressure" in texts(app)
    assert [each.name for each in app.session_state["job-record"].log_formulas] == ["drop"]
    go(app, "2_Measure")
    go(app, "3_In_the_car#log-in-full")
    assert "drop" in log_values(app).index
    next(button for button in app.button if button.label == "Take away").click().run()
    assert app.session_state["job-record"].log_formulas == ()


def test_the_operating_map_is_drawn_where_it_is_asked_for(app: AppTest) -> None:
    assert "how long it was driven there" not in texts(app)
    unfold(app, "operating-map")
    assert not app.exception
    assert "how long it was driven there" in texts(app)
    next(box for box in app.main.selectbox if box.label == "Show").select("engine_speed").run()
    assert not app.exception


def test_remembered_columns_go_into_the_job_file(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.syspath_prepend(str(ROOT))
    monkeypatch.setenv("ATLEAK_HOME", str(tmp_path / "home"))
    from pages.shared import cases

    log = SourceFile("two.csv", TWO_PRESSURES.encode())
    cases.remember_columns(log, {"main_pressure": "line pressure 2 [kPa]"}, {})
    chosen = cases.case_with_columns(cases.PageCase(road_test=log)).log_choices
    assert chosen == {"mapping": {"main_pressure": "line pressure 2 [kPa]"}, "units": {}, "constants": {}, "every": 1}


def test_a_window_of_the_log_is_evaluated_and_remembered(app: AppTest) -> None:
    def largest() -> float:
        return most_leakage(app)

    assert largest() == pytest.approx(2.92, rel=0.02, abs=0.0)
    app.main.slider[0].set_value((8.0, 12.0)).run()
    assert not app.exception
    less = largest()
    assert less < 2.6
    go(app, "2_Measure")
    go(app, "3_In_the_car#log-in-full")
    assert app.main.slider[0].value == (8.0, 12.0)
    assert largest() == less


def test_another_log_stays_laid_over_the_jobs(app: AppTest, sample_log: Path) -> None:
    next(widget for widget in app.main.file_uploader if widget.label == "Other road-test log").upload(
        "after.csv", sample_log.read_bytes(), "text/csv"
    ).run()
    next(widget for widget in app.main.text_input if widget.label == "Shifted by [s]").set_value("1,25").run()
    assert not app.exception
    table = log_values(app)
    assert table["Mean"]["engine speed, after.csv"] == table["Mean"]["engine speed"]
    go(app, "2_Measure")
    go(app, "3_In_the_car#log-in-full")
    assert "after.csv" in texts(app)
    assert next(widget for widget in app.main.text_input if widget.label == "Shifted by [s]").value == "1,25"
    next(widget for widget in app.button if widget.label == "Take it away").click().run()
    assert "after.csv" not in texts(app)


# --- a log without a sheet


@pytest.mark.page("4_Diagnosis?diagnosis=log")
def test_a_log_alone_is_judged_by_its_main_pressure(app: AppTest, sample_log: Path) -> None:
    low = [line.split(";") for line in sample_log.read_text(encoding="utf-8").splitlines()]
    rows = [";".join(low[0]), *(";".join([*row[:2], f"{0.4 * float(row[2]):.2f}", *row[3:]]) for row in low[1:])]
    uploader(app, "Road-test log").upload("low.csv", "\n".join(rows).encode(), "text/csv").run()
    assert not app.exception
    assert app.title[0].value == ":red[✖ critical] · provisional"
    assert "\nMain pressure stayed below what is permitted for 11" in texts(app)
    headings = [widget.value for widget in app.header]
    assert headings == ["What the road test says", "Over the road test"]
    assert "Main pressure is low in every gear and state that was judged" in texts(app)
    assert "(choice of this project)" in texts(app)
    assert "that of a unit with every pair new" in texts(app)
    go(app, "3_In_the_car#log-in-full")
    assert "✖ critical" in texts(app)
    states = next(each.value for each in app.dataframe if "State" in each.value)
    assert states["State"].tolist() == ["idle", *["driving"] * 4]
    happened = next(each.value for each in app.dataframe if "Event" in each.value)
    assert "minimum-acceleration test" in happened["Event"].tolist()


@pytest.mark.page("4_Diagnosis?diagnosis=log")
def test_a_log_without_main_pressure_is_taken_and_says_what_to_gauge(app: AppTest, sample_log: Path) -> None:
    uploader(app, "Road-test log").upload("phone.csv", columns_of(sample_log, 2), "text/csv").run()
    assert not app.exception
    assert "not taken" not in texts(app)
    assert app.title[0].value.startswith(":blue[○ not measured]")
    assert "\nThe log holds no main pressure" in texts(app)
    assert "Gauge it at the main pressure tap in P R N D 3 2 1" in texts(app)
    assert "No leakage is computed over phone.csv" in texts(app)
    assert "1201 rows" in texts(app)


def test_a_log_without_clock_and_pressure_takes_an_interval_and_the_operating_points(app: AppTest) -> None:
    rows = "".join(f"{1500 + step % 7};{83 + step % 3}\n" for step in range(100))
    uploader(app, "Road-test log").upload("dump.txt", rows.encode(), "text/plain").run()
    assert "has no header" in texts(app)
    column_box(app, "engine speed").select("column 1")
    next(
        widget for widget in app.main.selectbox if widget.key.startswith("unit-") and "engine_speed" in widget.key
    ).select("rpm")
    next(widget for widget in app.main.checkbox if widget.label.startswith("Assume the main pressure")).check()

    def interval():
        return next(each for each in app.main.text_input if each.label.startswith("Seconds from row to row"))

    interval().input("o.1")
    use_columns(app)
    drawn = list(app.main)
    beneath = drawn[next(at for at, each in enumerate(drawn) if each.key == interval().key) + 1]
    assert beneath.type == "error"
    assert beneath.value.startswith("'o.1' is not a number")
    interval().input("0.1")
    use_columns(app)
    assert not app.exception
    assert "the file names no columns by which others like it could be told" in texts(app)
    assert taken_from(app)["engine speed"] == "column 1"
    assert most_leakage(app) > 0.0


@pytest.mark.page("3_In_the_car#log-in-full")
def test_another_part_of_the_log_diagnoses_and_reads_nothing_again(
    app: AppTest, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only the leakage over it is computed, by the engine that the diagnosis keeps."""

    def again(*_: object, **__: object) -> None:
        raise AssertionError("the whole job is worked on again")

    works = "job.case.diagnose", "diagnosis.examination.assess", "job.case.understand", "job.case.read_readings"
    for worked in works:
        monkeypatch.setattr(f"atleak.{worked}", again)
    monkeypatch.setattr("pages.shared.cases.understand", again)
    whole = log_values(app)
    cursors = next(widget for widget in app.main.slider if "Part shown" in widget.label)
    cursors.set_value((3.0, 9.0)).run()
    assert not app.exception
    assert not log_values(app).equals(whole)
    cursors.set_value((3.001, 3.004)).run()  # between two samples
    assert not app.exception
    assert len(log_values(app))
