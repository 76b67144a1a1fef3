"""Start the dashboard in a browser: ``atleak app``."""

from __future__ import annotations

import argparse
import errno
import http.client
import os
import subprocess
import sys
import webbrowser
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from atleak.cli.parser import add_command
from atleak.errors import InputError
from atleak.sentence import Sentence
from atleak.system.reasons import reason_of
from atleak.system.shipped import shipped

PORT = 8501  # streamlit's own
_HERE = "127.0.0.1"
_PATIENCE = 2.0  # [s]
_PORTS = range(1, 65536)


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands, "app", run, "the dashboard in a browser", examples=("app", "app --port 8600"), quiet=False
    )
    help = f"at which it answers: the first free one from {PORT} on unless given"
    parser.add_argument("--port", metavar="N", type=port_number, help=help)
    help = f"of this machine at which it answers: {_HERE}, which no other machine reaches, unless given"
    parser.add_argument("--address", metavar="A", default=_HERE, help=help)


def run(options: argparse.Namespace) -> int:
    """Start the server; it runs until somebody ends it."""
    return _start(options.address, options.port)


def open_page(port: int, query: Mapping[str, str]) -> int:
    """Print the address of a page of the dashboard; show it in a browser, or start the dashboard where it is not up."""
    address = f"http://{_HERE}:{port}/?{urlencode(query)}"
    print(address, flush=True)
    if not _is_up(port):
        return _start(_HERE, port, "--server.headless", "true")  # or else a browser would open at another page
    webbrowser.open(address)
    return 0


def _is_up(port: int) -> bool:
    """Return whether a dashboard answers at a port of this machine."""
    import urllib.request

    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    try:
        with opener.open(f"http://{_HERE}:{port}/_stcore/health", timeout=_PATIENCE) as answer:
            return bool(answer.status == 200)
    except (OSError, http.client.HTTPException):
        return False


def _start(address: str, port: int | None, *options: str) -> int:
    if find_spec("streamlit") is None:
        expected = Sentence("{command}", command="python -m pip install streamlit")
        raise InputError(Sentence("the dashboard needs streamlit"), expected=expected)
    _check_free(address, port)
    app = shipped("app.py")
    command = [sys.executable, "-m", "streamlit", "run", str(app), "--server.address", address, *options]
    if port is not None:
        command += ["--server.port", str(port)]
    return _serve(command, app.parent)


def port_number(text: str) -> int:
    """Read a port."""
    if not text.isdecimal() or int(text) not in _PORTS:
        raise argparse.ArgumentTypeError(f"{text!r} is no port: write a whole number from 1 to {_PORTS[-1]}")
    return int(text)


def _check_free(address: str, port: int | None) -> None:
    """Refuse an address or a port that cannot be served; without a port the server looks for a free one."""
    import socket

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


def _serve(command: list[str], folder: Path) -> int:
    """Run the server in the dashboard's own folder, which holds its configuration."""
    if os.name == "posix":  # the server replaces this process, so that ending this one ends the server
        os.chdir(folder)
        os.execv(command[0], command)
    return subprocess.call(command, cwd=folder)
