"""List what the source study prints beside its tables, and where it contradicts itself.

Dziubak T., Szczepaniak P., Energies 2023, 16(22), 7667, doi 10.3390/en16227667. Every erratum was derived again
independently; ``docs/source-study.md`` shows the arithmetic and ``tests/literature`` repeats it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

import numpy as np

from atleak.analysis.source_study.variants import VariantResult
from atleak.common.unit_systems import DM3_MIN


@dataclass(frozen=True)
class StatedPoint:
    """A point of the minimum-acceleration test that the article's text states.

    ``time`` is None where the text names no instant. ``inferred`` points are not printed but follow from Table 3.
    """

    key: str
    quantity: str
    variant: str | None  # None: the pump, which all variants share
    time: float | None  # [s]
    printed: Decimal  # [dm³/min]
    inferred: bool = False


STATED_POINTS: tuple[StatedPoint, ...] = (
    StatedPoint("W4-start", "leakage", "W4", 0.0, Decimal("6.37")),
    StatedPoint("W4-before-shift", "leakage", "W4", 0.8, Decimal("6.22")),
    StatedPoint("W4-least", "least leakage", "W4", None, Decimal("5.09")),
    StatedPoint("W4-after-rise", "leakage after the rapid rise", "W4", None, Decimal("8.46")),
    StatedPoint("W4-most", "most leakage", "W4", 2.1, Decimal("8.56")),
    StatedPoint("W8-least", "least leakage", "W8", None, Decimal("6.67")),
    StatedPoint("W8-most", "most leakage", "W8", 2.1, Decimal("11.23")),
    StatedPoint("pump-at-most-leakage", "pump capacity", None, 2.1, Decimal("24.34"), inferred=True),
    StatedPoint("pump-most", "largest pump capacity", None, None, Decimal("33.6")),
)


@dataclass(frozen=True)
class ComparedPoint:
    """A stated point beside the value that a road test gives."""

    point: StatedPoint
    time: float  # [s] of the computed value
    computed: float  # [dm³/min]

    @property
    def deviation(self) -> float:
        """Return the deviation relative to the printed value."""
        return self.computed / float(self.point.printed) - 1.0


def compare_points(results: Sequence[VariantResult]) -> tuple[ComparedPoint, ...]:
    """Return the stated points beside the results of the shipped test; the pump's only where engine speed was logged.

    The end of the rapid rise is the first sample after the least leakage at which it stops growing.
    """
    by_name = {result.variant.name: result for result in results}
    compared = []
    for point in STATED_POINTS:
        result = by_name[point.variant or "W4"]
        values = result.computed.leakage if point.variant else result.computed.pump_capacity
        if values is None:
            continue
        index = _index(point, result.time, values)
        compared.append(ComparedPoint(point, float(result.time[index]), float(values[index]) * DM3_MIN))
    return tuple(compared)


def _index(point: StatedPoint, time: np.ndarray, values: np.ndarray) -> int:
    if point.quantity == "least leakage":
        return int(np.nanargmin(values))
    if point.quantity in {"most leakage", "largest pump capacity"}:
        return int(np.nanargmax(values))
    if point.time is not None:
        return int(np.argmin(np.abs(time - point.time)))
    least = int(np.nanargmin(values))
    falling = np.flatnonzero(np.diff(values[least:]) <= 0.0)
    return least + int(falling[0]) if falling.size else len(values) - 1


@dataclass(frozen=True)
class Erratum:
    """A place where the article contradicts itself or its own units."""

    number: int
    article: str
    finding: str
    here: str


ERRATA: tuple[Erratum, ...] = (
    Erratum(
        1, "viscosity of the gap law in Pa·s",
        "With the factor 10⁶ and mm, kPa it must be mPa·s; in Pa·s the flow would be 1000 times too large.",
        "SI throughout, no factor",
    ),
    Erratum(
        2, "leakage decreases linearly with viscosity",
        "It is inversely proportional: half the viscosity, twice the leakage.",
        "1/ν",
    ),
    Erratum(
        3, "Q_p reaches 33.6 dm³/min at 2500 rpm",
        "Its geometry (17 100.3 mm³/rev) and efficiency 0.95 give 40.61; 33.6 needs efficiency 0.786 or 2068 rpm.",
        "geometry and efficiency as printed; the sample log reaches 33.6 at 2068 rpm",
    ),
    Erratum(
        4, "F = p·A in N with kPa and mm²",
        "kPa·mm² is mN: a factor 10⁻³ is missing.",
        "SI",
    ),
    Erratum(
        5, "shear modulus 0.8·10⁵ GPa",
        "Spring steel has 0.8·10⁵ MPa.",
        "80 000 MPa",
    ),
    Erratum(
        6, "spring deflection from the pre-tensioned length",
        "That leaves out the preload, unless the free length is meant.",
        "deflection from the free length",
    ),
    Erratum(
        7, "p_s = p_g·A_2W/A_1W + F/A_1",
        "The factor 1000 on F/A_1 is missing, A_1 and A_1W are mixed, and it is not what the balance (6) gives.",
        "the balance (6) solved for p_s",
    ),
    Erratum(
        8, "pressure of the drains",
        "Three conventions: 0.1 p_g (13, 18), 0.1 p_m and 0.1 p_k (23, 24, 26), and 0 (26).",
        "every gap of the controller's file names its own low side, as printed",
    ),
    Erratum(
        9, "valve 8, land 1",
        "One land is a gap from p_g to p_m and at once from p_m to 0.1 p_m.",
        "both, as printed",
    ),
    Erratum(
        10, "valve 26",
        "The diameter of land 1 is printed for land 2 as well; the drop of 0.5 p_g is not explained.",
        "each land its own diameter; 0.5 p_g kept",
    ),
    Erratum(
        11, "the total is the sum of all sections",
        "Flow from p_g to p_m is counted again when it leaves p_m. The pump supplies only what ends in the sump.",
        "paper: the sum of all gaps; workshop: what ends in the sump",
    ),
    Erratum(
        12, "viscosity at 40 and 100 °C",
        "Table 2 has the data sheet's 42.0 and 7.0; the article's regression gives 61.6 and 4.67.",
        "paper: Table 2; workshop: ASTM D341 through 42.0 and 7.0",
    ),
    Erratum(
        13, "viscosity at -40 °C: 1923 mm²/s",
        "The regression's 1921; ASTM D341 gives 35 155, and a real Dexron IID has some 33 000 mPa·s (38 000 mm²/s).",
        "paper: 1923; ASTM D341 is not used below -20 °C for a fluid without a stated pour point",
    ),
    Erratum(
        14, "density falls by 0.0007 g/cm³ per K",
        "Table 2 follows 0.00073. The line gives 0.830 g/cm³ at 15 °C; a Dexron IID fluid's data sheet has 0.870.",
        "paper: Table 2",
    ),
    Erratum(
        15, "Table 3, W3 and W4",
        "They follow from 8.40 mm²/s, the used oil, not from the 10.93 of Table 2, which gives 2.80 and 6.58.",
        "both shown: computed (8.40) and as tabulated (10.93)",
    ),
    Erratum(
        16, "Table 3, W8: share 56.2 %",
        "W1 to W7 share a pump flow of 24.31 to 24.37 dm³/min; W8 is then 46.1 to 46.2 %. 56.2 % needs 19.98.",
        "46.2 % beside the printed figure",
    ),
    Erratum(17, "W7: 1.43 in Table 3, 1.41 in the text", "One of them is a slip; 1.43 fits the other rows.", "1.43"),
    Erratum(
        18, "maximum share",
        "It is the share at the instant of most leakage. The share is larger at idle, where the pump turns slowest.",
        "both reported",
    ),
    Erratum(19, "conclusion 4: 25 % of the pump capacity", "W2, which it speaks of, has 11.6 %.", "11.6 %"),
    Erratum(
        20, "conclusion 6: up to 20 % in W3",
        "Table 3 has 14.9 % for W3, and 11.5 % with the stated viscosity.",
        "15.0 and 11.5 %; 20.8 % at idle",
    ),
    Erratum(
        21, "viscosity 20 % lower, leakage 25 % higher",
        "From 10.93 to 8.40 mm²/s is 23.1 % lower, and the leakage 30.1 % higher.",
        "-23.1 %, +30.1 %",
    ),
    Erratum(
        22, "bores measured across the direction of wear",
        "The clearances are then a lower bound of the worn gap.",
        "plane and direction are kept; ovality and the worst direction are shown",
    ),
    Erratum(
        23, "repeated readings of Table 1",
        "The second reading has the two coordinates swapped, so it is no independent repeat and their scatter is 0.",
        "such repeats are recognised; resolution, not zero, sets the uncertainty",
    ),
)  # fmt: skip
