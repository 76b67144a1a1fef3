"""Write the reports of job files: ``atleak report``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from rich.progress import Progress

from atleak.cli.parser import add_command
from atleak.cli.shared import (
    add_force,
    add_print,
    check_targets,
    named_job_files,
    print_font,
    print_options,
    say_differences,
    say_doubts,
    say_written,
)
from atleak.job.batch import REPORT_KINDS, report_paths, write_reports
from atleak.report.terminal import TerminalConsole


def add_parser(commands: Any, name: str) -> None:
    """Add the command."""
    examples = ("report jobs/2026-0417.zip -o reports", "report *.zip -o reports --formats pdf,xlsx --language pl")
    parser = add_command(commands, name, run, examples=examples)
    what = "as diagnose --job-file writes them, or folders of them"
    parser.add_argument("jobs", metavar="JOB.zip", nargs="+", help=what)
    parser.add_argument(
        "-o", "--output", metavar="FOLDER", required=True, help="where they go, named as their job files"
    )
    parser.add_argument(
        "--formats", metavar="LIST", type=_formats, default=["pdf"], help="pdf, xlsx, json, or several with commas"
    )
    add_print(parser)
    add_force(parser)


def run(options: argparse.Namespace) -> int:
    """Write the reports of every job; one that cannot be read does not stop the others."""
    printed = print_options(options, options.formats, "--formats {}")
    font = print_font(options, options.formats, "--formats pdf")
    sources = named_job_files(options.jobs)
    planned = report_paths(sources, Path(options.output), options.formats)
    check_targets(
        options, map(str, sources), ((REPORT_KINDS[form], str(path)) for of in planned for form, path in of.items())
    )
    with Progress(console=TerminalConsole(sys.stderr), transient=True, disable=getattr(options, "quiet", False)) as bar:
        task = bar.add_task("reports", total=len(sources))
        reported = write_reports(
            sources,
            Path(options.output),
            formats=options.formats,
            **printed,
            font=font,
            progress=lambda done, total, last: bar.update(task, completed=done, total=total),
        )
    for outcome in reported:
        say_written(outcome.written)
        say_doubts(outcome.doubts)
        say_differences(outcome.source.name, outcome.result_by, outcome.differs)
        if outcome.error is not None:
            print(f"atleak: {outcome.error}", file=sys.stderr)
    return 2 if any(outcome.error is not None for outcome in reported) else 0


def _formats(text: str) -> list[str]:
    names = [name.strip().lower() for name in text.split(",")]
    for name in names:
        if name not in REPORT_KINDS:
            raise argparse.ArgumentTypeError(f"{name!r} is not one of {', '.join(REPORT_KINDS)}")
    return names
