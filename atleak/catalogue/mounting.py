"""Check the mounting clearance that a catalogue file states."""

from __future__ import annotations

from typing import Annotated

from pydantic import PlainValidator

from atleak.faults import NotAccepted
from atleak.sentence import Sentence


def _mounting_clearance(value: object) -> float | list[float]:
    """Check a mounting clearance [µm]: a number, or the two ends of the range in which new pairs lie."""
    ends: list[float] = []
    for end in value if isinstance(value, list) and len(value) == 2 else [value]:
        if isinstance(end, bool) or not isinstance(end, int | float) or not 1.0 <= end < 500.0:
            raise NotAccepted(Sentence("µm, a number from 1 to below 500, or a range of two such as [6.4, 20.0]"))
        ends.append(float(end))
    if len(ends) == 1:
        return ends[0]
    if not ends[0] < ends[1]:
        raise NotAccepted(Sentence("a range with its lower end first, such as [6.4, 20.0]"))
    return ends


MountingClearance = Annotated[float | list[float], PlainValidator(_mounting_clearance)]
