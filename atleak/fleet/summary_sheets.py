"""Lay out the tables of a fleet's summary as a workbook has them: what each sheet lists, column by column."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from atleak.fleet.summary_words import FleetWords, cumulated
from atleak.fleet.summed import Difference, FleetSummary, GroupComparison, LandOverMileage, ValveBody, VerdictCounts
from atleak.spreads import Rate, Spread
from atleak.uncertainty import DECISIONS
from atleak.verdicts import BANDS, FLAGGED, VERDICTS, Verdict
from atleak.wording import Wording

Cell = str | float | int | bool | dt.date | None
_COUNT, _TEXT = "#,##0", ""
_DATE = "yyyy-mm-dd"
_PARTS = ("quantile_5", "quantile_25", "median", "quantile_75", "quantile_95")  # `atleak.spreads.PARTS`
_NUMBER, _LEAST, _MOST, _LONG = 12, 10, 48, 90  # [characters] of columns: numbers, words, long texts that wrap


@dataclass(frozen=True)
class SheetColumn:
    """A column of a sheet: where its number is found again, what stands over it, what it means, and its cells."""

    key: str  # the same in every language: ``replace.percent``
    heading: str  # with its unit
    note: str  # what it means
    cell: Callable[[Any], Cell]
    form: str = _TEXT  # Excel's format of its numbers
    verdict: bool = False  # whether its cells are words of verdicts
    wrapped: bool = False  # whether its cells are long texts
    what: str = ""  # the heading alone, where several columns are parts of one thing
    about: str = ""  # what this thing means
    part: str = ""  # which of its parts this is: key of its words

    @property
    def is_number(self) -> bool:
        """Return whether its cells hold numbers."""
        return bool(self.form)

    def width(self, rows: Sequence[Any]) -> int:
        """Return how wide it is [characters]: its words, up to a limit."""
        if self.wrapped:
            return _LONG
        if self.is_number:
            return _NUMBER
        return min(max([_LEAST, *(len(str(self.cell(row) or "")) + 2 for row in rows)]), _MOST)


@dataclass(frozen=True)
class SummarySheet:
    """A sheet with one row for each item."""

    name: str  # the same in every language: key of its name and of what it says
    columns: tuple[SheetColumn, ...]
    rows: tuple[Any, ...]
    frozen: int = 1  # columns that stay in sight

    @cached_property
    def widths(self) -> tuple[int, ...]:
        """Return the widths of its columns [characters]."""
        return tuple(column.width(self.rows) for column in self.columns)

    def column(self, key: str) -> int:
        """Return the number of a column, from 0 on."""
        return next(number for number, column in enumerate(self.columns) if column.key == key)

    def stretch(self, wanted: Callable[[Any], bool]) -> tuple[int, int] | None:
        """Return the first and the last row of the sheet that hold such items, which stand together; None without."""
        found = [number for number, row in enumerate(self.rows, start=1) if wanted(row)]
        return (found[0], found[-1]) if found else None


@dataclass(frozen=True)
class Counted:
    """The verdicts of some units: of all, of a valve body, of a group in it."""

    body: ValveBody | None  # None: all of them
    group: str | None  # None: all of them
    counts: VerdictCounts
    mileage: Spread | None = None


@dataclass
class _Columns:
    """Makes the columns of one sheet."""

    say: Wording
    made: list[SheetColumn] = field(default_factory=list)
    headings: dict[str, str] = field(default_factory=dict)  # by key, of those that are no text of their own

    def text(self, key: str, cell: Callable[[Any], Cell], heading: str = "", **more: Any) -> None:
        """Add a column of words, or of dates."""
        said = heading or self._heading(key)
        self.made.append(SheetColumn(key, said, self._note(key), cell, **more))

    def count(self, key: str, cell: Callable[[Any], int | None], heading: str = "") -> None:
        """Add a column of numbers of units, files, lands …."""
        self.made.append(SheetColumn(key, heading or self._heading(key), self._note(key), cell, _COUNT))

    def number(
        self,
        key: str,
        kind: str,
        cell: Callable[[Any], float | None],
        digits: int | None = None,
        part: str = "",
        unit: str = "",
    ) -> None:
        """Add a column of a kind of quantity, in the reader's unit; ``part`` says which value of several it is."""
        say = self.say
        unit, places = unit or say.unit(kind), say.digits(kind, digits)

        def shown(row: Any) -> float | None:
            value = cell(row)
            return None if value is None else float(say.convert(value, kind))

        self._add(key, part, shown, _COUNT + ("." + "0" * places if places else ""), unit)

    def units(self, key: str, cell: Callable[[Any], int | None]) -> None:
        """Add a column that says of how many units the next ones are."""
        self._add(key, "units", cell, _COUNT)

    def rate(self, key: str, of: Callable[[Any], Rate], *, whole: bool = True) -> None:
        """Add the columns of a rate: how many, of how many unless that stands elsewhere, per cent and its interval."""
        self._add(key, "count", lambda row: of(row).count, _COUNT)
        if whole:
            self.units(key, lambda row: of(row).of)
        self.number(key, "percent", lambda row: of(row).percent, part="percent")
        self.number(key, "percent", lambda row: of(row).low_percent, part="low")
        self.number(key, "percent", lambda row: of(row).high_percent, part="high")

    def spread(
        self, key: str, kind: str, of: Callable[[Any], Spread | None], digits: int | None = None, *, ends: bool = True
    ) -> None:
        """Add the columns of a spread: of how many units, mean, quantiles, and its ends unless they stand elsewhere."""

        def of_it(value: Callable[[Spread], float | None]) -> Callable[[Any], float | None]:
            return lambda row: None if of(row) is None else value(_known(of(row)))

        def quantile(number: int) -> Callable[[Spread], float | None]:
            return lambda spread: None if spread.quantiles is None else spread.quantiles[number]

        self.units(key, lambda row: None if of(row) is None else _known(of(row)).units)
        self.number(key, kind, of_it(lambda spread: spread.mean), digits, "mean")
        if ends:
            self.number(key, kind, of_it(lambda spread: spread.least), digits, "least")
        for number, part in enumerate(_PARTS):
            values = of_it(lambda spread: spread.median) if part == "median" else of_it(quantile(number))
            self.number(key, kind, values, digits, part)
        if ends:
            self.number(key, kind, of_it(lambda spread: spread.most), digits, "most")

    def difference(self, key: str, words: FleetWords, of: Callable[[Any], Difference | None]) -> None:
        """Add the columns of a difference with both of its intervals, and whether it is one."""

        def end(name: str) -> Callable[[Any], float | None]:
            return lambda row: None if of(row) is None else getattr(of(row), name)

        unit = self.say("fleet_parts.unit_of_points")
        self.number(key, "percent", end("value"), part="points", unit=unit)
        for name in ("low", "high", "low_of_all", "high_of_all"):
            self.number(key, "percent", end(name), part=name, unit=unit)

        def differs(row: Any) -> str:
            found = of(row)
            return words.differs(None if found is None else found.differs)

        self._add(key, "differs", differs)

    def body(self, words: FleetWords, controller: Callable[[Any], str]) -> None:
        """Add the column with the valve body."""
        self.text("body", lambda row: words.body(controller(row)))

    def pair(self, words: FleetWords, of: Callable[[Any], tuple[str, Any]]) -> None:
        """Add the columns that name a land, in short and in full."""
        self.text("pair_number", lambda row: words.land_number(of(row)[0], of(row)[1].key))
        self.text("pair", lambda row: words.land(of(row)[0], of(row)[1].key))

    def _add(self, key: str, part: str, cell: Callable[[Any], Cell], form: str = _TEXT, unit: str = "") -> None:
        """Add a column that is one part of a thing, or the whole of it."""
        heading = what = self._heading(key)
        note = about = self._note(key)
        if part:
            said = self.say(f"fleet_parts.{part}")
            heading = self.say("fleet_parts.of", what=what, part=said) if said else what
            note = " ".join(filter(None, (about, self.say(f"fleet_part_notes.{part}"))))
            key = f"{key}.{part}"
        heading = f"{heading} [{unit}]" if unit else heading
        self.made.append(SheetColumn(key, heading, note, cell, form, what=what, about=about, part=part))

    def _heading(self, key: str) -> str:
        return self.headings.get(key) or self.say(f"fleet_columns.{key}").replace("\n", " ")

    def _note(self, key: str) -> str:
        key = "past" if key.startswith("past_") else key  # of every level alike
        return self.say.get("fleet_notes", key) if key in self.say.texts["fleet_notes"] else ""


