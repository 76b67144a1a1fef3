"""Decodes bytes to text: encodings with and without a byte-order mark, embedded NULs."""

from __future__ import annotations

import re
from dataclasses import dataclass

_CYRILLIC_RUN = re.compile(rb"[\xc0-\xff]{3,}")
_POLISH = re.compile(rb"(?<=[A-Za-z])[\xb3\xb9\xbf\x9c\x9f\xea\xe6](?=[A-Za-z])")
_WESTERN = re.compile(rb"(?<=[A-Za-z])[\xe4\xf6\xfc\xdf\xe9\xe8\xe0\xe7](?=[A-Za-z])")


@dataclass(frozen=True)
class LogText:
    """A log's text as UTF-8 (or plain single-byte) bytes and what it was encoded in.

    ``encoding`` is for people and JSON; ``decode`` turns pieces of ``data`` into ``str``.
    """

    data: bytes
    encoding: str
    codec: str

    def decode(self, piece: bytes) -> str:
        """Decode a piece of the text; what the encoding cannot hold becomes a replacement sign."""
        return piece.decode(self.codec, errors="replace")


def to_text(data: bytes) -> LogText:
    """Determine the encoding. Single-byte text stays as it is: numbers are plain ASCII in every such encoding."""
    if data.startswith(b"\xef\xbb\xbf"):
        return LogText(without_nul(data[3:]), "utf-8-sig", "utf-8")
    wide = _utf16(data)
    if wide:
        body = data[2:] if data[:2] in (b"\xff\xfe", b"\xfe\xff") else data
        text = body.decode(wide, errors="replace").replace("\x00", "")
        return LogText(text.encode("utf-8"), "utf-16" if body is not data else wide, "utf-8")
    body = without_nul(data)
    codec = _single_byte(body)
    return LogText(body, codec, codec)


def without_nul(data: bytes) -> bytes:
    """Return a text without zero bytes."""
    return data.replace(b"\x00", b"") if b"\x00" in data else data


def _utf16(data: bytes) -> str | None:
    if data.startswith(b"\xff\xfe"):
        return "utf-16-le"
    if data.startswith(b"\xfe\xff"):
        return "utf-16-be"
    head = data[:4096]
    if len(head) >= 64:
        if head[1::2].count(0) > 0.8 * len(head[1::2]) and head[0::2].count(0) < 0.1 * len(head):
            return "utf-16-le"
        if head[0::2].count(0) > 0.8 * len(head[0::2]) and head[1::2].count(0) < 0.1 * len(head):
            return "utf-16-be"
    return None


def _single_byte(data: bytes) -> str:
    if data.isascii():
        return "utf-8"
    head = data[: 1 << 20]
    try:
        head.decode("utf-8")
    except UnicodeDecodeError as error:
        cut_at_the_end = len(data) > len(head) and error.start >= len(head) - 4
        valid_before = any(byte >= 0x80 for byte in head[: error.start])
        if cut_at_the_end and valid_before:
            return "utf-8"
        return _code_page(head)
    return "utf-8"


def _code_page(head: bytes) -> str:
    if _CYRILLIC_RUN.search(head):
        return "cp1251"
    if len(_POLISH.findall(head)) > len(_WESTERN.findall(head)):
        return "cp1250"
    return "cp1252"
