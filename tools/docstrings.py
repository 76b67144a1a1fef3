"""Let the API reference show what docstrings leave to doctest and to the lines of fields: mkdocs.yml names this module.

Docstrings of the package may end with an example without a heading, as doctest allows; read as Markdown, its lines
would become quotations. A field of a class is described by the comment behind it, or by the heading and help of its
`key(...)`; such fields become the section Attributes, unless the docstring has one.
"""

from __future__ import annotations

import ast
import io
import re
import tokenize
from typing import Any

import griffe

#: The first line of an example, and whether the heading of examples stands somewhere above it.
_EXAMPLE = re.compile(r"^>>> ", re.MULTILINE)
_HEADING = re.compile(r"^Examples\n-+$", re.MULTILINE)
_RETURNS = re.compile(r"^(Returns|Yields)\n-+$", re.MULTILINE)
_SAID = re.compile(r"(?:Return|Compute|Find|Load|Tell|Count) (.+?)(?:[.:](?=\s|$)|$)", re.DOTALL)
_SECTION = re.compile(r"^(Raises|Notes|Examples|References|See Also|Warns)\n-+$", re.MULTILINE)
_ATTRIBUTES = re.compile(r"^Attributes\n-+$", re.MULTILINE)


def with_heading(text: str) -> str:
    r"""Return a docstring whose examples stand under their heading.

    >>> with_heading("Double it.\n\n>>> 2 * 2\n4").splitlines()[2:]
    ['Examples', '--------', '>>> 2 * 2', '4']
    """
    first = _EXAMPLE.search(text)
    if first is None or _HEADING.search(text, 0, first.start()):
        return text
    return f"{text[: first.start()]}Examples\n--------\n{text[first.start() :]}"


def field_description(source: str) -> str:
    """Return what the lines of a field say of it: its comment, or else heading and help of its key.

    >>> field_description("length: float | None = None  # [m] along the spool")
    '[m] along the spool'
    >>> field_description('price: float = key("Price", "Without tax", default=0.0)')
    'Price. Without tax.'
    >>> field_description("frozen: Place = Place()  # noqa: RUF009  so safe to share")
    ''
    """
    tokens = list(tokenize.generate_tokens(io.StringIO(source).readline))
    comments = [token.string.lstrip("# ") for token in tokens if token.type == tokenize.COMMENT]
    comments = [comment for comment in comments if not comment.startswith(("noqa", "type:"))]
    if comments:
        return comments[-1]
    value = getattr(ast.parse(source).body[0], "value", None)
    if not isinstance(value, ast.Call) or ast.unparse(value.func) != "key":
        return ""
    words = [each.value for each in value.args if isinstance(each, ast.Constant) and isinstance(each.value, str)]
    return " ".join(f"{word.rstrip('.')}." for word in words if word)


def with_returns(text: str, returned: str) -> str:
    r"""Return a docstring that says what its function returns: by its annotation, in the words of its first sentence.

    >>> text = "Return the land of a plane; None without one.\n\nRaises\n------\nKeyError\n    none."
    >>> print(with_returns(text, "Land"))
    Return the land of a plane; None without one.
    <BLANKLINE>
    Returns
    -------
    Land
        the land of a plane; None without one
    <BLANKLINE>
    Raises
    ------
    KeyError
        none.
    """
    said = _SAID.match(text)
    if said is None or returned in ("", "None") or _RETURNS.search(text):
        return text
    words = " ".join(said[1].split())
    after = _SECTION.search(text)
    place = len(text) if after is None else after.start()
    return f"{text[:place].rstrip()}\n\nReturns\n-------\n{returned}\n    {words}\n\n{text[place:]}".rstrip()


class Docstrings(griffe.Extension):
    """Puts the headings into every docstring that lacks them."""

    def on_instance(self, *, obj: griffe.Object, **_: Any) -> None:
        if obj.docstring is not None:
            obj.docstring.value = with_heading(obj.docstring.value)
            if isinstance(obj, griffe.Function) and obj.name[0] != "_":
                obj.docstring.value = with_returns(obj.docstring.value, str(obj.returns or ""))

    def on_class_members(self, *, cls: griffe.Class, **_: Any) -> None:
        if cls.docstring is None or _ATTRIBUTES.search(cls.docstring.value):
            return
        fields = [each for each in cls.attributes.values() if each.annotation is not None and each.name[0] != "_"]
        described = [(each.name, field_description(each.source)) for each in fields if "property" not in each.labels]
        lines = [f"{name}\n    {text}" for name, text in described if text]
        if lines:
            cls.docstring.value = "\n".join([cls.docstring.value, "", "Attributes", "----------", *lines])
