"""Run the eight variants W1-W8 of the source study, for its controller and test or for any other, and compare.

Dziubak T., Szczepaniak P., Energies 2023, 16(22), 7667, doi 10.3390/en16227667. A variant is a temperature, a wear of
every land and a fluid; wear scales the cold clearance, growth by heat is added afterwards, unscaled, as in the printed
results. ``computed`` takes the viscosity that the printed results follow from, ``as_tabulated`` the one that the
article's Table 2 prints; they differ in W3 and W4. ``docs/source-study.md`` shows the arithmetic of every erratum.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid, ViscosityModel, load_fluid
from atleak.common.errors import Message
from atleak.common.files import shipped
from atleak.common.units import DM3_MIN
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import PAPER, WORKSHOP, Profile
from atleak.engine.projection import with_wear
from atleak.engine.road_leakage import RoadLeakage, evaluate_road_test
from atleak.measurements.clearances import LandClearance, clearances
from atleak.measurements.road_test import Channel, RoadTest

FRESH_FLUID = "hipol_atf_iid"
USED_FLUID = "hipol_atf_iid_used"
_USED_VISCOSITY = 8.40e-6  # [m²/s] at 80 °C after 106 315 km
_USED_OIL_NOTE = (
    "Table 2 prints {printed} mm²/s, but the printed leakage follows from 8.40 mm²/s, the used oil of W2: with "
    "{printed} the study's controller gives {q} dm³/min. Computed here with 8.40, as tabulated with {printed}."
)
#: label → options set on top of ``paper``; the last two set everything
OPTION_STEPS: tuple[tuple[str, dict[str, object]], ...] = (
    ("paper: as the article computes", {}),
    ("mean diameter in the gap law", {"diameter": "mean"}),
    ("ASTM D341 viscosity", {"viscosity": "d341"}),
    ("only what ends in the sump", {"pump_draw": "into_sump"}),
    ("pump slip instead of a constant efficiency", {"pump_efficiency": "wilson"}),
    ("entry loss", {"entry_loss": "on"}),
)


@dataclass(frozen=True)
class Variant:
    """One row of the article's Tables 2 and 3.

    Printed results are kept with their decimals, so that a comparison knows the printed precision.
    """

    name: str
    temperature: float  # [°C]
    wear: float  # of every land, as a fraction
    kinematic_viscosity: float  # [m²/s] as Table 2 prints it
    density: float  # [kg/m³]
    printed_max_leakage: Decimal  # [dm³/min]
    printed_max_share: Decimal  # [%]
    used_oil: bool = False  # whether the printed results follow from the used oil's viscosity
    note: str = ""

    @property
    def viscosity_of_results(self) -> float:
        """Return the viscosity [m²/s] that the printed results follow from."""
        return _USED_VISCOSITY if self.used_oil else self.kinematic_viscosity

    @property
    def misprinted_viscosity(self) -> bool:
        """Return whether Table 2 prints another viscosity than the results follow from."""
        return self.viscosity_of_results != self.kinematic_viscosity


def _variant(name: str, temperature: float, wear: float, nu: float, rho: float, q: str, u: str, **more: Any) -> Variant:
    return Variant(name, temperature, wear, nu * 1e-6, rho * 1e3, Decimal(q), Decimal(u), **more)


VARIANTS: tuple[Variant, ...] = (
    _variant("W1", 80.0, 0.0, 10.93, 0.783, "2.16", "8.89"),
    _variant("W2", 80.0, 0.0, 8.40, 0.783, "2.81", "11.6", used_oil=True),
    _variant(
        "W3", 80.0, 0.1, 10.93, 0.783, "3.64", "14.9", used_oil=True,
        note=_USED_OIL_NOTE.format(printed="10.93", q="2.80"),
    ),
    _variant(
        "W4", 80.0, 0.5, 10.93, 0.783, "8.56", "35.2", used_oil=True,
        note=_USED_OIL_NOTE.format(printed="10.93", q="6.58"),
    ),
    _variant(
        "W5", -40.0, 0.5, 1923.0, 0.870, "0.021", "0.086",
        note="1923 mm²/s is what the article's regression gives; ASTM D341 through the data sheet's points gives "
        "35 155 and a real Dexron IID has some 38 000. That hardly anything leaks in the cold stands either way.",
    ),
    _variant("W6", 20.0, 0.5, 145.0, 0.826, "0.38", "1.56"),
    _variant("W7", 40.0, 0.5, 42.0, 0.812, "1.43", "5.89", note="The article's text prints 1.41, its Table 3 1.43."),
    _variant(
        "W8", 100.0, 0.5, 7.0, 0.768, "11.23", "56.2",
        note="The printed share is not reproducible: 11.23 dm³/min are 56.2 % of 19.98 dm³/min, but the shares of W1 "
        "to W7 follow from 24.31 to 24.37 dm³/min at the same instant, of which 11.23 are 46.1 to 46.2 %.",
    ),
)  # fmt: skip


def reaches_digits(printed: Decimal, value: float) -> bool:
    """Return whether a value rounds to every printed digit.

    >>> reaches_digits(Decimal("8.56"), 8.5577), reaches_digits(Decimal("8.56"), 8.5549)
    (True, False)
    """
    return abs(value - float(printed)) <= 0.5 * 10.0 ** int(printed.as_tuple().exponent)


@dataclass(frozen=True)
class VariantResult:
    """One variant computed twice: with the viscosity its printed results follow from, and with that of Table 2."""

    variant: Variant
    profile: Profile
    time: np.ndarray  # [s]
    kinematic_viscosity: float  # [m²/s] used in ``computed``
    density: float  # [kg/m³]
    computed: RoadLeakage  # without its sections
    as_tabulated: RoadLeakage  # the same object where Table 2's viscosity is the one used
    messages: tuple[Message, ...]


def run_variants(controller: Controller, road_test: RoadTest, *, profile: Profile = PAPER) -> tuple[VariantResult, ...]:
    """Run W1-W8 for a controller and a road test.

    Parameters
    ----------
    road_test
        main pressure is needed; converter pressure and gear are taken from the controller's first operating point
        where the log has none, and a message says so. The log's temperature is not used: a variant has its own.
    profile
        the options of the engine. With ``viscosity = "tabulated"``, as the ``paper`` profile has it, viscosity and
        density are the variant's own; else those of the study's fluid, fresh or used, by that model.

    Returns
    -------
    tuple of VariantResult
        in the article's order. A variant whose temperature the profile's viscosity model does not cover is left out.

    Raises
    ------
    RoadTestError
        a log without main pressure, or without a usable sample.
    """
    log = _StudyLog.of(controller, road_test)
    results = []
    for variant in VARIANTS:
        fluid = variant_fluid(variant)
        computed = log.run(variant, fluid, profile)
        if computed is None:
            continue
        tabulated: RoadLeakage | None = computed
        if variant.misprinted_viscosity:
            tabulated = log.run(variant, variant_fluid(variant, as_tabulated=True), profile)
        assert tabulated is not None  # the table has a row for every variant
        results.append(
            VariantResult(
                variant=variant,
                profile=profile,
                time=road_test.time,
                kinematic_viscosity=variant.viscosity_of_results
                if profile.viscosity == "tabulated"
                else fluid.kinematic_viscosity(variant.temperature, profile.viscosity),
                density=fluid.density(variant.temperature, profile.viscosity),
                computed=computed,
                as_tabulated=tabulated,
                messages=log.messages,
            )
        )
    return tuple(results)


def variant_fluid(variant: Variant, *, as_tabulated: bool = False) -> Fluid:
    """Return a variant's fluid: Table 2 with the variant's own row, and the data sheet of the fresh or used oil."""
    used = variant.used_oil and not (as_tabulated and variant.misprinted_viscosity)
    viscosity = variant.kinematic_viscosity if as_tabulated else variant.viscosity_of_results
    fresh = load_fluid(FRESH_FLUID)
    rows = {row[0]: row for row in fresh.table}
    rows[variant.temperature] = (variant.temperature, viscosity, variant.density)
    fluid = load_fluid(USED_FLUID) if used else fresh
    return replace(fluid, table=tuple(rows[temperature] for temperature in sorted(rows)))


def variant_road_test(road_test: RoadTest, temperature: float) -> RoadTest:
    """Return the same road test at one ATF temperature [°C]."""
    return _with_constants(road_test, {"atf_temperature": temperature})


def gear_at_most_leakage(run: RoadLeakage) -> int:
    """Return the gear in which a variant leaks most."""
    gear = run.road_test.values("gear")
    assert gear is not None  # logged or assumed
    return int(gear[int(np.nanargmax(run.leakage))])


def sample_log() -> Path:
    """Return the shipped minimum-acceleration test.

    Raises
    ------
    InputError
        where the installation lacks it.
    """
    return shipped("sample_data/minimum_acceleration_test.csv")


def _covers(fluid: Fluid, temperature: float, model: ViscosityModel) -> bool:
    low, high = fluid.span(model)
    return low <= temperature <= high


def _with_constants(road_test: RoadTest, constants: Mapping[str, float]) -> RoadTest:
    """Return the same road test with some quantities [SI] held constant."""
    channels = dict(road_test.channels)
    for quantity, value in constants.items():
        channels[quantity] = Channel(
            quantity, time=road_test.time[:1], values=np.array([value]), suspect=np.array([False]), source="constant"
        )
    return replace(road_test, channels=MappingProxyType(channels), _held={})


@dataclass(frozen=True)
class _StudyLog:
    """The road test that every variant runs over, with constants for what the log does not hold."""

    controller: Controller
    states: tuple[LandClearance, ...]  # that count as 0 % wear
    road_test: RoadTest
    messages: tuple[Message, ...]

    @classmethod
    def of(cls, controller: Controller, road_test: RoadTest) -> _StudyLog:
        """Check a log by running W1 over it as any job is run: an unusable log is refused, assumptions are reported."""
        states, assumed, first = clearances(None, controller), controller.operating_points[0], VARIANTS[0]
        model = LeakageModel(controller, states, variant_fluid(first), PAPER)
        messages = evaluate_road_test(model, variant_road_test(road_test, first.temperature), assumed).messages
        constants = {"converter_pressure": assumed.converter_pressure, "gear": float(assumed.gear)}
        missing = {name: value for name, value in constants.items() if road_test.values(name) is None}
        return cls(controller, states, _with_constants(road_test, missing), messages)

    def model(self, wear: float, fluid: Fluid, profile: Profile) -> LeakageModel:
        return LeakageModel(self.controller, with_wear(self.states, wear), fluid, profile)

    def run(self, variant: Variant, fluid: Fluid, profile: Profile) -> RoadLeakage | None:
        """Return a variant over the log; None where the viscosity's model does not cover its temperature."""
        if not _covers(fluid, variant.temperature, profile.viscosity):
            return None
        test, assumed = variant_road_test(self.road_test, variant.temperature), self.controller.operating_points[0]
        run = evaluate_road_test(self.model(variant.wear, fluid, profile), test, assumed)
        return replace(run, sections={})  # not needed, and those of ten runs over a long log take much memory


