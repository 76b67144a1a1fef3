"""Give the verdict on a unit, and its reports, ``atleak diagnose``; or what is likely worn, ``atleak evidence``."""

from __future__ import annotations

import argparse
import gc
from functools import cache, partial
from typing import Any

from atleak.cli.job_options import add_job_options, as_read, chosen_job, input_files, keep_columns
from atleak.cli.parser import add_command
from atleak.cli.shared import (
    PRINTED,
    Outputs,
    Printed,
    add_force,
    add_json,
    add_print,
    add_units,
    doubt_option,
    print_font,
    print_options,
    say_doubts,
)
from atleak.common.verdicts import FLAGGED, Verdict


def add_parser(commands: Any, name: str) -> None:
    """Add one of the commands."""
    add = _add_diagnose if name == "diagnose" else _add_evidence
    add(commands, name)


def _add_diagnose(commands: Any, name: str) -> None:
    parser = add_command(
        commands,
        name,
        _diagnose,
        usage="atleak diagnose [READINGS] [--road-test LOG] [--pressures FILE] [--vacuum FILE] [--flows FILE] …",
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
    help = "customer's and workshop's report, or NAME=FILE: customer, workshop, annex, all; may be repeated"
    written.add_argument("--pdf", metavar="FILE.pdf", action=Printed, help=help)
    written.add_argument("--xlsx", metavar="FILE.xlsx", help="everything as a workbook with live formulas")
    written.add_argument("--job-file", metavar="FILE.zip", help="the whole job as one file")
    add_json(written)
    add_force(written)
    printed = parser.add_argument_group("how it is printed")
    add_print(printed, shown=["units"])
    printed.add_argument("--sections", metavar="LIST", help="of the PDF, with commas; all of the document unless given")
    parser.add_argument(
        "--fail-on",
        choices=[level.value for level in FLAGGED],
        help="end with status 1 where a land, a total or a pressure is at or past this level",
    )


def _add_evidence(commands: Any, name: str) -> None:
    parser = add_command(
        commands,
        name,
        _evidence,
        usage="atleak evidence [READINGS] [--pressures FILE] [--vacuum FILE] [--flows FILE] --controller ID|FILE …",
        examples=(
            "evidence --pressures gauges.csv --controller five_speed_2005",
            "evidence --complaint slips_hot --controller five_speed_2005",
            "evidence --pressures gauges.csv --controller five_speed_2005 --assume worn_lands_percent=30 --json -",
        ),
    )
    add_job_options(parser)
    written = parser.add_argument_group("what is written, and how it is shown")
    add_units(written)
    add_json(written)
    add_force(written)


def _evidence(options: argparse.Namespace) -> int:
    """Show what is likely worn, and what to measure next."""
    outputs = Outputs(options, input_files(options))
    case, _ = chosen_job(options, may_be_new=True)
    from atleak.common.wording import wording
    from atleak.report.tables.evidence import closed_sections, evidence_record
    from atleak.report.terminal import print_sections

    diagnosis = case.diagnose()
    keep_columns(options, case, diagnosis)
    outputs.write(json=lambda: evidence_record(diagnosis))
    if outputs.shown and not getattr(options, "quiet", False):
        say = wording("en", options.units)
        warnings = [message for message in diagnosis.messages if message.level == "warning"]
        print_sections(closed_sections(diagnosis, say), warnings, say)
    outputs.say_written()
    return 0


def _diagnose(options: argparse.Namespace) -> int:
    """Diagnose the job, write the reports that were asked for and show the verdict."""
    gc.disable()  # one job is soon done, and nearly all that is made for it stays until then
    try:
        return _diagnosed(options)
    finally:
        gc.enable()


def _diagnosed(options: argparse.Namespace) -> int:
    outputs = Outputs(options, input_files(options))
    case, job = chosen_job(options)
    printed = print_options(options, outputs.formats, shown=["units"] if outputs.shown else ())
    font = print_font(options, outputs.formats)
    if options.sections is not None and "pdf" not in outputs.formats:
        doubt_option("--sections", ["--pdf"])
    diagnosis = case.diagnose()
    keep_columns(options, case, diagnosis)
    from atleak.analysis.record_doubts import with_sheet

    job = with_sheet(job, diagnosis.readings)

    def workbook() -> bytes:
        from atleak.report.xlsx import write_workbook

        return write_workbook(diagnosis, job, **printed)

    @cache
    def attached() -> tuple[Any, ...]:
        from atleak.job.batch import attachments

        return attachments(diagnosis, job, as_read(case), **printed)

    def pdf(document: str) -> bytes:
        from atleak.report.pdf import write_pdf

        sections = None if options.sections is None else [name.strip() for name in options.sections.split(",")]
        document = "all" if sections is not None and document == "report" else document  # no part was named
        files = attached() if sections is None and document in ("annex", "all") else ()
        return write_pdf(
            diagnosis, job, **printed, document=document, sections=sections, font=font, visits=None, attached=files
        )

    def job_file() -> bytes:
        from atleak.job.zip_file import write_job_file

        return write_job_file(diagnosis, job, as_read(case))

    def record() -> dict[str, Any]:
        from atleak.job.result import result_record

        return result_record(diagnosis, job)

    pdfs = {option: partial(pdf, document) for document, option in PRINTED.items()}
    outputs.write(xlsx=workbook, **pdfs, job_file=job_file, json=record)
    if outputs.shown and not getattr(options, "quiet", False):
        from atleak.report.terminal import print_diagnosis

        print_diagnosis(diagnosis, printed["units"])
    outputs.say_written()
    if job is not None:
        from atleak.analysis.record_doubts import record_doubts

        say_doubts(record_doubts(job, diagnosis))
        if "pdf" in outputs.formats:
            from atleak.report.pdf import missing_characters

            say_doubts(missing_characters([job], font))
    past = options.fail_on and diagnosis.verdict.rank >= Verdict(options.fail_on).rank
    return 1 if past else 0
