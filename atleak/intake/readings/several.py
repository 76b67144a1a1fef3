"""Several measuring sheets of one valve body, all read or all faults named."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path

from atleak.catalogue.controller import Controller
from atleak.errors import ReadingsError
from atleak.faults import together
from atleak.intake.readings import ReadingsRefused, read_readings
from atleak.readings import Readings


def read_several(
    sources: Iterable[tuple[str, str | Path | bytes]],
    controller: Controller,
    *,
    sheet: str | None = None,
    unit: str | None = None,
    where: Mapping[str, str] | None = None,
    fill_down: bool = False,
    made_for: str | None = None,
) -> list[Readings]:
    """Return the readings of measuring sheets, in their order; what each choice means: `read_readings`.

    Parameters
    ----------
    sources
        name, and path or bytes, of each; a name that comes again is numbered.

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
            sheets.append(
                read_readings(
                    *(source, controller),
                    name=name,
                    sheet=sheet,
                    unit=unit,
                    where=where,
                    fill_down=fill_down,
                    made_for=made_for,
                )
            )
        except ReadingsRefused as refused:
            faults.extend(refused.problems)
        except ReadingsError as fault:
            faults.append(fault)
    if faults:
        raise together(faults)
    return sheets
