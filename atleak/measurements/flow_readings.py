"""Hold flows that were caught in a jug: of the cooler's return line, or of another consumer whose line was opened."""

from __future__ import annotations

from dataclasses import dataclass

from atleak.catalogue.circuits import Consumer
from atleak.catalogue.controller import Controller
from atleak.common.errors import Message, Place
from atleak.common.printable import brief
from atleak.measurements.gauge_readings import FileOfReadings

COOLER = "cooler"  # what flows through the cooler, whatever the valve body's file calls that consumer


@dataclass(frozen=True)
class FlowReading:
    """One flow as it was caught and timed."""

    condition: str  # name of the operating point of the valve body's file that the vehicle was like
    what: str  # id of a consumer of that file, or `COOLER`
    flow: float  # [m³/s]
    place: Place = Place()  # noqa: RUF009  frozen, so safe to share


@brief
@dataclass(frozen=True)
class FlowTable(FileOfReadings):
    """All flows of one table."""

    readings: tuple[FlowReading, ...]  # in the table's order
    messages: tuple[Message, ...] = ()  # what was assumed


def consumer_of(controller: Controller, what: str) -> Consumer | None:
    """Return the consumer whose flow was caught; None where the file describes none, or several could be meant.

    Parameters
    ----------
    what
        of a `FlowReading`: for `COOLER` the only consumer whose id or name speaks of a cooler.
    """
    named = [each for each in controller.consumers if each.id == what]
    if not named and what == COOLER:
        named = [each for each in controller.consumers if COOLER in f"{each.id} {each.name}".casefold()]
    return named[0] if len(named) == 1 else None
