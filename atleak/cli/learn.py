"""Learn mounting clearances from measuring sheets of new units: ``atleak controller learn``."""

from __future__ import annotations

import argparse
import datetime as dt
from dataclasses import replace
from pathlib import Path
from typing import Any

from atleak.catalogue.catalogue_toml import written_toml
from atleak.catalogue.controller_reading import checked_controller, load_controller
from atleak.catalogue.entries import read_tables
from atleak.catalogue.instruments import load_instruments
from atleak.cli.job_options import add_sheet
from atleak.cli.parser import add_command
from atleak.cli.shared import Outputs, add_force, add_json
from atleak.errors import InputError
from atleak.intake.readings.several import read_several
from atleak.jobs.book import open_book
from atleak.jobs.new_sheets import NewSheet, new_sheets, shared_instruments
from atleak.learning.learned import Learned, learn
from atleak.learning.tables import with_learned
from atleak.learning.words import messages, summary
from atleak.report.terminal import print_table
from atleak.sentence import Sentence
from atleak.views.learned_table import learned_lands, learned_record
from atleak.views.table import Column
from atleak.wording import wording


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
    help = "the valve body that the sheets name, where this one was copied from it"
    parser.add_argument("--made-for", metavar="ID", help=help)
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
    sheets = read_several(
        ((Path(name).name, name) for name in options.sheets),
        controller,
        sheet=options.sheet,
        unit=options.sheet_unit,
        where=dict(options.where),
        fill_down=options.fill_down,
        made_for=options.made_for,
    )
    sheets += [sheet.readings(controller) for sheet in of_book]
    learned = learn(controller, sheets, instruments=instruments, temperature=options.measuring_temperature)
    outputs.write(output=lambda: _learned_toml(options, learned), json=lambda: learned_record(learned))
    if outputs.shown:
        _show(learned)
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


def _show(learned: Learned) -> None:
    print(summary(learned))
    lands = learned_lands(learned, wording("en"))
    pair = Column("pair", of=lambda each: "{}/{}".format(*each.land.key), whole=True)  # as options and records take it
    print_table(replace(lands, columns=(pair, *lands.columns[1:])))
    for message in messages(learned):
        print(f"{'! ' if message.level == 'warning' else ''}{message.text}")
