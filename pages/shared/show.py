"""Show results and messages: signs, words, markdown-safe text, tables with coloured verdicts."""

from __future__ import annotations

import base64
import html
import math
import os
import re
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import plotly.graph_objects as go
import plotly.io as pio
import streamlit as st
from plotly.basedatatypes import BaseFigure

from atleak.common.damage import unexpected
from atleak.common.errors import AtleakError, Message, Place
from atleak.common.sentences import Option, Sentence
from atleak.common.style import DARK, SCREEN, look_of
from atleak.common.verdicts import Band, Verdict
from atleak.common.wording import Wording, begun
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.gauge_check import PressureCheck
from atleak.diagnosis.road import NO_LEAKAGE
from atleak.report.charts.drawing import on_dark
from atleak.report.charts.figure import Figure
from atleak.report.charts.screen import drawn
from atleak.report.tables.assumed import assumed_section
from atleak.report.tables.sentences import caveats, fluid_in_state, profile_words, rule_name
from atleak.report.tables.table import VERDICT, Column, Facts, Picture, Points, Section, Table, Text, with_sign
from pages.shared import reader
from pages.shared.state import Refusal

_BOX = {"success": st.success, "warning": st.warning, "error": st.error, "info": st.info}
_MARKDOWN = re.compile(r"([\\`*_{}\[\]()#+|$~<>:!-])")
_ADDRESS = re.compile(r"(?<=:)(?=//)|(?<=\bwww)(?=\.)|(?<=\w@)(?=\w)", re.IGNORECASE)  # becomes a link by itself
_NO_BREAK = "\u2060"  # a sign without width
_IN_CHART = re.compile(r"<(?!/?(?:br|b|extra)>)", re.IGNORECASE)  # what atleak itself writes there stays
SHOWN = 12
PAGE = 50  # rows of a long table
_COLUMN = 135  # pixels of a column of flows, at which its words can be read
HAIR_SPACE = "\u200a"


def plain(text: object) -> str:
    """Escape text of a user or a file, so that markdown shows it sign for sign.

    A sentence of the program, and what an error says, comes in the reader's language and units. An address is no link.
    """
    return with_links(_ADDRESS.sub(_NO_BREAK, _sentence(text)))


def with_links(text: object) -> str:
    """Escape text as `plain` does, but let an address that it shows be a link: in the source of a value."""
    return _MARKDOWN.sub(r"\\\1", _sentence(text)).replace("\n", "  \n")


def _sentence(text: object) -> str:
    if type(text) is str:
        return text
    said = text.sentence if isinstance(text, AtleakError | Place) else text
    return reader.say().sentence(said.with_options(_field) if isinstance(said, Sentence) else said)


def _field(option: Option) -> str:
    """Return the field of the page that does what an option of the command line does."""
    field = reader.say()(f"options.{option.name}")
    return f"{field}: {option.value}" if option.value else field


def in_chart(part: Any) -> Any:
    """Return a part of a chart in whose texts nothing is a link or a style but what atleak writes there itself."""
    if isinstance(part, str):
        return _IN_CHART.sub("&lt;", part)
    if isinstance(part, dict):
        return {name: in_chart(each) for name, each in part.items()}
    if isinstance(part, list | tuple):
        return [in_chart(each) for each in part]
    if isinstance(part, np.ndarray) and part.dtype.kind in "OU":
        return in_chart(part.tolist())
    return part


def refusal(what: str, refused: Refusal, kept: str) -> None:
    """Show why something was refused, and what is shown instead."""
    problems = getattr(refused.error, "problems", (refused.error,))
    say = reader.say()
    head = f"**{say('show.refused', name=plain(refused.name), what=what)}**" if refused.name else f"**{what}**"
    lines = [f"- {plain(problem)}" for problem in problems[:SHOWN]]
    if len(problems) > SHOWN:
        lines.append(f"- {say('show.more', count=len(problems) - SHOWN)}")
    st.error("\n".join([f"{head} {plain(kept)}", "", *lines]))