# --- what the better physics is worth ---------------------------------------------------------------------------


@dataclass(frozen=True)
class OptionRow:
    """All variants with one set of options; None where the viscosity model does not cover a variant's temperature."""

    label: str
    profile: Profile
    runs: Mapping[str, RoadLeakage | None]  # by variant


def compare_options(controller: Controller, road_test: RoadTest) -> tuple[OptionRow, ...]:
    """Compute W1-W8 with ``paper``, with one option at a time, and with ``workshop`` without entry loss and with it."""
    profiles = [(label, PAPER.with_options(**options)) for label, options in OPTION_STEPS]
    profiles.append(("workshop: the four above without entry loss", WORKSHOP.with_options(entry_loss="off")))
    profiles.append(("workshop with entry loss", WORKSHOP.with_options(entry_loss="on")))
    log = _StudyLog.of(controller, road_test)
    return tuple(
        OptionRow(label, profile, {each.name: log.run(each, variant_fluid(each), profile) for each in VARIANTS})
        for label, profile in profiles
    )


@dataclass(frozen=True)
class StatedPoint:
    """A point of the minimum-acceleration test that the article's text states.

    ``time`` is None where the text names no instant. ``inferred`` points are not printed but follow from Table 3.
    """

    key: str
    quantity: str
    variant: str | None  # None: the pump, which all variants share
    time: float | None  # [s]
    printed: Decimal  # [dm³/min]
    inferred: bool = False


