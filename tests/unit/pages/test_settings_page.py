"""The page Settings: how the engine computes, where the spools lie, the fluid and its state."""

from __future__ import annotations

import pytest
from streamlit.testing.v1 import AppTest

from tests.unit.pages.conftest import choice, go, settle, texts


def test_profile_options_reach_the_engine(app: AppTest) -> None:
    settle(app, "4_Diagnosis", "Profile", "paper")
    assert "Profile: **paper**" in texts(app)
    settle(app, "22_Settings", "Diameter in the gap law", "mean")
    settle(app, "4_Diagnosis", "Loss at a gap's entry and exit", "on")
    changed = (
        "paper (Diameter in the gap law: mean of spool and sleeve; "
        "Loss at a gap's entry and exit: subtracted everywhere)"
    )
    assert changed in texts(app)


@pytest.mark.page("22_Settings")
def test_where_the_spools_lie_can_be_unknown(app: AppTest) -> None:
    def position():
        return next(widget for widget in app.toggle if "spools lie" in widget.label)

    def ratio():
        return next(widget for widget in app.slider if widget.label == "Eccentricity e/c")

    def options() -> dict:
        return dict(app.session_state["atleak"].good.options)

    ratio().set_value(0.4).run()
    assert options() == {"eccentricity": 0.4}
    position().set_value(True).run()
    assert options() == {"eccentricity": "unknown"}
    assert ratio().disabled
    position().set_value(False).run()
    assert options() == {"eccentricity": 0.4}
    go(app, "4_Diagnosis")
    assert "workshop (Eccentricity e/c: 0.4)" in texts(app)


def test_the_state_of_the_fluid_is_asked_and_reaches_the_result(app: AppTest) -> None:
    assert "taken as fresh (not stated)" in texts(app)
    go(app, "22_Settings")
    states = next(widget for widget in app.radio if widget.label == "The fluid is")
    assert states.value is None
    states.set_value("used").run()
    assert not app.exception
    go(app, "4_Diagnosis")
    assert "after 106 315 km" in texts(app)
    assert "taken as fresh" not in "".join(widget.value for widget in app.main.caption)
    go(app, "22_Settings")
    assert next(widget for widget in app.radio if widget.label == "The fluid is").value == "used"


@pytest.mark.page("22_Settings")
def test_options_have_plain_labels_and_keep_their_value_in_the_help(app: AppTest) -> None:
    box = choice(app, "Viscosity")
    assert box.options[0] == "ASTM D341"
    assert "viscosity=d341" in box.help
    assert choice(app, "Pump efficiency").options[0] == "Wilson slip"
    for label in ("Diameter in the gap law", "Viscosity", "Counted as drawn from the pump", "Pump efficiency"):
        assert not any("_" in option for option in choice(app, label).options)
