"""The dashboard's pages run in Streamlit's own test harness."""

from __future__ import annotations

import pytest
from streamlit.testing.v1 import AppTest

from tests.unit.pages.conftest import ROOT, choice, go

PAGES = (
    "0_Start", "1_Job", "21_Settings",
    "4_Diagnosis", "2_Measure", "4_Diagnosis?diagnosis=lands", "3_In_the_car", "6_Report", "28_Source_study", "20_Library",
    "5_Plan?plan=what_if", "20_Library?library=transmission", "10_Jobs", "11_History", "11_History?history=compare", "5_Plan",
    "12_Fleet",
    "20_Library?library=gauge_study", "20_Library?library=workshop_data",
)  # fmt: skip


@pytest.mark.parametrize("page", [pytest.param(page, marks=pytest.mark.page(page)) for page in PAGES])
def test_every_page_runs_with_the_sample_and_with_nothing(app: AppTest, page: str) -> None:
    assert not app.exception
    choice(app, "Valve body").select("minimal_example").run()
    assert not app.exception
    assert not app.error or "not" in app.error[0].value


@pytest.mark.parametrize(
    ("page", "breaks"),
    [
        pytest.param("3_In_the_car", "pages.shared.road.findings", marks=pytest.mark.page("1_Job")),
        pytest.param("4_Diagnosis", "atleak.report.json.diagnosis.diagnosis_record", marks=pytest.mark.page("1_Job")),
        pytest.param("5_Plan?plan=what_if", "pages.shared.what_if_form.draw", marks=pytest.mark.page("1_Job")),
        pytest.param("6_Report", "pages.shared.conditions.undecided", marks=pytest.mark.page("1_Job")),
    ],
)
def test_a_fault_of_atleak_is_a_message_on_its_page(
    app: AppTest, page: str, breaks: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fault(*_: object, **__: object) -> None:
        raise ValueError("index values must not have NaT")

    monkeypatch.delenv("ATLEAK_TRACEBACK")
    monkeypatch.setattr(breaks, fault)
    go(app, page)
    assert not app.exception
    assert app.error[-1].value.startswith("unexpected ValueError")
    assert "index values must not have NaT. This is a fault of atleak" in app.error[-1].value
    go(app, "1_Job")
    assert not app.error


def test_every_page_has_a_number_of_its_own() -> None:
    stems = [path.stem for path in (ROOT / "pages").glob("[0-9]*.py")]
    assert sorted(stems) == sorted(PAGES)
    assert len({int(name.split("_")[0]) for name in stems}) == len(stems)


@pytest.mark.parametrize("page", PAGES)
def test_pages_are_short_and_compute_nothing(page: str) -> None:
    text = (ROOT / "pages" / f"{page}.py").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 90
    assert "numpy" not in text
    assert "open(" not in text


def test_no_page_has_a_number_field_of_another_kind() -> None:
    for path in (ROOT / "pages").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        assert "number_input" not in text, path.name
        assert "data_editor" not in text or "NumberColumn" not in text, path.name  # a table that is only read may
