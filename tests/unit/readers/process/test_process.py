"""Reading in a child process: whatever becomes of the child, the caller gets an answer or a refusal."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import psutil
import pytest

from atleak.cli import main
from atleak.common.damage import is_own_fault
from atleak.common.errors import InputError, ReadingsError, RoadTestError
from atleak.readers.cells import workbook_marks
from atleak.readers.logs import read_road_test
from atleak.readers.process import parent as process
from atleak.readers.process.parent import MDF, PARQUET, WORKBOOK, ProcessBudget, read_apart, read_apart_in_parts

HERE = Path(__file__).parent
SMALL = ProcessBudget("test file", 100 << 20, 0.0, 30.0, 0.0, "it is damaged", "a better one")
HURRIED = ProcessBudget("test file", 100 << 20, 0.0, 1.0, 0.0, "it is damaged", "a better one")

Read = Callable[..., list[Any]]


@pytest.fixture
def readers(monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """The misbehaving functions, and children of this test's own that can import them."""
    monkeypatch.syspath_prepend(str(HERE))
    pool = process._Pool()
    monkeypatch.setattr(process, "_pool", pool)
    import misbehaving

    yield misbehaving
    pool.close()


@pytest.fixture
def refused() -> Callable[..., InputError]:
    def read(function: Any, data: bytes = b"", budget: ProcessBudget = SMALL, **options: Any) -> InputError:
        with pytest.raises(ReadingsError) as caught:
            read_apart(function, data, "some.file", ReadingsError, budget, **options)
        assert caught.value.place.file == "some.file"
        assert caught.value.expected
        return caught.value

    return read


def number(readers: ModuleType) -> int:
    """The number of the child that reads."""
    return read_apart(readers.number_and_size, b"", "some.file", ReadingsError, SMALL)[0][0]


def other_number() -> int:
    """The number of the child that reads files of another kind."""
    import of_another_kind

    return read_apart(of_another_kind.number, b"", "some.file", ReadingsError, SMALL)[0]


def ended(pid: int, within: float = 60.0) -> bool:
    """Whether the process ends in time; one that nobody has asked about yet counts as ended."""
    limit = time.monotonic() + within
    while time.monotonic() < limit:
        try:
            if psutil.Process(pid).status() == psutil.STATUS_ZOMBIE:
                return True
        except psutil.NoSuchProcess:
            return True
        time.sleep(0.02)
    return False


def test_plain_data_arrives_as_it_was_sent(readers):
    assert read_apart(readers.plain, b"", "some.file", ReadingsError, SMALL) == readers.PLAIN


def test_a_large_file_arrives_whole_and_the_child_stays_for_the_next(readers):
    data = bytes(30_000_000)
    first = read_apart(readers.number_and_size, data, "some.file", ReadingsError, SMALL)
    second = read_apart(readers.number_and_size, b"x", "some.file", ReadingsError, SMALL)
    assert (first[0][1], second[0][1]) == (30_000_000, 1)
    assert first[0][0] == second[0][0] != os.getpid()


def test_a_file_that_takes_too_long_is_refused(readers, refused):
    error = refused(readers.endless, budget=HURRIED)
    assert "took longer than 1 s and was stopped" in error.problem


@pytest.mark.parametrize("function", ["greedy", "greedy_at_once", "talkative"])
def test_a_file_that_takes_too_much_memory_is_refused(readers, refused, function):
    before = psutil.Process().memory_info().rss
    error = refused(getattr(readers, function), b"\1" * 5_000_000)
    assert "more than 100 MB of memory" in error.problem
    assert psutil.Process().memory_info().rss - before < 300 << 20


def test_a_file_that_ends_its_reader_is_refused_and_the_next_is_read(readers, refused):
    first = number(readers)
    assert "broke down; it is damaged" in refused(readers.aborts).problem
    assert ended(first)
    assert number(readers) != first


def test_a_panic_is_refused_in_one_line(readers, refused):
    assert "damaged or of a kind that cannot be read (slice index starts at 9)" in refused(readers.panics).problem


def test_a_plain_error_of_a_compiled_library_is_damage_too(readers, refused):
    problem = refused(readers.plain_error_of_a_library).problem
    assert "damaged or of a kind that cannot be read (year 0 is out of range)" in problem


def test_a_fault_of_atleak_in_the_child_is_called_so(readers, refused):
    with pytest.raises(ReadingsError, match=r"^some\.file: atleak could not make sense of it: TypeError: .*") as caught:
        read_apart(workbook_marks.column_index, b"AB", "some.file", ReadingsError, SMALL)
    assert "readers/cells/workbook_marks.py:" in caught.value.problem
    assert is_own_fault(caught.value)
    assert "in column_index" in str(caught.value.__cause__), "the child's traceback, for the log"
    assert number(readers) > 0


def test_a_refusal_keeps_its_words(readers, refused):
    error = refused(readers.refuses)
    assert (error.problem, error.place.sheet, error.value, error.expected) == ("nothing in it", "Tab", "7", "more")


def test_what_a_library_prints_is_neither_answer_nor_output(readers, capfd):
    assert read_apart(readers.prints, b"", "some.file", ReadingsError, SMALL) == ["said"]
    assert capfd.readouterr() == ("", "")


def test_code_in_an_answer_is_not_run(readers, refused, tmp_path):
    target = tmp_path / "made by an answer"
    assert "broke down" in refused(readers.smuggles, str(target).encode()).problem
    assert not target.exists()


def test_a_child_killed_during_a_read_is_replaced(readers, refused):
    first = number(readers)
    threading.Timer(0.3, psutil.Process(first).kill).start()
    assert "broke down" in refused(readers.endless).problem
    assert number(readers) != first


