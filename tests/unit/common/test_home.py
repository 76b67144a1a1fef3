"""The user's own folder: named in the environment, or where the system keeps such data."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from atleak.common.errors import OutputError
from atleak.common.files import HOME, home, made_folder
from atleak.readers.logs import default_path, recall, remember


@pytest.fixture
def settings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A computer on which version 0.1.0 remembered the columns of a log; nobody names a folder."""
    folder = tmp_path / "settings"
    for name in ("APPDATA", "XDG_CONFIG_HOME"):
        monkeypatch.setenv(name, str(folder))
    monkeypatch.setattr("platformdirs.user_data_path", lambda name, appauthor: tmp_path / "data" / name)
    monkeypatch.delenv("ATLEAK_HOME")
    remember(made_folder(folder / "atleak") / "road-test-columns.json", "logger", {"gear": "G"}, {})
    return folder / "atleak" / "road-test-columns.json"


def test_the_environment_names_the_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ATLEAK_HOME", str(tmp_path / "mine"))
    assert home() == tmp_path / "mine"
    assert default_path() == tmp_path / "mine" / "road-test-columns.json"


def test_a_folder_named_by_the_short_form_of_ones_own_is_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("HOME", "USERPROFILE"):
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.setenv("ATLEAK_HOME", "~/mine")
    assert home() == tmp_path / "mine"


def test_nobody_who_names_no_folder_loses_what_an_earlier_version_remembered(settings: Path, tmp_path: Path) -> None:
    path = default_path()
    assert path == tmp_path / "data" / "atleak" / "road-test-columns.json"
    taken = recall(path, "logger")
    assert taken is not None
    assert taken.mapping == {"gear": "G"}
    settings.write_text("{}", encoding="utf-8")
    assert recall(default_path(), "logger") == taken  # taken over once


def test_what_was_remembered_stays_in_use_where_it_cannot_be_copied(settings: Path, tmp_path: Path) -> None:
    (tmp_path / "data").write_text("no folder", encoding="utf-8")
    assert default_path() == settings


def test_a_folder_that_is_named_holds_everything(
    settings: Path, own_home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert recall(default_path(), "logger") is None


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(OutputError, match="ATLEAK_HOME") as caught:
        made_folder(tmp_path / "file" / "catalogue")
    assert caught.value.place.file == str(tmp_path / "file" / "catalogue")


def test_without_platformdirs_it_is_the_same_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(HOME, raising=False)
    usual = home()
    monkeypatch.setitem(sys.modules, "platformdirs", None)
    assert home() == usual
