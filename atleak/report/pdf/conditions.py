"""Build the printed sections on conditions: complaint, matrix of lands, order of repair, pressures, road test."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

from atleak.analysis.pressures import HeldPressure, PressuresAt, lowest_first, pressures_at
from atleak.analysis.repair.plan import PumpStep, RepairStep
from atleak.common.units import DM3_MIN, KPA, PERCENT, RPM, gear_name
from atleak.common.wording import begun, joined
from atleak.diagnosis.land import LandDiagnosis
from atleak.engine.road_leakage import RoadLeakage
from atleak.report.charts.flows import FlowDiagram, flow_diagram, flow_svg, flow_words
from atleak.report.charts.paper import drawn_on_paper
from atleak.report.charts.paper_curves import pump_chart, road_chart
from atleak.report.pdf.blocks import (
    FEW,
    Block,
    abreast,
    bullets,
    ends,
    named_facts,
    picture,
    printed,
    section_blocks,
    text,
)
from atleak.report.printed_names import PrintedNames, PrintedPart
from atleak.report.tables.complaint import MEASURE_FIRST, finding, measure_first, reason
from atleak.report.tables.first_sentence import pump_sentence
from atleak.report.tables.gauges import permissible_text
from atleak.report.tables.lands import MatrixRow, leaking_worst_first, matrix_table
from atleak.report.tables.names import land_number
from atleak.report.tables.pressures import PumpOverSpeed, condition_table, held_table, pressure_chart, pump_over_speed
from atleak.report.tables.repairs import RepairOptionRow, kit_words, option_table, order_table, plan_ends, totals_table
from atleak.report.tables.road_test import RoadInstant, RoadSeries, event_table, instant_table, place_table
from atleak.report.tables.road_words import (
    check_sentences,
    log_sentences,
    pressure_sentences,
    test_sentences,
    warm_up_section,
)
from atleak.report.tables.sentences import circuit_sentence, replace_at, shares_add_up
from atleak.report.tables.table import Column, Table

ABREAST, _BESIDE = 5, 3  # conditions beside one another in a table, and beside the steps of a plan


def leaking_elsewhere(names: PrintedNames, rows: Iterable[MatrixRow]) -> Iterable[str]:
    """Return one sentence for the lands that leak into the same circuits without drawing from the pump."""
    say = names.say
    lands: dict[tuple[str | None, ...], list[LandDiagnosis]] = {}
    for row in rows:
        if row.circuits:
            lands.setdefault(row.circuits, []).append(row.land)
    for circuits, leaking in lands.items():
        into = joined(
            say("texts.another_circuit") if circuit is None else names.section(circuit) for circuit in circuits
        )
        yield say("texts.elsewhere", lands=joined(map(names.land_number, leaking)), circuits=into)


class Conditions(PrintedPart):
    """What a report says about each condition."""

    # --- complaint

    def complaint(self) -> dict[str, Any] | None:
        """Return the customer's complaint, what explains it, and the lands to measure first; None without one."""
        say, diagnosis = self.say, self.diagnosis
        if diagnosis.complaint is None:
            return None
        at = joined((self.say.condition(each.condition) for each in diagnosis.complained), "; ")
        ranked = measure_first(diagnosis)
        items = [f"{self.names.land_name(each.land)}: {reason(each, say)}" for each in ranked[:MEASURE_FIRST]]
        if len(ranked) > MEASURE_FIRST:
            items.append(say("complaint.more", count=len(ranked) - MEASURE_FIRST))
        shows = say("complaint.shows", label=say.name(diagnosis.complaint.label), conditions=at)
        return {"sentence": f"{shows} {finding(diagnosis, say)}", "items": items}

    # --- matrix

    def matrix(self) -> Iterable[Block]:
        """Return the share of every land that leaks, at every condition."""
        say = self.say
        rows = leaking_worst_first(self.diagnosis, self.diagnosis.presented)
        if not rows:
            return

        yield from self._abreast(matrix_table(self.diagnosis, rows, say).without("elsewhere"))
        said = (say("texts.matrix"), shares_add_up(self.diagnosis, say), *leaking_elsewhere(self.names, rows))
        yield text(" ".join(said), small=True)

    # --- repairs

    def repair_order(self) -> Iterable[Block]:
        """Return the repairs in their order, with what each brings at every condition, and where they end."""
        say, plan = self.say, self.names.plan

        if plan.order:
            how = say("texts.repair_order_by_options" if plan.cost else "texts.repair_order")
            yield text(f"{how} {say('texts.totals_after')}", leads=True)
            yield from self._steps()
            yield from self._options()
            foreseen = [(self._step(step), at) for step in plan.steps if (at := replace_at(step.land, say))]
            if foreseen:
                beside = "" if len(plan.order) <= FEW else f" {joined(map(' '.join, foreseen), '; ')}."
                yield text(f"{say('printed.replace_at')}: {say('texts.replace_at')}.{beside}", small=True)
        yield from map(text, plan_ends(plan, say))

    def _steps(self) -> Iterator[Block]:
        """Yield the steps, with the total after each at every condition where these have room, else below."""
        say, plan = self.say, self.names.plan
        order, totals = (of(self.diagnosis, plan, say) for of in (order_table, totals_table))

        def step(row: Any) -> PumpStep | RepairStep | None:
            return plan.order[row[0] - 1] if row[0] else None

        def of_step(column: Column) -> Column:
            pair = column.key == "pair"
            unit, width = (say("repair_plan.as_measured"), 200) if pair else (None, column.width)
            return replace(column, width=width, of=lambda row: column.judged(found) if (found := step(row)) else unit)

        def about(row: Any) -> str:
            """Return what a new pump brings beside the total, and why a step lowers none."""
            said = isinstance(found := step(row), PumpStep) or (found and not found.helps)
            return helps.text(found, say) if said else ""

        (helps,) = order.only("helps_at").columns
        about_steps = map(of_step, order.only("pair", "verdict", "consequence", "replace_at").filled.columns)
        number = Column("", digits=0, words=say("repair_plan.number"), of=lambda row: str(row[0] or "–"))
        _, *conditions = totals.columns
        beside = [replace(each, width=150) for each in conditions] if len(conditions) <= _BESIDE else []
        if len(plan.order) <= FEW:
            yield printed(replace(totals, columns=(number, *about_steps, *beside), remark=about))
            yield from self._abreast(replace(totals, columns=(number, *([] if beside else conditions))))
            return
        # verdict, consequence and name stand with the flagged lands
        width = None if self.names.numbered else 200
        pair = Column("pair", width=width, of=lambda row: f"{row[0] or '–'} {self._step(step(row))}")
        rows = [row for row in totals.rows if (found := step(row)) is None or found.helps]
        many = replace(totals, columns=(pair, *(beside or conditions)), rows=rows)
        yield from [abreast(many)] if beside else self._abreast(many)
        said: dict[str, list[str]] = {}
        for row in totals.rows:
            said.setdefault(about(row), []).append(self._step(step(row)))
        yield bullets(f"{joined(steps)}: {what}" for what, steps in said.items() if what)

    def _step(self, step: PumpStep | RepairStep | None) -> str:
        """Return the number of the land that a step repairs, or its name."""
        if isinstance(step, RepairStep):
            return self.names.land_number(step.land)
        return self.say("repair_plan.as_measured") if step is None else self.say("pump.name")

    def _options(self) -> Iterator[Block]:
        """Return the repairs that the valve body's file names for the plan's lands."""
        say, controller = self.say, self.diagnosis.controller

        def lands(row: RepairOptionRow) -> str:
            numbers = joined(land_number(controller, key, say) for key in row.option.lands)
            lands = f"{say('printed.land')} {numbers}" if numbers else ""
            return kit_words(controller, row.option, say) or lands

        options = option_table(self.names.plan, say)
        if options.rows:
            yield text(say("texts.repair_options"), leads=True)
            yield printed(replace(options.without("lands").filled, remark=lands))

    def _abreast(self, table: Table) -> Iterator[Block]:
        """Yield a table of which as many conditions stand beside one another as have room."""
        first, *conditions = table.columns
        for start in range(0, len(conditions), ABREAST):
            yield printed(replace(table, columns=(first, *conditions[start : start + ABREAST])))


