"""Provide fields that people type into: numbers as they write them, and folds that stay as they were left.

Which element is which never depends on what is being typed: the place of a doubt is always there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, overload

import streamlit as st

from atleak.catalogue.written_numbers import AskedNumber, WrittenNumber, read_number, written
from atleak.common.sentences import Sentence
from atleak.common.wording import Wording, begun
from pages.shared import address, reader, show


def kept(key: str, start: Any) -> dict[str, Any]:
    """Return what makes a field keep what was typed, over other pages too."""
    return {"value": start, "key": key, "persist_state": "session"}


@overload
def number(label: str, asked: AskedNumber, start: float, *, key: str, optional: Literal[False] = False) -> float: ...


@overload
def number(
    label: str, asked: AskedNumber, start: float | None, *, key: str, optional: bool = False
) -> float | None: ...


def number(label: str, asked: AskedNumber, start: float | None, *, key: str, optional: bool = False) -> float | None:
    """Show a number's field in the reader's unit, with a remark below it; return the last value that could be used.

    That value, and the start, are in the unit of ``asked``. What a job file holds is the start, and is taken even
    where it is out of the usual range. Where the reader changes language or units, the field is written anew from the
    last value.
    """
    say, taken = reader.say(), st.session_state.setdefault("taken-numbers", {})
    shown, own = asked.to(say), key
    if (changes := reader.changes()) > 0:
        own = f"{key}-{changes}"
        start = st.session_state.setdefault("number-starts", {}).setdefault(own, taken.get(key, start))
    first = "" if start is None else written(_convert(start, asked, say), shown, say)
    text = st.text_input(f"{label} [{shown.unit}]" if shown.unit else label, **kept(own, first)).strip()
    place = st.container()
    entry = _entry(text, asked, first, start, optional)
    if entry.value is not None or (optional and not text):
        taken[key] = entry.value
        if entry.doubt:
            place.warning(show.plain(say.sentence(entry.doubt)))
        return entry.value
    last = taken.setdefault(key, start)
    value = "" if last is None else f"{written(_convert(last, asked, say), shown, say)} {shown.unit}".strip()
    with place:
        fault(entry.doubt, shown.name, value)
    return last


def fault(why: Sentence, name: Sentence, last: str) -> None:
    """Say at a field why what is written there is not used, and which value stays in use; "" where there is none."""
    say = reader.say()
    used = say("written.stays", value=last) if last else say("written.none_used", name=say.sentence(name))
    st.error(show.plain(f"{begun(say.sentence(why))} {used}"))


def _entry(text: str, asked: AskedNumber, first: str, start: float | None, optional: bool) -> WrittenNumber:
    """Read what stands in a field in the reader's unit; the value is in the unit of ``asked``."""
    say = reader.say()
    if not text:
        return WrittenNumber(None, Sentence("") if optional else Sentence("Nothing is written here"))
    entry = read_number(text, asked.to(say))
    if text == first and start is not None:
        return WrittenNumber(start, Sentence("") if entry.value is None else entry.reason)
    if entry.value is None or asked.kind is None:
        return entry
    return WrittenNumber(say.back(entry.value, asked.kind), entry.reason)


def _convert(value: float, asked: AskedNumber, say: Wording) -> float:
    """Return a value in the reader's unit, without the last digits that only converting it brings."""
    if asked.kind is None:
        return value
    shown = say.convert(value, asked.kind)
    return value if shown == value else float(f"{shown:.6g}")


def fold(label: str, *, key: str, opened: bool = False) -> Any:
    """Show a fold that stays as the user left it, here and after another page."""
    left = st.session_state.setdefault("folds", {})
    st.session_state.setdefault(key, left.get(key, opened))
    place = st.expander(label, key=key, on_change="rerun")
    left[key] = place.open
    return place


def unfold(label: str, key: str, draw: Callable[..., object], *given: Any) -> None:
    """Show a fold, and draw what stands in it only while it is open."""
    with fold(label, key=key) as place:
        if place.open:
            draw(*given)


def one_of(label: str, names: Mapping[Any, str], key: str, start: Any = None, *, place: Any = st, **more: Any) -> Any:
    """Let one of several things be picked by its name, ``start`` or the first where nothing was picked yet."""
    first = list(names).index(start) if start in names else 0
    return place.selectbox(label, list(names), first, lambda each: names.get(each, str(each)), key=key, **more)


def choice(
    label: str,
    options: Sequence[Any],
    current: Any,
    take: Callable[[Any], object],
    shown: Callable[[Any], str] = str,
    *,
    key: str,
    place: Any = st,
    **more: Any,
) -> Any:
    """Show the choice that holds, whoever made it; what is picked is taken before anything is drawn."""

    def picked() -> None:
        take(st.session_state[key])

    if None not in options and st.session_state.get(key, current) != current:  # to Streamlit None is no option
        st.session_state[key] = current
    else:  # said in each run: a page that is drawn twice at once may show only what the second says
        more["index"] = options.index(current) if current in options else None
    more.setdefault("disabled", len(options) < 2)
    return place.selectbox(label, options, format_func=shown, key=key, on_change=picked, **more)


def part(
    page: str, names: Mapping[str, str], *, closable: bool = False, left: Callable[[], None] = lambda: None
) -> str:
    """Offer the parts of a page by their labels; return the one that is open, "" for none. The address keeps it.

    ``left`` is called where one is left for another.
    """
    say, key, kept = reader.say(), f"part-of-{page}", address.kept(page, of_job=False)
    st.session_state[key] = kept if kept in names else None if closable else next(iter(names))

    def picked() -> None:
        address.keep(page, st.session_state[key] or "", of_job=False)
        left()

    opened = st.segmented_control(
        say("parts.of_page"),
        list(names),
        format_func=names.__getitem__,
        required=not closable,
        key=key,
        on_change=picked,
        label_visibility="collapsed",
    )
    return opened or ""


def turn(key: str, *, opened: bool) -> None:
    """Open or close a fold that is not drawn yet."""
    st.session_state[key] = st.session_state.setdefault("folds", {})[key] = opened
