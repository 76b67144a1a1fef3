"""Memory that a process no longer uses goes back to the system."""

from __future__ import annotations

import gc
import subprocess
import sys
import threading
from pathlib import Path
from types import ModuleType

import psutil
import pytest

from atleak.common import memory
from atleak.common.memory import collect_soon, free_memory, give_back, imports, set_imports_aside

SCRIPT = """
import psutil
from atleak.common.memory import give_back

def held():
    return psutil.Process().memory_info().rss / 1e6

kept = [[bytes(100_000) for _ in range(1000)] for _ in range(1)]
blocks = [bytes(50_000) for _ in range(4000)]
last = bytes(50_000)  # keeps the end of the heap, so that nothing goes back by itself
blocks.clear()
before = held()
give_back()
print(before - held())
"""


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What the collector was asked for, in place of doing it; nothing was set aside before."""
    asked: list[str] = []
    for name in ("collect", "freeze", "unfreeze"):
        monkeypatch.setattr(gc, name, lambda name=name: asked.append(name))
    monkeypatch.setattr(memory, "_aside", 0)
    return asked


def test_what_was_imported_is_set_aside_once_and_again_after_further_imports(
    calls: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    set_imports_aside()
    set_imports_aside()
    assert calls == ["collect", "freeze"]
    monkeypatch.setitem(sys.modules, "a page's own library", ModuleType("library"))
    set_imports_aside()
    assert calls == ["collect", "freeze"] * 2


def test_what_a_page_imports_is_set_aside_without_a_collection(
    calls: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with imports():
        assert not gc.isenabled()
        monkeypatch.setitem(sys.modules, "a page's own library", ModuleType("library"))
    assert gc.isenabled()
    assert calls == ["freeze"]
    with imports():
        pass  # nothing is imported a second time
    set_imports_aside()
    assert calls == ["freeze"]


def test_memory_is_given_back_of_all_that_was_set_aside_too(calls: list[str]) -> None:
    give_back()
    assert calls == ["unfreeze", "collect", "freeze"]


def test_a_collection_that_many_ask_for_is_made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    made = threading.Event()
    times: list[bool] = []
    monkeypatch.setattr(memory, "_SOON", 0.05)
    monkeypatch.setattr(memory, "_collect", lambda: (times.append(True), made.set()))
    for _ in range(5):
        collect_soon()
    assert made.wait(20.0)
    assert times == [True]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="malloc_trim is the GNU C library's")
def test_what_was_freed_goes_back() -> None:
    said = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True).stdout
    assert float(said) > 150.0  # of 200 MB


def test_free_is_what_the_machine_has_left_and_of_a_container_what_it_may_still_take(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stat = "anon 100000\nfile 250000\ninactive_file 200000\nactive_file 50000"
    for name, text in (("unlimited", "max"), ("limit", "1000000"), ("used", "600000"), ("memory.stat", stat)):
        (tmp_path / name).write_text(f"{text}\n", encoding="ascii")

    def containers(*names: tuple[str, str]) -> None:
        every = tuple((str(tmp_path), *each, "inactive_file") for each in names)
        monkeypatch.setattr(memory, "_CONTAINERS", every)

    containers(("none", "none"), ("unlimited", "used"))
    assert free_memory() == pytest.approx(psutil.virtual_memory().available, rel=0.2, abs=0.0)
    containers(("none", "none"), ("limit", "used"))
    assert free_memory() == 600_000  # what files hold of it, but for what was just read, counts as free
    containers(("used", "limit"))
    assert free_memory() == 0
