"""The page Settings: how the engine computes, where the spools lie, the fluid and its state."""

from __future__ import annotations

import pytest
from streamlit.testing.v1 import AppTest

from atleak.catalogue.fluid import load_fluid
from tests.unit.pages.conftest import choice, go, settle, texts


def test_profile_options_reach_the_engine(app: AppTest) -> None:
    settle(app, "4_Diagnosis?diagnosis=remarks", "Profile", "paper")
    assert "Profile: **paper**" in texts(app)
    settle(app, "21_Settings", "Diameter in the gap law", "mean")
    settle(app, "4_Diagnosis?diagnosis=remarks", "Loss at a gap's entry and exit", "on")
    changed = (
        "paper (Diameter in the gap law: mean of spool and sleeve; "
        "Loss at a gap's entry and exit: subtracted everywhere)"
    )
    assert changed in texts(app)


@pytest.mark.page("21_Settings")
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
    go(app, "4_Diagnosis?diagnosis=remarks")
    assert "workshop (Eccentricity e/c: 0.4)" in texts(app)


@pytest.mark.page("4_Diagnosis?diagnosis=remarks")
def test_the_state_of_the_fluid_is_asked_and_reaches_the_result(app: AppTest) -> None:
    assert "taken as fresh (not stated)" in texts(app)
    go(app, "21_Settings")
    states = next(widget for widget in app.radio if widget.label == "The fluid is")
    assert states.value is None
    states.set_value("used").run()
    assert not app.exception
    go(app, "4_Diagnosis")
    assert "after 106 315 km" in texts(app)
    assert "taken as fresh" not in "".join(widget.value for widget in app.main.caption)
    go(app, "21_Settings")
    assert next(widget for widget in app.radio if widget.label == "The fluid is").value == "used"


@pytest.mark.page("21_Settings")
def test_options_have_plain_labels_and_keep_their_value_in_the_help(app: AppTest) -> None:
    box = choice(app, "Viscosity")
    assert box.options[0] == "ASTM D341"
    assert "viscosity=d341" in box.help
    assert choice(app, "Pump efficiency").options[0] == "Wilson slip"
    for label in ("Diameter in the gap law", "Viscosity", "Counted as drawn from the pump", "Pump efficiency"):
        assert not any("_" in option for option in choice(app, label).options)


@pytest.mark.page("21_Settings")
def test_a_fluid_of_one_s_own_is_two_viscosities_and_no_file(app: AppTest) -> None:
    def field(label: str):
        return next(widget for widget in app.text_input if widget.label.startswith(label))

    def keep() -> None:
        next(widget for widget in app.button if widget.label == "Keep and use").click().run()
        assert not app.exception

    assert choice(app, "Fluid").value is None
    assert "HIPOL ATF IID" in choice(app, "Fluid").options[0]
    field("Name of the fluid").set_value("Drum 7, red").run()
    keep()
    assert "the viscosities at 40 and 100 °C" in "".join(error.value for error in app.main.error)
    field("Where the numbers come from").set_value("label of the drum").run()
    field("Viscosity at 40").set_value("34,1").run()
    field("Viscosity at 100").set_value("40").run()
    keep()
    assert "less at 100 °C than at 40 °C" in "".join(error.value for error in app.main.error)
    field("Viscosity at 100").set_value("7,1").run()
    keep()
    assert choice(app, "Fluid").value == "drum_7_red"
    fluid = load_fluid("drum_7_red")
    assert [at for at, _ in fluid.points] == [40.0, 100.0]
    assert [nu for _, nu in fluid.points] == pytest.approx([34.1e-6, 7.1e-6], rel=1e-12, abs=0.0)
    assert fluid.representative == ("density_g_cm3", "density_slope_g_cm3_k")
    go(app, "4_Diagnosis?diagnosis=remarks")
    assert "Drum 7, red" in texts(app)
    go(app, "3_In_the_car")
    assert "**Drum 7, red**" in texts(app)  # the step is done


@pytest.mark.page("21_Settings")
def test_the_fluid_of_the_valve_body_shows_its_name_where_none_was_chosen(app: AppTest) -> None:
    fluid = choice(app, "Fluid")
    assert (fluid.value, fluid.options[fluid.proto.default]) == (None, fluid.options[0])
    assert fluid.options[0].startswith("as this valve body's maker requires")
    assert not fluid.proto.set_value, "None is no option to the browser, which would ask for one"
