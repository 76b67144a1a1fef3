"""Sum up the results of a fleet: ``atleak fleet summary``."""

from __future__ import annotations

import argparse
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from atleak.cli.parser import add_command
from atleak.cli.shared import Outputs, add_force, add_json, add_print, print_font, print_options
from atleak.errors import OutputError

if TYPE_CHECKING:
    from atleak.fleet.results import Results


def add_summary(group: Any) -> None:
    """Add the command to those about fleets."""
    parser = add_command(
        group,
        "summary",
        run,
        "what the results of a fleet say together: verdicts, wear over mileage, the worst lands, temperatures, groups",
        usage="atleak fleet summary RESULTS [--by HEADING] [--pdf FILE] [--xlsx FILE] [--json FILE|-] [options]",
        examples=(
            "fleet summary results",
            "fleet summary results --by supplier --pdf fleet.pdf --xlsx fleet.xlsx",
            "fleet summary results --controller four_speed_2023 --json -",
        ),
    )
    parser.add_argument("results", metavar="RESULTS", help="the folder that `atleak fleet run` was given with --out")
    parser.add_argument(
        "--by", metavar="HEADING", help="compare the groups of units by a column of their table, or by `group`"
    )
    parser.add_argument("--controller", metavar="ID", help="the units of this valve body alone")
    parser.add_argument("--list", metavar="N", type=_units_count, help="list so many of the worst units")
    parser.add_argument("--errors", action="store_true", help="list instead every unit without a result, and why")
    parser.add_argument("--pdf", metavar="FILE.pdf", help="the summary on a few pages, with charts")
    parser.add_argument("--xlsx", metavar="FILE.xlsx", help="everything of the summary as a workbook, with charts")
    parser.add_argument(
        "--job",
        metavar="RECORD",
        help="a job record (.toml or .json) whose workshop, with its logo, stands at the head of the PDF",
    )
    add_print(parser)
    add_json(parser)
    add_force(parser)


def _units_count(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is no number of units")
    return int(text)


def run(options: argparse.Namespace) -> int:
    """Sum up, write what was asked for, and show the summary."""
    from atleak.fleet.known import note
    from atleak.fleet.results import Results
    from atleak.fleet.summary import summed_up
    from atleak.fleet.summary_record import summary_record
    from atleak.fleet.summary_sections import TERMINAL, FleetSections
    from atleak.fleet.summary_words import FleetWords
    from atleak.fleet.summed import LISTED
    from atleak.job.file import load_job
    from atleak.report.terminal import print_sections
    from atleak.wording import wording

    outputs = Outputs(options, [options.job])
    printed, font = print_options(options, outputs.formats), print_font(options, outputs.formats)
    letterhead = None if options.job is None else load_job(options.job)
    results = Results.open(options.results)
    if options.errors and not outputs.files:
        _list_errors(results)
        return 0
    listed = LISTED if options.list is None else options.list
    summary = summed_up(results, by=options.by, controller=options.controller, listed=listed)
    with suppress(OutputError):  # where the user's folder cannot be written, a page does not offer them
        note(options.results)

    def workbook() -> bytes:
        from atleak.fleet.summary_workbook import write_summary_workbook

        return write_summary_workbook(summary, **printed)

    def pdf() -> bytes:
        from atleak.fleet.summary_pdf import write_summary_pdf

        return write_summary_pdf(summary, **printed, font=font, letterhead=letterhead)

    outputs.write(xlsx=workbook, pdf=pdf, json=lambda: summary_record(summary))
    if outputs.shown:
        if options.errors:
            _list_errors(results)
        else:
            sections = FleetSections(FleetWords(summary, wording("en")), TERMINAL)
            print_sections([sections.head(), *sections.all()])
            if summary.by is None and summary.headings:
                headings = ", ".join(summary.headings)
                print(f"Groups of units can be compared by {headings}: --by {summary.headings[0]}")
    outputs.say_written()
    return 0


def _list_errors(results: Results) -> None:
    from atleak.fleet.summed import named_message

    for row in results.table("errors", columns=["name", "kind", "message"]).to_pylist():
        print(f"{named_message(row['name'], row['message'])} ({row['kind']})")
