"""The photo of an opened valve body: what is kept of it, where its bores may lie, and what is refused."""

from __future__ import annotations

import base64
import io
from pathlib import Path

import pytest
from PIL import Image
from pydantic import ValidationError

from atleak.catalogue.castings import Casting, casting_file, keep_casting, load_casting
from atleak.common.errors import CatalogueError, InputError, OutputError


def photo(width: int = 40, height: int = 30, **notes: object) -> bytes:
    target = io.BytesIO()
    Image.new("RGB", (width, height), "grey").save(target, "JPEG", **notes)
    return target.getvalue()


def test_a_photo_is_kept_upright_and_small_without_what_the_camera_noted(own_home: Path) -> None:
    notes = Image.Exif()
    notes[0x0112] = 6  # turned by a quarter
    notes[0x010F] = "maker of the phone"
    notes.get_ifd(0x8825)[1] = "N"  # a place
    casting = Casting.of_photo("IMG_1.JPG", photo(3000, 2000, exif=notes, comment=b"who took it"))
    keep_casting("gearbox", casting.marked({"25": (0.25, 0.5)}))
    kept = load_casting("gearbox")
    assert kept is not None
    content = base64.b64decode(kept.photo.partition(",")[2])
    shown = Image.open(io.BytesIO(content))
    assert shown.size == (kept.width, kept.height)
    assert kept.width < kept.height <= 1600
    assert not shown.getexif()
    assert not [noted for noted in (b"who took it", b"maker of the phone") if noted in content]
    assert dict(kept.marks) == {"25": (0.25, 0.5)}
    assert load_casting("another") is None


def test_one_of_another_size_takes_its_place_and_it_can_be_taken_away(own_home: Path) -> None:
    keep_casting("gearbox", Casting.of_photo("a.jpg", photo()).marked({"25": (0.25, 0.5)}))
    keep_casting("gearbox", Casting.of_photo("b.jpg", photo(20, 60)))
    kept = load_casting("gearbox")
    assert kept is not None
    assert (kept.width, kept.height, dict(kept.marks)) == (20, 60, {})
    keep_casting("gearbox", None)
    keep_casting("gearbox", None)  # there is none any more
    assert load_casting("gearbox") is None


@pytest.mark.parametrize("mark", [(1.01, 0.5), (0.5, -0.01), (float("nan"), 0.5)])
def test_a_mark_that_is_not_on_the_photo_is_refused_by_its_bore(mark: tuple[float, float]) -> None:
    casting = Casting.of_photo("a.jpg", photo())
    with pytest.raises(InputError, match=r"the mark of 25 is not on the photo .* from 0 to 1"):
        casting.marked({"17": (1.0, 0.0), "25": mark})


@pytest.mark.parametrize("content", [b"", b"no picture", photo()[:120]])
def test_what_is_no_picture_is_refused_by_its_name(content: bytes) -> None:
    with pytest.raises(InputError, match=r"picture cannot be read \(found 'IMG_1\.HEIC'\)"):
        Casting.of_photo("IMG_1.HEIC", content)


@pytest.mark.parametrize(
    ("before", "after"),
    [('"marks":{"25":[0.25', '"marks":{"25":[1.25'), ("data:image/jpeg;base64,", 'x" onload="'), ("}", "")],
)
def test_a_damaged_file_is_named_with_what_helps(own_home: Path, before: str, after: str) -> None:
    keep_casting("gearbox", Casting.of_photo("a.jpg", photo()).marked({"25": (0.25, 0.5)}))
    file = casting_file("gearbox")
    text = file.read_text(encoding="utf-8")
    assert before in text
    file.write_text(text.replace(before, after), encoding="utf-8")
    with pytest.raises(CatalogueError, match=r"gearbox\.json: .*load the photo again on the page Library"):
        load_casting("gearbox")


def test_only_a_picture_can_stand_where_the_photo_does() -> None:
    with pytest.raises(ValidationError):
        Casting(photo="data:image/svg+xml;base64,AAAA", width=1, height=1)


def test_one_that_cannot_be_taken_away_says_so(own_home: Path) -> None:
    casting_file("gearbox").mkdir(parents=True)
    with pytest.raises(OutputError, match=r"gearbox\.json: cannot be taken away"):
        keep_casting("gearbox", None)
