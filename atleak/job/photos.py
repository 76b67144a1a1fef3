"""Take out of a photo what the camera notes in it, such as the place: its picture stays as it is, byte by byte.

Only the note on how the picture is turned is kept: without it a photo taken upright would lie on its side.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

_PNG = b"\x89PNG\r\n\x1a\n"
_EXIF = b"Exif\0\0"
_PROFILE = b"ICC_PROFILE\0"
_PNG_NOTES = (b"eXIf", b"tEXt", b"zTXt", b"iTXt", b"tIME")
_WEBP_NOTES = (b"EXIF", b"XMP ")
_WEBP_FLAGS = 0x08 | 0x04  # of the head: has Exif, has XMP
_TURNED = 0x0112  # the tag of how the picture is turned
_ALONE = {0x01, *range(0xD0, 0xD9)}  # markers of JPEG without a length


def without_notes(content: bytes) -> bytes:
    """Return a JPEG, PNG or WebP file without the camera's notes; any other bytes as they are.

    A file that is cut short or damaged keeps what it has of its picture. What is cleaned already stays as it is.
    """
    if content.startswith(b"\xff\xd8"):
        return _jpeg(content)
    if content.startswith(_PNG):
        return _png(content)
    if content.startswith(b"RIFF") and content[8:12] == b"WEBP":
        return _webp(content)
    return content


def _jpeg(content: bytes) -> bytes:
    kept, turned = [content[:2]], 1
    for marker, segment in _segments(content):
        body = segment[4:]
        if marker == 0xE1 and body.startswith(_EXIF):
            turned = _orientation(body[len(_EXIF) :])
        of_application = 0xE1 <= marker <= 0xEF
        colours = (marker == 0xE2 and body.startswith(_PROFILE)) or (marker == 0xEE and body.startswith(b"Adobe"))
        if marker != 0xFE and (not of_application or colours):
            kept.append(segment)
    if turned != 1:
        notes = _EXIF + _only_turned(turned)
        first = 2 if len(kept) > 1 and kept[1][:2] == b"\xff\xe0" else 1
        kept.insert(first, b"\xff\xe1" + struct.pack(">H", len(notes) + 2) + notes)
    return b"".join(kept)


def _segments(content: bytes) -> Iterator[tuple[int, bytes]]:
    """Return every segment of a JPEG with its marker, one of a scan with its data; nothing behind the picture's end.

    What stands where a marker must is passed over, as viewers do.
    """
    at = 2
    while (at := content.find(b"\xff", at)) >= 0:
        while content[at : at + 1] == b"\xff":
            at += 1
        if at + 2 >= len(content):
            yield 0xD9, content[at - 1 :]
            return
        marker = content[at]
        at += 1
        if marker == 0xD9:
            yield marker, b"\xff\xd9"
            return
        if marker in _ALONE:
            yield marker, bytes((0xFF, marker))
            continue
        end = at + int.from_bytes(content[at : at + 2], "big")
        if marker == 0xDA:
            end = _end_of_scan(content, end)
        yield marker, bytes((0xFF, marker)) + content[at:end]
        at = end


def _end_of_scan(content: bytes, at: int) -> int:
    """Return where the next marker stands behind a scan's data."""
    while (at := content.find(b"\xff", at)) >= 0 and at + 1 < len(content):
        if content[at + 1] not in (0x00, 0xFF, *range(0xD0, 0xD8)):
            return at
        at += 1 if content[at + 1] == 0xFF else 2
    return len(content)


def _png(content: bytes) -> bytes:
    kept, turned, at = [_PNG], 1, len(_PNG)
    while at < len(content):
        length = int.from_bytes(content[at : at + 4], "big")
        kind, chunk = content[at + 4 : at + 8], content[at : at + 12 + length]
        if kind == b"eXIf":
            turned = _orientation(chunk[8:-4])
        elif kind not in _PNG_NOTES:
            kept.append(chunk)
        at += len(chunk)
        if kind == b"IEND":
            break
    if turned != 1:
        notes = b"eXIf" + _only_turned(turned)
        kept.insert(2, struct.pack(">I", len(notes) - 4) + notes + struct.pack(">I", zlib.crc32(notes)))
    return b"".join(kept)


def _webp(content: bytes) -> bytes:
    kept, turned, at = [], 1, 12
    while at < len(content):
        kind, length = content[at : at + 4], int.from_bytes(content[at + 4 : at + 8], "little")
        chunk = content[at : at + 8 + length + length % 2]
        if kind == b"EXIF":
            turned = _orientation(chunk[8 : 8 + length].removeprefix(_EXIF))
        elif kind not in _WEBP_NOTES:
            kept.append(chunk)
        at += len(chunk)
    if kept and kept[0][:4] == b"VP8X" and len(kept[0]) > 8:
        flags = kept[0][8] & ~_WEBP_FLAGS | (0x08 if turned != 1 else 0)
        kept[0] = kept[0][:8] + bytes((flags,)) + kept[0][9:]
        if turned != 1:
            notes = _only_turned(turned)
            kept.append(b"EXIF" + struct.pack("<I", len(notes)) + notes)
    whole = b"WEBP" + b"".join(kept)
    return b"RIFF" + struct.pack("<I", len(whole)) + whole


def _orientation(notes: bytes) -> int:
    """Return how a camera noted that a picture is turned, 1 to 8; 1 for upright, also where nothing sound is noted."""
    try:
        order = {b"II": "<", b"MM": ">"}[notes[:2]]
        (first,) = struct.unpack_from(f"{order}I", notes, 4)
        (count,) = struct.unpack_from(f"{order}H", notes, first)
        for entry in range(first + 2, first + 2 + 12 * count, 12):
            tag, _, _, value = struct.unpack_from(f"{order}HHIH", notes, entry)
            if tag == _TURNED:
                return int(value) if 1 <= value <= 8 else 1
    except (KeyError, struct.error):
        return 1
    return 1


def _only_turned(turned: int) -> bytes:
    """Return notes that say how a picture is turned and nothing else."""
    return b"MM\0*" + struct.pack(">IHHHIHHI", 8, 1, _TURNED, 3, 1, turned, 0, 0)
