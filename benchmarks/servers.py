"""Provide a Streamlit server in a process of its own, for the benchmarks that visit one."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path
from typing import Self

import psutil

ROOT = Path(__file__).resolve().parents[1]
COMPILED = Path(tempfile.gettempdir()) / "atleak-benchmark-compiled"
PATIENCE = 120.0  # [s]


class Server:
    """A Streamlit server in a process of its own, with its CPU time and its memory."""

    def __init__(self, command: list[str], home: Path, page: str = "", **options: str) -> None:
        with socket.socket() as listener:
            listener.bind(("127.0.0.1", 0))
            port = listener.getsockname()[1]
        self.address, self.page = f"http://127.0.0.1:{port}", page
        home.mkdir(exist_ok=True)
        environment = {**os.environ, "ATLEAK_HOME": str(home), "PYTHONPATH": str(ROOT)}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)  # an installed package is compiled
        environment["PYTHONPYCACHEPREFIX"] = str(COMPILED)
        options = {"port": str(port), "headless": "true", "address": "127.0.0.1", **options}
        environment |= {f"STREAMLIT_SERVER_{name.upper()}": value for name, value in options.items()}
        environment["STREAMLIT_BROWSER_GATHER_USAGE_STATS"] = "false"
        environment["STREAMLIT_SERVER_FILE_WATCHER_TYPE"] = "none"
        self._process = psutil.Popen(
            [*command, "--server.port", str(port)] if "streamlit" in command else [*command, "--port", str(port)],
            cwd=home,
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    @classmethod
    def of_atleak(cls, home: Path, page: str = "", **options: str) -> Self:
        """Start the dashboard as users do, with an empty folder of the user's own."""
        return cls([sys.executable, "-m", "atleak", "app"], home, page, **options)

    def __enter__(self) -> Self:
        limit = time.monotonic() + PATIENCE
        while time.monotonic() < limit and self._process.is_running():
            try:
                with urllib.request.urlopen(f"{self.address}/_stcore/health", timeout=2) as answer:
                    if answer.status == 200:
                        return self
            except OSError:
                time.sleep(0.1)
        self.__exit__()
        raise SystemExit("a server did not answer")

    def __exit__(self, *_: object) -> None:
        for process in (*self._process.children(recursive=True), self._process):
            process.terminate()
        self._process.wait(timeout=20)

    def _processes(self) -> list[psutil.Process]:
        return [self._process, *self._process.children(recursive=True)]

    def cpu(self) -> float:
        """Return the CPU time that it has taken so far, with the processes that it started [s]."""
        total = 0.0
        for process in self._processes():
            try:
                total += sum(process.cpu_times()[:4])
            except psutil.NoSuchProcess:
                continue  # it has just ended; the server counts it as one of its children
        return total

    def memory(self) -> float:
        """Return the memory that it holds [MB]."""
        return sum(process.memory_info().rss for process in self._processes() if process.is_running()) / 1e6
