"""What was typed in, cell by cell, sign for sign: judged by the rules of the measuring sheet, and kept as one.

`atleak.readers.sheets.measuring_sheet.read_readings` reads it as any other sheet. A column says of every row whether it
counts, so that nothing that cannot be a reading enters a verdict, and nothing typed is lost.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from typing import Any, NamedTuple

from pydantic import TypeAdapter

from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.instruments import Instruments
from atleak.catalogue.repairs import LandKey
from atleak.catalogue.written_numbers import decimal_number
from atleak.common.damage import own_errors_only
from atleak.common.errors import InputError, Place, ReadingsError
from atleak.common.sentences import Sentence
from atleak.common.units import MM, unit, unit_names
from atleak.measurements.clearances import LandClearance, clearances, far_from_nominal
from atleak.measurements.measuring_plan import PLAN_PARTS, Plan, PlanCell
from atleak.measurements.own_forms import LANDS, TYPED, OwnForm
from atleak.measurements.readings import Reading, Readings
from atleak.readers.cells.sheet_file import csv_bytes, csv_rows
from atleak.readers.sheets.plausibility import contradictions, off_by_factor
from atleak.readers.sheets.words import diameter, is_blank

MOST_STEPS = 200  # that can be undone
_LONGEST = 40  # signs of one entry: a number and its unit are far shorter
_LARGEST_BLOCK = 5_000  # entries that one paste may hold
BASE_UNIT = "mm"


@dataclass(frozen=True)
class TypedEntry:
    """The text of one cell, and the two coordinates [m] it is the distance of, where a sheet gave them."""

    text: str
    coordinates: tuple[float, float] | None = None


@dataclass(frozen=True)
class Done:
    """What a series of steps led to: the entries, the cell to go on in, and how many values found no cell."""

    typed: Typed
    at: PlanCell | None = None
    left_over: int = 0


@dataclass(frozen=True)
class Typed:
    """The entries of all cells, by which plan they were asked for, and what else the sheet they go on from holds."""

    entries: Mapping[PlanCell, TypedEntry] = field(default_factory=dict)
    plan: Plan = Plan()  # noqa: RUF009  frozen, so safe to share
    unit: str = BASE_UNIT  # of the entries that name none
    sheet: Readings | None = None  # gone on from: its head, lengths and unworn ends; its readings are in the cells
    earlier: tuple[Mapping[PlanCell, TypedEntry], ...] = field(default=(), compare=False)

    @classmethod
    def going_on_from(cls, readings: Readings, plan: Plan = Plan(), decimal: str = ".") -> Typed:  # noqa: B008  frozen
        """Return the cells filled with the readings of a sheet, written with a decimal sign."""
        entries = {
            cell_of(each): TypedEntry(_in_mm(each.diameter).replace(".", decimal), each.coordinates)
            for each in readings.readings
        }
        return cls(entries, plan, sheet=replace(readings, readings=()))

    def put(self, cell: PlanCell, text: str) -> Typed:
        """Return this with another text in a cell; an empty one takes its entry out."""
        return self.fill({cell: text})

    def fill(self, texts: Mapping[PlanCell, str]) -> Typed:
        """Return this with other texts in several cells, as one step."""
        new = dict(self.entries)
        for cell, text in texts.items():
            entry = " ".join(text.split())[:_LONGEST]
            if not entry:
                new.pop(cell, None)
            elif cell not in new or new[cell].text != entry:
                new[cell] = TypedEntry(entry)
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

    def paste(self, cells: Sequence[PlanCell], start: PlanCell, block: str) -> Done:
        """Return this with a block of a spreadsheet in the cells along, row by row; its empty cells change nothing.

        A block of one column goes down the cells of one repeat.
        """
        values, one_wide = block_values(block), "\t" not in block
        along = cells[cells.index(start) :] if start in cells else ()
        places = [cell for cell in along if not one_wide or cell.repeat == start.repeat]
        filled = {cell: text for cell, text in zip(places, values, strict=False) if not is_blank(text)}
        after = places[min(len(values), len(places) - 1)] if places else None
        return Done(self.fill(filled), after, max(len(values) - len(places), 0))

    def undo(self) -> Done:
        """Return this one step earlier, and the first cell in which it differs; the same where there is none."""
        if not self.earlier:
            return Done(self)
        back = replace(self, entries=self.earlier[-1], earlier=self.earlier[:-1])
        every = {**back.entries, **self.entries}
        return Done(back, next((cell for cell in every if back.entries.get(cell) != self.entries.get(cell)), None))

    def after(self, steps: Iterable[Mapping[str, Any]], cells: Sequence[PlanCell]) -> Done:
        """Return what steps lead to that come from a page: put a text, paste a block, undo.

        Each has a ``do`` (put, paste, undo), and but for the last the key of a ``cell`` that the page shows and a
        ``text``. A step that is none of these, or of a cell that is not there, changes nothing.
        """
        named: Mapping[Any, PlanCell] = {cell.key: cell for cell in cells}
        done = Done(self)
        for step in steps:
            cell, text, typed = None, str(step.get("text", "")), done.typed
            with suppress(KeyError, TypeError):  # a page may send anything as a key
                cell = named.get(tuple(step["cell"]))
            if step.get("do") == "undo":
                one = typed.undo()
            elif cell is None:
                one = Done(typed)
            else:
                one = typed.paste(cells, cell, text) if step.get("do") == "paste" else Done(typed.put(cell, text))
            done = replace(one, left_over=done.left_over + one.left_over)
        return done


def cell_of(reading: Reading) -> PlanCell:
    """Return the cell that a reading belongs in."""
    return PlanCell(*reading.station, reading.repeat)


def block_values(block: str) -> list[str]:
    r"""Return the cells of a block that was copied from a spreadsheet, row by row.

    >>> block_values("15,001\t15,002\r\n15,003\t\r\n")
    ['15,001', '15,002', '15,003', '']
    """
    lines = block.replace("\r\n", "\n").replace("\r", "\n").rstrip("\n").split("\n")
    return [value.strip() for line in lines for value in line.split("\t")][:_LARGEST_BLOCK]


def _in_mm(metres: float) -> str:
    """Write a length [m] in mm, with the digits that it was given with."""
    return f"{round(metres * MM, 7):.10g}"


_AT_A_CELL = ("repeats_disagree", "large_ovality", "tight_direction")  # codes of what a land's messages say of a cell


class _Doubt(NamedTuple):
    """What is doubtful about an entry, in a sentence, and whether it counts as a reading nevertheless."""

    text: Sentence
    counts: bool


@dataclass(frozen=True)
class JudgedEntry:
    """What the entries are worth.

    ``counting`` are the readings that a verdict may rest on; ``refused`` the lands of which the readings cannot be
    together, so that none of them counts.
    """

    doubts: Mapping[PlanCell, _Doubt]
    counting: Mapping[PlanCell, Reading]
    refused: frozenset[LandKey]
    states: tuple[LandClearance, ...]


def judge(
    typed: Typed, controller: Controller, *, temperature: float | None = None, instruments: Instruments | None = None
) -> JudgedEntry:
    """Judge all entries together; ``temperature`` is that of gauge and parts [°C], where the job states it."""
    judging = _Judging(typed, controller)
    judging.leave_out_slips()
    judging.leave_out_contradictions()
    states = judging.states(temperature, instruments)
    judging.doubt(states)
    return JudgedEntry(judging.doubts, judging.readings, frozenset(judging.refused), states)


class _Judging:
    """Collects doubts; ``readings`` are those that still count. Each bears the number of its cell as its place."""

    def __init__(self, typed: Typed, controller: Controller) -> None:
        self.controller = controller
        self.doubts: dict[PlanCell, _Doubt] = {}
        self.readings: dict[PlanCell, Reading] = {}
        self.lands: dict[PlanCell, Land] = {}  # of those with a reading
        self.refused: set[LandKey] = set()
        self.unit = typed.unit
        self.sheet = typed.sheet or Readings("", "", None, typed.unit, False, "tidy", ())
        for number, (cell, entry) in enumerate(typed.entries.items()):
            land = controller.land_of_plane(cell.component, cell.plane)
            if is_blank(entry.text) or land is None:
                continue
            try:
                value, written = diameter(entry.text)
            except ReadingsError as error:
                self.doubts[cell] = _Doubt(_said(error), False)
                continue
            metres = (written or unit(self.unit, "length")).to_si(value)
            self.readings[cell] = Reading(*cell.key, metres, Place(key=str(number)), entry.coordinates)
            self.lands[cell] = land
        self.by_place = {reading.place: cell for cell, reading in self.readings.items()}

    def together(self) -> Readings:
        """Return what still counts as the readings of a sheet."""
        return replace(self.sheet, unit=self.unit, readings=tuple(self.readings.values()))

    def leave_out_slips(self) -> None:
        """Leave out what is far off its nominal diameter."""
        for reading, error in off_by_factor(self.together(), self.controller):
            cell = self.by_place[reading.place]
            self.doubts[cell] = _Doubt(_said(error), False)
            del self.readings[cell]

    def leave_out_contradictions(self) -> None:
        """Leave out lands of which the readings, or those at unworn ends beside them, cannot be together."""
        now = self.together()
        wrong = contradictions(now, self.controller)
        if now.unworn:
            keys = {land.key for land, _ in wrong}
            wrong += [each for each in contradictions(now.when_new, self.controller) if each[0].key not in keys]
        for land, error in wrong:
            self._refuse(land.key, error)

    def _refuse(self, key: LandKey, error: InputError) -> None:
        mine = [cell for cell in self.readings if self.lands[cell].key == key]
        at = self.by_place.get(error.place, mine[0] if mine else None)
        if at is not None:
            self.doubts[at] = _Doubt(_said(error), False)
        self.refused.add(key)
        for cell in mine:
            del self.readings[cell]

    def states(self, temperature: float | None, instruments: Instruments | None) -> tuple[LandClearance, ...]:
        """Return the clearances of what counts; a land that only the temperature makes impossible is left out."""
        at = self.together().measured_at(temperature).value
        while True:
            try:
                return clearances(self.together(), self.controller, temperature_c=at, instruments=instruments)
            except ReadingsError as error:
                self._refuse(self.lands[self.by_place[error.place]].key, error)

    def doubt(self, states: Collection[LandClearance]) -> None:
        """Doubt what counts and is unusual nevertheless: alone, or beside the other readings of its land."""
        far = (
            (cell, far_from_nominal(self.lands[cell], cell.part, each.diameter)) for cell, each in self.readings.items()
        )
        unusual = [(cell, text) for cell, text in far if text]
        told = (message for state in states for message in state.messages if message.code in _AT_A_CELL)
        unusual += [(self.by_place[each.place], each.text) for each in told if each.place in self.by_place]
        for cell, text in unusual:
            before = self.doubts.setdefault(cell, _Doubt(text, True))
            if before.counts and before.text is not text:
                self.doubts[cell] = _Doubt(Sentence("{first}; {second}", first=before.text, second=text), True)


def _said(error: InputError) -> Sentence:
    """Return what is wrong without a place: it stands at its cell."""
    sentence = error.problem
    if error.value is not None:
        sentence = Sentence("{problem} ({value})", problem=sentence, value=error.value)
    if error.expected:
        sentence = Sentence("{problem}; expected {expected}", problem=sentence, expected=error.expected)
    return sentence


TYPED_FILE = "typed readings.csv"
_SEPARATED = b"sep=;\r\n"  # so that a spreadsheet program, and atleak's own reader, need not guess
_UNWORN = "unworn end"
_MM = unit("mm", "length")
_OF_LANDS = ("component", "land", "contact length", "position", "fitted repair")
_IN_MM = ("coordinate 1", "coordinate 2", "contact length", "position")


def written_sheet(typed: Typed, counting: Collection[PlanCell], controller: Controller) -> bytes | None:
    """Return the file; None where nothing was typed. The readings of the cells ``counting`` count."""
    if not typed.entries:
        return None
    rows = [[TYPED.mark, json.dumps(asdict(typed.plan))], [f"Controller {controller.id}"]]
    rows += [*_head(typed.sheet), _headings(typed.unit)]
    for cell in typed.plan.in_order(controller, typed.entries):
        rows.append([*_labels(cell), *_values(typed.entries[cell]), "yes" if cell in counting else "no", ""])
    for reading in typed.sheet.unworn if typed.sheet else ():
        size = f"{_in_mm(reading.diameter)} mm"
        rows.append([*_labels(cell_of(reading)), *_values(TypedEntry(size, reading.coordinates)), "yes", _UNWORN])
    return _SEPARATED + csv_bytes([*rows, *_of_lands(typed.sheet)])


def _headings(unit: str) -> list[str]:
    return [_heading(TYPED, key, unit) for key in TYPED.headings]


def _heading(form: OwnForm, key: str, unit: str = BASE_UNIT) -> str:
    text = " ".join(form.headings[key].split())
    return f"{text} [{BASE_UNIT if key in _IN_MM else unit}]" if key in (*_IN_MM, "diameter") else text


def _labels(cell: PlanCell) -> list[str]:
    direction = "" if cell.direction is None else f"{cell.direction:.12g}"
    return [cell.component, cell.part, cell.plane, direction, str(cell.repeat)]


def _values(entry: TypedEntry) -> list[str]:
    return ["", "", entry.text] if entry.coordinates is None else [*map(_in_mm, entry.coordinates), ""]


def _head(sheet: Readings | None) -> Iterator[list[str]]:
    """Yield what the sheet that is gone on from states of the measurement as a whole."""
    if sheet is None:
        return
    if sheet.temperature is not None:
        yield ["Measuring temperature", f"{sheet.temperature:.12g} °C"]
    if sheet.date is not None:
        yield ["Date", sheet.date.isoformat()]
    for name, um in zip(("side", "tip"), sheet.pump.um, strict=True):
        if um is not None:
            yield [f"Pump {name} clearance [µm]", f"{um:.12g}"]


def _of_lands(sheet: Readings | None) -> Iterator[list[str]]:
    """Yield, as a table of its own, what that sheet states of lands themselves."""
    if sheet is None or not (sheet.own_lands.lengths or sheet.own_lands.fitted):
        return
    yield []
    yield [_heading(LANDS, key) for key in _OF_LANDS]
    for length in sheet.own_lands.lengths:
        sizes = (length.contact_length, length.position)
        yield [length.component, str(length.land), *("" if size is None else _in_mm(size) for size in sizes), ""]
    for fitted in sheet.own_lands.fitted:
        yield [fitted.component, "", "", "", fitted.repair]


@own_errors_only(InputError)
def typed_in(content: bytes, sheet: Readings, controller: Controller) -> Typed | None:
    """Return the entries of a file that `written_sheet` gave; None for any other file, and for another valve body's.

    ``sheet`` is what `read_readings` reads of that same file.
    """
    rows = csv_rows(content.removeprefix(_SEPARATED))
    if not rows or rows[0][:1] != [TYPED.mark]:
        return None
    units = {tuple(_headings(name)): name for name in unit_names("length")}
    head = next((number for number, row in enumerate(rows) if tuple(row) in units), None)
    if head is None:
        return None
    try:
        plan = TypeAdapter(Plan).validate_json(rows[0][1] if len(rows[0]) > 1 else "")
        entries = dict(_entries(rows[head + 1 :]))
    except ValueError:  # somebody has edited it
        return None
    if any(controller.land_of_plane(cell.component, cell.plane) is None for cell in entries):
        return None
    return Typed(entries, plan, units[tuple(rows[head])], sheet=replace(sheet, readings=()))


def _entries(rows: Iterable[list[str]]) -> Iterator[tuple[PlanCell, TypedEntry]]:
    """Yield the entries of the table that begins here; `ValueError` where it is not as `written_sheet` gave it."""
    for row in itertools.takewhile(bool, rows):
        component, part, plane, direction, repeat, first, second, text, _, taken_at = row
        if taken_at:
            continue
        angle = float(direction) if direction else None
        cell = PlanCell(component, PLAN_PARTS[PLAN_PARTS.index(part)], plane, angle, int(repeat))
        if text:
            yield cell, TypedEntry(text)
        else:
            ends = _MM.to_si(float(first)), _MM.to_si(float(second))
            yield cell, TypedEntry(_in_mm(abs(ends[0] - ends[1])), ends)
