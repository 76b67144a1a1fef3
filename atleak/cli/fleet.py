"""Diagnose thousands of units at once, and sum up what their results say: ``atleak fleet run|summary``."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from atleak.cli.job_options import add_choices, chosen_case
from atleak.cli.parser import add_command, add_group
from atleak.cli.shared import Outputs, add_force, add_json, add_print, number_argument, print_font, print_options
from atleak.common.errors import InputError, Message, OutputError
from atleak.common.sentences import Sentence
from atleak.common.verdicts import FLAGGED, Verdict

if TYPE_CHECKING:
    import pyarrow as pa

    from atleak.fleet.results import Results
    from atleak.fleet.run import Finished, Progress
    from atleak.fleet.sources import FoundUnits


def add_summary(group: Any) -> None:
    """Add the command to those about fleets."""
    parser = add_command(
        group,
        "summary",
        run,
        "what the results of a fleet say together: verdicts, wear over mileage, the worst lands, temperatures, groups",
        usage="atleak fleet summary RESULTS [--by HEADING] [--pdf FILE] [--xlsx FILE] [--json FILE|-] [options]",
        examples=(
            "fleet summary results",
            "fleet summary results --by supplier --pdf fleet.pdf --xlsx fleet.xlsx",
            "fleet summary results --controller four_speed_2023 --json -",
        ),
    )
    parser.add_argument("results", metavar="RESULTS", help="the folder that `atleak fleet run` was given with --out")
    parser.add_argument(
        "--by", metavar="HEADING", help="compare the groups of units by a column of their table, or by `group`"
    )
    parser.add_argument("--controller", metavar="ID", help="the units of this valve body alone")
    parser.add_argument("--list", metavar="N", type=_units_count, help="list so many of the worst units")
    parser.add_argument("--errors", action="store_true", help="list instead every unit without a result, and why")
    parser.add_argument("--pdf", metavar="FILE.pdf", help="the summary on a few pages, with charts")
    parser.add_argument("--xlsx", metavar="FILE.xlsx", help="everything of the summary as a workbook, with charts")
    parser.add_argument(
        "--job",
        metavar="RECORD",
        help="a job record (.toml or .json) whose workshop, with its logo, stands at the head of the PDF",
    )
    add_print(parser, shown=["units"])
    add_json(parser)
    add_force(parser)


def _units_count(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is no number of units")
    return int(text)


def run(options: argparse.Namespace) -> int:
    """Sum up, write what was asked for, and show the summary."""
    from atleak.common.wording import wording
    from atleak.fleet.folder import note
    from atleak.fleet.results import Results
    from atleak.fleet.summary import summed_up
    from atleak.fleet.summary_sections import TERMINAL, FleetSections
    from atleak.fleet.summary_words import FleetWords
    from atleak.fleet.sums import LISTED, summary_record
    from atleak.job.zip_file import load_job
    from atleak.report.terminal import print_sections

    outputs = Outputs(options, [options.job])
    printed = print_options(options, outputs.formats, shown=["units"] if outputs.shown else ())
    font = print_font(options, outputs.formats)
    letterhead = None if options.job is None else load_job(options.job)
    results = Results.open(options.results)
    if options.errors and not outputs.files:
        _list_errors(results)
        return 0
    listed = LISTED if options.list is None else options.list
    summary = summed_up(results, by=options.by, controller=options.controller, listed=listed)
    with suppress(OutputError):  # where the user's folder cannot be written, a page does not offer them
        note(options.results)

    def workbook() -> bytes:
        from atleak.fleet.summary_workbook import write_summary_workbook

        return write_summary_workbook(summary, **printed)

    def pdf() -> bytes:
        from atleak.fleet.summary_pdf import write_summary_pdf

        return write_summary_pdf(summary, **printed, font=font, letterhead=letterhead)

    outputs.write(xlsx=workbook, pdf=pdf, json=lambda: summary_record(summary))
    if outputs.shown:
        if options.errors:
            _list_errors(results)
        else:
            sections = FleetSections(FleetWords(summary, wording("en", printed["units"])), TERMINAL)
            print_sections([sections.head(), *sections.all()])
            if summary.by is None and summary.headings:
                headings = ", ".join(summary.headings)
                print(f"Groups of units can be compared by {headings}: --by {summary.headings[0]}")
    outputs.say_written()
    return 0


def _list_errors(results: Results) -> None:
    from atleak.fleet.sums import named_message

    for row in results.table("errors", columns=["name", "kind", "message"]).to_pylist():
        print(f"{named_message(row['name'], row['message'])} ({row['kind']})")


_TWICE = 5  # names that are printed of units that are there twice
_ERRORS = 30  # messages that are printed of each kind of error


def add_parser(commands: Any, name: str) -> None:
    """Add the commands."""
    group = add_group(
        commands,
        name,
        examples=(
            "fleet run jobs/ --out results",
            "fleet run fleet.csv --controller four_speed_2023 --out results --fail-on replace",
            "fleet summary results --by supplier",
        ),
    )
    _add_run(group)
    add_summary(group)


def _add_run(group: Any) -> None:
    parser = add_command(
        group,
        "run",
        _run,
        "diagnose every unit that has no result yet, and keep the results as Parquet",
        usage="atleak fleet run [JOBS ...] --out FOLDER [--workers N | --scheduler ADDRESS] [options]",
        examples=(
            "fleet run jobs/ --out results",
            "fleet run 'stand_*/**/*.zip' --out results --workers 4",
            "fleet run fleet.csv --controller my_unit.toml --map main_pressure=PL --out results",
            "fleet run --book --text four_speed_2023 --out results --fail-on replace",
        ),
    )
    parser.add_argument(
        "jobs",
        metavar="JOBS",
        nargs="*",
        help="job files, folders of them (the name of a sub-folder is the group of its units), tables of units with "
        "the paths of sheets and logs (csv, xlsx or Parquet), patterns of any of these",
    )
    parser.add_argument("--book", action="store_true", help="also the jobs of the job book")
    parser.add_argument(
        "--text", metavar="WORDS", help="of the job book those alone that `atleak jobs list --text` shows"
    )
    parser.add_argument("-o", "--out", metavar="FOLDER", required=True, help="where the results are kept")
    _add_running(parser.add_argument_group("how it is run"))
    parser.add_argument(
        "--fail-on",
        choices=[level.value for level in FLAGGED],
        help="end with status 1 where a unit of the results, those of earlier runs too, is at or past this level; "
        "with status 2 all the same where a unit given has no result",
    )
    add_choices(parser)


def _add_running(group: Any) -> None:
    where = group.add_mutually_exclusive_group()
    where.add_argument("--workers", metavar="N", type=_count, help="processes: as many as processors unless given")
    where.add_argument("--scheduler", metavar="ADDRESS", help="of a dask scheduler that is up: tcp://10.0.0.5:8786")
    group.add_argument(
        "--time-limit", metavar="S", type=_seconds, help="for one unit [s]: 1800 unless given, 0 for none"
    )
    group.add_argument("--retry-errors", action="store_true", help="try units again that ended in an error before")
    group.add_argument("--replace", action="store_true", help="begin anew: what the folder holds of earlier runs goes")


def _count(text: str) -> int:
    if not text.isdecimal() or not 0 < int(text) <= 10_000:
        raise argparse.ArgumentTypeError(f"{text!r} is no number of processes")
    return int(text)


def _seconds(text: str) -> float:
    seconds = number_argument(text)
    if seconds < 0.0:
        raise argparse.ArgumentTypeError(f"{text!r} is no time: write seconds, or 0 for no limit")
    return seconds


# --- what the command does


def _run(options: argparse.Namespace) -> int:
    from atleak.fleet.cluster import connected
    from atleak.fleet.folder import note
    from atleak.fleet.results import Results
    from atleak.fleet.run import TIME_LIMIT, run_fleet

    found = _found(options)
    limit = TIME_LIMIT if options.time_limit is None else options.time_limit or None
    with (
        Results.reserved(options.out, replace=options.replace) as results,
        connected(options.scheduler, options.workers, tell=_say) as client,
    ):
        results.begin(replace=options.replace)
        with suppress(OutputError):  # where the user's folder cannot be written, a page does not offer them
            note(options.out)
        try:
            with _shown(quiet=getattr(options, "quiet", False)) as progress:
                retry = options.retry_errors
                finished = run_fleet(
                    found, results, client, time_limit=limit, retry_errors=retry, progress=progress, tell=_say
                )
        except KeyboardInterrupt:
            print("atleak: interrupted; what was finished is kept, and running again goes on from it", file=sys.stderr)
            raise
        _say_twice(found)
        return _print_finished(results, found, finished, options)


def _found(options: argparse.Namespace) -> FoundUnits:
    """Return the units that the command line names; what was left out, or does nothing, is told."""
    from atleak.fleet.sources import find_units
    from atleak.job_book.search import Query

    if not options.jobs and not options.book:
        expected = Sentence("job files, folders, tables of units, or --book")
        raise InputError(Sentence("no job is given"), expected=expected)
    defaults = chosen_case(options)
    found = find_units(options.jobs, defaults=defaults, book=Query(text=options.text or "") if options.book else None)
    if options.text and not options.book:
        print("atleak: --text does nothing without --book", file=sys.stderr)
    if not found.has_tables and defaults != type(defaults)():
        print("atleak: choices for units do nothing without a table of units: a job has its own", file=sys.stderr)
    quiet = getattr(options, "quiet", False)
    for message in found.messages:
        if message.level == "warning" or not quiet:
            _say(message)
    return found


def _say(message: Message) -> None:
    place = message.place.sentence if message.place is not None else ""
    print(f"atleak: {place}: {message.text}" if place else f"atleak: {message.text}", file=sys.stderr)


def _say_twice(found: FoundUnits) -> None:
    """Tell of which units the same content was found before: they are evaluated once."""
    for name, first in found.twice[:_TWICE]:
        print(f"atleak: {name}: the same as {first}, which is evaluated once", file=sys.stderr)
    if len(found.twice) > _TWICE:
        print(f"atleak: … and {len(found.twice) - _TWICE} more that are there twice", file=sys.stderr)


@contextmanager
def _shown(*, quiet: bool) -> Iterator[Callable[[Progress], None]]:
    """Show a bar with the rate and the time that is left, on standard error."""
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    from atleak.report.terminal import TerminalConsole

    columns = ("units", BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[rate]}"), TimeElapsedColumn())
    console = TerminalConsole(sys.stderr)
    with Bar(*columns, console=console, transient=True, disable=quiet or not console.is_terminal) as bar:
        task = bar.add_task("", total=None, rate="")

        def show(progress: Progress) -> None:
            done = progress.before + progress.done
            bar.update(task, total=progress.of, completed=done, rate=_rate(progress))

        yield show


def _rate(progress: Progress) -> str:
    """Return in words how fast a run goes, how long it still takes, and how many errors there are."""
    parts = [f"{progress.per_second:.3g}/s"] if progress.done else []
    if progress.seconds_left is not None:
        minutes, seconds = divmod(round(progress.seconds_left), 60)
        hours, minutes = divmod(minutes, 60)
        parts.append(f"{hours}:{minutes:02}:{seconds:02} left")
    if progress.errors:
        parts.append(f"{progress.errors} error{'' if progress.errors == 1 else 's'}")
    return " · ".join(parts)


def _print_finished(results: Results, found: FoundUnits, finished: Finished, options: argparse.Namespace) -> int:
    """Print what the results hold now, and return the exit status."""
    from atleak.common.wording import signed

    units = results.table("units", columns=["input_sha256", "verdict"])
    counts = _counts(units, "verdict")
    new = sum(finished.errors.values()) + finished.evaluated
    print(f"{_units(new)} tried in {finished.seconds:.0f} s; {sum(counts.values())} with a result in {options.out}:")
    for level in sorted(map(Verdict, counts), key=lambda each: each.rank, reverse=True):
        print(f"  {counts[level.value]:6}  {signed(level)}")
    others = sum(sha256 not in found.seen for sha256 in units["input_sha256"].to_pylist())
    if others:
        print(f"{_units(others)} of these {'was' if others == 1 else 'were'} not given this time")
    if _say_errors(results, found):
        return 2
    past = options.fail_on and any(Verdict(each).rank >= Verdict(options.fail_on).rank for each in counts)
    return 1 if past else 0


def _units(count: int) -> str:
    return f"{count} unit" if count == 1 else f"{count} units"


def _counts(table: pa.Table, column: str) -> dict[str, int]:
    return {each["values"]: each["counts"] for each in table[column].value_counts().to_pylist()}


def _say_errors(results: Results, found: FoundUnits) -> bool:
    """Print which of the units have no result, by kind, with the first messages; return whether there are any."""
    from atleak.fleet.sums import named_message

    errors = results.table("errors", columns=["input_sha256", "kind", "name", "message"])
    rows = errors.to_pylist()
    of_these = [row for row in rows if row["input_sha256"] in found.seen]
    for kind, count in sorted(Counter(row["kind"] for row in of_these).items()):
        print(f"atleak: {count} without a result ({kind}):", file=sys.stderr)
        for row in [row for row in of_these if row["kind"] == kind][:_ERRORS]:
            print(f"  {named_message(row['name'], row['message'])}", file=sys.stderr)
        if count > _ERRORS:
            print(
                f"  … and {count - _ERRORS} more: `atleak fleet summary --errors {results.folder}` lists all",
                file=sys.stderr,
            )
    if rows:
        others = len(rows) - len(of_these)
        more = f", {others} of units that were not given this time" if others else ""
        folder = results.folder / "errors"
        print(f"atleak: every error stands in {folder}{more}; --retry-errors tries them again", file=sys.stderr)
    return bool(of_these)
