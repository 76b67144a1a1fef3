"""Evaluate a unit's road test: what the log says by itself, and leakage over it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from atleak.catalogue.limits import Limits
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.cache import kept_with
from atleak.common.errors import Message, RoadTestError
from atleak.common.sentences import Sentence
from atleak.diagnosis.road_findings import RoadFindings, road_findings
from atleak.diagnosis.uncertainty import Assumptions
from atleak.engine.leakage import LeakageModel
from atleak.engine.road_leakage import RoadLeakage, evaluate_road_test
from atleak.measurements.road_test import RoadTest

NO_LEAKAGE = "no_leakage_over_log"  # code of the message why none is computed over a log
_LOGGED = ("main_pressure", "converter_pressure", "atf_temperature", "gear")  # channels from which leakage follows


@dataclass(frozen=True)
class RoadDiagnosis:
    """What a unit's road test says; nothing where none was driven."""

    log: RoadFindings | None = None  # what it says by itself
    leakage: RoadLeakage | None = None  # None where no leakage can be computed over it
    messages: tuple[Message, ...] = ()  # of a log without leakage over it: its own, and why


def diagnosed_road(
    road_test: RoadTest | None,
    model: LeakageModel,
    condition: OperatingPoint,
    limits: Limits,
    assumptions: Assumptions,
    guard_factor: float,
) -> RoadDiagnosis:
    """Evaluate a road test, if there is one.

    Parameters
    ----------
    model
        the engine with the unit's clearances.
    condition
        which stands for what the log does not hold.
    limits, assumptions, guard_factor
        by which the log is judged, and what is uncertain.
    """
    if road_test is None:
        return RoadDiagnosis()
    log = road_findings(model.controller, road_test, limits, assumptions, guard_factor)
    try:
        return RoadDiagnosis(log, leakage_over(model, road_test, condition))
    except RoadTestError as error:
        text = Sentence(
            "No leakage is computed over {file}: {problem}.", file=log.road_test.file, problem=error.problem
        )
        return RoadDiagnosis(log, None, (*log.road_test.messages, Message("warning", NO_LEAKAGE, text)))


def leakage_over(model: LeakageModel, road_test: RoadTest, condition: OperatingPoint) -> RoadLeakage:
    """Compute the leakage over a log, or take it from the last time, where nothing has changed on which it rests.

    The condition counts only where it stands for what the log does not hold, or sets the pressure of circuits.

    Raises
    ------
    RoadTestError
        a road test without usable main pressure.
    """
    logged = all(name in road_test.channels for name in _LOGGED) and not model.controller.circuits
    rests_on = (model, None if logged else condition)

    def made() -> dict[str, Any]:
        road = vars(evaluate_road_test(model, road_test, condition))
        return {name: value for name, value in road.items() if name not in ("road_test", "assumed")}

    return RoadLeakage(
        road_test=road_test, assumed=condition, **kept_with(road_test, "leakage", rests_on, made, most=1)
    )
