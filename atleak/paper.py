"""Name the papers that reports are printed on, as people, the PDF and the workbook call them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from atleak.errors import unknown
from atleak.sentence import Sentence


@dataclass(frozen=True)
class Paper:
    """One size of paper."""

    label: str  # for people
    typst: str  # its name in the PDF's template
    excel: int  # its number in a workbook


PAPERS: Mapping[str, Paper] = MappingProxyType(
    {"a4": Paper("A4", "a4", 9), "letter": Paper("Letter", "us-letter", 1)},
)
DEFAULT_PAPER = next(iter(PAPERS))


def find_paper(name: str) -> Paper:
    """Return the paper of that name.

    Raises
    ------
    InputError
        if there is none.
    """
    if name not in PAPERS:
        raise unknown(Sentence("no such paper"), name, PAPERS)
    return PAPERS[name]
