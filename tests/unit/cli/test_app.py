"""The dashboard's command."""

from __future__ import annotations

import socket
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import pytest

from atleak.cli import app
from tests.unit.common.test_admission import secrets_of

Run = Callable[..., tuple[int, str, str]]


@dataclass
class Served:
    """What would have been started, and how."""

    commands: list[list[str]] = field(default_factory=list)
    folder: Path = Path()
    allowed: str = "?"
    environment: Mapping[str, str] = field(default_factory=dict)

    def start(self, command: list[str], folder: Path, environment: Mapping[str, str]) -> int:
        self.commands.append(command)
        self.folder, self.allowed, self.environment = folder, environment["ATLEAK_ALLOWED"], environment
        return 0

    def given(self, option: str) -> list[str]:
        """What the last command says of an option of the server."""
        command = self.commands[-1]
        return [value for name, value in pairwise(command) if name == option]


@pytest.fixture
def served(monkeypatch: pytest.MonkeyPatch) -> Served:
    """The servers that would have been started."""
    now = Served()
    monkeypatch.setattr(app, "_serve", now.start)
    return now


@pytest.fixture
def sign_in(own_home: Path) -> Path:
    """The user's folder, with files that say who signs in, and with whom."""
    own_home.mkdir()
    secrets_of(own_home)
    (own_home / "allowed.toml").write_text('users = ["ana@shop.example"]', encoding="utf-8")
    (own_home / "allowed.toml").chmod(0o600)
    return own_home


def test_app_serves_this_machine_alone_unless_told(run: Run, served: Served) -> None:
    assert run("app")[0] == 0
    assert served.given("--server.address") == ["127.0.0.1"]
    assert served.given("--server.port") == served.given("--server.allowedHosts") == []
    assert (served.folder / "app.py").is_file()
    assert (served.folder / served.commands[0][4]).name == "serve.py"
    assert served.allowed == ""


def test_the_dashboard_works_in_the_book_that_other_commands_use(
    run: Run, served: Served, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its server runs in a folder of its own, in which a relative path means another file."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ATLEAK_HOME", "shopdata")
    assert run("app")[0] == 0
    assert served.environment["ATLEAK_HOME"] == str(tmp_path / "shopdata")
    monkeypatch.setenv("ATLEAK_DATABASE_URL", "sqlite:///shop.sqlite")
    assert run("app")[0] == 0
    assert served.environment["ATLEAK_DATABASE_URL"] == f"sqlite:///{tmp_path / 'shop.sqlite'}"
    for url in ("postgresql://shop:p%40ss@server/book?sslmode=require", "mysql://shop@server/book"):
        monkeypatch.setenv("ATLEAK_DATABASE_URL", url)
        assert run("app")[0] == (0 if url.startswith("postgresql") else 2)
    assert served.environment["ATLEAK_DATABASE_URL"] == ("postgresql+psycopg://shop:p%40ss@server/book?sslmode=require")


def test_app_serves_the_network_to_those_on_the_list(run: Run, served: Served, sign_in: Path) -> None:
    assert run("app", "--address", "0.0.0.0", "--port", "8600") == (0, "", "")
    assert served.given("--server.address") == ["0.0.0.0"]
    assert served.given("--server.port") == ["8600"]
    assert served.given("--secrets.files") == [str(sign_in / "secrets.toml")]
    assert served.allowed == str(sign_in / "allowed.toml")
    names = served.given("--server.allowedHosts")
    assert {"atleak.shop.example", "localhost", socket.gethostname().casefold()} <= set(names)
    assert "*" not in names
    # without a name of its own Streamlit asks a server outside for the address of this network
    assert served.given("--browser.serverAddress") == ["atleak.shop.example"]


@pytest.mark.parametrize("others", [("--address", "0.0.0.0"), ("--host", "atleak.shop.example")])
def test_app_does_not_serve_others_before_it_knows_who_may_use_it(
    run: Run, served: Served, sign_in: Path, others: tuple[str, str]
) -> None:
    (sign_in / "allowed.toml").unlink()
    status, _, err = run("app", *others)
    assert (status, served.commands) == (2, [])
    assert "allowed.toml: cannot be read: No such file" in err
    (sign_in / "secrets.toml").unlink()
    status, _, err = run("app", *others)
    assert (status, served.commands) == (2, [])
    assert "secrets.toml: cannot be read: No such file" in err
    assert "--without-login" in err
    assert run("app", *others, "--without-login")[0] == 0
    assert served.allowed == ""
    assert "localhost" in served.given("--server.allowedHosts")


def test_files_of_who_signs_in_may_be_named_also_for_this_machine_alone(
    run: Run, served: Served, sign_in: Path, tmp_path: Path
) -> None:
    named = (sign_in / "allowed.toml").rename(tmp_path / "who.toml")
    assert run("app", "--allowed", str(named))[0] == 0
    assert served.allowed == str(named)
    assert run("app", "--allowed", str(named), "--without-login")[0] == 2


def test_signing_in_without_its_libraries_says_what_to_install(
    run: Run, served: Served, sign_in: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(app, "find_spec", lambda name: None if name == "authlib" else name)
    status, _, err = run("app", "--address", "0.0.0.0")
    assert (status, served.commands) == (2, [])
    assert 'python -m pip install ".[auth]"' in err
    assert "Authlib" in err


def test_app_without_streamlit_says_what_to_install(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(app, "find_spec", lambda name: None)
    status, _, err = run("app")
    assert status == 2
    assert "pip install streamlit" in err


@pytest.mark.parametrize("port", ["0", "-1", "65536", "99999", "8600.5", "http", ""])
def test_a_port_that_is_none_is_a_fault_of_usage(run: Run, served: Served, port: str) -> None:
    status, out, err = run("app", f"--port={port}")
    assert (status, out, served.commands) == (2, "", [])
    assert f"argument --port: {port!r} is no port: write a whole number from 1 to 65535" in err


def test_a_port_in_use_says_so(run: Run, served: Served) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        status, _, err = run("app", "--port", port)
        assert (status, served.commands) == (2, [])
        assert f"--port is in use by another program (found {port})" in err
    assert run("app", "--port", port)[0] == 0
    assert served.commands[0][-1] == str(port)


@pytest.mark.parametrize("address", ["192.0.2.1", "nowhere.invalid", "a" * 64 + ".invalid"])
def test_an_address_of_another_machine_is_refused(run: Run, served: Served, address: str) -> None:
    status, _, err = run("app", "--address", address)
    assert (status, served.commands) == (2, [])
    assert f"--address is no address of this machine (found {address!r})" in err
