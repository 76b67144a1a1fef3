"""Files are written whole: the earlier one stays until all of the new one is on the disk."""

from __future__ import annotations

import errno
import os
import stat
import subprocess
import sys
import time
from pathlib import Path

import pytest

from atleak.common import files
from atleak.common.errors import OutputError
from atleak.common.files import PRIVATE, replace_file, replacing

POSIX = pytest.mark.skipif(os.name != "posix", reason="permissions, links and devices of POSIX")


def test_a_file_is_made_and_replaced_and_nothing_lies_beside_it(tmp_path: Path) -> None:
    target = tmp_path / "Łódź.json"
    for content in (b"first", b"second and longer", b""):
        replace_file(target, content)
        assert target.read_bytes() == content
    assert [path.name for path in tmp_path.iterdir()] == [target.name]


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_a_full_disk_leaves_the_earlier_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    target = tmp_path / "report.pdf"
    target.write_bytes(b"earlier")
    monkeypatch.setattr(*((os, "fsync", full) if step == "fsync" else (Path, "replace", full)))
    with pytest.raises(OutputError, match=r"report\.pdf: cannot be written: No space left"):
        replace_file(target, b"new")
    assert target.read_bytes() == b"earlier"
    assert len(list(tmp_path.iterdir())) == 1


def test_a_file_that_another_program_holds_is_named_with_the_likely_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def held(*_: object) -> None:
        raise PermissionError(errno.EACCES, "Access is denied")

    target = tmp_path / "report.xlsx"
    target.write_bytes(b"earlier")
    monkeypatch.setattr(Path, "replace", held)
    monkeypatch.setattr(files, "_PAUSE", 0.0)
    with pytest.raises(OutputError, match=r"report\.xlsx: cannot be written: Access is denied: is it open .* Excel"):
        replace_file(target, b"new")
    assert target.read_bytes() == b"earlier"
    assert len(list(tmp_path.iterdir())) == 1


def test_a_file_that_is_held_for_a_moment_is_replaced_after_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    refused, really = [], Path.replace

    def held_at_first(path: Path, target: Path) -> Path:
        if len(refused) < 3:
            refused.append(path)
            raise PermissionError(errno.EACCES, "Access is denied")
        return really(path, target)

    monkeypatch.setattr(Path, "replace", held_at_first)
    monkeypatch.setattr(files, "_PAUSE", 0.0)
    replace_file(tmp_path / "a.json", b"new")
    assert (tmp_path / "a.json").read_bytes() == b"new"


def test_a_folder_that_may_not_be_written_in_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> int:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(os, "open", refused)
    with pytest.raises(OutputError, match="nothing may be written in its folder"):
        replace_file(tmp_path / "a.json", b"new")


def test_a_write_protected_file_is_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "a.json"
    target.write_bytes(b"earlier")
    monkeypatch.setattr(os, "access", lambda *_: False)  # who runs this test may be allowed everything
    with pytest.raises(OutputError, match="write-protected"):
        replace_file(target, b"new")
    assert target.read_bytes() == b"earlier"


@POSIX
def test_permissions_are_those_of_the_earlier_file_or_of_any_new_one(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        earlier = tmp_path / "earlier"
        earlier.write_bytes(b"")
        earlier.chmod(0o664)
        replace_file(earlier, b"new")
        replace_file(tmp_path / "new", b"new")
        replace_file(tmp_path / "private", b"new", mode=PRIVATE)
    finally:
        os.umask(before)
    modes = {path.name: stat.S_IMODE(path.stat().st_mode) for path in tmp_path.iterdir()}
    assert modes == {"earlier": 0o664, "new": 0o640, "private": 0o600}


@POSIX
def test_a_link_stays_a_link_to_the_new_content(tmp_path: Path) -> None:
    (tmp_path / "shelf").mkdir()
    real, link, to_nothing = tmp_path / "shelf" / "real.json", tmp_path / "link.json", tmp_path / "to_nothing.json"
    real.write_bytes(b"earlier")
    link.symlink_to(real)
    to_nothing.symlink_to(tmp_path / "shelf" / "later.json")
    replace_file(link, b"new")
    replace_file(to_nothing, b"new")
    assert link.is_symlink()
    assert to_nothing.is_symlink()
    assert real.read_bytes() == (tmp_path / "shelf" / "later.json").read_bytes() == b"new"


@POSIX
def test_devices_and_standard_output_are_written_to(tmp_path: Path) -> None:
    replace_file("/dev/null", b"new")
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)
    code = "from atleak.common.files import replace_file; replace_file('/dev/stdout', b'new\\n'); print('said')"
    assert subprocess.check_output([sys.executable, "-c", code]) == b"new\nsaid\n"
    with (tmp_path / "log").open("wb") as stream:
        stream.write(b"earlier\n")
        stream.flush()
        subprocess.run([sys.executable, "-c", code], stdout=stream, check=True)
    assert (tmp_path / "log").read_bytes() == b"earlier\nnew\nsaid\n"


