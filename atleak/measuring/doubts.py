"""Judge typed entries by the rules of the measuring sheet, each at its own cell, and say which of them count."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace

from atleak.catalogue.complaints import LandKey
from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.instruments import Instruments
from atleak.errors import InputError, Place, ReadingsError
from atleak.intake.readings.checks import contradictions, off_by_factor
from atleak.intake.readings.words import diameter, is_blank
from atleak.intake.units import unit
from atleak.measuring.plan import Cell
from atleak.measuring.typed import Typed
from atleak.readings import LandClearance, Reading, Readings, clearances, far_from_nominal
from atleak.sentence import Sentence

_AT_A_CELL = ("repeats_disagree", "large_ovality", "tight_direction")  # codes of what a land's messages say of a cell


@dataclass(frozen=True)
class Doubt:
    """What is doubtful about an entry, in a sentence, and whether it counts as a reading nevertheless."""

    text: Sentence
    counts: bool


@dataclass(frozen=True)
class Judged:
    """What the entries are worth.

    ``counting`` are the readings that a verdict may rest on; ``refused`` the lands of which the readings cannot be
    together, so that none of them counts.
    """

    doubts: Mapping[Cell, Doubt]
    counting: Mapping[Cell, Reading]
    refused: frozenset[LandKey]
    states: tuple[LandClearance, ...]


def judge(
    typed: Typed,
    controller: Controller,
    *,
    temperature: float | None = None,
    instruments: Instruments | None = None,
) -> Judged:
    """Judge all entries together.

    Parameters
    ----------
    typed
        the entries.
    controller
        whose lands were measured, with what is fitted to them.
    temperature
        of gauge and parts [°C], where the job states it.
    instruments
        those that measured; the catalogue's defaults unless given.
    """
    judging = _Judging(typed, controller)
    judging.leave_out_slips()
    judging.leave_out_contradictions()
    states = judging.states(temperature, instruments)
    judging.doubt(states)
    return Judged(judging.doubts, judging.readings, frozenset(judging.refused), states)


class _Judging:
    """Collects doubts; ``readings`` are those that still count. Each bears the number of its cell as its place."""

    def __init__(self, typed: Typed, controller: Controller) -> None:
        self.controller = controller
        self.doubts: dict[Cell, Doubt] = {}
        self.readings: dict[Cell, Reading] = {}
        self.lands: dict[Cell, Land] = {}  # of those with a reading
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
                self.doubts[cell] = Doubt(_said(error), False)
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
            self.doubts[cell] = Doubt(_said(error), False)
            del self.readings[cell]

    def leave_out_contradictions(self) -> None:
        """Leave out lands of which the readings, or those at unworn ends beside them, cannot be together."""
        now = self.together()
        wrong = contradictions(now, self.controller)
        if now.unworn:
            known = {land.key for land, _ in wrong}
            wrong += [each for each in contradictions(now.when_new, self.controller) if each[0].key not in known]
        for land, error in wrong:
            self._refuse(land.key, error)

    def _refuse(self, key: LandKey, error: InputError) -> None:
        mine = [cell for cell in self.readings if self.lands[cell].key == key]
        at = self.by_place.get(error.place, mine[0] if mine else None)
        if at is not None:
            self.doubts[at] = Doubt(_said(error), False)
        self.refused.add(key)
        for cell in mine:
            del self.readings[cell]

    def states(self, temperature: float | None, instruments: Instruments | None) -> tuple[LandClearance, ...]:
        """Return the clearances of what counts; a land that only the temperature makes impossible is left out."""
        at = self.together().measured_at(temperature).value
        while True:
            try:
                return clearances(self.together(), self.controller, temperature=at, instruments=instruments)
            except ReadingsError as error:
                self._refuse(self.lands[self.by_place[error.place]].key, error)

    def doubt(self, states: Collection[LandClearance]) -> None:
        """Doubt what counts and is unusual nevertheless: alone, or beside the other readings of its land."""
        said: dict[Cell, Sentence] = {}
        for cell, text in self._unusual(states):
            said[cell] = Sentence("{first}; {second}", first=said[cell], second=text) if cell in said else text
        for cell, text in said.items():
            self.doubts.setdefault(cell, Doubt(text, True))

    def _unusual(self, states: Collection[LandClearance]) -> Iterator[tuple[Cell, Sentence]]:
        for cell, reading in self.readings.items():
            far = far_from_nominal(self.lands[cell], cell.part, reading.diameter)
            if far:
                yield cell, far
        for state in states:
            for message in state.messages:
                if message.code in _AT_A_CELL and message.place in self.by_place:
                    yield self.by_place[message.place], message.text


def _said(error: InputError) -> Sentence:
    """Return what is wrong without a place: it stands at its cell."""
    said = error.problem
    if error.value is not None:
        said = Sentence("{problem} ({value})", problem=said, value=error.value)
    if error.expected:
        said = Sentence("{problem}; expected {expected}", problem=said, expected=error.expected)
    return said
