"""Take files that are dropped into a place which stays where it is: one dropped while another is read counts too.

Streamlit ends what a page does, in a callback as well, as soon as the browser sends something new. So a file counts as
taken once all that is done with it is done; until then every drawing of the place begins with it again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import streamlit as st
from streamlit.typing import UploadedFile

KEY = "drop-zone"  # how the keys begin: `page.css` knows the places by it


def draw(
    name: str,
    label: str,
    take: Callable[[Sequence[UploadedFile]], None],
    *,
    types: Sequence[str] | None = None,
    several: bool = False,
    help: str | None = None,
) -> None:
    """Offer a place for files, and hand over each file that comes into it once; then the page is drawn anew.

    Parameters
    ----------
    take
        called with the files that are new; again with the same ones where it was broken off.
    """
    taken: set[str] = st.session_state.setdefault(f"{KEY}-taken", set())
    held = st.file_uploader(label, types, accept_multiple_files=several, key=f"{KEY}-{name}", help=help)
    new = [each for each in (held if isinstance(held, list) else [held]) if each and each.file_id not in taken]
    if not new:
        return
    try:
        take(new)
    except Exception:  # Streamlit's own end of a run is none
        taken.update(each.file_id for each in new)
        raise
    taken.update(each.file_id for each in new)
    st.rerun()
