"""The columns that are remembered: several writers lose none, and a damaged file stops nobody."""

from __future__ import annotations

import datetime as dt
import json
import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from atleak.common.errors import OutputError
from atleak.common.files import damaged_before
from atleak.readers.logs import NOT_LOGGED, forget_columns, recall, remember
from atleak.readers.remembered_columns import RememberedColumns, recall_all, restore_columns

WRITERS = 4  # processes, each with two threads
ANSWERS = 10  # of every thread

CODE = f"""
import sys, threading
from pathlib import Path
from atleak.readers.logs import remember

def write(thread):
    for number in range({ANSWERS}):
        remember(Path(sys.argv[1]), f"{{sys.argv[2]}}-{{thread}}-{{number}}", {{"gear": "G"}}, {{}})

threads = [threading.Thread(target=write, args=(number,)) for number in range(2)]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
"""


def test_several_writers_lose_no_answer(tmp_path: Path) -> None:
    store = tmp_path / "atleak" / "columns.json"
    commands = [[sys.executable, "-c", CODE, str(store), str(number)] for number in range(WRITERS)]
    running = [subprocess.Popen(command, stderr=subprocess.PIPE) for command in commands]
    for process in running:
        assert process.communicate(timeout=120) == (None, b"")
        assert process.returncode == 0
    expected = {f"{w}-{t}-{n}" for w in range(WRITERS) for t in range(2) for n in range(ANSWERS)}
    assert set(json.loads(store.read_text(encoding="utf-8"))) == expected
    assert sorted(path.suffix for path in store.parent.iterdir() if path.suffix != ".lock") == [".json"]


def test_forgetting_takes_nothing_else_with_it(tmp_path: Path) -> None:
    store = tmp_path / "columns.json"
    for number in range(20):
        remember(store, f"old {number}", {"gear": "G"})

    def write() -> None:
        for number in range(20):
            remember(store, f"new {number}", {"gear": "G"})

    writer = threading.Thread(target=write)
    writer.start()
    for number in range(20):
        forget_columns(store, f"old {number}")
    writer.join()
    assert set(json.loads(store.read_text(encoding="utf-8"))) == {f"new {number}" for number in range(20)}


def test_forgetting_what_was_never_kept_writes_nothing(tmp_path: Path) -> None:
    forget_columns(tmp_path / "columns.json", "never")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("content", [b"[" * 100_000, b"\xff\xfe", b"{", b"[1]", b'{"a": ' * 50_000])
def test_a_damaged_file_counts_as_empty(tmp_path: Path, content: bytes) -> None:
    store = tmp_path / "columns.json"
    store.write_bytes(content)
    assert recall(store, "a") is None
    forget_columns(store, "a")
    remember(store, "a", {"gear": "G"})
    remembered = recall(store, "a")
    assert remembered is not None
    assert remembered.mapping == {"gear": "G"}


def test_a_damaged_file_is_set_aside_and_said(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    store = tmp_path / "columns.json"
    for content in (b'{"a": {', b"[1]"):  # twice on one day
        store.write_bytes(content)
        remember(store, "a", {"gear": "G"})
    aside = damaged_before(store)
    assert [path.read_bytes() for path in aside] == [b'{"a": {', b"[1]"]
    assert [path.name for path in aside] == [f"columns.json.damaged-{dt.date.today()}-{number}" for number in (1, 2)]
    for path, said in zip(aside, caplog.messages, strict=True):
        assert said == f"atleak: {store}: was damaged and begins anew; what it held is in {path.name}"
    remember(store, "b", {"gear": "G"})
    assert len(recall_all(store)) == 2


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
def test_only_the_owner_may_read_what_is_remembered(tmp_path: Path) -> None:
    store = tmp_path / "columns.json"
    store.write_text("{}", encoding="utf-8")
    store.chmod(0o644)
    remember(store, "a", {"gear": "G"})
    assert stat.S_IMODE(store.stat().st_mode) == 0o600


def test_a_file_that_cannot_be_read_is_not_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object, **__: object) -> str:
        raise PermissionError(13, "Permission denied")

    store = tmp_path / "columns.json"
    remember(store, "a", {"gear": "G"})
    with monkeypatch.context() as patched:
        patched.setattr(Path, "read_text", refused)
        assert recall(store, "a") is None
        with pytest.raises(OutputError, match="Permission denied"):
            remember(store, "b", {"gear": "G"})
    assert recall(store, "a") is not None


def test_a_lock_that_is_never_released_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from filelock import FileLock

    from atleak.common import files as entries

    monkeypatch.setattr(entries, "_PATIENCE", 0.1)
    with FileLock(tmp_path / "columns.lock"), pytest.raises(OutputError, match="locked"):
        remember(tmp_path / "columns.json", "a", {"gear": "G"})


def test_what_is_kept_says_of_which_logs_and_since_when_the_latest_first(tmp_path: Path) -> None:
    store = tmp_path / "columns.json"
    store.write_text(
        json.dumps({"old": {"mapping": {"gear": "G"}, "units": {}}, "broken": 3, "odd": {"mapping": []}}),
        encoding="utf-8",
    )
    remember(store, "new", {"gear": NOT_LOGGED}, {"main_pressure": "bar"}, format="workbook", columns=["t", "p"])
    kept = recall_all(store)
    assert list(kept) == ["new", "old"]
    assert (kept["new"].format, kept["new"].columns) == ("workbook", ("t", "p"))
    assert dt.datetime.fromisoformat(kept["new"].when).utcoffset() == dt.timedelta(0)
    assert (kept["old"].mapping, kept["old"].when) == ({"gear": "G"}, "")


def test_what_was_forgotten_is_brought_back_as_it_was(tmp_path: Path) -> None:
    store = tmp_path / "columns.json"
    remember(store, "a", {"gear": "G"}, {"main_pressure": "bar"}, format="workbook", columns=["t", "G"])
    entry = recall_all(store)["a"]
    forget_columns(store, "a")
    assert recall_all(store) == {}
    restore_columns(store, "a", entry)
    back = recall_all(store)["a"]
    assert vars(back) == vars(entry)


def test_when_it_was_chosen_makes_no_other_choice() -> None:
    one, other = (RememberedColumns({"gear": "G"}, when=when) for when in ("2026-01-01", "2026-02-02"))
    assert (one == other, repr(one) == repr(other)) == (True, True)
