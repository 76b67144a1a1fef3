"""Write a measuring sheet to fill in: ``atleak template``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from atleak.cli.parser import add_command
from atleak.cli.shared import (
    add_controller,
    add_force,
    check_targets,
    chosen_controller,
    say_written,
    write,
)
from atleak.errors import InputError
from atleak.sentence import Sentence
from atleak.unit_systems import SYSTEMS
from atleak.wording import languages


def add_parser(commands: Any) -> None:
    """Add the command."""
    examples = ("template -o sheet.xlsx", "template --controller five_speed_2005 -o sheet.xlsx")
    parser = add_command(commands, "template", run, "a measuring sheet to fill in", examples=examples)
    add_controller(parser)
    parser.add_argument("-o", "--output", metavar="FILE.xlsx", required=True, help="the sheet")
    parser.add_argument(
        "--language", choices=languages(), default="en", help="of the sheet; any is read back: en unless given"
    )
    parser.add_argument("--units", choices=tuple(SYSTEMS), default="metric", help="of the sheet: metric unless given")
    add_force(parser)


def run(options: argparse.Namespace) -> int:
    """Write the sheet."""
    from atleak.report.measuring_sheet import write_template

    if Path(options.output).suffix.lower() != ".xlsx":
        problem = Sentence("the measuring sheet is an Excel workbook")
        raise InputError(problem, value=options.output, expected=Sentence("a name{suffix}", suffix=".xlsx"))
    check_targets(options, [options.controller], [("measuring sheet", options.output)])
    content = write_template(chosen_controller(options), language=options.language, units=options.units)
    say_written(write(options.output, content))
    return 0
