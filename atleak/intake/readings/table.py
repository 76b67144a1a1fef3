"""A table of a sheet: its headings and what they say its columns are, its rows, and what its title says of all."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from atleak.catalogue.instruments import Part
from atleak.errors import Message, Place
from atleak.intake.readings.one_heading import KEYS, OF_LANDS, SAYS_NOTHING, Column, Role
from atleak.intake.readings.words import is_blank, is_page_title, part_said, text_of
from atleak.intake.sheets.sheet import Cell, Sheet
from atleak.sentence import Sentence


@dataclass(frozen=True)
class Table:
    """One table of a sheet, with headings in rows ``first`` to ``last`` from 0, of all columns in ``texts``.

    A table that goes on under another title, or on another sheet, has no headings of its own: ``last`` is then the row
    above its first one, -1 at the top of a sheet. ``sheet`` holds its cells at the places of the whole sheet, and
    nothing of the tables beside and below. ``part`` and ``component`` are what the title or the sheet's name says, with
    ``said_by`` naming it. ``aside`` is why a table holds no readings of this valve body, None where it may. ``used``
    are columns whose numbers went into others behind the last, ``filled`` rows whose labels are those of a row above,
    and ``told`` is what is to be said of both.
    """

    sheet: Sheet
    first: int
    last: int
    columns: tuple[Column, ...]
    texts: tuple[str, ...] = ()
    part: Part | None = None
    component: str | None = None
    said_by: Sentence | None = None
    aside: Sentence | None = None
    used: frozenset[int] = frozenset()
    told: tuple[Message, ...] = ()
    filled: frozenset[int] = frozenset()

    # --- headings and columns -----------------------------------------------------------------------------------------

    def heading(self, index: int) -> str:
        """Return a column's heading on one line; "" where it has none."""
        return " ".join(self.texts[index].split()) if index < len(self.texts) else ""

    def heading_place(self, index: int | None = None) -> Place:
        """Return the place of a column's heading, or of the row of headings."""
        return self.sheet.place(max(self.last, 0), index, "" if index is None else self.heading(index))

    def of(self, role: Role) -> tuple[Column, ...]:
        """Return the columns of that role."""
        return tuple(column for column in self.columns if column.role == role)

    def role(self, index: int) -> Role | None:
        """Return the role of a column, None where its heading says nothing known."""
        return next((column.role for column in self.columns if column.index == index), None)

    @cached_property
    def values(self) -> tuple[Column, ...]:
        """Return the columns of diameters and their coordinates."""
        return tuple(column for column in self.columns if column.holds_value)

    @cached_property
    def of_lands(self) -> tuple[Column, ...]:
        """Return the columns of what a land itself has, or its component: contact length, position, fitted repair."""
        return tuple(column for column in self.columns if column.role in OF_LANDS)

    @property
    def labels(self) -> list[Column]:
        """Return the columns that say of which component, part or place the rows are."""
        return [column for column in self.columns if column.role in ("component", "part", "plane", "land")]

    @property
    def roles(self) -> set[Role]:
        """Return what the headings name, of all that makes a reading."""
        return {column.role for column in self.columns}.difference(SAYS_NOTHING)

    @property
    def complete(self) -> bool:
        """Return whether the rows under the headings can be read at all."""
        return bool(self.of("component") and self.values)

    @property
    def score(self) -> float:
        """Return how much this looks like the headings of a measuring sheet."""
        named = self.roles
        distinct = {(column.role, column.coordinate, column.group) for column in self.values}
        return (
            2.0 * ("component" in named)
            + 2.0 * bool(distinct)
            + len(named & {"part", "plane", "land", "direction"})
            + 0.5 * ("repeat" in named)
            + 0.1 * min(len(distinct), 20)
            + 0.05 * any(column.unit for column in self.values)
            - 0.1 * (len(self.values) - len(distinct))
            - 0.01 * (self.last - self.first)
        )

    @property
    def has_part(self) -> bool:
        """Return whether a column says the part, or every heading of a value; also a "component" column of parts."""
        headed = bool(self.values) and all(column.part for column in self.values)
        return bool(self.of("part")) or headed or any(map(self.names_parts, self.of("component")))

    @property
    def is_of_lands(self) -> bool:
        """Return whether it holds no diameters, and what lands themselves have: lengths, repairs that are fitted."""
        return not self.values and bool(self.of_lands) and not self.aside

    @property
    def readable(self) -> bool:
        """Return whether readings can be read from the table at all."""
        known = self.of("component") or self.component is not None
        return bool(known and self.values and not self.aside)

    @cached_property
    def span(self) -> range:
        """Return the columns that the table spans."""
        wide = [index for index, text in enumerate(self.texts) if text]
        return range(min(wide), max(wide) + 1) if wide else range(self.sheet.width)

    # --- rows and cells -----------------------------------------------------------------------------------------------

    @property
    def rows(self) -> range:
        """Return the rows under the headings."""
        return range(self.last + 1, len(self.sheet.rows))

    def cells(self, index: int) -> dict[int, Cell]:
        """Return what stands in a column under its heading, by row; in each row of merged cells."""
        return {row: cell for row in self.rows if not is_blank(cell := self.sheet.filled(row, index))}

    def count_values(self) -> int:
        """Count the cells under the headings that hold something where a diameter belongs."""
        return sum(not is_blank(self.sheet.cell(row, column.index)) for row in self.rows for column in self.values)

    def names_parts(self, column: Column) -> bool:
        """Return whether most cells of a column name a part, and nothing else."""
        cells = self.cells(column.index).values()
        return 2 * sum(part_said(text_of(cell)) is not None for cell in cells) > len(cells)

    def place(self, row: int, column: Column) -> Place:
        """Return the place of a cell."""
        return self.sheet.place(row, column.index, column.name)

    @cached_property
    def block(self) -> range:
        """Return the rows under the headings up to the first empty one."""
        for row in self.rows[1:]:
            if all(is_blank(self.sheet.cell(row, column)) for column in self.span):
                return range(self.last + 1, row)
        return self.rows

    @cached_property
    def title(self) -> str:
        """Return the line of text above the headings, but no count of pages; "" where there is none."""
        lines = [cells for row in self.sheet.rows[: max(self.first, 0)] if (cells := self._filled(row))]
        alone = lines and len(lines[-1]) == 1 and isinstance(lines[-1][0], str)
        return str(lines[-1][0]) if alone and not is_page_title(lines[-1][0]) else ""

    def _filled(self, row: Iterable[Cell]) -> list[Cell]:
        return [cell for cell in row if not is_blank(cell)]

    @cached_property
    def where(self) -> Sentence:
        """Return the rows from the headings to the last one, as a person counts them."""
        first = self.sheet.row_number(max(self.first, 0))
        rows = [row for row in self.block if self._filled(self.sheet.rows[row])]
        last = self.sheet.row_number(rows[-1]) if rows else first
        if self.sheet.name is None:
            return Sentence("rows {first} to {last}", first=first, last=last)
        return Sentence("sheet {name!r}, rows {first} to {last}", name=self.sheet.name, first=first, last=last)

    # --- the same table, otherwise ------------------------------------------------------------------------------------

    @property
    def as_it_stands(self) -> Table:
        """Return the table for what stands above its headings in the file, also where it was turned."""
        if not self.sheet.turned:
            return self
        first = min((each.index for each in self.columns if each.holds_size or each.role in KEYS), default=0)
        return replace(self, sheet=replace(self.sheet, turned=False), first=first)

    def with_columns(
        self, columns: Sequence[tuple[Column, int]], cells: Callable[[int], Iterable[Cell]], instead_of: frozenset[int]
    ) -> Table:
        """Return the table with further columns behind its last one.

        Parameters
        ----------
        columns
            each with the column of the file that it is made from; they get their own index.
        cells
            gives what stands in them in a row.
        instead_of
            the columns that are not read any more.
        """
        first = max(self.sheet.width, len(self.texts))
        added = [replace(column, index=first + at) for at, (column, _) in enumerate(columns)]
        sources = {column.index: source for column, (_, source) in zip(added, columns, strict=True)}
        rows = [[*row, *[""] * (first - len(row)), *cells(number)] for number, row in enumerate(self.sheet.rows)]
        texts = (*self.texts, *[""] * (first - len(self.texts)), *(column.heading for column in added))
        return replace(
            self,
            sheet=replace(self.sheet, rows=rows, derived={**self.sheet.derived, **sources}),
            columns=(*(column for column in self.columns if column.index not in instead_of), *added),
            texts=texts,
        )
