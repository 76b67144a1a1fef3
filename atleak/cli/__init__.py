"""Run the command line: files in, a verdict, JSON, a workbook out.

Exit status: 0 done, 1 only with ``--fail-on`` and a pair or a total at or past it, 2 bad input or usage.
Every module adds the parsers of its commands and runs them; what costs time is imported when a command runs.
"""

from __future__ import annotations

import argparse
import errno
import os
import sys
from collections.abc import Sequence

from atleak.cli import (
    app,
    catalogue,
    compare,
    controller,
    diagnose,
    gauge_study,
    import_log,
    jobs,
    report,
    template,
    variants,
)
from atleak.cli.shared import without_colours
from atleak.errors import AtleakError
from atleak.system.printable import printable_streams
from atleak.version import __version__

_BROKEN_PIPE = 141  # the status by which a shell reports a program whose reader went away
_INTERRUPTED = 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    with printable_streams():
        return _run(arguments)


def _run(arguments: Sequence[str] | None) -> int:
    try:
        options = _parser().parse_args(arguments)
        status: int = options.run(options)
        sys.stdout.flush()  # a reader that went away is noticed here, not when the interpreter ends
        return status
    except SystemExit:  # argparse has printed its message already
        raise
    except AtleakError as error:
        print(f"atleak: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        if not isinstance(error, BrokenPipeError) and error.errno != errno.EINVAL:  # EINVAL: the same on Windows
            print(f"atleak: {error.filename or 'a file'}: {error.strerror}", file=sys.stderr)
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


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="atleak", description="Internal leakage of automatic-transmission valve bodies."
    )
    without_colours(parser)
    parser.add_argument("--version", action="version", version=f"atleak {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for group in (
        diagnose,
        jobs,
        compare,
        variants,
        import_log,
        report,
        template,
        controller,
        gauge_study,
        catalogue,
        app,
    ):  # as --help lists them
        group.add_parser(commands)
    return parser
