"""Let pages of the site lead to files outside ``docs/``, as they do on a code host: mkdocs loads this (``mkdocs.yml``).

A link such as ``../CHANGELOG.md`` works in the checkout, but a site holds only what is in ``docs/``. Files that pages
lead to, and those that these lead to, are added to the site in the folder ``files/``, and the links follow them. A link
to a folder keeps its words and leads nowhere.

Blocks of Python on the pages of `RUN` run, and the site shows what each printed and what its last line is. The page of
commands ends with what ``--help`` says of all of them.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import io
import posixpath
import re
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

from atleak import cli

ROOT = Path(__file__).resolve().parents[1]
DOCS = "docs"
ELSEWHERE = "files"  # where files from outside `docs/` stand in the site

RUN = ("for-engineers.md",)
COMMANDS = "commands.md"
_BLOCK = re.compile(r"^```python\n(?P<code>.*?)^```\n", re.MULTILINE | re.DOTALL)

#: ``](target#anchor)`` of a relative link.
_LINK = re.compile(r"(?P<words>\[[^\]\[]*\])\((?P<target>[^)#\s:]+)(?P<anchor>#[^)\s]*)?\)")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add every file that pages lead to and that stands outside ``docs/``."""
    waiting = [posixpath.join(DOCS, file.src_uri) for file in files.documentation_pages()]
    seen = set(waiting)
    while waiting:
        path = waiting.pop()
        for found in _LINK.finditer((ROOT / path).read_text(encoding="utf-8")):
            target = _in_checkout(path, found["target"])
            if target in seen or target.startswith(f"{DOCS}/") or not (ROOT / target).is_file():
                continue
            seen.add(target)
            files.append(_file(target, config))
            if target.endswith(".md"):
                waiting.append(target)
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Let links that lead out of ``docs/``, or into it from outside, lead to where the site has the same file."""
    here = page.file.src_uri
    if here in RUN:
        names: dict[str, Any] = {}
        markdown = _BLOCK.sub(lambda found: f"{found[0]}\n{output(found['code'], names)}\n", markdown)
    if here == COMMANDS:
        markdown = f"{markdown}\n{listed(cli._parser())}"
    path = here.removeprefix(f"{ELSEWHERE}/") if here.startswith(f"{ELSEWHERE}/") else posixpath.join(DOCS, here)

    def led(found: re.Match[str]) -> str:
        target = _in_checkout(path, found["target"])
        if not (ROOT / target).exists():
            return found[0]  # mkdocs says that it is missing
        if (ROOT / target).is_dir():
            return found["words"][1:-1]
        place = posixpath.relpath(_in_site(target), posixpath.dirname(here) or ".")
        return f"{found['words']}({place}{found['anchor'] or ''})"

    return _LINK.sub(led, markdown)


def listed(whole: argparse.ArgumentParser) -> str:
    """Return every command with what it does, and their examples, as a table and a block of Markdown.

    >>> "| `atleak jobs list` | " in listed(cli._parser())
    True
    """
    rows, examples, waiting = [], [], [whole]
    while waiting:
        parser = waiting.pop(0)
        below = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
        waiting[:0] = [each for action in below for each in action.choices.values()]
        if not below:
            rows.append(f"| `{parser.prog}` | {(parser.description or '').replace('|', '&#124;')} |\n")
            examples += [line.strip() for line in (parser.epilog or "").splitlines()[1:]]
    table = "".join(["| command | does |\n|---|---|\n", *rows])
    return f"## All of them\n\n{table}\n## Examples\n\n```text\n" + "\n".join(dict.fromkeys(examples)) + "\n```\n"


def output(code: str, names: dict[str, Any]) -> str:
    """Run a block in the checkout, with the names of those before it; return what it gave as Markdown and HTML.

    >>> output("import atleak\\nprint(atleak.__name__)", {})
    '```text\\natleak\\n```\\n'
    """
    *lines, last = ast.parse(code).body
    printed, value = io.StringIO(), None
    with contextlib.chdir(ROOT), contextlib.redirect_stdout(printed):
        exec(compile(ast.Module(lines, []), "<page>", "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), "<page>", "eval"), names)
        else:
            exec(compile(ast.Module([last], []), "<page>", "exec"), names)
    text = f"```text\n{printed.getvalue()}```\n" if printed.getvalue() else ""
    if hasattr(value, "get_figure"):  # matplotlib's axes
        drawn = io.StringIO()
        value.get_figure().savefig(drawn, format="svg", metadata={"Date": None}, bbox_inches="tight")
        svg = drawn.getvalue()
        label = f"{value.get_title() or value.get_ylabel()} over {value.get_xlabel()}"
        return f'{text}<figure role="img" aria-label="{label}">{svg[svg.index("<svg") :]}</figure>\n'
    if hasattr(value, "_repr_html_"):
        return f'{text}<div style="overflow-x:auto">{value._repr_html_()}</div>\n'
    return text


def _in_checkout(path: str, target: str) -> str:
    return posixpath.normpath(posixpath.join(posixpath.dirname(path), target))


def _in_site(path: str) -> str:
    if path.startswith(f"{DOCS}/"):
        return path.removeprefix(f"{DOCS}/")
    return f"{ELSEWHERE}/{path}" if path.endswith(".md") else f"{ELSEWHERE}/{path}.txt"


def _file(path: str, config: MkDocsConfig) -> Any:
    source = ROOT / path
    return File.generated(config, _in_site(path), content=source.read_text(encoding="utf-8"))
