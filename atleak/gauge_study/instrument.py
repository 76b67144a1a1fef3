"""The result of a gauge study as an instrument: what the study showed, beside a calibration that it cannot show."""

from __future__ import annotations

import datetime as dt
import math
from typing import Any

from atleak.catalogue.instruments import Instrument
from atleak.gauge_study.anova import GaugeStudy
from atleak.workshop_units import UM

_DIGITS = 4  # of an uncertainty in µm: more than any study of this size can tell


def instrument_tables(
    study: GaugeStudy, of: Instrument, *, id: str, name: str, resolution: float, date: dt.date
) -> dict[str, Any]:
    """Return the tables of an instrument's file with the study's repeatability and reproducibility.

    Reproducibility joins the calibration: what differs from one operator to the next is common to all readings that
    one of them takes, what differs from part to part is not. The calibration itself, which no study of repeats can
    show, is that of the instrument that was studied.

    Parameters
    ----------
    study
        of readings in metres.
    of
        the instrument that was studied, with the calibration of its certificate.
    id, name
        of the new entry.
    resolution
        the step between two possible readings [m].
    date
        of the study.
    """
    operator, interaction = study.of("operator").variance, study.of("interaction").variance
    common = of.common**2 + operator
    variance = common + of.own**2 + interaction
    parts, operators, trials = study.readings.values.shape
    repeatability, reproducibility = study.of("repeatability").deviation, study.of("reproducibility").deviation
    source = (
        f"gauge study of {date.isoformat()}, {study.readings.file}: {parts} parts, {operators} operators, {trials} "
        f"readings each; repeatability {repeatability * UM:.{_DIGITS}g} µm, reproducibility "
        f"{reproducibility * UM:.{_DIGITS}g} µm. Calibration: {of.name}, {of.source}"
    )
    note = (
        "Repeatability and reproducibility are those of the study. A study of repeats does not show how far all "
        f"readings are off: {of.calibration * UM:.{_DIGITS}g} µm for that is taken from {of.name}."
    )
    return {
        "id": id,
        "name": name,
        "source": source,
        "date": date.isoformat(),
        "note": note,
        "measures": list(of.measures),
        "resolution_um": _um(resolution),
        "calibration_um": _um(math.sqrt(variance)),
        "common_part": round(common / variance, _DIGITS) if variance else of.common_part,
        "repeatability_um": _um(repeatability),
        # people press on a spool as on a bore, which makes one smaller and the other wider: nothing of it drops out
        "alike_inside_and_outside": of.alike_inside_and_outside and not operator,
        "expansion_per_k": of.expansion,
        "representative": [
            key for key in of.representative if key in ("calibration_um", "common_part", "expansion_per_k")
        ],
    }


def _um(metres: float) -> float:
    return float(f"{metres * UM:.{_DIGITS}g}")
