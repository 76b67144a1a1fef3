"""Build the section on pressures: what line and circuits hold at each condition, and what the pump has left."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from typing import Any

from atleak.report.pdf.blocks import Block, PrintedColumn, grouped_table, joined, table, text
from atleak.report.pdf.printed_names import PrintedNames
from atleak.report.printed_charts import pressures_chart, pump_chart
from atleak.views.flow_diagram import FlowDiagram, flow_diagram, flow_words
from atleak.views.flow_svg import flow_svg
from atleak.views.land_names import land_number
from atleak.views.pressures import HeldPressure, PressuresAt, lowest_first, pressures_at
from atleak.views.pump_speed import PumpOverSpeed, pump_over_speed
from atleak.views.pump_words import pump_sentence
from atleak.views.sentences import circuit_sentence
from atleak.workshop_units import KPA, RPM

_DRAWN = 4  # lands drawn by themselves where the flow goes
_LANDS = 4  # named as causes of one circuit's loss
_SHOWS = 0.5  # [kPa] that a whole number shows


class Pressures:
    """What a report says of the pressures held."""

    def __init__(self, names: PrintedNames) -> None:
        self.names, self.diagnosis, self.say = names, names.diagnosis, names.say

    @cached_property
    def conditions(self) -> list[PressuresAt]:
        """Return reserve and pressures at every condition, also as the planned repairs leave them."""
        plan = self.names.plan
        ends = plan.ends if plan.steps else ()
        return [pressures_at(self.diagnosis, each, ends) for each in self.diagnosis.presented]

    @cached_property
    def lowest(self) -> PressuresAt:
        """Return those at the condition at which a pressure or the reserve is judged worst."""
        first = lowest_first(self.diagnosis)[0]
        return next(each for each in self.conditions if each.projection is first)

    @cached_property
    def _speeds(self) -> PumpOverSpeed:
        return pump_over_speed(self.diagnosis, self.lowest.projection, self.say)

    @cached_property
    def _flows(self) -> FlowDiagram:
        return flow_diagram(self.diagnosis, self.lowest.projection, leaks_only=True, lands=_DRAWN, say=self.say)

    # --- drawings

    def drawings(self) -> dict[str, str]:
        """Return every drawing of the section as SVG, by name."""
        say, drawn = self.say, {"pump": pump_chart(self._speeds, self.say)}
        if self.diagnosis.controller.circuits:
            drawn["pressures"] = pressures_chart(self.lowest, say)
            drawn["flows"] = flow_svg(self._flows, self._flows_in_words(), say)
        return drawn

    def _drawing(self, charts: dict[str, str], name: str, words: Callable[[], str]) -> Block:
        """Return a drawing with its caption and, for a screen reader, its words; an empty block without it."""
        if name not in charts:
            return {}
        caption = self.say(f"charts.caption_{name}", condition=self._condition(self.lowest))
        return {"kind": "image", "file": charts[name], "alt": f"{caption} {words()}", "caption": caption}

    def _crossings_in_words(self) -> str:
        say = self.say
        crossings = []
        for each in self._speeds.demands:
            taken = say("charts.taken_at", temperature=say.plain_value(each.temperature, "temperature"))
            speed = say.number(each.crossing * RPM, 0)
            crossings.append(f"{taken}: {self.names.flow_with_unit(each.flow)}, {speed} 1/min")
        return f"{joined(crossings, '; ')}."

    def _pressures_in_words(self) -> str:
        held = (circuit_sentence(self.diagnosis, each, self.say) for each in self.lowest.applied)
        return f"{joined(held, '. ')}."

    def _flows_in_words(self) -> str:
        say, places = self.say, self._flows.places
        flows = (
            say(
                "flows.flow",
                source=places[each.source].name,
                target=places[each.target].name,
                flow=flow_words(each.flow, say),
            )
            for each in self._flows.flows
        )
        return say("flows.alt", flows=f"{joined(flows, '; ')}.")

    # --- the section

    def blocks(self, charts: dict[str, str]) -> Iterable[Block]:
        """Return the line and the pump at every condition, then the circuits of each, and their drawings."""
        say, conditions = self.say, self.conditions
        solved = self.diagnosis.profile.circuits == "on"
        if solved:
            yield self._line(conditions)
        yield self._pump(conditions)
        measured = pump_sentence(self.diagnosis, say)
        if measured is not None:
            yield text(measured)
        yield text(say("texts.held") if solved else say("held.not_solved"), small=True)
        yield self._drawing(charts, "pump", self._crossings_in_words)
        if solved and self.diagnosis.controller.circuits:
            for at in conditions:
                yield from self._circuits(at)
            yield text(say("texts.circuits"), small=True)
            yield self._drawing(charts, "pressures", self._pressures_in_words)
            yield self._drawing(charts, "flows", self._flows_in_words)

    def _condition(self, at: PressuresAt) -> str:
        return self.names.condition(at.projection.condition)

    def _kpa(self, pressure: float | None) -> str:
        return self.say.value(None if pressure is None else pressure * KPA, "pressure", 0)

    def _held(self, each: HeldPressure) -> str:
        low, high = each.interval or (None, None)
        low, high = (None if end is None else end * KPA for end in (low, high))
        return self._kpa(each.now) + self.names.interval(low, high, 0, "pressure")

    def _verdict(self, each: HeldPressure) -> dict[str, str] | str:
        if each.verdict is None:
            return "–"
        return {"sign": each.verdict, "text": self.say.level(each.verdict)}

    def _repaired(self, pressure: Callable[[Any], float | None], items: Iterable[Any]) -> list[PrintedColumn]:
        """Return the column with what is held after the planned repairs, where any are planned."""
        if all(pressure(each) is None for each in items):
            return []
        name = self.names.column("held_repaired")
        return [PrintedColumn(name, lambda each: self._kpa(pressure(each)), self.say.unit("pressure"), side="r")]

    # --- the line and the pump

    def _line(self, conditions: Sequence[PressuresAt]) -> Block:
        column, unit = self.names.column, self.say.unit("pressure")
        return grouped_table(
            [
                PrintedColumn(column("required"), self._required, unit, side="r"),
                PrintedColumn(column("held"), lambda at: self._held(at.line), unit, side="r"),
                PrintedColumn(column("held_new"), lambda at: self._kpa(at.line.new), unit, side="r"),
                *self._repaired(lambda at: at.line.repaired, conditions),
                PrintedColumn(column("permissible"), self._permissible, unit, side="r"),
                PrintedColumn(column("verdict"), lambda at: self._verdict(at.line)),
                PrintedColumn(column("decision"), lambda at: self._decision(at.line.decided), width=1),
            ],
            ((self._condition(at), [at]) for at in conditions),
            told=lambda at: self._told(at.line),
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

    def _pump(self, conditions: Sequence[PressuresAt]) -> Block:
        column, flow, say = self.names.column, self.names.flow, self.say

        def reserve(at: PressuresAt) -> str:
            low, high = at.reserve_interval or (None, None)
            return say.number(at.projection.reserve, 2) + self.names.interval(low, high, 2)

        unit = self.say.unit("flow")
        columns = [
            PrintedColumn(column("supply"), lambda at: flow(at.projection.pump_supply), unit, side="r"),
            PrintedColumn(column("leakage"), lambda at: flow(at.projection.leakage), unit, side="r"),
            PrintedColumn(column("slip"), lambda at: flow(at.projection.slip), unit, side="r"),
            PrintedColumn(column("consumers"), lambda at: flow(at.projection.consumers), unit, side="r"),
            PrintedColumn(column("short"), lambda at: flow(at.projection.starved), unit, side="r"),
            PrintedColumn(column("reserve"), reserve, side="r"),
            PrintedColumn(column("reserve_new"), lambda at: say.number(at.reserve_new, 2), side="r"),
        ]
        if any(at.reserve_repaired is not None for at in conditions):
            name = column("reserve_repaired")
            columns.append(PrintedColumn(name, lambda at: say.number(at.reserve_repaired, 2), side="r"))
        if any(at.reserve_rule is not None for at in conditions):
            columns.append(PrintedColumn(column("band"), self._reserve_band))
            columns.append(PrintedColumn(column("decision"), lambda at: self._decision(at.reserve_decided), width=1))
        return grouped_table(columns, ((self._condition(at), [at]) for at in conditions))

    def _reserve_band(self, at: PressuresAt) -> dict[str, str] | str:
        rule, verdict = at.reserve_rule, at.reserve_verdict
        if rule is None or verdict is None:
            return "–"
        return {"sign": verdict, "text": self.say.level(rule.level if verdict == rule.verdict else verdict)}

    # --- circuits

    def _circuits(self, at: PressuresAt) -> Iterable[Block]:
        say, column, unit = self.say, self.names.column, self.say.unit("pressure")
        applied = [each for each in at.circuits if not each.vented]
        yield text(say("texts.circuits_at", condition=self._condition(at)), leads=True)
        yield table(
            [
                PrintedColumn(column("circuit"), lambda each: self.names.section(each.id), width=3),
                PrintedColumn(column("held"), self._held, unit, side="r"),
                PrintedColumn(column("held_new"), lambda each: self._kpa(each.new), unit, side="r"),
                *self._repaired(lambda each: each.repaired, applied),
                PrintedColumn(column("set_pressure"), lambda each: self._kpa(each.set_pressure), unit, side="r"),
                PrintedColumn(column("lost"), lambda each: self._kpa(each.loss), unit, side="r"),
                PrintedColumn(column("verdict"), self._verdict),
                PrintedColumn(column("decision"), lambda each: self._decision(each.decided), width=2),
            ],
            applied,
            told=self._told,
        )
        vented = joined(self.names.section(each.id) for each in at.circuits if each.vented)
        if vented:
            yield text(say("texts.vented", circuits=vented), small=True)

    def _decision(self, decided: Any) -> str:
        return "–" if decided is None else self.names.decided(decided.decision, decided.probability_over_limit)

    def _told(self, each: HeldPressure) -> str:
        causes = self._causes(each)
        return f"{self.names.column('costs')}, {self.say.unit('pressure')}: {causes}" if causes else ""

    def _causes(self, each: HeldPressure) -> str:
        shown = [cause for cause in each.causes.items() if abs(cause[1]) * KPA >= _SHOWS]
        causes = sorted(shown, key=lambda cause: -abs(cause[1]))
        controller = self.diagnosis.controller
        named = [f"{land_number(controller, key, self.say)}\u00a0{self._kpa(loss)}" for key, loss in causes[:_LANDS]]
        more = len(causes) - _LANDS
        return joined([*named, self.say("texts.more_lands", count=more) if more > 0 else ""])