def _known(spread: Spread | None) -> Spread:
    assert spread is not None
    return spread


def sheets_of(words: FleetWords) -> list[SummarySheet]:
    """Return the sheets that have any row, in their order."""
    made = (
        _verdicts(words),
        _pairs(words),
        _deciders(words),
        _wear(words),
        _latest(words),
        _temperatures(words),
        _conditions(words),
        _rates_compared(words),
        _wear_compared(words),
        _units(words),
        _errors(words),
    )
    return [sheet for sheet in made if sheet.rows]


def _verdicts(words: FleetWords) -> SummarySheet:
    say, summary = words.say, words.summary
    columns = _Columns(say)
    every, all_of_them = say("fleet_summary.all_bodies"), say("fleet_summary.all_units")
    columns.text("body", lambda row: every if row.body is None else words.body(row.body.controller))
    heading = words.heading()
    if heading:
        columns.text("group", lambda row: all_of_them if row.group is None else row.group, heading=heading)
    columns.count("units", lambda row: row.counts.units)
    for verdict in VERDICTS:
        columns.count(f"verdict_{verdict}", _count_of(verdict), say.level(verdict))
    columns.count("judged", lambda row: row.counts.judged)
    for verdict in FLAGGED:
        columns.headings[f"past_{verdict}"] = words.or_worse(verdict)
        columns.rate(f"past_{verdict}", _rate_of(verdict), whole=False)
    columns.count("ok_throughout", lambda row: row.counts.ok_throughout)
    columns.count("ok_in_part", lambda row: row.counts.ok_in_part)
    columns.count("without_sheet", lambda row: row.counts.without_sheet)
    columns.count("provisional", lambda row: row.counts.provisional)
    for decision in DECISIONS:
        columns.count(f"decision_{decision}", _decided(decision), say(f"decisions.{decision}"))
    if any(row.mileage for row in _counted(summary)):
        columns.spread("mileage", "distance", lambda row: row.mileage, 0, ends=False)
    return SummarySheet("verdicts", tuple(columns.made), tuple(_counted(summary)), frozen=2 if heading else 1)


