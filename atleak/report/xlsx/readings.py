"""Write the readings as entered, what the repeats of every place give, and the clearance in every direction.

A place is one plane and direction of one part. The diameters of the sheet of lands are means of its places, and how far
repeats differ makes the budget: a changed reading, coordinate or choice of what counts changes all of it.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from statistics import fmean
from typing import TYPE_CHECKING, Any

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.controller import Land
from atleak.catalogue.instruments import Part
from atleak.catalogue.repairs import LandKey
from atleak.catalogue.words import PART_WORDS
from atleak.common.sentences import Sentence
from atleak.common.units import MM, UM, UnitOf
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.uncertainty.sources import PARTS
from atleak.measurements.clearances import REPEAT_TOLERANCE, Station, independent_repeats, repeats_that_count
from atleak.measurements.readings import Reading
from atleak.report.xlsx.book import ReportBook, cell_span
from atleak.report.xlsx.live_sheet import (
    CHANGEABLE,
    CLEARANCE,
    EXPANSIONS,
    LENGTH,
    MEASURED_AT,
    REFERENCE,
    REPEATS_APART,
    LiveCell,
    LiveCells,
    LiveColumn,
    LiveSheet,
    address,
    cells_of_part,
    component_width,
    quote,
)

if TYPE_CHECKING:
    from atleak.report.xlsx.lands import LiveSheets

READINGS = Sentence("Readings")
_ENTERED = {
    "component": Sentence("component"),
    "land": Sentence("land"),
    "part": Sentence("part"),
    "plane": Sentence("plane"),
    "direction": Sentence("direction [°]"),
    "repeat": Sentence("repeat"),
    "diameter": Sentence("diameter [{unit}]", unit=LENGTH),
    "coordinate_1": Sentence("coordinate 1 [{unit}]", unit=LENGTH),
    "coordinate_2": Sentence("coordinate 2 [{unit}]", unit=LENGTH),
    "counts": Sentence("counts in the mean: yes or no"),
}
_OF_COORDINATES = {
    "independent": Sentence("repeat of its own, not the same coordinates again"),
    "alike": Sentence("readings with these coordinates"),
}
_OF_REPEATS = {
    "off": Sentence("off the mean of the place's own repeats [{unit}]", unit=CLEARANCE),
    "degrees": Sentence("degrees of freedom of the place"),
    "squares": Sentence("sum of squares of the place, slips limited [{unit}]", unit=UnitOf("clearance_squared")),
}
_OF_PLACES = {
    "mean": Sentence("mean of the place [{unit}]", unit=LENGTH),
    "weight": Sentence("weight: directions of a plane alike, planes alike"),
    "repeat_weight": Sentence("variance of the mean per variance of a reading"),
}
_OF_OVALITY: dict[Part, Sentence] = {
    "spool": Sentence("ovality of the spool [{unit}]", unit=CLEARANCE),
    "sleeve": Sentence("ovality of the sleeve [{unit}]", unit=CLEARANCE),
}
_ORIGIN = {"sheet": Sentence("sheet"), "row": Sentence("row"), "column": Sentence("column")}


@dataclass
class _Place:
    """The repeats of one plane and direction of one part, and the rows in which they stand."""

    land: Land
    part: Part
    plane: str
    direction: float | None
    repeats: list[Reading]  # as the measuring sheet has them
    first: int = 0
    last: int = 0

    @property
    def several(self) -> bool:
        return len(self.repeats) > 1

    @cached_property
    def counted(self) -> list[Reading]:
        return repeats_that_count(self.repeats)

    @cached_property
    def own(self) -> list[Reading]:
        """Return the repeats that do not only repeat or swap another one's coordinates."""
        return independent_repeats(self.repeats)

    @cached_property
    def mean(self) -> float:
        return fmean(each.diameter for each in self.counted)

    def alike(self, reading: Reading) -> int:
        """Return how many readings that count have the coordinates of one."""
        if reading.coordinates is None:
            return 1
        pair = sorted(reading.coordinates)
        return sum(each.coordinates is not None and sorted(each.coordinates) == pair for each in self.counted)


