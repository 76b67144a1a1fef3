"""Learn the mounting clearances of a valve body from measuring sheets of new units."""

from __future__ import annotations

import datetime as dt
import hashlib
from collections.abc import Mapping
from typing import Any

import streamlit as st

from atleak.analysis.learning.learned_clearances import Learned, learn
from atleak.analysis.learning.learned_words import learned_messages, summary, with_learned
from atleak.catalogue.controller_file import checked_controller, written_toml
from atleak.catalogue.entries import catalogue_files
from atleak.catalogue.instruments import Part, instruments, load_instruments
from atleak.common.errors import AtleakError
from atleak.common.units import unit_names
from atleak.readers.remembered_columns import default_path
from atleak.readers.sheets.measuring_sheet import read_several
from atleak.report.tables.learned import learned_lands, learned_outliers, learned_units
from pages.shared import reader, show
from pages.shared.cases import sheets_remembered
from pages.shared.sheet_form import AS_STATED, unit_said

_TYPES = ["xlsx", "xls", "ods", "csv", "tsv", "txt"]


def learn_form(data: Mapping[str, Any], *, key: str = "learn") -> dict[str, Any] | None:
    """Ask for measuring sheets of new units, and show what they tell of a valve body when new.

    Parameters
    ----------
    data
        the tables of the valve body's file, without a fault.

    Returns
    -------
    dict or None
        the tables with the learned clearances, once, when the button that takes them over was pressed.
    """
    say = reader.say()
    st.write(say("learning.about"))
    files = st.file_uploader(say("learning.sheets"), _TYPES, accept_multiple_files=True, key=f"{key}-sheets")
    places = st.columns(2)
    units = [AS_STATED, *unit_names("length")]
    unit = places[0].selectbox(say("sheet_form.unit"), units, format_func=unit_said, key=f"{key}-unit")
    made_for = places[1].selectbox(
        say("learning.made_for"),
        [data["id"], *(name for name in catalogue_files("controllers") if name != data["id"])],
        key=f"{key}-made-for",
        help=say("learning.made_for_help"),
    )
    gauges = {"spool": _gauge(places[0], "spool", key), "sleeve": _gauge(places[1], "sleeve", key)}
    if not files:
        return None
    sources = tuple((file.name, file.getvalue()) for file in files)
    try:
        with st.spinner(say("learning.comparing")):
            learned = _learned(_digest(data, sources), data, sources, unit or None, made_for, gauges)
        tables = with_learned(data, learned, dt.date.today())
        checked_controller(tables)
    except AtleakError as error:
        st.error(show.plain(error))
        return None
    _show(learned)
    taken = st.button(say("learning.take"), type="primary", key=f"{key}-take")
    return tables if taken else None


def _gauge(place: Any, part: Part, key: str) -> str:
    say = reader.say()
    able = {gauge.id: say.name(gauge.name) for gauge in instruments() if part in gauge.measures}
    names = list(able)
    first = names.index(load_instruments().of(part).id)
    label = say(f"slots.{part}_instrument")
    chosen: str = place.selectbox(label, names, first, format_func=able.get, key=f"{key}-{part}")
    return chosen


def _digest(data: Mapping[str, Any], sources: tuple[tuple[str, bytes], ...]) -> tuple[str, ...]:
    contents = (written_toml(data).encode(), *(part for name, content in sources for part in (name.encode(), content)))
    return (*(hashlib.sha256(content).hexdigest() for content in contents), sheets_remembered())


@st.cache_resource(max_entries=4, show_spinner=False)
def _learned(
    digest: tuple[str, ...],
    _data: Mapping[str, Any],
    _sources: tuple[tuple[str, bytes], ...],
    unit: str | None,
    made_for: str,
    gauges: dict[str, str],
) -> Learned:
    """Learn once for the same tables, sheets and choices; ``digest`` stands for all but the choices."""
    controller = checked_controller(_data)
    return learn(
        controller,
        read_several(_sources, controller, unit=unit, made_for=made_for, remembered=default_path()),
        instruments=load_instruments(**gauges),
    )


def _show(learned: Learned) -> None:
    say = reader.say()
    st.markdown(show.plain(say.sentence(summary(learned))))
    for message in learned_messages(learned):
        (st.warning if message.level == "warning" else st.info)(show.plain(say.sentence(message.text)))
    show.table(learned_lands(learned, say))
    outliers = learned_outliers(learned, say)
    if outliers.rows:
        st.markdown(f"**{say('learning.left_out')}**")
        show.table(outliers)
    with st.expander(say("learning.units")):
        show.table(learned_units(learned, say))
