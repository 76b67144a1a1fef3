"""Print what an auditor asks for: the decision rule with every decision, who measured and when, and every reading."""

from __future__ import annotations

import itertools
import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from atleak.catalogue.limits import RuleKind
from atleak.equations.uncertainty import normal_cdf, normal_quantile
from atleak.land_diagnosis import LandDiagnosis
from atleak.readings import LandClearance, Reading
from atleak.report.pdf.blocks import Block, PrintedColumn, facts, grouped_table, joined, table, text
from atleak.report.pdf.printed_names import PrintedNames
from atleak.rules import Rule
from atleak.uncertainty import DECISIONS, RuleDecision, UnitUncertainty
from atleak.views.land_names import component_words, has_number, land_number
from atleak.workshop_units import MM, PERCENT, UM

_DIRECTIONS = 4  # of measuring, beside one another in a table
_ABREAST = 6  # readings that a row has room for


def coverage_factor(uncertainty: UnitUncertainty) -> float:
    """Return k of the expanded uncertainty U = k u: that of a normal distribution."""
    return float(normal_quantile(0.5 + 0.5 * uncertainty.coverage))


@dataclass(frozen=True)
class _Row:
    """The readings of one part of a component in one plane, by direction; those that do not count are known."""

    component: str
    part: str
    plane: str
    land: LandClearance | None  # None where the plane belongs to none
    readings: Sequence[Reading]
    left_out: frozenset[int]  # by the places of the readings in the sheet


