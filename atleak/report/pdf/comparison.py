"""Print two visits of one unit as a page for the customer: what was wrong, what was done, what it brought."""

from __future__ import annotations

import tempfile
from collections import defaultdict
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from atleak.comparison import Comparison, ConditionComparison, LandComparison
from atleak.diagnosis import Diagnosis
from atleak.engine.projection import Projection
from atleak.job.record import Job, RepairDecision
from atleak.land_diagnosis import LandDiagnosis
from atleak.paper import DEFAULT_PAPER, find_paper
from atleak.report.own_font import OwnFont
from atleak.report.pdf.blocks import Block, PrintedColumn, joined, table, text
from atleak.report.pdf.compiling import common_data, compile_pdf
from atleak.report.pictures import write_pictures
from atleak.report.printed_charts import TwoBars, two_visits_chart
from atleak.verdicts import Band
from atleak.views.comparison_words import differing_sentence, how_sure, visit_caveats, with_uncertainty
from atleak.views.measured_words import measured_sentence
from atleak.wording import Wording, isolated, wording
from atleak.workshop_units import KPA, PERCENT, UM

PAIRS = range(12, 2, -1)  # how many pairs the page lists, as many as fit; the report of each job has them all
LEFT = 6  # most pairs that it names as still to be repaired
BARS = 2  # most conditions in the picture
_CHART = "totals"
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
    comparison
        of the two jobs.
    before, after
        their records: whose car it is, and which repairs are noted as done.
    language
        one of `atleak.wording.languages`.
    paper
        one of `atleak.paper.PAPERS`.
    units
        one of `atleak.unit_systems.SYSTEMS`.
    font
        for characters that the bundled fonts lack.

    Raises
    ------
    InputError
        an unknown language or paper, or a logo that cannot be read.

    Notes
    -----
    Tagged and archival as the report is (`atleak.report.pdf.write_pdf`). One page: as many of the flagged pairs are
    listed as fit, the worst before first.
    """
    say, size = wording(language, units), find_paper(paper)
    page = _Page(comparison, before, after, say)
    with tempfile.TemporaryDirectory(prefix="atleak-", ignore_cleanup_errors=True) as folder:
        letterhead = after if not after.workshop.empty else before
        pictures = write_pictures(letterhead.letterhead, Path(folder))
        data = {
            **common_data(say("comparison.title"), say("comparison.subject"), letterhead, size, say, pictures),
            "facts": page.facts(),
            "sides": page.sides(),
            "lengths": len(page.lengths),
            "sections": [section for section in page.sections() if section["blocks"]],
            "charts": page.charts(),
        }
        return compile_pdf("comparison", Path(folder), data, after.date, say, font)


class _Page:
    """The content of the page, in one language."""

    def __init__(self, comparison: Comparison, before: Job, after: Job, say: Wording) -> None:
        self.comparison, self.jobs, self.say = comparison, (before, after), say
        self.diagnoses = comparison.before, comparison.after
        flagged = len(comparison.flagged)
        self.lengths = sorted({min(length, flagged) for length in PAIRS}, reverse=True)
        reported = [at.condition.name for at in (*comparison.before.reported, *comparison.after.reported)]
        self.shown = [each for each in comparison.on_both_sides if each is comparison.leading or each.name in reported][
            :BARS
        ]

    def facts(self) -> list[list[str]]:
        """Return whose car it is, of which unit, and when the two visits were; what nobody filled in is left out."""
        say, (before, after) = self.say, self.jobs

        def either(*path: str) -> str:
            for job in (after, before):
                value: Any = job
                for name in path:
                    value = getattr(value, name)
                if value:
                    return str(value)
            return ""

        rows = [
            ("customer", either("customer", "name")),
            ("vehicle", joined([either("vehicle", name) for name in ("make", "model", "year")], " ")),
            ("registration", either("vehicle", "registration")),
            ("vin", either("vehicle", "vin")),
            ("transmission", joined([either("transmission", name) for name in ("maker", "code")], " ")),
            ("serial", either("transmission", "serial")),
            ("controller", say.name(self.comparison.after.controller.name)),
        ]
        visits = [[say(f"comparison.{side}"), self._visit(number)] for number, side in enumerate(("before", "after"))]
        return [[say(f"facts.{name}"), value] for name, value in rows if value] + [row for row in visits if row[1]]

    def _visit(self, number: int) -> str:
        job = self.jobs[number]
        mileage = job.mileage_or(self.diagnoses[number].mileage)
        return joined(
            (
                job.number,
                self.say.date(job.date) if job.date else "",
                "" if mileage is None else self.say("texts.mileage", value=self.say.value(mileage, "distance", 0)),
            )
        )

    def sides(self) -> list[dict[str, str]]:
        """Return both verdicts, each with what was or is past a limit."""
        return [
            {
                "key": diagnosis.verdict,
                "name": self.say(f"comparison.{side}"),
                "word": self.say.level(diagnosis.verdict).capitalize(),
                "sentence": self._past(diagnosis),
            }
            for side, diagnosis in zip(("before", "after"), self.diagnoses, strict=True)
        ]

    def _past(self, diagnosis: Diagnosis) -> str:
        if not diagnosis.judged:
            return self.say("comparison.past_unmeasured")
        return self.say("comparison.past", flagged=len(diagnosis.flagged), measured=diagnosis.judged)

    def sections(self) -> Iterable[dict[str, Any]]:
        """Yield the sections in their order; one without anything to say has no blocks."""
        for name, blocks in (
            ("wrong", self._wrong()),
            ("done", self._done()),
            ("result", self._result()),
            ("pairs", self._pairs()),
            ("totals", self._totals()),
            ("know", self._know()),
        ):
            yield {"title": self.say(f"comparison.{name}"), "blocks": [block for block in blocks if block]}
        yield {"title": "", "blocks": [self._signatures()]}

    # --- in plain words

    def _wrong(self) -> Iterable[Block]:
        diagnosis, say = self.comparison.before, self.say
        complaint = joined(dict.fromkeys(job.complaint for job in self.jobs if job.complaint), " · ")
        said = [say("comparison.wrong_complaint", complaint=complaint)] if complaint else []
        if not diagnosis.judged:
            said.append(say("comparison.wrong_unmeasured"))
        elif diagnosis.flagged:
            repair = sum(land.verdict.calls_for_repair for land in diagnosis.flagged)
            watch = len(diagnosis.flagged) - repair
            counted = say("comparison.wrong_lands", measured=diagnosis.judged, repair=repair, watch=watch)
            said.append(f"{say('customer.seal')} {counted}")
        else:
            said.append(say("comparison.wrong_none", measured=diagnosis.judged))
        said += filter(None, [measured_sentence(diagnosis, say)])
        leading = self.comparison.leading
        if leading is not None and leading.before is not None and leading.share is not None:
            said.append(
                say(
                    "comparison.wrong_total",
                    condition=say.condition(leading.before.condition),
                    share=say.percent(leading.share.before),
                    new=say.percent(diagnosis.new_at(leading.before).share),
                )
            )
        yield text(" ".join(said))

    def _done(self) -> Iterable[Block]:
        """Yield the work that is noted as done, each kind with its pairs, and below what was not."""
        say, decisions = self.say, self._decisions()
        works: dict[str, list[str]] = defaultdict(list)
        for each in decisions:
            if each.decision == "done":
                works[each.work or each.repair or say("estimate.as_new")].append(self._named(each.component, each.land))
        if works:
            items = [say("comparison.done_item", work=work, pairs=joined(pairs, "; ")) for work, pairs in works.items()]
            yield {"kind": "list", "items": items}
        else:
            yield text(say("comparison.done_none"))
        left = [each for each in decisions if each.decision in ("declined", "deferred")]
        if left:
            yield text(say("comparison.not_done", items=joined(map(self._left, left), "; ")), small=True)

    def _decisions(self) -> list[RepairDecision]:
        """Return the decisions of both records; of those on one pair and work the later record's counts."""
        latest = {(each.component, each.land, each.work): each for job in self.jobs for each in job.repair_decisions}
        return list(latest.values())

    def _named(self, component: str, land: int | None) -> str:
        """Name a pair as a customer reads it: by its name, with its number only where several bear that name."""
        names = self.comparison.after.controller.components
        name = names.get(component, component)
        said = isolated(self.say.name(name))
        called = f"{component} {said}" if list(names.values()).count(name) > 1 else said
        several = sum(each.key[0] == component for each in self.comparison.lands) > 1
        return self.say("comparison.land", name=called, land=land) if land and several else called

    def _left(self, decision: RepairDecision) -> str:
        how = joined((self.say.get("job_decisions", decision.decision or ""), decision.reason), ": ")
        said = joined((self._named(decision.component, decision.land), decision.work), ": ")
        return self.say("comparison.not_done_item", work=said, decision=how)

    def _result(self) -> Iterable[Block]:
        comparison, say = self.comparison, self.say
        after = comparison.after
        if not after.judged:
            said = [say("comparison.result_unmeasured")]
        elif after.flagged:
            said = [say("comparison.result_lands", flagged=len(after.flagged), measured=after.judged)]
        else:
            said = [say("comparison.result_ok", measured=after.judged)]
        said += filter(None, [measured_sentence(after, say), self._still_to_repair()])
        changed, compared = len(comparison.changed), len(comparison.compared)
        if compared:
            said.append(say("comparison.result_changed", changed=changed, compared=compared))
        leading = comparison.leading
        if leading is not None and leading.before is not None and leading.share is not None:
            said.append(
                say(
                    "comparison.result_total",
                    condition=say.condition(leading.before.condition),
                    before=say.percent(leading.share.before),
                    after=say.percent(leading.share.after),
                    how=how_sure(leading.share, say),
                )
            )
        said += filter(None, [self._pressure()])
        yield text(" ".join(said))

    def _still_to_repair(self) -> str | None:
        """Name the pairs that are to be repaired still, the costliest first; None where there are none."""
        left = [land for land in self.comparison.after.flagged if land.verdict.calls_for_repair]
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

    def _pairs(self) -> Iterable[Block]:
        say, flagged = self.say, self.comparison.flagged
        if not flagged:
            yield text(say("comparison.pairs_none"))
            return
        sides = ("before", "after")
        columns = [
            PrintedColumn(say("printed.pair"), lambda land: self._named(*land.key), width=1),
            PrintedColumn(say("comparison.new"), self._mounting, say.unit("clearance"), side="r"),
            *(
                PrintedColumn(
                    say(f"comparison.clearance_{side}"), partial(self._clearance, side), say.unit("clearance"), side="r"
                )
                for side in sides
            ),
            PrintedColumn(say("comparison.change"), self._change, say.unit("clearance"), side="r"),
            *(PrintedColumn(say(f"comparison.verdict_{side}"), partial(self._verdict, side)) for side in sides),
        ]
        yield {"shortened": [table(columns, flagged[:length]) for length in self.lengths]}
        notes = [self._pairs_note(len(flagged) - length) for length in self.lengths]
        yield {"shortened": [text(note, small=True) for note in notes]}

    def _pairs_note(self, more: int) -> str:
        left = [self.say("comparison.more", count=more)] if more > 0 else []
        return " ".join([*left, self.say("comparison.pairs_note")])

    def _mounting(self, land: LandComparison) -> str:
        newest = land.after or land.before
        assert newest is not None
        return "–".join(self.say.value(end * UM, "clearance", 1) for end in newest.state.land.mounting_ends)

    def _clearance(self, side: str, compared: LandComparison) -> str:
        land: LandDiagnosis | None = getattr(compared, side)
        value = land.state.radial_clearance * UM if land and land.state.measured else None
        return self.say.value(value, "clearance", 1)

    def _change(self, land: LandComparison) -> str:
        if land.change is not None and not land.significant:
            return self.say("comparison.uncertain")
        return with_uncertainty(land.change, self.say)

    def _verdict(self, side: str, compared: LandComparison) -> dict[str, str] | str:
        land: LandDiagnosis | None = getattr(compared, side)
        return "–" if land is None else {"sign": land.verdict, "text": self.say.level(land.verdict)}

    def _totals(self) -> Iterable[Block]:
        rows = self._bars()
        if not rows:
            return
        said = " ".join(
            self.say(
                "comparison.chart_condition",
                condition=row.label,
                before=self.say.percent(row.shares[0] / PERCENT),
                after=self.say.percent(row.shares[1] / PERCENT),
            )
            for row in rows
        )
        alt = self.say("comparison.chart_alt", conditions=said)
        yield {"kind": "image", "file": _CHART, "alt": alt, "caption": self.say("comparison.caption")}

    def charts(self) -> dict[str, str]:
        """Return the picture of the totals as SVG."""
        rows = self._bars()
        return {_CHART: two_visits_chart(rows, self.say("comparison.axis"), self.say)} if rows else {}

    def _bars(self) -> list[TwoBars]:
        return [bars for each in self.shown if (bars := self._two_bars(each)) is not None]

    def _two_bars(self, each: ConditionComparison) -> TwoBars | None:
        comparison = self.comparison
        if each.before is None or each.alike is None or each.share is None:
            return None
        before, after = (comparison.before, each.before), (comparison.alike, each.alike)
        return TwoBars(
            label=self.say.condition(each.before.condition),
            shares=(each.share.before * PERCENT, each.share.after * PERCENT),
            verdicts=(_band(*before).verdict, _band(*after).verdict),
            intervals=(_interval(*before), _interval(*after)),
            new=comparison.before.new_at(each.before).share * PERCENT,
            levels=tuple(
                (Band(name), limit * PERCENT) for name, limit in comparison.before.total_rule(each.before).steps.levels
            ),
        )

    # --- below

    def _know(self) -> Iterable[Block]:
        say, comparison = self.say, self.comparison
        said: Sequence[str | None] = [differing_sentence(comparison, say), *visit_caveats(comparison, say)]
        items = [each for each in said if each is not None]
        if items:
            yield {"kind": "list", "items": items}

    def _signatures(self) -> Block:
        say, (before, after) = self.say, self.jobs
        return {
            "kind": "signatures",
            "room": 9,  # [mm]
            "line": say("texts.sign_place"),
            "people": [
                [say("texts.sign_technician"), after.technician or before.technician],
                [say("texts.sign_customer"), after.customer.name or before.customer.name],
            ],
        }


def _band(diagnosis: Diagnosis, at: Projection) -> Band:
    return diagnosis.band(at) or Band.GREEN


def _interval(diagnosis: Diagnosis, at: Projection) -> tuple[float, float] | None:
    total = diagnosis.uncertainty.total(at.condition.name) if diagnosis.uncertainty else None
    return None if total is None else (total.share_interval[0] * PERCENT, total.share_interval[1] * PERCENT)
