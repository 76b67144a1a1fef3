"""Show a valve body's components as a picture to press, one opened pair, and tables that a phone can show as cards."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any

import streamlit as st

from atleak.catalogue.castings import load_casting
from atleak.common.style import look_of
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording, begun
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.uncertainty import UnitUncertainty
from atleak.report.charts import land_figures as figures
from atleak.report.charts.casting import casting_drawing
from atleak.report.charts.drawing import component_svgs, on_dark, spool_svg
from atleak.report.printed_names import PrintedNames
from atleak.report.tables.clearances import budget_rows
from atleak.report.tables.lands import (
    ON_PAPER,
    OpenedLand,
    component_verdict,
    components_worst_first,
    leader,
    opened_lands,
    pair_table,
)
from atleak.report.tables.names import component_words, has_number
from atleak.report.tables.sentences import fluid_in_state, land_in_words
from atleak.report.tables.table import Column, Table, leveled
from pages.shared import address, conditions, fields, reader, show
from pages.shared.state import job, session

OPENED = "pair"  # the opened component's name in the address
_HTML = show.component("pairs")


def opened(diagnosis: Diagnosis) -> str | None:
    """Return the component whose pair is open; None where none is."""
    name = address.kept(OPENED)
    return name if name in components_worst_first(diagnosis) else None


def picture(diagnosis: Diagnosis, say: Wording) -> None:
    """Show what is flagged on the photo of the valve body, or as buttons with their spools; the rest folded."""
    verdicts: dict[tuple[str, int], str] = {land.key: land.verdict for land in diagnosis.lands}
    drawings = component_svgs(diagnosis.controller, verdicts)
    by_verdict: dict[Verdict, list[str]] = {}  # the buttons
    for name in components_worst_first(diagnosis):
        verdict = component_verdict(diagnosis, name)
        by_verdict.setdefault(verdict, []).append(_button(diagnosis, name, verdict, drawings[name], say))
    flagged, folds = "", ""
    for verdict, buttons in by_verdict.items():
        if verdict.flagged:
            flagged += "".join(buttons)
            continue
        counted = escape(say(f"diagnosis.valves_{verdict}", count=len(buttons)))
        head = f"<summary>{leveled(look_of(verdict).sign, verdict)} {counted}</summary>"
        folds += f'<details>{head}<div class="grid">{"".join(buttons)}</div></details>'
    note = f"{say('casting.schematic')} · {say('casting.photo_wanted')}"
    shown = f'<div class="grid worst">{flagged}</div>{folds}<p>{escape(note)}</p>'
    with show.refusing("casting"):
        if casting := load_casting(diagnosis.controller.id):
            shown = casting_drawing(casting, diagnosis, say, pressed=True).html + folds
    show.refused("casting")
    mount(shown, key="picture", pressed=opened(diagnosis), on_pair=_open)


def _button(diagnosis: Diagnosis, name: str, verdict: Verdict, drawing: str, say: Wording) -> str:
    number = f"<b>{escape(name)}</b> " if has_number(diagnosis.controller, name) else ""
    words = f"<small>{number}{escape(say.name(diagnosis.controller.components[name]))}</small>"
    flagged = [land for land in diagnosis.flagged if land.key[0] == name]
    leaders = "".join(
        leveled(f"{look_of(land.verdict).sign} {leader(diagnosis, land, say)}", land.verdict) for land in flagged
    )
    return (
        f'<button data-pair="{escape(name)}" style="border-left-color:{look_of(verdict).screen}">{words}'
        f"{_themed(drawing)}{leaders or leveled(say.signed(verdict), verdict)}</button>"
    )


def lands(diagnosis: Diagnosis) -> None:
    """Show the lands: flagged ones, each at every condition, all of them, and how sure their numbers are."""
    say = reader.say()
    fields.choice(  # for the keyboard
        say("diagnosis.open_pair"), components_worst_first(diagnosis), opened(diagnosis),
        lambda name: address.keep(OPENED, name or ""),
        lambda name: component_words(diagnosis.controller, name, say),
        key=f"open-pair-{diagnosis.controller.id}-{session().generation}", index=None,
        placeholder=say("diagnosis.no_pair"),
    )  # fmt: skip
    if diagnosis.without_sheet:  # where no picture is drawn above
        opened_pair(diagnosis, say)
    st.header(say("diagnosis.flagged_pairs"))
    if diagnosis.flagged:
        table(pair_table(diagnosis, diagnosis.flagged, say).without(*ON_PAPER), "flagged", pressable=True)
        said = [say("diagnosis.shares_of", fluid=fluid_in_state(diagnosis, say))]
        said += [say("texts.decision")] if any(land.decision for land in diagnosis.flagged) else []
        st.caption(show.plain(" ".join(said)))
    else:
        st.write(say("diagnosis.none_flagged") if diagnosis.judged else begun(say("diagnosis.nothing_measured")))
    conditions.complaint(diagnosis)
    if lines := advice(diagnosis, advised(diagnosis, say), say):
        with st.expander(say("show.open_verdicts", count=len(lines))):
            st.markdown("\n".join(lines))
    label, key = say("diagnosis.all_lands", count=len(diagnosis.lands)), f"all-lands-{session().generation}"
    with fields.fold(label, key=key) as every:
        if every.open:
            show.chart(figures.leakage_ranking(diagnosis, say), "ranking")
            table(pair_table(diagnosis, diagnosis.ranked, say, at=()).without(*ON_PAPER), "all", pressable=True)
            st.header(say("diagnosis.matrix"))
            conditions.matrix(diagnosis)
    if diagnosis.uncertainty is not None:
        key = f"how-sure-{session().generation}"
        fields.unfold(say("uncertainty.title"), key, _how_sure, diagnosis, diagnosis.uncertainty, say)


def _how_sure(diagnosis: Diagnosis, unit: UnitUncertainty, say: Wording) -> None:
    """Show the instruments, every clearance and leakage with its interval, and what is assumed of the rest."""
    used = (unit.instruments.spool, unit.instruments.sleeve)
    spool, sleeve = (f"**{show.plain(say.name(each.name))}**" for each in used)
    coverage = say.percent(unit.coverage, 0)
    st.markdown(say("uncertainty.instruments", spool=spool, sleeve=sleeve, coverage=coverage))
    of_land, advise = {land.key: land for land in diagnosis.lands}, advised(diagnosis, say)
    clearances = figures.land_clearances(unit, say, advised=lambda key: advise(of_land[key]))
    show.chart(clearances, "clearances")
    show.chart(figures.leakages(unit, diagnosis.projection.condition, say), "leakages")
    st.markdown(f"**{say('uncertainty.assumed')}**")
    what = Column("what", of=lambda each: say.get("uncertainty_assumed", each[0]))
    value = Column("value", of=lambda each: say.plain_quantity(each[1].value, each[1].kind))
    show.table(Table("assumed", (what, value), [*unit.assumptions.quantities.items()], say))


def opened_pair(diagnosis: Diagnosis, say: Wording) -> None:
    """Show everything that is known of the opened component and how sure it is; nothing where none is open."""
    name = opened(diagnosis)
    if name is None:
        return
    advise = advised(diagnosis, say)
    verdicts: dict[tuple[str, int], str] = {land.key: land.verdict for land in diagnosis.lands}
    drawing = _themed(spool_svg(diagnosis.controller, name, verdicts, say))
    heading = f"<h2>{escape(component_words(diagnosis.controller, name, say))}</h2>"
    lands = "".join(_land(each, say, advise(each.land)) for each in opened_lands(diagnosis, name, say))
    with st.container(border=True, key="opened-pair"):
        mount(
            f'{heading}<div class="drawing" tabindex="0">{drawing}</div><div class="lands">{lands}</div>',
            key="opened",
        )
        key = f"made-of-{session().generation}"
        fields.unfold(say("uncertainty.made_of"), key, _made_of, diagnosis, name, say)


def _made_of(diagnosis: Diagnosis, component: str, say: Wording) -> None:
    """Show which sources make up the uncertainty of a component's measured lands."""
    columns = (Column("uncertain_source"), Column("of_clearance", "percent"), Column("of_share", "percent"))
    for land in diagnosis.lands:
        if land.key[0] == component and land.uncertainty is not None:
            st.markdown(f"**{show.plain(land_in_words(diagnosis, land.key, say))}**")
            show.chart(figures.budget(land.uncertainty, say), f"budget-{land.key[1]}")
            show.table(Table("budget", columns, budget_rows(land.uncertainty, say), say))


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
    heading = f"<h3>{escape(say('diagnosis.land', land=number))} {leveled(say.signed(verdict), verdict)}</h3>"
    opened = " open" if verdict.flagged else ""
    fold = f"<details{opened}><summary>{escape(say('diagnosis.numbers'))}</summary><dl>{facts}</dl>{tables}</details>"
    return f"<section>{heading}<ul>{said}</ul>{fold}</section>"


def advised(diagnosis: Diagnosis, say: Wording) -> Callable[[LandDiagnosis], str]:
    """Return what says in the reader's language how a land's open verdict can be decided."""
    return PrintedNames(diagnosis, job(), say).advice


def advice(diagnosis: Diagnosis, advised: Callable[[LandDiagnosis], str], say: Wording) -> list[str]:
    """Return what would make the open verdicts clear, one line of markdown per land of which that can be said."""
    return [
        f"- **{show.plain(land_in_words(diagnosis, land.key, say))}**: {show.plain(said)}"
        for land in diagnosis.ranked
        if (said := advised(land))
    ]
