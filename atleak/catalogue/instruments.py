"""Describe a measuring instrument: resolution, calibration, and the error that its readings share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from atleak.catalogue import usual_values as usual
from atleak.catalogue.doubts import doubts_of
from atleak.catalogue.entries import Entry, Headed, Origin, Shelf
from atleak.catalogue.keys import key, made
from atleak.common.errors import CatalogueError, InputError, Message, one_of
from atleak.common.file_faults import validated
from atleak.common.sentences import Name, Sentence

Part = Literal["spool", "sleeve"]
DEFAULT_SPOOL_INSTRUMENT = "workshop_microscope"  # as in the source study
DEFAULT_SLEEVE_INSTRUMENT = "bore_gauge"
STEEL_EXPANSION = 11.5e-6  # [1/K] of gauge blocks, (11.5 ± 1.0)·10⁻⁶: ISO 3650. Taken where a file states none


@dataclass(frozen=True)
class Instrument(Headed):
    """One instrument for diameters; standard uncertainties in metres.

    ``common_part`` is the part of the calibration's variance that every reading of this instrument shares (its zero,
    its setting ring, its scale): the correlation of two readings. The rest differs from place to place but is
    the same for all readings of one part of one land. ``repeatability`` is the standard deviation of one reading, used
    where a sheet has too few independent repeats to tell; None where it is not known. ``expansion`` is that of its
    scale, or of the masters it is set with: away from 20 °C a part is compared with those.
    """

    measures: tuple[Part, ...]  # the parts that it can measure
    resolution: float  # [m] the step between two possible readings
    calibration: float  # [m] standard uncertainty
    common_part: float  # of the variance, 0 … 1
    repeatability: float | None  # [m] standard deviation of one reading
    alike_inside_and_outside: bool  # its common error is one and the same in a bore and on a spool
    representative: tuple[str, ...]  # which of its values are representative
    origin: Origin | None = None  # the file
    expansion: float = STEEL_EXPANSION  # [1/K]
    doubts: tuple[Message, ...] = field(default=(), repr=False, compare=False)  # values that are possible and unusual

    @property
    def common(self) -> float:
        """Return the standard uncertainty [m] of the error that all readings of this instrument share."""
        return self.calibration * self.common_part**0.5

    @property
    def own(self) -> float:
        """Return the standard uncertainty [m] of the calibration error that differs from one place to the next."""
        return self.calibration * (1.0 - self.common_part) ** 0.5


@dataclass(frozen=True)
class Instruments:
    """The instruments that measured the two parts of a pair."""

    spool: Instrument  # that measured spools
    sleeve: Instrument  # that measured bores

    def of(self, part: Part) -> Instrument:
        """Return the instrument of a part."""
        return self.spool if part == "spool" else self.sleeve

    @property
    def checked(self) -> Instruments:
        """Return these instruments after checking that each can reach its part.

        Raises
        ------
        InputError
            if an instrument cannot reach its part: a micrometer in a bore.
        """
        parts: tuple[Part, ...] = ("spool", "sleeve")
        for part in parts:
            instrument = self.of(part)
            if part not in instrument.measures:
                able = one_of(other.id for other in instruments() if part in other.measures)
                own = Sentence("a file of the workshop's own")
                raise InputError(
                    Sentence("{instrument} does not measure a spool", instrument=Name(instrument.name))
                    if part == "spool"
                    else Sentence("{instrument} does not measure a sleeve", instrument=Name(instrument.name)),
                    value=instrument.id,
                    expected=Sentence("{first}, or {second}", first=able, second=own),
                )
        return self

    @property
    def err_alike(self) -> bool:
        """Tell whether both parts share one common error, which then drops out of D − d."""
        return self.spool == self.sleeve and self.spool.alike_inside_and_outside


def _instrument(data: Mapping[str, Any], origin: Origin) -> Instrument:
    entry = validated(InstrumentFile, data, origin.file, kind=CatalogueError)
    doubts = doubts_of("instruments", InstrumentFile, data, origin.file)
    return made(Instrument, entry, origin=origin, doubts=doubts)


def load_instruments(
    spool: str | Path = DEFAULT_SPOOL_INSTRUMENT, sleeve: str | Path = DEFAULT_SLEEVE_INSTRUMENT
) -> Instruments:
    """Load the two instruments of a measuring sheet.

    Parameters
    ----------
    spool, sleeve
        the id of one that is shipped or in the workshop's own catalogue, or the path of a file.

    Raises
    ------
    CatalogueError
        if there is no such instrument, or its file lacks a value.
    InputError
        if an instrument cannot reach its part: a micrometer in a bore.
    """
    return Instruments(load_instrument(spool), load_instrument(sleeve)).checked


_Error = Annotated[float, Field(ge=0, le=1000)]  # [µm]: a millimetre, as a ruler's


class InstrumentFile(Entry):
    """The catalogue file; ``representative`` lists the keys whose values come from no certificate."""

    measures: list[Part] = key("Measures", "spool, sleeve, or both with a comma", min_length=1)
    resolution_um: float = key(
        "Resolution", "Step between two possible readings", known="Resolution is", usual=usual.RESOLUTION, gt=0, le=1000
    )
    calibration_um: _Error = key(
        "Calibration",
        "Standard uncertainty of its calibration, setting and scale",
        known="Calibration is",
        usual=usual.CALIBRATION,
    )
    common_part: float = key(
        "Common part",
        "Part of the calibration's variance that all readings share, 0 to 1: zero, setting ring, scale",
        known="Common part is",
        ge=0,
        le=1,
    )
    repeatability_um: _Error | None = key(
        "Repeatability",
        "Standard deviation of one reading; empty where it is not known",
        known="Repeatability is",
        usual=usual.REPEATABILITY,
        default=None,
    )
    alike_inside_and_outside: bool = key(
        "Errs alike inside and outside",
        "Its common error is the same in a bore and on a spool; yes unless stated",
        default=True,
    )
    expansion_per_k: float = key(
        "Expansion",
        "Of its scale or masters; 11.5 of steel",
        known="Expansion is",
        usual=usual.EXPANSION_OF_GAUGE,
        default=STEEL_EXPANSION,
        ge=0,
        le=1e-3,
    )
    representative: list[
        Literal["resolution_um", "calibration_um", "common_part", "repeatability_um", "expansion_per_k"]
    ] = []


INSTRUMENTS = Shelf("instruments", InstrumentFile, _instrument)
checked_instrument, instruments = INSTRUMENTS.checked, INSTRUMENTS.usable


def load_instrument(id_or_path: str | Path) -> Instrument:
    """Load an instrument by its id or the path of its file; a `CatalogueError` lists all that is wrong with it."""
    return INSTRUMENTS.load(id_or_path)