@contextmanager
def faults() -> Iterator[None]:
    """Show a fault of atleak as a message: what was drawn stays, files can be taken away, the server's log has more.

    With ``ATLEAK_TRACEBACK`` in the environment it ends the page, as it ends a command.
    """
    try:
        yield
    except Exception as error:
        if os.environ.get("ATLEAK_TRACEBACK"):
            raise
        traceback.print_exc()
        st.error(plain(error if isinstance(error, AtleakError) else unexpected(error)))


def tried(what: str, act: Callable[..., object], *given: object) -> bool:
    """Do something in a callback, and return whether it could be done; why it could not, `refused` says."""
    with refusing(what):
        act(*given)
        return True
    return False


@contextmanager
def refusing(what: str) -> Iterator[None]:
    """Keep why something cannot be done in a callback, until `refused` says it on the page."""
    try:
        yield
    except AtleakError as error:
        st.session_state[f"refused-{what}"] = error


def refused(what: str) -> bool:
    """Say once why something could not be done; return whether there was anything to say."""
    error = st.session_state.pop(f"refused-{what}", None)
    if error is not None:
        st.error(plain(error))
    return error is not None


def error_line(error: AtleakError) -> str:
    """Return where the first problem of an error stands; the whole text is at the head of the page."""
    problems = getattr(error, "problems", (error,))
    first = problems[0]
    say = reader.say()
    where = say.sentence(getattr(first, "place", "")) or first
    more = f" ({say('show.more', count=len(problems) - 1)})" if len(problems) > 1 else ""
    return f"{plain(where)}{more}: {say('show.see_head')}"


def judged_otherwise(result_by: str, differs: Sequence[Sentence]) -> str:
    """Say what differs from a result that was kept, made by another version perhaps, as a list."""
    say = reader.say()
    lines = [plain(each) for each in differs[:SHOWN]]
    if len(differs) > SHOWN:
        lines.append(say("show.more", count=len(differs) - SHOWN))
    return "\n- ".join([say("panel.judged_otherwise", version=plain(result_by)), *lines])


def messages(notes: Iterable[Message], about: str, opened: bool = False) -> None:
    """Show warnings in the open and remarks in a fold, each with its place; ``opened``: however many they are."""
    say, notes = reader.say(), list(dict.fromkeys(notes))
    warnings = [message for message in notes if message.level == "warning"]
    remarks = [message for message in notes if message.level != "warning"]
    if warnings:
        with st.expander(say("show.warnings", count=len(warnings), about=about), expanded=opened or len(warnings) <= 3):
            st.warning("\n".join(f"- {_with_place(message)}" for message in warnings))
    if remarks:
        with st.expander(say("show.remarks", count=len(remarks), about=about)):
            st.markdown("\n".join(f"- {_with_place(message)}" for message in remarks))


def _with_place(message: Message) -> str:
    place = plain(message.place or "")
    return plain(message.text) + (f" — *{place}*" if place else "")


def _heading(title: str) -> str:
    """Begin a column's title with a capital, unless it begins with a symbol or a unit: q, µm."""
    return begun(title) if title[1:2].isalpha() and not title.startswith("µ") else title


PAIR_WIDTH = 122  # pixels of a land's name, its number first
_LETTER, _PADDING = 7, 20  # pixels of a letter, and of a cell's sides
_TWO_LINES = 65  # pixels of a row: Streamlit wraps text only in rows of more than 64


def _room_for(names: Sequence[str]) -> tuple[int, int | None]:
    """Return the width of a column in which no word of a name is cut, and the height of rows in which names wrap."""
    words = [len(word) for name in names for word in name.split()]
    wide = max(PAIR_WIDTH, _LETTER * max(words, default=0) + _PADDING)
    return wide, _TWO_LINES if max(map(len, names), default=0) * _LETTER + _PADDING > wide else None


