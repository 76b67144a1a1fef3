"""Say how well a gauge measures in this workshop's hands: several people read several parts repeatedly.

The analysis of variance has random parts, random operators and their interaction, which is pooled with repeatability
where it is not significant: AIAG, Measurement Systems Analysis, 4th ed., chapter III, section B. Its result can be kept
as an instrument of the user's own catalogue, beside a calibration that the study cannot show.
"""

from __future__ import annotations

import datetime as dt
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from atleak.catalogue.instruments import Instrument
from atleak.common.errors import InputError, Message
from atleak.common.sentences import Sentence, counted
from atleak.common.units import UM, Quantity
from atleak.measurements.gauge_study import StudyReadings

ALPHA = 0.05  # significance at which the interaction is kept: as in the table of AIAG's example
SPREAD = 6.0  # standard deviations that make the width of a spread: 99.73 % of a normal distribution
CATEGORY = 1.41  # ndc = 1.41 · part variation / GRR (AIAG)
ACCEPTED, MARGINAL = 0.10, 0.30  # GRR as a fraction of the study's variation or of the tolerance (AIAG)
FEWEST_CATEGORIES = 5  # that AIAG asks for


@dataclass(frozen=True)
class AnovaRow:
    """One source of variation: sum of squares [m²], degrees of freedom, F and its probability by chance."""

    source: str  # part, operator, interaction, repeatability or total
    squares: float  # [m²] sum of squares
    freedom: int  # degrees of freedom
    f: float | None = None  # ratio of mean squares; None where there is none to compare with
    probability: float | None = None  # of an F as large by chance

    @property
    def mean_square(self) -> float:
        """Return the sum of squares over the degrees of freedom [m²]."""
        return self.squares / self.freedom


@dataclass(frozen=True)
class Component:
    """One component of the variation, and what it is of the whole."""

    name: str  # grr, repeatability, reproducibility, operator, interaction, part or total
    variance: float  # [m²]
    total: float = field(repr=False)  # [m²] variance of everything
    tolerance: float | None = field(default=None, repr=False)  # [m]

    @property
    def deviation(self) -> float:
        """Return the standard deviation [m]."""
        return math.sqrt(self.variance)

    @property
    def contribution(self) -> float | None:
        """Return the variance as a fraction of that of everything; None where nothing varies."""
        return self.variance / self.total if self.total else None

    @property
    def of_study(self) -> float | None:
        """Return the standard deviation as a fraction of that of everything; None where nothing varies."""
        return math.sqrt(self.variance / self.total) if self.total else None

    @property
    def of_tolerance(self) -> float | None:
        """Return `SPREAD` standard deviations as a fraction of the tolerance; None where none is stated."""
        return None if self.tolerance is None else SPREAD * self.deviation / self.tolerance


@dataclass(frozen=True)
class GaugeStudy:
    """The result of a study; variances in m², fractions of one."""

    readings: StudyReadings  # as they were read
    alpha: float  # probability under which an interaction counts
    tolerance: float | None  # [m] width between the two limits of the part, where there is one
    table: tuple[AnovaRow, ...]  # with the interaction
    pooled: bool  # whether the interaction was added to repeatability
    components: tuple[Component, ...]  # of the variance, in the order of the report
    messages: tuple[Message, ...] = ()  # what a reader must know of it

    def of(self, name: str) -> Component:
        """Return a component by its name."""
        return next(component for component in self.components if component.name == name)

    def row(self, source: str) -> AnovaRow:
        """Return a row of the table by its source."""
        return next(row for row in self.table if row.source == source)

    @property
    def grr(self) -> Component:
        """Return repeatability and reproducibility together."""
        return self.of("grr")

    @cached_property
    def categories(self) -> int | None:
        """Return how many groups of parts the gauge can tell apart; None where it shows no variation of its own."""
        if not self.grr.variance:
            return None
        return math.floor(CATEGORY * self.of("part").deviation / self.grr.deviation)

    @property
    def judged(self) -> str | None:
        """Return ``accepted``, ``marginal`` or ``refused``, by AIAG's bounds of the share of gauge and people.

        That of the tolerance where one is stated, else of the study's variation; None where nothing varies either.
        """
        share = self.grr.of_study if self.tolerance is None else self.grr.of_tolerance
        if share is None:
            return None
        return "accepted" if share < ACCEPTED else "marginal" if share <= MARGINAL else "refused"


