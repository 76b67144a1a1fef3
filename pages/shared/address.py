"""Keep small choices in the session and in the page's address, so that a reload keeps them.

A choice belongs to the job that is shown, and another job begins without it; a few belong to a page whatever the job.
"""

from __future__ import annotations

import streamlit as st

from pages.shared.state import session


def kept(name: str, *, of_job: bool = True) -> str:
    """Return what was kept under a name for the job that is shown; after a reload what the address has; else "".

    What is not ``of_job`` is kept for whatever job is shown.
    """
    choices = _choices()
    key = name, _job() if of_job else None
    if not of_job and name in st.query_params:  # a link leads to it
        choices[key] = st.query_params[name]
    elif key not in choices:
        first = not any(other == name for other, _ in choices)
        choices[key] = st.query_params.get(name, "") if first else ""
    _write(name, choices[key])  # the browser drops it from the address where another page is chosen
    return choices[key]


def keep(name: str, value: str, *, of_job: bool = True) -> None:
    """Keep a value under a name for the job that is shown, or for any; an empty one is forgotten."""
    _choices()[name, _job() if of_job else None] = value
    _write(name, value)


def _write(name: str, value: str) -> None:
    if value and st.query_params.get(name) != value:
        st.query_params[name] = value
    elif not value and name in st.query_params:
        del st.query_params[name]


def _choices() -> dict[tuple[str, tuple[str, int] | None], str]:
    choices: dict[tuple[str, tuple[str, int] | None], str] = st.session_state.setdefault("in-address", {})
    return choices


def _job() -> tuple[str, int]:
    now = session()
    chosen = now.good.controller
    return chosen if isinstance(chosen, str) else chosen.name, now.generation
