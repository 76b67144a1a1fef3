"""Draw one unit at two visits together: by how much its total, reserve and pressures changed, and how sure that is.

What both visits state alike, fluid, temperatures, pressures, pump and lengths of lands, is drawn once for both: it is
one number on both sides of the difference. So is what a bore keeps: what its pair was when new, how much of its wear
lies to one side, and to which. What was measured is drawn for each visit by itself, common errors of the instruments
included: no sheet says whether a gauge was set with the same ring, or a part is still the same one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from atleak.diagnosis.uncertainty.assumptions import Assumptions
from atleak.diagnosis.uncertainty.drawn_unit import DemandShape, Drawn, DrawnLands, deviates_of_factors, leakiest
from atleak.diagnosis.uncertainty.draws import Beside, Cube, Draws, Interval, interval_of, rounded_up
from atleak.diagnosis.uncertainty.land_draws import LandDraws, Positions, common_errors, land_draws
from atleak.diagnosis.uncertainty.one_sided_wear import OneSided, one_sided_wear
from atleak.diagnosis.uncertainty.sources import LandSources
from atleak.engine.leakage import LeakageModel
from atleak.engine.operation import spread_over
from atleak.engine.projection import Projection

_UNIT, _VISITS = 1, (4, 5)  # streams of what the unit keeps, and of what each visit measured
_LENGTH = 3  # dimension of a land's length, behind what it had when new and how its wear is seen, measured or not


@dataclass(frozen=True)
class PairedVisit:
    """One visit of a unit: its model, the sources of every land's uncertainty, and the conditions of interest."""

    model: LeakageModel
    lands: Sequence[LandSources]
    projections: Sequence[Projection]


@dataclass(frozen=True)
class ChangeSpread:
    """The intervals of what changed at one condition: after minus before."""

    leakage: Interval  # [m³/s]
    share: Interval
    reserve: Interval
    main_pressure: Interval  # [Pa] that holds
    circuits: Mapping[str, Interval]  # [Pa] by id, of those that both visits hold


def changes(
    before: PairedVisit, after: PairedVisit, assumptions: Assumptions, *, coverage: float, draws: int, seed: int
) -> tuple[ChangeSpread, ...]:
    """Return the intervals of what changed between two visits, at each pair of their conditions.

    Parameters
    ----------
    before, after
        the two visits; their projections belong together one by one, at the same stated conditions.
    coverage
        probability of every interval; as much is left out below as above.
    draws, seed
        number of draws and seed: the same input gives the same digits.

    Notes
    -----
    A land that neither visit measured is the same unknown one at both. A spool that was taken out may lie elsewhere in
    its bore than before.
    """
    draws = rounded_up(draws)
    shared = Draws(Cube(draws, seed, 0))
    deviates = deviates_of_factors(shared)
    one_sided = one_sided_wear(shared, before.model, assumptions, [*before.lands, *after.lands])
    drawn = list(_drawn_lands(before, after, deviates, one_sided, assumptions, seed))
    spreads = []
    for pair in zip(before.projections, after.projections, strict=True):
        (first, circuits), (second, others) = (
            _held(visit.model, projection, lands, assumptions, deviates)
            for visit, projection, lands in zip((before, after), pair, drawn, strict=True)
        )
        of_circuits = {
            name: _change(pressure, others[name], coverage) for name, pressure in circuits.items() if name in others
        }
        quantities = {name: _change(value, second[name], coverage) for name, value in first.items()}
        spreads.append(ChangeSpread(**quantities, circuits=of_circuits))
    return tuple(spreads)


def _change(before: np.ndarray, after: np.ndarray, coverage: float) -> Interval:
    """Return the interval of what changed; NaN where it is infinite at both visits, as a share of no delivery is."""
    with np.errstate(invalid="ignore"):
        difference = after - before
    return interval_of(difference, coverage)


def _drawn_lands(
    before: PairedVisit,
    after: PairedVisit,
    deviates: dict[str, np.ndarray],
    one_sided: OneSided,
    assumptions: Assumptions,
    seed: int,
) -> Iterator[list[LandDraws]]:
    """Draw every land of both visits, beside what both share."""
    first = before.projections[0]
    commons = [
        common_errors(Draws(Cube(one_sided.fraction.size, seed, number)), visit.lands)
        for visit, number in zip((before, after), _VISITS, strict=True)
    ]
    at_first = Drawn(before.model, first, assumptions, deviates)
    score = at_first.score(leakiest(before.lands, first), commons[0], one_sided)
    kept = Beside(Cube(one_sided.fraction.size, seed, _UNIT), score)
    for visit, number, common in zip((before, after), _VISITS, commons, strict=True):
        read = Beside(Cube(one_sided.fraction.size, seed, number, _UNIT), score)
        positions = Positions(visit.model, read, seed + number)
        streams = ((land, kept.draws(seed, *_words(_UNIT, *land.key))) for land in visit.lands)
        yield [
            land_draws(
                stream,
                land,
                common,
                one_sided,
                assumptions,
                positions.of(land),
                read.draws(seed, *_words(number, *land.key)),
                stream.onward_from(_LENGTH),
            )
            for land, stream in streams
        ]


def _words(*name: int | str) -> Iterator[int]:
    """Return the numbers that make a seed of a name."""
    return (part if isinstance(part, int) else int.from_bytes(part.encode()) for part in name)


def _held(
    model: LeakageModel,
    projection: Projection,
    lands: Sequence[LandDraws],
    assumptions: Assumptions,
    deviates: dict[str, np.ndarray],
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return what one visit comes to at one condition, as `ChangeSpread` names it: quantities, and circuits' [Pa]."""
    point, drawn = projection.condition, Drawn(model, projection, assumptions, deviates)
    counted = DrawnLands(drawn, (each.now for each in lands))
    for land in lands:
        counted.count(*land.now)
    unit = counted.unit()
    main, pressures = unit.held(DemandShape(model, point))
    return {
        "leakage": counted.leakage,
        "share": counted.share,
        "reserve": unit.reserve(point),
        "main_pressure": main,
    }, {
        state.circuit.id: spread_over(pressures[state.circuit.id], main.shape)
        for state in projection.circuits
        if not state.vented
    }