def analysed(readings: StudyReadings, *, tolerance: float | None = None, alpha: float = ALPHA) -> GaugeStudy:
    """Return the components of variation of a crossed study.

    Parameters
    ----------
    readings
        of shape (parts, operators, trials) [m].
    tolerance
        the width between the part's two limits [m]; None where shares of it are not asked for.
    alpha
        the interaction is kept where its F would be reached by chance with a probability below this.

    Raises
    ------
    InputError
        a tolerance that is not above 0, or an alpha that is not between 0 and 1.
    """
    if tolerance is not None and not (math.isfinite(tolerance) and tolerance > 0.0):
        expected = Sentence("a number greater than 0")
        raise InputError(Sentence("the tolerance is no width"), value=tolerance, expected=expected)
    if not 0.0 < alpha < 1.0:
        expected = Sentence("a number between 0 and 1")
        raise InputError(Sentence("the level of significance is none"), value=alpha, expected=expected)
    table = _table(readings.values)
    part, operator, interaction, repeatability, _ = table
    assert interaction.probability is not None
    pooled = not interaction.probability < alpha
    parts, operators, trials = readings.values.shape
    if pooled:
        freedom = interaction.freedom + repeatability.freedom
        error = beside = (interaction.squares + repeatability.squares) / freedom
    else:
        error, beside = repeatability.mean_square, interaction.mean_square
    estimates = {
        "repeatability": error,
        "interaction": 0.0 if pooled else (interaction.mean_square - error) / trials,
        "operator": (operator.mean_square - beside) / (parts * trials),
        "part": (part.mean_square - beside) / (operators * trials),
    }
    negative = tuple(name for name, variance in estimates.items() if variance < 0.0)
    variances = {name: max(variance, 0.0) for name, variance in estimates.items()}
    variances["reproducibility"] = variances["operator"] + variances["interaction"]
    variances["grr"] = variances["repeatability"] + variances["reproducibility"]
    variances["total"] = variances["grr"] + variances["part"]
    order = ("grr", "repeatability", "reproducibility", "operator", "interaction", "part", "total")
    components = tuple(Component(name, variances[name], variances["total"], tolerance) for name in order)
    study = GaugeStudy(readings, alpha, tolerance, table, pooled, components)
    return replace(study, messages=(*readings.messages, *_messages(study, negative)))


def _table(values: np.ndarray) -> tuple[AnovaRow, ...]:
    """Return the sums of squares; main effects are tested against the interaction, that against repeatability."""
    parts, operators, trials = values.shape
    values = values - values.mean()  # readings of 12.7 mm that differ by 0.001 mm keep their digits
    cells = values.mean(axis=2)
    by_part, by_operator = cells.mean(axis=1), cells.mean(axis=0)
    beside = cells - by_part[:, None] - by_operator[None, :]
    within = values - cells[:, :, None]
    smallest = 1e-24 * values.size  # [m²] a picometre each: what rounding leaves of readings that are all the same
    found = {
        "part": (operators * trials * float((by_part**2).sum()), parts - 1),
        "operator": (parts * trials * float((by_operator**2).sum()), operators - 1),
        "interaction": (trials * float((beside**2).sum()), (parts - 1) * (operators - 1)),
        "repeatability": (float((within**2).sum()), parts * operators * (trials - 1)),
    }
    found = {name: (squares if squares > smallest else 0.0, freedom) for name, (squares, freedom) in found.items()}
    rows = []
    for source, against in (("part", "interaction"), ("operator", "interaction"), ("interaction", "repeatability")):
        (squares, upper), (other, lower) = found[source], found[against]
        ratio = _ratio(squares / upper, other / lower)
        rows.append(AnovaRow(source, squares, upper, ratio, _by_chance(ratio, upper, lower)))
    rows.append(AnovaRow("repeatability", *found["repeatability"]))
    rows.append(AnovaRow("total", sum(squares for squares, _ in found.values()), values.size - 1))
    return tuple(rows)


def _ratio(above: float, below: float) -> float:
    """Return F; 0 where neither varies, infinite where only the upper one does."""
    if below:
        return above / below
    return math.inf if above else 0.0


def _by_chance(ratio: float, upper: int, lower: int) -> float:
    """Return the probability that F reaches this ratio by chance."""
    from scipy.special import fdtrc  # dear to import, and seldom needed

    return float(fdtrc(upper, lower, ratio))


_SET_TO_ZERO = {
    "interaction": Sentence(
        "The estimated variance of the interaction of parts and operators came out negative and is set to zero."
    ),
    "operator": Sentence("The estimated variance of the operators came out negative and is set to zero."),
    "part": Sentence("The estimated variance of the parts came out negative and is set to zero."),
}


