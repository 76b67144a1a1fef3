"""The dashboard's command."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
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


# --- a window of its own


class Machine:
    """Servers and browsers as they would be started; each is a process that waits, or ends as a test says."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.started: list[list[str]] = []
        self.environment: Mapping[str, str] = {}
        self.tabs: list[str] = []
        self.up = True
        self.window = "import time; time.sleep(0.3)"  # what the browser does
        self.processes: list[subprocess.Popen[bytes]] = []
        monkeypatch.setattr(app, "_started", self.start)
        monkeypatch.setattr(app, "_is_up", lambda _: self.up)
        monkeypatch.setattr(app, "_browser", lambda: self.browser)
        monkeypatch.setattr(app, "_SOON", 0.1)
        monkeypatch.setattr(app.webbrowser, "open", self.tabs.append)
        self.browser: str | None = "chromium"
        self.server = "import time; time.sleep(60)"

    def start(self, command: list[str], **settings: object) -> subprocess.Popen[bytes]:
        self.started.append(command)
        of_server = command[0] == sys.executable
        if of_server:
            self.environment = settings["env"]  # type: ignore[assignment]
        program = self.server if of_server else self.window
        # what is started is known by its command, as a server is
        self.processes.append(subprocess.Popen([sys.executable, "-c", program, *command]))
        return self.processes[-1]

    @property
    def opened(self) -> list[str]:
        """The addresses that windows were opened at."""
        return [each.removeprefix("--app=") for command in self.started for each in command if each[:6] == "--app="]


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> Iterator[Machine]:
    now = Machine(monkeypatch)
    yield now
    for process in now.processes:
        process.kill()
        process.wait()


def test_the_server_ends_with_its_window(run: Run, machine: Machine, own_home: Path) -> None:
    status, out, _ = run("app", "--window")
    (address,) = machine.opened
    assert (status, out) == (0, f"{address}\n")
    server, window = machine.processes
    assert server.poll() is not None
    assert window.returncode == 0
    assert f"--user-data-dir={own_home / 'window' / 'profile'}" in machine.started[1]
    assert [path.name for path in (own_home / "window").iterdir()] == ["server.log"]


def test_a_port_that_is_taken_is_passed_over(run: Run, machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        taken = other.getsockname()[1]
        monkeypatch.setattr(app, "PORT", taken)
        assert run("app", "--window")[0] == 0
        (address,) = machine.opened
        assert int(address.rpartition(":")[2]) > taken
        assert run("app", "--window", "--port", taken)[0] == 2


def test_a_second_start_opens_a_window_of_the_first(run: Run, machine: Machine, own_home: Path) -> None:
    note = own_home / "window" / "server"
    note.parent.mkdir(parents=True)
    first = machine.start([sys.executable, str(app.shipped("serve.py"))], env={})
    note.write_text(f"8765 {first.pid}", encoding="utf-8")
    assert run("app", "--window") == (0, "http://127.0.0.1:8765\n", "")
    assert machine.opened == ["http://127.0.0.1:8765"]
    assert len(machine.started) == 2  # no second server
    assert note.is_file()


@pytest.mark.parametrize("left", ["", "8765 4000000", "8765 {own}", "8765 x"])
def test_a_note_that_was_left_is_no_dashboard(
    run: Run, machine: Machine, own_home: Path, left: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(app, "_SOON", 0.0)
    note = own_home / "window" / "server"
    note.parent.mkdir(parents=True)
    note.write_text(left.format(own=os.getpid()), encoding="utf-8")  # of a process that is another program now
    assert run("app", "--window")[0] == 0
    assert machine.opened != ["http://127.0.0.1:8765"]
    assert not note.exists()


def test_without_such_a_browser_it_is_a_tab_and_the_server_ends_by_itself(run: Run, machine: Machine) -> None:
    machine.browser, machine.server = None, "import time; time.sleep(0.5)"
    assert run("app", "--window")[0] == 0
    assert machine.opened == []
    assert len(machine.tabs) == 1
    assert machine.environment["ATLEAK_ENDS_AFTER"] == "600"


def test_a_browser_that_cannot_start_leaves_a_tab(run: Run, machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(app, "_SOON", 30.0)
    machine.window, machine.server = "import sys; sys.exit(1)", "import time; time.sleep(1.5)"
    assert run("app", "--window")[0] == 0
    assert machine.tabs == machine.opened
    assert machine.environment["ATLEAK_ENDS_AFTER"] == "600"


def test_the_note_of_another_start_stays(
    run: Run, machine: Machine, own_home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    note = own_home / "window" / "server"
    monkeypatch.setattr(app, "_open", lambda *_: note.write_text("8765 4000000 4000001", encoding="utf-8") and None)
    machine.server = ""
    assert run("app", "--window")[0] == 0
    assert note.read_text(encoding="utf-8") == "8765 4000000 4000001"


def test_a_browser_that_hands_its_window_on_leaves_the_server(
    run: Run, machine: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(app, "_SOON", 30.0)
    machine.window, machine.server = "", "import time; time.sleep(1.5)"
    assert run("app", "--window")[0] == 0
    assert machine.processes[0].returncode == 0  # ended by itself
    assert machine.tabs == []


def test_a_server_that_does_not_start_names_its_log(run: Run, machine: Machine, own_home: Path) -> None:
    machine.up, machine.server = False, ""
    status, _, err = run("app", "--window")
    assert status == 2
    assert f"the dashboard did not start; {own_home / 'window' / 'server.log'} says why" in err


@pytest.mark.parametrize(
    "others",
    [
        ("--address", "0.0.0.0"),
        ("--address", "::1"),
        ("--address", "localhost"),
        ("--host", "x.example", "--without-login"),
        ("--host", "localhost"),
        ("--secrets", "x.toml"),
    ],
)
def test_a_window_is_for_this_machine_alone(run: Run, machine: Machine, others: tuple[str, ...]) -> None:
    status, _, err = run("app", "--window", *others)
    assert (status, machine.started) == (2, [])
    assert "--window is for this machine alone" in err


def test_the_browsers_of_each_system_are_looked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    edge = tmp_path / "Microsoft" / "Edge" / "Application" / "msedge.exe"
    edge.parent.mkdir(parents=True)
    edge.touch()
    monkeypatch.setattr(app.shutil, "which", lambda name: f"/usr/bin/{name}" if name == "chromium" else None)
    monkeypatch.setattr(app.sys, "platform", "linux")
    assert app._browser() == "/usr/bin/chromium"
    monkeypatch.setattr(app.sys, "platform", "win32")
    monkeypatch.setenv("PROGRAMFILES", str(tmp_path))
    assert app._browser() == str(edge)
