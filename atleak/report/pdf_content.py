"""What a printed report says, as blocks of ready text: the template only places them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from atleak import __version__
from atleak.controller import REFERENCE_TEMPERATURE, OperatingPoint
from atleak.diagnosis import Diagnosis, LandDiagnosis, RuleResult
from atleak.errors import InputError, nearest_name
from atleak.job import Job
from atleak.limits import VERDICTS
from atleak.projection import Projection
from atleak.report.record import DM3_MIN, KPA, MM, PERCENT, RPM, UM
from atleak.report.road_series import RoadSeries
from atleak.report.wording import Wording

Block = dict[str, Any]

SECTIONS = (
    "picture",
    "flagged",
    "repair_order",
    "all",
    "shares",
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
FLAGGED = ("watch", "replace", "critical")
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
            raise InputError(
                "no such section",
                value=name,
                expected=f"one of {', '.join(SECTIONS)}",
                nearest=nearest_name(name, SECTIONS),
            )
    return tuple(name for name in SECTIONS if name in wanted)


class Content:
    """The blocks of one report.

    ``pictures`` holds the names of the job's pictures that can be printed.
    """

    def __init__(
        self,
        diagnosis: Diagnosis,
        record: dict[str, Any],
        job: Job,
        say: Wording,
        series: RoadSeries | None,
        pictures: dict[str, str],
    ) -> None:
        self.diagnosis, self.record, self.job, self.say = diagnosis, record, job, say
        self.series, self.pictures = series, pictures
        self.rows = {(row["component"], row["land"]): row for row in record["lands"]}

    # --- front matter

    def head(self) -> dict[str, Any]:
        """Letterhead."""
        shop, say = self.job.workshop, self.say
        lines = [
            *shop.address.splitlines(),
            f"{say('facts.phone')} {shop.phone}" if shop.phone else "",
            shop.email,
            shop.website,
            f"{say('facts.register')} {shop.registration}" if shop.registration else "",
        ]
        return {
            "workshop": shop.name,
            "lines": [line for line in lines if line],
            "logo": self.pictures.get(shop.logo or ""),
        }

    def facts(self) -> list[list[str]]:
        """Whose car and which box; nothing that was not filled in."""
        job, say = self.job, self.say
        customer, vehicle, box = job.customer, job.vehicle, job.transmission
        mileage = self.record["mileage_km"] if self.record["mileage_km"] is not None else vehicle.mileage_km
        contact = [customer.name, customer.number, *customer.address.splitlines(), customer.phone, customer.email]
        rows = [
            ("number", job.number),
            ("date", say.date(job.date) if job.date else ""),
            ("customer", _joined(contact)),
            ("vehicle", _joined((vehicle.make, vehicle.model, vehicle.year), " ")),
            ("engine", vehicle.engine),
            ("registration", vehicle.registration),
            ("vin", vehicle.vin),
            ("mileage", "" if mileage is None else say("texts.mileage", value=say.number(mileage, 0))),
            ("transmission", _joined((box.maker, box.code), " ")),
            ("serial", box.serial),
            ("note", box.note),
            ("technician", job.technician),
            ("complaint", job.complaint),
            ("fault_codes", _joined(job.fault_codes)),
            ("controller", self.diagnosis.controller.name),
        ]
        return [[say(f"facts.{name}"), value] for name, value in rows if value]

    def verdict(self) -> dict[str, Any]:
        """The verdict in one sentence, and the totals under it."""
        diagnosis, say = self.diagnosis, self.say
        at = diagnosis.hot_idle or diagnosis.projection
        condition = self.condition(at.condition)
        if at.pump_capacity > 0.0:
            band = say.get("bands", diagnosis.band(at))
            total = say("sentences.total", condition=condition, share=say.percent(at.share), band=band)
        else:
            total = say("sentences.no_delivery", condition=condition)
        sentence = say(
            f"sentences.{diagnosis.verdict}",
            total=total,
            flagged=len(diagnosis.flagged),
            measured=diagnosis.measured,
        )
        more = [say("sentences.holds", speed=say.number(at.minimum_speed * RPM, 0))] if at.pump_capacity > 0.0 else []
        missing = len(diagnosis.lands) - diagnosis.measured
        if missing and diagnosis.measured:
            more.append(say("sentences.unmeasured", unmeasured=missing, lands=len(diagnosis.lands)))
        return {
            "key": diagnosis.verdict,
            "word": say.get("verdicts", diagnosis.verdict),
            "sentence": sentence,
            "more": " ".join(more),
            "totals": self._totals(),
        }

    def _totals(self) -> Block:
        say, diagnosis = self.say, self.diagnosis
        names = (
            "condition",
            "temperature",
            "speed",
            "gear",
            "pressure",
            "leakage",
            "capacity",
            "share",
            "band",
            "holds",
        )
        rows = []
        for found in _distinct(diagnosis.projections):
            at, band = found.condition, diagnosis.band(found)
            rows.append(
                [
                    self.condition(at),
                    f"{say.plain(at.temperature)} °C",
                    f"{say.number(at.engine_speed * RPM, 0)} 1/min",
                    str(at.gear),
                    f"{say.number(at.main_pressure * KPA, 0)} kPa",
                    f"{say.number(found.leakage * DM3_MIN, 2)} dm³/min",
                    f"{say.number(found.pump_capacity * DM3_MIN, 2)} dm³/min",
                    say.percent(found.share),
                    {"sign": _BAND_SIGNS[band], "text": say.get("bands", band)},
                    f"{say.number(found.minimum_speed * RPM, 0)} 1/min",
                ]
            )
        return table([say(f"columns.{name}") for name in names], rows, "2" + "1" * 9, "l" + "r" * 7 + "lr")

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
        flagged = _joined(self.land_name(found) for found in diagnosis.flagged)
        said = say("charts.picture_flagged", lands=flagged) if flagged else say("charts.picture_none")
        components = len({found.state.land.component for found in diagnosis.lands})
        counts = {verdict: sum(found.verdict == verdict for found in diagnosis.lands) for verdict in VERDICTS}
        legend = [
            [verdict, f"{say.get('verdicts', verdict)}: {counts[verdict]}"] for verdict in _LEGEND if counts[verdict]
        ]
        words = _joined(text for _, text in legend)
        yield {
            "kind": "image",
            "file": charts["picture"],
            "alt": say("charts.picture_alt", components=components, flagged=said),
            "caption": say("charts.caption_picture", counts=words),
            "legend": legend,
        }

    def _flagged(self, charts: dict[str, str]) -> Iterable[Block]:
        say, flagged = self.say, self.diagnosis.flagged
        if not flagged:
            yield text(say("texts.none_flagged"))
            return
        idle = self._idle()
        decided = any(self.rows[found.key]["decision"] for found in flagged)
        projected = any(_worth_saying(found.replace_mileage) for found in flagged)
        names = ["pair", "land", "verdict", "clearance", "mounting", "wear", "share"]
        names += ["share_hot_idle"] * (idle is not None) + ["decision"] * decided
        names += ["replace_at"] * projected + ["reason"]
        rows = []
        for found in flagged:
            state, row = found.state, self.rows[found.key]
            cells: list[Any] = [
                f"{state.land.component}  {self.diagnosis.controller.components[state.land.component]}",
                str(state.land.land),
                {"sign": found.verdict, "text": say.get("verdicts", found.verdict)},
                self._clearance(found),
                f"{say.number(state.land.mounting_clearance * UM, 1)} µm",
                say.percent(found.wear, 0),
                say.percent(found.share, 2),
            ]
            if idle is not None:
                cells.append(say.percent(idle.share_of(idle.leakage_of(found.key)), 2))
            if decided:
                cells.append(self._decision(row))
            if projected:
                at = found.replace_mileage
                cells.append(say("texts.mileage", value=say.number(at, 0)) if _worth_saying(at) else "–")
            rows.append([*cells, self._reason(found)])
        widths = "41" + "2" * (len(names) - 3) + "6"
        aligned = "lll" + "r" * (4 + (idle is not None)) + "l" * decided + "r" * projected + "l"
        yield table([self._column(name) for name in names], rows, widths, aligned)
        yield text(say("texts.both_rules"), small=True)
        if any(row["uncertainty_um"] is not None for row in self.record["lands"]):
            yield text(say("texts.uncertainty"), small=True)
        if projected:
            yield text(f"{say('columns.replace_at')}: {say('texts.replace_at')}.", small=True)

    def _repair_order(self, charts: dict[str, str]) -> Iterable[Block]:
        say, plan = self.say, self.diagnosis.repair_plan
        if not plan:
            return
        yield text(say("texts.repair_order", condition=self.condition(plan[0].condition)))
        rows = [
            [
                str(number),
                self.land_name(step.land),
                {"sign": step.land.verdict, "text": say.get("verdicts", step.land.verdict)},
                say.percent(step.share_before),
                say.percent(step.share_after),
            ]
            for number, step in enumerate(plan, start=1)
        ]
        names = ["", *(say(f"columns.{name}") for name in ("pair", "verdict", "before", "after"))]
        yield table(names, rows, "05222", "rllrr")

    def _all(self, charts: dict[str, str]) -> Iterable[Block]:
        say = self.say
        names = (
            "pair",
            "land",
            "sleeve",
            "spool",
            "clearance",
            "mounting",
            "wear",
            "effective",
            "leakage",
            "share",
            "verdict",
        )
        rows = []
        for found in self.diagnosis.lands:
            state = found.state
            rows.append(
                [
                    f"{state.land.component}  {self.diagnosis.controller.components[state.land.component]}",
                    str(state.land.land),
                    say.number(state.sleeve_diameter * MM, 4),
                    say.number(state.spool_diameter * MM, 4),
                    self._clearance(found, unit=False),
                    say.number(state.land.mounting_clearance * UM, 1),
                    say.number(None if found.wear is None else found.wear * PERCENT, 0),
                    say.number(found.effective_clearance * UM, 1),
                    self._leakage(found),
                    say.number(found.share * PERCENT, 2),
                    {"sign": found.verdict, "text": say.get("verdicts", found.verdict)},
                ]
            )
        units = dict(zip(names, ("", "", "mm", "mm", "µm", "µm", "%", "µm", "dm³/min", "%", ""), strict=True))
        titles = [f"{self._column(name)}, {units[name]}" if units[name] else self._column(name) for name in names]
        yield table(titles, rows, "41222222222", "lcrrrrrrrrl")
        yield text(f"{say('columns.share')}: {self.condition(self.diagnosis.projection.condition)}.", small=True)

    def _shares(self, charts: dict[str, str]) -> Iterable[Block]:
        if "shares" not in charts:
            return
        say, at = self.say, self.diagnosis.projection
        top = self.diagnosis.ranked[:BARS]
        lands = _joined(f"{self.land_name(found)} {say.percent(found.share, 2)}" for found in top)
        yield {
            "kind": "image",
            "file": charts["shares"],
            "alt": say("charts.shares_alt", lands=lands),
            "caption": say("charts.caption_shares", condition=self.condition(at.condition)),
        }

    def _road_test(self, charts: dict[str, str]) -> Iterable[Block]:
        road, say = self.diagnosis.road, self.say
        if road is None or self.series is None:
            return
        test = road.road_test
        shares = _joined(
            f"{say(f'pressures.{name}')} {say.percent(share, 0)}"
            for name, share in road.section_shares.items()
            if share is not None
        )
        yield facts(
            [
                [say("facts.road_test"), test.file],
                [say("facts.duration"), f"{say.number(test.duration, 1)} s"],
                [say("facts.samples"), say.number(test.rows, 0)],
                [say("facts.gears"), _joined(map(str, road.gears))],
                [say("facts.sections"), shares],
            ]
        )
        numbered = list(enumerate(self.series.instants.items(), start=1))
        spoken = " ".join(
            say(
                "charts.instant_alt",
                instant=say(f"instants.{name}"),
                share=say.percent(found.share) if found.share is not None else f"{self._flow(found.leakage)} dm³/min",
                time=say.number(found.time, 1),
            )
            for _, (name, found) in numbered
        )
        thinned = ""
        if self.series.thinned:
            kept = say.number(len(self.series.columns["time_s"]), 0)
            thinned = say("charts.caption_thinned", kept=kept, samples=say.number(self.series.samples, 0))
        listed = _joined(f"{number} {say(f'instants.{name}')}" for number, (name, _) in numbered)
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
                f"{self._flow(found.leakage)} dm³/min",
                "–" if found.pump_capacity is None else f"{self._flow(found.pump_capacity)} dm³/min",
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
            land = f"{say('columns.land')} {each.land}" if each.land else ""
            decision = say.get("job_decisions", each.decision) if each.decision else "–"
            date = say.date(each.date) if each.date else ""
            rows.append([_joined((f"{each.component}  {name}".strip(), land)), each.work, decision, each.reason, date])
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
            [say("facts.fluid_found"), _joined(found, "; ")],
            [say("facts.contamination"), _joined((grade, dirt.particles, dirt.note), "; ")],
        ]
        yield facts([row for row in rows if row[1]])
        scratches = [each for each in job.scratches if not each.empty]
        if scratches:
            names = [say("columns.component"), say("columns.land"), say("facts.scratches")]
            rows = [
                [
                    _joined((each.component, each.part), " "),
                    str(each.land or ""),
                    each.description,
                ]
                for each in scratches
            ]
            yield table(names, rows, "316", "lll")

    def _photos(self, charts: dict[str, str]) -> Iterable[Block]:
        photos = [(photo.file, _joined((photo.component, photo.caption), " · ")) for photo in self.job.photos]
        photos += [
            (each.photo, _joined((each.component, each.description), " · "))
            for each in self.job.scratches
            if each.photo
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
                nu=say.number(fluid.kinematic_viscosity(found.condition.temperature, model) * 1e6, 2),
                rho=say.number(fluid.density(found.condition.temperature, model) * 1e-3, 4),
                temperature=say.plain(found.condition.temperature),
            )
            for found in _distinct(diagnosis.projections)
        ]
        instruments = [
            _joined(
                (
                    _joined((each.name, each.serial), " "),
                    say("facts.calibrated", date=say.date(each.calibrated)) if each.calibrated else "",
                    each.note,
                )
            )
            for each in job.instruments
            if not each.empty
        ]
        measured = f"{diagnosis.measured} / {len(diagnosis.lands)}"
        temperature = REFERENCE_TEMPERATURE if job.measuring_temperature_c is None else job.measuring_temperature_c
        options = _joined(f"{name} = {value}" for name, value in diagnosis.profile.options.items())
        yield facts(
            [
                [say("facts.controller"), diagnosis.controller.name],
                [say("facts.fluid"), fluid.name],
                [say("facts.viscosity"), _joined(viscosities, "; ")],
                [say("facts.profile"), diagnosis.profile.label],
                [say("facts.options"), options],
                [say("facts.measured"), measured],
                [say("facts.measuring_temperature"), f"{say.plain(temperature)} °C"],
                *([[say("facts.instruments"), _joined(instruments, "; ")]] if instruments else []),
            ]
        )

    def _limits(self, charts: dict[str, str]) -> Iterable[Block]:
        say, limits = self.say, self.diagnosis.limits
        rows = []
        for name, steps in limits.rules.items():
            factor, unit = (UM, "µm") if name == "radial_clearance" else (PERCENT, "%")
            table_name = "bands" if name == "total_share" else "verdicts"
            levels = _joined(
                say("rules.level", level=say.get(table_name, level), limit=f"{say.plain(limit * factor)} {unit}")
                for level, limit in steps.levels
            )
            rows.append([say(f"rules.{name}"), levels, say.get("origins", steps.origin), steps.source])
        yield table([say(f"columns.{name}") for name in ("rule", "limit", "origin", "source")], rows, "3426", "llll")
        yield text(f"{limits.name}. {say('texts.limit_note')}", small=True)

    def _assumptions(self, charts: dict[str, str]) -> Iterable[Block]:
        say, diagnosis = self.say, self.diagnosis
        items = [diagnosis.controller.representative] if diagnosis.controller.representative else []
        by_values: dict[tuple[str, ...], list[str]] = {}
        for found in diagnosis.lands:
            if found.state.land.representative:
                by_values.setdefault(found.state.land.representative, []).append(self.land_number(found))
        for values, lands in by_values.items():
            named = _joined(say.get("parts", value) for value in values)
            said = say("texts.representative_land", values=named, lands=_joined(lands))
            items.append(say("texts.representative_lands", values=said))
        if diagnosis.controller.pump.representative:
            values = _joined(diagnosis.controller.pump.representative)
            items.append(say("texts.representative_lands", values=values))
        if diagnosis.fluid.representative:
            items.append(
                f"{diagnosis.fluid.name}: {say('facts.representative')}: {_joined(diagnosis.fluid.representative)}."
            )
        for status, key in (("spool_only", "assumed_sleeve"), ("sleeve_only", "assumed_spool"), ("not_measured",) * 2):
            lands = [self.land_number(found) for found in diagnosis.lands if found.state.status == status]
            if lands:
                items.append(say(f"texts.{key}", lands=_joined(lands)))
        own = [say(f"rules.{name}") for name, steps in diagnosis.limits.rules.items() if "choice" in steps.origin]
        if own:
            items.append(say("texts.project_limits", rules=_joined(own)))
        pump = diagnosis.controller.pump
        if diagnosis.profile.pump_efficiency == "wilson" and pump.slip_coefficient is not None:
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
            if message.level == level
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
        yield table(["", say("columns.file"), "SHA-256"], rows, "236", "lll")

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

    # --- words for things

    def condition(self, point: OperatingPoint) -> str:
        """A condition's name in the reader's language."""
        say = self.say
        if point.name in say.texts["conditions"] and point.name != "stated":
            name = say(f"conditions.{point.name}")
            return say("conditions.at", name=name, temperature=say.plain(point.temperature))
        if point.name == "stated":
            temperature, speed = say.plain(point.temperature), say.number(point.engine_speed * RPM, 0)
            return say("conditions.stated", gear=point.gear, temperature=temperature, speed=speed)
        return point.label

    def land_number(self, found: LandDiagnosis) -> str:
        """``8/2``: component and land."""
        return f"{found.state.land.component}/{found.state.land.land}"

    def land_name(self, found: LandDiagnosis) -> str:
        """Component, its name and the land."""
        land = found.state.land
        return f"{land.component} {self.diagnosis.controller.components[land.component]}, {self._column('land')} {land.land}"

    def _column(self, name: str) -> str:
        return self.say(f"columns.{name}")

    def _idle(self) -> Projection | None:
        idle = self.diagnosis.hot_idle
        return None if idle is None or idle is self.diagnosis.projection else idle

    def _clearance(self, found: LandDiagnosis, *, unit: bool = True) -> str:
        uncertainty = self.rows[found.key]["uncertainty_um"]
        value = self.say.number(found.state.radial_clearance * UM, 1)
        if uncertainty is not None:
            value += f" ± {self.say.number(uncertainty, 1)}"
        return f"{value} µm" if unit else value

    def _leakage(self, found: LandDiagnosis) -> str:
        row = self.rows[found.key]
        value = self._flow(found.leakage, 3)
        low, high = row["leakage_low_dm3_min"], row["leakage_high_dm3_min"]
        return value if low is None else f"{value} ({self.say.number(low, 3)}–{self.say.number(high, 3)})"

    def _flow(self, value: float, digits: int = 2) -> str:
        return self.say.number(value * DM3_MIN, digits)

    def _decision(self, row: dict[str, Any]) -> str:
        if row["decision"] is None:
            return "–"
        said = self.say.get("decisions", row["decision"])
        probability = row["probability_over_limit"]
        return said if probability is None else f"{said} ({self.say.percent(probability, 0)})"

    def _reason(self, found: LandDiagnosis) -> str:
        """Every rule that reached a limit, the one that gave the verdict first."""
        reached = [rule for rule in found.rules if rule.verdict in FLAGGED]
        reached.sort(key=lambda rule: -VERDICTS.index(rule.verdict))
        return "; ".join(self._reached(rule) for rule in reached)

    def _reached(self, rule: RuleResult) -> str:
        say = self.say
        factor, digits, unit = (UM, 1, "µm") if rule.unit == "µm" else (PERCENT, 1, "%")
        return say(
            "rules.reached",
            rule=self._rule(rule),
            value=f"{say.number(rule.value * factor, digits)} {unit}",
            limit=f"{say.plain(rule.limit * factor)} {unit}",
            origin=say.get("origins", rule.origin),
        )

    def _rule(self, rule: RuleResult) -> str:
        if not rule.rule.startswith("share_"):
            return self.say(f"rules.{rule.rule}")
        name = rule.rule.removeprefix("share_")
        points = (
            *(found.condition for found in self.diagnosis.projections),
            *self.diagnosis.controller.operating_points,
        )
        point = next((each for each in points if each.name == name), None)
        return self.say("rules.share_at", condition=name if point is None else self.condition(point))


_LEGEND = ("critical", "replace", "watch", "ok", "not_measured")
_BAND_SIGNS = {"green": "ok", "amber": "watch", "red": "replace", "critical": "critical"}


def text(content: str, *, small: bool = False) -> Block:
    """A paragraph."""
    return {"kind": "text", "text": content, "small": small}


def facts(rows: Sequence[Sequence[str]]) -> Block:
    """Names and values side by side; nothing where there are none."""
    return {"kind": "facts", "rows": [list(row) for row in rows]} if rows else {}


def table(
    names: Sequence[str], rows: Sequence[Sequence[Any]], widths: str, aligned: str, *, empty: bool = True
) -> Block:
    """A table; ``widths`` are shares (0: as narrow as its content), ``aligned`` l, c or r, a digit or letter a column.

    With ``empty`` False, columns in which nothing stands are left out.
    """
    columns = list(range(len(names)))
    if not empty:
        columns = [column for column in columns if any(row[column] not in ("", "–") for row in rows)]
    if not rows or not columns:
        return {}
    return {
        "kind": "table",
        "names": [names[column] for column in columns],
        "rows": [[row[column] for column in columns] for row in rows],
        "widths": [int(widths[column]) for column in columns],
        "aligned": "".join(aligned[column] for column in columns),
    }


def _joined(parts: Iterable[str], between: str = ", ") -> str:
    return between.join(part for part in parts if part)


def _distinct(projections: Iterable[Projection]) -> list[Projection]:
    found: list[Projection] = []
    for projection in projections:
        if not any(projection is other for other in found):
            found.append(projection)
    return found


def _worth_saying(mileage: float | None) -> bool:
    return mileage is not None and mileage < 1e7
