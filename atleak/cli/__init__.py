"""Run the command line: files in, a verdict, JSON, a workbook out.

Exit status: 0 done, 1 only with ``--fail-on`` and a pair or a total at or past it, 2 bad input or usage.
Every module adds the parsers of its commands and runs them; it is imported when one of them is called.
"""

from __future__ import annotations

import argparse
import atexit
import errno
import gc
import os
import sys
from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from importlib import import_module

from atleak.cli.parser import COMMANDS, Parser, add_shown, groups_of_options, parsed
from atleak.common.errors import AtleakError
from atleak.common.printable import only_what_is_asked_for, printable_streams
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
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # else it looks through every installed package
    atexit.register(gc.freeze)  # else all that is there is looked through once more when the interpreter ends
    with printable_streams():
        return _run(arguments)


def _run(arguments: Sequence[str] | None) -> int:
    try:
        arguments = sys.argv[1:] if arguments is None else arguments
        called = next((each for each in arguments if not each.startswith("-")), None)
        options = parsed(_parser([called]), arguments)
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
        library = (error.name or "").partition(".")[0] if isinstance(error, ModuleNotFoundError) else ""
        if library not in ("", "atleak"):
            print(f"atleak: this needs the library {library}, which is not installed", file=sys.stderr)
            return 2
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


def _parser(called: Collection[str | None] = tuple(COMMANDS)) -> Parser:
    """Return the parser of the command line, with all that some of its commands take; help names every one."""
    whole = Parser(prog="atleak", description="Internal leakage of automatic-transmission valve bodies.", epilog=_MORE)
    whole.add_argument("--version", action="version", version=f"atleak {__version__}", help="print it and end")
    add_shown(whole)
    commands = groups_of_options(whole, "COMMAND")
    for name, (module, about) in COMMANDS.items():
        if name in called:
            import_module(f"atleak.cli.{module}").add_parser(commands, name)
        else:
            commands.add_parser(name, help=about)
    return whole
