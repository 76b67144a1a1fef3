"""Say in which language, and in which units, this browser's pages are read."""

from __future__ import annotations

from atleak.wording import Wording, wording


def say() -> Wording:
    """Return the words of the reader's language."""
    return wording("en")
