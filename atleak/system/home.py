"""The folder in which atleak keeps what belongs to the user of this computer: own catalogue files, columns, drafts."""

from __future__ import annotations

import os
from pathlib import Path

from atleak.errors import OutputError, Place
from atleak.sentence import Sentence
from atleak.system.reasons import reason_of

HOME = "ATLEAK_HOME"
"""The variable of the environment that names another folder."""

DATABASE_URL = "ATLEAK_DATABASE_URL"
"""The variable of the environment that names another database for the job book than the file in the user's folder."""

PRIVATE_FOLDER = 0o700  # that only its owner may open


def home() -> Path:
    """Return the user's folder, whether or not it is there: ``ATLEAK_HOME``, else where the system keeps such data.

    The latter is ``%LOCALAPPDATA%\\atleak`` on Windows, ``~/Library/Application Support/atleak`` on macOS, and
    ``$XDG_DATA_HOME/atleak`` (``~/.local/share/atleak``) elsewhere.
    """
    if folder := os.environ.get(HOME):
        return Path(os.path.expanduser(folder)).absolute()  # noqa: PTH111  the other one refuses the name of no user
    from platformdirs import user_data_path  # only who names no folder of their own needs it

    return user_data_path("atleak", appauthor=False)


def made(folder: Path) -> Path:
    """Make a folder where it is not there yet, and return it; the user's own is for nobody else.

    Raises
    ------
    OutputError
        naming the folder and why it cannot be made.
    """
    try:
        if folder.is_relative_to(home()):
            home().mkdir(PRIVATE_FOLDER, parents=True, exist_ok=True)
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        problem = Sentence("cannot be made: {reason}", reason=reason_of(error))
        expected = Sentence(
            "a folder that can be written; {variable} in the environment names another one", variable=HOME
        )
        raise OutputError(problem, place=Place(file=str(folder)), expected=expected) from error
    return folder


def earlier_file(name: str) -> Path | None:
    """Return a file of version 0.1.0, which kept it where programs keep their settings; None without one.

    Where ``ATLEAK_HOME`` names the folder, everything is in that folder and nothing is looked for elsewhere.
    """
    if os.environ.get(HOME):
        return None
    folder = os.environ.get("APPDATA") or os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config"
    path = Path(folder) / "atleak" / name
    return path if path.is_file() else None
