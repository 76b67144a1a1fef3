"""A road-test log in the dashboard: its form, its window, and what of it is remembered."""

from __future__ import annotations

from pathlib import Path

import pytest
from streamlit.testing.v1 import AppTest

from atleak.job.case import SourceFile

from .conftest import ROOT, go, texts, uploader

pytestmark = pytest.mark.page("3_Road_test")

TWO_PRESSURES = (
    "time [s];engine_speed [rpm];line pressure 1 [kPa];line pressure 2 [kPa];ATF temperature [°C];gear\n"
    + "".join(f"{step / 10};800;{600 + step};{900 - step};80;2\n" for step in range(100))
)


def test_a_log_with_a_question_is_settled_by_the_form(app: AppTest) -> None:
    uploader(app, "Road-test log").upload("two.csv", TWO_PRESSURES.encode(), "text/csv").run()
    assert "two.csv was not taken" in texts(app)
    assert not app.exception
    assert "Which column is it?" in texts(app)
    next(widget for widget in app.main.selectbox if widget.label.startswith("main")).select("line pressure 2 [kPa]")
    next(widget for widget in app.button if widget.label.startswith("Use and remember")).click().run()
    assert not app.exception
    assert "not taken" not in texts(app)
    taken = app.dataframe[0].value.set_index("quantity")["column"]
    assert taken["main (line) pressure"] == "line pressure 2 [kPa]"


def column_box(app: AppTest, start: str):
    return next(widget for widget in app.main.selectbox if widget.label.startswith(start))


def use_columns(app: AppTest) -> AppTest:
    return next(widget for widget in app.button if widget.label.startswith("Use and remember")).click().run()


def most_leakage(app: AppTest) -> float:
    return app.dataframe[-1].value.set_index("what")["largest"]["leakage"]


def test_a_remapped_log_uploaded_again_gives_the_leakage_of_the_new_column(app: AppTest) -> None:
    log = TWO_PRESSURES.replace("line pressure 1", "main_pressure").encode()
    uploader(app, "Road-test log").upload("two.csv", log, "text/csv").run()
    first = most_leakage(app)
    column_box(app, "main").select("line pressure 2 [kPa]")
    use_columns(app)
    second = most_leakage(app)
    assert second > 1.2 * first  # 900 kPa at most, not 699
    uploader(app, "Road-test log").set_value(None).run()
    uploader(app, "Road-test log").upload("two.csv", log, "text/csv").run()
    assert not app.exception
    assert most_leakage(app) == second
    assert column_box(app, "main").value == "line pressure 2 [kPa]"


def test_what_was_settled_earlier_stays_when_something_else_is_settled(app: AppTest) -> None:
    uploader(app, "Road-test log").upload("two.csv", TWO_PRESSURES.encode(), "text/csv").run()
    column_box(app, "main").select("line pressure 2 [kPa]")
    use_columns(app)
    uploader(app, "Road-test log").set_value(None).run()
    uploader(app, "Road-test log").upload("again.csv", TWO_PRESSURES.encode(), "text/csv").run()
    column_box(app, "converter").select("line pressure 1 [kPa]")
    use_columns(app)
    assert not app.exception
    taken = app.dataframe[0].value.set_index("quantity")["column"]
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
    taken = app.dataframe[0].value.set_index("quantity")["column"]
    assert taken["main (line) pressure"] == "line pressure 2 [kPa]"


