"""What a flow that was caught in a jug says of what the line leaves over: at least so much, or just so much.

A consumer takes its usual flow F as long as the line leaves so much, else what is left, L: the jug catches min(F, L).
At about its usual flow it only says that no less is left; well below it, it measures what is left.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from atleak.catalogue.circuits import Consumer
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.errors import Message
from atleak.common.sentences import Name, Sentence
from atleak.common.units import DM3_MIN, Quantity
from atleak.diagnosis.uncertainty.assumptions import Assumptions
from atleak.engine.leakage import LeakageModel
from atleak.engine.operation import Operation, consumed, wanted
from atleak.measurements.flow_readings import FlowReading, FlowTable, consumer_of

_USUAL_FROM = 1.960  # standard deviations below the usual flow, from which on a reading is as usual: wrong in 2.5 %
_ENDS = 2.241  # of the jug's error, to each end of an interval: wrong in 1.25 % each, so that all is right in 95 %
_EXACT = 0.001  # relative: a standard uncertainty of less counts as so much, none at all too
_LEAST = 0.1  # of the usual flow: the error of a smaller one is that of so much


@dataclass(frozen=True)
class FlowFinding:
    """A flow that was caught, and what the line left over for it."""

    reading: FlowReading
    point: OperatingPoint  # at which it was caught
    consumer: Consumer | None  # that took it; None where the valve body's file describes none
    usual: float | None  # [m³/s] that it takes there, as the file states it
    left_low: float  # [m³/s] that the line leaves for it: pump less slip, leakage and all other consumers
    left_high: float  # [m³/s]; infinite where the reading only says that at least so much is left
    computed: float | None  # [m³/s] that the engine leaves for it, with the clearances as measured, or else new

    @property
    def condition(self) -> str:
        """Return the name of the operating point."""
        return self.point.name

    @property
    def what(self) -> str:
        """Return what flowed, as the table names it."""
        return self.reading.what

    @property
    def flow(self) -> float:
        """Return the flow that was caught [m³/s]."""
        return self.reading.flow

    @property
    def bound(self) -> bool:
        """Tell whether the reading says no more than that at least so much is left."""
        return math.isinf(self.left_high)

    @property
    def name(self) -> str:
        """Return the name of what flowed, for people."""
        return Name(self.consumer.name) if self.consumer is not None else _COOLER


_COOLER = Sentence("cooler")


def find_flows(table: FlowTable | None, model: LeakageModel, assumptions: Assumptions) -> tuple[FlowFinding, ...]:
    """Return what each flow of a table says, in its order; none without a table.

    Parameters
    ----------
    assumptions
        how far a consumer's flow, and one that was caught, may be from the value stated.
    """
    points = {point.name: point for point in model.controller.operating_points}
    readings = () if table is None else (each for each in table.readings if each.condition in points)
    return tuple(_found(each, points[each.condition], model, assumptions) for each in readings)


def _found(reading: FlowReading, point: OperatingPoint, model: LeakageModel, assumptions: Assumptions) -> FlowFinding:
    consumer, usual, computed = consumer_of(model.controller, reading.what), None, None
    if consumer is not None:
        at = Operation.of(model, point)
        usual = float(wanted(at.network, at.held.required, at.held.required)[consumer.id])
        computed = float(left_for(at, consumer))
    low, high = left_over(reading.flow, usual, assumptions.consumer_flow, assumptions.caught_flow)
    if consumer is not None and not consumer.after_line:
        high = math.inf  # fed before the regulator: less than usual comes of a lower line
    return FlowFinding(reading, point, consumer, usual, low, high, computed)


def left_for(at: Operation, consumer: Consumer) -> Any:
    """Return what the line leaves for a consumer [m³/s]: the pump's delivery less slip, leakage and other consumers.

    Parameters
    ----------
    at
        the unit at a condition, or at many of them.
    consumer
        whose own flow is not taken off.

    Returns
    -------
    float or numpy.ndarray
        never below zero; an array where the condition or the unit is one.
    """
    held, point = at.held, at.point
    supply = at.model.pump.capacity(point.engine_speed, held.main_pressure, at.viscosity)
    own = wanted(at.network, held.main_pressure, held.required)[consumer.id]
    others = consumed(at.network, held.main_pressure, held.required) - own
    return np.maximum(supply - at.network.drawn_from_pump(held.balance) - others, 0.0)


def caught_error(measured: Any, usual: Any, reading: float) -> Any:
    """Return the standard uncertainty of a flow that was caught [m³/s].

    Parameters
    ----------
    measured, usual
        that flow, and the consumer's usual one [m³/s].
    reading
        relative; of a flow below a tenth of the usual one it is as large as of that tenth.
    """
    return max(reading, _EXACT) * np.maximum(measured, _LEAST * np.asarray(usual))


def left_over(measured: float, usual: float | None, spread: float, reading: float) -> tuple[float, float]:
    """Return between which flows that lies which the line leaves over [m³/s], right in 95 of 100 cases or more.

    Parameters
    ----------
    measured, usual
        the flow that was caught, and the consumer's usual one [m³/s]; None where that is not known.
    spread, reading
        relative standard uncertainties of the usual flow, and of the one that was caught.

    Returns
    -------
    tuple
        the ends; the upper one is infinite where the flow is as usual, or no usual one is known.

    Examples
    --------
    >>> tuple(round(1e6 * each, 2) for each in left_over(30e-6, 63e-6, 0.2, 0.04))
    (27.31, 32.69)
    >>> tuple(round(1e6 * each, 2) for each in left_over(60e-6, 63e-6, 0.2, 0.04))
    (54.62, inf)
    """
    error = float(caught_error(measured, usual or measured, reading))
    low, high = max(measured - _ENDS * error, 0.0), measured + _ENDS * error
    if usual is None or measured >= usual - _USUAL_FROM * math.hypot(spread * usual, error):
        high = math.inf
    return low, high


def log_likelihood(measured: Any, left: Any, usual: Any, spread: float, reading: float) -> np.ndarray:
    """Return the log of the likelihood of a flow that was caught, given what the line leaves, by draw.

    Parameters
    ----------
    measured
        the flow that was caught [m³/s].
    left
        what the line leaves for the consumer in each draw [m³/s], as `left_for` gives it; of a consumer before the
        line's regulator infinite.
    usual
        the consumer's usual flow there [m³/s], a number or one of each draw.
    spread, reading
        relative standard uncertainties of the usual flow, which is integrated out, and of the one that was caught.

    Returns
    -------
    numpy.ndarray
        log of the density [s/m³]; shape of ``left`` and ``usual``.

    Notes
    -----
    The jug catches min(F, L) + e with F and e normal, so its density is
    N(q; L, s) P(F > L) + N(q; F₀, √(σ² + s²)) P(F < L | q), where F given q has mean (F₀ s² + q σ²)/(σ² + s²) and
    standard deviation σ s/√(σ² + s²).
    """
    from scipy.special import log_ndtr  # dear to import, and seldom needed

    usual, left = np.broadcast_arrays(np.asarray(usual, float), np.asarray(left, float))
    error, own = caught_error(measured, usual, reading), max(spread, _EXACT) * usual
    both = np.hypot(own, error)
    finite = np.where(np.isfinite(left), left, 0.0)
    limited = _log_normal(measured, np.maximum(finite, 0.0), error) + log_ndtr((usual - finite) / own)
    given = (usual * error**2 + measured * own**2) / both**2
    unlimited = _log_normal(measured, usual, both) + log_ndtr((left - given) / (own * error / both))
    return np.asarray(np.logaddexp(np.where(np.isfinite(left), limited, -np.inf), unlimited))


def _log_normal(value: Any, mean: Any, deviation: Any) -> Any:
    return -0.5 * ((value - mean) / deviation) ** 2 - np.log(math.sqrt(2.0 * math.pi) * deviation)


def flow_messages(findings: tuple[FlowFinding, ...]) -> Iterator[Message]:
    """Yield what is short of its usual flow, and of what no usual flow is known."""
    for each in findings:
        said = {"what": each.name, "condition": each.point, "flow": Quantity(each.flow * DM3_MIN, "flow", 2)}
        if each.usual is None:
            text = Sentence(
                "{what}, {condition}: {flow} {flow.unit} say that at least so much is left; the valve body's file "
                "states no usual flow to compare it with"
            )
            yield Message("info", "flow_without_usual", text.of(**said), each.reading.place)
        elif not each.bound:
            text = Sentence(
                "{what}, {condition}: {flow} {flow.unit} where {usual} {usual.unit} are usual: leakage "
                "leaves too little of what the pump delivers, or the line is blocked"
            )
            usual = Quantity(each.usual * DM3_MIN, "flow", 2)
            yield Message("warning", "flow_below_usual", text.of(**said, usual=usual), each.reading.place)
