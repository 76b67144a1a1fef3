"""The diagnosis page shows the repairs that a valve body's file names, and lets the workshop choose among them."""

from __future__ import annotations

from streamlit.testing.v1 import AppTest

from tests.unit.pages.conftest import choice, texts, unfold, uploader

SHEET = """Valve;Land;Part;Diameter [mm];Contact length [mm]
boost_valve;1;spool;9.855;4.5
boost_valve;1;bore;9.955;4.5
"""


def planned(app: AppTest) -> dict[str, str]:
    table = next(frame.value for frame in app.dataframe if "Use" in frame.value)
    return dict(zip(table["Repair"], table["Use"], strict=True))


def test_repairs_of_the_file_are_shown_and_another_one_can_be_chosen(app: AppTest) -> None:
    choice(app, "Valve body").select("five_speed_2005").run()
    uploader(app, "Measuring sheet").upload("worn.csv", SHEET.encode(), "text/csv").run()
    unfold(app, "order-of-repair")
    assert not app.exception
    first, second = planned(app)
    assert "37947-03K" in first
    assert planned(app) == {first: "planned", second: ""}
    assert "neither price nor hours" in texts(app)
    assert "Contact lengths of 1 of 34 lands are those measured on the sheet" in texts(app)
    app.multiselect[0].select("boost_kit_a4ld").run()
    assert not app.exception
    assert planned(app) == {second: "planned", first: ""}
    choice(app, "Valve body").select("minimal_example").run()
    assert not app.exception
