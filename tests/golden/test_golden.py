"""The sample job computes what it computed before, in both profiles. Golden values, no validation.

After a change that is meant: ``python tests/golden/regenerate.py``, and review the difference.
"""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

_SPEC = importlib.util.spec_from_file_location("regenerate", Path(__file__).with_name("regenerate.py"))
assert _SPEC is not None
assert _SPEC.loader is not None
regenerate = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(regenerate)


def leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Every number and word of a nested record with the way to it."""
    if isinstance(value, dict | list):
        pairs = value.items() if isinstance(value, dict) else enumerate(value)
        for key, inner in pairs:
            yield from leaves(inner, f"{path}.{key}" if path else str(key))
    else:
        yield path, value


@pytest.mark.usefixtures("all_draws")
@pytest.mark.parametrize("profile", ["workshop", "paper"])
def test_sample_job_computes_what_it_did(profile: str) -> None:
    before = dict(leaves(json.loads(regenerate.golden_file(profile).read_text(encoding="utf-8"))))
    now = dict(leaves(regenerate.sample_job(profile)))
    assert list(now) == list(before), f"if this is meant: {regenerate.COMMAND}"
    # the time of an instant and the rounding of a zero are exact; every flow follows to nine digits
    changed = {
        path: f"{before[path]} -> {value}"
        for path, value in now.items()
        if value != (pytest.approx(before[path], rel=1e-9, abs=0.0) if isinstance(value, float) else before[path])
    }
    assert not changed, f"if this is meant: {regenerate.COMMAND}"
