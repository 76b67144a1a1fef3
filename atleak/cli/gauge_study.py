"""Tell how well a gauge measures: ``atleak gauge-study``."""

from __future__ import annotations

import argparse
from typing import Any

from atleak.analysis.gauge_study import ALPHA, analysed
from atleak.catalogue.written_numbers import decimal_number
from atleak.cli.parser import add_command
from atleak.cli.shared import Outputs, add_force, add_json
from atleak.common.errors import InputError
from atleak.common.sentences import Sentence
from atleak.common.units import MM
from atleak.common.wording import wording
from atleak.readers.gauges.gauge_study import read_study
from atleak.report.tables.gauge_study import study_record, study_sections
from atleak.report.terminal import print_sections


def add_parser(commands: Any, name: str) -> None:
    """Add the command."""
    examples = ("gauge-study study.xlsx", "gauge-study study.csv --unit µm --tolerance 0.02 --json study.json")
    parser = add_command(commands, name, run, examples=examples)
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
    outputs = Outputs(options, [options.file])
    tolerance = None if options.tolerance is None else _number(options.tolerance, "--tolerance") / MM
    alpha = ALPHA if options.alpha is None else _number(options.alpha, "--alpha")
    readings = read_study(options.file, sheet=options.sheet, length_unit=options.unit)
    study = analysed(readings, tolerance=tolerance, alpha=alpha)
    outputs.write(json=lambda: study_record(study))
    if outputs.shown:
        print_sections(study_sections(study, wording("en")).values(), study.messages)
    outputs.say_written()
    return 0


def _number(text: str, option: str) -> float:
    number = decimal_number(text)
    if number is None:
        problem = Sentence("{option} is not a number", option=option)
        raise InputError(problem, value=text, expected=Sentence("a number such as {example}", example="0.02"))
    return number
