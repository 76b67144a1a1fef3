"""Show a log: the part that is looked at, its picture, formulas, values, and where it was driven."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
import streamlit as st

from atleak.analysis.formulas import CHANNEL_NAMES, FUNCTIONS, FormulaChannel, formula_channel
from atleak.catalogue.written_numbers import SHIFT
from atleak.common.errors import AtleakError, FormulaError
from atleak.common.memory import kept_with
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.engine.road_leakage import RoadLeakage
from atleak.engine.road_pressure import permitted_pressure
from atleak.job.case import SourceFile
from atleak.measurements.events import Event, events
from atleak.measurements.job_card import LogFormula
from atleak.measurements.road_test import RoadTest, hold
from atleak.readers.logs import Understood, tidy_csv
from atleak.report.charts import log_figures as figures
from atleak.report.charts.operating_map import histogram, operating_map
from atleak.report.tables.road_test import (
    Curve,
    LaidOver,
    as_it_is,
    channel_scales,
    event_table,
    formula_scale,
    log_curves,
    value_rows,
    whole,
)
from atleak.report.tables.road_words import event_span
from pages.shared import fields, log_form, reader, show
from pages.shared import road as road_page
from pages.shared.cases import understood
from pages.shared.state import RECORD, job, job_generation, session


@dataclass(frozen=True, eq=False)
class Part:
    """The part of a log that is looked at: ``ends`` [s] of it, None for the whole log, with what is computed of it."""

    whole: RoadTest
    test: RoadTest
    ends: tuple[float, float] | None
    formulas: tuple[FormulaChannel, ...]
    over: LaidOver | None

    @property
    def span(self) -> tuple[float, float]:
        """Return the ends of what is shown [s]."""
        return self.ends or (float(self.whole.time[0]), float(self.whole.time[-1]))

    @property
    def key(self) -> tuple[object, ...]:
        """Return what tells two parts of one log apart."""
        over = self.over and (self.over.test.sha256, id(self.over.test), self.over.shift)
        return self.ends, tuple((each.name, each.formula) for each in self.formulas), over


def in_full(diagnosis: Diagnosis, file: SourceFile, log: Understood) -> None:
    """Show a log in a fold: its picture under one cursor, the leakage over it, what happened, how it was understood.

    Parameters
    ----------
    file
        the job's log, or one that waits for an answer and is not in the job yet.
    """
    say, own = reader.say(), diagnosis.log if file == session().good.road_test else None
    with fields.fold(say("road_test.in_full"), key=f"log-in-full-{session().generation}") as place:
        test = log.road_test if own is None else own.road_test
        if test is None or not place.open:
            return
        happened = kept_with(test, "events", "", partial(events, test)) if own is None else own.events
        ends = window(test, happened)
        formulas_form(test)
        part = part_of(test, ends, overlay())
        road = None if own is None or diagnosis.road is None else _leakage(diagnosis, part)
        picture(part, happened, road, diagnosis)
        if road is not None:
            road_page.extremes(road, diagnosis.uncertainty)
        operating_part(part, road)
        st.header(say("road_test.happened"))
        events_table(test, happened)
        st.header(say("road_test.understood"))
        log_form.understood_table(log)
        if log.unused:
            st.caption(say("road_test.not_used", columns=show.plain(", ".join(log.unused))))
        tidy = partial(tidy_csv, part.test)
        st.download_button(say("road_test.tidy"), tidy, f"{file.name}.tidy.csv", on_click="ignore")


def _leakage(diagnosis: Diagnosis, part: Part) -> RoadLeakage | None:
    """Return the leakage over the part of the job's own log; say why there is none over so short a one."""
    say = reader.say()
    assert diagnosis.road is not None
    try:
        road = diagnosis.road if part.ends is None else diagnosis.over(part.test)
        road_page.as_new(diagnosis)
        show.messages(road.messages, say("road_test.about_leakage"))
    except AtleakError as error:
        st.warning(show.plain(error))
        return None
    return road


