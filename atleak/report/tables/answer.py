"""Say the answer in three lines: what is wrong, what to do, how sure that is; and record it for scripts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from atleak.analysis.answer import Answer, answer_of
from atleak.analysis.repair.plan import PumpStep, RepairStep
from atleak.catalogue.repairs import LandKey
from atleak.common.units import DM3_MIN, KPA
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording, begun
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.missing import Cause, Missing, Row
from atleak.engine.operation import LINE
from atleak.report.tables.first_sentence import impossible_part, worn_pump
from atleak.report.tables.repairs import price_and_hours, repair_name, step_in_words
from atleak.report.tables.sentences import land_in_words
from atleak.report.tables.table import Column, Facts, Table

_NAMED, _WORTH = 2, 0.1  # lands that the answer names, and what each explains of the whole at least
_ALL = 0.99  # of what is missing, from which on all of it counts as explained
_STEPS = 2  # of the plan that the answer names
_NOTHING = 1.0  # [kPa] that nobody reads off a gauge
_SURELY = 0.99  # probability above which no more is said than that


class AnswerLines(NamedTuple):
    """What people read first."""

    wrong: str
    do: str
    sure: str


def answer_lines(answer: Answer, say: Wording, *, whole: bool = True) -> AnswerLines:
    """Return an answer as three lines, or the first sentence of each."""
    words = _Words(answer, say)
    last = None if whole else 1
    return AnswerLines(*(" ".join([*part][:last]) for part in (words.wrong(), words.do(), words.sure())))


def how_sure(answer: Answer, say: Wording) -> str:
    """Return the first sentence of the third line alone."""
    return next(iter(_Words(answer, say).sure()), "")


def answer_facts(diagnosis: Diagnosis, say: Wording, *, whole: bool = True) -> Facts:
    """Return the three lines with what each says before it."""
    lines = answer_lines(answer_of(diagnosis), say, whole=whole)._asdict()
    return Facts([(say(f"answer.{name}"), said) for name, said in lines.items()])


def missing_table(diagnosis: Diagnosis, say: Wording) -> Table:
    """Return a row for every measured pressure past a limit: what is missing of it, and what each cause explains."""
    words = _Words(answer_of(diagnosis), say)

    def amount(of: Callable[[Missing], Any]) -> Callable[[Missing], str | None]:
        def said(missing: Missing) -> str | None:
            ends = [say.value(each * KPA, "pressure", 0) for each in missing.amount(of) if each is not None]
            if {end.lstrip("-−") for end in ends} <= {"0"}:
                return None
            return ends[0] if len(ends) == 1 else say("answer.between", value=ends[0], low=ends[1], high=ends[2])

        return said

    def tap(missing: Missing) -> str:
        return say("answer.line") if missing.tap == LINE else words.circuit(missing.tap)

    columns = (
        Column("condition", words=begun(say("printed.condition")), width=200, of=words.where),
        Column("tap", width=130, of=tap),
        Column("measured", "pressure", 0, words=say("answer.measured"), times=KPA),
        Column(
            "as_new", "pressure", 0, words=say("answer.as_new_held"), of=lambda each: each.split.new.mean(), times=KPA
        ),
        Column("missing", words=say("answer.missing"), words_of="pressure", of=amount(lambda each: each.missing)),
        *(
            Column(f"of_{cause}", words=say(f"answer.by_{cause}"), words_of="pressure", of=amount(partial(_of, cause)))
            for cause in Cause
            if cause is not Cause.NONE
        ),
    )
    return Table("missing", columns, diagnosis.missing_flagged, say, title=say("answer.split")).filled


def _of(cause: Cause, missing: Missing) -> np.ndarray:
    return missing.of(cause)


class _Words:
    def __init__(self, answer: Answer, say: Wording) -> None:
        self.answer, self.say, self.diagnosis = answer, say, answer.diagnosis

    @property
    def _within(self) -> str:
        """Return the name of what is said where no limit is passed."""
        diagnosis = self.diagnosis
        if diagnosis.too_tight:
            return "tight"
        if diagnosis.verdict is Verdict.NOT_MEASURED:
            return "flows" if diagnosis.flows else "not_measured"
        if diagnosis.vacuum_rules:
            return "vacuum"
        return "passed" if diagnosis.passed and not diagnosis.without_sheet else "so_far"

    def wrong(self) -> Iterator[str]:
        answer, say = self.answer, self.say
        if self.diagnosis.impossible:
            yield f"{begun(impossible_part(self.diagnosis, say))}."
        elif answer.cause is Cause.NONE:
            yield say(f"answer.wrong_{self._within}")
        elif answer.missing is None:
            yield say("answer.not_split")
        else:
            yield from self._by_flow() if answer.by_flow else self._by_pressure(answer.missing)

    def _by_pressure(self, missing: Missing) -> Iterator[str]:
        answer, say = self.answer, self.say
        words = {
            "total": self._amount(lambda each: each.missing, ends=False),
            "tap": say("answer.line") if missing.tap == LINE else self.circuit(missing.tap),
            "where": self.where(missing),
        }
        if missing.doubted:
            yield say("answer.lead_doubted", **words)
            return
        if answer.cause is not Cause.UNEXPLAINED:
            assert answer.row is not None
            explained, total = (missing.amount(of).value for of in (self._of_named, answer.total_in))
            key = "answer.lead_all" if explained >= _ALL * total else "answer.lead"
            what = self._what(answer.row)
            if answer.also:
                what = say("answer.or", what=what, others=self._others())
            yield say(key, what=begun(what), amount=self._amount(self._of_named), **words)
        elif Cause.PUMP in answer.also:
            yield say("answer.lead_open", **words)
        else:
            amount = self._amount(lambda each: each.unexplained)
            yield say("answer.lead_unexplained", amount=amount, **words)
        if answer.cause not in (Cause.LANDS, Cause.LINE_SETTING) and self.diagnosis.judged:
            yield say("answer.bores", amount=self._amount(self._of_measured))
        left = missing.amount(lambda each: -each.unexplained)
        if missing.measured is not None and left.low is not None and left.low > 0.0:
            yield say("answer.against", amount=self._amount(lambda each: -each.unexplained))

    def _of_measured(self, missing: Missing) -> np.ndarray:
        """Return what the lands that were measured explain."""
        judged = {land.key for land in self.diagnosis.lands if land.state.judged}
        lands = (each for of_row in missing.split.lands.values() for each in of_row.items())
        return np.asarray(sum((values for key, values in lands if key in judged), np.zeros_like(missing.missing)))

    def _by_flow(self) -> Iterator[str]:
        answer, say = self.answer, self.say
        assert answer.missing is not None
        pump = worn_pump(self.diagnosis, say)
        if pump is not None and answer.cause is not Cause.PUMP:
            yield pump
            return
        if self.diagnosis.profile.circuits != "on":
            held = say("answer.pressures_given")
        else:
            lost = answer.missing.amount(lambda each: each.missing).value * KPA
            held = say("answer.no_pressure_lost" if lost < _NOTHING else "answer.no_limit_passed")
        if answer.row is None or float(np.mean(answer.total)) <= 0.0:
            yield f"{held} {say('answer.no_growth')}"
            names = ", ".join(land_in_words(self.diagnosis, each.key, say) for each in self.diagnosis.flagged[:_NAMED])
            if names:
                yield say("answer.by_wear", lands=begun(names))
            return
        explained, total = (answer.missing.amount(of).value for of in (self._of_named, answer.total_in))
        grown = say(
            "answer.growth_all" if explained >= _ALL * total else "answer.growth",
            what=begun(self._what(answer.row)),
            amount=self._amount(self._of_named),
            total=self._amount(answer.total_in),
            where=self.where(answer.missing),
        )
        yield f"{held} {grown}"

    def where(self, missing: Missing) -> str:
        say, point = self.say, missing.point
        filed = next((each for each in self.diagnosis.controller.operating_points if each.name == point.name), point)
        if missing.seconds is None:
            return say.condition(filed)
        temperature = say.quantity(point.temperature, "temperature", 0)
        return say("answer.in_log", condition=say.condition(filed), temperature=temperature)

    def circuit(self, id_: str) -> str:
        return self.say.name(next(each.name for each in self.diagnosis.controller.circuits if each.id == id_))

    def _of_named(self, missing: Missing) -> np.ndarray:
        """Return what the lands that are named explain together; of a cause that is no lands its row."""
        row, of = self.answer.row, Missing.flow_of if self.answer.by_flow else Missing.of_row
        assert row is not None
        parts = self._named(row) if self._names_lands(row) else (None,)
        return np.asarray(sum((of(missing, row, part) for part in parts), np.zeros_like(missing.missing)))

    def _names_lands(self, row: Row) -> bool:
        """Tell whether it is lands that are named; what a line is set to has not fallen where no pressure is lost."""
        return row[0] is Cause.LANDS or (self.answer.by_flow and row[0] is Cause.LINE_SETTING)

    def _named(self, row: Row) -> tuple[LandKey, ...]:
        """Return the lands of a row that are named, those that explain most; none of the pump's."""
        least = _WORTH * float(np.mean(self.answer.total))
        lands = self.answer.lands_of(row)
        return tuple(key for key, each in lands.items() if float(np.mean(each)) >= least)[:_NAMED] or (*lands,)[:1]

    def _lands(self, row: Row) -> str:
        return ", ".join(land_in_words(self.diagnosis, key, self.say) for key in self._named(row))

    def _what(self, row: Row) -> str:
        say, (cause, circuit) = self.say, row
        if cause is Cause.PUMP:
            return say("answer.pump_or_feed" if self.diagnosis.model.pump_open else "answer.pump")
        lands = self._lands(row)
        name = "" if circuit is None else self.circuit(circuit)
        return say("answer.lands" if self._names_lands(row) else f"answer.{cause}", lands=lands, circuit=name)

    def _amount(self, of: Callable[[Missing], Any], *, ends: bool = True) -> str:
        say, by_flow, missing = self.say, self.answer.by_flow, self.answer.missing
        assert missing is not None
        kind, factor, digits = ("flow", DM3_MIN, 2) if by_flow else ("pressure", KPA, 0)
        value, low, high = missing.amount(of)
        shown = say.quantity(value * factor, kind, digits)
        if not ends or low is None or high is None:
            return shown
        both = (say.value(end * factor, kind, digits) for end in (low, high))
        return say("answer.between", value=shown, low=next(both), high=next(both))

    def _others(self) -> str:
        return self.say("answer.either").join(map(self._in_words, self.answer.also))

    def _in_words(self, cause: Cause) -> str:
        lands = self._names_lands((cause, None))
        return self.say("answer.or_lands" if lands else f"answer.or_{cause}")

    def do(self) -> Iterator[str]:
        answer, say = self.answer, self.say
        if self.diagnosis.impossible:
            yield say("answer.describe")
        elif answer.cause is Cause.NONE:
            yield say(f"answer.do_{self._within}")
        elif answer.cause is Cause.PUMP:
            yield self._open_pump() if self.diagnosis.model.pump_open else say("answer.pump_first")
            if any(step.chosen for step in answer.steps):
                yield self._steps()
        elif answer.cause is Cause.CLUTCH_SEAL:
            key = "answer.air_check_measure" if Cause.LANDS in answer.also else "answer.air_check"
            yield say(key, circuit=self.circuit(answer.circuit or ""))
        elif answer.missing is not None and answer.missing.doubted:
            yield say("answer.read_again")
        elif answer.cause is Cause.UNEXPLAINED:
            yield self._open_pump() if Cause.PUMP in answer.also else self._look_for()
        else:
            yield self._steps() if answer.steps else say("answer.can_wait") if answer.by_flow else self._unplanned()

    def _unplanned(self) -> str:
        """Say what to do about lands that no plan repairs: by a gauge alone they cost pressure."""
        assert self.answer.row is not None
        lands = self._lands(self.answer.row)
        if self.diagnosis.open_lands.intersection(self._named(self.answer.row)):
            return self.say("answer.measure_lands", lands=lands)
        return f"{begun(self.say('answer.repair', what=lands, repair=self.say('answer.as_new')))}."

    def _look_for(self) -> str:
        """Say where to look for what no part explains: in the circuit itself where the line beside it was read."""
        missing, measured = self.answer.missing, self.diagnosis.missing_measured
        if (
            missing is None
            or missing.tap == LINE
            or (missing.point, LINE) not in {(at.point, at.tap) for at in measured}
        ):
            return self.say("answer.look_for")
        return self.say("answer.look_in_circuit", circuit=self.circuit(missing.tap))

    def _open_pump(self) -> str:
        """Say what to do about a pump whose clearances were not measured, or count for nothing in the file."""
        measured = self.diagnosis.controller.pump.measured.any_known
        return self.say("answer.look_for" if measured else "answer.measure_pump")

    def _steps(self) -> str:
        every, cost = self.answer.steps, price_and_hours(self.answer.cost, self.say)
        steps, more = "; ".join(map(self._step, every[:_STEPS])), len(every) - _STEPS
        if more > 0:
            steps = self.say("diagnosis.and_more", named=steps, count=more)
        steps = begun(steps)
        open_ = self.answer.cost is not None and (self.answer.cost.without_price or self.answer.cost.without_option)
        key = "answer.cost_so_far" if open_ else "answer.cost"
        return f"{steps}. {self.say(key, cost=cost)}" if cost else f"{steps}."

    def _step(self, step: PumpStep | RepairStep) -> str:
        say = self.say
        if step.chosen is None and isinstance(step, PumpStep):
            return step_in_words(self.diagnosis, step, say)
        repair = say("answer.as_new") if step.chosen is None else repair_name(step.chosen.repair, say)
        return say("answer.repair", what=step_in_words(self.diagnosis, step, say), repair=repair)

    def sure(self) -> Iterator[str]:
        answer, say = self.answer, self.say
        if answer.missing is None or answer.missing.doubted:
            yield say("answer.not_computed" if answer.cause is Cause.UNEXPLAINED else "answer.as_the_verdict")
        elif answer.probability is None:
            yield say("answer.best_estimate")
        else:
            keys = {(): "answer.probability_of_none", (Cause.PUMP,): "answer.probability_of_these"}
            unexplained = answer.cause is Cause.UNEXPLAINED
            key = keys.get(answer.also, "answer.probability") if unexplained else "answer.probability"
            causes = ", ".join(map(self._in_words, (answer.cause, *answer.also)))
            surely = say("answer.more_than", percent=say.percent(_SURELY, 0))
            percent = surely if answer.probability > _SURELY else say.percent(answer.probability, 0)
            yield say(key, percent=percent, causes=causes)
            if answer.missing.measured is None and self.diagnosis.unmeasured:
                yield say("answer.others_new")
            elif answer.missing.measured is None and self.diagnosis.model.pump_open:
                yield say("answer.pump_new")
        parts = [
            say(f"answer.{each.part}")
            if each.land is None
            else land_in_words(self.diagnosis, (each.component, each.land), say)
            for each in answer.next_measurements
        ]
        if Cause.PUMP in answer.also:
            yield say("answer.read_fast")
        if parts:
            yield say("answer.or_next" if Cause.PUMP in answer.also else "answer.next", parts=", ".join(parts))
        if within := sum(land.shown_as == "within_range" for land in self.diagnosis.lands):
            yield say("answer.within_range", count=within)
