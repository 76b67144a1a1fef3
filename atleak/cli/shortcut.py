"""Put an icon of the dashboard on desktop and start menu, or take it away: ``atleak shortcut``."""

from __future__ import annotations

import argparse
import os
import plistlib
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from atleak.cli.parser import add_command
from atleak.common.errors import OutputError, reason_of
from atleak.common.files import DATABASE_URL, HOME, replace_file, shipped
from atleak.common.sentences import Sentence
from atleak.version import __version__

_ABOUT = "Internal leakage of automatic-transmission valve bodies"
_ICON = "pages/shared/icon"
_OF_WINDOWS = """\
[Console]::OutputEncoding = [Text.Encoding]::UTF8
$ErrorActionPreference = 'Stop'
foreach ($folder in 'Desktop', 'Programs') {
  $place = Join-Path ([Environment]::GetFolderPath($folder)) 'atleak.lnk'
  MAKE
  Write-Output $place
}
"""
_MAKE = """\
$link = (New-Object -ComObject WScript.Shell).CreateShortcut($place)
  $link.TargetPath = $env:ATLEAK_PROGRAM
  $link.Arguments = '-P -m atleak app --window'
  $link.WorkingDirectory = [Environment]::GetFolderPath('UserProfile')
  $link.Description = $env:ATLEAK_ABOUT
  $link.IconLocation = $env:ATLEAK_ICON
  $link.Save()"""
_REMOVE = "if (-not (Test-Path $place)) { continue }\n  Remove-Item $place"


def add_parser(commands: Any, name: str) -> None:
    """Add the command."""
    parser = add_command(commands, name, run, examples=("shortcut", "shortcut --remove"))
    parser.add_argument("--remove", action="store_true", help="take the icon away again")


def run(options: argparse.Namespace) -> int:
    """Write or remove the entries of this system, and name each."""
    try:
        done = _on_windows if sys.platform == "win32" else _on_macos if sys.platform == "darwin" else _on_freedesktop
        places = list(done(remove=options.remove))
    except (OSError, subprocess.CalledProcessError) as error:
        said = error.stderr.strip() if isinstance(error, subprocess.CalledProcessError) else reason_of(error)
        raise OutputError(Sentence("the icon cannot be written: {reason}", reason=said)) from error
    for place in places:
        print(f"{'removed' if options.remove else 'written'}: {place}")
    if not places:
        print("There is no icon of atleak.")
    own = [name for name in (HOME, DATABASE_URL) if os.environ.get(name)]
    if own and not options.remove:
        print(f"atleak: the icon knows {' and '.join(own)} only where the whole session has it", file=sys.stderr)
    return 0


def _program() -> str:
    """Return the interpreter that runs atleak: on Windows the one without a console, where it is there."""
    python = Path(sys.executable)
    without_console = python.with_name("pythonw.exe")
    return str(without_console if sys.platform == "win32" and without_console.is_file() else python)


def _on_windows(*, remove: bool) -> Iterator[Path]:
    """Make links on desktop and in the start menu, wherever this user's are."""
    script = _OF_WINDOWS.replace("MAKE", _REMOVE if remove else _MAKE)
    icon = str(shipped(f"{_ICON}.ico"))
    told = subprocess.run(
        ["powershell", "-NoProfile", "-NonInteractive", "-Command", script],
        capture_output=True,
        check=True,
        encoding="utf-8",
        errors="replace",
        env={**os.environ, "ATLEAK_PROGRAM": _program(), "ATLEAK_ABOUT": _ABOUT, "ATLEAK_ICON": icon},
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),  # else this console keeps the encoding
    )
    yield from map(Path, told.stdout.splitlines())


def _on_macos(*, remove: bool) -> Iterator[Path]:
    """Make an application of this user's, which Launchpad shows, and lead to it from the desktop."""
    bundle, link = Path.home() / "Applications" / "atleak.app", Path.home() / "Desktop" / "atleak"
    if remove:
        if link.is_symlink() and link.resolve() == bundle.resolve():
            link.unlink()
            yield link
        if bundle.is_dir():
            shutil.rmtree(bundle)
            yield bundle
        return
    program = bundle / "Contents" / "MacOS" / "atleak"
    program.parent.mkdir(parents=True, exist_ok=True)
    starts = f"#!/bin/sh\nexec {shlex.quote(_program())} -P -m atleak app --window\n"
    replace_file(program, starts.encode(), mode=0o755)
    names = {"CFBundleName": "atleak", "CFBundleExecutable": "atleak", "CFBundleIdentifier": "atleak.dashboard"}
    known = {**names, "CFBundlePackageType": "APPL", "CFBundleShortVersionString": __version__}
    # else a Mac with an arm processor asks for Rosetta, since a script states no architecture
    listed = plistlib.dumps({**known, "LSArchitecturePriority": ["arm64", "x86_64"]})
    replace_file(bundle / "Contents" / "Info.plist", listed)
    yield bundle
    with suppress(FileExistsError):  # it leads there already, or is something else of that name
        link.symlink_to(bundle)
    if link.resolve() == bundle.resolve():
        yield link


def _on_freedesktop(*, remove: bool) -> Iterator[Path]:
    """Write an entry into the menu of this user's, and one on the desktop where there is one."""
    data = os.environ.get("XDG_DATA_HOME")
    menu = (Path(data) if data else Path.home() / ".local" / "share") / "applications" / "atleak.desktop"
    desktop = _desktop() / "atleak.desktop"
    for place in (menu, desktop):
        if remove:
            if place.is_file():
                place.unlink()
                yield place
            continue
        if place == menu:
            place.parent.mkdir(parents=True, exist_ok=True)
        elif not place.parent.is_dir() or place.parent == Path.home():  # as where no desktop is shown
            continue
        replace_file(place, _entry().encode("utf-8"), mode=0o755)
        yield place


def _desktop() -> Path:
    """Return the folder of the desktop, which each language calls otherwise."""
    if (tool := shutil.which("xdg-user-dir")) is None:
        return Path.home() / "Desktop"
    return Path(subprocess.run([tool, "DESKTOP"], capture_output=True, check=True, text=True).stdout.strip())


def _entry() -> str:
    """Return the entry that desktops of freedesktop.org read."""
    program = "".join(f"\\{sign}" if sign in '"`$\\' else sign for sign in _program())
    # a backslash is escaped once for the command and once for the file, a percent sign begins a field
    program = program.replace("\\", "\\\\").replace("%", "%%")
    lines = {
        "Type": "Application",
        "Version": "1.5",
        "Name": "atleak",
        "Comment": _ABOUT,
        "Exec": f'"{program}" -P -m atleak app --window',
        "Icon": str(shipped(f"{_ICON}.svg")),
        "Terminal": "false",
        "Categories": "Science;Engineering;",
    }
    return "\n".join(["[Desktop Entry]", *(f"{key}={value}" for key, value in lines.items())]) + "\n"
