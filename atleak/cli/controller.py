"""Describe a valve body in a workbook, and learn its mounting clearances from measuring sheets of new units.

``atleak controller template|from-workbook|to-workbook|learn|export|check``.
"""

from __future__ import annotations

import argparse
import datetime as dt
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from atleak.analysis.learning.learned_clearances import Learned, learn
from atleak.analysis.learning.learned_words import learned_messages, summary, with_learned
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import checked_controller, load_controller, written_toml
from atleak.catalogue.entries import Entry, read_tables
from atleak.catalogue.instruments import load_instruments
from atleak.catalogue.workbook.cells import CLEARANCES, LENGTHS, PRESSURES, Units
from atleak.cli.job_options import add_sheet
from atleak.cli.parser import add_command, add_group
from atleak.cli.shared import Outputs, add_force, add_json, add_mapping, add_units, mapped_columns
from atleak.common.errors import InputError
from atleak.common.sentences import Sentence
from atleak.common.wording import Wording, wording
from atleak.job_book.book import open_book
from atleak.job_book.new_sheets import NewSheet, new_sheets, shared_instruments
from atleak.readers.controller_workbook import is_workbook, read_controller_workbook
from atleak.readers.remembered_columns import default_path
from atleak.readers.sheets.measuring_sheet import read_several
from atleak.report.sheets.controller_export import exported_controller
from atleak.report.sheets.controller_workbook import write_controller_workbook
from atleak.report.tables.catalogue import evidence_counts, open_values
from atleak.report.tables.learned import learned_lands, learned_record
from atleak.report.tables.table import Column
from atleak.report.terminal import print_table


def add_learn(group: Any) -> None:
    """Add the command to those about the description of a valve body."""
    parser = add_command(
        group,
        "learn",
        run,
        "mounting clearances from measuring sheets of new or known-good units",
        usage="atleak controller learn [SHEET ...] --controller ID|FILE [options]",
        examples=(
            "controller learn new_1.xlsx new_2.xlsx --controller my_unit.toml -o my_unit_learned.toml",
            "controller learn --from-book --controller four_speed_2023",
        ),
    )
    parser.add_argument(
        "sheets",
        metavar="SHEET",
        nargs="*",
        help="measuring sheet of one unit; of a used one the readings marked as taken at unworn ends count",
    )
    parser.add_argument(
        "--from-book",
        action="store_true",
        help="also the sheets of the job book of units that are new, and of lands that were repaired",
    )
    parser.add_argument("--controller", metavar="ID|FILE", required=True, help="the valve body that they are of")
    parser.add_argument("-o", "--output", metavar="FILE.toml|-", help="its file with the clearances that were learned")
    add_sheet(parser)
    add_mapping(parser)
    help = "the valve body that the sheets name, where this one was copied from it"
    parser.add_argument("--made-for", metavar="ID", help=help)
    add_units(parser)
    add_json(parser)
    add_force(parser)


def run(options: argparse.Namespace) -> int:
    """Learn, write the file that was asked for, and show what was learned."""
    if options.output == options.json == "-":
        problem = Sentence("only one of -o and --json can be written to standard output")
        raise InputError(problem, expected=Sentence("a file for the other"))
    outputs = Outputs(options, [options.controller, *options.sheets], "TOML file")
    controller = load_controller(options.controller)
    chosen = {"spool": options.spool_instrument, "sleeve": options.sleeve_instrument}
    of_book = _of_book(options, controller.id)
    instruments = (
        shared_instruments(of_book)
        if of_book and not any(chosen.values())
        else load_instruments(**{part: named for part, named in chosen.items() if named is not None})
    )
    columns = mapped_columns(options)
    sheets = read_several(
        ((Path(name).name, name) for name in options.sheets),
        controller,
        sheet=columns["sheet_name"],
        unit=columns["sheet_unit"],
        mapping=dict(columns["sheet_columns"]),
        remembered=default_path(),
        where=dict(options.where),
        fill_down=options.fill_down,
        made_for=options.made_for,
    )
    sheets += [sheet.readings(controller) for sheet in of_book]
    learned = learn(controller, sheets, instruments=instruments, temperature=options.measuring_temperature)
    outputs.write(output=lambda: _learned_toml(options, learned), json=lambda: learned_record(learned))
    if outputs.shown:
        _show(learned, wording("en", options.units))
    outputs.say_written()
    return 0


def _of_book(options: argparse.Namespace, controller: str) -> tuple[NewSheet, ...]:
    """Return the sheets of the job book that are asked for; of a valve body that was copied those of the original."""
    if not options.from_book:
        if not options.sheets:
            expected = Sentence("one for each unit, or --from-book")
            raise InputError(Sentence("no measuring sheet is given"), expected=expected)
        return ()
    return new_sheets(open_book(), options.made_for or controller)


def _learned_toml(options: argparse.Namespace, learned: Learned) -> str:
    tables = with_learned(read_tables("controllers", options.controller)[0], learned, dt.date.today())
    checked_controller(tables, str(options.output))
    return written_toml(tables)


def _show(learned: Learned, say: Wording) -> None:
    print(say.sentence(summary(learned)))
    lands = learned_lands(learned, say)
    pair = Column("pair", of=lambda each: "{}/{}".format(*each.land.key), whole=True)  # as options and records take it
    print_table(replace(lands, columns=(pair, *lands.columns[1:])))
    for message in learned_messages(learned):
        print(f"{'! ' if message.level == 'warning' else ''}{say.sentence(message.text)}")


