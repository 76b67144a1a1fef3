"""Set pages with typst: as PDF/A and PDF/UA-1 where the bundled fonts allow, else as a plain PDF that says so.

PDF/A-2a holds no files; with files attached it is PDF/A-3a.

Typst also turns the core's drawings into pictures for programs that take no SVG.
"""

from __future__ import annotations

import datetime as dt
import io
import json
import shutil
import tempfile
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

import typst
from PIL import Image, ImageColor

from atleak.common.pictures import printable_picture
from atleak.common.seals import KEYWORD
from atleak.common.style import LOOKS, PAPER_INKS, SHEET_OF_PAPER, Paper, find_paper
from atleak.common.verdicts import VERDICTS, Verdict
from atleak.common.wording import Wording, joined
from atleak.measurements.job_card import Job, clean_text
from atleak.report.charts.drawing import shortened
from atleak.report.printed_fonts import BOX_FONT, FONTS, OWN_FONT, OwnFont, box_font, characters_of
from atleak.version import __version__

DOTS = 150  # of an inch: on paper, where a sheet is shrunk, about 200
_PAGES = b"""
#for each in json(bytes(sys.inputs.drawings)) {
  page(width: each.width * 1pt, height: each.height * 1pt, margin: 0pt, fill: rgb(each.ground),
    image(bytes(each.svg), format: "svg", width: 100%, height: 100%))
}
"""


@dataclass(frozen=True)
class Drawing:
    """A drawing as SVG, the size in which it is shown [pt], and the colour of what lies under it."""

    svg: str
    width: float
    height: float
    ground: str = SHEET_OF_PAPER


@dataclass(frozen=True)
class Attachment:
    """A file that a PDF carries; ``relationship`` to what is printed: ``source``, ``data`` or ``alternative``."""

    name: str
    content: bytes
    mime_type: str
    relationship: str
    about: str


def write_pictures(job: Job, folder: Path) -> dict[str, str]:
    """Write the job's pictures beside the template, upright and no larger than they are printed; return their files."""
    files = {}
    for number, (name, content) in enumerate(job.pictures.items()):
        suffix, content = printable_picture(name, content)
        files[name] = f"picture{number}.{suffix}"
        (folder / files[name]).write_bytes(content)
    return files


@cache
def bundled_fonts() -> typst.Fonts:
    """Return the fonts of the package and no others."""
    return typst.Fonts(include_system_fonts=False, include_embedded_fonts=False, font_paths=[str(FONTS)])


def pngs_of(drawings: Sequence[Drawing]) -> list[bytes]:
    """Return each drawing as PNG in shades of grey, all drawn in one go; the same drawings give the same bytes."""
    if not drawings:
        return []
    given = [asdict(each) for each in drawings]
    compiler = typst.Compiler(_PAGES, font_paths=bundled_fonts())
    drawn = compiler.compile(format="png", ppi=DOTS, sys_inputs={"drawings": json.dumps(given)})
    assert drawn is not None  # typst returns what it writes to no file
    pages = drawn if isinstance(drawn, list) else [drawn]
    return [_small(png, each.ground) for png, each in zip(pages, drawings, strict=True)]


def _small(png: bytes, ground: str) -> bytes:
    """Return a picture in few shades of grey, a third as large, which says how many dots an inch has."""
    target = io.BytesIO()
    grey = Image.open(io.BytesIO(png)).convert("L").point(_shades(ground))
    grey.save(target, "PNG", dpi=(DOTS, DOTS))
    return target.getvalue()


@cache
def _shades(ground: str) -> list[int]:
    """Return for every shade the nearest one that is kept: sixteen and that of the ground, so that no box is seen."""
    kept = (*range(0, 256, 17), ImageColor.getcolor(ground, "L"))
    return [min(kept, key=lambda shade: abs(shade - each)) for each in range(256)]


_ALONE: tuple[typst.PDFStandard, ...] = ("a-2a", "ua-1")
_WITH_FILES: tuple[typst.PDFStandard, ...] = ("a-3a", "ua-1")
TEMPLATES = Path(__file__).parent.parent / "templates"
_UNDATED = dt.date(2000, 1, 1)  # PDF/A requires a date; today's date would make two files of one job differ
_MISSING_NAMED = 8
_RUNNING = 24  # letters of each name that stand at the head of every page, in one line


def common_data(
    title: str, subject: str, job: Job, paper: Paper, say: Wording, pictures: dict[str, str]
) -> dict[str, Any]:
    """Return what ``common.typ`` places on every kind of page: the file's properties, letterhead, colours and signs."""
    plate = job.vehicle.registration or job.vehicle.vin
    return {
        "lang": say.language,
        "paper": paper.typst,
        "title": title,
        "name": joined((title, job.number, plate), " · "),
        "author": job.workshop.name or "atleak",
        "description": subject,
        "keywords": KEYWORD,
        "running": joined((shortened(each, _RUNNING) for each in (job.workshop.name, job.number, plate)), " · "),
        "made": f"atleak {__version__}",
        "page": say("title.page", page="{page}", pages="{pages}"),
        "end": "",
        "note": None,
        "more-fonts": [],
        "head": _letterhead(job, pictures, say),
        "inks": {"ink": PAPER_INKS.ink, "soft": PAPER_INKS.soft, "rule": PAPER_INKS.rule},
        "looks": {verdict: _look(verdict) for verdict in VERDICTS},
    }


