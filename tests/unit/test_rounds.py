"""The tests' own rules hold where the tests run in several processes."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow  # what a round does with a warning or a skip changes with its settings alone

TESTS = {
    "plain": "def test_passes():\n    assert True\n",
    "skipped": "import pytest\n\ndef test_skipped():\n    pytest.skip('no browser')\n",
    "skipped_file": "import pytest\n\npytest.importorskip('no_such_module')\n",
    "warns": "import warnings\n\ndef test_warns():\n    warnings.warn('old', stacklevel=1)\n",
    "slow": "import pytest\n\n@pytest.mark.slow\ndef test_slow():\n    assert False\n",
    "misspelt": "import pytest\n\n@pytest.mark.slwo\ndef test_slow():\n    assert True\n",
}


def outcomes(root: Path, folder: Path, **environment: str) -> dict[str, str]:
    """How each of these tests ends, run by the project's own settings in two processes."""
    for name in ("tests", "atleak"):
        (folder / name).mkdir()
    shutil.copy(root / "pyproject.toml", folder)
    shutil.copy(root / "tests" / "conftest.py", folder / "tests")
    for name, test in TESTS.items():
        (folder / "tests" / f"test_{name}.py").write_text(test, encoding="utf-8")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST_", "ATLEAK_"))}
    kept["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"  # of the plugins only the one that the settings ask for
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-p", "xdist", "-n", "2", "-rA"]
    done = subprocess.run(
        [*command, "--continue-on-collection-errors"],
        cwd=folder, env=kept | environment, capture_output=True, encoding="utf-8", check=False,
    )  # fmt: skip
    assert "2 workers" in done.stdout, done.stdout + done.stderr
    lines = re.findall(r"^(PASSED|FAILED|ERROR|SKIPPED)(?: \[\d\])? tests.test_(\w+)\.py", done.stdout, re.MULTILINE)
    return {name: outcome.lower() for outcome, name in lines}


def test_a_warning_and_a_misspelt_mark_fail_and_what_is_slow_is_left_out(root: Path, tmp_path: Path) -> None:
    assert outcomes(root, tmp_path) == {
        "plain": "passed", "skipped": "skipped", "skipped_file": "skipped", "warns": "failed", "misspelt": "error",
    }  # fmt: skip


def test_a_skip_is_a_failure_where_nothing_may_skip(root: Path, tmp_path: Path) -> None:
    assert outcomes(root, tmp_path, ATLEAK_NOTHING_MAY_SKIP="1") == {
        "plain": "passed", "skipped": "failed", "skipped_file": "error", "warns": "failed", "misspelt": "error",
    }  # fmt: skip
