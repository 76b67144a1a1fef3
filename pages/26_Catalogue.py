"""Show valve bodies, fluids and limits: their values, sources, and which values are representative."""

import streamlit as st

from atleak.catalogue.entries import own_folder
from atleak.figures.fluid_figures import viscosity_curve
from atleak.views import catalogue_rows as rows
from pages.shared import panel, show
from pages.shared.cases import catalogue_list, own_faults, shown_name

case, diagnosis = panel.shown()
st.title("Catalogue")
st.write("Everything shipped names its source. Your own TOML files are offered too where they lie in the folders of:")
st.code(str(own_folder()), language=None)
for fault in own_faults():
    st.error(f"**An own file is left aside.** {show.plain(fault)}")


def entries(kind: str) -> dict:
    """Return the catalogue's entries of a kind and the one in the job, by the name that is shown."""
    known = list(catalogue_list(kind).entries.values())
    chosen = getattr(diagnosis, kind)
    return {shown_name(entry): entry for entry in ([] if chosen in known else [chosen]) + known}


for tab, kind in zip(st.tabs(["Valve bodies", "Fluids", "Limits"]), rows.FOLDERS, strict=True):
    with tab:
        known = entries(kind)
        names = list(known)
        name = st.selectbox("Show", names, names.index(shown_name(getattr(diagnosis, kind))), key=f"catalogue-{kind}")
        entry = known[name]
        st.markdown(f"**Source:** {show.plain(entry.source)} ({entry.date})")
        for doubt in entry.doubts:
            st.warning(show.plain(doubt.text))
        if entry.note:
            st.markdown(show.plain(entry.note))
        if getattr(entry, "representative", None):
            st.info(f"**Representative:** {show.plain(rows.representative(entry))}")
        if kind == "fluid":
            st.subheader("Viscosity over temperature")
            show.chart(viscosity_curve(entry), "viscosity-curve")
            st.caption("ASTM D341 through the points of the data sheet; dashed where it goes beyond them.")
        for title, table in rows.TABLES[kind](entry).items():
            st.subheader(title)
            show.table(table)
        st.download_button(
            "This file (TOML)", entry.origin.path.read_bytes, entry.origin.file, key=f"file-{kind}", on_click="ignore",
            disabled=not entry.origin.path.is_file(),
        )  # fmt: skip
