"""Keep what was computed from an object for as long as it is in use, and give back what a process no longer needs.

How much memory there is, is asked of the system; C libraries keep what was freed until they are told to give it back.
"""

from __future__ import annotations

import ctypes
import gc
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar
from weakref import finalize

_CONTAINERS = (  # folder, limit and use, and what of the use is of files and is let go of where it is needed
    ("/sys/fs/cgroup", "memory.max", "memory.current", "inactive_file"),
    ("/sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"),
)
_FREE = 2 << 30  # bytes that are taken as free where nothing tells: choice of this project
_aside = 0  # modules that were there when what there was was set aside
_LATER = (20.0, 150.0, 900.0)  # [s]
_SOON = 10.0  # [s]
_waiting: dict[float, threading.Timer] = {}
_Made = TypeVar("_Made")
_KEPT: dict[int, dict[str, tuple[tuple[Any, Any], ...]]] = {}  # keys and what was made, by owner's identity and name


def free_memory() -> int:
    """Return how many bytes of memory are free on this machine, or within this container."""
    found = []
    with suppress(ModuleNotFoundError):  # of the engine alone in an environment of few libraries
        import psutil  # a plain computation asks for nothing

        found.append(int(psutil.virtual_memory().available))
    for folder, limit, used, of_files in _CONTAINERS:
        with suppress(OSError, ValueError):  # a container without a limit writes max
            limits, use, of_kinds = (
                Path(folder, name).read_text(encoding="ascii") for name in (limit, used, "memory.stat")
            )
            kinds = dict(line.split() for line in of_kinds.splitlines())
            found.append(int(limits) - int(use) + int(kinds.get(of_files, 0)))
    return max(min(found, default=_FREE), 0)


def give_back() -> None:
    """Collect what nothing refers to any more, and hand free memory to the system where the C library can be asked."""
    gc.unfreeze()
    _set_aside()
    arrow = sys.modules.get("pyarrow")
    if arrow is not None:
        arrow.default_memory_pool().release_unused()
    if sys.platform.startswith("linux"):
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # of the GNU C library alone
        if trim is not None:
            trim(0)


def set_imports_aside() -> None:
    """Let later collections pass over what there is now, where modules were imported since the last time.

    These are some 240 000 objects with the first page, and more with others, that stay as long as the process. What
    else is there and ends later is let go of by whoever refers to it, or else by `give_back`, which looks at all.
    """
    if len(sys.modules) > _aside:
        _set_aside()


@contextmanager
def imports() -> Iterator[None]:
    """Import without a collection, and let later ones pass over what there is then, where anything was imported."""
    global _aside
    before = len(sys.modules)
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
        if len(sys.modules) > before:
            _aside = len(sys.modules)
            gc.freeze()


def _set_aside() -> None:
    global _aside
    _aside = len(sys.modules)
    gc.collect()
    gc.freeze()


def give_back_soon() -> None:
    """Do so some times later, once whoever asks has let go of what it holds; a process that ends does not wait.

    What refers to itself in a circle is let go of by the collection alone, so that one is not enough.
    """
    for seconds in _LATER:
        _do_in(seconds, give_back)


def collect_soon() -> None:
    """Collect once within some seconds, however often this is asked for meanwhile.

    A collection looks at all that was not set aside and keeps every page waiting meanwhile: one after each run of a
    page, as Streamlit would have it, costs more than most of these runs.
    """
    _do_in(_SOON, _collect)


def _collect() -> None:
    if len(sys.modules) > _aside:
        _set_aside()
    else:
        gc.collect()


def _do_in(seconds: float, what: Callable[[], object]) -> None:
    if seconds in _waiting and _waiting[seconds].is_alive():
        return
    _waiting[seconds] = threading.Timer(seconds, what)
    _waiting[seconds].daemon = True
    _waiting[seconds].start()


def kept_with(owner: Any, name: str, key: Any, make: Callable[[], _Made], most: int = 4) -> _Made:
    """Return what was made for a key before, or make it and keep it with its owner.

    Parameters
    ----------
    owner
        the object from which it is made; it must not change, and must not be part of what is made: else neither would
        ever be let go.
    name
        what is made: of each name the latest ``most`` keys are kept.
    key
        all else that it rests on, compared by ``==``.

    Raises
    ------
    ValueError
        what is made is the owner itself.
    """
    if id(owner) not in _KEPT:
        _KEPT[id(owner)] = {}
        finalize(owner, _KEPT.pop, id(owner), None)
    kept = _KEPT[id(owner)]
    for earlier_key, before in kept.get(name, ()):
        if earlier_key == key:
            earlier: _Made = before
            return earlier
    made = make()
    if made is owner:
        raise ValueError(f"{name}: kept with itself, it would never be let go")
    kept[name] = (*kept.get(name, ()), (key, made))[-most:]
    return made