def _messages(study: GaugeStudy, negative: Sequence[str]) -> list[Message]:
    """Say what was decided on the way, and what the study cannot show."""
    messages = []
    chance = study.row("interaction").probability
    if study.pooled:
        text = Sentence(
            "The interaction of parts and operators is not significant (p = {chance:.3g}, not below {alpha:g}): it is "
            "pooled with repeatability.",
            chance=chance,
            alpha=study.alpha,
        )
        messages.append(Message("info", "interaction_pooled", text))
    else:
        text = Sentence(
            "The interaction of parts and operators is significant (p = {chance:.3g}, below {alpha:g}): some people "
            "read some parts otherwise than others do, and it counts as reproducibility.",
            chance=chance,
            alpha=study.alpha,
        )
        messages.append(Message("warning", "interaction_kept", text))
    for name in negative:
        messages.append(Message("info", "variance_set_to_zero", _SET_TO_ZERO[name]))
    categories = study.categories
    if categories is not None and categories < FEWEST_CATEGORIES:
        text = counted(
            categories,
            "The gauge tells {count} group of these parts apart; AIAG asks for {fewest}. Parts that differ less than "
            "those on which it will be used make this number small, too.",
            "The gauge tells {count} groups of these parts apart; AIAG asks for {fewest}. Parts that differ less than "
            "those on which it will be used make this number small, too.",
            fewest=FEWEST_CATEGORIES,
        )
        messages.append(Message("warning", "few_categories", text))
    step, spread = study.readings.step, SPREAD * study.of("total").deviation
    if step is None:
        text = Sentence("All readings are the same: nothing can be said of gauge, people and parts.")
        messages.append(Message("warning", "nothing_varies", text))
    elif not study.of("repeatability").variance:
        text = Sentence("Every repeat is the same: repeatability hides below the resolution of the gauge.")
        messages.append(Message("warning", "repeats_alike", text))
    elif step > spread / 10.0:
        text = Sentence(
            "The readings step by {step:.3g} {step.unit}, more than a tenth of their spread of {spread:.3g} "
            "{spread.unit}: the gauge is too coarse for these parts.",
            step=Quantity(step * UM, "clearance"),
            spread=Quantity(spread * UM, "clearance"),
        )
        messages.append(Message("warning", "coarse_steps", text))
    return messages


_DIGITS = 4  # of an uncertainty in µm: more than any study of this size can tell


def instrument_tables(
    study: GaugeStudy, of: Instrument, *, id: str, name: str, resolution: float, date: dt.date
) -> dict[str, Any]:
    """Return the tables of an instrument's file with the study's repeatability and reproducibility.

    Reproducibility joins the calibration: what differs from one operator to the next is common to all readings that
    one of them takes, what differs from part to part is not. The calibration itself, which no study of repeats can
    show, is that of the instrument that was studied.

    Parameters
    ----------
    of
        the instrument that was studied, with the calibration of its certificate.
    resolution
        the step between two possible readings [m].
    """
    operator, interaction = study.of("operator").variance, study.of("interaction").variance
    common = of.common**2 + operator
    variance = common + of.own**2 + interaction
    parts, operators, trials = study.readings.values.shape
    repeatability, reproducibility = study.of("repeatability").deviation, study.of("reproducibility").deviation
    source = (
        f"gauge study of {date.isoformat()}, {study.readings.file}: {parts} parts, {operators} operators, {trials} "
        f"readings each; repeatability {repeatability * UM:.{_DIGITS}g} µm, reproducibility "
        f"{reproducibility * UM:.{_DIGITS}g} µm. Calibration: {of.name}, {of.source}"
    )
    note = (
        "Repeatability and reproducibility are those of the study. A study of repeats does not show how far all "
        f"readings are off: {of.calibration * UM:.{_DIGITS}g} µm for that is taken from {of.name}."
    )
    return {
        "id": id,
        "name": name,
        "source": source,
        "date": date.isoformat(),
        "note": note,
        "measures": list(of.measures),
        "resolution_um": _um(resolution),
        "calibration_um": _um(math.sqrt(variance)),
        "common_part": round(common / variance, _DIGITS) if variance else of.common_part,
        "repeatability_um": _um(repeatability),
        # people press on a spool as on a bore, which makes one smaller and the other wider: nothing of it drops out
        "alike_inside_and_outside": of.alike_inside_and_outside and not operator,
        "expansion_per_k": of.expansion,
        "representative": [
            key for key in of.representative if key in ("calibration_um", "common_part", "expansion_per_k")
        ],
    }


def _um(metres: float) -> float:
    return float(f"{metres * UM:.{_DIGITS}g}")
