"""Print what gauges and a vacuum stand should show on a unit, with room for what they do show: cards to fill in."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from atleak.common.style import DEFAULT_PAPER
from atleak.common.wording import Wording, begun, wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.vacuum_card import GROWN
from atleak.measurements.job_card import Job
from atleak.measurements.vacuum import VacuumStand
from atleak.report.pdf.blocks import printed
from atleak.report.pdf.typesetting import write_page
from atleak.report.printed_fonts import OwnFont
from atleak.report.printed_names import PrintedNames
from atleak.report.tables.gauges import card_notes, card_table
from atleak.report.tables.sentences import fluid_in_state
from atleak.report.tables.table import Column, Table
from atleak.report.tables.vacuum import vacuum_card_notes, vacuum_card_tables


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
    language, paper, units, font
        as `atleak.report.pdf.write_pdf` takes them.

    Raises
    ------
    InputError
        an unknown language, paper or system of units, or a logo that cannot be read.
    """
    say = wording(language, units)
    table = card_table(diagnosis, say)
    tap, *columns = table.columns
    read = Column("card_read", words_of="pressure", width=150, of=lambda _: "")
    by_tap = replace(table, columns=(*columns, read), group=lambda row: begun(tap.text(row, say))).parted
    fields = (
        f"{say('gauge_page.temperature')} [{say.unit('temperature')}]",
        f"{say('gauge_page.fast_idle')} [{say.unit('engine_speed')}]",
    )
    words = [say(f"gauge_card.{name}") for name in ("title", "subject", "what")]
    facts = [[say("facts.fluid"), fluid_in_state(diagnosis, say)]]
    return _card(diagnosis, job, say, paper, font, [by_tap], words, card_notes(diagnosis, say), fields, facts)


def write_vacuum_card(
    diagnosis: Diagnosis,
    job: Job | None = None,
    *,
    language: str = "en",
    paper: str = DEFAULT_PAPER,
    units: str = "metric",
    font: OwnFont | None = None,
) -> bytes:
    """Return the bytes of the card of a vacuum stand as a PDF: what it should show of each circuit and each land.

    Parameters
    ----------
    diagnosis
        of the unit; the stand of its vacuum test counts, with its calibrations, else that of the trade.
    job, language, paper, units, font
        as `write_gauge_card` takes them; in-Hg and kPa stand beside one another in every system of units.

    Raises
    ------
    InputError
        as `write_gauge_card`.
    """
    say, assumptions = wording(language, units), diagnosis.gauge_card.assumptions
    stand = diagnosis.vacuum_table.stand if diagnosis.vacuum_table else VacuumStand()
    tables = vacuum_card_tables(diagnosis.controller, stand, assumptions, say)
    grown = say.percent(GROWN, 0)
    words = [say("vacuum_card.title"), say("vacuum_card.subject"), say("vacuum_card.what", grown=grown)]
    fields = (
        f"{say('vacuum_card.closed')} [in-Hg]",
        f"{say('vacuum_card.ambient')} [kPa]",
        f"{say('vacuum_card.temperature')} [{say.unit('temperature')}]",
    )
    notes = vacuum_card_notes(stand, tables, assumptions, say)
    return _card(diagnosis, job, say, paper, font, tables, words, notes, fields)


def _card(
    diagnosis: Diagnosis,
    job: Job | None,
    say: Wording,
    paper: str,
    font: OwnFont | None,
    tables: Sequence[Table],
    words: Sequence[str],
    notes: Iterable[str],
    fields: Sequence[str],
    facts: Sequence[Sequence[str]] = (),
) -> bytes:
    """Return the bytes of a card: tables with room for what is read; words are its title, subject and what to do."""
    job = job or Job()
    title, subject, what = words
    known = {"number": job.number, "vehicle": PrintedNames(diagnosis, job, say).vehicle, "vin": job.vehicle.vin}
    data: dict[str, Any] = {
        "facts": [
            [say("facts.controller"), say.name(diagnosis.controller.name)],
            *facts,
            *([say(f"facts.{key}"), value] for key, value in known.items() if value),
        ],
        "fields": [
            say("facts.date"),
            *(say(f"facts.{key}") for key, value in known.items() if key != "vin" and not value),
            *fields,
        ],
        "what": what,
        "tables": [[table.title, printed(table)] for table in tables],
        "notes": [*notes],
    }
    letterhead, head = job.letterhead, (title, subject)
    return write_page(
        "gauge_card", head, job, paper, say, lambda _: data, pictured=letterhead, date=job.date, font=font
    )
