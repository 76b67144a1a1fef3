"""What was typed in, cell by cell, sign for sign; every change gives a new object, and the last ones can be undone."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from atleak.intake.readings.words import is_blank
from atleak.measuring.plan import Cell, CellKey, Plan
from atleak.readings import Reading, Readings
from atleak.workshop_units import MM
from atleak.written_numbers import decimal_number

MOST_STEPS = 200  # that can be undone
_LONGEST = 40  # signs of one entry: a number and its unit are far shorter
_LARGEST_BLOCK = 5_000  # entries that one paste may hold
BASE_UNIT = "mm"


@dataclass(frozen=True)
class Entry:
    """The text of one cell, and the two coordinates [m] it is the distance of, where a sheet gave them."""

    text: str
    coordinates: tuple[float, float] | None = None


@dataclass(frozen=True)
class Done:
    """What a series of steps led to: the entries, the cell to go on in, and how many values found no cell."""

    typed: Typed
    at: Cell | None = None
    left_over: int = 0


@dataclass(frozen=True)
class Typed:
    """The entries of all cells, by which plan they were asked for, and what else the sheet they go on from holds."""

    entries: Mapping[Cell, Entry] = field(default_factory=dict)
    plan: Plan = Plan()  # noqa: RUF009  frozen, so safe to share
    unit: str = BASE_UNIT  # of the entries that name none
    sheet: Readings | None = None  # gone on from: its head, lengths and unworn ends; its readings are in the cells
    earlier: tuple[Mapping[Cell, Entry], ...] = field(default=(), compare=False)

    @classmethod
    def going_on_from(cls, readings: Readings, plan: Plan = Plan(), decimal: str = ".") -> Typed:  # noqa: B008  frozen
        """Return the cells filled with the readings of a sheet, written with a decimal sign."""
        entries = {
            cell_of(each): Entry(in_mm(each.diameter).replace(".", decimal), each.coordinates)
            for each in readings.readings
        }
        return cls(entries, plan, sheet=replace(readings, readings=()))

    def put(self, cell: Cell, text: str) -> Typed:
        """Return this with another text in a cell; an empty one takes its entry out."""
        return self.fill({cell: text})

    def fill(self, texts: Mapping[Cell, str]) -> Typed:
        """Return this with other texts in several cells, as one step."""
        new = dict(self.entries)
        for cell, text in texts.items():
            said = " ".join(text.split())[:_LONGEST]
            if not said:
                new.pop(cell, None)
            elif cell not in new or new[cell].text != said:
                new[cell] = Entry(said)
        if new == self.entries:
            return self
        return replace(self, entries=new, earlier=(*self.earlier, self.entries)[-MOST_STEPS:])

    def in_unit(self, unit: str) -> Typed:
        """Return this with another unit for what is typed from now on; entries that named none keep the old one."""
        if unit == self.unit:
            return self
        entries = {
            cell: replace(entry, text=f"{entry.text} {self.unit}") if decimal_number(entry.text) is not None else entry
            for cell, entry in self.entries.items()
        }
        return replace(self, entries=entries, unit=unit, earlier=())

    def paste(self, cells: Sequence[Cell], start: Cell, block: str) -> Done:
        """Return this with a block of a spreadsheet in the cells along, row by row; its empty cells change nothing."""
        values = block_values(block)
        places = cells[cells.index(start) :] if start in cells else ()
        filled = {cell: text for cell, text in zip(places, values, strict=False) if not is_blank(text)}
        after = places[min(len(values), len(places) - 1)] if places else None
        return Done(self.fill(filled), after, max(len(values) - len(places), 0))

    def undo(self) -> Done:
        """Return this one step earlier, and the first cell in which it differs; the same where there is none."""
        if not self.earlier:
            return Done(self)
        back = replace(self, entries=self.earlier[-1], earlier=self.earlier[:-1])
        changed = [
            cell for cell in {**back.entries, **self.entries} if back.entries.get(cell) != self.entries.get(cell)
        ]
        return Done(back, next(iter(changed), None))

    def after(self, steps: Iterable[Mapping[str, Any]], cells: Sequence[Cell]) -> Done:
        """Return what steps lead to that come from a page: put a text, paste a block, undo.

        A step that is none of these, or of a cell that is not there, changes nothing.

        Parameters
        ----------
        steps
            each with a ``do`` (put, paste, undo), and but for the last the key of a cell and a text.
        cells
            the cells that the page shows, in its order.
        """
        named = {cell.key: cell for cell in cells}
        done = Done(self)
        for step in steps:
            next_one = _after_one(done.typed, step, named, cells)
            done = replace(next_one, left_over=done.left_over + next_one.left_over)
        return done


def _after_one(typed: Typed, step: Mapping[str, Any], named: Mapping[CellKey, Cell], cells: Sequence[Cell]) -> Done:
    if step.get("do") == "undo":
        return typed.undo()
    key = step.get("cell")
    cell = named.get(tuple(key)) if isinstance(key, list) and all(map(_is_plain, key)) else None
    if cell is None:
        return Done(typed)
    text = str(step.get("text", ""))
    return typed.paste(cells, cell, text) if step.get("do") == "paste" else Done(typed.put(cell, text))


def _is_plain(value: object) -> bool:
    return value is None or isinstance(value, str | int | float)


def cell_of(reading: Reading) -> Cell:
    """Return the cell that a reading belongs in."""
    return Cell(*reading.station, reading.repeat)


def block_values(block: str) -> list[str]:
    r"""Return the cells of a block that was copied from a spreadsheet, row by row.

    >>> block_values("15,001\t15,002\r\n15,003\t\r\n")
    ['15,001', '15,002', '15,003', '']
    """
    lines = block.replace("\r\n", "\n").replace("\r", "\n").rstrip("\n").split("\n")
    return [value.strip() for line in lines for value in line.split("\t")][:_LARGEST_BLOCK]


def in_mm(metres: float) -> str:
    """Write a length [m] in mm, with the digits that it was given with."""
    return f"{round(metres * MM, 7):.10g}"
