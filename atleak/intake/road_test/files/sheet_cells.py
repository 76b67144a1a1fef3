"""Holds the cells of a workbook's sheet block by block and column by column, numbers packed."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import islice

import numpy as np

Cell = object  # str, float, int, bool, date or time; None where empty
Column = bytes | list[Cell]  # packed floats where every cell is a number or empty (NaN), else a list of cells


@dataclass
class SheetCells:
    """The cells of one sheet in ``blocks`` of rows: how many, and their columns."""

    blocks: list[tuple[int, list[Column]]] = field(default_factory=list)

    @property
    def rows(self) -> int:
        """Return the number of rows."""
        return sum(count for count, _ in self.blocks)

    def head(self, most: int) -> list[list[Cell]]:
        """Return the first rows."""
        _, columns = self.blocks[0]
        return [list(row) for row in islice(zip(*map(_cells, columns), strict=True), most)]

    def column(self, index: int, start: int) -> np.ndarray | list[Cell]:
        """Return a column from a row of the first block on: floats where every cell is a number or empty."""
        parts: list[Column] = [
            columns[index] if index < len(columns) else [None] * count for count, columns in self.blocks
        ]
        first, *others = _cells(parts[0])[start:], *parts[1:]
        packed = [np.frombuffer(part) for part in others if isinstance(part, bytes)]
        if len(packed) == len(others) and all(cell is None or isinstance(cell, int | float) for cell in first):
            return np.concatenate([np.array([np.nan if cell is None else cell for cell in first], float), *packed])
        return [*first, *(cell for part in others for cell in _cells(part))]


def _cells(column: Column) -> list[Cell]:
    if isinstance(column, list):
        return column
    return [None if cell != cell else cell for cell in np.frombuffer(column).tolist()]
