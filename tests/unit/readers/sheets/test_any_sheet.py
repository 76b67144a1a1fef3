"""Changes to a sheet that must not change its readings do not change them."""

from __future__ import annotations

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.common.errors import ReadingsError
from atleak.measurements.clearances import clearances
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.sheets.measuring_sheet import write_readings
from tests.unit.conftest import first_of

HEADINGS = ("component", "part", "plane", "direction", "repeat", "diameter")
PAIRS = (("6", "1", 9.939), ("6", "2", 9.942), ("8", "1", 10.0), ("8", "2", 10.0), ("12'", "1", 14.0))


@pytest.fixture(scope="module")
def controller(three_pairs):
    return three_pairs


@st.composite
def sheets(draw):
    """Draw rows of a sheet in mm: some planes, each with both parts, one or two directions, one to three repeats."""
    rows = []
    for component, plane, nominal in draw(st.lists(st.sampled_from(PAIRS), min_size=1, unique=True)):
        for part, low, high in (("spool", -20, 5), ("sleeve", 20, 120)):
            for direction in draw(st.sampled_from([(0,), (90,), (0, 90)])):
                for repeat in range(1, 1 + draw(st.integers(1, 3))):
                    thousandths = round(nominal * 1000) + draw(st.integers(low, high))
                    rows.append((component, part, plane, direction, repeat, thousandths))
    return rows


def as_text(
    rows, columns=HEADINGS, heading="diameter_mm", delimiter=";", number=lambda microns: f"{microns / 1000:.3f}"
):
    lines = [[heading if name == "diameter" else name for name in columns]]
    for row in rows:
        cells = dict(zip(HEADINGS, row, strict=True))
        cells["diameter"] = number(cells["diameter"])
        lines.append([str(cells[name]) for name in columns])
    return "\n".join(delimiter.join(line) for line in lines).encode()


def diameters(readings):
    return {(one.component, one.part, one.plane, one.direction, one.repeat): one.diameter for one in readings.readings}


@pytest.mark.parametrize(
    ("heading", "number"),
    first_of(
        [
            ("diameter [mm]", lambda microns: f"{microns / 1000:.3f}".replace(".", ",")),
            ("diameter [µm]", lambda microns: f"{microns}"),
            ("diameter_inch", lambda microns: repr(microns / 25400)),
            ("diameter", lambda microns: f"{microns / 1000:.3f} mm"),
            ("diameter", lambda microns: f"{microns / 25400!r} in"),
        ]
    ),
)
@given(rows=sheets())
def test_the_unit_and_the_decimal_sign_do_not_matter(controller, heading, number, rows):
    plain = diameters(read_readings(as_text(rows), controller))
    other = diameters(read_readings(as_text(rows, heading=heading, number=number), controller))
    assert plain.keys() == other.keys()
    for key, diameter in plain.items():
        assert math.isclose(other[key], diameter, rel_tol=1e-12)


@given(rows=sheets(), columns=st.permutations(HEADINGS), delimiter=st.sampled_from([",", ";", "\t"]))
def test_the_order_of_columns_does_not_matter(controller, rows, columns, delimiter):
    plain = read_readings(as_text(rows), controller)
    other = read_readings(as_text(rows, columns=columns, delimiter=delimiter), controller)
    assert diameters(other) == diameters(plain)


@given(data=st.data(), rows=sheets())
def test_the_order_of_rows_does_not_matter(controller, data, rows):
    plain = read_readings(as_text(rows), controller)
    other = read_readings(as_text(data.draw(st.permutations(rows))), controller)
    assert diameters(other) == diameters(plain)
    for one, two in zip(clearances(plain, controller), clearances(other, controller), strict=True):
        assert one.radial_clearance == two.radial_clearance
        assert (one.min_clearance, one.max_clearance) == (two.min_clearance, two.max_clearance)
        assert one.status == two.status


def mean(values):
    return sum(values) / len(values)


def counted(part, repeats):
    """Of repeats more than 5 µm apart: those on which most agree, else the widest with what agrees with it."""
    if max(repeats) - min(repeats) <= 5:
        return repeats
    ends = sorted(set(repeats), reverse=part == "sleeve")
    agreeing = [[each for each in repeats if 0 <= (each - end) * (1 if part == "spool" else -1) <= 5] for end in ends]
    most = [group for group in agreeing if 2 * len(group) > len(repeats)]
    return max(most or agreeing[:1], key=len)