_LOST = "comments and the order of keys in a TOML file are not kept on the way through a workbook"


def add_parser(commands: Any, name: str) -> None:
    """Add the commands."""
    examples = (
        "controller template -o my_unit.xlsx --units inch --clearance diametral",
        "controller check my_unit.xlsx",
        "controller from-workbook my_unit.xlsx -o my_unit.toml",
        "controller learn new_unit.xlsx --controller my_unit.toml -o my_unit_learned.toml",
    )
    group = add_group(commands, name, examples)
    begun = ("controller template -o my_unit.xlsx", "controller template --from four_speed_2023 -o mine.xlsx")
    template = add_command(group, "template", _template, "a workbook to fill in", examples=begun)
    help = "start from this one: all of it is filled in but its id, name, source and date"
    template.add_argument("--from", dest="start", metavar="ID|FILE", help=help)
    _add_workbook(template)
    example = "controller from-workbook my_unit.xlsx -o my_unit.toml"
    read = add_command(group, "from-workbook", _from_workbook, "a filled workbook as TOML file", examples=[example])
    read.add_argument("workbook", metavar="FILE.xlsx", help="as template or to-workbook writes it, filled in")
    read.add_argument("-o", "--output", metavar="FILE.toml|-", required=True, help="what --controller takes")
    add_force(read)
    about = "a valve body as workbook, to change it there"
    example = "controller to-workbook four_speed_2023 -o mine.xlsx"
    written = add_command(group, "to-workbook", _to_workbook, about, examples=[example])
    written.add_argument("controller", metavar="ID|FILE", help="the valve body")
    _add_workbook(written)
    add_learn(group)
    about = "a valve body to pass on: where it comes from, what was learned, nothing of whose units"
    example = "controller export my_unit_learned.toml -o my_unit_for_all.toml"
    passed_on = add_command(group, "export", _export, about, examples=[example])
    passed_on.add_argument("controller", metavar="ID|FILE", help="the valve body")
    passed_on.add_argument("-o", "--output", metavar="FILE.toml|-", required=True, help="what --controller takes")
    add_force(passed_on)
    about = "whether a valve body is described well: lists all faults at once"
    check = add_command(group, "check", _check, about, examples=("controller check my_unit.xlsx",))
    check.add_argument("file", metavar="FILE", help="workbook, TOML file, or id of a shipped one")


def _add_workbook(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", metavar="FILE.xlsx", required=True, help="the workbook")
    parser.add_argument("--units", choices=LENGTHS, default=LENGTHS[0], help="of lengths and clearances")
    help = "half of bore minus spool, or all of it"
    parser.add_argument("--clearance", choices=CLEARANCES, default=CLEARANCES[0], help=help)
    parser.add_argument("--pressure", choices=PRESSURES, default=PRESSURES[0], help="unit of pressures")
    add_force(parser)


def _template(options: argparse.Namespace) -> int:
    def begun() -> Mapping[str, Any] | None:
        if options.start is None:
            return None
        tables, _ = _described(options.start)
        return {key: value for key, value in tables.items() if key not in Entry.model_fields}

    return _write_workbook(options, options.start, begun)


def _to_workbook(options: argparse.Namespace) -> int:
    status = _write_workbook(options, options.controller, lambda: _described(options.controller)[0])
    print(f"atleak: {_LOST}", file=sys.stderr)
    return status


def _write_workbook(
    options: argparse.Namespace, source: str | None, described: Callable[[], Mapping[str, Any] | None]
) -> int:
    outputs = Outputs(options, [source], "controller workbook")
    units = Units(options.units, options.clearance, options.pressure)
    outputs.write(output=lambda: write_controller_workbook(described(), units))
    outputs.say_written()
    return 0


def _from_workbook(options: argparse.Namespace) -> int:
    outputs = Outputs(options, [options.workbook], "TOML file")
    tables, controller = _from_sheets(options.workbook)
    outputs.write(output=lambda: written_toml(tables))
    outputs.say_written()
    if outputs.shown:
        print(_summary(controller))
    return 0


def _export(options: argparse.Namespace) -> int:
    outputs = Outputs(options, [options.controller], "TOML file")
    controller = load_controller(options.controller)
    exported = exported_controller(read_tables("controllers", options.controller)[0], controller, dt.date.today())
    outputs.write(output=lambda: exported.text)
    outputs.say_written()
    if exported.left_out:
        print(f"atleak: left out {exported.left_out} paths, names of files and numbers of vehicles", file=sys.stderr)
    if exported.own_words:
        print("atleak: words of your own go along; read them before you pass the file on:", file=sys.stderr)
    for words in exported.own_words:
        print(f"  {words}", file=sys.stderr)
    return 0


def _check(options: argparse.Namespace) -> int:
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
    if to_measure := open_values(controller, wording("en")):
        print(f"assumed, to be measured or looked up: {', '.join(to_measure)}")
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
    if is_workbook(id_or_path) or Path(id_or_path).suffix.lower() == ".xlsx":
        return _from_sheets(id_or_path)
    controller = load_controller(id_or_path)
    return read_tables("controllers", id_or_path)[0], controller


def _from_sheets(path: str) -> tuple[dict[str, Any], Controller]:
    """Return what a workbook describes; what was taken for granted is said aloud."""
    described = read_controller_workbook(path)
    for note in described.notes:
        print(f"atleak: {note}", file=sys.stderr)
    return described.data, described.controller