def test_remembered_columns_go_into_the_job_file(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.syspath_prepend(str(ROOT))
    monkeypatch.setenv("ATLEAK_HOME", str(tmp_path / "home"))
    from pages.shared import cases

    log = SourceFile("two.csv", TWO_PRESSURES.encode())
    cases.remember_columns(log, {"main_pressure": "line pressure 2 [kPa]"}, {})
    chosen = cases.case_with_columns(cases.PageCase(road_test=log)).log_choices
    assert chosen == {"mapping": {"main_pressure": "line pressure 2 [kPa]"}, "units": {}, "constants": {}}


def test_a_window_of_the_log_is_evaluated_and_remembered(app: AppTest) -> None:
    def largest() -> float:
        return app.dataframe[-1].value.set_index("what")["largest"]["leakage"]

    assert largest() == pytest.approx(2.92, rel=0.02, abs=0.0)
    app.main.slider[0].set_value((8.0, 12.0)).run()
    assert not app.exception
    less = largest()
    assert less < 2.6
    go(app, "2_Readings")
    go(app, "3_Road_test")
    assert app.main.slider[0].value == (8.0, 12.0)
    assert largest() == less


def test_another_log_stays_laid_over_the_jobs(app: AppTest, sample_log: Path) -> None:
    next(widget for widget in app.main.file_uploader if widget.label == "Other road-test log").upload(
        "after.csv", sample_log.read_bytes(), "text/csv"
    ).run()
    next(widget for widget in app.main.text_input if widget.label == "Shifted by [s]").set_value("1,25").run()
    assert not app.exception
    go(app, "2_Readings")
    go(app, "3_Road_test")
    assert "after.csv" in texts(app)
    assert next(widget for widget in app.main.text_input if widget.label == "Shifted by [s]").value == "1,25"
    next(widget for widget in app.button if widget.label == "Take it away").click().run()
    assert "after.csv" not in texts(app)


# --- a log without a sheet


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=pytest.mark.page(page))
        for page in ("4_Diagnosis", "3_Road_test", "6_Report", "2_Readings", "21_Uncertainty")
    ],
)
@pytest.mark.parametrize("kept", [6, 2], ids=["whole", "without main pressure"])
def test_a_log_alone_shows_on_every_page(app: AppTest, sample_log: Path, page: str, kept: int) -> None:
    uploader(app, "Road-test log").upload("alone.csv", columns_of(sample_log, kept), "text/csv").run()
    assert not app.exception
    assert "green" not in texts(app)


def columns_of(log: Path, kept: int) -> bytes:
    """The first columns of a log; of the sample two are its time and engine speed."""
    lines = log.read_text(encoding="utf-8").splitlines()
    return "\n".join(";".join(line.split(";")[:kept]) for line in lines).encode()


@pytest.mark.page("4_Diagnosis")
def test_a_log_alone_is_judged_by_its_main_pressure(app: AppTest, sample_log: Path) -> None:
    low = [line.split(";") for line in sample_log.read_text(encoding="utf-8").splitlines()]
    rows = [";".join(low[0]), *(";".join([*row[:2], f"{0.4 * float(row[2]):.2f}", *row[3:]]) for row in low[1:])]
    uploader(app, "Road-test log").upload("low.csv", "\n".join(rows).encode(), "text/csv").run()
    assert not app.exception
    said = "**✖ critical · provisional:** Main pressure stayed below what is permitted for 11"
    assert app.error[0].value.startswith(said)
    headings = [widget.value for widget in app.subheader]
    assert headings == ["What the road test says", "Over the road test", "Take it along"]
    assert "Main pressure is low in every gear and state that was judged" in texts(app)
    assert "(choice of this project)" in texts(app)
    assert "that of a unit with every pair new" in texts(app)
    go(app, "3_Road_test")
    assert "✖ critical" in texts(app)
    assert app.dataframe[1].value["state"].tolist() == ["idle", *["driving"] * 4]
    assert "minimum-acceleration test" in app.dataframe[2].value["event"].tolist()


@pytest.mark.page("4_Diagnosis")
def test_a_log_without_main_pressure_is_taken_and_says_what_to_gauge(app: AppTest, sample_log: Path) -> None:
    uploader(app, "Road-test log").upload("phone.csv", columns_of(sample_log, 2), "text/csv").run()
    assert not app.exception
    assert "not taken" not in texts(app)
    assert "**○ not measured:** The log holds no main pressure" in texts(app)
    assert "Gauge it at the main pressure tap in P R N D 3 2 1" in texts(app)
    assert "No leakage is computed over phone.csv" in texts(app)
    assert "1201 rows" in texts(app)
