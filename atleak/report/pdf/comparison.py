"""Print two visits of one unit as a page for the customer: what was wrong, what was done, what it brought."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator
from functools import partial
from operator import attrgetter
from typing import Any

from atleak.analysis.changes import SIDES, Comparison, LandComparison
from atleak.analysis.record_doubts import components_of, covered
from atleak.catalogue.repairs import LandKey
from atleak.common.style import DEFAULT_PAPER
from atleak.common.units import KPA, UM
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording, isolated, joined, wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.measurements.job_card import Job, RepairDecision
from atleak.report.charts.paper import drawn_on_paper
from atleak.report.pdf.blocks import section_blocks, signatures
from atleak.report.pdf.typesetting import write_page
from atleak.report.printed_fonts import OwnFont
from atleak.report.tables.comparison import differing_sentence, how_sure, total_picture, visit_caveats, with_uncertainty
from atleak.report.tables.first_sentence import measured_sentence
from atleak.report.tables.names import is_whole_body
from atleak.report.tables.table import VERDICT, Column, Picture, Points, Section, SectionPart, Table, Text, span

PAIRS = range(12, 2, -1)  # how many pairs the page lists, as many as fit; the report of each job has them all
LEFT = 6  # most pairs that it names as still to be repaired
_BARS = 2  # most conditions in the picture
_MOVED = 5e3  # [Pa] that a pressure must have moved to be named to a customer: choice of this project


def write_comparison_pdf(
    comparison: Comparison,
    before: Job,
    after: Job,
    *,
    language: str = "en",
    paper: str = DEFAULT_PAPER,
    units: str = "metric",
    font: OwnFont | None = None,
) -> bytes:
    """Return the bytes of the page for the customer.

    Parameters
    ----------
    before, after
        their records: whose car it is, and which repairs are noted as done.
    language, paper, units, font
        as `atleak.report.pdf.write_pdf` takes them.

    Raises
    ------
    InputError
        an unknown language or paper, or a logo that cannot be read.

    Notes
    -----
    Tagged and archival as the report is (`atleak.report.pdf.write_pdf`). One page: as many of the flagged pairs are
    listed as fit, the worst before first.
    """
    say = wording(language, units)
    page = _Page(comparison, before, after, say)
    head = after if not after.workshop.empty else before
    data = {
        "facts": page.facts(),
        "sides": page.sides(),
        "lengths": len(page.lengths),
        "sections": [*page.sections()],
    }
    words = say("comparison.title"), say("comparison.subject")
    return write_page(
        "comparison", words, head, paper, say, lambda _: data, pictured=head.letterhead, date=after.date, font=font
    )


class _Page:
    """The content of the page, in one language."""

    def __init__(self, comparison: Comparison, before: Job, after: Job, say: Wording) -> None:
        self.comparison, self.jobs, self.say = comparison, (before, after), say
        self.diagnoses = comparison.before, comparison.after
        flagged = len(comparison.flagged)
        self.lengths = sorted({min(length, flagged) for length in PAIRS}, reverse=True)
        reported = [at.condition.name for at in (*comparison.before.reported, *comparison.after.reported)]
        self.shown = [each for each in comparison.on_both_sides if each is comparison.leading or each.name in reported][
            :_BARS
        ]

    def facts(self) -> list[list[str]]:
        """Return whose car it is, of which unit, and when the two visits were; what nobody filled in is left out."""
        say, (before, after) = self.say, self.jobs

        def either(path: str) -> str:
            return next((str(value) for job in (after, before) if (value := attrgetter(path)(job))), "")

        facts = {
            "customer": either("customer.name"),
            "vehicle": joined(map(either, ("vehicle.make", "vehicle.model", "vehicle.year")), " "),
            "registration": either("vehicle.registration"),
            "vin": either("vehicle.vin"),
            "transmission": joined(map(either, ("transmission.maker", "transmission.code")), " "),
            "serial": either("transmission.serial"),
            "controller": say.name(self.comparison.after.controller.name),
        }
        rows: list[list[str]] = [[say(f"facts.{key}"), value] for key, value in facts.items() if value]
        visits = map(self._visit, self.jobs, self.diagnoses)
        return rows + [[say(f"comparison.{side}"), visit] for side, visit in zip(SIDES, visits, strict=True) if visit]

    def _visit(self, job: Job, diagnosis: Diagnosis) -> str:
        mileage, say = job.mileage_or(diagnosis.mileage), self.say
        at = "" if mileage is None else say("texts.mileage", value=say.value(mileage, "distance", 0))
        return joined((job.number, say.date(job.date) if job.date else "", at))

    def sides(self) -> list[dict[str, str]]:
        """Return both verdicts, each with what was or is past a limit."""
        return [
            {
                "key": diagnosis.verdict,
                "name": self.say(f"comparison.{side}"),
                "word": self.say.level(diagnosis.verdict).capitalize(),
                "sentence": self.say(
                    "comparison.past" if diagnosis.judged else "comparison.past_unmeasured",
                    flagged=len(diagnosis.flagged),
                    measured=diagnosis.judged,
                ),
            }
            for side, diagnosis in zip(SIDES, self.diagnoses, strict=True)
        ]

    def sections(self) -> Iterator[dict[str, Any]]:
        """Yield the sections in their order; of the pairs one for each length that the table may have."""

        def draw(picture: Picture) -> str:
            return drawn_on_paper(picture.chart, self.say)

        for name in ("wrong", "done", "result", "pairs", "totals", "know"):
            parts: Callable[..., Iterator[SectionPart]] = getattr(self, f"_{name}")
            every = [parts(length) for length in self.lengths] if name == "pairs" else [parts()]
            made = [
                section_blocks(Section(name, self.say(f"comparison.{name}"), tuple(each)), draw, self.say)
                for each in every
            ]
            if made[0]["blocks"]:
                yield made[0] if len(made) == 1 else {"lengths": made}
        before, after = self.jobs
        people = {
            "technician": after.technician or before.technician,
            "customer": after.customer.name or before.customer.name,
        }
        yield {"title": "", "blocks": [signatures(people.items(), self.say)]}

    # --- in plain words

    def _wrong(self) -> Iterator[SectionPart]:
        diagnosis, say, flagged = self.comparison.before, self.say, self.comparison.before.flagged
        complaint = joined(dict.fromkeys(job.complaint.rstrip(" .") for job in self.jobs if job.complaint), " · ")
        said = [say("comparison.wrong_complaint", complaint=complaint)] if complaint else []
        if not diagnosis.judged:
            said.append(say("comparison.wrong_unmeasured"))
        elif flagged:
            repair = sum(land.verdict.calls_for_repair for land in flagged)
            counts = {"measured": diagnosis.judged, "repair": repair, "watch": len(flagged) - repair}
            said.append(f"{say('customer.seal')} {say('comparison.wrong_lands', **counts)}")
        else:
            said.append(say("comparison.wrong_none", measured=diagnosis.judged))
        said += filter(None, [measured_sentence(diagnosis, say), self._leading("wrong_total")])
        yield Text(" ".join(said))

    def _leading(self, key: str) -> str | None:
        """Say what the total was where it was worst before, and is; None where no total can be compared."""
        leading, say = self.comparison.leading, self.say
        if leading is None or leading.before is None or leading.share is None:
            return None
        before = say.percent(leading.share.before)
        return say(
            f"comparison.{key}",
            condition=say.condition(leading.before.condition),
            share=before,
            before=before,
            new=say.percent(self.comparison.before.new_at(leading.before).share),
            after=say.percent(leading.share.after),
            how=how_sure(leading.share, say),
        )

    def _done(self) -> Iterator[SectionPart]:
        """Yield the work that is noted as done, each kind with its pairs, and below what was not."""
        say = self.say
        latest = {(each.component, each.land, each.work): each for job in self.jobs for each in job.repair_decisions}
        decisions = latest.values()  # of those of both records on one pair and work the later record's counts
        works: dict[str, list[str]] = defaultdict(list)
        for each in decisions:
            if each.decision == "done":
                works[each.work or each.repair or say("estimate.as_new")].append(self._of(each))
        items = [say("comparison.done_item", work=work, pairs=joined(pairs, "; ")) for work, pairs in works.items()]
        yield Points(items) if items else Text(say("comparison.done_none"))
        controller = self.comparison.after.controller
        noted = frozenset[LandKey]().union(
            *(covered(each, controller) for each in decisions if each.decision == "done")
        )
        tighter = (
            self._named(*each.key)
            for each in self.comparison.changed
            if each.change is not None and each.change.value < 0.0 and each.key not in noted
        )
        if pairs := joined(tighter, "; "):
            yield Text(say("comparison.done_measured", pairs=pairs))
        left = [each for each in decisions if each.decision in ("declined", "deferred")]
        if left:
            refused = (
                say(
                    "comparison.not_done_item",
                    work=joined((self._of(each), each.work), ": "),
                    decision=joined((say.get("job_decisions", each.decision or ""), each.reason), ": "),
                )
                for each in left
            )
            yield Text(say("comparison.not_done", items=joined(refused, "; ")), small=True)

    def _of(self, decision: RepairDecision) -> str:
        """Name the pair that a decision is about, or the components that a kit mends."""
        controller = self.comparison.after.controller
        components = components_of(decision, controller)
        if is_whole_body(controller, components):
            return self.say("plan.whole_body")
        land = decision.land if len(components) == 1 else None
        return joined(self._named(each, land) for each in components)

    def _named(self, component: str, land: int | None) -> str:
        """Name a pair as a customer reads it: by its name, with its number only where several bear that name."""
        names = self.comparison.after.controller.components
        name = names.get(component, component)
        said = isolated(self.say.name(name))
        called = f"{component} {said}" if list(names.values()).count(name) > 1 else said
        several = sum(each.key[0] == component for each in self.comparison.lands) > 1
        return self.say("comparison.land", name=called, land=land) if land and several else called

    def _result(self) -> Iterator[SectionPart]:
        comparison, say, after = self.comparison, self.say, self.comparison.after
        key = "unmeasured" if not after.judged else "lands" if after.flagged else "ok"
        changed, compared = len(comparison.changed), len(comparison.compared)
        said = (
            say(f"comparison.result_{key}", flagged=len(after.flagged), measured=after.judged),
            measured_sentence(after, say),
            self._still_to_repair(),
            say("comparison.result_changed", changed=changed, compared=compared) if compared else None,
            self._leading("result_total"),
            self._pressure(),
        )
        yield Text(" ".join(filter(None, said)))

    def _still_to_repair(self) -> str | None:
        """Name the pairs that are to be repaired still, the costliest first; None where there are none."""
        after = self.comparison.after
        left = [land for land in after.flagged if after.urgency_of(land).calls_for_repair]
        if not left:
            return None
        names = joined((self._named(*land.key) for land in left[:LEFT]), "; ")
        more = [self.say("comparison.more", count=len(left) - LEFT)] if len(left) > LEFT else []
        return " ".join([self.say("comparison.result_left", pairs=names), *more])

    def _pressure(self) -> str | None:
        """Say which pressure moved most and beyond its uncertainty; None where none did."""
        moved = [
            (abs(change.value), name, change, each.before)
            for each in self.comparison.on_both_sides
            for name, change in (
                (self.say("held.line"), each.main_pressure),
                *((self.say.name(one.circuit.name), one.change) for one in each.circuits),
            )
            if change is not None and change.significant and abs(change.value) >= _MOVED and each.before is not None
        ]
        if not moved:
            return None
        _, name, change, at = max(moved, key=lambda each: each[0])
        return self.say(
            "comparison.pressures",
            name=name,
            before=self.say.value(change.before * KPA, "pressure", 0),
            after=self.say.value(change.after * KPA, "pressure", 0),
            condition=self.say.condition(at.condition),
            how=how_sure(change, self.say),
        )

    # --- in numbers

    def _pairs(self, length: int) -> Iterator[SectionPart]:
        say, flagged = self.say, self.comparison.flagged
        if not flagged:
            yield Text(say("comparison.pairs_none"))
            return

        def clearance(side: str, compared: LandComparison) -> float | None:
            land: LandDiagnosis | None = getattr(compared, side)
            return land.state.radial_clearance if land and land.state.measured else None

        def verdict(side: str, compared: LandComparison) -> Verdict | None:
            land: LandDiagnosis | None = getattr(compared, side)
            return None if land is None else land.verdict

        columns = (
            Column("pair", width=50, of=lambda land: self._named(*land.key)),
            Column("comparison.new", words_of="clearance", of=self._mounting),
            *(
                Column(
                    "", "clearance", words=say(f"comparison.clearance_{side}"), of=partial(clearance, side), times=UM
                )
                for side in SIDES
            ),
            Column("comparison.change", words_of="clearance", of=self._change),
            *(
                Column("", VERDICT, words=say(f"comparison.verdict_{side}"), of=partial(verdict, side))
                for side in SIDES
            ),
        )
        yield Table("pairs", columns, flagged[:length], say)
        more = say("comparison.more", count=len(flagged) - length) if length < len(flagged) else ""
        yield Text(f"{more} {say('comparison.pairs_note')}".strip(), small=True)

    def _mounting(self, land: LandComparison) -> str:
        newest = land.after or land.before
        assert newest is not None
        return span((end * UM for end in newest.state.land.mounting_ends), "clearance", self.say)

    def _change(self, land: LandComparison) -> str:
        if land.change is not None and not land.significant:
            return self.say("comparison.uncertain")
        return with_uncertainty(land.change, self.say)

    def _totals(self) -> Iterator[SectionPart]:
        yield from total_picture(self.comparison, self.shown, self.say)

    # --- below

    def _know(self) -> Iterator[SectionPart]:
        say, comparison = self.say, self.comparison
        known = [*filter(None, [differing_sentence(comparison, say), *visit_caveats(comparison, say)])]
        if known:
            yield Points(known)
