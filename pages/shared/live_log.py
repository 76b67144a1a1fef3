"""Follow a log while its logger is writing it: present values beside what is permitted, events as they happen."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import streamlit as st

from atleak.common.errors import AtleakError
from atleak.common.wording import Wording
from atleak.diagnosis.road import RoadFindings
from atleak.engine.road_pressure import permitted_pressure
from atleak.job.case import SourceFile
from atleak.job.watched_log import WatchedLog
from atleak.report.charts.log_figures import log_channels
from atleak.report.tables.road_test import log_curves, present_values, whole
from atleak.report.tables.road_words import event_span
from pages.shared import entrance, fields, reader, show
from pages.shared.cases import PageCase
from pages.shared.state import put_file, remember, session

_EVERY = 1.0  # [s]
_SHOWN, _EVENTS = 120.0, 6  # [s] of main pressure, and the latest events, that are shown


def ask() -> None:
    """Ask in a fold for the path of a log to follow, where it is this computer's user who is asked."""
    say, now = reader.say(), session()
    with fields.fold(say("live.fold"), key=f"live-{now.generation}") as place:
        if not place.open:
            return
        if not entrance.is_of_this_computer():
            st.caption(say("live.elsewhere"))
            return
        st.caption(say("live.what"))
        path = st.text_input(say("live.path"), **fields.kept(f"live-path-{now.generation}", "")).strip().strip('"')
        if st.button(say("live.start"), disabled=now.watched is not None) and path:
            log = WatchedLog(Path(os.path.expanduser(path)), _case())  # noqa: PTH111  the other one refuses the name of no user
            if not log.path.is_absolute():
                st.error(say("live.whole_path"))
                return
            try:
                log.look()
            except AtleakError as error:
                st.error(show.plain(error))
            else:
                now.watched = log
                st.rerun()


def draw() -> None:
    """Show the log that is followed; nothing where none is."""
    log = session().watched
    if log is not None and entrance.is_of_this_computer():
        log.judge_by(_case())
        _follow()


def _case() -> PageCase:
    """Return the job that is shown, without a log."""
    return session().good.with_file("road_test", None)


@st.fragment(run_every=_EVERY)
def _follow() -> None:
    """Show what there is so far; drawn anew by itself, so that nothing that is typed elsewhere on the page is lost."""
    say, log = reader.say(), session().watched
    if log is None:
        st.rerun()
    with st.container(border=True), show.faults():
        try:
            log.look()
        except AtleakError as error:
            log.waits = error
        name, seconds = show.plain((log.file or log.path).name), say.number(log.quiet, 0)
        if log.findings is None:
            st.markdown(say("live.nothing_yet", file=name, seconds=seconds))
        else:
            rows = whole(log.findings.road_test.rows, say)
            st.markdown(say("live.following", file=name, seconds=seconds, rows=rows))
        st.button(say("live.stop"), on_click=_stop, type="primary")
        if log.waits is not None:
            said = "live.waits" if log.findings is None else "live.waits_more"
            st.warning(say(said, why=show.plain(log.waits)))
        if log.findings is not None:
            _show(log, log.findings, say)
        if log.earlier:
            st.markdown(say("live.anew", file=name))
        for number, file in enumerate(log.earlier, start=1):
            label, saved = say("live.earlier", file=file.name, number=number), f"{number}-{file.name}"
            st.download_button(label, file.content, saved, key=f"live-earlier-{number}", on_click="ignore")


def _stop() -> None:
    """Take what was read into the job, as a log that is dropped; for a callback."""
    now = session()
    log, now.watched = now.watched, None
    if log is not None and log.file is not None:
        file = log.file
        remember(lambda say: say("done.taken_in", name=file.name))
        put_file("road_test", SourceFile(file.name, file.content))


def _show(log: WatchedLog, found: RoadFindings, say: Wording) -> None:
    facts = present_values(found, log.controller, say).rows
    st.markdown("\n".join(f"- {show.plain(name)}: **{show.plain(value)}**" for name, value in facts))
    test = found.road_test
    if "main_pressure" in test.channels:
        part = test.window(float(test.time[-1]) - _SHOWN, float(test.time[-1]))
        part = replace(part, channels=MappingProxyType({"main_pressure": part.channels["main_pressure"]}))
        limits = permitted_pressure(log.controller, test)
        if limits is not None:
            inside = np.isin(test.time, part.time)
            limits = limits[0][inside], limits[1][inside]
        st.markdown(f"**{say('live.chart', seconds=say.number(_SHOWN, 0))}**")
        show.chart(log_channels(part, log_curves(part, say, permitted=limits), say), "live-chart")
    if found.events:
        st.markdown(f"**{say('live.happened')}**")
        latest = sorted(found.events, key=lambda event: event.stop)[: -_EVENTS - 1 : -1]
        st.markdown("\n".join(f"- {show.plain(event_span(event, say))}" for event in latest))
