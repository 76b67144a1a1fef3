"""Show how a log was understood, and ask what its file leaves open."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import pandas as pd
import streamlit as st

from atleak.catalogue.written_numbers import INTERVAL, read_number, written
from atleak.common.errors import AtleakError
from atleak.common.memory import kept_with
from atleak.common.units import unit_names
from atleak.common.wording import Wording
from atleak.engine.road_leakage import OPERATING_POINTS
from atleak.job.case import Case, Pairs, SourceFile
from atleak.measurements.road_test import QUANTITIES
from atleak.readers.logs import FORMATS, NOT_LOGGED, Ambiguous, LogColumn, Understood, describe
from atleak.readers.logs.understood import workshop_unit
from atleak.report.tables.road_test import channel_scales, short, whole
from pages.shared import fields, reader, show
from pages.shared.cases import Kept, PageCase, columns_of, remember_columns, remembered_columns, understood
from pages.shared.state import choose, put_file, session

NEEDED = ("main_pressure", "engine_speed", "atf_temperature", "gear")  # what results rest on most, asked first
ASK = "\x00choose"  # no column has such a name
_TRIED = "columns-tried"
_NUMBERS = frozenset(
    ("log_least", "log_mean", "log_largest", "log_first", "log_second", "log_samples", "log_suspect", "log_rate")
)


@dataclass(frozen=True)
class Tried:
    """The columns chosen last for a log, remembered only once the log was taken with them."""

    sha256: str
    columns: Mapping[str, str]
    units: Mapping[str, str]
    constants: Pairs = ()


def pending(case: PageCase) -> tuple[SourceFile, Understood] | None:
    """Return the log to show: the one refused for an open question, else that of the job."""
    refused = session().refused.get("road_test")
    if refused is not None and refused.file is not None:
        file, choices = refused.file, Case()
        if (tried := _tried_for(file)) is not None:
            columns, units = tuple(tried.columns.items()), tuple(tried.units.items())
            choices = Case(columns=columns, units=units, constants=tried.constants, remember=False)
        for chosen in (choices, Case()):  # the file is no log at all, or not with these columns
            with suppress(AtleakError):
                return file, understood(file, chosen)
    return None if case.road_test is None else (case.road_test, Kept().log(case))


def _tried_for(file: SourceFile) -> Tried | None:
    """Return the columns that were chosen for this log and not taken."""
    tried: Tried | None = st.session_state.get(_TRIED)
    return None if tried is None or tried.sha256 != file.sha256 else tried


def refused(file: SourceFile) -> bool:
    """Tell whether this log, or a column chosen for it, was refused: what was understood of it then says why."""
    refusal = session().refused.get("road_test")
    return _tried_for(file) is not None or (refusal is not None and refusal.file == file)


def keep_what_was_taken(case: PageCase) -> None:
    """Remember the columns chosen last, now that the log was taken with them; forget that they were tried."""
    file, refusal = case.road_test, session().refused.get("road_test")
    if _TRIED not in st.session_state or file is None or refusal is not None:
        return
    if (
        (tried := _tried_for(file)) is not None
        and dict(case.columns) == tried.columns
        and dict(case.units) == tried.units
    ):
        if not Kept().log(case).uses(tried.columns):
            return  # the form shows them, and why they were not used
        why = remember_columns(file, dict(tried.columns), dict(tried.units))
        session().unkept = (file.sha256, why) if why else ("", "")
    del st.session_state[_TRIED]


def draw(file: SourceFile, log: Understood, case: PageCase) -> None:
    """Show how a log was understood, and ask what it leaves open."""
    say = reader.say()
    st.markdown(f"**{show.plain(log.file)}**: {show.plain(facts(log, say))}")
    if log.problem is not None:
        st.error(show.plain(log.problem))
    form(file, log, case)
    if log.road_test is not None:
        show.messages(log.messages, say("road_test.about_log"), opened=refused(file))


def facts(log: Understood, say: Wording) -> str:
    """Return format, encoding, decimal sign, rows, duration and breaks of a log in one line."""
    parts = [say.sentence(FORMATS.get(log.format, log.format)), log.encoding]
    if log.decimal is not None:
        parts.append(say("road_test.decimal_comma" if log.decimal == "," else "road_test.decimal_point"))
    test = log.road_test
    if test is not None:
        breaks = len(test.segments) - 1
        parts.append(say("road_test.rows", rows=whole(test.rows, say), seconds=say.number(test.duration, 1)))
        parts.append(say("road_test.breaks", count=whole(breaks, say)) if breaks > 0 else say("road_test.no_break"))
    return ", ".join(part for part in parts if part)


def understood_table(log: Understood) -> None:
    """Show what was understood of every column, the time first."""
    say = reader.say()
    values_table(kept_with(log, "columns", say, lambda: _understood_rows(log, say)))


def _understood_rows(log: Understood, say: Wording) -> list[dict[str, Any]]:
    rows, test = [], log.road_test
    scales = {} if test is None else channel_scales(test, say)
    for row in describe(log)["columns"]:
        name, unit, rate = row["quantity"], row["unit"] or "–", row["sampling_hz"]
        in_unit, ends = row["value_unit"], (row["min"], row["max"])
        if name in scales and test is not None:
            written = workshop_unit(name, test.channels[name])
            in_unit, shown = scales[name]
            ends = tuple(end if end is None or written is None else shown(written.to_si(end)) for end in ends)
        rows.append(
            {
                "log_quantity": say(f"log_quantities.{name}"),
                "log_column": row["column"] or row["source"],
                "log_unit": say("road_test.assumed", unit=unit) if row["unit_assumed"] else unit,
                "log_kind": say(f"log_kinds.{row['kind']}") if name.endswith("pressure") else None,
                "log_least": _number(ends[0], say),
                "log_largest": _number(ends[1], say),
                "log_in": in_unit,
                "log_samples": whole(row["samples"], say),
                "log_suspect": whole(row["suspect_samples"], say),
                "log_rate": None if rate is None else short(rate, say),
            }
        )
    return rows


def _number(value: float | None, say: Wording) -> str | None:
    return None if value is None else say.plain(value, 7) if abs(value) < 1e6 else say.number(value, 0)


def _frame(rows: list[dict[str, Any]], say: Wording) -> pd.DataFrame:
    return pd.DataFrame(rows).rename(columns=lambda key: say(f"columns.{key}"))


def _config(rows: list[dict[str, Any]], say: Wording) -> dict[str, Any]:
    """Return how the columns of written values look: numbers stand on the right."""
    helps, config = say.table("column_help"), {}
    for key in rows[0] if rows else ():
        side: Any = "right" if key in _NUMBERS else "left"
        config[say(f"columns.{key}")] = st.column_config.TextColumn(help=helps.get(key), alignment=side)
    return config


def values_table(rows: list[dict[str, Any]]) -> None:
    """Show rows of values that are written already, by the keys of their columns."""
    say = reader.say()
    st.dataframe(_frame(rows, say), hide_index=True, width="stretch", column_config=_config(rows, say), placeholder="–")


# --- the form


@dataclass(frozen=True)
class _Asked:
    """What is asked about one log: its columns, what was chosen so far, and where it needs an answer."""

    log: Understood
    columns: tuple[LogColumn, ...]
    chosen: Mapping[str, str]
    units: Mapping[str, str]
    say: Wording
    open: Mapping[str, Ambiguous] = field(default_factory=dict)
    constants: Pairs = ()

    def taken(self, name: str) -> str | None:
        """Return the column from which a quantity is taken now."""
        test = self.log.road_test
        channel = None if test is None else test.channels.get(name)
        return None if channel is None else channel.column or None

    @property
    def missing(self) -> list[str]:
        """Return what the results need that the log lacks, so far as nobody said that it does."""
        return [name for name in NEEDED[:3] if self.taken(name) is None and self.chosen.get(name) != NOT_LOGGED]

    @property
    def recognised(self) -> bool:
        return self.log.road_test is not None and bool(self.log.road_test.channels)

    def options(self, name: str) -> list[str]:
        """Return the columns to choose from, the likeliest first."""
        kind = QUANTITIES[name].unit_kind
        offered = self.open[name].candidates if name in self.open else ()
        known = [each for each in self.columns if each.numbers or each.words] or []

        def rank(column: LogColumn) -> tuple[bool, bool, bool, bool]:
            of_kind = column.quantity is not None and QUANTITIES[column.quantity].unit_kind == kind
            return column.label not in offered, column.quantity != name, not of_kind, not column.numbers

        labels = [each.label for each in sorted(known, key=rank)] or [each.label for each in self.log.headings]
        start = [ASK, NOT_LOGGED] if name in self.open else [NOT_LOGGED]
        current = self.start(name)
        extra = [current] if current is not None and current not in (*start, *labels) else []
        return [*start, *extra, *dict.fromkeys(labels)]

    def start(self, name: str) -> str | None:
        """Return what is chosen at first: what was chosen before, what is taken, or the guess."""
        if name == "time":
            return self.chosen.get(name)
        guess = self.open[name].guess if name in self.open else None
        return self.chosen.get(name) or self.taken(name) or guess


def form(file: SourceFile, log: Understood, case: PageCase) -> None:
    """Ask for columns and units, where the file leaves them open or the user knows better."""
    say = reader.say()
    asked = _asked(file, log, case, say)
    for question in log.ambiguous:
        quantity = say(f"log_quantities.{question.quantity}")
        st.warning(say("mapping.ask", quantity=quantity, why=show.plain(question.why)))
    if session().unkept[0] == file.sha256:
        st.warning(say("mapping.not_kept", why=show.plain(session().unkept[1])))
    wanting = bool(log.ambiguous or refused(file) or not asked.recognised or (asked.missing and log.unused))
    key = f"columns-{session().generation}-{file.sha256}-{wanting}"
    with fields.fold(say("mapping.fold"), key=key, opened=wanting) as place:
        if not place.open:
            return
        asked = _asked(file, log, case, say, columns_of(file))
        _say_what_is_wanting(asked, file)
        _columns_table(asked)
        with st.form("columns", border=False):
            _fields(asked, file)


def _asked(
    file: SourceFile, log: Understood, case: PageCase, say: Wording, columns: tuple[LogColumn, ...] = ()
) -> _Asked:
    constants = case.constants if file == case.road_test else ()
    if (tried := _tried_for(file)) is not None:
        chosen, units, constants = dict(tried.columns), dict(tried.units), tried.constants
    else:
        earlier = remembered_columns(file) if file != case.road_test or case.remember else None
        chosen, units = (dict(earlier.mapping), dict(earlier.units)) if earlier is not None else ({}, {})
        if file == case.road_test:
            chosen |= dict(case.columns)
            units |= dict(case.units)
    questions = {question.quantity: question for question in log.ambiguous}
    return _Asked(log, columns, chosen, units, say, questions, constants)


def _say_what_is_wanting(asked: _Asked, file: SourceFile) -> None:
    say = asked.say
    with st.container():
        if _tried_for(file) is not None:
            st.warning(say("mapping.not_taken"))
        if not asked.recognised:
            st.info(say("mapping.nothing"))
        elif asked.missing:
            named = ", ".join(say(f"log_quantities.{name}") for name in asked.missing)
            st.info(say("mapping.missing", quantities=named))


def _columns_table(asked: _Asked) -> None:
    """Show every column with its range and its course, in the file's own unit."""
    say = asked.say
    taken = {asked.taken(name): say(f"log_quantities.{name}") for name in QUANTITIES}
    taken[asked.log.time_label or None] = say("log_quantities.time")
    rows = [
        {
            "log_column": each.label,
            "log_unit": each.unit,
            "log_least": _number(each.least, say) if each.numbers else ", ".join(each.words) or None,
            "log_largest": _number(each.largest, say),
            "log_course": list(each.curve) or None,
            "log_taken": taken.get(each.label),
        }
        for each in asked.columns
    ]
    if not rows:
        return
    config = _config(rows, say)
    config[say("columns.log_course")] = st.column_config.LineChartColumn(width="medium")
    st.dataframe(_frame(rows, say), hide_index=True, width="stretch", column_config=config, placeholder="–")


