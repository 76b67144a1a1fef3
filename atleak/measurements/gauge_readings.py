"""Hold a stationary pressure table: what gauges showed, range by range, while the vehicle stood."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import cast, get_args

from atleak.catalogue.circuits import Circuit, PermissiblePressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_tables import SelectorRange, StandingState
from atleak.common.errors import Message, Place
from atleak.common.printable import brief
from atleak.common.sentences import Name, Sentence

LINE_TAP = "line"  # the tap of main pressure
TOGETHER = 30.0  # [s] by which line and tap may be read apart, and still be judged together: choice of this project
RANGES: tuple[SelectorRange, ...] = get_args(SelectorRange)


class Engine(StrEnum):
    """What the engine does while the gauge is read, the vehicle standing."""

    SLOW_IDLE = "slow_idle"
    FAST_IDLE = "fast_idle"
    STALL = "stall"

    @property
    def label(self) -> Sentence:
        """Return its name for people."""
        return _LABELS[self]

    @property
    def state(self) -> StandingState:
        """Return the state under which a controller's file permits pressures of it."""
        return _STATES[self]


_LABELS: dict[Engine, Sentence] = {
    Engine.SLOW_IDLE: Sentence("slow idle"),
    Engine.FAST_IDLE: Sentence("fast idle"),
    Engine.STALL: Sentence("stall"),
}
_STATES: dict[Engine, StandingState] = {
    Engine.SLOW_IDLE: "idle",
    Engine.FAST_IDLE: "fast_idle",
    Engine.STALL: "stall",
}
_AT_FAST_IDLE = "its low limit at idle, for a pump that turns faster at the same throttle (choice of this project)"


@dataclass(frozen=True)
class GaugeCell:
    """One place of the table: a range of the selector lever, what the engine does, and where the gauge sits."""

    range: SelectorRange  # of the selector lever
    engine: Engine  # what the engine does
    tap: str = LINE_TAP  # or the id of a circuit


@dataclass(frozen=True)
class GaugeReading:
    """One pressure as a gauge showed it."""

    cell: GaugeCell  # where it was read
    pressure: float  # [Pa]
    repeat: int = 1  # counts the readings of one cell in the order in which they were taken
    round: float | None = None  # the repeat or time as the table states it: one for all taps that were read together
    time: float | None = None  # [s] where the table states it, after any beginning
    gauge: str = ""  # the name of the gauge, where the table states it: its readings share its error
    temperature: float | None = None  # [°C] of the fluid, where it is stated
    engine_speed: float | None = None  # [1/s] where it is stated
    place: Place = Place()  # noqa: RUF009  frozen, so safe to share


@dataclass(frozen=True)
class FileOfReadings:
    """The file that holds some readings.

    Attributes
    ----------
    file
        its name.
    sha256
        of its bytes.
    sheet
        the workbook's sheet; None for text files.
    """

    file: str
    sha256: str
    sheet: str | None


@brief
@dataclass(frozen=True)
class PressureTable(FileOfReadings):
    """All gauge readings of one table; a cell that is not among them was not measured.

    Attributes
    ----------
    units
        in which the pressures were written.
    readings
        in the table's order.
    messages
        what was assumed.
    """

    units: tuple[str, ...]
    readings: tuple[GaugeReading, ...]
    messages: tuple[Message, ...] = ()

    @property
    def taps(self) -> tuple[str, ...]:
        """Return the taps at which a gauge was read, the line's first."""
        taps = dict.fromkeys(reading.cell.tap for reading in self.readings)
        return tuple(sorted(taps, key=lambda tap: tap != LINE_TAP))

    def line_beside(self, reading: GaugeReading) -> GaugeReading | None:
        """Find the line's reading that belongs to one of a tap, in the same range and state.

        Parameters
        ----------
        reading
            that of the tap.

        Returns
        -------
        GaugeReading or None
            the nearest in time, and none where that is more than `TOGETHER` away; or the one of the same or nearest
            repeat; or the last, where neither is stated.
        """
        lines = self.at(replace(reading.cell, tap=LINE_TAP))
        timed = [line for line in lines if line.time is not None]
        if reading.time is not None and timed:
            nearest = min(timed, key=lambda line: abs((line.time or 0.0) - (reading.time or 0.0)))
            return nearest if abs((nearest.time or 0.0) - reading.time) <= TOGETHER else None
        counted = [line for line in lines if line.round is not None]
        if reading.round is not None and counted:
            return min(counted, key=lambda line: abs((line.round or 0.0) - (reading.round or 0.0)))
        return lines[-1] if lines else None

    def at(self, cell: GaugeCell) -> tuple[GaugeReading, ...]:
        """Return the readings of one cell in the order in which they were taken; none where it was not measured.

        Parameters
        ----------
        cell
            range, state of the engine and tap.
        """
        readings = (reading for reading in self.readings if reading.cell == cell)
        return tuple(sorted(readings, key=lambda reading: reading.repeat))


