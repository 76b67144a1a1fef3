"""Measure the dashboard under load: sessions that change a control every ten seconds, without browsers.

    python benchmarks/sessions.py [--small] [--sessions 20] [--seconds 180] [--pause 10]

Each session is a websocket client of Streamlit's own protocol, on one of the pages, and types another temperature,
engine speed or mileage into the sidebar, of its own, so that no session finds what another one computed. Prints, with
the goals:

- the time from a change until its rerun has ended, median (goal 1 s) and the 95th of 100 (goal 3 s), and the CPU time
  of the server for each; beside it the same of a bare Streamlit app, whose ratio tells the machine from the dashboard;
- the server's memory: after one session that visited every page was left and forgotten, with all sessions, and after
  all of them were (goal 1.3 times the first).

The load of the machine stands beside: on one that does something else, the ratio alone says something.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import cycle
from pathlib import Path

import websockets
from servers import Server
from streamlit.proto.BackMsg_pb2 import BackMsg
from streamlit.proto.ForwardMsg_pb2 import ForwardMsg
from timing import options

OPTIONS = options(__doc__)
OPTIONS.add_argument("--sessions", type=int, default=20)
OPTIONS.add_argument("--seconds", type=float, default=180.0, help="how long the sessions change controls")
OPTIONS.add_argument("--pause", type=float, default=10.0, help="seconds between two changes of a session")
SMALL = {"sessions": 2, "seconds": 4.0, "pause": 2.0}

BARE = """import streamlit

