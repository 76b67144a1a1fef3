"""Let in who may use the dashboard: everybody on its own machine, and where others reach it those on a list."""

from __future__ import annotations

import os
from pathlib import Path

import streamlit as st
from streamlit.runtime.scriptrunner import get_script_run_ctx

from atleak.common.access import ALLOWED, is_here_alone
from atleak.common.errors import InputError
from pages.shared import reader

_INSIDE: set[str] = set()  # ids of the sessions that were let in


def is_open() -> bool:
    """Tell whether the visitor may see the dashboard; the list is read each time, so that it holds at once."""
    is_open, context = _is_open(), get_script_run_ctx(suppress_warning=True)
    if context is not None:
        (_INSIDE.add if is_open else _INSIDE.discard)(context.session_id)
        if st.runtime.exists():  # ended sessions go, and those cut off: their page is drawn anew when they come back
            active = st.runtime.get_instance().is_active_session
            _INSIDE.difference_update([each for each in _INSIDE - {context.session_id} if not active(each)])
    return is_open


def _is_open() -> bool:
    path = os.environ.get(ALLOWED)
    if path is None:
        return is_here_alone(str(st.get_option("server.address")))
    if not path:
        return True
    from atleak.common.sign_in import read_allowed

    try:
        return bool(st.user.get("is_logged_in")) and read_allowed(Path(path)).admits(st.user.to_dict())
    except InputError:
        return False


def is_of_this_computer() -> bool:
    """Tell whether nobody but this computer's user reaches the dashboard: then it may open what a path names here.

    A proxy that hands on what others ask for says so in a header, whatever name it calls this computer by.
    """
    names = (str(st.get_option("server.address")), *map(str, st.get_option("server.allowedHosts") or ()))
    handed_on = any(name in st.context.headers for name in ("Forwarded", "X-Forwarded-For", "X-Forwarded-Host"))
    return not os.environ.get(ALLOWED) and all(map(is_here_alone, names)) and not handed_on


def may_send_files(session: str) -> bool:
    """Tell whether a session, by its id, was let in when its page was drawn last."""
    return session in _INSIDE


def draw() -> None:
    """Draw what somebody sees who is not let in: a way to sign in, or out again."""
    say, path = reader.say(), os.environ.get(ALLOWED)
    st.title("atleak")
    if not path:
        st.error(say("entrance.no_start"))
    elif not st.user.get("is_logged_in"):
        st.text(say("entrance.closed"))
        st.button(say("entrance.sign_in"), on_click=st.login, type="primary")
    else:
        st.text(_refusal(path))
        st.button(say("entrance.sign_out"), on_click=st.logout)


def draw_sign_out() -> None:
    """Say at the foot of the sidebar who is signed in, and offer to sign out."""
    if os.environ.get(ALLOWED):
        say = reader.say()
        with st.sidebar:
            st.text(say("entrance.signed_in", name=_name()))
            st.button(say("entrance.sign_out"), on_click=st.logout, width="stretch")


def person() -> str:
    """Return what tells who is signed in, as the provider has it; "" where nobody has to sign in."""
    if not os.environ.get(ALLOWED) or not st.user.get("is_logged_in"):
        return ""
    return " ".join(str(st.user.get(claim) or "") for claim in ("iss", "sub")).strip() or _name()


def _refusal(path: str) -> str:
    from atleak.common.sign_in import read_allowed

    say = reader.say()
    try:
        read_allowed(Path(path))
    except InputError as error:
        error.rename_file(lambda _: Path(path).name)  # where it lies is nobody's business
        return say("entrance.nobody", problem=say.sentence(error.sentence))
    return say("entrance.not_allowed", name=_name() or say("entrance.somebody"))


def _name() -> str:
    """Return how the provider calls the visitor."""
    names = (st.user.get(claim) for claim in ("email", "preferred_username", "name"))
    return str(next(filter(None, names), ""))
