"""Start the dashboard in a browser, or in a window of its own: ``atleak app``."""

from __future__ import annotations

import argparse
import errno
import os
import shutil
import socket
import subprocess
import sys
import time
import webbrowser
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from atleak.cli.parser import add_command
from atleak.common.access import ALLOWED, ENDS_AFTER, answered_names, is_here_alone
from atleak.common.errors import InputError, extra_installed, reason_of
from atleak.common.files import DATABASE_URL, HOME, home, made_folder, replace_file, shipped
from atleak.common.sentences import Sentence

PORT = 8501  # streamlit's own
_HERE = "127.0.0.1"
_PATIENCE = 2.0  # [s]
_PORTS = range(1, 65536)
_SECRETS, _ALLOWED = "secrets.toml", "allowed.toml"
# Else the GNU C library gives every thread, of which each run of a page has its own, memory that it keeps for that one,
# and threads of the linear algebra, whose matrices are small here, take a core each while they wait for one another.
_SPARING = {"MALLOC_ARENA_MAX": "2", "OPENBLAS_NUM_THREADS": "1"}
_LEFT = 600  # [s] without a connected page, after which the server of a window, or of a tab in its place, ends
_STARTS = 60.0  # [s] that a server may take to answer
_SOON = 5.0  # [s] within which a browser ends that cannot start, or that hands its window on to one that runs
# Browsers that show a page in a window of its own: programs on the PATH; in folders of Windows; in bundles of macOS.
_PROGRAMS = ("google-chrome", "google-chrome-stable", "chromium", "chromium-browser", "microsoft-edge", "brave-browser")
_ON_WINDOWS = ("Microsoft/Edge/Application/msedge.exe", "Google/Chrome/Application/chrome.exe")
_ON_MACOS = ("Google Chrome", "Microsoft Edge", "Chromium")
_INTERNET = (socket.AF_INET, socket.AF_INET6)


def add_parser(commands: Any, name: str) -> None:
    """Add the command."""
    examples = ("app", "app --window", "app --port 8600", "app --address 0.0.0.0", "app --host atleak.shop.example")
    parser = add_command(commands, name, run, examples=examples, quiet=False)
    help = f"at which it answers: the first free one from {PORT} on unless given"
    parser.add_argument("--port", metavar="N", type=port_number, help=help)
    help = f"of this machine at which it answers: {_HERE}, which no other machine reaches, unless given"
    parser.add_argument("--address", metavar="A", default=_HERE, help=help)
    help = "in a window of its own, where Edge, Chrome or Chromium is there, else in a tab; it ends with the window"
    parser.add_argument("--window", action="store_true", help=help)
    others = parser.add_argument_group("where other machines reach it (docs/network.md)")
    help = "a further name under which it answers, such as that of a proxy; may be repeated"
    others.add_argument("--host", metavar="NAME", action="append", default=[], help=help)
    help = f"TOML file that says with whom people sign in: {_SECRETS} in the user's folder unless given"
    others.add_argument("--secrets", metavar="FILE", type=Path, help=help)
    who = others.add_mutually_exclusive_group()
    help = f"TOML file that says who may use it: {_ALLOWED} in the user's folder unless given"
    who.add_argument("--allowed", metavar="FILE", type=Path, help=help)
    help = "let everybody use it who reaches it"
    who.add_argument("--without-login", action="store_true", help=help)


def run(options: argparse.Namespace) -> int:
    """Start the server; it runs until somebody ends it."""
    _check_streamlit()
    if options.window:
        if (options.address, options.host, options.allowed, options.secrets) != (_HERE, [], None, None):
            expected = Sentence("{command}, with no other option than --port", command="atleak app --window")
            raise InputError(Sentence("--window is for this machine alone"), expected=expected)
        return _in_window(options.port)
    _check_free(options.address, options.port)
    return _start(options.address, options.port, *_reach(options))


def _reach(options: argparse.Namespace) -> tuple[Sequence[str], str]:
    """Return options of the server, and the file of who may use it; "" where nobody has to sign in."""
    here_alone = all(map(is_here_alone, (options.address, *options.host)))
    signs_in = options.allowed is not None or options.secrets is not None
    if options.without_login or (here_alone and not signs_in):
        return () if here_alone else _answering(options.address, options.host), ""
    if find_spec("authlib") is None or find_spec("httpx") is None:
        raise InputError(Sentence("signing in needs Authlib and httpx"), expected=extra_installed("auth"))
    from atleak.common.sign_in import read_allowed, read_sign_in

    secrets = (options.secrets or home() / _SECRETS).resolve()
    allowed = (options.allowed or home() / _ALLOWED).resolve()
    name = read_sign_in(secrets)
    read_allowed(allowed)
    answering = _answering(options.address, [*options.host, name])
    return (*answering, "--secrets.files", str(secrets)), str(allowed)


