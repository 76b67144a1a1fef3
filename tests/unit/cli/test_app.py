"""The dashboard's command."""

from __future__ import annotations

import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from atleak.cli import app

Run = Callable[..., tuple[int, str, str]]


def test_app_serves_this_machine_alone_unless_told(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: dict[str, Any] = {}

    def serve(command: list[str], folder: Path) -> int:
        seen.update(command=command, cwd=folder)
        return 0

    monkeypatch.setattr(app, "_serve", serve)
    assert run("app")[0] == 0
    assert seen["command"][seen["command"].index("--server.address") + 1] == "127.0.0.1"
    assert "--server.port" not in seen["command"]
    assert (Path(seen["cwd"]) / "app.py").is_file()
    assert run("app", "--port", "8600", "--address", "0.0.0.0")[0] == 0
    assert seen["command"][-4:] == ["--server.address", "0.0.0.0", "--server.port", "8600"]


def test_app_without_streamlit_says_what_to_install(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(app, "find_spec", lambda name: None)
    status, _, err = run("app")
    assert status == 2
    assert "pip install streamlit" in err


@pytest.fixture
def served(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """The commands that would have started a server."""
    commands: list[list[str]] = []
    monkeypatch.setattr(app, "_serve", lambda command, folder: commands.append(command) or 0)
    return commands


@pytest.mark.parametrize("port", ["0", "-1", "65536", "99999", "8600.5", "http", ""])
def test_a_port_that_is_none_is_a_fault_of_usage(run: Run, served: list[list[str]], port: str) -> None:
    status, out, err = run("app", f"--port={port}")
    assert (status, out, served) == (2, "", [])
    assert f"argument --port: {port!r} is no port: write a whole number from 1 to 65535" in err


def test_a_port_in_use_says_so(run: Run, served: list[list[str]]) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        status, _, err = run("app", "--port", port)
        assert (status, served) == (2, [])
        assert f"--port is in use by another program (found {port})" in err
    assert run("app", "--port", port)[0] == 0
    assert served[0][-1] == str(port)


@pytest.mark.parametrize("address", ["192.0.2.1", "nowhere.invalid", "a" * 64 + ".invalid"])
def test_an_address_of_another_machine_is_refused(run: Run, served: list[list[str]], address: str) -> None:
    status, _, err = run("app", "--address", address)
    assert (status, served) == (2, [])
    assert f"--address is no address of this machine (found {address!r})" in err
