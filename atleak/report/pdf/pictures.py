"""The job's pictures as a report can print them."""

from __future__ import annotations

import io
import warnings
from pathlib import Path

from PIL import Image, ImageOps

from atleak.errors import InputError
from atleak.job.record import Job

_PHOTO_PIXELS = 1400  # of the longer side: sharp at the size it is printed
_PICTURE_LIMIT = 80_000_000  # pixels of a picture that is opened at all


def write_pictures(job: Job, folder: Path) -> dict[str, str]:
    """The job's pictures beside the template, turned upright and no larger than they are printed."""
    found = {}
    for number, (name, content) in enumerate(job.pictures.items()):
        suffix, content = printable_picture(name, content)
        found[name] = f"picture{number}.{suffix}"
        (folder / found[name]).write_bytes(content)
    return found


def printable_picture(name: str, content: bytes) -> tuple[str, bytes]:
    """A picture as PNG or JPEG without its metadata (a phone writes the place into it), upright and scaled down.

    Raises
    ------
    InputError
        what is no PNG, JPEG or WebP, or is damaged or too large.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            picture: Image.Image = Image.open(io.BytesIO(content), formats=("PNG", "JPEG", "WEBP"))
            if picture.width * picture.height > _PICTURE_LIMIT:
                raise InputError("picture too large", value=name, expected=f"at most {_PICTURE_LIMIT} pixels")
            picture = ImageOps.exif_transpose(picture)
            picture.thumbnail((_PHOTO_PIXELS, _PHOTO_PIXELS))
            transparent = picture.mode in ("RGBA", "LA", "PA") or "transparency" in picture.info
            target = io.BytesIO()
            if transparent:
                picture.convert("RGBA").save(target, "PNG")
                return "png", target.getvalue()
            picture.convert("RGB").save(target, "JPEG", quality=85)
            return "jpg", target.getvalue()
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError, Image.DecompressionBombWarning) as error:
        raise InputError("picture cannot be read", value=name, expected="a sound PNG, JPEG or WebP file") from error