def test_a_child_killed_between_two_reads_is_replaced(readers):
    for _ in range(10):  # for a moment a dead child's end cannot be asked for yet
        first = number(readers)
        psutil.Process(first).kill()
        assert ended(first)
        assert number(readers) != first


def test_a_child_that_has_grown_is_not_kept(readers, monkeypatch):
    monkeypatch.setattr(process, "KEPT", 1 << 20)
    first = number(readers)
    assert ended(first)
    assert number(readers) != first


def test_a_child_reads_files_of_one_kind_alone(readers):
    """Libraries keep the addresses that they once had, of which every kind of file has a budget of its own."""
    first = number(readers)
    pid = other_number()
    assert pid != first
    assert number(readers) == first
    assert other_number() == pid


def test_no_more_children_wait_than_are_kept(readers, monkeypatch):
    monkeypatch.setattr(process, "IDLE", 1)
    first = number(readers)
    other_number()
    assert ended(first)


def test_parts_come_one_by_one_however_many_they_are(readers):
    parts = read_apart_in_parts(readers.talkative, bytes(20 << 20), "some.file", ReadingsError, SMALL)
    assert [len(next(parts)) for _ in range(8)] == [20 << 20] * 8  # more together than a whole answer may have
    parts.close()
    assert process._pool._idle == []  # what was not taken cannot be answered any more
    assert number(readers)


def test_four_threads_read_at_once_by_no_more_children_than_there_may_be(readers):
    readings: list[tuple[int, int]] = []

    def read(size: int) -> None:
        for _ in range(5):
            readings.extend(read_apart(readers.number_and_size, bytes(size), "some.file", ReadingsError, SMALL))

    threads = [threading.Thread(target=read, args=(size,)) for size in (1, 20, 300, 100_000)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(size for _, size in readings) == [1] * 5 + [20] * 5 + [300] * 5 + [100_000] * 5
    assert len({pid for pid, _ in readings}) == process.CHILDREN


@pytest.mark.parametrize("busy", [False, True], ids=["waiting", "reading"])
def test_a_child_ends_when_its_parent_dies(busy):
    script = (
        "import os, sys, threading, time, psutil, misbehaving\n"
        "from atleak.common.errors import ReadingsError\n"
        "from atleak.readers.process.parent import WORKBOOK, read_apart\n"
        "def read(function): return read_apart(function, b'', 'some.file', ReadingsError, WORKBOOK)\n"
        "pid = read(misbehaving.number_and_size)[0][0]\n"
        f"if {busy}:\n"
        "    threading.Thread(target=read, args=(misbehaving.endless,), daemon=True).start()\n"
        "    time.sleep(0.5)\n"
        "print(pid, flush=True)\n"
        "os._exit(0)\n"
    )
    path = os.pathsep.join([str(HERE), *(entry for entry in sys.path if entry)])
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    assert ended(int(done.stdout))


def test_a_script_that_has_read_a_workbook_ends_quietly(sample_readings):
    script = (
        "import sys; from atleak.readers.cells.sheet_file import read_workbook\n"
        "print(len(read_workbook(open(sys.argv[1], 'rb').read(), 'sheet.xlsx')))"
    )
    command = [sys.executable, "-W", "error", "-X", "dev", "-W", "ignore::ResourceWarning:__main__", "-c", script]
    done = subprocess.run([*command, str(sample_readings)], capture_output=True, text=True, check=True)
    assert (int(done.stdout) > 0, done.stderr) == (True, "")


@pytest.mark.parametrize("executable", ["", "/no/such/python", "/bin/cat" if os.name != "nt" else "where.exe"])
def test_where_no_second_python_can_be_started_the_way_out_is_named(readers, refused, monkeypatch, executable):
    monkeypatch.setattr(sys, "executable", executable)
    monkeypatch.setattr(process, "START", 2.0)
    error = refused(readers.plain)
    assert "none can be started" in error.problem
    assert ".csv" in error.expected


def test_the_command_line_on_text_starts_no_child(monkeypatch, four_speed, sample_log, tmp_path):
    def never(_: Any) -> None:
        raise AssertionError("a child was started")

    monkeypatch.setattr(process, "_pool", process._Pool())
    monkeypatch.setattr(process._Child, "__init__", never)
    land = four_speed.lands[0]
    nominal = land.nominal_diameter * 1e3
    sheet, result = tmp_path / "sheet.csv", tmp_path / "result.json"
    lines = [
        f"{land.component};{part};{plane};{direction};{nominal + more:.3f}"
        for part, more in ((land.part, 0.0), ("sleeve", 0.05))
        for plane in land.planes
        for direction in ("0°", "90°")
    ]
    sheet.write_text("\n".join(["component;part;plane;direction;diameter [mm]", *lines]), encoding="utf-8")
    assert main(["diagnose", str(sheet), "--road-test", str(sample_log), "--json", str(result)]) == 0
    assert result.stat().st_size > 1000


def test_a_file_of_any_size_has_more_time_and_memory_than_a_smaller_one():
    for budget in (WORKBOOK, PARQUET, MDF):
        small, large = budget.limits(10_000), budget.limits(60_000_000)
        assert large[0] > small[0]
        assert large[1] > small[1]


def test_the_child_starts_light():
    script = (
        "import sys, atleak.readers.process.child, atleak.readers.process.workbooks, atleak.readers.process.mdf\n"
        "import atleak.readers.process.parquet\n"
    )
    heavy = (
        "numpy",
        "pandas",
        "pyarrow",
        "asammdf",
        "python_calamine",
        "psutil",
        "atleak.common.errors",
        "typing_extensions",
    )
    script += f"print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_log_refused_by_its_reader_is_an_error_of_the_log():
    with pytest.raises(RoadTestError, match=r"drive\.xls.*damaged"):
        read_road_test(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + b"\0" * 600, name="drive.xls")
