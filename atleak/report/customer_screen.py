"""Write the customer's screen: one page of HTML by itself, with a picture, and a yes or no to each repair."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from atleak.common.wording import wording

if TYPE_CHECKING:
    from jinja2 import Template

_TEMPLATES = Path(__file__).with_name("templates")
LETTERS = 80  # of the name of who answers


@dataclass(frozen=True)
class Answer:
    """What a customer answered: to which lines of the estimate yes and to which no, by their keys."""

    name: str  # as typed
    at: datetime
    agreed: Mapping[str, bool]


def asked_for(screen: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the keys of the lines that a screen asks a yes or no to."""
    return tuple(line["key"] for line in (screen["cost"] or {"lines": []})["lines"] if line["asked"])


def offered(screen: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    """Return work and amount of each line of a screen, by its key."""
    lines = (screen["cost"] or {"lines": []})["lines"]
    return {line["key"]: (line["work"], line["amount"]) for line in lines}


def shows_the_same(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Tell whether two screens say the same and ask the same, whatever was answered."""
    said = [
        [screen[name] for name in ("language", "headline", "sentence", "picture")]
        + [(bar["name"], bar["litres"]) for bar in screen["bars"]]  # a kept one may be of an older version
        for screen in (one, other)
    ]
    return said[0] == said[1] and offered(one) == offered(other)


def written(
    screen: Mapping[str, Any],
    *,
    answer: Answer | None = None,
    asks: bool = False,
    sent: Mapping[str, str] | None = None,
) -> str:
    """Write a screen as HTML that needs nothing else.

    Parameters
    ----------
    screen
        as `customer_screen` returned it.
    answer
        the one that was given last.
    asks
        whether a yes or no can be sent from it: only where an address serves it.
    sent
        the fields of what was sent last and was no whole answer; None where nothing was.
    """
    script = (_TEMPLATES / "customer.js").read_text(encoding="utf-8")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    given = {"answer": answer, "asks": asks, "sent": sent, "script": script, "script_source": f"'sha256-{digest}'"}
    return _template().render(**screen, **given, say=wording(screen["language"]))


def closed(language: str, *, busy: bool = False) -> str:
    """Return the page that stands where a screen is not shown any more, or never was; or where the book is busy."""
    say = wording(language)
    return _template().render(language=language, say=say, closed=True, busy=busy, script_source="'none'")


@cache
def _template() -> Template:
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return environment.from_string((_TEMPLATES / "customer.html").read_text(encoding="utf-8"))
