"""A log that is followed while it grows, is cut off, is replaced, goes away, or is none."""

from __future__ import annotations

import gzip
import os
from pathlib import Path

import pytest

from atleak.common.errors import AtleakError, RoadTestError
from atleak.common.sentences import Sentence
from atleak.common.wording import wording
from atleak.job import watched_log
from atleak.job.case import Case, SourceFile
from atleak.job.watched_log import LINES, WatchedLog, whole_lines
from atleak.report.tables.road_test import present_values

HEADING = "time [s];engine_speed [rpm];p_g [kPa];atf_temperature [°C];gear\n"


def rows(first: int, last: int, pressure: float = 700.0) -> str:
    """Rows of a drive at 10 Hz that shifts from gear 2 to 3 at 5 s."""
    return "".join(f"{n / 10};1500.0;{pressure};80.0;{2 if n < 50 else 3}\n" for n in range(first, last))


@pytest.fixture(autouse=True)
def without_rest(monkeypatch: pytest.MonkeyPatch, own_home: Path) -> None:
    """Let no log rest after it was read: how fast this machine reads decides no test."""
    monkeypatch.setattr(WatchedLog, "_rests_until", property(lambda _: 0.0, lambda *_: None), raising=False)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "trackLog.csv"


def write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="")


def kinds(log: WatchedLog, *, ended: bool = False) -> list[tuple[str, str | None]]:
    return [(event.kind, event.gears) for event in log.news(ended=ended)]


def test_an_empty_file_waits_for_its_heading_and_the_heading_for_rows(path: Path) -> None:
    write(path, "")
    log = WatchedLog(path, Case())
    assert not log.look()
    assert "is empty so far" in str(log.waits)
    write(path, HEADING[:20])
    assert not log.look()
    write(path, HEADING)
    assert log.look()
    assert (log.findings, "no table of numbers" in str(log.waits)) == (None, True)
    write(path, HEADING + rows(0, 30))
    assert log.look()
    assert log.waits is None
    assert log.findings is not None
    assert log.findings.road_test.rows == 30


def test_a_half_written_last_line_waits_for_its_end(path: Path) -> None:
    whole = HEADING + rows(0, 30)
    write(path, whole + "3.0;1500.0;7")  # 7 kPa would be below what is permitted
    log = WatchedLog(path, Case())
    assert log.look()
    assert log.findings is not None
    assert log.findings.road_test.rows == 30
    write(path, whole + "3.0;1500.0;70")
    assert not log.look()
    write(path, whole + rows(30, 31))
    assert log.look()
    assert log.findings.road_test.rows == 31
    assert log.file is not None
    assert log.file.content == (whole + rows(30, 31)).encode()


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be", "utf-8-sig", "cp1252"])
def test_a_line_ends_in_any_encoding(encoding: str) -> None:
    text = HEADING + rows(0, 3)
    assert whole_lines((text + "0.3;15").encode(encoding)) == text.encode(encoding)


def test_an_event_is_told_once_when_it_is_over(path: Path) -> None:
    log, told = WatchedLog(path, Case()), []
    for last in (30, 52, 60, 90, 120):
        write(path, HEADING + rows(0, last))
        log.look()
        told.append(kinds(log))
    assert told == [[], [], [], [("gear_shift", "2 → 3")], []]
    assert kinds(log, ended=True) == []


def test_what_reaches_to_the_last_line_is_told_at_the_end(path: Path) -> None:
    write(path, HEADING + rows(0, 55))
    log = WatchedLog(path, Case())
    log.look()
    assert kinds(log) == []
    assert kinds(log, ended=True) == [("gear_shift", "2 → 3")]


@pytest.mark.parametrize("anew", [rows(0, 10), rows(0, 200, 650.0)], ids=["cut off", "replaced by a longer one"])
def test_a_log_that_begins_anew_leaves_the_earlier_one(path: Path, anew: str) -> None:
    first = HEADING + rows(0, 120)
    write(path, first)
    log = WatchedLog(path, Case())
    log.look()
    assert kinds(log, ended=True) == [("gear_shift", "2 → 3")]
    write(path, HEADING + anew)
    assert log.look()
    assert [file.content for file in log.earlier] == [first.encode()]
    assert log.findings is not None
    assert log.findings.road_test.rows == anew.count("\n")
    assert len(kinds(log, ended=True)) == (anew.count("\n") > 50)  # the same shift of another drive


def test_a_log_that_goes_away_is_waited_for(path: Path) -> None:
    write(path, HEADING + rows(0, 30))
    log = WatchedLog(path, Case())
    log.look()
    content = path.read_bytes()
    path.unlink()
    assert not log.look()
    assert "cannot be opened" in str(log.waits)
    assert log.findings is not None  # what was read stays
    path.write_bytes(content)
    assert not log.look()  # the same lines
    assert (log.waits, log.earlier) == (None, [])


