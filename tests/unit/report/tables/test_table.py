"""A table is said once: its words and units follow the reader, its cells stay numbers, and every medium prints it."""

from __future__ import annotations

import io

import openpyxl
import pytest
import xlsxwriter

from atleak.common.style import find_paper
from atleak.common.translations import languages
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.engine.road_pressure import PlaceFinding, RoadPressure
from atleak.report.pdf.blocks import printed
from atleak.report.tables.road_test import place_table
from atleak.report.tables.table import Column, Judged, Table
from atleak.report.terminal import print_table
from atleak.report.xlsx.book import ReportBook
from atleak.report.xlsx.page import SheetPage, widths_for

COLUMNS = (
    Column("verdict", "verdict"),
    Column("pair", of=lambda row: row["name"], whole=True),
    Column("clearance", "clearance"),
    Column("share", "percent", 1, of=lambda row: Judged(row["share"], row["of_share"])),
    Column("note"),
)
ROWS = [
    {"verdict": Verdict.REPLACE, "name": "8/1 <b>", "clearance": 25.46, "share": 3.25, "of_share": Verdict.WATCH},
    {"verdict": None, "name": "9/2", "clearance": None, "share": None, "of_share": None},
]


def table(language: str = "en", units: str = "metric", **more: object) -> Table:
    return Table("lands", COLUMNS, ROWS, wording(language, units), **more).filled  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("language", "units", "heading"),
    [("en", "metric", "Clearance [µm]"), ("de", "metric", "Spiel [µm]"), ("pl", "us", "Luz [0.0001 in]")],
)
def test_a_heading_has_the_readers_words_and_unit(language: str, units: str, heading: str) -> None:
    assert Column("clearance", "clearance").heading(wording(language, units)) == heading


def test_a_cell_is_a_number_in_the_readers_unit_rounded_as_it_is_written() -> None:
    pressure, say = Column("held", "pressure", digits=0), wording("de", "us")
    assert pressure.cell({"held": 1000.0}, say, rounded=True) == 145
    assert pressure.cell({"held": 1000.0}, say) == pytest.approx(145.0377, abs=1e-4)
    assert pressure.text({"held": 1000.0}, say) == "145"
    assert pressure.cell({}, say) is None
    assert pressure.text({}, say) == "–"


def test_words_and_verdicts_stay_as_they_are() -> None:
    say = wording("pl", "us")
    assert Column("source").cell({"source": "CMM, 0.5 mm"}, say) == "CMM, 0.5 mm"
    assert Column("verdict", "verdict").cell({"verdict": Verdict.OK}, say) is Verdict.OK
    assert Column("verdict", "verdict").heading(say) == "Ocena"


def test_only_a_column_that_needs_it_says_what_it_means() -> None:
    for language in languages():
        assert Column("wear", "percent").help(wording(language)) is not None
        assert Column("source").help(wording(language)) is None


def test_a_column_without_anything_in_it_is_left_out() -> None:
    assert [column.key for column in table().columns] == ["verdict", "pair", "clearance", "share"]
    assert Table("none", COLUMNS, [], wording("en")).filled.columns == COLUMNS


def test_a_notebook_has_numbers_under_headings_with_their_unit() -> None:
    frame = table(units="us").frame()
    assert list(frame) == ["Verdict", "Pair", "Clearance [0.0001 in]", "Share [%]"]
    assert frame["Clearance [0.0001 in]"][0] == pytest.approx(10.0236, abs=1e-4)
    assert "8/1 &lt;b&gt;" in table().html()


def test_a_terminal_has_the_readers_words_and_what_is_told_of_a_row(capsys: pytest.CaptureFixture[str]) -> None:
    print_table(table("de", remark=lambda row: "of the first" if row is ROWS[0] else ""))
    said = capsys.readouterr().out
    lines = [line for line in said.splitlines()[1:] if "─" not in line]
    head, *rows = [[cell.strip() for cell in line.strip("│┃").split(line[0])] for line in lines]
    assert head == ["Befund", "Paarung", "Spiel [µm]", "Anteil [%]"]
    assert ["■ ersetzen", "8/1 <b>", "25,5", "▲ 3,2"] in rows
    assert ["–", "9/2", "–", "–"] in rows
    assert said.splitlines()[-1] == "of the first"


@pytest.mark.parametrize("width", [40, 60, 100])
def test_a_narrow_terminal_breaks_headings_and_words_never_a_number(
    width: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    columns = tuple(Column(f"share_{at}", "percent", 3, words="a long heading") for at in range(4))
    rows = [{column.key: 12.345 for column in columns} | {"name": "some words of a name"}]
    print_table(Table("", (Column("name", words="name"), *columns), rows, wording("en")))
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= width
    assert sum(line.count("12.345") for line in lines) == 4


def test_paper_has_the_unit_below_the_heading_and_each_value_in_its_own_colour() -> None:
    block = printed(table(group=lambda row: "a group"))
    assert block["names"] == ["Verdict", "Pair", "Clearance\nc_r\nµm", "Share\n%"]
    assert block["rows"][:2] == [
        ["a group"],
        [{"sign": "replace", "text": "replace"}, "8/1 <b>", "25.5", {"sign": "watch", "text": "3.2"}],
    ]
    assert block["aligned"] == "llrr"


def test_a_sheet_has_numbers_as_exact_as_they_are_in_the_readers_unit() -> None:
    target = io.BytesIO()
    with xlsxwriter.Workbook(target) as workbook:
        book = ReportBook(workbook, find_paper("a4"), wording("de"))
        page = SheetPage(book, workbook.add_worksheet(), widths_for([table("de")]))
        assert page.printed(0, table("de")) == 3
    sheet = openpyxl.load_workbook(target).active
    heads, first, second = ([cell.value for cell in row] for row in sheet.iter_rows(max_row=3))
    assert heads == ["Befund", "Paarung", "Spiel [µm]", "Anteil [%]"]
    assert first == ["■ ersetzen", "8/1 <b>", 25.46, 3.25]
    assert second == [None, "9/2", None, None]
    assert sheet["C2"].number_format == "#,##0.0"


def test_a_reverse_gear_stands_beside_numbers() -> None:
    places = tuple(PlaceFinding(gear, "idle", 3.0, 0.0, 0.0, None) for gear in (-1, 1))
    content = place_table(RoadPressure(places, None, None), wording("en"))
    assert content.frame(rounded=True)["Gear"].tolist() == ["R", 1]
