"""Count how often a sheet is said to have moved as a whole, on simulated units that did and that did not.

    python benchmarks/common_shift.py [--small]

Units are new (with the common error that a certificate allows), worn in several ways, or read with a gauge that is
off by 3 or 5 µm in the clearance. Their sheets are read with the catalogue's instruments: two directions, two repeats.
Exits with 1 where a stated rate is not met.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from simulated.gauges import Reader
from simulated.pairs import Pair, random_forms
from timing import options

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.instruments import load_instruments
from atleak.diagnosis.messages import common_shift
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.diagnosis.uncertainty.sources import find_sources
from atleak.measurements.clearances import clearances

OPTIONS = options(__doc__)
OPTIONS.add_argument("--units", type=int, default=400, help="units of each kind")
SEED = 20231122
INSTRUMENTS = (("workshop_microscope", "bore_gauge"), ("micrometer", "bore_gauge"), ("air_gauge", "air_gauge"))
MOST_FALSE, LEAST_FOUND = 0.03, 0.3  # of the units of each kind that did not move, and of those that did
Wear = Callable[[np.random.Generator, np.ndarray], np.ndarray]  # mounting clearances → what wear adds [m]


@dataclass(frozen=True)
class Kind:
    """A kind of unit: how its pairs are worn, and by how much its gauge is off in the clearance [m]."""

    name: str
    wear: Wear
    offset: float = 0.0
    tolerance: float | None = None  # [m] of the mounting clearances of its type, holding 95 %
    stated: bool = True  # whether a rate is stated: pairs that all grew by one fraction may be taken for moved


def _none(rng: np.random.Generator, new: np.ndarray) -> np.ndarray:
    return 0.0 * new


def _alike(part: float) -> Wear:
    return lambda rng, new: part * new


def _spread(mean: float) -> Wear:
    return lambda rng, new: rng.exponential(mean, len(new)) * new


def _some(part: float, mean: float) -> Wear:
    """Wear some of the pairs."""
    return lambda rng, new: (rng.random(len(new)) < part) * rng.exponential(mean, len(new)) * new


KINDS = (
    Kind("new", _none),
    Kind("new, type's tolerance 2 µm", _none, tolerance=2e-6),
    Kind("all grown by 10 %", _alike(0.10), stated=False),
    Kind("all grown by 25 %", _alike(0.25), stated=False),
    Kind("worn by 8 % in the mean", _spread(0.08)),
    Kind("worn by 15 % in the mean", _spread(0.15)),
    Kind("worn by 40 % in the mean", _spread(0.40)),
    Kind("a third worn by 30 %", _some(0.33, 0.30)),
    Kind("new, +3 µm", _none, 3e-6),
    Kind("new, −3 µm", _none, -3e-6),
    Kind("new, +5 µm", _none, 5e-6),
    Kind("a tenth worn by 30 %, +3 µm", _some(0.10, 0.30), 3e-6),
)


def main() -> int:
    given = OPTIONS.parse_args()
    units = 12 if given.small else given.units
    wrong = 0
    for controller in (load_controller("four_speed_2023"), load_controller("minimal_example")):
        print(f"{controller.id}: % of {units} sheets said to have moved as a whole, and the mean of what they say [µm]")
        for number, kind in enumerate(KINDS):
            found = [_shift_of(controller, kind, np.random.default_rng((SEED, number, unit))) for unit in range(units)]
            said = [shift for shift in found if shift is not None]
            rate, mean = len(said) / units, 1e6 * float(np.mean(said)) if said else float("nan")
            kept = not kind.stated or (rate >= LEAST_FOUND if kind.offset else rate <= MOST_FALSE)
            wrong += not kept and not given.small
            print(f"  {kind.name:32} {100.0 * rate:6.2f} %  {mean:6.2f}{'' if kept else '   not as stated'}")
    return int(wrong > 0)


def _shift_of(controller: Controller, kind: Kind, rng: np.random.Generator) -> float | None:
    tools = load_instruments(*INSTRUMENTS[rng.integers(len(INSTRUMENTS))])
    lands = tuple(replace(land, mounting_tolerance=kind.tolerance) for land in controller.lands)
    known = replace(controller, lands=lands)
    sheet = Reader(tools, repeats=2).read(rng, _pairs(known, kind, rng))
    sources, _ = find_sources(clearances(sheet, known), sheet, known, tools, DEFAULTS)
    found = common_shift(sources)
    return None if found is None else found.shift


def _pairs(controller: Controller, kind: Kind, rng: np.random.Generator) -> list[Pair]:
    new = np.array([land.new_clearance for land in controller.lands])
    spread = DEFAULTS.mounting_clearance if kind.tolerance is None else kind.tolerance / 1.96
    mounting = new + rng.normal(0.0, spread, len(new)) + kind.offset
    one_sided = rng.uniform()
    return [
        Pair(
            land,
            spool=land.nominal_diameter + rng.normal(0.0, 2e-6),
            mounting=own,
            wear=worn,
            one_sided=one_sided,
            side=rng.uniform(0.0, 2.0 * math.pi),
            length=land.contact_length,
            forms=random_forms(rng, DEFAULTS.unseen_ovality),
        )
        for land, own, worn in zip(controller.lands, mounting, kind.wear(rng, new), strict=True)
    ]


if __name__ == "__main__":
    sys.exit(main())
