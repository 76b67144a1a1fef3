"""Print what a fleet's summary says of one valve body: pairs, wear, temperatures, stated conditions, groups."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

from atleak.fleet.summary_words import NAME, FleetWords, called, within
from atleak.fleet.summed import (
    ConditionSpread,
    Difference,
    Group,
    GroupComparison,
    PairTrouble,
    ValveBody,
    VerdictCounts,
    WearDifference,
)
from atleak.report.pdf.blocks import Block, PrintedColumn, joined, table, text
from atleak.report.printed_charts.fleet import (
    GroupRow,
    PairRow,
    WearField,
    groups_chart,
    pairs_chart,
    temperatures_chart,
    wear_chart,
)
from atleak.spreads import Spread
from atleak.verdicts import BANDS, FLAGGED, Band, Verdict

DETAILED = 3  # most valve bodies with sections of their own


@dataclass(frozen=True)
class _Depth:
    """How much is printed of one valve body."""

    pairs: int  # that are listed
    wear: int  # pictures of wear over mileage
    deciders: int
    groups: int  # in the table
    differences: int  # of rates, and of wear
    bars: bool  # whether pairs and groups are drawn too


_DEPTHS = {  # by the number of valve bodies with sections: eight pages hold them
    1: _Depth(pairs=12, wear=6, deciders=6, groups=12, differences=8, bars=True),
    2: _Depth(pairs=8, wear=4, deciders=3, groups=8, differences=4, bars=True),
    3: _Depth(pairs=6, wear=4, deciders=0, groups=6, differences=3, bars=False),
}

Side = Literal["l", "c", "r", "d"]


def rate_columns(words: FleetWords, counts: Callable[[Any], VerdictCounts]) -> list[PrintedColumn]:
    """Return the columns of the rates at a verdict or past it."""

    def cell(verdict: Verdict, row: Any) -> str:
        return words.percent(counts(row).rates[verdict])

    return [
        PrintedColumn(words.or_worse(verdict).replace(" ", "\n", 1), partial(cell, verdict), side="r")
        for verdict in FLAGGED
    ]


class PrintedBody:
    """The sections on one valve body.

    Parameters
    ----------
    number
        of the valve body, from 1 on: its charts are named by it.
    among
        of how many that have sections; the more, the less of each is printed.
    """

    def __init__(self, words: FleetWords, body: ValveBody, number: int, among: int) -> None:
        self.words, self.say, self.body = words, words.say, body
        self.number, self.depth = number, _DEPTHS[among]
        self.charts: dict[str, str] = {}
        self.leading = [pair for pair in body.pairs if pair.flagged.count][: self.depth.pairs]

    def intro(self) -> Iterator[Block]:
        """Say how many units there are, what leads, and what to know about them."""
        say, counts = self.say, self.body.counts
        key = "body_units"
        if counts.units == 1:
            key = "body_unit" if counts.judged else "body_unit_unmeasured"
        said = [
            say(
                f"fleet_summary.{key}",
                units=say.number(counts.units, 0),
                judged=say.number(counts.judged, 0),
                visits=say.number(self.body.visits, 0),
            )
        ]
        if counts.judged:
            said.append(say("fleet_summary.headline", rate=self.words.rate(counts.rates[Verdict.REPLACE])))
            said.append(self.words.leading_pair(self.body))
        yield text(" ".join(said))
        yield from self.about()

    def about(self) -> Iterator[Block]:
        """List what to know about the units."""
        items = self.words.messages(self.body.messages)
        if items:
            yield {"kind": "list", "items": items}

    def sections(self) -> Iterator[tuple[str, Iterator[Block]]]:
        """Yield the sections in their order, each by its name."""
        yield "pairs", self._pairs()
        yield "deciders", self._deciders()
        yield "wear", self._wear()
        yield "temperatures", self._temperatures()
        yield "conditions", self._conditions()
        yield "comparison", self._comparison()

    def _image(self, name: str, drawing: str, alt: str, caption: str, legend: Sequence[Verdict | Band] = ()) -> Block:
        file = f"{name}-{self.number}"
        self.charts[file] = drawing
        block: Block = {"kind": "image", "file": file, "alt": alt, "caption": caption}
        if legend:
            block["legend"] = [
                [level.verdict if isinstance(level, Band) else level, self.say.level(level)] for level in legend
            ]
        return block

    def _named(self) -> str:
        return self.words.body(self.body.controller)

    # --- pairs

    def _pairs(self) -> Iterator[Block]:
        say, body = self.say, self.body
        if not body.counts.judged:
            return
        if not self.leading:
            yield text(say("fleet_summary.no_pair_flagged"))
            return
        named = [self.words.land(body.controller, pair.key) for pair in self.leading]
        rows = [PairRow(name, pair.flagged, pair.replace) for name, pair in zip(named, self.leading, strict=True)]
        if self.depth.bars:
            rate = self.words.counted(self.leading[0].replace)
            yield self._image(
                "pairs",
                pairs_chart(rows, say("fleet_summary.chart_pairs"), say),
                say("fleet_summary.alt_pairs", body=self._named(), pair=named[0], rate=rate),
                say("fleet_summary.caption_pairs"),
                (FLAGGED[0], Verdict.REPLACE),
            )
        yield table(
            [
                PrintedColumn(say("printed.pair"), lambda pair: self.words.land(body.controller, pair.key), width=1),
                PrintedColumn(say("fleet_columns.measured"), lambda pair: say.number(pair.flagged.of, 0), side="r"),
                *(self._pair_rate(name) for name in ("flagged", "replace", "deciding")),
            ],
            self.leading,
        )
        flagged = sum(pair.flagged.count > 0 for pair in body.pairs)
        said = [say("fleet_summary.note_pairs", judged=say.number(body.counts.judged, 0))]
        if flagged > len(self.leading):
            said.append(say("fleet_summary.more_pairs", count=flagged - len(self.leading)))
        yield text(" ".join(said), small=True)

    def _pair_rate(self, name: str) -> PrintedColumn:
        def cell(pair: PairTrouble) -> str:
            return self.words.percent(getattr(pair, name))

        return PrintedColumn(self.say(f"fleet_columns.pair_{name}"), cell, side="r")

    def _deciders(self) -> Iterator[Block]:
        say, deciders = self.say, self.body.deciders[: self.depth.deciders]
        if not deciders:
            return
        yield table(
            [
                PrintedColumn(
                    say("fleet_columns.decided_by"),
                    lambda each: self.words.decider(self.body.controller, each),
                    width=1,
                ),
                PrintedColumn(say("fleet_columns.flagged"), lambda each: self.words.counted(each.units), side="r"),
                PrintedColumn(say("fleet_columns.of_flagged"), lambda each: self.words.percent(each.units), side="r"),
            ],
            deciders,
        )
        yield text(say("fleet_summary.note_deciders"), small=True)

    # --- wear

    def _wear(self) -> Iterator[Block]:
        say, body = self.say, self.body
        wear = {land.key: land for land in body.wear}
        wanted = [wear[pair.key] for pair in body.pairs if pair.key in wear]
        shown = [land for land in wanted if land.classes][: self.depth.wear]
        if not any(land.latest_percent for land in body.wear):
            return
        if not shown:
            yield text(say("fleet_summary.no_mileage"))
            return
        fields = [WearField(self.words.land(body.controller, land.key), land.classes) for land in shown]
        yield self._image(
            "wear",
            wear_chart(fields, say),
            say("fleet_summary.alt_wear", body=self._named(), pairs=joined((field.name for field in fields), "; ")),
            f"{say('fleet_summary.caption_boxes')} {say('fleet_summary.caption_wear')}",
        )
        without = max(land.without_mileage for land in body.wear)
        repaired = max(land.repaired for land in body.wear)
        if without or repaired:
            yield text(say("fleet_summary.note_wear", without=without, repaired=repaired), small=True)

    # --- temperatures and conditions

    def _temperatures(self) -> Iterator[Block]:
        say, classes = self.say, self.body.temperatures
        if not any(each.share_percent or each.pressure_kpa for each in classes):
            yield text(say("fleet_summary.no_logs"))
            return
        hours = sum(each.seconds for each in classes) / 3600.0
        ends = [classes[0].low_c, classes[-1].high_c]
        said = [] if f"wear-{self.number}" in self.charts else [say("fleet_summary.caption_boxes")]
        said.append(say("fleet_summary.caption_temperatures", hours=say.number(hours, 1)))
        yield self._image(
            "temperatures",
            temperatures_chart(classes, say, low=not self.depth.bars),
            say("fleet_summary.alt_temperatures", body=self._named(), span=say.span(ends, "temperature", 0)),
            " ".join(said),
            BANDS if any(each.bands_percent for each in classes) else (),
        )

    def _conditions(self) -> Iterator[Block]:
        say, conditions = self.say, self.body.conditions
        if not conditions:
            return

        def pressure(value: float | None) -> str:
            return say.value(value, "pressure", 0)

        def held(part: Callable[[Spread], str]) -> Callable[[ConditionSpread], str]:
            return lambda at: "–" if at.pressure_held_kpa is None else part(at.pressure_held_kpa)

        def share(part: Callable[[Spread], str]) -> Callable[[ConditionSpread], str]:
            return lambda at: "–" if at.share_percent is None else part(at.share_percent)

        unit = say.unit("pressure")
        columns = [
            PrintedColumn(say("printed.condition"), self.words.condition, width=1),
            PrintedColumn(say("fleet_columns.units"), share(lambda each: say.number(each.units, 0)), side="r"),
            PrintedColumn(
                say("fleet_columns.share_median"), share(lambda each: say.number(each.median, 1)), "%", side="r"
            ),
            PrintedColumn(say("fleet_columns.most_of_all"), share(partial(self._most, percent=True)), "%", side="r"),
            PrintedColumn(say("fleet_columns.held_median"), held(lambda each: pressure(each.median)), unit, side="r"),
            PrintedColumn(say("fleet_columns.most_of_all"), held(partial(self._most, percent=False)), unit, side="r"),
            PrintedColumn(say("printed.required"), lambda at: pressure(at.required_kpa), unit, side="r"),
            PrintedColumn(say("fleet_columns.red"), self._red, side="r"),
        ]
        yield table(columns, conditions)
        partly = max(at.partly for at in conditions)
        said = [say("fleet_summary.note_conditions")]
        if partly:
            said.append(say("fleet_summary.note_partly", count=partly))
        yield text(" ".join(said), small=True)

    def _most(self, spread: Spread, *, percent: bool) -> str:
        """Write between which values nine of ten units are; of too few units, the least and the most, in brackets."""
        ends = (spread.least, spread.most) if spread.quantiles is None else (spread.quantiles[0], spread.quantiles[-1])
        say = self.say
        written = [say.number(end, 1) if percent else say.value(end, "pressure", 0) for end in ends]
        within = "–".join(dict.fromkeys(written))
        return within if spread.enough else f"({within})"

    def _red(self, at: ConditionSpread) -> str:
        units = sum(at.bands.values())
        red = at.bands[Band.RED] + at.bands[Band.CRITICAL]
        return self.say("fleet_summary.chart_rate", count=self.say.number(red, 0), of=self.say.number(units, 0))

    # --- groups

    def _comparison(self) -> Iterator[Block]:
        comparison, say = self.body.comparison, self.say
        if comparison is None:
            if self.words.summary.by is not None:
                yield text(say("fleet_summary.one_group", by=self.words.heading()))
            return
        how = "in_pairs" if comparison.in_pairs else "with_others"
        yield text(say(f"fleet_summary.{how}", by=self.words.heading(), count=len(comparison.groups)))
        groups = sorted(comparison.groups, key=lambda group: -group.counts.units)[: self.depth.groups]
        judged = [(within(group.name, NAME), group.counts.rates) for group in groups if group.counts.judged]
        if judged and self.depth.bars:
            yield self._image(
                "groups",
                groups_chart(
                    [GroupRow(*each) for each in judged],
                    say("fleet_summary.chart_groups"),
                    say,
                ),
                say(
                    "fleet_summary.alt_groups",
                    body=self._named(),
                    groups=joined(name for name, _ in judged),
                ),
                say("fleet_summary.caption_groups"),
                FLAGGED,
            )
        yield self._groups_table(groups, comparison)
        yield from self._rates(comparison)
        yield from self._wear_compared(comparison)
        items = self.words.messages(comparison.messages)
        if items:
            yield {"kind": "list", "items": items}

    def _groups_table(self, groups: Sequence[Group], comparison: GroupComparison) -> Block:
        say = self.say

        def mileage(group: Group) -> str:
            return say.value(group.mileage_km.median if group.mileage_km else None, "distance", 0)

        made = table(
            [
                PrintedColumn(self.words.heading(), lambda group: within(group.name, NAME), width=1),
                PrintedColumn(say("fleet_columns.units"), lambda group: say.number(group.counts.units, 0), side="r"),
                PrintedColumn(say("fleet_columns.judged"), lambda group: say.number(group.counts.judged, 0), side="r"),
                PrintedColumn(say("fleet_columns.mileage_median"), mileage, say.unit("distance"), side="r"),
                *rate_columns(self.words, lambda group: group.counts),
            ],
            groups,
        )
        left = len(comparison.groups) - len(groups)
        said = [say("fleet_summary.more_groups", count=left)] if left else []
        if comparison.not_stated:
            said.append(say("fleet_summary.not_stated", count=comparison.not_stated))
        return {**made, "note": " ".join(said)} if said else made

    def _rates(self, comparison: GroupComparison) -> Iterator[Block]:
        say = self.say
        decided = [each for each in comparison.verdicts if each.points and each.points.differs is not None]
        found = [each for each in decided if each.points and each.points.differs]
        if not decided:
            yield text(say("fleet_summary.rates_too_few"))
        elif not found:
            yield text(say("fleet_summary.rates_alike", count=len(decided)))
        else:
            yield text(say("fleet_summary.rates_differ", found=len(found), count=len(decided)), leads=True)
            found.sort(key=lambda each: -abs(each.points.value if each.points else 0.0))
            yield {
                "kind": "list",
                "items": [self.words.difference_of_rates(each) for each in found[: self.depth.differences]],
            }

    def _wear_compared(self, comparison: GroupComparison) -> Iterator[Block]:
        say = self.say
        decided = [each for each in comparison.lands if called(each) is not None]
        found = [each for each in decided if called(each)]
        if not decided:
            yield text(say("fleet_summary.wear_too_few"))
            return
        if not found:
            yield text(say("fleet_summary.wear_alike", count=len(decided)))
            return
        yield text(say("fleet_summary.wear_differs", found=len(found), count=len(decided)), leads=True)
        yield table(
            [
                PrintedColumn(
                    say("printed.pair"), lambda each: self.words.land(self.body.controller, each.key), width=3
                ),
                PrintedColumn(say("fleet_columns.compared"), self._sides, width=3),
                PrintedColumn(say("fleet_columns.means"), self._means, "%", side="r"),
                PrintedColumn(say("fleet_columns.mean_points"), lambda each: self._points(each.mean_points), side="r"),
                PrintedColumn(
                    say("fleet_columns.same_mileage"),
                    lambda each: self._points(each.same_mileage_points),
                    side="r",
                ),
            ],
            found[: self.depth.differences],
        )
        more = len(found) - self.depth.differences
        said = [say("fleet_summary.note_wear_compared")]
        if more > 0:
            said.append(say("fleet_summary.more_differences", count=more))
        yield text(" ".join(said), small=True)

    def _sides(self, each: WearDifference) -> str:
        first, second = (within(name, NAME) for name in (each.first, self.words.second(each.second)))
        return self.say("fleet_summary.sides", first=first, second=second)

    def _means(self, each: WearDifference) -> str:
        means = (each.first_percent, each.second_percent)
        return " / ".join(self.say.number(mean.mean if mean else None, 1) for mean in means)

    def _points(self, found: Difference | None) -> str:
        if found is None:
            return "–"
        within = self.words.interval(found.low_of_all, found.high_of_all)
        value = self.words.points(found.value)
        return f"{value}\u00a0({within})" if within else value
