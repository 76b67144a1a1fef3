"""The workbook's uncertainty budgets: atleak's own numbers, which follow readings and instruments."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import openpyxl
import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.controller_tables import NewOrigin
from atleak.catalogue.instruments import Instruments, load_instruments
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.uncertainty.results import MOST_BUDGETS, combined, effective_degrees, every_line
from atleak.diagnosis.uncertainty.sources import OF_A_DIAMETER, SLOPES
from atleak.measurements.readings import Readings
from atleak.report.xlsx import write_workbook
from atleak.report.xlsx.book import NUMBER_FORMATS
from tests.unit.conftest import worn_readings

UM = 1e-6
SHEET = "Uncertainty budget"
WHOLE = ("combined standard", "effective degrees", "coverage factor", "expanded")
Value = Callable[[str, str], Any]


@dataclass(frozen=True)
class Job:
    """What a diagnosis is made from, as far as it changes here."""

    found: Diagnosis
    readings: Readings
    instruments: Instruments

    def again(self, readings: Readings, instruments: Instruments | None = None) -> Diagnosis:
        found = self.found
        return diagnose(
            found.controller,
            found.fluid,
            found.limits,
            readings=readings,
            instruments=instruments or self.instruments,
        )


@pytest.fixture(scope="module")
def few_lands(hipol, limits) -> Diagnosis:
    """A small valve body, worn, with two directions and two repeats of every land but the last."""
    controller = load_controller("minimal_example")
    lands = (replace(each, mounting_tolerance=2 * UM, new_origin=NewOrigin.TYPE) for each in controller.lands)
    controller = replace(controller, lands=tuple(lands))
    return diagnose(controller, hipol, limits, readings=worn_readings(controller))


def by_diameters_of(found: Diagnosis) -> Job:
    """Diameters that repeat within a step, by two instruments."""
    instruments = load_instruments()
    return Job(found, found.readings, instruments)


def by_coordinates_of(found: Diagnosis) -> Job:
    """Coordinates, every fifth pair only swapped and no bore in two directions, by one instrument for both parts."""
    taken = []
    for number, reading in enumerate(found.readings.readings):
        start = 3e-3 + 7 * UM * (number % 3)
        coordinates = (start, start + reading.diameter)
        if reading.repeat == 2 and number % 5 == 1:
            first, second = taken[-1].coordinates
            coordinates = second, first
        if reading.part == "spool" or reading.direction == 0.0:
            diameter = abs(coordinates[0] - coordinates[1])
            taken.append(replace(reading, coordinates=coordinates, diameter=diameter))
    readings = replace(found.readings, readings=tuple(taken))
    instruments = load_instruments("workshop_microscope", "workshop_microscope")
    job = Job(found, readings, instruments)
    return replace(job, found=job.again(readings))


@pytest.fixture(scope="module")
def by_diameters(few_lands) -> Job:
    return by_diameters_of(few_lands)


@pytest.fixture(scope="module")
def by_coordinates(few_lands) -> Job:
    return by_coordinates_of(few_lands)


def blocks(book: openpyxl.Workbook) -> dict[str, dict[str, str]]:
    """Of each land the cells of its budget: by source that of its contribution, by words those of the whole."""
    found: dict[str, dict[str, str]] = {}
    title = ""
    for row in book[SHEET].iter_rows(max_col=8):
        label, last = row[0].value, row[7]
        if row[5].value == "c_r [µm]":
            title = str(label).split()[0]
            found[title] = {"c_r": row[6].coordinate}
        elif title and label is not None and (last.data_type == "f" or str(label).startswith(WHOLE)):
            found[title][str(label)] = row[6].coordinate
    return found


def expected(found: Diagnosis, key: str) -> dict[str, float]:
    """What atleak says of a land, by the same words."""
    land = next(land for land in found.lands if f"{land.key[0]}/{land.key[1]}" == key)
    lines = every_line(land.uncertainty.sources)
    u, k, say = combined(lines), 1.959963984540054, wording("en")
    assert u == pytest.approx(land.uncertainty.u_clearance, rel=1e-12, abs=0.0)
    of_lines = {say.get("uncertainty_sources", line.source.label): abs(line.contribution) / UM for line in lines}
    whole = (u / UM, effective_degrees(lines), k, k * u / UM)
    return {**of_lines, **dict(zip(WHOLE, whole, strict=True)), "c_r": land.state.radial_clearance / UM}


def off(book: openpyxl.Workbook, value: Value, found: Diagnosis) -> list[Any]:
    """The cells of the budgets that do not hold what atleak says."""
    wrong = []
    for key, cells in blocks(book).items():
        wanted = expected(found, key)
        for label, at in cells.items():
            name = next((each for each in WHOLE if label.startswith(each)), label)
            number = value(SHEET, at)
            number = float("inf") if number == "∞" else number
            if number != pytest.approx(wanted.pop(name), rel=1e-9, abs=1e-12):
                wrong.append((key, label, number))
        wrong += [(key, label) for label in wanted]
    return wrong


def cached(content: bytes) -> Value:
    book = openpyxl.load_workbook(io.BytesIO(content), data_only=True)
    return lambda sheet, at: book[sheet][at].value


def column(book: openpyxl.Workbook, heading: str) -> int:
    (number,) = (cell.column for cell in book["Readings"][1] if cell.value == heading)
    return int(number)


def set_name(book: openpyxl.Workbook, name: str, number: float) -> None:
    sheet, _, address = book.defined_names[name].attr_text.rpartition("!")
    cell = book[sheet.strip("'")][address.replace("$", "")]
    assert not cell.protection.locked
    cell.value = number


# --- changes, each made in the workbook and in what atleak starts from


def other_instruments(job: Job, book: openpyxl.Workbook) -> Diagnosis:
    """A worse calibration and a coarser step."""
    set_name(book, "spool_calibration", 2.5)
    set_name(book, "spool_resolution", 4.0)
    changed = replace(job.instruments.spool, calibration=2.5 * UM, resolution=4.0 * UM)
    if job.instruments.spool == job.instruments.sleeve:
        return job.again(job.readings, Instruments(changed, changed))
    set_name(book, "sleeve_common_part", 0.25)
    set_name(book, "sleeve_repeatability", 3.0)
    sleeve = replace(job.instruments.sleeve, common_part=0.25, repeatability=3.0 * UM)
    return job.again(job.readings, Instruments(changed, sleeve))


def wider_readings(job: Job, book: openpyxl.Workbook) -> Diagnosis:
    """Four readings of one flagged land by 3, 5, 11 and 20 µm more: a slip among them, and a form."""
    component = job.found.flagged[0].key[0]
    places = [each.place for each in job.readings.readings if each.component == component and each.part == "sleeve"][:4]
    more = dict(zip(places, (3.0, 5.0, 11.0, 20.0), strict=False))
    by_coordinate = job.readings.readings[0].coordinates is not None
    heads = {name: column(book, name) for name in ("row", "column", "sheet", "diameter [mm]", "coordinate 2 [mm]")}
    for row in book["Readings"].iter_rows(min_row=2):
        for place, step in more.items():
            at = (row[heads["sheet"] - 1].value, row[heads["row"] - 1].value, row[heads["column"] - 1].value)
            if at == (place.sheet, place.row, place.column):
                cell = row[heads["coordinate 2 [mm]" if by_coordinate else "diameter [mm]"] - 1]
                sign = -1.0 if by_coordinate and row[heads["coordinate 2 [mm]"] - 2].value > cell.value else 1.0
                cell.value += sign * step * 1e-3

    def changed(reading: Any) -> Any:
        step = more.get(reading.place, 0.0) * UM
        if not step or reading.coordinates is None:
            return replace(reading, diameter=reading.diameter + step)
        first, second = reading.coordinates
        second += -step if first > second else step
        return replace(reading, coordinates=(first, second), diameter=abs(first - second))

    found = job.again(replace(job.readings, readings=tuple(map(changed, job.readings.readings))))
    choose_what_counts(book, found)
    return found


def choose_what_counts(book: openpyxl.Workbook, found: Diagnosis) -> None:
    """Take over which readings atleak leaves out as slips: the choice of the workbook's reader."""
    again = openpyxl.load_workbook(io.BytesIO(write_workbook(found)), data_only=True)
    number = column(book, "counts in the mean: yes or no")
    for before, after in zip(
        book["Readings"].iter_rows(min_row=2), again["Readings"].iter_rows(min_row=2), strict=True
    ):
        if before[number - 1].value != after[number - 1].value:
            assert not before[number - 1].protection.locked
            before[number - 1].value = after[number - 1].value