def _fields(asked: _Asked, file: SourceFile) -> None:
    say = asked.say
    picked, units = {}, {}
    others = tuple(name for name in QUANTITIES if name not in NEEDED)
    for title, names in (("mapping.first", NEEDED), ("mapping.others", others)):
        st.markdown(f"**{say(title)}**")
        for first in range(0, len(names), 2):
            places = st.columns([3, 1, 3, 1])
            for name, left, right in zip(names[first : first + 2], places[::2], places[1::2], strict=False):
                picked[name], units[name] = _field(asked, file, name, left, right)
    lacking, usable = _lacking(asked, file)
    st.caption(say("mapping.remembered_here"))
    used = st.form_submit_button(say("mapping.use"))
    place = st.container()
    if used and usable:
        _use(asked, file, picked, {name: unit for name, unit in units.items() if unit}, lacking, place)


def _lacking(asked: _Asked, file: SourceFile) -> tuple[dict[str, float | str], bool]:
    """Ask what stands for a clock and for a main pressure that the log lacks.

    Returns
    -------
    tuple[dict[str, float | str], bool]
        what stands for them, and whether what was typed can be used.
    """
    say, lacking, given, usable = asked.say, dict(asked.constants), dict(asked.constants), True
    without_clock, without_pressure = not asked.log.time_label, asked.taken("main_pressure") is None
    if without_clock or without_pressure:
        st.markdown(f"**{say('mapping.lacking')}**")
    if without_clock:
        first = written(given["time"], INTERVAL, say) if "time" in given else ""
        typed = st.text_input(say("mapping.interval"), first, key=f"interval-{file.sha256}").strip()
        lacking.pop("time", None)
        if typed:
            interval = read_number(typed, INTERVAL.to(say))
            if interval.value is None:
                usable = False
                fields.fault(interval.doubt, INTERVAL.name, "")
            else:
                lacking["time"] = interval.value
    if without_pressure:
        kept = given.get("main_pressure") == OPERATING_POINTS
        chosen = st.checkbox(say("mapping.assume_points"), kept, key=f"points-{file.sha256}")
        if chosen:
            lacking["main_pressure"] = OPERATING_POINTS
        elif kept:
            del lacking["main_pressure"]
    return lacking, usable