def _answering(address: str, named: Sequence[str]) -> list[str]:
    """Return the server's options for a dashboard that other machines reach; it opens no browser."""
    import psutil

    addresses = [each.address for card in psutil.net_if_addrs().values() for each in card if each.family in _INTERNET]
    names = answered_names(address, addresses, named)
    allowed = [option for name in names for option in ("--server.allowedHosts", name)]
    return [*allowed, "--browser.serverAddress", names[0], "--server.headless", "true"]


def open_page(port: int, query: Mapping[str, str]) -> int:
    """Print the address of a page of the dashboard; show it in a browser, or start the dashboard where it is not up."""
    address = f"http://{_HERE}:{port}/?{urlencode(query)}"
    print(address, flush=True)
    if not _is_up(port):
        _check_streamlit()
        _check_free(_HERE, port)
        return _start(_HERE, port, ["--server.headless", "true"])  # else a browser would open at another page
    webbrowser.open(address)
    return 0


def _is_up(port: int) -> bool:
    """Return whether a dashboard answers at a port of this machine."""
    import http.client
    import urllib.request

    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    try:
        with opener.open(f"http://{_HERE}:{port}/_stcore/health", timeout=_PATIENCE) as answer:
            return bool(answer.status == 200)
    except (OSError, http.client.HTTPException):
        return False


def _check_streamlit() -> None:
    if find_spec("streamlit") is None:
        expected = Sentence("{command}", command="python -m pip install streamlit")
        raise InputError(Sentence("the dashboard needs streamlit"), expected=expected)


def _start(address: str, port: int | None, reach: Sequence[str], allowed: str = "") -> int:
    return _serve(*_server(address, port, reach, allowed))


def _server(
    address: str, port: int | None, reach: Sequence[str], allowed: str = ""
) -> tuple[list[str], Path, dict[str, str]]:
    """Return the command of the server, the folder in which it runs, and its environment."""
    server = shipped("serve.py")
    command = [sys.executable, "-m", "streamlit", "run", str(server), "--server.address", address, *reach]
    if port is not None:
        command += ["--server.port", str(port)]
    return command, server.parent, {**_SPARING, **os.environ, **_places(), ALLOWED: allowed}


def _places() -> dict[str, str]:
    """Return where the environment says that the job book is, for a server that runs in a folder of its own."""
    places = {HOME: str(home())} if os.environ.get(HOME) else {}
    if os.environ.get(DATABASE_URL):
        from atleak.job_book.database import database_url

        places[DATABASE_URL] = database_url().render_as_string(hide_password=False)
    return places


def port_number(text: str) -> int:
    """Read a port."""
    if not text.isdecimal() or int(text) not in _PORTS:
        raise argparse.ArgumentTypeError(f"{text!r} is no port: write a whole number from 1 to {_PORTS[-1]}")
    return int(text)


