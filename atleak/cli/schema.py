"""Describe the JSON that the commands write: ``atleak schema``."""

from __future__ import annotations

import argparse
from typing import Any

from atleak.cli.parser import add_command
from atleak.cli.shared import write_json
from atleak.schemas import DIALECT, OUTPUTS, schema

_UNLESS_GIVEN = "diagnose"
_JOB = "job"  # what people write for --job


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "schema",
        run,
        "the JSON Schema of what a command writes, or of a job record",
        examples=("schema", "schema import-log", "schema job"),
        quiet=False,
    )
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
    write_json("-", _job() if options.output == _JOB else schema(options.output))
    return 0


def _job() -> dict[str, Any]:
    from atleak.job.record import Job

    return {"$schema": DIALECT, "$id": "urn:atleak:job:1", **Job.model_json_schema()}
