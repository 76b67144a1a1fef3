"""Damage a sound file as cards, cables, programs and people do: cut, turn bits, swap entries, overdo numbers, quote."""

from __future__ import annotations

import io
import re
import zipfile
from typing import Any

from hypothesis import strategies as st

from .seeds import File, seeds

_NUMBER = re.compile(rb"\d+(?:[.,]\d+)?")
_TAG = re.compile(rb"<[^<>]{1,200}>")
_WORD = re.compile(rb"[A-Za-z_\xc0-\xff]{2,}")
_ODD: tuple[bytes, ...] = (
    b"", b"0", b"-1", b"1e306", b"1e999", b"-1e999", b"nan", b"inf", b"9" * 5000, b"1,2,3", b"1.234.567", b"0x1F",
    b"1e-320", b"99999999999999999999", b"2147483648", b"1/0", b"#REF!", b"=1+1", b"8-1", b"8.0000000000001",
    b"3:70:99", b"--", "½".encode(), "١٢٣".encode(), "−5".encode(),
)  # fmt: skip
_SIGNS: tuple[bytes, ...] = (
    b'"', b"'", b'"""', b"\0", b"\r", b"\n\n\n", b";", b"\t", b",,,,", b"\x1b[31m", b"\xff\xfe", b"\xef\xbb\xbf",
    b"\\ud800", b"\\", b"\x85", b"\xe2\x80\xa8", b"[[", b"]]", b"{", b"}", b"&a;", b"<!--", b"]]>", b"<a>" * 40,
    b"(" * 400, b"," * 1000, b" " * 5000, b"PK\3\4", b"PK\5\6", b"sep=|\n", "Żółw".encode("cp1250"),
    "мм".encode("cp1251"), b"%n%s", b"../../x", b"=cmd|'x'!A0",
)  # fmt: skip
_BYTE = st.integers(0, 255)


@st.composite
def damaged(draw: st.DrawFn, door: str) -> File:
    """A file of a door's seeds with one to four damages."""
    name, content = draw(st.sampled_from(seeds(door)))
    for _ in range(draw(st.integers(1, 4))):
        content = draw(_one(content, door))
    return name, content


def _one(content: bytes, door: str) -> st.SearchStrategy[bytes]:
    others = [seed for _, seed in seeds(door)]
    ways = [_bytes(content, others), _text(content)]
    if content.startswith(b"PK"):
        ways += [_entries(content), _entries(content), _headers(content)]
    return st.one_of(*ways)


@st.composite
def _bytes(draw: st.DrawFn, content: bytes, others: list[bytes]) -> bytes:
    at = draw(st.integers(0, max(len(content) - 1, 0)))
    length = draw(st.one_of(st.integers(1, 16), st.integers(1, max(len(content), 1))))
    way = draw(st.integers(0, 7))
    if way == 0:
        return content[:at]
    if way == 1:
        return content[at:]
    if way == 2:
        return content[:at] + content[at + length :]
    if way == 3:
        return content[:at] + content[at : at + length] * draw(st.integers(2, 30)) + content[at + length :]
    if way == 4:
        return content[:at] + bytes(draw(st.lists(_BYTE, min_size=1, max_size=8))) + content[at + 1 :]
    if way == 5:
        return content[:at] + draw(st.sampled_from(_SIGNS)) + content[at:]
    if way == 6:
        other = draw(st.sampled_from(others))
        return content[:at] + other[draw(st.integers(0, max(len(other) - 1, 0))) :]
    turned = bytearray(content)
    for place in draw(st.lists(st.integers(0, max(len(content) - 1, 0)), max_size=8)):
        if place < len(turned):
            turned[place] ^= 1 << draw(st.integers(0, 7))
    return bytes(turned)


@st.composite
def _text(draw: st.DrawFn, content: bytes) -> bytes:
    """What stands in the file as text: numbers overdone, words, tags and lines doubled, swapped or left out."""
    way = draw(st.integers(0, 3))
    if way == 3:
        lines = content.split(b"\n")
        first, second = (draw(st.integers(0, len(lines) - 1)) for _ in range(2))
        lines[first], lines[second] = lines[second], lines[first]
        if draw(st.booleans()):
            lines[first] = b"\n".join([lines[first]] * draw(st.sampled_from([0, 2, 50])))
        return b"\n".join(lines)
    places = [match.span() for match in (_NUMBER, _TAG, _WORD)[way].finditer(content)][:5000]
    if not places:
        return content
    begin, end = draw(st.sampled_from(places))
    other = draw(st.sampled_from(places))
    odd = st.one_of(st.sampled_from(_ODD), st.sampled_from(_SIGNS), st.binary(max_size=6))
    instead: Any = draw(st.one_of(odd, st.just(content[slice(*other)])))
    return content[:begin] + instead + content[end:]


@st.composite
def _entries(draw: st.DrawFn, content: bytes) -> bytes:
    """What an archive holds: an entry damaged, left out, renamed, doubled, or two swapped."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            entries = [(name, archive.read(name)) for name in archive.namelist()]
    except Exception:  # noqa: BLE001  damaged before: nothing to unpack
        return content
    if not entries:
        return content
    at, other = (draw(st.integers(0, len(entries) - 1)) for _ in range(2))
    name, inside = entries[at]
    way = draw(st.integers(0, 6))
    if way == 0:
        del entries[at]
    elif way == 1:
        entries[at], entries[other] = (name, entries[other][1]), (entries[other][0], inside)
    elif way == 2:
        entries[at] = (draw(st.sampled_from(["", "../x", "a" * 300, "\\", name.upper(), f"{name}/"])), inside)
    else:
        changed = draw(_text(inside)) if way < 5 else draw(_bytes(inside, [each for _, each in entries]))
        entries[at] = (name, changed)
    stream = io.BytesIO()
    packing = draw(st.sampled_from([zipfile.ZIP_DEFLATED, zipfile.ZIP_STORED, zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2]))
    with zipfile.ZipFile(stream, "w", packing if way == 6 else zipfile.ZIP_DEFLATED) as archive:
        for name, inside in entries:
            archive.writestr(zipfile.ZipInfo(name or "x"), inside, archive.compression)
    packed = stream.getvalue()
    return packed if name else packed.replace(b"x", b"", 1)


@st.composite
def _headers(draw: st.DrawFn, content: bytes) -> bytes:
    """The headers of an archive: a byte of one, where sizes, offsets, flags and packing stand."""
    marks = [match.start() for match in re.finditer(rb"PK[\1\3\5][\2\4\6]", content)]
    if not marks:
        return content
    at = draw(st.sampled_from(marks)) + draw(st.integers(4, 46))
    return content[:at] + bytes([draw(_BYTE)]) + content[at + 1 :]
