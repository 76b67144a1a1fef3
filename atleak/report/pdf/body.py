"""The sections of a printed report, as blocks of ready text: the template only places them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from atleak.catalogue.controller import REFERENCE_TEMPERATURE
from atleak.catalogue.limits import LimitOrigin
from atleak.errors import unknown
from atleak.report.pdf.blocks import Block, facts, joined, table, text
from atleak.report.pdf.printed_names import PrintedNames
from atleak.verdicts import VERDICTS, Verdict
from atleak.version import __version__
from atleak.views.road_series import RoadSeries
from atleak.wording import isolated
from atleak.workshop_units import G_CM3, MM, MM2_S, PERCENT, UM

SECTIONS = (
    "picture",
    "flagged",
    "repair_order",
    "all",
    "shares",
    "again",
    "road_test",
    "repair",
    "condition",
    "photos",
    "notes",
    "conditions",
    "limits",
    "assumptions",
    "messages",
    "method",
    "provenance",
    "signatures",
)
BARS = 16  # of the chart of shares


def chosen_sections(sections: Iterable[str] | None) -> tuple[str, ...]:
    """The sections asked for, in the report's order; all of them unless chosen.

    Raises
    ------
    InputError
        a section that no report has.
    """
    if sections is None:
        return SECTIONS
    wanted = list(sections)
    for name in wanted:
        if name not in SECTIONS:
            raise unknown("no such section", name, SECTIONS)
    return tuple(name for name in SECTIONS if name in wanted)


class Body:
    """The sections of one report.

    ``series`` is the thinned road test, ``pictures`` the printable pictures by the job's names.
    """

    def __init__(self, names: PrintedNames, series: RoadSeries | None, pictures: dict[str, str]) -> None:
        self.names, self.series, self.pictures = names, series, pictures
        self.diagnosis, self.record, self.job, self.say = names.diagnosis, names.record, names.job, names.say

    # --- sections

    def sections(self, names: Iterable[str], charts: dict[str, str]) -> list[dict[str, Any]]:
        """Title and blocks of every section that has something to say."""
        found = []
        for name in names:
            build: Callable[[dict[str, str]], Iterable[Block]] = getattr(self, f"_{name}")
            blocks = [block for block in build(charts) if block]
            if blocks:
                found.append({"name": name, "title": self.say(f"sections.{name}"), "blocks": blocks})
        return found

    def _picture(self, charts: dict[str, str]) -> Iterable[Block]:
        say, diagnosis = self.say, self.diagnosis
        flagged = joined(self.names.land_name(found) for found in diagnosis.flagged)
        said = say("charts.picture_flagged", lands=flagged) if flagged else say("charts.picture_none")
        components = len({found.state.land.component for found in diagnosis.lands})
        counts = {verdict: sum(found.verdict == verdict for found in diagnosis.lands) for verdict in VERDICTS}
        legend = [
            [verdict, f"{say.level(verdict)}: {counts[verdict]}"] for verdict in reversed(VERDICTS) if counts[verdict]
        ]
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
        idle = names.idle
        decided = any(found.decision for found in flagged)
        columns = {
            "pair": "",
            "land": "",
            "verdict": "",
            "clearance": "µm",
            "mounting": "µm",
            "wear": "%",
            "share": "%",
        }
        columns |= {"share_hot_idle": "%"} if idle else {}
        columns |= {"decision": ""} if decided else {}
        columns |= {"reason": ""}
        rows = []
        for found in flagged:
            state = found.state
            cells: list[Any] = [
                names.pair(found),
                str(state.land.land),
                {"sign": found.verdict, "text": say.level(found.verdict)},
                names.clearance(found),
                say.number(state.land.mounting_clearance * UM, 1),
                say.number(None if found.wear is None else found.wear * PERCENT, 0),
                say.number(found.share * PERCENT, 2),
            ]
            if idle is not None:
                cells.append(say.number(idle.share_of(idle.leakage_of(found.key)) * PERCENT, 2))
            if decided:
                cells.append(names.decision(found))
            rows.append([*cells, names.reason(found)])
        widths = "4000000" + "0" * (idle is not None) + "3" * decided + "7"
        aligned = "lcl" + "r" * (4 + (idle is not None)) + "l" * decided + "l"
        yield table(_with_units(names, columns), rows, widths, aligned)
        notes = [say("texts.both_rules")]
        notes += [say("texts.decision")] if decided else []
        notes += [say("texts.uncertainty")] if self.diagnosis.uncertainty else []
        yield text(" ".join(notes), small=True)

    def _repair_order(self, charts: dict[str, str]) -> Iterable[Block]:
        say, plan = self.say, self.diagnosis.repair_plan
        if not plan:
            return
        yield text(say("texts.repair_order", condition=self.names.condition(plan[0].condition)))
        rows = []
        for number, step in enumerate(plan, start=1):
            at = step.land.replace_mileage
            rows.append(
                [
                    str(number),
                    self.names.land_name(step.land),
                    {"sign": step.land.verdict, "text": say.level(step.land.verdict)},
                    say.percent(step.share_before),
                    say.percent(step.share_after),
                    say("texts.mileage", value=say.number(at, 0)) if _worth_saying(at) else "–",
                ]
            )
        titles = ["", *(say(f"columns.{name}") for name in ("pair", "verdict", "before", "after", "replace_at"))]
        yield table(titles, rows, "050222", "rllrrr", empty=False)
        if any(_worth_saying(step.land.replace_mileage) for step in plan):
            yield text(f"{say('columns.replace_at')}: {say('texts.replace_at')}.", small=True)

    def _again(self, charts: dict[str, str]) -> Iterable[Block]:
        """What to measure again where the readings cannot tell which side of a limit a land is on."""
        say, names = self.say, self.names
        items = [
            f"{names.land_name(found)}: {names.advice(found)}"
            for found in self.diagnosis.flagged
            if found.decision in _CONDITIONAL
        ]
        if items:
            yield {"kind": "list", "items": items}
        unsure = [
            found for found in self.diagnosis.lands if found.verdict == Verdict.OK and found.decision in _CONDITIONAL
        ]
        if unsure:
            yield text(say("texts.unsure", lands=joined(names.land_number(found) for found in unsure)))

    def _all(self, charts: dict[str, str]) -> Iterable[Block]:
        say, names = self.say, self.names
        columns = {
            "pair": "",
            "land": "",
            "sleeve": "mm",
            "spool": "mm",
            "clearance": "µm",
            "mounting": "µm",
            "wear": "%",
            "effective": "µm",
            "leakage": "dm³/min",
            "share": "%",
            "verdict": "",
        }
        rows = []
        for found in self.diagnosis.lands:
            state, row = found.state, names.rows[found.key]
            interval = names.interval(row["leakage_low_dm3_min"], row["leakage_high_dm3_min"], 3)
            rows.append(
                [
                    names.pair(found),
                    str(state.land.land),
                    say.number(state.sleeve_diameter * MM, 4),
                    say.number(state.spool_diameter * MM, 4),
                    names.clearance(found),
                    say.number(state.land.mounting_clearance * UM, 1),
                    say.number(None if found.wear is None else found.wear * PERCENT, 0),
                    say.number(found.effective_clearance * UM, 1),
                    names.flow(found.leakage, 3) + interval * (found.leakage > 0.0),
                    say.number(found.share * PERCENT, 2),
                    {"sign": found.verdict, "text": say.level(found.verdict)},
                ]
            )
        yield table(_with_units(names, columns), rows, "10000000000", "lcrrrrrrrrl")
        at = self.names.condition(self.diagnosis.projection.condition)
        yield text(say("texts.all_at", condition=at), small=True)

    def _shares(self, charts: dict[str, str]) -> Iterable[Block]:
        if "shares" not in charts:
            return
        say, at = self.say, self.diagnosis.projection
        top = self.diagnosis.ranked[:BARS]
        lands = joined(f"{self.names.land_name(found)} {say.percent(found.share, 2)}" for found in top)
        yield {
            "kind": "image",
            "file": charts["shares"],
            "alt": say("charts.shares_alt", lands=lands),
            "caption": say("charts.caption_shares", condition=self.names.condition(at.condition)),
        }

    def _road_test(self, charts: dict[str, str]) -> Iterable[Block]:
        road, say = self.diagnosis.road, self.say
        if road is None or self.series is None:
            return
        test = road.road_test
        shares = joined(
            f"{say(f'pressures.{name}')} {say.percent(share, 0)}"
            for name, share in road.section_shares.items()
            if share is not None
        )
        yield facts(
            [
                [say("facts.road_test"), test.file],
                [say("facts.duration"), f"{say.number(test.duration, 1)} s"],
                [say("facts.samples"), say.number(test.rows, 0)],
                [say("facts.gears"), joined(map(str, road.gears))],
                [say("facts.sections"), shares],
            ]
        )
        numbered = list(enumerate(self.series.instants.items(), start=1))
        spoken = " ".join(
            say(
                "charts.instant_alt",
                instant=say(f"instants.{name}"),
                share=say.percent(found.share)
                if found.share is not None
                else f"{self.names.flow(found.leakage)} dm³/min",
                time=say.number(found.time, 1),
            )
            for _, (name, found) in numbered
        )
        thinned = ""
        if self.series.thinned:
            kept = say.number(len(self.series.columns["time_s"]), 0)
            thinned = say("charts.caption_thinned", kept=kept, samples=say.number(self.series.samples, 0))
        listed = joined(f"{number} {say(f'instants.{name}')}" for number, (name, _) in numbered)
        known = "charts.road_alt" if road.share is not None else "charts.road_alt_no_share"
        yield {
            "kind": "image",
            "file": charts["road"],
            "alt": say(known, instants=spoken),
            "caption": say("charts.caption_road", instants=listed, thinned=thinned).strip(),
        }
        rows = [
            [
                str(number),
                say(f"instants.{name}"),
                f"{say.number(found.time, 1)} s",
                f"{self.names.flow(found.leakage)} dm³/min",
                "–" if found.pump_capacity is None else f"{self.names.flow(found.pump_capacity)} dm³/min",
                "–" if found.share is None else say.percent(found.share),
            ]
            for number, (name, found) in numbered
        ]
        names = ["", *(say(f"columns.{name}") for name in ("instant", "time", "leakage", "capacity", "share"))]
        yield table(names, rows, "042222", "rlrrrr")

    def _repair(self, charts: dict[str, str]) -> Iterable[Block]:
        say, decisions = self.say, [each for each in self.job.repair_decisions if not each.empty]
        if not decisions:
            return
        rows = []
        for each in decisions:
            name = self.diagnosis.controller.components.get(each.component, "")
            land = f"{say('columns.land')}\u00a0{each.land}" if each.land else ""
            decision = say.get("job_decisions", each.decision) if each.decision else "–"
            date = say.date(each.date) if each.date else ""
            pair = joined((f"{each.component}  {isolated(name)}".strip(), land))
            rows.append([pair, each.work, decision, each.reason, date])
        names = ("pair", "work", "decision", "reason", "date")
        yield table([say(f"columns.{name}") for name in names], rows, "45262", "lllll", empty=False)

    def _condition(self, charts: dict[str, str]) -> Iterable[Block]:
        say, job = self.say, self.job
        oil, dirt = job.fluid_condition, job.contamination
        found = [
            oil.product,
            say("facts.changed_at", mileage=say.number(oil.changed_at_km, 0)) if oil.changed_at_km is not None else "",
            f"{say('facts.level')}: {oil.level}" if oil.level else "",
            f"{say('facts.colour')}: {oil.colour}" if oil.colour else "",
            f"{say('facts.smell')}: {oil.smell}" if oil.smell else "",
            oil.note,
        ]
        grade = say.get("grades", dirt.grade) if dirt.grade else ""
        rows = [
            [say("facts.fluid_found"), joined(found, "; ")],
            [say("facts.contamination"), joined((grade, dirt.particles, dirt.note), "; ")],
        ]
        yield facts([row for row in rows if row[1]])
        scratches = [each for each in job.scratches if not each.empty]
        if scratches:
            names = [say("columns.component"), say("columns.land"), say("facts.scratches")]
            rows = [
                [
                    joined((each.component, each.part), " "),
                    str(each.land or ""),
                    each.description,
                ]
                for each in scratches
            ]
            yield table(names, rows, "316", "lll")

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
                nu=say.number(fluid.kinematic_viscosity(found.condition.temperature, model) * MM2_S, 2),
                rho=say.number(fluid.density(found.condition.temperature, model) * G_CM3, 4),
                temperature=say.plain(found.condition.temperature),
            )
            for found in diagnosis.reported
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
        temperature = f"{say.plain(REFERENCE_TEMPERATURE)} °C"
        if job.measuring_temperature_c is not None:
            temperature = say("facts.not_corrected", temperature=say.plain(job.measuring_temperature_c))
        options = joined(f"{name} = {_option(value)}" for name, value in diagnosis.profile.options.items())
        sure = diagnosis.uncertainty
        taken = (
            say(
                "facts.taken",
                spool=sure.instruments.spool.name,
                sleeve=sure.instruments.sleeve.name,
                coverage=say.percent(sure.coverage, 0),
                guard=say.plain(sure.guard_factor),
            )
            if sure
            else ""
        )
        yield facts(
            [
                [say("facts.controller"), diagnosis.controller.name],
                [say("facts.fluid"), fluid.name],
                [say("facts.viscosity"), joined(viscosities, "; ")],
                [say("facts.profile"), diagnosis.profile.label],
                [say("facts.options"), options],
                [say("facts.measured"), measured],
                [say("facts.measuring_temperature"), temperature],
                *([[say("facts.instruments"), joined(instruments, "; ")]] if instruments else []),
                *([[say("facts.uncertainty"), taken]] if taken else []),
            ]
        )

    def _limits(self, charts: dict[str, str]) -> Iterable[Block]:
        say, limits = self.say, self.diagnosis.limits
        rows = []
        for name, steps in limits.rules.items():
            levels = joined(
                say("rules.level", level=say.level(level), limit=f"{say.plain(limit * name.factor)}\u00a0{name.unit}")
                for level, limit in steps.levels
            )
            rows.append([say(f"rules.{name}"), levels, say.get("origins", steps.origin), steps.source])
        yield table([say(f"columns.{name}") for name in ("rule", "limit", "origin", "source")], rows, "3426", "llll")
        yield text(f"{isolated(limits.name)}. {say('texts.limit_note')}", small=True)

    def _assumptions(self, charts: dict[str, str]) -> Iterable[Block]:
        say, diagnosis = self.say, self.diagnosis
        items = [diagnosis.controller.representative] if diagnosis.controller.representative else []
        by_values: dict[tuple[str, ...], list[str]] = {}
        for found in diagnosis.lands:
            if found.state.land.representative:
                by_values.setdefault(found.state.land.representative, []).append(self.names.land_number(found))
        for values, lands in by_values.items():
            named = joined(say.get("parts", value) for value in values)
            said = say("texts.representative_land", values=named, lands=joined(lands))
            items.append(say("texts.representative_lands", values=said))
        if diagnosis.controller.pump.representative:
            values = joined(diagnosis.controller.pump.representative)
            items.append(say("texts.representative_lands", values=values))
        if diagnosis.fluid.representative:
            values = joined(diagnosis.fluid.representative)
            items.append(f"{isolated(diagnosis.fluid.name)}: {say('facts.representative')}: {values}.")
        for status, key in (("spool_only", "assumed_sleeve"), ("sleeve_only", "assumed_spool"), ("not_measured",) * 2):
            lands = [self.names.land_number(found) for found in diagnosis.lands if found.state.status == status]
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
        if self.diagnosis.messages and self.say("texts.messages_language"):
            yield text(self.say("texts.messages_language"), small=True)
        items = [
            f"{message.text} ({message.place})" if message.place and str(message.place) else message.text
            for level in ("warning", "info")
            for message in self.diagnosis.messages
            if message.level == level and message.code not in _SAID_ELSEWHERE
        ]
        if items:
            yield {"kind": "list", "items": items, "lang": "en"}

    def _method(self, charts: dict[str, str]) -> Iterable[Block]:
        say, profile, diagnosis = self.say, self.diagnosis.profile, self.diagnosis
        names = [f"method_{profile.diameter}", f"method_{profile.viscosity}", f"method_{profile.pump_draw}"]
        said = [say("texts.method"), *(say(f"texts.{name}") for name in names)]
        if profile.entry_loss:
            said.append(say("texts.method_entry_loss"))
        if profile.eccentricity:
            said.append(say("texts.method_eccentricity", value=say.plain(profile.eccentricity)))
        yield text(" ".join((*said, say("texts.method_limits"))))
        sources = [
            say("texts.source_study"),
            diagnosis.controller.source,
            diagnosis.fluid.source,
            diagnosis.limits.source,
        ]
        yield {"kind": "list", "items": list(dict.fromkeys(source for source in sources if source))}

    def _provenance(self, charts: dict[str, str]) -> Iterable[Block]:
        say, record = self.say, self.record
        profile = self.diagnosis.profile.label
        yield text(say("texts.made_with", version=__version__, profile=profile, language=say.texts["language"]))
        rows = []
        for name in ("readings", "road_test", "controller", "fluid", "limits"):
            found = record[name]
            if found and found.get("sha256"):
                rows.append([say(f"facts.{name}"), found.get("file") or found.get("id"), found["sha256"]])
        yield table(["", say("columns.file"), "SHA-256"], rows, "238", "lll")

    def _signatures(self, charts: dict[str, str]) -> Iterable[Block]:
        say = self.say
        yield {
            "kind": "signatures",
            "line": say("texts.sign_place"),
            "people": [
                [say("texts.sign_technician"), self.job.technician],
                [say("texts.sign_customer"), self.job.customer.name],
            ],
        }


_SAID_ELSEWHERE = ("controller_representative",)  # among the representative values
_CONDITIONAL = ("conditional_pass", "conditional_fail")


def _worth_saying(mileage: float | None) -> bool:
    return mileage is not None and mileage < 1e7


def _with_units(names: PrintedNames, columns: dict[str, str]) -> list[str]:
    return [f"{names.column(name)}\n{unit}" if unit else names.column(name) for name, unit in columns.items()]


def _option(value: Any) -> str:
    return {True: "on", False: "off"}[value] if isinstance(value, bool) else str(value)
