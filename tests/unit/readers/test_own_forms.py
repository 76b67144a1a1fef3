"""Forms that atleak wrote are known by their mark and read by the headings that they were given, with no guess."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import openpyxl
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import ReadingsError
from atleak.common.sentences import Sentence
from atleak.common.translations import languages
from atleak.common.units import SYSTEMS
from atleak.common.wording import wording
from atleak.job.kinds import TableKind, table_kind
from atleak.measurements.gauge_readings import Engine, GaugeCell, GaugeReading, PressureTable
from atleak.measurements.measuring_plan import PlanCell
from atleak.measurements.own_forms import MEASUREMENTS, OWN_FORMS, REPEATED, OwnForm
from atleak.measurements.readings import OwnLands, OwnLength, Reading, Readings
from atleak.readers.gauges import gauge_headings, gauge_study, value_table
from atleak.readers.gauges.gauge_study import read_study
from atleak.readers.gauges.gauge_table import read_pressure_table
from atleak.readers.gauges.typed_values import TypedFlows, TypedGauges, TypedTable, TypedVacuum
from atleak.readers.gauges.vacuum_table import read_vacuum_table
from atleak.readers.gauges.value_table import read_flow_table
from atleak.readers.own_forms import said_by_form
from atleak.readers.sheets import column_headings
from atleak.readers.sheets.column_headings import read_heading
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.readers.typed_sheet import Typed, written_sheet
from atleak.report.sheets.gauge_study_form import STUDY_HEADER, write_study_form
from atleak.report.sheets.measuring_columns import FormColumn
from atleak.report.sheets.measuring_head import MEASURING_HEADER
from atleak.report.sheets.measuring_sheet import write_readings, write_template
from tests.unit.conftest import by_turns

HEADER = MEASURING_HEADER + 1  # row of the headings as a spreadsheet counts
FORMS = Path(__file__).parent / "forms"  # filled in as `filled_in` does, written by an earlier atleak
EVERY = [(language, units) for language in languages() for units in SYSTEMS]
CHANGED = "own_form_changed"


@pytest.fixture(scope="module")
def unit() -> Controller:
    return load_controller("five_speed_2005")


@pytest.fixture
def no_guess(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever says what a heading may mean refuses to say it."""

    def guess(*given: object) -> None:
        raise AssertionError(f"guessed at {given}")

    monkeypatch.setattr(column_headings, "_read_heading", guess)
    monkeypatch.setattr(gauge_headings.GaugeWords, "_heading", guess)
    monkeypatch.setattr(gauge_headings, "_complete", guess)
    monkeypatch.setattr(gauge_study, "_at", guess)
    monkeypatch.setattr(value_table, "label_of", guess)


def measured(unit: Controller) -> list[Reading]:
    return [
        Reading(land.component, part, plane, angle, repeat, round(nominal + repeat * 1e-6, 6))
        for land in unit.lands[:5]
        for part, nominal in (("spool", land.nominal_diameter), ("sleeve", land.nominal_sleeve_diameter + 9e-6))
        for plane in land.planes
        for angle in (0.0, 90.0)
        for repeat in (1, 2)
    ]


def filled_in(unit: Controller, language: str = "en", units: str = "metric") -> bytes:
    """The measuring sheet with five lands measured, the lengths of two, and gauges at the line."""
    return _filled_in(unit.id, language, units)


@cache
def _filled_in(name: str, language: str, units: str) -> bytes:
    unit = load_controller(name)
    gauges = (
        GaugeReading(GaugeCell("D", Engine.SLOW_IDLE), 412e3),
        GaugeReading(GaugeCell("R", Engine.STALL), 912e3),
    )
    lengths = tuple(OwnLength(*land.key, land.contact_length + 1e-4, 5e-3) for land in unit.lands[:2])
    return write_readings(
        unit,
        measured(unit),
        pressures=PressureTable("", "", None, (), gauges),
        own_lands=OwnLands(lengths=lengths),
        language=language,
        units=units,
    )


def assert_same(read: Readings, unit: Controller, *, tabs: bool = True) -> None:
    """The same readings, up to what inches with five decimals leave of a micrometre."""
    found, wanted = (
        {(*each.station, each.repeat): each.diameter for each in all_} for all_ in (read.readings, measured(unit))
    )
    assert found == pytest.approx(wanted, rel=0.0, abs=0.2e-6)
    if tabs:
        assert read.pressures is not None
        assert [(each.cell, round(each.pressure, -1)) for each in read.pressures.readings] == [
            (GaugeCell("R", Engine.STALL), 912e3),
            (GaugeCell("D", Engine.SLOW_IDLE), 412e3),
        ]
        assert [(each.key, round(each.position or 0.0, 6)) for each in read.own_lands.lengths] == [
            (land.key, 5e-3) for land in unit.lands[:2]
        ]


