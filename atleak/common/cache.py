"""Keep what was computed from an object for as long as that object is in use, and no longer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar
from weakref import finalize

_Made = TypeVar("_Made")
_KEPT: dict[int, dict[str, tuple[tuple[Any, Any], ...]]] = {}  # keys and what was made, by owner's identity and name


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
