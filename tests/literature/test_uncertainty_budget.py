"""The linear budget against GTC, an independent implementation of the GUM; gap law and fluid written out anew."""

from __future__ import annotations

import math
from dataclasses import replace

import GTC
import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.instruments import Instrument, Instruments
from atleak.catalogue.limits import Limits
from atleak.diagnosis.rules import unit_rules
from atleak.diagnosis.uncertainty import Assumptions, UnitUncertainty, assess
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import project, project_unworn
from atleak.measurements.clearances import clearances
from atleak.measurements.readings import Reading, Readings

UM = 1e-6
ASSUMED = Assumptions(
    room_temperature=0.5,
    contact_length=0.05e-3,
    viscosity=0.03,
    temperature=1.5,
    main_pressure=0.01,
    slip_coefficient=0.1,
    form_residual=0.0,
    one_sided_wear=0.0,
)


def _instrument(name: str, calibration: float, common_part: float, expansion: float) -> Instrument:
    tool = Instrument(
        name, name, "test", "2026-01-01", "", ("spool", "sleeve"), 1e-9, calibration, common_part, 0.4 * UM, True, ()
    )
    return replace(tool, expansion=expansion)


TOOLS = Instruments(_instrument("outside", 0.6 * UM, 0.3, 8e-6), _instrument("inside", 0.9 * UM, 0.6, 11.5e-6))


@pytest.fixture(scope="module")
def two_lands(four_speed: Controller) -> Controller:
    """Two lands that leak from main pressure to a tenth of it."""
    gap = next(g for g in four_speed.gaps_in(2) if str(g.high) == "p_g" and str(g.low) == "0.1*p_g")
    land = four_speed.land(*gap.key)
    lands = (
        replace(land, component="a", land=1, planes=("1",), clearance_limit=None),
        replace(land, component="b", land=1, planes=("1",), clearance_limit=None, contact_length=0.006),
    )
    return replace(
        four_speed,
        lands=lands,
        gaps=tuple(replace(gap, component=name, land=1) for name in ("a", "b")),
        operating_points=four_speed.operating_points[:1],
    )


CLEARANCES = {"a": 30 * UM, "b": 42 * UM}


@pytest.fixture(scope="module")
def assessed(two_lands: Controller, hipol: Fluid, limits: Limits) -> UnitUncertainty:
    readings = []
    for land in two_lands.lands:
        # neither step nor repeats: a single setting in each of two directions
        spool = land.nominal_diameter + 0.1234 * UM
        for part, diameter in (("spool", spool), ("sleeve", spool + 2.0 * CLEARANCES[land.component])):
            readings += [Reading(land.component, part, "1", angle, 1, diameter) for angle in (0.0, 90.0)]
    sheet = Readings("x", "", None, "mm", False, "tidy", tuple(readings))
    states = clearances(sheet, two_lands)
    model = LeakageModel(two_lands, states, hipol, WORKSHOP)
    projections = [project(model, point) for point in two_lands.operating_points]
    return assess(
        model,
        states,
        projections,
        unit_rules(states, projections, project_unworn(states, model, projections), limits),
        readings=sheet,
        instruments=TOOLS,
        assumptions=ASSUMED,
        draws=100_000,
    )


def _referee(controller: Controller, hipol: Fluid) -> tuple[dict[str, object], dict[str, object], dict[str, object]]:
    """Clearances, shares and elementary inputs as GTC's uncertain numbers."""
    point, pump = controller.operating_points[0], controller.pump
    c_s, p_g = pump.slip_coefficient, point.main_pressure
    elementary = {
        "outside": GTC.ureal(0.0, TOOLS.spool.common, label="spool: common calibration"),
        "inside": GTC.ureal(0.0, TOOLS.sleeve.common, label="sleeve: common calibration"),
        "room": GTC.ureal(0.0, ASSUMED.room_temperature / math.sqrt(3.0), label="measuring temperature"),
        "viscosity": GTC.ureal(1.0, ASSUMED.viscosity, label="viscosity"),
        "temperature": GTC.ureal(point.temperature, ASSUMED.temperature, label="temperature"),
        "main": GTC.ureal(p_g, ASSUMED.main_pressure * p_g, label="main pressure"),
        "slip": GTC.ureal(c_s, ASSUMED.slip_coefficient * c_s, label="pump efficiency"),
    }
    (t_1, nu_1), (t_2, nu_2) = hipol.points[0], hipol.points[-1]
    w_1, w_2 = (math.log10(math.log10(nu * 1e6 + 0.7)) for nu in (nu_1, nu_2))
    slope = (w_1 - w_2) / (math.log10(t_2 + 273.15) - math.log10(t_1 + 273.15))
    t = elementary["temperature"]
    w = w_1 - slope * (GTC.log10(t + 273.15) - math.log10(t_1 + 273.15))
    nu = (10 ** (10**w) - 0.7) * 1e-6 * elementary["viscosity"]
    at, density = hipol.density_at
    rho = density + hipol.density_slope * (t - at)
    mu = nu * rho
    capacity = pump.displacement * (point.engine_speed - elementary["slip"] * elementary["main"] / (2 * math.pi * mu))
    cold, share = {}, {}
    repeat = math.sqrt((0.4 * UM) ** 2 + (1e-9) ** 2 / 12)
    for land in controller.lands:
        name = land.component
        d_0 = land.nominal_diameter + 0.1234 * UM
        own = {
            part: GTC.ureal(0.0, tool.calibration * math.sqrt(1 - tool.common_part), label=f"{part}: calibration")
            for part, tool in (("spool", TOOLS.spool), ("sleeve", TOOLS.sleeve))
        }
        repeats = {
            part: GTC.ureal(0.0, repeat / math.sqrt(2.0), label=f"{part}: repeats") for part in ("spool", "sleeve")
        }
        spool = d_0 + own["spool"] + repeats["spool"] + elementary["outside"]
        sleeve = d_0 + 2 * CLEARANCES[name] + own["sleeve"] + repeats["sleeve"] + elementary["inside"]
        big_d = d_0 + 2 * CLEARANCES[name]
        rate = 0.5 * (land.body_expansion * big_d - land.spool_expansion * d_0)
        gauges = 0.5 * (TOOLS.sleeve.expansion * big_d - TOOLS.spool.expansion * d_0)  # they expand with the parts
        cold[name] = 0.5 * (sleeve - spool) + (rate - gauges) * elementary["room"]
        hot = cold[name] + rate * (t - 20.0)
        length = GTC.ureal(land.contact_length, ASSUMED.contact_length, label="contact length")
        drop, viscous = 0.9 * elementary["main"], 12 * mu * length
        with_loss = GTC.sqrt(viscous**2 + 2 * 1.5 * rho * drop * hot**4)
        flow = 2 * math.pi * (d_0 + hot) * hot**3 * drop / (viscous + with_loss)
        share[name] = flow / capacity
        elementary |= {f"{name} {part} own": u for part, u in own.items()}
        elementary |= {f"{name} {part} repeats": u for part, u in repeats.items()}
        elementary[f"{name} length"] = length
    return cold, share, elementary


