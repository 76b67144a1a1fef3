"""The workbook changed: what its formulas then give is what atleak says of a unit with the same change."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import openpyxl
import pandas as pd
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.controller_tables import NewOrigin
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits, Steps, load_limits
from atleak.common.verdicts import Band, Verdict
from atleak.common.wording import signed, wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.engine.profile import WORKSHOP
from atleak.measurements.readings import Readings
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.xlsx import write_workbook
from atleak.report.xlsx.book import NUMBER_FORMATS
from tests.unit.conftest import first_of

UM = 1e-6
Book = openpyxl.Workbook

NEW_LEAKAGE = "leakage of the same unit new, its pairs as wide as they may have been"


@dataclass(frozen=True)
class Unit:
    """All that a diagnosis is made from."""

    controller: Controller
    readings: Readings
    limits: Limits
    fluid: Any
    measured_at: float | None = None  # [°C]

    def diagnose(self) -> Diagnosis:
        return diagnose(
            self.controller,
            self.fluid,
            self.limits,
            readings=self.readings,
            measuring_temperature_c=self.measured_at,
            assumptions=replace(DEFAULTS, one_sided_wear=0.0),  # formulas judge by the value, and draw no shape
        )


def by_range(unit: Controller) -> Controller:
    """The same valve body, of which only the range of new pairs is known."""
    lands = (replace(each, mounting_clearance=(6.4 * UM, 20 * UM), new_origin=NewOrigin.RANGE) for each in unit.lands)
    return replace(unit, lands=tuple(lands))


def by_type(unit: Controller) -> Controller:
    """The same valve body, of which the type's clearances are known with their tolerance."""
    lands = (replace(each, mounting_tolerance=2 * UM, new_origin=NewOrigin.TYPE) for each in unit.lands)
    return replace(unit, lands=tuple(lands))


@pytest.fixture(scope="module")
def units(readings_of, sample_readings, hipol, limits) -> dict[str, Unit]:
    def sheet(controller: Controller, worn: tuple[float, ...]) -> Readings:
        """Every land but the last, in turn worn so many times its clearance as new; of two of them only one part."""
        found = {}
        for number, land in enumerate(controller.lands[:-1]):
            spool, clearance = land.nominal_diameter, worn[number % len(worn)] * land.new_clearance
            found[land.key] = (spool if number != 2 else None, spool + 2.0 * clearance if number != 3 else None)
        return readings_of(controller, found)

    study, minimal = load_controller("four_speed_2023"), by_type(load_controller("minimal_example"))
    ranged = by_range(study)
    return {
        "four_speed_2023": Unit(study, read_readings(sample_readings, study), limits, hipol),
        "minimal_example": Unit(minimal, sheet(minimal, (1.0, 1.35, 1.9, 1.1)), limits, hipol),
        "known_by_range": Unit(ranged, sheet(ranged, (1.0, 1.2, 1.5, 1.1, 1.3)), limits, hipol, measured_at=26.5),
    }


# --- changes, each made in the workbook and in what atleak starts from


def four_readings(unit: Unit, book: Book) -> Unit:
    """Widen the sleeves of two lands in one direction by 50 µm: their means change, and their form."""
    lands = [land.key for land in unit.controller.lands[:2]]

    def meant(component: str, part: str, direction: float | None, plane: str) -> bool:
        land = unit.controller.land_of_plane(component, plane)
        return part == "sleeve" and direction == 90.0 and land is not None and land.key in lands

    changed = 0
    for row in book["Readings"].iter_rows(min_row=2):
        component, _, part, plane, direction = (cell.value for cell in row[:5])
        if meant(component, part, direction, plane):
            row[6].value += 0.050
            changed += 1
    assert changed >= 2
    found = (
        replace(each, diameter=each.diameter + 50 * UM)
        if meant(each.component, each.part, each.direction, each.plane)
        else each
        for each in unit.readings.readings
    )
    return replace(unit, readings=replace(unit.readings, readings=tuple(found)))


