"""Write the readings as entered, and the clearance that they give in every direction of every plane.

The diameters of the sheet of lands are means of the readings, the form of a land is that of its directions: a changed
reading changes both.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Land
from atleak.catalogue.instruments import Part
from atleak.diagnosis import Diagnosis
from atleak.land_diagnosis import LandDiagnosis
from atleak.readings import Reading, Station
from atleak.report.xlsx.book import Book, exact, formula, span
from atleak.report.xlsx.live_cells import (
    CHANGEABLE,
    EXPANSIONS,
    PER_KELVIN,
    Cell,
    ColumnKey,
    address,
    cells_of_row,
    write_cell,
)
from atleak.rules import LandKey
from atleak.sentence import Sentence
from atleak.wording import Wording
from atleak.workshop_units import MM, UM

_PARTS: tuple[Part, ...] = ("spool", "sleeve")
_DIAMETER, _COORDINATES = 6, 7  # columns of the sheet of readings
READINGS, DIRECTIONS = Sentence("Readings"), Sentence("Directions")
_HEADINGS = (
    Sentence("component"),
    Sentence("land"),
    Sentence("part"),
    Sentence("plane"),
    Sentence("direction [°]"),
    Sentence("repeat"),
    Sentence("diameter [mm]"),
    Sentence("coordinate 1 [mm]"),
    Sentence("coordinate 2 [mm]"),
    Sentence("sheet"),
    Sentence("row"),
    Sentence("column"),
)
_PART_NAMES: dict[Part, Sentence] = {"spool": Sentence("spool"), "sleeve": Sentence("sleeve")}
_Place = tuple[LandKey, Part, str, float | None]  # land, part, plane and direction of some readings


class ReadingCells:
    """Where every reading stands on its sheet, sorted by land, and the means over them as formulas.

    The readings are as they were read. A mean is corrected to 20 °C from the measuring temperature; ``expansion`` is
    the cell of the part's coefficient [1e-6/K].
    """

    def __init__(self, diagnosis: Diagnosis, say: Wording) -> None:
        self.sheet = say.sentence(READINGS)
        measured_at, uncertainty = diagnosis.measured_at, diagnosis.uncertainty
        self._gauges = uncertainty.instruments if uncertainty and measured_at and measured_at.corrects else None
        self._rise = measured_at.value - REFERENCE_TEMPERATURE if measured_at else 0.0  # [K]
        lands = {land.key: number for number, land in enumerate(diagnosis.lands)}
        found = diagnosis.readings.readings if diagnosis.readings else ()
        known = [(reading, diagnosis.controller.land_of_plane(reading.component, reading.plane)) for reading in found]
        known.sort(key=lambda pair: _order(pair[0], pair[1], lands))
        self.lines: list[tuple[Reading, Land | None]] = known
        self._rows: dict[_Place, list[int]] = {}
        for row, (reading, land) in enumerate(known, start=1):
            if land is not None:
                self._rows.setdefault((land.key, reading.part, reading.plane, reading.direction), []).append(row)

    def mean(self, key: LandKey, part: Part, expansion: str) -> str | None:
        """Return the formula of a part's mean diameter over repeats, then directions, then planes."""
        planes = dict.fromkeys(plane for at, of, plane, _ in self._rows if (at, of) == (key, part))
        return self._corrected(_average([self._of_plane(key, part, plane) for plane in planes]), part, expansion)

    def _of_plane(self, key: LandKey, part: Part, plane: str) -> str | None:
        rows = [rows for place, rows in self._rows.items() if place[:3] == (key, part, plane)]
        return _average([_average([span(each[0], each[-1], _DIAMETER, self.sheet)]) for each in rows])

    def at(self, key: LandKey, part: Part, station: Station, expansion: str) -> str | None:
        """Return the formula of a part's diameter at one place, as far as it was read there; else in its plane."""
        rows = self._rows.get((key, part, station.plane, station.direction))
        here = None if rows is None else _average([span(rows[0], rows[-1], _DIAMETER, self.sheet)])
        return self._corrected(here or self._of_plane(key, part, station.plane), part, expansion)

    def _corrected(self, mean: str | None, part: Part, expansion: str) -> str | None:
        if mean is None or self._gauges is None:
            return mean
        gauge = exact(self._gauges.of(part).expansion * PER_KELVIN)
        return f"{mean}*(1-({expansion}-{gauge})*1E-6*{exact(self._rise)})"


def _order(reading: Reading, land: Land | None, lands: dict[LandKey, int]) -> tuple[Any, ...]:
    place = lands[land.key] if land else len(lands)
    plane = land.planes.index(reading.plane) if land else 0
    direction = -1.0 if reading.direction is None else reading.direction
    return place, reading.part != "spool", plane, direction, reading.repeat


def _average(terms: Sequence[str | None]) -> str | None:
    """Return the formula of a mean of numbers; one mean is its own mean."""
    known = [term for term in terms if term is not None]
    if not known:
        return None
    if len(known) == 1 and known[0].startswith("AVERAGE("):
        return known[0]
    return f"AVERAGE({','.join(known)})"


def write_readings(book: Book, sheet: Worksheet, cells: ReadingCells) -> None:
    """Write every reading as entered, sorted by land."""
    book.headings(sheet, 0, _HEADINGS)
    form, mm = book.form(), book.form("mm", **CHANGEABLE)
    for row, (reading, land) in enumerate(cells.lines, start=1):
        values = (
            reading.component,
            land.land if land else None,
            _PART_NAMES[reading.part],
            reading.plane,
            reading.direction,
        )
        for column, value in enumerate((*values, reading.repeat)):
            book.put(sheet, row, column, value, form)
        if reading.coordinates is None:
            book.put(sheet, row, _DIAMETER, reading.diameter * MM, mm)
        else:
            for column, coordinate in enumerate(reading.coordinates, start=_COORDINATES):
                book.put(sheet, row, column, coordinate * MM, mm)
            ends = (address(row, _COORDINATES + end) for end in (0, 1))
            formula(sheet, row, _DIAMETER, f"ABS({'-'.join(ends)})", reading.diameter * MM, book.form("mm"))
        for column, value in enumerate((reading.place.sheet, reading.place.row, reading.place.column), start=9):
            book.put(sheet, row, column, value, form)
    sheet.set_column(0, len(_HEADINGS), 13)
    sheet.autofilter(0, 0, max(len(cells.lines), 1), len(_HEADINGS) - 1)


# --- the clearance in every direction

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
            for part in _PARTS
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
