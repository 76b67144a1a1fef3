"""Print a diagnosis as a PDF that a workshop hands over: PDF/A-2a and PDF/UA-1 where its fonts allow.

The same job gives the same bytes: the only date in the file is that of the job.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from atleak.diagnosis import Diagnosis
from atleak.errors import Message
from atleak.job.record import Job
from atleak.land_diagnosis import LandDiagnosis
from atleak.paper import DEFAULT_PAPER, Paper, find_paper
from atleak.report.own_font import OwnFont
from atleak.report.pdf.body import BARS, Body, chosen_sections
from atleak.report.pdf.compiling import common_data, compile_pdf, named_characters, unprintable
from atleak.report.pdf.customer import DRAWING, CustomerPage
from atleak.report.pdf.front import Front
from atleak.report.pdf.pressures import Pressures
from atleak.report.pdf.printed_names import PrintedNames
from atleak.report.pictures import write_pictures
from atleak.report.printed_charts import Bar, road_chart, shares_chart
from atleak.sentence import Sentence
from atleak.views.diagnosis_record import diagnosis_record
from atleak.views.drawing import controller_svg, shortened
from atleak.views.road_series import RoadSeries, road_series
from atleak.wording import Wording, wording
from atleak.workshop_units import DM3_MIN, PERCENT

_ROAD_POINTS = 1200
_LABEL = 48  # characters that fit beside a bar


def write_pdf(
    diagnosis: Diagnosis,
    job: Job | None = None,
    *,
    language: str = "en",
    paper: str = DEFAULT_PAPER,
    sections: Iterable[str] | None = None,
    units: str = "metric",
    font: OwnFont | None = None,
) -> bytes:
    """Return the bytes of the report.

    Parameters
    ----------
    diagnosis
        the frozen result; the report computes nothing.
    job
        what the workshop wrote down; what is not filled in is left out.
    language
        one of `atleak.wording.languages`.
    paper
        one of `atleak.paper.PAPERS`.
    sections
        names of `atleak.report.pdf.body.SECTIONS`; all of them unless given, or of a road test alone those that are not
        about lands.
    units
        one of `atleak.unit_systems.SYSTEMS`.
    font
        for characters that the bundled fonts lack.

    Raises
    ------
    InputError
        if the language, paper or section is unknown, or a picture cannot be read.

    Notes
    -----
    Where a text holds characters that no font has (an emoji, say), the file is a plain PDF and says so on top of its
    first page; `missing_characters` tells it beforehand.
    """
    job, say = job or Job(), wording(language, units)
    chosen = chosen_sections(sections, without_sheet=diagnosis.without_sheet)
    size = find_paper(paper)
    with tempfile.TemporaryDirectory(prefix="atleak-", ignore_cleanup_errors=True) as folder:
        pictures = write_pictures(job, Path(folder))
        data = report_data(diagnosis, job, say, size, chosen, pictures)
        return compile_pdf("report", Path(folder), data, job.date, say, font)


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
    diagnosis: Diagnosis, job: Job, say: Wording, paper: Paper, chosen: tuple[str, ...], pictures: dict[str, str]
) -> dict[str, Any]:
    computed = diagnosis.road if diagnosis.judged and "road_test" in chosen else None  # else it is that of a new unit
    series = None if computed is None else road_series(computed, _ROAD_POINTS)
    names = PrintedNames(diagnosis, diagnosis_record(diagnosis), job, say)
    front, body = Front(names), Body(names, series, pictures)
    customer = CustomerPage(names, signed="signatures" in chosen)
    charts = _draw_charts(names, series, chosen, body.pressures)
    worn = customer.drawing()
    charts |= {} if worn is None else {DRAWING: worn}
    return {
        **common_data(say("title.report"), say("title.subject"), job, paper, say, pictures),
        "end": body.annex.end(),
        "customer": customer.data(),
        "facts": front.facts(),
        "verdict": front.verdict(),
        "sections": body.sections(chosen, {name: name for name in charts}),
        "charts": charts,
    }


def picture_look(valves: int) -> tuple[int, float]:
    """Return how many of so many valves are drawn beside one another, and how large their names: all are legible."""
    return (4, 1.6) if valves <= 16 else (5, 1.5) if valves <= 20 else (6, 1.4)


def _draw_charts(
    names: PrintedNames, series: RoadSeries | None, chosen: tuple[str, ...], pressures: Pressures
) -> dict[str, str]:
    """Return every drawing of the chosen sections as SVG, by name."""
    diagnosis, say = names.diagnosis, names.say
    at = diagnosis.projection
    charts = {}
    if "picture" in chosen:
        verdicts = {land.key: land.verdict for land in diagnosis.lands}
        valves = {land.component for land in diagnosis.controller.lands}
        columns, letters = picture_look(len(valves))
        charts["picture"] = controller_svg(
            diagnosis.controller, verdicts, columns=columns, named=say.name, letters=letters
        )
    if "shares" in chosen and at.leakage > 0.0 and at.pump_capacity > 0.0:
        label = say("charts.share_of_pump", condition=names.condition(at.condition))
        charts["shares"] = shares_chart([_bar(names, land) for land in diagnosis.drawing_most[:BARS]], label, say)
    if "pressures" in chosen and diagnosis.profile.circuits == "on":
        charts |= pressures.drawings()
    if series is not None:
        marks = [
            (at.time, at.leakage * DM3_MIN, None if at.share is None else at.share * PERCENT)
            for at in (row.instant for row in series.instants if row.leads)
        ]
        bands = [(band, limit * PERCENT) for band, limit in diagnosis.limits.fixed_bands]
        charts["road"] = road_chart(series, marks, bands, say)
    return charts


def _bar(names: PrintedNames, land: LandDiagnosis) -> Bar:
    low, high = (land.uncertainty.share_interval if land.uncertainty else None) or (None, None)
    return Bar(
        label=shortened(names.land_name(land), _LABEL),
        share=land.share * PERCENT,
        verdict=land.verdict,
        low=None if low is None else low * PERCENT,
        high=None if high is None else high * PERCENT,
    )
