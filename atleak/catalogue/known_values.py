"""List what every value of a controller's file is known from: measured, published, representative, or not stated."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from typing import NamedTuple, get_args

from atleak.catalogue.controller_tables import ControllerFile, LandValue
from atleak.catalogue.entries import Evidence
from atleak.catalogue.pump_tables import OF_GAPS, PumpTable

LAND_VALUES: tuple[LandValue, ...] = get_args(LandValue)
_OF_PUMP = ("volumetric_efficiency", "slip_coefficient")
_LIMITS = ("side_clearance_limit_um", "tip_clearance_limit_um")
_BESIDE_SIZE = ("kind", "held_at_demand", *_LIMITS, "source", "representative", "measured", "published")


class KnownValue(NamedTuple):
    """One value, or one table of values that are known alike."""

    table: str  # of the file: "components", "gaps", "circuits"
    value: str  # the key, empty where the table stands as a whole
    evidence: Evidence | None  # None where the file does not say


def known_values(entry: ControllerFile) -> tuple[KnownValue, ...]:
    """Return what every value of a controller's file is known from, in the order of the file."""
    return tuple(_known_values(entry))


def counted_values(values: Iterable[KnownValue]) -> dict[Evidence | None, int]:
    """Count values by what they are known from; None stands for those of which the file says nothing."""
    counts = Counter(value.evidence for value in values)
    return {evidence: counts[evidence] for evidence in (*Evidence, None)}


def _known_values(entry: ControllerFile) -> Iterator[KnownValue]:
    for material in entry.materials.values():
        yield KnownValue("materials", "expansion_per_k", material.evidence)
    yield from _of_pump(entry.pump)
    for relation in entry.pressures.values():
        yield KnownValue("pressures", "", relation.evidence)
    for point in entry.operating_points:
        yield KnownValue("operating_points", "", point.evidence)
    for land in (land for component in entry.components for land in component.lands):
        for value in LAND_VALUES:
            yield KnownValue("components", value, entry.known_from(land, value))
    for gap in entry.gaps:
        yield KnownValue("gaps", "", gap.known_from)
    for circuit in entry.circuits:
        yield KnownValue("circuits", "gears", circuit.evidence)
        yield from (KnownValue("circuits", "diameter_mm", feed.evidence) for feed in circuit.feeds)
        if circuit.set_kpa is not None:
            yield KnownValue("circuits", "set_kpa", circuit.set_evidence)
    if entry.line is not None:
        yield KnownValue("line", "set_kpa", entry.line.evidence)
    for table in ("leaks", "consumers", "repairs", "permissible_pressure"):
        yield from (KnownValue(table, "", each.evidence) for each in getattr(entry, table))


def _of_pump(pump: PumpTable) -> Iterator[KnownValue]:
    """Yield how large the pump is, what its gaps are, and what else the file says of it."""
    stated = [key for key in pump.model_fields_set if getattr(pump, key) is not None]
    gaps = [key for key in stated if key in OF_GAPS]
    size = [key for key in stated if key not in (*_BESIDE_SIZE, *_OF_PUMP, *gaps)]
    yield KnownValue("pump", "displacement", _of_keys(pump, size))
    if gaps:
        yield KnownValue("pump", "gaps", _of_keys(pump, gaps))
    if limits := [key for key in stated if key in _LIMITS]:
        yield KnownValue("pump", "limits", _of_keys(pump, limits))
    for key in _OF_PUMP:
        if getattr(pump, key) is not None:
            yield KnownValue("pump", key, _of_keys(pump, [key]))


def _of_keys(pump: PumpTable, keys: Iterable[str]) -> Evidence | None:
    """Return what the least sure of some keys is known from; what is not representative or measured is published."""
    keys = list(keys)
    if any(key in pump.representative for key in keys):
        return Evidence.REPRESENTATIVE
    return Evidence.MEASURED if all(key in pump.measured for key in keys) else Evidence.PUBLISHED
