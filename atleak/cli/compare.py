"""Put two jobs of one unit side by side, before and after: ``atleak compare``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from atleak.cli.parser import add_command
from atleak.cli.shared import (
    add_force,
    add_json,
    add_print,
    check_targets,
    print_font,
    print_options,
    say_doubts,
    say_written,
    write,
    write_json,
)
from atleak.errors import InputError
from atleak.sentence import Sentence


def add_parser(commands: Any) -> None:
    """Add the command, among all commands or among those of the job book."""
    parser = add_command(
        commands,
        "compare",
        run,
        "two jobs of one unit side by side, before and after",
        examples=("compare before.zip after.zip --pdf page.pdf", "compare 2026-0417 2026-0533"),
    )
    parser.add_argument(
        "before", metavar="A", help="the earlier job: a job file (zip), or its id or number in the job book"
    )
    parser.add_argument("after", metavar="B", help="the later job, likewise")
    add_json(parser)
    parser.add_argument("--pdf", metavar="FILE.pdf", help="a page for the customer")
    add_print(parser, shown=True)
    add_force(parser)


def run(options: argparse.Namespace) -> int:
    """Compare the jobs, write what was asked for and show it."""
    from atleak.jobs.compared import compare_jobs, compared_record, job_of

    if options.pdf == "-":
        problem = Sentence("a PDF cannot be written to standard output")
        raise InputError(problem, value="--pdf -", expected=Sentence("a file name"))
    inputs = [name for name in (options.before, options.after) if Path(name).is_file()]
    check_targets(options, inputs, [("record", options.json), ("PDF", options.pdf)])
    formats = [] if options.pdf is None else ["pdf"]
    shown = options.json != "-"
    printed, font = print_options(options, formats, shown=shown), print_font(options, formats)
    compared = compare_jobs(job_of(options.before), job_of(options.after))
    written = []
    if options.pdf is not None:
        from atleak.report.pdf import missing_characters
        from atleak.report.pdf.comparison import write_comparison_pdf

        before, after = compared.before.job, compared.after.job
        content = write_comparison_pdf(compared.comparison, before, after, **printed, font=font)
        say_doubts(missing_characters([before, after], font))
        written += write(options.pdf, content)
    if options.json is not None:  # written last: standard output stays empty when another file fails
        written += write_json(options.json, compared_record(compared))
    if shown:
        from atleak.report.comparison_terminal import print_comparison
        from atleak.wording import wording

        print_comparison(compared.comparison, wording(printed["language"], printed["units"]))
        say_written(written)
    return 0