def _count_of(verdict: Verdict) -> Callable[[Counted], int]:
    return lambda row: row.counts.verdicts[verdict]


def _rate_of(verdict: Verdict) -> Callable[[Counted], Rate]:
    return lambda row: row.counts.rates[verdict]


def _decided(decision: Any) -> Callable[[Counted], int]:
    return lambda row: row.counts.decisions.get(decision, 0)


def _counted(summary: FleetSummary) -> Iterator[Counted]:
    """Yield the units of all valve bodies, of each, then of their groups: the valve bodies stand together."""
    yield Counted(None, None, summary.counts)
    yield from (Counted(body, None, body.counts) for body in summary.bodies)
    yield from (Counted(None, group.name, group.counts, group.mileage_km) for group in summary.groups)
    for body in summary.bodies if len(summary.bodies) > 1 else ():
        groups = body.comparison.groups if body.comparison else ()
        yield from (Counted(body, group.name, group.counts, group.mileage_km) for group in groups)


def _pairs(words: FleetWords) -> SummarySheet:
    columns = _Columns(words.say)
    columns.body(words, lambda row: row[0].controller)
    columns.pair(words, lambda row: (row[0].controller, row[1]))
    columns.count("measured", lambda row: row[1].flagged.of)
    columns.rate("pair_replace", lambda row: row[1].replace, whole=False)
    columns.number("cumulated", "percent", lambda row: row[2])
    columns.rate("pair_flagged", lambda row: row[1].flagged, whole=False)
    columns.rate("pair_deciding", lambda row: row[1].deciding)
    columns.count("pair_not_measured", lambda row: row[1].not_measured)
    columns.count("one_part", lambda row: row[1].flagged_by_one_part)
    rows = (
        (body, pair, part)
        for body in words.summary.bodies
        for pair, part in zip(body.pairs, cumulated(body.pairs), strict=True)
    )
    return SummarySheet("pairs", tuple(columns.made), tuple(rows), frozen=3)


