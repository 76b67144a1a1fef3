"""Write the reports of many jobs, one after another, and report on each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from atleak.analysis.record_doubts import record_doubts
from atleak.common.damage import unexpected
from atleak.common.errors import AtleakError, Message
from atleak.common.files import replace_file
from atleak.common.seals import SealedKind
from atleak.common.sentences import Sentence
from atleak.common.style import DEFAULT_PAPER
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording, wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.job.case import Case
from atleak.job.parts import JobFile
from atleak.job.result import judged_otherwise, result_record
from atleak.job.zip_file import read_job_file, write_job_file
from atleak.measurements.job_card import Job
from atleak.report.json.diagnosis import diagnosis_record, to_json
from atleak.report.pdf import missing_characters, write_pdf
from atleak.report.pdf.typesetting import Attachment
from atleak.report.printed_fonts import OwnFont
from atleak.report.xlsx import write_workbook

_JSON, _WORKBOOK = "application/json", "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet"
REPORT_KINDS: dict[str, SealedKind] = {"pdf": "PDF", "xlsx": "report workbook", "json": "record"}


@dataclass(frozen=True)
class Reported:
    """The outcome for one job: the files written, or why there are none."""

    source: Path  # the job file
    written: tuple[Path, ...] = ()  # reports, in the order of their formats
    verdict: Verdict | None = None  # None where there is none
    error: AtleakError | None = None  # why nothing was written
    result_by: str = ""  # the version of atleak by which the job file's result was made
    differs: tuple[Sentence, ...] = ()  # from that result
    doubts: tuple[Message, ...] = ()  # about the record


def report_paths(sources: Sequence[Path], folder: Path, formats: Iterable[str] = ("pdf",)) -> list[dict[str, Path]]:
    """Return where `write_reports` puts the reports: format → path, for every job file.

    Parameters
    ----------
    sources
        job files; two of one name are numbered.
    formats
        any of `REPORT_KINDS`.

    Returns
    -------
    list
        a path by format for each job file, in order; nothing is written.
    """
    taken: set[str] = set()
    stems = [_free(source.stem, taken) for source in sources]
    return [{form: folder / f"{stem}.{form}" for form in formats} for stem in stems]


def write_reports(
    sources: Sequence[Path],
    folder: Path,
    *,
    formats: Iterable[str] = ("pdf",),
    language: str = "en",
    units: str = "metric",
    paper: str = DEFAULT_PAPER,
    font: OwnFont | None = None,
    progress: Callable[[int, int, Reported], None] | None = None,
) -> list[Reported]:
    """Write the reports of every job file; a job that fails, in whatever way, is reported and stops no other.

    What stands in the place of a report is replaced, whole: ask `report_paths` where that must not be.

    Parameters
    ----------
    sources
        job files (zip), as `atleak.job.zip_file.write_job_file` makes them.
    folder
        where the reports go, named as their job files; two of one name are numbered.
    formats
        any of `REPORT_KINDS`.
    font
        for characters that the bundled fonts of the PDF lack.
    progress
        called after every job with how many are done, how many there are and what became of this one.
    """
    done = []
    folder.mkdir(parents=True, exist_ok=True)
    for source, paths in zip(sources, report_paths(sources, folder, tuple(formats)), strict=True):
        written: list[Path] = []
        try:
            job_file = read_job_file(source)
            diagnosis = job_file.diagnose()
            for form, path in paths.items():
                replace_file(path, _report(form, diagnosis, job_file, wording(language, units), paper, font))
                written.append(path)
            reported = Reported(
                source,
                tuple(written),
                diagnosis.verdict,
                result_by=job_file.result_by,
                differs=judged_otherwise(job_file.result, diagnosis_record(diagnosis), numbers=True),
                doubts=(
                    *record_doubts(job_file.job, diagnosis),
                    *(missing_characters([job_file.job], font) if "pdf" in paths else ()),
                ),
            )
        except AtleakError as error:
            reported = Reported(source, tuple(written), error=error)
        except (KeyboardInterrupt, SystemExit):
            raise
        except BaseException as error:  # noqa: BLE001 (a panic of a library in Rust is no Exception)
            reported = Reported(source, tuple(written), error=unexpected(error, source.name))
        done.append(reported)
        if progress is not None:
            progress(len(done), len(sources), reported)
    return done


def attachments(
    diagnosis: Diagnosis, job: Job | None, case: Case, *, language: str, units: str, paper: str = DEFAULT_PAPER
) -> tuple[Attachment, ...]:
    """Return what a technical annex carries: workbook, result and job file, the same bytes as when each is written."""
    say = wording(language, units)
    workbook = write_workbook(diagnosis, job, language=language, units=units, paper=paper)
    return (
        Attachment("workbook.xlsx", workbook, _WORKBOOK, "alternative", say("annex.attached_workbook")),
        Attachment("result.json", record_bytes(diagnosis, job), _JSON, "data", say("annex.attached_record")),
        Attachment(
            "job.zip", write_job_file(diagnosis, job, case), "application/zip", "source", say("annex.attached_job")
        ),
    )


def record_bytes(diagnosis: Diagnosis, job: Job | None) -> bytes:
    """Return the result as the file that ``--json`` writes."""
    return to_json(result_record(diagnosis, job)).encode("utf-8", errors="backslashreplace")


def _report(form: str, diagnosis: Diagnosis, kept: JobFile, say: Wording, paper: str, font: OwnFont | None) -> bytes:
    job, printed = kept.job, {"language": say.language, "units": say.units, "paper": paper}
    if form == "pdf":
        attached = attachments(diagnosis, job, kept.case, **printed)
        return write_pdf(diagnosis, job, **printed, font=font, visits=None, attached=attached)
    if form == "xlsx":
        return write_workbook(diagnosis, job, **printed)
    return record_bytes(diagnosis, job)


def _free(stem: str, taken: set[str]) -> str:
    name, number = stem, 2
    while name.casefold() in taken:
        name, number = f"{stem}-{number}", number + 1
    taken.add(name.casefold())
    return name
