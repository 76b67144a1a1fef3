"""Show a valve body's components as a picture to press, one opened pair, and tables that a phone can show as cards."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from pathlib import Path
from typing import Any

import streamlit as st

from atleak.catalogue.controller import Controller
from atleak.common.style import look_of
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.report.charts.drawing import component_svgs, on_dark, spool_svg
from atleak.report.pdf.printed_names import PrintedNames
from atleak.report.tables.lands import (
    ON_PAPER,
    OpenedLand,
    component_verdict,
    components_worst_first,
    opened_lands,
    pair_table,
)
from atleak.report.tables.names import component_words, has_number, land_words
from atleak.report.tables.sentences import land_in_words
from atleak.report.tables.table import Table, leveled
from pages.shared import address, reader, show
from pages.shared.state import job, session

OPENED = "pair"  # the opened component's name in the address
_HERE = Path(__file__).parent
_HTML = st.components.v2.component(
    "atleak_pairs",
    html='<div class="pairs"></div>',
    css=(_HERE / "pairs.css").read_text(encoding="utf-8"),
    js=(_HERE / "pairs.js").read_text(encoding="utf-8"),
)


@st.fragment
@show.faults()
def section(diagnosis: Diagnosis, advised: Callable[[LandDiagnosis], str]) -> None:
    """Show the picture, the opened pair and the flagged pairs; opening one computes nothing else of the page again."""
    say = reader.say()
    picture(diagnosis, say)
    choice(diagnosis, say)
    opened_pair(diagnosis, say, advised)
    st.subheader(say("diagnosis.flagged_pairs"), anchor="flagged-pairs")
    if diagnosis.flagged:
        table(pair_table(diagnosis, diagnosis.flagged, say).without(*ON_PAPER), "flagged", pressable=True)
        show.what_is_shown(diagnosis)
    else:
        st.write(say("diagnosis.none_flagged"))


def opened(diagnosis: Diagnosis) -> str | None:
    """Return the component whose pair is open; None where none is."""
    name = address.kept(OPENED)
    return name if name in components_worst_first(diagnosis) else None


def picture(diagnosis: Diagnosis, say: Wording) -> None:
    """Show every component as a button with its spool, in the colours of its lands' verdicts."""
    verdicts: dict[tuple[str, int], str] = {land.key: land.verdict for land in diagnosis.lands}
    drawings = component_svgs(diagnosis.controller, verdicts)
    buttons = []
    for name, drawing in drawings.items():
        level = component_verdict(diagnosis, name)
        edge = look_of(level).screen
        number = f"<b>{escape(name)}</b> " if has_number(diagnosis.controller, name) else ""
        words = f"<small>{number}{escape(say.name(diagnosis.controller.components[name]))}</small>"
        buttons.append(
            f'<button data-pair="{escape(name)}" style="border-left-color:{edge}">{words}{_themed(drawing)}'
            f"{leveled(say.signed(level), level)}</button>"
        )
    mount(f'<div class="grid">{"".join(buttons)}</div>', key="picture", pressed=opened(diagnosis), on_pair=_open)


def choice(diagnosis: Diagnosis, say: Wording) -> None:
    """Offer the same components in a list, for the keyboard."""
    controller = diagnosis.controller
    key = f"open-pair-{diagnosis.controller.id}-{session().generation}"
    st.session_state[key] = opened(diagnosis)
    st.selectbox(
        say("diagnosis.open_pair"),
        components_worst_first(diagnosis),
        index=None,
        format_func=lambda name: component_words(controller, name, say),
        placeholder=say("diagnosis.no_pair"),
        key=key,
        on_change=lambda: address.keep(OPENED, st.session_state[key] or ""),
    )


def opened_pair(diagnosis: Diagnosis, say: Wording, advised: Callable[[LandDiagnosis], str]) -> None:
    """Show everything that is known of the opened component; nothing where none is open."""
    name = opened(diagnosis)
    if name is None:
        return
    verdicts: dict[tuple[str, int], str] = {land.key: land.verdict for land in diagnosis.lands}
    drawing = _themed(spool_svg(diagnosis.controller, name, verdicts, say))
    heading = f"<h3>{escape(component_words(diagnosis.controller, name, say))}</h3>"
    lands = "".join(_land(each, say, advised(each.land)) for each in opened_lands(diagnosis, name, say))
    with st.container(border=True, key="opened-pair"):
        mount(f'{heading}<div class="drawing">{drawing}</div><div class="lands">{lands}</div>', key=f"opened-{name}")


def table(content: Table, key: str, *, pressable: bool = False) -> None:
    """Show a table; on a phone each row is a card. ``pressable`` opens a row's pair by its second cell."""
    opens = (lambda land: land.key[0]) if pressable else None
    mount(content.html(opens, "cards"), key=key, on_pair=_open if pressable else None)


def mount(html: str, *, key: str, pressed: str | None = None, on_pair: Callable[[str], None] | None = None) -> None:
    """Show escaped HTML in the page's theme; ``on_pair`` is called with the name on a button that is pressed."""
    own = f"{key}-{session().generation}"

    def pair_pressed() -> None:
        name: Any = st.session_state[own].get("pair")
        if name and on_pair is not None:
            on_pair(str(name))

    _HTML(key=own, data={"html": html, "opened": pressed or ""}, on_pair_change=pair_pressed)


def _open(name: str) -> None:
    """Open a component's pair, or close it where it is the one that is open."""
    address.keep(OPENED, "" if address.kept(OPENED) == name else name)


def _themed(drawing: str) -> str:
    return on_dark(drawing) if show.dark() else drawing


def _land(each: OpenedLand, say: Wording, advice: str) -> str:
    """Return one land; of one that is not flagged numbers and limits are folded."""
    _, number = each.land.key
    facts = "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>" for name, value in each.facts)
    said = "".join(f"<li>{escape(line)}</li>" for line in filter(None, (*each.why, advice, *each.does)))
    tables = each.shares.html() + (each.rules.html() if each.rules.rows else "")
    verdict = each.land.verdict
    heading = f"<h4>{escape(say('diagnosis.land', land=number))} {leveled(say.signed(verdict), verdict)}</h4>"
    opened = " open" if verdict.flagged else ""
    fold = f"<details{opened}><summary>{escape(say('diagnosis.numbers'))}</summary><dl>{facts}</dl>{tables}</details>"
    return f"<section>{heading}<ul>{said}</ul>{fold}</section>"


def advised(diagnosis: Diagnosis, say: Wording) -> Callable[[LandDiagnosis], str]:
    """Return what says in the reader's language how a land's open verdict can be decided."""
    return PrintedNames(diagnosis, job(), say).advice


def pair_name(controller: Controller, component: str, land: int) -> str:
    """Return component, land and name, so that a narrow column cuts the name only: ``25/1 main pressure valve``."""
    return land_words(controller, (component, land), reader.say())


def advice(diagnosis: Diagnosis, advised: Callable[[LandDiagnosis], str], say: Wording) -> list[str]:
    """Return what would make the open verdicts clear, one line of markdown per land of which that can be said."""
    return [
        f"- **{show.plain(land_in_words(diagnosis, land.key, say))}**: {show.plain(said)}"
        for land in diagnosis.ranked
        if (said := advised(land))
    ]