_DRAWN = 4  # lands drawn by themselves where the flow goes
_LANDS = 4  # named as causes of one circuit's loss
_SHOWS = 0.5  # [kPa] that a whole number shows


class Pressures(PrintedPart):
    """What a report says of the pressures held."""

    def blocks(self) -> Iterable[Block]:
        """Return the line and the pump at every condition, then the circuits of each, and their drawings."""
        say, diagnosis, plan = self.say, self.diagnosis, self.names.plan
        solved = diagnosis.profile.circuits == "on"
        repaired = plan.ends if plan.order else ()
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
            yield self._drawing(
                "pressures", drawn_on_paper(pressure_chart(lowest, say), say), f"{joined(held, '. ')}.", lowest
            )
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
            crossings.append(f"{taken}: {flow}, {say.quantity(each.crossing * RPM, 'engine_speed')}")
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
        below = {"lands_that_cost", "permissible"} if self.diagnosis.controller.circuits else {"lands_that_cost"}
        held = held_table(self.diagnosis, conditions, self.say).without(*below).filled
        if held.group and not self.diagnosis.controller.circuits:  # of which each condition has one row, of the line
            at = Column("condition", width=150, words=begun(self.say("printed.condition")), of=held.group)
            held = replace(held, columns=(at, *held.without("circuit").columns), group=None)
        yield printed(replace(held, remark=self._remark))
        vented = (
            f"{begun(self._condition(at))}: {self.say('texts.vented', circuits=joined(map(self.names.section, idle)))}"
            for at in conditions
            if (idle := [each.id for each in at.circuits if each.vented])
        )
        yield text(" ".join(vented), small=True)

    def _pump(self, conditions: Sequence[PressuresAt]) -> Block:
        table = condition_table(conditions, self.say)
        flows = table.only("condition", "pump_supply", "leakage", "slip", "consumers", "starved", "reserve")
        taken = {each.key: [*map(each.judged, table.rows)] for each in flows.only("consumers", "starved").columns}
        flows = flows.without(*(key for key, found in taken.items() if not any(each.value for each in found)))
        below = ends(lambda at: at.reserve_interval, flows.columns[-1])
        *more, decision = table.only("reserve_new", "reserve_repaired", "reserve_is", "reserve_decision").columns
        condition, *others = flows.columns
        columns = (replace(condition, width=150), *others, *below, *more, replace(decision, width=150))
        return printed(replace(table, columns=columns).filled)

    def _remark(self, each: HeldPressure) -> str:
        """Return what is permissible, where the table has no room for it, and the lands that cost it most."""
        say, controller = self.say, self.diagnosis.controller
        shown = [cause for cause in each.causes.items() if abs(cause[1]) * KPA >= _SHOWS]
        causes = sorted(shown, key=lambda cause: -abs(cause[1]))
        named = [
            f"{land_number(controller, key, say)}\u00a0{say.value(loss * KPA, 'pressure', 0)}"
            for key, loss in causes[:_LANDS]
        ]
        more = [say("texts.more_lands", count=len(causes) - _LANDS)] if len(causes) > _LANDS else []
        said = {
            "printed.permissible": (permissible_text(each.permissible, say) or "") if controller.circuits else "",
            "printed.costs": joined([*named, *more]) if causes else "",
        }
        return "; ".join(f"{say(key)}, {say.unit('pressure')}: {words}" for key, words in said.items() if words)


