"""Gather the valves that have reached a limit: where their oil goes, what that can be felt as, what a repair brings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum

from atleak.catalogue.complaints import Complaint
from atleak.catalogue.controller import Gap
from atleak.diagnosis import Diagnosis
from atleak.engine.projection import Projection
from atleak.land_diagnosis import LandDiagnosis
from atleak.repair import Choice, RepairedAt
from atleak.rules import LandKey
from atleak.verdicts import Verdict
from atleak.views.pressures import HeldPressure, lowest_first, pressures_at

WORTH_SAYING = (
    0.1  # part of what leaks at a complaint's conditions from which a valve is named for it: project's choice
)


class End(Enum):
    """Where oil leaks to that is no section with a name."""

    SUMP = "sump"
    FIXED_PRESSURE = "fixed_pressure"
    ANOTHER_SECTION = "another_section"  # which the valve body's file does not name


Path = tuple[str, str | End]  # section from which, and section or other end into which oil leaks


@dataclass(frozen=True)
class WornValve:
    """One component with lands past a limit, and what follows from them."""

    component: str
    lands: tuple[LandDiagnosis, ...]  # past a limit, the worst first
    paths: tuple[Path, ...]  # on which these lands leak, as the valve body's file describes them
    complaints: tuple[Complaint, ...]  # of the file, where they carry a part worth saying, the largest first
    costs: tuple[tuple[HeldPressure, float], ...]  # pressures past a limit, and what they cost them [Pa]
    alone: tuple[RepairedAt, ...]  # what repairing them alone brings at every condition; none where nothing is chosen

    @property
    def verdict(self) -> Verdict:
        """Return the worst verdict of its lands."""
        return self.lands[0].verdict

    def brings(self, projection: Projection) -> RepairedAt | None:
        """Return what repairing it alone brings at a condition; None where no repair of it is chosen."""
        return next((each for each in self.alone if each.condition == projection.condition), None)


def worn_valves(diagnosis: Diagnosis, choice: Choice) -> tuple[WornValve, ...]:
    """Return every valve with lands past a limit: the worst verdict first, of equal ones that which saves most.

    Parameters
    ----------
    choice
        the repairs that are chosen for the unit; a valve's own of them are those that change one of its lands.
    """
    by_component: dict[str, list[LandDiagnosis]] = {}
    for land in diagnosis.flagged:
        by_component.setdefault(land.key[0], []).append(land)
    mine = [[move for move in choice.chosen if any(key[0] == name for key in move.treats)] for name in by_component]
    now, *after = choice.totals_of([[], *mine])
    held = [each for each in pressures_at(diagnosis, lowest_first(diagnosis)[0]).applied if each.loss > 0.0]
    past = [each for each in held if each.verdict is not None and each.verdict.flagged]
    at = [(complaint, diagnosis.complained_of(complaint)) for complaint in diagnosis.controller.complaints]
    valves = []
    for (component, flagged), moves, totals in zip(by_component.items(), mine, after, strict=True):
        lands = tuple(sorted(flagged, key=lambda land: -land.verdict.rank))
        keys = {land.key for land in lands}
        alone = tuple(RepairedAt(one, other) for one, other in zip(now, totals, strict=True)) if moves else ()
        valves.append(
            WornValve(
                component,
                lands,
                _paths(diagnosis, keys),
                _felt(keys, at),
                tuple((each, loss) for each in past if (loss := _cost(each.costly, keys)) > 0.0),
                alone,
            )
        )
    return tuple(sorted(valves, key=lambda each: (-each.verdict.rank, -_saved(each))))


def part_of_leakage(keys: set[LandKey], projection: Projection) -> float:
    """Return which part of all that leaks at a condition goes past some lands."""
    everything = sum(gap.leakage for gap in projection.gaps)
    return sum(projection.leakage_of(key) for key in keys) / everything if everything > 0.0 else 0.0


def _saved(valve: WornValve) -> float:
    return max((each.saving for each in valve.alone), default=0.0)


def _paths(diagnosis: Diagnosis, keys: set[LandKey]) -> tuple[Path, ...]:
    described = keys - diagnosis.controller.gaps_not_described
    gaps = [gap for gap in diagnosis.controller.gaps if gap.key in described]
    return tuple(dict.fromkeys((gap.high.section, _end(gap)) for gap in gaps if gap.high.section is not None))


def _end(gap: Gap) -> str | End:
    if gap.low.section is None and gap.low.constant > 0.0:
        return End.FIXED_PRESSURE
    if gap.into_sump:
        return End.SUMP
    return gap.low.section if gap.low.section is not None and gap.low.is_section else End.ANOTHER_SECTION


def _felt(keys: set[LandKey], at: Iterable[tuple[Complaint, tuple[Projection, ...]]]) -> tuple[Complaint, ...]:
    """Return the complaints that name some of the lands, or name none, and show where these carry a part worth saying.

    The one where they carry most comes first.
    """
    parts: list[tuple[float, Complaint]] = []
    for complaint, projections in at:
        mine = keys & set(complaint.lands) if complaint.lands else keys
        parts.append((max((part_of_leakage(mine, each) for each in projections), default=0.0), complaint))
    return tuple(complaint for part, complaint in sorted(parts, key=lambda each: -each[0]) if part >= WORTH_SAYING)


def _cost(costly: tuple[tuple[LandKey, float], ...], keys: set[LandKey]) -> float:
    losses: Mapping[LandKey, float] = dict(costly)
    return sum(losses[key] for key in keys & set(losses))
