"""Run the command line: files in, a verdict, JSON, a workbook out.

Exit status: 0 done, 1 only with ``--fail-on`` and a pair or a total at or past it, 2 bad input or usage.
Every module adds the parsers of its commands and runs them; what costs time is imported when a command runs.
"""

from __future__ import annotations

import argparse
import errno
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager

from atleak.cli import (
    app,
    catalogue,
    compare,
    controller,
    diagnose,
    fleet,
    gauge_study,
    import_log,
    jobs,
    report,
    sample,
    schema,
    template,
    variants,
)
from atleak.cli.parser import Parser, add_shown, groups_of, parsed
from atleak.errors import AtleakError
from atleak.system.printable import only_what_is_asked_for, printable_streams
from atleak.version import __version__

_BROKEN_PIPE = 141  # the status by which a shell reports a program whose reader went away
_INTERRUPTED = 130
_NO_COLOUR = "NO_COLOR"  # the variable by which programs agree to print without colours
_MORE = """\
examples:
  atleak diagnose sample
  atleak diagnose sheet.xlsx --pdf report.pdf
  atleak diagnose sheet.xlsx --road-test log.csv --json - --fail-on replace
  atleak import-log log.csv
  atleak template -o sheet.xlsx
  atleak app

atleak COMMAND --help says more of each command. Exit status: 0 done, 1 only with
--fail-on and a pair or a total at or past it, 2 bad input or usage."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    with printable_streams():
        return _run(arguments)


def _run(arguments: Sequence[str] | None) -> int:
    try:
        options = parsed(_parser(), arguments)
        with _as_shown(options):
            status: int = options.run(options)
        sys.stdout.flush()  # a reader that went away is noticed here, not when the interpreter ends
        return status
    except SystemExit:  # argparse has printed its message already
        raise
    except AtleakError as error:
        print(f"atleak: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        on_windows = sys.platform == "win32" and error.errno == errno.EINVAL and error.filename is None
        if not isinstance(error, BrokenPipeError) and not on_windows:
            print(f"atleak: {error.filename or 'a file'}: {error.strerror or error}", file=sys.stderr)
            return 2
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _BROKEN_PIPE
    except KeyboardInterrupt:
        return _INTERRUPTED
    except BaseException as error:  # a panic of a library in Rust is no Exception; nobody is helped by a traceback
        if os.environ.get("ATLEAK_TRACEBACK"):
            raise
        print(f"atleak: unexpected {type(error).__name__}: {error}", file=sys.stderr)
        print("This is a fault of atleak. ATLEAK_TRACEBACK=1 in the environment shows where.", file=sys.stderr)
        return 2


@contextmanager
def _as_shown(options: argparse.Namespace) -> Iterator[None]:
    """Print as the options of every command ask for."""
    earlier = os.environ.get(_NO_COLOUR)
    with ExitStack() as stack:
        if getattr(options, "quiet", False):
            stack.enter_context(only_what_is_asked_for())
        if getattr(options, "no_color", False):
            os.environ[_NO_COLOUR] = "1"
        try:
            yield
        finally:
            if earlier is None:
                os.environ.pop(_NO_COLOUR, None)
            else:
                os.environ[_NO_COLOUR] = earlier


def _parser() -> Parser:
    parser = Parser(
        prog="atleak",
        description="Internal leakage of automatic-transmission valve bodies.",
        epilog=_MORE,
    )
    parser.add_argument("--version", action="version", version=f"atleak {__version__}", help="print it and end")
    add_shown(parser)
    commands = groups_of(parser, "COMMAND")
    for group in (
        diagnose,
        jobs,
        fleet,
        compare,
        variants,
        import_log,
        report,
        template,
        controller,
        gauge_study,
        catalogue,
        schema,
        sample,
        app,
    ):  # as --help lists them
        group.add_parser(commands)
    return parser
