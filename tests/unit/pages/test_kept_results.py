"""Results stay with the sessions that look at them, however many others there are."""

from __future__ import annotations

import gc
import weakref
from dataclasses import replace

from pages.shared.cases import PageCase, diagnosis_of

OWN = PageCase(controller="minimal_example", mileage=90_000.0)


def test_a_result_that_somebody_looks_at_is_not_computed_again() -> None:
    shown = diagnosis_of(OWN)
    others = [diagnosis_of(PageCase(controller="minimal_example", temperature=60.0 + number)) for number in range(8)]
    assert diagnosis_of(OWN) is shown
    assert diagnosis_of(replace(OWN, mileage=95_000.0)).projections is shown.projections
    assert len({id(each) for each in (shown, *others)}) == 9


def test_a_result_that_nobody_looks_at_any_more_is_let_go() -> None:
    left = weakref.ref(diagnosis_of(OWN))
    for number in range(8):
        diagnosis_of(PageCase(controller="minimal_example", temperature=80.0 + number))
    gc.collect()
    assert left() is None
