"""Say what to know about a comparison: what stands on one side only, and what else than the unit differs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from atleak.comparison.results import SIDES, Comparison, LandComparison
from atleak.errors import Message

_NAMED = 12  # lands that a message lists


def remarks(found: Comparison) -> Iterator[Message]:
    """Yield what stands on one side only, and what else than the unit differs between two jobs."""
    before, after = found.before, found.after
    if before.controller.sha256 != after.controller.sha256:
        text = (
            f"The file of the valve body ({after.controller.id}) was changed between the two jobs: what of totals and "
            "pressures changed is not the repair's alone"
        )
        yield Message("warning", "other_controller_file", text)
    if found.differing:
        named = "; ".join(f"{each.name}: {each.before} before, {each.after} after" for each in found.differing)
        text = (
            f"The two jobs were judged by other choices ({named}): their difference is not the repair's alone. Changes "
            "of totals and pressures are therefore to the unit after judged by the choices of the job before; its own "
            "verdict and numbers stay as its own report has them"
        )
        yield Message("warning", "other_choices", text)
    if before.readings is not None and after.readings is not None and before.readings.sha256 == after.readings.sha256:
        text = f"Both jobs rest on the same measuring sheet ({after.readings.file}): nothing was measured again"
        yield Message("warning", "same_sheet", text)
    yield from _missing_lands(found)
    for side, other in (SIDES, SIDES[::-1]):
        alone = [each.label for each in found.conditions if each.only_on(side)]
        if alone:
            text = f"Judged {side} only, as the job {other} has no such operating point: {'; '.join(alone)}"
            yield Message("info", "conditions_on_one_side", text)
    yield from _missing_logs(found)


def _missing_lands(found: Comparison) -> Iterator[Message]:
    without = [name for name in SIDES if getattr(found, name).readings is None]
    if without:
        text = f"No measuring sheet in the job {' nor in the job '.join(without)}: no clearance can be compared"
        yield Message("warning", "no_sheet", text)
        return
    for side, other in (SIDES, SIDES[::-1]):
        absent = [each for each in found.lands if each.described_only_on(side)]
        if absent:
            text = f"Only the valve body's file of the job {side} has these lands: {_names(absent)}"
            yield Message("warning", f"land_only_{side}", text)
        alone = [each for each in found.lands if each.only_on(side) and not each.described_only_on(side)]
        if alone:
            text = (
                f"Measured {side} and not {other}: {_names(alone)}. On the other side "
                f"{'they count' if len(alone) > 1 else 'it counts'} as new in totals and pressures"
            )
            yield Message("warning", f"measured_only_{side}", text)
    half = [land for land in found.compared if land.half]
    if half:
        text = (
            f"Measured on the spool or the sleeve only at one of the visits: {_names(half)}. The other part is taken "
            "at its nominal diameter"
        )
        yield Message("info", "half_measured", text)


def _names(lands: Sequence[LandComparison]) -> str:
    named = ", ".join(f"{component}/{land}" for component, land in (each.key for each in lands[:_NAMED]))
    return f"{named} and {len(lands) - _NAMED} more" if len(lands) > _NAMED else named


def _missing_logs(found: Comparison) -> Iterator[Message]:
    if found.logs is not None:
        alone = [pair for pair in found.logs.pairs if not pair.matched]
        if alone:
            text = f"{len(alone)} of {len(found.logs.pairs)} events of the road tests are in one of the logs only"
            yield Message("info", "events_on_one_side", text)
        return
    missing = [name for name in SIDES if getattr(found, name).log is None]
    if len(missing) == 1:
        text = f"The job {missing[0]} has no road test: there is no second log to lay over the other"
        yield Message("info", "log_on_one_side", text)
