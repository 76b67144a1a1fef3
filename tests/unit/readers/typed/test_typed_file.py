"""Typed entries are kept as a measuring sheet that is read as any other, and come back sign for sign."""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atleak.catalogue.controller import Controller
from atleak.catalogue.pump import PumpClearances
from atleak.common.errors import InputError, ReadingsError
from atleak.job.case import SourceFile
from atleak.job.kinds import FileKind, kind_of
from atleak.measurements.measuring_plan import Order, Plan, PlanCell
from atleak.measurements.readings import OwnLands, OwnLength, Reading, Readings, SheetIdentity
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.readers.typed_sheet import TYPED_FILE, Typed, judge, typed_in, written_sheet

SLIPS = (
    "150,01",
    "0.59",
    "abc",
    "15",
    "14,990",
    "15.6",
    "–",
    "12.5 mm",
    "7;5",
    "=1+1",
    '"',
    "1e1",
    "15,0,0",
    "-3",
    "0",
)


def kept(typed: Typed, controller: Controller) -> tuple[Readings, Typed | None]:
    content = written_sheet(typed, judge(typed, controller).counting, controller)
    assert content is not None
    sheet = read_readings(content, controller, name=TYPED_FILE)
    return sheet, typed_in(content, sheet, controller)


def sizes(readings: Mapping[PlanCell, Reading]) -> dict[tuple, float]:
    return {cell.key: reading.diameter for cell, reading in readings.items()}


@settings(max_examples=15)
@given(st.data())
def test_whatever_is_typed_the_job_can_read_it_and_holds_every_sign(
    minimal: Controller, careful_texts: Mapping[PlanCell, str], data: st.DataObject
) -> None:
    cells = list(careful_texts)
    slips = data.draw(st.dictionaries(st.sampled_from(cells), st.sampled_from(SLIPS), max_size=6))
    missing = data.draw(st.sets(st.sampled_from(cells), max_size=20))
    typed = Typed().fill({cell: text for cell, text in {**careful_texts, **slips}.items() if cell not in missing})
    sheet, back = kept(typed, minimal)
    assert back is not None
    assert back.entries == typed.entries
    counting = judge(typed, minimal).counting
    assert {(*each.station, each.repeat): each.diameter for each in sheet.readings} == pytest.approx(
        sizes(counting), abs=1e-12
    )


def test_what_does_not_count_is_left_aside_and_told(careful_entries: Typed, minimal: Controller) -> None:
    typed = careful_entries.put(PlanCell("accumulator", "spool", "1", 0.0, 1), "180,01")
    sheet, _ = kept(typed, minimal)
    assert len(sheet.readings) == len(typed.entries) - 1
    assert "rejected_left_aside" in [message.code for message in sheet.messages]


def test_a_first_entry_that_does_not_count_is_in_the_job_too(minimal: Controller) -> None:
    typed = Typed().put(PlanCell("accumulator", "spool", "1", 0.0, 1), "abc")
    sheet, back = kept(typed, minimal)
    assert sheet.readings == ()
    assert back is not None
    assert back.entries == typed.entries


def test_a_sheet_of_somebody_else_without_a_reading_is_refused_still(minimal: Controller) -> None:
    typed = Typed().put(PlanCell("accumulator", "spool", "1", 0.0, 1), "abc")
    content = written_sheet(typed, {}, minimal)
    assert content is not None
    with pytest.raises(ReadingsError, match="no reading is left"):
        read_readings(content.split(b"\r\n", 2)[2], minimal, name="own.csv")


def test_the_plan_and_the_unit_come_back(minimal: Controller) -> None:
    plan = Plan(Order.LANDS, 3, 1, 1, (("accumulator", 1),))
    typed = replace(Typed(plan=plan).put(PlanCell("accumulator", "spool", "1", 60.0, 1), "0,70866"), unit="inch")
    sheet, back = kept(typed, minimal)
    assert back is not None
    assert (back.plan, back.unit, back.entries) == (plan, "inch", typed.entries)
    assert sheet.readings[0].diameter == pytest.approx(18e-3, abs=1e-6)


@pytest.mark.parametrize("order", list(Order))
def test_the_plan_of_what_is_typed_is_no_number_of_the_job(minimal: Controller, order: Order) -> None:
    cell = next(iter(Plan().cells(minimal)))
    sheet, _ = kept(Typed(plan=Plan(order, lands=((cell.component, 1),))).put(cell, "15,000"), minimal)
    assert sheet.identity == SheetIdentity()
    assert not [message for message in sheet.messages if message.code == "head_unclear"]


