"""Provide what the commands share: options, numbers and pairs as people type them, and writing files."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatch
from pathlib import Path
from typing import TYPE_CHECKING, Any

from atleak.catalogue.written_numbers import INTERVAL, AskedNumber, decimal_number, read_number
from atleak.cli.parser import CommandOptions
from atleak.common import seals as marks
from atleak.common.errors import InputError, Message, Place, unknown
from atleak.common.files import replace_file, shipped
from atleak.common.printable import asked_for, unguarded
from atleak.common.seals import SealedKind
from atleak.common.sentences import Sentence
from atleak.common.style import DEFAULT_PAPER, PAPERS
from atleak.common.translations import languages
from atleak.common.units import SYSTEMS

if TYPE_CHECKING:
    from atleak.catalogue.controller import Controller
    from atleak.measurements.road_test import RoadTest
    from atleak.report.printed_fonts import OwnFont


# --- options ------------------------------------------------------------------------------------------------------


def add_controller(parser: CommandOptions) -> None:
    """Add ``--controller``, which `chosen_controller` loads."""
    help = "valve body: the study's four-speed one unless given; `atleak controllers` lists those known"
    parser.add_argument("--controller", metavar="ID|FILE", help=help)


def add_pairs(
    parser: CommandOptions, option: str, metavar: str, help: str, read: Callable[[str], Any] | None = None
) -> None:
    """Add an option that takes ``NAME=VALUE`` and may be repeated."""
    parser.add_argument(option, metavar=metavar, type=read or pair, action="append", default=[], help=help)


def add_job_id(parser: CommandOptions, count: str | None = None) -> None:
    """Add the argument that names a job of the book, or several, which `compared_jobs.named_job` finds."""
    help = "id of a job, its first characters, or the job's number"
    parser.add_argument("job" if count is None else "jobs", metavar="ID", nargs=count, help=help)


def named_job_files(names: Sequence[str]) -> list[Path]:
    """Return the job files that are named: each by itself, all of a folder, or by a pattern as ``jobs/*.zip``.

    A shell of Windows hands a pattern on as it was typed.

    Raises
    ------
    InputError
        no job file is there.
    """
    found: list[Path] = []
    for name in names:
        path = Path(name)
        if path.is_dir():
            found += sorted(_alike(path / "*"))
        else:
            alike = [path] if path.exists() or not any(sign in path.name for sign in "*?[") else sorted(_alike(path))
            if not alike:
                raise _no_job_file(name)
            found += alike
    if not found:
        raise _no_job_file(", ".join(names))
    return found


def _no_job_file(named: str) -> InputError:
    return InputError(Sentence("no job file is there"), value=named, expected=Sentence("job files (zip)"))


def _alike(pattern: Path) -> Iterator[Path]:
    """Yield the job files of a pattern: no folder, and no other file that stands beside them."""
    folder = pattern.parent
    for each in folder.iterdir() if folder.is_dir() else ():
        if fnmatch(each.name, pattern.name) and each.is_file() and each.suffix.lower() == ".zip":
            yield each


SAMPLES = "sample_data"  # the folder of the files that come with atleak
SAMPLE_LOG = "minimum_acceleration_test.csv"


def or_sample(name: str) -> Callable[[str], str]:
    """Return how to take a file's name: ``sample`` is this file of the sample, unless there is one called so."""
    return lambda text: str(shipped(f"{SAMPLES}/{name}")) if text == "sample" and not Path(text).is_file() else text


def add_force(parser: CommandOptions) -> None:
    """Add ``--force``, which `check_targets` asks for."""
    parser.add_argument("--force", action="store_true", help="write over files that atleak did not make, too")


def add_json(parser: CommandOptions) -> None:
    """Add ``--json``, which `write_json` serves."""
    help = "everything as JSON, to a file or (-) to standard output, alone; `atleak schema` describes it"
    parser.add_argument("--json", metavar="FILE|-", help=help)


_PRINT = {  # what is chosen of printing: the choices, the first unless given
    "language": ("en", languages()),
    "units": ("metric", tuple(SYSTEMS)),
    "paper": (DEFAULT_PAPER, tuple(PAPERS)),
}
SHOWN = "language", "units"  # of what a terminal can show


def add_units(parser: CommandOptions, unless_given: str | None = "metric") -> None:
    """Add ``--units`` of a command that shows quantities and prints none."""
    help = f"of what is shown: {unless_given or 'those of the file'} unless given"
    parser.add_argument("--units", choices=tuple(SYSTEMS), default=unless_given, help=help)


def add_print(parser: CommandOptions, *, shown: Collection[str] = ()) -> None:
    """Add the options of printing, which `print_options` gathers; the ones ``shown`` are the terminal's, too."""
    for name, (unless_given, choices) in _PRINT.items():
        of = "what is shown, " if name in shown else ""
        parser.add_argument(
            f"--{name}", choices=choices, help=f"of {of}the PDF and the workbook: {unless_given} unless given"
        )
    help = "for characters that the PDF's own fonts lack; without it the one kept on the page Library"
    parser.add_argument("--font", metavar="FILE", help=help)


def print_font(options: argparse.Namespace, formats: Collection[str], asked: str = "--pdf") -> OwnFont | None:
    """Return the font that ``--font`` names, or else the one that the workshop keeps; none where no PDF is written."""
    if "pdf" not in formats:
        if options.font is not None:
            doubt_option("--font", [asked])
        return None
    from atleak.report.printed_fonts import font_at, kept_font

    return kept_font() if options.font is None else font_at(options.font)


def print_options(
    options: argparse.Namespace, formats: Collection[str], asked: str = "--{}", *, shown: Collection[str] = ()
) -> dict[str, str]:
    """Return language, units and paper; one that is given for nothing is doubted aloud.

    ``formats`` are those to be written, such as ``pdf``; ``asked`` says how one asks for a format, ``shown`` names
    what the terminal follows, too.
    """
    for name in _PRINT:
        if getattr(options, name) is not None and not {"pdf", "xlsx"} & set(formats) and name not in shown:
            doubt_option(f"--{name}", [asked.format(each) for each in ("pdf", "xlsx")])
    return {name: getattr(options, name) or unless_given for name, (unless_given, _) in _PRINT.items()}


def doubt_option(option: str, others: Iterable[str]) -> None:
    """Say that an option does nothing without one of some others."""
    print(f"atleak: {option} does nothing without {' or '.join(others)}", file=sys.stderr)


def add_mapping(parser: CommandOptions, *, keeps: bool = False) -> None:
    """Add the options that say which column is what, which `mapped_columns` gathers."""
    help = (
        "the column of a quantity of the log, as main_pressure, or of a role of the measuring sheet: component, plane, "
        "part, direction, repeat, value, new; by heading, letter or number; part==spool holds for all rows"
    )
    add_pairs(parser, "--map", "NAME=COLUMN", help)
    add_pairs(parser, "--unit", "NAME=UNIT", "the unit of a quantity of the log, or of the sheet's value")
    help = "a file that says so, as --map-file writes it beside --map where there is none of that name"
    parser.add_argument("--map-file", metavar="FILE", help=help)
    if keeps:
        help = "neither use nor remember what is settled for files with these headings; what was is forgotten"
        parser.add_argument("--forget", action="store_true", help=help)


def add_columns(parser: CommandOptions) -> None:
    """Add the options about what a log lacks, and how much of it is read."""
    help = (
        "what stands for a channel that the log lacks, in kPa, °C or rpm: converter_pressure=300; in a diagnosis "
        "main_pressure=operating-points, those of the valve body's file by gear"
    )
    add_pairs(parser, "--constant", "QUANTITY=VALUE", help, constant)
    help = "seconds from row to row of a log without a clock: 0.033"
    parser.add_argument("--interval", metavar="S", type=number_of_argument(INTERVAL), help=help)
    help = "read only one row in N of the log, where all would take too much memory"
    parser.add_argument("--every", metavar="N", type=_every, default=1, help=help)


_WITH_UNIT = re.compile(r"(?P<number>[\d.,]+)\s*(?P<unit>[^\d\s.,].*)")


# --- what an option takes -----------------------------------------------------------------------------------------


def _every(text: str) -> int:
    if not text.isdecimal() or not int(text):
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number above 0")
    return int(text)


def pair(text: str) -> tuple[str, str]:
    """Split ``NAME=VALUE``."""
    name, equals, value = text.partition("=")
    if not equals or not name.strip():
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE")
    return name.strip(), value.strip()


def number_argument(text: str) -> float:
    """Read a number with decimal comma or point."""
    value = decimal_number(text)
    if value is None:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number")
    return value


def number_of_argument(asked: AskedNumber) -> Callable[[str], float]:
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
    in_own_unit = number_of_argument(asked)

    def read(text: str) -> float:
        from atleak.common.units import find_unit, unit

        match = _WITH_UNIT.fullmatch(text.strip())
        found = find_unit(match["unit"], "length") if match else None
        value = decimal_number(match["number"]) if match else None
        if found is None or value is None:
            return in_own_unit(text)
        return in_own_unit(repr(round(float(unit(asked.unit, "length").from_si(found.to_si(value))), 9)))

    return read


def constant(text: str) -> tuple[str, float | str]:
    """Read ``converter_pressure=300`` in kPa, °C, rpm or a plain number, and return name and value in SI.

    Main pressure may be that of the valve body's operating points, ``main_pressure=operating-points``.
    """
    from atleak.common.units import unit
    from atleak.engine.road_leakage import OPERATING_POINTS
    from atleak.measurements.road_test import QUANTITIES

    name, value = pair(text)
    if name not in QUANTITIES:
        raise argparse.ArgumentTypeError(str(unknown(Sentence("no such quantity of a log"), name, QUANTITIES)))
    if name == "main_pressure" and value.replace("-", "_") == OPERATING_POINTS:
        return name, OPERATING_POINTS
    known = QUANTITIES[name]
    stated = number_of_argument(AskedNumber(known.label, known.workshop_unit))(value)
    return name, unit(known.workshop_unit, known.unit_kind).to_si(stated) if known.unit_kind else stated


# --- what the options name ----------------------------------------------------------------------------------------


def chosen_controller(options: argparse.Namespace) -> Controller:
    """Load the controller that the command line names, or the default of every job."""
    from atleak.job.case import SLOTS, Case, Reader

    choice = Case.controller if options.controller is None else options.controller
    controller: Controller = Reader().entry(SLOTS["controller"], choice)
    return controller


def mapped_columns(options: argparse.Namespace) -> dict[str, Any]:
    """Return the choices of a case that say which column is what; the command line goes before the file that it names.

    Raises
    ------
    InputError
        no such file, or a name that is neither a quantity nor a role.
    """
    from atleak.job.case import named_columns
    from atleak.readers.remembered_columns import MapFile

    file = MapFile({})
    if options.map_file is not None and (Path(options.map_file).exists() or not options.map):
        file = MapFile.read(Path(options.map_file))
    given = {name for name, _ in options.map}
    columns = [*((name, column) for name, column in file.mapping.items() if name not in given), *options.map]
    units = {**file.units, **dict(options.unit)}
    chosen = named_columns(columns, units.items(), getattr(options, "sheet_unit", None))
    return chosen | {"sheet_name": getattr(options, "sheet", None) or file.sheet}


def write_map_file(
    options: argparse.Namespace, mapping: Mapping[str, str], units: Mapping[str, str], sheet: str | None = None
) -> None:
    """Write which column is what to the file that is asked for, where there is none of that name."""
    if options.map_file is not None and not Path(options.map_file).exists():
        from atleak.readers.remembered_columns import MapFile

        for name in write_file(options.map_file, MapFile(mapping, units, sheet).text()):
            print(f"atleak: columns are written to {name}", file=sys.stderr)


def log_choices(options: argparse.Namespace) -> dict[str, Any]:
    """Return the choices about a log: columns, units, values for missing channels, and of how many rows one is read."""
    chosen = mapped_columns(options)
    if chosen["sheet_columns"]:
        from atleak.measurements.road_test import QUANTITIES

        name = chosen["sheet_columns"][0][0]
        raise unknown(Sentence("a role of a measuring sheet, and no quantity of a log"), name, QUANTITIES)
    constants = {name: value for name, value in log_constants(options) if not isinstance(value, str)}
    named = {"mapping": dict(chosen["columns"]), "units": dict(chosen["units"])}
    return {**named, "constants": constants, "every": options.every}


def log_constants(options: argparse.Namespace) -> tuple[tuple[str, float | str], ...]:
    """Return what stands for channels that the log lacks; for its time, the interval between rows."""
    interval = () if options.interval is None else (("time", options.interval),)
    return (*options.constant, *interval)


def chosen_road_test(options: argparse.Namespace) -> RoadTest:
    """Read the log that the command line names, its columns as they are chosen or remembered."""
    from atleak.readers.logs import default_path, read_road_test

    return read_road_test(Path(options.road_test), **log_choices(options), remembered=default_path())


# --- files written ------------------------------------------------------------------------------------------------

PRINTED = {name: f"pdf_{name}" for name in ("report", "customer", "workshop", "annex", "all")}
"""The documents that ``--pdf`` writes, with what the options are called in which they are asked for."""


class Printed(argparse.Action):
    """Take ``FILE`` as that of the report and ``NAME=FILE`` as that of a document; other names with = need a folder."""

    def __call__(self, parser: Any, options: argparse.Namespace, value: Any, option: str | None = None) -> None:
        name, equals, file = str(value).partition("=")
        if not equals or set(name) & set("/\\"):
            name, file = "report", str(value)
        if name not in PRINTED or not file:
            raise argparse.ArgumentError(self, f"no such document: {name}={file} (expected FILE or {_NAMES}=FILE)")
        if getattr(options, PRINTED[name], None) is not None:
            raise argparse.ArgumentError(self, f"{name} is asked for twice")
        setattr(options, PRINTED[name], file)


_NAMES = "|".join(PRINTED)
_ASKED: dict[str, SealedKind] = {
    "xlsx": "report workbook",
    "pdf": "PDF",
    **dict.fromkeys(PRINTED.values(), "PDF"),
    "job_file": "job file",
    "csv": "table",
    "report": "table",
    "json": "record",
}
_BINARY = ("xlsx", "pdf", *PRINTED.values(), "job_file")  # options of which no terminal or pipe takes the file
_ENDINGS: dict[SealedKind, tuple[str, ...]] = {
    "record": (".json",),
    "report workbook": (".xlsx",),
    "measuring sheet": (".xlsx",),
    "controller workbook": (".xlsx",),
    "PDF": (".pdf",),
    "job file": (".zip",),
    "table": (".csv", ".parquet"),
    "TOML file": (".toml",),
}
_ONE_ENDING: dict[SealedKind, Sentence] = {  # kinds that no other command reads under another name
    "measuring sheet": Sentence("the measuring sheet is an Excel workbook"),
    "controller workbook": Sentence("the workbook is a .xlsx file"),
    "TOML file": Sentence("the description is a .toml file"),
}
_ENDINGS_OF_OTHERS = {
    *(ending for endings in _ENDINGS.values() for ending in endings),
    *(".doc", ".docx", ".odt", ".rtf", ".xls", ".xlsm", ".xlsb", ".ods", ".ppt", ".pptx", ".htm", ".html", ".xml"),
    *(".png", ".jpg", ".jpeg", ".webp", ".svg", ".mf4", ".gz", ".7z", ".exe"),
}


class Outputs:
    """The files that a command is asked for: refused before anything is computed, and written when all of it is.

    Parameters
    ----------
    inputs
        files that the command reads, which none may take the place of.
    output
        the kind of file that ``-o`` asks for.
    """

    def __init__(
        self, options: argparse.Namespace, inputs: Iterable[str | None] = (), output: SealedKind | None = None
    ) -> None:
        kinds = _ASKED if output is None else {"output": output, **_ASKED}
        asked = {name: getattr(options, name, None) for name in kinds}
        self.files = {name: target for name, target in asked.items() if target is not None}
        for name in _BINARY:
            if self.files.get(name) == "-":
                problem = Sentence("a workbook, PDF or job file cannot be written to standard output")
                value = f"--{'pdf' if name in PRINTED.values() else name.replace('_', '-')} -"
                raise InputError(problem, value=value, expected=Sentence("a file name"))
        if output in _ONE_ENDING and self.files.get("output", "-") != "-":
            (suffix,) = _ENDINGS[output]
            if Path(self.files["output"]).suffix.lower() != suffix:
                expected = Sentence("a name{suffix}", suffix=suffix)
                raise InputError(_ONE_ENDING[output], value=self.files["output"], expected=expected)
        check_targets(options, inputs, [(kinds[name], target) for name, target in self.files.items()])
        printed = any(name in self.files for name in ("pdf", *PRINTED.values()))
        self.formats = [*(["pdf"] if printed else []), *(["xlsx"] if "xlsx" in self.files else [])]
        self.shown = "-" not in self.files.values()  # else standard output is for a file alone
        self.written: list[str] = []

    def write(self, **contents: Callable[[], Any]) -> None:
        """Write what is asked for of some files, by the names of their options: bytes, text, or a record as JSON.

        What may go to standard output comes last, so that that stays empty when another file fails.
        """
        for name, content in contents.items():
            if name in self.files:
                self.written += write_file(self.files[name], content())

    def say_written(self) -> None:
        """Print one line for every file that was written, where standard output is not for one of them."""
        if self.shown:
            say_written(self.written)


def write_file(target: str, content: Any) -> list[str]:
    """Write a file or, for ``-``, to standard output; return the names of the files written.

    What is read by a program is written as it is; a terminal gets no control character.
    """
    if not isinstance(content, bytes | str):
        from atleak.report.json.diagnosis import to_json

        content = to_json(content)
    if target == "-":
        asked = asked_for(sys.stdout)
        output = asked if asked.isatty() else unguarded(asked)
        output.write(content)
        return []
    encoded = content.encode("utf-8", errors="backslashreplace") if isinstance(content, str) else content
    replace_file(target, encoded)
    return [target]


def check_targets(
    options: argparse.Namespace, inputs: Iterable[str | None], targets: Iterable[tuple[SealedKind, str]]
) -> None:
    """Refuse, before anything is computed, to write over a file that must not be replaced.

    A file whose name says that it is of another kind is refused too; a name that says nothing is taken.
    """
    targets = list(targets)
    marks.check_seals(inputs, targets, force=options.force)
    for kind, target in targets:
        ending = Path(target).suffix.lower()
        if ending in _ENDINGS_OF_OTHERS and ending not in _ENDINGS[kind]:
            problem = Sentence("the ending of its name is that of another kind of file")
            expected = Sentence("a name{suffix}", suffix=_ENDINGS[kind][0])
            raise InputError(problem, place=Place(file=target), expected=expected)


def say_written(names: Iterable[object]) -> None:
    """Print one line for every file that was written."""
    for name in names:
        print(f"written: {name}")


def say_doubts(doubts: Iterable[Message]) -> None:
    """Print what is doubtful about a job record, a line each, beside the result."""
    for doubt in doubts:
        print(f"atleak: {doubt.text}", file=sys.stderr)


_DIFFERENCES = 12  # of a job file from its own result that are printed


def say_differences(name: str, result_by: str, differs: Sequence[Sentence]) -> None:
    """Print where a job file differs from the result in it, and which version made that; nothing where it does not."""
    if not differs:
        return
    whose = f"{name}: differs from its result, made by atleak {result_by}"
    print("\n  ".join([f"atleak: {whose}:", *map(str, differs[:_DIFFERENCES])]), file=sys.stderr)
    if len(differs) > _DIFFERENCES:
        print(f"  … and {len(differs) - _DIFFERENCES} more", file=sys.stderr)
