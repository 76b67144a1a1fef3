"""Hold what one visit tells of a unit's wear, and say which visits can stand in one series."""

from __future__ import annotations

import datetime as dt
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

from atleak.diagnosis import Diagnosis
from atleak.errors import Message
from atleak.rules import LandKey
from atleak.sentence import Sentence
from atleak.uncertainty import LandSources
from atleak.unit_systems import Quantity


@dataclass(frozen=True)
class Visit:
    """One stay of a unit in the workshop: its mileage, and its lands as they were measured."""

    date: dt.date
    mileage: float | None  # [km]
    controller: str  # id of the valve body
    lands: tuple[LandSources, ...]  # none where nothing was measured
    repaired: frozenset[LandKey] = frozenset()  # by the record, after they were measured
    name: str = ""  # number of the job, as the workshop knows it

    @classmethod
    def of(
        cls,
        diagnosis: Diagnosis,
        date: dt.date,
        *,
        mileage: float | None = None,
        repaired: Iterable[LandKey] = (),
        name: str = "",
    ) -> Visit:
        """Return the visit at which a unit was so diagnosed.

        Parameters
        ----------
        mileage
            of the vehicle [km]; as the diagnosis has it unless given.
        repaired
            the lands that were repaired at this visit, after they were measured.
        name
            of the job, for people.
        """
        lands = diagnosis.uncertainty.lands if diagnosis.uncertainty is not None else ()
        return cls(
            date,
            diagnosis.mileage if mileage is None else mileage,
            diagnosis.controller.id,
            tuple(land.sources for land in lands),
            frozenset(repaired),
            name,
        )

    @property
    def label(self) -> Sentence:
        """Name the visit: ``2026-05-04 (job 1042)``."""
        date = self.date.isoformat()
        return Sentence("{date} (job {job})", date=date, job=self.name) if self.name else Sentence("{date}", date=date)

    def measured(self, key: LandKey) -> LandSources | None:
        """Return a land of which both parts were measured and whose clearance counts; None where they were not."""
        land = self._lands.get(key)
        return land if land is not None and land.state.can_be_ok else None

    @cached_property
    def _lands(self) -> dict[LandKey, LandSources]:
        return {land.key: land for land in self.lands}


@dataclass(frozen=True)
class Visits:
    """The visits of one unit in the order of their dates, and what is to be known about them."""

    visits: tuple[Visit, ...]  # of one valve body
    turned_back: frozenset[int]  # of the visits: those at which the mileage is less than at the one before
    messages: tuple[Message, ...]

    @property
    def present(self) -> float | None:
        """Return the latest mileage [km]; None where no visit states one."""
        return next((visit.mileage for visit in reversed(self.visits) if visit.mileage is not None), None)


def in_order(visits: Sequence[Visit]) -> Visits:
    """Return the visits of one unit in the order of their dates; of one day in the order in which they are given.

    Visits of another valve body than that of the last one are left out. A mileage that falls begins a new series: it
    cannot be told whether the odometer was changed or a digit is wrong.
    """
    ordered = sorted(visits, key=lambda visit: visit.date)
    kept = [visit for visit in ordered if visit.controller == ordered[-1].controller]
    messages = [
        Message(
            "warning",
            "visit_of_another_valve_body",
            Sentence(
                "The visit of {visit} is left out: its valve body is {controller}, that of the last visit {last}.",
                visit=visit.label,
                controller=visit.controller,
                last=kept[-1].controller,
            ),
        )
        for visit in ordered
        if visit.controller != kept[-1].controller
    ]
    unstated = Sentence("The visit of {visit} states no mileage: its clearances count in no rate of wear.")
    messages += [
        Message("warning", "visit_without_mileage", unstated.of(visit=visit.label))
        for visit in kept
        if visit.mileage is None and visit.lands
    ]
    turned_back = set()
    stated = [(place, visit, visit.mileage) for place, visit in enumerate(kept) if visit.mileage is not None]
    for (_, before, more), (place, after, less) in pairwise(stated):
        if less < more:
            turned_back.add(place)
            text = Sentence(
                "The mileage falls from {more:,.0f} {more.unit} on {before} to {less:,.0f} {less.unit} on {after}: "
                "another odometer, or a slip. No visit before that counts in any rate of wear.",
                more=Quantity(more, "distance"),
                before=before.label,
                less=Quantity(less, "distance"),
                after=after.label,
            )
            messages.append(Message("warning", "mileage_falls", text))
        elif less == more and before.lands and after.lands:
            text = Sentence(
                "{before} and {after} state the same mileage, {mileage:,.0f} {mileage.unit}: together they tell a "
                "clearance better, and no wear between them.",
                before=before.label,
                after=after.label,
                mileage=Quantity(less, "distance"),
            )
            messages.append(Message("info", "mileage_unchanged", text))
    return Visits(tuple(kept), frozenset(turned_back), tuple(messages))
