"""A fluid: its data sheet honoured, and no answer where it has none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.catalogue.controller_file import controllers
from atleak.catalogue.fluid import Fluid, ViscosityModel, fluids, load_fluid
from atleak.common.errors import CatalogueError, DomainError, InputError
from atleak.engine.profile import PROFILES, Profile

Edited = Callable[..., Path]
ALL = {fluid.id: fluid for fluid in fluids()}
CONTROLLERS = controllers()

# Dziubak & Szczepaniak 2023, Table 2: °C, mm²/s, g/cm³
TABLE_2 = [(-40.0, 1923.0, 0.870), (20.0, 145.0, 0.826), (40.0, 42.0, 0.812), (80.0, 10.93, 0.783), (100.0, 7.0, 0.768)]


@pytest.mark.parametrize("fluid", ALL.values(), ids=ALL)
def test_d341_passes_through_the_data_sheet(fluid: Fluid) -> None:
    for at, viscosity in (fluid.points[0], fluid.points[-1]):
        assert fluid.kinematic_viscosity(at) == pytest.approx(viscosity, rel=1e-9, abs=0.0)
    at, density = fluid.density_at
    assert fluid.density(at) == pytest.approx(density, rel=1e-12, abs=0.0)


@pytest.mark.parametrize(("at", "viscosity", "density"), TABLE_2)
def test_tabulated_is_table_2_as_printed(hipol: Fluid, at: float, viscosity: float, density: float) -> None:
    assert hipol.kinematic_viscosity(at, "tabulated") == pytest.approx(viscosity * 1e-6, rel=1e-12, abs=0.0)
    assert hipol.density(at, "tabulated") == pytest.approx(density * 1e3, rel=1e-12, abs=0.0)


def test_tabulated_is_a_straight_line_of_log_viscosity_between(hipol: Fluid) -> None:
    middle = hipol.kinematic_viscosity(60.0, "tabulated")
    assert middle == pytest.approx((42.0 * 10.93) ** 0.5 * 1e-6, rel=1e-12, abs=0.0)
    assert hipol.density(60.0, "tabulated") == pytest.approx((812.0 + 783.0) / 2.0, rel=1e-12, abs=0.0)


def test_tabulated_takes_the_data_sheet_where_there_is_no_table() -> None:
    fluid = ALL["mobil_atf_220"]
    assert not fluid.table
    assert fluid.span("tabulated") == (40.0, 100.0)
    assert fluid.kinematic_viscosity(40.0, "tabulated") == pytest.approx(37e-6, rel=1e-12, abs=0.0)
    assert fluid.density(40.0, "tabulated") == fluid.density(40.0)


def test_regression_is_that_of_the_study(hipol: Fluid) -> None:
    # eqs. (29) and (30): 343.92 e^(−0.043 T), −0.0007 T + 0.8409
    assert hipol.kinematic_viscosity(80.0, "regression") * 1e6 == pytest.approx(
        343.92 * np.exp(-3.44), rel=1e-12, abs=0.0
    )
    assert hipol.density(80.0, "regression") == pytest.approx(784.9, rel=1e-12, abs=0.0)


def test_the_study_s_fluids_fresh_and_used(hipol: Fluid) -> None:
    used = ALL["hipol_atf_iid_used"]
    assert used.kinematic_viscosity(80.0) == pytest.approx(8.40e-6, rel=1e-9, abs=0.0)
    assert hipol.kinematic_viscosity(100.0) == pytest.approx(7.0e-6, rel=1e-9, abs=0.0)


@pytest.mark.parametrize("fluid", ALL.values(), ids=ALL)
@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
def test_every_shipped_fluid_answers_at_every_shipped_operating_point(fluid: Fluid, profile: Profile) -> None:
    for controller in CONTROLLERS:
        for point in controller.operating_points:
            fluid.require(point.temperature, profile.viscosity)


def test_the_used_fluid_is_the_fresh_one_scaled(hipol: Fluid) -> None:
    used = ALL["hipol_atf_iid_used"]
    for at in (40.0, 80.0, 100.0):
        ratio = used.kinematic_viscosity(at, "tabulated") / hipol.kinematic_viscosity(at, "tabulated")
        assert ratio == pytest.approx(8.40 / 10.93, rel=1e-3, abs=0.0)
        assert used.density(at, "tabulated") == hipol.density(at, "tabulated")


def test_a_fluid_that_names_its_used_data_takes_them(hipol: Fluid) -> None:
    used = hipol.in_state("used")
    assert (used, used.state, used.estimated) == (ALL["hipol_atf_iid_used"], "used", False)
    assert used.in_state("used") is used
    assert hipol.in_state("fresh") is hipol


@pytest.mark.parametrize("model", ["d341", "tabulated"])
def test_without_used_data_the_viscosity_is_a_fifth_to_a_quarter_lower_and_the_density_the_fresh_one(
    model: ViscosityModel,
) -> None:
    fresh = ALL["mobil_atf_220"]
    used = fresh.in_state("used")
    for at in (40.0, 100.0):
        ratio = used.kinematic_viscosity(at, model) / fresh.kinematic_viscosity(at, model)
        assert ratio == pytest.approx(0.775, rel=1e-9, abs=0.0)
        assert used.density(at, model) == fresh.density(at, model)
        ends = tuple(ratio * each for each in used.viscosity_range)
        assert ends == pytest.approx((0.75, 0.80), rel=1e-9, abs=0.0)
    assert used.state == "used"
    assert "viscosity and density of the used fluid" in used.representative
    said = {message.code: message for message in used.messages(80.0, 80.0)}
    assert "20 to 25 % below the fresh one's (assumed" in said["fluid_used_estimated"].text
    assert "fluid_used_estimated" not in {message.code for message in fresh.messages(80.0, 80.0)}


def test_the_regression_of_a_fresh_fluid_is_not_claimed_for_an_estimated_used_one(edited: Edited) -> None:
    own = load_fluid(edited("fluids", "hipol_atf_iid", ('used = "hipol_atf_iid_used"\n', "")))
    assert "viscosity_of_another_fluid" not in {message.code for message in own.messages(80.0, 80.0, "regression")}
    said = {message.code: message.text for message in own.in_state("used").messages(80.0, 80.0, "regression")}
    assert "describes fresh HIPOL ATF IID, not" in said["viscosity_of_another_fluid"]


@pytest.mark.parametrize("name", [name for name, fluid in ALL.items() if fluid.state == "fresh"])
def test_a_fluid_that_was_made_used_can_be_fresh_again(name: str) -> None:
    assert ALL[name].in_state("used").in_state("fresh") is ALL[name]


def test_used_data_are_never_called_fresh() -> None:
    with pytest.raises(InputError, match="describe a used fluid") as caught:
        ALL["hipol_atf_iid_used"].in_state("fresh")
    assert (caught.value.value, caught.value.expected) == ("fresh", "used, or the file of the fresh fluid")


@pytest.mark.parametrize(
    ("name", "change", "value", "said"),
    [
        ("hipol_atf_iid", ('"hipol_atf_iid_used"', '"hipol_atf_iid_usd"'), "hipol_atf_iid_usd", "did you mean"),
        (
            "hipol_atf_iid",
            ('"hipol_atf_iid_used"', '"mobil_atf_220"'),
            "mobil_atf_220",
            "not describe a used fluid",
        ),
        ("hipol_atf_iid_used", ('state = "used"', 'state = "used"\nused = "x"'), "x", "no used state of its own"),
        ("hipol_atf_iid_used", ('state = "used"', 'state = "old"'), "old", "fresh"),
    ],
)
def test_a_used_state_that_cannot_be_is_refused(
    name: str, change: tuple[str, str], value: str, said: str, edited: Edited
) -> None:
    with pytest.raises(CatalogueError) as caught:
        load_fluid(edited("fluids", name, change))
    assert said in str(caught.value)
    assert caught.value.place.file == "own.toml"
    assert caught.value.value == value


@given(
    name=st.sampled_from(sorted(ALL)),
    model=st.sampled_from(get_args(ViscosityModel)),
    low=st.floats(0.0, 1.0),
    high=st.floats(0.0, 1.0),
)
def test_viscosity_and_density_fall_with_temperature(name: str, model: ViscosityModel, low: float, high: float) -> None:
    fluid = ALL[name]
    start, end = fluid.span(model)
    cold, hot = sorted((start + low * (end - start), start + high * (end - start)))
    assert fluid.kinematic_viscosity(cold, model) >= fluid.kinematic_viscosity(hot, model) * (1.0 - 1e-12)
    assert fluid.density(cold, model) >= fluid.density(hot, model) * (1.0 - 1e-12)
    if hot - cold > 0.01:
        assert fluid.kinematic_viscosity(cold, model) > fluid.kinematic_viscosity(hot, model) > 0.0


@given(
    model=st.sampled_from(get_args(ViscosityModel)),
    temperatures=st.lists(st.one_of(st.just(float("nan")), st.floats(-80.0, 200.0)), min_size=1, max_size=8),
)
def test_arrays_answer_as_their_elements_do(model: ViscosityModel, temperatures: list[float]) -> None:
    fluid = ALL["hipol_atf_iid"]
    for ask in (fluid.kinematic_viscosity, fluid.density):
        together = ask(np.array(temperatures), model)
        apart = np.array([ask(at, model) for at in temperatures])
        np.testing.assert_allclose(together, apart, rtol=1e-12, equal_nan=True)
    low, high = fluid.span(model)
    inside = [low <= at <= high for at in temperatures]
    assert np.isfinite(fluid.kinematic_viscosity(np.array(temperatures), model)).tolist() == inside


def test_a_number_in_gives_a_float_out(hipol: Fluid) -> None:
    for model in get_args(ViscosityModel):
        assert type(hipol.kinematic_viscosity(80.0, model)) is float
        assert type(hipol.density(80, model)) is float
    assert hipol.kinematic_viscosity(np.array([])).shape == (0,)


def test_below_the_pour_point_there_is_no_answer() -> None:
    fluid = ALL["mobil_atf_220"]
    assert fluid.pour_point == -44.0
    fluid.require(-44.0)
    with pytest.raises(DomainError, match=r"Mobil ATF 220.*-45 °C is below its pour point, -44 °C"):
        fluid.require(-45.0)
    assert np.isnan(fluid.kinematic_viscosity(-45.0))
    assert np.isnan(fluid.density(-45.0))


def test_without_a_pour_point_the_answer_ends_where_d341_does(hipol: Fluid) -> None:
    with pytest.raises(DomainError, match="no pour point is stated"):
        hipol.require(-21.0)


@pytest.mark.parametrize(
    ("model", "temperature"), [("d341", 151.0), ("tabulated", 101.0), ("tabulated", -41.0), ("regression", 101.0)]
)
def test_outside_the_data_there_is_no_answer(hipol: Fluid, model: ViscosityModel, temperature: float) -> None:
    with pytest.raises(DomainError, match=rf"{temperature:g} °C is outside the fluid's data \({model}\)"):
        hipol.require(temperature, model)
    assert np.isnan(hipol.kinematic_viscosity(temperature, model))


def test_not_a_temperature_is_outside(hipol: Fluid) -> None:
    with pytest.raises(DomainError):
        hipol.require(float("nan"))


def codes(fluid: Fluid, lowest: float, highest: float, model: ViscosityModel = "d341") -> set[str]:
    return {message.code for message in fluid.messages(lowest, highest, model)}


def test_what_a_reader_must_know_is_said() -> None:
    fluid = replace(ALL["mobil_atf_220"], representative=(), note="")
    assert codes(fluid, 20.0, 100.0) == set()
    assert codes(fluid, -20.1, 100.0) == {"viscosity_cold"}
    assert codes(fluid, 20.0, 120.1) == {"viscosity_extrapolated"}
    assert codes(fluid, 20.0, 100.0, "regression") == {"viscosity_of_another_fluid"}
    assert codes(replace(fluid, representative=("density_slope_g_cm3_k",)), 20.0, 100.0) == {"fluid_representative"}
    assert codes(replace(fluid, note="x"), 20.0, 100.0) == {"fluid_note"}
    assert codes(ALL["hipol_atf_iid"], 20.0, 100.0, "regression") == {"fluid_note"}


def test_a_fluids_file_says_whether_the_studys_regression_describes_it(edited) -> None:
    renamed = load_fluid(edited("fluids", "hipol_atf_iid", ('id = "hipol_atf_iid"', 'id = "our_own"')))
    assert "viscosity_of_another_fluid" not in codes(renamed, 20.0, 100.0, "regression")
    silent = load_fluid(edited("fluids", "hipol_atf_iid", ("study_regression = true", "study_regression = false")))
    assert "viscosity_of_another_fluid" in codes(silent, 20.0, 100.0, "regression")


def test_sheets_that_contradict_themselves_say_so() -> None:
    for name in ("mobil_multipurpose_atf", "mobil_delvac_1_atf"):
        assert "viscosity index" in ALL[name].note


@pytest.mark.parametrize("fluid", ALL.values(), ids=ALL)
def test_a_slope_of_density_that_no_sheet_gives_is_called_representative(fluid: Fluid) -> None:
    if not fluid.id.startswith("hipol"):  # whose slope is that of the study's Table 2
        assert any("density" in name for name in fluid.representative)


@pytest.mark.parametrize(
    ("changes", "table", "key", "value"),
    [
        ([("= 7.0\n", "= 70.0\n")], "viscosity[2]", "kinematic_viscosity_mm2_s", 70.0),
        ([("temperature_c = 100.0", "temperature_c = 40.0")], "viscosity[2]", "temperature_c", 40.0),
        ([("temperature_c = 20.0", "temperature_c = -40.0")], "table[2]", "temperature_c", -40.0),
        ([("= 145.0", "= 1923.0")], "table[2]", "kinematic_viscosity_mm2_s", 1923.0),
        ([("= 0.826", "= 826.0")], "density", "density_g_cm3", 826.0),
        ([("= -0.00073", "= 0.00073")], "density", "density_slope_g_cm3_k", 0.00073),
        ([("representative = []", "representative = []\npour_point_c = 44")], None, "pour_point_c", 44),
    ],
)
def test_a_fluid_that_cannot_be_is_refused(
    changes: list[tuple[str, str]], table: str | None, key: str, value: float, edited: Edited
) -> None:
    with pytest.raises(CatalogueError) as caught:
        load_fluid(edited("fluids", "hipol_atf_iid", *changes))
    error = caught.value
    assert (error.place.file, error.place.table, error.place.key, error.value) == ("own.toml", table, key, value)


def test_points_may_stand_in_any_order(hipol: Fluid, edited: Edited) -> None:
    swapped = edited(
        "fluids",
        "hipol_atf_iid",
        (
            "temperature_c = 40.0\nkinematic_viscosity_mm2_s = 42.0",
            "temperature_c = 100.0\nkinematic_viscosity_mm2_s = 7",
        ),
        (
            "temperature_c = 100.0\nkinematic_viscosity_mm2_s = 7.0",
            "temperature_c = 40.0\nkinematic_viscosity_mm2_s = 42",
        ),
    )
    assert load_fluid(swapped).points == hipol.points


def test_one_point_is_no_viscosity_and_one_row_no_table(edited: Edited) -> None:
    path = edited("fluids", "hipol_atf_iid")
    text = path.read_text(encoding="utf-8")
    tables = text.index("\n[[table]]")
    path.write_text(text[: text.rindex("[[viscosity]]")], encoding="utf-8")
    with pytest.raises(CatalogueError, match="list of at least 2"):
        load_fluid(path)
    path.write_text(text[: text.index("\n[[table]]", tables + 1)], encoding="utf-8")
    with pytest.raises(CatalogueError, match="at least two temperatures"):
        load_fluid(path)
    path.write_text(text[:tables], encoding="utf-8")
    assert load_fluid(path).table == ()