def test_clearance_and_its_budget(assessed: UnitUncertainty, two_lands: Controller, hipol: Fluid) -> None:
    cold, _, elementary = _referee(two_lands, hipol)
    for land in assessed.lands:
        clearance = cold[land.key[0]]
        assert land.sources.state.radial_clearance == pytest.approx(GTC.value(clearance), rel=1e-9, abs=0.0)
        assert land.u_clearance == pytest.approx(GTC.uncertainty(clearance), rel=1e-9, abs=0.0)
        expected = {
            source.label: (GTC.component(clearance, source) / GTC.uncertainty(clearance)) ** 2
            for source in elementary.values()
        }
        for label, fraction in land.budget:
            if label.endswith("resolution"):
                assert fraction < 1e-9
                continue
            referee = max(
                (GTC.component(clearance, s) / GTC.uncertainty(clearance)) ** 2
                for s in elementary.values()
                if s.label == label
            )
            assert fraction == pytest.approx(referee, rel=1e-6, abs=0.0)
        assert sum(fraction for _, fraction in land.budget) == pytest.approx(1.0, rel=1e-12, abs=0.0)
        assert set(expected) >= {label for label, _ in land.budget if not label.endswith("resolution")}


def test_share_and_its_budget(assessed: UnitUncertainty, two_lands: Controller, hipol: Fluid) -> None:
    _, share, elementary = _referee(two_lands, hipol)
    for land in assessed.lands:
        land_share, stated = share[land.key[0]], land.conditions[0]
        assert stated.share == pytest.approx(GTC.value(land_share), rel=1e-9, abs=0.0)
        # draws see the cube's curvature and scatter themselves, the linear sum does neither
        assert stated.u_share == pytest.approx(GTC.uncertainty(land_share), rel=0.03, abs=0.0)
        for label, fraction in stated.budget:
            same = [GTC.component(land_share, s) for s in elementary.values() if s.label == label]
            referee = max((part**2 / GTC.uncertainty(land_share) ** 2 for part in same), default=0.0)
            assert fraction == pytest.approx(referee, rel=1e-4, abs=1e-9), label


def test_total_and_its_budget(assessed: UnitUncertainty, two_lands: Controller, hipol: Fluid) -> None:
    _, share, elementary = _referee(two_lands, hipol)
    total_share, total = share["a"] + share["b"], assessed.totals[0]
    assert total.share == pytest.approx(GTC.value(total_share), rel=1e-9, abs=0.0)
    assert total.u_share == pytest.approx(GTC.uncertainty(total_share), rel=0.03, abs=0.0)
    variance = GTC.uncertainty(total_share) ** 2
    expected = {
        name: GTC.component(total_share, elementary[source]) ** 2 / variance
        for name, source in (
            ("viscosity", "viscosity"),
            ("temperature", "temperature"),
            ("main pressure", "main"),
            ("pump efficiency", "slip"),
            ("common to all lands: spool instrument", "outside"),
            ("common to all lands: sleeve instrument", "inside"),
            ("common to all lands: measuring temperature", "room"),
        )
    }
    own = [GTC.component(total_share, u) ** 2 for name, u in elementary.items() if name[:2] in {"a ", "b "}]
    expected["each land's own readings and contact length"] = math.fsum(own) / variance
    budget = dict(total.budget)
    for name, fraction in expected.items():
        assert budget[name] == pytest.approx(fraction, rel=1e-4, abs=1e-9), name
    assert math.fsum(expected.values()) == pytest.approx(1.0, rel=1e-9, abs=0.0)
    assert not set(budget) - set(expected)


def test_linear_interval_is_wrong_where_the_cube_bends(two_lands: Controller) -> None:
    """At u(c)/c = 20 % the linear interval reaches below zero, the exact one does not."""
    from tests.unit.equations.referees import cube_quantile

    c = GTC.ureal(10.0, 2.0)
    linear = GTC.value(c**3) - 1.96 * GTC.uncertainty(c**3)
    assert linear < 0.0
    assert cube_quantile(0.025, 10.0, 2.0) > 0.0
    drawn = np.quantile(np.random.default_rng(1).normal(10.0, 2.0, 400_000) ** 3, 0.025)
    assert cube_quantile(0.025, 10.0, 2.0) == pytest.approx(drawn, rel=0.02, abs=0.0)
