"""Holds the cells of a workbook's sheet: the first rows as they stand, all others column by column, numbers packed."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

Cell = object  # str, float, int, bool, date or time; None where empty


@dataclass
class SheetCells:
    """The cells of one sheet.

    ``head`` are its first rows. ``blocks`` hold the rows behind them: how many, and their columns, each as a list of
    cells, or as packed floats where every cell is a number or empty (NaN). The sheet's column ``left`` is their first.
    """

    head: list[list[Cell]] = field(default_factory=list)
    blocks: list[tuple[int, list[bytes | list[Cell]]]] = field(default_factory=list)
    left: int | None = None

    def add(self, left: int, count: int, rows: list[list[Cell]], columns: list[bytes | list[Cell]]) -> None:
        """Add the next rows: the first ones as they stand, all others column by column, from column ``left`` on."""
        before = (left if self.left is None else self.left) - left
        if before > 0:  # cells further to the left than any so far
            self.head = [[None] * before + row for row in self.head]
            for length, block in self.blocks:
                block[:0] = [np.full(length, np.nan).tobytes()] * before
        self.left = left
        if rows:
            self.head += rows
        else:
            self.blocks.append((count, columns))

    @property
    def rows(self) -> int:
        """Return the number of rows."""
        return len(self.head) + sum(count for count, _ in self.blocks)

    def drop_blank_end(self) -> None:
        """Take away the rows at the end in which every cell is empty."""
        while self.blocks:
            count, columns = self.blocks[-1]
            filled = np.zeros(count, bool)
            for column in columns:
                filled |= _filled(column)
            end = int(np.max(np.flatnonzero(filled), initial=-1)) + 1
            if end == count:
                return
            if end:
                self.blocks[-1] = (end, [_cut(column, end) for column in columns])
                return
            self.blocks.pop()
        while self.head and all(cell is None for cell in self.head[-1]):
            self.head.pop()

    def column(self, index: int, start: int) -> np.ndarray | list[Cell]:
        """Return a column from a row of the head on: floats where every cell is a number or empty, else its cells."""
        first = [row[index] if index < len(row) else None for row in self.head[start:]]
        parts = [columns[index] if index < len(columns) else [None] * count for count, columns in self.blocks]
        numbers = all(cell is None or isinstance(cell, int | float) for cell in first)
        if numbers and all(isinstance(part, bytes) for part in parts):
            packed = [np.frombuffer(part) for part in parts if isinstance(part, bytes)]
            return np.concatenate([np.array([np.nan if cell is None else cell for cell in first], float), *packed])
        cells = first
        for part in parts:
            cells += part if isinstance(part, list) else [None if cell != cell else cell for cell in unpacked(part)]
        return cells


def unpacked(column: bytes) -> list[float]:
    """Return packed floats as a list."""
    return list(np.frombuffer(column).tolist())


def _filled(column: bytes | list[Cell]) -> np.ndarray:
    if isinstance(column, bytes):
        return ~np.isnan(np.frombuffer(column))
    return np.array([cell is not None for cell in column])


def _cut(column: bytes | list[Cell], end: int) -> bytes | list[Cell]:
    return column[: end * 8] if isinstance(column, bytes) else column[:end]
