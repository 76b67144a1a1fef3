"""The user's own entries stand beside the shipped ones, and one that is broken breaks nothing else."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from atleak.catalogue.controller_file import CONTROLLERS, controllers, load_controller
from atleak.catalogue.entries import (
    KINDS,
    Shelf,
    catalogue_files,
    listed_entries,
    own_files,
    own_folder,
    remove_own,
    removed_own,
    restore_own,
    shipped_files,
    shipped_names,
    write_own,
)
from atleak.catalogue.fluid import FLUIDS, load_fluid
from atleak.catalogue.instruments import INSTRUMENTS
from atleak.catalogue.limits import LIMIT_SETS
from atleak.common.errors import CatalogueError, OutputError
from atleak.common.files import made_folder
from atleak.job.case import Case
from atleak.job.zip_file import read_job_file, write_job_file

Put = Callable[..., Path]


@pytest.fixture
def put(own_home: Path) -> Put:
    """Puts a shipped file, with words replaced, into the user's own catalogue."""

    def write(kind: str, shipped: str, file: str, *changes: tuple[str, str]) -> Path:
        text = shipped_files(kind)[shipped].read_text(encoding="utf-8")
        for old, new in changes:
            assert old in text
            text = text.replace(old, new, 1)
        path = made_folder(own_folder(kind)) / file
        path.write_text(text, encoding="utf-8")
        return path

    return write


OWN_ID = ('id = "minimal_example"', 'id = "my_box"')


def test_without_own_files_the_catalogue_is_what_ships(own_home: Path) -> None:
    assert not own_home.exists()
    for kind in KINDS:
        assert catalogue_files(kind) == shipped_files(kind)


def test_an_own_entry_is_chosen_by_its_id_and_says_whose_it_is(put: Put) -> None:
    path = put("controllers", "minimal_example", "my_box.toml", OWN_ID)
    own = load_controller("my_box")
    assert (own.id, own.origin.path, own.origin.own) == ("my_box", path, True)
    assert [each.id for each in controllers() if each.origin.own] == ["my_box"]
    assert list(catalogue_files("controllers")) == sorted({*shipped_files("controllers"), "my_box"})


def test_a_broken_own_file_is_named_and_the_others_work(put: Put) -> None:
    put("controllers", "minimal_example", "my_box.toml", OWN_ID)
    put("controllers", "minimal_example", "torn.toml", ("[pump]", "[pump"))
    put("controllers", "minimal_example", "nameless.toml", ('id = "minimal_example"', 'id = "other"'))
    found = listed_entries("controllers", load_controller)
    assert set(found.entries) == {*shipped_files("controllers"), "my_box"}
    named, torn = sorted(found.faults, key=lambda fault: fault.place.file or "")
    assert (named.place.file, named.place.key, named.value) == ("nameless.toml", "id", "other")
    assert str(named).endswith("expected nameless, or another name of the file")
    assert torn.place.file == "torn.toml"
    assert "is not valid TOML" in torn.problem


def test_an_own_entry_does_not_take_a_shipped_ones_id(put: Put) -> None:
    put("controllers", "minimal_example", "minimal_example.toml", ("volumetric", "volumetrik"))
    assert not load_controller("minimal_example").origin.own
    (fault,) = listed_entries("controllers", load_controller).faults
    assert str(fault) == (
        "minimal_example.toml, key 'id': has the id of an entry that ships with atleak and is left aside "
        "(found 'minimal_example'); expected an id of its own, and a file named as it"
    )


def test_an_own_fluid_refers_to_shipped_used_data_alone(put: Put) -> None:
    put("fluids", "hipol_atf_iid_used", "drum_used.toml", ('id = "hipol_atf_iid_used"', 'id = "drum_used"'))
    put("fluids", "mobil_atf_220", "drum.toml", ('id = "mobil_atf_220"', 'id = "drum"\nused = "drum_used"'))
    with pytest.raises(CatalogueError, match=r"drum\.toml, key 'used': no such entry"):
        load_fluid("drum")


def test_a_job_with_an_own_valve_body_is_another_one_when_its_file_changes(put: Put) -> None:
    put("controllers", "minimal_example", "my_box.toml", OWN_ID)
    case = Case(controller="my_box")
    before = case.key
    put(
        "controllers",
        "minimal_example",
        "my_box.toml",
        OWN_ID,
        ("volumetric_efficiency = 0.", "volumetric_efficiency = 0.1"),
    )
    assert case.key != before


def test_a_job_file_takes_the_own_valve_body_with_it(put: Put, own_home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = put("controllers", "minimal_example", "my_box.toml", OWN_ID)
    case = Case(controller="my_box")
    diagnosis = case.diagnose()
    content = write_job_file(diagnosis, case=case)
    path.unlink()
    opened = read_job_file(content).diagnose()
    assert opened.controller.id == "my_box"
    assert opened.projection.share == pytest.approx(diagnosis.projection.share, abs=1e-12)


def test_an_own_file_is_written_once_and_replaced_only_by_who_knows_it(own_home: Path) -> None:
    path = write_own("fluids", "drum", "first = 1\n")
    assert path == own_home / "catalogue" / "fluids" / "drum.toml"
    known = hashlib.sha256(path.read_bytes()).hexdigest()
    with pytest.raises(OutputError, match=r"drum\.toml: is in your catalogue already"):
        write_own("fluids", "drum", "second = 2\n")
    write_own("fluids", "drum", "second = 2\n", over=known)
    with pytest.raises(OutputError, match="changed by someone else"):
        write_own("fluids", "drum", "third = 3\n", over=known)
    assert path.read_text(encoding="utf-8") == "second = 2\n"
    with pytest.raises(OutputError, match="ships with atleak"):
        write_own("fluids", "mobil_atf_220", "")


def test_a_file_that_was_taken_out_can_be_brought_back(put: Put) -> None:
    text = put("controllers", "minimal_example", "my_box.toml", OWN_ID).read_bytes()
    remove_own("controllers", "my_box")
    assert "my_box" not in catalogue_files("controllers")
    assert list(removed_own("controllers")) == ["my_box"]
    restore_own("controllers", "my_box")
    assert own_files("controllers")["my_box"].read_bytes() == text
    assert removed_own("controllers") == {}


def test_a_file_is_not_brought_back_over_another_one(put: Put) -> None:
    put("controllers", "minimal_example", "my_box.toml", OWN_ID)
    remove_own("controllers", "my_box")
    newer = put("controllers", "minimal_example", "my_box.toml", OWN_ID, ("Example of a", "Another"))
    with pytest.raises(OutputError, match="is in your catalogue already"):
        restore_own("controllers", "my_box")
    assert "Another" in newer.read_text(encoding="utf-8")


def test_taking_out_what_is_not_there_is_refused_in_words(own_home: Path) -> None:
    with pytest.raises(OutputError, match=r"my_box.toml: cannot be moved"):
        remove_own("controllers", "my_box")


@pytest.mark.parametrize("shelf", [CONTROLLERS, FLUIDS, LIMIT_SETS, INSTRUMENTS], ids=lambda shelf: shelf.kind)
def test_where_one_chooses_shipped_entries_are_called_as_in_their_files(shelf: Shelf[Any]) -> None:
    names = shipped_names(shelf.kind)
    assert list(names) == list(shipped_files(shelf.kind))
    for entry in map(shelf.load, names):
        listed = names[entry.id]
        assert (listed.name, listed.measures) == (entry.name, getattr(entry, "measures", ()))
        assert not listed.origin.own
