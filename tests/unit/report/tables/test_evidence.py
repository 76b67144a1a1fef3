"""What is said of a unit before anything is opened: what is likely first, no ranking of what was only assumed."""

from __future__ import annotations

import io
from dataclasses import replace

import openpyxl
import pypdfium2
import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.evidence import CircuitEvidence, Evidence, evidence_of
from atleak.job.case import Case, SourceFile
from atleak.report.pdf import write_pdf
from atleak.report.tables import evidence as tables
from atleak.report.tables.evidence import evidence_record, evidence_sections, printed_sections
from atleak.report.tables.names import land_words
from atleak.report.tables.table import Section, Table, Text
from atleak.report.xlsx import write_workbook

SAY = wording("en")
GAUGES = b"tap,range,slow idle [kPa]\nline,D,857\nforward clutch,D,610\n"


@pytest.fixture(scope="module")
def unread() -> Diagnosis:
    """A unit of which nothing was read."""
    return Case(controller="minimal_example").diagnose()


@pytest.fixture(scope="module")
def gauged() -> Diagnosis:
    """A unit whose forward clutch has lost pressure; the line beside it has not."""
    return Case(controller="five_speed_2005", pressures=SourceFile("gauges.csv", GAUGES)).diagnose()


def words(section: Section) -> str:
    return " ".join(part.words for part in section.parts if isinstance(part, Text))


def table(section: Section) -> Table:
    return next(part for part in section.parts if isinstance(part, Table))


def shown(monkeypatch: pytest.MonkeyPatch, diagnosis: Diagnosis, evidence: Evidence) -> dict[str, Section]:
    monkeypatch.setattr(tables, "evidence_of", lambda _: evidence)
    return evidence_sections(diagnosis, SAY)


def test_where_nothing_was_read_that_is_said_first_and_nothing_is_ranked(unread: Diagnosis) -> None:
    sections = evidence_sections(unread, SAY)
    assert [*sections] == ["title", "next", "assumed"]
    assert words(sections["title"]).startswith("Nothing that was read sets a land or a circuit apart")


def test_every_assumption_is_named_as_the_command_line_takes_it(unread: Diagnosis) -> None:
    priors = evidence_record(unread)["priors"]
    assumed = {name: value for name, value in priors.items() if name != "eccentricity"}
    assert {"worn_lands_percent", "worn_seals_percent", "worn_pumps_percent", "viscosity_percent"} <= assumed.keys()
    again = Case(controller="minimal_example", assumptions=tuple({**assumed, "worn_lands_percent": 35.0}.items()))
    assert evidence_record(again.diagnose())["priors"] == {**priors, "worn_lands_percent": pytest.approx(35.0, abs=0.0)}
    rows = table(evidence_sections(unread, SAY)["assumed"]).records()
    assert [row["assumption_name"] for row in rows] == [*assumed]


def test_a_circuit_that_has_lost_pressure_is_said_first_with_its_interval(gauged: Diagnosis) -> None:
    sections = evidence_sections(gauged, SAY)
    said = words(sections["title"])
    (lost,) = (each for each in evidence_of(gauged).circuits if each.probability >= 0.5)
    assert said.startswith(f"Forward clutch has lost {lost.loss / 1e3:.0f}")
    assert f"({lost.low / 1e3:.0f} to {lost.high / 1e3:.0f})" in said
    usual = evidence_of(gauged).assumptions.worn_lands
    rows = table(sections["lands"]).rows
    assert 0 < len(rows) < 5, "of lands that nothing tells of there is no ranking"
    assert all(each.probability > usual for each in rows)
    assert f"The other {34 - len(rows)} lands" in words(sections["lands"])
    first = table(sections["circuits"]).texts(table(sections["circuits"]).rows[0])
    assert first[:3] == ("forward clutch", "yes", "100")


def test_lands_that_cannot_be_told_apart_are_said_together(gauged: Diagnosis, monkeypatch: pytest.MonkeyPatch) -> None:
    evidence = evidence_of(gauged)
    pair = [each for each in evidence.lands if each.group == 2]
    assert len(pair) > 1
    rest = tuple(replace(each, probability=0.1) for each in evidence.lands if each.group != 2)
    likely = tuple(replace(each, probability=0.314, of_group=0.614) for each in pair)
    sections = shown(monkeypatch, gauged, replace(evidence, lands=(*likely, *rest), seals=(), pump=None, thin=None))
    said, names = words(sections["title"]), [SAY.name(gauged.controller.components[e.land.component]) for e in pair]
    assert "Likely worn: one of " in said
    assert "(61\N{NO-BREAK SPACE}%), which cannot be told apart" in said
    assert said.count("%") == 1, "of a group what is known of all of it"
    assert all(name in said for name in names)
    rows = table(sections["lands"])
    assert [row["alike"] for row in rows.records()] == [2] * len(pair)
    assert [rows.texts(row)[1] for row in rows.rows] == ["31"] * len(pair)
    assert f"The other {len(rest)} lands are no likelier worn" in words(sections["lands"])


