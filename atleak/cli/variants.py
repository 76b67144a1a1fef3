"""Compute W1 to W8 of the source study: ``atleak variants``."""

from __future__ import annotations

import argparse
from typing import Any

from atleak.cli.parser import add_command
from atleak.cli.shared import (
    add_columns,
    add_controller,
    add_force,
    add_json,
    check_targets,
    chosen_controller,
    chosen_road_test,
    say_written,
    write_json,
)


def add_parser(commands: Any) -> None:
    """Add the command."""
    about = "W1 to W8 of the source study, as printed and as computed"
    parser = add_command(commands, "variants", run, about, examples=("variants", "variants --json variants.json"))
    add_controller(parser)
    parser.add_argument("--road-test", metavar="LOG", help="your own log instead of the shipped test")
    add_columns(parser)
    add_json(parser)
    add_force(parser)


def run(options: argparse.Namespace) -> int:
    """Compute the variants and show them."""
    from atleak.report.terminal import print_table
    from atleak.variants import run_variants, sample_log
    from atleak.wording import wording

    check_targets(options, (options.road_test, options.controller), [("record", options.json)])
    options.road_test = options.road_test or sample_log()
    controller, road_test = chosen_controller(options), chosen_road_test(options)
    results = run_variants(controller, road_test)
    if options.json is not None:
        from atleak.views.variant_rows import variants_record

        say_written(write_json(options.json, variants_record(results, controller, road_test)))
    if options.json != "-":
        from atleak.views.variant_rows import table_2, table_3

        say = wording("en")
        print_table(table_2(results, say))
        print_table(table_3(results, say))
        print(
            f"Leakage in dm³/min at its maximum over the log, share in % at that instant. {say('study.table_3_help')}"
        )
    return 0