def changed(data: bytes, change: Callable[[Any], object], title: str | None = None) -> bytes:
    """The workbook with one of its sheets changed, saved by another program."""
    book = openpyxl.load_workbook(io.BytesIO(data))
    change(book[title] if title else book.worksheets[0])
    target = io.BytesIO()
    book.save(target)
    return target.getvalue()


def codes(read: Readings) -> list[str]:
    return [message.code for message in read.messages]


# --- each form, filled in ---------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("no_guess")
@pytest.mark.parametrize(("language", "units"), EVERY)
def test_a_measuring_sheet_is_read_without_a_guess(unit: Controller, language: str, units: str) -> None:
    read = read_readings(filled_in(unit, language, units), unit)
    assert_same(read, unit)
    assert CHANGED not in codes(read)
    assert_same(read_readings(changed(filled_in(unit, language, units), lambda _: None), unit), unit)


@pytest.mark.slow
@pytest.mark.parametrize(("form", "kind"), by_turns(EVERY, ("xlsx", "ods", "csv")))
def test_a_measuring_sheet_that_libreoffice_saved_is_read_without_a_guess(
    unit: Controller, form: tuple[str, str], kind: str, tmp_path: Path, convert: Any, no_guess: None
) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    (folder / "sheet.xlsx").write_bytes(filled_in(unit, *form))
    if kind == "xlsx":
        convert(folder / "sheet.xlsx", "ods")
        (folder / "sheet.xlsx").unlink()
        convert(folder / "sheet.ods", "xlsx")
    else:
        convert(folder / "sheet.xlsx", kind if kind == "ods" else "csv:Text - txt - csv (StarCalc):44,34,76,1")
    assert_same(read_readings(folder / f"sheet.{kind}", unit), unit, tabs=kind != "csv")


@pytest.mark.usefixtures("no_guess")
def test_what_was_typed_is_read_without_a_guess(unit: Controller) -> None:
    cells = {PlanCell(*each.station, each.repeat): each for each in measured(unit)}
    typed = Typed().fill({cell: f"{each.diameter * 1e3:.4f}" for cell, each in cells.items()})
    lengths = (OwnLength(*unit.lands[0].key, unit.lands[0].contact_length + 1e-4, None),)
    sheet = Readings("", "", None, "mm", False, "tidy", (), own_lands=OwnLands(lengths=lengths))
    content = written_sheet(replace(typed, sheet=sheet), list(cells), unit)
    assert content is not None
    read = read_readings(content, unit)
    assert_same(read, unit, tabs=False)
    assert [each.key for each in read.own_lands.lengths] == [unit.lands[0].key]


@pytest.mark.parametrize(
    ("typed", "read", "kind"),
    [
        (
            TypedGauges({GaugeCell("D", Engine.STALL): "912"}, temperature="80"),
            lambda data, unit: [(each.pressure, each.temperature) for each in read_pressure_table(data, unit).readings],
            TableKind.PRESSURES,
        ),
        (
            TypedFlows({("hot_idle", "cooler"): "3"}),
            lambda data, unit: [round(each.flow * 60e3, 6) for each in read_flow_table(data, unit).readings],
            TableKind.FLOWS,
        ),
        (
            TypedVacuum({("8/1", "worn"): "17.5"}, supply="25"),
            lambda data, unit: [each.vacuum for each in read_vacuum_table(data, unit).readings],
            TableKind.VACUUM,
        ),
    ],
)
def test_a_typed_table_bears_its_mark_and_one_without_is_read_alike(
    typed: TypedTable, read: Callable[..., list[object]], kind: TableKind
) -> None:
    unit = load_controller("four_speed_2023")
    content = typed.written()
    assert content is not None
    mark, _, without = content.partition(b"\r\n")
    assert OWN_FORMS[mark.decode()] == typed.form
    assert read(content, unit) == read(without, unit) != []
    assert table_kind(content, unit) == table_kind(without, unit) == kind
    assert type(typed).read(content) == type(typed).read(without) == typed


@pytest.mark.usefixtures("no_guess")
def test_gauges_that_were_typed_are_read_without_a_guess(monkeypatch: pytest.MonkeyPatch) -> None:
    unit = load_controller("four_speed_2023")
    monkeypatch.undo()
    monkeypatch.setattr(gauge_headings, "_complete", None)
    content = TypedGauges({GaugeCell("D", Engine.FAST_IDLE): "600"}, fast_idle="1200").written()
    (reading,) = read_pressure_table(content or b"", unit).readings
    assert (reading.pressure, reading.engine_speed) == pytest.approx((600e3, 20.0), abs=1e-6)