@given(rows=sheets())
def test_clearances_are_means_of_means_in_thousandths(controller, rows):
    """Compare with means computed from whole micrometres: over repeats, then directions, then planes."""
    for gap in clearances(read_readings(as_text(rows), controller), controller):
        part_means = {}
        for part in ("spool", "sleeve"):
            planes = []
            for plane in gap.land.planes:
                mine = [row for row in rows if row[:3] == (gap.land.component, part, plane)]
                angles = sorted({row[3] for row in mine})
                if angles:
                    places = [[row[5] for row in mine if row[3] == angle] for angle in angles]
                    planes.append(mean([mean(counted(part, repeats)) for repeats in places]))
            if planes:
                part_means[part] = mean(planes)
        assert gap.measured == bool(part_means)
        if part_means:
            assert gap.spool_diameter == pytest.approx(part_means["spool"] * 1e-6, rel=1e-12, abs=0.0)
            assert gap.sleeve_diameter == pytest.approx(part_means["sleeve"] * 1e-6, rel=1e-12, abs=0.0)
            assert gap.radial_clearance == pytest.approx(
                (part_means["sleeve"] - part_means["spool"]) * 0.5e-6, rel=1e-9, abs=0.0
            )
            same_planes = all(
                len({row[3] for row in rows if row[:3] == (gap.land.component, part, plane)}) == 2
                for part in part_means
                for plane in gap.land.planes
            )
            if same_planes:
                assert gap.min_clearance - 1e-15 <= gap.radial_clearance <= gap.max_clearance + 1e-15


@given(rows=sheets(), blank_rows=st.booleans())
def test_a_sheet_that_is_written_reads_back(controller, rows, blank_rows):
    readings = read_readings(as_text(rows), controller)
    again = read_readings(write_readings(controller, readings.readings, blank_rows=blank_rows), controller)
    assert diameters(again).keys() == diameters(readings).keys()
    assert not [message for message in again.messages if message.code == "column_aside"]
    for key, diameter in diameters(readings).items():
        assert math.isclose(diameters(again)[key], diameter, rel_tol=1e-12)


WORDS = "spool;sleeve;x1;x2 [mm];diameter [mm];component;II;°;[mm];unit;mm;No.;repeat 1;#REF!;12'"
NUMBERS = "-1;0;1e999;nan;9,9;9.9.9;²;9939;0.391;99.39;9'939;9 939;½"
JUNK = st.sampled_from(["", *WORDS.split(";"), *NUMBERS.split(";")]) | st.text(max_size=5)


@given(rows=sheets(), changes=st.lists(st.tuples(st.integers(0, 20), st.integers(0, 6), JUNK), min_size=1, max_size=4))
def test_a_sheet_with_anything_in_it_is_read_or_refused_with_a_reason(controller, rows, changes):
    cells = [line.split(";") for line in as_text(rows).decode().splitlines()]
    for row, column, value in changes:
        line = cells[row % len(cells)]
        line += [""] * (column + 1 - len(line))
        line[column] = value
    data = "\n".join(";".join(line) for line in cells).encode("utf-8", "replace")
    readings, refusal = read_or_refuse(data, controller)
    if refusal is not None:
        assert refusal.place.file == "readings"
        assert refusal.problem
        assert str(refusal)
    else:
        assert all(0.004 < reading.diameter < 0.03 for reading in readings.readings)
        assert all(state.radial_clearance >= 0.0 for state in clearances(readings, controller))


def read_or_refuse(data, controller):
    try:
        return read_readings(data, controller), None
    except ReadingsError as refusal:
        return None, refusal


# --- no diameter is lost ------------------------------------------------------------------------------------------

SPECIFICATIONS = ("Nominal [mm]", "Soll-Ø", "Ø wg rysunku [mm]", "Target", "Max", "Diamètre théorique", "Номинал")
ANYTHING = (*SPECIFICATIONS, "Mean", "Remark", "Result [mm]", "Actual", "A", "", "Old [mm]", "Temperature", "Land", "x")
NEAR = st.builds(lambda pair, off: f"{pair[2] + off / 1000:.3f}", st.sampled_from(PAIRS), st.integers(-90, 90))
TITLES = st.sampled_from(("", "Limits", "Drawing values", "Calibration", "Pistons", "Summary", "Page 2"))
KEY_HEADINGS = st.lists(st.sampled_from(("component", "part", "plane", "Ring", "No.")), max_size=3, unique=True)
KEY_CELLS = {"component": "6", "part": "spool", "plane": "1", "Ring": "A3", "No.": "2"}


