"""Compare two diagnoses of one unit: lands, totals, pressures and logs, and what changed beyond its uncertainty."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from atleak.comparison.changes import Change, change_between, clearance_change
from atleak.comparison.choices import differing_choices, judged_as, same_condition
from atleak.comparison.logs import compared_logs
from atleak.comparison.remarks import remarks
from atleak.comparison.results import CircuitComparison, Comparison, ConditionComparison, LandComparison
from atleak.diagnosis import Diagnosis
from atleak.engine.projection import Projection
from atleak.errors import InputError
from atleak.land_diagnosis import LandDiagnosis
from atleak.sentence import Sentence
from atleak.uncertainty.assess import COVERAGE
from atleak.uncertainty.paired import ChangeSpread, Visit, changes


def compare(before: Diagnosis, after: Diagnosis) -> Comparison:
    """Put two diagnoses of one unit side by side.

    Parameters
    ----------
    before, after
        the earlier and the later one, of the same valve body.

    Returns
    -------
    Comparison
        every land and operating point of either side, and what changed between them. Where fluid, limits, profile,
        stated condition or assumptions differ, ``alike`` is the unit after judged by the choices of the job before,
        and changes of totals and pressures are those to it: they are the unit's own. The job after keeps its own
        verdict beside it, which is the one that its own report says.

    Raises
    ------
    InputError
        two different valve bodies.

    Notes
    -----
    A change of a clearance has a standard uncertainty of √(u² before + u² after), and is significant beyond 1.96 times
    that: 95 % coverage. Nothing that was measured is taken as common to both visits, neither gauge nor setting ring nor
    part, because no sheet says what they share; see `atleak.comparison.changes.clearance_change`. Changes of totals
    and pressures are drawn for both visits together (`atleak.uncertainty.paired`): at one and the same stated fluid,
    temperature, pressure and pump, so that they are the unit's. Each change is judged by itself: of forty lands that
    stayed as they were, two may be called changed by chance.
    """
    if before.controller.id != after.controller.id:
        raise InputError(
            Sentence("these are two different valve bodies, whose lands have nothing to do with each other"),
            value=f"{before.controller.name} and {after.controller.name}",
            expected=Sentence("two jobs of one unit"),
        )
    differing = differing_choices(before, after)
    alike = judged_as(after, before) if differing else after
    lands = tuple(_lands(before, after))
    conditions = tuple(_conditions(before, after, alike))
    logs = None if before.log is None or after.log is None else compared_logs(before.log, after.log)
    found = Comparison(before, after, alike, differing, lands, conditions, logs, ())
    return replace(found, messages=tuple(remarks(found)))


# --- lands


def _lands(before: Diagnosis, after: Diagnosis) -> Iterator[LandComparison]:
    earlier = {land.key: land for land in before.lands}
    for land in after.lands:
        other = earlier.pop(land.key, None)
        yield LandComparison(land.key, other, land, _clearance(other, land))
    for key, land in earlier.items():
        yield LandComparison(key, land, None, None)


def _clearance(before: LandDiagnosis | None, after: LandDiagnosis) -> Change | None:
    if before is None or before.uncertainty is None or after.uncertainty is None:
        return None
    return clearance_change(before.uncertainty, after.uncertainty)


# --- operating points


def _conditions(before: Diagnosis, after: Diagnosis, alike: Diagnosis) -> Iterator[ConditionComparison]:
    pairs = [(projection, _like(alike, projection)) for projection in before.projections]
    both = [(first, second) for first, second in pairs if second is not None]
    spreads = dict(zip((first.condition.name for first, _ in both), _spreads(before, alike, both), strict=False))
    seen = []
    for first, second in pairs:
        own = _like(after, first)
        seen.append(own)
        if second is None:
            yield ConditionComparison(first, own)
        else:
            yield _condition(first, own, second, spreads.get(first.condition.name))
    for projection in after.projections:
        if not any(projection is each for each in seen):
            yield ConditionComparison(None, projection)


def _spreads(
    before: Diagnosis, alike: Diagnosis, pairs: Sequence[tuple[Projection, Projection]]
) -> tuple[ChangeSpread, ...]:
    """Return how sure the changes at each pair of conditions are; nothing unless both sides were measured."""
    first, second = before.uncertainty, alike.uncertainty
    if first is None or second is None:
        return ()
    return changes(
        Visit(before.model, [land.sources for land in first.lands], [each for each, _ in pairs]),
        Visit(alike.model, [land.sources for land in second.lands], [each for _, each in pairs]),
        first.assumptions,
        coverage=COVERAGE,
        draws=min(first.draws, second.draws),
        seed=first.seed,
    )


def _like(diagnosis: Diagnosis, other: Projection) -> Projection | None:
    """Return the projection at the very operating point of another one; None without one."""
    return next((each for each in diagnosis.projections if same_condition(each.condition, other.condition)), None)


def _condition(
    before: Projection, after: Projection | None, alike: Projection, spread: ChangeSpread | None
) -> ConditionComparison:
    def change(name: str, value: str = "") -> Change | None:
        first, second = (getattr(each, value or name) for each in (before, alike))
        return change_between(first, second, None if spread is None else getattr(spread, name))

    return ConditionComparison(
        before,
        after,
        alike,
        share=change("share"),
        leakage=change("leakage"),
        reserve=change("reserve"),
        main_pressure=change("main_pressure", "main_pressure_held"),
        circuits=tuple(_circuits(before, alike, spread)),
    )


def _circuits(before: Projection, after: Projection, spread: ChangeSpread | None) -> Iterator[CircuitComparison]:
    """Yield the circuits that both have; a circuit that is vented on one of the sides holds nothing to compare."""
    later = {each.circuit.id: each for each in after.circuits}
    for state in before.circuits:
        other = later.get(state.circuit.id)
        if other is not None:
            interval = None if spread is None else spread.circuits.get(state.circuit.id)
            change = change_between(state.pressure, other.pressure, interval)
            yield CircuitComparison(state.circuit, state, other, None if state.vented or other.vented else change)
