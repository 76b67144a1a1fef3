"""How a log's columns were settled goes into the job file, and a file's own name into messages and records."""

from __future__ import annotations

from pathlib import Path

import pytest

from atleak import catalogue
from atleak.errors import CatalogueError
from atleak.instruments import load_instruments
from atleak.intake.road_test import read_road_test, remember, understand
from atleak.job_file import SourceFile, load_source, road_test_choices
from atleak.limits import load_limits

ROWS = "".join(f"{step / 10};800;{6 + step};{9 + step};80;2\n" for step in range(30))
LOG = ("time [s];engine_speed [rpm];p one [bar];p two [bar];atf_temperature [°C];gear\n" + ROWS).encode()


@pytest.fixture
def kept(tmp_path: Path) -> Path:
    """Answers given earlier for logs with this header."""
    path = tmp_path / "answers.json"
    answers = {"main_pressure": "p one [bar]", "converter_pressure": "p two [bar]"}
    remember(path, understand(LOG, name="a.csv").signature, answers, {"main_pressure": "kPa"})
    return path


@pytest.mark.parametrize("mapping", [{}, {"main_pressure": "p two [bar]"}, {"converter_pressure": "p one [bar]"}])
def test_choices_read_the_log_as_it_was_read_with_the_memory(kept: Path, mapping: dict[str, str]) -> None:
    log = understand(LOG, name="a.csv", mapping=mapping, remembered=kept)
    choices = road_test_choices(log, mapping, {}, remembered=kept)
    elsewhere = read_road_test(LOG, name="a.csv", **choices)
    assert set(elsewhere.channels) == set(log.road_test.channels)
    for quantity, channel in log.road_test.channels.items():
        assert (elsewhere.channels[quantity].values == channel.values).all()
        assert elsewhere.channels[quantity].column == channel.column


def test_answers_that_were_not_consulted_are_no_choices(kept: Path) -> None:
    log = understand(LOG, name="a.csv", mapping={"main_pressure": "p two [bar]"})
    choices = road_test_choices(log, {"main_pressure": "p two [bar]"}, {}, remembered=kept)
    assert choices == {"mapping": {"main_pressure": "p two [bar]"}, "units": {}}


def test_a_file_at_hand_as_bytes_keeps_its_name() -> None:
    content = catalogue.catalogue_files("limits")["project_default"].read_bytes()
    assert load_source(load_limits, SourceFile("our limits: 2026.toml", content)).origin.file == "our limits: 2026.toml"
    with pytest.raises(CatalogueError, match=r"^our limits: 2026\.toml, ") as caught:
        load_source(load_limits, SourceFile("our limits: 2026.toml", content.replace(b"watch = 10.0", b"watch = 'x'")))
    assert caught.value.place.file == "our limits: 2026.toml"


def test_two_files_keep_their_names() -> None:
    files = catalogue.catalogue_files("instruments")
    sources = [SourceFile("one.toml", files["micrometer"].read_bytes())]
    sources.append(SourceFile("two.toml", files["bore_gauge"].read_bytes()))
    found = load_source(load_instruments, *sources)
    assert (found.spool.origin.file, found.sleeve.origin.file) == ("one.toml", "two.toml")
