"""A log is followed by the command line: events, present values, a summary, and the job that is kept."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from atleak.cli import watch

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def growing(sample_log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the sample's log of which each pause of the command writes 300 more lines; then it is interrupted."""
    path, lines = tmp_path / "trackLog.csv", sample_log.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"")
    left = [b"".join(lines[first : first + 300]) for first in range(0, len(lines), 300)]

    def pause(_: float) -> None:
        if not left:
            raise KeyboardInterrupt
        with path.open("ab") as stream:
            stream.write(left.pop(0))

    monkeypatch.setattr(watch.time, "sleep", pause)
    monkeypatch.setattr(watch.WatchedLog, "_rests_until", property(lambda _: 0.0, lambda *_: None), raising=False)
    return path


def test_events_present_values_and_the_summary(run: Run, growing: Path) -> None:
    status, out, err = run("watch", growing)
    assert (status, err) == (0, "")
    lines = out.splitlines()
    assert lines[0].startswith("waiting: trackLog.csv: is empty so far")
    shifts = [line for line in lines if line.startswith("shift ")]
    assert shifts == ["shift 1 → 2, 0.9 to 0.9 s", "shift 2 → 3, 5.1 to 5.1 s", "shift 3 → 4, 8.5 to 8.5 s"]
    assert "main (line) pressure 625 kPa (permitted 412 to 1\xa0176)" in out
    assert "unit: ● ok (provisional), by the main pressure of the log alone" in lines
    assert "kept" not in out


def test_the_job_is_kept_if_asked(run: Run, growing: Path) -> None:
    status, out, _ = run("watch", growing, "--keep")
    assert status == 0
    kept = out.rpartition("kept in the job book: ")[2].strip()
    shown = json.loads(run("jobs", "show", kept, "--json", "-")[1])
    assert (shown["road_test"]["file"], shown["road_test"]["rows"]) == ("trackLog.csv", 1201)


def test_a_log_that_begins_anew_is_a_job_of_its_own(
    run: Run, sample_log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, steps = tmp_path / "trackLog.csv", [900, 400]
    lines = sample_log.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[: steps[0]]))

    def pause(_: float) -> None:
        if len(steps) == 1:
            raise KeyboardInterrupt
        path.write_bytes(b"".join(lines[: steps.pop()]))

    monkeypatch.setattr(watch.time, "sleep", pause)
    monkeypatch.setattr(watch.WatchedLog, "_rests_until", property(lambda _: 0.0, lambda *_: None), raising=False)
    status, out, _ = run("watch", path, "--keep")
    assert status == 0
    assert "trackLog.csv ended, a log begins anew" in out
    assert out.count("kept in the job book: ") == 2
    assert len(json.loads(run("jobs", "list", "--json", "-")[1])) == 2


def test_it_ends_by_itself_once_the_log_is_quiet(run: Run, sample_log: Path) -> None:
    status, out, _ = run("watch", sample_log, "--end-after", "0")
    assert status == 0
    assert "Road test minimum_acceleration_test.csv:" in out


@pytest.mark.parametrize(
    ("content", "said"),
    [(b"", "is empty so far"), (b"\x89PNG\r\n\x1a\n" + bytes(99), "no road-test log"), (None, "cannot be opened")],
    ids=["empty", "picture", "not there"],
)
def test_a_wrong_file_is_named(run: Run, tmp_path: Path, content: bytes | None, said: str) -> None:
    path = tmp_path / "wrong.csv"
    if content is not None:
        path.write_bytes(content)
    status, _, err = run("watch", path, "--end-after", "0")
    assert status == 2
    assert err.startswith("atleak: wrong.csv: ")
    assert said in err


def test_a_terminal_has_one_line_of_present_values(run: Run, growing: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    show = watch._Screen.__init__

    def on_a_terminal(self: watch._Screen, say: watch.Wording) -> None:
        show(self, say)
        self.in_place = True

    monkeypatch.setattr(watch._Screen, "__init__", on_a_terminal)
    out = run("watch", growing)[1]
    followed = out.partition("Road test")[0]
    assert "\rtime 3.0 s · main (line) pressure" in followed
    assert followed.count("\n") < 20  # no line for every reading


def test_a_heading_without_rows_is_no_log(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("time;rpm\n", encoding="utf-8")
    status, out, err = run("watch", path, "--end-after", "0")
    assert status == 2
    assert "no table of numbers" in err
    assert "Road test" not in out


@pytest.mark.parametrize("later", ["picture", "not diagnosed"])
def test_an_earlier_log_is_ended_whatever_comes_after(
    run: Run, sample_log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, later: str
) -> None:
    path, lines = tmp_path / "trackLog.csv", sample_log.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[:900]))
    contents, diagnose = [b"".join(lines[:400])], watch.Case.diagnose
    if later == "picture":
        contents = [b"\x89PNG\r\n\x1a\n" + bytes(99)]

    def pause(_: float) -> None:
        if not contents:
            raise KeyboardInterrupt
        path.write_bytes(contents.pop())

    def diagnosed(case: watch.Case) -> object:
        if later != "picture" and case.road_test.content.count(b"\n") == 900:
            raise watch.AtleakError(watch.AtleakError("cannot be diagnosed").sentence)
        return diagnose(case)

    monkeypatch.setattr(watch.time, "sleep", pause)
    monkeypatch.setattr(watch.Case, "diagnose", diagnosed)
    monkeypatch.setattr(watch.WatchedLog, "_rests_until", property(lambda _: 0.0, lambda *_: None), raising=False)
    status, out, err = run("watch", path, "--keep")
    assert status == 2
    assert "trackLog.csv ended, a log begins anew" in out
    assert out.count("kept in the job book: ") == 1
    assert ("no road-test log" if later == "picture" else "cannot be diagnosed") in err


def test_of_a_folder_nothing_is_forgotten(run: Run, tmp_path: Path) -> None:
    status, _, err = run("watch", tmp_path, "--forget")
    assert status == 2
    assert "--forget needs the log itself" in err
