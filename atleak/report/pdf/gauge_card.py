"""Print what gauges should show on a unit, with room for what they do show: the gauge card."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

from atleak.common.style import DEFAULT_PAPER, find_paper
from atleak.common.wording import begun, wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import Job
from atleak.report.pdf.blocks import printed
from atleak.report.pdf.printed_names import PrintedNames
from atleak.report.pdf.typesetting import common_data, compile_pdf
from atleak.report.pictures import write_pictures
from atleak.report.printed_fonts import OwnFont
from atleak.report.tables.gauges import card_notes, card_table
from atleak.report.tables.sentences import fluid_in_state
from atleak.report.tables.table import Column


def write_gauge_card(
    diagnosis: Diagnosis,
    job: Job | None = None,
    *,
    language: str = "en",
    paper: str = DEFAULT_PAPER,
    units: str = "metric",
    font: OwnFont | None = None,
) -> bytes:
    """Return the bytes of the card as a PDF.

    Parameters
    ----------
    diagnosis
        of the unit; without a measuring sheet the card says what gauges show when it is new.
    job
        what the workshop wrote down: whose vehicle it is stands at the head, and the workshop.
    language
        one of `atleak.common.wording.languages`.
    paper
        one of `atleak.common.style.PAPERS`.
    units
        one of `atleak.common.units.SYSTEMS`.
    font
        for characters that the bundled fonts lack.

    Raises
    ------
    InputError
        an unknown language, paper or system of units, or a logo that cannot be read.
    """
    job, say, size = job or Job(), wording(language, units), find_paper(paper)
    table = card_table(diagnosis, say)
    tap, *columns = table.columns
    read = Column("card_read", words_of="pressure", width=150, of=lambda _: "")
    by_tap = replace(table, columns=(*columns, read), group=lambda row: begun(tap.text(row, say))).parted
    known = {"number": job.number, "vehicle": PrintedNames(diagnosis, job, say).vehicle, "vin": job.vehicle.vin}
    with tempfile.TemporaryDirectory(prefix="atleak-", ignore_cleanup_errors=True) as folder:
        pictures = write_pictures(job.letterhead, Path(folder))
        data: dict[str, Any] = {
            **common_data(say("gauge_card.title"), say("gauge_card.subject"), job, size, say, pictures),
            "facts": [
                [say("facts.controller"), say.name(diagnosis.controller.name)],
                [say("facts.fluid"), fluid_in_state(diagnosis, say)],
                *([say(f"facts.{key}"), value] for key, value in known.items() if value),
            ],
            "fields": [
                say("facts.date"),
                *(say(f"facts.{key}") for key, value in known.items() if key != "vin" and not value),
                f"{say('gauge_page.temperature')} [{say.unit('temperature')}]",
                f"{say('gauge_page.fast_idle')} [{say.unit('engine_speed')}]",
            ],
            "what": say("gauge_card.what"),
            "table": printed(by_tap),
            "notes": [*card_notes(diagnosis, say)],
        }
        return compile_pdf("gauge_card", Path(folder), data, job.date, say, font)
