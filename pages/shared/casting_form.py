"""Take a photo of an opened valve body, and the marks of its components' bores on it."""

from __future__ import annotations

from collections.abc import Sequence

import streamlit as st
from streamlit.typing import UploadedFile

from atleak.catalogue.castings import Casting, keep_casting, load_casting
from atleak.catalogue.controller import Controller
from atleak.report.tables.names import component_words
from pages.shared import drop_zone, reader, show

_PHOTO = show.component("casting")


def draw(controller: Controller) -> None:
    """Offer to load, replace and remove the photo of a valve body, and to mark its bores one after another."""
    say, key = reader.say(), f"casting-{controller.id}"
    st.caption(say("casting.about"))
    casting: Casting | None = None
    with show.refusing(key):
        casting = load_casting(controller.id)
    show.refused(key)

    def put(new: Casting | None) -> None:
        with show.refusing(key):
            keep_casting(controller.id, new)
            st.session_state[f"{key}-before"] = casting

    def take(files: Sequence[UploadedFile]) -> None:
        with show.refusing(key):
            put(Casting.of_photo(files[0].name, files[0].getvalue()))

    def marked() -> None:
        with show.refusing(key):
            sent = st.session_state.get(f"{key}-photo") or {}  # none once another page is shown
            marks, now = sent.get("marks"), load_casting(controller.id)
            if casting and now and now.photo == casting.photo and marks is not None:  # they are of no other photo
                keep_casting(controller.id, now.marked(marks))

    drop_zone.draw(key, say("casting.load"), take, types=["jpg", "jpeg", "png", "webp"])
    if casting is not None:
        bores = [
            [each, component_words(controller, each, say)]
            for each in controller.components
            if controller.lands_of(each)
        ]
        words = {each: say.get("casting", each) for each in ("title", "bore", "press", "marked", "next", "undo")}
        shown = {"photo": casting.photo, "marks": dict(casting.marks), "bores": bores, "words": words}
        _PHOTO(key=f"{key}-photo", data=shown, on_marks_change=marked)
        st.button(say("casting.remove"), key=f"{key}-remove", on_click=put, args=(None,))
    if before := st.session_state.get(f"{key}-before"):
        st.button(say("casting.bring_back"), key=f"{key}-back", on_click=put, args=(before,))
