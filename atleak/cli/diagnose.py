"""Give the verdict on a unit, and its reports: ``atleak diagnose``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from atleak.cli.job_options import add_job_options, as_read, chosen_job, input_files
from atleak.cli.shared import (
    add_command,
    add_force,
    add_json,
    add_print,
    check_targets,
    say_written,
    write,
    write_json,
)
from atleak.errors import InputError
from atleak.verdicts import FLAGGED

if TYPE_CHECKING:
    from atleak.diagnosis import Diagnosis
    from atleak.job.case import Case
    from atleak.job.record import Job
    from atleak.system.marks import Kind


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(commands, "diagnose", run, "a verdict from a measuring sheet, a road test or gauge readings")
    add_job_options(parser)
    add_json(parser)
    parser.add_argument("--xlsx", metavar="FILE")
    parser.add_argument("--pdf", metavar="FILE")
    add_print(parser)
    parser.add_argument("--sections", metavar="LIST", help="of the PDF, with commas; all of them unless given")
    parser.add_argument("--job-file", metavar="FILE.zip", help="the whole job as one file")
    parser.add_argument(
        "--fail-on",
        choices=[level.value for level in FLAGGED],
        help="end with status 1 where a land, a total or a pressure is at or past this level",
    )
    add_force(parser)


def run(options: argparse.Namespace) -> int:
    """Diagnose the job, write the reports that were asked for and show the verdict."""
    from atleak.verdicts import Verdict

    for name in ("xlsx", "pdf", "job_file"):
        if getattr(options, name) == "-":
            problem = "a workbook, PDF or job file cannot be written to standard output"
            raise InputError(problem, value=f"--{name} -", expected="a file name")
    targets: list[tuple[Kind, str | None]] = [("record", options.json), ("report workbook", options.xlsx)]
    check_targets(options, input_files(options), [*targets, ("PDF", options.pdf), ("job file", options.job_file)])
    case, job = chosen_job(options)
    diagnosis = case.diagnose()
    written = _write_reports(diagnosis, job, case, options)
    if options.json != "-":
        from atleak.report.terminal import print_diagnosis

        print_diagnosis(diagnosis)
        say_written(written)
    past = options.fail_on and diagnosis.verdict.rank >= Verdict(options.fail_on).rank
    return 1 if past else 0


def _write_reports(diagnosis: Diagnosis, job: Job | None, case: Case, options: argparse.Namespace) -> list[str]:
    """Write the files asked for; return their names."""
    written = []
    if options.xlsx is not None:
        from atleak.report.xlsx import write_workbook

        content = write_workbook(diagnosis, job, **_print(options))
        written += write(options.xlsx, content)
    if options.pdf is not None:
        from atleak.report.pdf import write_pdf

        sections = None if options.sections is None else [name.strip() for name in options.sections.split(",")]
        content = write_pdf(diagnosis, job, **_print(options), sections=sections)
        written += write(options.pdf, content)
    if options.job_file is not None:
        from atleak.job.file import write_job_file

        content = write_job_file(diagnosis, job, as_read(case))
        written += write(options.job_file, content)
    if options.json is not None:  # written last: standard output stays empty when another file fails
        from atleak.views.diagnosis_record import diagnosis_record

        written += write_json(options.json, diagnosis_record(diagnosis))
    return written


def _print(options: argparse.Namespace) -> dict[str, Any]:
    """Return language, units and paper of PDF and workbook."""
    return {"language": options.language, "units": options.units, "paper": options.paper}