number = streamlit.text_input("Temperature [°C]", "80")
streamlit.write(f"{number} °C")
"""
PAGES = ("Diagnosis", "Measure", "In_the_car", "Plan", "Report", "Library")
FIELDS: dict[str, Callable[[int], str]] = {  # label, and what is typed at a change of all changes of a run
    "Temperature": lambda change: f"{70 + change * 0.037 % 40:.3f}",
    "Engine speed": lambda change: f"{700 + change % 1500}",
    "Mileage": lambda change: f"{90_000 + 7 * change}",
}
GOALS = {"median": 1.0, "95 of 100": 3.0}  # [s]
MEMORY_GOAL = 1.3
TTL = 20  # [s] after which a session that was left is forgotten; Streamlit's own two minutes would only take longer
SETTLING = 45.0  # [s] in which the server notices, and gives memory back
PATIENCE = 120.0  # [s] for one rerun


@dataclass
class Session:
    """A visitor without a browser: keeps what was typed into which field, and which messages it knows by their hash."""

    address: str
    page: str
    fields: dict[str, str] = field(default_factory=dict)  # id by label
    typed: dict[str, str] = field(default_factory=dict)  # value by id
    known: set[str] = field(default_factory=set)

    async def __aenter__(self) -> Session:
        where = self.address.replace("http", "ws", 1)
        self.socket = await websockets.connect(
            f"{where}/_stcore/stream", origin=self.address, subprotocols=["streamlit"], max_size=None, compression=None
        )
        await self.rerun()
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.socket.close()

    async def rerun(self) -> float:
        """Ask for a run of the page, and return how long it took [s]."""
        asked = BackMsg()
        state = asked.rerun_script
        state.page_name, state.query_string = self.page, ""
        state.context_info.locale, state.context_info.url = "en", f"{self.address}/{self.page}"
        state.cached_message_hashes.extend(self.known)
        for id, text in self.typed.items():
            widget = state.widget_states.widgets.add()
            widget.id, widget.string_value = id, text
        start = time.perf_counter()
        await self.socket.send(asked.SerializeToString())
        await asyncio.wait_for(self._until_the_end(), PATIENCE)
        return time.perf_counter() - start

    async def change(self, label: str, text: str) -> float:
        id = next(id for shown, id in self.fields.items() if shown.startswith(label))
        self.typed[id] = text
        return await self.rerun()

    async def _until_the_end(self) -> None:
        while True:
            message = ForwardMsg.FromString(await self.socket.recv())
            kind = message.WhichOneof("type")
            if message.metadata.cacheable:
                self.known.add(message.hash)
            if kind == "delta" and message.delta.new_element.WhichOneof("type") == "text_input":
                shown = message.delta.new_element.text_input
                self.fields[shown.label] = shown.id
            elif kind == "delta" and message.delta.new_element.WhichOneof("type") == "exception":
                raise SystemExit(f"{self.page}: {message.delta.new_element.exception.message}")
            elif kind == "script_finished" and message.script_finished == ForwardMsg.FINISHED_SUCCESSFULLY:
                return


async def under_load(server: Server, pages: tuple[str, ...], chosen: argparse.Namespace) -> tuple[list[float], float]:
    """Return how long the reruns took [s] while all sessions changed controls, and what one took of the CPU [s]."""
    numbers, times = iter(range(10**9)), []

    async def visit(number: int, page: str) -> None:
        async with Session(server.address, page) as session:
            ready.release()
            await started.wait()
            next_at = time.perf_counter() + chosen.pause * number / chosen.sessions
            while next_at < end:
                await asyncio.sleep(max(0.0, next_at - time.perf_counter()))
                change = next(numbers)
                labels = [label for label in FIELDS if any(shown.startswith(label) for shown in session.fields)]
                label = labels[change % len(labels)]
                times.append(await session.change(label, FIELDS[label](change)))
                next_at = max(next_at + chosen.pause, time.perf_counter())
            left.release()
            await over.wait()

    ready, left = asyncio.Semaphore(0), asyncio.Semaphore(0)
    started, over, end = asyncio.Event(), asyncio.Event(), float("inf")
    tasks = [asyncio.create_task(visit(number, page)) for number, page in zip(range(chosen.sessions), cycle(pages))]
    for _ in tasks:
        await ready.acquire()
    end, cpu = time.perf_counter() + chosen.seconds, server.cpu()
    started.set()
    for _ in tasks:
        await left.acquire()
    cpu = server.cpu() - cpu
    print(f"    memory with {chosen.sessions} sessions: {server.memory():.0f} MB")
    over.set()
    await asyncio.gather(*tasks)
    return times, cpu / len(times)


async def warmed(server: Server, pages: tuple[str, ...]) -> None:
    """Let one session visit every page and change every control, and leave."""
    for page in pages:
        async with Session(server.address, page) as session:
            for label, typed in FIELDS.items():
                if any(shown.startswith(label) for shown in session.fields):
                    await session.change(label, typed(3))


def measured(server: Server, pages: tuple[str, ...], chosen: argparse.Namespace) -> list[float]:
    """Print what a server takes for sessions; return how long the reruns took [s]."""
    asyncio.run(warmed(server, pages))
    time.sleep(0 if chosen.small else TTL + SETTLING)
    before = server.memory()
    print(f"    memory after one session has left: {before:.0f} MB")
    times, cpu = asyncio.run(under_load(server, pages, chosen))
    ordered = sorted(times)
    found = {"median": statistics.median(ordered), "95 of 100": ordered[int(0.95 * (len(ordered) - 1))]}
    said = "   ".join(f"{name} {value:.2f} s (goal {GOALS[name]})" for name, value in found.items())
    print(f"    {len(times)} reruns: {said}   longest {ordered[-1]:.2f} s   CPU {cpu:.3f} s each")
    time.sleep(0 if chosen.small else TTL + SETTLING)
    after = server.memory()
    print(f"    memory after all have left: {after:.0f} MB, {after / before:.2f} times (goal {MEMORY_GOAL})")
    return times


def main(chosen: argparse.Namespace) -> None:
    if chosen.small:
        for name, value in SMALL.items():
            setattr(chosen, name, value)
    print(f"{chosen.sessions} sessions, a change every {chosen.pause:.0f} s, for {chosen.seconds:.0f} s")
    medians = {}
    with tempfile.TemporaryDirectory() as folder:
        bare = Path(folder) / "bare.py"
        bare.write_text(BARE, encoding="utf-8")
        forgets = {"disconnected_session_ttl": str(TTL)}
        command, home = [sys.executable, "-m", "streamlit", "run", str(bare)], Path(folder) / "home"
        kinds: dict[str, tuple[Callable[[], Server], tuple[str, ...]]] = {
            "a bare Streamlit app": (lambda: Server(command, Path(folder), **forgets), ("",)),
            "atleak": (lambda: Server.of_atleak(home, **forgets), PAGES),
        }
        for name, (start, pages) in kinds.items():
            print(f"  {name}; load of the machine {os.getloadavg()[0]:.1f}")
            with start() as server:
                medians[name] = statistics.median(measured(server, pages, chosen))
        print(f"  load of the machine {os.getloadavg()[0]:.1f}")
    first, own = medians.values()
    print(f"  median of atleak over that of the bare app: {own / first:.0f}")


if __name__ == "__main__":
    main(OPTIONS.parse_args())
