"""Provide what the commands share: options, numbers and pairs as people type them, and writing files."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from atleak.errors import unknown
from atleak.paper import DEFAULT_PAPER, PAPERS
from atleak.system.files import replace_file
from atleak.system.printable import unguarded
from atleak.unit_systems import SYSTEMS
from atleak.wording import languages
from atleak.written_numbers import AskedNumber, decimal_number, read_number

if TYPE_CHECKING:
    from atleak.catalogue.controller import Controller
    from atleak.road_test import RoadTest
    from atleak.system.marks import Kind


def add_command(commands: Any, name: str, run: Callable[..., int], about: str) -> argparse.ArgumentParser:
    """Add the parser of a command, which ``run`` carries out."""
    parser: argparse.ArgumentParser = commands.add_parser(
        name, help=about, description=about[0].upper() + about[1:] + "."
    )
    parser.set_defaults(run=run)
    without_colours(parser)
    return parser


def without_colours(parser: argparse.ArgumentParser) -> None:
    """Make help and messages plain: from Python 3.14 on argparse colours them, which no guarded stream shows."""
    parser.color = False  # type: ignore[attr-defined,unused-ignore]


# --- options ------------------------------------------------------------------------------------------------------


def add_controller(parser: argparse.ArgumentParser) -> None:
    """Add ``--controller``, which `chosen_controller` loads."""
    parser.add_argument("--controller", metavar="ID|FILE", help="the study's four-speed controller unless given")


def add_job_id(parser: argparse.ArgumentParser, count: str | None = None) -> None:
    """Add the argument that names a job of the book, or several, which `atleak.jobs.named.named_job` finds."""
    help = "id of a job, its first characters, or the job's number"
    parser.add_argument("job" if count is None else "jobs", metavar="ID", nargs=count, help=help)


def add_force(parser: argparse.ArgumentParser) -> None:
    """Add ``--force``, which `check_targets` asks for."""
    parser.add_argument("--force", action="store_true", help="write over files that atleak did not make, too")


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add ``--json``, which `write_json` serves."""
    parser.add_argument("--json", metavar="FILE|-")


def add_print(parser: argparse.ArgumentParser) -> None:
    """Add the options of printing: language, units and paper."""
    parser.add_argument("--language", choices=languages(), default="en", help="of the PDF and the workbook")
    parser.add_argument("--units", choices=tuple(SYSTEMS), default="metric", help="of the PDF and the workbook")
    parser.add_argument("--paper", choices=list(PAPERS), default=DEFAULT_PAPER, help="of the PDF and the workbook")


def add_columns(parser: argparse.ArgumentParser) -> None:
    """Add the options about a log's columns, which `log_choices` gathers."""
    for name, what in (("map", "COLUMN"), ("unit", "UNIT")):
        parser.add_argument(
            f"--{name}",
            metavar=f"QUANTITY={what}",
            type=pair,
            action="append",
            default=[],
            help=f"the {what.lower()} of a quantity of the log",
        )
    parser.add_argument(
        "--constant",
        metavar="QUANTITY=VALUE",
        type=constant,
        action="append",
        default=[],
        help="what stands for a channel that the log lacks, in kPa, °C or rpm: converter_pressure=300",
    )


_WITH_UNIT = re.compile(r"(?P<number>[\d.,]+)\s*(?P<unit>[^\d\s.,].*)")


# --- what an option takes -----------------------------------------------------------------------------------------


def pair(text: str) -> tuple[str, str]:
    """Split ``NAME=VALUE``."""
    name, equals, value = text.partition("=")
    if not equals or not name.strip():
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE")
    return name.strip(), value.strip()


def number(text: str) -> float:
    """Read a number with decimal comma or point."""
    value = decimal_number(text)
    if value is None:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number")
    return value


def number_of(asked: AskedNumber) -> Callable[[str], float]:
    """Return the reader of an option that takes this number; one that is accepted with a doubt is doubted aloud."""

    def read(text: str) -> float:
        written = read_number(text, asked)
        if written.value is None:
            raise argparse.ArgumentTypeError(written.doubt)
        if written.doubt:
            print(f"atleak: {written.doubt}", file=sys.stderr)
        return written.value

    return read


def length_of(asked: AskedNumber) -> Callable[[str], float]:
    """Return the reader of an option that takes a length in the asked number's unit, or with another one behind it."""
    in_own_unit = number_of(asked)

    def read(text: str) -> float:
        from atleak.intake.units import find_unit, unit

        match = _WITH_UNIT.fullmatch(text.strip())
        found = find_unit(match["unit"], "length") if match else None
        value = decimal_number(match["number"]) if match else None
        if found is None or value is None:
            return in_own_unit(text)
        return in_own_unit(repr(round(float(unit(asked.unit, "length").from_si(found.to_si(value))), 9)))

    return read


def constant(text: str) -> tuple[str, float]:
    """Read ``converter_pressure=300`` in kPa, °C, rpm or a plain number, and return name and value in SI."""
    from atleak.intake.units import unit
    from atleak.road_test import QUANTITIES

    name, value = pair(text)
    if name not in QUANTITIES:
        raise argparse.ArgumentTypeError(str(unknown("no such quantity of a log", name, QUANTITIES)))
    known = QUANTITIES[name]
    stated = number_of(AskedNumber(known.label, known.workshop_unit))(value)
    return name, unit(known.workshop_unit, known.unit_kind).to_si(stated) if known.unit_kind else stated


# --- what the options name ----------------------------------------------------------------------------------------


def chosen_controller(options: argparse.Namespace) -> Controller:
    """Load the controller that the command line names, or the default of every job."""
    from atleak.job.case import SLOTS, Case, Reader

    choice = Case.controller if options.controller is None else options.controller
    controller: Controller = Reader().entry(SLOTS["controller"], choice)
    return controller


def log_choices(options: argparse.Namespace) -> dict[str, Any]:
    """Return the choices about a log: columns, units and values for missing channels."""
    return {"mapping": dict(options.map), "units": dict(options.unit), "constants": dict(options.constant)}


def chosen_road_test(options: argparse.Namespace) -> RoadTest:
    """Read the log that the command line names, its columns as they are chosen or remembered."""
    from atleak.intake.road_test import default_path, read_road_test

    return read_road_test(Path(options.road_test), **log_choices(options), remembered=default_path())


# --- files written ------------------------------------------------------------------------------------------------


def check_targets(
    options: argparse.Namespace, inputs: Iterable[str | None], targets: Iterable[tuple[Kind, str | None]]
) -> None:
    """Refuse, before anything is computed, to write over a file that must not be replaced."""
    from atleak.system import marks

    marks.check_targets(inputs, targets, force=options.force)


def write(target: str, content: bytes) -> list[str]:
    """Write a file; return its name."""
    replace_file(target, content)
    return [target]


def write_text(target: str, text: str) -> list[str]:
    """Write text as UTF-8 to a file or, for ``-``, to standard output; return the names of the files written.

    What is read by a program is written as it is; a terminal gets no control character.
    """
    if target == "-":
        output = sys.stdout if sys.stdout.isatty() else unguarded(sys.stdout)
        output.write(text)
        return []
    return write(target, text.encode("utf-8", errors="backslashreplace"))


def write_json(target: str, record: Any) -> list[str]:
    """Write a record as JSON, as `write_text` does."""
    from atleak.views.diagnosis_record import to_json

    return write_text(target, to_json(record))


def say_written(names: Iterable[object]) -> None:
    """Print one line for every file that was written."""
    for name in names:
        print(f"written: {name}")
