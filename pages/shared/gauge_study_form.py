"""Ask for the readings of a gauge study and how to judge them, and take its result as an own instrument."""

from __future__ import annotations

import datetime as dt

import streamlit as st

from atleak.analysis.gauge_study import ALPHA, GaugeStudy, analysed, instrument_tables
from atleak.catalogue.instruments import Instrument
from atleak.catalogue.written_numbers import AskedNumber
from atleak.common.errors import InputError
from atleak.common.sentences import Sentence
from atleak.common.units import UM
from atleak.common.wording import Wording
from atleak.job.case import SourceFile
from atleak.readers.gauges.gauge_study import read_study
from atleak.report.charts.gauge_study_figures import by_part_and_operator
from atleak.report.sheets.gauge_study_form import write_study_form
from atleak.report.tables.gauge_study import study_sections
from pages.shared import fields, show, workshop_data
from pages.shared.cases import catalogue_list, shown_name
from pages.shared.state import session

_FILE = "gauge-study-file"
_UNITS = ("mm", "µm", "inch")
_COUNTS = range(2, 61)  # of parts, people and repeats that a workbook is made for
_ALPHAS = (ALPHA, 0.1, 0.25)
TOLERANCE = AskedNumber(Sentence("tolerance"), "µm", 20.5, (1e-3, 1e6), (1.0, 1_000.0), "clearance")


def draw(say: Wording) -> None:
    """Tell how well a gauge measures in the workshop's own hands, and take the result as an instrument."""
    st.write(say("gauge_study.what"))
    _draw_blank_form(say)
    study = _asked_study(say)
    if study is None:
        return
    sections = study_sections(study, say)
    show.section(sections["title"], "gauge-study")
    show.messages(study.messages, say("gauge_study.about"))
    st.header(sections["components"].title)
    show.section(sections["components"], "gauge-study")
    st.header(say("gauge_study.readings"))
    show.chart(by_part_and_operator(study, say), "gauge-study-readings")
    st.caption(say("gauge_study.readings_help"))
    with st.expander(sections["anova"].title):
        show.section(sections["anova"], "gauge-study")
    st.header(say("gauge_study.take"))
    _draw_taking(study, say)


def _draw_blank_form(say: Wording) -> None:
    """Offer a workbook to fill in."""
    with fields.fold(say("gauge_study.form"), key="gauge-study-form"):
        places = st.columns(4, vertical_alignment="bottom")
        asked = zip(("parts", "operators", "trials"), (10, 3, 3), places, strict=False)
        parts, operators, trials = (
            place.selectbox(say(f"gauge_study.{name}"), _COUNTS, _COUNTS.index(first), key=f"gauge-study-{name}")
            for name, first, place in asked
        )
        places[3].download_button(
            say("gauge_study.download"),
            lambda: write_study_form(parts, operators, trials, say),
            "gauge_study.xlsx",
            on_click="ignore",
            width="stretch",
        )


def _asked_study(say: Wording) -> GaugeStudy | None:
    """Return the study of the file that was given, as it is to be judged; None where there is none that can be used."""
    st.file_uploader(
        say("gauge_study.upload"), ["xlsx", "xls", "ods", "csv", "txt"], help=say("gauge_study.upload_help"),
        key=f"{_FILE}-upload", on_change=_take_file,
    )  # fmt: skip
    file: SourceFile | None = st.session_state.get(_FILE)
    with st.container():
        if file is not None:
            st.caption(f"**{show.plain(file.name)}**")
    places = st.columns(3)
    units = {"": say("gauge_study.unit_of_file"), **{name: name for name in _UNITS}}
    kept = {"persist_state": "session"}
    unit = fields.one_of(say("gauge_study.unit"), units, "gauge-study-unit", place=places[0], **kept)
    with places[1]:
        tolerance = fields.number(
            say("gauge_study.tolerance"), TOLERANCE, None, key="gauge-study-tolerance", optional=True
        )
    kept["help"], alphas = say("gauge_study.alpha_help"), {each: say.plain(each) for each in _ALPHAS}
    alpha = fields.one_of(say("gauge_study.alpha"), alphas, "gauge-study-alpha", place=places[2], **kept)
    if file is None:
        return None
    try:
        return _study((file.sha256, file.name), file, unit or None, tolerance, alpha)
    except InputError as error:
        st.error(f"**{show.plain(say('typed_entries.not_taken', file=file.name))}** {show.plain(error)}")
        return None


def _take_file() -> None:
    """Take the file that was given, or away; it stays over other pages, on which the uploader forgets it."""
    upload = st.session_state[f"{_FILE}-upload"]
    st.session_state[_FILE] = None if upload is None else SourceFile(upload.name, upload.getvalue())


@st.cache_resource(max_entries=8, show_spinner=False)
def _study(
    key: tuple[str, str], _file: SourceFile, unit: str | None, tolerance: float | None, alpha: float
) -> GaugeStudy:
    readings = read_study(_file.content, name=_file.name, length_unit=unit)
    return analysed(readings, tolerance=None if tolerance is None else tolerance / UM, alpha=alpha)


def _draw_taking(study: GaugeStudy, say: Wording) -> None:
    """Offer to go on with the study's result as an instrument of the user's own, which is named and saved there."""
    st.write(say("gauge_study.take_what"))
    known, in_job = catalogue_list("spool_instrument").entries, session().case.spool_instrument
    with st.container(horizontal=True, vertical_alignment="bottom"):
        names = {name: shown_name(each, say) for name, each in known.items()}
        of = fields.one_of(say("gauge_study.studied"), names, "gauge-study-of", in_job)
        st.button(say("gauge_study.take"), type="primary", on_click=_take, args=(study, known[of]))


def _take(study: GaugeStudy, of: Instrument) -> None:
    name = f"{of.name}, {study.readings.file}"
    step = of.resolution if study.readings.step is None else study.readings.step
    tables = instrument_tables(study, of, id="", name=name, resolution=step, date=dt.date.today())
    del tables["id"]  # which follows from the name that it is given there
    workshop_data.go_on_with("instruments", tables)