def _field(asked: _Asked, file: SourceFile, name: str, left: Any, right: Any) -> tuple[str, str]:
    say, kind, options = asked.say, QUANTITIES[name].unit_kind, asked.options(name)
    start = asked.start(name)
    picked = left.selectbox(
        say(f"log_quantities.{name}"),
        options,
        options.index(start) if start in options else 0,
        key=f"column-{file.sha256}-{name}",
        format_func=partial(_option, asked, name),
    )
    if kind is None:
        return picked, ""
    names = ["", *unit_names(kind)]
    unit = right.selectbox(
        say("mapping.unit"),
        names,
        names.index(asked.units[name]) if asked.units.get(name) in names else 0,
        key=f"unit-{file.sha256}-{name}",
        format_func=lambda each: each or say("mapping.as_stated"),
    )
    return picked, unit


def _option(asked: _Asked, name: str, option: str) -> str:
    """Return a column with its range, so that the right one can be told from its numbers."""
    say = asked.say
    if option == ASK:
        return say("mapping.choose")
    if option == NOT_LOGGED and name == "time":
        label = asked.log.time_label
        return say("mapping.as_understood", column=label) if label else say("mapping.as_understood_without")
    if option == NOT_LOGGED:
        return say("mapping.not_in_log")
    column = next((each for each in asked.columns if each.label == option), None)
    if column is None or not (column.numbers or column.words):
        return option
    if not column.numbers:
        return say("mapping.words", label=option, words=", ".join(column.words[:3]))
    least, largest = _number(column.least, say), _number(column.largest, say)
    return say("mapping.range", label=option, least=least, largest=largest, unit=column.unit or "").rstrip()


