"""Say between which values the numbers of catalogue files usually lie: outside of them one is doubted, not refused.

Every range is a choice of this project, wide enough that nothing which ships with atleak is doubted. It is there for
slips: a decimal sign, another unit, bore minus spool where half of it is asked for.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from atleak.common.sentences import Sentence, any_of

EACH = "*"  # any entry of a list, or any name
KeyPattern = tuple[str, ...]


@dataclass(frozen=True)
class Usual:
    """What a number of a file usually is, in the unit of the file."""

    name: Sentence  # in a sentence: "the displacement of one revolution"
    unit: str
    low: float
    high: float
    others: Mapping[str, float] = field(default_factory=dict)  # units that may have been meant, each in the file's

    @property
    def ends(self) -> tuple[float, float]:
        """Return the lowest and the highest usual value."""
        return self.low, self.high

    def doubt(self, value: float) -> Sentence:
        """Return what to ask about a value; "" where it is a usual one.

        >>> DISPLACEMENT.doubt(18000.0)
        ''
        >>> DISPLACEMENT.doubt(18.0)
        '18 mm³ is unusual for the displacement of one revolution: most are from 3000 to 80000 mm³. Was it in cm³?'
        """
        if self.low <= value <= self.high:
            return Sentence("")
        meant = [unit for unit, size in self.others.items() if self.low <= value * size <= self.high]
        return Sentence(
            "{value:.6g}{unit} is unusual for {quantity}: most are from {low:.15g} to {high:.15g}{unit}.{question}",
            value=value,
            unit=f" {self.unit}" if self.unit else "",
            quantity=self.name,
            low=self.low,
            high=self.high,
            question=Sentence(" Was it in {units}?", units=any_of(meant)) if meant else Sentence(""),
        )


_OF_MM = {"µm": 1e-3, "inch": 25.4}
_OF_UM = {"mm": 1e3, "inch": 25.4e3}
_OF_KPA = {"bar": 1e2, "MPa": 1e3, "psi": 6.894757, "Pa": 1e-3}

_OF_ONE: Mapping[str, float] = {Sentence("parts of one"): 1e2}

DISPLACEMENT = Usual(Sentence("the displacement of one revolution"), "mm³", 3e3, 8e4, {"cm³": 1e3, "inch³": 16387.064})
LAND_DIAMETER = Usual(Sentence("the diameter of a land"), "mm", 3.0, 80.0, _OF_MM)
CONTACT_LENGTH = Usual(Sentence("a contact length"), "mm", 0.8, 40.0, _OF_MM)
ORIFICE = Usual(Sentence("the diameter of an orifice"), "mm", 0.2, 12.0, _OF_MM)
USUAL_CLEARANCE = Usual(Sentence("a radial clearance when new"), "µm", 2.0, 100.0, _OF_UM)
NEW_CLEARANCE = Usual(Sentence("the median radial clearance of new lands"), "µm", 6.4, 20.0)
"""Sonnax, valve body inspection: new valves have a diametral clearance of 0.0127 to 0.040 mm."""
WIDEST_NEW = 40.0  # [µm] median over which even a measured one is doubted: the source study's unit, used, has 28.5

USUAL_TEMPERATURE = Usual(Sentence("a fluid temperature"), "°C", -30.0, 150.0)
USUAL_ENGINE_SPEED = Usual(Sentence("an engine speed"), "rpm", 400.0, 7000.0, {"1/s": 60.0})
SIDE_CLEARANCE = Usual(Sentence("the side clearance of a pump"), "µm", 10.0, 300.0, _OF_UM)
TIP_CLEARANCE = Usual(Sentence("the tip clearance of a pump"), "µm", 20.0, 1000.0, _OF_UM)
TOLERANCE = Usual(Sentence("the tolerance of a mounting clearance"), "µm", 0.2, 40.0, _OF_UM)
CLEARANCE_LIMIT = Usual(Sentence("the limit of a radial clearance"), "µm", 5.0, 300.0, _OF_UM)
MAIN_PRESSURE = Usual(Sentence("a main pressure"), "kPa", 100.0, 3500.0, _OF_KPA)
CONVERTER_PRESSURE = Usual(Sentence("a converter pressure"), "kPa", 0.0, 1500.0, _OF_KPA)
SET_PRESSURE = Usual(Sentence("the set pressure of a circuit"), "kPa", 10.0, 3500.0, _OF_KPA)
EFFICIENCY = Usual(Sentence("a volumetric efficiency"), "", 0.6, 1.0, {"%": 0.01})
USUAL_EXPANSION = Usual(Sentence("a linear expansion"), "1/K", 5e-6, 35e-6, {"10⁻⁶/K": 1e-6})

WEAR = Usual(Sentence("a limit of wear"), "%", 2.0, 300.0, _OF_ONE)
WEAR_LIMIT = Usual(Sentence("a limit of the radial clearance"), "µm", 5.0, 300.0, _OF_UM)
PAIR_SHARE = Usual(Sentence("a limit of one pair's share of the pump"), "%", 0.2, 50.0, _OF_ONE)
TOTAL_SHARE = Usual(Sentence("a limit of the unit's share of the pump"), "%", 1.0, 100.0, _OF_ONE)
CIRCUIT_LOSS = Usual(Sentence("a limit of the pressure that a circuit loses"), "kPa", 10.0, 600.0, _OF_KPA)
BELOW_PERMISSIBLE = Usual(Sentence("a limit below the permissible pressure"), "%", 0.0, 60.0)
OFF_COMMANDED = Usual(Sentence("a limit of the distance from commanded pressure"), "kPa", 10.0, 600.0, _OF_KPA)
RESERVE = Usual(Sentence("a limit of the pump's reserve"), "", 0.5, 4.0, {"%": 0.01})
FALL = Usual(Sentence("a fall of the reserve"), "%", 1.0, 60.0, _OF_ONE)
GROWTH = Usual(Sentence("growth over a new one"), "%", 2.0, 500.0, _OF_ONE)
ADDED_POINTS = Usual(Sentence("points of the pump's flow added by wear"), "%", 0.0, 40.0)
AT_LEAST = Usual(Sentence("a least growth of the clearance"), "µm", 0.5, 60.0, _OF_UM)

RESOLUTION = Usual(Sentence("the resolution of a gauge for diameters"), "µm", 0.01, 20.0, _OF_UM)
CALIBRATION = Usual(Sentence("the standard uncertainty of a gauge for diameters"), "µm", 0.05, 20.0, _OF_UM)
REPEATABILITY = Usual(Sentence("the standard deviation of one reading"), "µm", 0.02, 20.0, _OF_UM)
EXPANSION_OF_GAUGE = Usual(Sentence("the expansion of a scale or of masters"), "1/K", 0.0, 30e-6, {"10⁻⁶/K": 1e-6})

DENSITY = Usual(Sentence("the density of a transmission fluid"), "g/cm³", 0.75, 0.95)
DENSITY_OF_TABLE = Usual(Sentence("the density of a transmission fluid"), "g/cm³", 0.68, 0.95)
DENSITY_SLOPE = Usual(Sentence("the slope of a density"), "g/(cm³·K)", -1.2e-3, -3e-4)
POUR_POINT = Usual(Sentence("the pour point of a transmission fluid"), "°C", -75.0, -10.0)
THINNEST, THICKEST = ((10.0, 2.7), (80.0, 14.0))
"""Kinematic viscosities [mm²/s] at 40 and 100 °C between which those of transmission fluids lie, fresh or used."""
