"""Print what an auditor asks for: every decision with its rule, who measured and when, the readings, the budgets."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from atleak.catalogue.controller import REFERENCE_TEMPERATURE
from atleak.catalogue.limits import RuleKind
from atleak.common.style import DECISION_MARKS
from atleak.common.units import MM, PERCENT, UM
from atleak.common.wording import begun, joined
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.rules import Rule
from atleak.diagnosis.uncertainty import RuleDecision, UnitUncertainty
from atleak.diagnosis.uncertainty.results import MOST_BUDGETS, BudgetLine, budget_lines, combined
from atleak.engine.projection import Projection
from atleak.equations.statistics import normal_cdf, normal_quantile
from atleak.measurements.clearances import LandClearance
from atleak.measurements.readings import Reading
from atleak.report.pdf.blocks import Block, bullets, listed, named_facts, text
from atleak.report.pdf.conditions import leaking_elsewhere
from atleak.report.printed_names import PrintedPart
from atleak.report.tables.lands import land_at, leaking_worst_first, share_cell
from atleak.report.tables.names import component_words, land_number
from atleak.report.tables.sentences import shares_add_up
from atleak.report.tables.table import VERDICT, Column, Judged, Table

_CONDITIONS = 5  # whose shares have room beside one another
_WITH_LEAKAGE = 2  # beside which the leakage has room, too
_DIRECTIONS = 4  # of measuring, beside one another in a table
_ABREAST = 6  # readings that a row has room for
_OF_BOTH = 4  # readings of a part, where those of sleeve and spool stand in one row


def coverage_factor(uncertainty: UnitUncertainty) -> float:
    """Return k of the expanded uncertainty U = k u: that of a normal distribution."""
    return float(normal_quantile(0.5 + 0.5 * uncertainty.coverage))


@dataclass(frozen=True)
class _Row:
    """The readings of one part of a component in one plane; those that do not count are known."""

    component: str
    part: str
    plane: str
    land: LandClearance | None  # None where the plane belongs to none
    readings: Sequence[Reading]
    left_out: frozenset[int]  # by the places of the readings in the sheet


class Annex(PrintedPart):
    """The parts of a report by which somebody else can judge its measurements."""

    def _by_valve(self, rows: Iterable[Any], columns: Sequence[Column], of: Callable[[Any], str]) -> Block:
        """Return a table of rows of one height: valves without numbers are named above their rows."""

        def valve(row: Any) -> str:
            return component_words(self.diagnosis.controller, of(row), self.say)

        return listed(self.say, rows, *columns, group=None if self.names.numbered else valve)

    # --- decisions

    def decisions(self) -> Iterable[Block]:
        """Return the decision rule, and what it decides of totals, pressures and every measured land."""
        uncertainty, say, names = self.diagnosis.uncertainty, self.say, self.names
        lands = [land for land in self.diagnosis.lands if land.decision is not None]
        if uncertainty is None or not lands:
            return
        guard, risk = say.plain(uncertainty.guard_factor), float(normal_cdf(-uncertainty.guard_factor))
        yield text(say("annex.subject", limits=say.name(self.diagnosis.limits.name), section=say("sections.limits")))
        yield text(say("annex.rule", guard=guard))
        yield text(say("annex.risk", risk=say.percent(risk, 0)))
        yield text(
            say(
                "annex.expanded",
                k=say.number(coverage_factor(uncertainty), 2),
                coverage=say.percent(uncertainty.coverage, 0),
                draws=say.number(uncertainty.draws, 0),
                seed=uncertainty.seed,
            )
        )
        counts = Counter(land.shown_as for land in lands)
        words = (f"{say.get('decisions', each)}: {counts[each]}" for each in DECISION_MARKS if counts[each])
        yield text(say("annex.counted", lands=len(lands), counts=joined(words)), leads=True)
        of_unit = ((rule, self.diagnosis.decided(rule)) for rule in self.diagnosis.unit_rules)
        decided = [(rule, decision) for rule, decision in of_unit if decision is not None]
        losing = [row for row in decided if self._losing(row)]
        yield listed(
            say,
            losing,
            Column("rule", width=400, of=lambda row: names.rule_name(row[0])),
            _quantity("annex.value", lambda row: names.rule_value(row[0], row[0].value)),
            _quantity("annex.limit", lambda row: names.rule_value(row[0], row[1].limit)),
            _quantity("annex.u_or_interval", lambda row: self._u(row[1])),
            Column("verdict", VERDICT, of=lambda row: self.diagnosis.verdict_on(row[0])),
            Column("decision", width=100, of=lambda row: say.get("decisions", row[1].decision)),
            _probability(lambda row: row[1]),
        )
        left_out = len(decided) - len(losing)
        notes = [say("annex.columns_of_unit"), *([say("annex.left_out", count=left_out)] if left_out else [])]
        yield text(" ".join(notes), small=True)

    def _losing(self, row: tuple[Rule, RuleDecision]) -> bool:
        """Tell whether a rule of the unit says more than that nothing is lost, for certain."""
        rule, decision = row
        nothing = self.names.rule_value(rule, 0.0)
        said = (decision.value, *(decision.interval or (decision.standard_uncertainty,)))
        return decision.probability_over_limit > 0.0 or any(
            self.names.rule_value(rule, each) != nothing for each in said
        )

    # --- every land

    def lands(self) -> Iterable[Block]:
        """Return every land once: its clearance and wear, what it leaks, and how sure the verdict is."""
        say, names, diagnosis = self.say, self.names, self.diagnosis
        at = diagnosis.presented if len(diagnosis.presented) <= _CONDITIONS else diagnosis.reported
        yield self._by_valve(diagnosis.lands, self._columns_of_lands(at), lambda land: land.key[0])
        conditions = joined((f"{number} {say.condition(each.condition)}" for number, each in enumerate(at, 1)), "; ")
        about = "texts.all_at" if len(at) <= _WITH_LEAKAGE else "annex.warm_at"
        notes = [say(about, condition=say.condition(diagnosis.projection.condition))]
        notes += [say("annex.rules", conditions=conditions), say("annex.columns"), say("texts.matrix")]
        rows = leaking_worst_first(diagnosis, diagnosis.presented)
        notes += [shares_add_up(diagnosis, say), *leaking_elsewhere(names, rows)] if rows else []
        if self.names.numbered:
            valves = dict.fromkeys(land.key[0] for land in diagnosis.lands)
            notes.append(f"{joined((component_words(diagnosis.controller, each, say) for each in valves), '; ')}.")
        yield text(" ".join(notes), small=True)

    def _columns_of_lands(self, at: Sequence[Projection]) -> list[Column]:
        say, names = self.say, self.names
        numbers = {each.condition: str(number) for number, each in enumerate(at, start=1)}
        short = {RuleKind.WEAR: "Z", RuleKind.CLEARANCE: "c_r"}

        def rule(_: LandDiagnosis, decision: RuleDecision) -> str:
            about = decision.rule
            name = short.get(about.kind) or (about.condition and numbers.get(about.condition))
            return name or names.rule_name(about)

        def decided(of: Callable[[LandDiagnosis, RuleDecision], str]) -> Callable[[LandDiagnosis], str | None]:
            return lambda land: None if (decision := _deciding(land)) is None else of(land, decision)

        def guard(_: LandDiagnosis, decision: RuleDecision) -> str:
            factor = self.diagnosis.uncertainty.guard_factor if self.diagnosis.uncertainty else 0.0
            return self._spread(decision.rule, factor * decision.standard_uncertainty)

        def share(projection: Projection, land: LandDiagnosis) -> Judged:
            return share_cell(land_at(land, self.diagnosis, projection), say, unit=False)

        def decision(land: LandDiagnosis) -> str | None:
            within = land.shown_as == "within_range"  # shorter than the decision's own words
            return say("texts.within_new") if within else land.shown_as and say.get("decisions", land.shown_as)

        of_lands = names.lands
        (land, clearance, verdict) = of_lands.only("land", "clearance", "verdict").columns
        sizes = of_lands.only("mounting", "effective").columns
        leakage = of_lands.only(*(["leakage"] if len(at) <= _WITH_LEAKAGE else [])).columns
        columns = (
            Column("land", of=names.land_number) if self.names.numbered else land,
            Column("", "clearance", words="c_r ± U", of=clearance.of),
            Column("", "percent", words="Z ± U", of=self._wear),
            *sizes,
            *leakage,
            *(
                Column(
                    "",
                    "percent",
                    words=f"{begun(say('columns.share'))} {numbers[each.condition]}",
                    of=partial(share, each),
                )
                for each in at
            ),
            Column("annex.decides", of=decided(rule)),
            _quantity("annex.limit", decided(lambda _, each: names.rule_value(each.rule, each.limit))),
            _quantity("", decided(guard), "± w"),
            verdict,
            Column("decision", of=decision),
            _probability(_deciding),
        )
        return list(Table("", columns, self.diagnosis.lands, say).filled.columns)

    def _wear(self, land: LandDiagnosis) -> str | None:
        if land.within_new or land.wear is None:
            return self.say("texts.within_new") if land.within_new else None
        value = self.say.number(land.wear * PERCENT, 1)
        interval = land.uncertainty.wear_interval if land.uncertainty else None
        if interval is None:
            return value
        return f"{value} ± {self.say.number((interval[1] - interval[0]) / 2.0 * PERCENT, 1)}"

    def _u(self, decided: RuleDecision) -> str:
        """Return the standard uncertainty, or the interval where the distribution lies to one side."""
        if decided.interval is None or not decided.skewed:
            return self._spread(decided.rule, decided.standard_uncertainty)
        return "–".join(self.names.rule_value(decided.rule, end) for end in decided.interval)

    def _spread(self, rule: Rule, value: float) -> str:
        return self.names.rule_value(rule, value) if math.isfinite(value) else "–"

    # --- the report itself

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
        yield named_facts(
            "annex",
            say,
            measured_on=say.date(day) if day else say("annex.not_stated"),
            measured_by=self.job.technician or say("annex.not_stated"),
            sheet=joined((readings.file, readings.sheet or ""), " · "),
            count=str(len(readings.readings)),
        )

        def of_part(what: str, row: _Row) -> float | None:
            return None if row.land is None else getattr(row.land, f"{row.part}_{what}")

        forms = {"ovality": "ovality", "taper": "taper", "apart": "repeat_spread"}
        every = self._rows(readings.readings)
        columns = [
            *self._of_directions(readings.readings),
            Column("annex.mean", "length", 4, of=self._mean, times=MM),
            *(
                Column(f"annex.{key}", "clearance", 1, of=partial(of_part, what), times=UM)
                for key, what in forms.items()
            ),
        ]
        rows: list[dict[str, _Row]] = [{row.part: row} for row in every]
        if max(len(row.readings) for row in every) <= _OF_BOTH:
            pairs: dict[tuple[str, str], dict[str, _Row]] = defaultdict(dict)
            for row in every:
                pairs[row.component, row.plane][row.part] = row
            rows = [*pairs.values()]
            columns = [self._of_part(part, column) for part in ("sleeve", "spool") for column in columns]
        else:
            columns = [Column("annex.part", of=lambda row: say(f"annex.{row.part}")), *columns]
            columns = [self._of_part("", column) for column in columns]
        which = [Column("land", of=self._land)]
        if any(row.land is None or row.plane != str(row.land.land.key[1]) for row in every):
            which.append(Column("annex.plane", of="plane"))
        table = Table("", (*(self._of_part("", each) for each in which), *columns), rows, say).filled
        yield self._by_valve(rows, table.columns, lambda row: next(iter(row.values())).component)
        reference = say.plain_value(REFERENCE_TEMPERATURE, "temperature")
        yield text(say("annex.about_readings", reference=reference), small=True)

    def _rows(self, readings: Iterable[Reading]) -> list[_Row]:
        """Return the readings in the valve body's order, those of planes that belong to no land last."""
        controller = self.diagnosis.controller
        groups: dict[tuple[str, str, str], list[Reading]] = defaultdict(list)
        for reading in readings:
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
        return sorted(
            rows, key=lambda row: (len(order) if row.land is None else order[row.land.land.key], row.part == "sleeve")
        )

    def _of_part(self, part: str, column: Column) -> Column:
        """Return a column of the rows of one part, or of whichever part a row has, as one of rows of several parts."""

        def of(rows: Mapping[str, _Row]) -> Any:
            row = rows.get(part) if part else next(iter(rows.values()))
            return None if row is None else column.judged(row)

        key = column.key
        title = column.words or (self.say(key) if "." in key else self.say(f"printed.{key}"))
        words = f"{begun(self.say(f'annex.{part}'))}\n{title}" if part else title
        return replace(column, of=of, times=None, words=words)

    def _land(self, row: _Row) -> str | None:
        if self.names.numbered:
            controller = self.diagnosis.controller
            return row.component if row.land is None else land_number(controller, row.land.land.key, self.say)
        return None if row.land is None else str(row.land.land.key[1])

    def _of_directions(self, readings: Sequence[Reading]) -> list[Column]:
        """Return a column for each direction of measuring, or one for all of them where they are many.

        Where the repeats of all directions have no room beside one another, they stand below one another in every row.
        """
        directions = sorted({each.direction for each in readings}, key=lambda each: -1.0 if each is None else each)
        if len(directions) > _DIRECTIONS:
            return [Column("annex.each_reading", words_of="length", width=150, of=self._each)]
        repeats = max(Counter((each.component, each.part, each.plane, each.direction) for each in readings).values())
        between = "\u2002" if repeats * len(directions) <= _ABREAST else "\n"

        def at(direction: float | None, row: _Row) -> str:
            return between.join(self._by_direction(row)[direction])

        return [
            Column("", words_of="length", width=50, words=self._direction(each), of=partial(at, each))
            for each in directions
        ]

    def _direction(self, direction: float | None) -> str:
        return self.say("annex.each_reading") if direction is None else f"{self.say.plain(direction)}°"

    def _by_direction(self, row: _Row) -> dict[float | None, list[str]]:
        """Return the readings of every direction; one that does not count stands in brackets."""
        by_direction: dict[float | None, list[str]] = defaultdict(list)
        for reading in row.readings:
            written = self.say.value(reading.diameter * MM, "length", 4)
            by_direction[reading.direction].append(f"({written})" if id(reading) in row.left_out else written)
        return by_direction

    def _each(self, row: _Row) -> str:
        """Return every reading behind its direction."""
        return "; ".join(
            f"{'' if direction is None else f'{self._direction(direction)}: '}{' '.join(written)}"
            for direction, written in self._by_direction(row).items()
        )

    def _mean(self, row: _Row) -> float:
        """Return the mean of the directions of this plane [m], each the mean of its repeats that count."""
        by_direction: dict[float | None, list[float]] = defaultdict(list)
        for reading in row.readings:
            if id(reading) not in row.left_out:
                by_direction[reading.direction].append(reading.diameter)
        means = [math.fsum(each) / len(each) for each in by_direction.values()]
        return math.fsum(means) / len(means)


