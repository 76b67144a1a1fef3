"""Build the section on pressures: what line and circuits hold at each condition, and what the pump has left."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import Any

from atleak.report.pdf.blocks import Block, PrintedColumn, joined, table, text
from atleak.report.pdf.printed_names import PrintedNames
from atleak.views.flow_diagram import FlowDiagram, flow_diagram, flow_words
from atleak.views.pressures import HeldPressure, PressuresAt, lowest_first, pressures_at
from atleak.workshop_units import KPA

_DRAWN = 10  # lands drawn by themselves where the flow goes
_LANDS = 4  # named as causes of one circuit's loss
_SHOWS = 0.5  # [kPa] that a whole number shows


class Pressures:
    """What a report says of the pressures held."""

    def __init__(self, names: PrintedNames) -> None:
        self.names, self.diagnosis, self.say = names, names.diagnosis, names.say

    @cached_property
    def flows(self) -> FlowDiagram:
        """Return where the pump's flow goes, at the condition at which a pressure or the reserve is judged worst."""
        return flow_diagram(self.diagnosis, lowest_first(self.diagnosis)[0], lands=_DRAWN, say=self.say)

    def flows_in_words(self) -> str:
        """Return all flows of the drawing in words, as a screen reader says them."""
        say, places = self.say, self.flows.places
        flows = (
            say(
                "flows.flow",
                source=places[each.source].name,
                target=places[each.target].name,
                flow=flow_words(each.flow, say),
            )
            for each in self.flows.flows
        )
        return say("flows.alt", flows=f"{joined(flows, '; ')}.")

    def blocks(self, charts: dict[str, str]) -> Iterable[Block]:
        """Return the line and the pump at every condition, where the flow goes, then the circuits of each condition."""
        say = self.say
        conditions = [pressures_at(self.diagnosis, each) for each in self.diagnosis.presented]
        solved = self.diagnosis.profile.circuits == "on"
        if solved:
            yield self._line(conditions)
        yield self._pump(conditions)
        yield text(say("texts.held") if solved else say("held.not_solved"), small=True)
        if "flows" in charts:
            condition = self.names.condition(self.flows.projection.condition)
            caption = say("charts.caption_flows", condition=condition)
            yield {"kind": "image", "file": charts["flows"], "alt": self.flows_in_words(), "caption": caption}
        if solved and self.diagnosis.controller.circuits:
            for at in conditions:
                yield from self._circuits(at)
            yield text(say("texts.circuits"), small=True)

    def _condition(self, at: PressuresAt) -> str:
        return self.names.condition(at.projection.condition)

    def _kpa(self, pressure: float | None) -> str:
        return self.say.number(None if pressure is None else pressure * KPA, 0)

    def _held(self, each: HeldPressure) -> str:
        low, high = each.interval or (None, None)
        low, high = (None if end is None else end * KPA for end in (low, high))
        return self._kpa(each.now) + self.names.interval(low, high, 0)

    def _verdict(self, each: HeldPressure) -> dict[str, str] | str:
        if each.verdict is None:
            return "–"
        return {"sign": each.verdict, "text": self.say.level(each.verdict)}

    # --- the line and the pump

    def _line(self, conditions: Iterable[PressuresAt]) -> Block:
        column = self.names.column
        return table(
            [
                PrintedColumn(column("condition"), self._condition, width=3),
                PrintedColumn(column("required"), self._required, "kPa", side="r"),
                PrintedColumn(column("held"), lambda at: self._held(at.line), "kPa", side="r"),
                PrintedColumn(column("held_new"), lambda at: self._kpa(at.line.new), "kPa", side="r"),
                PrintedColumn(column("permissible"), self._permissible, "kPa", side="r"),
                PrintedColumn(column("verdict"), lambda at: self._verdict(at.line)),
                PrintedColumn(column("decision"), lambda at: self._decision(at.line.decided)),
                PrintedColumn(column("costs"), lambda at: self._causes(at.line), width=2),
            ],
            conditions,
        )

    def _required(self, at: PressuresAt) -> str:
        return self._kpa(at.projection.condition.main_pressure)

    def _permissible(self, at: PressuresAt) -> str:
        permissible = at.line.permissible
        low, high = (permissible.low, permissible.high) if permissible else (None, None)
        if low is not None and high is not None:
            return f"{self._kpa(low)}–{self._kpa(high)}"
        if low is not None:
            return self.say("texts.at_least_kpa", low=self._kpa(low))
        return "–" if high is None else self.say("texts.at_most_kpa", high=self._kpa(high))

    def _pump(self, conditions: Iterable[PressuresAt]) -> Block:
        column, flow, say = self.names.column, self.names.flow, self.say

        def reserve(at: PressuresAt) -> str:
            low, high = at.reserve_interval or (None, None)
            return say.number(at.projection.reserve, 2) + self.names.interval(low, high, 2)

        unit = "dm³/min"
        columns = [
            PrintedColumn(column("condition"), self._condition, width=3),
            PrintedColumn(column("supply"), lambda at: flow(at.projection.pump_supply), unit, side="r"),
            PrintedColumn(column("leakage"), lambda at: flow(at.projection.leakage), unit, side="r"),
            PrintedColumn(column("slip"), lambda at: flow(at.projection.slip), unit, side="r"),
            PrintedColumn(column("consumers"), lambda at: flow(at.projection.consumers), unit, side="r"),
            PrintedColumn(column("short"), lambda at: flow(at.projection.starved), unit, side="r"),
            PrintedColumn(column("reserve"), reserve, side="r"),
            PrintedColumn(column("reserve_new"), lambda at: say.number(at.reserve_new, 2), side="r"),
        ]
        if any(at.reserve_rule is not None for at in conditions):
            columns.append(PrintedColumn(column("band"), self._reserve_band))
            columns.append(PrintedColumn(column("decision"), lambda at: self._decision(at.reserve_decided)))
        return table(columns, conditions)

    def _reserve_band(self, at: PressuresAt) -> dict[str, str] | str:
        rule, verdict = at.reserve_rule, at.reserve_verdict
        if rule is None or verdict is None:
            return "–"
        return {"sign": verdict, "text": self.say.level(rule.level if verdict == rule.verdict else verdict)}

    # --- circuits

    def _circuits(self, at: PressuresAt) -> Iterable[Block]:
        say, column = self.say, self.names.column
        applied = [each for each in at.circuits if not each.vented]
        yield text(say("texts.circuits_at", condition=self._condition(at)), leads=True)
        yield table(
            [
                PrintedColumn(column("circuit"), lambda each: self.names.section(each.id), width=3),
                PrintedColumn(column("held"), self._held, "kPa", side="r"),
                PrintedColumn(column("held_new"), lambda each: self._kpa(each.new), "kPa", side="r"),
                PrintedColumn(column("set_pressure"), lambda each: self._kpa(each.set_pressure), "kPa", side="r"),
                PrintedColumn(column("lost"), lambda each: self._kpa(each.loss), "kPa", side="r"),
                PrintedColumn(column("verdict"), self._verdict),
                PrintedColumn(column("decision"), lambda each: self._decision(each.decided)),
                PrintedColumn(column("costs"), self._causes, width=2),
            ],
            applied,
        )
        vented = joined(self.names.section(each.id) for each in at.circuits if each.vented)
        if vented:
            yield text(say("texts.vented", circuits=vented), small=True)

    def _decision(self, decided: Any) -> str:
        return "–" if decided is None else self.names.decided(decided.decision, decided.probability_over_limit)

    def _causes(self, each: HeldPressure) -> str:
        shown = [cause for cause in each.causes.items() if abs(cause[1]) * KPA >= _SHOWS]
        causes = sorted(shown, key=lambda cause: -abs(cause[1]))
        named = [f"{component}/{land}\u00a0{self._kpa(loss)}" for (component, land), loss in causes[:_LANDS]]
        more = len(causes) - _LANDS
        return joined([*named, self.say("texts.more_lands", count=more) if more > 0 else ""])
