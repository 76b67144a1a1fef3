"""What the pages tell people to type does what they say: every block of code is checked, and those that can run, run.

In a block marked ``python`` everything runs; in one marked ``sh`` what begins with ``atleak``. All blocks of a page run
in their order in one folder, which holds nothing but ``sample_data``. What is marked ``text`` is output, or a form in
which names in capitals stand for files: it does not run, but a command line in it is one that atleak takes.
"""

from __future__ import annotations

import json
import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest

from atleak import cli
from tests.unit.docs.pages import OTHER_PROGRAMS, ROOT, Block, Command, commands, pages, programs, split, text_of
from tests.unit.docs.quotes import samples, unsaid

PAGES = pages()

#: Pages whose answers are those of their commands. Where commands need files that the reader makes, a test of that page
#: makes them: `tests/unit/cli/test_my_first_transmission.py`.
QUOTING = ["docs/before-and-after.md", *(page for page in PAGES if page.startswith("docs/tutorials/"))]
QUOTING.remove("docs/tutorials/my-first-transmission.md")

#: What a block may be marked as; the last three are files of other programs, which are shown and not checked.
LANGUAGES = ("python", "sh", "toml", "json", "text", "csv", "dockerfile", "nginx", "caddy")


def blocks(page: str) -> list[Block]:
    return split(text_of(page))[1]


def fault_of(command: Command, capsys: pytest.CaptureFixture[str]) -> str | None:
    """What atleak says of a command line that it does not take."""
    try:
        cli.parsed(cli._parser(), command.words)
    except SystemExit as end:
        said = capsys.readouterr().err
        return f"{command}: {said}" if end.code else None  # asked for its help, it ends with status 0
    return None


@pytest.mark.parametrize("page", PAGES)
def test_every_block_is_what_it_is_marked_as(page: str, capsys: pytest.CaptureFixture[str]) -> None:
    for block in blocks(page):
        place = f"{page}, line {block.line}"
        assert block.language in LANGUAGES, place
        match block.language:
            case "python":
                compile(block.text, place, "exec")
            case "toml":
                assert tomllib.loads(block.text), place
            case "json":
                assert json.loads(block.text) is not None, place
            case "sh":
                assert set(programs(block)) <= {"atleak", *OTHER_PROGRAMS}, place
                assert all(command.words for command in commands(block)), place
        assert [fault for command in commands(block) if (fault := fault_of(command, capsys))] == [], place


def run_page(page: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> str:
    """Run what a page tells people to type, in the order in which they read it, and return what all of it printed."""
    shutil.copytree(ROOT / "sample_data", folder / "sample_data")
    monkeypatch.chdir(folder)
    monkeypatch.setenv("ATLEAK_HOME", str(folder.parent / f"{folder.name}-home"))
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.delenv("ATLEAK_DATABASE_URL", raising=False)
    heard: list[str] = []
    names: dict[str, Any] = {"__name__": "__main__"}
    for block in blocks(page):
        if block.language == "python":
            # a line of the page in a traceback, without inheriting this module's future imports
            exec(compile("\n" * block.line + block.text, page, "exec", dont_inherit=True), names)
        elif block.language == "sh":
            for command in filter(lambda command: command.runs, commands(block)):
                heard += capsys.readouterr()
                status = cli.main(command.here())
                said = capsys.readouterr()
                heard += said
                assert status in command.statuses, f"{page}, {command}\n{said.err}"
                if command.into:
                    Path(command.into).write_text(said.out, encoding="utf-8")
    return "\n".join([*heard, *capsys.readouterr()])


def runs(page: str, language: str) -> bool:
    return any(
        block.language == language and (language == "python" or any(command.runs for command in commands(block)))
        for block in blocks(page)
    )


@pytest.mark.parametrize("page", [page for page in PAGES if runs(page, "python") and not runs(page, "sh")])
def test_python_on_a_page_runs(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    said = run_page(page, tmp_path / "here", monkeypatch, capsys)
    assert page not in QUOTING or unsaid(blocks(page), said + samples()) == []


@pytest.mark.slow  # the test of every block shows in no time that each of these command lines is one
@pytest.mark.usefixtures("all_draws")  # intervals that a page shows are those that its reader sees
@pytest.mark.parametrize("page", [page for page in PAGES if runs(page, "sh")])
def test_command_lines_on_a_page_run(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    said = run_page(page, tmp_path / "here", monkeypatch, capsys)
    assert page not in QUOTING or unsaid(blocks(page), said + samples()) == []


def test_an_answer_that_no_command_gave_is_found() -> None:
    _, shown = split(
        "```text\nunit: ■ replace\n… 24.2 % │ amber\natleak diagnose SHEET\n```\n\n```text\n24.3 %\nred\n```\n"
    )
    assert unsaid(shown, "unit: ■ replace\n 24.2 %\n  amber; red") == ["24.3 %"]
    _, quoted = split("```text\nunit: ■ replace\n… 24.2 % │ amber\n```\n")
    assert unsaid(quoted, "unit: ■\nreplace\n 24.2 %\n  amber") == []


def test_a_command_line_that_atleak_does_not_take_is_found(capsys: pytest.CaptureFixture[str]) -> None:
    _, (block,) = split(
        "Type\n\n```sh\natleak diagnose sheet.xlsx --rode-test log.csv  # as you like\natlaek app\n```\n"
    )
    (command,) = commands(block)
    assert command.words == ("diagnose", "sheet.xlsx", "--rode-test", "log.csv")
    assert "did you mean --road-test" in (fault_of(command, capsys) or "")
    assert "atlaek" in set(programs(block))


def test_a_page_whose_command_fails_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "page.md"
    page.write_text("```sh\natleak schema > schema.json\natleak import-log none.csv\n```\n", encoding="utf-8")
    with pytest.raises(AssertionError, match=r"import-log none\.csv(?s:.)*none\.csv"):
        run_page(str(page), tmp_path / "here", monkeypatch, capsys)
    assert json.loads((tmp_path / "here" / "schema.json").read_text(encoding="utf-8"))
