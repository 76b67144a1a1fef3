"""Compute the linear budget of every land and of the total: one factor is changed at a time, by central differences.

All lands are evaluated at once, a row for each; every column changes one thing. The pressures of the circuits stay as
they are with the unit as measured.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from atleak.engine.leakage import LeakageModel
from atleak.engine.projection import Projection
from atleak.uncertainty.assumptions import Assumptions
from atleak.uncertainty.drawn import Drawn, DrawnLands
from atleak.uncertainty.draws import FACTORS, Bore, LandInState, with_one_side
from atleak.uncertainty.sources import LandSources
from atleak.uncertainty.spread import flow_ratio

ONE_SIDE, POSITION = "wear to one side", "where the spool lies"  # names in the budgets

_SMALL = 0.01  # step of the derivatives, as a fraction of a standard uncertainty
#: Two columns per factor, two of the wear to one side, two of the clearance, two of the contact length, one as it is.
_COLUMNS = 2 * len(FACTORS) + 7
_HALF_ASIDE, _ALL_ASIDE, _WIDER, _LONGER = -7, -6, -5, -3  # the column after the last two is the other way


@dataclass(frozen=True)
class LandSlopes:
    """The leakage of one land at one condition, and how its share follows what is uncertain."""

    leakage: float  # [m³/s] at the values as measured
    share_per_clearance: float  # [1/m]
    share_effects: dict[str, float]  # change of the share for one standard uncertainty


class Linear:
    """The lands of a unit at one condition as measured, with one thing changed in each column."""

    def __init__(
        self,
        model: LeakageModel,
        projection: Projection,
        sources: Sequence[LandSources],
        assumptions: Assumptions,
        position: float,
    ) -> None:
        """Evaluate them; ``position`` is the relative standard deviation of a flow by where the spool lies."""
        self._sources, self._position = sources, position
        self._probe = Drawn(model, projection, assumptions, _deviates())
        lands = DrawnLands(self._probe, map(_as_measured, sources))
        self._beside = lands.leakage
        self._steps = np.array([_SMALL * (land.standard_uncertainty or 1e-7) for land in sources])
        bore, lengths = self._changed(assumptions)
        self._flow, self._drawn = lands.flows(sources, bore, lengths)

    def _changed(self, assumptions: Assumptions) -> tuple[Bore, np.ndarray]:
        """Return bores and contact lengths [m], shapes (lands, columns)."""
        lands, shape = [source.state for source in self._sources], (len(self._sources), _COLUMNS)
        rows = np.array(
            [
                (each.radial_clearance, *each.form_moments, each.land.contact_length, uncertain)
                for each in lands
                for uncertain in [assumptions.of_contact_length(measured=each.land.contact_length_measured)]
            ]
        ).reshape(-1, 5)
        clearance, square, cube, length = (np.broadcast_to(row[:, None], shape).copy() for row in rows.T[:4])
        for at, sign in ((_WIDER, 1.0), (_WIDER + 1, -1.0)):
            clearance[:, at] += sign * self._steps
        for at, sign in ((_LONGER, 1.0), (_LONGER + 1, -1.0)):
            length[:, at] += sign * _SMALL * rows[:, 4]
        if self._probe.model.law.counts_form:
            worn = np.array(["sleeve" in source.plans for source in self._sources])
            new = np.array([each.land.new_clearance for each in lands])
            shown = np.where(worn, np.maximum(rows[:, 0] - new, 0.0), 0.0)
            for at, part in ((_HALF_ASIDE, 0.5), (_ALL_ASIDE, 1.0)):
                wear = part * assumptions.one_sided_wear * shown
                square[:, at], cube[:, at] = with_one_side(wear, rows[:, 1], rows[:, 2])
        return Bore(clearance, square, cube), length

    @cached_property
    def lands(self) -> tuple[LandSlopes, ...]:
        """Return the slopes of every land."""
        share = self._share(self._drawn)
        effects = self._effects(share)
        names, values = [*effects], np.array(list(effects.values())).T.tolist()
        per_clearance = (_difference(share, _WIDER) / self._steps).tolist()
        each = zip(self._flow[:, -1].tolist(), per_clearance, values, strict=True)
        return tuple(LandSlopes(flow, slope, dict(zip(names, of, strict=True))) for flow, slope, of in each)

    def _share(self, drawn: np.ndarray) -> np.ndarray:
        return flow_ratio(drawn, np.broadcast_to(self._probe.capacity, drawn.shape))

    def total_effects(self) -> dict[str, float]:
        """Return the change of the total's share for one standard uncertainty of each source."""
        total = self._beside + sum(self._drawn)  # in the order of the lands
        share = self._share(total[None])
        capacity = float(np.broadcast_to(self._probe.capacity, _COLUMNS)[-1])
        per_flow = 1.0 / capacity if capacity > 0.0 else math.nan
        slopes = (_difference(self._drawn, _WIDER) / self._steps).tolist()
        lengths = (_difference(self._drawn, _LONGER) / _SMALL).tolist()
        own = 0.0  # variance from errors that no land shares
        shared: dict[str, float] = defaultdict(float)
        components: dict[str, float] = defaultdict(float)  # drawn, as measured
        for land, slope, by_length, flow in zip(
            self._sources, slopes, lengths, self._drawn[:, -1].tolist(), strict=True
        ):
            own += slope**2 * land.own_variance + by_length**2
            components[land.key[0]] += flow
            for name, u in land.groups.items():
                shared[name] += slope * u
        effects = {name: float(values[0]) for name, values in _of_factors(share).items()}
        effects["each land's own readings and contact length"] = math.sqrt(own) * per_flow
        effects[ONE_SIDE] = float(_one_side_effect(share)[0])
        effects[POSITION] = self._position * math.hypot(*components.values()) * per_flow
        return effects | {f"common to all lands: {name}": slope * per_flow for name, slope in shared.items()}

    def _effects(self, values: np.ndarray) -> dict[str, np.ndarray]:
        with np.errstate(invalid="ignore"):  # a share is infinite where the pump delivers nothing
            by_position = self._position * values[:, -1]
        return _of_factors(values) | {
            "contact length": _difference(values, _LONGER) / _SMALL,
            ONE_SIDE: _one_side_effect(values),
            POSITION: by_position,
        }


def _deviates() -> dict[str, np.ndarray]:
    deviates = {}
    for number, name in enumerate(FACTORS):
        column = np.zeros(_COLUMNS)
        column[2 * number], column[2 * number + 1] = _SMALL, -_SMALL
        deviates[name] = column
    return deviates


def _as_measured(land: LandSources) -> LandInState:
    """Return a land as its readings have it."""
    state = land.state
    return land, Bore(state.radial_clearance, *state.form_moments), state.land.contact_length, None


def _of_factors(values: np.ndarray) -> dict[str, np.ndarray]:
    return {name: _difference(values, 2 * number) / _SMALL for number, name in enumerate(FACTORS)}


def _one_side_effect(values: np.ndarray) -> np.ndarray:
    """Return the standard deviation over none, half and all of the wear to one side, all three alike likely."""
    three = values[:, [-1, _HALF_ASIDE, _ALL_ASIDE]]
    known = np.isfinite(three).all(axis=1)
    return np.where(known, np.where(known[:, None], three, 0.0).std(axis=1), math.nan)


def _difference(values: np.ndarray, column: int) -> np.ndarray:
    first, second = values[:, column], values[:, column + 1]
    known = np.isfinite(first) & np.isfinite(second)
    return np.where(known, 0.5 * (np.where(known, first, 0.0) - np.where(known, second, 0.0)), math.nan)
