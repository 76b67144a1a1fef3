"""The charts of a fleet's summary: verdicts, pairs, wear over mileage, temperatures, groups side by side."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from atleak.analysis.rates import Rate
from atleak.common.style import LOOKS, OK_IN_PART, PAPER_INKS, SCREEN, Look, SignShape, look_of
from atleak.common.units import PERCENT
from atleak.common.verdicts import BANDS, FLAGGED, Band, Verdict
from atleak.fleet.summary_words import NAME, FleetWords, within_words
from atleak.fleet.sums import (
    Difference,
    Group,
    LandOverMileage,
    PairTrouble,
    TemperatureSums,
    ValveBody,
    VerdictCounts,
    WearDifference,
)
from atleak.report.charts.chart import ClassChart, Field, Layer, RowChart, Span

_BAR, _NARROW = 0.72, 0.45  # of a row: a bar, and one over it
_MARKS = dict(zip(FLAGGED, np.linspace(0.27, -0.27, len(FLAGGED)).tolist(), strict=True))  # above the row's middle
_DIAMOND = SignShape(((0.0, -1.0), (0.8, 0.0), (0.0, 1.0), (-0.8, 0.0)))


def _mark(like: Look, marker: str, screen: str, paper: str) -> Look:
    return replace(like, marker=marker, screen=screen, fill=paper, line=paper)


_DECIDING = replace(_mark(LOOKS[Verdict.OK], "diamond", SCREEN.ink, PAPER_INKS.ink), shape=_DIAMOND)
_MEANS = {
    "in_the_mean": _mark(LOOKS[Verdict.OK], "circle", SCREEN.leakage, PAPER_INKS.leakage),
    "at_same_mileage": replace(_DECIDING, screen=SCREEN.share, fill=PAPER_INKS.share),
}


class FleetCharts:
    """The charts of a summary, in its reader's words."""

    def __init__(self, words: FleetWords) -> None:
        self.words, self.say = words, words.say

    def verdicts(self, rows: Sequence[tuple[str, VerdictCounts]]) -> RowChart:
        """Return how the verdicts of the units are parted; ok in part, where not all was measured, is not green."""
        parts = [list(self._parts(counts)) for _, counts in rows]
        layers = []
        for number, (what, look, _) in enumerate(parts[0]):
            of_rows = [(name, of[number][2], counts.units) for (name, counts), of in zip(rows, parts, strict=True)]
            if any(count for _, count, _ in of_rows):
                layers.append(self._counts(what, look, of_rows))
        units = [self._units(counts.units) for _, counts in rows]
        axis = self.say("fleet_summary.chart_verdicts")
        return RowChart([name for name, _ in rows], layers, axis, units, stacked=True)

    def _parts(self, counts: VerdictCounts) -> Iterator[tuple[str, Look, int]]:
        """Yield the parts of a bar, the worst first: their names, looks, and how many units are in them."""
        say = self.say
        for level in (*reversed(FLAGGED), Verdict.OK, Verdict.NOT_MEASURED):
            ok = level is Verdict.OK
            yield say.signed(level), look_of(level), counts.ok_throughout if ok else counts.verdicts[level]
            if ok:
                yield say("fleet.ok_in_part"), OK_IN_PART, counts.ok_in_part

    def _counts(self, what: str, look: Look, rows: Sequence[tuple[str, int, int]]) -> Layer:
        parts = [PERCENT * count / units if units else 0.0 for _, count, units in rows]
        return Layer(
            what,
            look,
            parts,
            hover=[
                f"{name}<br>{what}: {self.words.counted(count, units)}, {part:.1f} %"
                for (name, count, units), part in zip(rows, parts, strict=True)
            ],
            inside=[self.say.number(count, 0) for _, count, _ in rows],
            thick=_BAR,
        )

    def pairs(self, troubles: Sequence[PairTrouble], names: Sequence[str]) -> RowChart:
        """Return in which share of the units pairs are flagged, at *replace* or past it, and decide.

        Intervals are of those to be replaced. Of too few units there are words instead, with the count.
        """
        say = self.say
        layers = [
            self._rates([each.flagged for each in troubles], FLAGGED[0], names, thick=_BAR),
            self._rates([each.replace for each in troubles], Verdict.REPLACE, names, thick=_NARROW),
            Layer(
                say("fleet.deciding"),
                _DECIDING,
                [each.deciding.percent if each.deciding.count else None for each in troubles],
                hover=[
                    f"{name}<br>{say('fleet.deciding')}: {self.words.rate(each.deciding)}"
                    for each, name in zip(troubles, names, strict=True)
                ],
            ),
        ]
        layers[0] = replace(layers[0], spans=())
        beside = [self._beside(each.replace) for each in troubles]
        return RowChart(names, layers, say("fleet_summary.chart_pairs"), beside)

    def _units(self, count: int) -> str:
        return self.say("fleet_summary.chart_units", count=self.say.number(count, 0))

    def _beside(self, rate: Rate, otherwise: str = "") -> str:
        """Return the words at the end of a row: of too few units that they are."""
        counted = self.words.counted(rate.count, rate.of)
        if not rate.enough:
            return self.say("fleet.too_few", rate=counted)
        return otherwise or f"{self.say.number(rate.percent, 1)} %, {counted}"

    def _rates(
        self, rates: Sequence[Rate], level: Verdict, names: Sequence[str], *, thick: float = 0.0, lift: float = 0.0
    ) -> Layer:
        """Return rates at a level or past it; as marks those of enough units alone."""
        what = self.words.or_worse(level, signed=True)
        return Layer(
            what,
            look_of(level),
            [rate.percent or 0.0 if rate.enough or thick else None for rate in rates],
            [rate.span for rate in rates],
            [f"{name}<br>{what}: {self.words.rate(rate)}" for name, rate in zip(names, rates, strict=True)],
            thick=thick,
            lift=lift,
        )

    def groups(self, groups: Sequence[Group]) -> RowChart:
        """Return which share of each group's units is at a verdict or past it; of too few units, words alone."""
        names = [within_words(group.name, NAME) for group in groups]
        layers = [
            self._rates([group.counts.rates[level] for group in groups], level, names, lift=_MARKS[level])
            for level in FLAGGED
        ]
        beside = [
            self._beside(group.counts.rates[Verdict.REPLACE], self._units(group.counts.judged)) for group in groups
        ]
        return RowChart(names, layers, self.say("fleet_summary.chart_groups"), beside)

    def differences(self, body: ValveBody, found: Sequence[WearDifference]) -> RowChart:
        """Return by how much the wear of lands differs between two groups, with intervals that hold for all at once.

        Marks are filled where the interval leaves out zero; a difference without an interval has none.
        """
        names = [f"{self.words.land(body.controller, each.key)}: {self.words.sides(each)}" for each in found]
        of_each = {
            "in_the_mean": [each.mean_points for each in found],
            "at_same_mileage": [each.same_mileage_points for each in found],
        }
        layers = [
            self._differences(what, names, points, lift)
            for (what, points), lift in zip(of_each.items(), (0.15, -0.15), strict=True)
        ]
        return RowChart(names, layers, self.say("fleet.difference_of_wear"), zero=True)

    def _differences(self, what: str, names: Sequence[str], points: Sequence[Difference | None], lift: float) -> Layer:
        name = self.say(f"fleet.{what}")
        return Layer(
            name,
            _MEANS[what],
            [None if each is None or each.differs is None else each.value for each in points],
            [None if each is None else each.span_of_all for each in points],
            [f"{row}<br>{self.words.difference(each)}<br>{name}" for row, each in zip(names, points, strict=True)],
            lift=lift,
            open=[each is None or not each.differs for each in points],
        )

    def wear(self, body: ValveBody, land: LandOverMileage) -> ClassChart:
        """Return how the wear of a land is spread over the units of each class of mileage, and how many those are."""
        say, spreads = self.say, [each.wear_percent for each in land.classes]
        ends = [(each.low_km, each.high_km) for each in land.classes]
        return ClassChart(
            self._edges(ends, "distance"),
            [say.span(each, "distance", 0) for each in ends],
            say("fleet_summary.chart_mileage"),
            [
                Field(say("fleet_summary.chart_wear"), 0.7, "percent", spreads),
                Field(say("fleet_summary.over_units"), 0.2, units=[each.units for each in spreads]),
            ],
            self.words.land(body.controller, land.key),
            say("fleet_summary.chart_mileage_thousand", thousand=say.number(1000.0, 0)),
        )

    def _edges(self, ends: Sequence[Span], kind: str) -> list[Span]:
        return [(float(self.say.convert(low, kind)), float(self.say.convert(high, kind))) for low, high in ends]

    def temperatures(self, classes: Sequence[TemperatureSums]) -> ClassChart:
        """Return share, main pressure, time in the bands of the share and units over the temperature of the fluid.

        What no log tells anything of is left out.
        """
        say, ends = self.say, [(each.low_c, each.high_c) for each in classes]
        names = {part: say(f"fleet_summary.over_{part}") for part in ("share", "pressure", "bands", "units")}
        hours = [say("fleet.hours", hours=say.number(each.seconds / 3600.0, 1)) for each in classes]
        fields = [
            Field(
                names["share"], 0.36, "percent", [each.share_percent for each in classes],
                [each.share_mean_percent for each in classes], [each.share_max_percent for each in classes],
            ),
            Field(
                names["pressure"], 0.29, "pressure", [each.pressure_kpa for each in classes],
                [each.pressure_mean_kpa for each in classes], [each.pressure_min_kpa for each in classes],
                "lowest", from_zero=False,
            ),
            Field(names["bands"], 0.21, stack=list(self._bands(classes)), hover=hours),
            Field(names["units"], 0.14, units=[each.units for each in classes]),
        ]  # fmt: skip
        has = [any(fields[0].spreads), any(fields[1].spreads), any(each.bands_percent for each in classes), True]
        return ClassChart(
            self._edges(ends, "temperature"),
            [say.span(each, "temperature", 0) for each in ends],
            say("fleet_summary.chart_temperature"),
            [field for field, shown in zip(fields, has, strict=True) if shown],
        )

    def _bands(self, classes: Sequence[TemperatureSums]) -> Iterator[tuple[str, Look, list[float]]]:
        """Yield the parts of the time from below: green, green as far as it was measured, the other bands."""
        for band in BANDS:
            parts = [(each.bands_percent or {}).get(band, 0.0) for each in classes]
            if band is Band.GREEN:
                in_part = [each.green_in_part_percent for each in classes]
                parts = [whole - part for whole, part in zip(parts, in_part, strict=True)]
                yield self.say.signed(band), look_of(band), parts
                yield self.say("fleet.green_in_part"), OK_IN_PART, in_part
            else:
                yield self.say.signed(band), look_of(band), parts
