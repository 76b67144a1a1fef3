"""Memory that a process no longer uses goes back to the system."""

from __future__ import annotations

import gc
import subprocess
import sys
import threading

import pytest

from atleak.system import memory
from atleak.system.memory import collect_soon, set_imports_aside

SCRIPT = """
import psutil
from atleak.system.memory import give_back

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


def test_only_the_first_call_sets_imports_aside(monkeypatch: pytest.MonkeyPatch) -> None:
    frozen: list[bool] = []
    monkeypatch.setattr(gc, "freeze", lambda: frozen.append(True))
    set_imports_aside.cache_clear()
    set_imports_aside()
    set_imports_aside()
    set_imports_aside.cache_clear()
    assert frozen == [True]


def test_a_collection_that_many_ask_for_is_made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    made = threading.Event()
    times: list[bool] = []
    monkeypatch.setattr(memory, "_SOON", 0.05)
    monkeypatch.setattr(gc, "collect", lambda: (times.append(True), made.set()))
    for _ in range(5):
        collect_soon()
    assert made.wait(20.0)
    assert times == [True]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="malloc_trim is the GNU C library's")
def test_what_was_freed_goes_back() -> None:
    said = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True).stdout
    assert float(said) > 150.0  # of 200 MB
