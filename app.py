"""Run the dashboard: ``atleak app`` starts it."""

from pathlib import Path

import streamlit as st

from pages.shared import panel

HERE = Path(__file__).parent

st.set_page_config("atleak", page_icon=HERE / "pages" / "shared" / "icon.svg", layout="wide")
page_files = sorted((HERE / "pages").glob("[0-9]_*.py"))
page = st.navigation([st.Page(path, title=path.stem[2:].replace("_", " ")) for path in page_files], position="top")
panel.draw()
page.run()
