"""Damaged files at every door: nothing but the package's own errors comes out, and it comes soon.

These are a handful for each door, the same at every run. ``python -m tests.fuzz.run`` tries new ones for as long as one
likes.
"""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, Phase, given, settings

from atleak.common.errors import InputError
from atleak.common.sentences import Sentence

from . import doors, run
from .damage import damaged
from .doors import OwnFault, fault_behind, passes
from .seeds import DOORS, seeds

FEW = settings(
    max_examples=8, phases=[Phase.explicit, Phase.generate], suppress_health_check=[HealthCheck.too_slow]
)  # fmt: skip


QUICK = ("study", "record", "instruments", "picture", "remembered")
IN_TURN = [door if door in QUICK else pytest.param(door, marks=pytest.mark.slow) for door in DOORS]


@pytest.mark.parametrize("door", IN_TURN)
def test_what_the_damages_start_from_is_sound(door):
    """A door that refuses the sound file would refuse the damaged ones for that alone."""
    for name, content in seeds(door):
        assert passes(door, name, content) is None, name


@pytest.mark.parametrize("door", IN_TURN)
def test_a_damaged_file_ends_in_an_error_of_the_package_or_is_taken(door):
    @FEW
    @given(damaged(door))
    def attempt(file: tuple[str, bytes]) -> None:
        passes(door, *file)

    attempt()


def test_what_comes_out_and_should_not_is_counted_and_kept(tmp_path, monkeypatch):
    def broken(name: str, content: bytes) -> None:
        raise KeyError("a fault of the program")

    monkeypatch.setitem(doors.OF, "record", broken)
    monkeypatch.setattr(run, "ROUND", 5)
    tried = run.try_door("record", 0.0, 1, tmp_path)
    assert tried.files == 5
    assert tried.wrong == {"KeyError  \"'a fault of the program'\"": 5}
    assert {path.suffix for path in tmp_path.iterdir()} in ({".json", ".txt"}, {".toml", ".txt"})


def test_a_fault_of_atleak_s_own_is_no_refusal_of_the_file(tmp_path, monkeypatch):
    monkeypatch.setattr("atleak.job.zip_file.tomllib", None)  # so that `parse_job` itself fails
    monkeypatch.setattr(run, "ROUND", 5)
    with pytest.raises(OwnFault, match=r"^AttributeError at job/zip_file\.py:\d+$"):
        passes("record", "job.toml", b'number = "7"')
    tried = run.try_door("record", 0.0, 1, tmp_path)
    assert sum(tried.wrong.values()) > 0
    assert all("AttributeError at job/zip_file.py" in said for said in tried.wrong)


def test_a_fault_that_a_library_raises_is_one_of_the_file():
    refused = passes("job", "job.zip", b"PK\3\4 and no more")
    assert refused is not None
    assert fault_behind(refused) is None


def test_a_fault_behind_another_refusal_is_found(monkeypatch):
    monkeypatch.setattr("atleak.job.zip_file.tomllib", None)

    def again(name: str, content: bytes) -> None:
        try:
            doors.parse_job(content, name)
        except InputError as error:
            raise InputError(Sentence("a job in another")) from error

    monkeypatch.setitem(doors.OF, "record", again)
    with pytest.raises(OwnFault, match="AttributeError at job/zip_file"):
        passes("record", "job.toml", b'number = "7"')
