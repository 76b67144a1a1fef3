"""Who sees the dashboard."""

from __future__ import annotations

import ast
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from streamlit.testing.v1 import AppTest

from atleak.common.access import ALLOWED
from pages.shared import entrance
from tests.unit.pages.conftest import ROOT, texts


class Visitor(dict):
    """What Streamlit says of a visitor."""

    def to_dict(self) -> dict[str, Any]:
        return dict(self)


ANA = {"is_logged_in": True, "email": "ana@shop.example"}


@pytest.fixture
def allowed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The list of who may use the dashboard; nobody is signed in."""
    path = tmp_path / "allowed.toml"
    path.touch(0o600)
    path.write_text('users = ["ana@shop.example"]', encoding="utf-8")
    monkeypatch.setenv(ALLOWED, str(path))
    visited_by(monkeypatch, {"is_logged_in": False})
    return path


def visited_by(monkeypatch: pytest.MonkeyPatch, claims: dict[str, Any], address: str | None = "0.0.0.0") -> None:
    monkeypatch.setattr(entrance, "st", SimpleNamespace(user=Visitor(claims), get_option=lambda _: address))


def test_who_is_signed_in_is_told_by_provider_and_subject_and_nobody_else_is_anybody(
    allowed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert entrance.person() == ""
    told = {}
    for name, more in {"ana": {"sub": "1"}, "ben": {"sub": "2"}, "elsewhere": {"sub": "1", "iss": "https://b"}}.items():
        visited_by(monkeypatch, {**ANA, "iss": "https://a", **more})
        told[name] = entrance.person()
    assert len({*told.values(), ""}) == 4
    visited_by(monkeypatch, ANA)
    assert entrance.person() == "ana@shop.example"
    monkeypatch.delenv(ALLOWED)
    assert entrance.person() == ""


@pytest.mark.parametrize(
    ("claims", "is_open"),
    [
        ({}, False),
        ({"is_logged_in": False, "email": "ana@shop.example"}, False),
        ({"email": "ana@shop.example"}, False),
        ({"is_logged_in": True}, False),
        ({"is_logged_in": True, "email": "ben@shop.example"}, False),
        (ANA, True),
    ],
)
def test_it_is_open_to_who_is_signed_in_and_on_the_list(
    allowed: Path, monkeypatch: pytest.MonkeyPatch, claims: dict[str, Any], is_open: bool
) -> None:
    visited_by(monkeypatch, claims)
    assert entrance.is_open() is is_open


def test_a_list_that_cannot_be_read_lets_nobody_in(allowed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    visited_by(monkeypatch, ANA)
    assert entrance.is_open()
    allowed.write_text('users = "ana@shop.example"', encoding="utf-8")
    assert not entrance.is_open()
    allowed.unlink()
    assert not entrance.is_open()


def test_a_session_that_has_ended_is_forgotten_when_somebody_else_comes_in(
    allowed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    active = {"ana", "ben"}
    runtime = SimpleNamespace(
        exists=lambda: True, get_instance=lambda: SimpleNamespace(is_active_session=active.__contains__)
    )
    visited_by(monkeypatch, ANA)
    entrance.st.runtime = runtime
    for session in ("ana", "ben"):
        monkeypatch.setattr(
            entrance, "get_script_run_ctx", lambda session=session, **_: SimpleNamespace(session_id=session)
        )
        assert entrance.is_open()
    assert entrance.may_send_files("ana")
    active.remove("ana")
    assert entrance.is_open()
    assert not entrance.may_send_files("ana")
    assert entrance.may_send_files("ben")
    assert len(entrance._INSIDE) == 1


@pytest.mark.parametrize(("address", "is_open"), [("127.0.0.1", True), ("0.0.0.0", False), (None, False)])
def test_a_server_that_was_not_told_who_may_use_it_is_open_on_its_own_machine_alone(
    monkeypatch: pytest.MonkeyPatch, address: str | None, is_open: bool
) -> None:
    monkeypatch.delenv(ALLOWED, raising=False)
    visited_by(monkeypatch, {}, address)
    assert entrance.is_open() is is_open
    monkeypatch.setenv(ALLOWED, "")  # as the command says where nobody signs in
    assert entrance.is_open()


def test_every_page_asks_for_what_app_py_leaves_before_it_does_anything() -> None:
    for path in (ROOT / "pages").glob("[0-9]*_*.py"):
        body = ast.parse(path.read_text(encoding="utf-8")).body
        calls = [node for node in body if any(isinstance(each, ast.Call) for each in ast.walk(node))]
        assert ast.unparse(calls[0]).endswith("panel.shown()"), path.name


@pytest.mark.page("0_Start")
def test_a_visitor_who_is_not_signed_in_sees_a_way_to_sign_in_and_nothing_else(
    app: AppTest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "Sign out" not in [each.label for each in app.button]
    monkeypatch.setenv(ALLOWED, str(tmp_path / "allowed.toml"))
    app.run()
    assert not app.exception
    assert [each.label for each in app.button] == ["Sign in"]
    assert [each.value for each in app.text] == ["This dashboard is for the people of one workshop. Sign in to go on."]
    assert not app.sidebar.children
    assert "sample" not in texts(app).lower()
    assert not entrance.may_send_files("test session id")
    monkeypatch.setenv(ALLOWED, "")
    app.run()
    assert entrance.may_send_files("test session id")