def temperature(unit: Unit, book: Book) -> Unit:
    """Heat the second condition to 113 °C."""
    points = list(unit.controller.operating_points)
    points[1] = replace(points[1], temperature=113.0)
    set_name(book, f"{points[1].name}_T", 113.0)
    return replace(unit, controller=replace(unit.controller, operating_points=tuple(points)))


def limits_of(unit: Unit, book: Book) -> Unit:
    """Allow less growth of the total, less of a land, and ask for more micrometres of wear."""
    old = unit.limits
    set_limit(book, "and growth over the same unit new", "amber", 20.0)
    set_limit(book, "and points of pump flow added to it", "amber", 0.5)
    set_limit(book, "and growth over the same unit new", "red", 40.0)
    set_limit(book, "share of pump flow of one land", "watch", 0.3)
    set_limit(book, "and growth over the same land new", "watch", 12.0)
    set_limit(book, "and clearance over c_m", "watch", 6.5)
    growth = {**old.total_share.growth, Band.AMBER: (0.20, 0.005), Band.RED: (0.40, 0.04)}
    assert old.pair_share is not None
    assert old.wear is not None
    pair: Steps = replace(
        old.pair_share,
        levels=((Verdict.WATCH, 0.003), *old.pair_share.levels[1:]),
        growth={**old.pair_share.growth, Verdict.WATCH: (0.12, 0.0)},
    )
    wear = replace(old.wear, at_least={Verdict.WATCH: 6.5 * UM})
    return replace(
        unit, limits=replace(old, wear=wear, pair_share=pair, total_share=replace(old.total_share, growth=growth))
    )


def what_new_was(unit: Unit, book: Book) -> Unit:
    """Take new pairs as 2 µm wider, measured lands and others alike."""
    for heading in ("mounting clearance, low end", "mounting clearance c_m"):
        columns = [cell.column for cell in book["Lands"][1] if str(cell.value).startswith(heading)]
        for column in columns:
            for (cell,) in book["Lands"].iter_rows(min_row=2, min_col=column, max_col=column):
                if cell.value is not None:
                    cell.value += 2.0
    lands = []
    for land in unit.controller.lands:
        ends = tuple(end + 2.0 * UM for end in land.mounting_ends)
        lands.append(replace(land, mounting_clearance=ends if len(ends) > 1 else ends[0]))
    return replace(unit, controller=replace(unit.controller, lands=tuple(lands)))


CHANGES = (four_readings, temperature, limits_of, what_new_was)


def set_name(book: Book, name: str, value: float) -> None:
    sheet, _, address = book.defined_names[name].attr_text.rpartition("!")
    book[sheet.strip("'")][address.replace("$", "")].value = value


def set_limit(book: Book, label: str, level: str, value: float) -> None:
    """Change a limit by the words of its row; of several rows the one that has that level."""
    sheet = book["Limits"]
    (column,) = (cell.column for cell in sheet[1] if cell.value == level)
    rows = [row[0].row for row in sheet.iter_rows(min_row=2) if str(row[0].value).startswith(label)]
    (row,) = (row for row in rows if sheet.cell(row, column).value is not None)
    sheet.cell(row, column).value = value


# --- comparison


def issued(unit: Unit) -> tuple[Diagnosis, Book]:
    """A diagnosis, and its workbook with atleak's own numbers."""
    found = unit.diagnose()
    return found, openpyxl.load_workbook(io.BytesIO(write_workbook(found)), data_only=True)


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
def test_a_change_in_the_workbook_gives_what_atleak_gives(units, change, referee):
    unit = units["minimal_example"]
    before = unit.diagnose()
    sheets = referee.SheetCalculator(write_workbook(before))
    after, expected = issued(change(unit, sheets.book))
    assert rules_of(before) != rules_of(after)
    assert referee.differing(sheets.book, sheets.value, expected) == []


