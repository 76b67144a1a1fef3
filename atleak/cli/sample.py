"""Write the sample files into a folder: ``atleak sample``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from atleak.cli.parser import add_command
from atleak.cli.shared import SAMPLES, say_written, write_file
from atleak.common.errors import OutputError, Place
from atleak.common.files import shipped
from atleak.common.sentences import Sentence


def add_parser(commands: Any, name: str) -> None:
    """Add the command."""
    parser = add_command(commands, name, run, examples=("sample", "sample trial"))
    parser.add_argument(
        "folder", metavar="FOLDER", nargs="?", default=SAMPLES, help=f"into which they go: {SAMPLES} unless given"
    )
    parser.add_argument("--force", action="store_true", help="write over files of these names")


def run(options: argparse.Namespace) -> int:
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
