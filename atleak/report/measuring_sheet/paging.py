"""Lay a measuring sheet out on paper: rows high enough for a pencil, and no block of rows cut by the end of a page."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

_PIXEL = 0.75  # [pt] to which workbooks round a row's height
ROW = 7.0  # [mm] least height of a row on paper, to write in by hand: choice of this project
_PAGE = 297.0, 210.0  # [mm] A4, landscape
LEFT, RIGHT, TOP, BOTTOM = 0.4, 0.4, 0.4, 0.5  # [in] margins: 24 rows fit, a component of two lands and one of one
_INCH, _POINT = 25.4, 25.4 / 72.0  # [mm]
_PIXELS = 96.0  # of an inch
_SPARE = 0.82  # of the width that is used: without the sheet's font a program takes a wider one

Block = Sequence["Block"] | int  # blocks within a block; at the end a number of rows


@dataclass(frozen=True)
class Paging:
    """How the sheet is shrunk to a page's width, and what that makes of heights.

    Parameters
    ----------
    widths
        of the columns, in characters.
    above
        heights of the rows over the first one to fill in [pt]; the last of them is repeated on every page.
    """

    widths: tuple[int, ...]
    above: tuple[float, ...]

    @property
    def scale(self) -> int:
        """Return the scale of printing [%] at which all columns stand side by side."""
        drawn = sum(7 * width + 5 for width in self.widths) / _PIXELS * _INCH
        return int(min(100.0, 100.0 * _SPARE * (_PAGE[0] - (LEFT + RIGHT) * _INCH) / drawn))

    @property
    def row_height(self) -> float:
        """Return the height of a row [pt], at least `ROW` when printed, in whole pixels as workbooks keep it."""
        return math.ceil(ROW / _POINT * 100.0 / self.scale / _PIXEL) * _PIXEL

    def breaks(self, blocks: Sequence[Block]) -> list[int]:
        """Return the rows before which a page begins, counted from the first row to fill in.

        A block that fits on a page stands on one; of a larger one its own blocks do. The first page has the head, so
        that of its first block too the own blocks may have to.
        """
        found: list[int] = []
        used = self._printed(sum(self.above))
        blocks = list(blocks)
        while blocks and not isinstance(blocks[0], int) and used + self._height(blocks[0]) > self._room:
            blocks[:1] = blocks[0]
        for row, rows in self._pieces(blocks):
            height = self._printed(rows * self.row_height)
            if row and used + height > self._room:
                found.append(row)
                used = self._printed(self.above[-1])
            used += height
        return found

    def _pieces(self, blocks: Sequence[Block]) -> Iterator[tuple[int, int]]:
        """Yield first row and number of rows of what must not be cut."""
        row = 0
        for block in blocks:
            rows = _rows_of(block)
            fits = self._printed(self.above[-1] + rows * self.row_height) <= self._room
            if fits or isinstance(block, int):
                yield row, rows
            else:
                yield from ((row + first, many) for first, many in self._pieces(block))
            row += rows

    def _height(self, block: Block) -> float:
        return self._printed(_rows_of(block) * self.row_height)

    def _printed(self, points: float) -> float:
        """Return a height on paper [mm]."""
        return points * _POINT * self.scale / 100.0

    @property
    def _room(self) -> float:
        """Return the height of a page between its margins [mm]."""
        return _PAGE[1] - (TOP + BOTTOM) * _INCH


def _rows_of(block: Block) -> int:
    return block if isinstance(block, int) else sum(map(_rows_of, block))