CHANGES = (other_instruments, wider_readings)


# --- tests


def test_budgets_hold_what_atleak_says_of_each_source(by_diameters):
    job = by_diameters
    content = write_workbook(job.found)
    book = openpyxl.load_workbook(io.BytesIO(content))
    flagged = [f"{land.key[0]}/{land.key[1]}" for land in job.found.flagged][:MOST_BUDGETS]
    assert list(blocks(book)) == flagged
    assert off(book, cached(content), job.found) == []


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
def test_a_changed_instrument_or_reading_reaches_the_budget(by_coordinates, calculator, change):
    job = by_coordinates
    sheets = calculator(write_workbook(job.found))
    after = change(job, sheets.book)
    assert off(sheets.book, sheets.value, after) == []
    assert off(sheets.book, sheets.value, job.found)


@pytest.mark.slow  # each time, the calculator says the same
@pytest.mark.parametrize("job_of", [by_diameters_of, by_coordinates_of])
def test_libreoffice_follows_instruments_and_readings_into_every_budget(worn, job_of, recalculated):
    job = job_of(replace(worn, road=None, log=None))
    book = openpyxl.load_workbook(io.BytesIO(write_workbook(job.found)))
    for change in CHANGES:
        after = change(job, book)
        job = replace(job, instruments=after.uncertainty.instruments)
    assert off(book, recalculated(book), after) == []


