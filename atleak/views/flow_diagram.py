"""Lay out where the pump's flow goes: places with their words and verdicts, and the flows between them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from atleak.catalogue.circuits import Circuit, Consumer, Leak
from atleak.diagnosis import Diagnosis
from atleak.engine.flows import Flow, Kind, Place, flows_at
from atleak.engine.line import LINE
from atleak.engine.projection import Projection
from atleak.verdicts import Verdict
from atleak.views.land_names import has_number, land_number
from atleak.views.pressures import pressures_at
from atleak.views.table import VERDICT, Column, Table
from atleak.wording import Wording, isolated, wording
from atleak.workshop_units import DM3_MIN, KPA

SHOWN = 12  # lands that are drawn by themselves; the others of a section stand together
_OTHERS = -1  # number of a land that stands for several


@dataclass(frozen=True)
class DrawnPlace:
    """One place of the diagram."""

    place: Place
    words: str  # short
    pressure: float | None  # [Pa] of a section or circuit
    name: str  # in full
    verdict: Verdict | None  # None where nothing is judged
    column: int  # 0 is the pump
    flow: float  # [m³/s] through it


@dataclass(frozen=True)
class DrawnFlow:
    """One flow of the diagram: between two of its places, by their numbers."""

    source: int
    target: int
    flow: float  # [m³/s]
    verdict: Verdict | None


@dataclass(frozen=True)
class FlowDiagram:
    """Where the flow goes at one condition, at the pressures that hold there."""

    projection: Projection
    places: tuple[DrawnPlace, ...]
    flows: tuple[DrawnFlow, ...]

    @property
    def columns(self) -> int:
        """Count the columns."""
        return 1 + max((each.column for each in self.places), default=0)


def flow_diagram(
    diagnosis: Diagnosis,
    projection: Projection,
    *,
    leaks_only: bool = False,
    lands: int = SHOWN,
    say: Wording | None = None,
) -> FlowDiagram:
    """Lay out the flow at one condition of a diagnosis.

    Parameters
    ----------
    leaks_only
        begin at the line, and leave out slip, consumers and what is left over.
    lands
        how many are drawn by themselves: the worst first, of equal ones those that leak most.
    say
        the words of a language; English unless given.

    Raises
    ------
    DomainError
        temperature outside the fluid's data.
    """
    say = say or wording("en")
    every = flows_at(diagnosis.model, projection.condition)
    verdicts = _verdicts(diagnosis, projection, every.flows)
    flows, count = _together([*every.flows], verdicts, lands)
    if leaks_only:
        flows = [each for each in flows if each.source.kind not in (Kind.PUMP, Kind.BEYOND)]
    columns = _columns(flows)
    through: dict[Place, float] = {
        place: max(
            sum(each.flow for each in flows if each.target == place),
            sum(each.flow for each in flows if each.source == place),
        )
        for place in columns
    }
    order = sorted(columns, key=lambda place: (columns[place], -_rank(verdicts.get(place)), -through[place]))
    words = _Words(diagnosis, every.pressures, count, say)
    places = tuple(
        DrawnPlace(
            place=place,
            words=words.short(place),
            pressure=every.pressures[place.name] if place.kind is Kind.SECTION else None,
            name=words.full(place),
            verdict=verdicts.get(place),
            column=columns[place],
            flow=through[place],
        )
        for place in order
    )
    number = {place: at for at, place in enumerate(order)}
    drawn = (DrawnFlow(number[each.source], number[each.target], each.flow, _of_flow(each, verdicts)) for each in flows)
    return FlowDiagram(projection, places, tuple(drawn))


def flow_table(diagram: FlowDiagram, say: Wording) -> Table:
    """Return the diagram as a table, the largest flow first."""
    columns = (
        Column("verdict", VERDICT, width=92),
        Column("flows_from", of=lambda flow: diagram.places[flow.source].name),
        Column("flows_to", of=lambda flow: diagram.places[flow.target].name),
        Column("flow", "flow", 3, times=DM3_MIN),
    )
    return Table("flows", columns, sorted(diagram.flows, key=lambda each: -each.flow), say)


def flow_words(flow: float, say: Wording) -> str:
    """Return a flow [m³/s] in the reader's unit, with as many digits as small ones need: ``7.6``, ``0.088``."""
    value = flow * DM3_MIN
    return say.value(value, "flow", 1 if value >= 1.0 else 2 if value >= 0.1 else 3)


def _verdicts(diagnosis: Diagnosis, projection: Projection, flows: Sequence[Flow]) -> dict[Place, Verdict]:
    """Return the verdict of every place that is judged at a condition."""
    at = pressures_at(diagnosis, projection)
    of_lands = {land.key: land.verdict for land in diagnosis.lands}
    lands = {each.target for each in flows if each.target.kind is Kind.LAND}
    found = {land: of_lands[land.name, land.land] for land in lands}
    found |= {Place(Kind.SECTION, each.id): each.verdict for each in at.applied if each.verdict is not None}
    if at.reserve_verdict is not None:
        found[Place(Kind.PUMP)] = at.reserve_verdict
    return found


