"""Catalogue files: what ships states its source and date, and what is wrong in one is named so that it can be found."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import Any

import pytest

from atleak.catalogue.controller_file import controllers, load_controller
from atleak.catalogue.entries import catalogue_files
from atleak.catalogue.fluid import fluids, load_fluid
from atleak.catalogue.instruments import load_instrument
from atleak.catalogue.limits import limit_sets, load_limits
from atleak.common.errors import CatalogueError, InputError, Place, nearest_name

Edited = Callable[..., Path]
LOADERS: dict[str, Callable[[Any], Any]] = {
    "controllers": load_controller,
    "fluids": load_fluid,
    "limits": load_limits,
    "instruments": load_instrument,
}
SHIPPED = [(kind, name) for kind in LOADERS for name in catalogue_files(kind)]
EXAMPLES = {
    "controllers": "minimal_example",
    "fluids": "hipol_atf_iid",
    "limits": "project_default",
    "instruments": "micrometer",
}


def refused(load: Callable[[Any], Any], path: Any) -> CatalogueError:
    with pytest.raises(CatalogueError) as caught:
        load(path)
    return caught.value


def controller_error(edited: Edited, *changes: tuple[str, str]) -> CatalogueError:
    return refused(load_controller, edited("controllers", "minimal_example", *changes))


@pytest.mark.parametrize(("kind", "name"), SHIPPED)
def test_every_shipped_file_loads_and_states_source_and_day(kind: str, name: str) -> None:
    entry = LOADERS[kind](name)
    assert entry.id == name
    assert entry.name
    assert len(entry.source) > 10
    assert date(2000, 1, 1) < date.fromisoformat(entry.date)
    content = catalogue_files(kind)[name].read_bytes()
    assert entry.origin.sha256 == hashlib.sha256(content).hexdigest()
    assert entry.origin.file == f"{name}.toml"


@pytest.mark.parametrize(("kind", "name"), SHIPPED)
def test_every_shipped_file_says_its_source_in_its_head_too(kind: str, name: str) -> None:
    first = catalogue_files(kind)[name].read_text(encoding="utf-8").split("\n\n")[0]
    assert first.startswith("# ")


def test_lists_hold_every_shipped_entry() -> None:
    assert [entry.id for entry in controllers()] == list(catalogue_files("controllers"))
    assert [entry.id for entry in fluids()] == list(catalogue_files("fluids"))
    assert [entry.id for entry in limit_sets()] == list(catalogue_files("limits"))
    assert len(fluids()) >= 17


@pytest.mark.parametrize("kind", LOADERS)
@pytest.mark.parametrize("key", ["source", "date", "name", "id"])
def test_a_file_without_source_or_date_is_refused(kind: str, key: str, edited: Edited) -> None:
    path = edited(kind, EXAMPLES[kind], (f"\n{key} = ", f"\n# {key} = "))
    error = refused(LOADERS[kind], path)
    assert error.place == Place(file="own.toml", key=key)
    assert error.problem == "required key is missing"


@pytest.mark.parametrize("kind", LOADERS)
def test_an_empty_source_is_none(kind: str, edited: Edited) -> None:
    path = edited(kind, EXAMPLES[kind], ("\nsource = ", '\nsource = " "  # '))
    error = refused(LOADERS[kind], path)
    assert (error.place.key, error.value, error.expected) == ("source", " ", "text that is not empty")


@pytest.mark.parametrize(
    ("written", "accepted"),
    [("2026-11-21", True), ('"2026-02-30"', False), ('"21.11.2026"', False), ("2026-11-21T10:00:00", False)],
)
def test_a_date_is_a_day_that_exists(written: str, accepted: bool, edited: Edited) -> None:
    path = edited("controllers", "minimal_example", ('date = "2026-11-21"', f"date = {written}"))
    if accepted:
        assert load_controller(path).date == "2026-11-21"
    else:
        error = refused(load_controller, path)
        assert error.place.key == "date"
        assert "2026-01-31" in str(error)


def test_an_unknown_key_names_the_nearest_and_comes_before_the_key_it_leaves_missing(edited: Edited) -> None:
    error = controller_error(edited, ("volumetric_efficiency = 0.92", "volumetric_eficiency = 0.92"))
    assert error.place == Place(file="own.toml", table="pump", key="volumetric_eficiency")
    assert error.problem == "unknown key"
    assert error.value == 0.92
    assert "displacement_mm3" in (error.expected or "")
    assert error.nearest == "volumetric_efficiency"
    assert [(other.problem, other.place.key) for other in error.others] == [
        ("required key is missing", "volumetric_efficiency")
    ]
    assert "did you mean 'volumetric_efficiency'?" in str(error)


def test_an_unknown_key_deep_in_a_list_names_its_table_as_a_person_finds_it(edited: Edited) -> None:
    error = controller_error(edited, ("nominal_diameter_mm = 12.5", "nominal_diametr_mm = 12.5"))
    assert error.place.table == "components[1] (pressure_regulator).lands[2]"
    assert error.nearest == "nominal_diameter_mm"


def test_an_unknown_table_is_not_printed_whole(edited: Edited) -> None:
    path = edited("limits", "project_default", ("[wear_percent]", "[wear]"))
    error = refused(load_limits, path)
    assert error.nearest == "wear_percent"
    assert error.value is None


@pytest.mark.parametrize(
    ("old", "new", "table", "key", "value", "expected"),
    [
        ("= 18000.0", '= "18000"', "pump", "displacement_mm3", "18000", "a number, without quotes"),
        ("= 0.92", "= true", "pump", "volumetric_efficiency", True, "a number, without quotes"),
        ("= 0.92", "= 92", "pump", "volumetric_efficiency", 92, "less than or equal to 1"),
        ("= 0.92", "= nan", "pump", "volumetric_efficiency", None, "less than or equal to 1"),
        ("[1, 2, 3", '["1", 2, 3', None, "gears[1]", "1", "a whole number, without quotes"),
        ("[1, 2, 3", "[1, 2.5, 3", None, "gears[2]", 2.5, "a whole number, without quotes"),
        ('id = "tcc_regulator"', "id = 7", "components[2] (7)", "id", 7, "text in quotes"),
        ('id = "minimal_example"', 'id = "Meine Datei"', None, "id", "Meine Datei", "small letters, digits and _"),
        ("[1, 2, 3, 4, 5, 6]", "[]", None, "gears", [], "a list of at least 1"),
        ("[1, 2, 3, 4, 5, 6]", "6", None, "gears", 6, "a list in square brackets"),
        ("= 21.3e-6", "= 21.3", "materials.aluminium", "expansion_per_k", 21.3, "less than 0.001"),
        ("= 1500.0", "= 0", "operating_points[1] (driving_second)", "engine_rpm", 0, "greater than 0"),
        ("= 800.0", "= 800e3", "operating_points[1] (driving_second)", "p_g_kpa", 800e3, "less than or equal to 10000"),
    ],
)
def test_a_value_is_named_with_table_key_and_what_was_expected(
    old: str, new: str, table: str | None, key: str, value: object, expected: str, edited: Edited
) -> None:
    error = controller_error(edited, (old, new))
    assert (error.place.file, error.place.table, error.place.key) == ("own.toml", table, key)
    if value is not None:
        assert error.value == value
    assert error.expected == expected
    assert "pydantic" not in str(error)


def test_several_faults_are_all_listed_once(edited: Edited) -> None:
    error = controller_error(edited, ("= 18000.0", "= -1"), ("= 0.92", "= 92"), ("= 700.0", "= -3"))
    assert isinstance(error, CatalogueError)
    lines = str(error).splitlines()
    assert len(lines) == 3
    assert [word in line for word, line in zip(("-1", "92", "-3"), lines, strict=True)] == [True] * 3


def test_a_long_list_of_faults_is_cut_and_says_so() -> None:
    others = [InputError(f"fault {number}") for number in range(20)]
    text = str(InputError("first", others=others))
    assert len(text.splitlines()) == 11
    assert text.endswith("… and 11 more")


def test_toml_syntax_names_the_line(edited: Edited) -> None:
    error = controller_error(edited, ("gears = [1", "gears = 1"))
    assert error.place.file == "own.toml"
    assert "line 11" in str(error)


def test_a_key_given_twice_is_a_fault_of_syntax(edited: Edited) -> None:
    error = controller_error(edited, ("volumetric_efficiency = 0.92", "volumetric_efficiency = 0.92\n" * 2))
    assert "is not valid TOML" in str(error)


def test_a_byte_order_mark_is_no_fault(edited: Edited) -> None:
    path = edited("controllers", "minimal_example")
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert load_controller(path).id == "minimal_example"


def test_windows_line_ends_are_no_fault(edited: Edited) -> None:
    path = edited("controllers", "minimal_example")
    path.write_bytes(path.read_bytes().replace(b"\r\n", b"\n").replace(b"\n", b"\r\n"))
    assert len(load_controller(path).lands) == 5


def test_text_that_is_not_utf_8_is_said_to_be_so(edited: Edited) -> None:
    path = edited("controllers", "minimal_example", ("pressure regulator valve", "Hauptdruckventil für Öl"))
    path.write_bytes(path.read_text(encoding="utf-8").encode("cp1252", errors="replace"))
    error = refused(load_controller, path)
    assert error.expected == "TOML text in UTF-8"


@pytest.mark.parametrize("content", [b"", b"\x00\x01\x02", b"PK\x03\x04 a workbook"])
def test_a_file_of_something_else_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_bytes(content)
    assert refused(load_controller, path).place.file == "own.toml"


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    error = refused(load_controller, tmp_path)
    assert error.problem == "is a folder"
    assert error.value == str(tmp_path)


@pytest.mark.parametrize("name", ["own.toml", "folder/own", "x" * 5000, "", "."])
def test_a_file_that_is_not_there(name: str) -> None:
    error = refused(load_controller, name)
    assert error.problem in {"no such file", "no such entry among the controllers"}
    assert "four_speed_2023" in (error.expected or "")


def test_a_mistyped_id_names_the_nearest() -> None:
    error = refused(load_controller, "four_sped_2023")
    assert error.nearest == "four_speed_2023"
    assert error.value == "four_sped_2023"


def test_an_id_is_found_before_a_file_of_that_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "minimal_example").write_text("not TOML", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert load_controller("minimal_example").id == "minimal_example"


def test_entries_are_read_by_path_object_and_text_alike(edited: Edited) -> None:
    path = edited("fluids", "hipol_atf_iid")
    assert load_fluid(path) == load_fluid(str(path))


def test_nearest_name_is_silent_when_nothing_is_near() -> None:
    assert nearest_name("zzz", ["paper", "workshop"]) is None


def test_a_place_says_only_what_is_known() -> None:
    assert str(Place()) == ""
    everything = Place(file="a.xlsx", sheet="S", row=3, column="C", table="pump", key="teeth")
    assert str(everything) == "a.xlsx, sheet 'S', row 3, column C, [pump], key 'teeth'"


@pytest.mark.parametrize("line", ["deep = " + "[" * 5000 + "]" * 5000, "long = " + "9" * 5000])
def test_a_file_nested_too_deep_or_a_number_too_long_is_refused_in_words(tmp_path: Path, line: str) -> None:
    path = tmp_path / "own.toml"
    path.write_text(f"{line}\n", encoding="utf-8")
    for load in LOADERS.values():
        assert str(refused(load, path)).startswith("own.toml: is not valid TOML")


def test_a_workbook_in_place_of_the_file_made_of_it_says_how_to_make_that(tmp_path: Path) -> None:
    path = tmp_path / "my_unit.xlsx"
    path.write_bytes(b"PK\x03\x04\xb3")
    made = "atleak controller from-workbook my_unit.xlsx -o my_unit.toml"
    assert str(refused(load_controller, path)) == f"my_unit.xlsx: is a workbook; expected the file that '{made}' makes"
    assert str(refused(load_limits, path)) == "my_unit.xlsx: is a workbook; expected TOML text in UTF-8"
