"""Write the names and rows that several pages show: only words and choice of columns."""

from __future__ import annotations

from collections.abc import Callable

from atleak.catalogue.controller import Controller
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.report.pdf.printed_names import PrintedNames
from atleak.report.tables.names import land_words
from atleak.report.tables.sentences import land_in_words
from pages.shared import reader
from pages.shared.show import plain
from pages.shared.state import job


def advised(diagnosis: Diagnosis, say: Wording) -> Callable[[LandDiagnosis], str]:
    """Return what says in the reader's language how a land's open verdict can be decided."""
    return PrintedNames(diagnosis, job(), say).advice


def pair(controller: Controller, component: str, land: int) -> str:
    """Return component, land and name, so that a narrow column cuts the name only: ``25/1 main pressure valve``."""
    return land_words(controller, (component, land), reader.say())


def advice(diagnosis: Diagnosis, advised: Callable[[LandDiagnosis], str], say: Wording) -> list[str]:
    """Return what would make the open verdicts clear, one line of markdown per land of which that can be said."""
    return [
        f"- **{plain(land_in_words(diagnosis, land.key, say))}**: {plain(said)}"
        for land in diagnosis.ranked
        if (said := advised(land))
    ]
