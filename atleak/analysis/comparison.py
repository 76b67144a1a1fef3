"""Compare two diagnoses of one unit: before and after a repair, or two visits.

`compare` is the one function to call; `atleak.analysis.changes` has the types of its result. It says of lands, totals,
pressures and logs what changed beyond its uncertainty.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from atleak.analysis.changes import (
    SIDES,
    Change,
    ChoiceName,
    CircuitComparison,
    Comparison,
    ConditionComparison,
    DifferingChoice,
    LandComparison,
    Side,
    change_between,
    clearance_change,
    compared_logs,
    differing_choices,
    judged_as,
    same_condition,
)
from atleak.common.errors import InputError, Message
from atleak.common.sentences import Sentence, counted, in_a_row, some
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.messages import LANDS_LISTED
from atleak.diagnosis.uncertainty.assess import COVERAGE
from atleak.diagnosis.uncertainty.paired import ChangeSpread, PairedVisit, changes
from atleak.engine.projection import Projection

_JUDGED_ONLY: dict[Side, Sentence] = {
    "before": Sentence("Judged before only, as the job after has no such operating point: {conditions}"),
    "after": Sentence("Judged after only, as the job before has no such operating point: {conditions}"),
}
_DESCRIBED_ONLY: dict[Side, Sentence] = {
    "before": Sentence("Only the valve body's file of the job before has these lands: {lands}"),
    "after": Sentence("Only the valve body's file of the job after has these lands: {lands}"),
}
_MEASURED_ONLY: dict[Side, Sentence] = {
    "before": Sentence("Measured before and not after: {lands}. {counts}"),
    "after": Sentence("Measured after and not before: {lands}. {counts}"),
}
_CHOICES: dict[ChoiceName, Sentence] = {
    "fluid": Sentence("fluid"),
    "limits": Sentence("limits"),
    "profile": Sentence("profile"),
    "condition": Sentence("condition"),
    "assumptions": Sentence("assumptions"),
}


def remarks(found: Comparison) -> Iterator[Message]:
    """Yield what stands on one side only, and what else than the unit differs between two jobs."""
    before, after = found.before, found.after
    if before.controller.sha256 != after.controller.sha256:
        text = Sentence(
            "The file of the valve body ({controller}) was changed between the two jobs: what of totals and pressures "
            "changed is not the repair's alone",
            controller=after.controller.id,
        )
        yield Message("warning", "other_controller_file", text)
    if found.differing:
        text = Sentence(
            "The two jobs were judged by other choices ({choices}): their difference is not the repair's alone. "
            "Changes of totals and pressures are therefore to the unit after judged by the choices of the job before; "
            "its own verdict and numbers stay as its own report has them",
            choices=in_a_row(map(_differing, found.differing)),
        )
        yield Message("warning", "other_choices", text)
    if before.readings is not None and after.readings is not None and before.readings.sha256 == after.readings.sha256:
        text = Sentence(
            "Both jobs rest on the same measuring sheet ({file}): nothing was measured again", file=after.readings.file
        )
        yield Message("warning", "same_sheet", text)
    yield from _missing_lands(found)
    alone = {side: [each.projection.condition for each in found.conditions if each.only_on(side)] for side in SIDES}
    for side, conditions in alone.items():
        if conditions:
            text = _JUDGED_ONLY[side].of(conditions=in_a_row(conditions))
            yield Message("info", "conditions_on_one_side", text)
    yield from _missing_logs(found)


def _differing(choice: DifferingChoice) -> Sentence:
    name = _CHOICES[choice.name]
    return Sentence("{choice}: {before} before, {after} after", choice=name, before=choice.before, after=choice.after)


def _missing_lands(found: Comparison) -> Iterator[Message]:
    without = _without_sheet(found)
    if without:
        yield Message("warning", "no_sheet", without)
        return
    for side in SIDES:
        absent = [each for each in found.lands if each.described_only_on(side)]
        if absent:
            yield Message("warning", f"land_only_{side}", _DESCRIBED_ONLY[side].of(lands=_names(absent)))
        alone = [each for each in found.lands if each.only_on(side) and not each.described_only_on(side)]
        if alone:
            counts = counted(
                len(alone),
                "On the other side it counts as new in totals and pressures",
                "On the other side they count as new in totals and pressures",
            )
            text = _MEASURED_ONLY[side].of(lands=_names(alone), counts=counts)
            yield Message("warning", f"measured_only_{side}", text)
    half = [land for land in found.compared if land.half]
    if half:
        text = Sentence(
            "Measured on the spool or the sleeve only at one of the visits: {lands}. The other part is taken at its "
            "nominal diameter",
            lands=_names(half),
        )
        yield Message("info", "half_measured", text)


def _without_sheet(found: Comparison) -> Sentence | None:
    if found.before.readings is None and found.after.readings is None:
        return Sentence("No measuring sheet in the job before nor in the job after: no clearance can be compared")
    if found.before.readings is None:
        return Sentence("No measuring sheet in the job before: no clearance can be compared")
    if found.after.readings is None:
        return Sentence("No measuring sheet in the job after: no clearance can be compared")
    return None


def _names(lands: Sequence[LandComparison]) -> Sentence:
    return some([f"{component}/{land}" for component, land in (each.key for each in lands)], LANDS_LISTED)


def _missing_logs(found: Comparison) -> Iterator[Message]:
    if found.logs is not None:
        alone = [pair for pair in found.logs.pairs if not pair.matched]
        if alone:
            text = Sentence(
                "{count} of {events} events of the road tests are in one of the logs only",
                count=len(alone),
                events=len(found.logs.pairs),
            )
            yield Message("info", "events_on_one_side", text)
        return
    missing = [name for name in SIDES if getattr(found, name).log is None]
    if len(missing) == 1:
        text = (
            Sentence("The job before has no road test: there is no second log to lay over the other")
            if missing == ["before"]
            else Sentence("The job after has no road test: there is no second log to lay over the other")
        )
        yield Message("info", "log_on_one_side", text)


def compare(before: Diagnosis, after: Diagnosis) -> Comparison:
    """Put two diagnoses of one unit side by side.

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
    part, because no sheet says what they share; see `atleak.analysis.changes.clearance_change`. Changes of
    totals and pressures are drawn for both visits together (`atleak.diagnosis.uncertainty.paired`): at one and the same
    stated fluid, temperature, pressure and pump, so that they are the unit's. Each change is judged by itself: of forty
    lands that stayed as they were, two may be called changed by chance.
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
        PairedVisit(before.model, [land.sources for land in first.lands], [each for each, _ in pairs]),
        PairedVisit(alike.model, [land.sources for land in second.lands], [each for _, each in pairs]),
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
