"""The page that shows what is shipped."""

from __future__ import annotations

import pytest
from streamlit.testing.v1 import AppTest


@pytest.mark.page("20_Library")
def test_a_valve_body_with_circuits_shows_them_and_what_of_them_is_assumed(app: AppTest) -> None:
    assert not app.exception
    assert "Circuits" not in [heading.value for heading in app.header]
    chosen = next(widget for widget in app.selectbox if widget.key == "catalogue-controller-en")
    chosen.select("Five-speed after Ford's 5R55S, with its circuits").run()
    assert not app.exception
    headings = [heading.value for heading in app.header]
    assert headings[:6] == ["What the values are known from", "Head", "Materials", "Components", "Lands", "Pump"]
    circuits = app.dataframe[headings.index("Circuits")].value
    assert "overdrive band servo" in list(circuits["Name"])
    assert any("Assumed" in info.value and "pump" in info.value for info in app.info)
