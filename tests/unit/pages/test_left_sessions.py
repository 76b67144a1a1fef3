"""Sessions that were left."""

from __future__ import annotations

import asyncio
import inspect
import signal
from types import SimpleNamespace

import pytest
import streamlit as st
from streamlit.runtime import RuntimeState
from streamlit.runtime.app_session import AppSession
from streamlit.runtime.memory_session_storage import MemorySessionStorage
from streamlit.runtime.session_manager import SessionInfo

from pages.shared import left_sessions
from pages.shared.left_sessions import _HELD, let_go


class Left:
    """A session with all that its visitor had."""

    id = "left"

    def __init__(self) -> None:
        self._session_state, self._fragment_storage, self._browser_queue = {"log": "large"}, ["page"], ["message"]
        self.ended = False

    def shutdown(self) -> None:
        self.ended = True


@pytest.mark.parametrize(("seconds", "goes"), [(0, True), (600, False)])
def test_a_session_goes_when_its_time_for_coming_back_is_over(
    monkeypatch: pytest.MonkeyPatch, seconds: int, goes: bool
) -> None:
    storage, session = MemorySessionStorage(ttl_seconds=seconds), Left()
    storage.save(SessionInfo(None, session))
    manager = SimpleNamespace(_session_storage=storage)
    monkeypatch.setattr(st.runtime, "get_instance", lambda: SimpleNamespace(_session_mgr=manager))
    assert let_go() is goes
    # whoever still refers to it, as Streamlit's loop does, holds nothing of the visitor's any more
    assert session.ended is goes
    assert set(vars(session)) == {"ended"} | (set() if goes else set(_HELD))
    assert let_go() is False


def test_another_way_of_keeping_sessions_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(st.runtime, "get_instance", SimpleNamespace)
    assert let_go() is False


def test_what_is_taken_out_of_a_session_is_what_streamlit_keeps_in_one() -> None:
    source = inspect.getsource(AppSession.__init__)
    assert [name for name in _HELD if f"self.{name}" not in source] == []


@pytest.mark.parametrize(("connected", "ends_after"), [((), 4), ((True, True, False, True), 8)])
def test_a_server_ends_once_no_page_has_been_connected_for_so_long(
    connected: tuple[bool, ...], ends_after: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    states, looks, ended = iter(connected), [], []

    class Kept:
        @property
        def state(self) -> RuntimeState:
            there = next(states, False)
            return RuntimeState.ONE_OR_MORE_SESSIONS_CONNECTED if there else RuntimeState.NO_SESSIONS_CONNECTED

    async def pause(seconds: float) -> None:
        looks.append(seconds)

    monkeypatch.setattr(left_sessions.asyncio, "sleep", pause)
    monkeypatch.setattr(left_sessions.st.runtime, "get_instance", Kept)
    monkeypatch.setattr(left_sessions.signal, "raise_signal", ended.append)
    asyncio.run(left_sessions.end_when_left(4 * left_sessions.LOOKS))
    assert (len(looks), ended) == (ends_after, [signal.SIGTERM])
