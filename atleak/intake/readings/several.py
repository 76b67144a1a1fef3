"""Several measuring sheets of one valve body, all read or all faults named."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.errors import ReadingsError
from atleak.faults import together
from atleak.intake.readings import ReadingsRefused, read_readings
from atleak.readings import Readings


def read_several(
    sources: Iterable[tuple[str, str | Path | bytes]], controller: Controller, **choices: Any
) -> list[Readings]:
    """Return the readings of measuring sheets, in their order.

    Parameters
    ----------
    sources
        name, and path or bytes, of each; a name that comes again is numbered.
    choices
        as of `read_readings`: which sheet, unit and rows.

    Raises
    ------
    ReadingsError
        the first fault of any sheet, with those of all the sheets in ``others``.
    """
    sheets: list[Readings] = []
    faults: list[ReadingsError] = []
    counted: Counter[str] = Counter()
    for given, source in sources:
        counted[given] += 1
        name = given if counted[given] == 1 else f"{given} ({counted[given]})"  # of another folder
        try:
            sheets.append(read_readings(source, controller, name=name, **choices))
        except ReadingsError as fault:
            faults += fault.problems if isinstance(fault, ReadingsRefused) else [fault]
    if faults:
        raise together(faults)
    return sheets
