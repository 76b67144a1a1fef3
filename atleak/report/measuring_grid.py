"""All that a grid for measuring shows, in a reader's words, as plain values that a page can hand on."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.repairs import LandKey
from atleak.common.style import look_of
from atleak.common.units import MM, UM
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.measurements.measuring_plan import PlanCell
from atleak.readers.typed_sheet import JudgedEntry, Typed
from atleak.report.charts.drawing import on_dark, spool_svg
from atleak.report.tables.names import component_words, has_number
from atleak.report.tables.sentences import wear_words


@dataclass(frozen=True)
class Grid:
    """What a grid shows: the cells in the order of measuring, what was typed in them, and what it is worth.

    ``diagnosis`` is that of the job which holds the entries: clearance, wear and verdict of a land are its own.
    """

    cells: tuple[PlanCell, ...]
    typed: Typed
    judged: JudgedEntry
    diagnosis: Diagnosis

    @property
    def controller(self) -> Controller:
        """Return the valve body."""
        return self.diagnosis.controller

    @cached_property
    def components(self) -> tuple[str, ...]:
        """Return the components that are measured, in the order of measuring: the valve body's, or of a quick pass."""
        return tuple(dict.fromkeys(cell.component for cell in self.cells))

    @cached_property
    def asked(self) -> Counter[LandKey]:
        """Return how many readings are asked of every land."""
        return Counter(self.land_of(cell).key for cell in self.cells)

    @cached_property
    def counting(self) -> Counter[LandKey]:
        """Return how many of them are there and count."""
        return Counter(self.land_of(cell).key for cell in self.cells if cell in self.judged.counting)

    @cached_property
    def finished(self) -> dict[LandKey, LandDiagnosis]:
        """Return the lands of which every cell holds a reading that counts."""
        return {
            land.key: land
            for land in self.diagnosis.lands
            if land.state.status == "measured" and 0 < self.asked[land.key] == self.counting[land.key]
        }

    def land_of(self, cell: PlanCell) -> Land:
        """Return the land that a cell is of."""
        land = self.controller.land_of_plane(cell.component, cell.plane)
        assert land is not None  # a plan has cells of known lands only
        return land


def grid_record(grid: Grid, say: Wording, *, dark: bool = False) -> dict[str, Any]:
    """Return what a grid shows as plain values.

    Returns
    -------
    dict
        ``components``, each with its drawing, its lands and how far they are, and ``cells`` in the order of measuring,
        each with its text and what is doubtful about it.
    """
    return {
        "components": [_component(grid, name, say, dark) for name in grid.components],
        "cells": [_cell(grid, cell, say) for cell in grid.cells],
    }


def _component(grid: Grid, name: str, say: Wording, dark: bool) -> dict[str, Any]:
    lands = [land for land in grid.controller.lands_of(name) if land.key in grid.asked]
    angles = sorted({cell.direction for cell in grid.cells if cell.component == name and cell.direction is not None})
    verdicts = {key: land.verdict for key, land in grid.finished.items()}
    drawing = spool_svg(grid.controller, name, verdicts, say, directions=angles)
    return {
        "name": name,
        "label": name if has_number(grid.controller, name) else say.name(grid.controller.components[name]),
        "title": component_words(grid.controller, name, say),
        "drawing": on_dark(drawing) if dark else drawing,
        "lands": [_land(grid, land, say) for land in lands],
    }


def _land(grid: Grid, land: Land, say: Wording) -> dict[str, Any]:
    finished = grid.finished.get(land.key)
    if land.key in grid.judged.refused:
        progress = say("measuring.contradicts")
    else:
        progress = say("measuring.progress", done=grid.counting[land.key], asked=grid.asked[land.key])
    return {
        "name": say("measuring.land", land=land.land),
        "progress": progress,
        "finished": finished is not None,
        "result": None if finished is None else _result(finished, say),
    }


def _result(land: LandDiagnosis, say: Wording) -> dict[str, str]:
    state, look = land.state, look_of(land.verdict)
    ovalities = [each for each in (state.spool_ovality, state.sleeve_ovality) if each is not None]
    return {
        "clearance": say.quantity(state.radial_clearance * UM, "clearance"),
        "wear": wear_words(land, say),
        "ovality": say.quantity(max(ovalities) * UM, "clearance") if ovalities else "–",
        "verdict": say.signed(land.verdict),
        "sure": "" if land.decision is None else say.get("decisions", land.decision),
        "ground": look.screen if look.on_screen else "",
        "ink": look.on_screen,
    }


def _cell(grid: Grid, cell: PlanCell, say: Wording) -> dict[str, Any]:
    land, doubt, entry = grid.land_of(cell), grid.judged.doubts.get(cell), grid.typed.entries.get(cell)
    part = say("measuring.bore") if cell.part == "sleeve" else say(f"measuring.{land.part}")
    direction = "–" if cell.direction is None else f"{say.plain(cell.direction)}°"
    place = say("measuring.place", plane=cell.plane, direction=direction)
    return {
        "key": list(cell.key),
        "component": grid.components.index(cell.component),
        "part": part,
        "place": place,
        "repeat": cell.repeat,
        "text": "" if entry is None else entry.text,
        "doubt": "" if doubt is None else say.sentence(doubt.text),
        "counts": doubt is None or doubt.counts,
        "nominal": say.quantity(land.nominal_of(cell.part) * MM, "length"),
    }
