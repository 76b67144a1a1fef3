"""The page Plan shows the repairs that a valve body's file names, and lets the workshop choose among them."""

from __future__ import annotations

import pytest
from streamlit.testing.v1 import AppTest

from atleak.catalogue.entries import catalogue_files
from tests.unit.pages.conftest import choice, go, texts, unfold, uploader

SHEET = """Valve;Land;Part;Diameter [mm];Contact length [mm]
boost_valve;1;spool;9.855;4.5
boost_valve;1;bore;9.955;4.5
"""


def planned(app: AppTest) -> dict[str, str]:
    table = next(frame.value for frame in app.dataframe if "Use" in frame.value)
    assert set(table.iloc[:, -1]) == {"boost_valve/1, boost_valve/2, boost_valve/3"}
    return dict(zip(table["Repair"], table["Use"], strict=True))


@pytest.mark.page("5_Plan")
def test_repairs_of_the_file_are_shown_and_which_of_them_is_planned(app: AppTest) -> None:
    choice(app, "Valve body").select("five_speed_2005").run()
    uploader(app, "Measuring sheet").upload("worn.csv", SHEET.encode(), "text/csv").run()
    unfold(app, "order-of-repair")
    assert not app.exception
    first, second = planned(app)
    assert "37947-03K" in first
    assert planned(app) == {first: "planned", second: ""}
    assert "neither price nor hours" in texts(app)
    choice(app, "Valve body").select("minimal_example").run()
    assert not app.exception


KITS = """
[[repairs]]
id = "sleeve"
component = "pressure_regulator"
kind = "sleeve"
name = "bore sleeved"
price = 38.0
currency = "EUR"
source = "made up"

[[repairs]]
id = "body"
components = "all"
kind = "other"
name = "remanufactured body"
price = 650.0
currency = "EUR"
source = "made up"
"""
TWO_WORN = b"""Valve;Land;Part;Diameter [mm]
pressure_regulator;1;spool;15.00
pressure_regulator;1;bore;15.09
accumulator;1;spool;18.00
accumulator;1;bore;18.10
"""


@pytest.mark.page("21_Settings")
def test_a_body_that_is_switched_on_is_one_line_of_the_estimate_and_the_sleeve_is_off(app: AppTest) -> None:
    own = catalogue_files("controllers")["minimal_example"].read_text(encoding="utf-8") + KITS
    uploader(app).upload_all({"own.toml": own.encode(), "worn.csv": TWO_WORN}).run()
    go(app, "4_Diagnosis")
    assert not app.exception
    next(each for each in app.main.toggle if "bore sleeved" in each.label).set_value(True).run()
    body = next(each for each in app.main.toggle if "remanufactured body" in each.label)
    assert "one repair of the whole valve body" in body.label
    body.set_value(True).run()
    assert [each.value for each in app.main.toggle if "sleeved" in each.label] == [False]
    go(app, "5_Plan")
    assert not app.exception
    (line,) = [each for each in app.main.toggle if each.value]
    assert line.label.startswith("**the whole valve body**")
    (sums,) = [table.value for table in app.dataframe if "Net" in table.value]
    assert list(sums["Parts"]) == ["650.00"]