def _deciders(words: FleetWords) -> SummarySheet:
    columns = _Columns(words.say)
    columns.body(words, lambda row: row[0].controller)
    columns.text("decided_by", lambda row: words.decider(row[0].controller, row[1]))
    columns.rate("decided", lambda row: row[1].units)
    rows = ((body, decider) for body in words.summary.bodies for decider in body.deciders)
    return SummarySheet("deciders", tuple(columns.made), tuple(rows), frozen=2)


def _ordered(body: ValveBody) -> Iterator[LandOverMileage]:
    """Yield the lands over mileage, those first that are most often at *replace*."""
    places = {pair.key: place for place, pair in enumerate(body.pairs)}
    yield from sorted(body.wear, key=lambda land: (places.get(land.key, len(places)), land.key))


def _wear(words: FleetWords) -> SummarySheet:
    columns = _Columns(words.say)
    columns.body(words, lambda row: row[0].controller)
    columns.pair(words, lambda row: (row[0].controller, row[1]))
    columns.number("mileage_from", "distance", lambda row: row[2].low_km, 0)
    columns.number("mileage_to", "distance", lambda row: row[2].high_km, 0)
    columns.number("mileage_middle", "distance", lambda row: 0.5 * (row[2].low_km + row[2].high_km), 0)
    columns.spread("wear", "percent", lambda row: row[2].wear_percent)
    rows = ((body, land, each) for body in words.summary.bodies for land in _ordered(body) for each in land.classes)
    return SummarySheet("wear", tuple(columns.made), tuple(rows), frozen=3)


def _latest(words: FleetWords) -> SummarySheet:
    columns = _Columns(words.say)
    columns.body(words, lambda row: row[0].controller)
    columns.pair(words, lambda row: (row[0].controller, row[1]))
    columns.spread("latest", "percent", lambda row: row[1].latest_percent)
    columns.count("without_mileage", lambda row: row[1].without_mileage)
    columns.count("repaired", lambda row: row[1].repaired)
    rows = ((body, land) for body in words.summary.bodies for land in _ordered(body))
    return SummarySheet("latest", tuple(columns.made), tuple(rows), frozen=3)


def _temperatures(words: FleetWords) -> SummarySheet:
    say = words.say
    columns = _Columns(say)
    columns.body(words, lambda row: row[0].controller)
    columns.number("temperature_from", "temperature", lambda row: row[1].low_c, 0)
    columns.number("temperature_to", "temperature", lambda row: row[1].high_c, 0)
    columns.number("temperature_middle", "temperature", lambda row: 0.5 * (row[1].low_c + row[1].high_c), 1)
    columns.number("hours", "number", lambda row: row[1].seconds / 3600.0, 2)
    columns.number("share_mean", "percent", lambda row: row[1].share_mean_percent)
    columns.spread("share", "percent", lambda row: row[1].share_percent, ends=False)
    columns.number("share_max", "percent", lambda row: row[1].share_max_percent)
    columns.number("pressure_mean", "pressure", lambda row: row[1].pressure_mean_kpa, 0)
    columns.spread("pressure", "pressure", lambda row: row[1].pressure_kpa, 0, ends=False)
    columns.number("pressure_min", "pressure", lambda row: row[1].pressure_min_kpa, 0)
    for band in BANDS:
        heading = say("fleet_parts.of", what=say("fleet_columns.band_time"), part=say.level(band))
        note = say("fleet_notes.band_time")
        columns.made.append(SheetColumn(f"band_{band}", f"{heading} [%]", note, _band_time(band), "0.0"))
    rows = ((body, each) for body in words.summary.bodies for each in body.temperatures)
    return SummarySheet("temperatures", tuple(columns.made), tuple(rows), frozen=3)


def _band_time(band: Any) -> Callable[[Any], float | None]:
    return lambda row: None if row[1].bands_percent is None else row[1].bands_percent.get(band, 0.0)


def _band_units(band: Any) -> Callable[[Any], int]:
    return lambda row: row[1].bands.get(band, 0)