def events_table(test: RoadTest, happened: Sequence[Event]) -> None:
    """Show every event of a log."""
    say = reader.say()
    if not happened:
        st.write(say("road_test.no_event"))
        return
    frame = kept_with(test, "event rows", say, lambda: event_table(happened, say).frame(rounded=True))
    numbers = frame.select_dtypes("number").columns
    config = {name: st.column_config.NumberColumn(format="localized") for name in numbers}
    st.dataframe(frame, hide_index=True, width="stretch", column_config=config, placeholder="–")


# --- the part that is looked at


def window(test: RoadTest, happened: Sequence[Event]) -> tuple[float, float] | None:
    """Return the part of the log to look at: an event, or between two stamps [s]; None for the whole log."""
    say = reader.say()
    first, last = float(test.time[0]), float(test.time[-1])
    if not last > first:
        return None
    kept = session().windows
    names = kept_with(test, "event names", say, lambda: [event_span(event, say) for event in happened])
    number = st.selectbox(
        say("road_test.look_at"),
        [None, *range(len(happened))],
        key=_picked(test),
        format_func=lambda number: say("road_test.whole") if number is None else names[number],
    )
    chosen = None if number is None else happened[number]
    ends = (first, last) if chosen is None else (chosen.start, chosen.stop)
    if chosen is None:
        ends = kept.get(test.sha256, ends)
    key = f"window-{test.sha256}-{st.session_state.get('window-set', 0)}-{ends if chosen is not None else 'own'}"
    start, stop = st.slider(f"{say('road_test.part_shown')} [s]", first, last, ends, key=key, format="localized")
    all_of_it = (start, stop) == (first, last)
    if chosen is None:
        kept.pop(test.sha256, None) if all_of_it else kept.update({test.sha256: (start, stop)})
    low, high = np.searchsorted(test.time, start), np.searchsorted(test.time, stop, side="right")
    if low == high:  # between two samples: both are shown
        start, stop = float(test.time[low - 1]), float(test.time[low])
    return None if all_of_it else (start, stop)


def look_between(test: RoadTest, start: float, stop: float) -> None:
    """Set the part that is shown; a chart calls this before the slider is drawn."""
    first, last = float(test.time[0]), float(test.time[-1])
    ends = (min(max(start, first), last), min(max(stop, first), last))
    if ends[1] > ends[0]:
        session().windows[test.sha256] = ends
        st.session_state[_picked(test)] = None
        st.session_state["window-set"] = st.session_state.get("window-set", 0) + 1  # a fresh slider starts from it


def _picked(test: RoadTest) -> str:
    return f"window-event-{test.sha256}"


def part_of(test: RoadTest, ends: tuple[float, float] | None, over: tuple[RoadTest, float] | None) -> Part:
    """Return the part of a log between two stamps [s], with the job's formulas over it and the log laid over it."""
    shown = test if ends is None else kept_with(test, "part", ends, lambda: test.window(*ends), most=1)
    typed = job().log_formulas
    laid = None
    if over is not None:
        other, shift = over
        if ends is not None:
            other = kept_with(
                other, "part", (ends, shift), lambda: over[0].window(ends[0] - shift, ends[1] - shift), most=1
            )
        laid = LaidOver(other, shift, _computed(other, typed))
    return Part(test, shown, ends, tuple(_computed(shown, typed).values()), laid)


# --- formulas


def _computed(test: RoadTest, typed: Sequence[LogFormula]) -> dict[str, FormulaChannel]:
    """Return what the formulas give over a log, without those that it cannot give."""
    computed: dict[str, FormulaChannel] = {}
    for number, each in enumerate(typed):
        result = kept_with(test, "formula", tuple(typed[: number + 1]), partial(_one, test, each, computed), most=24)
        if isinstance(result, FormulaChannel):
            computed[each.name] = result
    return computed


def _one(test: RoadTest, typed: LogFormula, above: Mapping[str, FormulaChannel]) -> FormulaChannel | FormulaError:
    try:
        return formula_channel(typed.name, typed.formula, test, dict(above))
    except FormulaError as error:
        return error


