"""What is typed stays as it was typed; blocks fill the cells along, and each step can be undone."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.catalogue.controller import Controller
from atleak.measurements.measuring_plan import Plan, PlanCell
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.readers.typed_sheet import MOST_STEPS, Typed, TypedEntry

A, B, C, D = (PlanCell("8", "spool", "1", angle, repeat) for angle in (0.0, 90.0) for repeat in (1, 2))
CELLS = (A, B, C, D)


def texts(typed: Typed) -> dict[PlanCell, str]:
    return {cell: entry.text for cell, entry in typed.entries.items()}


def test_a_text_is_kept_sign_for_sign_and_an_empty_one_is_none() -> None:
    typed = Typed().put(A, " 15,0010 ").put(B, "abc")
    assert texts(typed) == {A: "15,0010", B: "abc"}
    assert texts(typed.put(A, "  ")) == {B: "abc"}


def test_what_changes_nothing_is_no_step() -> None:
    typed = Typed().put(A, "15")
    assert typed.put(A, "15") is typed


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("block", ["15,001\t15,002{0}15,003{0}", "15,001\t15,002{0}15,003"])
def test_a_block_fills_the_cells_along_row_by_row(block: str, newline: str) -> None:
    done = Typed().paste(CELLS, A, block.format(newline))
    assert texts(done.typed) == {A: "15,001", B: "15,002", C: "15,003"}
    assert (done.at, done.left_over) == (D, 0)


def test_empty_cells_of_a_block_leave_what_is_there() -> None:
    done = Typed().put(B, "14").paste(CELLS, A, "15\t\n16\t")
    assert texts(done.typed) == {A: "15", B: "14", C: "16"}


def test_a_block_of_one_column_goes_down_the_cells_of_one_repeat() -> None:
    first = Typed().paste(CELLS, A, "15,001\n15,003\n").typed
    both = first.paste(CELLS, B, "15,002\n15,004")
    assert texts(both.typed) == {A: "15,001", B: "15,002", C: "15,003", D: "15,004"}
    assert both.at == D


def test_values_without_a_cell_are_counted() -> None:
    done = Typed().paste(CELLS, C, "1\t2\n3\t4\n5\t")
    assert texts(done.typed) == {C: "1", D: "2"}
    assert (done.at, done.left_over) == (D, 4)


def test_a_block_is_undone_in_one_step() -> None:
    typed = Typed().put(A, "14").paste(CELLS, A, "1\n2\n3").typed
    back = typed.undo()
    assert texts(back.typed) == {A: "14"}
    assert back.at == A
    assert back.typed.undo().typed.undo().typed == Typed()


@given(st.lists(st.tuples(st.sampled_from(CELLS), st.sampled_from(["", "1", "2", "x"])), max_size=12))
def test_undoing_every_step_leads_back_through_every_state(steps: list[tuple[PlanCell, str]]) -> None:
    states = [Typed()]
    for cell, text in steps:
        after = states[-1].put(cell, text)
        states += [after] if after != states[-1] else []
    typed = states[-1]
    for state in reversed(states):
        assert typed == state
        typed = typed.undo().typed


def test_only_the_last_steps_are_kept() -> None:
    typed = Typed()
    for number in range(MOST_STEPS + 20):
        typed = typed.put(A, str(number))
    assert len(typed.earlier) == MOST_STEPS


def test_steps_of_a_page_are_done_in_their_order() -> None:
    steps = [
        {"do": "put", "cell": list(A.key), "text": "1"},
        {"do": "paste", "cell": list(B.key), "text": "2\n3"},
        {"do": "undo"},
        {"do": "put", "cell": ["8", "spool", "1", 90, 2], "text": "4"},  # a browser writes 90.0 as 90
    ]
    done = Typed().after(steps, CELLS)
    assert texts(done.typed) == {A: "1", D: "4"}


@pytest.mark.parametrize(
    "step",
    [
        {},
        {"do": "put"},
        {"do": "put", "cell": None, "text": "1"},
        {"do": "put", "cell": ["9", "spool", "1", 0, 1], "text": "1"},
        {"do": "put", "cell": [["8"], "spool", "1", 0, 1], "text": "1"},
        {"do": "undo"},
    ],
)
def test_a_step_that_cannot_be_done_changes_nothing(step: Mapping) -> None:
    typed = Typed()
    assert typed.after([step], CELLS).typed is typed


def test_another_unit_leaves_what_was_typed_before_in_the_old_one() -> None:
    typed = Typed().put(A, "15,001").put(B, "0.59 in").put(C, "abc").in_unit("inch")
    assert texts(typed) == {A: "15,001 mm", B: "0.59 in", C: "abc"}
    assert typed.unit == "inch"


def test_a_sheet_is_gone_on_from_with_its_readings_in_the_cells(four_speed: Controller, sample_readings) -> None:
    sheet = read_readings(sample_readings, four_speed)
    typed = Typed.going_on_from(sheet)
    assert set(typed.entries) == set(Plan().cells(four_speed))
    first = typed.entries[PlanCell("5", "spool", "1", 0.0, 1)]
    assert first.text == "13.999"
    assert first.coordinates == pytest.approx((0.089409, 0.07541), abs=1e-9)
    assert typed.put(PlanCell("5", "spool", "1", 0.0, 1), "14").entries[
        PlanCell("5", "spool", "1", 0.0, 1)
    ] == TypedEntry("14")
