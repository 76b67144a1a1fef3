"""Compute studies: the source study's W1 to W8, ``atleak variants``, and a gauge's, ``atleak gauge-study``."""

from __future__ import annotations

import argparse
from typing import Any

from atleak.analysis.gauge_study import ALPHA, analysed
from atleak.analysis.source_study import run_variants, sample_log
from atleak.catalogue.written_numbers import decimal_number
from atleak.cli.parser import add_command
from atleak.cli.shared import (
    Outputs,
    add_columns,
    add_controller,
    add_force,
    add_json,
    add_mapping,
    add_units,
    chosen_controller,
    chosen_road_test,
)
from atleak.common.errors import InputError
from atleak.common.sentences import Sentence
from atleak.common.units import MM
from atleak.common.wording import wording
from atleak.readers.gauges.gauge_study import read_study
from atleak.report.tables.gauge_study import study_record, study_sections
from atleak.report.tables.source_study import table_2, table_3, variants_record
from atleak.report.terminal import print_sections, print_table


def add_parser(commands: Any, name: str) -> None:
    """Add one of the commands."""
    add = _add_variants if name == "variants" else _add_gauge_study
    add(commands, name)


def _add_variants(commands: Any, name: str) -> None:
    """Add the command."""
    parser = add_command(commands, name, _variants, examples=("variants", "variants --json variants.json"))
    add_controller(parser)
    parser.add_argument("--road-test", metavar="LOG", help="your own log instead of the shipped test")
    add_mapping(parser)
    add_columns(parser)
    add_json(parser)
    add_force(parser)


def _variants(options: argparse.Namespace) -> int:
    """Compute the variants and show them."""
    outputs = Outputs(options, (options.road_test, options.controller))
    options.road_test = options.road_test or sample_log()
    controller, road_test = chosen_controller(options), chosen_road_test(options)
    results = run_variants(controller, road_test)
    outputs.write(json=lambda: variants_record(results, controller, road_test))
    if outputs.shown:
        say = wording("en")
        print_table(table_2(results, say))
        print_table(table_3(results, say))
        print(
            f"Leakage in dm³/min at its maximum over the log, share in % at that instant. {say('study.table_3_help')}"
        )
    outputs.say_written()
    return 0


def _add_gauge_study(commands: Any, name: str) -> None:
    """Add the command."""
    examples = ("gauge-study study.xlsx", "gauge-study study.csv --unit µm --tolerance 0.02 --json study.json")
    parser = add_command(commands, name, _gauge_study, examples=examples)
    parser.add_argument("file", metavar="FILE", help="repeated readings of several parts by several people: xlsx, csv")
    parser.add_argument("--sheet", metavar="NAME", help="of the workbook, where several hold readings")
    parser.add_argument(
        "--unit", metavar="UNIT", help="of all readings: mm unless their heading or this says otherwise"
    )
    parser.add_argument("--tolerance", metavar="MM", help="width between the two limits of the part")
    parser.add_argument(
        "--alpha", metavar="P", default=None, help="the interaction is kept below it; 0.05 unless given"
    )
    add_units(parser)
    add_json(parser)
    add_force(parser)


def _gauge_study(options: argparse.Namespace) -> int:
    """Analyse the readings and show the components of their variation."""
    outputs = Outputs(options, [options.file])
    tolerance = None if options.tolerance is None else _number(options.tolerance, "--tolerance") / MM
    alpha = ALPHA if options.alpha is None else _number(options.alpha, "--alpha")
    readings = read_study(options.file, sheet=options.sheet, length_unit=options.unit)
    study = analysed(readings, tolerance=tolerance, alpha=alpha)
    outputs.write(json=lambda: study_record(study))
    if outputs.shown:
        say = wording("en", options.units)
        print_sections(study_sections(study, say).values(), study.messages, say)
    outputs.say_written()
    return 0


def _number(text: str, option: str) -> float:
    number = decimal_number(text)
    if number is None:
        problem = Sentence("{option} is not a number", option=option)
        raise InputError(problem, value=text, expected=Sentence("a number such as {example}", example="0.02"))
    return number
