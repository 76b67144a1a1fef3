"""The command line: files in, a verdict, JSON, a workbook out.

Exit status: 0 done, 1 only with ``--fail-on`` and a pair at or past it, 2 bad input or usage.
"""

from __future__ import annotations

import argparse
import errno
import os
import subprocess
import sys
from collections.abc import Callable, Iterable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from atleak.errors import AtleakError, InputError, OutputError, Place, unknown
from atleak.files import replace_file
from atleak.shipped import shipped
from atleak.verdicts import FLAGGED
from atleak.version import __version__
from atleak.wording import languages
from atleak.written_numbers import (
    ENGINE_SPEED,
    MILEAGE,
    TEMPERATURE,
    AskedNumber,
    decimal_number,
    read_number,
)

if TYPE_CHECKING:
    from atleak.catalogue.controller import Controller
    from atleak.diagnosis import Diagnosis
    from atleak.job.case import Case
    from atleak.job.record import Job
    from atleak.marks import Kind
    from atleak.road_test import RoadTest

_BROKEN_PIPE = 141  # as a shell reports a program whose reader went away


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # µ and ° must survive a Windows code page
            stream.reconfigure(encoding="utf-8", errors="replace")
    options = _parser().parse_args(arguments)
    try:
        status = options.run(options)
        sys.stdout.flush()  # a reader that went away is noticed here, not when the interpreter ends
        return status
    except AtleakError as error:
        print(f"atleak: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        if not isinstance(error, BrokenPipeError) and error.errno != errno.EINVAL:  # EINVAL: the same on Windows
            print(f"atleak: {error.filename or 'a file'}: {error.strerror}", file=sys.stderr)
            return 2
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _BROKEN_PIPE
    except KeyboardInterrupt:
        return 130
    except Exception as error:  # nobody at a workshop's bench is helped by a traceback
        if os.environ.get("ATLEAK_TRACEBACK"):
            raise
        print(f"atleak: unexpected {type(error).__name__}: {error}", file=sys.stderr)
        print("This is a fault of atleak. ATLEAK_TRACEBACK=1 in the environment shows where.", file=sys.stderr)
        return 2


# --- diagnose -----------------------------------------------------------------------------------------------------


def _diagnose(options: argparse.Namespace) -> int:
    from atleak.verdicts import Verdict

    for name in ("xlsx", "pdf", "job_file"):
        if getattr(options, name) == "-":
            problem = "a workbook, PDF or job file cannot be written to standard output"
            raise InputError(problem, value=f"--{name} -", expected="a file name")
    inputs = (options.readings, options.road_test, options.job, options.controller, options.fluid, options.limits)
    targets: list[tuple[Kind, str | None]] = [("record", options.json), ("report workbook", options.xlsx)]
    _check_targets(options, inputs, [*targets, ("PDF", options.pdf), ("job file", options.job_file)])
    job = None
    if options.job is not None:
        from atleak.job.file import load_job

        job = load_job(options.job)
        if options.mileage is None:
            options.mileage = job.vehicle.mileage_km
    case = _case(options)
    diagnosis = case.diagnose()
    written = _write_reports(diagnosis, job, case, options)
    if options.json != "-":
        from atleak.report.terminal import print_diagnosis

        print_diagnosis(diagnosis)
        _say(written)
    past = options.fail_on and diagnosis.verdict.rank >= Verdict(options.fail_on).rank
    return 1 if past else 0


def _controller(options: argparse.Namespace) -> Controller:
    from atleak.catalogue.controller import load_controller
    from atleak.job.case import Case

    return load_controller(Case.controller if options.controller is None else options.controller)


def _case(options: argparse.Namespace) -> Case:
    """The files and choices that the command line names."""
    from atleak.job.case import SLOTS, Case, SourceFile

    return Case(
        readings=SourceFile.at(options.readings),
        road_test=None if options.road_test is None else SourceFile.at(options.road_test),
        **{name: chosen for name in SLOTS if (chosen := getattr(options, name)) is not None},
        profile=options.profile,
        options=tuple(options.set),
        temperature=options.temperature,
        engine_speed=None if options.rpm is None else options.rpm / 60.0,
        gear=options.gear,
        mileage=options.mileage,
        sheet_name=options.sheet,
        sheet_unit=options.sheet_unit,
        sheet_where=tuple(options.where),
        columns=tuple(options.map),
        units=tuple(options.unit),
        constants=tuple(options.constant),
        assumptions=tuple(options.assume),
        guard_factor=options.guard,
    )


def _write_reports(diagnosis: Diagnosis, job: Job | None, case: Case, options: argparse.Namespace) -> list[str]:
    """The files asked for; their names."""
    written = []
    if options.xlsx is not None:
        from atleak.report.xlsx import write_workbook

        written += _write(options.xlsx, write_workbook(diagnosis, job, paper=options.paper))
    if options.pdf is not None:
        from atleak.report.pdf import write_pdf

        sections = None if options.sections is None else [name.strip() for name in options.sections.split(",")]
        content = write_pdf(diagnosis, job, language=options.language, paper=options.paper, sections=sections)
        written += _write(options.pdf, content)
    if options.job_file is not None:
        from atleak.job.case import Reader, with_log_choices
        from atleak.job.file import write_job_file

        settled = case if case.road_test is None else with_log_choices(case, Reader().log(case))
        content = write_job_file(diagnosis, job, settled)
        written += _write(options.job_file, content)
    if options.json is not None:  # last: nothing stands on standard output when another file fails
        from atleak.views.diagnosis_record import diagnosis_record, to_json

        written += _write(options.json, to_json(diagnosis_record(diagnosis)).encode())
    return written


def _report(options: argparse.Namespace) -> int:
    from rich.console import Console
    from rich.progress import Progress

    from atleak.report.batch import KINDS, report_paths, write_reports

    sources = [Path(name) for name in options.jobs]
    planned = report_paths(sources, Path(options.output), options.formats)
    _check_targets(options, options.jobs, ((KINDS[form], str(path)) for of in planned for form, path in of.items()))
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("reports", total=len(sources))
        reported = write_reports(
            sources,
            Path(options.output),
            formats=options.formats,
            language=options.language,
            paper=options.paper,
            progress=lambda done, total, last: bar.update(task, completed=done, total=total),
        )
    for found in reported:
        _say([str(path) for path in found.written])
        if found.error is not None:
            print(f"atleak: {found.error}", file=sys.stderr)
    return 2 if any(found.error is not None for found in reported) else 0


def _road_test(options: argparse.Namespace) -> RoadTest:
    from atleak.intake.road_test import default_path, read_road_test

    return read_road_test(Path(options.road_test), **_told(options), remembered=default_path())


def _told(options: argparse.Namespace) -> dict[str, Any]:
    """What the command line says of a log: columns, units and what stands for missing channels."""
    return {"mapping": dict(options.map), "units": dict(options.unit), "constants": dict(options.constant)}


def _check_targets(
    options: argparse.Namespace, inputs: Iterable[str | None], targets: Iterable[tuple[Kind, str | None]]
) -> None:
    """Before anything is computed: what may not be written over is refused."""
    from atleak.marks import check_targets

    check_targets(inputs, targets, force=options.force)


# --- variants, import-log -----------------------------------------------------------------------------------------


def _variants(options: argparse.Namespace) -> int:
    from atleak.report.terminal import print_variants
    from atleak.variants import run_variants, sample_log

    _check_targets(options, (options.road_test, options.controller), [("record", options.json)])
    options.road_test = options.road_test or sample_log()
    controller, road_test = _controller(options), _road_test(options)
    results = run_variants(controller, road_test)
    if options.json is not None:
        from atleak.views.diagnosis_record import to_json
        from atleak.views.variant_rows import variants_record

        _say(_write(options.json, to_json(variants_record(results, controller, road_test)).encode()))
    if options.json != "-":
        print_variants(results)
    return 0


def _import_log(options: argparse.Namespace) -> int:
    from atleak.intake.road_test import default_path, describe, remember, tidy_csv, understand
    from atleak.report.terminal import print_log

    _check_targets(options, [options.road_test], [("record", options.json), ("table", options.csv)])
    told = _told(options)
    mapping, units = told["mapping"], told["units"]
    understood = understand(Path(options.road_test), **told, remembered=default_path())
    record = describe(understood)
    written = []
    if options.json is not None:
        from atleak.views.diagnosis_record import to_json

        written += _write(options.json, to_json(record).encode())
    if understood.road_test is None:
        raise understood.problem or InputError("the log's columns cannot be told", place=Place(file=understood.file))
    if options.csv is not None:
        written += _write(options.csv, tidy_csv(understood.road_test).encode())
    if (mapping or units) and not options.forget:
        try:
            remember(default_path(), understood.signature, mapping, units)
        except OutputError as error:
            print(f"atleak: columns are not remembered: {error}", file=sys.stderr)
    if "-" not in (options.json, options.csv):
        print_log(record)
        _say(written)
    return 0


# --- template, catalogue ------------------------------------------------------------------------------------------


def _template(options: argparse.Namespace) -> int:
    from atleak.report.measuring_sheet import write_template

    if Path(options.output).suffix.lower() != ".xlsx":
        raise InputError("the measuring sheet is an Excel workbook", value=options.output, expected="a name.xlsx")
    _check_targets(options, [options.controller], [("measuring sheet", options.output)])
    _say(_write(options.output, write_template(_controller(options))))
    return 0


def _controllers(options: argparse.Namespace) -> int:
    from atleak.catalogue.controller import controllers

    rows = [
        {
            "id": found.id,
            "name": found.name,
            "components": len({land.component for land in found.lands}),
            "lands": len(found.lands),
            "gaps": len(found.gaps),
            "gears": list(found.gears),
            "operating_points": [point.name for point in found.operating_points],
            "representative": bool(found.representative),
            "source": found.source,
            "sha256": found.sha256,
        }
        for found in controllers()
    ]
    return _list(rows, ["id", "name", "lands", "gaps", "representative"], options)


def _fluids(options: argparse.Namespace) -> int:
    from atleak.catalogue.fluid import fluids

    rows = [
        {
            "id": found.id,
            "name": found.name,
            "viscosity_mm2_s": {f"{at:g}": nu * 1e6 for at, nu in found.points},
            "density_g_cm3": found.density_at[1] * 1e-3,
            "density_at_c": found.density_at[0],
            "pour_point_c": found.pour_point,
            "representative": list(found.representative),
            "note": found.note or None,
            "source": found.source,
            "sha256": found.origin.sha256,
        }
        for found in fluids()
    ]
    return _list(rows, ["id", "name", "viscosity_mm2_s", "density_g_cm3", "pour_point_c"], options)


def _limits(options: argparse.Namespace) -> int:
    from atleak.catalogue.limits import limit_sets
    from atleak.views.diagnosis_record import limits_record

    rows = [limits_record(found) for found in limit_sets()]
    return _list(rows, ["id", "name", "source"], options)


def _instruments(options: argparse.Namespace) -> int:
    from atleak.catalogue.instruments import instruments

    rows = [
        {
            "id": found.id,
            "name": found.name,
            "measures": list(found.measures),
            "resolution_um": found.resolution * 1e6,
            "calibration_um": found.calibration * 1e6,
            "common_part": found.common_part,
            "repeatability_um": None if found.repeatability is None else found.repeatability * 1e6,
            "representative": list(found.representative),
            "note": found.note or None,
            "source": found.source,
        }
        for found in instruments()
    ]
    return _list(rows, ["id", "name", "measures", "resolution_um", "calibration_um", "common_part"], options)


def _list(rows: list[dict[str, Any]], columns: list[str], options: argparse.Namespace) -> int:
    _check_targets(options, [], [("record", options.json)])
    if options.json is not None:
        from atleak.views.diagnosis_record import to_json

        _say(_write(options.json, to_json([{**row, "atleak": __version__} for row in rows]).encode()))
    if options.json != "-":
        from atleak.report.terminal import print_table

        print_table(columns, rows)
    return 0


# --- the dashboard ------------------------------------------------------------------------------------------------


def _app(options: argparse.Namespace) -> int:
    if find_spec("streamlit") is None:
        raise InputError("the dashboard needs streamlit", expected="python -m pip install streamlit")
    app = shipped("app.py")
    command = [sys.executable, "-m", "streamlit", "run", str(app), "--server.address", options.address]
    if options.port is not None:
        command += ["--server.port", str(options.port)]
    return _serve(command, app.parent)


def _serve(command: list[str], folder: Path) -> int:
    """Run the server in the dashboard's own folder, where its configuration is found."""
    if os.name == "posix":  # in place of this process, so that whoever ends this one ends the server
        os.chdir(folder)
        os.execv(command[0], command)
    return subprocess.call(command, cwd=folder)


# --- the words of the command line --------------------------------------------------------------------------------


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="atleak", description="Internal leakage of automatic-transmission valve bodies."
    )
    parser.add_argument("--version", action="version", version=f"atleak {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    add = _adder(commands)
    diagnose = add("diagnose", _diagnose, "a verdict for every land from a measuring sheet and a road test")
    diagnose.add_argument("readings", metavar="READINGS", help="measuring sheet: xlsx, xls, ods or csv")
    diagnose.add_argument("--sheet", metavar="NAME", help="of the workbook, where several hold readings")
    diagnose.add_argument(
        "--sheet-unit", metavar="UNIT", help="of the diameters, where the sheet does not say: mm, µm, inch"
    )
    diagnose.add_argument(
        "--where",
        metavar="HEADING=VALUE",
        type=_pair,
        action="append",
        default=[],
        help="the rows of the sheet to read, where it holds several inspections or vehicles: Inspection=May",
    )
    diagnose.add_argument("--road-test", metavar="LOG", help="road-test log of any logger: text, xlsx or mf4")
    _add_columns(diagnose)
    _add_controller(diagnose)
    diagnose.add_argument("--fluid", metavar="ID|FILE")
    diagnose.add_argument("--limits", metavar="ID|FILE")
    diagnose.add_argument("--profile", choices=["workshop", "paper"], default="workshop")
    diagnose.add_argument(
        "--set",
        metavar="OPTION=VALUE",
        type=_pair,
        action="append",
        default=[],
        help="one option of the profile",
    )
    diagnose.add_argument(
        "--temperature", metavar="C", type=_number_of(TEMPERATURE), help="of the stated condition [°C]"
    )
    diagnose.add_argument(
        "--rpm", metavar="N", type=_number_of(ENGINE_SPEED), help="engine speed of the stated condition"
    )
    diagnose.add_argument("--gear", metavar="N", type=int, help="gear of the stated condition")
    diagnose.add_argument("--mileage", metavar="KM", type=_number_of(MILEAGE), help="of the vehicle [km]")
    diagnose.add_argument(
        "--assume", metavar="NAME=VALUE", type=_pair, action="append", default=[], help="one assumed uncertainty"
    )
    diagnose.add_argument(
        "--guard", metavar="K", type=_number, help="guard band of every limit in standard uncertainties"
    )
    diagnose.add_argument("--spool-instrument", metavar="ID|FILE", help="with which spools were measured")
    diagnose.add_argument("--sleeve-instrument", metavar="ID|FILE", help="with which sleeves were measured")
    diagnose.add_argument("--json", metavar="FILE|-")
    diagnose.add_argument("--xlsx", metavar="FILE")
    diagnose.add_argument("--pdf", metavar="FILE")
    _add_print(diagnose)
    diagnose.add_argument("--sections", metavar="LIST", help="of the PDF, with commas; all of them unless given")
    diagnose.add_argument("--job", metavar="FILE", help="job record (TOML or JSON) for the reports")
    diagnose.add_argument("--job-file", metavar="FILE.zip", help="the whole job as one file")
    diagnose.add_argument(
        "--fail-on",
        choices=[level.value for level in FLAGGED],
        help="end with status 1 where a land or a total is at or past this level",
    )
    _add_force(diagnose)

    variants = add("variants", _variants, "W1 to W8 of the source study, as printed and as computed")
    _add_controller(variants)
    variants.add_argument("--road-test", metavar="LOG", help="your own log instead of the shipped test")
    _add_columns(variants)
    variants.add_argument("--json", metavar="FILE|-")
    _add_force(variants)

    log = add("import-log", _import_log, "what is understood of a road-test log")
    log.add_argument("road_test", metavar="LOG", help="text, xlsx or mf4, as the logger wrote it")
    _add_columns(log)
    log.add_argument("--json", metavar="FILE|-")
    log.add_argument("--csv", metavar="FILE|-", help="the log as a plain table in rpm, °C, kPa and km/h")
    _add_force(log)
    log.add_argument("--forget", action="store_true", help="do not remember --map and --unit for logs with this header")

    report = add("report", _report, "the reports of job files")
    report.add_argument("jobs", metavar="JOB.zip", nargs="+", help="as diagnose --job-file writes them")
    report.add_argument("-o", "--output", metavar="FOLDER", required=True)
    report.add_argument(
        "--formats", metavar="LIST", type=_formats, default=["pdf"], help="pdf, xlsx, json, or several with commas"
    )
    _add_print(report)
    _add_force(report)

    template = add("template", _template, "a measuring sheet to fill in")
    _add_controller(template)
    template.add_argument("-o", "--output", metavar="FILE.xlsx", required=True)
    _add_force(template)

    for name, run in (
        ("controllers", _controllers),
        ("fluids", _fluids),
        ("limits", _limits),
        ("instruments", _instruments),
    ):
        listing = add(name, run, f"the {name} of the catalogue")
        listing.add_argument("--json", metavar="FILE|-")
        _add_force(listing)

    app = add("app", _app, "the dashboard in a browser")
    app.add_argument("--port", metavar="N", type=int)
    app.add_argument("--address", metavar="A", default="127.0.0.1")
    return parser


def _adder(commands: Any) -> Callable[[str, Callable[..., int], str], argparse.ArgumentParser]:
    def add(name: str, run: Callable[..., int], about: str) -> argparse.ArgumentParser:
        parser = commands.add_parser(name, help=about, description=about[0].upper() + about[1:] + ".")
        parser.set_defaults(run=run)
        return parser

    return add


def _add_controller(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--controller", metavar="ID|FILE", help="the study's four-speed controller unless given")


def _add_force(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--force", action="store_true", help="write over files that atleak did not make, too")


def _add_print(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--language", choices=languages(), default="en", help="of the PDF")
    parser.add_argument("--paper", choices=["a4", "letter"], default="a4", help="of the PDF and the workbook")


def _add_columns(parser: argparse.ArgumentParser) -> None:
    for name, what in (("map", "COLUMN"), ("unit", "UNIT")):
        parser.add_argument(
            f"--{name}",
            metavar=f"QUANTITY={what}",
            type=_pair,
            action="append",
            default=[],
            help=f"the {what.lower()} of a quantity of the log",
        )
    parser.add_argument(
        "--constant",
        metavar="QUANTITY=VALUE",
        type=_constant,
        action="append",
        default=[],
        help="what stands for a channel that the log lacks, in kPa, °C or rpm: converter_pressure=300",
    )


def _constant(text: str) -> tuple[str, float]:
    """``converter_pressure=300`` in kPa, °C, rpm or a plain number → SI."""
    from atleak.intake.units import unit
    from atleak.road_test import QUANTITIES

    name, value = _pair(text)
    if name not in QUANTITIES:
        raise argparse.ArgumentTypeError(str(unknown("no such quantity of a log", name, QUANTITIES)))
    known = QUANTITIES[name]
    number = _number_of(AskedNumber(known.label, known.workshop_unit))(value)
    return name, unit(known.workshop_unit, known.unit_kind).to_si(number) if known.unit_kind else number


def _number(text: str) -> float:
    value = decimal_number(text)
    if value is None:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number")
    return value


def _number_of(asked: AskedNumber) -> Callable[[str], float]:
    """The reader of an option that takes this number."""

    def read(text: str) -> float:
        found = read_number(text, asked)
        if found.value is None:
            raise argparse.ArgumentTypeError(found.doubt)
        return found.value

    return read


def _formats(text: str) -> list[str]:
    from atleak.report.batch import KINDS

    names = [name.strip().lower() for name in text.split(",")]
    for name in names:
        if name not in KINDS:
            raise argparse.ArgumentTypeError(f"{name!r} is not one of {', '.join(KINDS)}")
    return names


def _pair(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals or not name.strip():
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE")
    return name.strip(), value.strip()


def _say(written: list[str]) -> None:
    for name in written:
        print(f"written: {name}")


def _write(target: str, content: bytes) -> list[str]:
    """Write to a file or, for ``-``, to standard output; the names of the files written."""
    if target == "-":
        sys.stdout.write(content.decode("utf-8"))
        return []
    replace_file(target, content)
    return [target]
