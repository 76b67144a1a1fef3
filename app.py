"""Run the dashboard: ``atleak app`` starts it."""

from pathlib import Path

import streamlit as st

from atleak.common.memory import collect_soon
from pages.shared import entrance, reader

HERE = Path(__file__).parent

st.set_page_config("atleak", page_icon=HERE / "pages" / "shared" / "icon.svg", layout="wide")
# A page's number gives its place: a job's way up to nine, from ten on the job book, from twenty on the rare ones.
GROUPS = ("", "group_book", "group_more")
say = reader.say()
page_files = {int(path.stem.partition("_")[0]): path for path in (HERE / "pages").glob("[0-9]*_*.py")}
groups: dict[str, list[st.Page]] = {say(f"pages.{group}") if group else "": [] for group in GROUPS}
for number, path in sorted(page_files.items()):
    title = say.get("pages", path.stem.partition("_")[2])
    if number:
        list(groups.values())[number // 10].append(st.Page(path, title=title))
    else:  # where the bare address leads
        groups[""].append(st.Page(path, title=title, default=True, visibility="hidden"))
is_open = entrance.is_open()
page = st.navigation(groups, position="top" if is_open else "hidden")
reader.mark_page()
if not is_open:
    entrance.draw()
    st.stop()
heading = st.empty()
if "framed" not in st.session_state:  # seen while all else is imported, read and computed
    heading.title(page.title)

from pages.shared import book, panel, show  # noqa: E402

result = panel.draw()
entrance.draw_sign_out()
heading.empty()
try:
    with show.faults():
        if page in groups[""][1:]:
            panel.draw_steps(result)
        del result  # the names of this file outlive the visit
        page.run()
finally:  # also where the page ends early
    news = book.keep(page.url_path)
    collect_soon()
if news:
    st.rerun()
