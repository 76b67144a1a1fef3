"""Follow a log that a logger is still writing: ``atleak watch``."""

from __future__ import annotations

import argparse
import shutil
import sys
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from atleak.cli.job_options import add_job_options, chosen_job, save_job
from atleak.cli.parser import add_command
from atleak.cli.shared import add_units, number_argument
from atleak.common.errors import AtleakError
from atleak.common.printable import printable, unguarded
from atleak.common.wording import Wording, wording
from atleak.job.case import Case
from atleak.job.watched_log import WatchedLog
from atleak.measurements.job_card import Job
from atleak.report.tables.road_test import present_values
from atleak.report.tables.road_words import event_remark, event_span
from atleak.report.terminal import print_diagnosis

_EVERY = 1.0  # [s]


def add_parser(commands: Any, name: str) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        name,
        run,
        usage="atleak watch LOG [READINGS] [--controller ID|FILE] [--keep] …",
        examples=(
            "watch torqueLogs/trackLog.csv --controller five_speed_2005",
            "watch torqueLogs --controller five_speed_2005 --keep --job job.toml",
        ),
    )
    add_job_options(parser, grows=True)
    shown = parser.add_argument_group("how it is shown and ended: Ctrl-C ends it, and prints the summary")
    add_units(shown)
    help = "put the job into the job book when it ends, and when the log begins anew"
    shown.add_argument("--keep", action="store_true", help=help)
    help = "end by itself once the log has had no new line for so many seconds; 0 reads it once"
    shown.add_argument("--end-after", metavar="S", type=number_argument, help=help)


def run(options: argparse.Namespace) -> int:
    """Follow the log until somebody ends it; print the summary of what was read, and keep the job if asked."""
    if options.forget and Path(options.road_test).is_dir():
        options.refuse("--forget needs the log itself, not its folder: its headings say what is forgotten")
    case, job = chosen_job(options)
    log, screen = WatchedLog(Path(options.road_test), case), _Screen(wording("en", options.units))
    status = 0
    with suppress(KeyboardInterrupt):
        while True:
            try:
                log.look()
            finally:
                for file in log.earlier:
                    screen.line(f"{file.name} ended, a log begins anew")
                    status |= _end(options, replace(case, road_test=file), job)
                log.earlier.clear()
            screen.show(log)
            if options.end_after is not None and log.quiet >= options.end_after:
                break
            time.sleep(_EVERY)
    screen.show(log, ended=True)
    if log.waits is not None and log.findings is None:
        raise log.waits
    if log.file is not None:
        status |= _end(options, replace(case, road_test=log.file), job)
    return status


def _end(options: argparse.Namespace, case: Case, job: Job | None) -> int:
    """Print the summary of a log that has ended, and keep the job if asked; say why where it cannot be: 2, else 0."""
    try:
        diagnosis = case.diagnose()
        print_diagnosis(diagnosis, options.units)
        if options.keep:
            print(f"kept in the job book: {save_job(options, case, job, diagnosis)}")
    except AtleakError as error:
        print(f"atleak: {error}", file=sys.stderr)
        return 2
    return 0


class _Screen:
    """A line for every event, and one of present values: written anew in its place where a terminal shows it."""

    def __init__(self, say: Wording) -> None:
        self.say, self.stands = say, ""
        self.in_place = sys.stdout.isatty()

    def show(self, log: WatchedLog, *, ended: bool = False) -> None:
        """Show what is new in a log, and its present values."""
        happened = list(log.news(ended=ended))
        for event in happened:
            self.line(": ".join(filter(None, (event_span(event, self.say), event_remark(event, self.say)))))
        waits = "" if log.waits is None else f"waiting: {log.waits}"
        now = []
        if log.findings is not None:
            facts = present_values(log.findings, log.controller, self.say).rows
            now = [f"{name} {value}" for name, value in facts]
        if log.file is not None and log.quiet >= 2 * _EVERY:
            now.append(f"last line {log.quiet:.0f} s ago")
        if self.in_place and not ended:
            self._write_over(" · ".join(filter(None, (waits, *now))))
        elif happened or (waits and waits != self.stands):
            self.line(" · ".join(filter(None, (waits, *now))))
        self.stands = waits

    def line(self, text: str) -> None:
        """Print a line that stays."""
        if self.in_place:
            self._write_over("")
            unguarded(sys.stdout).write("\r")
        print(text, flush=True)

    def _write_over(self, text: str) -> None:
        stream, room = unguarded(sys.stdout), shutil.get_terminal_size().columns - 1
        stream.write(f"\r{printable(text)[:room].ljust(room)}")
        stream.flush()
