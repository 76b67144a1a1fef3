"""Let sessions go that were left, and end a server of one window that was.

Streamlit looks for sessions that nobody came back to only when another one ends.
"""

from __future__ import annotations

import asyncio
import signal
from typing import Any

import streamlit as st
from streamlit.runtime import RuntimeState

from atleak.common.memory import give_back

EVERY = 30.0  # [s]
LOOKS = 2.0  # [s]
_HELD = ("_session_state", "_fragment_storage", "_browser_queue")  # by a session of Streamlit's, of its visitor's


async def end_when_left(seconds: float) -> None:
    """End this server once no page has been connected for so long [s], as when its window is closed."""
    left = 0.0
    while left < seconds:
        await asyncio.sleep(LOOKS)
        connected = st.runtime.get_instance().state is RuntimeState.ONE_OR_MORE_SESSIONS_CONNECTED
        left = 0.0 if connected else left + LOOKS
    signal.raise_signal(signal.SIGTERM)


async def let_go_in_time() -> None:
    """Let them go as long as the server runs, and give back the memory that they held."""
    while True:
        await asyncio.sleep(EVERY)
        if let_go():
            await asyncio.to_thread(give_back)


def let_go() -> bool:
    """Let go of every session whose time for coming back is over, and return whether there was any.

    Streamlit's own loop goes on referring to the one that it served last until another one comes, so that what the
    visitor had is taken out of it. It is nothing that Streamlit offers: where another version keeps its sessions
    otherwise, nothing is done.
    """
    kept: Any = st.runtime.get_instance()
    for name in ("_session_mgr", "_session_storage", "_cache"):
        kept = getattr(kept, name, None)
    if not hasattr(kept, "expire"):
        return False
    left = [kept_session.session for _, kept_session in kept.expire()]
    for session in left:
        session.shutdown()
        for name in _HELD:
            vars(session).pop(name, None)
    return bool(left)
