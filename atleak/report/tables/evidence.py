"""Say what is likely worn of a unit before anything is opened, and what to measure next; and record it for scripts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from atleak.common.units import KPA, PERCENT, UM
from atleak.common.wording import Wording, begun
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.evidence import LIKELY, CircuitEvidence, Evidence, LandEvidence, evidence_of
from atleak.engine.profile import UNKNOWN
from atleak.report.json.conditions import named_record, of_land
from atleak.report.tables.before_opening import before_opening, flow_record
from atleak.report.tables.names import land_number, land_words
from atleak.report.tables.road_record import warm_up_record
from atleak.report.tables.road_words import warm_up_section
from atleak.report.tables.table import Column, Section, SectionPart, Table, Text, span
from atleak.report.tables.vacuum import vacuum_records
from atleak.version import __version__

FORMAT = 1
_LIKELY = 0.5  # from which probability on a part is named as likely worn
_SURELY = 0.99  # probability above which no more is said than that
_NAMED = 3  # parts that a sentence names


def evidence_sections(diagnosis: Diagnosis, say: Wording) -> dict[str, Section]:
    """Return the sections by their names: what is likely, lands, circuits, what to measure next, what is assumed.

    Where nothing that was read tells more than what is assumed, that is said first, and nothing is ranked.
    """
    words = _Words(diagnosis, say)
    parts: dict[str, Iterable[SectionPart]] = {
        "title": words.lead(),
        "lands": words.lands(),
        "circuits": words.circuits(),
        "next": [Text(said)] if (said := next_sentence(diagnosis, say)) else (),
        "assumed": words.assumed(),
    }
    made = {name: Section(name, say(f"likely.{name}"), tuple(of_name)) for name, of_name in parts.items()}
    return {name: section for name, section in made.items() if section.parts}


def closed_sections(diagnosis: Diagnosis, say: Wording) -> Iterator[Section]:
    """Yield all that is said before a unit is opened: what is likely, what stand, jug and drive showed, and more."""
    sections = evidence_sections(diagnosis, say)
    last = [sections.pop(name) for name in ("next", "assumed") if name in sections]
    drive = warm_up_section(diagnosis, say)
    yield from (*sections.values(), *before_opening(diagnosis, say), *([drive] if drive else []), *last)


def printed_sections(diagnosis: Diagnosis, say: Wording) -> Iterator[Section]:
    """Yield what a report has of it beside the road test: of a unit of which no sheet was measured what gauges tell."""
    told = diagnosis.without_sheet and diagnosis.pressures is not None and evidence_of(diagnosis).thin is None
    sections = closed_sections(diagnosis, say) if told else before_opening(diagnosis, say)
    yield from (section for section in sections if section.name != "warm_up")


def next_sentence(diagnosis: Diagnosis, say: Wording) -> str:
    """Say which lands to measure next, or that no further one is worth it; "" where nothing is known to say so."""
    evidence = evidence_of(diagnosis)
    lands = ", ".join(land_words(diagnosis.controller, each.land.key, say) for each in evidence.next)
    if lands:
        return say("likely.measure", lands=lands)
    return say("likely.enough") if evidence.thin is None else ""


class _Words:
    def __init__(self, diagnosis: Diagnosis, say: Wording) -> None:
        self.diagnosis, self.say = diagnosis, say
        self.evidence: Evidence = evidence_of(diagnosis)

    def lead(self) -> Iterator[Text]:
        evidence, say = self.evidence, self.say
        if evidence.thin is not None:
            yield Text(say.sentence(evidence.thin))
            return
        lost = [self._lost(each) for each in evidence.circuits if each.probability >= LIKELY]
        worn = [part for probability, part in self._parts() if probability >= _LIKELY]
        first = [part for _, part in self._parts()][:_NAMED]
        likely = say("likely.likely", parts=", ".join(worn[:_NAMED])) if worn else ""
        unlikely = say("likely.unlikely", parts=", ".join(first)) if first and not lost else ""
        yield Text(" ".join(filter(None, (*lost[:_NAMED], likely or unlikely))))

    def _parts(self) -> list[tuple[float, str]]:
        """Return every part that may be worn and how likely it is, the likeliest first, one of each group of lands."""
        evidence, say = self.evidence, self.say
        found = [(each.probability, "seal_part", self._circuit(each), "") for each in evidence.seals]
        if evidence.pump is not None:
            found.append((evidence.pump.probability, "part", say("pump.name"), ""))
        named, usual = set[int](), evidence.assumptions.worn_lands
        for each in evidence.lands:
            others = [other for other in self._group(each) if other != each]
            told = others and any(land.probability > usual for land in (each, *others))  # else many are worn by chance
            if each.group not in named:
                key, worn = ("group_part", each.of_group) if told else ("part", each.probability)
                found.append((worn, key, self._land(each), self._short(others)))
            named |= {each.group} if each.group is not None and told else set()
        return [
            (probability, say(f"likely.{key}", part=name, others=others, percent=self._percent(probability)))
            for probability, key, name, others in sorted(found, key=lambda each: -each[0])
        ]

    def _group(self, land: LandEvidence) -> list[LandEvidence]:
        """Return the lands that cannot be told apart from one, and itself; none of one that stands by itself."""
        return [each for each in self.evidence.lands if each.group == land.group is not None]

    def _short(self, lands: Iterable[LandEvidence]) -> str:
        controller = self.diagnosis.controller
        return ", ".join(land_number(controller, each.land.key, self.say) for each in lands)

    def _percent(self, probability: float) -> str:
        if probability > _SURELY:
            return self.say("answer.more_than", percent=self.say.percent(_SURELY, 0))
        return self.say.percent(probability, 0)

    def _land(self, each: LandEvidence) -> str:
        return land_words(self.diagnosis.controller, each.land.key, self.say)

    def _circuit(self, each: CircuitEvidence) -> str:
        return self.say.name(each.circuit.name)

    def _lost(self, each: CircuitEvidence) -> str:
        ends = (self.say.value(end * KPA, "pressure", 0) for end in (each.low, each.high))
        value = self.say.quantity(each.loss * KPA, "pressure", 0)
        amount = self.say("answer.between", value=value, low=next(ends), high=next(ends))
        return self.say("likely.lost", circuit=begun(self._circuit(each)), amount=amount)

    def lands(self) -> Iterator[SectionPart]:
        evidence, say = self.evidence, self.say
        if evidence.thin is not None:
            return
        usual = evidence.assumptions.worn_lands
        told = [each for each in evidence.lands if each.measured or each.probability > usual]
        columns = (
            Column("pair", of=self._land, width=220),
            Column("likely_worn", "percent", 0, of="probability", times=PERCENT),
            Column("clearance", "clearance", times=UM),
            Column("between", words_of="clearance", of=lambda each: self._span(each, UM, "clearance", 1)),
            Column("wear_costs", "pressure", 0, of="loss", times=KPA),
            Column("alike", digits=0, of="group"),
            Column("measured_land", of="measured"),
        )
        if told:
            yield Table("lands", columns, told, say).filled
        first = {each.group: each for each in reversed(told) if each.group is not None}
        for number, each in sorted(first.items()):
            yield Text(f"{number}: {say('likely.alike', lands=self._short(self._group(each)))}", small=True)
        if len(told) < len(evidence.lands):
            count = len(evidence.lands) - len(told)
            yield Text(say("likely.others" if told else "likely.none_apart", count=count), small=bool(told))

    def _span(self, each: Any, factor: float, kind: str, digits: int) -> str:
        return span((each.low * factor, each.high * factor), kind, self.say, digits)

    def circuits(self) -> Iterator[SectionPart]:
        evidence, say = self.evidence, self.say
        if evidence.thin is not None:
            return
        seals = {each.circuit.id: each for each in evidence.seals}

        def leaks(each: CircuitEvidence) -> float | None:
            seal = seals.get(each.circuit.id)
            return None if seal is None else seal.probability * PERCENT

        def by_seal(each: CircuitEvidence) -> str | None:
            seal = seals.get(each.circuit.id)
            return None if seal is None else self._span(seal, KPA, "pressure", 0)

        columns = (
            Column("circuit", of=self._circuit, width=160),
            Column("gauged", of="read"),
            Column("lost_too_much", "percent", 0, of="probability", times=PERCENT),
            Column("lost", "pressure", 0, of="loss", times=KPA),
            Column("between", words_of="pressure", of=lambda each: self._span(each, KPA, "pressure", 0)),
            Column("seal_leaks", "percent", 0, of=leaks),
            Column("lost_by_seal", words_of="pressure", of=by_seal),
        )
        if evidence.circuits:
            yield Table("circuits", columns, evidence.circuits, say).filled
        pump = evidence.pump
        if pump is not None:
            times = [say.number(1.0 + each, 1) for each in (pump.growth, pump.low, pump.high)]
            said = dict(zip(("value", "low", "high"), times, strict=True))
            yield Text(say("likely.pump", **said, percent=self._percent(pump.probability)))

    def assumed(self) -> Iterator[SectionPart]:
        say, rows = self.say, self.evidence.assumptions.priors
        columns = (
            Column("assumption", of=lambda name: say.get("uncertainty_assumed", name), width=260),
            Column("value", of=lambda name: say.plain_quantity(rows[name].value, rows[name].kind)),
            Column("assumption_name", of=lambda name: name, whole=True),
        )
        yield Table("assumed", columns, [*rows], say)
        eccentricity = self.diagnosis.profile.eccentricity
        key = "anywhere" if eccentricity == UNKNOWN else "lies"
        value = "" if eccentricity == UNKNOWN else say.percent(float(eccentricity), 0)
        yield Text(say(f"likely.{key}", value=value), small=True)
        yield Text(say("likely.set_by"), small=True)


def evidence_record(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return it as scripts read it, in the form of ``evidence --json``: µm, kPa and percent; nothing is rounded."""
    evidence = evidence_of(diagnosis)
    pump, priors = evidence.pump, evidence.assumptions.priors
    return {
        "format": FORMAT,
        "atleak": __version__,
        "controller": diagnosis.controller.id,
        "thin": None if evidence.thin is None else str(evidence.thin),
        "lands": [
            {
                **of_land(each.land.key),
                "probability_worn": each.probability,
                **named_record(each, "clearance_um", "low_um", "high_um", "loss_kpa", "group"),
                **named_record(each, group_probability="of_group", measured="measured"),
            }
            for each in evidence.lands
        ],
        "circuits": [*map(_circuit_record, evidence.circuits)],
        "pump": pump
        and {
            **named_record(pump, probability="probability", slip_growth_percent="growth"),
            **named_record(pump, "low_percent", "high_percent"),
        },
        "clutch_seals": [*map(_circuit_record, evidence.seals)],
        "vacuum": vacuum_records(diagnosis),
        "flows": [flow_record(each) for each in diagnosis.flows],
        "warm_up": warm_up_record(diagnosis),
        "next": [{**of_land(each.land.key), "value": each.value} for each in evidence.next],
        "effective_samples": evidence.effective_samples,
        "priors": {
            **{name: each.value for name, each in priors.items()},
            "eccentricity": diagnosis.profile.eccentricity,
        },
    }


def _circuit_record(each: CircuitEvidence) -> dict[str, Any]:
    return {"id": each.circuit.id, **named_record(each, "probability", "loss_kpa", "low_kpa", "high_kpa", "read")}
