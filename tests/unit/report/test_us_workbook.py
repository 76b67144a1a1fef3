"""The workbook in US units: every number is the metric one converted, and its formulas compute as ever."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterator
from functools import cache, reduce
from typing import Any

import openpyxl
import pytest

from atleak.common.units import SYSTEMS
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.report.xlsx import write_workbook
from tests.unit.conftest import first_of

METRIC, US = SYSTEMS["metric"], SYSTEMS["us"]
KINDS = [kind for kind in METRIC if METRIC[kind].name != US[kind].name]
SHOWN = {(METRIC[kind].name, US[kind].name): US[kind] for kind in reversed(KINDS)}  # a temperature before a difference
NAMES = {METRIC[kind].name for kind in METRIC}
NOT_US = {metric for metric, _ in SHOWN} | {"bar", "l/min"}
IN_BRACKETS = re.compile(r"\[([^\[\]]+)\]")


@pytest.fixture(scope="module")
def units(worn, minimal, readings_of, hipol, limits) -> list[Diagnosis]:
    """One with repeats and a road test, and one with circuits and a pump's slip."""
    worn_half = {
        land.key: (land.nominal_diameter, land.nominal_diameter + 3.0 * land.new_clearance) for land in minimal.lands
    }
    return [worn, diagnose(minimal, hipol, limits, readings=readings_of(minimal, worn_half))]


@pytest.fixture(scope="module")
def written(units) -> Callable[[int, str], bytes]:
    """The workbook of one of them in a system of units, written once."""
    return cache(lambda place, system: write_workbook(units[place], units=system))


def read(content: bytes, **kind: Any) -> openpyxl.Workbook:
    return openpyxl.load_workbook(io.BytesIO(content), **kind)


def numbers(sheet: Any) -> Iterator[tuple[Any, list[str]]]:
    """Give every cell with a number and the units that its row, its label and its heading name."""
    headings: dict[int, str] = {}  # the last text above, by column
    for row in sheet.iter_rows():
        labels: list[str] = []
        for cell in row:
            if isinstance(cell.value, int | float):
                beside = [str(sheet.cell(cell.row, column).value) for column in (2, 4, cell.column + 1)]
                named = [labels[-1] if labels else "", headings.get(cell.column, "")]
                yield cell, [*beside, *(unit for text in named for unit in IN_BRACKETS.findall(text))]
            elif isinstance(cell.value, str):
                labels.append(cell.value)
        headings |= {cell.column: cell.value for cell in row if isinstance(cell.value, str)}


def test_every_number_is_the_metric_one_in_the_unit_that_its_heading_names(written):
    for place in range(2):
        metric, us = (read(written(place, each), data_only=True) for each in ("metric", "us"))
        converted = 0
        for name in metric.sheetnames:
            for (cell, in_metric), (other, in_us) in zip(numbers(metric[name]), numbers(us[name]), strict=True):
                label = str(metric[name].cell(cell.row, 1).value)
                if label.startswith(("effective deg", "coverage factor")):
                    continue
                if (name, cell.column_letter) == ("Uncertainty budget", "F"):  # a sensitivity names no unit
                    continue
                pairs = zip(in_metric, in_us, strict=True)
                unit = next((SHOWN.get(pair) for pair in pairs if pair[0] in NAMES), None)
                expected = cell.value if unit is None else unit.shown(cell.value)
                off = 0.5 if unit is US["distance"] else 1e-12  # a mileage is in whole miles
                assert other.coordinate == cell.coordinate
                assert other.value == pytest.approx(expected, rel=1e-9, abs=off), (name, cell.coordinate)
                converted += unit is not None
        assert converted > 300


def test_a_metric_unit_stands_only_where_a_source_is_quoted(units, written):
    for place, diagnosis in enumerate(units):
        points, instruments = diagnosis.controller.operating_points, diagnosis.uncertainty.instruments
        quoted = [
            diagnosis.fluid.source,
            *(each.source for each in (*points, *diagnosis.controller.permissible, *diagnosis.limits.rules.values())),
            *(each.source for each in (instruments.spool, instruments.sleeve)),
            *(message.text for message in diagnosis.messages),
        ]
        quoted.sort(key=len, reverse=True)
        for sheet in read(written(place, "us"), read_only=True):
            for cell in (cell for row in sheet.iter_rows() for cell in row):
                if isinstance(cell.value, str) and not cell.value.startswith("="):
                    said = reduce(lambda text, source: text.replace(source, ""), quoted, cell.value)
                    assert not NOT_US & set(re.split(r"[\s\xa0()\[\],;:]+", said)), (sheet.title, said)


@pytest.mark.parametrize("units_of", first_of(["us", "metric_bar"]))
def test_every_formula_gives_its_cached_value(written, calculator, units_of):
    for place in range(2):
        assert calculator(written(place, units_of)).wrong() == []


def test_a_change_in_us_units_gives_what_the_same_change_gives_in_metric_ones(written, calculator):
    metric, us = (calculator(written(0, each)) for each in ("metric", "us"))
    for sheets, temperature, share in ((metric, 95.0, 3.0), (us, 203.0, 3.0)):
        for name, value in (("stated_T", temperature), ("limit_pair_share_watch", share)):
            sheet, address = sheets.book.defined_names[name].attr_text.split("!")
            sheets.set(sheet.strip("'"), address.replace("$", ""), value)
    for name in ("stated_nu", "stated_share", "stated_band", "hot_idle_share"):
        one, other = (sheets.value(*sheets.book.defined_names[name].attr_text.split("!")) for sheets in (metric, us))
        assert one == (other if isinstance(other, str) else pytest.approx(other, rel=1e-9, abs=0.0)), name


@pytest.mark.slow
def test_libreoffice_computes_the_workbook_in_us_units(written, recalculated, referee):
    cached, formulas = (read(written(0, "us"), data_only=each) for each in (True, False))
    assert referee.differing(formulas, recalculated(formulas), cached) == []


def test_a_limit_has_the_digits_of_its_source(written):
    sheet = read(written(1, "us"))["Limits"]
    shown = {
        f"{cell.value:.{len(cell.number_format.partition('.')[2])}f} psi"
        for row in sheet.iter_rows()
        for cell in row
        if "[psi]" in str(sheet.cell(cell.row, 1).value) and isinstance(cell.value, float)
    }
    assert shown == {"8 psi", "15 psi", "10 psi"}
