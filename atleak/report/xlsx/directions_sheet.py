"""Write the clearance that the readings give in every direction of every plane; the form of a land follows from it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.instruments import Part
from atleak.land_diagnosis import LandDiagnosis
from atleak.readings import Station
from atleak.report.xlsx.book import Book, span
from atleak.report.xlsx.live_cells import EXPANSIONS, Cell, ColumnKey, cells_of_row, write_cell
from atleak.report.xlsx.readings_sheet import ReadingCells
from atleak.rules import LandKey
from atleak.sentence import Sentence
from atleak.uncertainty.sources import PARTS
from atleak.wording import Wording
from atleak.workshop_units import MM, UM

DIRECTIONS = Sentence("Directions")
_COLUMNS = {
    "component": Sentence("component"),
    "land": Sentence("land"),
    "plane": Sentence("plane"),
    "direction": Sentence("direction [°]"),
    "sleeve": Sentence("sleeve diameter [mm]"),
    "spool": Sentence("spool diameter [mm]"),
    "c": Sentence("radial clearance c [µm]"),
    "weight": Sentence("weight: directions of a plane alike, planes alike"),
    "off": Sentence("c − mean of the land [µm]"),
    "m2": Sentence("weight · (c − mean)² [µm²]"),
    "m3": Sentence("weight · (c − mean)³ [µm³]"),
}
_COLUMN_OF = {key: number for number, key in enumerate(_COLUMNS)}


class DirectionCells:
    """Where the clearance of a land stands in every direction, and the moments over them as formulas.

    Lands whose form nobody can see, because no plane was measured in two directions, are left out.
    """

    def __init__(self, lands: Sequence[LandDiagnosis], say: Wording) -> None:
        self.sheet = say.sentence(DIRECTIONS)
        self.lines = [(land, each) for land in lands if _shows_form(land) for each in land.state.stations]
        self.rows: dict[LandKey, tuple[int, int]] = {}
        for row, (land, _) in enumerate(self.lines, start=1):
            self.rows[land.key] = (self.rows.get(land.key, (row, row))[0], row)

    def moment(self, key: LandKey, power: int) -> str | None:
        """Return the formula of a land's second or third moment [µm², µm³]; None where its form was not seen."""
        rows = self.rows.get(key)
        return None if rows is None else f"SUM({span(*rows, _COLUMN_OF[f'm{power}'], self.sheet)})"


def _shows_form(land: LandDiagnosis) -> bool:
    return max(Counter(each.plane for each in land.state.stations).values(), default=0) > 1


def write_directions(
    book: Book,
    sheet: Worksheet,
    directions: DirectionCells,
    readings: ReadingCells,
    of_land: Callable[[LandKey, ColumnKey], str],
) -> None:
    """Write the clearance in every direction; ``of_land`` gives the cells of a land."""
    book.headings(sheet, 0, _COLUMNS.values(), lines=3)
    for row, (land, station) in enumerate(directions.lines, start=1):
        rows = directions.rows[land.key]
        diameters = {
            part: readings.at(land.key, part, station, of_land(land.key, EXPANSIONS[part])) or of_land(land.key, part)
            for part in PARTS
        }
        for column, content in enumerate(_direction(land, station, row, rows, diameters)):
            write_cell(book, sheet, row, column, content)
    sheet.set_column(0, len(_COLUMNS), 14)
    sheet.autofilter(0, 0, max(len(directions.lines), 1), len(_COLUMNS) - 1)


def _direction(
    land: LandDiagnosis, station: Station, row: int, rows: tuple[int, int], diameters: dict[Part, str]
) -> list[Cell]:
    here = cells_of_row(row, _COLUMN_OF)
    stations = land.state.stations
    of_plane = Counter(each.plane for each in stations)
    weights = [1.0 / (len(of_plane) * of_plane[each.plane]) for each in stations]
    weight = 1.0 / (len(of_plane) * of_plane[station.plane])
    mean = sum(share * each.radial_clearance for share, each in zip(weights, stations, strict=True))
    off = (station.radial_clearance - mean) * UM
    clearances, shares = (span(*rows, _COLUMN_OF[key]) for key in ("c", "weight"))
    return [
        Cell("plain", land.key[0]),
        Cell("plain", land.key[1]),
        Cell("plain", station.plane),
        Cell("plain", station.direction),
        Cell("mm", station.sleeve_diameter * MM, diameters["sleeve"]),
        Cell("mm", station.spool_diameter * MM, diameters["spool"]),
        Cell("um", station.radial_clearance * UM, f"({here('sleeve')}-{here('spool')})/2*1000"),
        Cell("plain", weight),
        Cell("um", off, f"{here('c')}-SUMPRODUCT({clearances},{shares})"),
        Cell("um", weight * off**2, f"{here('weight')}*{here('off')}^2"),
        Cell("um", weight * off**3, f"{here('weight')}*{here('off')}^3"),
    ]