def test_a_changed_coordinate_changes_its_diameter_and_the_mean(units, calculator):
    sheets = calculator(write_workbook(units["four_speed_2023"].diagnose()))
    row = next(row for row in sheets.book["Readings"].iter_rows(min_row=2) if row[7].value is not None)
    component, diameter, coordinate = row[0].value, row[6].coordinate, row[7]
    lands = sheets.book["Lands"]
    land = next(cells[0].row for cells in lands.iter_rows(min_row=2) if cells[0].value == component)
    (spool,) = (cell.column_letter for cell in lands[1] if str(cell.value).startswith("spool diameter"))
    before = sheets.value("Readings", diameter), sheets.value("Lands", f"{spool}{land}")
    sheets.set("Readings", coordinate.coordinate, coordinate.value + 0.004)  # one of four readings of the plane
    after = sheets.value("Readings", diameter), sheets.value("Lands", f"{spool}{land}")
    assert [b - a for a, b in zip(before, after, strict=True)] == pytest.approx([0.004, 0.001], abs=1e-9)


def rules_of(found: Diagnosis) -> list[Any]:
    return [(rule.value, rule.steps.levels) for land in found.lands for rule in (*land.rules, *found.total_rules)]


@pytest.mark.slow  # each time, the calculator says the same of each change
@pytest.mark.parametrize("name", ["minimal_example", "four_speed_2023", "known_by_range"])
def test_libreoffice_gives_what_atleak_gives_after_every_change_at_once(
    units, name, recalculated, referee, monkeypatch
):
    """Judged by values alone: no formula draws."""
    judge = Steps.judge
    monkeypatch.setattr(Steps, "judge", lambda steps, value, below, reached=None: judge(steps, value, below))
    unit = units[name]
    before, as_issued = issued(unit)
    book = openpyxl.load_workbook(io.BytesIO(write_workbook(before)))
    assert referee.differing(book, recalculated(book), as_issued) == []
    for change in CHANGES:
        unit = change(unit, book)
    after, expected = issued(unit)
    value = recalculated(book)
    assert referee.differing(book, value, expected) == []
    totals = [[(rule.value, rule.steps.levels) for rule in found.total_rules] for found in (before, after)]
    verdicts = [[land.verdict for land in found.lands] for found in (before, after)]
    assert all(was != now for was, now in zip(*totals, strict=True))
    assert verdicts[0] != verdicts[1]
    assert value("Summary", "B5") == signed(after.verdict)
    assert len([land for land in after.lands if land.verdict.flagged]) == flagged_now(book, value)


def flagged_now(book: Book, value: Callable[[str, str], Any]) -> float:
    """The number beside *flagged now* on the summary."""
    (cell,) = (cell for row in book["Summary"].iter_rows() for cell in row if cell.value == "flagged now")
    return value("Summary", cell.offset(column=1).coordinate)


# --- what stands where


def lands_sheet(found: Diagnosis) -> pd.DataFrame:
    return pd.read_excel(io.BytesIO(write_workbook(found)), sheet_name="Lands", engine="calamine")


def test_lands_say_what_their_clearance_when_new_is_known_from(units):
    ranged = lands_sheet(units["known_by_range"].diagnose())
    low, high = ("mounting clearance, low end of a range [µm]", "mounting clearance c_m, high end of a range [µm]")
    assert ranged[[low, high]].drop_duplicates().to_numpy().tolist() == [pytest.approx([6.4, 20.0], abs=1e-12)]
    assert ranged["clearance of a new pair, of equal flow [µm]"][0] == pytest.approx(14.2774, abs=1e-4)
    assert set(ranged["clearance when new is known from"]) == {NewOrigin.RANGE.label}
    typed = lands_sheet(units["minimal_example"].diagnose())
    assert typed["tolerance of c_m, half width of 95 % [µm]"].tolist() == pytest.approx([2.0] * len(typed), abs=1e-12)
    assert set(typed["clearance when new is known from"]) == {NewOrigin.TYPE.label}
    assert not [name for name in typed.columns if "range" in name]


