"""Let the API reference show the examples of docstrings as code: mkdocs.yml names this extension of griffe.

Docstrings of the package may end with an example without a heading, as doctest allows. Read as Markdown, its lines
would become quotations.
"""

from __future__ import annotations

import re
from typing import Any

import griffe

#: The first line of an example, and whether the heading of examples stands somewhere above it.
_EXAMPLE = re.compile(r"^>>> ", re.MULTILINE)
_HEADING = re.compile(r"^Examples\n-+$", re.MULTILINE)


def with_heading(text: str) -> str:
    """Return a docstring whose examples stand under their heading.

    >>> print(with_heading("Double it." + chr(10) + chr(10) + ">>> 2 * 2" + chr(10) + "4"))
    Double it.
    <BLANKLINE>
    Examples
    --------
    >>> 2 * 2
    4
    """
    first = _EXAMPLE.search(text)
    if first is None or _HEADING.search(text, 0, first.start()):
        return text
    return f"{text[: first.start()]}Examples\n--------\n{text[first.start() :]}"


class Examples(griffe.Extension):
    """Puts the heading into every docstring that lacks it."""

    def on_instance(self, *, obj: griffe.Object, **_: Any) -> None:
        if obj.docstring is not None:
            obj.docstring.value = with_heading(obj.docstring.value)
