"""Build the customer's page, with the sections of his screen: the answer, the picture, what it costs.

A reader who repairs no cars must be able to say after 20 seconds what is wrong, what to do and what it costs. Texts are
built in several lengths, and the template takes the longest that fits; an estimate may take a second page.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, starmap
from types import MappingProxyType
from typing import Any

from atleak.analysis.changes import Comparison
from atleak.analysis.estimate import Line
from atleak.analysis.pressures import lowest_first, pressures_at
from atleak.analysis.record_doubts import needless_work
from atleak.catalogue.repairs import LandKey
from atleak.common.units import KPA, PERCENT
from atleak.common.verdicts import VERDICTS, Band, Verdict
from atleak.common.wording import begun, isolated, joined
from atleak.diagnosis.consequence import Consequence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.missing import Cause
from atleak.report.charts.drawing import shortened
from atleak.report.pdf.blocks import Block, listed, signatures
from atleak.report.pdf.customer_valves import CustomerValves
from atleak.report.printed_names import PrintedNames, PrintedPart
from atleak.report.tables.answer import how_sure
from atleak.report.tables.complaint import explanations, most_lost
from atleak.report.tables.first_sentence import impossible_part, may_parts, measured_sentence, shown_verdict, worn_pump
from atleak.report.tables.repairs import repair_name
from atleak.report.tables.sentences import service_mileage
from atleak.report.tables.table import Column


@dataclass(frozen=True)
class _Length:
    """How much of everything that can be long stands on the page."""

    letters: int  # of the complaint
    sentences: int = 99  # of what is wrong, and of what to do
    found: int = 99  # sentences


_LENGTHS = (
    *map(_Length, (700, 480, 320, 700, 480, 320, 180, 100)),
    *starmap(_Length, ((100, 3, 2), (60, 2, 1), (60, 1, 1), (60, 1, 0))),
)
_WITH_PHOTO = 3  # of these lengths; and with the estimate on the same page
_WITH_FOUND = next(number for number, each in enumerate(_LENGTHS) if not each.found)
_LINES = (40, 30, 20, 10)  # of the estimate, on a page of its own


class CustomerPage(PrintedPart):
    """The first page of one report.

    Parameters
    ----------
    signed
        puts the signatures on it.
    visits
        this result beside that of another visit of the unit.
    """

    def __init__(self, names: PrintedNames, *, signed: bool, visits: Comparison | None = None) -> None:
        super().__init__(names)
        self.signed, self.valves = signed, CustomerValves(names)
        shown = shown_verdict(names.diagnosis)
        self.verdict = names.diagnosis.urgency if shown.flagged else shown
        known = visits is not None and _total_known(visits.before) and _total_known(visits.after)
        leading = visits.leading if visits is not None and known else None
        both = (None, None) if leading is None else (leading.before, leading.after)
        self._is_later = visits is not None and visits.after is self.diagnosis
        here, self._other = both[::-1] if self._is_later else both
        self._worst = here or self.diagnosis.worst
        self._changed = leading is not None and leading.share is not None and leading.share.significant is not False

    def data(self, *, behind: str = "", pictures: Mapping[str, str] = MappingProxyType({})) -> dict[str, Any]:
        """Return everything that the template places.

        Parameters
        ----------
        behind
            what follows the page.
        pictures
            files of the job's pictures by their names.
        """
        say, diagnosis = self.say, self.diagnosis
        wrong, found, do = (list(each) for each in (self._wrong(), self._found(), self._do()))
        answer = self.names.answer
        unjudged = answer.cause is not Cause.UNEXPLAINED and (answer.missing is None or answer.missing.doubted)
        sure = "" if unjudged else how_sure(answer, say)
        return {
            "title": say("customer_screen.title"),
            "about": self._about(),
            "key": self.verdict,
            "headline": self.headline,
            "urgency": self.urgency,
            "answer": [
                [
                    [name, said]
                    for name, said in (
                        (say("answer.wrong"), " ".join(wrong[: each.sentences])),
                        (say("answer.do"), " ".join(do[: each.sentences])),
                        (say("customer.cost"), self._asked()),
                        (say("answer.sure"), sure),
                    )
                    if said
                ]
                for each in _LENGTHS
            ],
            "caveats": [say(f"customer.{name}") for name in ("provisional", "upper_bound") if getattr(diagnosis, name)],
            "told": {"title": say("customer.told"), "texts": [self._told(each.letters) for each in _LENGTHS]},
            "found": {"title": say("customer.found"), "texts": [found[: each.found] for each in _LENGTHS]},
            "valves": say("customer.valves"),
            "drawings": [
                {**each, "lengths": _WITH_FOUND if each["casting"] else len(_LENGTHS)}
                for each in self.valves.drawings()
            ],
            "photo": self.valves.photo(pictures),
            "bars": {"title": self.bars_at, "rows": [*self.bars()], "note": self._tighter()},
            "cost": self._cost(),
            "signatures": self._signatures() if self.signed else None,
            "follows": say("customer.follows", part=behind) if behind else "",
            "overleaf": say("customer.overleaf"),
            "lengths": len(_LENGTHS),
            "with-photo": _WITH_PHOTO,
        }

    @property
    def headline(self) -> str:
        """Say in a line how the valve body is."""
        return self.say(f"customer.{self._case or self._told_as}")

    @property
    def urgency(self) -> tuple[str, str]:
        """Return how urgent it is, behind the words that ask for it."""
        return self.say("customer.urgency"), self.say(f"customer.urgent_{self._urgency}", mileage=self._service)

    @cached_property
    def _planned_lands(self) -> list[LandKey]:
        """Return the lands that the plan of repairs names and that cannot wait, in its order."""
        steps = (step for step in self.names.plan.steps if step.consequence in (Consequence.NOW, Consequence.UNKNOWN))
        lands = ((step.land, *(each for each in step.together if each.verdict.flagged)) for step in steps)
        return [land.key for land in chain.from_iterable(lands)]

    @property
    def _planned(self) -> list[str]:
        """Return their valves."""
        return list(dict.fromkeys(component for component, _ in self._planned_lands))

    @cached_property
    def _due(self) -> list[str]:
        """Return the valves that are worn past a limit and cannot wait; where none is, those that are planned."""
        return [each.component for each in self.valves.worn if each.urgency.calls_for_repair] or self._planned

    @cached_property
    def _before_service(self) -> tuple[LandDiagnosis, ...]:
        """Return the lands past a limit whose wear does something before the next service, and nothing yet."""
        diagnosis = self.diagnosis
        return tuple(
            land for land in diagnosis.flagged if diagnosis.consequences[land.key] is Consequence.BEFORE_NEXT_SERVICE
        )

    @property
    def _service(self) -> str:
        """Return the mileage of the next service; an empty text where nothing is foreseen by then."""
        at = [self.diagnosis.next_service(land) for land in self._before_service]
        return service_mileage(at[0], self.say) if at and at[0] is not None else ""

    @cached_property
    def _case(self) -> str:
        """Return what is special about the finding; an empty text where valves have reached a limit by themselves.

        Gauges or a log alone found nothing; description or readings cannot be right; the pump is worn; what was
        measured is sound and the customer complains; the limit of a total, gauge or log is passed that no valve has.
        """
        diagnosis, verdict = self.diagnosis, self.verdict
        if verdict is Verdict.OK and diagnosis.without_sheet:
            return "ok_unmeasured"
        if diagnosis.impossible:
            return "impossible"
        if diagnosis.decided_by is None and diagnosis.too_tight:
            return "doubtful"
        if diagnosis.decided_by is diagnosis.pump or (diagnosis.pump.verdict.flagged and not self._due):
            return "pump"
        if verdict is Verdict.OK:
            return "ok_complaint" if self._complaint else ""
        if not verdict.calls_for_repair:
            return "past_watch" if verdict.flagged and not diagnosis.flagged else ""
        if self._not_the_valves:
            return "past_unexplained"
        if any(diagnosis.urgency_of(land).calls_for_repair for land in diagnosis.flagged):
            return ""
        return "past_together" if self._planned else "past_unexplained"

    @cached_property
    def _not_the_valves(self) -> bool:
        """Tell whether a pressure is missing that no valve explains."""
        answer = self.names.answer
        missing = answer.missing is not None and not answer.by_flow
        return missing and answer.cause not in (Cause.LANDS, Cause.LINE_SETTING)

    @property
    def _urgency(self) -> str:
        if self._case in ("impossible", "ok_unmeasured", "ok_complaint"):
            return self._case
        if self._before_service and self._told_as is Verdict.WATCH:
            return "before_service"
        past = "past_" if self._case in ("past_together", "past_unexplained") else ""
        return Verdict.NOT_MEASURED if self._case == "doubtful" else f"{past}{self._told_as}"

    @property
    def _told_as(self) -> Verdict:
        """Return the verdict, or the next milder one for which there are words: a customer is told fewer levels."""
        worded = (each for each in reversed(VERDICTS) if f"urgent_{each}" in self.say.table("customer"))
        return next(each for each in worded if each.rank <= self.verdict.rank)

    # --- who, and how bad

    def _about(self) -> str:
        """Return whose vehicle it is, in a line."""
        job, say = self.job, self.say
        return joined(
            (
                f"{say('facts.number')} {isolated(job.number)}" if job.number else "",
                say.date(job.date) if job.date else "",
                job.customer.name,
                self.names.vehicle,
                job.vehicle.registration or job.vehicle.vin,
                self.names.mileage,
            ),
            " · ",
        )

    # --- complaint and finding

    @cached_property
    def _complaint(self) -> str:
        complaint = self.diagnosis.complaint
        return " ".join(self.job.complaint.split()) or (self.say.name(complaint.label) if complaint is not None else "")

    def _told(self, letters: int) -> str:
        """Return what the customer complained of in so many letters, or as the valve body's file words it."""
        words = self._complaint
        if len(words) <= letters:
            return words
        return self.say("customer.cut", text=words[:letters].rsplit(" ", 1)[0].rstrip(" ,;."))

    def _wrong(self) -> Iterator[str]:
        """Say what is wrong: with the unit, its pump or its valves, and which pressure falls."""
        say, diagnosis = self.say, self.diagnosis
        finding, pump = measured_sentence(diagnosis, say), worn_pump(diagnosis, say)
        if diagnosis.impossible:
            yield f"{begun(impossible_part(diagnosis, say))}."
        elif pump is not None:
            yield pump
        due = [each.component for each in self.valves.worn if each.urgency.calls_for_repair]
        if due:
            yield say("customer.worn_valves", valves=self.valves.named(due))
        yield from self.held()
        if any(not diagnosis.can_wait(land) for land in diagnosis.flagged):
            yield say("customer_screen.escapes")
        if watched := [each.component for each in self.valves.worn if not each.urgency.calls_for_repair]:
            yield say("customer.worn_little", valves=self.valves.named(watched))
        if finding is not None and self.verdict is not Verdict.OK:
            yield finding

    @property
    def sentence(self) -> str:
        """Say what was lost at the visit before and is lost now, where that is not the measuring alone; else why."""
        if self._other is not None and self._changed and self._is_later:
            before, now = (self._litres(each.share) for each in (self._other, self._worst))
            return self.say("customer_screen.since", before=before, now=now)
        return next(self.held(), self.say("customer_screen.escapes") if self.valves.worn else "")

    @property
    def bars_at(self) -> str:
        """Say what the bars are of, and where."""
        return self.say("customer_screen.bars", condition=self.say.condition(self._worst.condition))

    def bars(self) -> Iterator[dict[str, Any]]:
        """Yield how much of what the pump delivers is lost now, at another visit, after the repairs and when new."""
        worst = self._worst
        if not _total_known(self.diagnosis) or worst.pump_capacity <= 0.0:
            return
        lost = {"now": worst.share}
        if self._other is not None:
            lost = {"before": self._other.share, **lost} if self._is_later else {**lost, "later": self._other.share}
        lost |= self._repaired | {"new": self.diagnosis.new_at(worst).share}
        for name, share in lost.items():
            said, width = self.say(f"customer_screen.{name}"), round(min(share, 1.0), 3)
            yield {"name": said, "litres": self._litres(share), "width": width, "now": name == "now"}

    def _litres(self, share: float) -> str:
        """Say how many litres of 100 are lost: more than all, where the leaks ask for more than there is."""
        return ("> " if share > 1.0 else "") + self.say.number(min(share, 1.0) * PERCENT, 0)

    @cached_property
    def _repaired(self) -> dict[str, float]:
        """Return what is lost with the repairs of the estimate, or with the planned ones where none is made."""
        words = self.names.estimate
        if words is not None:
            done = any(line.carried_out for line in words.estimate.lines)
            name, ends = "after", words.estimate.ends if done else ()
        else:
            due = self.verdict.calls_for_repair and self.names.plan.order
            name, ends = "planned", self.names.plan.ends if due else ()
        end = next((each for each in ends if each.condition == self._worst.condition), None)
        return {} if end is None else {name: end.share}

    def _tighter(self) -> str:
        """Say why less may be lost after the repairs than in a new unit."""
        new = self.diagnosis.new_at(self._worst).share
        shown = map(self._litres, (*self._repaired.values(), new))
        less = any(each < new for each in self._repaired.values()) and len({*shown}) > 1
        return self.say("customer.tighter") if less else ""

    def _found(self) -> Iterator[str]:
        """Say what was measured, what is lost by it where bars cannot, and what the complaint has to do with it."""
        say, diagnosis = self.say, self.diagnosis
        if diagnosis.without_sheet:
            yield say("customer.no_sheet")
            finding = measured_sentence(diagnosis, say)
            if finding and self.verdict is Verdict.OK:
                yield finding
        elif diagnosis.judged:
            yield self._measured()
        if not self._not_the_valves:
            yield from self._explained()
        flagged = (land for land in diagnosis.flagged if land.key[0] not in self._due)
        if waits := [land.key[0] for land in flagged if diagnosis.can_wait(land)]:
            yield say("customer.waits", valves=self.valves.named(waits))
        if not any(self.bars()) or self._worst.share > 1.0:
            yield from self.lost()
        if self.verdict is Verdict.OK and any(may_parts(diagnosis, say)):
            yield say("customer.may")
        half = sum(land.state.measured for land in diagnosis.unmeasured)
        missing = len(diagnosis.unmeasured) - half
        if missing and diagnosis.judged:
            yield say("customer.open", missing=missing, lands=len(diagnosis.lands))
        if half:
            yield say("customer.half", half=half, lands=len(diagnosis.lands))
        if diagnosis.in_doubt:
            yield say("customer.doubt", count=len(diagnosis.in_doubt))

    def _measured(self) -> str:
        flagged = self.diagnosis.flagged
        repair = sum(self.diagnosis.urgency_of(land).calls_for_repair for land in flagged)
        found = self.say(
            f"customer.{'worn' if flagged else 'within'}",
            measured=self.diagnosis.judged,
            repair=repair,
            watch=len(flagged) - repair,
        )
        later = len(self._before_service)
        said = [self.say("customer.seal"), found]
        said += [self.say("customer.later", count=later, mileage=self._service)] if later else []
        return " ".join(said)

    def lost(self) -> Iterator[str]:
        """Say how much of the oil that the pump delivers is lost, where that is worst."""
        say, at = self.say, self.diagnosis.worst
        condition, band = self.say.condition(at.condition), self.diagnosis.band(at)
        new = say.percent(self.diagnosis.new_at(at).share)
        if self.diagnosis.worst_total in self.diagnosis.pump.lacking or self.diagnosis.impossible:
            return
        if at.pump_capacity <= 0.0:
            said = say("diagnosis.no_delivery", condition=condition)
            yield f"{said[0].upper()}{said[1:]}."
        elif band is None:
            if not self.diagnosis.without_sheet:
                key = "lost_new_over" if self.diagnosis.new_at(at).share > 1.0 else "lost_new"
                yield say(f"customer.{key}", condition=condition, new=new)
        else:
            key = "lost_over" if at.share > 1.0 else "lost"
            yield say(f"customer.{key}", condition=condition, share=say.percent(at.share), band=self._reached, new=new)

    @property
    def _reached(self) -> str:
        """Return the word of the band that the total reached where it is worst, with "just" where that is not sure."""
        rule = self.diagnosis.worst_total
        decided, word = self.diagnosis.decided(rule), self.say.level(Band(rule.level))
        return self.say("customer.just", band=word) if decided is not None and decided.conditional else word

    def held(self) -> Iterator[str]:
        """Say which pressures are past a limit where they are judged worst, the worst first, two at the most."""
        at = pressures_at(self.diagnosis, lowest_first(self.diagnosis)[0])
        ranked = [(each.verdict.rank, each) for each in at.applied if each.verdict is not None and each.verdict.flagged]
        past = [each for each in ranked if each[1].rule not in self.diagnosis.pump.lacking]
        for _, each in sorted(past, key=lambda each: -each[0])[:2] if not self.diagnosis.impossible else ():
            yield self.say(
                "customer.holds",
                circuit=self._pressure(each.id),
                condition=self.say.condition(at.projection.condition),
                held=self._kpa(each.now),
                new=self._kpa(each.new),
            )

    def _kpa(self, pressure: float) -> str:
        return self.say.value(pressure * KPA, "pressure", 0)

    def _explained(self) -> Iterator[str]:
        """Say which pressure the worn valves cost where the complaint shows; that they cost none, where they do not."""
        say, diagnosis = self.say, self.diagnosis
        if diagnosis.complaint is None or not diagnosis.complained or not diagnosis.judged:
            return
        label = say.name(diagnosis.complaint.label)
        for each in explanations(diagnosis, diagnosis.complaint)[:1]:
            assert each.rule.condition is not None  # as of every pressure that is computed
            values = {
                "label": label,
                "condition": self.say.condition(each.rule.condition),
                "valves": self.valves.named(component for component, _ in each.lands),
            }
            if each.held is None:
                yield say("customer.explained_by_reserve", **values)
            else:
                held, new = self._kpa(each.held.now), self._kpa(each.held.new)
                yield say("customer.explained", circuit=self._pressure(each.held.id), held=held, new=new, **values)
            return
        if diagnosis.profile.circuits != "on":  # no pressure is solved
            return
        conditions = joined(self.say.condition(each.condition) for each in diagnosis.complained)
        lost = most_lost(diagnosis)
        loss = "" if lost is None else self._kpa(lost.loss)
        key = "no_effect" if lost is None else "small_effect"
        yield say(f"customer.{key}", label=label, condition=conditions, loss=loss)

    def _more(self, count: int) -> str:
        return self.say("customer.more", count=count) if count else ""

    def _pressure(self, section: str) -> str:
        """Name a section as people say it."""
        letters = f" {section}"
        return self.names.section(section).removesuffix(letters)

    # --- what to do

    def _do(self) -> Iterator[str]:
        say, planned, case = self.say, self._planned, self._case
        if self.verdict is Verdict.OK:
            unmeasured = "measure_sheet" if self._complaint else "nothing_seen"
            alone = {"ok_unmeasured": unmeasured, "ok_complaint": "elsewhere"}
            yield say(f"customer.do_{alone.get(case, 'nothing')}")
            return
        if self.verdict is Verdict.NOT_MEASURED or case in ("doubtful", "impossible"):
            describe = case == "impossible" and self.verdict is not Verdict.NOT_MEASURED
            yield say("customer.do_describe" if describe else "customer.do_measure")
            return
        if (pump := self.names.plan.pump) is not None:
            repair = "" if pump.chosen is None else repair_name(pump.chosen.repair, say)
            words = self.names.estimate
            for line in () if words is None else words.estimate.lines:
                if line.of_pump and line.own:
                    repair = say.name(line.decision.work)
            yield say("pump.repair_by", repair=repair) if repair else say("pump.repair_first")
            if not self._due:
                yield say("customer.do_pump")
                return
        if self._not_the_valves and self.names.plan.pump is None:
            yield say("customer.do_find")
        watched = [each.component for each in self.valves.worn if not each.urgency.calls_for_repair]
        if not self.verdict.calls_for_repair:
            before = list(dict.fromkeys(land.key[0] for land in self._before_service))
            key = "do_before" if before else "do_watch" if watched or planned else "do_look"
            yield say(f"customer.{key}", valves=self.valves.named(before or watched or planned), mileage=self._service)
            yield from self._elsewhere()
            return
        due = self._due
        if not due:
            if not self._not_the_valves:
                yield say("customer.do_look")
            return
        yield say("customer.do_repair", valves=self.valves.named(due))
        words, plan = self.names.estimate, self.names.plan
        if words is not None:  # the work that is agreed to with this page
            yield say(f"customer.do_{'past' if words.estimate.past else 'green'}_estimate")
        else:
            yield say(f"customer.do_{'green' if plan.reached else 'past'}_plan")
        yield from self._elsewhere()
        waiting = [each.component for each in self.valves.worn if each.urgency is not each.verdict]
        if waiting:
            yield say("customer.do_wait", valves=self.valves.named(waiting))

    def _elsewhere(self) -> Iterator[str]:
        """Say what to look at for a complaint that no pressure explains, where pressures are solved."""
        diagnosis = self.diagnosis
        if diagnosis.complaint is None or not diagnosis.judged or diagnosis.profile.circuits != "on":
            return
        if not explanations(diagnosis, diagnosis.complaint):
            yield self.say("customer.do_elsewhere")

    # --- what it costs, and who signs

    def _cost(self) -> Block | None:
        """Return the lines of the estimate with boxes to agree to each, and the sum; None where none is made."""
        say, words = self.say, self.names.estimate
        lines = self.lines()
        if words is None or not any(map(can_be_agreed_to, lines)):
            return None
        names = Counter(self.valves.about(line.decision) for line in lines)

        def valve(line: Line) -> str:
            name, land = self.valves.about(line.decision), line.decision.land
            return f"{name}, {say('printed.land')}\u00a0{land}" if land and names[name] > 1 else name

        columns = (
            Column("customer.valve", width=250, of=valve),
            Column("work", width=250, of=words.work),
            Column(
                "",
                digits=2,
                words=f"{say('printed.amount')}\n{words.estimate.currency}".strip(),
                of=lambda line: words.amount(line) if can_be_agreed_to(line) else say("customer.not_yet"),
            ),
            Column("agreed", width=200, of=lambda line: words.agreed(line) if can_be_agreed_to(line) else ""),
        )
        tables = [listed(say, lines[:most], *columns) for most in _LINES]
        needless = self.valves.first(map(self.valves.about, needless_work(self.job, self.diagnosis)))
        others = self.valves.first(
            self.valves.about(line.decision) for line in words.estimate.lines if line not in lines
        )
        due = self._due and self.verdict.calls_for_repair
        waits = not due and not needless and not self._case and self.verdict in (Verdict.OK, Verdict.WATCH)
        notes = (
            ("needless", needless, needless),
            ("none_due", waits, ""),
            ("incomplete", not words.estimate.total.complete, ""),
            ("unpriced", others, others),
            ("declined", due, ""),
        )
        said = [say(f"customer.{name}", valves=valves) for name, holds, valves in notes if holds]
        return {
            "title": say("customer.cost"),
            "tables": tables,
            "notes": [joined((self._more(max(len(lines) - most, 0)), *said), " ") for most in _LINES],
            "sum": self._sum(),
        }

    def lines(self) -> list[Line]:
        """Return the lines of the estimate that can be agreed to, or were, and those that cannot wait, these first."""
        words = self.names.estimate
        every = () if words is None else words.estimate.lines
        lines = [line for line in every if can_be_agreed_to(line) or self._needed(line)]
        return sorted(lines, key=lambda line: (not self._needed(line), not has_price(line)))

    def _needed(self, line: Line) -> bool:
        """Tell whether a line of the estimate is about what cannot wait."""
        due = {land.key for land in self.diagnosis.flagged if self.diagnosis.urgency_of(land).calls_for_repair}
        return line.of_pump or any(land.key in due.union(self._planned_lands) for land in line.lands)

    def _asked(self) -> str:
        """Say what a repair that is called for costs, and of which valves the price is missing."""
        words = self.names.estimate
        if not self.verdict.calls_for_repair:
            return ""
        if words is None or words.estimate.total.gross is None:
            asked = words is None or words.estimate.total.lines  # else every line is declined, or still open
            return self.say("customer.no_price") if asked and self._due else ""
        refused = ("declined", "deferred")
        missing = [each for each in self.lines() if not has_price(each) and each.decision.decision not in refused]
        valves = self.valves.first(self.valves.about(line.decision) for line in missing)
        return joined((self._sum(), self.say("customer.lacking", valves=valves) if missing else ""), " ")

    def _sum(self) -> str:
        """Say what the estimate adds up to; an empty text where nothing of it is known."""
        say, words = self.say, self.names.estimate
        if words is None or words.estimate.total.gross is None:
            return ""
        due = words.estimate.total
        gross, net = (words.money(each) for each in (due.gross, due.net))
        if not due.complete:
            gross, net = (say("customer.at_least", amount=each) for each in (gross, net))
        key = "customer.sum" if due.tax is None else "customer.sum_with_tax"
        return say(key, amount=gross, net=net, currency=words.estimate.currency)

    def _signatures(self) -> Block:
        """Return a line for technician and customer, and between them for who approves where the job names somebody."""
        job = self.job
        people = {"technician": job.technician, "approver": job.approved_by, "customer": job.customer.name}
        signing = [(role, shortened(name, 40)) for role, name in people.items() if name or role != "approver"]
        return signatures(signing, self.say)


def has_price(line: Line) -> bool:
    """Tell whether anything of what a line of the estimate costs is known."""
    return line.part is not None or line.work is not None


def can_be_agreed_to(line: Line) -> bool:
    """Tell whether a line of the estimate can be agreed to, or was: it has a price, or was decided."""
    return has_price(line) or line.decision.decision not in (None, "proposed")


def _total_known(diagnosis: Diagnosis) -> bool:
    """Tell whether the total says something of the valve body, and not of a pump that is worn or not described."""
    if not diagnosis.judged or diagnosis.impossible:
        return False
    return diagnosis.worst_total not in diagnosis.pump.lacking
