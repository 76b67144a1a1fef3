"""Write the names and rows that several pages show: only words and choice of columns."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.diagnosis import Diagnosis, LandDiagnosis
from atleak.report.pdf.printed_names import PrintedNames, condition_name
from atleak.views.repair_words import Named, label_of
from atleak.wording import Wording
from pages.shared.show import plain
from pages.shared.state import job

FILES_IN = "en"  # the language of the catalogue's names
DIGITS = {
    "Clearance [µm]": 1,
    "u [µm]": 1,
    "Mounting [µm]": 1,
    "Wear [%]": 1,
    "Share [%]": 2,
    "Largest share [%]": 2,
    "Over it [%]": 1,
    **dict.fromkeys(("Leakage [dm³/min]", "from", "to"), 3),
    "Spool [mm]": 4,
    "Sleeve [mm]": 4,
    "Least [µm]": 1,
    "Largest [µm]": 1,
    "At [°]": 0,
    **dict.fromkeys(
        (f"{part} {what} [µm]" for what in ("ovality", "taper", "spread") for part in ("Spool", "Sleeve")), 1
    ),
}


def named(say: Wording) -> Named:
    """Return what names a condition in the reader's language; in English as the valve body's file does."""
    return label_of if say.language == FILES_IN else partial(condition_name, say=say)


def advised(diagnosis: Diagnosis, record: dict[str, Any], say: Wording) -> Callable[[LandDiagnosis], str]:
    """Return what says in the reader's language how a land's open verdict can be decided."""
    return PrintedNames(diagnosis, record, job(), say).advice


def pair(controller: Controller, component: str, land: int) -> str:
    """Return component, land and name, so that a narrow column cuts the name only: ``25 · 1 main pressure valve``."""
    return f"{component} · {land} {controller.components[component]}"


def land_name(diagnosis: Diagnosis, key: tuple[str, int]) -> str:
    """Return a land in words: ``25 · main pressure valve, land 1``."""
    return f"{key[0]} · {diagnosis.controller.components[key[0]]}, land {key[1]}"


def advice(diagnosis: Diagnosis) -> list[str]:
    """Return what would make the open verdicts clear, one line of markdown per land."""
    return [
        f"- **component {plain(land.state.land.component)} land {land.state.land.land}**: "
        f"{plain(land.uncertainty.advice)}"
        for land in diagnosis.ranked
        if land.uncertainty is not None and land.uncertainty.advice
    ]
