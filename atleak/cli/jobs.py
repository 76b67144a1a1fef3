"""Work with the job book, and keep it; put two jobs of one unit side by side, before and after: ``atleak compare``.

``atleak jobs add|list|show|open|…|export|import|merge|part|duplicates|erase|backup|restore|verify``.
"""

from __future__ import annotations

import argparse
import datetime as dt
import sys
from pathlib import Path
from typing import Any

from atleak.cli.app import PORT, open_page, port_number
from atleak.cli.job_options import add_job_options, chosen_job, save_job
from atleak.cli.parser import add_command, add_group
from atleak.cli.shared import (
    SHOWN,
    Outputs,
    add_force,
    add_job_id,
    add_json,
    add_print,
    add_units,
    check_targets,
    named_job_files,
    print_font,
    print_options,
    say_differences,
    say_doubts,
    say_written,
)
from atleak.common.errors import AtleakError, InputError, Place
from atleak.common.files import made_folder, replace_file
from atleak.common.printable import asked_for
from atleak.common.seals import SealedKind
from atleak.common.sentences import Sentence
from atleak.common.verdicts import Verdict
from atleak.common.wording import signed, wording
from atleak.job.result import judged_otherwise, result_record
from atleak.job_book.book import Book, JobRow, open_book
from atleak.job_book.compared_jobs import compare_jobs, compared_record, job_of, named_job
from atleak.job_book.search import Query
from atleak.readers.dates import sure_date
from atleak.report.terminal import print_diagnosis, print_records
from atleak.version import __version__

_LIMIT = 200  # rows of a list
_MOST = 1_000_000  # rows that may be asked for
_ID = 8  # characters of an id in it


def _add_compare(commands: Any, name: str) -> None:
    """Add the command, among all commands or among those of the job book."""
    examples = ("compare before.zip after.zip --pdf page.pdf", "compare 2026-0417 2026-0533")
    parser = add_command(commands, name, _compare, examples=examples)
    help = "the earlier job: a job file (zip), or its id or number in the job book"
    parser.add_argument("before", metavar="A", help=help)
    parser.add_argument("after", metavar="B", help="the later job, likewise")
    add_json(parser)
    parser.add_argument("--pdf", metavar="FILE.pdf", help="a page for the customer")
    add_print(parser, shown=SHOWN)
    add_force(parser)


def _compare(options: argparse.Namespace) -> int:
    """Compare the jobs, write what was asked for and show it."""
    outputs = Outputs(options, [name for name in (options.before, options.after) if Path(name).is_file()])
    printed = print_options(options, outputs.formats, shown=SHOWN if outputs.shown else ())
    font = print_font(options, outputs.formats)
    compared = compare_jobs(job_of(options.before), job_of(options.after))

    def pdf() -> bytes:
        from atleak.report.pdf import missing_characters
        from atleak.report.pdf.comparison import write_comparison_pdf

        before, after = compared.before.job, compared.after.job
        say_doubts(missing_characters([before, after], font))
        return write_comparison_pdf(compared.comparison, before, after, **printed, font=font)

    outputs.write(pdf=pdf, json=lambda: compared_record(compared))
    if outputs.shown:
        from atleak.report.tables.comparison import comparison_sections
        from atleak.report.terminal import print_sections

        comparison, say = compared.comparison, wording(printed["language"], printed["units"])
        print_sections(comparison_sections(comparison, say, brief=True), comparison.messages, say)
    outputs.say_written()
    return 0


