"""Provide fields that people type into: numbers as they write them, and folds that stay as they were left.

Which element is which never depends on what is being typed: the place of a doubt is always there.
"""

from __future__ import annotations

from typing import Any, Literal, overload

import streamlit as st

from atleak.written_numbers import AskedNumber, WrittenNumber, read_number, written
from pages.shared import show


def kept(key: str, start: Any) -> dict[str, Any]:
    """Return what makes a field keep what was typed: its value, key and callback.

    The callback runs before any page does, so what is typed last is kept even where the next click leaves the page.
    """
    typed = st.session_state.setdefault("typed", {})
    return {"value": typed.get(key, start), "key": key, "on_change": _keep, "args": (key,)}


def _keep(key: str) -> None:
    st.session_state["typed"][key] = st.session_state[key]


@overload
def number(label: str, asked: AskedNumber, start: float, *, key: str, optional: Literal[False] = False) -> float: ...


@overload
def number(
    label: str, asked: AskedNumber, start: float | None, *, key: str, optional: bool = False
) -> float | None: ...


def number(label: str, asked: AskedNumber, start: float | None, *, key: str, optional: bool = False) -> float | None:
    """Show a number's field with a remark below it; return the last value that could be used.

    What a job file holds is the start, and is taken even where it is out of the usual range.
    """
    first = "" if start is None else written(start, asked)
    text = st.text_input(f"{label} [{asked.unit}]" if asked.unit else label, **kept(key, first)).strip()
    place = st.container()
    taken = st.session_state.setdefault("taken-numbers", {})
    entry = _entry(text, asked, first, start, optional)
    if entry.value is not None or (optional and not text):
        taken[key] = entry.value
        if entry.doubt:
            place.warning(show.plain(entry.doubt))
        return entry.value
    last = taken.setdefault(key, start)
    used = f"No {asked.name} is used" if last is None else f"{written(last, asked)} {asked.unit} stays in use"
    place.error(show.plain(f"{entry.doubt} {used}."))
    return last


def _entry(text: str, asked: AskedNumber, first: str, start: float | None, optional: bool) -> WrittenNumber:
    if text == first and start is not None:
        entry = read_number(text, asked)
        return WrittenNumber(start, "" if entry.value is None else entry.doubt)
    if text:
        return read_number(text, asked)
    return WrittenNumber(None, "" if optional else "Nothing is written here.")


def fold(label: str, *, key: str, opened: bool = False) -> Any:
    """Show a fold that stays as the user left it, here and after another page."""
    left = st.session_state.setdefault("folds", {})
    st.session_state.setdefault(key, left.get(key, opened))
    place = st.expander(label, key=key, on_change="rerun")
    left[key] = place.open
    return place