def formulas_form(test: RoadTest) -> None:
    """Ask for channels that are computed from the log's own, and list those there are."""
    say = reader.say()
    generation = job_generation()
    with fields.fold(say("formulas.fold"), key=f"formulas-fold-{generation}") as place:
        if not place.open:
            return
        with st.form(f"formulas-{generation}", border=False, clear_on_submit=False):
            left, right, button = st.columns([2, 4, 1], vertical_alignment="bottom")
            name = left.text_input(say("formulas.name"), placeholder=say("formulas.name_example"))
            formula = right.text_input(say("formulas.formula"), placeholder="p_g − p_k")
            add = button.form_submit_button(say("formulas.add"), width="stretch")
        fault = st.container()
        short = {quantity: each for each, quantity in CHANNEL_NAMES.items()}
        names = [short.get(quantity, quantity) for quantity in test.channels]
        st.caption(show.plain(f"{say('formulas.help', names=', '.join(names))} {say('formulas.kept')}"))
        if add and (why := _add(test, name.strip(), formula.strip(), say)):
            fault.error(show.plain(why))
        _list(test, say)


def _add(test: RoadTest, name: str, formula: str, say: Wording) -> str:
    """Add a formula to the job; return why it is not taken, else an empty text."""
    typed = job().log_formulas
    if not name:
        return say("formulas.no_name")
    taken = {each.name for each in typed} | set(test.channels) | set(CHANNEL_NAMES) | set(FUNCTIONS)
    if name in taken:
        return say("formulas.name_taken", name=name)
    result = _one(test, LogFormula(name=name, formula=formula), _computed(test, typed))
    if isinstance(result, FormulaError):
        return say.sentence(result.sentence)
    _keep((*typed, LogFormula(name=name, formula=formula)))
    return ""


def _keep(typed: tuple[LogFormula, ...]) -> None:
    st.session_state[RECORD] = job().model_copy(update={"log_formulas": typed})


def _take_away(number: int) -> None:
    typed = job().log_formulas
    _keep((*typed[:number], *typed[number + 1 :]))


def _list(test: RoadTest, say: Wording) -> None:
    typed = job().log_formulas
    computed = _computed(test, typed)
    for number, each in enumerate(typed):
        name, formula = show.plain(each.name), show.plain(each.formula)
        text, button = st.columns([5, 1], vertical_alignment="center")
        channel = computed.get(each.name)
        if channel is None:
            why = _one(test, each, {name: computed[name] for name in computed})
            text.warning(say("formulas.not_drawn", name=name, formula=formula, why=show.plain(why)))
        else:
            unit = formula_scale(channel.dimension, say)[0]
            key = "undefined" if channel.undefined else "drawn" if unit else "drawn_plain"
            count = whole(channel.undefined, say)
            text.markdown(say(f"formulas.{key}", name=name, formula=formula, unit=unit or "–", count=count))
        button.button(
            say("formulas.away"), key=f"formula-away-{number}-{each.name}", on_click=_take_away, args=(number,),
            width="stretch",
        )  # fmt: skip


# --- a second log


def overlay() -> tuple[RoadTest, float] | None:
    """Return another log to lay over the job's, and by how much it is shifted; kept while pages change."""
    say = reader.say()
    now = session()
    with fields.fold(say("road_test.over_fold"), key=f"over-fold-{now.generation}"):
        own = st.file_uploader(say("road_test.over_log"), key=f"over-{now.generation}")
        if own is not None:
            now.over = SourceFile(own.name, own.getvalue())
        if now.over is None:
            return None
        st.caption(say("road_test.over_dashed", file=show.plain(now.over.name)))
        key = f"shift-{now.generation}-{now.over.sha256}"
        now.offset = fields.number(say("road_test.over_shift"), SHIFT, 0.0, key=key)
        if st.button(say("road_test.over_away"), disabled=own is not None, help=say("road_test.over_away_help")):
            now.over = None
            st.rerun()
        try:
            test = understood(now.over).road_test
        except AtleakError as error:
            st.error(show.plain(error))
            return None
    return None if test is None or not len(test.time) else (test, now.offset)


# --- picture and values


