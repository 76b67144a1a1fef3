"""What stands in somebody's file is shown sign for sign: it becomes no link, no formula and no style."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from streamlit.testing.v1 import AppTest

from pages.shared.show import in_chart, plain, with_links
from tests.unit.pages.conftest import uploader


@pytest.mark.parametrize(
    "address", ["http://evil.example", "HTTPS://evil.example/x", "www.evil.example", "a@evil.example"]
)
def test_an_address_in_a_name_becomes_no_link(address):
    shown = plain(f"sheet {address} of May")
    assert "\u2060" in shown
    assert shown.replace("\u2060", "").replace("\\", "") == f"sheet {address} of May"


def test_what_markdown_would_read_is_escaped():
    for sign in ["[link](x)", "$x$", ":red[x]", "**x**", "`x`", "<b>", "![x](y)"]:
        assert plain(sign).replace("\\", "") == sign
        assert not set("[]()$:*`<>!") & set(plain(sign).replace("\\", "\0").split("\0")[0])


def test_the_source_of_a_value_keeps_its_address():
    assert with_links("see https://doi.org/10.1") == "see https\\://doi.org/10.1"


def test_no_name_in_a_chart_is_a_link_and_its_own_line_breaks_stay():
    name = '<a href="http://evil.example">hot idle</a> <span style="x">s</span>'
    spec = {
        "data": [
            {
                "y": [name, 1.0],
                "text": np.array([name], dtype=object),
                "hovertemplate": "<b>%{y}</b><br>x<extra></extra>",
            }
        ],
        "layout": {"xaxis": {"title": name}},
    }
    shown = in_chart(spec)
    assert "<a" not in str(shown)
    assert "<span" not in str(shown)
    assert shown["data"][0]["y"][0].startswith('&lt;a href="http://evil.example">hot idle')
    assert shown["data"][0]["hovertemplate"] == "<b>%{y}</b><br>x<extra></extra>"


def test_the_numbers_of_a_chart_are_handed_on_as_they_are():
    numbers = np.arange(3.0)
    assert in_chart({"x": numbers})["x"] is numbers


@pytest.mark.page("2_Measure")
def test_a_files_name_is_shown_sign_for_sign(app: AppTest, sample_log: Path) -> None:
    name = "<b>x $y$ :red[z] *w* [a](b) `c`.csv"
    uploader(app, "Road-test log").upload(name, sample_log.read_bytes(), "text/csv").run()
    assert not app.exception
    shown = next(widget.value for widget in app.sidebar.caption if "1201 rows" in widget.value)
    for sign in ("\\<b\\>", "\\$y\\$", "\\:red\\[z\\]", "\\*w\\*", "\\`c\\`"):
        assert sign in shown
