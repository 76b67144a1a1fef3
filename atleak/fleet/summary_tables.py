"""The tables of a fleet's summary, each said once: a workbook has all of their columns, other media a few of them.

A rate, a spread or a difference is one column of words, whose parts are the numbers that a workbook has instead.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

from atleak.analysis.rates import Rate, Spread
from atleak.common.verdicts import BANDS, FLAGGED, VERDICTS, Band, Verdict
from atleak.common.wording import Wording
from atleak.diagnosis.uncertainty import DECISIONS
from atleak.fleet.summary_words import FleetWords, called, cumulated
from atleak.fleet.sums import ConditionSpread, FleetSummary, LandOverMileage, ValveBody, VerdictCounts
from atleak.report.tables.table import VERDICT, Column, Judged, Table

_QUANTILES = (
    "quantile_5",
    "quantile_25",
    "median",
    "quantile_75",
    "quantile_95",
)  # `atleak.analysis.rates.SHOWN_QUANTILES`
_Of = str | Callable[[Any], Any]  # what a cell holds of its row, or the names that lead there from it, or its item
Bodies = Iterable[ValveBody]


class SummaryRow(NamedTuple):
    """A row of a table: an item of a valve body."""

    body: ValveBody
    item: Any
    more: Any = None


class Counted(NamedTuple):
    """The verdicts of some units: of all, of a valve body, of a group in it."""

    body: ValveBody | None  # None: all of them
    group: str | None  # None: all of them
    counts: VerdictCounts
    mileage: Spread | None = None


def _counted(summary: FleetSummary) -> Iterator[Counted]:
    """Yield the units of all valve bodies, of each, then of their groups: the valve bodies stand together."""
    yield Counted(None, None, summary.counts)
    yield from (Counted(body, None, body.counts) for body in summary.bodies)
    yield from (Counted(None, group.name, group.counts, group.mileage_km) for group in summary.groups)
    for body in summary.bodies if len(summary.bodies) > 1 else ():
        yield from counted_groups(body)


def counted_groups(body: ValveBody) -> Iterator[Counted]:
    """Yield the units of every group of a valve body."""
    for group in body.comparison.groups if body.comparison else ():
        yield Counted(body, group.name, group.counts, group.mileage_km)


def by_trouble(body: ValveBody) -> list[LandOverMileage]:
    """Return the lands over mileage, those first that are most often at *replace*."""
    places = {pair.key: place for place, pair in enumerate(body.pairs)}
    return sorted(body.wear, key=lambda land: (places.get(land.key, len(places)), land.key))


class FleetTables:
    """The tables of a summary, in its reader's words."""

    def __init__(self, words: FleetWords) -> None:
        self.words, self.say, self.summary = words, words.say, words.summary

    def all(self) -> list[Table]:
        """Return the tables that have any row, in their order."""
        bodies = self.summary.bodies
        made = (
            self.verdicts(_counted(self.summary)),
            *(table(bodies) for table in (self.pairs, self.deciders, self.wear, self.latest)),
            *(table(bodies) for table in (self.temperatures, self.conditions, self.rates_compared)),
            self.wear_compared(bodies),
            self.units(),
            self.errors(),
        )
        return [table for table in made if table.rows]

    def verdicts(self, rows: Iterable[Counted]) -> Table:
        """Return how many units have which verdict, and which share of them is at a verdict or past it."""
        say, words, listed = self.say, self.words, list(rows)
        heading = words.heading() or say("fleet_summary.group")
        every, all_units = say("fleet_summary.all_bodies"), say("fleet_summary.all_units")
        columns = [
            self._text("body", lambda row: words.body(row.body.controller) if row.body else every, width=150),
            self._text("group", lambda row: all_units if row.group is None else row.group, heading, width=150),
            self._count("units", "counts.units"),
            *(
                self._count(f"verdict_{level}", partial(_counted_at, level), words=say.level(level))
                for level in VERDICTS
            ),
            self._count("judged", "counts.judged"),
            *(
                self._rate(
                    f"past_{level}", partial(_rate_at, level), words.or_worse(level).replace(" ", "\n", 1), whole=False
                )
                for level in FLAGGED
            ),
            *(
                self._count(key, f"counts.{key}")
                for key in ("ok_throughout", "ok_in_part", "without_sheet", "provisional")
            ),
            *(
                self._count(f"decision_{decision}", partial(_decided, decision), words=say(f"decisions.{decision}"))
                for decision in DECISIONS
            ),
            self._spread("mileage", "distance", "mileage", 0, ends=False),
        ]
        made = self._table("verdicts", columns, listed)
        left_out = ["group"] * (self.summary.by is None) + ["mileage"] * (not any(row.mileage for row in listed))
        return made.without(*left_out)

    def pairs(self, bodies: Bodies) -> Table:
        """Return how often each land is flagged, at *replace* or past it, and decides."""
        columns = [
            *self._land_columns(),
            self._count("measured", "flagged.of"),
            self._rate("pair_replace", "replace", whole=False),
            self._number("cumulated", "percent", lambda row: row.more),
            self._rate("pair_flagged", "flagged", whole=False),
            self._rate("pair_deciding", "deciding"),
            self._count("pair_not_measured", "not_measured"),
            self._count("one_part", "flagged_by_one_part"),
        ]
        rows = [
            SummaryRow(body, *each) for body in bodies for each in zip(body.pairs, cumulated(body.pairs), strict=True)
        ]
        return self._table("pairs", columns, rows)

    def deciders(self, bodies: Bodies) -> Table:
        """Return what gave the verdicts of the flagged units."""
        rate = replace(self._rate("decided", "units"), of=lambda row: self.words.rate(row.item.units), words_of=None)
        named = self._text("decided_by", lambda row: self.words.decider(row.body.controller, row.item))
        rows = [SummaryRow(body, decider) for body in bodies for decider in body.deciders]
        return self._table("deciders", [self._body(), replace(named, width=150), rate], rows)

    def wear(self, bodies: Bodies) -> Table:
        """Return the wear of every land in classes of mileage."""
        columns = [
            *self._land_columns(),
            self._class("mileage", "distance", lambda row: (row.more.low_km, row.more.high_km)),
            self._spread("wear", "percent", lambda row: row.more.wear_percent),
        ]
        rows = [SummaryRow(body, land, each) for body in bodies for land in by_trouble(body) for each in land.classes]
        return self._table("wear", columns, rows)

    def latest(self, bodies: Bodies) -> Table:
        """Return the wear of every land at the visit that counts."""
        columns = [
            *self._land_columns(),
            self._spread("latest", "percent", "latest_percent"),
            self._count("without_mileage"),
            self._count("repaired"),
        ]
        rows = [SummaryRow(body, land) for body in bodies for land in by_trouble(body)]
        return self._table("latest", columns, rows)

    def temperatures(self, bodies: Bodies) -> Table:
        """Return what the logs say in classes of fluid temperature."""
        time, say = self.say("fleet_columns.band_time"), self.say
        in_bands = (
            replace(
                self._number("band_time", "percent", partial(_time_in, band)),
                key=f"band_{band}",
                words=say("fleet_parts.of", what=time, part=say.level(band)),
            )
            for band in BANDS
        )
        columns = [
            self._body(),
            self._class("temperature", "temperature", lambda row: (row.item.low_c, row.item.high_c)),
            self._number("hours", "number", lambda row: row.item.seconds / 3600.0, 2),
            self._number("share_mean", "percent", "share_mean_percent"),
            self._spread("share", "percent", "share_percent", ends=False),
            self._number("share_max", "percent", "share_max_percent"),
            self._number("pressure_mean", "pressure", "pressure_mean_kpa", 0),
            self._spread("pressure", "pressure", "pressure_kpa", 0, ends=False),
            self._number("pressure_min", "pressure", "pressure_min_kpa", 0),
            *in_bands,
        ]
        return self._table(
            "temperatures", columns, [SummaryRow(body, each) for body in bodies for each in body.temperatures]
        )

    def conditions(self, bodies: Bodies) -> Table:
        """Return the stated conditions over the units."""
        units, say = self.say("fleet_columns.band_units"), self.say
        in_bands = [
            self._count(
                f"band_{band}", partial(_units_in, band), say("fleet_parts.of", what=units, part=say.level(band))
            )
            for band in BANDS
        ]
        red = Column("red", of=self._red, words=say("fleet_columns.red"), parts=tuple(in_bands))
        columns = [
            self._body(),
            self._text("condition", lambda row: self.words.condition(row.item), width=190),
            self._number("temperature", "temperature", "temperature_c", 0),
            self._number("engine_speed", "engine_speed", "engine_rpm", 0),
            self._count("gear"),
            self._spread("share", "percent", "share_percent"),
            self._number("required", "pressure", "required_kpa", 0),
            self._spread("held", "pressure", "pressure_held_kpa", 0),
            red,
            self._count("partly"),
        ]
        return self._table(
            "conditions", columns, [SummaryRow(body, each) for body in bodies for each in body.conditions]
        )

    def _red(self, row: SummaryRow) -> str:
        at: ConditionSpread = row.item
        red = at.bands[Band.RED] + at.bands[Band.CRITICAL]
        return self.words.counted(red, sum(at.bands.values()))

    def rates_compared(self, bodies: Bodies) -> Table:
        """Return the differences of the rates of verdicts between groups."""
        columns = [
            self._body(),
            self._text("first"),
            self._text("second", lambda row: self.words.second(row.item.second)),
            self._verdict("verdict_or_worse", "verdict"),
            self._count("first_units"),
            self._count("second_units"),
            self._difference("rate_points", "points"),
        ]
        rows = [SummaryRow(body, each) for body in bodies if body.comparison for each in body.comparison.verdicts]
        return self._table("rates_compared", columns, rows)

    def wear_compared(self, bodies: Bodies) -> Table:
        """Return the differences of the wear of lands between groups."""
        words, say = self.words, self.say
        sides = (self._text("first"), self._text("second", lambda row: words.second(row.item.second)))
        means = (
            *self._spread("first_wear", "percent", "first_percent", ends=False).parts,
            *self._spread("second_wear", "percent", "second_percent", ends=False).parts,
        )
        columns = [
            *self._land_columns(),
            self._text("compared", lambda row: words.sides(row.item), parts=sides, width=150),
            self._text("means", lambda row: words.means(row.item), parts=means, words_of="percent"),
            self._difference("mean_points"),
            self._difference("same_mileage", "same_mileage_points"),
            self._in_points(self._text("median_points", digits=1)),
            self._text("differs", lambda row: words.differs(called(row.item)), words=say("fleet_parts.differs")),
        ]
        rows = [SummaryRow(body, each) for body in bodies if body.comparison for each in body.comparison.lands]
        return self._table("wear_compared", columns, rows)

    def units(self, group: _Of | None = None) -> Table:
        """Return the units, the worst first; unless it is given, with the group by which the summary is."""
        words, say = self.words, self.say
        told_by = tuple(map(self._text, ("serial", "vin", "number")))
        columns = [
            self._text("name", width=190),
            self._verdict("verdict"),
            self._text("decision", lambda unit: say.get("decisions", unit.decision) if unit.decision else None),
            self._text("decided_by", lambda unit: words.decided_by(unit) or None, width=240),
            self._count("lands_past"),
            self._text("lands_measured", words.lands_measured, say("columns.measured").lower()),
            self._number("share_max", "percent", "max_share_percent"),
            self._text("group", group or "label", words=words.heading() or say("fleet_summary.group"), width=100),
            self._text("told_by", lambda unit: unit.serial or unit.vin or unit.number, parts=told_by, width=100),
            self._text("date"),
            self._number("mileage", "distance", "mileage_km", 0),
            self._text("body", lambda unit: words.body(unit.controller)),
            self._text("provisional_unit", "provisional"),
            self._count("visits"),
            self._text("reference"),
        ]
        made = self._table("units", columns, self.summary.worst)
        return made if group or self.summary.by else made.without("group")

    def errors(self) -> Table:
        """Return the files without a result: each message once, with the first file that has it."""
        columns = [
            self._text("error", lambda row: self.say.get("fleet_errors", row[0].kind)),
            self._count("files", lambda row: row[0].count),
            self._text("name", lambda row: row[1][0]),
            self._text("message", lambda row: row[1][1]),
        ]
        return self._table("errors", columns, [(kind, first) for kind in self.summary.errors for first in kind.first])

    # --- columns

    def _table(self, name: str, columns: Sequence[Column], rows: Sequence[Any]) -> Table:
        return Table(name, tuple(columns), rows, self.say, self.say(f"fleet_sheets.{name}"))

    def _text(self, key: str, of: _Of = "", words: str = "", **more: Any) -> Column:
        """Return a column of words."""
        notes = self.say.table("fleet_notes")
        note = notes.get("past" if key.startswith("past_") else key, "")
        return Column(key, words=words or self.say(f"fleet_columns.{key}"), of=_found(of or key), note=note, **more)

    def _count(self, key: str, of: _Of = "", words: str = "") -> Column:
        """Return a column of numbers of units, files, lands …."""
        return self._text(key, of, words, digits=0)

    def _number(self, key: str, kind: str, of: _Of, digits: int | None = None) -> Column:
        return self._text(key, of, kind=kind, digits=digits)

    def _verdict(self, key: str, of: _Of = "") -> Column:
        return self._text(key, of, kind=VERDICT, width=92)

    def _body(self) -> Column:
        return self._text("body", lambda row: self.words.body(row.body.controller))

    def _land_columns(self) -> tuple[Column, ...]:
        """Return the columns that name the valve body, and a land of it in short and in full."""
        words = self.words
        return (
            self._body(),
            self._text("pair_number", lambda row: words.land_number(row.body.controller, row.item.key)),
            self._text("pair", lambda row: words.land(row.body.controller, row.item.key), width=150),
        )

    def _part(self, whole: Column, part: str, of: Callable[[Any], Any], **more: Any) -> Column:
        """Return the column of one of the numbers that a thing is made of."""
        part_word, about = self.say(f"fleet_parts.{part}"), self.say.table("fleet_part_notes")[part]
        words = self.say("fleet_parts.of", what=whole.title(self.say), part=part_word) if part_word else whole.words
        note = " ".join(filter(None, (whole.note, about)))
        return Column(f"{whole.key}.{part}", words=words, of=of, note=note, **more)

    def _rate(self, key: str, of: _Of, words: str = "", *, whole: bool = True) -> Column:
        """Return the column of a rate: how many, of how many unless that is elsewhere, per cent and its interval."""
        rate: Callable[[Any], Rate] = _found(of)
        made = self._text(key, lambda row: self.words.percent(rate(row)), words, words_of="percent")
        parts = [self._part(made, "count", lambda row: rate(row).count, digits=0)]
        if whole:
            parts.append(self._part(made, "units", lambda row: rate(row).of, digits=0))
        shares = {"percent": "percent", "low": "low_percent", "high": "high_percent"}
        parts += [self._part(made, part, partial(_of_it, rate, name), kind="percent") for part, name in shares.items()]
        return replace(made, parts=tuple(parts))

    def _spread(self, key: str, kind: str, of: _Of, digits: int | None = None, *, ends: bool = True) -> Column:
        """Return the column of a spread: of how many units, mean, quantiles, and its ends unless they are elsewhere."""
        spread: Callable[[Any], Spread | None] = _found(of)
        made = self._text(key, lambda row: self.words.spread(spread(row), kind, digits), words_of=kind)
        names = ["mean", *["least"] * ends, *_QUANTILES, *["most"] * ends]
        values = (self._part(made, name, partial(_of_spread, spread, name), kind=kind, digits=digits) for name in names)
        units = self._part(made, "units", partial(_of_it, spread, "units"), digits=0)
        return replace(made, parts=(units, *values))

    def _difference(self, key: str, of: _Of = "") -> Column:
        """Return the column of a difference with both of its intervals, and whether it is one."""
        found = _found(of or key)
        made = self._text(key, lambda row: self.words.difference(found(row)))
        names = {"points": "value", **{end: end for end in ("low", "high", "low_of_all", "high_of_all")}}
        parts = (
            self._in_points(self._part(made, part, partial(_of_it, found, name), digits=1))
            for part, name in names.items()
        )
        differs = self._part(made, "differs", lambda row: self.words.differs(_of_it(found, "differs", row)))
        return replace(made, parts=(*parts, differs))

    def _in_points(self, column: Column) -> Column:
        return replace(column, words=f"{column.words} [{self.say('fleet_parts.unit_of_points')}]")

    def _class(self, key: str, kind: str, of: Callable[[Any], tuple[float, float]]) -> Column:
        """Return the column of a class of a quantity, whose parts are where it begins, where it ends and its middle."""
        parts = (
            self._number(f"{key}_from", kind, lambda row: of(row)[0], 0),
            self._number(f"{key}_to", kind, lambda row: of(row)[1], 0),
            self._number(f"{key}_middle", kind, lambda row: 0.5 * sum(of(row)), 1 if kind == "temperature" else 0),
        )
        words = partial(_class_words, of, kind, self.say)
        return self._text(key, words, words_of=kind, parts=parts)


