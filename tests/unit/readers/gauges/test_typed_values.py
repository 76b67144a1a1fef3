"""Typed flows and vacuum tests as files: what was typed comes back sign for sign, and readers read them."""

from __future__ import annotations

import pytest

from atleak.catalogue.controller import Controller
from atleak.common.errors import InputError
from atleak.readers.gauges.typed_values import TypedFlows, TypedGauges, TypedTable, TypedVacuum
from atleak.readers.gauges.vacuum_table import read_vacuum_table
from atleak.readers.gauges.value_table import read_flow_table

FLOWS = TypedFlows({("hot_idle", "cooler"): "946"}, "ml/15 s")
VACUUM = TypedVacuum(
    {("accumulator/1", "worn"): "17,5", ("accumulator/1", "repaired"): "24"},
    supply="25", ambient="98,5", temperature="22", orifice="0.5",
    known_1="0,3", shown_1="23", known_2="1", shown_2="4,5",
)  # fmt: skip


@pytest.mark.parametrize("typed", [FLOWS, VACUUM, TypedVacuum({("accumulator/1", "worn"): ";"}, orifice='"')])
def test_what_is_typed_comes_back_from_its_own_file_and_from_no_other(typed: TypedTable) -> None:
    content = typed.written()
    assert content is not None
    assert type(typed).read(content) == typed
    assert type(typed).read(content + b"more") is None
    assert [kind for kind in (TypedFlows, TypedGauges, TypedVacuum) if kind.read(content)] == [type(typed)]


def test_the_reader_of_flows_reads_them(minimal: Controller) -> None:
    (reading,) = read_flow_table(FLOWS.written() or b"", minimal).readings
    assert (reading.condition, reading.what) == ("hot_idle", "cooler")
    assert reading.flow == pytest.approx(946e-6 / 15.0, rel=1e-9, abs=0.0)


def test_the_reader_of_vacuum_tests_reads_stand_and_readings(minimal: Controller) -> None:
    table = read_vacuum_table(VACUUM.written() or b"", minimal)
    stand = table.stand
    assert (stand.ambient, stand.temperature) == pytest.approx((98_500.0, 22.0), rel=1e-9, abs=0.0)
    assert stand.supply == pytest.approx(25 * 3386.389, rel=1e-6, abs=0.0)
    known = [(each.orifice * 1e3, each.vacuum / 3386.389) for each in stand.calibrations]
    assert known == [pytest.approx(each, rel=1e-6, abs=0.0) for each in ((0.3, 23.0), (1.0, 4.5))]
    assert [(each.repaired, each.orifice) for each in table.readings] == [(False, 0.5e-3), (True, 0.5e-3)]


@pytest.mark.parametrize(
    ("part", "text"),
    [
        ("supply", "many"), ("ambient", "5"), ("orifice", "0"), ("known_2", "x"), ("shown_1", "99"),
        (("accumulator/1", "repaired"), "26.5"),
    ],
)  # fmt: skip
def test_a_fault_is_found_where_it_was_typed(minimal: Controller, part: object, text: str) -> None:
    typed = VACUUM.with_text(part, text)
    with pytest.raises(InputError) as caught:
        read_vacuum_table(typed.written() or b"", minimal)
    assert {typed.part_at(each.place) for each in (caught.value, *caught.value.others)} == {part}