class Annex:
    """The parts of a report by which somebody else can judge its measurements."""

    def __init__(self, names: PrintedNames) -> None:
        self.names, self.diagnosis, self.job, self.say = names, names.diagnosis, names.job, names.say

    @property
    def _numbered(self) -> bool:
        """Tell whether every component has a number, so that lands are named in a few signs."""
        return all(has_number(self.diagnosis.controller, land.key[0]) for land in self.diagnosis.lands)

    def _by_valve(self, columns: Sequence[PrintedColumn], rows: Iterable[Any], of: Callable[[Any], str]) -> Block:
        """Return a table of rows of one height: valves without numbers are named above their rows."""
        if self._numbered:
            return table(columns, rows)
        controller, say = self.diagnosis.controller, self.say
        grouped = itertools.groupby(rows, of)
        return grouped_table(columns, ((component_words(controller, each, say), [*of_it]) for each, of_it in grouped))

    # --- decisions

    def decisions(self) -> Iterable[Block]:
        """Return the decision rule, and what it decides of totals, pressures and every measured land."""
        uncertainty, say = self.diagnosis.uncertainty, self.say
        decided = [land for land in self.diagnosis.lands if land.decision is not None]
        if uncertainty is None or not decided:
            return
        guard, risk = say.plain(uncertainty.guard_factor), float(normal_cdf(-uncertainty.guard_factor))
        yield text(say("annex.subject", limits=say.name(self.diagnosis.limits.name), section=say("sections.limits")))
        yield text(say("annex.rule", guard=guard))
        yield text(say("annex.risk", risk=say.percent(risk, 0)))
        yield text(self.expanded(uncertainty))
        counts = Counter(land.decision for land in decided)
        words = (f"{say.get('decisions', each)}: {counts[each]}" for each in DECISIONS if counts[each])
        yield text(say("annex.counted", lands=len(decided), counts=joined(words)), leads=True)
        yield table(self._columns_of_unit(), self._of_unit())
        yield self._by_valve(self._columns_of_lands(uncertainty), decided, lambda land: land.key[0])
        yield text(say("annex.columns"), small=True)

    def expanded(self, uncertainty: UnitUncertainty) -> str:
        """Return what ± and brackets are: the expanded uncertainty with its factor and coverage."""
        return self.say(
            "annex.expanded",
            k=self.say.number(coverage_factor(uncertainty), 2),
            coverage=self.say.percent(uncertainty.coverage, 0),
            draws=self.say.number(uncertainty.draws, 0),
            seed=uncertainty.seed,
        )

    def _of_unit(self) -> list[tuple[Rule, RuleDecision]]:
        decided = ((rule, self.diagnosis.decided(rule)) for rule in self.diagnosis.unit_rules)
        return [(rule, decision) for rule, decision in decided if decision is not None]

    def _columns_of_unit(self) -> list[PrintedColumn]:
        say, names = self.say, self.names

        def verdict(rule: Rule) -> Any:
            level = self.diagnosis.verdict_on(rule)
            return "–" if level is None else {"sign": level, "text": say.level(level)}

        return [
            PrintedColumn(say("printed.rule"), lambda row: names.rule_name(row[0]), width=6),
            PrintedColumn(say("annex.value"), lambda row: names.rule_value(row[0], row[0].value), side="d"),
            PrintedColumn(say("annex.limit"), lambda row: names.rule_value(row[0], row[1].limit), side="d"),
            PrintedColumn(say("annex.u_or_interval"), lambda row: self._u(row[1]), side="r"),
            PrintedColumn(say("printed.verdict"), lambda row: verdict(row[0])),
            PrintedColumn(say("printed.decision"), lambda row: say.get("decisions", row[1].decision), width=3),
            PrintedColumn("P", lambda row: self._probability(row[1]), "%", side="r"),
        ]

    def _columns_of_lands(self, uncertainty: UnitUncertainty) -> list[PrintedColumn]:
        say, names = self.say, self.names

        def guard(land: LandDiagnosis) -> str:
            decision = _deciding(land)
            return (
                "–"
                if decision is None
                else self._spread(decision.rule, uncertainty.guard_factor * decision.standard_uncertainty)
            )

        def value(land: LandDiagnosis, decision: RuleDecision) -> str:
            worn = decision.rule.kind is RuleKind.WEAR
            return names.wear(land) if worn and land.within_new else names.rule_value(decision.rule, decision.value)

        def of(land: LandDiagnosis, what: Any) -> str:
            decision = _deciding(land)
            return "–" if decision is None else what(decision)

        return [
            PrintedColumn(names.column("land"), names.land_number if self._numbered else names.land, width=1),
            PrintedColumn("c_r ± U", names.clearance, say.unit("clearance"), side="d"),
            PrintedColumn("Z ± U", self._wear, "%", side="d"),
            PrintedColumn(
                say("annex.decides"), lambda land: of(land, lambda each: names.rule_name(each.rule)), width=2
            ),
            PrintedColumn(
                say("annex.value"),
                lambda land: of(land, partial(value, land)),
                side="d",
            ),
            PrintedColumn(
                say("annex.limit"),
                lambda land: of(land, lambda each: names.rule_value(each.rule, each.limit)),
                side="d",
            ),
            PrintedColumn("± w", guard, side="d"),
            PrintedColumn(names.column("verdict"), names.verdict),
            PrintedColumn(names.column("decision"), lambda land: say.get("decisions", land.decision or ""), width=3),
            PrintedColumn("P", lambda land: of(land, self._probability), "%", side="r"),
        ]

    def _wear(self, land: LandDiagnosis) -> str:
        value = self.names.wear(land)
        interval = land.uncertainty.wear_interval if land.uncertainty else None
        if interval is None or land.wear is None or land.within_new:
            return value
        return f"{value} ± {self.say.number((interval[1] - interval[0]) / 2.0 * PERCENT, 0)}"

    def _u(self, decided: RuleDecision) -> str:
        """Return the standard uncertainty, or the interval where the distribution lies to one side."""
        if decided.interval is None or not decided.skewed:
            return self._spread(decided.rule, decided.standard_uncertainty)
        return "–".join(self.names.rule_value(decided.rule, end) for end in decided.interval)

    def _spread(self, rule: Rule, value: float) -> str:
        return self.names.rule_value(rule, value) if math.isfinite(value) else "–"

    def _probability(self, decided: RuleDecision) -> str:
        return self.say.number(decided.probability_over_limit * PERCENT, 0)

    # --- the report itself

    def issue(self) -> Iterable[Block]:
        """Return which report this is, when it was issued and by whom it was approved."""
        say, job = self.say, self.job
        rows = [
            ("report_number", job.number),
            ("revision", job.revision),
            ("replaces", job.replaces),
            ("issued_on", say.date(job.issued_on) if job.issued_on else ""),
            ("approved_by", job.approved_by),
        ]
        yield facts([[say(f"annex.{name}"), value] for name, value in rows if value])
        yield text(say("annex.whole"), small=True)

    def end(self) -> str:
        """Return the mark at the end of the last page."""
        number = joined((self.job.number, self.job.revision), " · ")
        return self.say("annex.end_of", report=number) if number else self.say("annex.end")

    # --- readings

    def readings(self) -> Iterable[Block]:
        """Return who measured, when and how, then every reading with what its repeats and directions show."""
        readings, say = self.diagnosis.readings, self.say
        if readings is None or not readings.readings:
            return
        day = self.job.measured_on or readings.date
        rows = [
            ("measured_on", say.date(day) if day else say("annex.not_stated")),
            ("measured_by", self.job.technician or say("annex.not_stated")),
            ("sheet", joined((readings.file, readings.sheet or ""), " · ")),
            ("count", str(len(readings.readings))),
        ]
        yield facts([[say(f"annex.{name}"), value] for name, value in rows])
        unit = say.unit("length")
        columns = [
            PrintedColumn(self.names.column("land"), self._land),
            PrintedColumn(say("annex.part"), lambda row: say(f"annex.{row.part}")),
            PrintedColumn(say("annex.plane"), lambda row: row.plane, side="c"),
            *self._of_directions(readings.readings, unit),
            PrintedColumn(say("annex.mean"), self._mean, unit, width=1, side="r"),
            PrintedColumn(
                say("annex.ovality"), lambda row: self._of_part(row, "ovality"), say.unit("clearance"), side="r"
            ),
            PrintedColumn(say("annex.taper"), lambda row: self._of_part(row, "taper"), say.unit("clearance"), side="r"),
            PrintedColumn(
                say("annex.apart"), lambda row: self._of_part(row, "repeat_spread"), say.unit("clearance"), side="r"
            ),
        ]
        yield self._by_valve(columns, self._rows(), lambda row: row.component)
        yield text(say("annex.about_readings"), small=True)

    def _rows(self) -> Iterator[_Row]:
        """Return the readings in the valve body's order, those of planes that belong to no land last."""
        assert self.diagnosis.readings is not None
        controller = self.diagnosis.controller
        groups: dict[tuple[str, str, str], list[Reading]] = defaultdict(list)
        for reading in self.diagnosis.readings.readings:
            groups[reading.component, reading.part, reading.plane].append(reading)
        states = {land.key: land.state for land in self.diagnosis.lands}
        order = {key: number for number, key in enumerate(states)}
        rows = []
        for (component, part, plane), found in groups.items():
            land = controller.land_of_plane(component, plane)
            state = states.get(land.key) if land is not None else None
            doubts = state.doubts if state is not None else ()
            left_out = frozenset(id(each) for doubt in doubts for each in doubt.repeats if each not in doubt.counted)
            rows.append(_Row(component, part, plane, state, found, left_out))
        rows.sort(key=lambda row: (len(order) if row.land is None else order[row.land.land.key], row.part == "sleeve"))
        yield from rows

    def _land(self, row: _Row) -> str:
        if self._numbered:
            controller = self.diagnosis.controller
            return row.component if row.land is None else land_number(controller, row.land.land.key, self.say)
        return "–" if row.land is None else str(row.land.land.key[1])

    def _of_directions(self, readings: Sequence[Reading], unit: str) -> list[PrintedColumn]:
        """Return a column for each direction of measuring, or one for all of them where they are many.

        Where the repeats of all directions have no room beside one another, they stand below one another in every row.
        """
        directions = sorted({each.direction for each in readings}, key=lambda each: -1.0 if each is None else each)
        if len(directions) > _DIRECTIONS:
            return [PrintedColumn(self.say("annex.each_reading"), self._each, unit, width=3)]
        repeats = max(Counter((each.component, each.part, each.plane, each.direction) for each in readings).values())
        between = "\u2002" if repeats * len(directions) <= _ABREAST else "\n"

        def at(direction: float | None) -> Callable[[_Row], str]:
            return lambda row: between.join(self._by_direction(row)[direction])

        return [PrintedColumn(self._direction(each), at(each), unit, width=1, side="d") for each in directions]

    def _direction(self, direction: float | None) -> str:
        return self.say("annex.each_reading") if direction is None else f"{self.say.plain(direction)}°"

    def _by_direction(self, row: _Row) -> dict[float | None, list[str]]:
        """Return the readings of every direction; one that does not count stands in brackets."""
        by_direction: dict[float | None, list[str]] = defaultdict(list)
        for reading in row.readings:
            written = self._diameter(reading.diameter)
            by_direction[reading.direction].append(f"({written})" if id(reading) in row.left_out else written)
        return by_direction

    def _each(self, row: _Row) -> str:
        """Return every reading behind its direction."""
        return "; ".join(
            f"{'' if direction is None else f'{self._direction(direction)}: '}{' '.join(written)}"
            for direction, written in self._by_direction(row).items()
        )

    def _mean(self, row: _Row) -> str:
        """Return the mean of the directions of this plane, each the mean of its repeats that count."""
        by_direction: dict[float | None, list[float]] = defaultdict(list)
        for reading in row.readings:
            if id(reading) not in row.left_out:
                by_direction[reading.direction].append(reading.diameter)
        means = [math.fsum(each) / len(each) for each in by_direction.values()]
        return self._diameter(math.fsum(means) / len(means))

    def _diameter(self, diameter: float) -> str:
        return self.say.value(diameter * MM, "length", 4)

    def _of_part(self, row: _Row, what: str) -> str:
        value = None if row.land is None else getattr(row.land, f"{row.part}_{what}")
        return "–" if value is None else self.say.value(value * UM, "clearance", 1)


def _deciding(land: LandDiagnosis) -> RuleDecision | None:
    return land.uncertainty.deciding if land.uncertainty else None
