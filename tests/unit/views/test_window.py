"""Events of a road test as a workbook lists them."""

from __future__ import annotations

import pytest

from atleak.events import Event
from atleak.views.window import event_rows


def test_events_are_listed_with_their_gears_and_remarks() -> None:
    shift = Event("gear_shift", 0.89, 1.4, 1, 2)
    idle = Event("hot_idle", 3.0, 9.0, note="warm")
    rows = event_rows([shift, idle])
    assert [row["gears"] for row in rows] == ["1 → 2", None]
    assert rows[1]["lasts [s]"] == pytest.approx(6.0, rel=1e-9, abs=0.0)
    assert rows[1]["note"] == "warm"
