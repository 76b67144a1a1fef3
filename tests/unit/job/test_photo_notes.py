"""The photos of a job file: no place and no camera in them, the picture as it was."""

from __future__ import annotations

import io
from typing import Any

import pytest
from PIL import Image, ImageOps, PngImagePlugin

from atleak.job.photos import without_notes

PLACE = 0x8825
SECRET = b"Secret Camera"


def noted(form: str, turned: int | None, mode: str = "RGB", **options: Any) -> bytes:
    exif = Image.Exif()
    exif[0x010F] = SECRET.decode()
    exif[PLACE] = {1: "N"}  # get_ifd(PLACE)[1] does not reach it in early versions
    if turned is not None:
        exif[0x0112] = turned
    if form == "PNG":
        texts = PngImagePlugin.PngInfo()
        texts.add_text("Comment", SECRET.decode())
        options["pnginfo"] = texts
    if form == "JPEG":
        options["comment"] = SECRET
    picture = Image.linear_gradient("L").resize((60, 40)).convert(mode)
    target = io.BytesIO()
    picture.save(target, form, exif=exif, xmp=b"<x>" + SECRET + b"</x>", **options)
    return target.getvalue()


@pytest.mark.parametrize("turned", [None, 1, 6])
@pytest.mark.parametrize(
    ("form", "options"),
    [
        ("JPEG", {}),
        ("JPEG", {"progressive": True}),
        ("PNG", {}),
        ("PNG", {"mode": "RGBA"}),
        ("WEBP", {}),
        ("WEBP", {"mode": "RGBA", "lossless": True}),
    ],
)
def test_the_place_is_gone_and_the_picture_is_as_it_was(form: str, options: dict[str, Any], turned: int | None) -> None:
    content = noted(form, turned, **options)
    assert SECRET in content
    cleaned = without_notes(content)
    assert SECRET not in cleaned
    before, after = (Image.open(io.BytesIO(each)) for each in (content, cleaned))
    assert PLACE in before.getexif()
    assert set(after.getexif()) <= {0x0112}
    assert ImageOps.exif_transpose(after).tobytes() == ImageOps.exif_transpose(before).tobytes()
    assert ImageOps.exif_transpose(after).size == ((40, 60) if turned == 6 else (60, 40))
    assert without_notes(cleaned) == cleaned


def test_what_a_phone_hangs_behind_the_picture_is_gone_too() -> None:
    content = noted("JPEG", 6)
    assert without_notes(content + noted("JPEG", 6) + b"trailer") == without_notes(content)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"not a picture",
        b"\xff\xd8",
        b"\xff\xd8\xff\xe1\x00",
        noted("PNG", 6)[:30],
        b"RIFF\x00\x00\x00\x00WEBP"[:11],
    ],
)
def test_what_has_no_notes_stays_as_it_is(content: bytes) -> None:
    assert without_notes(content) == content


@pytest.mark.parametrize("form", ["JPEG", "PNG", "WEBP"])
def test_a_picture_that_is_cut_short_keeps_no_notes_either(form: str) -> None:
    content = noted(form, 6)
    for length in range(20, len(content)):
        assert SECRET not in without_notes(content[:length]), length
    damaged = without_notes(content[:2] + b"garbage" + content[2:])
    assert SECRET not in damaged or form != "JPEG"


def test_a_photo_without_its_last_bytes_still_shows_its_picture() -> None:
    content = noted("JPEG", 6)
    cut = without_notes(content[:-2])
    assert without_notes(content).startswith(cut)
    assert len(cut) == len(without_notes(content)) - 2