# --- what cells hold


def _found(of: _Of) -> Callable[[Any], Any]:
    """Return what finds a cell's value: by the names that lead there from a row or its item; None where one is none."""
    if callable(of):
        return of

    def found(row: Any) -> Any:
        value = row.item if isinstance(row, SummaryRow) else row
        for name in of.split("."):
            value = None if value is None else getattr(value, name)
        return value

    return found


def _of_it(found: Callable[[Any], Any], name: str, row: Any) -> Any:
    it = found(row)
    return None if it is None else getattr(it, name)


def _of_spread(found: Callable[[Any], Spread | None], name: str, row: Any) -> float | None:
    spread = found(row)
    if spread is None or not name.startswith("quantile"):
        return None if spread is None else getattr(spread, name)
    return None if spread.quantiles is None else spread.quantiles[_QUANTILES.index(name)]


def _counted_at(level: Verdict, row: Counted) -> Judged:
    count = row.counts.verdicts[level]
    return Judged(count, level if count else None)


def _rate_at(level: Verdict, row: Counted) -> Rate:
    return row.counts.rates[level]


def _decided(decision: Any, row: Counted) -> int:
    return row.counts.decisions.get(decision, 0)


def _time_in(band: Band, row: SummaryRow) -> float | None:
    bands = row.item.bands_percent
    return None if bands is None else bands.get(band, 0.0)


def _units_in(band: Band, row: SummaryRow) -> int:
    return int(row.item.bands.get(band, 0))


def _class_words(of: Callable[[Any], tuple[float, float]], kind: str, say: Wording, row: Any) -> str:
    return "–".join(say.value(end, kind, 0) for end in of(row))