def test_a_changed_coordinate_reaches_lands_headline_and_budget(by_coordinates, calculator):
    sheets = calculator(write_workbook(by_coordinates.found))
    (_, cells), *_ = blocks(sheets.book).items()
    (u,) = (at for label, at in cells.items() if label.startswith("combined"))
    component = by_coordinates.found.flagged[0].key[0]
    second = column(sheets.book, "coordinate 2 [mm]")

    def shown() -> list[Any]:
        return [sheets.value(SHEET, u), sheets.value(SHEET, cells["c_r"]), sheets.value("Summary", "B6")]

    before = shown()
    for row in sheets.book["Readings"].iter_rows(min_row=2):
        if row[0].value == component and row[2].value == "sleeve":
            cell = row[second - 1]
            cell.value += 0.5 if cell.value > row[second - 2].value else -0.5
    sheets.known.clear()
    assert all(new != old for new, old in zip(shown(), before, strict=True))


def test_a_slip_left_out_is_marked_and_counts_again_when_chosen(by_diameters, calculator):
    """The mean on the sheet is atleak's, which leaves a slip out; until now the sheet took all readings."""
    readings = by_diameters.readings
    first = readings.readings[0]
    three = [replace(first, repeat=3, diameter=first.diameter + step * UM) for step in (1.0, 40.0)]
    found = by_diameters.again(replace(readings, readings=(*readings.readings, *three)))
    sheets = calculator(write_workbook(found))
    counts = column(sheets.book, "counts in the mean: yes or no")
    rows = [row for row in sheets.book["Readings"].iter_rows(min_row=2) if row[counts - 1].value == "no"]
    assert len(rows) == 1
    (spool,) = (cell.column_letter for cell in sheets.book["Lands"][1] if str(cell.value).startswith("spool diameter"))
    before = sheets.value("Lands", f"{spool}2")
    assert before == pytest.approx(found.lands[0].state.spool_diameter * 1e3, abs=1e-12)
    sheets.set("Readings", rows[0][counts - 1].coordinate, "yes")
    assert sheets.value("Lands", f"{spool}2") > before + 0.001


@pytest.fixture(scope="module")
def with_other_temperatures(by_coordinates) -> Any:
    """The sheet of budgets, where temperatures are shown with three decimals."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(NUMBER_FORMATS, "temperature", "0.000")
        return openpyxl.load_workbook(io.BytesIO(write_workbook(by_coordinates.found)))[SHEET]


def test_degrees_of_freedom_are_no_temperature(with_other_temperatures):
    rows = [row for row in with_other_temperatures.iter_rows() if str(row[0].value).startswith(WHOLE[1])]
    assert {row[6].number_format for row in rows} == {"0.0"}


def test_the_slope_of_an_error_is_that_with_which_it_was_collected(with_other_temperatures, by_diameters):
    assert SLOPES == {"spool": -OF_A_DIAMETER, "sleeve": OF_A_DIAMETER}
    for line in every_line(by_diameters.found.flagged[0].uncertainty.sources):
        if line.input_kind == "diameter" and line.input_uncertainty:
            common = line.source.kind == "common calibration"
            assert line.sensitivity == pytest.approx(
                SLOPES[line.source.part] if common else OF_A_DIAMETER, rel=1e-15, abs=0.0
            )
    slopes = {row[5].value for row in with_other_temperatures.iter_rows() if row[0].value == "sleeve: calibration"}
    assert slopes == {OF_A_DIAMETER}
