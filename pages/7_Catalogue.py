"""Show valve bodies, fluids and limits: their values, sources, and which values are representative."""

import streamlit as st

from atleak.catalogue.entries import catalogue_files
from atleak.views import catalogue_rows as rows
from pages.shared import panel, show
from pages.shared.cases import catalogue_entry

case, diagnosis = panel.shown()
st.title("Catalogue")
st.write("Everything shipped names its source. Choose a workshop's own TOML file in the sidebar.")


def entries(kind: str) -> dict:
    """Return the shipped entries of a kind and the one in the job, by name."""
    shipped = [catalogue_entry(kind, name) for name in catalogue_files(rows.FOLDERS[kind])]
    own = getattr(diagnosis, kind)
    return {entry.name: entry for entry in ([] if own in shipped else [own]) + shipped}


for tab, kind in zip(st.tabs(["Valve bodies", "Fluids", "Limits"]), rows.FOLDERS, strict=True):
    with tab:
        known = entries(kind)
        names = list(known)
        name = st.selectbox("Show", names, names.index(getattr(diagnosis, kind).name), key=f"catalogue-{kind}")
        entry = known[name]
        st.markdown(f"**Source:** {show.plain(entry.source)} ({entry.date})")
        if entry.note:
            st.markdown(show.plain(entry.note))
        if getattr(entry, "representative", None):
            st.info(f"**Representative:** {show.plain(rows.representative(entry))}")
        for title, table in rows.TABLES[kind](entry).items():
            st.subheader(title)
            show.table(table)
        st.download_button(
            "This file (TOML)", entry.origin.path.read_bytes, entry.origin.file, key=f"file-{kind}", on_click="ignore",
            disabled=not entry.origin.path.is_file(),
        )  # fmt: skip
