"""Start the dashboard in a browser: ``atleak app``."""

from __future__ import annotations

import argparse
import errno
import os
import socket
import subprocess
import sys
import webbrowser
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from atleak.cli.parser import add_command
from atleak.common.access import ALLOWED, answered_names, is_here_alone
from atleak.common.errors import InputError, extra_installed, reason_of
from atleak.common.files import DATABASE_URL, HOME, home, shipped
from atleak.common.sentences import Sentence

PORT = 8501  # streamlit's own
_HERE = "127.0.0.1"
_PATIENCE = 2.0  # [s]
_PORTS = range(1, 65536)
_SECRETS, _ALLOWED = "secrets.toml", "allowed.toml"
# Else the GNU C library gives every thread, of which each run of a page has its own, memory that it keeps for that one.
_SPARING = {"MALLOC_ARENA_MAX": "2"}
_INTERNET = (socket.AF_INET, socket.AF_INET6)


def add_parser(commands: Any, name: str) -> None:
    """Add the command."""
    examples = ("app", "app --port 8600", "app --address 0.0.0.0", "app --host atleak.shop.example")
    parser = add_command(commands, name, run, examples=examples, quiet=False)
    help = f"at which it answers: the first free one from {PORT} on unless given"
    parser.add_argument("--port", metavar="N", type=port_number, help=help)
    help = f"of this machine at which it answers: {_HERE}, which no other machine reaches, unless given"
    parser.add_argument("--address", metavar="A", default=_HERE, help=help)
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
    server = shipped("serve.py")
    command = [sys.executable, "-m", "streamlit", "run", str(server), "--server.address", address, *reach]
    if port is not None:
        command += ["--server.port", str(port)]
    return _serve(command, server.parent, {**_SPARING, **os.environ, **_places(), ALLOWED: allowed})


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
