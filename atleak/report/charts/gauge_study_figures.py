"""Draw a gauge study on the screen: every reading by its part and operator, and what makes up its variation."""

from __future__ import annotations

from dataclasses import replace

from atleak.analysis.gauge_study import ACCEPTED, MARGINAL, GaugeStudy
from atleak.common.style import AS_NEW, CURVES, SCREEN, Look, look_of
from atleak.common.units import PERCENT, UM
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording
from atleak.report.charts.chart import LayerOf, RowChart, layers_of
from atleak.report.charts.figure import Figure, framed

_SYMBOLS = ("circle", "square", "diamond", "triangle-up", "x", "cross", "star", "triangle-down", "pentagon")
_BARS = ("grr", "repeatability", "reproducibility", "part")


def by_part_and_operator(study: GaugeStudy, say: Wording) -> Figure:
    """Draw how far every reading is from the mean of its part [µm], one series for each operator.

    Readings of several parts differ by more than any gauge: from their part's own mean, people and repeats show.
    """
    readings = study.readings
    apart = (readings.values - readings.values.mean(axis=(1, 2), keepdims=True)) * UM
    figure = Figure()
    colours = list(CURVES.values())
    count = len(readings.operators)
    for number, operator in enumerate(readings.operators):
        colour, beside = colours[number % len(colours)], (number - (count - 1) / 2) * 0.6 / count
        places = [place + beside for place in range(len(readings.parts))]
        own, each = apart[:, number], [place for place in places for _ in range(readings.trials)]
        mark = (colour, _SYMBOLS[number % len(_SYMBOLS)], 8, 0.0)
        figure.marks(
            own.ravel(), each, operator, mark, upright=True, legendgroup=operator, opacity=0.75, hover="%{y:.2f} µm"
        )
        figure.line(places, own.mean(axis=1), colour, 1.5, legendgroup=operator)
    figure.add_hline(y=0.0, line={"color": SCREEN.rule, "width": 1})
    figure.update_xaxes(
        title=say("gauge_study_names.part"), tickvals=list(range(len(readings.parts))), ticktext=list(readings.parts)
    )
    figure.update_yaxes(title=f"{say('gauge_study.from_mean')} [µm]")
    return framed(figure, 380, 56)


def component_chart(study: GaugeStudy, say: Wording) -> RowChart:
    """Return the components as shares of the study's variation, and of the tolerance where there is one [%].

    Marks are the bounds within which a gauge is good, or usable for some purposes.
    """
    names = [say(f"gauge_study_names.{component}") for component in _BARS]
    both = [("of_study", replace(AS_NEW, screen=CURVES["blue"]))]
    if study.tolerance is not None:
        both.append(("of_tolerance", replace(AS_NEW, screen=CURVES["ochre"], pattern="/")))

    def bars(number: int, name: str, look: Look) -> LayerOf:
        values = [(getattr(study.of(component), name) or 0.0) * PERCENT for component in _BARS]
        named = say(f"gauge_study.{name}")
        hover = [f"{row}: {say.number(value, 1)} % {named}" for row, value in zip(names, values, strict=True)]
        lift = 0.0 if len(both) == 1 else 0.22 - 0.44 * number
        return named, look, values, {"hover": hover, "thick": 0.8 / len(both), "lift": lift}

    def bound(key: str, level: Verdict, share: float) -> LayerOf:
        of_gauge = [share * PERCENT if component == "grr" else None for component in _BARS]
        return say(f"gauge_study.{key}"), look_of(level), of_gauge, {}

    bounds = bound("marginal", Verdict.WATCH, ACCEPTED), bound("refused", Verdict.REPLACE, MARGINAL)
    layers = (*(bars(number, *each) for number, each in enumerate(both)), *bounds)
    return RowChart(names, layers_of(layers), "%")
