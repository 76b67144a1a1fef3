"""Show valve bodies, fluids and limits: their values, sources, and which values are representative."""

import streamlit as st

from atleak.catalogue.entries import own_folder
from atleak.report.charts.condition_figures import viscosity_curve
from atleak.report.tables import catalogue as rows
from pages.shared import panel, reader, show
from pages.shared.cases import catalogue_list, own_faults, shown_name

case, diagnosis = panel.shown()
say = reader.say()
st.title(say("pages.Catalogue"))
st.write(say("catalogue.about"))
st.code(str(own_folder()), language=None)
for fault in own_faults():
    st.error(f"**{say('catalogue.left_aside')}** {show.plain(say.sentence(fault.sentence))}")


def entries(kind: str) -> dict:
    """Return the catalogue's entries of a kind and the one in the job, by the name that is shown."""
    known = list(catalogue_list(kind).entries.values())
    chosen = getattr(diagnosis, kind)
    return {shown_name(entry, say): entry for entry in ([] if chosen in known else [chosen]) + known}


for tab, kind in zip(st.tabs([say(f"catalogue.{kind}") for kind in rows.FOLDERS]), rows.FOLDERS, strict=True):
    with tab:
        known = entries(kind)
        names = list(known)
        first = names.index(shown_name(getattr(diagnosis, kind), say))
        name = st.selectbox(say("catalogue.show"), names, first, key=f"catalogue-{kind}-{say.language}")
        entry = known[name]
        st.markdown(f"**{say('columns.source')}:** {show.with_links(say.name(entry.source))} ({entry.date})")
        for doubt in entry.doubts:
            st.warning(show.plain(say.sentence(doubt.text)))
        if entry.note:
            st.markdown(show.plain(say.name(entry.note)))
        if getattr(entry, "representative", None):
            st.info(f"**{say('catalogue.representative')}** {show.plain(rows.representative(entry, say))}")
        if kind == "fluid":
            st.subheader(say("catalogue.viscosity"))
            show.chart(viscosity_curve(entry, say), "viscosity-curve")
            st.caption(say("catalogue.viscosity_caption"))
        for table in rows.TABLES[kind](entry, say):
            st.subheader(table.title or say(f"catalogue.{table.name}"))
            show.table(table)
        st.download_button(
            say("catalogue.file"), entry.origin.path.read_bytes, entry.origin.file, key=f"file-{kind}",
            on_click="ignore", disabled=not entry.origin.path.is_file(),
        )  # fmt: skip
