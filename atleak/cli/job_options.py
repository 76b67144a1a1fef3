"""The options that make a job of files and choices: those of ``atleak diagnose`` and of ``atleak jobs add``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from atleak.catalogue.written_numbers import (
    ENGINE_SPEED,
    MEASURING_TEMPERATURE,
    MILEAGE,
    PUMP_SIDE_CLEARANCE,
    PUMP_TIP_CLEARANCE,
    TEMPERATURE,
)
from atleak.cli.parser import CommandOptions
from atleak.cli.shared import (
    SAMPLE_LOG,
    add_columns,
    add_controller,
    add_mapping,
    add_pairs,
    length_of,
    log_constants,
    mapped_columns,
    number_argument,
    number_of_argument,
    or_sample,
    say_doubts,
    write_map_file,
)
from atleak.common.errors import InputError, OutputError, unknown
from atleak.common.sentences import Sentence

if TYPE_CHECKING:
    from atleak.diagnosis.diagnosis import Diagnosis
    from atleak.job.case import Case
    from atleak.measurements.job_card import Job

_POSITION = "eccentricity"  # an option of the profile that people also look for among the assumptions


def add_job_options(parser: argparse.ArgumentParser, *, grows: bool = False) -> None:
    """Add the files and choices of a job, which `chosen_job` makes a job of.

    Parameters
    ----------
    grows
        whether its log is one that a logger is still writing: named first, as a file or as the folder that it is in.
    """
    if grows:
        help = "text that a logger is writing, or the folder of which the newest log is followed; sample: one of atleak"
        log = parser.add_argument_group("the log")
        log.add_argument("road_test", metavar="LOG", type=or_sample(SAMPLE_LOG), help=help)
        add_columns(log)
    _add_measured(parser.add_argument_group("what was measured"))
    if not grows:
        _add_road_test(parser.add_argument_group("the road test"))
    add_mapping(
        parser.add_argument_group("which column is what, of sheet and log, where the headings do not tell"), keeps=True
    )
    _add_unit(parser.add_argument_group("the unit and its job"))
    _add_condition(parser.add_argument_group("the stated condition, in place of the valve body's first"))
    _add_computing(parser.add_argument_group("how it is computed and judged"))
    parser.set_defaults(refuse=parser.error)


def add_choices(parser: argparse.ArgumentParser) -> None:
    """Add the choices of a job without its files, for the rows of a table; `chosen_case` makes a case of them."""
    add_sheet(parser.add_argument_group("how measuring sheets are read, where their row does not say"))
    logs = parser.add_argument_group("how logs are read, where their row does not say")
    add_mapping(logs)
    add_columns(logs)
    _add_catalogue(parser.add_argument_group("what units are diagnosed with, where their row does not say"))
    _add_condition(parser.add_argument_group("the stated condition, in place of each valve body's first"))
    _add_computing(parser.add_argument_group("how they are computed and judged"))
    parser.set_defaults(**_OF_ONE_JOB)


_OF_ONE_JOB: dict[str, Any] = {
    **dict.fromkeys(("readings", "road_test", "pressures", "vacuum", "flows", "mileage", "complaint")),
    **dict.fromkeys(("pump_side_clearance", "pump_tip_clearance")),
    "repair": [],
}


def _add_measured(group: CommandOptions) -> None:
    help = (
        "measuring sheet: xlsx, xls, ods or csv; sample: the one that comes with atleak, unless there is a file "
        "of that name; without one the road test is judged by itself"
    )
    sample = or_sample("measuring_sheet_four_speed.xlsx")
    group.add_argument("readings", metavar="READINGS", nargs="?", type=sample, help=help)
    add_sheet(group)
    help = "clearance of this job's pump [µm, or with its unit: 0.0033in]; as the job record or the sheet's head says"
    for side, asked in (("side", PUMP_SIDE_CLEARANCE), ("tip", PUMP_TIP_CLEARANCE)):
        group.add_argument(
            f"--pump-{side}-clearance", metavar="UM", type=length_of(asked), help=f"{side} {help} unless given"
        )
    help = "gauge readings of the standing vehicle: xlsx or csv; the measuring sheet's own tab unless given"
    group.add_argument("--pressures", metavar="FILE", help=help)
    help = "vacuum test: what a stand's gauge showed of circuits and lands, xlsx or csv"
    group.add_argument("--vacuum", metavar="FILE", help=help)
    help = "flows caught in a jug, the cooler's at hot idle for one: xlsx or csv"
    group.add_argument("--flows", metavar="FILE", help=help)


def add_sheet(group: CommandOptions) -> None:
    """Add how measuring sheets are read, and with what they were measured."""
    group.add_argument("--sheet", metavar="NAME", help="of the workbook, where several hold readings")
    help = "of the diameters, where the sheet does not say: mm, µm, inch"
    group.add_argument("--sheet-unit", metavar="UNIT", help=help)
    help = "the rows of the sheet to read, where it holds several inspections or vehicles: Inspection=May"
    add_pairs(group, "--where", "HEADING=VALUE", help)
    help = "an empty cell under a valve, land, part or direction means the one above it"
    group.add_argument("--fill-down", action="store_true", help=help)
    help = "of gauge and parts when they were measured [°C]; as the job record or the sheet says unless given"
    group.add_argument(
        "--measuring-temperature", metavar="C", type=number_of_argument(MEASURING_TEMPERATURE), help=help
    )
    group.add_argument("--spool-instrument", metavar="ID|FILE", help="with which spools were measured")
    group.add_argument("--sleeve-instrument", metavar="ID|FILE", help="with which sleeves were measured")


def _add_road_test(group: CommandOptions) -> None:
    help = "road-test log of any logger: text, xlsx or mf4; sample: likewise"
    group.add_argument("--road-test", metavar="LOG", type=or_sample(SAMPLE_LOG), help=help)
    add_columns(group)


def _add_catalogue(group: CommandOptions) -> None:
    add_controller(group)
    help = "ATF in the transmission; the one that the valve body's file names unless given; `atleak fluids` lists all"
    group.add_argument("--fluid", metavar="ID|FILE", help=help)
    help = "of the fluid in the transmission; taken as fresh unless given"
    group.add_argument("--fluid-state", metavar="fresh|used", type=_fluid_state, help=help)


def _add_unit(group: CommandOptions) -> None:
    _add_catalogue(group)
    group.add_argument("--mileage", metavar="KM", type=number_of_argument(MILEAGE), help="of the vehicle [km]")
    group.add_argument("--complaint", metavar="ID", help="of the customer, one that the valve body's file maps")
    group.add_argument("--job", metavar="RECORD", help="what the workshop wrote down (TOML or JSON)")
    help = "plan with this repair of the valve body's file; of other lands the cheapest is planned"
    group.add_argument("--repair", metavar="ID", action="append", default=[], help=help)


def _add_condition(group: CommandOptions) -> None:
    group.add_argument("--temperature", metavar="C", type=number_of_argument(TEMPERATURE), help="of the fluid [°C]")
    group.add_argument("--rpm", metavar="N", type=number_of_argument(ENGINE_SPEED), help="engine speed")
    group.add_argument("--gear", metavar="N", type=int, help="gear that is engaged")


def _add_computing(group: CommandOptions) -> None:
    group.add_argument("--limits", metavar="ID|FILE", help="limits to judge by; `atleak limits` lists those known")
    group.add_argument("--profile", metavar="NAME", type=_profile, help="of the engine: workshop unless given")
    add_pairs(group, "--set", "OPTION=VALUE", "one option of the profile")
    help = "one assumed uncertainty; or eccentricity=unknown, an option of the profile"
    add_pairs(group, "--assume", "NAME=VALUE", help)
    group.add_argument(
        "--guard", metavar="K", type=number_argument, help="guard band of every limit in standard uncertainties"
    )


def _profile(text: str) -> str:
    from atleak.engine.profile import PROFILES

    if text not in PROFILES:
        raise argparse.ArgumentTypeError(str(unknown(Sentence("no such profile"), text, PROFILES)))
    return text


def _fluid_state(text: str) -> str:
    from atleak.catalogue.fluid import FluidState

    if text not in get_args(FluidState):
        raise argparse.ArgumentTypeError(str(unknown(Sentence("no such state of a fluid"), text, get_args(FluidState))))
    return text


def input_files(options: argparse.Namespace) -> tuple[str | None, ...]:
    """Return the files that the command line names, for `atleak.cli.shared.Outputs`."""
    from atleak.job.case import OWN_FILES, SLOTS

    return (options.job, *(getattr(options, name) for name in (*OWN_FILES, *SLOTS)))


def chosen_job(options: argparse.Namespace, *, may_be_new: bool = False) -> tuple[Case, Job | None]:
    """Return the files and choices that the command line names, and the record; what it says counts where they do not.

    Where nothing was measured the command ends with a word on its usage, unless it ``may_be_new``: a unit of which
    nothing was.
    """
    from atleak.job.case import OWN_FILES, SLOTS, Reader, with_record

    if not may_be_new and all(getattr(options, name) is None for name in OWN_FILES):
        given = "no measuring sheet, road test, gauge readings, vacuum test or flows are given"
        named = "READINGS, --road-test LOG, --pressures FILE, --vacuum FILE or --flows FILE"
        options.refuse(f"there is nothing to diagnose: {given}; expected {named}")
    case = chosen_case(options)
    if options.job is None:
        return case, None
    from atleak.analysis.record_doubts import check_decisions
    from atleak.job.zip_file import load_job

    job = load_job(options.job)
    if job.repair_decisions:
        check_decisions(job, Reader().entry(SLOTS["controller"], case.controller), Path(options.job).name)
    return with_record(case, job), job


def as_read(case: Case) -> Case:
    """Return the job with its log's columns as chosen or remembered here, so that it reads the same anywhere."""
    from atleak.job.case import Reader, with_log_choices

    return case if case.road_test is None else with_log_choices(case, Reader().log(case))


