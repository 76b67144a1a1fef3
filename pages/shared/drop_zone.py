"""Take files that are dropped into a place which stays where it is, so that one dropped while another is read counts.

An uploader that gives way to an empty one once its file is taken loses what is dropped, or still on its way, until the
empty one is drawn. This one stays; what was taken out of it is no longer offered, and `page.css` hides its name there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import streamlit as st
from streamlit.runtime.scriptrunner import get_script_run_ctx
from streamlit.runtime.uploaded_file_manager import UploadedFile

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
    """Offer a place for files, and hand over each file that comes into it once.

    Parameters
    ----------
    name
        of the place, for its key.
    take
        called with the files that are new, in a callback: before the page is drawn.
    types
        endings that are taken; any unless given.
    several
        whether more than one file can be dropped at a time.
    """
    key = f"{KEY}-{name}"

    def changed() -> None:
        held = st.session_state[key]
        new = [each for each in (held if isinstance(held, list) else [held]) if isinstance(each, UploadedFile)]
        _let_go(new)
        if new:
            take(new)

    st.file_uploader(label, types, accept_multiple_files=several, key=key, on_change=changed, help=help)


def _let_go(files: Sequence[UploadedFile]) -> None:
    """Take files out of what the server keeps of the visitor's: the browser names them again with every change."""
    context = get_script_run_ctx()
    remove = None if context is None else getattr(context.uploaded_file_mgr, "remove_file", None)
    if context is not None and remove is not None:
        for file in files:
            remove(session_id=context.session_id, file_id=file.file_id)
