"""Describe the JSON that the commands write: ``atleak schema``."""

from __future__ import annotations

import argparse
from typing import Any

from atleak.cli.parser import add_command
from atleak.cli.shared import write_file
from atleak.report.json.schemas import DIALECT, OUTPUTS, schema

_UNLESS_GIVEN = "diagnose"
_JOB = "job"  # what people write for --job


def add_parser(commands: Any, name: str) -> None:
    """Add the command."""
    examples = ("schema", "schema import-log", "schema job")
    parser = add_command(commands, name, run, examples=examples, quiet=False)
    known = ", ".join((*OUTPUTS, _JOB))
    parser.add_argument(
        "output",
        metavar="NAME",
        nargs="?",
        choices=(*OUTPUTS, _JOB),
        default=_UNLESS_GIVEN,
        help=f"{_UNLESS_GIVEN} unless given; of {known}",
    )


def run(options: argparse.Namespace) -> int:
    """Print the schema."""
    if options.output == _JOB:
        from atleak.measurements.job_card import Job

        record = {"$schema": DIALECT, "$id": "urn:atleak:job:1", **Job.model_json_schema()}
    else:
        record = schema(options.output)
    write_file("-", record)
    return 0
