"""Remembers how a workshop settled a log's columns, by the signature of the log's header."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from atleak.intake.road_test.names import words


@dataclass(frozen=True)
class Settled:
    """What was settled: quantity → column, quantity → unit."""

    mapping: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)


def signature(labels: Iterable[str]) -> str:
    """A header's signature: the same for every log with these column names in this order.

    >>> signature(["Time (s)", "RPM"]) == signature(["time (s) ", "rpm"])
    True
    """
    text = "\x1f".join(words(label) for label in labels)
    return hashlib.sha256(text.encode("utf-8")).hexdigest()[:16]


def default_path(environment: Mapping[str, str] | None = None, home: Path | None = None) -> Path:
    """Where mappings are kept: under %APPDATA% on Windows, else under XDG_CONFIG_HOME or ~/.config."""
    environment = os.environ if environment is None else environment
    if folder := environment.get("APPDATA"):
        return Path(folder) / "atleak" / "road-test-columns.json"
    if folder := environment.get("XDG_CONFIG_HOME"):
        return Path(folder) / "atleak" / "road-test-columns.json"
    return (home or Path.home()) / ".config" / "atleak" / "road-test-columns.json"


def recall(path: Path, header: str) -> Settled | None:
    """What was settled for a header's signature, or None. A damaged file counts as empty."""
    entry = _load(path).get(header)
    if not isinstance(entry, dict):
        return None
    parts = [entry.get(key) for key in ("mapping", "units")]
    if not all(isinstance(part, dict) for part in parts):
        return None
    return Settled(*({str(key): str(value) for key, value in part.items()} for part in parts))  # type: ignore[union-attr]


def remember(path: Path, header: str, mapping: Mapping[str, str], units: Mapping[str, str] | None = None) -> None:
    """Keeps what was settled for a header's signature; replaces what was kept before."""
    entries = _load(path)
    entries[header] = {"mapping": dict(mapping), "units": dict(units or {})}
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_suffix(".part")
    beside.write_text(json.dumps(entries, ensure_ascii=False, indent=1), encoding="utf-8")
    beside.replace(path)


def forget(path: Path, header: str) -> None:
    """Drops what was kept for a header's signature."""
    entries = _load(path)
    if entries.pop(header, None) is not None:
        path.write_text(json.dumps(entries, ensure_ascii=False, indent=1), encoding="utf-8")


def _load(path: Path) -> dict[str, object]:
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}
