"""A population of units as a workshop gets them: new valve bodies and worn ones, with clearances as published.

Which land sees which pressures, the pump and the operating points are those of the shipped four-speed valve body.
Everything about a pair is drawn: its own clearance when new from the range that is published for new valves of
automatic transmissions, its diameter, its contact length, the metal of its spool, and its wear. In a valve body with
circuits the feeds fit the lands, whose diameters and lengths stay as its file has them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache

import numpy as np

from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.controller_tables import NewOrigin
from atleak.catalogue.fluid import Fluid, load_fluid
from atleak.catalogue.instruments import Instruments, load_instrument
from atleak.catalogue.limits import Limits, load_limits
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.uncertainty import DEFAULTS
from simulated.flows import Circumstances, TrueFlows, flows_in_circuits, true_flows
from simulated.gauges import Reader
from simulated.pairs import Pair, random_forms, sides_as_assumed

SEED = 20261121
WITHOUT_CIRCUITS, WITH_CIRCUITS = "four_speed_2023", "five_speed_2005"
NEW = (6.4e-6, 20e-6)  # [m] radial clearance of new valves: Sonnax, valve body inspection, 0.0127 … 0.040 mm diametral
DIAMETER = (8e-3, 16e-3)  # [m]
LENGTH = (4e-3, 12e-3)  # [m] of contact
ALUMINIUM, STEEL = 21.3e-6, 12.0e-6  # [1/K]
NEW_UNITS = 0.3  # fraction of units in which no land is worn
UNWORN = 0.4  # fraction of the lands of the other units that are not worn
MEAN_WEAR = (2e-6, 25e-6)  # [m] a worn unit's own mean of the exponential distribution of its worn lands
WORN_OUT = 60e-6  # [m] no land is worn further
#: [m] half width that holds 95 % of a type's pairs. A bore and a spool of 6-10 mm made to ISO 286 IT5, 6 µm each, vary
#: by ± √(3² + 3²) µm in D − d; those of 10-18 mm by a third more. Chosen for this benchmark.
TOLERANCE = 2.0e-6


#: All wear of every unit of one shape: which part is to one side, and its exponent. None: drawn as it is assumed.
SHAPES: dict[str, tuple[float, int] | None] = {
    "as assumed": None,
    "even": (0.0, 1),
    "cos": (1.0, 1),
    "cos²": (1.0, 2),
    "cos³": (1.0, 3),
}


class Known(StrEnum):
    """What the valve body's file says of the clearance when new."""

    PAIR = "each pair's own, measured when new"
    TYPE = "the type's ± 2 µm (95 %), as of bores and spools each made to ISO 286 IT5"
    RANGE = "only the range 6.4 … 20 µm"


@dataclass(frozen=True)
class Unit:
    """One simulated unit: its truth at every operating point, and the diagnosis of its measuring sheet."""

    pairs: tuple[Pair, ...]
    true: dict[str, TrueFlows]  # by operating point
    diagnosis: Diagnosis

    @property
    def is_new(self) -> bool:
        """Return whether no land is worn."""
        return all(pair.wear == 0.0 for pair in self.pairs)

    def greatest_share(self, pair: Pair) -> float:
        """Return the largest part of the pump's flow that a land truly takes at any operating point."""
        return max(flows.share(pair.land.key) for flows in self.true.values())


@cache
def _catalogue_entries(body: str) -> tuple[Controller, Fluid, Limits, Instruments]:
    return (
        load_controller(body),
        load_fluid("hipol_atf_iid"),
        load_limits("project_default"),
        Instruments(load_instrument("micrometer"), load_instrument("bore_gauge")),
    )


def simulate(
    known: Known,
    unit: int,
    shape: str = "as assumed",
    directions: tuple[float, ...] = (0.0, 90.0),
    body: str = WITHOUT_CIRCUITS,
) -> Unit:
    """Simulate one unit, read it in some directions, twice in each, and diagnose the sheet like any other.

    The unit itself and its readings are the same whatever the file says of the clearance when new; whatever the shape
    of its wear, of `SHAPES`, the unit has the same wear.
    """
    rng = np.random.default_rng((SEED, unit))
    whole, fluid, limits, instruments = _catalogue_entries(body)
    pairs = _pairs(rng, whole, SHAPES[shape] or sides_as_assumed(np.random.default_rng((SEED, unit, 1))))
    readings = Reader(instruments, repeats=2, directions=directions).read(rng, pairs)
    circumstances = Circumstances.draw(rng)
    flows = true_flows if body == WITHOUT_CIRCUITS else flows_in_circuits
    true = {point.name: flows(pairs, whole, fluid, point, circumstances, DEFAULTS) for point in whole.operating_points}
    controller = replace(whole, lands=tuple(_in_file(rng, pair, known) for pair in pairs))
    return Unit(pairs, true, diagnose(controller, fluid, limits, readings=readings, instruments=instruments))


def _pairs(rng: np.random.Generator, controller: Controller, sides: tuple[float, int]) -> tuple[Pair, ...]:
    new_unit = rng.random() < NEW_UNITS
    mean_wear = rng.uniform(*MEAN_WEAR)
    one_sided, exponent = sides  # a property of the unit: bores wear by how it was used and how clean its fluid was
    pairs = []
    for land in controller.lands:
        if controller.id == WITHOUT_CIRCUITS:
            land = replace(
                land,
                nominal_diameter=round(rng.uniform(*DIAMETER), 4),
                contact_length=round(rng.uniform(*LENGTH), 4),
                body_expansion=ALUMINIUM,
                spool_expansion=ALUMINIUM if rng.random() < 0.5 else STEEL,
            )
        unworn = rng.random() < UNWORN
        wear = rng.exponential(mean_wear)
        pairs.append(
            Pair(
                land,
                spool=land.nominal_diameter + rng.normal(0.0, 2e-6),
                mounting=rng.uniform(*NEW),
                wear=0.0 if new_unit or unworn else min(wear, WORN_OUT),
                one_sided=one_sided,
                exponent=exponent,
                side=rng.uniform(0.0, 2.0 * math.pi),
                length=land.contact_length + rng.normal(0.0, DEFAULTS.contact_length),
                forms=random_forms(rng, DEFAULTS.unseen_ovality),
            )
        )
    return tuple(pairs)


def _in_file(rng: np.random.Generator, pair: Pair, known: Known) -> Land:
    """Return the land as the valve body's file describes it."""
    error = rng.normal()
    if known is Known.PAIR:
        return replace(pair.land, mounting_clearance=pair.mounting + DEFAULTS.mounting_clearance * error)
    if known is Known.TYPE:
        middle = pair.mounting + TOLERANCE / 1.96 * error
        return replace(pair.land, mounting_clearance=middle, mounting_tolerance=TOLERANCE, new_origin=NewOrigin.TYPE)
    return replace(pair.land, mounting_clearance=NEW, new_origin=NewOrigin.RANGE)
