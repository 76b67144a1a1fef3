"""Units of twelve lands of the source study's valve body, in worlds that are as the assessment assumes, or not."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid, load_fluid
from atleak.catalogue.instruments import Instrument, Instruments, load_instrument
from atleak.catalogue.limits import LimitOrigin, Limits, Steps, load_limits
from atleak.common.verdicts import Band, Verdict
from atleak.diagnosis.rules import unit_rules
from atleak.diagnosis.uncertainty import DEFAULTS, UnitUncertainty, assess
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import UNKNOWN, WORKSHOP
from atleak.engine.projection import project, project_unworn
from atleak.measurements.clearances import clearances
from simulated.flows import Circumstances, TrueFlows, true_flows
from simulated.gauges import Reader
from simulated.pairs import Pair, random_forms, sides_as_assumed

SEED = 20231122
LANDS = 12
SPOOL_INSTRUMENTS = ("workshop_microscope", "micrometer", "air_gauge")
SLEEVE_INSTRUMENTS = ("bore_gauge", "air_gauge")
WEAR = 0.15  # mean of the exponential distribution of true wear
CLEARANCE_LIMIT = 1.25  # times the mounting clearance: the limit of the rule on the clearance itself
SHARE_LIMIT = 0.005
TOTAL_LIMIT = 0.031


@dataclass(frozen=True)
class World:
    """How the simulated world differs from what the assessment assumes."""

    name: str
    heavy_tails: bool = False  # every error of an instrument Student t with 3 degrees of freedom, same spread
    common: float = 1.0  # times the declared common error
    calibration: float = 1.0  # times the declared own calibration error
    directions: tuple[float, ...] = (0.0, 90.0)
    ovality: float = 4e-6  # [m] root mean square of the sleeves' difference of diameters
    room_temperature: float = 0.5  # [K] half width of its range
    one_sided: float | None = 0.0  # fraction of every land's wear that is on one side; None: each land its own
    exponent: int = 1  # n of its shape, max(cos θ, 0)^n
    mixed: bool = False  # fraction and exponent of each unit drawn as the assessment has them
    spools_anywhere: bool = False  # e/c of each component's spool anywhere from 0 to 1, and assessed as unknown


AS_DECLARED = World("as declared")
HALF = World("wear to one side: half of it", one_sided=0.5)
ONE_SIDED = tuple(
    World(f"wear to one side: all of it, {name}", one_sided=1.0, exponent=exponent)
    for exponent, name in enumerate(("cos", "cos²", "cos³"), 1)
)
MIXED = World("wear to one side: as assumed", mixed=True)
FOUR = 0.0, 45.0, 90.0, 135.0
ANYWHERE = World("spools lie anywhere, assessed as unknown", spools_anywhere=True)
WRONG = (
    World("four directions, wear as assumed", directions=FOUR, mixed=True),
    World("four directions, cos³", directions=FOUR, one_sided=1.0, exponent=3),
    World("four directions, each land worn to one side by a part of its own", directions=FOUR, one_sided=None),
    World("heavy tails", heavy_tails=True),
    World("common error twice as declared", common=2.0),
    World("all calibration twice as declared", common=2.0, calibration=2.0),
    World("one direction, ovality as assumed", directions=(0.0,)),
    World("one direction, all wear to one side", directions=(0.0,), one_sided=1.0),
    World("one direction, ovality three times as assumed", directions=(0.0,), ovality=12e-6),
    World("room within 5 K instead of 0.5 K", room_temperature=5.0),
    World("each land worn to one side by a part of its own", one_sided=None),
    World("ovality three times as assumed", ovality=12e-6),
)
AS_ASSUMED = (AS_DECLARED, HALF, *ONE_SIDED, MIXED, ANYWHERE)  # nobody knows how much is worn to one side, and how
WORLDS = (*AS_ASSUMED, *WRONG)


@dataclass(frozen=True)
class Simulated:
    """One unit: its truth, and what atleak says of its measuring sheet."""

    pairs: tuple[Pair, ...]
    true: TrueFlows
    assessed: UnitUncertainty
    repeats: int


@cache
def _catalogue_entries() -> tuple[Controller, Fluid, Limits]:
    whole = load_controller("four_speed_2023")
    point = whole.operating_points[0]
    leaking = {gap.key for gap in whole.gaps_in(point.gear)}
    chosen = [land for land in whole.lands if land.key in leaking][:LANDS]
    lands = tuple(
        replace(
            land,
            planes=(f"{land.land}a", f"{land.land}b") if number % 2 else (f"{land.land}a",),
            clearance_limit=CLEARANCE_LIMIT * land.mounting_clearance,
        )
        for number, land in enumerate(chosen)
    )
    keys = {land.key for land in lands}
    controller = replace(
        whole,
        lands=lands,
        gaps=tuple(gap for gap in whole.gaps if gap.key in keys),
        operating_points=(point,),
    )
    limits = load_limits("project_default")
    own = (LimitOrigin.PROJECT, "benchmark")
    limits = replace(
        limits,
        wear=Steps(((Verdict.WATCH, 0.1), (Verdict.REPLACE, 0.5)), *own),
        pair_share=Steps(((Verdict.WATCH, SHARE_LIMIT),), *own),
        total_share=Steps(((Band.AMBER, TOTAL_LIMIT), (Band.RED, 2 * TOTAL_LIMIT), (Band.CRITICAL, 0.5)), *own),
    )
    return controller, load_fluid("hipol_atf_iid"), limits


@cache
def _instrument(name: str) -> Instrument:
    return load_instrument(name)


def simulate(world: World, unit: int, draws: int) -> Simulated:
    """Simulate one unit of a world and assess its measuring sheet like any other."""
    rng = np.random.default_rng((SEED, WORLDS.index(world), unit))
    controller, fluid, limits = _catalogue_entries()
    instruments = Instruments(
        _instrument(SPOOL_INSTRUMENTS[rng.integers(len(SPOOL_INSTRUMENTS))]),
        _instrument(SLEEVE_INSTRUMENTS[rng.integers(len(SLEEVE_INSTRUMENTS))]),
    )
    reader = Reader(
        instruments,
        int(rng.integers(1, 4)),
        directions=world.directions,
        heavy_tails=world.heavy_tails,
        common=world.common,
        calibration=world.calibration,
        room_temperature=world.room_temperature,
    )
    pairs = _pairs(rng, world, controller)
    sheet = reader.read(rng, pairs)
    states = clearances(sheet, controller)
    profile = replace(WORKSHOP, eccentricity=UNKNOWN) if world.spools_anywhere else WORKSHOP
    model = LeakageModel(controller, states, fluid, profile)
    projections = [project(model, point) for point in controller.operating_points]
    when_new = project_unworn(states, model, projections)
    assessed = assess(
        model,
        states,
        projections,
        unit_rules(states, projections, when_new, limits),
        readings=sheet,
        instruments=instruments,
        draws=draws,
        seed=unit,
    )
    true = true_flows(pairs, controller, fluid, controller.operating_points[0], Circumstances.draw(rng), DEFAULTS)
    return Simulated(pairs, true, assessed, reader.repeats)


def _pairs(rng: np.random.Generator, world: World, controller: Controller) -> tuple[Pair, ...]:
    u = DEFAULTS
    eccentricity = dict.fromkeys((land.component for land in controller.lands), 0.0)
    if world.spools_anywhere:
        eccentricity = {component: rng.uniform() for component in eccentricity}
    one_sided, exponent = sides_as_assumed(rng) if world.mixed else (world.one_sided, world.exponent)
    pairs = []
    for land in controller.lands:
        mounting = land.mounting_clearance + rng.normal(0.0, u.mounting_clearance)
        pairs.append(
            Pair(
                land,
                spool=land.nominal_diameter + rng.normal(0.0, 2e-6),
                mounting=mounting,
                wear=mounting * rng.exponential(WEAR),
                one_sided=rng.uniform() if one_sided is None else one_sided,
                exponent=exponent,
                side=rng.uniform(0.0, 2.0 * math.pi),
                length=land.contact_length + rng.normal(0.0, u.contact_length),
                forms=random_forms(rng, world.ovality),
                eccentricity=eccentricity[land.component],
                lies=rng.uniform(0.0, 2.0 * math.pi),
            )
        )
    return tuple(pairs)