def _use(
    asked: _Asked,
    file: SourceFile,
    picked: Mapping[str, str],
    units: Mapping[str, str],
    lacking: Mapping[str, float | str],
    place: Any,
) -> None:
    """Read the log with the columns that were picked; they are remembered once it was taken with them."""
    say = asked.say
    columns: dict[str, str] = {}
    for name, label in picked.items():
        known = name in asked.chosen or name in asked.open or asked.taken(name) is not None
        if label == NOT_LOGGED:
            if known and name != "time":
                columns[name] = NOT_LOGGED
        elif label != ASK and (name in asked.chosen or label != asked.taken(name)):
            columns[name] = label
    in_use = Counter(label for label in picked.values() if label not in (ASK, NOT_LOGGED))
    twice = [label for label, count in in_use.items() if count > 1]
    for label in twice:
        names = ", ".join(say(f"log_quantities.{name}") for name, each in picked.items() if each == label)
        place.error(say("mapping.twice", column=show.plain(label), quantities=names))
    if twice:
        return
    constants = tuple(lacking.items())
    st.session_state[_TRIED] = Tried(file.sha256, columns, dict(units), constants)
    put_file("road_test", file)
    choose(columns=tuple(columns.items()), units=tuple(units.items()), constants=constants, remember=False)
    st.rerun()
