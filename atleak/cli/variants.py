"""Compute W1 to W8 of the source study: ``atleak variants``."""

from __future__ import annotations

import argparse
from typing import Any

from atleak.analysis.source_study import run_variants, sample_log
from atleak.cli.parser import add_command
from atleak.cli.shared import (
    Outputs,
    add_columns,
    add_controller,
    add_force,
    add_json,
    chosen_controller,
    chosen_road_test,
)
from atleak.common.wording import wording
from atleak.report.tables.source_study import table_2, table_3, variants_record
from atleak.report.terminal import print_table


def add_parser(commands: Any, name: str) -> None:
    """Add the command."""
    parser = add_command(commands, name, run, examples=("variants", "variants --json variants.json"))
    add_controller(parser)
    parser.add_argument("--road-test", metavar="LOG", help="your own log instead of the shipped test")
    add_columns(parser)
    add_json(parser)
    add_force(parser)


def run(options: argparse.Namespace) -> int:
    """Compute the variants and show them."""
    outputs = Outputs(options, (options.road_test, options.controller))
    options.road_test = options.road_test or sample_log()
    controller, road_test = chosen_controller(options), chosen_road_test(options)
    results = run_variants(controller, road_test)
    outputs.write(json=lambda: variants_record(results, controller, road_test))
    if outputs.shown:
        say = wording("en")
        print_table(table_2(results, say))
        print_table(table_3(results, say))
        print(
            f"Leakage in dm³/min at its maximum over the log, share in % at that instant. {say('study.table_3_help')}"
        )
    outputs.say_written()
    return 0
