"""A small file cannot keep the program busy: what is far more than people fill in is refused before it is read."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from contextlib import suppress

import pytest

from atleak.catalogue.controller import Controller
from atleak.common.errors import AtleakError, ReadingsError
from atleak.job.kinds import TableKind, table_kind
from atleak.readers.cells import extent
from atleak.readers.gauges.gauge_study import read_study
from atleak.readers.gauges.gauge_table import read_pressure_table
from atleak.readers.logs import log_columns, understand
from atleak.readers.sheets.measuring_sheet import read_readings
from tests.effort import in_time, most_calls

ENOUGH = 20_000_000  # calls
HEADS = {
    "sheet": ["component", "part", "plane", "direction", "diameter [mm]"],
    "gauges": ["range", "slow idle [kPa]", "stall [kPa]"],
    "study": ["part", "operator", "trial", "reading [mm]"],
    "log": ["Time (s)", "Engine RPM", "Line Pressure (kPa)"],
}
ROWS = {
    "sheet": [["8", "spool", "I", "0", "15.98"]] * 3,
    "gauges": [["P", "500", ""], ["D", "500", "1300"]],
    "study": [[part, operator, "1", "16.01"] for part in "123" for operator in "AB"],
    "log": [[f"{row * 0.1:.1f}", str(900 + row), "500"] for row in range(30)],
}
WEIRD = {
    "1000 commas": "Speed" + "," * 1000,
    "20 000 blanks": "Speed" + " " * 20_000 + "x",
    "20 000 strokes": "/" * 20_000,
    "10 000 brackets": "x(" * 10_000,
}
Door = Callable[[bytes], object]


@pytest.fixture
def doors(four_speed: Controller) -> dict[str, Door]:
    """What reads each kind of file."""
    return {
        "sheet": lambda data: read_readings(data, four_speed),
        "gauges": lambda data: read_pressure_table(data, four_speed),
        "study": read_study,
        "log": lambda data: (understand(data), log_columns(data)),
    }


def text(rows: list[list[str]], between: str = ";") -> bytes:
    return "\n".join(between.join(row) for row in rows).encode()


@pytest.mark.parametrize("weird", WEIRD.values(), ids=list(WEIRD))
@pytest.mark.parametrize("kind", list(HEADS))
def test_a_heading_of_thousands_of_signs_takes_no_time(doors, four_speed, kind, weird):
    again = range(6)  # each text anew
    data = text([[*HEADS[kind], *(f"{weird}{number}" for number in again)], *([*row, *"1" * 6] for row in ROWS[kind])])
    with most_calls(ENOUGH), in_time():
        with suppress(AtleakError):
            doors[kind](data)
        table_kind(data, four_speed)


@pytest.mark.parametrize("kind", ["sheet", "gauges", "study"])
@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([["1"] * 10] * 6_000, "this sheet has 600"),
        ([[str(column) for column in range(100_000)]] * 3, "100000 columns"),
        ([[f"word {row} {column}" for column in range(3)] for row in range(1_700)], "different texts"),
        ([["x"], *[[""]] * 12_000, ["y"]], "12006 rows"),
    ],
    ids=["cells", "columns", "words", "rows"],
)
def test_a_table_larger_than_people_fill_in_is_refused_with_its_size(doors, kind, rows, said):
    data = text([HEADS[kind], *ROWS[kind], *rows])
    with most_calls(ENOUGH), pytest.raises(AtleakError) as refused:
        doors[kind](data)
    if kind == "sheet":
        assert said in str(refused.value)
        assert "filled in at a bench" in str(refused.value)


def test_blank_columns_and_rows_at_the_end_are_no_part_of_a_table(doors):
    rows = [HEADS["study"], *ROWS["study"], *ROWS["study"]]
    plain = doors["study"](text(rows).replace(b";1;", b";;"))
    padded = [[*row, *[""] * 5_000] for row in rows] + [[""]] * 50_000
    with most_calls(ENOUGH):
        assert doors["study"](text(padded).replace(b";1;", b";;")).values.tolist() == plain.values.tolist()


def test_hundreds_of_tables_on_one_sheet_are_refused(doors):
    with most_calls(ENOUGH), pytest.raises(ReadingsError, match="tables with headings of their own"):
        doors["sheet"](text([HEADS["sheet"], *ROWS["sheet"], [""]] * 1_000))


def test_after_hundreds_of_faults_the_rest_of_a_file_is_not_read(doors):
    rows = [["8", "spool", f"Z{row}", "0", str(row)] for row in range(extent.FAULTS + 50)]
    with most_calls(ENOUGH), pytest.raises(ReadingsError) as refused:
        doors["sheet"](text([HEADS["sheet"], *rows]))
    assert extent.FAULTS < len(refused.value.problems) < extent.FAULTS + 20


def test_merged_ranges_and_spans_beyond_the_cells_take_no_time(doors, bare_workbook):
    cells = "<row><c><v>1</v></c><c><v>2</v></c></row>"
    merged = bare_workbook(f'<sheetData>{cells}</sheetData><mergeCells><mergeCell ref="A1:XFD1048576"/></mergeCells>')
    spans = 'table:number-rows-spanned="1048576" table:number-columns-spanned="16384"'
    cell = f'<table:table-cell {spans} office:value-type="float" office:value="1"/>'
    content = (
        '<office:document-content xmlns:office="urn:oasis:names:tc:opendocument:xmlns:office:1.0" '
        'xmlns:table="urn:oasis:names:tc:opendocument:xmlns:table:1.0"><office:body><office:spreadsheet>'
        f'<table:table table:name="Sheet"><table:table-row>{cell}</table:table-row></table:table>'
        "</office:spreadsheet></office:body></office:document-content>"
    )
    spanned = io.BytesIO()
    with zipfile.ZipFile(spanned, "w") as archive:
        archive.writestr("content.xml", content)
    for data in (merged, spanned.getvalue()):
        for door in doors.values():
            with most_calls(ENOUGH), suppress(AtleakError):
                door(data)


@pytest.mark.slow  # the quick round has tables of too many cells, columns and rows
def test_a_workbook_of_hundreds_of_sheets_is_refused(doors, bare_workbook):
    space = "http://schemas.openxmlformats.org"
    sheets = "".join(f'<sheet name="S{number}" sheetId="{number}" r:id="rId1"/>' for number in range(1, 1001))
    book = f'<workbook xmlns="{space}/spreadsheetml/2006/main" xmlns:r="{space}/officeDocument/2006/relationships">'
    data = bare_workbook("<sheetData/>", {"xl/workbook.xml": f"{book}<sheets>{sheets}</sheets></workbook>"})
    for door in doors.values():
        with most_calls(ENOUGH), pytest.raises(AtleakError, match="this workbook has 1000 sheets"):
            door(data)


def test_a_long_log_in_a_workbook_is_known_as_a_log(four_speed, bare_workbook):
    heads = "".join(f'<c t="inlineStr"><is><t>{name}</t></is></c>' for name in HEADS["log"])
    rows = "".join(f"<row><c><v>{row / 10}</v></c><c><v>900</v></c><c><v>500</v></c></row>" for row in range(12_000))
    assert (
        table_kind(bare_workbook(f"<sheetData><row>{heads}</row>{rows}</sheetData>"), four_speed) == TableKind.ROAD_TEST
    )


@pytest.mark.parametrize(
    ("inside", "parts"),
    [
        ("<cols>" + '<col min="1" max="16383" hidden="1"/>' * 16_384 + "</cols>", {}),
        ("<sheetData/>", {"xl/workbook.xml": "<a>" * 1_000_000}),
        ("<sheetData/>", {"xl/_rels/workbook.xml.rels": "<a>" * 1_000_000}),
        ("<sheetData/>", {"xl/sharedStrings.xml": "<si><r>strike</r></si>" * 1_500_000}),
        (b" " * 33_000_000, {}),
    ],
    ids=["hidden columns", "nested", "nested relations", "shared texts", "blanks"],
)
def test_parts_of_a_workbook_that_unpack_to_millions_of_marks_are_refused_soon(doors, bare_workbook, inside, parts):
    data = bare_workbook(inside, parts)
    with pytest.raises(ReadingsError) as refused:
        doors["sheet"](data)
    assert "took longer" not in str(refused.value)  # than its process may
