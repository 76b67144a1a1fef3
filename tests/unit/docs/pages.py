"""The pages that people read, as the tests of them see them: their blocks of code, command lines, links and anchors."""

from __future__ import annotations

import re
import shlex
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]

#: Programs that a page may tell people to run, besides atleak; what they do is not this package's to test.
OTHER_PROGRAMS = ("dask", "docker", "git", "pytest", "python", "ruff", "source")

_FENCE = re.compile(r"^(?P<indent> *)(?P<ticks>```+)(?P<language>[\w-]*)(?P<more>.*)$")
_HEADING = re.compile(r"^#{1,6} +(?P<title>.*?)(?: +#+)?$")
_ANCHOR = re.compile(r"<a (?:id|name)=\"([^\"]+)\"")
_LINK = re.compile(r"\]\((?P<target>[^()\s]+(?:\([^()\s]*\)[^()\s]*)*)(?: \"[^\"]*\")?\)")
_DEFINED = re.compile(r"^\[[^\]]+\]: +(?P<target>\S+)", re.MULTILINE)
_DRAWN = re.compile(r"<(?:img|source|a)\b[^>]*?\b(?:src|srcset|href)=\"(?P<target>[^\"]+)\"")


def pages() -> list[str]:
    """Return every page's path from the root."""
    own = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), ROOT / "sample_data" / "README.md"]
    return sorted(path.relative_to(ROOT).as_posix() for path in own)


def text_of(page: str) -> str:
    return (ROOT / page).read_text(encoding="utf-8")


@dataclass(frozen=True)
class Block:
    """A block of code between two fences."""

    line: int  # of its first fence
    language: str
    text: str


def split(text: str) -> tuple[str, list[Block]]:
    """Part a page into its prose, with an empty line in the place of each line of code, and its blocks of code."""
    prose: list[str] = []
    blocks: list[Block] = []
    opened: tuple[int, str, str, str] | None = None  # line, indent, ticks, language
    inside: list[str] = []
    for number, line in enumerate(text.splitlines(), start=1):
        fence = _FENCE.match(line)
        if opened is None and fence:
            opened, inside = (number, fence["indent"], fence["ticks"], fence["language"]), []
        elif opened is not None and line.strip() == opened[2]:
            blocks.append(Block(opened[0], opened[3], "\n".join(inside) + "\n"))
            opened = None
        elif opened is not None:
            inside.append(line.removeprefix(opened[1]))
        prose.append("" if opened or fence else line)
    if opened is not None:
        raise ValueError(f"the block of line {opened[0]} has no end")
    return "\n".join(prose), blocks


@dataclass(frozen=True)
class Command:
    """A command line of atleak."""

    line: int  # where its block begins
    words: tuple[str, ...]  # without the program's name
    into: str | None = None  # the file that takes what it prints

    def __str__(self) -> str:
        return f"line {self.line}: atleak {shlex.join(self.words)}"

    @property
    def runs(self) -> bool:
        """Whether it comes to an end by itself."""
        return self.words[:1] != ("app",)

    @property
    def statuses(self) -> tuple[int, ...]:
        """Which exit statuses are as they should be."""
        return (0, 1) if "--fail-on" in self.words else (0,)

    def here(self) -> list[str]:
        """Return the words as a shell hands them on: with the files that a pattern fits in its place."""
        fitting = {word: sorted(map(str, Path().glob(word))) for word in self.words if "*" in word}
        return [name for word in self.words for name in fitting.get(word) or [word]]


def commands(block: Block) -> list[Command]:
    """Return the command lines of atleak in a block, in their order."""
    found = []
    for line in block.text.replace("\\\n", " ").splitlines():
        if not re.match(r"(python -m )?atleak ", line):
            continue
        words = shlex.split(line, comments=True)
        words = words[3:] if words[0] == "python" else words[1:]
        into = None
        if ">" in words:
            words, (into,) = words[: words.index(">")], words[words.index(">") + 1 :]
        found.append(Command(block.line, tuple(words), into))
    return found


def programs(block: Block) -> Iterator[str]:
    """Yield what each line of a block for the shell begins with, comments aside."""
    for line in block.text.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if words:
            yield words[0]


def slug(title: str) -> str:
    """Return the anchor that code hosts, and this site, make of a heading.

    >>> slug("What `--fill-down` does: *example* of [U_p](#share)")
    'what---fill-down-does-example-of-u_p'
    """
    shown = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", title)
    shown = re.sub(r"<[^>]+>", "", shown)
    shown = re.sub(r"(?<!\w)([*_]+)(\S.*?)\1(?!\w)", r"\2", shown.replace("`", ""))
    return re.sub(r"[^\w\- ]", "", shown.strip().lower()).replace(" ", "-")


def anchors(text: str) -> Counter[str]:
    """Count the anchors of a page: its headings and the ones that it sets itself."""
    prose, _ = split(text)
    headings = [slug(found["title"]) for line in prose.splitlines() if (found := _HEADING.match(line))]
    return Counter([*headings, *_ANCHOR.findall(prose)])


def links(text: str) -> list[str]:
    """Return where a page leads, pictures too; what stands in code leads nowhere."""
    prose, _ = split(text)
    prose = re.sub(r"(`+).+?\1", "", prose)
    return [found["target"] for form in (_LINK, _DEFINED, _DRAWN) for found in form.finditer(prose)]