def summary_totals(found: Diagnosis) -> pd.DataFrame:
    """The table of totals on the summary."""
    sheet = pd.read_excel(io.BytesIO(write_workbook(found)), sheet_name="Summary", header=None, engine="calamine")
    first = int(sheet.index[sheet[0] == "condition"][0])
    last = int(sheet.index[sheet[0] == "engine speed [rpm]"][0])
    table = sheet.iloc[first : last + 1, : 1 + len(found.projections)].set_index(0)
    return table.T.reset_index(drop=True)


def test_the_summary_shows_each_total_beside_the_same_unit_new_and_how_sure_it_is(units):
    found = units["four_speed_2023"].diagnose()
    table = summary_totals(found)
    for row, (at, new, rule) in enumerate(
        zip(found.projections, found.new_projections, found.total_rules, strict=True)
    ):
        total = found.uncertainty.total(at.condition.name)
        low, high = total.leakage_interval
        expected = {
            "leakage drawn from the pump, spools concentric [dm³/min]": at.leakage * 6e4,
            "leakage, low as issued [dm³/min]": low * 6e4,
            "leakage, high as issued [dm³/min]": high * 6e4,
            f"{NEW_LEAKAGE}, spools concentric [dm³/min]": new.leakage * 6e4,
            "growth over that new unit [%]": rule.growth * 100,
            "share of pump capacity [%]": at.share * 100,
            "share with every spool concentric [%]": at.share * 100,
            "share with every spool touching its bore [%]": at.share_of(at.touching_leakage) * 100,
        }
        assert {name: table[name][row] for name in expected} == pytest.approx(expected, rel=1e-12, abs=0.0)
        assert table["band of the total share"][row] == found.band(at)
        assert table["decision as issued"][row] == wording("en").get("decisions", total.decision.decision)


def test_flows_of_spools_anywhere_say_so_and_lie_between_concentric_and_touching(units):
    unit = units["four_speed_2023"]
    profile = WORKSHOP.with_options(eccentricity="unknown")
    found = diagnose(unit.controller, unit.fluid, unit.limits, readings=unit.readings, profile=profile)
    table = summary_totals(found)
    assert "leakage drawn from the pump, mean over all positions of the spools [dm³/min]" in table.columns
    for eccentricity, spools in ((0.0, "concentric"), (1.0, "touching its bore")):
        fixed = WORKSHOP.with_options(eccentricity=eccentricity)
        there = diagnose(unit.controller, unit.fluid, unit.limits, readings=unit.readings, profile=fixed)
        shares = [at.share * 100 for at in there.projections]
        assert table[f"share with every spool {spools} [%]"].tolist() == pytest.approx(shares, rel=1e-12, abs=0.0)
    assert any(name.startswith("leakage q [dm³/min], mean over all positions") for name in lands_sheet(found).columns)


def test_a_gap_that_draws_nothing_from_the_pump_says_where_it_leaks(units):
    found = units["four_speed_2023"].diagnose()
    gaps = pd.read_excel(io.BytesIO(write_workbook(found)), sheet_name="Gaps", engine="calamine")
    aside = gaps[gaps["to"] == "p_m"]["drawn from the pump"]
    assert len(aside)
    assert set(aside) == {"no, it leaks into p_m"}
    drawn = gaps[gaps["drawn from the pump"] == "yes"]["leakage q [mm³/s], spools concentric"]
    assert drawn.sum() * 6e-5 == pytest.approx(found.projection.leakage * 6e4, rel=1e-12, abs=0.0)
    shares = lands_sheet(found)["share of pump capacity [%], stated condition"]
    assert shares.sum() == pytest.approx(found.projection.share * 100, rel=1e-12, abs=0.0)


