"""Build the section on pressures: what line and circuits hold at each condition, and what the pump has left."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from atleak.report.pdf.blocks import Block, ends, joined, picture, printed, text
from atleak.report.pdf.printed_names import Part
from atleak.report.printed_charts import pressures_chart, pump_chart
from atleak.uncertainty import RuleDecision
from atleak.views.flow_diagram import FlowDiagram, flow_diagram, flow_words
from atleak.views.flow_svg import flow_svg
from atleak.views.gauge_rows import permissible_text
from atleak.views.land_names import land_number
from atleak.views.pressures import HeldPressure, PressuresAt, lowest_first, pressures_at
from atleak.views.pump_speed import PumpOverSpeed, pump_over_speed
from atleak.views.pump_words import pump_sentence
from atleak.views.sentences import circuit_sentence
from atleak.views.table import VERDICT, Column, Judged, Table
from atleak.workshop_units import DM3_MIN, KPA, RPM

_DRAWN = 4  # lands drawn by themselves where the flow goes
_LANDS = 4  # named as causes of one circuit's loss
_SHOWS = 0.5  # [kPa] that a whole number shows


class Pressures(Part):
    """What a report says of the pressures held."""

    def blocks(self) -> Iterable[Block]:
        """Return the line and the pump at every condition, then the circuits of each, and their drawings."""
        say, diagnosis, plan = self.say, self.diagnosis, self.names.plan
        solved = diagnosis.profile.circuits == "on"
        ends = plan.ends if plan.steps else ()
        conditions = [pressures_at(diagnosis, each, ends) for each in diagnosis.presented]
        first = lowest_first(diagnosis)[0]  # at which a pressure or the reserve is judged worst
        lowest = next(each for each in conditions if each.projection is first)
        if solved:
            yield self._line(conditions)
        yield self._pump(conditions)
        measured = pump_sentence(diagnosis, say)
        if measured is not None:
            yield text(measured)
        yield text(say("texts.held") if solved else say("held.not_solved"), small=True)
        if not solved:
            return
        speeds = pump_over_speed(diagnosis, first, say)
        yield self._drawing("pump", pump_chart(speeds, say), self._crossings(speeds), lowest)
        if diagnosis.controller.circuits:
            for at in conditions:
                yield from self._circuits(at)
            yield text(say("texts.circuits"), small=True)
            held = (circuit_sentence(diagnosis, each, say) for each in lowest.applied)
            yield self._drawing("pressures", pressures_chart(lowest, say), f"{joined(held, '. ')}.", lowest)
            flows = flow_diagram(diagnosis, first, leaks_only=True, lands=_DRAWN, say=say)
            words = self._flows(flows)
            yield self._drawing("flows", flow_svg(flows, words, say), words, lowest)

    # --- drawings

    def _drawing(self, name: str, svg: str, words: str, at: PressuresAt) -> Block:
        """Return a drawing with its caption and, for a screen reader, its words."""
        caption = self.say(f"charts.caption_{name}", condition=self._condition(at))
        return picture(svg, f"{caption} {words}", caption)

    def _crossings(self, speeds: PumpOverSpeed) -> str:
        say = self.say
        crossings = []
        for each in speeds.demands:
            taken = say("charts.taken_at", temperature=say.plain_value(each.temperature, "temperature"))
            flow = f"{say.value(each.flow * DM3_MIN, 'flow', 2)} {say.unit('flow')}"
            crossings.append(f"{taken}: {flow}, {say.number(each.crossing * RPM, 0)} 1/min")
        return f"{joined(crossings, '; ')}."

    def _flows(self, diagram: FlowDiagram) -> str:
        say, places = self.say, diagram.places
        flows = (
            say(
                "flows.flow",
                source=places[each.source].name,
                target=places[each.target].name,
                flow=flow_words(each.flow, say),
            )
            for each in diagram.flows
        )
        return say("flows.alt", flows=f"{joined(flows, '; ')}.")

    # --- tables

    def _condition(self, at: PressuresAt) -> str:
        return self.names.condition(at.projection.condition)

    def _table(self, rows: Iterable[Any], columns: Iterable[Column], **more: Any) -> Block:
        """Return a table without the columns on repairs and limits, where none is planned and none is set."""
        whole = Table("", tuple(columns), list(rows), self.say, **more)
        kept = {column.key for column in whole.filled.columns}
        optional = {"held_repaired", "reserve_repaired", "band", "reserve_decision"}
        return printed(whole.without(*(optional - kept)))

    def _held(self, of: Callable[[Any], HeldPressure]) -> list[Column]:
        """Return the columns of what is held, with its interval below it, when new and with the planned repairs."""

        held = Column("held", "pressure", of=lambda item: of(item).now, times=KPA)
        return [
            held,
            *ends(lambda item: of(item).interval, held),
            Column("held_new", "pressure", of=lambda item: of(item).new, times=KPA),
            Column("held_repaired", "pressure", of=lambda item: of(item).repaired, times=KPA),
        ]

    def _judged(self, of: Callable[[Any], HeldPressure]) -> list[Column]:
        return [
            Column("verdict", VERDICT, of=lambda item: of(item).verdict),
            Column("decision", width=100, of=lambda item: self._decision(of(item).decided)),
        ]

    def _line(self, conditions: Iterable[PressuresAt]) -> Block:
        def line(at: PressuresAt) -> HeldPressure:
            return at.line

        columns = [
            Column("required", "pressure", of=lambda at: at.projection.condition.main_pressure, times=KPA),
            *self._held(line),
            Column("permissible", words_of="pressure", of=lambda at: permissible_text(at.line.permissible, self.say)),
            *self._judged(line),
        ]
        return self._table(conditions, columns, group=self._condition, told=lambda at: self._told(at.line))

    def _pump(self, conditions: Iterable[PressuresAt]) -> Block:
        def band(at: PressuresAt) -> Judged:
            rule, verdict = at.reserve_rule, at.reserve_verdict
            if rule is None or verdict is None:
                return Judged(None)
            return Judged(self.say.level(rule.level if verdict == rule.verdict else verdict), verdict)

        def flow(what: str, at: PressuresAt) -> float:
            return float(getattr(at.projection, what))

        flows = {"supply": "pump_supply", "leakage": "leakage", "slip": "slip"}
        flows |= {"consumers": "consumers", "short": "starved"}
        reserve = Column("reserve", digits=2, of=lambda at: at.projection.reserve)
        columns = [
            *(Column(key, "flow", of=partial(flow, what), times=DM3_MIN) for key, what in flows.items()),
            reserve,
            *ends(lambda at: at.reserve_interval, reserve),
            Column("reserve_new", digits=2),
            Column("reserve_repaired", digits=2),
            Column("band", of=band),
            Column(
                "reserve_decision",
                words=self.say("printed.decision"),
                width=50,
                of=lambda at: self._decision(at.reserve_decided),
            ),
        ]
        return self._table(conditions, columns, group=self._condition)

    def _circuits(self, at: PressuresAt) -> Iterable[Block]:
        def itself(each: HeldPressure) -> HeldPressure:
            return each

        say, section = self.say, self.names.section
        columns = [
            Column("circuit", width=150, of=lambda each: section(each.id)),
            *self._held(itself),
            Column("set_pressure", "pressure", times=KPA),
            Column("lost", "pressure", of="loss", times=KPA),
            *self._judged(itself),
        ]
        yield text(say("texts.circuits_at", condition=self._condition(at)), leads=True)
        yield self._table((each for each in at.circuits if not each.vented), columns, told=self._told)
        vented = joined(section(each.id) for each in at.circuits if each.vented)
        if vented:
            yield text(say("texts.vented", circuits=vented), small=True)

    def _decision(self, decided: RuleDecision | None) -> str | None:
        return None if decided is None else self.names.decided(decided.decision, decided.probability_over_limit)

    def _told(self, each: HeldPressure) -> str:
        """Name the lands that cost it most."""
        say, controller = self.say, self.diagnosis.controller
        shown = [cause for cause in each.causes.items() if abs(cause[1]) * KPA >= _SHOWS]
        causes = sorted(shown, key=lambda cause: -abs(cause[1]))
        named = [
            f"{land_number(controller, key, say)}\u00a0{say.value(loss * KPA, 'pressure', 0)}"
            for key, loss in causes[:_LANDS]
        ]
        more = [say("texts.more_lands", count=len(causes) - _LANDS)] if len(causes) > _LANDS else []
        return f"{say('printed.costs')}, {say.unit('pressure')}: {joined([*named, *more])}" if causes else ""
