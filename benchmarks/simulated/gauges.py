"""Read the diameters of simulated pairs with simulated gauges: errors in common, of their own, of each repeat."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from atleak.catalogue.instruments import Instruments, Part
from atleak.measurements.readings import Reading, Readings
from simulated.pairs import Pair

PARTS: tuple[Part, ...] = ("spool", "sleeve")


@dataclass(frozen=True)
class Reader:
    """How a sheet comes about: the gauges, where and how often they are set, and how their errors fall."""

    instruments: Instruments
    repeats: int
    directions: tuple[float, ...] = (0.0, 90.0)  # [°]
    heavy_tails: bool = False  # every error Student t with 3 degrees of freedom, same spread
    common: float = 1.0  # times the declared common error
    calibration: float = 1.0  # times the declared own calibration error
    room_temperature: float = 0.5  # [K] half width of its range around 20 °C

    def read(self, rng: np.random.Generator, pairs: Sequence[Pair]) -> Readings:
        """Read every pair in each of its planes."""
        error = self._errors(rng)
        too_warm = rng.uniform(-self.room_temperature, self.room_temperature)  # [K]
        common = {part: error(self.common * self.instruments.of(part).common) for part in PARTS}
        if self.instruments.err_alike:
            common["spool"] = common["sleeve"]
        readings = []
        for pair in pairs:
            land = pair.land
            for part in PARTS:
                tool = self.instruments.of(part)
                warm = pair.spool * (land.expansion_of(part) - tool.expansion) * too_warm  # the gauge expands too
                offset = common[part] + error(self.calibration * tool.own) + warm
                for place, plane in enumerate(land.planes):
                    along = place - 0.5 if len(land.planes) > 1 else 0.0
                    for direction in self.directions:
                        true = pair.diameter(part, direction, along)
                        for repeat in range(1, self.repeats + 1):
                            read = true + offset + error(tool.repeatability or 0.0)
                            read = round(read / tool.resolution) * tool.resolution
                            readings.append(Reading(land.component, part, plane, direction, repeat, read))
        return Readings("simulated", "", None, "mm", False, "tidy", tuple(readings))

    def _errors(self, rng: np.random.Generator) -> Callable[[float], float]:
        def normal(spread: float) -> float:
            return float(rng.normal(0.0, spread))

        def heavy(spread: float) -> float:
            return float(rng.standard_t(3)) * spread / math.sqrt(3.0)

        return heavy if self.heavy_tails else normal