def test_without_a_likely_part_the_likeliest_are_named_as_such(
    gauged: Diagnosis, monkeypatch: pytest.MonkeyPatch
) -> None:
    evidence = evidence_of(gauged)
    lands = tuple(replace(each, probability=0.3, group=None) for each in evidence.lands[:1])
    said = words(shown(monkeypatch, gauged, replace(evidence, lands=lands, circuits=(), seals=(), next=()))["title"])
    assert said.startswith("No part is likelier worn than not. The likeliest: ")
    assert "(30\N{NO-BREAK SPACE}%)" in said


def test_where_no_reading_is_worth_it_that_is_said(gauged: Diagnosis, monkeypatch: pytest.MonkeyPatch) -> None:
    evidence = evidence_of(gauged)
    named = words(evidence_sections(gauged, SAY)["next"])
    places = [named.index(land_words(gauged.controller, each.land.key, SAY)) for each in evidence.next]
    assert places == sorted(places) != []
    enough = words(shown(monkeypatch, gauged, replace(evidence, next=()))["next"])
    assert enough.startswith("No further land is worth measuring")


def test_the_record_is_in_order_and_in_its_units(gauged: Diagnosis) -> None:
    evidence, record = evidence_of(gauged), evidence_record(gauged)
    losses = [each["loss_kpa"] for each in record["lands"]]
    assert losses == sorted(losses, reverse=True)
    assert losses[0] == pytest.approx(evidence.lands[0].loss / 1e3, rel=1e-12, abs=0.0)
    assert {(each["component"], each["land"]) for each in record["lands"]} == {
        each.key for each in load_controller("five_speed_2005").lands if not each.seal
    }
    first: CircuitEvidence = evidence.circuits[0]
    assert record["circuits"][0]["loss_kpa"] == pytest.approx(first.loss / 1e3, rel=1e-12, abs=0.0)
    assert record["circuits"][0]["id"] == first.circuit.id
    assert record["effective_samples"] == evidence.effective_samples
    assert [each["value"] for each in record["next"]] == [each.value for each in evidence.next]


def test_a_report_has_it_where_no_sheet_was_measured_and_gauges_tell(gauged: Diagnosis, unread: Diagnosis) -> None:
    printed = [*printed_sections(gauged, SAY)]
    assert [each.name for each in printed] == ["title", "lands", "circuits", "next", "assumed"]
    assert [*printed_sections(unread, SAY)] == [], "nothing is said of what was only assumed"
    pages = "".join(page.get_textpage().get_text_range() for page in pypdfium2.PdfDocument(write_pdf(gauged)))
    assert "Forward clutch has lost" in pages
    assert "worn_pumps_percent" in pages
    assert "of their clearance off the middle" in pages, "a note is not lost to the next one"
    book = openpyxl.load_workbook(io.BytesIO(write_workbook(gauged)))
    cells = [str(cell) for row in book["Before opening"].iter_rows(values_only=True) for cell in row if cell]
    assert any(cell.startswith("Forward clutch has lost") for cell in cells)
    assert any(cell.startswith("worn_pumps_percent") for cell in cells)


def test_a_large_group_that_nothing_tells_of_is_not_called_worn(
    gauged: Diagnosis, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of many lands one is worn by chance: that is no finding."""
    evidence = evidence_of(gauged)
    pair = [replace(each, probability=0.15, of_group=0.6) for each in evidence.lands if each.group is not None]
    sections = shown(monkeypatch, gauged, replace(evidence, lands=tuple(pair), circuits=(), seals=(), pump=None))
    assert words(sections["title"]).startswith("No part is likelier worn than not.")


def test_what_is_known_of_a_group_lies_between_its_likeliest_land_and_their_sum(gauged: Diagnosis) -> None:
    lands = evidence_of(gauged).lands
    for each in lands:
        group = [other.probability for other in lands if other.group == each.group] if each.group else []
        low, high = (max(group), sum(group)) if group else (each.probability, each.probability)
        assert low - 1e-9 <= each.of_group <= high + 1e-9
    assert any(each.of_group > each.probability for each in lands)
