"""Show what is understood of a road-test log: ``atleak import-log``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from atleak.cli.parser import add_command
from atleak.cli.shared import (
    SAMPLE_LOG,
    Outputs,
    add_columns,
    add_force,
    add_json,
    add_mapping,
    add_units,
    log_choices,
    or_sample,
    write_map_file,
)
from atleak.common.errors import InputError, OutputError, Place
from atleak.common.sentences import Sentence
from atleak.readers.logs import default_path, describe, forget_columns, remember, tidy_csv, understand
from atleak.readers.masked_file import masked_file
from atleak.report.terminal import print_log


def add_parser(commands: Any, name: str) -> None:
    """Add the command."""
    examples = (
        "import-log log.csv",
        "import-log log.csv --map main_pressure=PL --unit main_pressure=bar --csv tidy.csv",
    )
    parser = add_command(commands, name, run, examples=examples)
    parser.add_argument(
        "road_test",
        metavar="LOG",
        type=or_sample(SAMPLE_LOG),
        help="text, xlsx or mf4, as the logger wrote it; sample: the one that comes with atleak",
    )
    add_mapping(parser, keeps=True)
    add_columns(parser)
    add_units(parser, None)
    add_json(parser)
    parser.add_argument("--csv", metavar="FILE|-", help="the log as a plain table in rpm, °C, kPa and km/h")
    parser.add_argument(
        "--report",
        metavar="FILE|-",
        help="nothing but the form of the log, or of a measuring sheet, as text: headings and layout without a value, "
        "name or date, to be shown to whoever is asked why it is not read",
    )
    add_force(parser)


def run(options: argparse.Namespace) -> int:
    """Read the log, write what was asked for and remember how its columns were chosen."""
    outputs, choices = Outputs(options, [options.road_test]), log_choices(options)
    if options.report:
        outputs.write(report=lambda: masked_file(options.road_test))
        outputs.say_written()
        return 0
    mapping, units = choices["mapping"], choices["units"]
    if options.forget:
        forget_columns(default_path(), understand(Path(options.road_test)).signature)
    understood = understand(Path(options.road_test), **choices, remembered=default_path())
    record, test = describe(understood), understood.road_test
    outputs.write(json=lambda: record)
    if test is None:
        raise understood.problem or InputError(
            Sentence("the log's columns cannot be identified"), place=Place(file=understood.file)
        )
    outputs.write(csv=lambda: tidy_csv(test))
    if (mapping or units) and not options.forget and understood.uses(mapping):
        labels = [heading.label for heading in understood.headings]
        try:
            remember(default_path(), understood.signature, mapping, units, format=understood.format, columns=labels)
        except OutputError as error:
            print(f"atleak: columns are not remembered: {error}", file=sys.stderr)
    write_map_file(options, mapping, units)
    if outputs.shown:
        print_log(record, options.units)
    outputs.say_written()
    return 0
