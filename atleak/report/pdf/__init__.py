"""Print a diagnosis as a PDF that a workshop hands over: PDF/A-2a and PDF/UA-1 where its fonts allow.

The same job gives the same bytes: the only date in the file is that of the job.
"""

from __future__ import annotations

import datetime as dt
import json
import shutil
import tempfile
import unicodedata
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import typst

from atleak.diagnosis import Diagnosis, LandDiagnosis
from atleak.job.record import Job, clean_text
from atleak.look import LOOKS, PAPER
from atleak.paper import DEFAULT_PAPER, Paper, find_paper
from atleak.report.pdf.blocks import joined
from atleak.report.pdf.body import BARS, Body, chosen_sections
from atleak.report.pdf.boxes import BOX_FONT, box_font
from atleak.report.pdf.front import Front
from atleak.report.pdf.pictures import write_pictures
from atleak.report.pdf.pressures import Pressures
from atleak.report.pdf.printed_names import PrintedNames
from atleak.report.printed_charts import FONTS, Bar, glyphs, road_chart, shares_chart
from atleak.system.marks import KEYWORD
from atleak.verdicts import VERDICTS, Verdict
from atleak.version import __version__
from atleak.views.diagnosis_record import diagnosis_record
from atleak.views.drawing import controller_svg, shortened
from atleak.views.road_series import RoadSeries, road_series
from atleak.wording import Wording, wording
from atleak.workshop_units import DM3_MIN, PERCENT

STANDARDS: tuple[typst.PDFStandard, ...] = ("a-2a", "ua-1")
TEMPLATE = Path(__file__).parent.parent / "templates" / "report.typ"
_ROAD_POINTS = 1200
_LABEL = 48  # characters that fit beside a bar
_UNDATED = dt.date(2000, 1, 1)  # PDF/A requires a date; today's date would make two files of one job differ
_MISSING_NAMED = 8