def table(content: Table, *, empty: bool = False, pinned: str = "", **options: Any) -> Any:
    """Show a table, unless ``empty`` without the columns that no row has a value in.

    Numbers are sorted as numbers, verdicts with the worst first; what is None is a dash. The column ``pinned`` stays in
    sight. Further ``options`` are those of `st.dataframe`; returned is what it returns, such as the rows that are
    selected.
    """
    content, say = content if empty else content.filled, content.say
    titled = (replace(column, words=_heading(column.title(say))) for column in content.columns)
    content = replace(content, columns=tuple(titled))
    frame = content.frame(rounded=True)
    style, config = frame.style, {}
    written: dict[Any, str | Callable[[object], str] | None] = {}
    for heading, column in zip(content.headings, content.columns, strict=True):
        config[heading] = st.column_config.Column(help=column.help(say), width=column.width)
        if column.is_number:
            written[heading] = partial(column.written, say=say)
        elif any(isinstance(value, int) for value in frame[heading]):  # gears are numbers and R
            frame[heading] = frame[heading].map(str)
        levels = [column.judged(item).level for item in content.rows]
        if column.kind == VERDICT:
            signs = zip(levels, frame[heading], strict=True)
            frame[heading] = [_sorted_verdict(level, say) if level else words or "–" for level, words in signs]
        elif any(levels):
            written.pop(heading, None)
            for level in set(levels):
                rows = [number for number, each in enumerate(levels) if each == level]
                style = style.format(partial(_judged, column, level, say), subset=pd.IndexSlice[rows, [heading]])
        if any(levels):
            shades = ["" if level is None else colours(level) for level in levels]
            style = style.apply(lambda _, shades=shades: shades, subset=[heading])
        if column.key == pinned:
            wide, options["row_height"] = _room_for([str(cell) for cell in frame[heading]])
            config[heading] = st.column_config.TextColumn(width=wide, pinned=True)
    if written:
        style = style.format(written, subset=list(written))
    return st.dataframe(style, hide_index=True, width="stretch", column_config=config, placeholder="–", **options)


def _judged(column: Column, level: Verdict | Band | None, say: Wording, value: object) -> str:
    """Return what a cell with a verdict shows: a number or words with the verdict's sign, a dash for nothing."""
    if isinstance(value, float):
        value = None if math.isnan(value) else column.written(value, say)
    return "–" if value is None else with_sign(str(value), level)


