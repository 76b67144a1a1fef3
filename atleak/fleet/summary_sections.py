"""A fleet's summary as sections, each said once for terminal, page, PDF and workbook."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from atleak.common.verdicts import BANDS, FLAGGED, VERDICTS, Verdict
from atleak.fleet.summary_charts import FleetCharts
from atleak.fleet.summary_tables import Counted, FleetTables, by_trouble, counted_groups
from atleak.fleet.summary_words import TERMS, FleetWords, called, within_words
from atleak.fleet.sums import GroupComparison, ValveBody, WearDifference
from atleak.report.charts.drawing import shortened
from atleak.report.tables.table import Facts, Picture, Points, Section, SectionPart, Text

_ROWS = 12  # most rows of valve bodies in a table
_RATES = tuple(f"past_{level}" for level in FLAGGED)
_UNIT_NAME = 48  # letters
_ALL = 1_000_000
_OF_A_BODY = ("pairs", "deciders", "wear", "temperatures", "conditions", "comparison")  # sections of each
_OVER_TEMPERATURE = ("temperature", "hours", "share", "share_max", "pressure", "pressure_min")


@dataclass(frozen=True)
class Depth:
    """How much is said."""

    pairs: int = _ALL  # that are listed
    drawn: int = 15  # pairs and groups in a chart
    wear: int = 1  # lands whose wear over mileage is shown
    deciders: int = _ALL
    groups: int = _ALL  # that are listed
    differences: int = _ALL  # of rates, and of wear
    units: int = 0  # that are listed
    message: int = _ALL  # letters of an error's message
    bodies: int = _ALL  # valve bodies with sections of their own
    compared: bool = True  # whether differences of wear are drawn
    terms: bool = True  # whether it is said what the words mean


TERMINAL = Depth(10, 0, 3, 5, differences=12, units=15, compared=False, terms=False)


class FleetSections:
    """The sections of a summary, in its reader's words."""

    def __init__(self, words: FleetWords, depth: Depth) -> None:
        self.words, self.say, self.summary, self.depth = words, words.say, words.summary, depth
        self.tables, self.charts = FleetTables(words), FleetCharts(words)

    def all(self) -> list[Section]:
        """Return all of them, without those that have nothing to say."""
        several, bodies = len(self.summary.bodies) > 1, self.summary.bodies[: self.depth.bodies]
        sections = [self.section("verdicts"), self.know()]
        for body in bodies:
            if several:
                sections.append(self.intro(body))
            sections += [self.section(name, body) for name in _OF_A_BODY]
        if several:
            sections.append(self._section("units_and_files", (), level=1))
        sections += [self.section("worst"), self.section("errors")]
        if self.depth.terms:
            sections.append(self.rests_on(level=1 if several else 2))
        return [section for section in sections if section.parts or section.level == 1]

    def section(self, name: str, *body: ValveBody) -> Section:
        """Return a section by its name: of the whole, or one of `_OF_A_BODY` of a valve body."""
        parts: Iterator[SectionPart] = getattr(self, f"_{name}")(*body)
        return self._section(name, parts)

    def _section(self, name: str, parts: Iterator[SectionPart] | Sequence[SectionPart], level: int = 2) -> Section:
        return Section(name, self.say(f"fleet_summary.section_{name}"), tuple(parts), level)

    def _name(self, body: ValveBody) -> str:
        return self.words.body(body.controller)

    # --- the whole

    def figures(self) -> list[tuple[str, str | int]]:
        """Return what the summary is of, numbers as they are."""
        say, summary = self.say, self.summary
        bodies = summary.bodies
        figures: dict[str, str | int] = {
            "folder": summary.folder,
            "units": summary.counts.units,
            "judged": summary.counts.judged,
            "visits": summary.visits,
            **({"body": self._name(bodies[0])} if len(bodies) == 1 else {"bodies": len(bodies)}),
            "failed": sum(each.count for each in summary.errors),
            "by": self.words.heading() or say("fleet_summary.by_nothing"),
            "atleak": summary.atleak,
        }
        return [(say(f"fleet_summary.fact_{name}"), value) for name, value in figures.items()]

    def facts(self) -> list[tuple[str, str]]:
        """Return what the summary is of, in words."""
        return [(name, each if isinstance(each, str) else self.say.number(each, 0)) for name, each in self.figures()]

    def head(self) -> Section:
        """Say what the summary is of, and what leads."""
        findings = " ".join(self.words.findings())
        texts = [Text(each) for each in (self.words.headline(), findings) if each]
        return Section("head", self.say("fleet_summary.title"), (*texts, Facts(self.facts())))

    def _verdicts(self) -> Iterator[SectionPart]:
        """Say how many units have which verdict, of all valve bodies and of each."""
        say, summary = self.say, self.summary
        if not summary.counts.units:
            yield Text(say("fleet_summary.no_units"))
            return
        rows = [Counted(None, None, summary.counts)]
        if len(summary.bodies) > 1:
            rows += [Counted(body, None, body.counts) for body in summary.bodies[:_ROWS]]
        named = [
            (say("fleet_summary.all_units") if row.body is None else self._name(row.body), row.counts) for row in rows
        ]
        counts, table = summary.counts.verdicts, self.tables.verdicts(rows)
        by_level = (*VERDICTS[1:], VERDICTS[0])
        counted = ", ".join(f"{say.level(level)} {say.number(counts[level], 0)}" for level in by_level)
        yield Picture(
            "verdicts",
            self.charts.verdicts(named),
            say("fleet_summary.alt_verdicts", counted=counted),
            say("fleet_summary.caption_verdicts"),
            by_level,
            table.only("body", "units", *(f"verdict_{level}" for level in by_level)),
        )
        yield table.only("body", "units", "judged", *_RATES)
        yield from self._notes(self.say("fleet_summary.note_rates"), more_bodies=len(summary.bodies) - _ROWS)

    def _notes(self, *notes: str, **more: int) -> Iterator[Text]:
        """Yield what is to be known of a table, and what is not in it."""
        sentences = list(notes)
        sentences += [self.say(f"fleet_summary.{key}", count=count) for key, count in more.items() if count > 0]
        if sentences:
            yield Text(" ".join(sentences), small=True)

    def know(self) -> Section:
        """Say what to know about the results."""
        summary, depth = self.summary, self.depth
        items = self.words.messages(summary.messages)
        if len(summary.bodies) == 1:
            items += self.words.messages(summary.bodies[0].messages)
        beyond = len(summary.bodies) - depth.bodies
        if beyond > 0:
            items.append(self.say("fleet_summary.beyond", count=beyond, detailed=depth.bodies))
        return self._section("know", _listed(items))

    # --- one valve body

    def intro(self, body: ValveBody) -> Section:
        """Say how many units there are, what leads, and what to know about them."""
        say, counts = self.say, body.counts
        numbers = {"judged": say.number(counts.judged, 0), "visits": say.number(body.visits, 0)}
        key = "body_units" if counts.judged else "body_unjudged"
        sentences = [say(f"fleet_summary.{key}", count=counts.units, **numbers)]
        if counts.judged:
            sentences.append(say("fleet_summary.headline", rate=self.words.rate(counts.rates[Verdict.REPLACE])))
            sentences.append(self.words.leading_pair(body))
        parts = Text(" ".join(sentences)), *_listed(self.words.messages(body.messages))
        return Section("body", self._name(body), parts, level=1)

    def _pairs(self, body: ValveBody) -> Iterator[SectionPart]:
        """Say which pairs are flagged and to be replaced most often."""
        say, depth = self.say, self.depth
        flagged = [pair for pair in body.pairs if pair.flagged.count or pair.deciding.count]
        if not body.counts.judged:
            return
        if not flagged:
            yield Text(say("fleet_summary.no_pair_flagged"))
            return
        drawn = flagged[: depth.drawn]
        names = [self.words.land(body.controller, pair.key) for pair in drawn]
        judged = say.number(body.counts.judged, 0)
        if drawn:
            first = drawn[0].replace
            alt = {"body": self._name(body), "pair": names[0], "rate": self.words.counted(first.count, first.of)}
            yield Picture(
                "pairs",
                self.charts.pairs(drawn, names),
                say("fleet_summary.alt_pairs", **alt),
                say("fleet_summary.caption_pairs", judged=judged),
                (FLAGGED[0], Verdict.REPLACE),
            )
        shown = self.tables.pairs([body])
        shown = shown.only("pair", "measured", "pair_flagged", "pair_replace", "pair_deciding", "pair_not_measured")
        yield shown.first(min(depth.pairs, len(flagged)) if depth.pairs < _ALL else _ALL)
        note = say("fleet_summary.note_pairs", judged=judged)
        yield from self._notes(note, more_pairs=len(flagged) - depth.pairs)

    def _deciders(self, body: ValveBody) -> Iterator[SectionPart]:
        """Say what decided the verdicts of flagged units."""
        if body.deciders and self.depth.deciders:
            yield self.tables.deciders([body]).only("decided_by", "decided").first(self.depth.deciders)
            yield from self._notes(self.say("fleet_summary.note_deciders"))

    def _wear(self, body: ValveBody) -> Iterator[SectionPart]:
        """Say how the wear of the leading lands grows with mileage."""
        if not any(land.latest_percent for land in body.wear):
            return
        say, lands = self.say, [land for land in by_trouble(body) if land.classes][: self.depth.wear]
        if not lands:
            yield Text(say("fleet_summary.no_mileage"))
            return
        charts = [self.charts.wear(body, land) for land in lands]
        names = "; ".join(chart.name for chart in charts)
        shown = self.tables.wear([replace(body, wear=tuple(lands))]).only("pair", "mileage", "wear.units", "wear")
        yield Picture(
            "wear",
            charts,
            say("fleet_summary.alt_wear", body=self._name(body), pairs=names),
            f"{say('fleet_summary.caption_boxes')} {say('fleet_summary.caption_wear')}",
            numbers=shown,
        )
        left_out = {name: max(getattr(land, name) for land in body.wear) for name in ("without_mileage", "repaired")}
        without, repaired = left_out.values()
        if without or repaired:
            yield Text(say("fleet_summary.note_wear", without=without, repaired=repaired), small=True)

    def _temperatures(self, body: ValveBody) -> Iterator[SectionPart]:
        """Say what the logs tell over temperature."""
        say, classes = self.say, body.temperatures
        if not any(each.units for each in classes):
            yield Text(say("fleet_summary.no_logs"))
            return
        hours = say.number(sum(each.seconds for each in classes) / 3600.0, 1)
        span = say.span([classes[0].low_c, classes[-1].high_c], "temperature", 0)
        sentences = [] if any(land.classes for land in body.wear) else [say("fleet_summary.caption_boxes")]
        sentences.append(say("fleet_summary.caption_temperatures", hours=hours))
        yield Picture(
            "temperatures",
            self.charts.temperatures(classes),
            say("fleet_summary.alt_temperatures", body=self._name(body), span=span),
            " ".join(sentences),
            BANDS if any(each.bands_percent for each in classes) else (),
            self.tables.temperatures([body]).only(*_OVER_TEMPERATURE).filled,
        )

    def _conditions(self, body: ValveBody) -> Iterator[SectionPart]:
        """Say what is at the stated conditions."""
        if not body.conditions:
            return
        yield self.tables.conditions([body]).only("condition", "share.units", "share", "held", "required", "red")
        yield from self._notes(
            self.say("fleet_summary.note_conditions"), note_partly=max(at.partly for at in body.conditions)
        )

    # --- groups

    def _comparison(self, body: ValveBody) -> Iterator[SectionPart]:
        """Say what differs between the groups, and what cannot be told."""
        comparison, say, by = body.comparison, self.say, self.words.heading()
        if self.summary.by is None:
            return
        if comparison is None:
            yield Text(say("fleet_summary.one_group", by=by))
            return
        how = "in_pairs" if comparison.in_pairs else "with_others"
        yield Text(say(f"fleet_summary.{how}", by=by, count=len(comparison.groups)))
        largest = sorted(counted_groups(body), key=lambda group: -group.counts.units)[: self.depth.groups]
        judged = {group.group for group in largest[: self.depth.drawn] if group.counts.judged}
        drawn = [group for group in comparison.groups if group.name in judged]
        if drawn:
            yield Picture(
                "groups",
                self.charts.groups(drawn),
                say("fleet_summary.alt_groups", body=self._name(body), groups=", ".join(group.name for group in drawn)),
                say("fleet_summary.caption_groups"),
                FLAGGED,
            )
        yield self.tables.verdicts(largest).only("group", "units", "judged", "mileage.median", *_RATES)
        left = len(comparison.groups) - len(largest)
        yield from self._notes(more_groups=left, not_stated=comparison.not_stated)
        yield from self._rates_compared(comparison)
        yield from self._wear_compared(body, comparison)
        yield from _listed(self.words.messages(comparison.messages))

    def _rates_compared(self, comparison: GroupComparison) -> Iterator[SectionPart]:
        compared = [each for each in comparison.verdicts if each.points and each.points.differs is not None]
        found = [each for each in compared if each.points and each.points.differs]
        yield Text(self._differ("rates", len(found), len(compared)), leads=bool(found))
        found.sort(key=lambda each: -abs(each.points.value if each.points else 0.0))
        yield from _listed([self.words.difference_of_rates(each) for each in found[: self.depth.differences]])

    def _differ(self, what: str, found: int, compared: int) -> str:
        how = "differ" if found else "alike" if compared else "too_few"
        how = "differs" if found and what == "wear" else how
        return self.say(f"fleet_summary.{what}_{how}", found=found, count=compared)

    def _wear_compared(self, body: ValveBody, comparison: GroupComparison) -> Iterator[SectionPart]:
        told = [each for each in comparison.lands if called(each) is not None]
        found = [each for each in told if called(each)]
        yield Text(self._differ("wear", len(found), len(told)), leads=bool(told))
        if not told:
            return
        if self.depth.compared:
            yield from self._drawn_differences(body, found, told)
        shown = found if self.depth.differences < _ALL else told
        if shown:
            compared = replace(body, comparison=replace(comparison, lands=tuple(shown)))
            table = self.tables.wear_compared([compared])
            columns = ["pair", "compared", "means", "mean_points", "same_mileage"]
            columns += ["differs"] if len(shown) > len(found) else []
            yield table.only(*columns).first(self.depth.differences)
            more, not_told = len(shown) - self.depth.differences, len(comparison.lands) - len(told)
            yield from self._notes(
                self.say("fleet_summary.note_wear_compared"), more_differences=more, not_told=not_told
            )

    def _drawn_differences(
        self, body: ValveBody, found: Sequence[WearDifference], compared: Sequence[WearDifference]
    ) -> Iterator[SectionPart]:
        yield from _listed([self.words.difference_of_wear(body, each) for each in found[:3]])
        drawn = (found or compared)[: self.depth.drawn]
        yield Picture(
            "differences",
            self.charts.differences(body, drawn),
            self.say("fleet_summary.section_comparison"),
            self.say("fleet_summary.caption_differences"),
        )

    # --- units and files

    def _worst(self) -> Iterator[SectionPart]:
        """List the flagged units, the worst first."""
        say, summary = self.say, self.summary
        listed = [unit for unit in summary.worst if unit.verdict.flagged][: self.depth.units]
        if not listed:
            yield Text(say("fleet_summary.none_flagged"))
            return
        table = self.tables.units().only(
            *("name", "told_by", "group", "mileage", "verdict", "decided_by", "lands_past")
        )
        yield replace(table, rows=[replace(unit, name=within_words(unit.name, _UNIT_NAME)) for unit in listed]).filled
        flagged = sum(summary.counts.verdicts[verdict] for verdict in FLAGGED)
        yield from self._notes(self.say("fleet_summary.note_worst"), more_units=flagged - len(listed))

    def _errors(self) -> Iterator[SectionPart]:
        """Say which files have no result, and why."""
        say, errors = self.say, self.summary.errors
        if not errors:
            yield Text(say("fleet_summary.no_errors"))
            return
        for kind in errors:
            yield Text(f"{say.get('fleet_errors', kind.kind)}: {say.number(kind.count, 0)}", leads=True)
            yield Points([shortened(message, self.depth.message) for message in kind.messages])
        yield from self._notes(self.say("fleet_summary.note_errors"))

    def rests_on(self, level: int = 2) -> Section:
        """Say what the words mean."""
        rows = [(self.say(f"fleet_terms.{name}"), self.say(f"fleet_meaning.{name}")) for name in TERMS]
        return self._section("rests_on", (Facts(rows),), level)


def _listed(items: Sequence[str]) -> Iterator[SectionPart]:
    if items:
        yield Points(items)
