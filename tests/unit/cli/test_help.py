"""What the command line says of itself: help, examples, what somebody may have meant, and what is printed at all."""

from __future__ import annotations

import argparse
import json
import shlex
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from atleak import cli
from atleak.cli.parser import Parser, parsed

Run = Callable[..., tuple[int, str, str]]
SmallSheet = Callable[..., Path]


def _commands(parser: Parser) -> Iterator[Parser]:
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _commands(command)


PARSER = cli._parser()
COMMANDS = {command.prog: command for command in _commands(PARSER)}


@pytest.mark.parametrize("prog", COMMANDS)
def test_every_command_every_option_and_every_name_has_a_text(prog: str) -> None:
    command = COMMANDS[prog]
    of_commands = (argparse._SubParsersAction, argparse._HelpAction)
    assert command.description
    assert [action.dest for action in command._actions if not isinstance(action, of_commands) and not action.help] == []


@pytest.mark.parametrize("prog", COMMANDS)
def test_every_example_is_taken_by_its_command(prog: str) -> None:
    lines = (COMMANDS[prog].epilog or "").splitlines()
    examples = [shlex.split(line) for line in lines if line.startswith(f"  {prog}")]
    for _, *arguments in examples:
        parsed(PARSER, arguments)
    with_files = {"diagnose", "report", "compare", "template", "import-log", "jobs", "controller", "app"}
    assert examples or prog.removeprefix("atleak ") not in with_files


@pytest.mark.parametrize("arguments", [(), ("jobs",), ("controller",), ("catalogue",)])
def test_without_a_command_the_help_is_shown_as_a_fault_of_usage(run: Run, arguments: tuple[str, ...]) -> None:
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert err.startswith(f"usage: {' '.join(['atleak', *arguments])}")
    assert "examples:" in err


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        (("diagnos", "sheet.xlsx"), "did you mean 'diagnose'?"),
        (("jobs", "lst"), "did you mean 'list'?"),
        (("diagnose", "sheet.xlsx", "--pfd", "x.pdf"), "unrecognized arguments: --pfd x.pdf; did you mean --pdf?"),
        (("diagnose", "sheet.xlsx", "--contoller=x"), "did you mean --controller?"),
        (("compare", "a.zip", "b.zip", "--paper", "a5"), "did you mean 'a4'?"),
    ],
)
def test_a_slip_is_answered_with_what_may_be_meant(run: Run, arguments: tuple[str, ...], meant: str) -> None:
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert meant in err
    assert err.count("\n") < 7, "a word, not the whole help"


def test_quiet_prints_nothing_but_what_is_asked_for_and_what_goes_wrong(
    run: Run, small_sheet: SmallSheet, tmp_path: Path
) -> None:
    job = ("diagnose", small_sheet(), "--controller", "minimal_example")
    assert "lands measured" in run(*job)[1]
    assert run(*job, "--quiet", "--xlsx", tmp_path / "x.xlsx") == (0, "", "")
    assert (tmp_path / "x.xlsx").is_file()
    assert json.loads(run("-q", *job, "--json", "-")[1])["verdict"]
    status, out, err = run(*job, "-q", "--gear", "9")
    assert (status, out) == (2, "")
    assert "one of" in err


def test_quiet_leaves_the_id_that_a_new_job_is_asked_for(run: Run, small_sheet: SmallSheet) -> None:
    status, out, _ = run("--quiet", "jobs", "add", small_sheet(), "--controller", "minimal_example")
    assert status == 0
    assert run("jobs", "show", out.strip(), "--quiet") == (0, "", "")


def test_no_color_prints_without_colours(run: Run, small_sheet: SmallSheet, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.delenv("NO_COLOR", raising=False)
    job = ("diagnose", small_sheet(11.3), "--controller", "minimal_example")
    coloured, plain, again = (run(*job, *options)[1] for options in ((), ("--no-color",), ()))
    assert "\x1b[1;3" in coloured or "\x1b[3" in coloured
    assert not any(f"\x1b[{bold}3" in plain for bold in ("", "1;"))
    assert again == coloured, "it counts for this command alone"


@pytest.mark.parametrize(
    ("option", "name", "expected"),
    [
        ("--pdf", "x.docx", "a name.pdf"),
        ("--xlsx", "x.pdf", "a name.xlsx"),
        ("--json", "x.xlsx", "a name.json"),
        ("--job-file", "x.PDF", "a name.zip"),
    ],
)
def test_a_name_that_ends_as_another_kind_of_file_does_is_refused(
    run: Run, tmp_path: Path, option: str, name: str, expected: str
) -> None:
    """Before anything is read: the sheet is not there."""
    status, out, err = run("diagnose", tmp_path / "no.xlsx", option, tmp_path / name)
    assert (status, out) == (2, "")
    assert f"{name}: the ending of its name is that of another kind of file; expected {expected}" in err
    assert not (tmp_path / name).exists()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--language", "de"), ["--language does nothing without --pdf"]),
        (
            ("--language", "de", "--sections", "lands"),
            ["--language does nothing", "--sections does nothing without --pdf"],
        ),
        (("--paper", "letter"), ["--paper does nothing without --pdf or --xlsx"]),
        ((), []),
    ],
)
def test_an_option_that_does_nothing_is_doubted(
    run: Run, small_sheet: SmallSheet, options: tuple[str, ...], said: list[str]
) -> None:
    status, _, err = run("diagnose", small_sheet(), "--controller", "minimal_example", *options)
    assert status == 0
    assert err.count("does nothing") == len(said)
    for each in said:
        assert f"atleak: {each}" in err
