"""What several sheets have in common: kinds of columns, and the columns of sources and of how a value is known."""

from __future__ import annotations

from atleak.catalogue.evidence import Evidence
from atleak.controller_sheets.kinds import Choice, Kind, Number
from atleak.controller_sheets.shapes import Column
from atleak.controller_sheets.units import (
    CLEARANCE,
    CONTACT_LENGTH,
    LAND_DIAMETER,
    LENGTH,
    NUMBER,
    ORIFICE,
    PRESSURE,
    SMALL_LENGTH,
    VOLUME,
    Measure,
)

TEXT = Kind()
MM, UM, C_R, MM3, KPA = (Number(measure) for measure in (LENGTH, SMALL_LENGTH, CLEARANCE, VOLUME, PRESSURE))
OF_LAND, L_C, OF_ORIFICE = (Number(measure) for measure in (LAND_DIAMETER, CONTACT_LENGTH, ORIFICE))
PLAIN = Number(NUMBER)
EVIDENCE = Choice(tuple(Evidence))


def in_unit(unit: str) -> Number:
    return Number(Measure(unit))


def source(needed: bool = True) -> Column:
    return Column("Source", ("source",), required=needed, width=40, help="Manual and page, or who measured it")


def evidence(key: str = "evidence", heading: str = "How known") -> Column:
    return Column(heading, (key,), EVIDENCE, help="Empty: not stated", width=15)


def known(heading: str, key: str, *, kind: Choice = EVIDENCE) -> Column:
    return Column(heading, (), kind, how_known=key, help="Empty: as the head says", width=15)
