"""Printed reports read back: the words of every page, and what a file claims to be."""

from __future__ import annotations

import re
import unicodedata

import pypdfium2


def pages_of(content: bytes) -> list[str]:
    """The words of every page, line by line as they stand."""
    with pypdfium2.PdfDocument(content) as document:
        return [page.get_textpage().get_text_range() for page in document]


def text_of(content: bytes) -> str:
    """All words, with line breaks and hard spaces as single spaces."""
    return re.sub(r"\s+", " ", " ".join(pages_of(content)))


def squeezed(text: str) -> str:
    """Text without any space or sign of direction, as a reader of long broken words compares it."""
    return "".join(sign for sign in text if not sign.isspace() and unicodedata.category(sign) != "Cf")


def is_archival(content: bytes) -> bool:
    """Whether a file claims PDF/A-2a and PDF/UA-1."""
    return b"<pdfaid:part>2<" in content and b"<pdfaid:conformance>A<" in content and b"<pdfuaid:part>1<" in content
