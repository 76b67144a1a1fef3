"""Know the fonts of the printed report: which characters they have, and how wide a text is in them.

For characters that the bundled fonts lack there is a font file that the workshop names, never the system's, and last a
font of boxes: one sees a box, and the file keeps the text.
"""

from __future__ import annotations

import io
import re
import struct
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache, lru_cache
from pathlib import Path

from fontTools.fontBuilder import FontBuilder
from fontTools.pens.ttGlyphPen import TTGlyphPen
from fontTools.ttLib import TTFont, TTLibError

from atleak.common.errors import InputError, OutputError, Place, reason_of
from atleak.common.files import home, made_folder, replace_file
from atleak.common.sentences import Sentence

FONTS = Path(__file__).parent / "fonts"
_TEXT, _OTHERS = "NotoSans-Regular.ttf", ("NotoSans-Bold.ttf", "DejaVuSans.ttf")
_UNKNOWN = 0.6  # width of a character that is set in another font, against the size


@cache
def _widths(name: str) -> dict[int, float]:
    """Return the width of every character of a bundled font, against the size."""
    with TTFont(FONTS / name, lazy=True) as font:
        metrics, em = font["hmtx"].metrics, font["head"].unitsPerEm
        return {sign: metrics[glyph][0] / em for sign, glyph in font.getBestCmap().items()}


@cache
def glyphs() -> frozenset[int]:
    """Return the code points that the bundled fonts have."""
    return frozenset().union(*map(_widths, (_TEXT, *_OTHERS)))


def width_of(text: str, size: float) -> float:
    """Return how wide a line of text is [in the unit of its size]."""
    widths = _widths(_TEXT)
    return size * sum(widths.get(ord(sign)) or _elsewhere(sign) for sign in text)


def _elsewhere(sign: str) -> float:
    """Return about how wide a character is in another font: those of East Asia fill a square."""
    return 1.0 if unicodedata.east_asian_width(sign) in "WF" else _UNKNOWN


def fitting(text: str, size: float, width: float) -> str:
    """Return as much of a text as is no wider; an ellipsis stands for the rest."""
    if width_of(text, size) <= width:
        return text
    shorter = text
    while shorter and width_of(f"{shorter}…", size) > width:
        shorter = shorter[:-1].rstrip()
    return f"{shorter}…"


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
    folder, earlier = made_folder(home() / _FOLDER), kept_file()
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


BOX_FONT = "Atleak Boxes"
_JOINERS = ("\u200c", "\u200d", "\ufe0e", "\ufe0f")
_EM, _WIDTH, _LINE = 1000, 600, 60


def box_font(characters: Sequence[str], text: str) -> bytes:
    """Return a TrueType font that draws a box for each of the characters and for each sequence of them in the text.

    Joiners, variation selectors and skin tones hold a sequence together. As it is one box, it is also copied from the
    PDF as one piece of text.
    """
    names = {sign: f"box{number}" for number, sign in enumerate(characters)}
    joiners = {sign: f"joiner{number}" for number, sign in enumerate(_JOINERS)}
    sequences = {sequence: f"sequence{number}" for number, sequence in enumerate(_sequences(characters, text))}
    order = [".notdef", *joiners.values(), *names.values(), *sequences.values()]
    builder = FontBuilder(_EM, isTTF=True)
    builder.setupGlyphOrder(order)
    builder.setupCharacterMap({ord(sign): name for sign, name in (joiners | names).items()})
    nothing = dict.fromkeys(joiners.values(), TTGlyphPen(None).glyph())
    builder.setupGlyf({**dict.fromkeys(order, _box()), **nothing})
    builder.setupHorizontalMetrics({**dict.fromkeys(order, (_WIDTH, 60)), **dict.fromkeys(nothing, (0, 0))})
    if sequences:
        parts = joiners | names
        rules = [f"sub {' '.join(parts[sign] for sign in sequence)} by {name};" for sequence, name in sequences.items()]
        builder.addOpenTypeFeatures(f"feature ccmp {{ {' '.join(rules)} }} ccmp;")
    builder.setupHorizontalHeader(ascent=900, descent=-200)
    builder.setupNameTable(
        {
            "familyName": BOX_FONT,
            "styleName": "Regular",
            "uniqueFontIdentifier": BOX_FONT,
            "fullName": BOX_FONT,
            "psName": BOX_FONT.replace(" ", "-"),
            "version": "Version 1.0",
        }
    )
    builder.setupOS2(sTypoAscender=900, sTypoDescender=-200, usWinAscent=900, usWinDescent=200)
    builder.setupPost()
    builder.font["head"].created = builder.font["head"].modified = 0  # the same characters give the same bytes
    builder.font.recalcTimestamp = False
    target = io.BytesIO()
    builder.save(target)
    return target.getvalue()


def _sequences(characters: Sequence[str], text: str) -> list[str]:
    """Return the sequences of a text, the longest first: a short one must not take the beginning of a long one."""
    known = "".join(map(re.escape, characters))
    pattern = f"[{known}](?:[\ufe0e\ufe0f\U0001f3fb-\U0001f3ff]|\u200d[{known}])+"
    sequences = {each for each in re.findall(pattern, text) if set(each) <= {*characters, *_JOINERS}}
    return sorted(sequences, key=lambda each: (-len(each), each))


def _box() -> object:
    pen = TTGlyphPen(None)
    left, right, low, high = 60, _WIDTH - 60, 0, 720
    for inset, clockwise in ((0, True), (_LINE, False)):
        corners = [
            (left + inset, low + inset),
            (left + inset, high - inset),
            (right - inset, high - inset),
            (right - inset, low + inset),
        ]
        corners = corners if clockwise else corners[::-1]
        pen.moveTo(corners[0])
        for corner in corners[1:]:
            pen.lineTo(corner)
        pen.closePath()
    return pen.glyph()
