"""Learn the mounting clearances of a valve body from measuring sheets of new units."""

from __future__ import annotations

import datetime as dt
import hashlib
from collections.abc import Mapping
from typing import Any

import streamlit as st

from atleak.catalogue.catalogue_toml import written_toml
from atleak.catalogue.controller_reading import checked_controller
from atleak.catalogue.entries import catalogue_files
from atleak.catalogue.instruments import Part, instruments, load_instruments
from atleak.errors import AtleakError
from atleak.intake.readings.several import read_several
from atleak.intake.units import unit_names
from atleak.learning.learned import Learned, learn
from atleak.learning.tables import with_learned
from atleak.learning.words import messages, summary
from atleak.views.learned_rows import land_rows, outlier_rows, unit_rows
from pages.shared import reader, show
from pages.shared.sheet_form import AS_STATED

_TYPES = ["xlsx", "xls", "ods", "csv", "tsv", "txt"]


def learn_form(data: Mapping[str, Any], *, key: str = "learn") -> dict[str, Any] | None:
    """Ask for measuring sheets of new units, and show what they tell of a valve body when new.

    Parameters
    ----------
    data
        the tables of the valve body's file, without a fault.
    key
        beginning of the keys of the widgets.

    Returns
    -------
    dict or None
        the tables with the learned clearances, once, when the button that takes them over was pressed.
    """
    st.write(
        "Measuring sheets of new or known-good units give every land its mounting clearance and how far new pairs "
        "differ. Of a used unit mark the readings taken where the spool never runs as *unworn end*: only they count."
    )
    files = st.file_uploader(
        "Measuring sheets, one for each unit", _TYPES, accept_multiple_files=True, key=f"{key}-sheets"
    )
    places = st.columns(2)
    unit = places[0].selectbox("Unit of the diameters", [AS_STATED, *unit_names("length")], key=f"{key}-unit")
    made_for = places[1].selectbox(
        "The sheets were made for",
        [data["id"], *(name for name in catalogue_files("controllers") if name != data["id"])],
        key=f"{key}-made-for",
        help="The id that stands at the head of a printed sheet: that of the unit from which this one was copied.",
    )
    gauges = {"spool": _gauge(places[0], "spool", key), "sleeve": _gauge(places[1], "sleeve", key)}
    if not files:
        return None
    sources = tuple((file.name, file.getvalue()) for file in files)
    try:
        stated = None if unit == AS_STATED else unit
        learned = _learned(_digest(data, sources), data, sources, stated, made_for, gauges)
        tables = with_learned(data, learned, dt.date.today())
        checked_controller(tables)
    except AtleakError as error:
        st.error(show.plain(error))
        return None
    _show(learned)
    with st.container(horizontal=True):
        taken = st.button("Take these over", type="primary", key=f"{key}-take")
        st.download_button(
            "Download TOML", lambda: written_toml(tables), f"{data['id']}.toml", on_click="ignore", key=f"{key}-file"
        )
    return tables if taken else None


def _gauge(place: Any, part: Part, key: str) -> str:
    able = {gauge.id: gauge.name for gauge in instruments() if part in gauge.measures}
    names = list(able)
    first = names.index(load_instruments().of(part).id)
    label = f"{'Spools' if part == 'spool' else 'Sleeves'} measured with"
    chosen: str = place.selectbox(label, names, first, format_func=able.get, key=f"{key}-{part}")
    return chosen


def _digest(data: Mapping[str, Any], sources: tuple[tuple[str, bytes], ...]) -> tuple[str, ...]:
    contents = (written_toml(data).encode(), *(part for name, content in sources for part in (name.encode(), content)))
    return tuple(hashlib.sha256(content).hexdigest() for content in contents)


@st.cache_resource(max_entries=4, show_spinner="Comparing the units …")
def _learned(
    digest: tuple[str, ...],
    _data: Mapping[str, Any],
    _sources: tuple[tuple[str, bytes], ...],
    unit: str | None,
    made_for: str,
    gauges: dict[str, str],
) -> Learned:
    """Learn once for the same tables, sheets and choices; ``digest`` stands for the first two."""
    controller = checked_controller(_data)
    return learn(
        controller,
        read_several(_sources, controller, unit=unit, made_for=made_for),
        instruments=load_instruments(**gauges),
    )


def _show(learned: Learned) -> None:
    say = reader.say()
    st.markdown(show.plain(say.sentence(summary(learned))))
    for message in messages(learned):
        (st.warning if message.level == "warning" else st.info)(show.plain(say.sentence(message.text)))
    show.table(land_rows(learned))
    outliers = outlier_rows(learned)
    if outliers:
        st.markdown("**Left out**")
        show.table(outliers)
    with st.expander("The units"):
        show.table(unit_rows(learned))
