"""The page of the source study, run without a browser: on the study itself and on a job of one's own."""

from __future__ import annotations

from pathlib import Path

import pytest

from atleak.analysis.source_study import ERRATA, OPTION_STEPS, STATED_POINTS, VARIANTS
from atleak.common.wording import wording
from atleak.job.case import SourceFile

testing = pytest.importorskip("streamlit.testing.v1")


@pytest.fixture
def page(root: Path):
    app = testing.AppTest.from_file(str(root / "pages" / "28_Source_study.py"), default_timeout=240)
    app.session_state["framed"] = True  # as app.py has it before it runs a page
    return app


def test_study_is_shown_beside_its_printed_tables(page) -> None:
    page.run()
    assert not page.exception
    assert page.title[0].value == "The source study, reproduced"
    assert not page.radio
    table_2, table_3, points = (widget.value for widget in page.dataframe[:3])
    assert table_2["Variant"].tolist() == [f"W{number}" for number in range(1, 9)]
    assert " ".join(table_3["q printed [dm³/min]"]) == "2.16 2.81 3.64 8.56 0.021 0.38 1.43 11.23"
    assert table_3["q digits"].tolist() == ["✓"] * 8
    assert table_3["U digits"].tolist() == ["✓", "✓", "≠", "✓", "✓", "≠", "≠", "≠"]
    assert len(points) == 9
    assert len(page.table[0].value) == 23
    assert len(page.get("plotly_chart")) == 3
    assert any("56.2" in widget.value for widget in page.markdown)


def test_a_job_of_ones_own_runs_through_the_same_variants(page, root: Path) -> None:
    from pages.shared.cases import PageCase
    from pages.shared.state import Session

    log = root / "sample_data" / "minimum_acceleration_test.csv"
    job = PageCase(road_test=SourceFile("mine.csv", log.read_bytes()), controller="minimal_example")
    page.session_state["atleak"] = Session(job, job, {})
    page.run()
    assert not page.exception
    assert page.radio[0].value == "of_study"
    page.radio[0].set_value("of_job").run()
    assert not page.exception
    table_3 = page.dataframe[1].value
    assert table_3["q computed"].iloc[3] < 2.0  # W4 of the small controller, not the study's 8.56
    assert "every number" in " ".join(widget.value for widget in page.caption).lower()


def test_what_the_article_s_tables_say_is_said_in_every_language() -> None:
    words = wording("en").table("study_words")
    said = {text for each in ERRATA for text in (each.article, each.finding, each.here)}
    said |= {each.note for each in VARIANTS if each.note} | {label for label, _ in OPTION_STEPS}
    said |= {f"{each.variant or 'pump'}: {each.quantity}" for each in STATED_POINTS}
    assert sorted(said - set(words)) == []
    assert all(text == english for text, english in words.items())
