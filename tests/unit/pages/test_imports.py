"""What the first visitor waits for: nothing large is imported that the first page does not use."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
LARGE = ("scipy", "sqlalchemy", "matplotlib", "typst", "jinja2")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("imported", "without"),
    [
        ("pages.shared.entrance, pages.shared.places, pages.shared.reader", (*LARGE, "pydantic", "pandas")),
        ("pages.shared.book, pages.shared.customer, pages.shared.panel", LARGE),
        ("atleak.diagnosis.diagnosis, atleak.job.case", LARGE),
        ("atleak.cli.app", (*LARGE, "pydantic", "numpy", "streamlit")),
    ],
    ids=["before the heading", "frame of every page", "diagnosis", "command that starts the server"],
)
def test_imports_nothing_large(imported: str, without: tuple[str, ...]) -> None:
    script = f"import sys, streamlit.delta_generator\nbefore = set(sys.modules)\nimport {imported}\n"
    if "cli" in imported:
        script = f"import sys\nbefore = set()\nimport {imported}\n"
    script += f"print(*({set(without)} & (sys.modules.keys() - before)))"
    ran = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
    assert ran.stdout.split() == []
