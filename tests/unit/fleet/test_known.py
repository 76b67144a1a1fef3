"""The folders that are remembered, from which a page offers results of fleets."""

from __future__ import annotations

import json
import threading
from pathlib import Path

import pytest

from atleak.common.errors import OutputError
from atleak.fleet import folder as known
from atleak.fleet.folder import forget, known_folders, note
from atleak.fleet.results import Results


def test_the_folder_that_was_used_last_comes_first_and_each_stands_once(
    own_home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in ("spring", tmp_path / "autumn", "./spring/../spring"):
        note(folder)
    assert [each.path for each in known_folders()] == [tmp_path / "spring", tmp_path / "autumn"]
    assert len({each.id for each in known_folders()}) == 2
    assert all("spring" not in each.id for each in known_folders())


def test_a_folder_is_there_as_long_as_it_holds_results(own_home: Path, tmp_path: Path) -> None:
    Results.open(tmp_path / "spring", for_writing=True).close()
    (tmp_path / "something else").mkdir()
    for name in ("spring", "never", "something else"):
        note(tmp_path / name)
    assert {each.path.name: each.is_there for each in known_folders()} == {
        "spring": True,
        "never": False,
        "something else": False,
    }
    (tmp_path / "spring" / "run.json").write_text("{", encoding="utf-8")
    assert not known_folders()[-1].is_there


def test_what_is_forgotten_is_offered_no_more_and_stays_on_the_disk(own_home: Path, tmp_path: Path) -> None:
    Results.open(tmp_path / "spring", for_writing=True).close()
    note(tmp_path / "spring")
    note(tmp_path / "autumn")
    spring = known_folders()[1]
    forget(spring)
    forget(spring)  # in another tab too
    assert [each.path.name for each in known_folders()] == ["autumn"]
    assert (tmp_path / "spring" / "run.json").is_file()


def test_of_too_many_the_one_that_was_used_longest_ago_goes(
    own_home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(known, "_MOST", 3)
    for name in ("a", "b", "c", "a", "d"):
        note(tmp_path / name)
    assert [each.path.name for each in known_folders()] == ["d", "a", "c"]


def test_commands_that_note_at_once_lose_none(own_home: Path, tmp_path: Path) -> None:
    threads = [threading.Thread(target=note, args=(tmp_path / str(number),)) for number in range(8)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert {each.path.name for each in known_folders()} == set(map(str, range(8)))


@pytest.mark.parametrize("content", ["{", "[]", '{"/a": 3}'])
def test_a_damaged_list_counts_as_empty_and_is_written_anew(own_home: Path, tmp_path: Path, content: str) -> None:
    own_home.mkdir()
    (own_home / "fleets.json").write_text(content, encoding="utf-8")
    assert known_folders() == ()
    note(tmp_path / "spring")
    assert [each.path.name for each in known_folders()] == ["spring"]
    assert str(tmp_path / "spring") in json.loads((own_home / "fleets.json").read_text(encoding="utf-8"))


def test_a_home_that_cannot_be_written_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "home").write_text("no folder", encoding="utf-8")
    monkeypatch.setenv("ATLEAK_HOME", str(tmp_path / "home"))
    with pytest.raises(OutputError, match="home: cannot be made"):
        note(tmp_path / "spring")
    assert known_folders() == ()
