"""Type gauge readings of the standing vehicle, and show them beside what is permitted and expected."""

import streamlit as st

from atleak.report.tables.gauges import card_notes, card_table, pattern_text
from pages.shared import fields, panel, pressure_form, reader, show
from pages.shared.state import session

case, diagnosis = panel.shown()
controller, check, say = diagnosis.controller, diagnosis.pressures, reader.say()
st.title(say("gauge_page.title"))
st.write(say("gauge_page.what"))
pressure_form.draw(case, controller)
card = fields.fold(say("gauge_card.on_page"), key=f"gauge-card-{session().generation}")
if card.open:
    with card:
        show.table(card_table(diagnosis, say))
        for note in card_notes(diagnosis, say):
            st.caption(show.plain(note))
if check is None:
    st.info(say("gauge_page.none"))
    st.stop()

st.subheader(say("gauge_page.beside"))
show.gauge_banner(check)
show.gauges(check)
st.caption(say("gauge_page.beside_help"))
if check.patterns:
    st.subheader(say("gauge_page.hints"))
    hints = [(pattern_text(each, controller, say), say.get("pattern_sources", each.source)) for each in check.patterns]
    st.markdown("\n".join(f"- {show.plain(hint)} *({show.plain(source)})*" for hint, source in hints))
    st.caption(say("gauge_page.hints_help"))
show.messages(check.messages, say("gauge_page.about"))
