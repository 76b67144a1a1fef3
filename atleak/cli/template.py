"""Write a measuring sheet to fill in: ``atleak template``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from atleak.cli.shared import (
    add_command,
    add_controller,
    add_force,
    check_targets,
    chosen_controller,
    say_written,
    write,
)
from atleak.errors import InputError
from atleak.unit_systems import SYSTEMS
from atleak.wording import languages


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(commands, "template", run, "a measuring sheet to fill in")
    add_controller(parser)
    parser.add_argument("-o", "--output", metavar="FILE.xlsx", required=True)
    parser.add_argument("--language", choices=languages(), default="en", help="of the sheet; any of them is read back")
    parser.add_argument("--units", choices=tuple(SYSTEMS), default="metric", help="of the sheet")
    add_force(parser)


def run(options: argparse.Namespace) -> int:
    """Write the sheet."""
    from atleak.report.measuring_sheet import write_template

    if Path(options.output).suffix.lower() != ".xlsx":
        raise InputError("the measuring sheet is an Excel workbook", value=options.output, expected="a name.xlsx")
    check_targets(options, [options.controller], [("measuring sheet", options.output)])
    content = write_template(chosen_controller(options), language=options.language, units=options.units)
    say_written(write(options.output, content))
    return 0