@pytest.mark.usefixtures("no_guess")
@pytest.mark.parametrize("language", languages())
def test_a_gauge_study_is_read_without_a_guess(language: str) -> None:
    def fill(sheet: Any) -> None:
        for row in range(STUDY_HEADER + 2, sheet.max_row + 1):
            sheet.cell(row, 4).value = 12.0 + row * 1e-4

    study = read_study(changed(write_study_form(3, 2, 2, wording(language)), fill))
    assert study.values.shape == (3, 2, 2)
    assert study.values.min() == pytest.approx(0.0120007, abs=1e-9)


def test_a_temperature_on_a_form_in_fahrenheit_is_read_in_fahrenheit(unit: Controller) -> None:
    def fill(sheet: Any) -> None:
        sheet["C4"] = 176

    read = read_readings(changed(filled_in(unit, units="us"), fill, "Pressures"), unit)
    assert read.pressures is not None
    assert {each.temperature for each in read.pressures.readings} == {80.0}


@pytest.mark.parametrize(("language", "units"), EVERY)
def test_the_headings_are_understood_as_those_of_any_other_sheet(language: str, units: str) -> None:
    """A form without its mark is read by its headings, to which the form says the same."""
    say = wording(language, units)
    for column in FormColumn:
        assert said_by_form(MEASUREMENTS, column.said(say)) == column.holds
        guessed = read_heading(column.said(say))
        holds, repeat = REPEATED.get(column.holds, (column.holds, None))
        if holds in ("component", "part", "plane", "direction", "diameter", "coordinate 1", "coordinate 2"):
            assert guessed is not None
            assert (guessed.role, guessed.repeat) == (holds.partition(" ")[0], repeat)


@pytest.mark.parametrize("form", OWN_FORMS.values(), ids=lambda form: form.mark)
def test_no_heading_says_two_things(form: OwnForm) -> None:
    for language in languages():
        said = [" ".join(wording(language).sentence(text).split()) for text in form.headings.values()]
        assert len(set(said)) == len(said)
        keys = dict(zip(said, form.headings, strict=True))
        assert {key: said_by_form(form, text) for text, key in keys.items()} == {key: key for key in form.headings}


# --- changed by whoever fills it in -----------------------------------------------------------------------------------


def told(read: Readings) -> str:
    (message,) = [message.text for message in read.messages if message.code == CHANGED]
    return message


def mark_of(sheet: Any) -> Any:
    return next(cell for row in sheet.iter_rows() for cell in row if cell.value in OWN_FORMS)


@pytest.mark.parametrize("title", [None, "Lands", "Pressures"])
def test_a_damaged_mark_is_told_and_the_sheet_read_as_any_other(unit: Controller, title: str | None) -> None:
    def damage(sheet: Any) -> None:
        mark_of(sheet).value += " 2"

    read = read_readings(changed(filled_in(unit), damage, title), unit)
    assert_same(read, unit)
    told = [*read.messages, *(read.pressures.messages if read.pressures else ())]
    assert [message.text for message in told if message.code == CHANGED] == [
        Sentence("this sheet was a form of atleak's, but {why}: it is read as any other one").of(
            why="its mark was changed"
        )
    ]


def test_a_form_without_a_mark_is_read_as_ever(unit: Controller) -> None:
    def unmark(sheet: Any) -> None:
        mark_of(sheet).value = None

    read = read_readings(changed(filled_in(unit), unmark), unit)
    assert_same(read, unit)
    assert CHANGED not in codes(read)


@pytest.mark.usefixtures("no_guess")
@pytest.mark.parametrize(
    "change",
    [
        lambda sheet: sheet.insert_rows(1, 2),
        lambda sheet: sheet.insert_cols(1),
        lambda sheet: sheet.insert_cols(6),
        lambda sheet: sheet.move_range("K8:K400", cols=9),
        lambda sheet: sheet.cell(HEADER, 19, "Remark") and sheet.cell(HEADER + 1, 19, "scratched"),
    ],
    ids=["rows above", "column before", "column between", "column moved", "remarks"],
)
def test_rows_and_columns_that_were_put_in_or_moved_change_nothing(unit: Controller, change: Any) -> None:
    def unmerge(sheet: Any) -> None:  # whose cells openpyxl does not move along
        for cells in list(sheet.merged_cells.ranges):
            top = sheet.cell(cells.min_row, cells.min_col).value
            sheet.unmerge_cells(str(cells))
            for row in range(cells.min_row, cells.max_row + 1):
                sheet.cell(row, cells.min_col).value = top
        change(sheet)

    assert_same(read_readings(changed(filled_in(unit), unmerge), unit), unit)