def _check_free(address: str, port: int | None) -> None:
    """Refuse an address or a port that cannot be served; without a port the server looks for a free one."""
    try:
        addresses = socket.getaddrinfo(address, port or 0, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, kind, protocol, _, place = addresses[0]
        with socket.socket(family, kind, protocol) as tried:
            if os.name == "posix":  # ignore a connection just closed; on Windows this would ignore every conflict
                tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            tried.bind(place)
    except (socket.gaierror, UnicodeError) as error:
        raise _no_address(address) from error
    except OSError as error:
        if error.errno == errno.EADDRNOTAVAIL:
            raise _no_address(address) from error
        if error.errno == errno.EADDRINUSE:
            problem = Sentence("--port is in use by another program")
            expected = Sentence("another --port; is the dashboard running already?")
            raise InputError(problem, value=port, expected=expected) from error
        problem = Sentence("--port cannot be served: {reason}", reason=reason_of(error))
        raise InputError(problem, value=port, expected=Sentence("another --port, from 1024 up")) from error


def _no_address(address: str) -> InputError:
    expected = Sentence("127.0.0.1 for this machine alone, 0.0.0.0 for every machine of its network")
    return InputError(Sentence("--address is no address of this machine"), value=address, expected=expected)


def _serve(command: list[str], folder: Path, environment: Mapping[str, str]) -> int:
    """Run the server in the dashboard's own folder, which holds its configuration."""
    if os.name == "posix":  # the server replaces this process, so that ending this one ends the server
        os.chdir(folder)
        os.execve(command[0], command, environment)
    return subprocess.call(command, cwd=folder, env=environment)


# --- a window of its own


def _in_window(port: int | None) -> int:
    """Serve the dashboard as long as its window is open; where one is open already, open another one of that.

    The note beside the browser's profile says which: the port, and the processes of its server and of its start.
    """
    folder = made_folder(home() / "window")
    note = folder / "server"
    while True:
        with suppress(FileExistsError), note.open("x", encoding="utf-8") as stream:
            stream.write(f"{os.getpid()}")
            break
        if (running := _running(note)) is not None:
            _open(folder, running)
            return 0
        note.unlink(missing_ok=True)  # of one that ended without a word
    try:
        return _until_closed(folder, note, port)
    finally:
        with suppress(FileNotFoundError):
            if note.read_text(encoding="utf-8").split()[-1:] == [f"{os.getpid()}"]:  # else it is another start's now
                note.unlink()


def _running(note: Path) -> int | None:
    """Return the port of the dashboard that a note tells of, once it answers; None where it runs no more."""
    import psutil

    until = time.monotonic() + _STARTS
    while time.monotonic() < until:
        try:
            words = note.read_text(encoding="utf-8").split()
            old = time.time() - note.stat().st_mtime > _SOON
        except FileNotFoundError:
            return None
        if len(words) > 1:
            try:
                command = psutil.Process(int(words[1])).cmdline()
            except (psutil.Error, ValueError):
                return None
            if str(shipped("serve.py")) not in command:
                return None
            if _is_up(int(words[0])):
                return int(words[0])
        elif old:
            return None
        time.sleep(0.1)
    return None


def _until_closed(folder: Path, note: Path, port: int | None) -> int:
    """Start a server, open its window, and end the server when that is closed."""
    port = _free_port() if port is None else port
    _check_free(_HERE, port)
    command, place, environment = _server(_HERE, port, ["--server.headless", "true"])
    environment[ENDS_AFTER] = str(_LEFT)
    log = folder / "server.log"
    with log.open("wb") as stream:
        server = _started(command, stdout=stream, cwd=place, env=environment)
    try:
        replace_file(note, f"{port} {server.pid} {os.getpid()}".encode())  # another start reads it meanwhile
        until = time.monotonic() + _STARTS
        while not _is_up(port):
            if server.poll() is not None or time.monotonic() > until:
                problem = Sentence("the dashboard did not start; {file} says why", file=str(log))
                raise InputError(problem, expected=Sentence("{command} in a terminal", command="atleak app"))
            time.sleep(0.1)
        window, opened = _open(folder, port), time.monotonic()
        while server.poll() is None:
            if window is not None and window.poll() is not None:
                if time.monotonic() - opened > _SOON:
                    break
                if window.returncode:  # it cannot start
                    webbrowser.open(_address(port))
                window = None  # the server ends by itself when no page is connected any longer
            time.sleep(0.2)
    finally:
        server.terminate()
        server.wait()
    return 0


def _open(folder: Path, port: int) -> subprocess.Popen[bytes] | None:
    """Open a window, and return the browser of it; None where it is a tab of the usual browser."""
    browser, address = _browser(), _address(port)
    print(address, flush=True)
    if browser is None:
        webbrowser.open(address)
        return None
    profile = f"--user-data-dir={folder / 'profile'}"
    plainly = ("--no-first-run", "--no-default-browser-check", "--disable-background-mode", "--window-size=1366,900")
    return _started([browser, f"--app={address}", profile, *plainly], stdout=subprocess.DEVNULL)


def _started(command: list[str], **settings: Any) -> subprocess.Popen[bytes]:
    """Start a program that shows no console, and whose messages go where its output does."""
    hidden = getattr(subprocess, "CREATE_NO_WINDOW", 0)
    return subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stderr=subprocess.STDOUT, creationflags=hidden, **settings
    )


def _browser() -> str | None:
    """Return the first browser that shows a page in a window of its own."""
    return next(_browsers(), None)


def _browsers() -> Iterator[str]:
    if sys.platform == "win32":
        folders = [
            os.environ[name] for name in ("PROGRAMFILES(X86)", "PROGRAMFILES", "LOCALAPPDATA") if name in os.environ
        ]
        files = [Path(folder) / program for program in _ON_WINDOWS for folder in folders]
    else:
        files = [Path("/Applications") / f"{name}.app" / "Contents" / "MacOS" / name for name in _ON_MACOS]
    yield from (str(file) for file in files if file.is_file())
    yield from filter(None, map(shutil.which, _PROGRAMS))


def _address(port: int) -> str:
    return f"http://{_HERE}:{port}"


def _free_port() -> int:
    """Return the first free port."""
    for port in range(PORT, PORT + 100):
        with suppress(InputError):
            _check_free(_HERE, port)
            return port
    return PORT  # which then says that it is taken
