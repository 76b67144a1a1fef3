"""Between which shares a total may lie as the spools do."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import PAPER, WORKSHOP, Profile
from atleak.engine.projection import project
from atleak.measurements.clearances import clearances
from atleak.measurements.readings import Readings
from atleak.report.tables.names import concentric_factors, position_band, positions
from tests.unit.conftest import first_of

DiagnoseLand = Callable[[float, Profile], Diagnosis]


@pytest.fixture
def with_land_at(
    four_speed: Controller, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings]
) -> DiagnoseLand:
    """A unit like new but for land 25/1, of a given radial clearance."""

    def build(clearance: float, profile: Profile) -> Diagnosis:
        diameters = {
            land.key: (
                land.nominal_diameter,
                land.nominal_diameter + 2.0 * (clearance if land.key == ("25", 1) else land.new_clearance),
            )
            for land in four_speed.lands
        }
        return diagnose(four_speed, hipol, limits, readings=readings_of(four_speed, diameters), profile=profile)

    return build


@pytest.mark.parametrize("clearance", first_of([150e-6, 100e-6, 490e-6]))
@pytest.mark.parametrize("taken", [0.0, "unknown"])
def test_the_band_ends_at_the_shares_of_spools_concentric_and_touching(
    with_land_at: DiagnoseLand, clearance: float, taken: object
) -> None:
    found, concentric, touching = (
        with_land_at(clearance, WORKSHOP.with_options(eccentricity=each)) for each in (taken, 0.0, 1.0)
    )
    for at, least, largest in zip(found.projections, concentric.projections, touching.projections, strict=True):
        assert position_band(found, at) == pytest.approx((least.share, largest.share), rel=1e-9, abs=0.0)
        assert f"{100.0 * least.share:.0f} to {100.0 * largest.share:.0f} % as they may lie" in positions(found, at)
        factors = 1.0, largest.leakage / least.leakage
        assert concentric_factors(found.profile, at) == pytest.approx(factors, rel=1e-9, abs=0.0)


def test_a_wide_gap_gains_little_from_where_its_spool_lies(with_land_at: DiagnoseLand) -> None:
    found = with_land_at(490e-6, WORKSHOP)
    assert max(concentric_factors(found.profile, at)[1] for at in found.projections) < 1.2


def test_narrow_gaps_leak_up_to_two_and_a_half_times_as_much(four_speed: Controller, hipol: Fluid) -> None:
    model = LeakageModel(four_speed, clearances(None, four_speed), hipol, WORKSHOP)
    for point in four_speed.operating_points:
        low, high = concentric_factors(WORKSHOP, project(model, point))
        assert low == 1.0
        assert 2.4 < high < 2.5
    model = LeakageModel(four_speed, clearances(None, four_speed), hipol, PAPER)
    without_entry_loss = concentric_factors(PAPER, project(model, four_speed.operating_points[0]))
    assert without_entry_loss == pytest.approx((1.0, 2.5), rel=1e-12, abs=0.0)


def test_a_position_that_was_set_leaves_no_band(with_land_at: DiagnoseLand) -> None:
    found, concentric = (with_land_at(150e-6, WORKSHOP.with_options(eccentricity=each)) for each in (0.6, 0.0))
    for at, least in zip(found.projections, concentric.projections, strict=True):
        assert position_band(found, at) is None
        assert positions(found, at) == "spools at e/c = 0.6"
        factor = at.leakage / least.leakage
        assert concentric_factors(found.profile, at) == pytest.approx((factor, factor), rel=1e-9, abs=0.0)