def paged(count: int, rows_from: Callable[[int], Table], key: str, mode: str) -> list[Any]:
    """Show a long table page by page; return the items of the rows that are picked."""
    pages, page = -(-count // PAGE), 1
    if pages > 1:
        page = st.selectbox(reader.say()("job_book.page", pages=pages), range(1, pages + 1), key=f"{key}-of-{pages}")
    content = rows_from(PAGE * (page - 1))
    event = table(content, empty=True, key=f"{key}-{page}", on_select="rerun", selection_mode=mode)
    return [content.rows[number] for number in event.selection.rows if number < len(content.rows)]


def downloads(name: str, key: str, files: Mapping[str, tuple[str, Any]], tips: Mapping[str, str]) -> None:
    """Offer files side by side by their labels: each the ending of its name, and its content or what writes that."""
    with st.container(horizontal=True):
        for label, (suffix, content) in files.items():
            st.download_button(
                label, content or "", f"{name}.{suffix}", key=f"{key}-{suffix}", on_click="ignore",
                help=tips.get(label), disabled=content is None,
            )  # fmt: skip


def section(content: Section, name: str) -> None:
    """Show what stands below the title of a section; its tables are folded in where they have a title.

    The charts of a page are told by ``name`` and their own.
    """
    for part in content.parts:
        if isinstance(part, Text):
            box = st.write if part.level is None else _BOX[look_of(part.level).box]
            (st.caption if part.small else box)(plain(part.words))
        elif isinstance(part, Points):
            st.markdown("\n".join(f"- {plain(item)}" for item in part.items))
        elif isinstance(part, Facts):
            st.markdown(" · ".join(f"{plain(fact)}: **{plain(value)}**" for fact, value in part.rows))
        elif isinstance(part, Picture):
            chart(drawn(part.chart, reader.say()), f"{name}-{part.name}")
            if part.caption:
                st.caption(plain(part.caption))
        elif part.title:
            with st.expander(part.title):
                table(part)
        else:
            table(part)


def _sorted_verdict(level: Verdict | Band, say: Wording) -> str:
    """Return sign and word of a verdict.

    A table's text column is sorted by collation, in which a space comes before any sign: the worse a verdict, the
    more hair spaces stand before it.
    """
    rank = (level.verdict if isinstance(level, Band) else level).rank
    return HAIR_SPACE * rank + say.signed(level)


def gauge_banner(check: PressureCheck) -> None:
    """Show the worst verdict on any gauge reading in a box of its colour, and what gave it."""
    say, verdict, deciding = reader.say(), check.verdict, check.deciding
    if verdict is None or deciding is None:
        st.info(say("gauge_page.none_judged"))
        return
    judged = sum(each.verdict is not None for each in check.readings)
    rule, sure = rule_name(deciding.rule, say), say.get("decisions", deciding.decision)
    because = say("gauge_page.because", rule=rule) if verdict.flagged else ""
    said = say("gauge_page.banner", because=because, decision=sure, judged=judged, count=len(check.readings))
    _BOX[look_of(verdict).box](f"**{say.signed(verdict)}**{plain(said)}")


def colours(verdict: Verdict | Band) -> str:
    """Return the ground and the ink of a verdict's cell as CSS; an empty text where it stays plain."""
    look = look_of(verdict)
    return f"background-color: {look.screen}; color: {look.on_screen}" if look.on_screen else ""


def remarks(diagnosis: Diagnosis) -> dict[str, list[Message]]:
    """Return all that is remarked, each remark once, by the key of what it is about."""
    by_subject = {
        "sheet": [*(diagnosis.readings.messages if diagnosis.readings else ())],
        "uncertainty": [*(diagnosis.uncertainty.messages if diagnosis.uncertainty else ())],
        "log": [*(diagnosis.log.road_test.messages if diagnosis.log else ())],
        "rest": list(diagnosis.messages),
    }
    by_subject["sheet"] += [message for land in diagnosis.lands for message in land.messages]
    by_subject["log"] += diagnosis.road.messages if diagnosis.road else ()
    by_subject["log"] += [each for each in diagnosis.messages if diagnosis.log and each.code == NO_LEAKAGE]
    said: set[Message] = set()
    for about, notes in by_subject.items():
        by_subject[about] = [note for note in dict.fromkeys(notes) if note not in said]
        said.update(notes)
    return by_subject


def basis(diagnosis: Diagnosis) -> None:
    """Show what the result rests on: what is assumed and what that does to the verdict, remarks, and the sources."""
    say = reader.say()
    for sentence in caveats(diagnosis, say):
        st.markdown(plain(sentence))
    section(Section("assumed", "", assumed_section(diagnosis, say).parts[1:]), "assumed")  # the first is a caveat
    for about, notes in remarks(diagnosis).items():
        messages(notes, say(f"about.{about}"), opened=True)
    lines = [
        f"- {say(f'slots.{name}')}: **{plain(called)}** — {with_links(say.name(getattr(diagnosis, name).source))}"
        for name, called in (
            ("controller", say.name(diagnosis.controller.name)),
            ("fluid", fluid_in_state(diagnosis, say)),
            ("limits", say.name(diagnosis.limits.name)),
        )
    ]
    lines.append(f"- {say('facts.profile')}: **{plain(profile_words(diagnosis.profile, say))}**")
    st.markdown("\n".join([f"**{say('show.rests_on')}**", "", *lines]))


def dark() -> bool:
    """Tell whether the browser shows the dark theme."""
    return st.context.theme.type == "dark"


class _Ready(BaseFigure):  # type: ignore[misc]
    """A figure in which plotly has nothing left to check: Streamlit asks it for its dictionary alone."""

    def __init__(self, spec: dict[str, Any]) -> None:
        self.__dict__["spec"] = spec

    def to_dict(self) -> dict[str, Any]:
        return self.__dict__["spec"]


@cache
def _template(name: str) -> dict[str, Any]:
    return dict(pio.templates[name].to_plotly_json())


def chart(
    figure: Figure | go.Figure,
    key: str,
    on_span: Callable[[float, float], None] | None = None,
    *,
    empty: str = "",
) -> None:
    """Show a figure with words and error bars in the theme's ink, where the usual grey is too pale to read.

    A finger that starts on it scrolls the page; the figure's own toolbar zooms. With ``on_span``, dragging the mouse
    across it marks a stretch of its x axis and calls that with its ends. Of a figure without a point ``empty`` is said,
    or that there is nothing to draw yet.
    """
    ink = (DARK if dark() else SCREEN).ink
    spec = figure.to_dict()
    traces, layout = spec["data"], spec["layout"]
    if not any(_points(trace) for trace in traces):
        st.caption(empty or reader.say()("show.nothing_to_draw"))
        return
    layout["template"] = _template(pio.templates.default)  # whose colours Streamlit replaces by those of its theme
    for name in [name for name in layout if name.startswith(("xaxis", "yaxis"))]:
        axis = layout[name] = {"title": {}, **layout[name]}
        axis["tickfont"] = {**axis.get("tickfont", {}), "color": ink}
        axis["title"] = {**axis["title"], "font": {**axis["title"].get("font", {}), "color": ink}}
    for note in layout.get("annotations", []):
        note["font"] = {**note.get("font", {}), "color": ink}
    layout["separators"] = f"{reader.say().decimal}\u00a0"  # of decimals, of thousands
    layout["legend"] = {**layout.get("legend", {}), "font": {"color": ink}}
    layout |= {"dragmode": False} if on_span is None else {"dragmode": "select", "selectdirection": "h"}
    for trace in traces:
        if trace["type"] == "scatter":
            trace["textfont"] = {**trace.get("textfont", {}), "color": ink}
        if trace.get("error_x", {}).get("color") == SCREEN.soft:
            trace["error_x"]["color"] = ink
        if trace.get("marker", {}).get("color") == SCREEN.ink:
            trace["marker"] = {**trace["marker"], "color": ink, "line": {**trace["marker"]["line"], "color": ink}}
        if "colorbar" in trace:
            title = {**trace["colorbar"]["title"], "font": {"color": ink}}
            trace["colorbar"] = {**trace["colorbar"], "title": title, "tickfont": {"color": ink}}
    marked: Any = "ignore" if on_span is None else partial(_spanned, key, on_span)
    st.plotly_chart(_Ready(in_chart(spec)), key=key, on_select=marked, selection_mode="box")


def _points(trace: dict[str, Any]) -> int:
    """Count what a trace has to draw."""
    return max((len(trace[name]) for name in ("x", "y", "z") if trace.get(name) is not None), default=0)


def _spanned(key: str, on_span: Callable[[float, float], None]) -> None:
    boxes = st.session_state[key]["selection"]["box"]
    if boxes:
        ends = sorted(float(end) for end in boxes[-1]["x"])
        on_span(ends[0], ends[-1])


def component(name: str) -> Callable[..., Any]:
    """Return the component that the files of its name beside this one make."""
    files = (Path(__file__).with_name(f"{name}.{kind}") for kind in ("html", "css", "js"))
    html, css, js = (file.read_text(encoding="utf-8") for file in files)
    return st.components.v2.component(f"atleak_{name}", html=html, css=css, js=js)


def svg(drawing: str, label: str, columns: int = 0) -> None:
    """Show a drawing in the theme's ink, wide enough to be read; on a phone it scrolls inside its frame."""
    data = base64.b64encode((on_dark(drawing) if dark() else drawing).encode()).decode("ascii")
    st.html(
        f'<div style="padding:8px;overflow-x:auto">'
        f'<img alt="{html.escape(label)}" src="data:image/svg+xml;base64,{data}" '
        f'style="min-width:{_COLUMN * columns or 640}px;width:100%;max-width:1100px;display:block;margin:auto"></div>'
    )


def named(what: str, number: str) -> str:
    """Return a file's name without its ending: what it is, and the workshop's number as far as it can stand."""
    kept = "".join(sign if sign.isalnum() or sign in "-_" else "_" for sign in number.strip())
    return f"{what}_{kept}" if kept else what