def add_upkeep(group: Any) -> None:
    """Add the commands."""
    export = add_command(group, "export", _export, "jobs as job files, with tables for other programs")
    add_job_id(export, "*")
    export.add_argument("--all", action="store_true", help="every job of the book, archived ones too")
    export.add_argument("-o", "--output", metavar="FOLDER", required=True, help="where they go")
    add_force(export)
    taken = add_command(group, "import", _import, "take job files into the book; a job that is there is recognised")
    taken.add_argument("files", metavar="FILE|FOLDER", nargs="+", help="job files, or folders of them")
    merge = add_command(group, "merge", _merge, "make two units one, as after a slip in typing a VIN; part undoes it")
    merge.add_argument("unit", metavar="UNIT", type=int, help="number of the unit that stays, as list --json names it")
    merge.add_argument("other", metavar="UNIT", type=int, help="number of the one that leads to it")
    part = add_command(group, "part", _part, "undo a merge")
    part.add_argument("unit", metavar="UNIT", type=int, help="number of the unit that was merged into another one")
    add_command(group, "duplicates", _duplicates, "which units may be one")
    erase = add_command(group, "erase", _erase, "remove a customer's personal data from the book for good", quiet=False)
    add_job_id(erase, "*")
    erase.add_argument("--customer", metavar="NAME|NUMBER", help="every job of this customer")
    erase.add_argument("--delete", action="store_true", help="delete jobs whole that this version cannot open or judge")
    erase.add_argument("--yes", action="store_true", help="do not ask")
    backup = add_command(group, "backup", _backup, "a copy of the whole book, also while it is in use")
    backup.add_argument("file", metavar="FILE", help="the copy")
    add_force(backup)
    restore = add_command(group, "restore", _restore, "bring a backup back")
    restore.add_argument("file", metavar="FILE", help="as backup wrote it")
    restore.add_argument("--force", action="store_true", help="in the place of a book that holds jobs")
    restore.add_argument("--damaged", action="store_true", help="take what is left of damaged jobs of the backup too")
    add_command(group, "verify", _verify, "whether every job opens and its stored result is whole")


# --- out and in


def _export(options: argparse.Namespace) -> int:
    from atleak.job_book.exchange import export_paths, exported

    book, folder = open_book(), Path(options.output)
    ids = _ids(book, options)
    targets: list[tuple[SealedKind, str]] = [
        ("job file" if path.suffix == ".zip" else "table", str(folder / path))
        for path in export_paths(book, ids).values()
    ]
    check_targets(options, [], targets)
    made_folder(folder / "tables")
    for path, content in exported(book, ids):
        replace_file(folder / path, content)
    print(f"written: {len(ids)} job{'s' * (len(ids) != 1)} and their tables in {folder}")
    return 0


def _ids(book: Book, options: argparse.Namespace) -> list[str]:
    """Return the jobs that an export is asked for."""
    if options.all == bool(options.jobs):
        raise InputError(Sentence("it is not said which jobs"), expected=Sentence("their ids, or --all"))
    if not options.all:
        return list(dict.fromkeys(named_job(book, name) for name in options.jobs))
    return [row.id for row in book.rows(Query(archived=None, limit=None))]


def _import(options: argparse.Namespace) -> int:
    from atleak.job_book.exchange import import_job

    book, failed = open_book(), 0
    for path in named_job_files(options.files):
        try:
            taken = import_job(book, path)
        except AtleakError as error:  # one file that cannot be used does not stop the others
            print(f"atleak: {error}", file=sys.stderr)
            failed += 1
            continue
        words = "is in the book already" if taken.known else "taken in"
        print(f"{path.name}: {words}: {taken.id}, {taken.verdict}")
        say_differences(path.name, taken.result_by, taken.differs)
    return 2 if failed else 0


# --- units


def _merge(options: argparse.Namespace) -> int:
    from atleak.job_book.merges import merge

    moved = merge(open_book(), options.unit, options.other)
    print(f"units {options.unit} and {options.other} are one now; `atleak jobs part {moved}` undoes it")
    return 0


def _part(options: argparse.Namespace) -> int:
    from atleak.job_book.merges import part

    part(open_book(), options.unit)
    print(f"unit {options.unit} stands by itself again")
    return 0


def _duplicates(options: argparse.Namespace) -> int:
    from atleak.job_book.merges import duplicates

    pairs = duplicates(open_book())
    for pair in pairs:
        both = f"{pair.one.in_words} | {pair.other.in_words}"
        print(f"atleak jobs merge {pair.one.id} {pair.other.id}   # {pair.why}: {both}")
    if not pairs:
        print("No two units of the job book look like one.")
    return 0


# --- erasing