def write_pdf(
    diagnosis: Diagnosis,
    job: Job | None = None,
    *,
    language: str = "en",
    paper: str = DEFAULT_PAPER,
    sections: Iterable[str] | None = None,
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

    Raises
    ------
    InputError
        if the language, paper or section is unknown, or a picture cannot be read.

    Notes
    -----
    Where a text holds characters that the bundled fonts lack (an emoji, say), the file is a plain PDF and
    says so on top of its first page.
    """
    job, say = job or Job(), wording(language)
    chosen = chosen_sections(sections, without_sheet=diagnosis.without_sheet)
    size = find_paper(paper)
    with tempfile.TemporaryDirectory(prefix="atleak-", ignore_cleanup_errors=True) as folder:
        pictures = write_pictures(job, Path(folder))
        data = report_data(diagnosis, job, say, size, chosen, pictures)
        shutil.copy(TEMPLATE, folder)
        return _compile(Path(folder), data, job.date, say)


def report_data(
    diagnosis: Diagnosis, job: Job, say: Wording, paper: Paper, chosen: tuple[str, ...], pictures: dict[str, str]
) -> dict[str, Any]:
    series = road_series(diagnosis.road, _ROAD_POINTS) if diagnosis.road and "road_test" in chosen else None
    names = PrintedNames(diagnosis, diagnosis_record(diagnosis), job, say)
    front, body = Front(names, pictures), Body(names, series, pictures)
    charts = _draw_charts(names, series, chosen, body.pressures)
    title = say("title.report")
    return {
        "lang": say.language,
        "paper": paper.typst,
        "title": title,
        "author": job.workshop.name or "atleak",
        "description": say("title.subject"),
        "keywords": KEYWORD,
        "running": joined((job.workshop.name, job.number, job.vehicle.registration or job.vehicle.vin), " · "),
        "made": f"atleak {__version__}",
        "page": say("title.page", page="{page}", pages="{pages}"),
        "note": None,
        "more-fonts": [],
        "head": front.head(),
        "facts": front.facts(),
        "verdict": front.verdict(),
        "sections": body.sections(chosen, {name: name for name in charts}),
        "charts": charts,
        "inks": {"ink": PAPER.ink, "soft": PAPER.soft, "rule": PAPER.rule},
        "looks": {verdict: _look(verdict) for verdict in VERDICTS},
    }


def _look(verdict: Verdict) -> dict[str, Any]:
    """Return what the template needs to draw a verdict: colours, corners of its sign, whether its word is bold."""
    look = LOOKS[verdict]
    return {
        "line": look.line,
        "tint": look.tint,
        "on-tint": look.on_tint,
        "corners": [list(point) for point in look.shape.points],
        "filled": look.shape.filled,
        "ground": verdict.flagged,
        "bold": verdict.calls_for_repair,
    }


def _draw_charts(
    names: PrintedNames, series: RoadSeries | None, chosen: tuple[str, ...], pressures: Pressures
) -> dict[str, str]:
    """Return every drawing of the chosen sections as SVG, by name."""
    diagnosis, say = names.diagnosis, names.say
    at = diagnosis.projection
    charts = {}
    if "picture" in chosen:
        verdicts = {land.key: land.verdict for land in diagnosis.lands}
        charts["picture"] = controller_svg(diagnosis.controller, verdicts, columns=6)
    if "shares" in chosen and at.leakage > 0.0 and at.pump_capacity > 0.0:
        label = say("charts.share_of_pump", condition=names.condition(at.condition))
        charts["shares"] = shares_chart([_bar(names, land) for land in diagnosis.ranked[:BARS]], label, say)
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


# --- typst


@cache
def bundled_fonts() -> typst.Fonts:
    """Return the fonts of the package and no others."""
    return typst.Fonts(include_system_fonts=False, include_embedded_fonts=False, font_paths=[str(FONTS)])


def _compile(folder: Path, data: dict[str, Any], date: dt.date | None, say: Wording) -> bytes:
    data = _cleaned(data)
    moment = dt.datetime.combine(date or _UNDATED, dt.time(), dt.UTC)

    def run(fonts: typst.Fonts, standards: Sequence[typst.PDFStandard], **changes: Any) -> bytes:
        compiler = typst.Compiler(folder / TEMPLATE.name, root=folder, font_paths=fonts)
        inputs = {"data": json.dumps({**data, **changes}, ensure_ascii=False)}
        pdf = compiler.compile(format="pdf", sys_inputs=inputs, pdf_standards=list(standards), timestamp=moment)
        assert isinstance(pdf, bytes)  # typst returns bytes for one document that it writes to no file
        return pdf

    try:
        return run(bundled_fonts(), STANDARDS)
    except typst.TypstError as error:
        missing = _missing_characters(data)
        if not missing:
            reason = str(error.message).splitlines()[0]
            return run(bundled_fonts(), (), note=say("title.plain_other", reason=reason))
        (folder / "boxes.ttf").write_bytes(box_font(missing, json.dumps(data, ensure_ascii=False)))
        fonts = typst.Fonts(
            include_system_fonts=False, include_embedded_fonts=False, font_paths=[str(FONTS), str(folder)]
        )
        return run(fonts, (), note=_note(missing, say), **{"more-fonts": [BOX_FONT]})


def _note(missing: list[str], say: Wording) -> str:
    """Return why the file is a plain PDF, with the characters that no font has."""
    named = ", ".join(f"U+{ord(sign):04X} {sign}" for sign in missing[:_MISSING_NAMED])
    return say("title.plain", characters=f"{named}, …" if len(missing) > _MISSING_NAMED else named)


def _missing_characters(data: Any) -> list[str]:
    """Return the characters of the report that none of the bundled fonts has, in their order in the text."""
    seen = dict.fromkeys(json.dumps(data, ensure_ascii=False))
    return [sign for sign in seen if ord(sign) not in glyphs() and not _invisible(sign)]


def _invisible(sign: str) -> bool:
    """Tell whether nothing is drawn for a character: joiners, signs of direction, variation selectors."""
    return unicodedata.category(sign) in ("Cc", "Cf") or "VARIATION SELECTOR" in unicodedata.name(sign, "")


def _cleaned(data: Any) -> Any:
    """Return the data without the characters that a PDF cannot hold."""
    if isinstance(data, str):
        return clean_text(data)
    if isinstance(data, dict):
        return {key: _cleaned(value) for key, value in data.items()}
    return [_cleaned(value) for value in data] if isinstance(data, list) else data
