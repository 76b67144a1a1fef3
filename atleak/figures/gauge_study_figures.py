"""Draw a gauge study on the screen: every reading by part and operator, and what the variation is made of."""

from __future__ import annotations

from atleak.figures.figure import Figure
from atleak.figures.frame import framed
from atleak.gauge_study.anova import ACCEPTED, MARGINAL, GaugeStudy
from atleak.look import CURVES, SCREEN
from atleak.wording import Wording
from atleak.workshop_units import PERCENT, UM

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


def components(study: GaugeStudy, say: Wording) -> Figure:
    """Draw the components as shares of the study's variation, and of the tolerance where there is one [%]."""
    figure = Figure()
    shares = [("of_study", CURVES["blue"], "")]
    if study.tolerance is not None:
        shares.append(("of_tolerance", CURVES["ochre"], "/"))
    for name, colour, pattern in shares:
        values = [getattr(study.of(component), name) or 0.0 for component in _BARS]
        names = [say(f"gauge_study_names.{component}") for component in _BARS]
        said = {"text": list(map(say.percent, values)), "textposition": "outside", "cliponaxis": False}
        named, look = say(f"gauge_study.{name}"), (colour, pattern)
        figure.bars(values, names, named, look, factor=PERCENT, upright=True, hover="%{x}: %{text}", **said)
    for limit, dash in ((ACCEPTED, "dot"), (MARGINAL, "dash")):
        figure.add_hline(y=limit * PERCENT, line={"color": SCREEN.rule, "dash": dash, "width": 1.5})
    figure.update_yaxes(title="%", rangemode="tozero")
    return framed(figure, 360, 56, barmode="group", showlegend=True)