def _quantity(key: str, of: Callable[[Any], str | None], words: str | None = None) -> Column:
    """Return a column of values of several kinds, each with its unit, the decimal signs below one another."""
    return Column(key, digits=0, words=words, of=of)


def _probability(of: Callable[[Any], RuleDecision | None]) -> Column:
    """Return the column with the probability that the true value is past the limit."""

    def over(item: Any) -> float | None:
        decision = of(item)
        return None if decision is None else decision.probability_over_limit

    return Column("", "percent", 0, words="P", of=over, times=PERCENT)


def _deciding(land: LandDiagnosis) -> RuleDecision | None:
    return land.uncertainty.deciding if land.uncertainty else None


_OF_SHARE = 6  # of the sources of a share that are named


class Budget(PrintedPart):
    """The budgets of one report."""

    def blocks(self) -> Iterable[Block]:
        """Return what all flagged lands that were measured have in common, then of each, the worst first, the rest."""
        uncertainty, say = self.diagnosis.uncertainty, self.say
        flagged = [land for land in self.diagnosis.flagged if land.uncertainty and land.uncertainty.u_clearance]
        if uncertainty is None or not flagged:
            return
        yield text(say("annex.model"), leads=True)
        shown = flagged[:MOST_BUDGETS]
        budgets = [budget_lines(land.uncertainty.sources) for land in shown if land.uncertainty]
        written = [[self._written(line) for line in lines] for lines in budgets]
        common = [
            line for line, said in zip(budgets[0], written[0], strict=True) if all(said in each for each in written)
        ]
        if len(shown) == 1:
            common = []
        if common:
            yield text(say("annex.in_all", lands=joined(map(self.names.land_number, shown))), leads=True)
            yield listed(say, common, *self._columns())
        same = [self._written(line) for line in common]
        rows = [
            (land, line, combined(lines))
            for land, lines in zip(shown, budgets, strict=True)
            for line in lines
            if self._written(line) not in same
        ]
        yield listed(say, rows, *self._columns_of_lands(), group=partial(self._of_land, uncertainty))
        yield bullets((*self._of_shares(shown), *self._of_wear(shown)))
        if len(flagged) > MOST_BUDGETS:
            others = joined(map(self.names.land_number, flagged[MOST_BUDGETS:]))
            yield text(say("annex.more_budgets", lands=others))
        yield text(say("annex.about_budgets"), small=True)

    def _of_land(self, unit: UnitUncertainty, row: tuple[LandDiagnosis, BudgetLine, float]) -> str:
        """Return the heading above what is the land's own."""
        (land, _, u), say, k = row, self.say, coverage_factor(unit)
        return say(
            "annex.of_land",
            land=self.names.land_name(land),
            clearance=say.quantity(land.state.radial_clearance * UM, "clearance", 1),
            u=say.quantity(u * UM, "uncertainty", 2),
            expanded=say.quantity(k * u * UM, "clearance", 1),
            k=say.number(k, 2),
            coverage=say.percent(unit.coverage, 0),
        )

    def _written(self, line: BudgetLine) -> tuple[str, ...]:
        """Return a line as it is printed, without what part of the variance it is: by that lands are compared."""
        return listed(self.say, [line], *self._columns())["rows"][0]

    def _columns(self) -> tuple[Column, ...]:
        """Return the columns of the sources of a budget."""
        say = self.say
        return (
            Column("annex.source", width=250, of=lambda line: say.get("uncertainty_sources", line.source.label)),
            Column("annex.distribution", width=150, of=self._distribution),
            Column("annex.degrees", digits=0, of=self._degrees),
            Column("", digits=0, width=100, words="u(x)", of=self._input),
            Column("", digits=0, width=100, words="c", of=self._sensitivity),
            Column("", "clearance", 2, words="c · u(x)", of=lambda line: abs(line.contribution), times=UM),
        )

    def _columns_of_lands(self) -> Iterator[Column]:
        """Yield the same of rows of lands, with what part of the variance each source is."""

        def of(column: Column, row: tuple[LandDiagnosis, BudgetLine, float]) -> Judged:
            return column.judged(row[1])

        yield from (replace(each, of=partial(of, each), times=None) for each in self._columns())
        yield Column("annex.part_of_variance", "percent", 1, of=lambda row: row[1].fraction, times=PERCENT)

    def _distribution(self, line: BudgetLine) -> str:
        return f"{self.say(f'annex.{line.source.shape}')}, {'A' if line.statistical else 'B'}"

    def _degrees(self, line: BudgetLine) -> str:
        return self.say.number(line.degrees_of_freedom, 0) if math.isfinite(line.degrees_of_freedom) else "∞"

    def _input(self, line: BudgetLine) -> str:
        if line.input_kind == "temperature":
            say = self.say
            return f"{say.plain(say.convert(line.input_uncertainty, 'kelvin'), 3)}\u00a0{say.unit('kelvin')}"
        return self.say.quantity(line.input_uncertainty * UM, "uncertainty", 2)

    def _sensitivity(self, line: BudgetLine) -> str:
        if line.input_kind == "temperature":
            return self.say.quantity(line.sensitivity * UM, "clearance_per_kelvin", 3)
        return self.say.number(line.sensitivity, 1)

    def _of_wear(self, lands: Iterable[LandDiagnosis]) -> Iterator[str]:
        """Yield what the wear adds: the uncertainty of what the pairs were when new."""
        say, alike = self.say, defaultdict(list)
        for land in lands:
            its, rule = land.uncertainty, _deciding(land)
            if land.wear is None or its is None or rule is None or rule.rule.kind is not RuleKind.WEAR:
                continue
            ranged = isinstance(land.state.land.mounting_clearance, tuple)
            mounting = say.quantity(its.sources.u_mounting * UM, "uncertainty", 2)
            key = ("_range", "", "") if ranged else ("", mounting, say.percent(rule.limit))
            alike[key].append(f"{self.names.land_number(land)}\u00a0{say.percent(rule.standard_uncertainty)}")
        for (ranged_, mounting, limit), named in alike.items():
            yield say(f"annex.of_wear{ranged_}", mounting=mounting, limit=limit, lands=joined(named))

    def _of_shares(self, lands: Iterable[LandDiagnosis]) -> Iterator[str]:
        """Yield what makes shares uncertain where a share decides."""
        say = self.say
        for land in lands:
            rule = _deciding(land)
            if rule is None or rule.rule.kind is not RuleKind.PAIR_SHARE or rule.rule.condition is None:
                continue
            for at in land.uncertainty.conditions if land.uncertainty else ():
                if at.condition == rule.rule.condition.name and math.isfinite(at.u_share) and at.budget:
                    named = (
                        f"{say.get('uncertainty_sources', source)} {say.percent(fraction, 0)}"
                        for source, fraction in at.budget[:_OF_SHARE]
                    )
                    yield f"{self.names.land_number(land)}: " + say(
                        "annex.of_share",
                        condition=say.condition(rule.rule.condition),
                        u=say.percent(at.u_share, 2),
                        parts=joined(named),
                    )