class ReadingCells:
    """Where every reading stands on its sheet, sorted by land, and what follows from the readings as formulas."""

    def __init__(self, diagnosis: Diagnosis, say: Wording) -> None:
        self.say = say
        self._yes, self._no = quote(say("estimate.yes")), quote(say("estimate.no"))
        lands = {land.key: number for number, land in enumerate(diagnosis.lands)}
        found = diagnosis.readings.readings if diagnosis.readings else ()
        known = [(reading, diagnosis.controller.land_of_plane(reading.component, reading.plane)) for reading in found]
        places: dict[Any, _Place] = {}
        for reading, land in known:
            if land is not None:
                station = land.key, *reading.station
                places.setdefault(station, _Place(land, reading.part, reading.plane, reading.direction, []))
                places[station].repeats.append(reading)
        known.sort(key=lambda pair: _order(pair[0], pair[1], lands))
        self._places: dict[tuple[LandKey, Part], list[_Place]] = defaultdict(list)
        self.lines: list[tuple[Reading, _Place | None]] = []
        for row, (reading, land) in enumerate(known, start=1):
            place = places[land.key, *reading.station] if land is not None else None
            if place is not None:
                if not place.first:
                    place.first = row
                    self._places[place.land.key, place.part].append(place)
                place.last = row
            self.lines.append((reading, place))
        self._states = {land.key: land for land in diagnosis.lands}
        columns = [LiveColumn(key, heading, width=13) for key, heading in self._headings().items()]
        columns[0] = replace(columns[0], width=component_width(diagnosis.controller.components))
        self.sheet = LiveSheet(say.sentence(READINGS), columns, self.lines)
        self._column = self.sheet.place

    def _headings(self) -> dict[str, Sentence]:
        """Return the columns that have a value for these readings."""
        with_coordinates = any(reading.coordinates is not None for reading, _ in self.lines)
        repeated = any(place is not None and place.several for _, place in self.lines)
        return {
            **_ENTERED,
            **(_OF_COORDINATES if with_coordinates else {}),
            **(_OF_REPEATS if repeated else {}),
            **_OF_PLACES,
            **{
                f"ovality_{part}": heading
                for part, heading in _OF_OVALITY.items()
                if any(_ovality(land, part) is not None for land in self._states.values())
            },
            **_ORIGIN,
        }

    # --- what other sheets ask for

    def mean(self, key: LandKey, part: Part, expansion: str) -> str | None:
        """Return the formula of a part's mean diameter at 20 °C over repeats, then directions, then planes.

        ``expansion`` is the cell of the part's coefficient [1e-6/K].
        """
        planes = [self.span("mean", rows) for rows in self._planes(key, part)]
        return self._corrected(_average(planes), part, expansion)

    def at(self, key: LandKey, part: Part, station: Station, expansion: str) -> str | None:
        """Return the formula of a part's diameter at one place, as far as it was read there; else in its plane."""
        places = self._places.get((key, part), [])
        here = [place for place in places if (place.plane, place.direction) == (station.plane, station.direction)]
        near = here or [place for place in places if place.plane == station.plane]
        rows = self.span("mean", near) if near else None
        return self._corrected(None if rows is None else _average([rows]), part, expansion)

    def span(self, column: str, places: Sequence[_Place]) -> str:
        """Return the stretch of a column's cells over neighbouring places."""
        return self.sheet.span(places[0].first, places[-1].last, column)

    def whole(self, column: str) -> str | None:
        """Return the stretch of all cells of a column; None where the sheet has no such column."""
        return self.sheet.whole(column) if column in self._column else None

    def places_of(self, key: LandKey, part: Part) -> list[_Place]:
        """Return the places at which a part of a land was read, in the order of their rows."""
        return self._places.get((key, part), [])

    def taper(self, key: LandKey, part: Part) -> str:
        """Return the formula of how far the planes of a part differ [µm]."""
        planes = [_average([self.span("mean", rows)]) for rows in self._planes(key, part)]
        return f"({_of('MAX', planes)}-{_of('MIN', planes)})*1000" if len(planes) > 1 else "0"

    def _planes(self, key: LandKey, part: Part) -> list[list[_Place]]:
        planes: dict[str, list[_Place]] = defaultdict(list)
        for place in self._places.get((key, part), []):
            planes[place.plane].append(place)
        return list(planes.values())

    def _corrected(self, mean: str | None, part: Part, expansion: str) -> str | None:
        if mean is None:
            return None
        return f"{mean}*(1-({expansion}-{cells_of_part(part, 'expansion')})*1E-6*({MEASURED_AT}-{REFERENCE}))"

    # --- the sheet

    def write(self, book: ReportBook, sheet: Worksheet) -> None:
        """Write every reading as entered, sorted by land, and at the first of each place what its repeats give."""
        self.sheet.write(book, sheet, self._cells, printed=False)
        last, counts = max(len(self.lines), 1), self._column["counts"]
        choice = {"validate": "list", "source": [self.say("estimate.yes"), self.say("estimate.no")]}
        sheet.data_validation(1, counts, last, counts, choice)

    def _cells(self, row: int, line: tuple[Reading, _Place | None]) -> dict[str, LiveCell]:
        reading, place = line
        cells = dict(self._entered(row, reading, place))
        if place is not None:
            cells |= self._of_repeat(row, reading, place)
            cells |= self._of_place(place) if row == place.first else ()
        return cells

    def _entered(self, row: int, reading: Reading, place: _Place | None) -> Iterable[tuple[str, LiveCell]]:
        at = reading.place
        values = {
            "component": reading.component,
            "land": place.land.land if place else None,
            "part": PART_WORDS[reading.part],
            "plane": reading.plane,
            "direction": reading.direction,
            "repeat": reading.repeat,
            "sheet": at.sheet,
            "row": at.row,
            "column": at.column,
        }
        yield from ((key, LiveCell("plain", value, look={"align": "left"})) for key, value in values.items())
        if reading.coordinates is None:
            yield "diameter", LiveCell("mm", reading.diameter * MM, look=CHANGEABLE)
            return
        for number, coordinate in enumerate(reading.coordinates, start=1):
            yield f"coordinate_{number}", LiveCell("mm", coordinate * MM, look=CHANGEABLE)
        here = self._here(row)
        apart = f"ABS({here('coordinate_1')}-{here('coordinate_2')})"
        yield "diameter", LiveCell("mm", reading.diameter * MM, apart)

    def _of_repeat(self, row: int, reading: Reading, place: _Place) -> Iterable[tuple[str, LiveCell]]:
        """Return what a reading is among the repeats of its place."""
        counts = any(each is reading for each in place.counted)
        yield "counts", LiveCell("plain", counts, look={"align": "center", **(CHANGEABLE if place.several else {})})
        if not place.several:
            return
        own = any(each is reading for each in place.own)
        here, rows = self._here(row), self._rows(place)
        independent = self._yes
        if reading.coordinates is not None:
            word, text = self.say("estimate.yes" if own else "estimate.no"), None
            if row > place.first:  # the first of a place repeats none
                text = f"IF({self._same(row, place.first, row - 1)}>0,{self._no},{self._yes})"
            yield "independent", LiveCell("plain", word, text, {"align": "center"})
            yield (
                "alike",
                LiveCell("count", place.alike(reading), self._same(row, place.first, place.last, counted=True)),
            )
            independent = here("independent")
        elif "independent" in self._column:
            yield "independent", LiveCell("plain", True, look={"align": "center"})
        mean = f"AVERAGE({rows('diameter')})"
        if any(each.coordinates is not None for each in place.repeats):
            mean = f"AVERAGEIF({rows('independent')},{self._yes},{rows('diameter')})"
        off = f"({here('diameter')}-{mean})*1000"
        if independent != self._yes:
            off = f'IF({independent}={self._yes},{off},"")'
        value: Any = (reading.diameter - fmean(each.diameter for each in place.own)) * UM if own else ""
        yield "off", LiveCell("um", value, off)

    def _same(self, row: int, first: int, last: int, *, counted: bool = False) -> str:
        """Return the formula of how many readings of some rows have the coordinates of one, either way round."""
        columns = [self._column[f"coordinate_{number}"] for number in (1, 2)]
        low, high = (address(row, column) for column in columns)
        ends = [cell_span(first, last, column) for column in columns]
        beside = f",{cell_span(first, last, self._column['counts'])},{self._yes}" if counted else ""
        return "+".join(
            f"COUNTIFS({ends[0]},{one},{ends[1]},{other}{beside})" for one, other in ((low, high), (high, low))
        )

    def _of_place(self, place: _Place) -> Iterable[tuple[str, LiveCell]]:
        """Return what the repeats of a place give; where none of them counts, all do."""
        rows, here = self._rows(place), self._here(place.first)
        count = f"COUNTIF({rows('counts')},{self._yes})"
        mean, repeat_weight = here("diameter"), "1"
        if place.several:
            all_of_them, chosen = rows("diameter"), f"{rows('counts')},{self._yes},{rows('diameter')}"
            mean = f"IF({count}>0,AVERAGEIF({chosen}),AVERAGE({all_of_them}))"
            weight = f"1/{count}"
            if any(each.coordinates is not None for each in place.repeats):
                weight = f"SUMIF({rows('counts')},{self._yes},{rows('alike')})/{count}^2"
            repeat_weight = f"IF({count}>0,{weight},1/ROWS({all_of_them}))"
        yield "mean", LiveCell("mm", place.mean * MM, mean)
        places = self._planes(place.land.key, place.part)
        of_plane = next(each for each in places if place in each)
        yield "weight", LiveCell("plain", 1.0 / (len(places) * len(of_plane)))
        alike = sum(place.alike(each) for each in place.counted)
        yield "repeat_weight", LiveCell("plain", alike / len(place.counted) ** 2, repeat_weight)
        if place.several:
            yield from self._spread(place)
        if place is places[0][0]:
            ovality = _ovality(self._states[place.land.key], place.part)
            if ovality is not None:
                mean_cells = self._column["mean"]
                terms = [cell_span(each[0].first, each[-1].last, mean_cells) for each in places if len(each) > 1]
                apart = _of("MAX", [f"MAX({each})-MIN({each})" for each in terms])
                yield f"ovality_{place.part}", LiveCell("um", ovality * UM, f"({apart})*1000")

    def _spread(self, place: _Place) -> Iterable[tuple[str, LiveCell]]:
        """Return the degrees of freedom and the squares of a place with repeats; see `uncertainty.sources`."""
        off, diameters = self._rows(place)("off"), [each.diameter * UM for each in place.own]
        mean, apart = fmean(diameters), max(diameters) - min(diameters)
        limited = min(REPEAT_TOLERANCE * UM / apart, 1.0) if apart else 1.0
        yield "degrees", LiveCell("count", len(diameters) - 1, f"MAX(COUNT({off})-1,0)")
        squares = sum((each - mean) ** 2 for each in diameters) * limited**2
        far = f"MAX({off})-MIN({off})"
        text = f"SUMSQ({off})*IF({far}>{REPEATS_APART},({REPEATS_APART}/({far}))^2,1)"
        yield "squares", LiveCell("um", squares, text)

    def _here(self, row: int) -> Callable[[str], str]:
        return lambda key: address(row, self._column[key])

    def _rows(self, place: _Place) -> Callable[[str], str]:
        return lambda key: cell_span(place.first, place.last, self._column[key])


