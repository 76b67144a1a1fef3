"""What the cells of the workbook are: no number hides in a formula, what may be changed is open, all else follows."""

from __future__ import annotations

import io
import re
import textwrap
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import openpyxl
import pytest
from openpyxl.utils import get_column_letter

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.instruments import instruments
from atleak.catalogue.limits import load_limits
from atleak.common.style import INPUT
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.engine.profile import PAPER, WORKSHOP
from atleak.report.xlsx import write_workbook
from atleak.report.xlsx.constants import fluid_formulas
from atleak.report.xlsx.live_sheet import sheet_conditions

#: What a formula may hold itself: halves, squares, cubes and fourth powers, ranks and places, the 12 of flow between
#: plates and of a rectangle's variance; the one decimal that the headline shows; minutes, percent and SI prefixes.
STRUCTURAL = {"0", "1", "2", "3", "4", "12"} | {"10"} | {"60", "100", "1000", "0.001", "1E-6", "1E6"}
_FORMULA = re.compile(r"<f>([^<]*)</f>")
_TEXT = re.compile(r"&quot;|\"[^\"]*\"|'[^']*'!")
_NUMBER = re.compile(r"(?<![\w.$])\d+(?:\.\d+)?(?:[eE][+-]?\d+)?(?![\w.(!])")
_NAME = re.compile(r"(?<![\w.$!])(?:const|limit)_\w+")


#: Of budgets, asked for by lands with a part not measured, without a second direction, without repeats.
OF_OTHER_LANDS = {
    "const_own_mounting", "const_unseen_ovality", "const_tolerance_coverage", "const_repeats_apart",
    "const_nominal_diameter",
}  # fmt: skip


def formulas(content: bytes) -> Iterator[str]:
    """Every formula of a workbook, without its texts and the names of sheets."""
    with zipfile.ZipFile(io.BytesIO(content)) as parts:
        for part in parts.namelist():
            if part.startswith("xl/worksheets/sheet"):
                for text in _FORMULA.findall(parts.read(part).decode("utf-8")):
                    yield _TEXT.sub("", text.replace("&quot;", '"').replace("&gt;", ">").replace("&lt;", "<"))


def numbers_in(content: bytes) -> set[str]:
    return {number for text in formulas(content) for number in _NUMBER.findall(text)} - STRUCTURAL


def of_profile(found: Diagnosis, **options: str) -> Diagnosis:
    profile = PAPER if options == {"name": "paper"} else WORKSHOP.with_options(**options)
    return diagnose(found.controller, found.fluid, found.limits, readings=found.readings, profile=profile)


@pytest.fixture(scope="module")
def content(worn_clutch) -> bytes:
    return write_workbook(worn_clutch)


@pytest.fixture(scope="module")
def book(content) -> openpyxl.Workbook:
    return openpyxl.load_workbook(io.BytesIO(content))


def test_no_number_hides_in_a_formula(content):
    assert numbers_in(content) == set()
    assert _NUMBER.findall("A1*2.5+$B$3*1E-6-c_2/stated_n1+ROUND(x,0)+LOG10(3)") == ["2.5", "1E-6", "0", "3"]


@pytest.mark.slow
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"name": "paper"},
        {"eccentricity": "0.4", "viscosity": "regression"},
        {"eccentricity": "unknown", "entry_loss": "off"},
    ],
    ids=str,
)
def test_no_number_hides_in_a_formula_of_other_units_and_profiles(worn, options):
    assert numbers_in(write_workbook(of_profile(worn, **options))) == set()


def test_every_constant_is_asked_for_by_its_name_and_has_unit_or_source(content, book):
    asked = {name for text in formulas(content) for name in _NAME.findall(text)}
    named = {name for name in book.defined_names if name.startswith(("const_", "limit_"))}
    assert asked <= named
    assert {name for name in named - asked if name.startswith("const_")} == OF_OTHER_LANDS
    rows = list(book["Constants"].iter_rows(min_row=2, values_only=True))
    assert {row[0] for row in rows} == {name for name in named if name.startswith("const_")} - {"const_terms_of_series"}
    assert all(label and source and value is not None for _, label, value, _, source in rows)


