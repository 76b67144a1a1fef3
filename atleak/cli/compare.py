"""Put two jobs of one unit side by side, before and after: ``atleak compare``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from atleak.cli.parser import add_command
from atleak.cli.shared import Outputs, add_force, add_json, add_print, print_font, print_options, say_doubts
from atleak.common.wording import wording
from atleak.job_book.compared_jobs import compare_jobs, compared_record, job_of


def add_parser(commands: Any, name: str) -> None:
    """Add the command, among all commands or among those of the job book."""
    examples = ("compare before.zip after.zip --pdf page.pdf", "compare 2026-0417 2026-0533")
    parser = add_command(commands, name, run, examples=examples)
    help = "the earlier job: a job file (zip), or its id or number in the job book"
    parser.add_argument("before", metavar="A", help=help)
    parser.add_argument("after", metavar="B", help="the later job, likewise")
    add_json(parser)
    parser.add_argument("--pdf", metavar="FILE.pdf", help="a page for the customer")
    add_print(parser, shown=True)
    add_force(parser)


def run(options: argparse.Namespace) -> int:
    """Compare the jobs, write what was asked for and show it."""
    outputs = Outputs(options, [name for name in (options.before, options.after) if Path(name).is_file()])
    printed = print_options(options, outputs.formats, shown=outputs.shown)
    font = print_font(options, outputs.formats)
    compared = compare_jobs(job_of(options.before), job_of(options.after))

    def pdf() -> bytes:
        from atleak.report.pdf import missing_characters
        from atleak.report.pdf.comparison import write_comparison_pdf

        before, after = compared.before.job, compared.after.job
        say_doubts(missing_characters([before, after], font))
        return write_comparison_pdf(compared.comparison, before, after, **printed, font=font)

    outputs.write(pdf=pdf, json=lambda: compared_record(compared))
    if outputs.shown:
        from atleak.report.tables.comparison import comparison_sections
        from atleak.report.terminal import print_sections

        comparison, say = compared.comparison, wording(printed["language"], printed["units"])
        print_sections(comparison_sections(comparison, say, brief=True), comparison.messages)
    outputs.say_written()
    return 0