def _forget(case: Case) -> None:
    """Delete what was settled for files with the headings of this job's sheet and log."""
    from atleak.readers.logs import default_path, forget_columns, understand
    from atleak.readers.sheets.measuring_sheet import forget_sheet

    if case.readings is not None:
        forget_sheet(case.readings.given, default_path(), case.readings.name)
    if case.road_test is not None:
        forget_columns(default_path(), understand(case.road_test.given, name=case.road_test.name).signature)


def keep_columns(options: argparse.Namespace, case: Case, diagnosis: Diagnosis) -> None:
    """Say what was settled earlier, remember how the sheet's columns were named, and write it to the file asked for."""
    from atleak.readers.logs import default_path
    from atleak.readers.sheets.mapping import remember_sheet

    readings = diagnosis.readings
    say_doubts(message for message in (readings.messages if readings else ()) if message.code == "remembered")
    try:
        if case.sheet_columns and readings is not None and not options.forget:
            remember_sheet(default_path(), readings, case.sheet_unit)
    except OutputError as error:
        print(f"atleak: columns are not remembered: {error}", file=sys.stderr)
    units = {**dict(case.units), **({"value": case.sheet_unit} if case.sheet_unit else {})}
    of_sheet = dict(readings.columns) if readings is not None else {}
    write_map_file(options, {**of_sheet, **dict(case.columns)}, units, case.sheet_name)


