"""What was carried through before is not computed again, and nothing else is taken for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.uncertainty import DEFAULTS, propagation
from atleak.engine.projection import stated_condition
from atleak.measurements.readings import Readings
from atleak.report.json.diagnosis import diagnosis_record


class Judge:
    """Diagnoses a unit at a stated temperature, and counts the conditions that were carried through for it."""

    def __init__(self, controller: Controller, fluid: Fluid, limits: Limits, patch: pytest.MonkeyPatch) -> None:
        self.controller, self.fluid, self.limits, self.carried = controller, fluid, limits, 0
        unit = propagation._Trials.unit

        def counted(*given: object) -> object:
            self.carried += 1
            return unit(*given)

        patch.setattr(propagation._Trials, "unit", counted)

    def at(self, readings: Readings, temperature: float, **changes: object) -> Diagnosis:
        condition = stated_condition(self.controller, temperature=temperature)
        given = {"controller": self.controller, "fluid": self.fluid, "limits": self.limits, **changes}
        return diagnose(**given, readings=readings, condition=condition)


@pytest.fixture(params=["minimal", pytest.param("three_circuits", marks=pytest.mark.slow)])
def judge(request: pytest.FixtureRequest, hipol: Fluid, limits: Limits, monkeypatch: pytest.MonkeyPatch) -> Judge:
    return Judge(request.getfixturevalue(request.param), hipol, limits, monkeypatch)


@pytest.fixture
def sheet(judge: Judge, readings_of: Callable[..., Readings]) -> Readings:
    """Every land of the unit, worn by half of its clearance."""
    worn = {
        land.key: (land.nominal_diameter, land.nominal_diameter + 3.0 * land.new_clearance)
        for land in judge.controller.lands
    }
    return readings_of(judge.controller, worn)


def test_at_another_condition_only_that_is_carried_through_and_nothing_differs(judge: Judge, sheet: Readings) -> None:
    points = len(judge.controller.operating_points)
    judge.at(sheet, 71.0)
    assert judge.carried == points + 1
    again = judge.at(sheet, 72.5)
    assert judge.carried == points + 2
    judge.at(sheet, 71.0)
    assert judge.carried == points + 2
    alone = judge.at(replace(sheet), 72.5)
    assert judge.carried == 2 * points + 3
    assert diagnosis_record(again) == diagnosis_record(alone)


@pytest.mark.parametrize("what", ["fluid", "limits", "assumptions", "controller"])
def test_nothing_known_is_taken_where_anything_else_has_changed(judge: Judge, sheet: Readings, what: str) -> None:
    other = {
        "fluid": replace(judge.fluid, id="other"),
        "limits": replace(judge.limits, name="other"),
        "assumptions": replace(DEFAULTS, temperature=9.0),
        "controller": replace(judge.controller, note="other"),
    }
    judge.at(sheet, 71.0)
    before = judge.carried
    judge.at(sheet, 71.0, **{what: other[what]})
    assert judge.carried == 2 * before