def test_nothing_is_read_where_nothing_was_written(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(path, HEADING + rows(0, 30))
    log = WatchedLog(path, Case())
    log.look()
    monkeypatch.setattr(Path, "read_bytes", lambda _: pytest.fail("read again"))
    assert not log.look()


def test_a_log_is_read_for_half_of_the_time_at_most(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(WatchedLog, "_rests_until")
    write(path, HEADING + rows(0, 30))
    log, clock = WatchedLog(path, Case()), iter([100.0, 104.0, 105.0, 109.0, 109.0, 113.0])
    monkeypatch.setattr(watched_log.time, "monotonic", lambda: next(clock))
    assert log.look()  # which took 4 s
    write(path, HEADING + rows(0, 60))
    assert not log.look()
    assert log.look()


def test_of_a_folder_the_newest_log_is_followed(tmp_path: Path) -> None:
    with pytest.raises(RoadTestError, match="holds no log"):
        WatchedLog(tmp_path, Case()).look()
    for name, age in (("old.csv", 60), ("picture.png", 0), (".hidden.csv", 0)):
        write(tmp_path / name, HEADING + rows(0, 30))
        os.utime(tmp_path / name, (1_700_000_000 - age,) * 2)
    log = WatchedLog(tmp_path, Case())
    assert log.look()
    assert log.file is not None
    assert log.file.name == "old.csv"
    write(tmp_path / "new.csv", HEADING + rows(0, 40))
    assert log.look()
    assert log.file.name == "new.csv"
    assert [file.name for file in log.earlier] == ["old.csv"]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"\x89PNG\r\n\x1a\n" + bytes(range(256)), "no road-test log"),
        (b"<!DOCTYPE html>\n<html>\n", "a web page"),
        (gzip.compress((HEADING + rows(0, 30)).encode()), "no log that grows line by line"),
        (b"PK\x03\x04" + bytes(99), "no log that grows line by line"),
        (b"A letter.\n" * (LINES + 1), "no table of numbers"),
    ],
    ids=["picture", "web page", "gz", "workbook", "letter"],
)
def test_a_file_that_is_no_growing_log_is_refused(path: Path, content: bytes, said: str) -> None:
    path.write_bytes(content)
    with pytest.raises(AtleakError, match=said):
        WatchedLog(path, Case()).look()


def test_a_file_that_is_not_there_is_refused_by_name(path: Path) -> None:
    with pytest.raises(RoadTestError, match=r"trackLog\.csv: cannot be opened"):
        WatchedLog(path, Case()).look()


def test_a_text_without_a_table_is_waited_for_until_it_is_long(path: Path) -> None:
    write(path, "A letter.\n" * 9)
    log = WatchedLog(path, Case())
    log.look()
    assert "no table of numbers" in str(log.waits)


@pytest.mark.parametrize(
    ("pressure", "said"),
    [(300.0, "▲ below what is permitted"), (700.0, "kPa (permitted 412 to"), (9000.0, "▲ above what is permitted")],
)
def test_present_values_say_on_which_side_of_its_limits_main_pressure_is(
    path: Path, pressure: float, said: str
) -> None:
    write(path, HEADING + rows(0, 30, pressure))
    log = WatchedLog(path, Case())
    log.look()
    assert log.findings is not None
    (_, time), (name, value), *others = present_values(log.findings, log.controller, wording("en")).rows
    assert (time, name) == ("2.9 s", "main (line) pressure")
    assert said in value
    assert ("▲" in value) == (pressure != 700.0)
    assert ("gear", "2") in others


def test_what_was_followed_gives_the_same_job_as_the_file(path: Path) -> None:
    write(path, HEADING + rows(0, 120))
    log = WatchedLog(path, Case())
    log.look()
    assert log.file is not None
    assert log.file.sha256 == SourceFile.at(path).sha256


def test_a_long_log_without_a_column_named_is_waited_for(path: Path) -> None:
    text = "a;b;c;d;e\n" + rows(0, LINES + 20)
    write(path, text[:200])
    log = WatchedLog(path, Case())
    log.look()
    write(path, text)
    log.look()
    assert "no time column" in str(log.waits)
    assert log.file is not None
    assert log.file.content == text.encode()


def test_what_could_be_read_last_stays_where_more_of_it_cannot(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(path, HEADING + rows(0, 120))
    log = WatchedLog(path, Case())
    log.look()
    write(path, HEADING + rows(0, 150))
    refusal = RoadTestError(Sentence("cannot be read"))
    monkeypatch.setattr(watched_log.Reader, "log", lambda *_: (_ for _ in ()).throw(refusal))
    log.look()
    assert log.waits is refusal
    assert log.file is not None
    assert log.file.content == (HEADING + rows(0, 120)).encode()


def test_of_two_logs_written_in_turn_the_first_is_followed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first, second, now = tmp_path / "a.csv", tmp_path / "b.csv", 1_700_000_000
    write(first, HEADING + rows(0, 60))
    log = WatchedLog(tmp_path, Case())
    log.look()
    for last in (70, 80, 90):
        for path in (first, second):
            write(path, HEADING + rows(0, last))
            now += 1
            os.utime(path, (now, now))
            log.look()
        assert (log.file.name if log.file else None, log.earlier) == ("a.csv", [])
    monkeypatch.setattr(watched_log, "TURN", 0.0)
    log.look()
    assert (log.file.name, [file.name for file in log.earlier]) == ("b.csv", ["a.csv"])


def test_what_is_no_log_is_passed_over_in_a_folder(tmp_path: Path) -> None:
    write(tmp_path / "old.csv", HEADING + rows(0, 60))
    os.utime(tmp_path / "old.csv", (1_700_000_000,) * 2)
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "picture.csv").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(99))
    write(tmp_path / "letter.txt", "A letter.\n" * (LINES + 1))
    log = WatchedLog(tmp_path, Case())
    log.look()
    assert log.file is not None
    assert log.file.name == "old.csv"
    (tmp_path / "old.csv").unlink()
    log.look()
    assert log.file.name == "old.csv"
    assert log.waits is not None


def test_the_same_log_again_is_held_once(path: Path) -> None:
    log = WatchedLog(path, Case())
    for last in (120, 10, 120, 10, 120):
        write(path, HEADING + rows(0, last, 650.0 if last == 10 else 700.0))
        log.look()
    assert len(log.earlier) == 2


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_is_not_waited_on(path: Path) -> None:
    os.mkfifo(path)
    with pytest.raises(RoadTestError, match="is no file"):
        WatchedLog(path, Case()).look()