def picture(part: Part, happened: Sequence[Event], road: RoadLeakage | None, diagnosis: Diagnosis) -> None:
    """Draw the part of the log under one cursor, or say that there is nothing to draw."""
    say = reader.say()
    if not any(channel.samples for channel in part.test.channels.values()):
        st.info(say("road_test.empty"))
        return
    # what is computed over the log stays the same object where nothing changed that it rests on
    owner, key = part.whole if road is None else road.extremes, (part.key, say)
    curves = cache(partial(_curves, part, road, diagnosis, say))  # as large as the log: made where asked for, not kept
    with fields.fold(say("road_test.values"), key="log-values") as place:
        if place.open:
            log_form.values_table(kept_with(owner, "values", key, lambda: value_rows(curves(), say), most=2))
            st.caption(say("road_test.values_help"))
    drawn = (*key, show.dark(), tuple(diagnosis.limits.fixed_bands), diagnosis.controller.sha256)
    figure = kept_with(
        owner, "picture", drawn, lambda: figures.log_channels(part.test, curves(), say, happened), most=2
    )
    road_page.under_cursor(figure, f"channels-{part.ends}", partial(look_between, part.whole))
    first, last = part.span
    count = sum(each.stop >= first and each.start <= last for each in happened)
    notes = [say("road_test.picture_help")]
    if count:
        said = "road_test.events_all" if count <= figures.LINES else "road_test.events_lines"
        notes.append(say(said, count=whole(count, say), most=whole(figures.LINES, say)))
    st.caption(" ".join(notes))


def _curves(part: Part, road: RoadLeakage | None, diagnosis: Diagnosis, say: Wording) -> list[Curve]:
    permitted = None if road is None else permitted_pressure(diagnosis.controller, part.test)
    return log_curves(
        part.test, say, formulas=part.formulas, over=part.over, permitted=permitted, road=road, limits=diagnosis.limits
    )


# --- where it was driven


def operating_part(part: Part, road: RoadLeakage | None) -> None:
    """Show, where it is asked for, share and time over engine speed and temperature, or how long a channel had what."""
    say = reader.say()
    with fields.fold(say("operating_map.fold"), key="operating-map") as place:
        if not place.open:
            return
        computed = {each.name: each for each in part.formulas}
        names = [name for name in part.test.channels if part.test.channels[name].samples]
        chosen = st.selectbox(
            say("operating_map.show"),
            ["", *names, *computed],
            key="operating-map-of",
            format_func=lambda name: say("operating_map.map") if not name else say.get("log_quantities", name),
        )
        if not chosen:
            _map(part, road, say)
        else:
            _histogram(part, chosen, computed.get(chosen), say)


def _map(part: Part, road: RoadLeakage | None, say: Wording) -> None:
    scales = channel_scales(part.test, say)
    cells = None
    if "engine_speed" in scales and "atf_temperature" in scales:
        speed, temperature = scales["engine_speed"], scales["atf_temperature"]
        owner = part.whole if road is None else road.extremes
        cells = kept_with(
            owner, "map", (part.ends, say), lambda: operating_map(part.test, road, speed, temperature), most=2
        )
    if cells is None:
        st.info(say("operating_map.map_lacks"))
        return
    show.chart(figures.operating_map_figure(cells, speed[0], temperature[0], say), "operating-map-chart")
    _left_out(cells.left_out, say, say("operating_map.map_help"))


def _histogram(part: Part, name: str, computed: FormulaChannel | None, say: Wording) -> None:
    test = part.test
    if computed is None:
        unit, convert = channel_scales(test, say).get(name, (test.channels[name].unit, as_it_is))
        values, label = test.values(name), say(f"log_quantities.{name}")
    else:
        unit, convert = formula_scale(computed.dimension, say)
        values, label = computed.values, name
        if computed.time is not test.time:
            values = hold(computed.time, computed.values, test.time, test.segments)
    bars = None if values is None else histogram(test, convert(values))
    if bars is None:
        st.info(say("operating_map.no_value"))
        return
    show.chart(figures.histogram_figure(bars, label, unit, say), "histogram-chart")
    _left_out(bars.left_out, say)


def _left_out(seconds: float, say: Wording, help: str = "") -> None:
    said = say("operating_map.left_out", seconds=say.number(seconds, 1)) if seconds > 0.05 else ""
    if text := " ".join(part for part in (help, said) if part):
        st.caption(text)
