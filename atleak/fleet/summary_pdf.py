"""Print a fleet's summary as a PDF: the headline first, then each valve body's pairs, wear, temperatures and groups.

PDF/A-2a and PDF/UA-1 where the fonts allow, as every report of atleak; the same summary gives the same bytes.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from atleak.common.style import DEFAULT_PAPER, HEADING
from atleak.common.wording import joined, wording
from atleak.fleet.summary_sections import Depth, FleetSections
from atleak.fleet.summary_words import FleetWords
from atleak.fleet.sums import FleetSummary
from atleak.measurements.job_card import Job
from atleak.report.charts.drawing import shortened
from atleak.report.charts.paper import drawn_on_paper
from atleak.report.pdf.blocks import section_blocks
from atleak.report.pdf.typesetting import write_page
from atleak.report.printed_fonts import OwnFont
from atleak.report.tables.table import Picture

DETAILED = 3  # most valve bodies with sections of their own
DEPTHS = {  # by the number of valve bodies with sections: eight pages hold them
    1: Depth(12, 12, 6, 6, 12, 8, units=20, message=300, bodies=DETAILED, compared=False),
    2: Depth(8, 8, 4, 3, 8, 4, units=16, message=300, bodies=DETAILED, compared=False),
    3: Depth(6, 0, 4, 0, 5, 3, units=10, message=300, bodies=DETAILED, compared=False),
}
_LOW = 0.66  # of the height of charts over temperature, where there is little room


def write_summary_pdf(
    summary: FleetSummary,
    *,
    language: str = "en",
    paper: str = DEFAULT_PAPER,
    units: str = "metric",
    font: OwnFont | None = None,
    letterhead: Job | None = None,
) -> bytes:
    """Return the bytes of the PDF.

    Parameters
    ----------
    summary
        the fleet in numbers; nothing is computed from it.
    language, paper, units, font
        as `atleak.report.pdf.write_pdf` takes them.
    letterhead
        a job record whose workshop stands at the head, with its logo; nothing else of it is printed.

    Raises
    ------
    InputError
        if the language, the paper or the system of units is unknown, or the logo cannot be read.

    Notes
    -----
    The first `DETAILED` valve bodies have sections of their own, the more of them the shorter; all are in the table of
    verdicts, and in the workbook.
    """
    say = wording(language, units)
    words = FleetWords(summary, say)
    several = max(min(len(summary.bodies), DETAILED), 1)
    sections = FleetSections(words, DEPTHS[several])
    scale = 1.0 if DEPTHS[several].drawn else _LOW

    def draw(picture: Picture) -> str:
        return drawn_on_paper(picture.chart, say, scale=scale)

    head = Job() if letterhead is None else letterhead.letterhead
    title, name = say("fleet_summary.title"), Path(summary.folder).name
    data: dict[str, Any] = {
        "name": joined((title, name), " · "),
        "running": shortened(name, 60),
        "subtitle": say("fleet_summary.subtitle", folder=summary.folder),
        "headline": words.headline(),
        "findings": " ".join(words.findings()),
        "facts": sections.facts()[1:],  # the folder stands in the subtitle
        "ground": HEADING,
        "sections": [section_blocks(section, draw, say) for section in sections.all()],
    }
    return write_page("fleet", (title, say("fleet_summary.subject")), head, paper, say, lambda _: data, font=font)
