"""The file of a log as it lies on the disk."""

from __future__ import annotations

import hashlib
from pathlib import Path

from atleak.intake.road_test.files.log_file import open_source


def test_the_digest_is_that_of_the_whole_file(tmp_path: Path) -> None:
    content = b"1,2\n" * 300_000
    path = tmp_path / "log.csv"
    path.write_bytes(content)
    assert open_source(path).sha256 == open_source(content).sha256 == hashlib.sha256(content).hexdigest()
