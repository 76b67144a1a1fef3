"""Lay out the clearance that the readings give in every direction of every plane; a land's form follows from it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from atleak.catalogue.instruments import Part
from atleak.land_diagnosis import LandDiagnosis
from atleak.readings import Station
from atleak.report.xlsx.book import span
from atleak.report.xlsx.live_cells import EXPANSIONS, Cells, LiveColumn, LiveSheet, component_width
from atleak.rules import LandKey
from atleak.sentence import Sentence
from atleak.workshop_units import MM, UM

if TYPE_CHECKING:
    from atleak.report.xlsx.live import LiveSheets

DIRECTIONS = Sentence("Directions")


@dataclass(frozen=True)
class _Line:
    """One direction of a land."""

    land: LandDiagnosis
    station: Station
    weight: float
    off: float  # [µm] its clearance less the mean of the land


class DirectionCells:
    """Where the clearance of a land stands in every direction, and the moments over them as formulas.

    Lands whose form nobody can see, because no plane was measured in two directions, are left out.
    """

    def __init__(self, live: LiveSheets) -> None:
        lines = [line for land in live.lands for line in _directions(land)]
        self.rows: dict[LandKey, tuple[int, int]] = {}
        for row, line in enumerate(lines, start=1):
            self.rows[line.land.key] = (self.rows.get(line.land.key, (row, row))[0], row)

        def diameter(part: Part) -> Callable[[_Line, Cells], str]:
            def formula(line: _Line, _: Cells) -> str:
                key = line.land.key
                there = live.readings.at(key, part, line.station, live.of_land(key, EXPANSIONS[part]))
                return there or live.of_land(key, part)

            return formula

        def off(line: _Line, here: Cells) -> str:
            rows, place = self.rows[line.land.key], self.sheet.place
            clearances, weights = (span(*rows, place[key]) for key in ("c", "weight"))
            return f"{here['c']}-SUMPRODUCT({clearances},{weights})"

        weight = Sentence("weight: directions of a plane alike, planes alike")
        # fmt: off
        columns = (
            LiveColumn("component", Sentence("component"), value=lambda line: line.land.key[0],
                       width=component_width(live.diagnosis.controller.components)),
            LiveColumn("land", Sentence("land"), value=lambda line: line.land.key[1], width=14),
            LiveColumn("plane", Sentence("plane"), value=lambda line: line.station.plane, width=14),
            LiveColumn("direction", Sentence("direction [°]"), value=lambda line: line.station.direction, width=14),
            LiveColumn("sleeve", Sentence("sleeve diameter [mm]"), "mm", lambda line: line.station.sleeve_diameter,
                       diameter("sleeve"), MM, 14),
            LiveColumn("spool", Sentence("spool diameter [mm]"), "mm", lambda line: line.station.spool_diameter,
                       diameter("spool"), MM, 14),
            LiveColumn("c", Sentence("radial clearance c [µm]"), "um", lambda line: line.station.radial_clearance,
                       "({sleeve}-{spool})/2*1000", UM, 14),
            LiveColumn("weight", weight, value=lambda line: line.weight, width=14),
            LiveColumn("off", Sentence("c − mean of the land [µm]"), "um", lambda line: line.off, off, width=14),
            LiveColumn("m2", Sentence("weight · (c − mean)² [µm²]"), "um", lambda line: line.weight * line.off**2,
                       "{weight}*{off}^2", width=14),
            LiveColumn("m3", Sentence("weight · (c − mean)³ [µm³]"), "um", lambda line: line.weight * line.off**3,
                       "{weight}*{off}^3", width=14),
        )
        # fmt: on
        self.sheet = LiveSheet(live.say.sentence(DIRECTIONS), columns, lines)

    def moment(self, key: LandKey, power: int) -> str | None:
        """Return the formula of a land's second or third moment [µm², µm³]; None where its form was not seen."""
        rows = self.rows.get(key)
        return None if rows is None else f"SUM({self.sheet.span(*rows, f'm{power}')})"


def _directions(land: LandDiagnosis) -> list[_Line]:
    """Return the directions of a land whose form shows; none where no plane was measured in two."""
    stations = land.state.stations
    of_plane = Counter(each.plane for each in stations)
    if max(of_plane.values(), default=0) < 2:
        return []
    weights = [1.0 / (len(of_plane) * of_plane[each.plane]) for each in stations]
    mean = sum(weight * each.radial_clearance for weight, each in zip(weights, stations, strict=True))
    return [
        _Line(land, station, weight, (station.radial_clearance - mean) * UM)
        for weight, station in zip(weights, stations, strict=True)
    ]