@st.composite
def further_tables(draw):
    """Draw lines of a table with numbers of the size of a diameter in it, with or without title, headings and keys."""
    keys, headings = draw(KEY_HEADINGS), draw(st.lists(st.sampled_from(ANYTHING), min_size=1, max_size=3))
    count = draw(st.integers(1, 3))
    lines = [[title] for title in [draw(TITLES)] if title]
    if draw(st.booleans()):
        lines.append([*keys, *headings])
    lines += [[*(KEY_CELLS[key] for key in keys), *(draw(NEAR) for _ in headings)] for _ in range(count)]
    return [*draw(st.sampled_from([[[]], []])), *lines, []]


def numbers_on(lines):
    return sum(bool(re.fullmatch(r"\d+\.\d{3}", cell)) for line in lines for cell in line)


def numbers_named(readings):
    """Count the numbers that messages name as left aside or not read."""
    texts = [message.text for message in readings.messages if message.code.endswith(("_aside", "not_read"))]
    more = sum(int(count) for text in texts for count in re.findall(r" and (\d+) more", text))
    return more + sum(len(re.findall(r"\(row \d+\)", text)) for text in texts)


def original(rows):
    return {(*row[:3], float(row[3]), row[4]): row[5] for row in rows}


def microns(readings):
    return {key: round(diameter * 1e6) for key, diameter in diameters(readings).items()}


@given(rows=sheets(), extra=further_tables(), where=st.sampled_from(["above", "below", "beside"]))
def test_no_number_of_another_table_is_lost(controller, rows, extra, where):
    lines = [line.split(";") for line in as_text(rows).decode().splitlines()]
    if where == "beside":
        blank = [""] * len(lines[0])
        longest = max(len(lines), len(extra))
        beside = zip(lines + [blank] * (longest - len(lines)), extra + [[]] * (longest - len(extra)), strict=True)
        lines = [[*left, "", *right] for left, right in beside]
    else:
        lines = [*extra, *lines] if where == "above" else [*lines, [], *extra]
    readings, refusal = read_or_refuse("\n".join(";".join(line) for line in lines).encode(), controller)
    if refusal is None:
        assert numbers_on(lines) == len(readings.readings) + numbers_named(readings)
        assert original(rows).items() <= microns(readings).items()


@given(data=st.data(), rows=sheets(), heading=st.sampled_from(ANYTHING), filled=st.integers(1, 100))
def test_no_number_of_another_column_is_lost(controller, data, rows, heading, filled):
    lines = [line.split(";") for line in as_text(rows).decode().splitlines()]
    at = data.draw(st.integers(0, len(lines[0])))
    lines[0].insert(at, heading)
    for index, line in enumerate(lines[1:]):
        line.insert(at, data.draw(NEAR) if index * filled % 100 < filled else "")
    readings, refusal = read_or_refuse("\n".join(";".join(line) for line in lines).encode(), controller)
    if refusal is None:
        assert numbers_on(lines) == len(readings.readings) + numbers_named(readings)
        assert microns(readings) == original(rows)


@given(data=st.data(), rows=sheets(), heading=st.sampled_from(SPECIFICATIONS))
def test_a_specification_is_never_the_measurement(controller, data, rows, heading):
    lines = [line.split(";") for line in as_text(rows, heading="Actual [mm]").decode().splitlines()]
    at = data.draw(st.integers(0, len(lines[0])))
    for line, cell in zip(lines, [heading, *(f"{round(row[5], -2) / 1000:.3f}" for row in rows)], strict=True):
        line.insert(at, cell)
    readings = read_readings("\n".join(";".join(line) for line in lines).encode(), controller)
    assert microns(readings) == original(rows)
    assert any(heading in message.text for message in readings.messages if message.code == "column_aside")


def test_the_forms_own_nominal_diameters_need_no_word_and_others_do(controller):
    lines = ["component;part;plane;diameter [mm];Nominal diameter [mm]", "12';piston;1;13.998;14.000"]
    text = "\n".join([*lines, "12';bore;1;14.075;14.070"])
    assert not [each for each in read_readings(text.encode(), controller).messages if each.code == "column_aside"]
    for other in (text.replace("14.070", "14.071"), text.replace("Nominal diameter", "Nominal")):
        messages = read_readings(other.encode(), controller).messages
        assert [each.level for each in messages if each.code == "column_aside"] == ["info"]
