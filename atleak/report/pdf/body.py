"""Build the sections of a printed report as blocks of ready text: the template only places them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import isfinite
from types import MappingProxyType
from typing import Any

from atleak.analysis.record_doubts import components_of, record_doubts
from atleak.catalogue.castings import sound_casting
from atleak.catalogue.limits import Level, LimitOrigin, RuleKind, Steps
from atleak.catalogue.words import PART_WORDS
from atleak.common.errors import unknown
from atleak.common.sentences import Sentence
from atleak.common.style import look_of
from atleak.common.units import G_CM3, MM2_S, PERCENT, UM
from atleak.common.verdicts import VERDICTS, Verdict
from atleak.common.wording import Wording, isolated, joined
from atleak.diagnosis.land import LandDiagnosis
from atleak.engine.profile import UNKNOWN
from atleak.measurements.job_card import RepairDecision, Scratch
from atleak.report.charts.casting import casting_drawing
from atleak.report.charts.chart import LayerOf, RowChart, layers_of
from atleak.report.charts.drawing import controller_svg, shortened
from atleak.report.charts.paper import drawn_on_paper as printed_chart
from atleak.report.json.conditions import named_record
from atleak.report.json.diagnosis import head_record
from atleak.report.pdf.annex import Annex, Budget
from atleak.report.pdf.blocks import (
    FEW,
    Block,
    abreast,
    bullets,
    listed,
    named_facts,
    passage,
    picture,
    printed,
    text,
    with_notes,
)
from atleak.report.pdf.conditions import Conditions, Pressures, RoadTestSection
from atleak.report.pdf.workshop import before_opening_blocks, estimate_blocks, gauge_blocks
from atleak.report.printed_names import PrintedNames, PrintedPart
from atleak.report.tables.assumed import assumed_line, assumed_table
from atleak.report.tables.estimate import open_words
from atleak.report.tables.names import components_words
from atleak.report.tables.road_test import RoadSeries
from atleak.report.tables.sentences import fluid_in_state, measuring_temperature, option_words, profile_words
from atleak.report.tables.table import Column, Table
from atleak.version import __version__

# those that say what was measured of lands, and what follows from it
_OF_LANDS = (
    "picture", "flagged", "matrix", "pressures", "repair_order", "all", "shares", "again", "decisions", "readings",
    "budget",
)  # fmt: skip
_CUSTOMER = ("signatures",)  # at the foot of the customer's page
_WORKSHOP = (
    "picture", "flagged", "again", "pressures", "repair_order", "gauges", "before_opening", "road_test", "repair",
    "estimate", "condition", "photos", "notes",
)  # fmt: skip
_ANNEX = (
    "all", "shares", "road_log", "conditions", "limits", "decisions", "assumptions", "messages", "method", "readings",
    "budget", "provenance",
)  # fmt: skip
_BY_NAME = ("matrix",)  # printed where it is asked for: what it says of lands stands in the table of all of them
PDF_SECTIONS = (*_WORKSHOP, *_BY_NAME, *_ANNEX, *_CUSTOMER)
DOCUMENTS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "report": (*_WORKSHOP, *_CUSTOMER),
        "customer": _CUSTOMER,
        "workshop": _WORKSHOP,
        "annex": _ANNEX,
        "all": (*_WORKSHOP, *_ANNEX, *_CUSTOMER),
    }
)
"""What one prints of a diagnosis, with the sections of each; the first is customer's and workshop's report together."""
_WIDTHS = {"pair": 300, "consequence": 100, "decision": None}  # of the columns of flagged lands: a line each
_ELSEWHERE = ("sleeve", "spool", "effective", "leakage", "interval")  # of lands: in the table of all of them
_STUDY = "Dziubak & Szczepaniak, Energies 2023, 16, 7667"  # as the catalogue's files cite it
CATALOGUE_LANGUAGE = "en"  # of the sources that the catalogue's files name
_BARS = 16  # largest number of bars in the chart of shares
_MANY = 16  # rows of a table from which on its letters are small


def chosen_sections(
    sections: Iterable[str] | None, document: str = "all", *, without_sheet: bool = False
) -> tuple[str, ...]:
    """Return the sections asked for, in the report's order; those of the document where none is chosen.

    Without a measuring sheet those about lands are left out unless they are asked for: no land was measured.

    Raises
    ------
    InputError
        if there is no such document, or it has no such section.
    """
    if document not in DOCUMENTS:
        raise unknown(Sentence("no such document"), document, DOCUMENTS)
    if sections is None:
        return tuple(name for name in DOCUMENTS[document] if not (without_sheet and name in _OF_LANDS))
    wanted = list(sections)
    known = PDF_SECTIONS if document == "all" else (*DOCUMENTS[document], *(_BY_NAME if document == "annex" else ()))
    for name in wanted:
        if name not in known:
            raise unknown(Sentence("no such section"), name, known)
    if "road_test" in wanted and document == "all":  # asked for by its name it is printed whole
        wanted.append("road_log")
    return tuple(name for name in PDF_SECTIONS if name in wanted)


def _catalogue_source(source: str, say: Wording) -> str | dict[str, str]:
    """Return a source in the reader's language, or marked as one of the catalogue's own where it has no other words.

    The study, which the section on the method cites in full, is [1].
    """
    named = say.name(source)
    cited = named.replace(_STUDY, "[1]")
    return passage(cited, CATALOGUE_LANGUAGE, say) if named == source else cited


class Body(PrintedPart):
    """The sections of one report.

    ``series`` is the thinned road test; ``pictures`` holds the printable pictures by their names in the job.
    """

    def __init__(self, names: PrintedNames, series: RoadSeries | None, pictures: Mapping[str, str]) -> None:
        super().__init__(names)
        self.series, self.pictures = series, pictures

    def parts(self, wanted: Sequence[str], document: str) -> list[dict[str, Any]]:
        """Return workshop report and annex, each with title and sections, as far as they have any of those wanted.

        The first has facts and verdict at its head, and stands there for these alone where no section is wanted.
        """
        sections, say = self._sections(wanted), self.say
        every = {"workshop": _WORKSHOP, "annex": (*_BY_NAME, *_ANNEX)}
        of_part = {part: names for part, names in every.items() if set(DOCUMENTS[part]) <= set(DOCUMENTS[document])}
        parts = [
            {"title": say(f"documents.{part}"), "sections": [each for each in sections if each["name"] in names]}
            for part, names in of_part.items()
        ]
        return [part for part in parts if part["sections"]] or parts[:1]

    def _sections(self, wanted: Sequence[str]) -> list[dict[str, Any]]:
        """Return title and blocks of every section that has any content."""
        names = self.names
        conditions, annex, road = Conditions(names), Annex(names), RoadTestSection(names, self.series)
        elsewhere: dict[str, Callable[[], Iterable[Block]]] = {
            "matrix": conditions.matrix,
            "all": annex.lands,
            "pressures": Pressures(names).blocks,
            "repair_order": conditions.repair_order,
            "gauges": partial(gauge_blocks, self.diagnosis, self.say),
            "before_opening": partial(before_opening_blocks, self.diagnosis, self.say),
            "road_test": road.blocks,
            "road_log": road.in_full,
            "estimate": partial(estimate_blocks, names),
            "repair": partial(self._repair, listed="estimate" not in wanted or names.estimate is None),
            "decisions": annex.decisions,
            "readings": annex.readings,
            "budget": Budget(names).blocks,
            "signatures": tuple,  # stand at the foot of the first page
        }
        filled = []
        for name in wanted:
            build = elsewhere.get(name) or getattr(self, f"_{name}")
            if blocks := [_dense(each, name) for each in with_notes(build())]:
                filled.append({"name": name, "title": self.say(f"sections.{name}"), "blocks": blocks})
        return filled

    def _picture(self) -> Iterable[Block]:
        say, diagnosis = self.say, self.diagnosis
        flagged = joined(self.names.land_name(land) for land in diagnosis.flagged)
        said = say("charts.picture_flagged", lands=flagged) if flagged else say("charts.picture_none")
        valves = {land.component for land in diagnosis.controller.lands}
        columns, letters = picture_look(len(valves))
        verdicts = {land.key: land.verdict for land in diagnosis.lands}
        casting = sound_casting(diagnosis.controller.id)
        drawings = [] if casting is None else [casting_drawing(casting, diagnosis, say).svg]
        unmarked = valves.difference(() if casting is None else casting.marks)
        if unmarked:
            drawn = controller_svg(
                diagnosis.controller, verdicts, columns=columns, letters=letters, named=say.name,
                only=unmarked if casting else (), note=say("casting.schematic"),
            )  # fmt: skip
            drawings.append(drawn)
        counts = Counter(verdicts.values())
        open_ = [land.state for land in diagnosis.lands if land.verdict is Verdict.NOT_MEASURED]
        beside = {
            "half_measured": sum(state.measured and state.land.seal is None for state in open_),
            "sealed": sum(state.land.seal is not None for state in open_),
        }
        counts[Verdict.NOT_MEASURED] -= sum(beside.values())
        legend = [
            [verdict, f"{say.level(verdict)}: {counts[verdict]}"] for verdict in reversed(VERDICTS) if counts[verdict]
        ]
        legend += [[Verdict.NOT_MEASURED, say(f"charts.{key}", count=count)] for key, count in beside.items() if count]
        alt = say("charts.picture_alt", components=len(valves), flagged=said)
        *before, last = drawings
        yield from (picture(drawn, say("casting.alt"), "") for drawn in before)
        about = "charts.caption_picture" if unmarked else "casting.caption"
        caption = say(about)
        yield {**picture(last, alt, caption), "legend": legend}

    def _flagged(self) -> Iterable[Block]:
        say, flagged = self.say, self.diagnosis.flagged
        if not flagged:
            yield text(say("texts.none_flagged"))
            return
        table = self.names.lands.without(*_ELSEWHERE, "land", "share", "decided_by")
        columns = (replace(each, width=_WIDTHS.get(each.key, each.width)) for each in table.columns)
        table = replace(table, columns=tuple(columns), rows=flagged)
        (consequence,) = table.only("consequence").columns

        def remark(land: LandDiagnosis) -> str:
            return f"{consequence.text(land, say)}; {self.names.reason(land)}"

        when: dict[str, list[str]] = {}
        if len(flagged) <= FEW:
            yield printed(replace(table.without("consequence"), remark=remark).filled)
        else:  # all else stands in the annex's table of all lands
            shown = table.without("verdict", "mounting", "consequence", "decision").filled
            yield abreast(replace(shown, group=lambda land: say.signed(land.verdict)))
            for land in flagged:
                when.setdefault(consequence.text(land, say), []).append(self.names.land_number(land))
        words = (f"{said}: {', '.join(lands)}" if len(when) > 1 else said for said, lands in when.items())
        consequences = [f"{consequence.title(say)}: {'; '.join(words)}."] if when else []
        decided = ("decision",) if any(land.decision for land in flagged) else ()
        radial = ["radial"] if say.units == "us" else []  # its readers have diametral ones from their manuals
        notes = [*radial, "both_rules", *decided, *(["uncertainty"] if self.diagnosis.uncertainty else [])]
        origins = dict.fromkeys(say.get("origins", land.deciding.origin) for land in flagged if land.deciding)
        sources = say("findings.limits_from", source=joined(origins))
        yield text(" ".join([*consequences, sources, *(say(f"texts.{note}") for note in notes)]), small=True)

    def _again(self) -> Iterable[Block]:
        """Name what to measure again where the readings leave open on which side of a limit a land lies."""
        say, names = self.say, self.names
        yield bullets(names.advice_by_group(land for land in self.diagnosis.flagged if land.decision in _CONDITIONAL))
        within = [land for land in self.diagnosis.lands if land.verdict == Verdict.OK and land.decision in _CONDITIONAL]
        kinds = ["suspect" if land.suspect else land.shown_as for land in within]
        for kind, key in (("within_range", "within_range"), ("conditional_pass", "unsure"), ("suspect", "suspect")):
            lands = [names.land_number(land) for land, each in zip(within, kinds, strict=True) if each == kind]
            if lands:
                yield text(say(f"texts.{key}", lands=joined(lands)))

    def _shares(self) -> Iterable[Block]:
        say, names, at = self.say, self.names, self.diagnosis.projection
        if at.leakage <= 0.0 or at.pump_capacity <= 0.0:
            return
        top, condition = self.diagnosis.drawing_most[:_BARS], names.say.condition(at.condition)
        lands = joined(f"{names.land_name(land)} {say.percent(land.share, 2)}" for land in top)
        drawn = printed_chart(self._share_chart(top, say("charts.share_of_pump", condition=condition)), say)
        yield picture(drawn, say("charts.shares_alt", lands=lands), say("charts.caption_shares", condition=condition))

    def _share_chart(self, lands: Sequence[LandDiagnosis], axis: str) -> RowChart:
        """Return the lands that leak most as bars with their intervals, each in the shade of its verdict."""
        say = self.say
        intervals = [land.uncertainty.share_interval if land.uncertainty else None for land in lands]
        spans = [tuple(end * PERCENT for end in each) if each and isfinite(each[0]) else None for each in intervals]
        ends = [end for land, span in zip(lands, spans, strict=True) for end in (land.share * PERCENT, *(span or ()))]
        right = max(filter(isfinite, ends), default=1.0)  # the interval of a pump that may deliver nothing has no end
        said = [
            say.number(land.share * PERCENT, 2)
            + ("" if span is None else f" ({say.number(span[0], 2)}–{say.number(span[1], 2)})")
            for land, span in zip(lands, spans, strict=True)
        ]
        shown = [span and (span[0], min(span[1], right)) for span in spans]

        def bar(verdict: Verdict) -> LayerOf:
            values = [land.share * PERCENT if land.verdict is verdict else None for land in lands]
            return say.level(verdict), look_of(verdict), values, {"spans": shown, "thick": 0.68}

        layers = layers_of(map(bar, VERDICTS))
        return RowChart([shortened(self.names.land_name(land), _LABEL) for land in lands], layers, axis, said)

    def _repair(self, *, listed: bool) -> Iterable[Block]:
        """Yield what was decided, where the estimate does not list it, and what is open."""
        say, controller = self.say, self.diagnosis.controller

        def pair(each: RepairDecision) -> str:
            land = f"{say('printed.land')}\u00a0{each.land}" if each.land else ""
            return joined((components_words(controller, components_of(each, controller), say), land))

        columns = (
            Column("pair", width=200, of=pair),
            Column("work", width=250),
            Column("decision", of=lambda each: each.decision and say.get("job_decisions", each.decision)),
            Column("reason", width=300),
            Column("date", of=lambda each: each.date and say.date(each.date)),
        )
        decisions = [each for each in self.job.repair_decisions if listed and not each.empty]
        yield printed(Table("", columns, decisions, say).filled)
        for sentence in open_words(self.diagnosis, self.job, say, closing=True):
            yield text(sentence)

    def _condition(self) -> Iterable[Block]:
        say, oil, dirt = self.say, self.job.fluid_condition, self.job.contamination
        changed = oil.changed_at_km
        remarks = [
            oil.product,
            "" if changed is None else say("facts.changed_at", mileage=say.value(changed, "distance", 0)),
            *(
                f"{say(f'facts.{name}')}: {said}"
                for name in ("level", "colour", "smell")
                if (said := getattr(oil, name))
            ),
            oil.note,
        ]
        grade = say.get("grades", dirt.grade) if dirt.grade else ""
        contamination = joined((grade, dirt.particles, dirt.note), "; ")
        yield named_facts("facts", say, fluid_found=joined(remarks, "; "), contamination=contamination)

        def scratched(each: Scratch) -> str:
            part = next((words for name, words in PART_WORDS.items() if name == each.part), each.part)
            return joined((each.component, say.sentence(part)), " ")

        yield listed(
            say,
            [each for each in self.job.scratches if not each.empty],
            Column("component", width=150, of=scratched),
            Column("land", width=50, of=lambda each: str(each.land or "")),
            Column("facts.scratches", width=300, of="description"),
        )

    def _photos(self) -> Iterable[Block]:
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

    def _notes(self) -> Iterable[Block]:
        return (text(part) for part in self.job.notes.splitlines() if part.strip())

    def _conditions(self) -> Iterable[Block]:
        say, diagnosis = self.say, self.diagnosis
        fluid, profile, uncertainty = diagnosis.fluid, diagnosis.profile, diagnosis.uncertainty
        viscosities = [
            say(
                "facts.viscosity_at",
                nu=say.value(fluid.kinematic_viscosity(at, profile.viscosity) * MM2_S, "viscosity", 2),
                rho=say.value(fluid.density(at, profile.viscosity) * G_CM3, "density", 4),
                temperature=say.plain_value(at, "temperature"),
            )
            for at in (each.condition.temperature for each in diagnosis.reported)
        ]
        instruments = [
            joined(
                (
                    joined((each.name, each.serial), " "),
                    say("facts.calibrated", date=say.date(each.calibrated)) if each.calibrated else "",
                    each.note,
                )
            )
            for each in self.job.instruments
            if not each.empty
        ]
        taken = (
            ""
            if uncertainty is None
            else say(
                "facts.taken",
                spool=say.name(uncertainty.instruments.spool.name),
                sleeve=say.name(uncertainty.instruments.sleeve.name),
                coverage=say.percent(uncertainty.coverage, 0),
                guard=say.plain(uncertainty.guard_factor),
            )
        )
        yield named_facts(
            "facts",
            say,
            controller=say.name(diagnosis.controller.name),
            fluid=fluid_in_state(diagnosis, say),
            viscosity=joined(viscosities, "; "),
            profile=profile_words(profile, say),
            options=joined(option_words(profile.options, say), "; "),
            measured=f"{diagnosis.measured} / {len(diagnosis.lands)}",
            measuring_temperature=measuring_temperature(diagnosis, say),
            instruments=joined(instruments, "; "),
            uncertainty=taken,
        )

    def _limits(self) -> Iterable[Block]:
        say, limits = self.say, self.diagnosis.limits

        def source(steps: Steps) -> str | dict[str, str]:  # what the workshop set, it says in its own words
            own = steps.origin is LimitOrigin.WORKSHOP
            return steps.source if own else _catalogue_source(steps.source, say)

        yield listed(
            say,
            limits.rules.items(),
            Column("rule", width=200, of=lambda rule: say(f"rules.{rule[0]}")),
            Column("limit", width=350, of=lambda rule: self._levels(*rule)),
            Column("origin", width=150, of=lambda rule: say.get("origins", rule[1].origin)),
            Column("source", width=700, of=lambda rule: source(rule[1])),
        )
        yield text(f"{isolated(say.name(limits.name))}. {say('texts.limit_note')}", small=True)

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

    def _assumptions(self) -> Iterable[Block]:
        say, table = self.say, assumed_table(self.diagnosis, self.say)
        what, changes, low, high, value, off, file = table.columns

        def named(*columns: Column) -> Callable[[Any], str]:
            return lambda each: f"{changes.title(say)}: {joined((column.text(each, say) for column in columns), ' · ')}"

        telling = [each for each in table.rows if each.changes in ("verdict", "decision")]
        kinds = [each.changes for each in table.rows]
        others = sorted(table.rows[len(telling) :], key=lambda each: (kinds.index(each.changes), each.stands_in))
        yield text(assumed_line(self.diagnosis, say), leads=True)
        yield printed(replace(table, columns=(what, low, high, value, off, file), rows=telling, group=named(changes)))
        yield abreast(
            replace(table, columns=(replace(what, width=250), value, off), rows=others, group=named(changes, file))
        )
        yield text(say("assumed.how"), small=True)
        yield bullets(self._taken())

    def _taken(self) -> Iterator[str]:
        """Say what was taken for what nobody measured or said."""
        say, diagnosis = self.say, self.diagnosis
        for status, key in (("spool_only", "assumed_sleeve"), ("sleeve_only", "assumed_spool"), ("not_measured",) * 2):
            unmeasured = [self.names.land_number(land) for land in diagnosis.lands if land.state.status == status]
            if unmeasured:
                yield say(f"texts.{key}", lands=joined(unmeasured))
        efficiency = say("texts.efficiency", value=say.plain(diagnosis.controller.pump.volumetric_efficiency))
        yield say("texts.slip") if diagnosis.model.uses_slip else efficiency

    def _messages(self) -> Iterable[Block]:
        say = self.say
        messages = (*record_doubts(self.job, self.diagnosis), *self.diagnosis.messages)
        said = (each for each in messages if each.level in ("warning", "info"))
        yield bullets(
            f"{say.sentence(each.text)} ({say.sentence(each.place.sentence)})"
            if each.place
            else say.sentence(each.text)
            for each in sorted(said, key=lambda each: each.level != "warning")
        )

    def _method(self) -> Iterable[Block]:
        say, profile, diagnosis = self.say, self.diagnosis.profile, self.diagnosis
        said = ["", f"_{profile.diameter}", f"_{profile.viscosity}", f"_{profile.pump_draw}"]
        said += ["_form"] if profile.form == "mean_of_cubes" else []
        said += ["_entry_loss"] if profile.entry_loss != "off" else []
        if profile.eccentricity:
            said.append("_eccentricity_unknown" if profile.eccentricity == UNKNOWN else "_eccentricity")
        eccentric = "" if isinstance(profile.eccentricity, str) else say.plain(profile.eccentricity)
        yield text(" ".join(say(f"texts.method{name}", value=eccentric) for name in (*said, "_limits")))
        study = say("texts.source_study")
        sources = dict.fromkeys((diagnosis.controller.source, diagnosis.fluid.source, diagnosis.limits.source))
        others = (each for each in sources if each not in ("", study, f"{_STUDY}, doi 10.3390/en16227667"))
        yield bullets([f"[1] {study}", *(_catalogue_source(each, say) for each in others)])

    def _provenance(self) -> Iterable[Block]:
        say, job, profile = self.say, self.job, profile_words(self.diagnosis.profile, self.say)
        yield named_facts(
            "annex",
            say,
            report_number=job.number,
            revision=job.revision,
            replaces=job.replaces,
            issued_on=say.date(job.issued_on) if job.issued_on else "",
            approved_by=job.approved_by,
        )
        yield text(say("annex.whole"), small=True)
        yield text(say("texts.made_with", version=__version__, profile=profile, language=say("language.name")))
        diagnosis, record = self.diagnosis, head_record(self.diagnosis)
        files: dict[str, dict[str, Any]] = {"readings": record["readings"]}
        if diagnosis.log is not None:
            files["road_test"] = named_record(diagnosis.log.road_test, "file", "sha256")
        if diagnosis.pressures is not None:
            files["pressure_table"] = named_record(diagnosis.pressures.table, "file", "sha256")
        files |= {name: record[name] for name in ("controller", "fluid", "limits")}
        yield listed(
            say,
            [(name, file) for name, file in files.items() if file.get("sha256")],
            Column("", words="", width=100, of=lambda each: say(f"facts.{each[0]}")),
            Column("file", width=150, of=lambda each: each[1].get("file") or each[1].get("id")),
            Column("", words="SHA-256", width=500, of=lambda each: each[1]["sha256"]),
        )


def _dense(block: Block, section: str) -> Block:
    """Return a block of a section with its letters small if it is one of the annex or a table of many rows."""
    return {**block, "dense": section in _ANNEX or len(block.get("rows", ())) > _MANY}


def picture_look(valves: int) -> tuple[int, float]:
    """Return how many of so many valves are drawn beside one another, and how large their names: all are legible."""
    return (6, 1.4) if valves <= 18 else (8, 1.35)


_CONDITIONAL = ("conditional_pass", "conditional_fail")
_LABEL = 48  # characters that fit beside a bar


def _begins(steps: Steps, level: Level) -> str:
    """Return the key of the words for where a level begins: from, over or under its limit."""
    if steps.falling:
        return "level_under"
    return "level_over" if steps.limit_of(level) == 0.0 and steps.has_limit(level) else "level"
