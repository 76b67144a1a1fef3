"""Sum up the results of a fleet: ``atleak fleet summary``."""

from __future__ import annotations

import argparse
from typing import Any

from atleak.cli.parser import add_command
from atleak.cli.shared import add_force, add_json, check_targets, say_written, write_json


def add_summary(group: Any) -> None:
    """Add the command to those about fleets."""
    parser = add_command(
        group,
        "summary",
        run,
        "what the results of a fleet say together: verdicts, wear over mileage, the worst lands, temperatures, groups",
        usage="atleak fleet summary RESULTS [--by HEADING] [--controller ID] [--json FILE|-] [options]",
        examples=(
            "fleet summary results",
            "fleet summary results --by supplier",
            "fleet summary results --controller four_speed_2023 --json -",
        ),
    )
    parser.add_argument("results", metavar="RESULTS", help="the folder that `atleak fleet run` was given with --out")
    parser.add_argument(
        "--by", metavar="HEADING", help="compare the groups of units by a column of their table, or by `group`"
    )
    parser.add_argument("--controller", metavar="ID", help="the units of this valve body alone")
    parser.add_argument("--list", metavar="N", type=_count, help="list so many of the worst units")
    add_json(parser)
    add_force(parser)


def _count(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is no number of units")
    return int(text)


def run(options: argparse.Namespace) -> int:
    """Sum up, write what was asked for, and show the summary."""
    from atleak.fleet.results import Results
    from atleak.fleet.summary import summed_up
    from atleak.fleet.summary_record import summary_record
    from atleak.fleet.summary_terminal import print_summary
    from atleak.fleet.summed import LISTED

    check_targets(options, [], [("record", options.json)])
    results = Results.open(options.results)
    listed = LISTED if options.list is None else options.list
    summary = summed_up(results, by=options.by, controller=options.controller, listed=listed)
    if options.json != "-":
        print_summary(summary)
    if options.json is not None:
        say_written(write_json(options.json, summary_record(summary)))
    return 0
