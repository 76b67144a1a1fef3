"""Say what to know about a comparison: what stands on one side only, and what else than the unit differs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from atleak.comparison.choices import ChoiceName, DifferingChoice
from atleak.comparison.results import SIDES, Comparison, LandComparison, Side
from atleak.errors import Message
from atleak.sentence import Sentence, in_a_row, some

_NAMED = 12  # lands that a message lists


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


def _differing(choice: DifferingChoice) -> Sentence:
    name = _CHOICES[choice.name]
    return Sentence("{choice}: {before} before, {after} after", choice=name, before=choice.before, after=choice.after)


_CHOICES: dict[ChoiceName, Sentence] = {
    "fluid": Sentence("fluid"),
    "limits": Sentence("limits"),
    "profile": Sentence("profile"),
    "condition": Sentence("condition"),
    "assumptions": Sentence("assumptions"),
}


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
            several = Sentence("On the other side they count as new in totals and pressures")
            one = Sentence("On the other side it counts as new in totals and pressures")
            counts = several if len(alone) > 1 else one
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
    return some([f"{component}/{land}" for component, land in (each.key for each in lands)], _NAMED)


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