def _erase(options: argparse.Namespace) -> int:
    from atleak.job_book.erasure import erase, jobs_of_customer, same_vehicle

    if (options.customer is None) == (not options.jobs):
        expected = Sentence("--customer NAME|NUMBER, or ids of jobs")
        raise InputError(Sentence("it is not said which jobs"), expected=expected)
    book = open_book()
    if options.customer is None:
        ids = [named_job(book, name) for name in options.jobs]
    else:
        ids = [row.id for row in jobs_of_customer(book, options.customer)]
        if not ids:
            problem = Sentence("no job is of this customer")
            expected = Sentence("the whole name or number, as `atleak jobs list` shows it")
            raise InputError(problem, place=Place(file=book.name), value=options.customer, expected=expected)
    rows = [row for row in book.rows(Query(archived=None, limit=None)) if row.id in ids]
    for row in rows:
        print(f"{row.id}  {row.in_words}")
    print(wording("en")("job_book.what_goes"))
    for row in same_vehicle(book, ids):
        print(f"Not erased, of the same vehicle or transmission: {row.id}  {row.in_words}")
    if not options.yes and not _agreed(len(rows)):
        return 2
    for done in erase(book, ids, delete=options.delete):
        if done.deleted:
            print(f"deleted as a whole: {done.id}")
            continue
        gone = f"; gone with it, the stored result stays: {', '.join(done.lost)}" if done.lost else ""
        print(f"erased: {done.id}{gone}")
        for name in done.left_in:
            print(f"atleak: {done.id}: left as it is, and it names the customer: {name}", file=sys.stderr)
    return 0


def _agreed(count: int) -> bool:
    if not sys.stdin.isatty():
        raise InputError(Sentence("nothing was erased: nobody can be asked here"), expected=Sentence("--yes"))
    answer = input(f"Erase {count} job{'s' * (count != 1)}? Write yes: ")
    if answer.strip().lower() == "yes":
        return True
    print("nothing was erased")
    return False


# --- safety


def _backup(options: argparse.Namespace) -> int:
    from atleak.job_book.backup import backup

    path = Path(options.file)
    if path.exists() and not options.force:
        expected = Sentence("another name, or --force")
        raise InputError(Sentence("is there already"), place=Place(file=str(path)), expected=expected)
    count = backup(open_book(), path)
    say_written([f"{path}, {count} job{'s' * (count != 1)}"])
    return 0


def _restore(options: argparse.Namespace) -> int:
    from atleak.job_book.backup import restore

    book = open_book()
    before = book.count(Query(archived=None))
    count = restore(Path(options.file), book, force=options.force, damaged=options.damaged)
    instead = f", in the place of {before}" if before else ""
    print(f"restored: {count} job{'s' * (count != 1)}{instead}")
    return 0


def _verify(options: argparse.Namespace) -> int:
    from atleak.job_book.backup import verify

    book = open_book()
    faults = verify(book)
    for fault in faults:
        print(f"atleak: {fault}", file=sys.stderr)
    if faults:
        return 2
    count = book.count(Query(archived=None))
    print(f"{count} job{'s' * (count != 1)}, every one whole")
    return 0


def add_parser(commands: Any, name: str) -> None:
    """Add the command, or those of the job book."""
    if name == "compare":
        _add_compare(commands, name)
        return
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
        usage="atleak jobs add [READINGS] [--road-test LOG] [--pressures FILE] [--vacuum FILE] [--flows FILE] …",
        examples=("jobs add sheet.xlsx --road-test log.csv --job job.toml",),
        quiet=False,
    )
    add_job_options(add)
    _add_list(group)
    example = "jobs show 2026-0417 --json job.json"
    show = add_command(group, "show", _show, "a job of the book, diagnosed anew", examples=[example])
    add_job_id(show)
    add_units(show)
    add_json(show)
    add_force(show)
    about = "a job of the book in the dashboard, which is started where it is not up"
    opened = add_command(group, "open", _open, about, quiet=False)
    add_job_id(opened)
    help = f"of the dashboard: {PORT} unless given"
    opened.add_argument("--port", metavar="N", type=port_number, default=PORT, help=help)
    add_parser(group, "compare")
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
    print(save_job(options, case, job, case.diagnose()), file=asked_for(sys.stdout))
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
    record = result_record(diagnosis, stored.file.job)
    if stored.archived_at is not None:
        print(f"atleak: this job was archived on {stored.archived_at.astimezone():%Y-%m-%d}", file=sys.stderr)
    otherwise = judged_otherwise(stored.file.result, record)
    if otherwise:
        print(f"atleak: judged otherwise than by atleak {stored.result_by}, which stored it:", file=sys.stderr)
        for each in otherwise:
            print(f"  {wording('en', options.units).sentence(each)}", file=sys.stderr)
    written_down = {**record["job"], **stored.file.job.record()}
    of_book = {"id": stored.id, "stored_verdict": stored.file.result.get("verdict")}
    outputs.write(json=lambda: {**record, "job": written_down, **of_book})
    if outputs.shown:
        print_diagnosis(diagnosis, options.units)
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
