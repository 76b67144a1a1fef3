"""Work with the job book: ``atleak jobs add|list|show|open|…``."""

from __future__ import annotations

import argparse
import datetime as dt
import sys
from typing import Any

from atleak.cli import compare
from atleak.cli.app import PORT, open_page, port_number
from atleak.cli.job_options import add_job_options, as_read, chosen_job
from atleak.cli.jobs_upkeep import add_upkeep
from atleak.cli.parser import add_command, add_group
from atleak.cli.shared import Outputs, add_force, add_job_id, add_json
from atleak.intake.dates import sure_date
from atleak.job.issued import issued_record
from atleak.job.judged_anew import judged_otherwise
from atleak.job.of_sheet import with_sheet
from atleak.job.parts import job_parts
from atleak.jobs.book import JobRow, open_book
from atleak.jobs.named import named_job
from atleak.jobs.search import Query
from atleak.report.terminal import print_diagnosis, print_records
from atleak.system.printable import asked_for
from atleak.verdicts import Verdict
from atleak.version import __version__
from atleak.wording import signed

_LIMIT = 200  # rows of a list
_MOST = 1_000_000  # rows that may be asked for
_ID = 8  # characters of an id in it


def add_parser(commands: Any, name: str) -> None:
    """Add the commands."""
    examples = (
        "jobs add sheet.xlsx --job job.toml",
        "jobs list --text WVW --verdict replace",
        "jobs show 2026-0417",
        "jobs export --all -o backup",
        "jobs erase --customer 10023",
    )
    group = add_group(commands, name, examples)
    add = add_command(
        group,
        "add",
        _add,
        "diagnose a job and put it into the book; prints its id",
        usage="atleak jobs add [READINGS] [--road-test LOG] [--pressures FILE] [options]",
        examples=("jobs add sheet.xlsx --road-test log.csv --job job.toml",),
        quiet=False,
    )
    add_job_options(add)
    _add_list(group)
    example = "jobs show 2026-0417 --json job.json"
    show = add_command(group, "show", _show, "a job of the book, diagnosed anew", examples=[example])
    add_job_id(show)
    add_json(show)
    add_force(show)
    about = "a job of the book in the dashboard, which is started where it is not up"
    opened = add_command(group, "open", _open, about, quiet=False)
    add_job_id(opened)
    help = f"of the dashboard: {PORT} unless given"
    opened.add_argument("--port", metavar="N", type=port_number, default=PORT, help=help)
    compare.add_parser(group, "compare")
    about = "take jobs out of lists and statistics; bring-back undoes it"
    add_job_id(add_command(group, "archive", _archive, about), "+")
    add_job_id(add_command(group, "bring-back", _archive, "put archived jobs back"), "+")
    add_upkeep(group)


def _add_list(group: Any) -> None:
    examples = ("jobs list --text WVW", "jobs list --from 2026-04-01 --verdict replace --json -")
    parser = add_command(group, "list", _list, "the jobs of the book, the last changed one first", examples=examples)
    parser.add_argument(
        "--text",
        default="",
        help="what a number, customer, VIN, plate or serial begins with, or a VIN or serial ends with",
    )
    for name in ("vin", "plate", "serial", "customer", "number"):
        parser.add_argument(f"--{name}", default="", help="likewise, of this alone")
    for name in ("from", "to"):
        parser.add_argument(f"--{name}", metavar="DATE", type=_date, help=f"{name} this date of the job on: 2026-04-17")
    parser.add_argument("--verdict", choices=[each.value for each in Verdict], default="", help="of the unit")
    parser.add_argument("--controller", metavar="ID", default="", help="of the valve body")
    parser.add_argument("--archived", action="store_true", help="the archived jobs in place of the others")
    parser.add_argument("--limit", metavar="N", type=_rows, default=_LIMIT, help=f"rows at most: {_LIMIT} unless given")
    add_json(parser)
    add_force(parser)


def _rows(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= _MOST:
        raise argparse.ArgumentTypeError(f"{text!r} is no number of rows: write a whole number from 1 to {_MOST}")
    return int(text)


def _date(text: str) -> dt.date:
    date = sure_date([text])
    if date is None:
        raise argparse.ArgumentTypeError(f"{text!r} is no date that can be read in one way: write it as 2026-04-17")
    return date


# --- what the commands do


def _add(options: argparse.Namespace) -> int:
    case, job = chosen_job(options)
    diagnosis = case.diagnose()
    parts = job_parts(diagnosis, with_sheet(job, diagnosis.readings), as_read(case))
    print(open_book().save(parts).id, file=asked_for(sys.stdout))
    return 0


def _list(options: argparse.Namespace) -> int:
    outputs = Outputs(options)
    names = ("text", "vin", "plate", "serial", "customer", "number", "to", "verdict", "controller", "archived", "limit")
    asked = {name: getattr(options, name) for name in names}
    query = Query(date_from=getattr(options, "from"), date_to=asked.pop("to"), **asked)
    book = open_book()
    rows = book.rows(query)
    outputs.write(json=lambda: [_record(row) for row in rows])
    if outputs.shown:
        _print_rows(rows, book.count(query))
    outputs.say_written()
    return 0


def _record(row: JobRow) -> dict[str, Any]:
    names = ("id", "number", "vin", "serial", "customer", "date", "controller", "verdict", "mileage_km", "plate")
    known = {name: getattr(row, name) for name in (*names, "unit", "visit", "changed_at", "archived_at", "sample")}
    plain = {name: value.isoformat() if isinstance(value, dt.date) else value for name, value in known.items()}
    return {**plain, "atleak": __version__}


def _print_rows(rows: list[JobRow], count: int) -> None:
    if not rows:
        print("No job of the job book fits.")
        return
    shown = [
        {
            **_record(row),
            "id": row.id[:_ID],  # names the job as the whole id does
            "verdict": signed(Verdict(row.verdict)),
            "vehicle": row.vin or row.plate or row.serial,
        }
        for row in rows
    ]
    print_records(["id", "date", "number", "customer", "vehicle", "unit", "verdict"], shown, whole=["date", "unit"])
    if count > len(rows):
        print(f"{len(rows)} of {count} jobs; --limit shows more, --text and the others look one up")


def _show(options: argparse.Namespace) -> int:
    outputs, book = Outputs(options), open_book()
    stored = book.load(named_job(book, options.job))
    diagnosis = stored.file.diagnose()
    record = issued_record(diagnosis, stored.file.job)
    if stored.archived_at is not None:
        print(f"atleak: this job was archived on {stored.archived_at.astimezone():%Y-%m-%d}", file=sys.stderr)
    otherwise = judged_otherwise(stored.file.result, record)
    if otherwise:
        print(f"atleak: judged otherwise than by atleak {stored.result_by}, which stored it:", file=sys.stderr)
        for each in otherwise:
            print(f"  {each}", file=sys.stderr)
    written_down = {**record["job"], **stored.file.job.record()}
    said = {"id": stored.id, "stored_verdict": stored.file.result.get("verdict")}
    outputs.write(json=lambda: {**record, "job": written_down, **said})
    if outputs.shown:
        print_diagnosis(diagnosis)
    outputs.say_written()
    return 0


def _open(options: argparse.Namespace) -> int:
    return open_page(options.port, {"job": named_job(open_book(), options.job)})


def _archive(options: argparse.Namespace) -> int:
    book, back = open_book(), options.action == "bring-back"
    for id in [named_job(book, name) for name in options.jobs]:  # one that is not there stops before the first
        book.archive(id, back=back)
        print(f"{'brought back' if back else 'archived'}: {id}")
    return 0
