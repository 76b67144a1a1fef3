"""Give the verdict on a unit, and its reports: ``atleak diagnose``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from atleak.cli.job_options import add_job_options, as_read, chosen_job, input_files
from atleak.cli.parser import add_command
from atleak.cli.shared import (
    add_force,
    add_json,
    add_print,
    check_targets,
    doubt_option,
    print_font,
    print_options,
    say_doubts,
    say_written,
    write,
    write_json,
)
from atleak.errors import InputError
from atleak.sentence import Sentence
from atleak.verdicts import FLAGGED

if TYPE_CHECKING:
    from atleak.diagnosis import Diagnosis
    from atleak.job.case import Case
    from atleak.job.record import Job
    from atleak.report.own_font import OwnFont
    from atleak.system.marks import Kind


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "diagnose",
        run,
        "a verdict from a measuring sheet, a road test or gauge readings",
        usage="atleak diagnose [READINGS] [--road-test LOG] [--pressures FILE] [options]",
        examples=(
            "diagnose sheet.xlsx",
            "diagnose sheet.xlsx --road-test log.csv --pdf report.pdf --xlsx report.xlsx",
            "diagnose sheet.xlsx --controller my_unit.toml --temperature 95 --rpm 800 --gear 3",
            "diagnose --road-test log.csv --map main_pressure=PL --unit main_pressure=bar",
            "diagnose sheet.xlsx --job job.toml --pdf bericht.pdf --language de --units metric_bar",
            "diagnose sheet.xlsx --json - --fail-on replace",
        ),
    )
    add_job_options(parser)
    written = parser.add_argument_group("what is written")
    written.add_argument("--pdf", metavar="FILE.pdf", help="the report for customer and file")
    written.add_argument("--xlsx", metavar="FILE.xlsx", help="everything as a workbook with live formulas")
    written.add_argument("--job-file", metavar="FILE.zip", help="the whole job as one file")
    add_json(written)
    add_force(written)
    printed = parser.add_argument_group("how it is printed")
    add_print(printed)
    printed.add_argument("--sections", metavar="LIST", help="of the PDF, with commas; all of them unless given")
    parser.add_argument(
        "--fail-on",
        choices=[level.value for level in FLAGGED],
        help="end with status 1 where a land, a total or a pressure is at or past this level",
    )


def run(options: argparse.Namespace) -> int:
    """Diagnose the job, write the reports that were asked for and show the verdict."""
    from atleak.verdicts import Verdict

    for name in ("xlsx", "pdf", "job_file"):
        if getattr(options, name) == "-":
            problem = Sentence("a workbook, PDF or job file cannot be written to standard output")
            raise InputError(problem, value=f"--{name} -", expected=Sentence("a file name"))
    targets: list[tuple[Kind, str | None]] = [("record", options.json), ("report workbook", options.xlsx)]
    check_targets(options, input_files(options), [*targets, ("PDF", options.pdf), ("job file", options.job_file)])
    case, job = chosen_job(options)
    formats = [name for name in ("pdf", "xlsx") if getattr(options, name) is not None]
    printed, font = print_options(options, formats), print_font(options, formats)
    if options.sections is not None and options.pdf is None:
        doubt_option("--sections", ["--pdf"])
    from atleak.job.of_sheet import with_sheet

    diagnosis = case.diagnose()
    job = with_sheet(job, diagnosis.readings)
    written = _write_reports(diagnosis, job, case, options, printed, font)
    if options.json != "-":
        from atleak.report.terminal import print_diagnosis

        print_diagnosis(diagnosis)
        say_written(written)
    if job is not None:
        from atleak.job.doubts import record_doubts

        say_doubts(record_doubts(job, diagnosis))
        if options.pdf is not None:
            from atleak.report.pdf import missing_characters

            say_doubts(missing_characters([job], font))
    past = options.fail_on and diagnosis.verdict.rank >= Verdict(options.fail_on).rank
    return 1 if past else 0


def _write_reports(
    diagnosis: Diagnosis,
    job: Job | None,
    case: Case,
    options: argparse.Namespace,
    printed: dict[str, str],
    font: OwnFont | None,
) -> list[str]:
    """Write the files asked for; return their names."""
    written = []
    if options.xlsx is not None:
        from atleak.report.xlsx import write_workbook

        written += write(options.xlsx, write_workbook(diagnosis, job, **printed))
    if options.pdf is not None:
        from atleak.report.pdf import write_pdf

        sections = None if options.sections is None else [name.strip() for name in options.sections.split(",")]
        content = write_pdf(diagnosis, job, **printed, sections=sections, font=font)
        written += write(options.pdf, content)
    if options.job_file is not None:
        from atleak.job.file import write_job_file

        content = write_job_file(diagnosis, job, as_read(case))
        written += write(options.job_file, content)
    if options.json is not None:  # written last: standard output stays empty when another file fails
        from atleak.job.issued import issued_record

        written += write_json(options.json, issued_record(diagnosis, job))
    return written
