"""The place into which files are dropped."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import streamlit as st
from streamlit.testing.v1 import AppTest

SCRIPT = """
import streamlit as st
from pages.shared import drop_zone

taken = st.session_state.setdefault("taken", [])
drop_zone.draw("here", "Files", lambda files: taken.extend((each.name, each.getvalue()) for each in files), several={})
st.button("Again")
"""


def test_a_file_is_taken_once_and_the_place_stays_for_one_that_comes_meanwhile() -> None:
    app = AppTest.from_string(SCRIPT.format(True)).run()
    app.file_uploader[0].set_value([("a.csv", b"1", "text/csv")]).run()
    place = app.file_uploader[0].proto.id
    app.button[0].click().run()
    assert app.session_state["taken"] == [("a.csv", b"1")]
    # the browser names the first file again with the one that was dropped while it was read
    app.file_uploader[0].upload("b.csv", b"2", "text/csv").run()
    assert app.session_state["taken"] == [("a.csv", b"1"), ("b.csv", b"2")]
    assert app.file_uploader[0].proto.id == place
    assert not app.exception


@pytest.mark.parametrize("broken_off", [st.stop, st.rerun])
def test_a_file_whose_taking_is_broken_off_is_taken_by_the_next_run(broken_off: Callable[[], None]) -> None:
    def page(broken_off):  # a script of its own, without the names of this module
        import streamlit as st

        from pages.shared import drop_zone

        def take(files: list) -> None:
            tried = st.session_state["tried"] = st.session_state.get("tried", 0) + 1
            if tried == 1:
                broken_off()  # as Streamlit does with what the browser sends meanwhile
            st.session_state["taken"] = [each.name for each in files]

        drop_zone.draw("here", "Files", take, several=True)

    app = AppTest.from_function(page, args=(broken_off,)).run()
    app.file_uploader[0].set_value([("a.csv", b"1", "text/csv")]).run()
    app.run()
    assert app.session_state["taken"] == ["a.csv"]
    assert app.session_state["tried"] == 2
    assert not app.exception


def test_a_place_for_one_file_takes_it_and_says_nothing_of_one_that_was_taken_away() -> None:
    app = AppTest.from_string(SCRIPT.format(False)).run()
    app.file_uploader[0].set_value(("a.csv", b"1", "text/csv")).run()
    app.file_uploader[0].set_value(None).run()
    assert app.session_state["taken"] == [("a.csv", b"1")]
    assert not app.exception