def test_what_is_blue_is_open_and_all_else_is_protected_without_a_password(book):
    blue = f"FF{INPUT.lstrip('#')}".upper()
    differing = []
    for sheet in book:
        assert sheet.protection.sheet
        assert sheet.protection.password is None
        for row in sheet.iter_rows():
            for cell in row:
                colour = cell.font.color.rgb if cell.font.color is not None else None
                if cell.value is not None and cell.protection.locked == (str(colour).upper() == blue):
                    differing.append((sheet.title, cell.coordinate))
    assert differing == []


OF_THE_EXAMPLE = "Every number of this example is assumed."


@pytest.fixture(scope="module", params=["en", pytest.param("de", marks=pytest.mark.slow), "pl"])
def said(request, worn_clutch) -> tuple[str, openpyxl.Workbook]:
    """A language, and the workbook in it, of a valve body that says what the shipped example says of itself."""
    controller = replace(worn_clutch.controller, representative=OF_THE_EXAMPLE)
    content = write_workbook(replace(worn_clutch, controller=controller), language=request.param)
    return request.param, openpyxl.load_workbook(io.BytesIO(content), data_only=True)


def test_the_first_sheet_says_that_there_is_no_password(said):
    language, book = said
    word = {"en": "without a password", "de": "ohne Kennwort", "pl": "bez hasła"}[language]
    texts = [str(cell.value) for row in book.worksheets[0].iter_rows() for cell in row if cell.value]
    assert [text for text in texts if word in text]


LINE = 13.5  # [pt] of letters of 10 pt


def widths_of(sheet: Any) -> dict[str, float]:
    """The width [characters] of each column."""
    columns = sheet.column_dimensions.values()
    return {get_column_letter(at): each.width for each in columns for at in range(each.min, each.max + 1)}


def clipped(sheet: Any) -> list[str]:
    """The texts that have less room than they need: cut by a neighbour, at the bottom, or within a word."""
    widths, merged = widths_of(sheet), {each.coord.partition(":")[0]: each for each in sheet.merged_cells.ranges}
    found = []
    for cell in (cell for row in sheet.iter_rows(min_row=2) for cell in row if isinstance(cell.value, str)):
        columns = (
            range(cell.column, merged[cell.coordinate].max_col + 1) if cell.coordinate in merged else [cell.column]
        )
        width = int(sum(widths[get_column_letter(at)] for at in columns))
        lines = textwrap.wrap(cell.value, width, break_long_words=False) or [""]
        lines = lines if cell.alignment.wrap_text else [cell.value]
        high = (sheet.row_dimensions[cell.row].height or LINE) >= LINE * len(lines)
        if max(map(len, lines)) > width or not high:
            found.append(cell.value)
    return found


def printed_size(sheet: Any) -> float:
    """The part of its size at which a sheet that fits the width of a page in landscape is printed."""
    assert (sheet.page_setup.orientation, sheet.sheet_properties.pageSetUpPr.fitToPage) == ("landscape", True)
    paper = {"9": 11.69, "1": 11.0}[str(sheet.page_setup.paperSize)]
    wide = sum((7 * width + 5) / 96 for width in widths_of(sheet).values())  # [in]
    return (paper - sheet.page_margins.left - sheet.page_margins.right) / wide


def test_every_text_of_the_summary_has_the_room_it_needs_and_prints_large_enough(said):
    summary = said[1].worksheets[0]
    assert clipped(summary) == []
    assert printed_size(summary) > 0.7
    area = summary.print_area.replace("$", "").partition("!")[2]
    assert area == f"A1:{get_column_letter(len(widths_of(summary)))}{summary.max_row}"


@pytest.mark.slow  # its columns are more
def test_the_summary_of_a_unit_with_seven_conditions_prints_large_enough_too():
    found = diagnose(load_controller("gm_4l60e"), load_fluid("hipol_atf_iid"), load_limits("project_default"))
    summary = openpyxl.load_workbook(io.BytesIO(write_workbook(found))).worksheets[0]
    assert len(found.projections) == 7
    assert printed_size(summary) > 0.7


def test_what_the_catalogue_says_of_itself_is_in_the_reader_s_language(said):
    language, book = said
    texts = {str(cell.value) for sheet in book for row in sheet.iter_rows() for cell in row if cell.value}
    sources = {each.source for each in instruments() if each.id in ("bore_gauge", "workshop_microscope")}
    english = {"fresh", "instrument", OF_THE_EXAMPLE, *sources}
    assert texts & english == (english if language == "en" else set())


