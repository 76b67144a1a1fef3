"""Describe a valve body in a workbook: ``atleak controller template|from-workbook|to-workbook|learn|check``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from atleak.cli.learn import add_learn
from atleak.cli.parser import add_command, add_group
from atleak.cli.shared import add_force, check_targets, say_written, write, write_text
from atleak.errors import InputError
from atleak.sentence import Sentence

if TYPE_CHECKING:
    from atleak.catalogue.controller import Controller

_LOST = "comments and the order of keys in a TOML file are not kept on the way through a workbook"


def add_parser(commands: Any) -> None:
    """Add the commands."""
    about = "describe a valve body: in a workbook, and as the TOML file that every command takes"
    group = add_group(
        commands,
        "controller",
        about,
        examples=(
            "controller template -o my_unit.xlsx --units inch --clearance diametral",
            "controller check my_unit.xlsx",
            "controller from-workbook my_unit.xlsx -o my_unit.toml",
            "controller learn new_unit.xlsx --controller my_unit.toml -o my_unit_learned.toml",
        ),
    )
    _add_template(group)
    _add_from_workbook(group)
    _add_to_workbook(group)
    add_learn(group)
    about = "whether a valve body is described well: lists all faults at once"
    check = add_command(group, "check", _check, about, examples=("controller check my_unit.xlsx",))
    check.add_argument("file", metavar="FILE", help="workbook, TOML file, or id of a shipped one")


def _add_template(group: Any) -> None:
    template = add_command(
        group,
        "template",
        _template,
        "a workbook to fill in",
        examples=("controller template -o my_unit.xlsx", "controller template --from four_speed_2023 -o mine.xlsx"),
    )
    template.add_argument("-o", "--output", metavar="FILE.xlsx", required=True, help="the workbook")
    template.add_argument(
        "--from",
        dest="start",
        metavar="ID|FILE",
        help="start from this one: all of it is filled in but its id, name, source and date",
    )
    _add_units(template)
    add_force(template)


def _add_from_workbook(group: Any) -> None:
    parser = add_command(
        group,
        "from-workbook",
        _from_workbook,
        "a filled workbook as TOML file",
        examples=("controller from-workbook my_unit.xlsx -o my_unit.toml",),
    )
    parser.add_argument("workbook", metavar="FILE.xlsx", help="as template or to-workbook writes it, filled in")
    parser.add_argument("-o", "--output", metavar="FILE.toml|-", required=True, help="what --controller takes")
    add_force(parser)


def _add_to_workbook(group: Any) -> None:
    parser = add_command(
        group,
        "to-workbook",
        _to_workbook,
        "a valve body as workbook, to change it there",
        examples=("controller to-workbook four_speed_2023 -o mine.xlsx",),
    )
    parser.add_argument("controller", metavar="ID|FILE", help="the valve body")
    parser.add_argument("-o", "--output", metavar="FILE.xlsx", required=True, help="the workbook")
    _add_units(parser)
    add_force(parser)


def _add_units(parser: argparse.ArgumentParser) -> None:
    from atleak.controller_sheets.units import CLEARANCES, LENGTHS, PRESSURES

    parser.add_argument("--units", choices=LENGTHS, default=LENGTHS[0], help="of lengths and clearances")
    parser.add_argument(
        "--clearance", choices=CLEARANCES, default=CLEARANCES[0], help="half of bore minus spool, or all of it"
    )
    parser.add_argument("--pressure", choices=PRESSURES, default=PRESSURES[0], help="unit of pressures")


def _template(options: argparse.Namespace) -> int:
    from atleak.catalogue.entries import Entry

    _check_name(options.output, ".xlsx", Sentence("the workbook to fill in is a .xlsx file"))
    data = None
    if options.start is not None:
        tables = _described(options.start)[0]
        data = {key: value for key, value in tables.items() if key not in Entry.model_fields}
    return _write_workbook(options, options.start, data)


def _to_workbook(options: argparse.Namespace) -> int:
    _check_name(options.output, ".xlsx", Sentence("the workbook is a .xlsx file"))
    status = _write_workbook(options, options.controller, _described(options.controller)[0])
    print(f"atleak: {_LOST}", file=sys.stderr)
    return status


def _write_workbook(options: argparse.Namespace, source: str | None, data: Mapping[str, Any] | None) -> int:
    from atleak.controller_sheets.units import Units
    from atleak.report.controller_workbook import write_controller_workbook

    check_targets(options, [source], [("controller workbook", options.output)])
    units = Units(options.units, options.clearance, options.pressure)
    say_written(write(options.output, write_controller_workbook(data, units)))
    return 0


def _from_workbook(options: argparse.Namespace) -> int:
    from atleak.catalogue.catalogue_toml import written_toml

    if options.output != "-":
        _check_name(options.output, ".toml", Sentence("the description is a .toml file"))
    check_targets(options, [options.workbook], [("TOML file", options.output)])
    tables, controller = _from_sheets(options.workbook)
    say_written(write_text(options.output, written_toml(tables)))
    if options.output != "-":
        print(_summary(controller))
    return 0


def _check(options: argparse.Namespace) -> int:
    from atleak.views.evidence_rows import evidence_counts, still_to_measure

    controller = _described(options.file)[1]
    print(f"{_summary(controller)}; nothing is wrong with it")
    for doubt in controller.doubts:
        print(f"in doubt: {doubt.place}: {doubt.text}")
    if without := controller.gaps_not_described:
        leaking = [land for land in controller.lands if not land.seal]
        lands = ", ".join(f"{land.component}/{land.land}" for land in leaking if land.key in without)
        who = "no gap is described: every land is" if len(without) == len(leaking) else f"no gap of {lands}: each is"
        print(f"{who} taken to leak from main pressure to the sump, which is an upper bound")
    counts = evidence_counts(controller)
    print("values: " + ", ".join(f"{count} {known.replace('_', ' ')}" for known, count in counts.items()))
    if to_measure := still_to_measure(controller):
        print(f"representative, to be measured or looked up: {', '.join(to_measure)}")
    return 0


def _summary(controller: Controller) -> str:
    """Say what a valve body's description holds."""
    counts = {
        "components": len(controller.components),
        "lands": len(controller.lands),
        "gaps": sum(gap.key not in controller.gaps_not_described for gap in controller.gaps),
        "circuits": len(controller.circuits),
        "operating points": len(controller.operating_points),
    }
    return f"{controller.name}: " + ", ".join(f"{number} {what}" for what, number in counts.items())


def _described(id_or_path: str) -> tuple[dict[str, Any], Controller]:
    """Return the tables of a controller, described in a TOML file or in a workbook, and the controller."""
    from atleak.catalogue.controller_reading import load_controller
    from atleak.catalogue.entries import read_tables
    from atleak.intake.controller_workbook import is_workbook

    if is_workbook(id_or_path) or Path(id_or_path).suffix.lower() == ".xlsx":
        return _from_sheets(id_or_path)
    controller = load_controller(id_or_path)
    return read_tables("controllers", id_or_path)[0], controller


def _from_sheets(path: str) -> tuple[dict[str, Any], Controller]:
    """Return what a workbook describes; what was taken for granted is said aloud."""
    from atleak.intake.controller_workbook import read_controller_workbook

    described = read_controller_workbook(path)
    for note in described.notes:
        print(f"atleak: {note}", file=sys.stderr)
    return described.data, described.controller


def _check_name(name: str, suffix: str, problem: Sentence) -> None:
    if Path(name).suffix.lower() != suffix:
        raise InputError(problem, value=name, expected=Sentence("a name{suffix}", suffix=suffix))
