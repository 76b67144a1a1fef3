"""Files that travel with the package: the dashboard and the sample job."""

from __future__ import annotations

from pathlib import Path

from atleak.errors import InputError, Place
from atleak.sentence import Sentence


def shipped(name: str) -> Path:
    """A file that lies beside the package: inside an installed wheel, or at the root of a checkout.

    Raises
    ------
    InputError
        where neither has it.
    """
    package = Path(__file__).resolve().parents[1]
    for folder in (package / "_dashboard", package.parent):
        if (folder / name).exists():
            return folder / name
    problem, expected = Sentence("{file} is not beside the package", file=name), Sentence("a complete installation")
    raise InputError(problem, place=Place(file=str(package)), expected=expected)
