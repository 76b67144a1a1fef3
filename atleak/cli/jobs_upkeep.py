"""Keep the job book: ``atleak jobs export|import|merge|part|duplicates|erase|backup|restore|verify``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from atleak.cli.parser import add_command
from atleak.cli.shared import add_force, add_job_id, check_targets, job_files, say_differences, say_written
from atleak.errors import AtleakError, InputError, Place
from atleak.jobs.book import Book, open_book
from atleak.jobs.named import named_job
from atleak.jobs.search import Query
from atleak.sentence import Sentence
from atleak.system.files import replace_file
from atleak.system.home import made
from atleak.system.marks import Kind
from atleak.wording import wording


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
    from atleak.jobs.exchange import export_paths, exported

    book, folder = open_book(), Path(options.output)
    ids = _ids(book, options)
    targets: list[tuple[Kind, str]] = [
        ("job file" if path.suffix == ".zip" else "table", str(folder / path))
        for path in export_paths(book, ids).values()
    ]
    check_targets(options, [], targets)
    made(folder / "tables")
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
    from atleak.jobs.exchange import import_job

    book, failed = open_book(), 0
    for path in job_files(options.files):
        try:
            taken = import_job(book, path)
        except AtleakError as error:  # one file that cannot be used does not stop the others
            print(f"atleak: {error}", file=sys.stderr)
            failed += 1
            continue
        said = "is in the book already" if taken.known else "taken in"
        print(f"{path.name}: {said}: {taken.id}, {taken.verdict}")
        say_differences(path.name, taken.result_by, taken.differs)
    return 2 if failed else 0


# --- units


def _merge(options: argparse.Namespace) -> int:
    from atleak.jobs.merge import merge

    moved = merge(open_book(), options.unit, options.other)
    print(f"units {options.unit} and {options.other} are one now; `atleak jobs part {moved}` undoes it")
    return 0


def _part(options: argparse.Namespace) -> int:
    from atleak.jobs.merge import part

    part(open_book(), options.unit)
    print(f"unit {options.unit} stands by itself again")
    return 0


def _duplicates(options: argparse.Namespace) -> int:
    from atleak.jobs.merge import duplicates

    pairs = duplicates(open_book())
    for pair in pairs:
        both = f"{pair.one.in_words} | {pair.other.in_words}"
        print(f"atleak jobs merge {pair.one.id} {pair.other.id}   # {pair.why}: {both}")
    if not pairs:
        print("No two units of the job book look like one.")
    return 0


# --- erasing


def _erase(options: argparse.Namespace) -> int:
    from atleak.jobs.erase import erase, jobs_of_customer, same_vehicle

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
    from atleak.jobs.backup import backup

    path = Path(options.file)
    if path.exists() and not options.force:
        expected = Sentence("another name, or --force")
        raise InputError(Sentence("is there already"), place=Place(file=str(path)), expected=expected)
    count = backup(open_book(), path)
    say_written([f"{path}, {count} job{'s' * (count != 1)}"])
    return 0


def _restore(options: argparse.Namespace) -> int:
    from atleak.jobs.backup import restore

    book = open_book()
    before = book.count(Query(archived=None))
    count = restore(Path(options.file), book, force=options.force, damaged=options.damaged)
    instead = f", in the place of {before}" if before else ""
    print(f"restored: {count} job{'s' * (count != 1)}{instead}")
    return 0


def _verify(options: argparse.Namespace) -> int:
    from atleak.jobs.backup import verify

    book = open_book()
    faults = verify(book)
    for fault in faults:
        print(f"atleak: {fault}", file=sys.stderr)
    if faults:
        return 2
    count = book.count(Query(archived=None))
    print(f"{count} job{'s' * (count != 1)}, every one whole")
    return 0
