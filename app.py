"""Run the dashboard: ``atleak app`` starts it."""

from pathlib import Path

import streamlit as st

from pages.shared import book, panel

HERE = Path(__file__).parent

st.set_page_config("atleak", page_icon=HERE / "pages" / "shared" / "icon.svg", layout="wide")
page_files = {int(path.stem.partition("_")[0]): path for path in (HERE / "pages").glob("[0-9]*_*.py")}
groups: dict[str, list[st.Page]] = {"": [], "Job book": []}
for number, path in sorted(page_files.items()):
    title = path.stem.partition("_")[2].replace("_", " ")
    groups["" if number < 10 else "Job book"].append(st.Page(path, title=title))
page = st.navigation(groups if groups["Job book"] else groups[""], position="top")
panel.draw()
try:
    page.run()
finally:  # also where the page ends early
    news = book.keep(page.url_path)
if news:
    st.rerun()
