"""Make a photo ready to be printed and kept: upright, no larger than needed, without what the camera notes in it."""

from __future__ import annotations

import io
import warnings
from functools import lru_cache

from atleak.common.damage import own_errors_only
from atleak.common.errors import InputError
from atleak.common.sentences import Sentence

_PHOTO_PIXELS = 1400  # of the longer side: enough to be sharp at the printed size
_PICTURE_LIMIT = 80_000_000  # a picture with more pixels is not opened


@own_errors_only(InputError, "name")
@lru_cache(maxsize=16)  # photos of a job or two: each of its documents shows them
def printable_picture(name: str, content: bytes) -> tuple[str, bytes]:
    """Return a picture as PNG or JPEG, upright, scaled down and without its metadata (a phone writes the place there).

    Raises
    ------
    InputError
        if the picture is no PNG, JPEG or WebP file, is damaged or is too large.
    """
    from PIL import Image, ImageOps  # only who loads a picture needs it

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of damaged notes of the camera: the picture can be seen all the same
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            picture: Image.Image = Image.open(io.BytesIO(content), formats=("PNG", "JPEG", "WEBP"))
            if picture.width * picture.height > _PICTURE_LIMIT:
                expected = Sentence("at most {count} pixels", count=_PICTURE_LIMIT)
                raise InputError(Sentence("picture too large"), value=name, expected=expected)
            picture = ImageOps.exif_transpose(picture)
            picture.thumbnail((_PHOTO_PIXELS, _PHOTO_PIXELS))
            transparent = picture.mode in ("RGBA", "LA", "PA") or "transparency" in picture.info
            target = io.BytesIO()
            if transparent:
                picture.convert("RGBA").save(target, "PNG")
                return "png", target.getvalue()
            picture.convert("RGB").save(target, "JPEG", quality=85, comment="")
            return "jpg", target.getvalue()
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError, Image.DecompressionBombWarning) as error:
        expected = Sentence("a sound PNG, JPEG or WebP file")
        raise InputError(Sentence("picture cannot be read"), value=name, expected=expected) from error
