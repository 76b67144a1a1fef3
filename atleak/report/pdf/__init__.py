"""Print a diagnosis as a PDF that a workshop hands over: PDF/A and PDF/UA-1 where its fonts allow.

The same job gives the same bytes: the only date in the file is that of the job.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

from atleak.analysis.changes import Comparison
from atleak.common.errors import Message
from atleak.common.sentences import Sentence
from atleak.common.style import DEFAULT_PAPER
from atleak.common.wording import Wording, joined, wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import Job
from atleak.report.pdf.annex import Annex
from atleak.report.pdf.body import Body, chosen_sections
from atleak.report.pdf.customer import CustomerPage
from atleak.report.pdf.front import Front
from atleak.report.pdf.typesetting import Attachment, named_characters, unprintable, write_page
from atleak.report.printed_fonts import OwnFont
from atleak.report.printed_names import PrintedNames
from atleak.report.tables.road_test import road_series

_ROAD_POINTS = 1200


def write_pdf(
    diagnosis: Diagnosis,
    job: Job | None = None,
    *,
    language: str = "en",
    paper: str = DEFAULT_PAPER,
    document: str = "all",
    sections: Iterable[str] | None = None,
    units: str = "metric",
    font: OwnFont | None = None,
    visits: Comparison | None = None,
    attached: Sequence[Attachment] = (),
) -> bytes:
    """Return the bytes of the report.

    Parameters
    ----------
    diagnosis
        the frozen result; the report computes nothing.
    job
        what the workshop wrote down; what is not filled in is left out.
    language
        one of `atleak.common.wording.languages`.
    paper
        one of `atleak.common.style.PAPERS`.
    document
        one of `atleak.report.pdf.body.DOCUMENTS`: the customer's page, the workshop's report, the annex, or several.
    sections
        names of `atleak.report.pdf.body.PDF_SECTIONS`; all of the document unless given, or of a road test alone those
        not about lands.
    units
        one of `atleak.common.units.SYSTEMS`.
    font
        for characters that the bundled fonts lack.
    visits
        this result beside that of another visit of the unit, for the customer's page.
    attached
        files that it carries, such as those of `atleak.job.batch.attachments`; it is PDF/A-3a then.

    Raises
    ------
    InputError
        if the language, paper, document or section is unknown, or a picture cannot be read.

    Notes
    -----
    Where a text holds characters that no font has (an emoji, say), the file is a plain PDF and says so on top of its
    first page; `missing_characters` tells it beforehand.
    """
    filled, say = job or Job(), wording(language, units)
    chosen = chosen_sections(sections, document, without_sheet=diagnosis.without_sheet)
    words = say("title.report"), say("title.subject")
    files = joined(each.name for each in attached)
    note = say("annex.attached", files=files) if files else ""
    data = partial(report_data, diagnosis, filled, say, chosen, document=document, note_at_end=note, visits=visits)
    return write_page("report", words, filled, paper, say, data, date=filled.date, font=font, attached=attached)


def missing_characters(jobs: Iterable[Job], font: OwnFont | None = None) -> list[Message]:
    """Return a message that names the characters of some records that show as boxes in print; none without such."""
    missing = unprintable("".join(job.model_dump_json() for job in jobs), font)
    if not missing:
        return []
    text = Sentence(
        "the fonts of the PDF lack {characters}, which show as boxes: name a font file that has them",
        characters=named_characters(missing),
    )
    return [Message("warning", "characters_missing", text)]


def report_data(
    diagnosis: Diagnosis,
    job: Job,
    say: Wording,
    chosen: tuple[str, ...],
    pictures: dict[str, str],
    *,
    document: str = "all",
    visits: Comparison | None = None,
    note_at_end: str = "",
) -> dict[str, Any]:
    """Return what the template of the report places beside `common_data`."""
    computed = diagnosis.road if diagnosis.judged and "road_log" in chosen else None  # else it is that of a new unit
    series = None if computed is None else road_series(computed, _ROAD_POINTS)
    names = PrintedNames(diagnosis, job, say)
    front, parts = Front(names), Body(names, series, pictures).parts(chosen, document)
    page = CustomerPage(names, signed="signatures" in chosen, visits=visits)
    return {
        "end": Annex(names).end(),
        "customer": None
        if document in ("workshop", "annex")
        else page.data(behind=parts[0]["title"] if parts else "", pictures=pictures),
        "opening": {
            "facts": front.facts(),
            "verdict": front.verdict() | ({"more": "", "complaint": None} if document == "annex" else {}),
        }
        if parts
        else None,
        "parts": parts,
        "note-at-end": note_at_end,
    }
