"""Tell how well a gauge measures: ``atleak gauge-study``."""

from __future__ import annotations

import argparse
from typing import Any

from atleak.cli.parser import add_command
from atleak.cli.shared import (
    add_force,
    add_json,
    check_targets,
    say_written,
    write_json,
)
from atleak.errors import InputError
from atleak.sentence import Sentence
from atleak.written_numbers import decimal_number


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "gauge-study",
        run,
        "repeatability and reproducibility of a gauge, by ANOVA",
        examples=("gauge-study study.xlsx", "gauge-study study.csv --unit µm --tolerance 0.02 --json study.json"),
    )
    parser.add_argument("file", metavar="FILE", help="repeated readings of several parts by several people: xlsx, csv")
    parser.add_argument("--sheet", metavar="NAME", help="of the workbook, where several hold readings")
    parser.add_argument(
        "--unit", metavar="UNIT", help="of all readings: mm unless their heading or this says otherwise"
    )
    parser.add_argument("--tolerance", metavar="MM", help="width between the two limits of the part")
    parser.add_argument(
        "--alpha", metavar="P", default=None, help="the interaction is kept below it; 0.05 unless given"
    )
    add_json(parser)
    add_force(parser)


def run(options: argparse.Namespace) -> int:
    """Analyse the readings and show the components of their variation."""
    from atleak.gauge_study.anova import ALPHA, analysed
    from atleak.intake.gauge_study import read_study
    from atleak.report.terminal import print_gauge_study
    from atleak.views.gauge_study import study_record
    from atleak.wording import wording
    from atleak.workshop_units import MM

    check_targets(options, [options.file], [("record", options.json)])
    tolerance = None if options.tolerance is None else _number(options.tolerance, "--tolerance") / MM
    alpha = ALPHA if options.alpha is None else _number(options.alpha, "--alpha")
    readings = read_study(options.file, sheet=options.sheet, length_unit=options.unit)
    study = analysed(readings, tolerance=tolerance, alpha=alpha)
    if options.json is not None:
        say_written(write_json(options.json, study_record(study)))
    if options.json != "-":
        print_gauge_study(study, wording("en"))
    return 0


def _number(text: str, option: str) -> float:
    number = decimal_number(text)
    if number is None:
        problem = Sentence("{option} is not a number", option=option)
        raise InputError(problem, value=text, expected=Sentence("a number such as {example}", example="0.02"))
    return number