def test_a_share_over_the_pumps_flow_is_called_a_demand(units, readings_of):
    unit = units["four_speed_2023"]
    wide = {land.key: (land.nominal_diameter, land.nominal_diameter + 200 * UM) for land in unit.controller.lands}
    content = write_workbook(replace(unit, readings=readings_of(unit.controller, wide)).diagnose())
    summary = openpyxl.load_workbook(io.BytesIO(content), data_only=True)["Summary"]
    assert "✖ critical: " in summary["B7"].value
    formats = [cell for row in summary.iter_rows() for cell in row if cell.number_format == NUMBER_FORMATS["share"]]
    assert max(cell.value for cell in formats) > 100.0
    assert '[>100]0.00" demand"' in NUMBER_FORMATS["share"]


def test_every_limit_that_is_issued_follows_its_cell(units):
    """No limit of a rule is a number of its own, unless the valve body's file gives it to the land."""
    book = openpyxl.load_workbook(io.BytesIO(write_workbook(units["known_by_range"].diagnose())))
    rules = book["Rules"]
    columns = [cell.column for cell in rules[1] if str(cell.value).endswith(" from")]
    values = [row[column - 1] for row in rules.iter_rows(min_row=2) for column in columns]
    stated = [cell for cell in values if cell.value is not None]
    assert len(stated) > 100
    assert [cell.coordinate for cell in stated if "limit_" not in str(cell.value)] == []


def test_a_limit_of_the_clearance_follows_its_cell_and_a_land_s_own_is_a_number_to_change(units, calculator):
    unit = units["minimal_example"]
    first, *others = unit.controller.lands
    lands = (replace(first, clearance_limit=30 * UM), *others)
    limits = load_limits("new_part_clearance")
    unit = replace(unit, controller=replace(unit.controller, lands=lands), limits=limits)
    sheets = calculator(write_workbook(unit.diagnose()))
    assert sheets.wrong() == []
    rules = sheets.book["Rules"]
    heads = {cell.value: cell.column - 1 for cell in rules[1]}
    of_clearance = [row for row in rules.iter_rows(min_row=2) if row[heads["rule"]].value == "radial clearance"]
    own, another, *_ = of_clearance
    assert own[heads["replace from"]].value == pytest.approx(30.0, abs=1e-12)
    assert own[heads["watch from"]].value is None
    verdict = another[heads["verdict"]].coordinate
    before = sheets.value("Rules", verdict)
    assert before == signed(Verdict.WATCH)
    set_limit(sheets.book, "radial clearance", "watch", 500.0)
    sheets.known.clear()
    assert sheets.value("Rules", verdict) == signed(Verdict.OK)


@pytest.mark.parametrize("name", first_of(["ford_4r70w", "gm_4l60e", "jatco_jf506e"]))
def test_what_is_worse_than_a_likely_level_is_no_milder(
    name: str, hipol: Fluid, limits: Limits, readings_of: Callable[..., Readings], referee: Any
) -> None:
    unit = load_controller(name)
    wide = {each.key: (each.nominal_diameter, each.nominal_diameter + 2.0 * each.new_clearance) for each in unit.lands}
    diagnosis = diagnose(unit, hipol, limits, readings=readings_of(unit, wide))
    totals = tuple(replace(rule, reached=(1.0, 1.0, 0.0)[: len(rule.steps.levels)]) for rule in diagnosis.total_rules)
    assert totals[0].probable
    content = write_workbook(replace(diagnosis, total_rules=totals))
    sheets, sheet = referee.SheetCalculator(content), openpyxl.load_workbook(io.BytesIO(content))["Rules"]
    label = str(totals[0].label)
    row = next(cells for cells in sheet.iter_rows() if any(str(each.value) == label for each in cells))
    heads = {each.value: each.column_letter for cells in sheet.iter_rows() for each in cells if each.value is not None}
    number, value, verdict = row[0].row, heads["value"], heads["verdict"]
    said = sheets.value("Rules", f"{verdict}{number}")
    sheets.set("Rules", f"{value}{number}", sheets.value("Rules", f"{value}{number}") * 1.01)
    assert sheets.value("Rules", f"{verdict}{number}") == said != signed(Verdict.OK)
