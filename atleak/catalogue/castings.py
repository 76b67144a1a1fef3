"""Keep a photo of the opened valve body for each description, with where on it the bores of its components lie.

Each is one file beside the user's own entries, named as the id of its description: of a shipped one, too. A valve
body's file that is sent to someone else goes without it.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Annotated

from pydantic import Field

from atleak.catalogue.entries import NonEmptyText, Strict, own_folder
from atleak.common.damage import own_errors_only
from atleak.common.errors import CatalogueError, InputError, OutputError, Place, reason_of
from atleak.common.files import made_folder, replace_file
from atleak.common.pictures import printable_picture
from atleak.common.sentences import Sentence

_Fraction = Annotated[float, Field(ge=0, le=1)]


class Casting(Strict):
    """A photo of an opened valve body, and the bores that are marked on it."""

    photo: Annotated[str, Field(pattern=r"^data:image/(jpeg|png);base64,[A-Za-z0-9+/]+=*$")]  # as its address holds it
    width: Annotated[int, Field(ge=1)]  # [px]
    height: Annotated[int, Field(ge=1)]  # [px]
    marks: Mapping[NonEmptyText, tuple[_Fraction, _Fraction]] = {}  # fractions of width and height, by component

    @classmethod
    def of_photo(cls, name: str, content: bytes) -> Casting:
        """Return a photo without a mark: upright, scaled down, without what the camera noted in it.

        Raises
        ------
        InputError
            if the file is no picture that can be read.
        """
        from PIL import Image  # only who loads a photo needs it

        suffix, picture = printable_picture(name, content)
        with Image.open(io.BytesIO(picture)) as opened:
            width, height = opened.size
        kind = {"jpg": "jpeg"}.get(suffix, suffix)
        return cls(photo=f"data:image/{kind};base64,{base64.b64encode(picture).decode()}", width=width, height=height)

    def marked(self, marks: Mapping[str, Sequence[float]]) -> Casting:
        """Return the same photo with other marks: by component, fractions of width and height from the upper left.

        Raises
        ------
        InputError
            for a mark that is not on the photo.
        """
        for component, (across, down) in marks.items():
            if not (0.0 <= across <= 1.0 and 0.0 <= down <= 1.0):
                problem = Sentence("the mark of {component} is not on the photo", component=component)
                expected = Sentence("fractions of its width and height, from 0 to 1")
                raise InputError(problem, value=f"{across:g}, {down:g}", expected=expected)
        return self.model_copy(update={"marks": {name: (across, down) for name, (across, down) in marks.items()}})


def casting_file(controller: str) -> Path:
    """Return where the photo of a description lies, by the description's id; it need not be there."""
    return own_folder("castings") / f"{controller}.json"


@own_errors_only(CatalogueError, "controller")
def load_casting(controller: str) -> Casting | None:
    """Return the photo that is kept for a description, by the description's id; None without one.

    Raises
    ------
    CatalogueError
        for a file that cannot be read, or was damaged.
    """
    path = casting_file(controller)
    try:
        return Casting.model_validate_json(path.read_bytes())
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        problem = Sentence("holds no photo of a valve body that can be shown")
        expected = Sentence("the file as atleak wrote it; load the photo again on the page Library")
        raise CatalogueError(problem, place=Place(file=str(path)), expected=expected) from error


def sound_casting(controller: str) -> Casting | None:
    """Return what `load_casting` returns; None for a damaged file too: Library and Diagnosis tell of it."""
    with suppress(CatalogueError):
        return load_casting(controller)
    return None


def keep_casting(controller: str, casting: Casting | None) -> None:
    """Keep a photo and its marks for every job with this description, in place of the one before; None takes it away.

    Raises
    ------
    OutputError
        where the file cannot be written, or not be taken away.
    """
    path = casting_file(controller)
    if casting is not None:
        made_folder(path.parent)
        replace_file(path, casting.model_dump_json().encode())
        return
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        problem = Sentence("cannot be taken away: {reason}", reason=reason_of(error))
        raise OutputError(problem, place=Place(file=str(path))) from error
