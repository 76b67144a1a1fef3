"""What the first visitor waits for: nothing large is imported that the first page does not use."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
LARGE = ("scipy", "sqlalchemy", "matplotlib", "typst")


@pytest.mark.slow
def test_the_frame_of_every_page_imports_nothing_large() -> None:
    script = f"import sys\nfrom pages.shared import book, panel\nprint(*({set(LARGE)} & sys.modules.keys()))"
    ran = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
    assert ran.stdout.split() == []


@pytest.mark.slow
def test_a_diagnosis_imports_no_scipy() -> None:
    script = "import sys\nimport atleak.diagnosis.diagnosis, atleak.job.case\nprint('scipy' in sys.modules)"
    ran = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
    assert ran.stdout.split() == ["False"]