def save_job(options: argparse.Namespace, case: Case, job: Job | None, diagnosis: Diagnosis) -> str:
    """Put a job into the job book, remember its columns, and return its id."""
    from atleak.analysis.record_doubts import with_sheet
    from atleak.job.parts import job_parts
    from atleak.job_book.book import open_book

    id = open_book().save(job_parts(diagnosis, with_sheet(job, diagnosis.readings), as_read(case))).id
    keep_columns(options, case, diagnosis)
    return id


def chosen_case(options: argparse.Namespace) -> Case:
    """Return the files and choices that the command line names, without what a job record says."""
    from atleak.catalogue.pump import PumpClearances
    from atleak.job.case import OWN_FILES, SLOTS, Case, SourceFile

    given = {name: getattr(options, name) for name in (*OWN_FILES, *SLOTS, "profile")}
    chosen: dict[str, Any] = {
        name: SourceFile.at(value) if name in OWN_FILES else value for name, value in given.items() if value is not None
    }
    case = Case(
        **chosen,
        fluid_state=options.fluid_state,
        options=_profile_options(options),
        temperature=options.temperature,
        engine_speed=None if options.rpm is None else options.rpm / 60.0,
        gear=options.gear,
        mileage=options.mileage,
        measuring_temperature=options.measuring_temperature,
        pump_clearances=PumpClearances.of_um(options.pump_side_clearance, options.pump_tip_clearance),
        **mapped_columns(options),
        remember=not getattr(options, "forget", False),
        sheet_where=tuple(options.where),
        sheet_fill_down=options.fill_down,
        constants=log_constants(options),
        every=options.every,
        assumptions=tuple(pair for pair in options.assume if pair[0] != _POSITION),
        guard_factor=options.guard,
        complaint=options.complaint,
        repairs=tuple(options.repair),
    )
    if not case.remember:
        _forget(case)
    return case


def _profile_options(options: argparse.Namespace) -> tuple[tuple[str, str], ...]:
    """Return the options of the profile, among them where the spools are assumed to lie."""
    assumed = [pair for pair in options.assume if pair[0] == _POSITION]
    if assumed and _POSITION in dict(options.set):
        expected = Sentence("--set or --assume, not both")
        raise InputError(Sentence("the eccentricity is set twice"), value=assumed[-1][1], expected=expected)
    return (*options.set, *assumed)