def _ovality(land: LandDiagnosis, part: Part) -> float | None:
    return land.state.spool_ovality if part == "spool" else land.state.sleeve_ovality


def _order(reading: Reading, land: Land | None, lands: dict[LandKey, int]) -> tuple[Any, ...]:
    place = lands[land.key] if land else len(lands)
    plane = land.planes.index(reading.plane) if land else 0
    direction = -1.0 if reading.direction is None else reading.direction
    return place, PARTS.index(reading.part), plane, direction, reading.repeat


def _average(stretches: Sequence[str]) -> str | None:
    """Return the formula of a mean of means over stretches of cells."""
    return _of("AVERAGE", [f"AVERAGE({each})" for each in stretches]) if stretches else None


def _of(function: str, terms: Sequence[str | None]) -> str:
    known = [term for term in terms if term is not None]
    return known[0] if len(known) == 1 else f"{function}({','.join(known)})"


DIRECTIONS_SHEET = Sentence("Directions")


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

        def diameter(part: Part) -> Callable[[_Line, LiveCells], str]:
            def formula(line: _Line, _: LiveCells) -> str:
                key = line.land.key
                there = live.readings.at(key, part, line.station, live.of_land(key, EXPANSIONS[part]))
                return there or live.of_land(key, part)

            return formula

        def off(line: _Line, here: LiveCells) -> str:
            rows, place = self.rows[line.land.key], self.sheet.place
            clearances, weights = (cell_span(*rows, place[key]) for key in ("c", "weight"))
            return f"{here['c']}-SUMPRODUCT({clearances},{weights})"

        weight = Sentence("weight: directions of a plane alike, planes alike")
        # fmt: off
        columns = (
            LiveColumn("component", Sentence("component"), value=lambda line: line.land.key[0],
                       width=component_width(live.diagnosis.controller.components)),
            LiveColumn("land", Sentence("land"), value=lambda line: line.land.key[1], width=14),
            LiveColumn("plane", Sentence("plane"), value=lambda line: line.station.plane, width=14),
            LiveColumn("direction", Sentence("direction [°]"), value=lambda line: line.station.direction, width=14),
            LiveColumn("sleeve", Sentence("sleeve diameter [{unit}]", unit=LENGTH), "mm",
                       lambda line: line.station.sleeve_diameter, diameter("sleeve"), MM, 14),
            LiveColumn("spool", Sentence("spool diameter [{unit}]", unit=LENGTH), "mm",
                       lambda line: line.station.spool_diameter, diameter("spool"), MM, 14),
            LiveColumn("c", Sentence("radial clearance c [{unit}]", unit=CLEARANCE), "um",
                       lambda line: line.station.radial_clearance, "({sleeve}-{spool})/2*1000", UM, 14),
            LiveColumn("weight", weight, value=lambda line: line.weight, width=14),
            LiveColumn("off", Sentence("c − mean of the land [{unit}]", unit=CLEARANCE), "um", lambda line: line.off,
                       off, width=14),
            LiveColumn("m2", Sentence("weight · (c − mean)² [{unit}]", unit=UnitOf("clearance_squared")), "um",
                       lambda line: line.weight * line.off**2, "{weight}*{off}^2", width=14),
            LiveColumn("m3", Sentence("weight · (c − mean)³ [{unit}]", unit=UnitOf("clearance_cubed")), "um",
                       lambda line: line.weight * line.off**3, "{weight}*{off}^3", width=14),
        )
        # fmt: on
        self.sheet = LiveSheet(live.say.sentence(DIRECTIONS_SHEET), columns, lines)

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
