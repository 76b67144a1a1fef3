"""Keep a font file for the reports' PDF on the page Workshop data, and print with it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import streamlit as st
from streamlit.typing import UploadedFile

from atleak.common.errors import AtleakError
from atleak.common.wording import Wording
from atleak.measurements.job_card import Job
from atleak.report.pdf import missing_characters
from atleak.report.printed_fonts import forget_font, keep_font, kept_file, kept_font
from pages.shared import drop_zone, show

_KEY = "workshop-data-font"


def draw(say: Wording) -> None:
    """Show which font is kept, take another one, or keep none any more."""
    st.header(say("workshop_data.font"))
    st.caption(say("workshop_data.font_what"))
    try:
        drop_zone.draw("font", say("workshop_data.font_file"), _take, types=["ttf", "otf", "ttc"])
        with st.container():
            show.refused(_KEY)
        kept = kept_file()
        st.write(show.plain(say("workshop_data.font_kept", name=kept.name) if kept else say("workshop_data.font_none")))
        if st.button(say("workshop_data.font_forget"), disabled=kept is None, key=f"{_KEY}-forget"):
            forget_font()
            st.rerun()
    except AtleakError as error:
        st.error(show.plain(error))


def _take(files: Sequence[UploadedFile]) -> None:
    for file in files:
        with show.refusing(_KEY):
            keep_font(file.getvalue(), file.name)


def printing(write: Callable[..., bytes]) -> Callable[[], bytes]:
    """Return what writes a PDF with the font that is kept when it is asked for."""
    return lambda: write(font=kept_font())


def draw_missing(records: Sequence[Job]) -> None:
    """Name the characters of job records that a PDF shows as boxes, where there are any."""
    if missing_characters(records):
        for message in missing_characters(records, kept_font()):
            st.warning(show.plain(message.text))