def _of_flow(flow: Flow, verdicts: dict[Place, Verdict]) -> Verdict | None:
    """Return the verdict of the land or circuit that a flow leads into, or out of where it leads to an end."""
    for place in (flow.target, flow.source):
        if place.kind in (Kind.LAND, Kind.SECTION) and place != Place(Kind.SECTION, LINE):
            return verdicts.get(place)
    return None


def _together(flows: Sequence[Flow], verdicts: dict[Place, Verdict], lands: int) -> tuple[list[Flow], dict[Place, int]]:
    """Let lands that are not drawn by themselves stand together, by the sections between which they leak.

    All that leak to the sump alone are one place.

    Returns
    -------
    tuple
        the flows, and how many lands stand at each place that several share.
    """
    through: dict[Place, float] = defaultdict(float)
    ends: dict[Place, set[tuple[int, Place]]] = defaultdict(set)
    for each in flows:
        if each.target.kind is Kind.LAND:
            through[each.target] += each.flow
            ends[each.target].add((0, each.source))
        if each.source.kind is Kind.LAND:
            ends[each.source].add((1, each.target))
    worst_first = sorted(through, key=lambda land: (-_rank(verdicts.get(land)), -through[land]))
    groups: dict[frozenset[tuple[int, Place]], list[Place]] = defaultdict(list)
    for land in worst_first[lands:]:
        to = {end for end in ends[land] if end[0] == 1}
        to_sump = {place.kind for _, place in to} == {Kind.SUMP}
        groups[frozenset(to if to_sump else ends[land])].append(land)
    stands_at = {land: land for land in through}
    count: dict[Place, int] = {}
    for number, alike in enumerate(groups.values()):
        if len(alike) > 1:
            place = Place(Kind.LAND, str(number), _OTHERS)
            count[place] = len(alike)
            verdicts[place] = max((verdicts[land] for land in alike), key=lambda verdict: verdict.rank)
            stands_at |= dict.fromkeys(alike, place)
    sums: dict[tuple[Place, Place], float] = defaultdict(float)
    for each in flows:
        sums[stands_at.get(each.source, each.source), stands_at.get(each.target, each.target)] += each.flow
    return [Flow(*both, flow) for both, flow in sums.items()], count


def _rank(verdict: Verdict | None) -> int:
    return -1 if verdict is None else verdict.rank


def _columns(flows: Sequence[Flow]) -> dict[Place, int]:
    """Return the column of every place: one behind the last that leads to it.

    What leads to the sump alone stands before it, and the sump last of all.
    """
    columns = {place: 0 for each in flows for place in (each.source, each.target)}
    for _ in columns:  # in a circle of flows places stay where the last round leaves them
        later = {each.target: columns[each.source] + 1 for each in sorted(flows, key=lambda each: columns[each.source])}
        moved = {place: max(column, later.get(place, 0)) for place, column in columns.items()}
        if moved == columns:
            break
        columns = moved
    last = max(columns.values(), default=0)
    leads_to: dict[Place, set[Kind]] = defaultdict(set)
    for each in flows:
        leads_to[each.source].add(each.target.kind)
    moved = {place: last - 1 for place in columns if leads_to[place] == {Kind.SUMP} and place.kind is not Kind.SECTION}
    moved |= {place: last for place in columns if place.kind is Kind.SUMP}
    return columns | moved


@dataclass(frozen=True)
class _Words:
    """The words of the places."""

    diagnosis: Diagnosis
    pressures: Mapping[str, float]
    count: Mapping[Place, int]
    say: Wording

    def short(self, place: Place) -> str:
        """Return the words beside a place."""
        controller = self.diagnosis.controller
        if place.kind is not Kind.LAND or place in self.count:
            return self.name(place)
        if not has_number(controller, place.name):
            return land_number(controller, (place.name, place.land), self.say)
        return f"{place.name} · {place.land}"

    def full(self, place: Place) -> str:
        """Return the name of a place, of a section or circuit with its pressure."""
        if place.kind is not Kind.SECTION:
            return self.name(place)
        pressure = self.say.value(self.pressures[place.name] * KPA, "pressure", 0)
        return f"{self.name(place)} {pressure} {self.say.unit('pressure')}"

    def name(self, place: Place) -> str:
        """Return the name of a place."""
        say, controller = self.say, self.diagnosis.controller
        if place in self.count:
            return say("flows.others", count=self.count[place])
        if place.kind is Kind.LAND:
            named = isolated(say.name(controller.components[place.name]))
            return f"{self.short(place)} {named}" if has_number(controller, place.name) else self.short(place)
        described: dict[Kind, Sequence[Circuit | Leak | Consumer]] = {
            Kind.SECTION: controller.circuits,
            Kind.LEAK: controller.leaks,
            Kind.CONSUMER: controller.consumers,
        }
        if place.kind in described:
            known = next((each.name for each in described[place.kind] if each.id == place.name), "")
            return isolated(say.name(known) if known else say.get("pressures", place.name))
        return say(f"flows.{place.kind}")