STATED_POINTS: tuple[StatedPoint, ...] = (
    StatedPoint("W4-start", "leakage", "W4", 0.0, Decimal("6.37")),
    StatedPoint("W4-before-shift", "leakage", "W4", 0.8, Decimal("6.22")),
    StatedPoint("W4-least", "least leakage", "W4", None, Decimal("5.09")),
    StatedPoint("W4-after-rise", "leakage after the rapid rise", "W4", None, Decimal("8.46")),
    StatedPoint("W4-most", "most leakage", "W4", 2.1, Decimal("8.56")),
    StatedPoint("W8-least", "least leakage", "W8", None, Decimal("6.67")),
    StatedPoint("W8-most", "most leakage", "W8", 2.1, Decimal("11.23")),
    StatedPoint("pump-at-most-leakage", "pump capacity", None, 2.1, Decimal("24.34"), inferred=True),
    StatedPoint("pump-most", "largest pump capacity", None, None, Decimal("33.6")),
)


@dataclass(frozen=True)
class ComparedPoint:
    """A stated point beside the value that a road test gives."""

    point: StatedPoint
    time: float  # [s] of the computed value
    computed: float  # [dm³/min]

    @property
    def deviation(self) -> float:
        """Return the deviation relative to the printed value."""
        return self.computed / float(self.point.printed) - 1.0


def compare_points(results: Sequence[VariantResult]) -> tuple[ComparedPoint, ...]:
    """Return the stated points beside the results of the shipped test; the pump's only where engine speed was logged.

    The end of the rapid rise is the first sample after the least leakage at which it stops growing.
    """
    by_name = {result.variant.name: result for result in results}
    compared = []
    for point in STATED_POINTS:
        result = by_name[point.variant or "W4"]
        values = result.computed.leakage if point.variant else result.computed.pump_capacity
        if values is None:
            continue
        index = _index(point, result.time, values)
        compared.append(ComparedPoint(point, float(result.time[index]), float(values[index]) * DM3_MIN))
    return tuple(compared)


def _index(point: StatedPoint, time: np.ndarray, values: np.ndarray) -> int:
    if point.quantity == "least leakage":
        return int(np.nanargmin(values))
    if point.quantity in {"most leakage", "largest pump capacity"}:
        return int(np.nanargmax(values))
    if point.time is not None:
        return int(np.argmin(np.abs(time - point.time)))
    least = int(np.nanargmin(values))
    falling = np.flatnonzero(np.diff(values[least:]) <= 0.0)
    return least + int(falling[0]) if falling.size else len(values) - 1
