"""Parts of sentences that several rooms need: what is measured, where, and its sizes."""

from __future__ import annotations

from collections.abc import Mapping

from atleak.catalogue.controller import Land
from atleak.catalogue.instruments import Part
from atleak.common.sentences import Sentence
from atleak.common.units import MM, UM, Quantity

PART_WORDS: Mapping[Part, Sentence] = {"spool": Sentence("spool"), "sleeve": Sentence("sleeve")}


def named(land: Land) -> Sentence:
    """Name a land as messages do."""
    return Sentence("component {component} land {land}", component=land.component, land=land.land)


def angle(direction: float | None) -> Sentence | str:
    """Say a direction behind the plane; nothing where there is none.

    >>> angle(90.0), angle(None)
    (', 90°', '')
    """
    return "" if direction is None else Sentence(", {direction:g}°", direction=direction)


def in_mm(metres: float) -> Quantity:
    """Return a diameter, with no more decimal places than it has, four at most.

    >>> f"{in_mm(0.01)} {in_mm(0.0179985)}"
    '10 17.9985'
    """
    needed = len(f"{metres * MM:.4f}".rstrip("0").partition(".")[2])
    return _Size(metres * MM, "length", max(needed, 3))


def in_um(metres: float) -> Quantity:
    """Return a difference of diameters or a clearance, with a decimal place where it needs one.

    >>> f"{in_um(5e-6)} {in_um(59.5e-6)}"
    '5 59.5'
    """
    return _Size(metres * UM, "clearance", 1)


class _Size(Quantity):
    """A size that English in the record's unit writes without zeros at its end; elsewhere it has all its places."""

    __slots__ = ()

    def __format__(self, specification: str) -> str:
        written = super().__format__(specification)
        return written if specification else written.rstrip("0").rstrip(".")
