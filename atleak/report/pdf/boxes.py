"""Make a font of boxes for the characters that no bundled font has: one sees a box, the file keeps the text."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence

from fontTools.fontBuilder import FontBuilder
from fontTools.pens.ttGlyphPen import TTGlyphPen

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
