"""Write what atleak comes with: the sample files, and the schemas of its JSON: ``atleak sample``, ``atleak schema``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from atleak.cli.parser import add_command
from atleak.cli.shared import SAMPLES, say_written, write_file
from atleak.common.errors import OutputError, Place
from atleak.common.files import shipped
from atleak.common.sentences import Sentence
from atleak.report.json.schemas import DIALECT, OUTPUTS, schema

_UNLESS_GIVEN = "diagnose"
_JOB = "job"  # what people write for --job


def add_parser(commands: Any, name: str) -> None:
    """Add one of the commands."""
    if name == "sample":
        parser = add_command(commands, name, _write_samples, examples=("sample", "sample trial"))
        parser.add_argument(
            "folder", metavar="FOLDER", nargs="?", default=SAMPLES, help=f"into which they go: {SAMPLES} unless given"
        )
        parser.add_argument("--force", action="store_true", help="write over files of these names")
        return
    examples = ("schema", "schema import-log", "schema job")
    parser = add_command(commands, name, _print_schema, examples=examples, quiet=False)
    known = ", ".join((*OUTPUTS, _JOB))
    parser.add_argument(
        "output",
        metavar="NAME",
        nargs="?",
        choices=(*OUTPUTS, _JOB),
        default=_UNLESS_GIVEN,
        help=f"{_UNLESS_GIVEN} unless given; of {known}",
    )


def _write_samples(options: argparse.Namespace) -> int:
    """Write the files, all or none."""
    folder = Path(options.folder)
    files = sorted(path for path in shipped(SAMPLES).iterdir() if path.is_file())
    there = [folder / file.name for file in files if (folder / file.name).exists()]
    if there and not options.force:
        expected = Sentence("another folder, or --force to write over it")
        problem = Sentence("is there already")
        others = [OutputError(problem, place=Place(file=str(path)), expected=expected) for path in there[1:]]
        raise OutputError(problem, place=Place(file=str(there[0])), expected=expected, others=others)
    contents = {folder / file.name: file.read_bytes() for file in files}
    folder.mkdir(parents=True, exist_ok=True)
    for path, content in contents.items():
        say_written(write_file(str(path), content))
    return 0


def _print_schema(options: argparse.Namespace) -> int:
    """Print the schema."""
    if options.output == _JOB:
        from atleak.measurements.job_card import Job

        record = {"$schema": DIALECT, "$id": "urn:atleak:job:1", **Job.model_json_schema()}
    else:
        record = schema(options.output)
    write_file("-", record)
    return 0
