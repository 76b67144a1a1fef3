"""Say in which language, and in which units, this browser's pages are read, and let the reader choose."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import streamlit as st
from streamlit.delta_generator import DeltaGenerator

from atleak.common.style import DEFAULT_PAPER, PAPERS
from atleak.common.translations import languages
from atleak.common.units import SYSTEMS
from atleak.common.wording import Wording, wording

OTHERWISE = "en", "metric"
_CHOICES = ("language", "units")
_CHANGES = "reader-changes"
_COOKIES = "reader-cookies"
_MARK = st.components.v2.component(
    "atleak_reader",
    css=".st-key-atleak-reader {position: absolute}",  # it shows nothing and takes no place
    # A field that loses the focus to a link sends what was typed a few tasks later, from the page on which it stands;
    # a click handled before that would lead away and be led back. So a plain click on a link waits until they are done,
    # and 50 ms more: a page that is left while the server still takes the text in would lose it.
    js="""const later = window.requestIdleCallback ?? (task => setTimeout(task, 100))
    document.addEventListener("click", event => {
        const link = event.target.closest?.("a[href]:not([target=_blank], [download])")
        if (!link || !event.isTrusted || event.ctrlKey || event.metaKey || event.shiftKey || event.altKey) return
        event.preventDefault()
        event.stopImmediatePropagation()
        later(() => setTimeout(() => link.click(), 50), {timeout: 300})
    }, true)
    export default function({data}) {
        document.documentElement.lang = data.language
        for (const [name, value] of Object.entries(data.cookies))
            document.cookie = `${name}=${value}; path=/; max-age=157680000; samesite=lax`
    }""",
    isolate_styles=False,
)


def say() -> Wording:
    """Return the words of the reader's language, with quantities in the reader's units.

    They are those chosen in this session, else those that this browser remembers. Without either the language is the
    browser's own, or English where atleak does not speak that, and the units are metric.
    """
    own = str(st.context.locale or "").partition("-")[0]
    language = _chosen("language", languages(), own if own in languages() else OTHERWISE[0])
    return wording(language, _chosen("units", SYSTEMS, OTHERWISE[1]))


def mark_page() -> None:
    """Tell the browser which language the page is in, and let it remember what was chosen."""
    chosen = {_cookie(name): st.session_state[_kept(name)] for name in _CHOICES if _kept(name) in st.session_state}
    _MARK(key="atleak-reader", data={"language": say().language, "cookies": chosen})


def draw_choices() -> None:
    """Show the choice of language and of units; what is picked holds at once, and in this browser's next visits."""
    words = say()
    names = {language: wording(language)("language.name") for language in languages()}
    _choice("language", words.language, names, words("reader.language"))
    systems = {units: words(f"unit_systems.{units}") for units in SYSTEMS}
    _choice("units", words.units, systems, words("reader.units"))
    st.caption(f"{words('reader.kept')} {words('reader.messages')}")


def pick_language(key: str, place: DeltaGenerator | None = None) -> str:
    """Ask in which language a file is to be written: in the reader's own unless another one is picked."""
    words = say()
    names = {language: wording(language)("language.name") for language in languages()}
    start, key = list(names).index(words.language), f"{key}-language-{words.language}"
    place = place or st.container()
    return str(place.selectbox(words("reader.language"), list(names), start, names.__getitem__, key=key))


def pick_print(key: str) -> tuple[str, str]:
    """Ask in which language, and on which paper, a file is to be printed: that of the reader's units otherwise."""
    words, (left, right) = say(), st.columns(2)
    start = list(PAPERS).index("letter" if words.units == "us" else DEFAULT_PAPER)
    label, own = words("take_along.paper"), f"{key}-paper-{words.units}"
    paper = right.selectbox(label, list(PAPERS), start, lambda name: PAPERS[name].label, key=own)
    return pick_language(key, left), str(paper)


def changes() -> int:
    """Return how often language or units were changed in this session; fields with numbers are written anew then."""
    return int(st.session_state.get(_CHANGES, 0))


def _choice(name: str, current: str, labels: Mapping[str, str], label: str) -> None:
    options, key = list(labels), f"pick-{name}-{say().language}"

    def changed() -> None:
        st.session_state[_kept(name)] = st.session_state[key]
        st.session_state[_CHANGES] = changes() + 1

    st.selectbox(
        label, options, options.index(current), key=key, format_func=lambda each: labels[each], on_change=changed
    )


def _chosen(name: str, known: Iterable[str], otherwise: str) -> str:
    """Return what was chosen in this session or, by its cookie, in an earlier one of this browser."""
    if _kept(name) not in st.session_state:
        if _COOKIES not in st.session_state:  # they are those with which the session was opened
            st.session_state[_COOKIES] = {each: st.context.cookies.get(_cookie(each)) for each in _CHOICES}
        remembered = st.session_state[_COOKIES][name]
        if remembered is None or remembered not in known:
            return otherwise
        st.session_state[_kept(name)] = remembered
    return str(st.session_state[_kept(name)])


def _kept(name: str) -> str:
    return f"reader-{name}"


def _cookie(name: str) -> str:
    return f"atleak-{name}"
