"""On the page In the car a log is followed by its path, and taken into the job when that is stopped."""

from __future__ import annotations

from pathlib import Path

import pytest
from streamlit.testing.v1 import AppTest

from atleak.common.access import ALLOWED
from pages.shared import entrance
from tests.unit.pages.conftest import ROOT, choice, go, press, texts, unfold

PAGE = "3_In_the_car#step-drive"
pytestmark = pytest.mark.page(PAGE)
SAMPLE = (ROOT / "sample_data" / "minimum_acceleration_test.csv").read_bytes()


def follow(app: AppTest, path: object) -> AppTest:
    unfold(app, "live")
    next(field for field in app.main.text_input if field.label.startswith("Path of the log")).set_value(str(path)).run()
    return press(app, "Follow it")


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "trackLog.csv"
    path.write_bytes(b"")
    return path


def test_a_log_is_followed_from_its_first_line_into_the_job(app: AppTest, log: Path) -> None:
    follow(app, f'"{log}"')  # as Windows copies a path
    assert not app.exception
    assert "Following **trackLog.csv**: nothing in it yet that can be read" in texts(app)
    assert "Waiting: trackLog.csv: is empty so far" in texts(app)
    log.write_bytes(SAMPLE[:20_000])
    app.run()
    assert "605 rows so far" in texts(app)
    assert "main (line) pressure: **701 kPa (permitted 412 to 1\xa0176)**" in texts(app)
    assert "shift 1 → 2, 0.9 to 0.9 s" in texts(app)
    press(app, "Stop, and take it into the job")
    assert not app.exception
    assert "Following" not in texts(app)
    file = app.session_state["atleak"].good.road_test
    assert (file.name, file.content) == ("trackLog.csv", SAMPLE[: SAMPLE.rfind(b"\n", 0, 20_000) + 1])


def test_what_is_typed_and_another_page_do_not_end_it(app: AppTest, log: Path) -> None:
    follow(app, log)
    go(app, "1_Job")
    log.write_bytes(SAMPLE)
    go(app, PAGE)
    assert "1\xa0201 rows so far" in texts(app)


def test_another_valve_body_judges_what_is_followed(app: AppTest, log: Path) -> None:
    log.write_bytes(SAMPLE)
    follow(app, log)
    assert "(permitted 412 to 1\xa0176)" in texts(app)
    choice(app, "Valve body").select("five_speed_2005").run()
    app.session_state["atleak"].watched._rests_until = 0.0
    app.run()
    assert "(permitted 412 to 1\xa0176)" not in texts(app)
    assert app.session_state["atleak"].watched.controller.id == "five_speed_2005"
    assert "1\xa0201 rows so far" in texts(app)


def test_a_log_that_begins_anew_leaves_the_earlier_one_to_be_saved(app: AppTest, log: Path) -> None:
    log.write_bytes(SAMPLE)
    follow(app, log)
    log.write_bytes(SAMPLE[:9_000])
    app.session_state["atleak"].watched._rests_until = 0.0
    app.run()
    assert "trackLog.csv began anew" in texts(app)
    assert [button.label for button in app.get("download_button")] == ["Save trackLog.csv, 1"]


@pytest.mark.parametrize(
    ("content", "said"), [(None, "cannot be opened"), (b"\x89PNG\r\n\x1a\n" + bytes(99), "no road-test log")]
)
def test_a_wrong_file_is_said_where_its_path_stands(
    app: AppTest, tmp_path: Path, content: bytes | None, said: str
) -> None:
    path = tmp_path / "wrong.csv"
    if content is not None:
        path.write_bytes(content)
    follow(app, path)
    assert said in texts(app)
    assert app.session_state["atleak"].watched is None


def test_another_job_does_not_end_it(app: AppTest, log: Path) -> None:
    log.write_bytes(SAMPLE)
    follow(app, log)
    press(app, "New, empty job")
    go(app, PAGE)
    assert "1\xa0201 rows so far" in texts(app)


@pytest.mark.parametrize("path", ["torqueLogs/trackLog.csv", "~nobody-of-this-name/x.csv"])
def test_the_whole_path_is_asked_for(app: AppTest, path: str) -> None:
    follow(app, path)
    assert not app.exception
    assert "The whole path is needed" in texts(app)
    assert app.session_state["atleak"].watched is None


@pytest.mark.parametrize("how", ["sign in", "address", "name", "proxy"])
def test_nobody_from_outside_names_a_path(how: str, monkeypatch: pytest.MonkeyPatch) -> None:
    options = {"server.address": "127.0.0.1", "server.allowedHosts": ["localhost", "127.0.0.1", "::1"]}
    headers: dict[str, str] = {}
    monkeypatch.setenv(ALLOWED, "")
    monkeypatch.setattr(entrance.st, "get_option", options.__getitem__)
    monkeypatch.setattr(type(entrance.st.context), "headers", property(lambda _: headers))
    assert entrance.is_of_this_computer()
    if how == "sign in":
        monkeypatch.setenv(ALLOWED, "allowed.toml")
    elif how == "address":
        options["server.address"] = "0.0.0.0"
    elif how == "name":
        options["server.allowedHosts"].append("atleak.shop.example")
    else:
        headers["X-Forwarded-For"] = "192.168.1.5"
    assert not entrance.is_of_this_computer()


def test_where_others_reach_the_dashboard_no_path_is_asked_for(app: AppTest, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(entrance, "is_of_this_computer", lambda: False)
    unfold(app, "live")
    assert "can be followed only in a dashboard that this computer alone reaches" in texts(app)
    assert not [field for field in app.main.text_input if field.label.startswith("Path of the log")]