NO_GAUGES = PressureTable("", "", None, (), ())


def ranges_of(controller: Controller) -> tuple[SelectorRange, ...]:
    """Return the ranges that the lever of a unit has, as far as its file tells.

    Park, reverse, neutral, drive, every forward gear below the highest, and what its permissible pressures name.
    """
    named = {selected for permissible in controller.permissible for selected in permissible.ranges}
    forward = sorted((gear for gear in controller.gears if 0 < gear < 10), reverse=True)
    held = [cast("SelectorRange", str(gear)) for gear in forward[1:]]
    usual: tuple[SelectorRange, ...] = ("P", "R", "N", "D", *held)
    return (*usual, *(selected for selected in RANGES if selected in named and selected not in usual))


def gear_in(selected: SelectorRange, gears: Iterable[int]) -> int | None:
    """Return the gear that is engaged in a range while the vehicle stands; None where the gears do not tell.

    A forward range stands in the lowest forward gear (a choice of this project: some units start in second where 2 is
    selected). A file counts neutral and park as 0, both without a clutch that drives, and reverse as a negative number.

    >>> [gear_in(selected, (-1, 1, 2, 3)) for selected in ("P", "R", "N", "D", "2")]
    [None, -1, None, 1, 1]
    >>> gear_in("P", (-1, 0, 1)), gear_in("N", (-1, 0, 1))
    (0, 0)
    """
    known = sorted(gears)
    if selected in {"P", "N"}:
        return 0 if 0 in known else None
    if selected == "R":
        return max((gear for gear in known if gear < 0), default=None)
    return min((gear for gear in known if gear > 0), default=None)


def circuit_at(controller: Controller, tap: str) -> Circuit | None:
    """Return the circuit that a tap belongs to; None for the line's."""
    return next((circuit for circuit in controller.circuits if circuit.id == tap), None)


def tap_name(controller: Controller, tap: str) -> str:
    """Return the name of a tap for people."""
    circuit = circuit_at(controller, tap)
    if circuit is not None:
        return Name(circuit.name)
    return Sentence("line") if tap == LINE_TAP else tap


def taps_of(controller: Controller) -> tuple[str, ...]:
    """Return every tap at which a gauge may sit: the line's, then those of the circuits."""
    return (LINE_TAP, *(circuit.id for circuit in controller.circuits))


def applied(controller: Controller, cell: GaugeCell) -> bool:
    """Return whether the circuit of a cell is applied in its range; the line always is."""
    circuit = circuit_at(controller, cell.tap)
    return circuit is None or gear_in(cell.range, controller.gears) in circuit.gears


def permitted(controller: Controller, cell: GaugeCell) -> PermissiblePressure | None:
    """Return between which pressures main pressure must lie in a cell; None where the file does not tell.

    A file that permits nothing at a fast idle of its own means that the low limit at idle holds there too.
    """
    if cell.tap != LINE_TAP:
        return None
    gear = gear_in(cell.range, controller.gears)
    found = controller.permissible_in(cell.range, gear, cell.engine.state)
    if found is not None or cell.engine is not Engine.FAST_IDLE:
        return found
    idle = controller.permissible_in(cell.range, gear, Engine.SLOW_IDLE.state)
    if idle is None or idle.low is None:
        return None
    return replace(idle, state="fast_idle", high=None, source=f"{idle.source}; {_AT_FAST_IDLE}", published=False)
