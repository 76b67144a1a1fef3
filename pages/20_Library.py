"""Show what the catalogue has, and describe valve bodies, limits, instruments and fluids of the workshop's own."""

import streamlit as st

from atleak.catalogue.entries import own_folder
from atleak.report.charts.condition_figures import viscosity_curve
from atleak.report.tables import catalogue as rows
from pages.shared import (
    casting_form,
    fields,
    gauge_study_form,
    panel,
    reader,
    show,
    transmission,
    workshop_data,
)
from pages.shared.cases import catalogue_list, own_faults, shown_name

case, diagnosis = panel.shown()
say = reader.say()


def catalogue() -> None:
    """Show valve bodies, fluids and limits: their values, sources, and which values are assumed."""
    st.write(say("catalogue.about"))
    st.code(str(own_folder()), language=None)
    for fault in own_faults():
        st.error(f"**{say('catalogue.left_aside')}** {show.plain(say.sentence(fault.sentence))}")
    for tab, kind in zip(st.tabs([say(f"catalogue.{kind}") for kind in rows.FOLDERS]), rows.FOLDERS, strict=True):
        with tab:
            entry_of(kind)


def entry_of(kind: str) -> None:
    """Show one of the catalogue's entries of a kind, that in the job unless another is chosen."""
    known, chosen = list(catalogue_list(kind).entries.values()), getattr(diagnosis, kind)
    entries = {shown_name(entry, say): entry for entry in ([] if chosen in known else [chosen]) + known}
    first = list(entries).index(shown_name(chosen, say))
    entry = entries[st.selectbox(say("catalogue.show"), list(entries), first, key=f"catalogue-{kind}-{say.language}")]
    st.markdown(f"**{say('columns.source')}:** {show.with_links(say.name(entry.source))} ({entry.date})")
    for doubt in entry.doubts:
        st.warning(show.plain(say.sentence(doubt.text)))
    if entry.note:
        st.markdown(show.plain(say.name(entry.note)))
    if getattr(entry, "representative", None):
        st.info(f"**{say('catalogue.representative')}** {show.plain(rows.representative(entry, say))}")
    if kind == "fluid":
        st.header(say("catalogue.viscosity"))
        show.chart(viscosity_curve(entry, say), "viscosity-curve")
        st.caption(say("catalogue.viscosity_caption"))
    if kind == "controller":
        with st.expander(say("casting.title")):
            casting_form.draw(entry)
    for table in rows.TABLES[kind](entry, say):
        st.header(table.title or say(f"catalogue.{table.name}"))
        show.table(table)
    st.download_button(
        say("catalogue.file"), entry.origin.path.read_bytes, entry.origin.file, key=f"file-{kind}",
        on_click="ignore", disabled=not entry.origin.path.is_file(),
    )  # fmt: skip


PARTS = {
    "catalogue": catalogue,
    "transmission": lambda: transmission.draw(diagnosis),
    "workshop_data": lambda: workshop_data.draw(say),
    "gauge_study": lambda: gauge_study_form.draw(say),
}
st.title(say("pages.Library"))
PARTS[fields.part("library", {name: say(f"parts.{name}") for name in PARTS})]()
