"""The parser of the command line: help with examples, and the command or option that somebody may have meant."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from atleak.common.errors import nearest_name, unknown
from atleak.common.sentences import Sentence

CommandOptions = argparse.ArgumentParser | argparse._ArgumentGroup
"""What options are added to: a command, or one of the groups under which its help lists them."""

COMMANDS = {
    "diagnose": ("diagnose", "a verdict from a measuring sheet, a road test or gauge readings"),
    "evidence": ("diagnose", "what is likely worn, and what to measure next, before anything is opened"),
    "jobs": ("jobs", "the job book: every job that was worked on"),
    "fleet": ("fleet", "thousands of units: diagnosed on all processors or many machines, and summed up"),
    "compare": ("jobs", "two jobs of one unit side by side, before and after"),
    "variants": ("studies", "W1 to W8 of the source study, as printed and as computed"),
    "import-log": ("import_log", "what is understood of a road-test log"),
    "watch": (
        "watch",
        "follow a log while it is being written: pressure beside what is permitted, events as they happen",
    ),
    "report": ("report", "the reports of job files"),
    "template": ("template", "a measuring sheet to fill in"),
    "gauge-card": ("template", "what gauges should show at every tap, as a card to fill in"),
    "vacuum-card": ("template", "what a vacuum stand should show of circuits and lands, as a card to fill in"),
    "controller": ("controller", "describe a valve body: in a workbook, and as the TOML file that every command takes"),
    "gauge-study": ("studies", "repeatability and reproducibility of a gauge, by ANOVA"),
    **{
        name: ("catalogue", f"the {name} of the catalogue, shipped and own")
        for name in ("controllers", "fluids", "limits", "instruments")
    },
    "catalogue": ("catalogue", "your own catalogue"),
    "schema": ("shipped", "the JSON Schema of what a command writes, or of a job record"),
    "sample": ("shipped", "the sample files: sheets, a log, gauge readings"),
    "app": ("app", "the dashboard in a browser, or in a window of its own"),
    "shortcut": ("shortcut", "an icon of the dashboard on desktop and start menu"),
}
"""Every command as help lists them: its module, imported when it is called, and what it does or gives."""


class Parser(argparse.ArgumentParser):
    """A parser whose help keeps the lines of its examples, and which names what somebody may have meant."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(formatter_class=_Formatter, **settings)
        # from Python 3.14 on argparse colours help and messages, which no guarded stream shows
        self.color = False  # type: ignore[attr-defined,unused-ignore]

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Check a choice, of a command too; argparse says no more than that it is none of a list."""
        if action.choices is None or value in action.choices:
            return
        commands = isinstance(action, argparse._SubParsersAction)
        problem = Sentence("no such command") if commands else Sentence("no such choice")
        raise argparse.ArgumentError(action, str(unknown(problem, value, map(str, action.choices))))

    def refuse_rest(self, rest: list[str]) -> None:
        """End with a word on what nothing takes: an unknown option, with the nearest one, or one name too many."""
        first = rest[0].partition("=")[0]
        known = [name for action in self._actions for name in action.option_strings if name.startswith("--")]
        nearest = nearest_name(first, known) if first.startswith("-") else None
        meant = f"; did you mean {nearest}?" if nearest else ""
        self.error(f"unrecognized arguments: {' '.join(rest)}{meant}")


class _Formatter(argparse.RawDescriptionHelpFormatter):
    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=30)


def parsed(parser: Parser, arguments: Sequence[str] | None) -> argparse.Namespace:
    """Return what the command line says; end with a word on it where no command takes it."""
    options, rest = parser.parse_known_args(arguments)
    if rest:
        getattr(options, "parser", parser).refuse_rest(rest)
    return options


def add_command(
    commands: Any,
    name: str,
    run: Callable[[argparse.Namespace], int],
    about: str = "",
    *,
    examples: Iterable[str] = (),
    usage: str | None = None,
    quiet: bool = True,
) -> Parser:
    """Add the parser of a command, which ``run`` carries out.

    Parameters
    ----------
    about
        what it does, or gives, in one line; as `COMMANDS` says unless given.
    examples
        command lines, without the program's name.
    usage
        in place of a list of all options, where there are many.
    quiet
        whether it takes ``--quiet``: not where what it prints is all that it is for.
    """
    parser = _added(commands, name, about, examples, usage=usage)
    parser.set_defaults(run=run, parser=parser)
    add_shown(parser, quiet=quiet)
    return parser


def add_shown(parser: Parser, *, quiet: bool = True) -> None:
    """Add the options of what is printed, which count before a command and behind it."""
    unless = argparse.SUPPRESS  # of a command, which would take back what stood before it
    if quiet:
        help = "print nothing but what goes wrong and what is written to -"
        parser.add_argument("-q", "--quiet", action="store_true", default=unless, help=help)
    help = "print without colours, as with NO_COLOR in the environment"
    parser.add_argument("--no-color", action="store_true", default=unless, help=help)


def add_group(commands: Any, name: str, examples: Iterable[str]) -> Any:
    """Add a command that has commands of its own; by itself it shows its help. Return what those are added to."""
    return groups_of_options(_added(commands, name, "", examples), "ACTION")


def groups_of_options(parser: Parser, metavar: str) -> Any:
    """Return what the commands of a parser are added to; without one of them it shows its help, as a fault of usage."""

    def show(options: argparse.Namespace) -> int:
        parser.print_help(sys.stderr)
        return 2

    parser.set_defaults(run=show, parser=parser)
    return parser.add_subparsers(metavar=metavar, title="commands", dest=metavar.lower())


def _added(commands: Any, name: str, about: str, examples: Iterable[str], **settings: Any) -> Parser:
    about = about or COMMANDS[name][1]
    lines = [f"  atleak {each}" for each in examples]
    epilog = "\n".join(["examples:", *lines]) if lines else None
    description = f"{about[0].upper()}{about[1:]}."
    parser: Parser = commands.add_parser(name, help=about, description=description, epilog=epilog, **settings)
    return parser
