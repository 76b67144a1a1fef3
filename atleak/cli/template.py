"""Write forms to fill in: a measuring sheet, ``atleak template``, and cards for gauges and for a vacuum stand."""

from __future__ import annotations

import argparse
from typing import Any

from atleak.cli.job_options import add_job_options, chosen_job, input_files
from atleak.cli.parser import add_command
from atleak.cli.shared import Outputs, add_force, add_print, chosen_controller, doubt_option, print_font, print_options
from atleak.common.errors import InputError
from atleak.common.sentences import Sentence
from atleak.common.translations import languages
from atleak.common.units import SYSTEMS
from atleak.job.zip_file import load_job
from atleak.measurements.job_card import Job, clean_text
from atleak.report.sheets import measuring_head as head
from atleak.report.sheets.measuring_sheet import write_template

_TEXTS = {
    "number": "the job's number",
    "vehicle": "make and model",
    "vin": "of the vehicle",
    "serial": "of the transmission",
    "measured-by": "who measures",
}


def add_parser(commands: Any, name: str) -> None:
    """Add one of the commands."""
    add = _add_template if name == "template" else _add_card
    add(commands, name)


def _add_template(commands: Any, name: str) -> None:
    examples = (
        "template -o sheet.xlsx",
        "template --controller five_speed_2005 --number 2026-0417 --mileage 212000 -o sheet.xlsx",
        "template --quick --pressures gauges.csv --controller five_speed_2005 -o quick.xlsx",
    )
    usage = "atleak template [--controller ID|FILE] [--quick [READINGS] [--pressures FILE] ...] [options] -o FILE.xlsx"
    parser = add_command(commands, name, _template, examples=examples, usage=usage)
    help = "only the few lands whose reading tells most, by what is known of the unit; each once, in that order"
    parser.add_argument("--quick", action="store_true", help=help)
    add_job_options(parser)
    parser.add_argument("-o", "--output", metavar="FILE.xlsx", required=True, help="the sheet")
    parser.add_argument(
        "--language", choices=languages(), default="en", help="of the sheet; any is read back: en unless given"
    )
    parser.add_argument("--units", choices=tuple(SYSTEMS), default="metric", help="of the sheet: metric unless given")
    add_force(parser)
    head = parser.add_argument_group("what is known of the job: it stands in the sheet's head, with a QR code to scan")
    for name, what in _TEXTS.items():
        head.add_argument(f"--{name}", metavar="TEXT", help=f"{what}; as the job record says unless given")


def _template(options: argparse.Namespace) -> int:
    """Write the sheet."""
    outputs = Outputs(options, input_files(options), "measuring sheet")
    known = {"fields": _fields(options), "language": options.language, "units": options.units}
    if options.quick:
        outputs.write(output=lambda: _quick_sheet(options, known))
    else:
        for name in ("READINGS", "--pressures", "--road-test", "--complaint"):
            if getattr(options, name.strip("-").replace("-", "_").lower()) is not None:
                doubt_option(name, ["--quick"])
        outputs.write(output=lambda: write_template(chosen_controller(options), **known))
    outputs.say_written()
    return 0


def _quick_sheet(options: argparse.Namespace, known: dict[str, Any]) -> bytes:
    """Return the sheet of the lands that tell most of a unit by what is known of it."""
    from atleak.diagnosis.evidence import quick_pass

    case, _ = chosen_job(options, may_be_new=True)
    diagnosis = case.diagnose()
    plan = quick_pass(diagnosis)
    if plan is None:
        raise InputError(Sentence("no further land is worth a reading: it would hardly change what is decided"))
    return write_template(diagnosis.controller, plan=plan, **known)


def _add_card(commands: Any, name: str) -> None:
    given, more = ("READINGS", "sheet.xlsx") if name == "gauge-card" else ("--vacuum FILE", "--vacuum stand.csv")
    examples = (
        f"{name} --controller five_speed_2005 -o card.pdf",
        f"{name} {more} --controller five_speed_2005 --job job.toml --units us --paper letter -o card.pdf",
    )
    usage = f"atleak {name} [{given}] [--controller ID|FILE] [options] -o FILE.pdf"
    parser = add_command(commands, name, _card, examples=examples, usage=usage)
    parser.set_defaults(card=name)
    add_job_options(parser)
    written = parser.add_argument_group("what is written, and how it is printed")
    written.add_argument("-o", "--output", metavar="FILE.pdf", required=True, help="the card")
    add_print(written)
    add_force(written)


def _card(options: argparse.Namespace) -> int:
    """Write what gauges should show on the unit new and as measured, or what a vacuum stand should show of it."""
    outputs = Outputs(options, input_files(options), "PDF")
    case, job = chosen_job(options, may_be_new=True)
    printed, font = print_options(options, ["pdf"]), print_font(options, ["pdf"])
    from atleak.report.pdf.gauge_card import write_gauge_card, write_vacuum_card

    write = write_gauge_card if options.card == "gauge-card" else write_vacuum_card
    outputs.write(output=lambda: write(case.diagnose(), job, **printed, font=font))
    outputs.say_written()
    return 0


def _fields(options: argparse.Namespace) -> dict[str, str]:
    """Return what the head says: the record, and in its place what the options say."""
    if not any(getattr(options, name.replace("-", "_")) is not None for name in ("job", "mileage", *_TEXTS)):
        return {}
    job = Job() if options.job is None else load_job(options.job)
    if options.mileage is not None:
        job = job.model_copy(update={"vehicle": job.vehicle.model_copy(update={"mileage_km": options.mileage})})
    told = {
        head.JOB: options.number,
        head.VEHICLE: options.vehicle,
        head.VIN: options.vin,
        head.SERIAL: options.serial,
        head.MEASURED_BY: options.measured_by,
    }
    return head.fields_of(job, options.units) | {
        label: clean_text(text).strip() for label, text in told.items() if text is not None
    }
