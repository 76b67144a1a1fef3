"""Tell by which choices two jobs were judged, where these differ, and judge one unit by the choices of the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Literal

from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.pump import NO_CLEARANCES
from atleak.diagnosis import Diagnosis, diagnose
from atleak.sentence import Name, Sentence
from atleak.uncertainty import DEFAULTS, GUARD_FACTOR

ChoiceName = Literal["fluid", "limits", "profile", "condition", "assumptions"]


@dataclass(frozen=True)
class DifferingChoice:
    """One choice in which two jobs differ, in English words."""

    name: ChoiceName
    before: Sentence
    after: Sentence


def differing_choices(before: Diagnosis, after: Diagnosis) -> tuple[DifferingChoice, ...]:
    """Return the choices that change a result of the same readings, and in which two jobs differ.

    Instruments, measuring temperature, pump clearances and lengths that were measured are no such choices: they belong
    to what was measured.
    """
    return tuple(_differing(before, after))


def _differing(before: Diagnosis, after: Diagnosis) -> Iterator[DifferingChoice]:
    for name, what, said in _CHOICES:
        if what(before) != what(after):
            yield DifferingChoice(name, *_told_apart(said(before), said(after)))
    if before.uncertainty is not None and after.uncertainty is not None:
        assumed = [
            {**each.assumptions.settings, "guard band": each.guard_factor}
            for each in (before.uncertainty, after.uncertainty)
        ]
        names = [name for name, value in assumed[0].items() if value != assumed[1][name]]
        if names:
            first, second = (
                tuple(Sentence("{name} {value:g}", name=name.replace("_", " "), value=each[name]) for name in names)
                for each in assumed
            )
            yield DifferingChoice("assumptions", _named(first), _named(second))


def _in_state(diagnosis: Diagnosis) -> Sentence:
    if diagnosis.fluid.state == "used":
        return Sentence("{fluid}, used", fluid=Name(diagnosis.fluid.name))
    return Sentence("{fluid}, fresh", fluid=Name(diagnosis.fluid.name))


def _named(choice: str | OperatingPoint | tuple[Sentence, ...]) -> Sentence:
    return Sentence("{choice}", choice=choice)


def _told_apart(before: Sentence, after: Sentence) -> tuple[Sentence, Sentence]:
    """Return both names; what differs in its file alone says so."""
    return (before, after) if before != after else (before, Sentence("another file of the name {name}", name=after))


def same_condition(before: OperatingPoint, after: OperatingPoint) -> bool:
    """Tell whether two operating points are one and the same; how they are called and who states them aside."""
    return _bare(before) == _bare(after)


def _bare(condition: OperatingPoint) -> OperatingPoint:
    return replace(condition, label="", source="")


_CHOICES: tuple[tuple[ChoiceName, Callable[[Diagnosis], object], Callable[[Diagnosis], Sentence]], ...] = (
    ("fluid", lambda job: (job.fluid.origin.sha256, job.fluid.state, job.fluid.estimated), _in_state),
    ("limits", lambda job: job.limits.origin.sha256, lambda job: _named(Name(job.limits.name))),
    ("profile", lambda job: job.profile.options, lambda job: _named(job.profile.label)),
    ("condition", lambda job: _bare(job.projection.condition), lambda job: _named(job.projection.condition)),
)


def judged_as(after: Diagnosis, before: Diagnosis) -> Diagnosis:
    """Return the same unit, as measured, judged by the choices of another job of it.

    Parameters
    ----------
    after
        the diagnosis whose readings, log, gauges and valve body count.
    before
        the diagnosis whose fluid, limits, profile, stated condition and assumptions count.
    """
    measured, chosen = after.uncertainty, before.uncertainty or after.uncertainty
    same_file = before.controller.sha256 == after.controller.sha256
    # the controller holds this job's pump and lands already: the pump of the sheet's head must not count twice
    readings = None if after.readings is None else replace(after.readings, pump=NO_CLEARANCES)
    again = diagnose(
        after.controller,
        before.fluid,
        before.limits,
        fluid_state=None if before.fluid_state_assumed else before.fluid.state,
        readings=readings,
        road_test=after.log.road_test if after.log is not None else None,
        pressures=after.pressures.table if after.pressures is not None else None,
        profile=before.profile,
        condition=(before if same_file else after).projection.condition,
        mileage=after.mileage,
        measuring_temperature=after.measured_at.value if after.measured_at is not None else None,
        instruments=measured.instruments if measured is not None else None,
        assumptions=chosen.assumptions if chosen is not None else DEFAULTS,
        guard_factor=chosen.guard_factor if chosen is not None else GUARD_FACTOR,
        complaint=after.complaint,
    )
    return replace(again, repairs=after.repairs)
