"""Write the names and rows that several pages show: only words and choice of columns."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.diagnosis import Diagnosis
from atleak.land_diagnosis import LandDiagnosis
from atleak.report.pdf.printed_names import PrintedNames, condition_name
from atleak.views.repair_words import Named, label_of
from atleak.views.sentences import land_in_words
from atleak.wording import Wording
from pages.shared.show import plain
from pages.shared.state import job

FILES_IN = "en", "°C"  # the language of the catalogue's names, and the unit of the temperatures in them


def named(say: Wording) -> Named:
    """Return what names a condition in the reader's language and unit; where those are the file's, as it does."""
    as_filed = (say.language, say.unit("temperature")) == FILES_IN
    return label_of if as_filed else partial(condition_name, say=say)


def advised(diagnosis: Diagnosis, record: dict[str, Any], say: Wording) -> Callable[[LandDiagnosis], str]:
    """Return what says in the reader's language how a land's open verdict can be decided."""
    return PrintedNames(diagnosis, record, job(), say).advice


def pair(controller: Controller, component: str, land: int) -> str:
    """Return component, land and name, so that a narrow column cuts the name only: ``25 · 1 main pressure valve``."""
    return f"{component} · {land} {controller.components[component]}"


def advice(diagnosis: Diagnosis, advised: Callable[[LandDiagnosis], str], say: Wording) -> list[str]:
    """Return what would make the open verdicts clear, one line of markdown per land of which that can be said."""
    return [
        f"- **{plain(land_in_words(diagnosis, land.key, say))}**: {plain(said)}"
        for land in diagnosis.ranked
        if (said := advised(land))
    ]
