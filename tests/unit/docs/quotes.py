"""What a tutorial shows as the answer of its commands, beside what these say."""

from __future__ import annotations

import re

from tests.unit.docs.pages import ROOT, Block, commands

_FRAMES = re.compile(r"[\s│┃]+")  # and how lines are broken


def _plain(text: str) -> str:
    return _FRAMES.sub(" ", text).strip()


def samples() -> str:
    """Return the sample files that are text, which pages show as well."""
    return "\n".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / "sample_data").glob("*.csv")))


def unsaid(blocks: list[Block], said: str) -> list[str]:
    """Return what blocks of output show and no command said, whatever the breaks of lines; … is what is left out.

    What tells people to type something is no output.
    """
    known = _plain(said)
    shown = [
        block for block in blocks if block.language == "text" and not commands(block) and "python -m" not in block.text
    ]
    parts = [_plain(part) for block in shown for line in block.text.splitlines() for part in line.split("…")]
    return [part for part in parts if part not in known]
