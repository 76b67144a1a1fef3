"""Take a font file that the workshop names, for the characters that the report's own fonts lack: never the system's."""

from __future__ import annotations

import io
import struct
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from fontTools.ttLib import TTFont, TTLibError

from atleak.errors import InputError, OutputError, Place
from atleak.report.printed_fonts import glyphs
from atleak.sentence import Sentence
from atleak.system.files import replace_file
from atleak.system.home import home, made
from atleak.system.reasons import reason_of

OWN_FONT = "Atleak Own Font"  # its family in a report, whatever the file calls it
_FOLDER = "report_font"  # in the user's folder, with one file in it
_LARGEST = 64_000_000  # [bytes]: the fonts for all of Chinese, Japanese and Korean have some 20 MB


@dataclass(frozen=True)
class OwnFont:
    """A font file: its name, the same font under a family of its own, and the code points that it has."""

    name: str
    content: bytes = field(repr=False)
    glyphs: frozenset[int] = field(repr=False)


@lru_cache(maxsize=2)
def read_font(content: bytes, name: str) -> OwnFont:
    """Return the font in a file; of a collection the first one.

    Raises
    ------
    InputError
        the file is no TrueType or OpenType font, or one of which no character can be drawn.
    """
    place = Place(file=name)
    expected = Sentence("a TrueType or OpenType font (.ttf, .otf, .ttc)")
    if len(content) > _LARGEST:
        most = Sentence("at most {count} bytes", count=_LARGEST)
        raise InputError(Sentence("the font file is too large"), place=place, value=len(content), expected=most)
    try:
        with TTFont(io.BytesIO(content), fontNumber=0, lazy=True, recalcTimestamp=False) as font:
            drawn = frozenset(font.getBestCmap() or ())
            if font.flavor is not None or not drawn or not {"glyf", "CFF ", "CFF2"} & set(font.keys()):
                raise InputError(Sentence("font cannot be used"), place=place, expected=expected)
            font["name"].names = []
            for number, said in {1: OWN_FONT, 2: "Regular", 4: OWN_FONT, 6: OWN_FONT.replace(" ", "-")}.items():
                font["name"].setName(said, number, 3, 1, 0x409)
            target = io.BytesIO()
            font.save(target, reorderTables=False)
    except (TTLibError, KeyError, ValueError, IndexError, AssertionError, struct.error, OSError) as error:
        raise InputError(Sentence("no font can be read in it"), place=place, expected=expected) from error
    return OwnFont(name, target.getvalue(), drawn)


def font_at(path: str | Path) -> OwnFont:
    """Return the font of a file that is named, as on the command line.

    Raises
    ------
    InputError
        the file cannot be read, or is no font.
    """
    path = Path(path)
    try:
        content = path.read_bytes()
    except OSError as error:
        problem = Sentence("cannot be read: {reason}", reason=reason_of(error))
        raise InputError(problem, place=Place(file=str(path))) from error
    return read_font(content, path.name)


def kept_file() -> Path | None:
    """Return the font file that the workshop keeps for its reports; None without one."""
    folder = home() / _FOLDER
    files = sorted(each for each in folder.iterdir() if each.is_file()) if folder.is_dir() else []
    return files[0] if files else None


def kept_font() -> OwnFont | None:
    """Return the font that the workshop keeps for its reports; None without one."""
    path = kept_file()
    return None if path is None else font_at(path)


def keep_font(content: bytes, name: str) -> OwnFont:
    """Keep a font file for all later reports, in place of any other.

    Raises
    ------
    InputError, OutputError
        the file is no font; it cannot be written.
    """
    font = read_font(content, Path(name).name)
    folder, earlier = made(home() / _FOLDER), kept_file()
    replace_file(folder / font.name, content)
    if earlier is not None and earlier.name != font.name:
        _remove(earlier)
    return font


def forget_font() -> None:
    """Keep no font any more.

    Raises
    ------
    OutputError
        the file cannot be removed.
    """
    path = kept_file()
    if path is not None:
        _remove(path)


def _remove(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        problem = Sentence("cannot be removed: {reason}", reason=reason_of(error))
        raise OutputError(problem, place=Place(file=str(path))) from error


def characters_of(font: OwnFont | None) -> frozenset[int]:
    """Return the code points that a report can show."""
    return glyphs() if font is None else glyphs() | font.glyphs
