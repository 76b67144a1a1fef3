"""What holds for every command: usage, streams, and messages in place of tracebacks."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from atleak import cli
from atleak.catalogue.entries import catalogue_files
from atleak.version import __version__

Run = Callable[..., tuple[int, str, str]]

SmallSheet = Callable[..., Path]
Process = Callable[..., subprocess.CompletedProcess[bytes]]


@pytest.mark.parametrize("arguments", [[], ["foo"], ["template"], ["diagnose", "--rpm", "x"]])
def test_faults_of_usage_end_with_2(run: Run, arguments: list[str]) -> None:
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert "usage: atleak" in err


def test_version_and_help(run: Run) -> None:
    assert run("--version")[:2] == (0, f"atleak {__version__}\n")
    status, out, _ = run("--help")
    assert status == 0
    for command in ("diagnose", "variants", "import-log", "template", "controllers", "fluids", "limits", "app"):
        assert command in out


def test_a_fault_of_the_program_is_said_without_a_traceback(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise RuntimeError("the shelf fell down")

    monkeypatch.delenv("ATLEAK_TRACEBACK", raising=False)
    monkeypatch.setattr("atleak.cli.catalogue.listed_entries", broken)
    assert cli.main(["limits"]) == 2
    err = capsys.readouterr().err
    assert "RuntimeError: the shelf fell down" in err
    assert "Traceback" not in err


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (OSError(errno.EINVAL, "Invalid argument", "report.pdf"), "atleak: report.pdf: Invalid argument"),
        (OSError(errno.EINVAL, "Invalid argument"), "atleak: a file: Invalid argument"),
        (OSError("a driver's own word"), "atleak: a file: a driver's own word"),
    ],
)
def test_an_error_of_the_system_is_said(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, error: OSError, said: str
) -> None:
    def refused(*_: object) -> None:
        raise error

    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr("atleak.cli.catalogue.listed_entries", refused)
    assert cli.main(["limits"]) == 2
    assert capsys.readouterr().err.strip() == said


@pytest.mark.usefixtures("all_draws")  # as the process does
def test_python_m_is_the_same_and_survives_a_windows_code_page(
    run: Run, sample_readings: Path, process: Process
) -> None:
    _, here, _ = run("diagnose", sample_readings, "--json", "-")
    finished = process("diagnose", sample_readings, "--json", "-", PYTHONIOENCODING="cp1252")
    assert (finished.returncode, finished.stderr) == (0, b"")
    assert json.loads(finished.stdout.decode("utf-8")) == json.loads(here)


def test_a_message_survives_a_windows_code_page(tmp_path: Path, process: Process) -> None:
    finished = process("diagnose", tmp_path / "Messblatt Łódź µm.xlsx", PYTHONIOENCODING="cp1252", PYTHONUTF8="0")
    assert finished.returncode == 2
    assert "Messblatt Łódź µm.xlsx" in finished.stderr.decode("utf-8")
    assert b"Traceback" not in finished.stderr


@pytest.mark.skipif(os.name == "nt", reason="a closed pipe is reported otherwise on Windows")
@pytest.mark.parametrize("arguments", [["limits", "--json", "-"], pytest.param(["fluids"], marks=pytest.mark.slow)])
def test_a_reader_that_goes_away_is_no_verdict(arguments: list[str]) -> None:
    """Status 1 would say that a pair is past its limit."""
    read, write = os.pipe()
    os.close(read)
    with subprocess.Popen(
        [sys.executable, "-m", "atleak", *arguments], stdout=write, stderr=subprocess.PIPE
    ) as running:
        os.close(write)
        _, err = running.communicate(timeout=60)
    assert running.returncode == 141
    assert err == b""


class _Panic(BaseException):
    """As a library in Rust raises it."""


def test_a_panic_is_a_fault_of_the_program_and_no_verdict(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Status 1 would say that a limit is passed."""

    def panics(*_: object) -> None:
        raise _Panic("called `Option::unwrap()` on a `None` value")

    monkeypatch.delenv("ATLEAK_TRACEBACK", raising=False)
    monkeypatch.setattr("atleak.cli.catalogue.listed_entries", panics)
    assert cli.main(["limits"]) == 2
    assert "unexpected _Panic: called `Option::unwrap()`" in capsys.readouterr().err


def test_whoever_interrupts_gets_no_message(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("atleak.cli.catalogue.listed_entries", interrupted)
    assert run("limits") == (130, "", "")


ESCAPES = "\x1b]0;owned\x07\x1b[2J\x9b31m"


def _without_escapes(text: str) -> bool:
    return not {"\x1b", "\x07", "\x9b"} & set(text)


def test_escapes_in_a_log_reach_no_terminal(run: Run, tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    heading = f"time [s],engine_speed [rpm],p_g [kPa],oil{ESCAPES} level"
    log.write_text(heading + "\n" + "".join(f"{i / 10},1500,800,{i}\n" for i in range(20)), encoding="utf-8")
    status, out, _ = run("import-log", log)
    assert status == 0
    assert "oil]0;owned[2J31m level" in " ".join(out.split())
    assert _without_escapes(out)


@pytest.mark.parametrize(
    "arguments", [("diagnose", ESCAPES), (ESCAPES,), ("limits", ESCAPES), ("diagnose", "x", "--set", ESCAPES)]
)
def test_escapes_in_messages_reach_no_terminal(run: Run, arguments: tuple[str, ...]) -> None:
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert "owned" in err
    assert _without_escapes(err)


@pytest.fixture
def odd_controller(tmp_path: Path) -> Path:
    """A controller of one's own with escapes in its name."""
    own = tmp_path / "own.toml"
    text = catalogue_files("controllers")["minimal_example"].read_text(encoding="utf-8")
    own.write_text(text.replace('name = "', 'name = "\\u001b[2J\\u009bowned ', 1), encoding="utf-8")
    return own


def test_escapes_in_the_catalogue_reach_no_terminal(run: Run, odd_controller: Path, small_sheet: SmallSheet) -> None:
    status, out, err = run("diagnose", small_sheet(), "--controller", odd_controller)
    assert status == 0
    assert "[2Jowned " in out
    assert _without_escapes(out + err)


def test_a_record_for_a_program_keeps_every_sign(run: Run, odd_controller: Path, small_sheet: SmallSheet) -> None:
    _, out, _ = run("diagnose", small_sheet(), "--controller", odd_controller, "--json", "-")
    assert json.loads(out)["controller"]["name"].startswith("\x1b[2J\x9bowned ")


@pytest.mark.skipif(sys.platform != "linux", reason="other systems take no such file name")
@pytest.mark.parametrize("target", ["-", pytest.param("out.json", marks=pytest.mark.slow)])
def test_a_file_name_that_is_no_text_is_no_fault(
    process: Process, sample_log: Path, tmp_path: Path, target: str
) -> None:
    log = tmp_path / os.fsdecode(b"caf\xe9.csv")
    log.write_bytes(sample_log.read_bytes())
    written = target if target == "-" else tmp_path / target
    finished = process("import-log", log, "--json", written, PYTHONUTF8="1")
    assert finished.returncode == 0
    record = json.loads(finished.stdout if target == "-" else Path(written).read_bytes())
    assert record["file"] == log.name


@pytest.mark.skipif(os.name == "nt", reason="a stream is closed otherwise on Windows")
def test_a_closed_standard_output_is_no_fault() -> None:
    code = "import os, sys; os.close(1); os.execv(sys.executable, [sys.executable, '-m', 'atleak', 'fluids'])"
    finished = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert (finished.returncode, finished.stderr) == (0, b"")
