"""Small files that would end the process that reads them, or take its memory or its time: refused in either slot."""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Callable

import numpy as np
import psutil
import pytest

from atleak.catalogue.controller import Controller
from atleak.common.errors import InputError, ReadingsError, RoadTestError
from atleak.readers.logs import read_road_test
from atleak.readers.sheets.measuring_sheet import read_readings

Build = Callable[..., bytes]
Read = Callable[[bytes, str], None]


@pytest.fixture(params=["sheet", "log"])
def read(request: pytest.FixtureRequest, four_speed: Controller) -> tuple[Read, type[InputError]]:
    """The two places a file is given to, and the error each refuses with."""
    if request.param == "sheet":
        return lambda data, name: read_readings(data, four_speed, name=name), ReadingsError
    return lambda data, name: read_road_test(data, name=name), RoadTestError


def refused(read: tuple[Read, type[InputError]], data: bytes, name: str = "hostile.xlsx") -> InputError:
    """The refusal for what the file holds, not for the time it took, and without the caller growing."""
    before = psutil.Process().memory_info().rss
    with pytest.raises(read[1]) as caught:
        read[0](data, name)
    assert psutil.Process().memory_info().rss - before < 250 << 20
    assert "took longer" not in caught.value.problem
    assert caught.value.place.file == name
    return caught.value


def row(*cells: str) -> str:
    return f"<sheetData><row r='1'>{''.join(f'<c {cell}><v>1</v></c>' for cell in cells)}</row></sheetData>"


CORNERS = ('r="XFD1048576"', "r='XFD1048576'", 'r = "XFD1048576"', 'r="xfd1048576"', 'r="XFD10485760"')


@pytest.mark.parametrize("cell", CORNERS)
def test_a_cell_in_the_last_corner_is_refused_with_what_to_delete(read, bare_workbook: Build, cell):
    error = refused(read, bare_workbook(row('r="A1"', cell)))
    assert "far outside its table" in error.problem
    assert "delete what lies outside the table" in error.expected


def test_a_row_with_a_million_cells(read, bare_workbook: Build):
    error = refused(read, bare_workbook("<sheetData><row>" + "<c><v>1</v></c>" * 1_000_000 + "</row></sheetData>"))
    assert "column number 1000000" in error.problem


def test_merged_ranges_over_the_whole_sheet_cost_no_more_than_its_cells(read, bare_workbook: Build):
    ranges = '<mergeCell ref="A1:XFD1048576"/>' * 3
    refused(read, bare_workbook(row('r="A1"', 'r="B1"') + f"<mergeCells>{ranges}</mergeCells>"))


def test_merged_ranges_that_overlap_are_no_workbook_of_a_spreadsheet_program(four_speed, bare_workbook: Build):
    ranges = '<mergeCell ref="A1:XFD1048576"/>' * 3
    with pytest.raises(ReadingsError, match="overlap"):
        read_readings(bare_workbook(row('r="A1"') + f"<mergeCells>{ranges}</mergeCells>"), four_speed)


def test_spans_of_an_open_document_beyond_its_cells(read):
    spans = 'table:number-rows-spanned="1048576" table:number-columns-spanned="16384"'
    cell = f'<table:table-cell {spans} office:value-type="float" office:value="1"/>'
    content = (
        '<office:document-content xmlns:office="urn:oasis:names:tc:opendocument:xmlns:office:1.0" '
        'xmlns:table="urn:oasis:names:tc:opendocument:xmlns:table:1.0"><office:body><office:spreadsheet>'
        f'<table:table table:name="Sheet"><table:table-row>{cell * 2}</table:table-row></table:table>'
        "</office:spreadsheet></office:body></office:document-content>"
    )
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
        archive.writestr("content.xml", content)
        archive.writestr("META-INF/manifest.xml", "<manifest/>")
    refused(read, stream.getvalue(), "hostile.ods")


def test_one_long_text_in_many_cells(read, bare_workbook: Build):
    """Stored once in the file, and as often as it is used in memory."""
    cells = "<c t='s'><v>0</v></c>" * 20
    lines = "".join(f"<row r='{line}'>{cells}</row>" for line in range(1, 1001))
    space = "http://schemas.openxmlformats.org"
    types = f"{space}/officeDocument/2006/relationships"
    data = bare_workbook(
        f"<sheetData>{lines}</sheetData>",
        {
            "xl/sharedStrings.xml": f'<sst xmlns="{space}/spreadsheetml/2006/main"><si><t>{"x" * 100_000}</t></si>'
            "</sst>",
            "xl/_rels/workbook.xml.rels": f'<Relationships xmlns="{space}/package/2006/relationships">'
            f'<Relationship Id="rId1" Type="{types}/worksheet" Target="worksheets/sheet1.xml"/>'
            f'<Relationship Id="rId2" Type="{types}/sharedStrings" Target="sharedStrings.xml"/></Relationships>',
        },
    )
    assert len(data) < 10_000
    assert "MB of memory" in refused(read, data).problem


@pytest.mark.parametrize("method", [12, 14], ids=["bzip2", "lzma"])
def test_an_entry_packed_in_a_way_it_is_not(read, bare_workbook: Build, method):
    """Each packing has its own error when what it is given makes no sense."""
    data = bytearray(bare_workbook(row('r="A1"')))
    for mark, at in ((b"PK\3\4", 8), (b"PK\1\2", 10)):
        place = data.find(mark)
        while place >= 0:
            struct.pack_into("<H", data, place + at, method)
            place = data.find(mark, place + 4)
    assert "damaged" in refused(read, bytes(data)).problem


def test_a_cut_mdf_says_so_and_nothing_else(capfd):
    asammdf = pytest.importorskip("asammdf", reason="the extra mdf is not installed")
    stream = io.BytesIO()
    with asammdf.MDF(version="4.10") as mdf:
        mdf.append([asammdf.Signal(np.arange(500.0), np.arange(500.0), name="Engine Speed", unit="rpm")])
        mdf.save(stream)
    capfd.readouterr()
    with pytest.raises(RoadTestError, match=r"cut\.mf4: this MDF file is damaged"):
        read_road_test(stream.getvalue()[:3000], name="cut.mf4")
    assert capfd.readouterr() == ("", "")


def test_the_next_file_is_read(stray_workbook: bytes, four_speed, sample_readings):
    for _ in range(3):
        with pytest.raises(ReadingsError):
            read_readings(stray_workbook, four_speed)
        assert read_readings(sample_readings, four_speed).readings