def _conditions(words: FleetWords) -> SummarySheet:
    say = words.say
    columns = _Columns(say)
    columns.body(words, lambda row: row[0].controller)
    columns.text("condition", lambda row: words.condition(row[1]))
    columns.number("temperature", "temperature", lambda row: row[1].temperature_c, 0)
    columns.number("engine_speed", "engine_speed", lambda row: row[1].engine_rpm, 0)
    columns.count("gear", lambda row: row[1].gear)
    columns.spread("share", "percent", lambda row: row[1].share_percent)
    columns.number("required", "pressure", lambda row: row[1].required_kpa, 0)
    columns.spread("held", "pressure", lambda row: row[1].pressure_held_kpa, 0)
    for band in BANDS:
        heading = say("fleet_parts.of", what=say("fleet_columns.band_units"), part=say.level(band))
        columns.count(f"band_{band}", _band_units(band), heading)
    columns.count("partly", lambda row: row[1].partly)
    rows = ((body, each) for body in words.summary.bodies for each in body.conditions)
    return SummarySheet("conditions", tuple(columns.made), tuple(rows), frozen=2)


def _compared(words: FleetWords) -> Iterator[tuple[ValveBody, GroupComparison]]:
    """Yield the valve bodies of which groups are compared."""
    yield from ((body, body.comparison) for body in words.summary.bodies if body.comparison is not None)


def _rates_compared(words: FleetWords) -> SummarySheet:
    say = words.say
    columns = _Columns(say)
    columns.body(words, lambda row: row[0].controller)
    columns.text("first", lambda row: row[1].first)
    columns.text("second", lambda row: words.second(row[1].second))
    columns.text("verdict_or_worse", lambda row: say.signed(row[1].verdict), verdict=True)
    columns.count("first_units", lambda row: row[1].first_units)
    columns.count("second_units", lambda row: row[1].second_units)
    columns.difference("rate_points", words, lambda row: row[1].points)
    rows = ((body, each) for body, comparison in _compared(words) for each in comparison.verdicts)
    return SummarySheet("rates_compared", tuple(columns.made), tuple(rows), frozen=3)


def _wear_compared(words: FleetWords) -> SummarySheet:
    columns = _Columns(words.say)
    columns.body(words, lambda row: row[0].controller)
    columns.pair(words, lambda row: (row[0].controller, row[1]))
    columns.text("first", lambda row: row[1].first)
    columns.text("second", lambda row: words.second(row[1].second))
    columns.spread("first_wear", "percent", lambda row: row[1].first_percent, ends=False)
    columns.spread("second_wear", "percent", lambda row: row[1].second_percent, ends=False)
    columns.difference("mean_points", words, lambda row: row[1].mean_points)
    columns.difference("same_mileage", words, lambda row: row[1].same_mileage_points)
    unit = words.say("fleet_parts.unit_of_points")
    columns.number("median_points", "percent", lambda row: row[1].median_points, unit=unit)
    rows = ((body, each) for body, comparison in _compared(words) for each in comparison.lands)
    return SummarySheet("wear_compared", tuple(columns.made), tuple(rows), frozen=5)


def _units(words: FleetWords) -> SummarySheet:
    say = words.say
    columns = _Columns(say)
    columns.text("name", lambda row: row.name)
    columns.text("verdict", lambda row: say.signed(row.verdict), verdict=True)
    columns.text("decision", lambda row: say.get("decisions", row.decision) if row.decision else None)
    columns.text("decided_by", words.decided_by)
    columns.count("lands_past", lambda row: row.lands_past)
    columns.number("share_max", "percent", lambda row: row.max_share_percent)
    heading = words.heading()
    if heading:
        columns.text("group", lambda row: row.label, heading=heading)
    columns.text("number", lambda row: row.number)
    columns.text("date", lambda row: row.date)
    columns.text("serial", lambda row: row.serial)
    columns.text("vin", lambda row: row.vin)
    columns.number("mileage", "distance", lambda row: row.mileage_km, 0)
    columns.body(words, lambda row: row.controller)
    columns.text("provisional_unit", lambda row: row.provisional)
    columns.count("visits", lambda row: row.visits)
    columns.text("reference", lambda row: row.reference)
    return SummarySheet("units", tuple(columns.made), tuple(words.summary.worst))


def _errors(words: FleetWords) -> SummarySheet:
    columns = _Columns(words.say)
    columns.text("error", lambda row: words.kind_of_error(row[0]))
    columns.count("files", lambda row: row[0].count)
    columns.text("name", lambda row: row[1][0])
    columns.text("message", lambda row: row[1][1], wrapped=True)
    rows = ((kind, first) for kind in words.summary.errors for first in kind.first)
    return SummarySheet("errors", tuple(columns.made), tuple(rows))
