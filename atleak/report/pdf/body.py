"""Build the sections of a printed report as blocks of ready text: the template only places them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import groupby
from typing import Any

from atleak.catalogue.fluid import USED_THINNER
from atleak.catalogue.limits import Level, LimitOrigin, RuleKind, Steps
from atleak.engine.profile import UNKNOWN
from atleak.errors import Message, unknown
from atleak.job.doubts import record_doubts
from atleak.job.record import RepairDecision, Scratch
from atleak.phrases import PART_WORDS
from atleak.report.estimate_words import open_words
from atleak.report.pdf.annex import Annex
from atleak.report.pdf.blocks import (
    Block,
    PrintedColumn,
    facts,
    grouped_table,
    joined,
    passage,
    table,
    text,
    with_notes,
)
from atleak.report.pdf.budget import Budget
from atleak.report.pdf.conditions import Conditions
from atleak.report.pdf.estimate import estimate_blocks
from atleak.report.pdf.gauges import gauge_blocks
from atleak.report.pdf.pressures import Pressures
from atleak.report.pdf.printed_names import PrintedNames
from atleak.report.pdf.road import RoadTestSection
from atleak.sentence import Sentence
from atleak.verdicts import VERDICTS, Verdict
from atleak.version import __version__
from atleak.views.land_names import component_words
from atleak.views.road_series import RoadSeries
from atleak.views.sentences import fluid_in_state, measuring_temperature
from atleak.wording import isolated
from atleak.workshop_units import G_CM3, MM, MM2_S, PERCENT, UM

SECTIONS = (
    "picture",
    "flagged",
    "matrix",
    "pressures",
    "repair_order",
    "all",
    "shares",
    "again",
    "gauges",
    "road_test",
    "repair",
    "estimate",
    "condition",
    "photos",
    "notes",
    "conditions",
    "limits",
    "decisions",
    "assumptions",
    "messages",
    "method",
    "readings",
    "budget",
    "provenance",
    "signatures",
)
# those that say what was measured of lands, and what follows from it
OF_LANDS = (
    "picture",
    "flagged",
    "matrix",
    "pressures",
    "repair_order",
    "all",
    "shares",
    "again",
    "decisions",
    "readings",
    "budget",
)
CATALOGUE_LANGUAGE = "en"  # of the sources that the catalogue's files name
BARS = 16  # largest number of bars in the chart of shares


def chosen_sections(sections: Iterable[str] | None, *, without_sheet: bool = False) -> tuple[str, ...]:
    """Return the sections asked for, in the report's order; all of them where none is chosen.

    Without a measuring sheet those about lands are left out unless they are asked for: no land was measured.

    Raises
    ------
    InputError
        if no report has such a section.
    """
    if sections is None:
        return tuple(name for name in SECTIONS if not (without_sheet and name in OF_LANDS))
    wanted = list(sections)
    for name in wanted:
        if name not in SECTIONS:
            raise unknown(Sentence("no such section"), name, SECTIONS)
    return tuple(name for name in SECTIONS if name in wanted)


class Body:
    """The sections of one report.

    ``series`` is the thinned road test; ``pictures`` holds the printable pictures by their names in the job.
    """

    def __init__(self, names: PrintedNames, series: RoadSeries | None, pictures: dict[str, str]) -> None:
        self.names, self.series, self.pictures = names, series, pictures
        self.diagnosis, self.record, self.job, self.say = names.diagnosis, names.record, names.job, names.say
        self.conditions, self.pressures, self.annex = Conditions(names), Pressures(names), Annex(names)

    # --- sections

    def sections(self, names: Iterable[str], charts: dict[str, str]) -> list[dict[str, Any]]:
        """Return title and blocks of every section that has any content."""
        filled = []
        for name in names:
            if name == "signatures":  # stands at the foot of the first page
                continue
            build: Callable[[dict[str, str]], Iterable[Block]] = getattr(self, f"_{name}")
            blocks = list(with_notes(build(charts)))
            if blocks:
                filled.append({"name": name, "title": self.say(f"sections.{name}"), "blocks": blocks})
        return filled

    def _picture(self, charts: dict[str, str]) -> Iterable[Block]:
        say, diagnosis = self.say, self.diagnosis
        flagged = joined(self.names.land_name(land) for land in diagnosis.flagged)
        said = say("charts.picture_flagged", lands=flagged) if flagged else say("charts.picture_none")
        components = len({land.key[0] for land in diagnosis.lands})
        counts = {verdict: sum(land.verdict == verdict for land in diagnosis.lands) for verdict in VERDICTS}
        open_ = [land.state for land in diagnosis.lands if land.verdict is Verdict.NOT_MEASURED]
        half = sum(state.measured and state.land.seal is None for state in open_)
        sealed = sum(state.land.seal is not None for state in open_)
        counts[Verdict.NOT_MEASURED] -= half + sealed
        legend = [
            [verdict, f"{say.level(verdict)}: {counts[verdict]}"] for verdict in reversed(VERDICTS) if counts[verdict]
        ]
        for key, count in (("half_measured", half), ("sealed", sealed)):
            legend += [[Verdict.NOT_MEASURED, say(f"charts.{key}", count=count)]] if count else []
        words = joined(text for _, text in legend)
        yield {
            "kind": "image",
            "file": charts["picture"],
            "alt": say("charts.picture_alt", components=components, flagged=said),
            "caption": say("charts.caption_picture", counts=words),
            "legend": legend,
        }

    def _flagged(self, charts: dict[str, str]) -> Iterable[Block]:
        say, names, flagged = self.say, self.names, self.diagnosis.flagged
        if not flagged:
            yield text(say("texts.none_flagged"))
            return
        decided = any(land.decision for land in flagged)
        columns = [
            PrintedColumn(names.column("pair"), names.pair, width=3),
            PrintedColumn(names.column("land"), names.land, side="c"),
            PrintedColumn(names.column("verdict"), names.verdict),
            PrintedColumn(names.column("clearance"), names.clearance, say.unit("clearance"), side="d"),
            PrintedColumn(names.column("mounting"), names.mounting, say.unit("clearance"), side="r"),
            PrintedColumn(names.column("wear"), names.wear, "%", side="r"),
            PrintedColumn(names.column("share_largest"), names.share_largest, "%", side="r"),
        ]
        if decided:
            columns.append(PrintedColumn(names.column("decision"), names.decision, width=2))
        yield table(columns, flagged, told=names.reason)
        notes = [say("texts.both_rules")]
        notes += [say("texts.decision")] if decided else []
        notes += [say("texts.uncertainty")] if self.diagnosis.uncertainty else []
        yield text(" ".join(notes), small=True)

    def _repair_order(self, charts: dict[str, str]) -> Iterable[Block]:
        yield from self.conditions.repair_order()

    def _matrix(self, charts: dict[str, str]) -> Iterable[Block]:
        yield from self.conditions.matrix()

    def _pressures(self, charts: dict[str, str]) -> Iterable[Block]:
        yield from self.pressures.blocks(charts)

    def _again(self, charts: dict[str, str]) -> Iterable[Block]:
        """Name what to measure again where the readings leave open on which side of a limit a land lies."""
        say, names = self.say, self.names
        items = names.advice_by_group(land for land in self.diagnosis.flagged if land.decision in _CONDITIONAL)
        if items:
            yield {"kind": "list", "items": items}
        within = [land for land in self.diagnosis.lands if land.verdict == Verdict.OK and land.decision in _CONDITIONAL]
        for key, suspect in (("texts.unsure", False), ("texts.suspect", True)):
            lands = [names.land_number(land) for land in within if land.suspect == suspect]
            if lands:
                yield text(say(key, lands=joined(lands)))

    def _all(self, charts: dict[str, str]) -> Iterable[Block]:
        say, names = self.say, self.names
        columns = [
            PrintedColumn(names.column("land"), names.land, width=1),
            PrintedColumn(
                names.column("sleeve"),
                lambda at: say.value(at.state.sleeve_diameter * MM, "length", 4),
                say.unit("length"),
                side="r",
            ),
            PrintedColumn(
                names.column("spool"),
                lambda at: say.value(at.state.spool_diameter * MM, "length", 4),
                say.unit("length"),
                side="r",
            ),
            PrintedColumn(names.column("clearance"), names.clearance, say.unit("clearance"), side="d"),
            PrintedColumn(names.column("mounting"), names.mounting, say.unit("clearance"), side="r"),
            PrintedColumn(names.column("wear"), names.wear, "%", side="r"),
            PrintedColumn(
                names.column("effective"),
                lambda at: say.value(at.effective_clearance * UM, "clearance", 1),
                say.unit("clearance"),
                side="r",
            ),
            PrintedColumn(names.column("leakage"), lambda at: names.flow(at.leakage, 3), say.unit("flow"), side="r"),
            PrintedColumn(names.column("interval"), names.leakage_interval, say.unit("flow"), side="r"),
            PrintedColumn(names.column("share"), names.share, "%", side="r"),
            PrintedColumn(names.column("verdict"), names.verdict),
        ]
        yield grouped_table(columns, ((pair, list(lands)) for pair, lands in groupby(self.diagnosis.lands, names.pair)))
        at = self.names.condition(self.diagnosis.projection.condition)
        yield text(say("texts.all_at", condition=at), small=True)

    def _shares(self, charts: dict[str, str]) -> Iterable[Block]:
        if "shares" not in charts:
            return
        say, at = self.say, self.diagnosis.projection
        top = self.diagnosis.drawing_most[:BARS]
        lands = joined(f"{self.names.land_name(land)} {say.percent(land.share, 2)}" for land in top)
        yield {
            "kind": "image",
            "file": charts["shares"],
            "alt": say("charts.shares_alt", lands=lands),
            "caption": say("charts.caption_shares", condition=self.names.condition(at.condition)),
        }

    def _gauges(self, charts: dict[str, str]) -> Iterable[Block]:
        yield from gauge_blocks(self.diagnosis, self.say)

    def _road_test(self, charts: dict[str, str]) -> Iterable[Block]:
        yield from RoadTestSection(self.names, self.series).blocks(charts)

    def _repair(self, charts: dict[str, str]) -> Iterable[Block]:
        say = self.say
        columns = [
            PrintedColumn(say("printed.pair"), self._repaired_pair, width=4),
            PrintedColumn(say("printed.work"), lambda each: each.work, width=5),
            PrintedColumn(
                say("printed.decision"),
                lambda each: say.get("job_decisions", each.decision) if each.decision else "–",
            ),
            PrintedColumn(say("printed.reason"), lambda each: each.reason, width=6),
            PrintedColumn(say("printed.date"), lambda each: say.date(each.date) if each.date else ""),
        ]
        yield table(columns, [each for each in self.job.repair_decisions if not each.empty], empty=False)
        for sentence in open_words(self.diagnosis, self.job, say, closing=True):
            yield text(sentence)

    def _repaired_pair(self, decision: RepairDecision) -> str:
        land = f"{self.say('printed.land')}\u00a0{decision.land}" if decision.land else ""
        return joined((component_words(self.diagnosis.controller, decision.component, self.say), land))

    def _estimate(self, charts: dict[str, str]) -> Iterable[Block]:
        yield from estimate_blocks(self.names)

    def _condition(self, charts: dict[str, str]) -> Iterable[Block]:
        say, job = self.say, self.job
        oil, dirt = job.fluid_condition, job.contamination
        remarks = [
            oil.product,
            say("facts.changed_at", mileage=say.value(oil.changed_at_km, "distance", 0))
            if oil.changed_at_km is not None
            else "",
            f"{say('facts.level')}: {oil.level}" if oil.level else "",
            f"{say('facts.colour')}: {oil.colour}" if oil.colour else "",
            f"{say('facts.smell')}: {oil.smell}" if oil.smell else "",
            oil.note,
        ]
        grade = say.get("grades", dirt.grade) if dirt.grade else ""
        rows = [
            [say("facts.fluid_found"), joined(remarks, "; ")],
            [say("facts.contamination"), joined((grade, dirt.particles, dirt.note), "; ")],
        ]
        yield facts([row for row in rows if row[1]])
        columns = [
            PrintedColumn(say("printed.component"), self._scratched, width=3),
            PrintedColumn(say("printed.land"), lambda each: str(each.land or ""), width=1),
            PrintedColumn(say("facts.scratches"), lambda each: each.description, width=6),
        ]
        yield table(columns, [each for each in job.scratches if not each.empty])

    def _scratched(self, scratch: Scratch) -> str:
        part = next((words for name, words in PART_WORDS.items() if name == scratch.part), scratch.part)
        return joined((scratch.component, self.say.sentence(part)), " ")

    def _photos(self, charts: dict[str, str]) -> Iterable[Block]:
        photos = [(photo.file, joined((photo.component, photo.caption), " · ")) for photo in self.job.photos]
        photos += [
            (each.photo, joined((each.component, each.description), " · ")) for each in self.job.scratches if each.photo
        ]
        shown = [
            {"file": self.pictures[name], "caption": caption, "alt": caption or name}
            for name, caption in photos
            if name in self.pictures
        ]
        if shown:
            yield {"kind": "photos", "photos": shown}

    def _notes(self, charts: dict[str, str]) -> Iterable[Block]:
        for part in self.job.notes.splitlines():
            if part.strip():
                yield text(part)

    def _conditions(self, charts: dict[str, str]) -> Iterable[Block]:
        say, diagnosis, job = self.say, self.diagnosis, self.job
        model = diagnosis.profile.viscosity
        fluid = diagnosis.fluid
        viscosities = [
            say(
                "facts.viscosity_at",
                nu=say.number(fluid.kinematic_viscosity(projection.condition.temperature, model) * MM2_S, 2),
                rho=say.number(fluid.density(projection.condition.temperature, model) * G_CM3, 4),
                temperature=say.plain_value(projection.condition.temperature, "temperature"),
            )
            for projection in diagnosis.reported
        ]
        instruments = [
            joined(
                (
                    joined((each.name, each.serial), " "),
                    say("facts.calibrated", date=say.date(each.calibrated)) if each.calibrated else "",
                    each.note,
                )
            )
            for each in job.instruments
            if not each.empty
        ]
        measured = f"{diagnosis.measured} / {len(diagnosis.lands)}"
        temperature = measuring_temperature(diagnosis, say)
        options = joined(f"{name} = {_option(value)}" for name, value in diagnosis.profile.options.items())
        uncertainty = diagnosis.uncertainty
        taken = (
            say(
                "facts.taken",
                spool=say.name(uncertainty.instruments.spool.name),
                sleeve=say.name(uncertainty.instruments.sleeve.name),
                coverage=say.percent(uncertainty.coverage, 0),
                guard=say.plain(uncertainty.guard_factor),
            )
            if uncertainty
            else ""
        )
        yield facts(
            [
                [say("facts.controller"), say.name(diagnosis.controller.name)],
                [say("facts.fluid"), fluid_in_state(diagnosis, say)],
                [say("facts.viscosity"), joined(viscosities, "; ")],
                [say("facts.profile"), diagnosis.profile.label],
                [say("facts.options"), options],
                [say("facts.measured"), measured],
                *([[say("facts.measuring_temperature"), temperature]] if temperature else []),
                *([[say("facts.instruments"), joined(instruments, "; ")]] if instruments else []),
                *([[say("facts.uncertainty"), taken]] if taken else []),
            ]
        )

    def _limits(self, charts: dict[str, str]) -> Iterable[Block]:
        say, limits = self.say, self.diagnosis.limits
        columns = [
            PrintedColumn(say("printed.rule"), lambda rule: say(f"rules.{rule[0]}"), width=3),
            PrintedColumn(say("printed.limit"), lambda rule: self._levels(*rule), width=4),
            PrintedColumn(say("printed.origin"), lambda rule: say.get("origins", rule[1].origin), width=2),
            PrintedColumn(say("printed.source"), lambda rule: self._source_of(rule[1]), width=6),
        ]
        yield table(columns, limits.rules.items())
        yield text(f"{isolated(say.name(limits.name))}. {say('texts.limit_note')}", small=True)

    def _source_of(self, steps: Steps) -> str | dict[str, str]:
        """Return the source of a limit: what the workshop set, it says in its own words."""
        own = steps.origin is LimitOrigin.WORKSHOP
        return steps.source if own else passage(steps.source, CATALOGUE_LANGUAGE, self.say)

    def _levels(self, kind: RuleKind, steps: Steps) -> str:
        say = self.say
        words = [
            say(f"rules.{_begins(steps, level)}", level=say.level(level), limit=say("rules.and").join(asked))
            for level, asked in ((level, self._asked(kind, steps, level)) for level, _ in steps.levels)
        ]
        return joined([*words, say("rules.fall", fall=say.plain(steps.fall * PERCENT)) if steps.fall else ""])

    def _asked(self, kind: RuleKind, steps: Steps, level: Level) -> Iterable[str]:
        """Return all that a level asks for: its limit, a least growth in µm, growth over the same land or unit new."""
        say, limit = self.say, dict(steps.levels)[level]
        if steps.has_limit(level):
            carried, quantity = limit * kind.factor, kind.quantity
            yield (
                say.plain_quantity(carried, quantity) if quantity else f"{say.plain(carried)}\u00a0{kind.unit}".rstrip()
            )
        if level in steps.at_least:
            yield say("rules.at_least", clearance=say.plain_quantity(steps.at_least[level] * UM, "clearance"))
        if level in steps.growth:
            growth, added = steps.growth[level]
            yield say("rules.growth", growth=say.plain(growth * PERCENT))
            if added:
                yield say("rules.added", points=say.plain(added * PERCENT))

    def _assumptions(self, charts: dict[str, str]) -> Iterable[Block]:
        say, diagnosis = self.say, self.diagnosis
        items = [say.name(diagnosis.controller.representative)] if diagnosis.controller.representative else []
        by_values: dict[tuple[str, ...], list[str]] = {}
        for land in diagnosis.lands:
            values = land.state.land.representative
            if values:
                by_values.setdefault(values, []).append(self.names.land_number(land))
        for values, lands in by_values.items():
            names = joined(say.get("parts", value) for value in values)
            values_of_lands = say("texts.representative_land", values=names, lands=joined(lands))
            items.append(say("texts.representative_lands", values=values_of_lands))
        if diagnosis.controller.pump.representative:
            names = joined(say.get("value_names", each) for each in diagnosis.controller.pump.representative)
            items.append(say("texts.representative_lands", values=names))
        if diagnosis.fluid_state_assumed:
            low, high = USED_THINNER
            items.append(say("texts.fluid_assumed", low=low, high=high))
        if diagnosis.fluid.representative:
            names = joined(say.get("value_names", each) for each in diagnosis.fluid.representative)
            items.append(f"{isolated(say.name(diagnosis.fluid.name))}: {say('facts.representative')}: {names}.")
        for status, key in (("spool_only", "assumed_sleeve"), ("sleeve_only", "assumed_spool"), ("not_measured",) * 2):
            lands = [self.names.land_number(land) for land in diagnosis.lands if land.state.status == status]
            if lands:
                items.append(say(f"texts.{key}", lands=joined(lands)))
        own = [
            say(f"rules.{name}")
            for name, steps in diagnosis.limits.rules.items()
            if steps.origin is LimitOrigin.PROJECT
        ]
        if own:
            items.append(say("texts.project_limits", rules=joined(own)))
        pump = diagnosis.controller.pump
        if diagnosis.model.uses_slip:
            items.append(say("texts.slip"))
        else:
            items.append(say("texts.efficiency", value=say.plain(pump.volumetric_efficiency)))
        yield {"kind": "list", "items": items or [say("texts.none_assumed")]}

    def _messages(self, charts: dict[str, str]) -> Iterable[Block]:
        messages = (*record_doubts(self.job, self.diagnosis), *self.diagnosis.messages)
        items = [
            self._said(message)
            for level in ("warning", "info")
            for message in messages
            if message.level == level and message.code not in _SAID_ELSEWHERE
        ]
        if items:
            yield {"kind": "list", "items": items}

    def _said(self, message: Message) -> str:
        """Return a message, with its place where it has one."""
        said = self.say.sentence(message.text)
        place = self.say.sentence(message.place.sentence) if message.place else ""
        return f"{said} ({place})" if place else said

    def _method(self, charts: dict[str, str]) -> Iterable[Block]:
        say, profile, diagnosis = self.say, self.diagnosis.profile, self.diagnosis
        names = [f"method_{profile.diameter}", f"method_{profile.viscosity}", f"method_{profile.pump_draw}"]
        sentences = [say("texts.method"), *(say(f"texts.{name}") for name in names)]
        if profile.form == "mean_of_cubes":
            sentences.append(say("texts.method_form"))
        if profile.entry_loss != "off":
            sentences.append(say("texts.method_entry_loss"))
        if profile.eccentricity == UNKNOWN:
            sentences.append(say("texts.method_eccentricity_unknown"))
        elif profile.eccentricity:
            sentences.append(say("texts.method_eccentricity", value=say.plain(profile.eccentricity)))
        yield text(" ".join((*sentences, say("texts.method_limits"))))
        study = say("texts.source_study")
        sources = dict.fromkeys((diagnosis.controller.source, diagnosis.fluid.source, diagnosis.limits.source))
        named = [passage(each, CATALOGUE_LANGUAGE, say) for each in sources if each and each != study]
        yield {"kind": "list", "items": [study, *named]}

    def _decisions(self, charts: dict[str, str]) -> Iterable[Block]:
        yield from self.annex.decisions()

    def _readings(self, charts: dict[str, str]) -> Iterable[Block]:
        yield from self.annex.readings()

    def _budget(self, charts: dict[str, str]) -> Iterable[Block]:
        yield from Budget(self.names).blocks()

    def _provenance(self, charts: dict[str, str]) -> Iterable[Block]:
        say, record = self.say, self.record
        yield from self.annex.issue()
        profile = self.diagnosis.profile.label
        yield text(say("texts.made_with", version=__version__, profile=profile, language=say.texts["language"]))
        columns = [
            PrintedColumn("", lambda name: say(f"facts.{name}"), width=2),
            PrintedColumn(
                say("printed.file"), lambda name: record[name].get("file") or record[name].get("id"), width=3
            ),
            PrintedColumn("SHA-256", lambda name: record[name]["sha256"], width=8),
        ]
        used = ("readings", "road_test", "pressure_table", "controller", "fluid", "limits")
        yield table(columns, [name for name in used if record[name] and record[name].get("sha256")])


_SAID_ELSEWHERE = ("controller_representative",)  # stands among the representative values
_CONDITIONAL = ("conditional_pass", "conditional_fail")


def _begins(steps: Steps, level: Level) -> str:
    """Return the key of the words for where a level begins: from, over or under its limit."""
    if steps.falling:
        return "level_under"
    return "level_over" if steps.limit_of(level) == 0.0 and steps.has_limit(level) else "level"


def _option(value: Any) -> str:
    return {True: "on", False: "off"}[value] if isinstance(value, bool) else str(value)
