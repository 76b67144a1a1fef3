"""Run a PostgreSQL server of one's own for a while: on loopback, in a temporary folder, gone afterwards."""

from __future__ import annotations

import contextlib
import os
import secrets
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psycopg
from psycopg import sql

DEBIAN = Path("/usr/lib/postgresql")
ACCOUNT = "postgres"  # the server refuses to run as root; Debian's package makes this account
START = 60.0  # [s] until the server must answer
# What is written need not outlive a power cut: three times as many small commits a second.
NOT_DURABLE = ("fsync=off", "synchronous_commit=off", "full_page_writes=off")


class NoServer(Exception):
    """PostgreSQL's server is not installed here."""


@dataclass(frozen=True)
class Server:
    """A running server, whose only user may do everything."""

    port: int
    process: subprocess.Popen[bytes]

    def address(self, database: str) -> str:
        """Return a database's address as atleak takes it."""
        return f"postgresql+psycopg://atleak@127.0.0.1:{self.port}/{database}"

    def connect(self) -> psycopg.Connection[Any]:
        """Connect to the server itself, outside of any transaction."""
        return psycopg.connect(host="127.0.0.1", port=self.port, user="atleak", dbname="postgres", autocommit=True)

    def new_database(self) -> str:
        """Make an empty database and return its name."""
        name = f"book_{secrets.token_hex(6)}"
        with self.connect() as connection:
            connection.execute(sql.SQL("CREATE DATABASE {} TEMPLATE template0").format(sql.Identifier(name)))
        return name


def programs() -> Path:
    """Return the folder with the server's programs, of the newest version that is installed.

    Raises
    ------
    NoServer
        where there is none.
    """
    folders = [folder / "bin" for folder in DEBIAN.glob("*") if folder.name.isdecimal()]
    if folders := [folder for folder in folders if (folder / "initdb").is_file()]:
        return max(folders, key=lambda folder: int(folder.parent.name))
    if (command := shutil.which("initdb")) and shutil.which("postgres", path=Path(command).parent):
        return Path(command).parent
    raise NoServer(f"no PostgreSQL server in {DEBIAN} or on the path")


@contextlib.contextmanager
def running(*, durable: bool = False) -> Iterator[Server]:
    """Start a server and end it afterwards, with all its databases.

    Parameters
    ----------
    durable
        whether what is written must outlive a power cut, as it must at users'; costs time at every commit.

    Raises
    ------
    NoServer
        where PostgreSQL's server is not installed.
    """
    folder, account = programs(), _account()
    with tempfile.TemporaryDirectory(prefix="atleak-postgresql-", ignore_cleanup_errors=True) as place:
        if account:
            shutil.chown(place, ACCOUNT, ACCOUNT)
        data = Path(place) / "data"
        making = [folder / "initdb", "-D", data, "-U", "atleak", "-A", "trust", "-E", "UTF8", "--locale=C", "--no-sync"]
        subprocess.run(making, check=True, capture_output=True, cwd=place, **account)
        port = _free_port()
        command = [folder / "postgres", "-D", data, "-h", "127.0.0.1", "-p", str(port)]
        settings = ["unix_socket_directories=", "shared_buffers=32MB", *(() if durable else NOT_DURABLE)]
        command += [word for setting in settings for word in ("-c", setting)]
        with (Path(place) / "server.log").open("wb") as log:
            process = subprocess.Popen(command, cwd=place, stdout=log, stderr=subprocess.STDOUT, **account)
        server = Server(port, process)
        try:
            _wait(server, Path(place) / "server.log")
            yield server
        finally:
            process.send_signal(getattr(signal, "SIGQUIT", signal.SIGTERM))  # at once: nobody reads it again
            process.wait(timeout=START)


def _account() -> dict[str, Any]:
    if not hasattr(os, "geteuid") or os.geteuid() != 0:
        return {}
    return {"user": ACCOUNT, "group": ACCOUNT, "extra_groups": []}


def _free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def _wait(server: Server, log: Path) -> None:
    limit = time.monotonic() + START
    while time.monotonic() < limit and server.process.poll() is None:
        with contextlib.suppress(psycopg.OperationalError), server.connect():
            return
        time.sleep(0.02)
    raise RuntimeError(f"the server did not answer: {log.read_text(encoding='utf-8', errors='replace')[-2000:]}")