def _letterhead(job: Job, pictures: dict[str, str], say: Wording) -> dict[str, Any]:
    shop = job.workshop
    lines = [
        *shop.address.splitlines(),
        f"{say('facts.phone')} {shop.phone}" if shop.phone else "",
        shop.email,
        shop.website,
        f"{say('facts.register')} {shop.registration}" if shop.registration else "",
    ]
    return {
        "workshop": shop.name,
        "lines": [line for line in lines if line],
        "logo": pictures.get(shop.logo or ""),
        "logo-alt": shop.name or say("title.logo"),
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


def write_page(
    template: str,
    words: tuple[str, str],
    job: Job,
    paper: str,
    say: Wording,
    data: Callable[[dict[str, str]], Mapping[str, Any]],
    *,
    pictured: Job | None = None,
    date: dt.date | None = None,
    font: OwnFont | None = None,
    attached: Sequence[Attachment] = (),
) -> bytes:
    """Return the bytes of a PDF.

    Parameters
    ----------
    template
        name of one of the package's templates, without its ending.
    words
        title and subject.
    job
        whose workshop, number and vehicle stand at the head; with its pictures, unless another record is ``pictured``.
    data
        what the template places beside `common_data`, given the files of the pictures by their names.
    date
        of the file; a fixed one where none is given.
    font
        for characters that the package's own ones lack; without such characters it changes nothing.
    attached
        files that it carries.
    """
    size = find_paper(paper)
    with tempfile.TemporaryDirectory(prefix="atleak-", ignore_cleanup_errors=True) as folder:
        pictures = write_pictures(pictured or job, Path(folder))
        files = [{**asdict(each), "content": f"attached{number}"} for number, each in enumerate(attached)]
        for file, each in zip(files, attached, strict=True):
            (Path(folder) / file["content"]).write_bytes(each.content)
        placed = {**common_data(*words, job, size, say, pictures), "attached": files, **data(pictures)}
        return _compiled(template, Path(folder), placed, date, say, font)


def _compiled(
    template: str, folder: Path, data: dict[str, Any], date: dt.date | None, say: Wording, own: OwnFont | None
) -> bytes:
    for path in TEMPLATES.glob("*.typ"):
        shutil.copy(path, folder)
    data = _cleaned(data)
    moment = dt.datetime.combine(date or _UNDATED, dt.time(), dt.UTC)

    def run(fonts: typst.Fonts, standards: Sequence[typst.PDFStandard], **changes: Any) -> bytes:
        compiler = typst.Compiler(folder / f"{template}.typ", root=folder, font_paths=fonts)
        inputs = {"data": json.dumps({**data, **changes}, ensure_ascii=False)}
        pdf = compiler.compile(format="pdf", sys_inputs=inputs, pdf_standards=list(standards), timestamp=moment)
        assert isinstance(pdf, bytes)  # typst returns bytes for one document that it writes to no file
        return _made_by_atleak(pdf)

    said = json.dumps(data, ensure_ascii=False)
    families = []
    if own is not None and own.glyphs.intersection(map(ord, unprintable(said))):
        (folder / "own.ttf").write_bytes(own.content)
        families.append(OWN_FONT)

    def fonts() -> typst.Fonts:
        paths = [str(FONTS), *([str(folder)] if families else [])]
        return typst.Fonts(include_system_fonts=False, include_embedded_fonts=False, font_paths=paths)

    try:
        standards = _WITH_FILES if data["attached"] else _ALONE
        return run(fonts() if families else bundled_fonts(), standards, **{"more-fonts": families})
    except typst.TypstError as error:
        missing = unprintable(said, own)
        if not missing:
            reason = str(error.message).splitlines()[0]
            note = say("title.plain_other", reason=reason)
            return run(fonts(), (), note=note, **{"more-fonts": families})
        (folder / "boxes.ttf").write_bytes(box_font(missing, said))
        families.append(BOX_FONT)
        note = say("title.plain", characters=named_characters(missing))
        return run(fonts(), (), note=note, **{"more-fonts": families})


def _made_by_atleak(pdf: bytes) -> bytes:
    """Name atleak as the program that made the file, in its information and its metadata alike; its size stays."""
    for before, after in ((b"/Creator(", b")"), (b"<xmp:CreatorTool>", b"</xmp:CreatorTool>")):
        start = pdf.find(before)
        end = pdf.find(after, start)
        if start < 0 or end < 0:
            continue
        room = end - start - len(before)
        name = next(each for each in (f"atleak {__version__}", "atleak", "") if len(each) <= room).encode()
        if name:
            pdf = pdf[:start] + before + name + after + b" " * (room - len(name)) + pdf[end + len(after) :]
    return pdf


def named_characters(missing: Sequence[str]) -> str:
    """Return the first of some characters with their code points."""
    named = ", ".join(f"U+{ord(sign):04X} {sign}" for sign in missing[:_MISSING_NAMED])
    return f"{named}, …" if len(missing) > _MISSING_NAMED else named


def unprintable(text: str, own: OwnFont | None = None) -> list[str]:
    """Return the characters of a text that no font of the report has, in their order in the text."""
    known = characters_of(own)
    return [sign for sign in dict.fromkeys(text) if ord(sign) not in known and not _invisible(sign)]


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
