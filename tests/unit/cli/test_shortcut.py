"""The icon of the dashboard, on each system, and that it goes away."""

from __future__ import annotations

import configparser
import plistlib
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from atleak.cli import shortcut

Run = Callable[..., tuple[int, str, str]]
RUNS = ["-P", "-m", "atleak", "app", "--window"]


@pytest.fixture
def person(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of somebody with a desktop."""
    (tmp_path / "Desktop").mkdir()
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    monkeypatch.delenv("XDG_DATA_HOME", raising=False)
    monkeypatch.setattr(shortcut.shutil, "which", lambda _: None)
    monkeypatch.delenv("ATLEAK_HOME")
    return tmp_path


@pytest.fixture
def freedesktop(person: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(shortcut.sys, "platform", "linux")
    return person


def test_the_menu_and_the_desktop_get_an_entry_that_opens_a_window(run: Run, freedesktop: Path) -> None:
    status, out, err = run("shortcut")
    places = [freedesktop / ".local" / "share" / "applications" / "atleak.desktop"]
    places.append(freedesktop / "Desktop" / "atleak.desktop")
    assert (status, out.splitlines(), err) == (0, [f"written: {place}" for place in places], "")
    for place in places:
        entry = configparser.ConfigParser(interpolation=None)
        entry.read(place, encoding="utf-8")
        said = entry["Desktop Entry"]
        assert shlex.split(said["Exec"]) == [sys.executable, *RUNS]
        assert Path(said["Icon"]).is_file()
    assert run("shortcut")[0] == 0  # once more, as after an update
    assert run("shortcut", "--remove")[1].splitlines() == [f"removed: {place}" for place in places]
    assert not any(place.exists() for place in places)
    assert run("shortcut", "--remove")[1] == "There is no icon of atleak.\n"


def test_without_a_desktop_the_menu_has_it(run: Run, freedesktop: Path) -> None:
    (freedesktop / "Desktop").rmdir()
    assert run("shortcut")[1].count("written:") == 1


def test_signs_of_a_path_are_written_as_such_an_entry_has_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shortcut, "_program", lambda: '/home/a "b"/100 %/$c/python')
    assert 'Exec="/home/a \\\\"b\\\\"/100 %%/\\\\$c/python" -P -m atleak app --window' in shortcut._entry()


def test_a_folder_that_only_this_shell_names_is_said(run: Run, freedesktop: Path, own_home: Path) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ATLEAK_HOME", str(own_home))
        assert "the icon knows ATLEAK_HOME only where the whole session has it" in run("shortcut")[2]


def test_a_folder_that_cannot_be_written_is_said(run: Run, freedesktop: Path) -> None:
    (freedesktop / ".local").write_text("", encoding="utf-8")
    status, _, err = run("shortcut")
    assert status == 2
    assert err.startswith("atleak: the icon cannot be written: ")


@pytest.mark.skipif(sys.platform == "win32", reason="a link needs a right there")
def test_on_macos_an_application_is_made(run: Run, person: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shortcut.sys, "platform", "darwin")
    assert run("shortcut")[0] == run("shortcut")[0] == 0
    contents = person / "Applications" / "atleak.app" / "Contents"
    known = plistlib.loads((contents / "Info.plist").read_bytes())
    program = contents / "MacOS" / known["CFBundleExecutable"]
    assert program.stat().st_mode & 0o111
    assert shlex.split(program.read_text(encoding="utf-8").splitlines()[1]) == ["exec", sys.executable, *RUNS]
    assert (person / "Desktop" / "atleak").resolve() == contents.parent
    assert run("shortcut", "--remove")[1].count("removed:") == 2
    assert list((person / "Desktop").iterdir()) == list((person / "Applications").iterdir()) == []


@pytest.mark.skipif(sys.platform == "win32", reason="a link needs a right there")
def test_what_stands_on_the_desktop_of_macos_stays(run: Run, person: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shortcut.sys, "platform", "darwin")
    (person / "Desktop" / "atleak").mkdir()
    application = person / "Applications" / "atleak.app"
    assert run("shortcut") == (0, f"written: {application}\n", "")
    assert run("shortcut", "--remove") == (0, f"removed: {application}\n", "")
    assert (person / "Desktop" / "atleak").is_dir()


def test_on_windows_links_are_made_by_its_shell(run: Run, person: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scripts, given = [], {}

    def shell(command: list[str], **settings: Any) -> subprocess.CompletedProcess[str]:
        scripts.append(command[-1])
        given.update(settings)
        return subprocess.CompletedProcess(command, 0, "C:\\Desktop\\atleak.lnk\nC:\\Programs\\atleak.lnk\n", "")

    own = person / "O’Neil ICON MAKE"
    own.mkdir()
    (own / "pythonw.exe").touch()
    monkeypatch.setattr(shortcut.sys, "platform", "win32")
    monkeypatch.setattr(shortcut.sys, "executable", str(own / "python.exe"))
    monkeypatch.setattr(shortcut.subprocess, "run", shell)
    assert run("shortcut")[1].count("written: ") == 2
    made = scripts[0].splitlines()
    assert "  $link.TargetPath = $env:ATLEAK_PROGRAM" in made
    assert given["env"]["ATLEAK_PROGRAM"] == str(own / "pythonw.exe")
    assert "O’Neil" not in scripts[0]  # nothing of a path is script
    assert given["encoding"] == "utf-8"
    assert made[0] == "[Console]::OutputEncoding = [Text.Encoding]::UTF8"
    assert "  $link.Arguments = '-P -m atleak app --window'" in made
    assert Path(given["env"]["ATLEAK_ICON"]).is_file()
    assert all(f"${part}" in scripts[0] for part in ("env:ATLEAK_ABOUT", "env:ATLEAK_ICON"))
    assert "MAKE" not in scripts[0]
    assert run("shortcut", "--remove")[1].count("removed: ") == 2
    assert "Remove-Item $place" in scripts[1]
    assert "CreateShortcut" not in scripts[1]


def test_what_the_shell_of_windows_refuses_is_said(run: Run, person: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def shell(command: list[str], **_: object) -> subprocess.CompletedProcess[str]:
        raise subprocess.CalledProcessError(1, command, "", "Access is denied.\n")

    monkeypatch.setattr(shortcut.sys, "platform", "win32")
    monkeypatch.setattr(shortcut.subprocess, "run", shell)
    status, _, err = run("shortcut")
    assert (status, err) == (2, "atleak: the icon cannot be written: Access is denied.\n")