def test_a_process_killed_while_it_writes_leaves_a_whole_file(tmp_path: Path) -> None:
    target, size = tmp_path / "report.json", 1 << 20
    replace_file(target, b"0" * size)
    code = (
        "import sys; from atleak.common.files import replace_file\n"
        f"for n in range(10**9): replace_file(sys.argv[1], b'%d' % (n % 10) * {size})"
    )
    for kill in range(12):
        with subprocess.Popen([sys.executable, "-c", code, str(target)]) as writer:
            before, until = target.stat().st_mtime_ns, time.monotonic() + 30.0
            while target.stat().st_mtime_ns == before and time.monotonic() < until:
                time.sleep(0.001)
            time.sleep(0.0007 * kill)
            writer.kill()
        content = target.read_bytes()
        assert len(content) == size
        assert len(set(content)) == 1


@POSIX
@pytest.mark.parametrize(
    "option",
    ["--json", *(pytest.param(name, marks=pytest.mark.slow) for name in ("--pdf", "--xlsx", "--job-file"))],
)
def test_a_report_that_does_not_fit_on_the_disk_leaves_the_earlier_one(
    tmp_path: Path, sample_readings: Path, option: str
) -> None:
    import resource

    target = tmp_path / "report"
    command = [sys.executable, "-m", "atleak", "diagnose", str(sample_readings), option, str(target), "--force"]
    target.write_bytes(b"earlier")

    def little_room() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

    # else a compiled module is cut short too, and fails another test
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}
    finished = subprocess.run(command, capture_output=True, check=False, env=environment, preexec_fn=little_room)
    assert finished.returncode == 2
    assert b"cannot be written" in finished.stderr
    assert target.read_bytes() == b"earlier"
    assert [path.name for path in tmp_path.iterdir()] == ["report"]


def test_what_a_killed_process_has_left_goes_after_a_day(tmp_path: Path) -> None:
    left, begun = tmp_path / ".atleak-00.part", tmp_path / ".atleak-01.part"
    others = [tmp_path / name for name in (".atleak-00.part-wal", ".atleak.part", "atleak-02.part")]
    for path in (left, begun, *others):
        path.touch()
        yesterday = time.time() - (25 if path != begun else 23) * 3600
        os.utime(path, (yesterday, yesterday))
    replace_file(tmp_path / "report.pdf", b"new")
    assert {path.name for path in tmp_path.iterdir()} == {begun.name, ".atleak.part", "atleak-02.part", "report.pdf"}


@POSIX
def test_a_file_that_something_else_writes_has_its_mode_from_the_start(tmp_path: Path) -> None:
    (tmp_path / "shop.backup").touch(0o644)
    with replacing(tmp_path / "shop.backup", mode=PRIVATE) as beside:
        assert stat.S_IMODE(beside.stat().st_mode) == PRIVATE
        beside.write_bytes(b"all of it")
    assert stat.S_IMODE((tmp_path / "shop.backup").stat().st_mode) == PRIVATE
    with pytest.raises(OutputError, match="No such file"), replacing(tmp_path / "nowhere" / "a", mode=PRIVATE):
        pass