def test_tabs_of_conditions_are_named_in_the_reader_s_language():
    found = diagnose(load_controller("five_speed_2005"), load_fluid("hipol_atf_iid"), load_limits("project_default"))
    tabs = {
        language: [at.sheet for at in sheet_conditions(found, wording(language))[1:]] for language in ("en", "de", "pl")
    }
    assert tabs["en"] == ["Gaps hot idle", "Gaps reverse idle", "Gaps stall", "Gaps cruising fifth"]
    assert tabs["de"][1:3] == ["Leckspalte heißer Leerlauf in R", "Leckspalte Festbremsen in D"]
    assert tabs["pl"][1:3] == ["Szczeliny gorący bieg jałowy w…", "Szczeliny utyk (stall) w D"]
    assert all(len(name) <= 31 for names in tabs.values() for name in names)


def test_a_tab_named_by_a_file_of_the_workshop_s_own_holds_no_letter_that_excel_refuses():
    found = diagnose(load_controller("minimal_example"), load_fluid("hipol_atf_iid"), load_limits("project_default"))
    points = [
        replace(point, name=f"own_{number}", label=label)
        for number, (point, label) in enumerate(
            zip(found.controller.operating_points[1:] * 3, ("D/R: 'idle' [hot]", "d r idle hot", "*?"), strict=True)
        )
    ]
    controller = replace(found.controller, operating_points=(found.controller.operating_points[0], *points))
    found = diagnose(controller, found.fluid, found.limits)
    tabs = [at.sheet for at in sheet_conditions(found, wording("de"))]
    assert tabs == ["Leckspalte", "Leckspalte D R idle hot", "Leckspalte d r idle hot 2", "Leckspalte own_2"]


def test_what_counts_is_chosen_from_a_list_in_the_reader_s_words(worn_clutch):
    say = wording("pl")
    book = openpyxl.load_workbook(io.BytesIO(write_workbook(worn_clutch, language="pl")))
    (choice,) = [each for sheet in book for each in sheet.data_validations.dataValidation]
    assert choice.formula1 == f'"{say("estimate.yes")},{say("estimate.no")}"'


#: Numbers that name, order or weigh what stands in a row by where it stands: no result, and nothing to change.
_STRUCTURE = (
    "land", "repeat", "direction [°]", "row", "step, and term of the series",
    "weight: directions of a plane alike, planes alike", "sensitivity c", "gear", "roundings in one diameter",
    "part of a two-lobe form that its directions leave", "the same of other forms, of two directions 1",
    "a mark of this workbook, not a quantity", "const_rounding",
)  # fmt: skip


def test_a_number_that_cannot_follow_is_marked_as_issued(book):
    """Of the sheets that compute: a number is a formula, or open to change, or its row or column says *as issued*."""
    around = ("Summary", "Job", "Messages", "Provenance", "Road test", "Road test events")
    unmarked = []
    for sheet in (sheet for sheet in book if sheet.title not in around):
        heads: dict[int, str] = {}
        for row in sheet.iter_rows():
            heads |= {cell.column: cell.value for cell in row if cell.font.b and isinstance(cell.value, str)}
            words = {cell.value for cell in row if isinstance(cell.value, str)}
            for cell in row:
                if isinstance(cell.value, int | float) and cell.protection.locked:
                    said = words | {heads.get(cell.column, "")}
                    if not said & set(_STRUCTURE) and "as issued" not in " ".join(said):
                        unmarked.append((sheet.title, cell.coordinate, said))
    assert unmarked == []


def test_a_fluid_s_formulas_ask_for_the_constants_of_its_model_alone(content):
    asked = {name for text in fluid_formulas("d341", "x_T") for name in _NAME.findall(text)}
    assert asked <= {name for text in formulas(content) for name in _NAME.findall(text)}
    assert asked.isdisjoint(name for text in fluid_formulas("regression", "x_T") for name in _NAME.findall(text))
    assert fluid_formulas("tabulated", "x_T") == (None, None)


@pytest.mark.slow
def test_of_a_unit_with_a_road_test_too(worn):
    test_a_number_that_cannot_follow_is_marked_as_issued(openpyxl.load_workbook(io.BytesIO(write_workbook(worn))))