EVENTS = 40  # that are listed one by one; the others stand in the workbook and in the JSON


class RoadTestSection(PrintedPart):
    """The section on the road test; ``series`` is the thinned leakage over it, None where there is none."""

    def __init__(self, names: PrintedNames, series: RoadSeries | None) -> None:
        super().__init__(names)
        self.series = series

    def blocks(self) -> Iterable[Block]:
        """Yield what the log says by itself."""
        log, say = self.diagnosis.log, self.say
        if log is None:
            return
        test = log.road_test
        samples = f"{say.number(test.rows, 0)} {say('facts.samples')}"
        yield named_facts("facts", say, road_test=joined((test.file, f"{say.number(test.duration, 1)} s", samples)))
        yield text(" ".join(pressure_sentences(log, say)))
        if log.permitted is not None:
            yield printed(place_table(log.permitted, say).without("place_source"))
        yield text(" ".join((*test_sentences(log, say), *log_sentences(log, say))))
        section = warm_up_section(self.diagnosis, say)
        if section is not None:
            yield from section_blocks(section, lambda _: "", say)["blocks"]
        checks = check_sentences(self.diagnosis, say)
        if checks:
            yield text(say("findings.check_next"), leads=True)
            yield bullets(checks)

    def in_full(self) -> Iterable[Block]:
        """Yield its events one by one, and the leakage over it."""
        log, road = self.diagnosis.log, self.diagnosis.road
        if log is None:
            return
        yield printed(event_table(log.events[:EVENTS], self.say).without("event_lasts", "event_source"))
        more = len(log.events) - EVENTS
        if more > 0:
            yield text(self.say("findings.more_events", count=more), small=True)
        if road is not None and self.series is not None:
            yield from self._leakage(road, self.series)

    # --- leakage over the log

    def _leakage(self, road: RoadLeakage, series: RoadSeries) -> Iterator[Block]:
        say, names = self.say, self.names
        shares = joined(
            f"{names.section(name)} {say.percent(share, 0)}"
            for name, share in road.section_shares.items()
            if share is not None
        )
        yield named_facts("facts", say, gears=joined(map(gear_name, road.gears)), sections=shares)
        yield self._drawing(road, series)
        numbers = {row.label(say): number for number, row in enumerate(_marked(series), start=1)}
        number = Column("", digits=0, words="", of=lambda row: numbers.get(row["instant"], ""))
        table = instant_table(road, self.diagnosis.uncertainty, say)
        yield printed(replace(table, columns=(number, *table.columns)))
        notes = [say("texts.sustained", seconds=say.plain(road.extremes.window))]
        notes += [say("texts.lower_bound")] if road.lower_bound else []
        yield text(" ".join(notes), small=True)

    def _drawing(self, road: RoadLeakage, series: RoadSeries) -> Block:
        """Return the leakage over the log with the instants that are read first marked by numbers."""
        say = self.say
        marked = _marked(series)
        points = [
            (at.time, at.leakage * DM3_MIN, None if at.share is None else at.share * PERCENT)
            for at in (row.instant for row in marked)
        ]
        bands = [(band, limit * PERCENT) for band, limit in self.diagnosis.limits.fixed_bands]
        spoken = " ".join(
            say(
                "charts.instant_alt",
                instant=row.label(say),
                share=say.quantity(leakage, "flow", 2) if share is None else say.number(share, 1) + "\u00a0%",
                time=say.number(time, 1),
            )
            for row, (time, leakage, share) in zip(marked, points, strict=True)
        )
        thinned = ""
        if series.thinned:
            kept = say.number(len(series.columns["time_s"]), 0)
            thinned = say("charts.caption_thinned", kept=kept, samples=say.number(series.samples, 0))
        listed = joined(f"{number} {row.label(say)}" for number, row in enumerate(marked, start=1))
        return picture(
            road_chart(series, points, bands, say),
            say("charts.road_alt" if road.share is not None else "charts.road_alt_no_share", instants=spoken),
            say("charts.caption_road", instants=listed, thinned=thinned).strip(),
        )


def _marked(series: RoadSeries) -> list[RoadInstant]:
    return [row for row in series.instants if row.leads]