def test_no_entry_is_no_file(minimal: Controller) -> None:
    assert written_sheet(Typed(), {}, minimal) is None


def test_what_a_sheet_says_beside_its_diameters_stays(careful_entries: Typed, minimal: Controller) -> None:
    unworn = Reading("accumulator", "sleeve", "1", 0.0, 1, 18.042e-3)
    own = OwnLands((OwnLength("accumulator", 1, 9.2e-3, 1.5e-3),))
    base = Readings(
        "a", "", None, "mm", False, "tidy", (), temperature=21.5, date=dt.date(2026, 3, 14), unworn=(unworn,)
    )
    base = replace(base, own_lands=own, pump=PumpClearances(85e-6, 120e-6))
    sheet, back = kept(replace(careful_entries, sheet=base), minimal)
    assert (sheet.temperature, sheet.date) == (21.5, base.date)
    assert sheet.pump.um == (85.0, 120.0)
    (length,) = sheet.own_lands.lengths
    assert length.key == ("accumulator", 1)
    assert (length.contact_length, length.position) == pytest.approx((9.2e-3, 1.5e-3), abs=1e-12)
    assert [each.diameter for each in sheet.unworn] == [pytest.approx(18.042e-3, abs=1e-9)]
    assert back is not None
    assert written_sheet(back, judge(back, minimal).counting, minimal) == written_sheet(
        replace(careful_entries, sheet=base), judge(careful_entries, minimal).counting, minimal
    )


def test_coordinates_of_an_uploaded_sheet_stay_in_the_file(four_speed: Controller, sample_readings) -> None:
    sheet = read_readings(sample_readings, four_speed)
    typed = Typed.going_on_from(sheet)
    again, back = kept(typed, four_speed)
    assert back is not None
    assert back.entries == typed.entries
    same = {(*each.station, each.repeat): (each.diameter, each.coordinates) for each in sheet.readings}
    assert {(*each.station, each.repeat): (each.diameter, each.coordinates) for each in again.readings} == same


def test_it_is_told_from_other_files_by_its_content(careful_entries: Typed, minimal: Controller) -> None:
    content = written_sheet(careful_entries, judge(careful_entries, minimal).counting, minimal)
    assert content is not None
    assert kind_of(SourceFile("x.bin", content), minimal) is FileKind.READINGS


@pytest.mark.parametrize(
    "changed",
    [
        lambda content: b"a;b;c\r\n" + content,
        lambda content: content.replace(b'""order"": ""parts""', b'""order"": ""other""'),
        lambda content: content.replace(b";Counts;", b";Counted;"),
        lambda content: content.replace(b";spool;", b";rod;", 1),
        lambda content: content.replace(b"accumulator;", b"other;", 1),
        lambda content: content.replace(b'""lands"": []', b'""lands"": [7]'),
        lambda content: content.replace(b'""repeats"": 2', b'""repeats"": Infinity'),
        lambda content: content.replace(b";0;1;", b";0;one;", 1),
        lambda content: content.split(b"\r\n")[0].partition(b";{")[0] + b"\r\n" + content.partition(b"}\r\n")[2],
        lambda content: b"\xff\xfe" + content,
        lambda content: b"",
    ],
)
def test_a_file_that_somebody_has_edited_is_a_sheet_as_any_other(
    careful_entries: Typed, minimal: Controller, changed
) -> None:
    content = written_sheet(careful_entries, judge(careful_entries, minimal).counting, minimal)
    assert content is not None
    sheet = Readings("a", "", None, "mm", False, "tidy", ())
    assert typed_in(content, sheet, minimal) is not None
    assert typed_in(changed(content), sheet, minimal) is None


def test_a_fault_of_atleak_is_not_taken_for_an_edited_file(
    careful_entries: Typed, minimal: Controller, monkeypatch: pytest.MonkeyPatch
) -> None:
    content = written_sheet(careful_entries, judge(careful_entries, minimal).counting, minimal)
    assert content is not None
    monkeypatch.setattr("atleak.readers.typed_sheet.PlanCell", None)
    with pytest.raises(InputError, match=r"atleak could not make sense of it: TypeError"):
        typed_in(content, Readings("a", "", None, "mm", False, "tidy", ()), minimal)
