"""Build the section on pressures: what line and circuits hold at each condition, and what the pump has left."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial

from atleak.report.pdf.blocks import Block, ends, joined, picture, printed, text
from atleak.report.pdf.printed_names import Part
from atleak.report.printed_charts import pump_chart
from atleak.report.printed_charts.charts import drawn
from atleak.uncertainty import RuleDecision
from atleak.views.flow_diagram import FlowDiagram, flow_diagram, flow_words
from atleak.views.flow_svg import flow_svg
from atleak.views.land_names import land_number
from atleak.views.pressure_tables import held_table, pressure_chart
from atleak.views.pressures import HeldPressure, PressuresAt, lowest_first, pressures_at
from atleak.views.pump_speed import PumpOverSpeed, pump_over_speed
from atleak.views.pump_words import pump_sentence
from atleak.views.sentences import circuit_sentence
from atleak.views.table import Column, Judged, Table
from atleak.wording import begun
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
        repaired = plan.ends if plan.steps else ()
        conditions = [pressures_at(diagnosis, each, repaired) for each in diagnosis.presented]
        first = lowest_first(diagnosis)[0]  # at which a pressure or the reserve is judged worst
        lowest = next(each for each in conditions if each.projection is first)
        yield self._pump(conditions)
        measured = pump_sentence(diagnosis, say)
        if measured is not None:
            yield text(measured)
        yield text(say("texts.held") if solved else say("held.not_solved"), small=True)
        if not solved:
            return
        yield from self._held(conditions)
        speeds = pump_over_speed(diagnosis, first, say)
        yield self._drawing("pump", pump_chart(speeds, say), self._crossings(speeds), lowest)
        if diagnosis.controller.circuits:
            yield text(say("texts.circuits"), small=True)
            held = (circuit_sentence(diagnosis, each, say) for each in lowest.applied)
            yield self._drawing("pressures", drawn(pressure_chart(lowest, say), say), f"{joined(held, '. ')}.", lowest)
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
        return self.say.condition(at.projection.condition)

    def _held(self, conditions: Sequence[PressuresAt]) -> Iterator[Block]:
        """Yield what the line and every circuit hold at each condition, and which circuits are not applied there."""
        held = held_table(self.diagnosis, conditions, self.say).without("lands_that_cost").filled
        yield printed(replace(held, told=self._told))
        for at in conditions:
            vented = joined(self.names.section(each.id) for each in at.circuits if each.vented)
            if vented:
                said = self.say("texts.vented", circuits=vented)
                yield text(f"{begun(self._condition(at))}: {said}", small=True)

    def _pump(self, conditions: Sequence[PressuresAt]) -> Block:
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
        whole = Table("", tuple(columns), conditions, self.say, group=self._condition)
        kept = {column.key for column in whole.filled.columns}
        return printed(whole.without(*({"reserve_repaired", "band", "reserve_decision"} - kept)))

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
