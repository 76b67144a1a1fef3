"""Run the dashboard: ``atleak app`` starts it."""

from pathlib import Path

import streamlit as st

from pages.shared import book, panel

HERE = Path(__file__).parent

st.set_page_config("atleak", page_icon=HERE / "pages" / "shared" / "icon.svg", layout="wide")
# A page's number gives its place. Those from ten on are about the job book, and those in BESIDE about no job at all.
BESIDE = (6, 7, 9)
page_files = {int(path.stem.partition("_")[0]): path for path in (HERE / "pages").glob("[0-9]*_*.py")}
groups: dict[str, list[st.Page]] = {"": [], "Job book": [], "Reference": []}
for number, path in sorted(page_files.items()):
    group = "Reference" if number in BESIDE else "" if number < 10 else "Job book"
    groups[group].append(st.Page(path, title=path.stem.partition("_")[2].replace("_", " ")))
page = st.navigation(groups, position="top")
panel.draw()
try:
    page.run()
finally:  # also where the page ends early
    news = book.keep(page.url_path)
if news:
    st.rerun()
