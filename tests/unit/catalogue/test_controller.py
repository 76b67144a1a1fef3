"""What a controller is, and what its file may not say."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel

from atleak.catalogue.circuits import Pressure, PressureRelation
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.controller_tables import ControllerFile
from atleak.catalogue.fluid import FluidFile, load_fluid
from atleak.catalogue.limits import LimitsFile, load_limits
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.errors import CatalogueError
from atleak.diagnosis.examination import diagnose
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import PROFILES
from atleak.engine.projection import Projection, project
from atleak.measurements.clearances import clearances
from atleak.measurements.readings import Readings

Edited = Callable[..., Path]

GAP = '\n[[gaps]]\ncomponent = "accumulator"\nland = 1\nsection = "p_g"\nfrom = "p_g"\nto = "drain"\ngears = [1, 2]\n'
LINE = (
    '\n[pressures.p_s]\nrelation = "line"\nratio = 0.4\noffset_kpa = 20.0\nlimit_kpa = 300.0\nsource = "own reading"\n'
)


def minimal_with(edited: Edited, *changes: tuple[str, str]) -> Path:
    return edited("controllers", "minimal_example", *changes)


def with_gap(edited: Edited, *changes: tuple[str, str], more: str = "") -> Path:
    gap = GAP
    for old, new in changes:
        assert old in gap
        gap = gap.replace(old, new)
    path = minimal_with(edited)
    with path.open("a", encoding="utf-8") as file:
        file.write(gap + more)
    return path


def error_of(path: Path) -> CatalogueError:
    with pytest.raises(CatalogueError) as caught:
        load_controller(path)
    return caught.value


# --- pressures


@pytest.mark.parametrize(
    ("text", "coefficient", "section", "shown"),
    [
        ("p_g", 1.0, "p_g", "p_g"),
        ("0.1*p_g", 0.1, "p_g", "0.1*p_g"),
        (" .5 * p_m ", 0.5, "p_m", "0.5*p_m"),
        ("1*p_k", 1.0, "p_k", "p_k"),
        ("0", 0.0, None, "drain"),
        ("drain", 0.0, None, "drain"),
    ],
)
def test_pressure_is_a_share_of_a_section(text: str, coefficient: float, section: str | None, shown: str) -> None:
    pressure = Pressure.parse(text)
    assert (pressure.coefficient, pressure.section, str(pressure)) == (coefficient, section, shown)
    assert Pressure.parse(str(pressure)) == pressure


@pytest.mark.parametrize("text", ["", "p-q", "p_g*0.1", "0,1*p_g", "-0.1*p_g", "0.1 p_g", "1e-1*p_g", "2*p_g", "0*p_g"])
def test_anything_else_is_no_pressure(text: str) -> None:
    with pytest.raises(ValueError, match=r"p_g|share"):
        Pressure.parse(text)


# --- the shipped ones


def test_spool_6_has_the_published_diameters(four_speed: Controller) -> None:
    assert four_speed.land("6", 1).nominal_diameter == pytest.approx(9.939e-3, rel=1e-12, abs=0.0)
    assert four_speed.land("6", 2).nominal_diameter == pytest.approx(9.942e-3, rel=1e-12, abs=0.0)
    for land in four_speed.lands:
        assert ("nominal_diameter_mm" in land.representative) == (land.component != "6")
        assert "contact_length_mm" in land.representative


def test_gear_2_has_the_published_components_in_every_section(four_speed: Controller) -> None:
    # Dziubak & Szczepaniak 2023, eqs. (16), (20), (22), (25).
    published = {
        "p_g": "5 7 8 9 11 14 15 16 17 20 23 25 26",
        "p_s": "13 14 15 16 17 18 19",
        "p_m": "7 8 12 12'",
        "p_k": "20 22 23",
    }
    for section, components in published.items():
        leaking = {gap.component for gap in four_speed.gaps_in(2) if gap.section == section}
        assert leaking == set(components.split())


def test_gear_2_has_the_published_pressures(four_speed: Controller) -> None:
    # eqs. (17)-(19), (21), (23), (24), (26)
    ends = {(gap.key, str(gap.high), str(gap.low)) for gap in four_speed.gaps_in(2) if gap.published}
    printed = {
        (("5", 1), "p_g", "p_m"),
        (("8", 1), "p_g", "p_m"),
        (("8", 2), "p_g", "0.1*p_g"),
        (("13", 1), "p_s", "0.1*p_g"),
        (("7", 1), "p_m", "0.1*p_m"),
        (("8", 1), "p_m", "0.1*p_m"),
        (("20", 1), "p_k", "drain"),
        (("20", 2), "p_k", "0.1*p_k"),
        *((("26", land), "p_g", "0.5*p_g") for land in (1, 2, 3, 4)),
    }
    assert printed == ends


def test_flow_between_sections_is_not_into_the_sump(four_speed: Controller) -> None:
    for gap in four_speed.gaps:
        assert gap.into_sump == (str(gap.low) not in {"p_g", "p_s", "p_m", "p_k"})


def test_pump_of_the_study(four_speed: Controller) -> None:
    expected = math.pi * 4.5 * 12 * 12.0 * 8.4  # mm³/rev
    assert four_speed.pump.displacement * 1e9 == pytest.approx(expected, rel=1e-12, abs=0.0)
    assert four_speed.pump.volumetric_efficiency == 0.95
    assert four_speed.pump.representative == ("slip_coefficient",)


def test_control_pressure_is_that_of_the_spool_balance(four_speed: Controller) -> None:
    pressures = four_speed.section_pressures(800e3, 400e3)
    assert pressures["p_s"] == pytest.approx(320_543.7, abs=0.05)
    assert (pressures["p_g"], pressures["p_m"], pressures["p_k"]) == (800e3, 400e3, 400e3)


def test_modulated_and_control_pressure_end_at_their_limits(four_speed: Controller) -> None:
    pressures = four_speed.section_pressures(np.array([400e3, 1000e3, 4000e3]), 0.0)
    assert pressures["p_m"].tolist() == [200e3, 500e3, 500e3]
    assert pressures["p_s"][2] == 500e3


def test_operating_points(four_speed: Controller, hot_idle: OperatingPoint) -> None:
    assert four_speed.operating_points[0].temperature == 80.0
    assert four_speed.operating_points[0].gear == 2
    assert (hot_idle.temperature, hot_idle.engine_speed * 60.0) == (100.0, 800.0)


def test_a_controller_without_gaps_leaks_from_main_pressure_to_the_drain(minimal: Controller) -> None:
    assert [gap.key for gap in minimal.gaps] == [land.key for land in minimal.lands]
    for gap in minimal.gaps:
        assert (str(gap.high), str(gap.low), gap.section) == ("p_g", "drain", "p_g")
        assert gap.gears == frozenset(range(1, 7))
        assert gap.into_sump
        assert not gap.published
    assert minimal.section_pressures(8e5, 4e5) == {"p_g": 8e5, "p_s": 0.0, "p_m": 0.0, "p_k": 4e5}


def test_lands_are_found_by_component_and_plane(four_speed: Controller) -> None:
    land = four_speed.land_of_plane("12'", "1")
    assert land is not None
    assert land.key == ("12'", 1)
    assert four_speed.land_of_plane("12'", "9") is None
    assert four_speed.land_of_plane("99", "1") is None
    assert [land.land for land in four_speed.lands_of("26")] == [1, 2, 3, 4]
    with pytest.raises(KeyError):
        four_speed.land("99", 1)


def test_a_land_takes_what_it_does_not_say_from_the_defaults(minimal: Controller) -> None:
    regulator, piston = minimal.land("pressure_regulator", 1), minimal.land("accumulator", 1)
    assert [regulator.contact_length, piston.contact_length] == pytest.approx([5e-3, 9e-3], rel=1e-12, abs=0.0)
    assert (regulator.spool_material, piston.spool_material) == ("aluminium", "steel")
    assert (piston.body_expansion, piston.spool_expansion) == (21.3e-6, 12.0e-6)
    assert (regulator.part, piston.part) == ("spool", "piston")


def test_thermal_rate_opens_aluminium_on_steel_and_leaves_one_material_alone(minimal: Controller) -> None:
    piston = minimal.land("accumulator", 1)
    expected = (21.3e-6 * 18.04e-3 - 12.0e-6 * 18.0e-3) / 2.0
    assert piston.thermal_rate(18.0e-3, 18.04e-3) == pytest.approx(expected, rel=1e-12, abs=0.0)
    regulator = minimal.land("pressure_regulator", 1)
    assert regulator.thermal_rate(15.0e-3, 15.036e-3) == pytest.approx(21.3e-6 * 18e-6, rel=1e-9, abs=0.0)
    assert regulator.nominal_sleeve_diameter == pytest.approx(15.036e-3, rel=1e-12, abs=0.0)


# --- pressure relations


@given(
    ratio=st.floats(0.0, 2.0),
    offset=st.floats(-2e5, 2e5),
    limit=st.one_of(st.none(), st.floats(1e5, 8e5)),
    low=st.floats(0.0, 1e6),
    width=st.floats(0.0, 1e6),
    part=st.floats(0.0, 1.0),
)
def test_a_relation_s_line_holds_everywhere_between(
    ratio: float, offset: float, limit: float | None, low: float, width: float, part: float
) -> None:
    relation = PressureRelation("line", ratio, offset, limit)
    line = relation.line_between(low, low + width)
    if line is None:
        assert limit is not None
        assert float(relation(low + width)) == limit
        return
    pressure = low + part * width
    assert float(relation(pressure)) == pytest.approx(line[0] * pressure + line[1], rel=1e-9, abs=1e-3)


def test_a_relation_given_as_a_line(edited: Edited) -> None:
    relation = load_controller(with_gap(edited, more=LINE)).relations["p_s"]
    assert relation(500e3) == pytest.approx(220e3, rel=1e-12, abs=0.0)
    assert float(relation(5000e3)) == 300e3


def test_rings_of_main_pressure_can_be_given_apart(four_speed: Controller, edited: Edited) -> None:
    # A_g1 = A_2W and A_g2 = A_3W unless the file says otherwise.
    same = edited(
        "controllers",
        "four_speed_2023",
        ("rod_diameter_mm = 5.0", "rod_diameter_mm = 5.0\ndiameter_g1_mm = 10.0\ndiameter_g2_mm = 9.0"),
    )
    assert load_controller(same).relations == four_speed.relations
    other = edited(
        "controllers", "four_speed_2023", ("rod_diameter_mm = 5.0", "rod_diameter_mm = 5.0\ndiameter_g1_mm = 11.0")
    )
    area = math.pi / 4.0
    ratio = area * (11.0**2 - 9.0**2) / (area * (12.0**2 - 10.0**2 + 9.0**2))
    assert load_controller(other).relations["p_s"].ratio == pytest.approx(ratio, rel=1e-12, abs=0.0)


# --- what a file may not say


@pytest.mark.parametrize(
    ("old", "new", "table", "key", "words"),
    [
        ('spool = "steel"', 'spool = "steal"', "components[4] (accumulator).lands[1]", "spool", ("steal", "'steel'")),
        ('body = "aluminium"\n', "", "components[1] (pressure_regulator).lands[1]", "body", ("no material",)),
        (
            "contact_length_mm = 5.0\n",
            "",
            "components[1] (pressure_regulator).lands[1]",
            "contact_length_mm",
            ("[defaults]",),
        ),
        ("land = 2, nom", "land = 1, nom", "components[1] (pressure_regulator).lands[2]", "land", ("twice", "1")),
        ('"tcc_regulator"', '"accumulator"', "components[4] (accumulator)", "id", ("twice", "'accumulator'")),
        (
            "land = 2, nom",
            'land = 2, planes = ["1"], nom',
            "components[1] (pressure_regulator).lands[2]",
            "planes",
            ("'1'",),
        ),
        ("[1, 2, 3, 4, 5, 6]", "[1, 2, 2]", None, "gears", ("twice", "2")),
        ("gear = 2", "gear = 7", "operating_points[1] (driving_second)", "gear", ("7", "one of 1, 2, 3, 4, 5, 6")),
        ('name = "hot_idle"', 'name = "driving_second"', "operating_points[2] (driving_second)", "name", ("twice",)),
        (
            'name = "hot_idle"',
            'name = "stated"',
            "operating_points[2] (stated)",
            "name",
            ("a job states", "another name"),
        ),
        ("mounting_clearance_um = 18.0", "mounting_clearance_um = 0.018", None, "mounting_clearance_um", ("0.018",)),
        ("displacement_mm3 = 18000.0\n", "", "pump", None, ("displacement_mm3", "tooth_height_mm")),
        ("displacement_mm3 = 18000.0", "displacement_mm3 = 1.0\nteeth = 3", "pump", None, ("not both",)),
        ('["displacement_mm3", "vol', '["displacment", "vol', "pump", "representative", ("'displacment'",)),
        ('["nominal_diameter_mm"', '["diameter"', None, "representative_values[1]", ("'nominal_diameter_mm'",)),
    ],
)
def test_faults_of_meaning_name_table_and_key(
    old: str, new: str, table: str | None, key: str | None, words: tuple[str, ...], edited: Edited
) -> None:
    error = error_of(minimal_with(edited, (old, new)))
    assert error.place.file == "own.toml"
    assert error.place.key == key
    if table is not None:
        assert error.place.table == table
    for word in words:
        assert word in str(error)


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    [
        ("land = 1", "land = 4", "land", ("4", "lands 1")),
        ('"accumulator"', '"acumulator"', "component", ("'acumulator'", "component with lands")),
        ("[1, 2]", "[1, 9]", "gears", ("9", "one of 1, 2, 3, 4, 5, 6")),
        ('from = "p_g"', 'from = "p_q"', "from", ("'p_q'", "p_g, p_s, p_m, p_k")),
        ('to = "drain"', 'to = "1.5*p_g"', "to", ("'1.5*p_g'", "at most 1")),
        ('section = "p_g"', 'section = "p_k"', "section", ("'p_k'", "from = 'p_g'")),
        ('from = "p_g"', 'from = "drain"', "from", ("'drain'", "leaks from no section")),
        ('from = "p_g"', 'from = "p g"', "from", ("'p g'", "'0.1*p_g'")),
    ],
)
def test_faults_of_a_gap_name_it(old: str, new: str, key: str, words: tuple[str, ...], edited: Edited) -> None:
    error = error_of(with_gap(edited, (old, new)))
    assert (error.place.table or "").startswith("gaps[1]")
    assert error.place.key == key
    for word in words:
        assert word in str(error)


def test_a_gap_given_twice_would_count_twice(edited: Edited) -> None:
    error = error_of(with_gap(edited, more=GAP.replace("[1, 2]", "[2, 3]")))
    assert (error.place.table, error.place.key, error.value) == ("gaps[2] (accumulator)", "gears", 2)
    gaps = load_controller(with_gap(edited, more=GAP.replace("[1, 2]", "[3]"))).gaps
    assert [gap.key for gap in gaps].count(("accumulator", 1)) == 2


def test_a_gap_to_a_pressure_that_nothing_gives(edited: Edited) -> None:
    error = error_of(with_gap(edited, ('to = "drain"', 'to = "p_s"')))
    assert (error.place.table, error.place.key) == ("pressures", "p_s")
    assert "[pressures.p_s]" in str(error)


def test_where_a_gap_ends_can_be_said(edited: Edited) -> None:
    first = load_controller(with_gap(edited, more=LINE)).gaps[0]
    assert first.into_sump
    to_section = load_controller(with_gap(edited, ('to = "drain"', 'to = "p_s"'), more=LINE)).gaps[0]
    assert not to_section.into_sump
    said = ('to = "drain"', 'to = "0.1*p_g"\nends_in = "section"')
    assert not load_controller(with_gap(edited, said)).gaps[0].into_sump


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("rod_diameter_mm = 5.0\n", "", ("spool balance with rod_diameter_mm",)),
        ("rod_diameter_mm = 5.0", "rod_diameter_mm = 9.5", ("rod diameter",)),
        ("free_length_mm = 30.0", "free_length_mm = 19.0", ("free length",)),
        ("diameter_1_mm = 12.0", "diameter_1_mm = 3.0", ("A_1",)),
    ],
)
def test_a_spool_balance_that_cannot_be(old: str, new: str, words: tuple[str, ...], edited: Edited) -> None:
    error = error_of(edited("controllers", "four_speed_2023", (old, new)))
    assert (error.place.file, error.place.table) == ("own.toml", "pressures.p_s")
    for word in words:
        assert word in str(error)


def test_a_line_without_its_ratio(edited: Edited) -> None:
    error = error_of(edited("controllers", "four_speed_2023", ("ratio = 0.5\n", "")))
    assert error.place.table == "pressures.p_m"
    assert "ratio" in str(error)


def test_converter_pressure_is_measured_and_takes_no_relation(edited: Edited) -> None:
    error = error_of(with_gap(edited, more=LINE.replace("p_s", "p_k")))
    assert error.place.table == "pressures"
    assert "'p_s' or 'p_m'" in str(error)


def test_a_controller_wants_at_least_one_land(edited: Edited) -> None:
    path = minimal_with(edited)
    text = path.read_text(encoding="utf-8")
    path.write_text(text[: text.index("[[components]]")] + '[[components]]\nid = "1"\nname = "pump"\n', "utf-8")
    assert "at least one land" in str(error_of(path))


def test_a_workshop_s_limit_of_one_land(edited: Edited) -> None:
    path = minimal_with(
        edited, ("mounting_clearance_um = 16.0", "mounting_clearance_um = 16.0, clearance_limit_um = 40")
    )
    controller = load_controller(path)
    assert controller.land("tcc_regulator", 1).clearance_limit == pytest.approx(40e-6, rel=1e-12, abs=0.0)
    assert controller.land("accumulator", 1).clearance_limit is None


# --- the document that says how to write one


def test_the_document_names_every_key(root: Path) -> None:
    text = described(root)
    for file in (ControllerFile, FluidFile, LimitsFile):
        missing = {key for key in keys_of(file) if f"`{key}`" not in text}
        assert missing == set()


def test_the_document_s_examples_load_and_give_a_diagnosis(root: Path, tmp_path: Path) -> None:
    paths = examples(root, tmp_path)
    controller, fluid, limits = (
        load_controller(paths["my_box"]),
        load_fluid(paths["my_atf"]),
        load_limits(paths["my_limits"]),
    )
    diagnosis = diagnose(controller, fluid, limits)
    assert diagnosis.hot_idle is diagnosis.projection
    assert diagnosis.projection.leakage > 0.0


def test_the_document_s_circuit_can_be_added_to_its_controller(root: Path, tmp_path: Path) -> None:
    controller = load_controller(examples(root, tmp_path)["my_box with circuits"])
    (clutch,) = controller.circuits
    assert (clutch.id, clutch.gears) == ("clutch_c1", {1, 2, 3})
    assert clutch.feeds[0].diameter == pytest.approx(0.5e-3, rel=1e-12, abs=0.0)
    assert {str(gap.high) for gap in controller.gaps} == {"p_g", "clutch_c1"}
    assert controller.permissible_at(1, "idle").low == pytest.approx(400e3, abs=1e-6)


def test_the_document_says_what_its_circuit_holds(
    root: Path, tmp_path: Path, readings_of: Callable[..., Readings]
) -> None:
    text = " ".join(described(root).split())
    assert (
        "clutch C1 holds 417 kPa when new. With both its lands worn to 35 µm it holds 231, and all that leaks" in text
    )
    paths = examples(root, tmp_path)
    controller, fluid = load_controller(paths["my_box with circuits"]), load_fluid(paths["my_atf"])

    def at_hot_idle(clearance: float) -> Projection:
        lands = (controller.land("clutch_c1_valve", number) for number in (1, 2))
        sheet = {land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * clearance) for land in lands}
        states = clearances(readings_of(controller, sheet), controller)
        return project(LeakageModel(controller, states, fluid, PROFILES["workshop"]), controller.operating_points[0])

    new, worn = at_hot_idle(13e-6), at_hot_idle(35e-6)
    assert new.circuit("clutch_c1").pressure / 1e3 == pytest.approx(417, abs=0.5)
    assert worn.circuit("clutch_c1").pressure / 1e3 == pytest.approx(231, abs=0.5)
    assert worn.share == pytest.approx(0.017, abs=0.0005)


def described(root: Path) -> str:
    """Return the pages that say how to write files of the catalogue."""
    names = ("describing-a-controller", "circuits-and-repairs", "fluids-and-limits")
    return "\n".join((root / "docs" / f"{name}.md").read_text(encoding="utf-8") for name in names)


def examples(root: Path, folder: Path) -> dict[str, Path]:
    """Write the document's files, and the controller with the circuit that is added to it, each by its name."""
    text = described(root)
    controller, _, circuit, fluid, limits = re.findall(r"```toml\n(.*?)```", text, flags=re.DOTALL)
    contents = {
        "my_box": controller,
        "my_box with circuits": controller + circuit,
        "my_atf": fluid,
        "my_limits": limits,
    }
    paths = {name: folder / f"{number}.toml" for number, name in enumerate(contents)}
    for name, path in paths.items():
        path.write_text(contents[name], encoding="utf-8")
    return paths


def keys_of(model: type[BaseModel]) -> set[str]:
    """Every key of a file's tables, however deep."""
    keys: set[str] = set()
    for name, field in model.model_fields.items():
        inner = [table for table in models_in(field.annotation) if table is not model]
        if not inner:
            keys.add(field.alias or name)
        for table in inner:
            keys |= keys_of(table)
    return keys


def models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for inner in getattr(annotation, "__args__", ()) for model in models_in(inner)]


def test_keys_are_collected_from_the_deepest_table() -> None:
    keys = keys_of(ControllerFile)
    assert {"gears", "expansion_per_k", "nominal_diameter_mm", "from", "to", "shear_modulus_mpa", "p_k_kpa"} <= keys
    assert len(keys) > 50
