"""Entries that a careful hand would make."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import pytest

from atleak.catalogue.controller import Controller
from atleak.measurements.measuring_plan import Plan, PlanCell
from atleak.readers.typed_sheet import Typed

Texts = dict[PlanCell, str]


def careful(controller: Controller, wear_um: float = 2.0) -> Texts:
    """Every diameter of a plan, spools as new, bores worn, the second repeat 1 µm larger, with decimal commas."""
    texts = {}
    for cell in Plan().cells(controller):
        land = controller.land_of_plane(cell.component, cell.plane)
        assert land is not None
        size = land.nominal_of(cell.part) * 1e3 + 0.001 * (cell.repeat - 1)
        size += 2e-3 * wear_um if cell.part == "sleeve" else 0.0
        texts[cell] = f"{size:.4f}".replace(".", ",")
    return texts


@pytest.fixture(scope="session")
def careful_texts(minimal: Controller) -> Mapping[PlanCell, str]:
    return careful(minimal)


@pytest.fixture(scope="session")
def careful_entries(careful_texts: Texts) -> Typed:
    return Typed().fill(careful_texts)


@pytest.fixture(scope="session")
def with_texts(careful_entries: Typed) -> Callable[[Mapping[PlanCell, str]], Typed]:
    """The careful entries with some of them written otherwise."""

    def made(texts: Mapping[PlanCell, str]) -> Typed:
        return careful_entries.fill(texts)

    return made