def test_a_row_that_was_deleted_is_both_its_readings_less(unit: Controller) -> None:
    data = write_readings(unit, measured(unit), blank_rows=False)
    rows = list(csv.reader(io.StringIO(as_csv(data))))
    del rows[HEADER + 1]
    target = io.StringIO()
    csv.writer(target).writerows(rows)
    read = read_readings(target.getvalue().encode(), unit)
    assert len(read.readings) == len(measured(unit)) - 2  # of both repeats


def test_a_column_of_numbers_that_was_added_is_read_by_its_heading(unit: Controller) -> None:
    def add(sheet: Any) -> None:
        sheet.cell(HEADER, 8).value = "Spool [mm]"
        sheet.cell(HEADER, 11).value = "Spool diameter [mm]"

    def add_beside(sheet: Any) -> None:
        sheet.cell(HEADER, 19, "Temperature")
        sheet.cell(HEADER + 1, 19, 21.5)

    read = read_readings(changed(filled_in(unit), add_beside), unit)
    assert_same(read, unit)
    assert "columns were added (S)" in told(read)
    with pytest.raises(ReadingsError, match=r"'Spool \[mm\]' and 'Spool diameter \[mm\]'.*\n.*headings were changed"):
        read_readings(changed(filled_in(unit), add), unit)


@pytest.mark.usefixtures("no_guess")
def test_a_third_repeat_has_columns_of_its_own(unit: Controller) -> None:
    land = unit.lands[0]

    def add(sheet: Any) -> None:
        sheet.cell(HEADER, 20, "Diameter 3 [mm]")
        sheet.cell(HEADER + 1, 20, round(land.nominal_diameter * 1e3 + 0.004, 4))

    third = Reading(land.component, "spool", land.planes[0], 0.0, 3, round(land.nominal_diameter + 4e-6, 7))
    typed = read_readings(changed(filled_in(unit), add), unit)
    written = read_readings(write_readings(unit, [*measured(unit), third]), unit)
    for read in (typed, written):
        assert CHANGED not in codes(read)
        assert len(read.readings) == len(measured(unit)) + 1
        (found,) = [each for each in read.readings if each.repeat == 3]
        assert (found.station, found.diameter) == (third.station, pytest.approx(third.diameter, abs=1e-10))


@pytest.mark.usefixtures("no_guess")
@pytest.mark.parametrize("language", languages())
def test_a_sheet_of_atleak_0_2_with_a_row_for_every_repeat_is_read_without_a_guess(
    unit: Controller, language: str
) -> None:
    read = read_readings((FORMS / f"measuring_sheet_0_2_{language}.xlsx").read_bytes(), unit)
    assert_same(read, unit)
    assert CHANGED not in codes(read)


def test_headings_that_were_deleted_are_told(unit: Controller) -> None:
    with pytest.raises(ReadingsError):
        read_readings(changed(filled_in(unit), lambda sheet: sheet.delete_rows(HEADER)), unit)


def test_an_empty_form_is_told(unit: Controller) -> None:
    with pytest.raises(ReadingsError, match="no readings are filled in"):
        read_readings(write_template(unit), unit)


def test_a_form_for_another_valve_body_is_refused(unit: Controller) -> None:
    with pytest.raises(ReadingsError, match=f"made for controller {unit.id}, not for minimal_example"):
        read_readings(filled_in(unit), load_controller("minimal_example"))


def as_csv(data: bytes, delimiter: str = ",", decimal: str = ".") -> str:
    """The first sheet as a spreadsheet program saves it as text; only the first of merged cells keeps its value."""
    rows = openpyxl.load_workbook(io.BytesIO(data)).worksheets[0].iter_rows(values_only=True)
    target = io.StringIO()
    writer = csv.writer(target, delimiter=delimiter)
    for row in rows:
        cells = ("" if cell is None or str(cell).startswith("=") else cell for cell in row)
        writer.writerow(
            f"{cell:.10g}".replace(".", decimal) if isinstance(cell, int | float) else str(cell) for cell in cells
        )
    return target.getvalue()


@pytest.mark.usefixtures("no_guess")
@pytest.mark.parametrize(("form", "text"), by_turns(EVERY, [(",", "."), (";", ","), ("\t", ","), (",", ",")]))
def test_a_form_saved_as_text_is_read_without_a_guess(
    unit: Controller, form: tuple[str, str], text: tuple[str, str]
) -> None:
    data = as_csv(filled_in(unit, *form), *text).encode("utf-8-sig")
    assert_same(read_readings(data, unit), unit, tabs=False)
    assert table_kind(data, unit) == TableKind.READINGS


def test_decimal_commas_that_part_the_cells_are_refused(unit: Controller) -> None:
    bare = re.sub(r'"(\d+,\d+)"', r"\1", as_csv(filled_in(unit), ",", ","))
    with pytest.raises(ReadingsError, match="another nominal diameter than that stands here"):
        read_readings(bare.encode(), unit)
